//! Illusions of motion in a patch, on the tactors that there are: which cannot be, and what there is to know of the others.

use crate::patch::motion::{Burst, Bursts, Kind};
use crate::patch::{Motion, Patch, Play, Voice};
use crate::space::array::Array;
use crate::space::fault::Fault;
use crate::text::Problem;
use crate::text::sink::Sink;

/// Calls `see` with every event that is several bursts, in order of the patch: of which voice, and the bursts. Those of voices that there are not are left out.
pub fn each<'a>(
    patch: &'a Patch,
    array: Option<&Array>,
    mut see: impl FnMut(&'a Voice, &'a Play, &'a Motion, Result<Bursts, Fault>),
) {
    patch.each_play(|play, pattern| {
        if let Some(motion) = &play.motion
            && let Some(voice) = patch.voices.iter().find(|voice| voice.name == play.voice)
        {
            let seconds = play.duration.unwrap_or(voice.duration) * pattern.time.seconds() / pattern.rate;
            see(voice, play, motion, motion.bursts(seconds, array));
        }
    });
}

/// What cannot be: too fast, or in no time.
pub(super) fn check(patch: &Patch, array: Option<&Array>, problems: &mut Vec<Problem>) {
    each(patch, array, |voice, _, motion, bursts| {
        if let Err(fault) = bursts
            && problems.len() < Sink::MOST
        {
            let what = format!("`{}` of voice `{}`: {fault}", motion.key(), voice.name);
            problems.push(Problem::error(&motion.span, what));
        }
    });
}

/// More bursts at a time than the voice has.
fn crowded(voice: &Voice, bursts: &[Burst]) -> Option<String> {
    let mut ends: Vec<f64> = bursts.iter().map(|burst| burst.start + burst.seconds).collect();
    ends.sort_by(f64::total_cmp);
    // Both rise: what has ended before a burst begins is let go of first.
    let mut over = 0;
    let most = bursts.iter().enumerate().map(|(n, burst)| {
        over += ends[over..].iter().take_while(|end| **end <= burst.start).count();
        n + 1 - over
    });
    let most = most.max().filter(|most| *most > voice.voices as usize)?;
    Some(format!(
        "{most} of its bursts sound at a time, and the voice has `voices = {}`: those that began first are cut off",
        voice.voices
    ))
}

/// An attack that is longer than any burst. Of what needs no array to be known, all events of the voice are looked at together.
fn sluggish(voice: &Voice, motion: &Motion, bursts: &[Burst]) -> Option<String> {
    let longest = bursts.iter().map(|burst| burst.seconds).fold(0.0, f64::max);
    let (seconds, key, node) = voice.rises().filter(|(seconds, ..)| *seconds > longest)?;
    matches!(motion.kind, Kind::Stroke(_)).then(|| {
        format!(
            "`{key}` of node `{node}` is {seconds} s, and its bursts last {longest:.3} s at most: they end before it has risen"
        )
    })
}

/// Warnings: of what was measured otherwise, of what is left out or cut off.
pub fn remarks(patch: &Patch, array: Option<&Array>) -> Vec<Problem> {
    let mut remarks = Vec::new();
    each(patch, array, |voice, _, motion, bursts| {
        let Ok(Bursts { list, remarks: mut told }) = bursts else { return };
        told.extend(crowded(voice, &list).into_iter().chain(sluggish(voice, motion, &list)));
        let room = Sink::MOST.saturating_sub(remarks.len());
        remarks.extend(told.into_iter().take(room).map(|remark| {
            Problem::warning(&motion.span, format!("`{}` of voice `{}`: {remark}", motion.key(), voice.name))
        }));
    });
    remarks
}
