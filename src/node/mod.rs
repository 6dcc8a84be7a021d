//! The node library: one file a node, holding its description, its kernel over lanes, its exact twin and its tests.
//!
//! To add a node, write its file and add its line to the list at the foot of this one.

#![deny(clippy::disallowed_methods)]

pub mod asset;
pub(crate) mod course;
#[cfg(test)]
pub(crate) mod harness;
pub mod kernel;
#[cfg(feature = "fundsp-nodes")]
mod leaf;
mod legs;
pub mod motion;
mod order;
mod second_order;
mod segment;
pub mod spec;
mod wave;
pub mod words;

use crate::dsp::isa::Isa;
use crate::dsp::lanes::{LANES, Real};
use kernel::{Io, Kernel, Onset, Setup, Twin};
use motion::Motion;
use spec::NodeSpec;

/// Nodes of the feature `fundsp-nodes`, which is on by default: without, they are not in [`REGISTRY`]. All but `pluck`, a unit of our own, are made of
/// units of `fundsp`.
pub const OF_FUNDSP: [&str; 5] = ["pluck", "chaos", "brown", "ladder", "bell"];

/// A node type: its place in [`REGISTRY`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeKind(usize);

/// Those that a graph needs to know: it makes them, or what they do lets it leave something out.
#[allow(missing_docs)]
impl NodeKind {
    pub(crate) const ADD: Self = Self(Index::Add as usize);
    pub(crate) const MULTIPLY: Self = Self(Index::Multiply as usize);
    pub(crate) const MIX: Self = Self(Index::Mix as usize);
    pub(crate) const DELAY: Self = Self(Index::Delay as usize);
    pub(crate) const INPUT: Self = Self(Index::Input as usize);
    pub(crate) const LFO: Self = Self(Index::Lfo as usize);
    pub(crate) const ONSET: Self = Self(Index::Onset as usize);
    pub(crate) const TOUCH: Self = Self(Index::Touch as usize);
    pub(crate) const DRIVE_CLICK: Self = Self(Index::DriveClick as usize);
    pub(crate) const DRIVE_SPIN: Self = Self(Index::DriveSpin as usize);
    pub(crate) const DRIVE_SWELL: Self = Self(Index::DriveSwell as usize);
    pub(crate) const DRIVE_ON: Self = Self(Index::DriveOn as usize);
    pub(crate) const DRIVE_BRAKE: Self = Self(Index::DriveBrake as usize);
    pub(crate) const DRIVE_HOME: Self = Self(Index::DriveHome as usize);
    pub(crate) const PLACE: Self = Self(Index::Place as usize);
    #[cfg(feature = "fundsp-nodes")]
    pub(crate) const PLUCK: Self = Self(Index::Pluck as usize);
}

impl NodeKind {
    /// Whether its sound is set off by noise, which begins with the voice.
    pub(crate) fn is_set_off_by_noise(self) -> bool {
        #[cfg(feature = "fundsp-nodes")]
        return self == Self::PLUCK;
        #[cfg(not(feature = "fundsp-nodes"))]
        false
    }

    /// The type of that name.
    pub fn find(name: &str) -> Option<Self> {
        REGISTRY.iter().position(|spec| spec.name == name).map(Self)
    }
    /// What it says about itself.
    pub fn spec(self) -> &'static NodeSpec {
        REGISTRY[self.0]
    }
}

