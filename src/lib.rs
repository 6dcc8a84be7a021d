//! pacinian plays the skin the way a synthesizer plays the ear.
//!
//! A **patch** says what is felt and when: voices are node graphs, patterns are events in time. A **rig** says which actuator hangs on
//! which channel, and where on the body it sits. The two are compiled into a plan, and an engine runs the plan: from an audio
//! callback, or straight into a buffer. All vibration is band-limited to 1 kHz, in engine samples of about 8 kHz.
//!
#![cfg_attr(feature = "io", doc = "```")]
#![cfg_attr(not(feature = "io"), doc = "```ignore")]
//! use pacinian::{NoAssets, Note, Options, Player, io};
//!
//! fn main() -> Result<(), Box<dyn std::error::Error>> {
//!     // With the feature `io`; `Patch::parse` and `Rig::parse` read texts that are at hand.
//!     let patch = io::load::patch("patches/04-heartbeat.toml")?.value;
//!     let rig = io::load::rig("rigs/belt.toml")?.value;
//!     // `live` keeps voices that nothing in the patch starts, and what may be moved.
//!     let options = Options { live: true, ..Options::default() };
//!     let mut player = Player::new(&patch, &rig, &options, &NoAssets)?;
//!
//!     // The seventh channel of the belt is called `left`.
//!     player.play("beat", &Note::default().level(0.5).at_place("left"))?;
//!     player.set("strength", 0.5)?;
//!     let mut second = vec![0.0; 48_000 * player.engine().channels()];
//!     player.process(&mut second); // interleaved frames
//!
//!     let peak = |channel: usize| second.iter().skip(channel).step_by(8).fold(0.0_f32, |p, x| p.max(x.abs()));
//!     assert!(peak(6) > 0.1 && peak(6) < 0.3, "half of a half: {}", peak(6));
//!     assert!(peak(0) > 0.3, "the heart of the patch beats on its own tactors meanwhile");
//!     Ok(())
//! }
//! ```
//!
//! [`NoAssets`] says that there are no recordings: a patch with a node `sample` or `scan` is refused. With the feature
//! `io`, `io::assets::Folder` reads them from a folder. The patch's own pattern plays as well, from the first frame on; a patch of
//! voices alone is silent until something is played.
//!
//! What is meant for a sound card is compiled with [`Options::for_card`], which keeps steady voltages off outputs that are not declared for them, also
//! where the rig does not say what the card lets through. From one's own audio callback, drive [`engine::Engine::process`]: it neither allocates nor locks, and what it computes does not
//! depend on how long the calls are. [`engine::exchange`] lets another plan follow while it sounds.
//!
//! The rooms, from the street to the cellar; each uses those below it and none above:
//!
//! | room | holds |
//! |---|---|
//! | `io` | files: WAV, recordings, texts, logs; live also devices, ports of MIDI, OSC, journals, sessions; with the feature `serial` knobs on serial ports; with the feature `io` |
//! | `live` | what a session is made of but for its devices: signals, the thread that leads it, its callback; with the feature `live` |
//! | `report` | the scene reference, error against run time, what actuators do under drives, what a knob bears and does, pictures; with the feature `report` |
//! | `edit` | bindings, channels and figures into the text of a patch or rig; with the feature `edit` |
//! | [`player`] | performer and engine together |
//! | [`performer`] | patterns, keys and messages become events |
//! | [`engine`] | voices, events, mix, output stage, hand-over of plans |
//! | [`graph`] | a node graph and the passes that turn it into a plan |
//! | [`score`] | patterns unrolled in time |
//! | [`feel`] | what the actuators of a rig do, by their models, with what leaves the device |
//! | [`patch`], [`rig`] | what people write, and its checks |
//! | [`midi`] | bytes of MIDI into messages, messages into gestures; with the feature `midi` files too |
//! | [`text`] | problems that point at their line, schemas |
//! | [`node`] | the node library, one file a node; with the feature `fundsp-nodes` a few units of `fundsp` too |
//! | [`perception`] | what the skin feels: thresholds by site and contactor, and what a calibrated tactor needs for them |
//! | [`knob`] | a force-feedback knob: its effects, its servo, what it bears, and a simulated one |
//! | [`actuator`] | models of what moves, and which drive makes it do what is wanted, and what it bears |
//! | [`space`] | where on the body: tactors that share a point, paths, strokes, common arrays |
//! | [`schedule`] | the sample clock |
//! | [`dsp`] | blocks that several rooms share |

#![warn(missing_docs)]

pub mod actuator;
pub mod dsp;
#[cfg(feature = "edit")]
pub mod edit;
pub mod engine;
pub mod feel;
pub mod graph;
#[cfg(feature = "io")]
pub mod io;
pub mod knob;
#[cfg(feature = "live")]
pub mod live;
pub mod midi;
pub mod node;
pub mod patch;
pub mod perception;
pub mod performer;
pub mod player;
#[cfg(feature = "report")]
pub mod report;
pub mod rig;
pub mod schedule;
pub mod score;
pub mod space;
pub mod text;

// What most programs begin with.
pub use graph::scene::Options;
pub use node::asset::NoAssets;
pub use patch::{Patch, Place};
pub use player::{Note, Player};
pub use rig::Rig;
