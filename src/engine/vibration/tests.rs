use super::{Options, Refusal, Row, Vibration};
use crate::dsp::biquad::{Biquad, Complex};
use crate::dsp::isa::Isa;
use std::f64::consts::TAU;

const RATES: [f64; 9] =
    [6000.0, 11_025.0, 12_000.0, 44_100.0, 48_000.0, 88_200.0, 96_000.0, 176_400.0, 192_000.0];

fn stage(channels: usize, rate: f64, options: &Options) -> Vibration {
    Vibration::new(channels, rate, options).expect("sound options")
}

/// Runs `channels` signals of one length through a stage in blocks of the lengths that `cut` gives.
fn run(stage: &mut Vibration, signals: &[Vec<f32>], mut cut: impl FnMut() -> usize) -> Vec<f32> {
    let length = signals[0].len();
    let mut out = Vec::new();
    let mut done = 0;
    while done < length {
        let count = cut().clamp(1, length - done);
        let mut rows = vec![[0.0; 8]; count * stage.groups()];
        for (c, signal) in signals.iter().enumerate() {
            for n in 0..count {
                rows[c / 8 * count + n][c % 8] = signal[done + n];
            }
        }
        let mut block = vec![f32::NAN; count * stage.ratio() * stage.channels()];
        let fed: Vec<bool> = rows.chunks(count).map(|g| g.iter().any(|r| *r != [0.0; 8])).collect();
        assert_eq!(stage.process(count, &mut rows, &fed, done as u64, &mut block), count);
        out.extend(block);
        done += count;
    }
    out
}

fn channel(out: &[f32], channels: usize, c: usize) -> Vec<f64> {
    out.iter().skip(c).step_by(channels).map(|&v| f64::from(v)).collect()
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|v| v.to_bits()).collect()
}

fn at(signal: &[f64], hertz: f64, rate: f64) -> Complex {
    let mut sum = Complex::default();
    for (n, &v) in signal.iter().enumerate() {
        sum = sum + Complex::turned(-TAU * hertz / rate * n as f64) * v;
    }
    sum
}

fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Share of the power above `hertz`, in decibels; the length is cut to a power of two, under a Hann window.
fn above(signal: &[f64], hertz: f64, rate: f64) -> f64 {
    let n = 1 << signal.len().ilog2();
    let mut data: Vec<Complex> =
        (0..n).map(|i| Complex::from(signal[i] * (0.5 - 0.5 * (TAU * i as f64 / n as f64).cos()))).collect();
    let shift = usize::BITS - n.ilog2();
    for i in 0..n {
        let j = i.reverse_bits() >> shift;
        if i < j {
            data.swap(i, j);
        }
    }
    let mut half = 1;
    while half < n {
        for k in 0..half {
            let twiddle = Complex::turned(-TAU * k as f64 / (2 * half) as f64);
            for i in (k..n).step_by(2 * half) {
                let (a, b) = (data[i], data[i + half] * twiddle);
                (data[i], data[i + half]) = (a + b, a - b);
            }
        }
        half *= 2;
    }
    let power = |bins: &[Complex]| bins.iter().map(|v| v.re * v.re + v.im * v.im).sum::<f64>();
    // The window's main lobe reaches two bins down.
    let edge = (hertz / rate * n as f64).ceil() as usize + 2;
    10.0 * (power(&data[edge..n / 2]) / power(&data[..n / 2])).log10()
}

