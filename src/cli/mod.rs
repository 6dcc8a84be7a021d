//! The command line: one file a subcommand, each a thin use of the library.

mod advice;
mod against;
mod ask;
mod by_default;
mod check;
mod choose;
mod coupled;
mod curves;
mod demo;
mod device_queue;
mod devices;
mod ear;
mod error;
mod even;
mod failure;
mod feel;
mod felt;
mod form;
mod format;
mod guard;
mod hearers;
mod held_back;
mod identify;
mod input;
mod keep;
mod knob;
mod latency;
mod learn;
mod left_out;
mod line;
mod load;
mod loaded;
mod memory;
mod motor;
mod named;
mod nodes;
mod osc;
mod outside;
mod paint;
mod parts;
mod patience;
mod patterns;
mod perform;
mod place;
mod plan;
mod play;
mod plot;
mod priority;
mod problems;
mod progress;
mod provenance;
mod pushes;
mod render;
mod replay;
mod rig;
mod rise;
mod schema;
mod screen;
mod setting;
#[cfg(any(feature = "pipewire", test))]
mod stay;
mod stop;
mod summary;
mod table;
mod terminal;
mod unplayed;
mod unsung;
mod walk;
mod watch;
mod wrap;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use failure::Failure;
#[cfg(feature = "pipewire")]
pub use stay::stay_on_one_device;
use terminal::{Terminal, When};

/// Plays the skin the way a synthesizer plays the ear.
#[derive(Debug, Parser)]
#[command(
    name = "pacinian",
    version,
    about = "Vibrotactile synthesis: plays the skin the way a synthesizer plays the ear",
    long_about = "Vibrotactile synthesis: plays the skin the way a synthesizer plays the ear.\n\n\
        A patch (a TOML file) says what is felt and when; a rig (another) says which tactor hangs on which channel. \
        pacinian checks them, plays them on a sound card in real time, and renders them to a WAV file with a channel for each tactor.",
    after_help = "Begin here:\n  pacinian demo                   a WAV file and a picture, no hardware needed\n  \
        pacinian check PATCH            see what is wrong with a patch, or what it will run\n  \
        pacinian render PATCH -o x.wav  render it\n  \
        pacinian devices                the sound cards and MIDI ports of this machine\n  \
        pacinian play PATCH             play it: at -20 dB on a card that nobody has named, on a virtual one where there is none\n  \
        pacinian format                 what a patch and a rig may say\n  \
        pacinian nodes                  the nodes that voices are made of\n  \
        pacinian rig new vest 40        the rig of a common array\n  \
        pacinian motor PART             what a motor does; pacinian parts lists those that are known\n  \
        pacinian knob PATCH             what a force-feedback knob feels like and bears, simulated\n  \
        pacinian identify RECORDING     what a recording tells of an actuator\n\n\
        Exit codes: 0 all is well, 1 a replay that differs from its recording, 2 the command line, 65 the patch,\n\
        66 a file that is not there, 69 a device, port or address that is not there or does not fit, 70 a bug in pacinian,\n\
        71 what the system does not give (a thread, signals), 73 and 74 a file that cannot be written, a device that fails,\n\
        75 a device or port that another program has: try again, 77 no permission, 78 the rig,\n\
        129 stopped by SIGHUP, 130 by Ctrl-C, 131 by SIGQUIT, 143 by SIGTERM.",
    disable_help_subcommand = true,
    propagate_version = true
)]
struct Cli {
    /// Colours: always, never, or auto, which asks NO_COLOR, CLICOLOR_FORCE, FORCE_COLOR and the terminal
    #[arg(long, global = true, value_name = "WHEN", value_enum, default_value_t = When::Auto, hide_possible_values = true, help_heading = "Terminal")]
    color: When,
    /// Problems one a line, FILE:LINE:COLUMN, as when they do not go to a terminal
    #[arg(long, global = true, help_heading = "Terminal")]
    plain: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Demo(demo::Demo),
    Check(check::Check),
    Render(render::Render),
    Play(play::Play),
    Replay(replay::Replay),
    Devices(devices::Devices),
    Walk(walk::Walk),
    Learn(learn::Learn),
    Latency(latency::Latency),
    Plot(plot::Plot),
    Error(error::Error),
    Motor(motor::Motor),
    Knob(knob::KnobCommand),
    Identify(identify::Identify),
    Parts(parts::Parts),
    Rig(rig::RigCommand),
    Nodes(nodes::Nodes),
    Format(format::Format),
    Schema(schema::Schema),
}

/// Runs the program; gives its exit code.
pub fn main() -> u8 {
    guard::guarded(run)
}

fn run() -> u8 {
    stop::outlive_large_files();
    let wish = terminal::wish(std::env::args_os());
    let command = Cli::command().color(Terminal::new(wish, false).clap());
    let cli = match command.try_get_matches().and_then(|m| Cli::from_arg_matches(&m)) {
        Ok(cli) => cli,
        Err(error) => return terminal::usage(&error),
    };
    let terminal = Terminal::new(cli.color, cli.plain);
    let result: Result<(), Failure> = match &cli.command {
        Command::Demo(demo) => demo.run(&terminal),
        Command::Plot(plot) => plot.run(&terminal),
        Command::Error(error) => error.run(&terminal),
        Command::Motor(motor) => motor.run(&terminal),
        Command::Knob(knob) => knob.run(&terminal),
        Command::Identify(identify) => identify.run(&terminal),
        Command::Parts(parts) => parts.run(&terminal),
        Command::Rig(rig) => rig.run(&terminal),
        Command::Check(check) => check.run(&terminal),
        Command::Render(render) => render.run(&terminal),
        Command::Play(play) => play.run(&terminal),
        Command::Replay(replay) => replay.run(&terminal),
        Command::Devices(devices) => devices.run(&terminal),
        Command::Walk(walk) => walk.run(&terminal),
        Command::Learn(learn) => learn.run(&terminal),
        Command::Latency(latency) => latency.run(&terminal),
        Command::Nodes(nodes) => nodes.run(&terminal),
        Command::Format(format) => format.run(&terminal),
        Command::Schema(schema) => schema.run(&terminal),
    };
    match result {
        Ok(()) => 0,
        Err(failure) => {
            failure.show(&terminal);
            failure.code()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Cli;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_sound() {
        Cli::command().debug_assert();
    }
}
