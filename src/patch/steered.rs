//! Voices that say themselves where they are, by a node `place`.

use super::{Node, Place, Voice};
use crate::node::NodeKind;
use crate::text::{Problem, Span};

impl Voice {
    /// The node that says where it is, if it has one.
    pub fn steering(&self) -> Option<&Node> {
        self.nodes.iter().find(|node| node.kind == NodeKind::PLACE)
    }
}

/// More than one in a voice, and any among the shared nodes.
pub(super) fn check(nodes: &[Node], voice: Option<&Voice>) -> Option<Problem> {
    let mut all = nodes.iter().filter(|node| node.kind == NodeKind::PLACE);
    match (voice, all.next(), all.next()) {
        (None, Some(node), _) => {
            let what = format!("shared node `{}` is a `place`, but only a voice is anywhere", node.name);
            let help = "give each voice its own, and let that read shared nodes".to_string();
            Some(Problem::error(&node.span, what).help(help))
        }
        (Some(voice), Some(first), Some(second)) => {
            let what = format!(
                "voice `{}` has two nodes `place`: `{}` and `{}`",
                voice.name, first.name, second.name
            );
            Some(Problem::error(&second.span, what).help("add up what both say in one".to_string()))
        }
        _ => None,
    }
}

/// A place by name, or by channel, of a voice that says itself where it is.
pub(super) fn fits(voice: &Voice, place: Option<&Place>, span: &Span) -> Option<Problem> {
    let node = voice.steering()?;
    if !matches!(place?, Place::Name(_) | Place::Names(_) | Place::Channel(_)) {
        return None;
    }
    let what = format!(
        "voice `{}` says itself where it is, by its node `{}`, and plays on no tactor by name",
        voice.name, node.name
    );
    let help = "leave the place out, or give a position or a path: the node adds to it".to_string();
    Some(Problem::error(span, what).help(help))
}
