//! Where ports are the system's own, no server can end and take them with it.

use std::sync::Arc;

use crate::live::board::Board;

/// None.
pub(super) struct Server;

impl Server {
    /// None.
    pub fn new() -> Self {
        Self
    }

    /// Never.
    pub fn has_ended(&mut self, _answers: bool, _board: Option<&Arc<Board>>) -> bool {
        false
    }

    /// Nobody says.
    pub fn anew(&self) -> Vec<String> {
        Vec::new()
    }
}
