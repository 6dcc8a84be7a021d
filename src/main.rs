//! The command line of pacinian.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main().into()
}