/// Signals that ask most of the limiter, at full scale.
fn hostile(rate: f64, length: usize) -> Vec<(&'static str, Vec<f64>)> {
    let mut noise = random(1);
    let impulse = {
        let filter = crate::dsp::elliptic::Elliptic::low_pass(4, 0.3, 66.0, 850.0, rate);
        let mut state = [[0.0; 2]; 4];
        let mut run = |x| filter.sections.iter().zip(&mut state).fold(x, |x, (f, s)| f.step(s, x));
        (0..400).map(|n| run(if n == 0 { 1.0 } else { 0.0 })).collect::<Vec<f64>>()
    };
    let turn = move |hertz: f64, n: usize| (hertz * n as f64 / rate).fract();
    let mut set: Vec<(&str, Vec<f64>)> = Vec::new();
    let mut add = |name, f: &mut dyn FnMut(usize) -> f64| set.push((name, (0..length).map(f).collect()));
    add("square 333", &mut |n| if turn(333.0, n) < 0.5 { 1.0 } else { -1.0 });
    add("square 60", &mut |n| if turn(60.0, n) < 0.5 { 1.0 } else { -1.0 });
    for (name, hertz, gate) in [("gate 250", 250.0, 7.3), ("gate 600", 600.0, 17.3), ("gate 800", 800.0, 5.1)]
    {
        add(name, &mut |n| if turn(gate, n) < 0.5 { (TAU * turn(hertz, n)).sin() } else { 0.0 });
    }
    add("white", &mut |_| 2.0 * noise() - 1.0);
    add("FM 10", &mut |n| (TAU * turn(250.0, n) + 10.0 * (TAU * turn(40.0, n)).sin()).sin());
    add("one of noise", &mut |n| if n == 4001 { 0.8 } else { 0.0 });
    add("click", &mut |n| if n == 4000 { 1.0 } else { 0.0 });
    add("pulse 1 ms", &mut |n| if (4000..4008).contains(&n) { 1.0 } else { 0.0 });
    add("bang-bang", &mut |n| if (4000..4400).contains(&n) { impulse[4399 - n].signum() } else { 0.0 });
    add("bang-bang on", &mut |n| impulse[399 - n % 400].signum());
    set
}

#[test]
fn the_chain_is_flat_and_its_delay_is_the_reported_one_at_every_rate() {
    for rate in RATES {
        let mut chain = stage(1, rate, &Options::default());
        let mut click = vec![0.0; 4000];
        click[0] = 0.25;
        let out = channel(&run(&mut chain, &[click], || 64), 1, 0);
        for hertz in (0..=850).step_by(10).map(f64::from) {
            let h = at(&out, hertz, rate) * (4.0 / chain.ratio() as f64);
            let designed = chain.response(0, hertz);
            assert!((h - designed).abs() < 1e-5, "{rate} {hertz}: {h:?} {designed:?}");
            assert!((20.0 * h.abs().log10()).abs() < 0.5, "{rate} {hertz}");
        }
        let delay = chain.delay();
        let total = delay.fir_frames / rate + delay.band_limit_group_250;
        let phase = |hertz: f64| at(&out, hertz, rate).angle();
        let measured = (phase(249.0) - phase(251.0)) / (TAU * 2.0);
        assert!((measured - total).abs() < 2e-7, "{rate}: {measured} {total}");
        let steady = delay.fir_frames / rate + delay.band_limit_phase_250;
        assert!((phase(250.0) + TAU * 250.0 * steady).sin().abs() < 1e-5, "{rate}");
        assert!(total < 1.6e-3, "{rate}: {total}");
    }
}

#[test]
fn images_and_noise_of_a_sine_stay_low_at_every_rate() {
    for (rate, taps, worst) in RATES.map(|r| (r, 6, -88.0)).into_iter().chain([(48_000.0, 8, -110.0)]) {
        let mut chain = stage(1, rate, &Options { taps, ..Options::default() });
        let engine = chain.rate();
        let sine =
            (0..20_000).map(|n| (0.9 * (TAU * 843.0 / engine * f64::from(n)).sin() * 0.7) as f32).collect();
        let out = channel(&run(&mut chain, &[sine], || 64), 1, 0);
        let skip = 2000 * chain.ratio();
        let leak = above(&out[skip..], 1000.0, rate);
        assert!(leak < worst, "{rate} {taps}: {leak}");
    }
}

