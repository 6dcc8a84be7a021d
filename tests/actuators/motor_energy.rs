//! What goes into a rumble motor comes out of it or stays in it. What is dissipated and supplied is summed up by quadrature of the motion, so
//! the balance closes only where the motion is right. The casing is no part of it: on springs it takes from the mass and gives nothing back.

use crate::common::{PAD, cases, run};
use pacinian::actuator::motor::{Drive, Energy, Level, Motor, Parameters, Plan};

/// What is missing, as a share of what came in.
fn share(motor: &Motor<true>) -> f64 {
    let energy = motor.energy();
    let put_in = energy.supplied.abs() + energy.placed;
    energy.missing(motor.stored()).abs() / put_in
}

#[test]
fn the_balance_closes_over_every_trajectory_at_48_khz() {
    for case in cases() {
        for (level, most) in [(Level::Default, 1e-7), (Level::Fine, 1e-10)] {
            let (motor, _) = run::<true>(&case, &Plan::whole(level), 48_000.0);
            let most = if case.parameters.gravity == 0.0 { 1e-12 } else { most };
            assert!(share(&motor) < most, "{} {level:?}: {:e}", case.name, share(&motor));
        }
    }
}

/// Voltages, a current within its limit and beyond it, and terminals opened while current flows.
fn all_drives(parameters: &Parameters, level: Level) -> (f64, Energy) {
    let mut motor = Motor::<true>::new(parameters, &Plan::whole(level), 48_000.0).unwrap();
    let stall = parameters.rated_volts / parameters.resistance;
    let current = |share: f64| Drive::Current { amperes: share * stall, limit: parameters.rated_volts };
    let drives = [
        Drive::Voltage(parameters.rated_volts),
        Drive::Voltage(-parameters.rated_volts),
        current(0.6),
        current(-0.8),
        Drive::Open,
        Drive::Voltage(0.4 * parameters.rated_volts),
        Drive::SHORT,
    ];
    for (n, drive) in drives.iter().cycle().take(21).enumerate() {
        for step in 0..700 {
            if step == 0 {
                motor.step_with(&[(0.37 + 0.02 * n as f64, *drive)]);
            } else {
                motor.step();
            }
        }
    }
    assert!(motor.counts().events >= 15, "{:?}", motor.counts());
    (share(&motor), motor.energy())
}

#[test]
fn the_balance_closes_over_every_kind_of_drive() {
    for (level, most) in [(Level::Default, 1e-7), (Level::Fine, 1e-10)] {
        let (missing, energy) = all_drives(&PAD, level);
        assert!(missing < most, "{level:?}: {missing:e}");
        // Each part is there: a balance of nothing closes as well.
        for part in [energy.heat, energy.viscous, energy.dry, energy.opened] {
            assert!(part > 1e-5 * energy.supplied, "{energy:?}");
        }
        let level_off = all_drives(&Parameters { gravity: 0.0, ..PAD }, level).0;
        assert!(level_off < 1e-12, "{level:?}: {level_off:e}");
    }
    // With no inductance there is nothing in the coil to lose.
    let (missing, energy) = all_drives(&Parameters { inductance: 0.0, ..PAD }, Level::Fine);
    assert!(missing < 1e-10 && energy.opened == 0.0, "{missing:e}");
}

/// Booking changes nothing of the motion.
#[test]
fn a_motor_that_keeps_books_moves_alike() {
    let mut kept = Motor::<true>::new(&PAD, &Plan::whole(Level::Fine), 8000.0).unwrap();
    let mut bare = Motor::<false>::new(&PAD, &Plan::whole(Level::Fine), 8000.0).unwrap();
    for n in 0..4000 {
        let drive = Drive::Voltage(if n % 400 < 200 { 9.0 } else { -4.0 });
        kept.drive(drive);
        bare.drive(drive);
        kept.step();
        bare.step();
        assert_eq!(kept.reading(), bare.reading());
    }
}
