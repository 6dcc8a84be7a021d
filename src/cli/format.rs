//! `pacinian format`.

use super::curves;
use super::failure::Failure;
use super::nodes::{self, markup, wrapped};
use super::paint::Paint;
use super::table::Table;
use super::terminal::Terminal;
use clap::{Args, ValueEnum};
use pacinian::node::NodeKind;
use pacinian::text::field::{self, Field};
use pacinian::text::nearest;
use pacinian::text::reference::{self, Defined, Topic, unsaid, wanted};
use pacinian::{patch, rig};

/// Explains what a patch and a rig may say: lists the topics, or explains one
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  pacinian format event\n  pacinian format shuffle     the topic that has this key\n\n\
    What nodes there are, `pacinian nodes` says; for programs and editors there is `pacinian schema`."
)]
pub struct Format {
    /// Explains this one: a topic, or any key
    topic: Option<String>,
    /// All of a reference as Markdown
    #[arg(long, value_enum, value_name = "OF", conflicts_with = "topic", hide = true)]
    markdown: Option<Book>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Book {
    Patch,
    Rig,
    Nodes,
    Felt,
}

/// The topics of a format, and what its keys refer to.
type Part = (&'static str, &'static [Topic], Defined);

const PARTS: [Part; 2] = [
    ("patch", patch::reference::TOPICS, patch::reference::DEFINED),
    ("rig", rig::reference::TOPICS, rig::reference::DEFINED),
];

impl Format {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        terminal.print(&match (&self.topic, self.markdown) {
            (_, Some(Book::Patch)) => book(&PARTS[0]),
            (_, Some(Book::Rig)) => book(&PARTS[1]),
            (_, Some(Book::Nodes)) => nodes::markdown(),
            (_, Some(Book::Felt)) => curves::markdown(),
            (None, None) => list(terminal.out),
            (Some(word), None) => {
                let (topic, defined) = find(word)?;
                explain(topic, defined, terminal.out)
            }
        })
    }
}

/// Whether a word is explained here.
pub fn knows(word: &str) -> bool {
    PARTS.iter().any(|(_, topics, _)| reference::find(topics.iter(), word).is_some())
}

/// Words that are looked for here, and where they are explained.
const ELSEWHERE: [(&[&str], &str); 3] = [
    (&["midi"], "notes and programs: `pacinian format trigger`; controllers: `pacinian format bind`"),
    (
        &["osc"],
        "addresses that set something off: `pacinian format trigger`; faders: `pacinian format bind`; all others: docs/osc.md",
    ),
    (&["live", "keys", "meter", "screen"], "docs/live.md, and `pacinian play --help`"),
];

fn find(word: &str) -> Result<(&'static Topic, Defined), Failure> {
    // A topic that is called so goes before a key of another.
    let named = PARTS.iter().find_map(|(_, topics, d)| Some((topics.iter().find(|t| t.name == word)?, *d)));
    let within = || PARTS.iter().find_map(|(_, topics, d)| Some((reference::find(topics.iter(), word)?, *d)));
    named.or_else(within).ok_or_else(|| {
        let known = PARTS.iter().flat_map(|(_, topics, _)| reference::words(topics.iter()));
        let elsewhere = ELSEWHERE.iter().find(|(words, _)| words.contains(&word));
        let help = if let Some((_, help)) = elsewhere {
            (*help).to_string()
        } else if NodeKind::find(word).is_some() {
            format!("it is a node: pacinian nodes {word}")
        } else {
            nearest::nearest(word, known).map_or_else(
                || "`pacinian format` lists all".into(),
                |near| format!("did you mean `{near}`?"),
            )
        };
        Failure::usage(format!("there is no topic `{word}`"), help)
    })
}

fn list(paint: Paint) -> String {
    let mut text = String::new();
    for (part, topics, _) in PARTS {
        text += &format!("{}\n", paint.bold(&format!("in a {part}")));
        let mut table = Table::default();
        topics.iter().for_each(|t| table.row([t.name, t.doc]));
        text += &format!("{}\n", table.text());
    }
    text + "`pacinian format TOPIC` explains one; `pacinian nodes` lists the nodes.\n"
}

