//! What is felt: what the actuators of a rig do, by their models, with the samples that leave the device.
//!
//! | file | holds |
//! |---|---|
//! | [`Feel`] | all outputs of a rig, frame by frame |
//! | [`Felt`], [`Figures`] | one of them, and what it did: peak, root mean square, travel or speed, energy, heat |
//! | [`Now`] | what one does at the end of a frame: drive, speed, energy |
//! | [`Trace`] | what a channel of what is felt holds |
//! | [`Wish`], [`Left`] | how well it is to be known; what the models left out for that |
//! | [`Unfelt`] | an output of which it is not known what it moves |
//!
//! On its way each sample passes the converter (cut at full scale), the coupling of card and amplifier, the amplifier (gain, polarity, volts,
//! amperes) and the model of the actuator at the device's rate; before diodes in parts of a frame, with what a converter gives between its samples. Nothing on this way is refused as long as it can be computed: a motor behind
//! capacitors does here what it would do there.
//!
//! ```
//! use pacinian::Rig;
//! use pacinian::feel::{Feel, Wish};
//!
//! let rig = Rig::parse("wrist.toml", br#"
//! format = "pacinian-rig/1"
//! [device]
//! channels = 1
//! full_scale_volts = 3.0
//! coupling = "dc"
//! [actuator.coin]
//! part = "coin-10mm"
//! [[output]]
//! kind = "raw"
//! name = "wrist"
//! channel = 1
//! actuator = "coin"
//! "#)?.value;
//! let mut feel = Feel::new(&rig, 1, 48_000.0, &Wish::default())?;
//! let mut felt = Vec::new();
//! feel.process(&[1.0; 24_000], &mut felt);
//! // Across and upright, half a second at 3 V.
//! assert_eq!(felt.len(), 2 * 24_000);
//! let figures = feel.felt()[0].figures();
//! assert!((figures.peak - 17.6).abs() < 0.1 && figures.fastest.is_some_and(|speed| speed > 1500.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod chain;
mod felt;
mod figures;
mod heat;
mod left;
mod mover;
mod now;
mod simulation;
mod spinner;
mod swinger;
mod trace;
mod unfelt;
mod wish;

pub use felt::Felt;
pub use figures::{Counts, Figures};
pub use left::Left;
pub use now::Now;
pub use simulation::Feel;
pub use trace::{Axis, Trace, Unit};
pub use unfelt::Unfelt;
pub use wish::Wish;
