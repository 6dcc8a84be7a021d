use super::{FULL, Gauge, Path, REFERENCE, amplitude, magnitude};
use crate::dsp::biquad::Biquad;
use crate::perception::calibration::{Table, UNITS, Unit};
use crate::perception::site::find;
use crate::perception::threshold::{Threshold, decibels};

const RATE: f64 = 8000.0;

fn path(gain: f64, per_sample: f64) -> Path {
    Path { gain, per_sample, corners: Vec::new(), filters: Vec::new(), rate: RATE, most: 1.0, limited: None }
}

fn table(points: &[[f64; 2]]) -> Table {
    Table::new(points, Unit::at(UNITS.iter().position(|word| *word == "um/V").unwrap()).1).unwrap()
}

/// By the definition: volts at the terminals times what was measured, over the threshold, both in metres.
#[test]
fn a_level_makes_the_displacement_that_is_so_far_above_the_threshold() {
    let measured = [[40.0, 30.0], [80.0, 22.0], [160.0, 14.0], [320.0, 3.0]];
    let peak = Biquad::peaking(150.0, 1.5, 6.0, RATE);
    let mut way = Path { filters: vec![peak, peak], ..path(0.5, 2.4) };
    way.corners = vec![15.0, 4.0];
    let threshold = Threshold::new(find("fingertip").unwrap(), 2e-5);
    let gauge = Gauge::calibrated(threshold, table(&measured), way);
    for [hertz, micrometres] in measured {
        for felt in [-10.0, 0.0, 10.0, 13.0] {
            let level = gauge.level(felt, 1.0, hertz);
            let raised = peak.response(hertz, RATE).abs().powi(2);
            let passed: f64 = [15.0, 4.0]
                .iter()
                .map(|corner| 1.0 / (1.0 + (corner / hertz) * (corner / hertz)).sqrt())
                .product();
            let metres = level * 0.5 * raised * passed * 2.4 * micrometres * 1e-6;
            let above = 20.0 * metres.log10() - threshold.metres(hertz);
            assert!((above - felt).abs() < 1e-9, "{hertz} Hz, {felt} dB: {above}");
        }
    }
}

/// Shares of an energy law keep the sum of squares of what is felt, in units of the threshold.
#[test]
fn shares_of_unequal_tactors_keep_the_power() {
    let finger = Threshold::new(find("fingertip").unwrap(), 2e-5);
    let arm = Threshold::new(find("forearm").unwrap(), 1e-4);
    let strong = Gauge::calibrated(finger, table(&[[50.0, 90.0], [500.0, 30.0]]), path(1.0, 1.0));
    let weak = Gauge::calibrated(arm, table(&[[50.0, 9000.0], [500.0, 700.0]]), path(0.7, 3.0));
    let felt = |gauge: &Gauge, level: f64| amplitude(decibels(level) + gauge.full(200.0));
    for part in [0.01, 0.25, 0.5, 0.8, 0.99_f64] {
        let power: f64 = [(&strong, part), (&weak, 1.0 - part)]
            .map(|(gauge, weight)| felt(gauge, gauge.level(12.0, weight.sqrt(), 200.0)).powi(2))
            .iter()
            .sum();
        assert!((10.0 * power.log10() - 12.0).abs() < 1e-9, "{part}: {power}");
    }
}

#[test]
fn what_is_beyond_the_limit_is_capped_and_told() {
    let threshold = Threshold::new(find("thenar").unwrap(), 1e-4);
    let gauge = Gauge::calibrated(
        threshold,
        table(&[[50.0, 1.0], [500.0, 1.0]]),
        Path { most: 0.25, ..path(0.5, 1.0) },
    );
    let most = gauge.most(100.0);
    // A quarter of full scale at 1 µm a volt.
    assert!((most - (20.0 * 0.25e-6f64.log10() - threshold.metres(100.0))).abs() < 1e-9, "{most}");
    assert!((gauge.level(most, 1.0, 100.0) - 0.5).abs() < 1e-12);
    assert_eq!(gauge.level(most + 7.5, 1.0, 100.0), 0.5);
    assert!((gauge.missing(most + 7.5, 1.0, 100.0) - 7.5).abs() < 1e-9);
    // A share of it may still fit.
    assert_eq!(gauge.missing(most + 5.0, 0.5, 100.0), 0.0);
    assert!((gauge.level(most + 5.0, 0.5, 100.0) - 0.25 * 10f64.powf(0.25)).abs() < 1e-9);
    for (felt, share) in [(f64::NAN, 1.0), (20.0, f64::NAN), (f64::NEG_INFINITY, 1.0)] {
        assert_eq!(gauge.level(felt, share, 100.0), 0.0);
    }
    assert_eq!(gauge.level(f64::INFINITY, 1.0, 100.0), 0.5);
    let off = Gauge { path: Path { gain: 0.0, ..gauge.path.clone() }, ..gauge };
    assert_eq!(off.level(20.0, 1.0, 100.0), 0.0);
}

