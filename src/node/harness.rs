//! Test bench for nodes: runs a kernel on one lane and its twin on the same instants and inputs, and measures the difference.
//!
//! ```ignore
//! let bench = Bench::new("sine", 8000.0).steady("frequency", 250.0).moving("amplitude", 1.0, |t| 0.1 * (9.0 * t).sin());
//! bench.check_contract();
//! assert!(bench.error_db::<f32>(80_000) < -110.0);
//! ```

#![allow(dead_code, reason = "a bench offers more than each build of the tests uses")]

use std::rc::Rc;

use super::asset::Asset;
use super::kernel::{Input, Io, Onset, Point, Setup};
use super::motion::Motion;
use super::spec::Kind;
use super::{NodeKind, States, twin};
use crate::dsp::lanes::{LANES, Real};

/// An input as a function of voice time (seconds): the part known at the onset, and the part that moves.
#[derive(Clone)]
struct Drive {
    base: f64,
    part: Option<Rc<dyn Fn(f64) -> f64>>,
}

impl Drive {
    fn at(&self, t: f64) -> f64 {
        self.base + self.part.as_ref().map_or(0.0, |part| part(t))
    }
}

/// One voice of one node, with what drives it. Parameters that are not named hold their defaults (0 where there is none).
#[derive(Clone)]
pub struct Bench {
    /// The node type.
    pub kind: NodeKind,
    /// What the node is built from; change it for points, an asset and the like.
    pub setup: Setup,
    /// See [`Onset::stream`].
    pub stream: u64,
    /// Voice time of the first sample, in samples: above −2, at most −1.
    pub age: f64,
    /// Voice time of the release, in seconds.
    pub release: Option<f64>,
    /// What the hand does, at voice times in seconds, in order.
    touches: Vec<(f64, Motion, f64)>,
    drives: Vec<Drive>,
    frequency: Vec<bool>,
}

impl Bench {
    /// A voice of the node named `node`, at `rate` samples a second, that begins 1.6 samples after the first one computed.
    pub fn new(node: &str, rate: f64) -> Self {
        let kind = NodeKind::find(node).unwrap_or_else(|| panic!("no node `{node}`"));
        let (mut constants, mut choices) = (Vec::new(), Vec::new());
        let (mut drives, mut frequency) = (Vec::new(), Vec::new());
        for param in kind.spec().params {
            match param.kind {
                Kind::Signal(n) | Kind::Frequency(n) | Kind::Start(n) => {
                    drives.push(Drive { base: n.default.unwrap_or(0.0), part: None });
                    frequency.push(matches!(param.kind, Kind::Frequency(_)));
                }
                Kind::Constant(n) => constants.push(n.default.unwrap_or(0.0)),
                Kind::Choice(_, place) => choices.push(place),
                Kind::Flag(on) => choices.push(usize::from(on)),
                Kind::Signals | Kind::Points | Kind::File => {}
            }
        }
        let setup = Setup {
            rate,
            engine_rate: rate,
            constants,
            choices,
            points: Vec::new(),
            asset: None,
            begins: false,
        };
        Self { kind, setup, stream: 7, age: -1.6, release: None, touches: Vec::new(), drives, frequency }
    }

    fn place(&self, name: &str, of: impl Fn(&Kind) -> bool) -> usize {
        let params = self.kind.spec().params;
        let end = params.iter().position(|p| p.name == name && of(&p.kind));
        let end = end.unwrap_or_else(|| panic!("`{}` has no such parameter `{name}`", self.kind.spec().name));
        params[..end].iter().filter(|p| of(&p.kind)).count()
    }

