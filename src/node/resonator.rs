//! Resonator.

use super::second_order::{self, Part};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::phase;
use crate::dsp::sine::sine64;
use crate::dsp::svf::{LEAST_CUTOFF, MOST_CUTOFF};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "resonator",
    family: Family::Filter,
    summary: "Rings at a frequency for a time.",
    detail: "(s/qω) / (1 + s/qω + s²/ω²): gain 1 at its frequency, and after a knock it falls by 60 dB in `decay` seconds. \
             It is the bilinear (trapezoidal) state-variable filter at the engine's rate, exact at its frequency, with the q that \
             makes its poles decay in that time: q = sin(2π frequency / rate) / (2 tanh(ln 1000 / (decay rate))), which is about \
             π frequency decay / ln 1000. With q = 1/2 it dies away as fast as it can, in about 1.5 / frequency: no `decay` makes it shorter. The frequency is limited to 1 Hz to \
             0.45 of that rate, q to 0.5 to 1000, at every sample, however they move; an input that is not a number counts as 0. A tail \
             below −140 dB ends in silence.",
    params: &[
        Param {
            name: "input",
            kind: Kind::Signal(Numeric::required(-1000000.0, 1000000.0)),
            unit: "",
            doc: "What is filtered.",
        },
        Param {
            name: "frequency",
            kind: Kind::Signal(Numeric::required(0.0, 4000.0)),
            unit: "Hz",
            doc: "Where it acts.",
        },
        Param {
            name: "decay",
            kind: Kind::Signal(Numeric::or(0.1, 0.0, 100.0)),
            unit: "s",
            doc: "Time to fall by 60 dB.",
        },
    ],
    example: r#"ring = { type = "resonator", input = "click", frequency = 180, decay = 0.2 }"#,
};

/// The part of the state-variable filter that this is, by the decay of its poles.
#[derive(Debug, Clone)]
pub enum Ring {}

/// With less the poles are real, and the slower of them would ring longer.
const LEAST_Q: f64 = 0.5;

/// ln 1000: 60 dB.
const FALL: f64 = 6.907_755_278_982_137;

impl Part for Ring {
    #[inline(always)]
    fn of(_input: f64, _low: f64, band: f64) -> f64 {
        band
    }

    #[inline(always)]
    fn q(frequency: f64, decay: f64, rate: f64) -> f64 {
        let (least, most) = (LEAST_CUTOFF, MOST_CUTOFF * rate);
        let hertz = if frequency > least { frequency } else { least };
        let hertz = if hertz < most { hertz } else { most };
        // Where this is large, q is at its least anyway.
        let a = FALL / (decay * rate);
        let a = if a > 0.0 && a < 2.0 { a } else { 2.0 };
        let z = a * a;
        // Padé's fraction of tanh.
        let tanh = a * (945.0 + z * (105.0 + z)) / (945.0 + z * (420.0 + z * 15.0));
        let q = sine64(phase::turns(hertz / rate)) / (2.0 * tanh);
        if q > LEAST_Q { q } else { LEAST_Q }
    }

    fn exact_q(frequency: f64, decay: f64, rate: f64) -> f64 {
        let hertz = frequency.max(LEAST_CUTOFF).min(MOST_CUTOFF * rate);
        let seconds = if decay > 0.0 { decay } else { 0.0 };
        let q = (std::f64::consts::TAU * hertz / rate).sin() / (2.0 * (1000f64.ln() / (seconds * rate)).tanh());
        q.max(0.5)
    }
}

/// Eight filters.
pub type Lanes<R> = second_order::Lanes<R, Ring>;
/// The definition.
pub type Exact = second_order::Exact<Ring>;

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;
    use crate::node::second_order::tests::{
        follows_its_twin, hostile_input_stays_bounded, is_the_same_at_sixteen_times_the_rate,
    };

    #[test]
    fn it_is_its_definition_however_it_moves() {
        let inputs = ["frequency", "decay"];
        follows_its_twin("resonator", inputs, [(5.0, 0.7), (250.0, 0.3), (800.0, 0.01)], (0.05, 0.04));
        is_the_same_at_sixteen_times_the_rate("resonator", inputs, 0.03);
        hostile_input_stays_bounded("resonator", inputs);
    }

    /// A decay too short for the frequency is the shortest there is, (1 + x) exp(-x) = 1/1000 at x = 9.2 = 2π frequency t.
    #[test]
    fn nothing_rings_longer_for_a_shorter_decay() {
        for hertz in [60.0, 180.0, 400.0] {
            let seconds = |decay: f64| {
                let bench = Bench::new("resonator", 8000.0)
                    .age(-1.0)
                    .moving("input", 0.0, |t| if t == 0.0 { 1.0 } else { 0.0 })
                    .steady("frequency", hertz)
                    .steady("decay", decay);
                let out = bench.kernel::<f64>(4000, &[64]);
                let peak = out.iter().fold(0.0, |p: f64, x| p.max(x.abs()));
                out.iter().rposition(|x| x.abs() > 1e-3 * peak).unwrap_or(0) as f64 / 8000.0
            };
            let times = [0.1, 0.03, 0.01, 0.003, 0.001, 0.0].map(seconds);
            assert!(times.windows(2).all(|w| w[1] <= w[0] + 1e-3), "{hertz} Hz: {times:?}");
            assert!(times[5] < 1.7 / hertz, "{hertz} Hz: {times:?}");
        }
    }

    /// Up to the edge of the band.
    #[test]
    fn a_knock_decays_by_60_db_in_the_time_given() {
        for hertz in [50.0, 200.0, 500.0, 800.0, 1000.0] {
            let bench = Bench::new("resonator", 8000.0)
                .age(-1.0)
                .moving("input", 0.0, |t| if t == 0.0 { 1.0 } else { 0.0 })
                .steady("frequency", hertz)
                .steady("decay", 0.25);
            let out = bench.kernel::<f64>(4000, &[64]);
            // Whole periods of all of these, but for the damping.
            let power = |from: usize| out[from..from + 160].iter().map(|v| v * v).sum::<f64>();
            let fall = 10.0 * (power(2400) / power(400)).log10();
            assert!((fall + 60.0).abs() < 0.3, "{hertz} Hz: {fall} dB");
        }
    }
}