#[test]
fn beyond_the_range_its_end_holds() {
    let threshold = Threshold::new(find("thenar").unwrap(), 1e-4);
    let gauge = Gauge::calibrated(threshold, table(&[[60.0, 4.0], [400.0, 0.8]]), path(1.0, 1.0));
    assert_eq!(gauge.range(), [60.0, 400.0]);
    for (beyond, end) in
        [(1.0, 60.0), (-5.0, 60.0), (f64::NAN, 60.0), (4000.0, 400.0), (f64::INFINITY, 400.0)]
    {
        assert!(!gauge.knows(beyond));
        assert_eq!(gauge.level(10.0, 1.0, beyond), gauge.level(10.0, 1.0, end));
    }
    let wide = Gauge::calibrated(threshold, table(&[[1.0, 4.0], [5000.0, 0.8]]), path(1.0, 1.0));
    assert_eq!(wide.range(), [10.0, 1000.0], "where thresholds are known");
}

/// Without a calibration the full level at 250 Hz counts for 40 dB, and the rest follows the curves.
#[test]
fn a_tactor_of_which_nothing_is_known_keeps_the_shape_of_the_curves() {
    let threshold = Threshold::new(find("thenar").unwrap(), 2.9e-4);
    let gauge = Gauge::unknown(threshold, path(0.3, 77.0));
    assert!(!gauge.is_calibrated());
    assert!((gauge.level(FULL, 1.0, REFERENCE) - 1.0).abs() < 1e-12);
    assert!((gauge.level(FULL - 20.0, 1.0, REFERENCE) - 0.1).abs() < 1e-12);
    for hertz in [20.0, 60.0, 125.0, 500.0] {
        // As much more as the threshold is higher, less what displacement gains below at the same acceleration.
        let due = threshold.metres(hertz) - threshold.metres(REFERENCE) - 40.0 * (REFERENCE / hertz).log10();
        let is = decibels(gauge.level(FULL - 30.0, 1.0, hertz)) + 30.0;
        assert!((is - due).abs() < 1e-9, "{hertz}: {is} {due}");
    }
}

#[test]
fn sections_are_what_their_response_says() {
    for section in
        [Biquad::THROUGH, Biquad::peaking(60.0, 9.0, -30.0, RATE), Biquad::peaking(900.0, 0.3, 24.0, RATE)]
    {
        for hertz in [10.0, 60.0, 250.0, 899.0] {
            let due = section.response(hertz, RATE).abs();
            assert!((magnitude(&section, hertz / RATE) / due - 1.0).abs() < 1e-9, "{section:?} {hertz}");
        }
    }
}

/// Of a tone at 800 Hz the limiter leaves 0.69 of its level, at 100 Hz 0.9; what amplifier and actuator bear does not depend on that.
#[test]
fn the_limiter_leaves_less_of_high_tones() {
    let threshold = Threshold::new(find("thenar").unwrap(), 1e-4);
    let gauge = |most: f64, limited: Option<f64>| {
        let way = Path { most, limited, ..path(1.0, 1.0) };
        Gauge::calibrated(threshold, table(&[[50.0, 1.0], [1000.0, 1.0]]), way)
    };
    let free = gauge(1.0, None);
    for (hertz, share) in [(100.0, 0.9), (400.0, 0.9), (600.0, 0.85), (800.0, 0.688)] {
        let less = free.most(hertz) - gauge(1.0, Some(1.0)).most(hertz);
        assert!((less + decibels(share)).abs() < 1e-9, "{hertz}: {less}");
        assert!((gauge(0.3, Some(1.0)).most(hertz) - gauge(0.3, None).most(hertz)).abs() < 1e-9);
        assert!((gauge(1.0, Some(0.5)).level(300.0, 1.0, hertz) - 0.5 * share).abs() < 1e-9);
    }
}