    /// Holds an input at `value`.
    pub fn steady(mut self, name: &str, value: f64) -> Self {
        let place = self.place(name, Kind::is_input);
        self.drives[place] = Drive { base: value, part: None };
        self
    }
    /// Moves an input: `base` is known at the onset, `part` (of seconds of voice time) is added to it.
    pub fn moving(mut self, name: &str, base: f64, part: impl Fn(f64) -> f64 + 'static) -> Self {
        let place = self.place(name, Kind::is_input);
        self.drives[place] = Drive { base, part: Some(Rc::new(part)) };
        self
    }
    /// Adds an input to a node that takes a list of them: a base and what is added to it.
    pub fn signal(mut self, base: f64, part: impl Fn(f64) -> f64 + 'static) -> Self {
        self.drives.push(Drive { base, part: Some(Rc::new(part)) });
        self.frequency.push(false);
        self
    }
    /// Sets a [`Kind::Constant`].
    pub fn constant(mut self, name: &str, value: f64) -> Self {
        let place = self.place(name, |kind| matches!(kind, Kind::Constant(_)));
        self.setup.constants[place] = value;
        self
    }
    /// Sets a [`Kind::Choice`] or, with 0 or 1, a [`Kind::Flag`].
    pub fn choice(mut self, name: &str, value: usize) -> Self {
        let place = self.place(name, |kind| matches!(kind, Kind::Choice(..) | Kind::Flag(_)));
        self.setup.choices[place] = value;
        self
    }
    /// Sets the breakpoints.
    pub fn points(mut self, points: &[Point]) -> Self {
        self.setup.points = points.to_vec();
        self
    }
    /// What moves a frequency is 0 before the onset.
    pub fn begins(mut self) -> Self {
        self.setup.begins = true;
        self
    }
    /// Sets the recording.
    pub fn asset(mut self, samples: Vec<f32>, rate: f64) -> Self {
        self.setup.asset = Some(std::sync::Arc::new(Asset { samples, rate }));
        self
    }
    /// Sets the voice time of the first sample, above −2 and at most −1.
    pub fn age(mut self, age: f64) -> Self {
        assert!(age > -2.0 && age <= -1.0, "an onset's age is above -2 and at most -1");
        self.age = age;
        self
    }
    /// Releases the voice at `t` seconds of voice time, at least 0.
    pub fn released(mut self, t: f64) -> Self {
        assert!(t >= 0.0, "a voice is released after its onset");
        self.release = Some(t);
        self
    }

    /// The hand moves so at `t` seconds of voice time, at least 0; later than it did before.
    pub fn touched(mut self, t: f64, motion: Motion, value: f64) -> Self {
        assert!(t >= self.touches.last().map_or(0.0, |last| last.0), "in order");
        self.touches.push((t, motion, value));
        self
    }

