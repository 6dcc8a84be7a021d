//! Paths that are not felt as they were written: warnings.

use crate::patch::{Patch, Place, Play, Voice};
use crate::space::array::Array;
use crate::space::path::{Path, Route};
use crate::space::point::distance;
use crate::text::Problem;
use crate::text::sink::Sink;

/// Tactors passed in a second from which on the band limit takes from what each of them has: at 1250 it takes 0.2 dB, at 2500 0.7, at 5000 2.6.
const MOST: f64 = 2000.0;
/// An event hardly begins a path of which it lasts for no more than that share.
const HARDLY: f64 = 0.01;

/// Of paths over an array: those that pass tactors faster than the band lets them sound, and those that have hardly begun when their event is over.
pub fn advice(patch: &Patch, array: Option<&Array>) -> Vec<Problem> {
    let mut all = Vec::new();
    patch.each_play(|play, pattern| {
        let voice = patch.voices.iter().find(|voice| voice.name == play.voice);
        let Some((voice, route)) = voice.and_then(|voice| Some((voice, route(play, voice)?))) else { return };
        let seconds = play.duration.unwrap_or(voice.duration) * pattern.time.seconds() / pattern.rate;
        let what = array.and_then(|array| quick(route, seconds, array)).or_else(|| late(route, seconds));
        if let Some(what) = what.filter(|_| all.len() < Sink::MOST) {
            all.push(Problem::warning(
                &play.span,
                format!("the path of an event of voice `{}` {what}", voice.name),
            ));
        }
    });
    all
}

/// The path of an event that goes along one.
fn route<'a>(play: &'a Play, voice: &'a Voice) -> Option<&'a Route> {
    match play.place.as_ref().or(voice.place.as_ref())? {
        Place::Path(way) if play.motion.is_none() => Some(way.route()),
        _ => None,
    }
}

fn quick(route: &Route, seconds: f64, array: &Array) -> Option<String> {
    let lasts = if route.stretched { seconds } else { route.path.seconds() };
    let speed = fastest(&route.path, lasts);
    let passes = speed / array.spacing();
    (array.tactors() > 1 && passes > MOST && passes.is_finite()).then(|| {
        format!(
            "is gone along at up to {speed:.3} m/s, over tactors {:.4} m apart: it passes {passes:.0} of them a second, each in less time than anything up to \
             1000 Hz takes, and is felt weaker",
            array.spacing()
        )
    })
}

/// The highest speed along a path that takes so many seconds, m/s.
fn fastest(path: &Path, seconds: f64) -> f64 {
    let times = path.times();
    if times.is_empty() {
        // 3x² − 2x³ is steepest in the middle.
        return path.length() / seconds * if path.is_smooth() { 1.5 } else { 1.0 };
    }
    let pieces = path.points().windows(2).zip(times.windows(2));
    pieces.map(|(points, times)| distance(points[0], points[1]) / (times[1] - times[0])).fold(0.0, f64::max)
}

fn late(route: &Route, seconds: f64) -> Option<String> {
    if route.stretched {
        return None;
    }
    let begins = route.path.times().first().copied().unwrap_or_default();
    let lasts = route.path.times().last().copied().unwrap_or(route.path.seconds());
    (seconds < begins + HARDLY * (lasts - begins)).then(|| {
        format!("takes from {begins} to {lasts} s, and the event is over after {seconds} s: it hardly moves")
    })
}
