//! `pacinian plot`.

use super::failure::Failure;
use super::load::Scene;
use super::loaded::Loaded;
use super::named::Codes;
use super::perform::{Until, perform};
use super::place::check_picture;
use super::problems;
use super::render::seconds;
use super::stop::Stop;
use super::terminal::Terminal;
use clap::Args;
use pacinian::io::out;
use pacinian::report::plot::{Collector, Map, Site, Style};
use pacinian::rig::OutputKind;
use pacinian::text::Problem;
use std::path::PathBuf;

/// Draws what every tactor does over time, and the spectrum, as SVG
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  pacinian plot patches/04-heartbeat.toml --rig rigs/belt.toml -o heartbeat.svg\n  \
    pacinian plot patches/34-brush.toml --rig rigs/back.toml --map -o brush.svg\n\n\
    The patch is rendered for it, but no WAV file is written. The spectrum shows the limit of 1 kHz."
)]
pub struct Plot {
    #[command(flatten)]
    scene: Scene,
    /// The SVG file to write; one that is there is replaced; - for standard output
    #[arg(short, long, value_name = "FILE.svg")]
    output: PathBuf,
    /// Seconds to draw [default: what the patch says, else until everything is over]
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Width of the picture in pixels, 500 to 4000
    #[arg(long, value_name = "PX", default_value_t = 1200, value_parser = clap::value_parser!(u16).range(500..=4000))]
    width: u16,
    /// The tactors where they sit, frame by frame: how strongly each shakes
    #[arg(long)]
    map: bool,
    /// Frames of a map
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 24, requires = "map", conflicts_with = "animated", value_parser = clap::value_parser!(u16).range(1..=400))]
    frames: u16,
    /// One map that plays in a browser, as fast as it is felt
    #[arg(long, requires = "map")]
    animated: bool,
    /// Dark on light, whatever the reader's system prefers
    #[arg(long)]
    light: bool,
}

impl Plot {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        let loaded = self.scene.load(false, self.duration)?;
        for warnings in &loaded.warnings {
            terminal.note(&problems::shown(warnings, terminal));
        }
        let to_stdout = self.output.as_os_str() == "-";
        if !to_stdout {
            check_picture(&self.output, &loaded)?;
        }
        let mut player = loaded.player()?;
        let until = Until::of(&loaded, &player, self.duration)?;
        let mut canvas = self.canvas(&loaded, until.expected(&player))?;
        let stop = Stop::listen()?;
        let performed = perform(&mut player, &loaded, until, &stop, terminal, |_, block| {
            canvas.push(block);
            Ok::<bool, Failure>(true)
        })
        .map_err(|(failure, _)| failure)?;
        let mut style = style(&loaded);
        style.width = f64::from(self.width);
        style.dark = !self.light;
        let svg = match &canvas {
            Canvas::Rows(collector) => collector.svg(&style),
            Canvas::Map(map) if self.animated => map.animated(&style),
            Canvas::Map(map) => map.frames(&style, usize::from(self.frames)),
        };
        if to_stdout {
            terminal.print(&svg)?;
        } else {
            out::write(&self.output, svg.as_bytes())?;
            let shown =
                terminal.out.bold(&pacinian::text::problem::escaped(&self.output.display().to_string()));
            let rows = match &canvas {
                Canvas::Rows(collector) => super::table::many(collector.peaks().len(), "channel"),
                Canvas::Map(map) => super::table::many(map.sites().len(), "tactor"),
            };
            let set = match loaded.settings.as_slice() {
                [] => String::new(),
                set => format!(", {}", super::setting::named(set)),
            };
            terminal.print(&format!("{shown}: {rows}, {:.3} s{set}\n", canvas.seconds()))?;
        }
        match (performed.stopped, player.trouble()) {
            (Some(code), _) => {
                let what = format!("stopped; the picture shows the first {:.3} s", canvas.seconds());
                terminal.note(&problems::sentence(&Problem::warning(&(0..0), what), terminal));
                Err(Failure::told(code))
            }
            (None, Some(trouble)) => Err(loaded.refuse(vec![trouble.clone()], &Codes::new())),
            (None, None) => Ok(()),
        }
    }
}

/// What is drawn.
enum Canvas {
    /// Rows over time, and the spectrum.
    Rows(Box<Collector>),
    /// Tactors where they sit.
    Map(Map),
}

impl Canvas {
    fn push(&mut self, block: &[f32]) {
        match self {
            Self::Rows(collector) => collector.push(block),
            Self::Map(map) => map.push(block),
        }
    }

    fn seconds(&self) -> f64 {
        match self {
            Self::Rows(collector) => collector.seconds(),
            Self::Map(map) => map.seconds(),
        }
    }
}

impl Plot {
    fn canvas(&self, loaded: &Loaded, expected: Option<f64>) -> Result<Canvas, Failure> {
        if !self.map {
            return Ok(Canvas::Rows(Box::new(collector(loaded, expected))));
        }
        let channels = loaded.rig.device.channels as usize;
        let sites: Vec<Site> = loaded
            .rig
            .outputs
            .iter()
            .filter(|output| !matches!(output.kind, OutputKind::Trigger { .. } | OutputKind::Torque))
            .filter_map(|output| {
                let channel = (output.channel as usize).checked_sub(1)?;
                Some(Site { name: output.name.clone(), channel, position: output.position? })
            })
            .collect();
        if sites.is_empty() {
            let what = "no tactor of the rig has a position, so there is no map of them";
            let help = "give the tactors a `position`, or leave out --map";
            return Err(loaded.refuse(vec![Problem::of_file(what).help(help.to_string())], &Codes::new()));
        }
        Ok(Canvas::Map(Map::new(&sites, channels, loaded.options.rate.unwrap_or(48_000.0))))
    }
}

/// A collector of all channels of a scene, by their names.
pub fn collector(loaded: &Loaded, expected: Option<f64>) -> Collector {
    let name = |(i, name): (usize, String)| if name.is_empty() { format!("channel {}", i + 1) } else { name };
    let names: Vec<String> = loaded.tactors().into_iter().enumerate().map(name).collect();
    Collector::new(&names, loaded.options.rate.unwrap_or(48_000.0), expected)
}

/// The words of a picture.
pub fn style(loaded: &Loaded) -> Style {
    let mut style = Style::new(&loaded.patch.title);
    style.subtitle = if loaded.rig.title.is_empty() {
        loaded.name().to_string()
    } else {
        format!("{} on {}", loaded.name(), loaded.rig.title)
    };
    if !loaded.settings.is_empty() {
        style.subtitle += &format!(", {}", super::setting::named(&loaded.settings));
    }
    style
}
