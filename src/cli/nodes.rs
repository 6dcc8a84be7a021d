//! `pacinian nodes`.

use super::check::json;
use super::failure::Failure;
use super::format;
use super::paint::Paint;
use super::table::Table;
use super::terminal::Terminal;
use clap::Args;
use pacinian::node::spec::{Family, Kind, NodeSpec, Numeric, Param};
use pacinian::node::{NodeKind, REGISTRY, words};
use pacinian::text::reference::short;
use serde::Serialize;

/// Lists the nodes that patches are made of, or explains one
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pacinian nodes envelope")]
pub struct Nodes {
    /// Explains this one
    name: Option<String>,
    /// As JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize)]
struct NodeReport {
    name: &'static str,
    family: &'static str,
    summary: &'static str,
    definition: &'static str,
    example: &'static str,
    parameters: Vec<ParamReport>,
}

#[derive(Debug, Serialize)]
struct ParamReport {
    name: &'static str,
    kind: &'static str,
    unit: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    least: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    most: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    choices: Option<&'static [&'static str]>,
    default: Option<String>,
    required: bool,
    doc: &'static str,
}

impl Nodes {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        let Some(name) = &self.name else {
            let text = if self.json {
                json(&REGISTRY.iter().map(|spec| report(spec)).collect::<Vec<_>>())
            } else {
                list(terminal.out)
            };
            return terminal.print(&text);
        };
        let Some(kind) = NodeKind::find(name) else {
            let help = if format::knows(name) {
                format!("it is a part of a patch or a rig: pacinian format {name}")
            } else {
                words::advice(name)
            };
            return Err(Failure::usage(format!("there is no node `{name}`"), help));
        };
        let spec = kind.spec();
        terminal.print(&if self.json { json(&report(spec)) } else { explain(spec, terminal.out) })
    }
}

fn report(spec: &'static NodeSpec) -> NodeReport {
    NodeReport {
        name: spec.name,
        family: family(spec.family),
        summary: spec.summary,
        definition: spec.detail,
        example: spec.example,
        parameters: spec.params.iter().map(param).collect(),
    }
}

fn param(p: &'static Param) -> ParamReport {
    let numeric = numeric(&p.kind);
    let (choices, default, required) = match p.kind {
        Kind::Choice(words, default) => (Some(words), words.get(default).map(ToString::to_string), false),
        Kind::Flag(default) => (None, Some(default.to_string()), false),
        _ => {
            let default = numeric.and_then(|n| n.default);
            (None, default.map(|x| x.to_string()), default.is_none())
        }
    };
    ParamReport {
        name: p.name,
        kind: kind(&p.kind),
        unit: p.unit,
        least: numeric.map(|n| n.least).filter(|x| x.is_finite()),
        most: numeric.map(|n| n.most).filter(|x| x.is_finite()),
        choices,
        default,
        required,
        doc: p.doc,
    }
}

fn numeric(kind: &Kind) -> Option<Numeric> {
    match kind {
        Kind::Signal(n) | Kind::Frequency(n) | Kind::Start(n) | Kind::Constant(n) => Some(*n),
        _ => None,
    }
}

fn kind(kind: &Kind) -> &'static str {
    match kind {
        Kind::Signal(_) | Kind::Frequency(_) => "signal",
        Kind::Start(_) => "at onset",
        Kind::Constant(_) => "number",
        Kind::Signals => "signals",
        Kind::Choice(..) => "word",
        Kind::Points => "points",
        Kind::File => "WAV file",
        Kind::Flag(_) => "true/false",
    }
}

const FAMILIES: [(Family, &str); 9] = [
    (Family::Oscillator, "oscillators"),
    (Family::Noise, "noise"),
    (Family::Envelope, "envelopes"),
    (Family::Recording, "recordings"),
    (Family::Arithmetic, "arithmetic"),
    (Family::Filter, "filters"),
    (Family::Input, "input"),
    (Family::Motor, "motors"),
    (Family::Place, "places"),
];

fn family(family: Family) -> &'static str {
    FAMILIES.iter().find(|(f, _)| *f == family).map_or("", |(_, name)| name)
}

fn list(paint: Paint) -> String {
    let mut text = String::new();
    let width = REGISTRY.iter().map(|spec| spec.name.len()).max().unwrap_or(0);
    for (family, title) in FAMILIES {
        let mut nodes = REGISTRY.iter().filter(|spec| spec.family == family).peekable();
        if nodes.peek().is_none() {
            continue;
        }
        text += &format!("{}\n", paint.bold(title));
        for spec in nodes {
            let summary = spec.summary;
            text += &format!("  {}{}  {summary}\n", spec.name, " ".repeat(width - spec.name.len()));
        }
        text.push('\n');
    }
    text + "`pacinian nodes NAME` explains one.\n"
}

