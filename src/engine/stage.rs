//! From the mix to the device: the output stage of each kind of output.

use super::drives::Drives;
use super::hush::Hush;
use super::protection::Protections;
use super::raw::Raw;
use super::refusal::Refusal;
use super::standing::Standing;
use super::succession::Succession;
use super::triggers::Triggers;
use super::vibration::{Counts, Options, Row, Vibration, single};
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
    /// The most that leaves each channel.
    levels: Vec<f32>,
    /// From the stage before to this one, while both sound.
    succession: Option<Box<Succession>>,
    /// What the stage before met.
    met: Counts,
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
        let raw = Raw::new(plan);
        let levels = plan.max_levels().into_iter().map(single).collect();
        let (succession, met) = (None, Counts::default());
        Ok(Self { vibration, rows, triggers, raw, drives, hush, protections, levels, succession, met })
    }

    /// Makes it ready to take over from another in this way.
    pub(crate) fn expect_succession(&mut self, succession: Succession) {
        self.succession = Some(Box::new(succession));
    }

    /// Whether it is to take over from another that sounds on for a while, or does so.
    pub(crate) fn is_succeeding(&self) -> bool {
        self.succession.as_ref().is_some_and(|succession| !succession.is_over())
    }

    /// Takes over from `old` at the engine sample `clock`, as it was told to [expect](Self::expect_succession).
    pub(crate) fn take_over(&mut self, old: &mut Self, clock: u64) {
        let Some(succession) = &self.succession else { return };
        let crossed = succession.channels();
        self.vibration.take_over(&mut old.vibration, crossed);
        self.raw.take_over(&mut old.raw, crossed);
        self.triggers.take_over(&mut old.triggers);
        self.drives.take_over(&mut old.drives, crossed, clock);
        self.protections.take_over(&mut old.protections, crossed);
        std::mem::swap(&mut self.hush, &mut old.hush);
        self.met = old.counts();
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
        counts.masked += self.met.masked;
        counts.held += self.met.held;
        counts.clamped += self.met.clamped;
        counts.limited += self.met.limited;
        counts
    }

    /// The designed linear response of a channel (from 0) at `frequency` (Hz), delays included.
    pub fn response(&self, channel: usize, frequency: f64) -> Complex {
        match self.raw.has(channel) {
            true => self.raw.response(frequency),
            false => self.vibration.response(channel, frequency),
        }
    }

    /// The channels on which the pulses of trigger outputs leave (from 0).
    pub fn pulsed(&self) -> impl Iterator<Item = usize> + '_ {
        self.triggers.channels()
    }

    /// The most that leaves each channel.
    pub fn levels(&self) -> &[f32] {
        &self.levels
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
        self.levels.iter_mut().zip(levels).for_each(|(most, level)| *most = *level);
    }

    /// Whether nothing rings in it.
    pub(crate) fn is_asleep(&self) -> bool {
        !self.is_succeeding()
            && self.triggers.is_idle()
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
    /// sample after those for which `output` has room goes to `rest`. The stage before sounds with it while one crosses to the other.
    #[expect(clippy::too_many_arguments, reason = "the stages' own arguments, handed on")]
    pub(crate) fn process<R: Real>(
        &mut self,
        mix: &mut [[R; LANES]],
        fed: &[bool],
        samples: usize,
        clock: u64,
        output: &mut [f32],
        rest: &mut [f32],
        before: Option<&mut Self>,
        standing: &Standing,
    ) {
        let mut own = std::mem::take(&mut self.rows);
        let rows = R::singles(mix, &mut own);
        match (before, self.succession.take()) {
            (Some(before), Some(mut succession)) if !succession.is_over() => {
                before.hush = self.hush.clone();
                before.drives.halt_with(&self.drives);
                let mut old = std::mem::take(&mut before.rows);
                succession.feed(&mut old, rows, fed, samples);
                self.pass(rows, fed, samples, clock, output, rest, standing);
                let (fed, out, over) = succession.room(output.len(), rest.len());
                before.pass(&mut old, fed, samples, clock, out, over, standing);
                succession.mix(samples, output, rest);
                before.rows = old;
                self.met = before.counts();
                self.succession = Some(succession);
            }
            (_, succession) => {
                self.succession = succession;
                self.pass(rows, fed, samples, clock, output, rest, standing);
            }
        }
        self.rows = own;
    }

    #[expect(clippy::too_many_arguments, reason = "the stages' own arguments, handed on")]
    fn pass(
        &mut self,
        rows: &mut [Row],
        fed: &[bool],
        samples: usize,
        clock: u64,
        output: &mut [f32],
        rest: &mut [f32],
        standing: &Standing,
    ) {
        self.raw.take(rows, fed, samples);
        self.drives.take(rows, fed, samples);
        self.vibration.process_with_rest(samples, rows, fed, clock, output, rest);
        self.raw.write(samples, output, rest);
        self.hush.apply(samples, self.vibration.channels(), output, rest);
        if !self.drives.is_empty() {
            standing.motors(samples, || self.drives.write(samples, output, rest));
        }
        self.triggers.write(clock, samples, output, rest);
        self.protections.hold(samples, output, rest);
    }
}
