use super::super::lra::Sheet;
use super::super::lra::tests::sheet;
use super::super::model::Model;
use super::super::plant::Plant;
use super::super::resonance::Resonance;
use super::Burst;
use crate::actuator::drive::Drive;

fn plant(sheet: Sheet) -> (Plant, Resonance) {
    let plant = Plant::inertial(&sheet.actuator().unwrap()).unwrap();
    (plant, plant.resonance(Drive::Voltage).unwrap())
}

/// The figures of two usual actuators: natural decay to a tenth, rise and brake with twice the voltage.
#[test]
fn times_are_those_of_the_closed_forms() {
    for (hertz, q, decay, rise, brake) in
        [(175.0, 15.0, 27e-3, 19e-3, 11e-3), (235.0, 10.0, 13.5e-3, 9.4e-3, 5.5e-3)]
    {
        let burst = Burst::new(Resonance { hertz, q }, 1.0, 2.0, 1.0).unwrap();
        assert!((burst.resonance.decay() - decay).abs() < 0.5e-3);
        assert!((burst.rise - rise).abs() < 0.5e-3 && (burst.brake - brake).abs() < 0.5e-3, "{burst:?}");
        assert!(
            (burst.envelope(burst.rise) - 1.0).abs() < 1e-12 && (burst.envelope(0.9) - 1.0).abs() < 1e-12
        );
        assert!(burst.envelope(1.0 + burst.brake).abs() < 1e-12);
    }
    // A burst that ends before the rated amplitude is reached is braked for a shorter time.
    let short = Burst::new(Resonance { hertz: 175.0, q: 15.0 }, 1.0, 2.0, 8e-3).unwrap();
    assert!(short.rise == 8e-3 && short.envelope(9e-3 + short.brake).abs() < 1e-12 && short.brake < 9e-3);
    let plain = Burst::new(Resonance { hertz: 175.0, q: 15.0 }, 1.0, 1.0, 0.5).unwrap();
    assert!(
        plain.rise == 0.0 && (plain.envelope(plain.resonance.decay()) + (-1f64).exp() - 1.0).abs() < 1e-12
    );
}

/// Amplitude of what swings, from displacement and velocity.
fn amplitude(model: &Model, resonance: Resonance) -> f64 {
    model.state().displacement.hypot(model.state().velocity / resonance.omega())
}

/// The model stepped through the samples: rated when the overdrive ends, within 1/Q or so; at rest after the settled brake.
#[test]
fn the_stepped_model_rises_and_stops_as_planned() {
    for (q, inductance) in [(15.0, 0.0), (15.0, 1e-3), (10.0, 1e-4), (40.0, 0.0)] {
        for gain in [1.3, 2.0, 4.0] {
            let sheet = Sheet { q, inductance, rated_acceleration: q, ..sheet() };
            let (plant, resonance) = plant(sheet);
            let rated_volts = 1.0;
            let mut burst = Burst::new(resonance, rated_volts, gain, 0.1).unwrap();
            let rated = plant.per_volt(resonance.hertz).displacement.abs() * rated_volts;
            let rate = 192_000.0;
            let closed = burst.rest(&plant, Drive::Voltage).amplitude;
            assert!(closed < 0.6 * (1.0 + gain) / q, "{q} {gain}: {closed}");
            let settled = burst.settle(&plant, Drive::Voltage);
            assert!(settled.amplitude < 1e-9, "{q} {gain}: {settled:?}");
            assert!(burst.lead.abs() < 0.7, "the phase stays opposite: {burst:?}");
            let mut model = Model::new(&plant, rate, Drive::Voltage).unwrap();
            let (mut at_rise, mut most) = (0.0, 0.0f64);
            for (n, volts) in burst.samples(rate).into_iter().enumerate() {
                model.advance(volts);
                most = most.max(volts.abs());
                if n == (burst.rise * rate) as usize {
                    at_rise = amplitude(&model, resonance) / rated;
                }
            }
            assert!(most <= gain * rated_volts);
            if burst.rise < burst.length {
                assert!((at_rise - 1.0).abs() < 1.0 / q, "{q} {gain}: {at_rise}");
            }
            let rest = amplitude(&model, resonance) / rated;
            // Samples of 1/192 000 s end up to one of them late.
            assert!(rest < 1e-3, "{q} {gain}: {rest}");
        }
    }
}

/// Samples are means of the drive, each over its time.
#[test]
fn samples_are_means_of_the_drive() {
    let (plant, resonance) = plant(sheet());
    let mut burst = Burst::new(resonance, 1.0, 2.0, 30e-3).unwrap();
    burst.settle(&plant, Drive::Voltage);
    assert!(burst.lead.abs() > 1e-3);
    for (n, sample) in burst.samples(8000.0).into_iter().enumerate() {
        let at = |k: usize| (n as f64 + (k as f64 + 0.5) / 2000.0) / 8000.0;
        let mean = (0..2000).map(|k| burst.drive(at(k))).sum::<f64>() / 2000.0;
        // The drive leaps where it is braked.
        assert!((sample - mean).abs() < 2e-3, "{n}: {sample} {mean}");
    }
    assert_eq!((burst.drive(-1.0), burst.drive(1.0), burst.drive(f64::NAN)), (0.0, 0.0, 0.0));
}

/// What braking is for: without it, a tenth is left only after τ ln 10.
#[test]
fn braking_in_phase_makes_it_worse() {
    let (plant, resonance) = plant(sheet());
    let burst = Burst::new(resonance, 1.0, 2.0, 0.2).unwrap();
    let opposite = burst.rest(&plant, Drive::Voltage).amplitude;
    let none = Burst { brake: 0.0, ..burst }.rest(&plant, Drive::Voltage).amplitude;
    let along = Burst { lead: std::f64::consts::PI, ..burst }.rest(&plant, Drive::Voltage).amplitude;
    assert!(opposite < 0.1 && (none - 1.0).abs() < 0.01 && along > 1.2, "{opposite} {none} {along}");
}

#[test]
fn a_burst_that_cannot_be_is_refused() {
    let sound = Resonance { hertz: 175.0, q: 15.0 };
    let fault = |r, rated, most, length| Burst::new(r, rated, most, length).unwrap_err().field;
    assert_eq!(fault(sound, 2.0, 1.0, 0.1), "most");
    assert_eq!(fault(sound, 0.0, 1.0, 0.1), "rated");
    assert_eq!(fault(sound, 1.0, f64::NAN, 0.1), "most");
    assert_eq!(fault(sound, 1.0, 2.0, -0.1), "length");
    assert_eq!(fault(Resonance { q: 0.5, ..sound }, 1.0, 2.0, 0.1), "q");
    assert_eq!(fault(Resonance { hertz: 0.0, ..sound }, 1.0, 2.0, 0.1), "resonance");
    let nothing = Burst::new(sound, 1.0, 2.0, 0.0).unwrap();
    assert_eq!((nothing.brake, nothing.samples(8000.0).len()), (0.0, 0));
}
