//! The sound card.

/// The sound card, `[device]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Device {
    /// As the system calls it; `None`: the default one.
    pub name: Option<String>,
    /// How many channels it has.
    pub channels: u32,
    /// Samples a second; `None`: whatever is asked for.
    pub rate: Option<f64>,
    /// Volts at a sample of 1.0; `None`: unknown, and then no figure in volts is given.
    pub full_scale_volts: Option<f64>,
    /// What its outputs let through.
    pub coupling: Coupling,
}

/// What an output lets through.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Coupling {
    /// Everything down to steady voltages.
    Dc,
    /// A first-order high-pass at so many hertz.
    HighPass(f64),
}
