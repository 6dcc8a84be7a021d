//! What tactors were measured to give, as a rig says it.

mod date;
mod of_rig;

use date::date;

use crate::perception::calibration::{Table, UNITS, Unit};
use crate::perception::fault::Fault;
use crate::perception::site::{self, Site};
use crate::text::cells::cells;
use crate::text::field::{Field, Form, Table as Keys};
use crate::text::reader::Reader;
use crate::text::{Problem, Span};

/// A calibration, `[calibration.NAME]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// Its name.
    pub name: String,
    /// When it was measured, as written: a year, a month and a day.
    pub date: String,
    /// How, and on what.
    pub method: String,
    /// Area of the contactor, m².
    pub area: f64,
    /// Where on the body it was measured; `None`: on no skin.
    pub site: Option<&'static Site>,
    /// What the numbers of `points` are.
    pub unit: Unit,
    /// The word for that.
    pub unit_word: &'static str,
    /// Frequencies (Hz) and outputs; empty where they stand in a file that was not read.
    pub points: Vec<[f64; 2]>,
    /// The file in which they stand, relative to that of the rig; `None`: in the rig.
    pub file: Option<String>,
    /// Where it stands.
    pub span: Span,
    /// Where its table, or the name of its file, stands.
    pub table_span: Span,
}

/// Its keys.
pub(crate) static TABLE: Keys = Keys {
    name: "calibration",
    doc: "What a tactor was measured to give.",
    fields: &[
        Field::new("date", Form::Defined("date"), "", "When it was measured.").required(),
        Field::new(
            "method",
            Form::Text,
            "",
            "How it was measured, on what, and how hard that was pressed: whoever doubts it reads this.",
        )
        .required(),
        Field::new(
            "unit",
            Form::Word(UNITS),
            "",
            "What the numbers of the table are: displacement, velocity or acceleration, for each volt at the tactor, each ampere, or full scale \
             of the device (FS). Peak over peak, or rms over rms.",
        )
        .required(),
        Field::new("area", Form::any_number(1e-8, 1e-2), "m2", "Area of the contactor: 2e-5 for one of 5 mm.").required(),
        Field::new(
            "site",
            Form::Defined("site"),
            "",
            "Where on the body it was measured, as skin loads a tactor; leave it out where it was measured on no skin.",
        ),
        Field::new(
            "table",
            Form::Defined("table"),
            "",
            "Frequency (Hz) and output at each: [[50, 31.0], [250, 12.5]], or a file beside the rig, \"left.csv\". Straight in dB over the logarithm \
             of the frequency in between; beyond the first and the last nothing is known.",
        )
        .required(),
    ],
    others: None,
};

pub(crate) fn read(name: &str, reader: &Reader) -> Calibration {
    let (unit_word, unit) = Unit::at(reader.word("unit"));
    let mut calibration = Calibration {
        name: name.into(),
        date: date(reader).unwrap_or_default(),
        method: reader.text("method").unwrap_or_default().trim().into(),
        area: reader.number("area").unwrap_or(1e-4),
        site: read_site(reader),
        unit,
        unit_word,
        points: Vec::new(),
        file: None,
        span: reader.span.clone(),
        table_span: reader.span_of("table"),
    };
    if reader.has("method") && calibration.method.is_empty() {
        let help = "say it in words: method = \"laser vibrometer, on the fingertip, 0.5 N\"".to_string();
        let what = format!("the method of {} says nothing", reader.who);
        reader.sink.push(Problem::error(&reader.span_of("method"), what).help(help));
    }
    calibration.table(reader);
    calibration
}

/// Reads the site at `site`.
pub(super) fn read_site(reader: &Reader) -> Option<&'static Site> {
    let value = reader.at("site")?;
    reader.word_of("site", &value, site::WORDS).and_then(|place| site::SITES.get(place))
}