fn explain(spec: &NodeSpec, paint: Paint) -> String {
    let mut text = format!("{}: {}\n\n{}\n", paint.bold(spec.name), spec.summary, wrapped(spec.detail, "  "));
    text += &format!("\n{}\n", paint.bold("parameters"));
    let mut table = Table::default();
    table.row(["name", "kind", "range", "default", "what it is"].map(|head| paint.dim(head)));
    for p in spec.params {
        let p = param(p);
        table.row([p.name.into(), p.kind.into(), range(&p), default(&p), p.doc.to_string()]);
    }
    if spec.params.is_empty() {
        table = Table::default();
        table.row(["none"]);
    }
    text += &table.text();
    if spec.params.iter().any(|p| matches!(p.kind, Kind::Signal(_) | Kind::Frequency(_) | Kind::Signals)) {
        text += &wrapped(
            "A signal is a number, the name of a node or a control, or an expression of them, and may move at every sample. \
             What is read at onset is a number or an expression of the event's fields.",
            "  ",
        );
        text.push('\n');
    }
    text + &format!("\n{}\n  {}\n", paint.bold("example"), spec.example.trim().replace('\n', "\n  "))
}

/// All nodes as Markdown.
pub fn markdown() -> String {
    let mut text = String::from(
        "# The nodes\n\n<!-- Made by `pacinian format --markdown nodes`; a test keeps it in step. -->\n\n\
         The same in a terminal: `pacinian nodes`, `pacinian nodes NAME`.\n\n\
         A signal is a number, the name of a node or a control, or an [expression](patch.md#expression) of them, and may move at every \
         sample. What is read at onset is a number or an expression of the event's fields.\n",
    );
    let of = |family: Family| REGISTRY.iter().filter(move |spec| spec.family == family);
    for (family, title) in FAMILIES {
        let links: Vec<String> = of(family).map(|spec| format!("[{0}](#{0})", spec.name)).collect();
        if !links.is_empty() {
            text += &format!("\n- {title}: {}", links.join(", "));
        }
    }
    text.push('\n');
    for spec in FAMILIES.iter().flat_map(|(family, _)| of(*family)) {
        let (name, summary, detail) = (spec.name, markup(spec.summary), markup(spec.detail));
        let example = spec.example.trim();
        text += &format!("\n## {name}\n\n{summary}\n\n```toml\n{example}\n```\n\n{detail}\n");
        if spec.params.is_empty() {
            continue;
        }
        text += "\n| parameter | kind | range | default | what it is |\n|---|---|---|---|---|\n";
        for p in spec.params.iter().map(param) {
            let (range, default) = (markup(&range(&p)), default(&p));
            text += &format!("| `{}` | {} | {range} | {default} | {} |\n", p.name, p.kind, markup(p.doc));
        }
    }
    text
}

/// Text in which nothing is a link, a column or an emphasis; what stands between backticks is left as it is.
pub fn markup(text: &str) -> String {
    let part = |(i, part): (usize, &str)| {
        let part = part.replace('|', "\\|");
        if i % 2 == 1 { part } else { part.replace('[', "\\[").replace('*', "\\*").replace('<', "&lt;") }
    };
    text.split('`').enumerate().map(part).collect::<Vec<_>>().join("`")
}

fn range(p: &ParamReport) -> String {
    match (p.choices, p.least, p.most) {
        (Some(words), ..) => words.join(", "),
        (None, None, None) => String::new(),
        (None, least, most) => {
            let end = |x: Option<f64>| x.map_or("any".into(), short);
            let unit = if p.unit.is_empty() { String::new() } else { format!(" {}", p.unit) };
            format!("{} to {}{unit}", end(least), end(most))
        }
    }
}

fn default(p: &ParamReport) -> String {
    p.default.clone().unwrap_or_else(|| "required".into())
}

/// Lines of at most 100 characters.
pub fn wrapped(text: &str, indent: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last().map_or(0, |l| l.chars().count());
        match lines.last_mut() {
            Some(last) if line == 0 => last.push_str(word),
            Some(last) if line + 1 + word.chars().count() <= 100 - indent.len() => {
                last.push(' ');
                last.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines.iter().map(|line| format!("{indent}{line}")).collect::<Vec<_>>().join("\n")
}