#[test]
fn single_precision_follows_the_double_precision_definition() {
    let options = Options { limiter: false, ..Options::default() };
    let mut chain = stage(8, 48_000.0, &options);
    let mut noise = random(3);
    let signals: Vec<Vec<f32>> = (0..8)
        .map(|c| {
            (0..16_000)
                .map(|n| match c {
                    0 => (noise() - 0.5) as f32,
                    _ => {
                        (0.9 * (TAU * [0.0, 5.0, 20.0, 60.0, 250.0, 500.0, 700.0, 850.0][c] / 8000.0
                            * f64::from(n))
                        .sin()) as f32
                    }
                })
                .collect()
        })
        .collect();
    let out = run(&mut chain, &signals, || 64);
    let filter = crate::dsp::elliptic::Elliptic::low_pass(4, 0.3, 66.0, 850.0, 8000.0);
    let fir = crate::dsp::interpolator::Interpolator::design(6, 6, 8000.0);
    for (c, signal) in signals.iter().enumerate() {
        let mut state = [[0.0; 2]; 4];
        let y: Vec<f64> = signal
            .iter()
            .map(|&x| {
                filter.gain
                    * filter.sections.iter().zip(&mut state).fold(f64::from(x), |x, (f, s)| f.step(s, x))
            })
            .collect();
        let (mut error, mut total) = (0.0, 0.0);
        for (m, got) in channel(&out, 8, c).into_iter().enumerate() {
            let (n, phase) = (m / 6, m % 6);
            let exact: f64 = (0..6).filter(|k| *k <= n).map(|k| fir.response[k * 6 + phase] * y[n - k]).sum();
            error += (got - exact).powi(2);
            total += exact * exact;
        }
        let decibel = 10.0 * (error / total).log10();
        assert!(decibel < -122.0, "signal {c}: {decibel}");
    }
}

#[test]
fn hostile_signals_keep_to_full_scale_and_to_the_band() {
    for rate in [44_100.0, 48_000.0, 96_000.0] {
        let options = Options::default();
        let engine = stage(1, rate, &options).rate();
        for level in [1.0, 4.0, 100.0] {
            for (name, signal) in hostile(engine, 12_000) {
                let mut chain = stage(1, rate, &options);
                let out = run(&mut chain, &[signal.iter().map(|v| (level * v) as f32).collect()], || 64);
                let out = channel(&out, 1, 0);
                let peak = chain.take_peak(0);
                assert!(out.iter().all(|v| v.abs() <= 1.0), "{name} × {level} at {rate}");
                assert!(peak < 1.05, "{name} × {level} at {rate}: {peak} before the clamp");
                let leak = above(&out, 1000.0, rate);
                // Forty decibels over full scale is no music: there only the peak is promised.
                assert!(leak < -60.0 || level > 4.0, "{name} × {level} at {rate}: {leak} dB");
            }
        }
    }
}

/// The band limit rings longest near its edge: there, predictions that end too soon let an output run into full scale.
#[test]
fn tones_near_the_edge_may_stop_dead() {
    let mut draw = random(11);
    for (rate, ratio) in [(44_100.0, 6), (48_000.0, 6), (12_000.0, 2), (12_000.0, 1), (8_400.0, 1)] {
        let options = Options { ratio: Some(ratio), ..Options::default() };
        let engine = rate / ratio as f64;
        let mut chain = stage(1, rate, &options);
        for _ in 0..120 {
            let (hertz, level) = (800.0 + 150.0 * draw(), 1.0 + 7.0 * draw());
            let (phase, count) = (TAU * draw(), (60.0 + 500.0 * draw()) as usize);
            let tone = |n: usize| match n < count {
                true => (level * (TAU * hertz / engine * n as f64 + phase).sin()) as f32,
                false => 0.0,
            };
            let before = chain.counts().clamped;
            run(&mut chain, &[(0..900).map(tone).collect()], || 64);
            let clamped = chain.counts().clamped - before;
            assert_eq!(clamped, 0, "{hertz} Hz × {level} from {phase}, {count} samples of {engine} Hz");
        }
    }
}

