//! What is imposed on an actuator.

/// What is imposed on an actuator's terminals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drive {
    /// A voltage; 0 V is a short.
    Voltage,
    /// A current; 0 A is open terminals.
    Current,
}
