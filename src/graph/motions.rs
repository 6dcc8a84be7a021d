//! Illusions of motion in a patch, on the tactors that there are: which cannot be, and what there is to know of the others.

use crate::patch::motion::Bursts;
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

/// Warnings: of what was measured otherwise, and of what is left out.
pub fn remarks(patch: &Patch, array: Option<&Array>) -> Vec<Problem> {
    let mut remarks = Vec::new();
    each(patch, array, |voice, _, motion, bursts| {
        let told = bursts.map(|bursts| bursts.remarks).unwrap_or_default();
        let room = Sink::MOST.saturating_sub(remarks.len());
        remarks.extend(told.into_iter().take(room).map(|remark| {
            Problem::warning(&motion.span, format!("`{}` of voice `{}`: {remark}", motion.key(), voice.name))
        }));
    });
    remarks
}