#[test]
fn what_needs_no_limiter_passes_to_the_bit() {
    let off = Options { limiter: false, ..Options::default() };
    let levels = [20.0, 60.0, 100.0, 200.0, 250.0, 300.0, 400.0].map(|f| (f, 0.94));
    let levels = levels.into_iter().chain([(600.0, 0.86), (700.0, 0.77), (800.0, 0.68), (850.0, 0.66)]);
    for (hertz, level) in levels {
        let sine: Vec<f32> = (0..8000)
            .map(|n| {
                let rise = (f64::from(n) / 400.0).min(1.0);
                (level * rise * (TAU * hertz / 8000.0 * f64::from(n)).sin()) as f32
            })
            .collect();
        let mut with = stage(1, 48_000.0, &Options::default());
        let got = run(&mut with, std::slice::from_ref(&sine), || 64);
        let plain = run(&mut stage(1, 48_000.0, &off), &[sine], || 64);
        assert_eq!(with.counts().limited, 0, "{hertz}");
        assert!(bits(&got) == bits(&plain), "{hertz}");
    }
}

/// What is left of a signal when the best sine of that frequency is taken away, against that sine, decibels.
fn residual(signal: &[f64], hertz: f64, rate: f64) -> f64 {
    // Normal equations of a sine and a cosine.
    let (mut m, mut b) = ([0.0; 3], [0.0; 2]);
    let wave = |n: usize| (TAU * hertz / rate * n as f64).sin_cos();
    for (n, v) in signal.iter().enumerate() {
        let (s, c) = wave(n);
        (m[0], m[1], m[2]) = (m[0] + s * s, m[1] + s * c, m[2] + c * c);
        (b[0], b[1]) = (b[0] + s * v, b[1] + c * v);
    }
    let det = m[0] * m[2] - m[1] * m[1];
    let (p, q) = ((b[0] * m[2] - b[1] * m[1]) / det, (b[1] * m[0] - b[0] * m[1]) / det);
    let (mut error, mut energy) = (0.0, 0.0);
    for (n, v) in signal.iter().enumerate() {
        let (s, c) = wave(n);
        let fit = p * s + q * c;
        (error, energy) = (error + (v - fit).powi(2), energy + fit * fit);
    }
    10.0 * (error / energy).log10()
}

/// A tone that is too loud comes out as the same tone: the gain does not breathe with its waves, and nothing is torn out of them.
#[test]
fn steady_tones_stay_sines_however_loud() {
    for hertz in
        [20.0, 40.0, 60.0, 100.0, 120.0, 150.0, 200.0, 250.0, 300.0, 333.0, 400.0, 450.0, 500.0, 600.0, 800.0]
    {
        for (level, attack) in
            [(0.96, 0.005), (1.0, 0.0), (1.0, 0.005), (1.05, 0.02), (1.2, 0.001), (2.0, 0.05), (4.0, 0.005)]
        {
            let tone = |n: usize| {
                let t = n as f64 / 8000.0;
                let rise = if attack > 0.0 { (t / attack).min(1.0) } else { 1.0 };
                (level * rise * (TAU * hertz * t).sin()) as f32
            };
            let mut chain = stage(1, 48_000.0, &Options::default());
            let out = channel(&run(&mut chain, &[(0..6400).map(tone).collect()], || 64), 1, 0);
            let left = residual(&out[16_800..36_000], hertz, 48_000.0);
            assert!(left < -90.0, "{hertz} Hz × {level}, attack {attack} s: {left} dB");
        }
    }
}

/// What was too loud is forgotten: within half a second the gain is 1 again, to the bit.
#[test]
fn the_gain_comes_back() {
    let signal = |quiet: f64| -> Vec<f32> {
        let loud = |n: usize| if n < 800 { 4.0 } else { quiet };
        (0..8000).map(|n| (loud(n) * (TAU * 90.0 / 8000.0 * n as f64).sin()) as f32).collect()
    };
    let mut chain = stage(1, 48_000.0, &Options::default());
    let got = run(&mut chain, &[signal(0.5)], || 64);
    assert_eq!(chain.gain(0), 1.0);
    let off = Options { limiter: false, ..Options::default() };
    let plain = run(&mut stage(1, 48_000.0, &off), &[signal(0.5)], || 64);
    let far = got[28_800..].iter().zip(&plain[28_800..]).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(far < 1e-5, "{far}");
}

/// Gives the length of the next block.
type Cut = Box<dyn FnMut() -> usize>;