#[inline]
fn run_on<R: Real, K: Kernel<R>>(isa: Isa, kernel: &mut K, io: &mut Io<R>) {
    match isa {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: an engine holds this level only where `Isa::or_supported` found it on this machine.
        Isa::Avx2 => unsafe { run_avx2(kernel, io) },
        _ => run_baseline(kernel, io),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_avx2<R: Real, K: Kernel<R>>(kernel: &mut K, io: &mut Io<R>) {
    kernel.run(io);
}

#[inline(never)]
fn run_baseline<R: Real, K: Kernel<R>>(kernel: &mut K, io: &mut Io<R>) {
    kernel.run(io);
}

fn ended<R: Real, K: Kernel<R>>(kernel: &K) -> u8 {
    (0..LANES).fold(0, |all, lane| all | u8::from(kernel.sounding(lane) != Some(true)) << lane)
}

macro_rules! registry {
    ($($(#[$attr:meta])* $variant:ident = $module:ident),* $(,)?) => {
        $($(#[$attr])* pub(crate) mod $module;)*

        /// All node types.
        pub static REGISTRY: &[&NodeSpec] = &[$($(#[$attr])* &$module::SPEC),*];

        #[allow(missing_docs)]
        #[derive(Clone, Copy)]
        enum Index { $($(#[$attr])* $variant),* }

        /// The states of one op, a group of lanes each.
        #[allow(missing_docs)]
        pub(crate) enum States<R: Real> { $($(#[$attr])* $variant(Vec<$module::Lanes<R>>)),* }

        impl<R: Real> States<R> {
            /// States for `groups` groups of silent lanes.
            pub fn new(kind: NodeKind, setup: &Setup, groups: usize) -> Self {
                $($(#[$attr])* if kind.0 == Index::$variant as usize {
                    return Self::$variant((0..groups).map(|_| Kernel::<R>::new(setup)).collect());
                })*
                unreachable!("a NodeKind names a registered node")
            }
            /// Bytes that a group of lanes takes.
            pub fn bytes(kind: NodeKind, setup: &Setup) -> usize {
                $($(#[$attr])* if kind.0 == Index::$variant as usize {
                    return size_of::<$module::Lanes<R>>() + <$module::Lanes<R> as Kernel<R>>::heap(setup);
                })*
                unreachable!("a NodeKind names a registered node")
            }
            /// Whether both hold states of the same node type for as many groups.
            pub fn matches(&self, other: &Self) -> bool {
                match (self, other) {
                    $($(#[$attr])* (Self::$variant(a), Self::$variant(b)) => a.len() == b.len(),)*
                    #[allow(unreachable_patterns)]
                    _ => false,
                }
            }
            /// Becomes a copy of states of the same node with the same settings, of the lanes in `live`: by group, a bit each. Neither allocates nor frees.
            pub fn copy(&mut self, from: &Self, live: &[u8]) {
                match (self, from) {
                    $($(#[$attr])* (Self::$variant(to), Self::$variant(from)) => {
                        let pairs = to.iter_mut().zip(from).zip(live).filter(|(_, live)| **live != 0);
                        pairs.for_each(|((to, from), live)| Kernel::<R>::copy(to, from, *live));
                    })*
                    #[allow(unreachable_patterns)]
                    _ => {}
                }
            }
            /// See [`Kernel::copy_ahead`].
            pub fn copy_ahead(&mut self, from: &Self, live: &[u8], left: &mut usize) {
                match (self, from) {
                    $($(#[$attr])* (Self::$variant(to), Self::$variant(from)) => {
                        let pairs = to.iter_mut().zip(from).zip(live).filter(|(_, live)| **live != 0);
                        pairs.for_each(|((to, from), live)| Kernel::<R>::copy_ahead(to, from, *live, left));
                    })*
                    #[allow(unreachable_patterns)]
                    _ => {}
                }
            }
            /// See [`Kernel::start`].
            pub fn start(&mut self, group: usize, lane: usize, onset: &Onset) {
                match self { $($(#[$attr])* Self::$variant(s) => Kernel::<R>::start(&mut s[group], lane, onset)),* }
            }
            /// See [`Kernel::retune`].
            pub fn retune(&mut self, group: usize, lane: usize, was: &[f64], now: &[f64]) {
                match self { $($(#[$attr])* Self::$variant(s) => Kernel::<R>::retune(&mut s[group], lane, was, now)),* }
            }
            /// See [`Kernel::release`].
            pub fn release(&mut self, group: usize, lane: usize, at: f64) {
                match self { $($(#[$attr])* Self::$variant(s) => Kernel::<R>::release(&mut s[group], lane, at)),* }
            }
            /// See [`Kernel::touch`].
            pub fn touch(&mut self, group: usize, lane: usize, motion: Motion, value: f64, at: f64) {
                match self {
                    $($(#[$attr])* Self::$variant(s) => Kernel::<R>::touch(&mut s[group], lane, motion, value, at)),*
                }
            }
            /// See [`Kernel::run`]; `isa` must be one that this machine has.
            #[inline]
            pub fn run(&mut self, isa: Isa, group: usize, io: &mut Io<R>) {
                match self { $($(#[$attr])* Self::$variant(s) => run_on(isa, &mut s[group], io)),* }
            }
            /// See [`Kernel::sounding`].
            pub fn sounding(&self, group: usize, lane: usize) -> Option<bool> {
                match self { $($(#[$attr])* Self::$variant(s) => Kernel::<R>::sounding(&s[group], lane)),* }
            }
            /// Lanes, a bit each, of which [`Kernel::sounding`] says that they have ended, or nothing.
            pub fn ended(&self, group: usize) -> u8 {
                match self { $($(#[$attr])* Self::$variant(s) => ended::<R, _>(&s[group])),* }
            }
            /// See [`Kernel::value`].
            pub fn value(&self, group: usize, lane: usize) -> Option<f64> {
                match self { $($(#[$attr])* Self::$variant(s) => Kernel::<R>::value(&s[group], lane)),* }
            }
            /// See [`Kernel::settle`].
            pub fn settle(&mut self, group: usize) {
                match self { $($(#[$attr])* Self::$variant(s) => Kernel::<R>::settle(&mut s[group])),* }
            }
        }

        /// The twin of a node.
        pub fn twin(kind: NodeKind, setup: &Setup, onset: &Onset) -> Box<dyn Twin> {
            $($(#[$attr])* if kind.0 == Index::$variant as usize {
                return Box::new($module::Exact::new(setup, onset));
            })*
            unreachable!("a NodeKind names a registered node")
        }
    };
}

registry! {
    Sine = sine,
    Multiply = multiply,
    Envelope = envelope,
    Burst = burst,
    Gate = gate,
    Onset = onset,
    Decay = decay,
    Breakpoints = breakpoints,
    Triangle = triangle,
    Sawtooth = sawtooth,
    Pulse = pulse,
    Add = add,
    Mix = mix,
    Scale = scale,
    Crossfade = crossfade,
    Clip = clip,
    Shape = shape,
    Function = function,
    Sweep = sweep,
    White = white,
    Pink = pink,
    BandNoise = band_noise,
    Lowpass = lowpass,
    Highpass = highpass,
    Bandpass = bandpass,
    Notch = notch,
    Resonator = resonator,
    Follow = follow,
    Lfo = lfo,
    Delay = delay,
    Sample = sample,
    Scan = scan,
    Input = input,
    Touch = touch,
    DriveClick = drive_click,
    DriveSpin = drive_spin,
    DriveSwell = drive_swell,
    DriveOn = drive_on,
    DriveBrake = drive_brake,
    DriveHome = drive_home,
    Place = place,
    #[cfg(feature = "fundsp-nodes")]
    Pluck = pluck,
    #[cfg(feature = "fundsp-nodes")]
    Chaos = chaos,
    #[cfg(feature = "fundsp-nodes")]
    Brown = brown,
    #[cfg(feature = "fundsp-nodes")]
    Ladder = ladder,
    #[cfg(feature = "fundsp-nodes")]
    Bell = bell,
}