fn explain(topic: &Topic, defined: Defined, paint: Paint) -> String {
    let mut text = format!("{}: {}\n", paint.bold(topic.name), topic.doc);
    if !topic.written.is_empty() {
        text += &format!("\n{}\n  {}\n", paint.bold("how it is written"), topic.written);
    }
    for (i, table) in topic.tables.iter().enumerate() {
        let head = if table.name == topic.name { "keys".into() } else { format!("keys of `{}`", table.name) };
        text += &format!("\n{}\n", paint.bold(&head));
        let (known, fields): (Vec<&Field>, Vec<&Field>) =
            table.fields.iter().chain(table.others).partition(|f| is_above(f, &topic.tables[..i]));
        for field in fields {
            let key = key(field);
            let default = match unsaid(field) {
                word if field.required => format!(", {}", paint.yellow(&word)),
                word if word.is_empty() => word,
                word => format!(", default {word}"),
            };
            let gap = " ".repeat(KEY.saturating_sub(key.len()).max(2));
            text += &format!("  {}{gap}{}{default}\n", paint.bold(key), wanted(field, defined));
            text += &format!("{}\n", wrapped(field.doc, &" ".repeat(KEY + 4)));
        }
        if !known.is_empty() {
            text += &format!("{}\n", wrapped(&as_above(&known), "  "));
        }
    }
    text += "\n";
    for line in topic.text.lines() {
        match line.strip_prefix("- ") {
            Some(item) => text += &format!("  - {}\n", wrapped(item, "    ").trim_start()),
            None if line.is_empty() => text += "\n",
            None => text += &format!("{}\n", wrapped(line, "  ")),
        }
    }
    if topic.name == "felt" {
        let head = "thresholds, dB above 1 um (peak), by how much they may be off; sources: docs/felt.md";
        text += &format!("\n{}\n{}", paint.bold(head), curves::text());
    }
    text + &format!(
        "\n{}\n  {}\n",
        paint.bold("example"),
        topic.example.replace('\n', "\n  ").replace("\n  \n", "\n\n")
    )
}

/// Whether a key is that of a table before.
fn is_above(field: &Field, before: &[&field::Table]) -> bool {
    before.iter().any(|table| {
        table.fields.iter().chain(table.others).any(|f| (f.key, f.doc) == (field.key, field.doc))
    })
}

fn key(field: &Field) -> &'static str {
    if field.key.is_empty() { "any other" } else { field.key }
}

/// What names a picture or a page leads to it.
fn linked(text: &str) -> String {
    ["body.svg", "felt.md"].iter().fold(text.to_string(), |text, page| {
        text.replace(&format!("docs/{page}"), &format!("[docs/{page}]({page})"))
    })
}

fn as_above(fields: &[&Field]) -> String {
    let keys: Vec<&str> = fields.iter().map(|f| key(f)).collect();
    format!("and, as above, {}", keys.join(", "))
}

/// Columns for a key.
const KEY: usize = 18;

fn book(part: &Part) -> String {
    let (name, topics, defined) = part;
    let mut text = format!(
        "# The {name} format\n\n<!-- Made by `pacinian format --markdown {name}`; a test keeps it in step. -->\n\n\
         The same in a terminal: `pacinian format`. For editors and programs: [`schema/{name}.json`](../schema/{name}.json).\n\n"
    );
    for topic in *topics {
        text += &format!("- [{0}](#{0}): {1}\n", topic.name, markup(topic.doc));
    }
    for topic in *topics {
        text += &format!("\n## {}\n\n{}", topic.name, markup(topic.doc));
        if !topic.written.is_empty() {
            text += &format!(" Written `{}`.", topic.written.replace('`', ""));
        }
        text += &format!("\n\n```toml\n{}\n```\n\n{}\n", topic.example, linked(&prose(topic.text)));
        for (i, table) in topic.tables.iter().enumerate() {
            let head =
                if table.name == topic.name { "key".into() } else { format!("key of `{}`", table.name) };
            text +=
                &format!("\n| {head} | what may stand there | default | what it is |\n|---|---|---|---|\n");
            let (known, fields): (Vec<&Field>, Vec<&Field>) =
                table.fields.iter().chain(table.others).partition(|f| is_above(f, &topic.tables[..i]));
            for field in fields {
                let key = if field.key.is_empty() { "any other".into() } else { format!("`{}`", field.key) };
                let cells = [wanted(field, defined), unsaid(field), field.doc.into()].map(|c| markup(&c));
                text += &format!("| {key} | {} |\n", cells.join(" | "));
            }
            if !known.is_empty() {
                text += &format!("\n{}.\n", as_above(&known));
            }
        }
    }
    text
}

/// Paragraphs; lines of a file within them stay lines.
fn prose(text: &str) -> String {
    let paragraph = |p: &str| {
        let is_file = p.lines().count() > 1 && !p.lines().any(|l| l.starts_with("- "));
        if is_file { format!("```\n{p}\n```") } else { markup(p) }
    };
    text.split("\n\n").map(paragraph).collect::<Vec<_>>().join("\n\n")
}
