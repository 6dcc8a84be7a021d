//! Functions of signals: what expressions are made of, besides sums and products.

use super::kernel::{Input, Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Param};
use crate::dsp::elementary::{MOST, exp, finite, ln, power, sin};
use crate::dsp::lanes::{LANES, Real};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "function",
    family: Family::Arithmetic,
    summary: "A function of its inputs.",
    detail: "subtract a − b; divide a / b, 0 where b is 0; min, max of all; abs; sqrt, 0 below 0; floor; exp; log, natural, that of \
             1e-30 below it; sin and cos of radians; power a^b, 0 where a is 0 (1 where b is) or where it has no real value; clamp a to b .. c \
             (c where they cross); modulo a − b floor(a / b), 0 where b is 0. Numbers stay within ±1e30, and what is not a number \
             counts as 0, so a number always comes out. An input that is missing is 0. Nothing is oversampled: meant for what steers, since of \
             what is felt the harmonics that it adds fold back.",
    params: &[
        Param {
            name: "op",
            kind: Kind::Choice(OPS, 0),
            unit: "",
            doc: "Which function.",
        },
        Param { name: "inputs", kind: Kind::Signals, unit: "", doc: "Its arguments." },
    ],
    example: r#"depth = { type = "function", op = "max", inputs = ["lfo", 0.2] }"#,
};

/// The words for `op`, in the order of the functions.
pub const OPS: &[&str] = &[
    "subtract", "divide", "min", "max", "abs", "sqrt", "floor", "exp", "log", "sin", "cos", "power", "clamp", "modulo",
];

/// A function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Op {
    Subtract,
    Divide,
    Min,
    Max,
    Abs,
    Sqrt,
    Floor,
    Exp,
    Log,
    Sin,
    Cos,
    Power,
    Clamp,
    Modulo,
}

impl Op {
    fn of(setup: &Setup) -> Self {
        use Op::{Abs, Clamp, Cos, Divide, Exp, Floor, Log, Max, Min, Modulo, Power, Sin, Sqrt, Subtract};
        let all = [Subtract, Divide, Min, Max, Abs, Sqrt, Floor, Exp, Log, Sin, Cos, Power, Clamp, Modulo];
        setup.choices.first().and_then(|place| all.get(*place)).copied().unwrap_or(Subtract)
    }
}

/// The function that was chosen.
#[derive(Debug, Clone)]
pub struct Lanes<R> {
    op: Op,
    _real: std::marker::PhantomData<R>,
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        Self { op: Op::of(setup), _real: std::marker::PhantomData }
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        match self.op {
            Op::Subtract => apply(io, |a, b, _| a - b),
            Op::Divide => apply(io, |a, b, _| if b == 0.0 { 0.0 } else { a / b }),
            Op::Min => fold(io, |a, b| if b < a { b } else { a }),
            Op::Max => fold(io, |a, b| if b > a { b } else { a }),
            Op::Abs => apply(io, |a, _, _| a.abs()),
            Op::Sqrt => apply(io, |a, _, _| if a > 0.0 { a.sqrt() } else { 0.0 }),
            Op::Floor => apply(io, |a, _, _| a.floor()),
            Op::Exp => apply(io, |a, _, _| exp(a)),
            Op::Log => apply(io, |a, _, _| ln(a)),
            Op::Sin => apply(io, |a, _, _| sin(a)),
            Op::Cos => apply(io, |a, _, _| sin(std::f64::consts::FRAC_PI_2 - a)),
            Op::Power => apply(io, |a, b, _| power(a, b)),
            Op::Clamp => apply(io, |a, b, c| {
                let a = if a > b { a } else { b };
                if a < c { a } else { c }
            }),
            Op::Modulo => apply(io, |a, b, _| if b == 0.0 { 0.0 } else { a - b * finite(a / b).floor() }),
        }
    }
}

/// The `f64` of an input at a frame; 0 where there is no such input.
#[inline(always)]
fn argument<R: Real>(inputs: &[Input<R>], place: usize, frame: usize) -> [f64; LANES] {
    inputs.get(place).map_or([0.0; LANES], |input| input.at(frame).map(|x| finite(x.wide())))
}