    fn starts(&self) -> Vec<f64> {
        self.drives.iter().map(|drive| drive.base).collect()
    }
    fn onset<'a>(&self, start: &'a [f64]) -> Onset<'a> {
        Onset { age: self.age, stream: self.stream, start }
    }
    /// Samples of the kernel before which it is told of the release.
    fn told(&self) -> usize {
        self.release.map_or(usize::MAX, |t| self.told_at(t))
    }
    /// And of what happens at `t`.
    fn told_at(&self, t: f64) -> usize {
        (t * self.setup.rate - 2.0 - self.age).ceil().max(0.0) as usize
    }

    /// The first `samples` outputs of the kernel on lane 3, in blocks of the lengths in `blocks`, over and over.
    pub fn kernel<R: Real>(&self, samples: usize, blocks: &[usize]) -> Vec<f64> {
        self.run::<R>(samples, blocks, 3, false).0
    }
    /// After how many samples (of at most `samples`) the kernel says that it no longer sounds.
    pub fn ends<R: Real>(&self, samples: usize) -> Option<usize> {
        self.run::<R>(samples, &[1], 3, false).1
    }

    /// With `crowd`, the other lanes are played meanwhile: started, restarted and released, one of them fed NaN.
    fn run<R: Real>(
        &self,
        samples: usize,
        blocks: &[usize],
        lane: usize,
        crowd: bool,
    ) -> (Vec<f64>, Option<usize>) {
        let rate = self.setup.rate;
        let mut states = States::<R>::new(self.kind, &self.setup, 1);
        let start = self.starts();
        let scale = |l: usize| if l == lane { 1.0 } else { 1.0 + 0.07 * l as f64 };
        let mut bases = vec![[0.0; LANES]; self.drives.len()];
        for (base, drive) in bases.iter_mut().zip(&self.drives) {
            for (l, base) in base.iter_mut().enumerate() {
                *base = if l == lane || crowd { drive.base * scale(l) } else { 0.0 };
            }
        }
        states.start(0, lane, &self.onset(&start));
        let (mut output, mut ended) = (Vec::with_capacity(samples), None);
        // An engine does not begin with this voice.
        let first = 1000;
        let mut sizes = blocks.iter().copied().cycle();
        let mut left = 0;
        let mut touches = self.touches.iter().copied().peekable();
        while output.len() < samples {
            let n = output.len();
            while let Some((t, motion, value)) = touches.next_if(|(t, ..)| self.told_at(*t) <= n) {
                states.touch(0, lane, motion, value, t * rate);
            }
            if n == self.told() {
                states.release(0, lane, self.release.unwrap_or(0.0) * rate);
            }
            let clock = first + n as u64;
            if clock.is_multiple_of(64) {
                states.settle(0);
            }
            let neighbour = n / 50 % LANES;
            if crowd && n % 50 == 20 && neighbour != lane {
                let start: Vec<f64> = start.iter().map(|v| v * scale(neighbour)).collect();
                let age = -1.0 - 0.1 * neighbour as f64;
                states.start(0, neighbour, &Onset { age, stream: n as u64, start: &start });
            }
            if crowd && n > 80 && (n - 80) % 50 == 20 && (n - 80) / 50 % LANES != lane {
                let neighbour = (n - 80) / 50 % LANES;
                states.release(0, neighbour, -1.0 - 0.1 * neighbour as f64 + 81.5);
            }
            if crowd && !self.touches.is_empty() && n > 80 && (n - 80) % 50 == 20 {
                let neighbour = (n - 80) / 50 % LANES;
                if neighbour != lane {
                    let at = -1.0 - 0.1 * neighbour as f64 + 81.5;
                    for motion in Motion::ALL {
                        states.touch(0, neighbour, motion, 0.3 + n as f64 * 0.001, at);
                    }
                }
            }
            if left == 0 {
                left = sizes.next().unwrap_or(64).max(1);
            }
            // Cut at whatever happens at a sample: the release, the housekeeping, the crowd.
            let mut frames = left.min(samples - n).min(64 - (clock % 64) as usize);
            if n < self.told() {
                frames = frames.min(self.told() - n);
            }
            if let Some((t, ..)) = touches.peek() {
                frames = frames.min(self.told_at(*t) - n);
            }
            if crowd {
                frames = frames.min(10 - n % 10);
            }
            left -= frames;

            let mut rows = vec![Vec::new(); self.drives.len()];
            for (i, drive) in self.drives.iter().enumerate() {
                let count = if drive.part.is_some() { frames } else { 1 };
                for k in 0..count {
                    let t = (self.age + (n + k) as f64) / rate;
                    let moved = drive.part.as_ref().map_or(0.0, |part| part(t));
                    let mut row = [R::ZERO; LANES];
                    for (l, value) in row.iter_mut().enumerate() {
                        let base = if self.frequency[i] { 0.0 } else { bases[i][l] };
                        let part = if l == lane || crowd { moved * scale(l) } else { 0.0 };
                        *value = R::of(base + part);
                    }
                    if crowd && drive.part.is_some() {
                        row[(lane + 1) % LANES] = R::of(f64::NAN);
                    }
                    rows[i].push(row);
                }
            }
            let inputs: Vec<Input<R>> = (0..self.kind.spec().running(rows.len()))
                .map(|i| Input {
                    rows: &rows[i],
                    step: usize::from(self.drives[i].part.is_some()),
                    steady: self.drives[i].part.is_none(),
                    base: &bases[i],
                })
                .collect();
            let mut block = vec![[R::of(f64::NAN); LANES]; frames];
            let mut io = Io { inputs: &inputs, output: &mut block, still: false };
            states.run(crate::dsp::isa::Isa::detect(), 0, &mut io);
            if io.still {
                let row = block[0];
                block.fill(row);
            }
            output.extend(block.iter().map(|row| row[lane].wide()));
            if ended.is_none() && states.sounding(0, lane) == Some(false) {
                ended = Some(output.len());
            }
        }
        (output, ended)
    }

    /// The first `samples` outputs of the twin at `factor` times the rate, from the kernel's first instant on.
    pub fn twin(&self, samples: usize, factor: usize) -> Vec<f64> {
        self.twin_of(samples, factor, |_, drive, t| drive.at(t))
    }

    /// The same at the engine's rate, of inputs as a kernel over `R` gets them: what moves is rounded.
    fn twin_of_rounded<R: Real>(&self, samples: usize) -> Vec<f64> {
        self.twin_of(samples, 1, |i, drive, t| match &drive.part {
            Some(part) if self.frequency[i] => drive.base + R::of(part(t)).wide(),
            Some(part) => R::of(drive.base + part(t)).wide(),
            None => drive.base,
        })
    }

    fn twin_of(&self, samples: usize, factor: usize, input: impl Fn(usize, &Drive, f64) -> f64) -> Vec<f64> {
        let setup = Setup { rate: self.setup.rate * factor as f64, ..self.setup.clone() };
        let start = self.starts();
        let mut twin = twin(self.kind, &setup, &self.onset(&start));
        let mut release = self.release;
        let mut touches = self.touches.iter().copied().peekable();
        (0..samples)
            .map(|n| {
                let t = (self.age + n as f64 / factor as f64) / self.setup.rate;
                // A twin that averages over a sample must know a sample ahead.
                if let Some(at) = release.filter(|at| *at <= t + 1.0 / setup.rate) {
                    twin.release(at);
                    release = None;
                }
                while let Some((at, motion, value)) = touches.next_if(|(at, ..)| *at <= t + 1.0 / setup.rate)
                {
                    twin.touch(at, motion, value);
                }
                let inputs: Vec<f64> =
                    self.drives.iter().enumerate().map(|(i, drive)| input(i, drive, t)).collect();
                twin.step(t, &inputs)
            })
            .collect()
    }

    /// Kernel against twin, both at the engine's rate and with the same inputs, sample by sample: see [`error_db`].
    pub fn error_db<R: Real>(&self, samples: usize) -> f64 {
        error_db(&self.kernel::<R>(samples, &[64]), &self.twin_of_rounded::<R>(samples))
    }

    /// Kernel against a twin at `factor` times the rate, within 0 to 1 kHz (for an engine of 8 kHz): what a kernel that
    /// band-limits its jumps is measured by, as its samples near a jump differ from the definition's on purpose. Both
    /// pass the same low-pass filter; before the first sample there is silence, and the last 80 samples are not looked at.
    pub fn band_error_db<R: Real>(&self, samples: usize, factor: usize) -> f64 {
        let kernel = low_pass(&self.kernel::<R>(samples, &[64]), 1);
        let twin = low_pass(&self.twin(samples * factor, factor), factor);
        let end = samples.saturating_sub(80);
        error_db(&kernel[..end], &twin[..end])
    }

    /// That blocks of 1, 7, 64 and mixed lengths give the same bits, that neighbours do not matter, and that a voice
    /// sounds the same on every lane; in both precisions.
    pub fn check_contract(&self) {
        self.check_contract_in::<f32>();
        self.check_contract_in::<f64>();
    }

    fn check_contract_in<R: Real>(&self) {
        let samples = 1500;
        let whole = bits(&self.kernel::<R>(samples, &[64]));
        for blocks in [&[1][..], &[7], &[3, 64, 1, 1, 17, 40, 2, 31, 5]] {
            assert!(
                bits(&self.kernel::<R>(samples, blocks)) == whole,
                "blocks of {blocks:?} change the output"
            );
        }
        assert!(bits(&self.kernel::<R>(samples, &[64])) == whole, "a second run gives other bits");
        for lane in 0..LANES {
            assert!(bits(&self.run::<R>(samples, &[64], lane, false).0) == whole, "lane {lane} differs");
        }
        assert!(bits(&self.run::<R>(samples, &[64], 3, true).0) == whole, "neighbours change the output");
    }
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

