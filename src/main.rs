//! The command line of pacinian.

mod cli;

fn main() -> std::process::ExitCode {
    #[cfg(feature = "pipewire")]
    cli::stay_on_one_device();
    cli::main().into()
}