/// Nineteen channels with noise, pauses, onsets and overload.
fn scene() -> Vec<Vec<f32>> {
    let mut noise = random(5);
    (0..19)
        .map(|c| {
            (0..6000)
                .map(|n| match (n / 700 + c) % 4 {
                    0 if c % 5 != 4 => 0.0,
                    1 => (3.0 * noise() - 1.5) as f32,
                    2 => (TAU * 230.0 * (c + 1) as f64 / 8000.0 * n as f64).sin() as f32 * 0.3,
                    _ => 0.0,
                })
                .collect()
        })
        .collect()
}

#[test]
fn any_split_and_any_instruction_set_give_the_same_bits() {
    let equalisers = vec![
        vec![Biquad::peaking(200.0, 1.0, 6.0, 8000.0)],
        Vec::new(),
        vec![Biquad::peaking(80.0, 2.0, -6.0, 8000.0), Biquad::peaking(400.0, 2.0, 3.0, 8000.0)],
    ];
    for taps in [4, 5, 6, 8, 12] {
        for rate in [48_000.0, 88_200.0, 8000.0] {
            let equalisers = equalisers.clone();
            let (keeps_dc_off, levels) = (vec![true, false, true], vec![1.0, 0.3, 0.05]);
            let options =
                Options { taps, equalisers, keeps_dc_off, levels, isa: Isa::Baseline, ..Options::default() };
            let whole = run(&mut stage(19, rate, &options), &scene(), || 6000);
            assert!(whole.iter().all(|v| v.abs() <= 1.0));
            let mut random = random(9);
            let mut cuts: [(&str, Cut); 4] = [
                ("1", Box::new(|| 1)),
                ("7", Box::new(|| 7)),
                ("64", Box::new(|| 64)),
                ("random", Box::new(move || (random() * 300.0) as usize)),
            ];
            for (name, cut) in &mut cuts {
                for isa in [Isa::Baseline, Isa::detect()] {
                    let options = Options { isa, ..options.clone() };
                    let split = run(&mut stage(19, rate, &options), &scene(), &mut *cut);
                    assert!(
                        bits(&split) == bits(&whole),
                        "{taps} taps, {rate} Hz, blocks of {name}, {isa:?}"
                    );
                }
            }
        }
    }
}

/// So does another level that is gone to while it sounds, be it in the middle of a turn.
#[test]
fn any_split_of_a_glide_gives_the_same_bits() {
    let halves = |from: usize, to: usize| -> Vec<Vec<f32>> {
        scene().into_iter().map(|signal| signal[from..to].to_vec()).collect()
    };
    let glide = |cut: usize, isa: Isa| {
        let options = Options { levels: vec![0.5; 12], isa, ..Options::default() };
        let mut chain = stage(19, 48_000.0, &options);
        let mut out = run(&mut chain, &halves(0, 3003), || cut);
        chain.limit_to(&[0.125; 19]);
        out.extend(run(&mut chain, &halves(3003, 3203), || cut));
        // Before it is there, it goes elsewhere.
        chain.limit_to(&[0.25; 4]);
        out.extend(run(&mut chain, &halves(3203, 6000), || cut));
        out
    };
    let whole = glide(6000, Isa::Baseline);
    for cut in [1, 7, 64, 131] {
        assert!(bits(&glide(cut, Isa::detect())) == bits(&whole), "blocks of {cut}");
    }
}