#[inline(always)]
fn apply<R: Real>(io: &mut Io<R>, function: impl Fn(f64, f64, f64) -> f64) {
    let inputs = io.inputs;
    for (frame, out) in io.pointwise().iter_mut().enumerate() {
        let [a, b, c] = [0, 1, 2].map(|place| argument(inputs, place, frame));
        for l in 0..LANES {
            out[l] = R::of(finite(function(a[l], b[l], c[l])));
        }
    }
}

#[inline(always)]
fn fold<R: Real>(io: &mut Io<R>, function: impl Fn(f64, f64) -> f64) {
    let inputs = io.inputs;
    for (frame, out) in io.pointwise().iter_mut().enumerate() {
        let mut all = argument(inputs, 0, frame);
        for place in 1..inputs.len() {
            let next = argument(inputs, place, frame);
            for l in 0..LANES {
                all[l] = function(all[l], next[l]);
            }
        }
        *out = all.map(R::of);
    }
}

/// The definition.
#[derive(Debug)]
pub struct Exact {
    op: &'static str,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, _onset: &Onset) -> Self {
        Self { op: OPS[setup.choices.first().map_or(0, |place| *place.min(&(OPS.len() - 1)))] }
    }
}

impl Twin for Exact {
    fn step(&mut self, _t: f64, inputs: &[f64]) -> f64 {
        let given: Vec<f64> =
            inputs.iter().map(|x| if x.is_nan() { 0.0 } else { x.clamp(-MOST, MOST) }).collect();
        let [a, b, c] = [0, 1, 2].map(|k| given.get(k).copied().unwrap_or(0.0));
        let value = match self.op {
            "subtract" => a - b,
            "divide" if b == 0.0 => 0.0,
            "divide" => a / b,
            "min" => given.iter().copied().reduce(f64::min).unwrap_or(0.0),
            "max" => given.iter().copied().reduce(f64::max).unwrap_or(0.0),
            "abs" => a.abs(),
            "sqrt" => a.max(0.0).sqrt(),
            "floor" => a.floor(),
            "exp" => a.exp(),
            "log" => a.max(1e-30).ln(),
            "sin" => a.sin(),
            "cos" => a.cos(),
            "power" if b == 0.0 => 1.0,
            "power" if a == 0.0 => 0.0,
            "power" => a.powf(b),
            "clamp" => a.max(b).min(c),
            _ if b == 0.0 => 0.0,
            _ => a - b * (a / b).floor(),
        };
        if value.is_nan() { 0.0 } else { value.clamp(-MOST, MOST) }
    }
}

#[cfg(test)]
mod tests {
    use super::{OPS, Op};
    use crate::node::harness::Bench;

    #[test]
    fn every_function_follows_its_twin() {
        for (op, name) in OPS.iter().enumerate() {
            let bench = Bench::new("function", 8000.0)
                .choice("op", op)
                .signal(0.2, |t| 2.0 * (9.1 * t).sin())
                .signal(1.5, |t| (7.3 * t).cos())
                .signal(1.0, |t| (3.0 * t).cos());
            bench.check_contract();
            let error = bench.error_db::<f64>(20_000);
            assert!(error < -200.0, "{name}: {error}");
            // Where a rounding flips a whole number, single precision says little.
            if !["floor", "modulo"].contains(name) {
                let error = bench.error_db::<f32>(80_000);
                assert!(error < -115.0, "{name}: {error}");
            }
        }
    }

    #[test]
    fn every_word_is_its_function() {
        let words: Vec<String> = (0..OPS.len())
            .map(|op| {
                let mut setup = Bench::new("function", 8000.0).setup;
                setup.choices = vec![op];
                format!("{:?}", Op::of(&setup)).to_lowercase()
            })
            .collect();
        assert_eq!(words, OPS);
    }

    #[test]
    fn a_number_always_comes_out() {
        let wild = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -1.0, 3e38, -3e38, 1e-45];
        for (op, name) in OPS.iter().enumerate() {
            for a in wild {
                for b in wild {
                    let bench = Bench::new("function", 8000.0).choice("op", op).signal(a, |_| 0.0).signal(b, |_| 0.0);
                    assert!(bench.kernel::<f32>(1, &[1])[0].is_finite(), "{name} of {a} and {b}");
                }
            }
            assert!(Bench::new("function", 8000.0).choice("op", op).kernel::<f32>(1, &[1])[0].is_finite());
        }
    }
}
