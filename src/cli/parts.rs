//! `pacinian parts`.

use super::check::json;
use super::failure::Failure;
use super::nodes::wrapped;
use super::paint::Paint;
use super::table::{Table, many};
use super::terminal::Terminal;
use clap::Args;
use pacinian::rig::knob::motor::{self, Motor};
use pacinian::rig::knob::table::FIELDS;
use pacinian::rig::part::{self, Origin, Part, Source, Value};
use pacinian::text::field::Field;
use pacinian::text::nearest;
use serde::Serialize;
use std::collections::BTreeMap;

/// Lists the actuators that ship with pacinian, or shows all that is known of one, and where from
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pacinian parts coin-10mm\n\n\
    A rig takes one over with part = \"NAME\" under [actuator], and a motor of a knob with motor = \"NAME\" under [knob]; `pacinian motor NAME` says what\n\
    an actuator does, and `pacinian knob PATCH --rig RIG` what a knob does.\n\
    Every figure says how one came to know it: data-sheet (its maker says it), measured (somebody else measured and published it),\n\
    derived (it follows from others), assumed (nobody measured it: it is usual for such parts).")]
pub struct Parts {
    /// Shows this one
    name: Option<String>,
    /// As JSON
    #[arg(long)]
    json: bool,
}

/// A part, as programs read it.
#[derive(Debug, Serialize)]
struct PartReport {
    name: &'static str,
    title: &'static str,
    model: &'static str,
    /// Figures by their origin.
    origins: BTreeMap<&'static str, usize>,
    figures: Vec<FigureReport>,
    sources: Vec<SourceReport>,
}

#[derive(Debug, Serialize)]
struct FigureReport {
    key: &'static str,
    value: f64,
    unit: &'static str,
    doc: &'static str,
    origin: &'static str,
    from: &'static str,
}

#[derive(Debug, Serialize)]
struct SourceReport {
    title: &'static str,
    url: Option<&'static str>,
}

/// What a motor of a knob is, in place of a model.
const OF_KNOB: &str = "knob motor";

impl Parts {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        let Some(name) = &self.name else {
            let parts = part::all().iter().map(PartReport::new);
            let all: Vec<PartReport> = parts.chain(motor::all().iter().map(PartReport::of_knob)).collect();
            return terminal.print(&if self.json { json(&all) } else { list(&all, terminal.out) });
        };
        let of_knob = motor::find(name).map(PartReport::of_knob);
        let part = of_knob.map_or_else(|| find(name).map(PartReport::new), Ok)?;
        terminal.print(&if self.json { json(&part) } else { part.text(terminal.out) })
    }
}

/// The part of a name.
///
/// # Errors
/// Of usage, with the nearest name.
pub fn find(name: &str) -> Result<&'static Part, Failure> {
    part::find(name).ok_or_else(|| Failure::usage(format!("there is no part `{name}`"), advice(name)))
}

/// What to do where a name is not that of a part.
pub fn advice(name: &str) -> String {
    let names = part::all().iter().map(|part| part.name).chain(motor::all().iter().map(|motor| motor.name));
    nearest::suggest(name, names).unwrap_or_else(|| "`pacinian parts` lists them".into())
}

/// "2 from a data sheet, 1 measured, 3 assumed".
pub fn counted(counts: &BTreeMap<&'static str, usize>) -> String {
    let said = |(word, n): (&'static str, &usize)| {
        let words = if word == Origin::DataSheet.word() { "from a data sheet" } else { word };
        format!("{n} {words}")
    };
    let of = |origin: &Origin| counts.get_key_value(origin.word()).map(|(word, n)| said((word, n)));
    let known: Vec<String> = Origin::ALL.iter().filter_map(of).collect();
    known.join(", ")
}

impl PartReport {
    fn new(part: &'static Part) -> Self {
        let named = (part.name, &*part.title, part.model.word());
        Self::of(named, &part.values, &part.sources, part::fields())
    }

    fn of_knob(motor: &'static Motor) -> Self {
        Self::of((motor.name, &motor.title, OF_KNOB), &motor.values, &motor.sources, FIELDS.iter())
    }

    fn of(
        (name, title, model): (&'static str, &'static str, &'static str),
        values: &'static BTreeMap<&'static str, Value>,
        sources: &'static [Source],
        fields: impl Iterator<Item = &'static Field>,
    ) -> Self {
        let mut origins = BTreeMap::new();
        for value in values.values() {
            *origins.entry(value.origin.word()).or_default() += 1;
        }
        // In the order in which one fills them in.
        let figures = fields.filter_map(|field| {
            let value = values.get(field.key)?;
            let (origin, from) = (value.origin.word(), value.from.as_str());
            Some(FigureReport {
                key: field.key,
                value: value.value,
                unit: field.unit,
                doc: field.doc,
                origin,
                from,
            })
        });
        Self {
            name,
            title,
            model,
            origins,
            figures: figures.collect(),
            sources: sources
                .iter()
                .map(|source| SourceReport { title: &source.title, url: source.url.as_deref() })
                .collect(),
        }
    }

    fn text(&self, paint: Paint) -> String {
        let mut text = format!("{}: {}\n  model  {}\n", paint.bold(self.name), self.title, self.model);
        text += &format!("  {}: {}\n\n", many(self.figures.len(), "figure"), counted(&self.origins));
        let mut table = Table::default();
        table.row(["figure", "value", "", "known", "how"].map(|head| paint.dim(head)));
        for figure in &self.figures {
            let origin = match figure.origin {
                "assumed" => paint.yellow(figure.origin),
                other => other.into(),
            };
            table.row([
                figure.key.into(),
                number(figure.value),
                figure.unit.into(),
                origin,
                figure.from.into(),
            ]);
        }
        text += &table.text();
        text += &format!("\n{}\n", paint.bold("what they are"));
        for figure in &self.figures {
            text += &format!("  {}\n{}\n", figure.key, wrapped(figure.doc, "      "));
        }
        if self.sources.is_empty() {
            return text + "\nNo sources: none of it was measured.\n";
        }
        text += &format!("\n{}\n", paint.bold("sources"));
        for source in &self.sources {
            text += &format!("{}\n", wrapped(source.title, "  "));
            text += &source.url.map_or(String::new(), |url| format!("      {url}\n"));
        }
        text
    }
}

/// A figure as short as it is exact.
pub fn number(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e6).contains(&value.abs()) { format!("{value:e}") } else { value.to_string() }
}

fn list(all: &[PartReport], paint: Paint) -> String {
    let mut table = Table::default();
    table.row(["part", "what", "model", "figures"].map(|head| paint.dim(head)));
    for part in all {
        table.row([part.name, part.title, part.model, &counted(&part.origins)]);
    }
    table.text() + "\n`pacinian parts NAME` shows one; `pacinian motor NAME` says what an actuator does.\n"
}