impl Calibration {
    /// Reads `table`.
    fn table(&mut self, reader: &Reader) {
        let Some(value) = reader.at("table") else { return };
        if let Some(file) = value.text().filter(|file| !file.is_empty()) {
            self.file = Some(file.into());
            return;
        }
        let Some(list) = value.list() else {
            reader.mistaken(
                "table",
                &value,
                "a list of pairs, [[50, 31.0], [250, 12.5]], or the name of a file",
            );
            return;
        };
        let mut spans = Vec::new();
        for point in list {
            let pair: Option<Vec<f64>> = point.list().and_then(|pair| pair.map(|x| x.number()).collect());
            let Some([hertz, output]) = pair.as_deref().and_then(|pair| <[f64; 2]>::try_from(pair).ok())
            else {
                let what = format!(
                    "a point of {} is {}; it must be a pair, [Hz, output]",
                    reader.who,
                    point.shown()
                );
                reader.sink.error(&point.span(), what);
                return;
            };
            self.points.push([hertz, output]);
            spans.push(point.span());
        }
        if let Err(fault) = Table::new(&self.points, self.unit) {
            let span = fault.point().and_then(|n| spans.get(n)).unwrap_or(&self.table_span);
            reader.sink.error(span, format!("{}: {fault}", reader.who));
        }
    }

    /// What it says of the frequency; `None` where it stands in a file that was not read.
    ///
    /// # Errors
    /// What is wrong with its points, where they were made or changed in code.
    pub fn response(&self) -> Option<Result<Table, Fault>> {
        (self.file.is_none() || !self.points.is_empty()).then(|| Table::new(&self.points, self.unit))
    }

    /// Takes the points from the text of its file: a line of column names with `frequency` and `output`, and a line for each point. Other columns
    /// are passed over, and cells may stand in double quotes.
    ///
    /// # Errors
    /// What is wrong, each with its place in the text.
    pub fn take(&mut self, text: &str) -> Result<(), Vec<Problem>> {
        let mut problems = Vec::new();
        let (mut columns, mut places): (Option<[usize; 2]>, Vec<Span>) = (None, Vec::new());
        let mut from = 0;
        self.points.clear();
        for line in text.split_inclusive('\n') {
            let span = from..from + line.trim_end().len();
            from += line.len();
            let line = line.trim_start_matches('\u{feff}').trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let cells: Vec<String> = match cells(line) {
                Ok(cells) => cells.into_iter().map(|cell| cell.text).collect(),
                Err(what) => {
                    problems.push(Problem::error(&span, what));
                    if columns.is_none() || problems.len() >= MOST_WRONG {
                        break;
                    }
                    continue;
                }
            };
            let Some([hertz, output]) = columns else {
                let find = |wanted: &str| cells.iter().position(|cell| *cell == wanted);
                let (Some(hertz), Some(output)) = (find("frequency"), find("output")) else {
                    let what =
                        "the first line names the columns, and two of them must be `frequency` and `output`";
                    let help = "write frequency,output; cells are divided by commas".to_string();
                    return Err(vec![Problem::error(&span, what).help(help)]);
                };
                if let Some(twice) = ["frequency", "output"]
                    .into_iter()
                    .find(|name| cells.iter().filter(|cell| cell == name).count() > 1)
                {
                    let what = format!("two columns are called `{twice}`");
                    let help = "leave the one that counts, and call the other something else".to_string();
                    return Err(vec![Problem::error(&span, what).help(help)]);
                }
                columns = Some([hertz, output]);
                continue;
            };
            let number = |place: usize| cells.get(place).and_then(|cell| cell.trim().parse::<f64>().ok());
            match (number(hertz), number(output)) {
                (Some(hertz), Some(output)) => {
                    self.points.push([hertz, output]);
                    places.push(span);
                }
                _ => problems
                    .push(Problem::error(&span, format!("`{line}` has no number for frequency or output"))),
            }
            if problems.len() >= MOST_WRONG {
                break;
            }
        }
        if problems.is_empty()
            && let Err(fault) = Table::new(&self.points, self.unit)
        {
            let problem = Problem::of_file(fault.to_string());
            let span = fault.point().and_then(|n| places.get(n)).cloned();
            problems.push(Problem { span, ..problem });
        }
        if problems.is_empty() {
            return Ok(());
        }
        self.points.clear();
        Err(problems)
    }
}

/// So many lines that say no numbers are told.
const MOST_WRONG: usize = 20;

#[cfg(test)]
mod tests;
