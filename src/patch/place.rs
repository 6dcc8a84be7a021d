//! Where on the body.

/// A place, as written: `"top"`, `3`, `[0.0, -0.2]`. [`crate::rig::Rig::resolve`] finds its tactor.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// The tactor of that name.
    Name(String),
    /// A channel of the device, from 1.
    Channel(u32),
    /// Metres; goes to the nearest tactor.
    Position([f64; 3]),
}
