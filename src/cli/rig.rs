//! `pacinian rig`.

use super::failure::Failure;
use super::terminal::Terminal;
use clap::{Args, Subcommand};
use pacinian::io::out::OutputFile;
use pacinian::space::fault::Fault;
use pacinian::space::layout::{self, Hand, Layout};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;

/// Makes rigs
#[derive(Debug, Args)]
pub struct RigCommand {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    New(New),
}

/// Prints the rig of a common array: every tactor with its name, channel and position, groups, and what is where
#[derive(Debug, Args)]
#[command(
    after_help = "Layouts:\n  line 8           a row, 40 mm apart (--spacing)\n  grid 4x5         rows by columns, 40 mm apart (--spacing)\n  \
    ring 12          a ring of 50 mm (--radius)\n  belt 8           around the waist, the first one in front\n  vest 40          twenty in front and twenty on the back\n  \
    sleeve 4x6       rows around a forearm (4x6 where nothing is said)\n  hand right       finger tips, pads and palm of a hand (left or right)\n\n\
    Example:\n  pacinian rig new grid 4x5 -o back.toml\n  pacinian check PATCH --rig back.toml\n\n\
    Then write what your card and your actuators are into it: `pacinian format rig` says what may stand there."
)]
struct New {
    /// line, grid, ring, belt, vest, sleeve or hand
    layout: String,
    /// How many: 8, or rows by columns, 4x5; of a hand, left or right
    #[arg(allow_negative_numbers = true)]
    size: Option<String>,
    /// Of a line or a grid: metres from one tactor to the next [default: 0.04]
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    spacing: Option<f64>,
    /// Of a ring: its radius in metres [default: 0.05]
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    radius: Option<f64>,
    /// Writes it into this file, which must not be there yet
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Metres from one tactor of a line or a grid to the next: about what a back tells apart.
const SPACING: f64 = 0.04;

/// Of a ring, metres.
const RADIUS: f64 = 0.05;

/// The layouts that there are.
const LAYOUTS: [&str; 7] = ["line", "grid", "ring", "belt", "vest", "sleeve", "hand"];

impl RigCommand {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        let What::New(new) = &self.what;
        let layout = new.made()?;
        let text = text(&layout, &new.words(), new.layout == "sleeve");
        match &new.output {
            None => terminal.print(&text),
            Some(path) if path.exists() => {
                let what = format!("`{}` is there already", path.display());
                Err(Failure::usage(what, "give another --output, or take that file away").with_code(73))
            }
            Some(path) => {
                let mut file = OutputFile::create(path)?;
                file.write_all(text.as_bytes()).and_then(|()| file.flush()).map_err(|error| {
                    Failure::said(74, format!("`{}` could not be written: {error}", path.display()))
                })
            }
        }
    }
}

impl New {
    /// How it was asked for.
    fn words(&self) -> String {
        let mut words = format!("pacinian rig new {}", self.layout);
        // A string takes whatever it is given.
        let _ = self.size.iter().try_for_each(|size| write!(words, " {size}"));
        let _ = self.spacing.iter().try_for_each(|metres| write!(words, " --spacing {metres}"));
        let _ = self.radius.iter().try_for_each(|metres| write!(words, " --radius {metres}"));
        words
    }

    fn made(&self) -> Result<Layout, Failure> {
        let name = self.layout.as_str();
        if !LAYOUTS.contains(&name) {
            let what = format!("there is no layout `{name}`");
            return Err(Failure::usage(what, format!("give one of {}", LAYOUTS.join(", "))));
        }
        for (given, option, of) in [
            (self.spacing.is_some(), "--spacing", &["line", "grid"][..]),
            (self.radius.is_some(), "--radius", &["ring"][..]),
        ] {
            if given && !of.contains(&name) {
                let what = format!("{option} is for {}, not for a {name}", of.join(" and "));
                return Err(Failure::usage(what, "leave it out, and change positions in the file"));
            }
        }
        let spacing = self.spacing.unwrap_or(SPACING);
        let made = match name {
            "line" => layout::line(self.count(8)?, spacing),
            "grid" => {
                let [rows, columns] = self.rows_by([4, 4])?;
                layout::grid(rows, columns, spacing)
            }
            "ring" => layout::ring(self.count(8)?, self.radius.unwrap_or(RADIUS)),
            "belt" => layout::belt(self.count(8)?),
            "vest" => match self.count(40)? {
                40 => Ok(layout::vest()),
                other => {
                    let what = format!("a vest of {other} is not known, one of 40 is");
                    return Err(Failure::usage(what, "begin with: pacinian rig new vest 40"));
                }
            },
            "sleeve" => {
                let [rows, around] = self.rows_by([4, 6])?;
                layout::sleeve(rows, around)
            }
            _ => match self.size.as_deref() {
                None | Some("right") => Ok(layout::hand(Hand::Right)),
                Some("left") => Ok(layout::hand(Hand::Left)),
                Some(other) => {
                    return Err(Failure::usage(format!("there is no hand `{other}`"), "give left or right"));
                }
            },
        };
        made.map_err(|fault: Fault| Failure::usage(fault.to_string(), "see `pacinian rig new --help`"))
    }

    fn count(&self, usual: usize) -> Result<usize, Failure> {
        let Some(size) = &self.size else { return Ok(usual) };
        size.parse().map_err(|_| {
            let what = format!("`{size}` does not say how many tactors a {} has", self.layout);
            Failure::usage(what, format!("give a number: pacinian rig new {} {usual}", self.layout))
        })
    }