/// Energy of the difference over energy of the twin, dB: −infinity where they are the same, +infinity where one of them is
/// not finite.
pub fn error_db(kernel: &[f64], twin: &[f64]) -> f64 {
    assert_eq!(kernel.len(), twin.len());
    let difference: f64 = kernel.iter().zip(twin).map(|(a, b)| (a - b) * (a - b)).sum();
    let energy: f64 = twin.iter().map(|b| b * b).sum();
    match difference {
        d if !d.is_finite() || !energy.is_finite() => f64::INFINITY,
        0.0 => f64::NEG_INFINITY,
        d => 10.0 * (d / energy).log10(),
    }
}

/// Every `factor`-th sample of `values` after a low-pass filter without delay: flat to 1/8 of the kept rate within 1e-6,
/// nothing above 3/16. A sinc in a Kaiser window, the same function of time whatever `factor` is.
pub fn low_pass(values: &[f64], factor: usize) -> Vec<f64> {
    const REACH: f64 = 70.0;
    const BETA: f64 = 12.0;
    let bessel = |x: f64| {
        let (mut sum, mut term) = (1.0, 1.0);
        for k in 1..60 {
            term *= (x / (2.0 * f64::from(k))).powi(2);
            sum += term;
        }
        sum
    };
    let half = (REACH * factor as f64) as isize;
    let taps: Vec<f64> = (-half..=half)
        .map(|k| {
            let t = k as f64 / factor as f64;
            let x = std::f64::consts::PI * t * 0.3125;
            let sinc = if k == 0 { 1.0 } else { x.sin() / x };
            let window = bessel(BETA * (1.0 - (t / REACH).powi(2)).max(0.0).sqrt()) / bessel(BETA);
            0.3125 / factor as f64 * sinc * window
        })
        .collect();
    (0..values.len())
        .step_by(factor)
        .map(|n| {
            let first = n as isize - half;
            let skip = (-first).max(0) as usize;
            let from = first.max(0) as usize;
            values[from..].iter().zip(&taps[skip..]).map(|(v, tap)| v * tap).sum()
        })
        .collect()
}