/// What leaves keeps to the level of its channel as it otherwise keeps to full scale, and what is too loud there stays the tone it is.
#[test]
fn a_level_below_full_scale_is_held_as_full_scale_is() {
    for level in [0.3, 0.07] {
        let options = Options { levels: vec![level], ..Options::default() };
        for (name, signal) in hostile(8000.0, 12_000) {
            let mut chain = stage(1, 48_000.0, &options);
            let loud = signal.iter().map(|v| (3.0 * level * v) as f32).collect();
            let out = channel(&run(&mut chain, &[loud], || 64), 1, 0);
            let peak = f64::from(chain.take_peak(0));
            assert!(out.iter().all(|v| v.abs() <= level), "{name} at {level}");
            assert!(peak < 1.05 * level, "{name} at {level}: {peak} before the clamp");
            let leak = above(&out, 1000.0, 48_000.0);
            assert!(leak < -60.0, "{name} at {level}: {leak} dB");
        }
        for (hertz, over) in [(40.0, 2.0), (150.0, 1.0), (250.0, 4.0), (600.0, 1.2), (90.0, 0.9)] {
            let tone = |n: usize| {
                let rise = (n as f64 / 40.0).min(1.0);
                (level * over * rise * (TAU * hertz / 8000.0 * n as f64).sin()) as f32
            };
            let mut chain = stage(1, 48_000.0, &options);
            let out = channel(&run(&mut chain, &[(0..6400).map(tone).collect()], || 64), 1, 0);
            let left = residual(&out[16_800..36_000], hertz, 48_000.0);
            assert!(left < -90.0, "{hertz} Hz × {over} at {level}: {left} dB");
            assert_eq!(chain.counts().limited == 0, over < 0.95, "{hertz} Hz × {over} at {level}");
            assert_eq!(chain.counts().clamped, 0);
        }
    }
}

/// Against its definition in double precision: of a voltage that stays nothing stays, however long one waits.
#[test]
fn the_high_pass_follows_its_definition_and_leaves_nothing_of_what_is_steady() {
    let options = Options { keeps_dc_off: vec![false, true, true], limiter: false, ..Options::default() };
    let mut chain = stage(3, 48_000.0, &options);
    let mut noise = random(17);
    let signals: Vec<Vec<f32>> = (0..3)
        .map(|c| (0..24_000).map(|_| if c < 2 { 0.6 } else { (0.3 + 0.4 * noise()) as f32 }).collect())
        .collect();
    let out = run(&mut chain, &signals, || 64);
    let blocker = crate::dsp::blocker::Blocker::new(1.0, 8000.0);
    let mut plain = stage(3, 48_000.0, &Options { limiter: false, ..Options::default() });
    let exact: Vec<Vec<f32>> = signals
        .iter()
        .map(|signal| {
            let mut mean = 0.0;
            let step = |x: &f32| {
                let apart = f64::from(*x) - mean;
                mean += blocker.pull * apart;
                (blocker.keep * apart) as f32
            };
            signal.iter().map(step).collect()
        })
        .collect();
    let wanted = run(&mut plain, &exact, || 64);
    for c in [1, 2] {
        assert!(channel(&out, 3, c) == channel(&wanted, 3, c), "channel {c}");
    }
    let late = |c: usize| channel(&out, 3, c)[130_000..].iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    // Single precision would leave 90 dB below it for ever.
    assert!(late(0) > 0.55 && late(1) < 1e-7, "{} {}", late(0), late(1));
}

#[test]
fn levels_that_are_none_are_refused() {
    for level in [0.0, -0.5, 1.5, f64::NAN, f64::INFINITY] {
        let options = Options { levels: vec![1.0, level], ..Options::default() };
        let why = Vibration::new(2, 48_000.0, &options).unwrap_err();
        assert!(matches!(why, Refusal::Level(1, _)), "{why}");
        // Of channels that are not there nothing is said.
        assert!(Vibration::new(1, 48_000.0, &options).is_ok());
    }
}

#[test]
fn neighbours_change_nothing() {
    let signals = scene();
    let together = run(&mut stage(19, 48_000.0, &Options::default()), &signals, || 64);
    for (c, signal) in signals.iter().enumerate() {
        let alone = run(&mut stage(1, 48_000.0, &Options::default()), std::slice::from_ref(signal), || 64);
        assert!(alone.iter().map(|&v| f64::from(v)).eq(channel(&together, 19, c)), "channel {c}");
    }
}

