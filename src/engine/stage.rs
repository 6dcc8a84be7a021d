//! From the mix to the device: the output stage of each kind of output.

use super::drives::Drives;
use super::hush::Hush;
use super::protection::Protections;
use super::raw::Raw;
use super::refusal::Refusal;
use super::triggers::Triggers;
use super::vibration::{Counts, Options, Row, Vibration};
use crate::actuator::driver::order::Order;
use crate::dsp::biquad::Complex;
use crate::dsp::isa::Isa;
use crate::dsp::lanes::{LANES, Real};
use crate::graph::plan::Plan;
use crate::schedule::Instant;

/// The output stage.
pub struct Stage {
    vibration: Vibration,
    /// The mix in single precision.
    rows: Vec<Row>,
    triggers: Triggers,
    raw: Raw,
    drives: Drives,
    hush: Hush,
    protections: Protections,
}

impl Stage {
    /// The stage of a plan.
    ///
    /// # Errors
    /// A rate or a number of taps that the stage cannot be built for; a motor that cannot be.
    pub(crate) fn new(plan: &Plan, isa: Isa) -> Result<Self, Refusal> {
        let options = Options {
            taps: plan.taps,
            ratio: Some(plan.ratio),
            equalisers: plan.by_channel(Vec::new(), |output| output.equaliser.clone()),
            keeps_dc_off: plan.by_channel(false, |output| output.keeps_dc_off),
            levels: plan.max_levels(),
            isa,
            ..Options::default()
        };
        let vibration = Vibration::new(plan.channels, plan.device_rate, &options)?;
        let rows = vec![Row::default(); vibration.groups() * super::workspace::BLOCK];
        let triggers = Triggers::new(plan, &vibration);
        let hush = Hush::new(plan.device_rate, plan.ratio);
        let cannot = |(channel, fault)| Refusal::Motor { channel, fault };
        let drives = Drives::new(plan, &vibration).map_err(cannot)?;
        let protections = Protections::new(plan).map_err(cannot)?;
        Ok(Self { vibration, rows, triggers, raw: Raw::new(plan), drives, hush, protections })
    }

    /// What the stage does to vibration outputs.
    pub fn vibration(&self) -> &Vibration {
        &self.vibration
    }

    /// What the stage has met so far.
    pub fn counts(&self) -> Counts {
        let mut counts = self.vibration.counts();
        for other in [self.raw.counts(), self.drives.counts()] {
            counts.masked += other.masked;
            counts.clamped += other.clamped;
        }
        counts
    }

    /// The designed linear response of a channel (from 0) at `frequency` (Hz), delays included.
    pub fn response(&self, channel: usize, frequency: f64) -> Complex {
        match self.raw.has(channel) {
            true => self.raw.response(frequency),
            false => self.vibration.response(channel, frequency),
        }
    }

    /// The motors.
    pub fn drives(&self) -> &Drives {
        &self.drives
    }

    /// What is held back for the sake of actuators.
    pub fn protections(&self) -> &Protections {
        &self.protections
    }

    /// An order for the motor of a channel (from 0) at an instant, in engine samples.
    pub(crate) fn order(&mut self, channel: u32, at: f64, voice: u64, order: Order) {
        self.drives.order(channel, at, voice, order);
    }

    /// Lets no more leave the channels than these levels: raw outputs and pulses from the next frame on, vibration as
    /// [`Vibration::limit_to`] says.
    pub(crate) fn limit_to(&mut self, levels: &[f32]) {
        self.vibration.limit_to(levels);
        self.raw.limit_to(levels);
        self.drives.limit_to(levels);
        self.triggers.limit_to(levels);
    }

    /// Whether nothing rings in it.
    pub(crate) fn is_asleep(&self) -> bool {
        self.triggers.is_idle()
            && self.raw.is_idle()
            && self.drives.is_idle()
            && (0..self.vibration.groups()).all(|g| self.vibration.sleeps(g))
    }

    /// A marker at an instant.
    pub(crate) fn mark(&mut self, marker: u32, at: Instant) {
        self.triggers.mark(marker, at);
    }

    /// All that sounded falls silent: everything but pulses of markers is exact zero 2 ms after the engine sample `clock`, and motors
    /// 4 ms after it, in which they are braked.
    pub(crate) fn shut(&mut self, clock: u64) {
        self.drives.shut(clock);
        self.hush.shut(clock);
    }

    /// Something sounds from the engine sample `clock` on.
    pub(crate) fn open(&mut self, clock: u64) {
        self.drives.open(clock);
        self.hush.open(clock);
    }

    /// Whether motors are held down, as [`Drives::hold`] says.
    pub(crate) fn hold_motors(&mut self, held: bool) {
        self.drives.hold(held);
    }

    /// Takes over what another stage, of the same motors, knows of envelopes.
    pub(crate) fn trade_swells(&mut self, other: &mut Self) {
        self.drives.trade_swells(&mut other.drives);
    }

    /// Renders `samples` engine samples of the mix, from `clock` on, to interleaved frames of the device. The
    /// sample after those for which `output` has room goes to `rest`.
    pub(crate) fn process<R: Real>(
        &mut self,
        mix: &mut [[R; LANES]],
        fed: &[bool],
        samples: usize,
        clock: u64,
        output: &mut [f32],
        rest: &mut [f32],
    ) {
        let rows = R::singles(mix, &mut self.rows);
        self.raw.take(rows, fed, samples);
        self.drives.take(rows, fed, samples);
        self.vibration.process_with_rest(samples, rows, fed, clock, output, rest);
        self.raw.write(samples, output, rest);
        self.hush.apply(clock, samples, self.vibration.channels(), output, rest);
        self.drives.write(samples, output, rest);
        self.triggers.write(clock, samples, output, rest);
        self.protections.hold(samples, output, rest);
    }
}