mod tests {
    use super::{Bench, error_db, low_pass};

    #[test]
    fn the_sine_follows_its_twin() {
        let steady = Bench::new("sine", 8000.0).steady("frequency", 250.1).steady("phase", 0.3);
        steady.check_contract();
        assert!(steady.error_db::<f32>(80_000) < -110.0);
        assert!(steady.error_db::<f64>(80_000) < -180.0);
        let moving = Bench::new("sine", 7350.0)
            .age(-1.25)
            .moving("frequency", 250.0, |t| 40.0 * (30.0 * t.max(0.0)).sin())
            .moving("phase", 0.1, |t| 0.2 * (50.0 * t).cos());
        moving.check_contract();
        assert!(moving.error_db::<f32>(73_500) < -110.0, "{}", moving.error_db::<f32>(73_500));
    }

    #[test]
    fn a_late_kernel_is_seen() {
        let bench = Bench::new("sine", 8000.0).steady("frequency", 250.0);
        let late = bench.clone().age(-1.61).kernel::<f64>(8000, &[64]);
        let error = error_db(&late, &bench.twin(8000, 1));
        let exact = 20.0 * (std::f64::consts::TAU * 250.0 * 0.01 / 8000.0).log10();
        assert!((error - exact).abs() < 0.1, "{error} against {exact}");
    }

    #[test]
    fn a_product_of_signals() {
        let bench = Bench::new("multiply", 8000.0)
            .signal(1.0, |t| (900.0 * t).sin())
            .signal(0.0, |t| (700.0 * t).cos());
        bench.check_contract();
        assert!(bench.error_db::<f32>(8000) < -130.0);
    }

    #[test]
    fn the_low_pass_is_flat_to_an_eighth_and_shut_above_three_sixteenths() {
        for factor in [1, 16] {
            let fast = 8000.0 * factor as f64;
            for (hertz, least, most) in
                [(0.0, -1e-6, 1e-6), (990.0, -1e-6, 1e-6), (1500.0, -1.0 - 1e-6, -1.0 + 1e-6)]
            {
                let wave = |rate: f64, count: usize| -> Vec<f64> {
                    (0..count).map(|n| (std::f64::consts::TAU * hertz * n as f64 / rate).cos()).collect()
                };
                let got = low_pass(&wave(fast, 600 * factor), factor);
                let plain = wave(8000.0, 600);
                for n in 100..500 {
                    let gain = got[n] - plain[n];
                    if least < -0.5 {
                        assert!(got[n].abs() < 2e-6, "{hertz} Hz at {n}: {}", got[n]);
                    } else {
                        assert!((least..most).contains(&gain), "{hertz} Hz at {n}: {gain}");
                    }
                }
            }
        }
    }
}
