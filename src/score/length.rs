//! What is known of sheets before they are played: which play anything, how deep they nest, how long they are.

use std::collections::HashSet;

use super::MOST_DEEP;
use super::sheet::{Content, Deed, Item, Sheet};
use crate::text::Problem;

/// The sheets that a deed may play.
pub(super) fn nested(deed: &Deed) -> Vec<usize> {
    match deed {
        Deed::Pattern(nested) => vec![nested.sheet],
        Deed::Choose(all) => all.iter().flat_map(|(_, deed)| nested(deed)).collect(),
        Deed::Play(_) | Deed::Motion(_) | Deed::Marker(_) => Vec::new(),
    }
}

/// Whether nothing ever comes of a deed.
pub(super) fn is_barren(sheets: &[Option<Sheet>], deed: &Deed) -> bool {
    match deed {
        Deed::Pattern(nested) => sheets.get(nested.sheet).and_then(Option::as_ref).is_none_or(|s| s.barren),
        Deed::Choose(all) => all.iter().all(|(_, deed)| is_barren(sheets, deed)),
        Deed::Play(_) | Deed::Motion(_) | Deed::Marker(_) => false,
    }
}

/// Takes out what plays nothing and notes lengths.
///
/// # Errors
/// A pattern that contains itself; patterns nested too deep.
pub(super) fn settle(sheets: &mut [Option<Sheet>]) -> Result<(), Problem> {
    for index in innermost_first(sheets)? {
        let Some(Some(mut sheet)) = sheets.get_mut(index).map(Option::take) else { continue };
        if let Content::Held(items) = &mut sheet.content {
            if items.iter().any(|item| is_barren(sheets, &item.deed)) {
                std::sync::Arc::make_mut(items).retain(|item| !is_barren(sheets, &item.deed));
            }
            sheet.barren = items.is_empty();
        }
        sheet.length = length(sheets, &sheet);
        sheets[index] = Some(sheet);
    }
    Ok(())
}

/// Notes which sheets play nothing now that one more is known to.
pub(super) fn spread_barrenness(sheets: &mut [Option<Sheet>]) {
    let silent = |sheets: &[Option<Sheet>], sheet: &Sheet| match &sheet.content {
        Content::Held(items) => items.iter().all(|item| is_barren(sheets, &item.deed)),
        Content::File { .. } => false,
    };
    loop {
        let news = sheets.iter().position(|s| s.as_ref().is_some_and(|s| !s.barren && silent(sheets, s)));
        let Some(Some(sheet)) = news.and_then(|index| sheets.get_mut(index)) else { return };
        sheet.barren = true;
    }
}

/// All sheets, each after those it plays.
fn innermost_first(sheets: &[Option<Sheet>]) -> Result<Vec<usize>, Problem> {
    #[derive(Clone, Copy, PartialEq)]
    enum Seen {
        No,
        Open,
        /// How many sheets deep it is.
        Done(u32),
    }
    let children = |index: usize| -> Vec<usize> {
        let Some(Some(Sheet { content: Content::Held(items), .. })) = sheets.get(index) else {
            return Vec::new();
        };
        let all: HashSet<usize> = items.iter().flat_map(|item| nested(&item.deed)).collect();
        all.into_iter().filter(|c| sheets.get(*c).is_some_and(Option::is_some)).collect()
    };
    let mut seen = vec![Seen::No; sheets.len()];
    let mut order = Vec::with_capacity(sheets.len());
    for root in (0..sheets.len()).filter(|i| sheets[*i].is_some()) {
        if seen[root] != Seen::No {
            continue;
        }
        seen[root] = Seen::Open;
        let mut stack = vec![(root, children(root), 1)];
        while let Some((index, ahead, deep)) = stack.last_mut() {
            let index = *index;
            let Some(sheet) = &sheets[index] else { break };
            match ahead.pop() {
                Some(child) => match seen[child] {
                    Seen::No => {
                        seen[child] = Seen::Open;
                        stack.push((child, children(child), 1));
                    }
                    Seen::Open => {
                        let what = format!("pattern `{}` contains itself", sheet.name);
                        return Err(Problem::error(&sheet.span, what));
                    }
                    Seen::Done(below) => *deep = (*deep).max(below + 1),
                },
                None => {
                    if *deep > MOST_DEEP {
                        let what = format!("pattern `{}` nests more than {MOST_DEEP} deep", sheet.name);
                        return Err(Problem::error(&sheet.span, what));
                    }
                    let below = *deep;
                    seen[index] = Seen::Done(below);
                    order.push(index);
                    stack.pop();
                    if let Some((_, _, deep)) = stack.last_mut() {
                        *deep = (*deep).max(below + 1);
                    }
                }
            }
        }
    }
    Ok(order)
}

/// Seconds from the start of a sheet, played at rate 1, to the end of its last event.
fn length(sheets: &[Option<Sheet>], sheet: &Sheet) -> Option<f64> {
    let Content::Held(items) = &sheet.content else { return None };
    if sheet.barren {
        return Some(0.0);
    }
    if sheet.shuffle || sheet.jitter.is_some() {
        return None;
    }
    let scale = sheet.unit / sheet.rate;
    let end = |item: &Item| {
        item.repeat.as_ref().is_none_or(|r| r.times.is_some()).then_some(())?;
        let onset = scale * item.onset(item.at, item.times() - 1);
        match &item.deed {
            Deed::Play(play) => Some(onset + scale * play.duration),
            Deed::Motion(bursts) => {
                let ends = bursts.iter().map(|burst| burst.start + burst.play.duration);
                Some(onset + scale * ends.fold(0.0, f64::max))
            }
            Deed::Marker(_) => Some(onset),
            Deed::Pattern(nested) => {
                let inner = sheets.get(nested.sheet)?.as_ref()?.length?;
                Some(onset + inner / (nested.rate * sheet.rate))
            }
            Deed::Choose(_) => None,
        }
    };
    let ends: Option<Vec<f64>> = items.iter().map(end).collect();
    let one = ends?.into_iter().fold(0.0, f64::max);
    match sheet.repeat {
        None => Some(one),
        Some(r) => Some(one + scale * r.every * (r.times? - 1) as f64),
    }
}