    fn rows_by(&self, usual: [usize; 2]) -> Result<[usize; 2], Failure> {
        let Some(size) = &self.size else { return Ok(usual) };
        let found =
            size.split_once(['x', 'X', '×']).and_then(|(a, b)| Some([a.parse().ok()?, b.parse().ok()?]));
        found.ok_or_else(|| {
            let what = format!("`{size}` does not say how many rows and columns a {} has", self.layout);
            let [a, b] = usual;
            Failure::usage(what, format!("give both: pacinian rig new {} {a}x{b}", self.layout))
        })
    }
}

/// The rig of a layout as a file; `unrolled`: of what goes around a limb.
fn text(layout: &Layout, made_by: &str, unrolled: bool) -> String {
    let channels = layout.tactors.len();
    let mut text = format!("format = \"pacinian-rig/1\"\ntitle = \"{}\"\n\n", layout.title);
    for line in layout.notes.iter().flat_map(|note| lines(note)) {
        text += &format!("# {line}\n");
    }
    for line in picture(layout, unrolled) {
        text += format!("#{line}").trim_end();
        text.push('\n');
    }
    text += &format!(
        "#\n# Made by: {made_by}\n\n[device]\nchannels = {channels}\n# rate = 48000                      # frames a second of your card\n\
         # full_scale_volts = 1.0            # what a sample of 1.0 is, with a meter\n# coupling = {{ high_pass = 5.0 }}    # or \"dc\"\n\n\
         # What hangs there, for all of them: `pacinian parts` lists those that are known. Name it in each tactor: actuator = \"mine\".\n\
         # [actuator.mine]\n# part = \"NAME\"\n\n# Positions are metres.\n"
    );
    for (n, tactor) in layout.tactors.iter().enumerate() {
        let position: Vec<String> = tactor.position.iter().map(|x| format!("{x:?}")).collect();
        let kept = if layout.tactors.iter().all(|tactor| tactor.position[2] == 0.0) { 2 } else { 3 };
        text += &format!(
            "\n[[tactor]]\nname = \"{}\"\nchannel = {}\nposition = [{}]\n",
            tactor.name,
            n + 1,
            position[..kept].join(", ")
        );
    }
    text += "\n# Groups: what is played at their names sounds on all of them.\n";
    for group in &layout.groups {
        let names = group.tactors.iter().filter_map(|n| layout.tactors.get(*n));
        let names: Vec<String> = names.map(|tactor| format!("\"{}\"", tactor.name)).collect();
        text += &format!("\n[group.{}]\ntactors = [\n", group.name);
        for row in names.chunks(8) {
            text += &format!("  {},\n", row.join(", "));
        }
        text += "]\n";
    }
    text
}

/// A text in lines of no more than 100 letters.
fn lines(text: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(last) if last.is_empty() => last.push_str(word),
            Some(last) if last.chars().count() + word.chars().count() < 100 => {
                last.push(' ');
                last.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}

/// Letters across a picture, at most.
const ACROSS: f64 = 64.0;

/// Lines of one, at most.
const HIGH: f64 = 16.0;

/// A letter is about twice as high as it is wide.
const TALL: f64 = 2.2;

/// Where the channels are, from one side or two: what lies behind another is drawn apart, and what goes around a limb is unrolled.
fn picture(layout: &Layout, unrolled: bool) -> Vec<String> {
    let mut places = layout.positions();
    if unrolled {
        for place in &mut places {
            let [x, y, z] = *place;
            // From underneath over the left, the top and the right; up is towards the hand.
            *place = [0.05 * x.atan2(y), z, 0.0];
        }
    }
    let span = |axis: usize| {
        let all = || places.iter().map(|place| place[axis]);
        (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max))
    };
    let [x, y, z] = [0, 1, 2].map(span);
    let deep = |(least, most): (f64, f64)| most - least;
    // Seen from above where nothing stands up, else from behind; what has two sides is drawn side by side.
    let level = deep(y) < 1e-6 && deep(z) > 1e-6;
    let (up, upward) = if level { (2, "ahead") } else { (1, "up") };
    let rows = span(up);
    let two = !level && deep(z) > 0.05 && deep(x) > 1e-6;
    let middle = 0.5 * (z.0 + z.1);
    let sides: Vec<(&str, Vec<usize>)> = match two {
        false => vec![("", (0..places.len()).collect())],
        true => {
            let (near, far) = (0..places.len()).partition(|n| places[*n][2] < middle);
            vec![("back, seen from behind", near), ("front, as the wearer has it", far)]
        }
    };
    let wide = deep(x).max(1e-9);
    let columns = (6.0 * (places.len() as f64).sqrt() + 4.0).clamp(8.0, ACROSS);
    let scale = columns / wide;
    let lines = (scale * deep(rows) / TALL).min(HIGH);
    let by = if deep(rows) > 1e-9 { lines / deep(rows) } else { 0.0 };
    let mut all = vec![String::new()];
    for (side, numbers) in sides {
        let (width, height) = ((scale * wide) as usize + 4, lines.round() as usize + 1);
        let mut canvas = vec![vec![' '; width + 2]; height];
        for n in numbers {
            let column = (scale * (places[n][0] - x.0)).round() as usize;
            let row = height - 1 - ((by * (places[n][up] - rows.0)).round() as usize).min(height - 1);
            for (k, letter) in (n + 1).to_string().chars().enumerate() {
                if let Some(cell) = canvas[row].get_mut(column + k + 1) {
                    *cell = letter;
                }
            }
        }
        if !side.is_empty() {
            all.push(format!(" {side}:"));
        }
        all.extend(canvas.into_iter().map(|row| format!(" {}", row.into_iter().collect::<String>())));
        all.push(String::new());
    }
    all.push(match unrolled {
        true => " Numbers are channels; unrolled: the top is in the middle, left and right beside it, the hand is up.".into(),
        false => format!(" Numbers are channels; the wearer's right is on the right, {upward} is up."),
    });
    all
}