#[test]
fn silence_becomes_exact_zero_and_sleeps_until_the_exact_sample() {
    let mut chain = stage(9, 48_000.0, &Options::default());
    assert!(chain.sleeps(0) && chain.sleeps(1));
    let mut burst = vec![vec![0.0; 8000]; 9];
    for (n, x) in burst[2].iter_mut().take(400).enumerate() {
        *x = (TAU * 250.0 / 8000.0 * n as f64).sin() as f32 * 2.0;
    }
    burst[2][7001] = 0.5;
    let out = run(&mut chain, &burst, || 100);
    let lane = channel(&out, 9, 2);
    assert!(lane[300 * 6] != 0.0);
    assert!(lane[4000 * 6..7001 * 6].iter().all(|v| *v == 0.0));
    assert!(lane[7001 * 6] != 0.0);
    assert!(!chain.sleeps(0) && chain.sleeps(1));
    assert!(channel(&out, 9, 8).iter().all(|v| *v == 0.0));
    // Asleep and not fed, rows are not even looked at.
    let mut rows = vec![[f32::NAN; 8]; 2 * 64];
    let mut block = vec![1.0; 64 * 6 * 9];
    let mut fresh = stage(9, 48_000.0, &Options::default());
    assert_eq!(fresh.process(64, &mut rows, &[false, false], 0, &mut block), 64);
    assert!(block.iter().all(|v| *v == 0.0));
}

#[test]
fn what_is_not_finite_is_masked_counted_and_stays_in_its_channel() {
    let clean = scene();
    let mut spoilt = clean.clone();
    for (n, wild) in [(100, f32::NAN), (900, f32::INFINITY), (901, f32::NEG_INFINITY), (1500, 1e30)] {
        spoilt[3][n] = wild;
    }
    for limiter in [true, false] {
        let options = Options { limiter, ..Options::default() };
        let mut chain = stage(19, 48_000.0, &options);
        let got = run(&mut chain, &spoilt, || 64);
        let plain = run(&mut stage(19, 48_000.0, &options), &clean, || 64);
        assert_eq!((chain.counts().masked, chain.counts().held), (3, 1));
        assert!(got.iter().all(|v| v.abs() <= 1.0));
        for c in (0..19).filter(|c| *c != 3) {
            assert!(channel(&got, 19, c) == channel(&plain, 19, c), "channel {c}");
        }
    }
}

#[test]
fn an_equaliser_shapes_its_own_channel_only() {
    let bell = Biquad::peaking(250.0, 2.0, 6.0, 8000.0);
    let options = Options { equalisers: vec![Vec::new(), vec![bell]], ..Options::default() };
    let mut chain = stage(2, 48_000.0, &options);
    let mut click = vec![0.0; 4000];
    click[0] = 0.1;
    let out = run(&mut chain, &[click.clone(), click], || 64);
    let gain = |hertz| at(&channel(&out, 2, 1), hertz, 48_000.0) / at(&channel(&out, 2, 0), hertz, 48_000.0);
    for hertz in [100.0, 250.0, 600.0] {
        assert!((gain(hertz) - bell.response(hertz, 8000.0)).abs() < 1e-5, "{hertz}");
    }
}

#[test]
fn what_cannot_be_built_is_refused_and_short_slices_render_what_fits() {
    let refuse = |rate, options: &Options| Vibration::new(1, rate, options).err();
    assert_eq!(refuse(48_000.0, &Options { taps: 3, ..Options::default() }), Some(Refusal::Taps(3)));
    assert_eq!(refuse(5000.0, &Options::default()), Some(Refusal::Rate(5000.0)));
    assert!(refuse(f64::NAN, &Options::default()).is_some());
    let many = Options { equalisers: vec![vec![Biquad::THROUGH; 17]], ..Options::default() };
    assert_eq!(refuse(48_000.0, &many), Some(Refusal::Sections(0, 17)));
    let mut chain = stage(3, 48_000.0, &Options::default());
    let mut rows: Vec<Row> = vec![[0.1; 8]; 10];
    assert_eq!(chain.process(10, &mut rows, &[], 0, &mut [0.0; 3 * 6 * 4]), 4);
    assert_eq!(chain.process(10, &mut [], &[], 0, &mut []), 0);
    assert_eq!(stage(0, 48_000.0, &Options::default()).process(10, &mut [], &[], 0, &mut []), 10);
}
