//! What a plan promises of its errors, and what it leaves out, held against trajectories of 19 digits.

use crate::common::{Case, cases, run};
use pacinian::actuator::motor::{Casing, Level, Part, Plan, Why, Wish};

fn speed_error(case: &Case, plan: &Plan, rate: f64) -> f64 {
    let (_, rows) = run::<false>(case, plan, rate);
    let off = rows.iter().map(|(row, got)| (got[1] - case.rows[*row][1]).abs());
    off.fold(0.0, f64::max) / case.parameters.rated_speed()
}

fn full_drive() -> impl Iterator<Item = Case> {
    cases().into_iter().filter(|c| c.name.contains("_f_") || c.name.contains("_g_") || c.name.contains("_k_"))
}

#[test]
fn errors_are_what_the_plan_says() {
    for case in full_drive() {
        for rate in [8e3, 48e3, 192e3] {
            for (level, slack) in [(Level::Default, 2.0), (Level::Fine, 200.0)] {
                let plan = Plan::whole(level);
                let (said, is) = (plan.error(&case.parameters, rate), speed_error(&case, &plan, rate));
                // Rounding is the floor of both.
                assert!(is <= said + 1e-13, "{} {level:?} {rate}: {is:e} {said:e}", case.name);
                assert!(said <= slack * is + 1e-12, "{} {level:?} {rate}: {is:e} {said:e}", case.name);
            }
        }
    }
}

#[test]
fn an_inductance_left_out_costs_what_the_plan_says() {
    let mut seen = 0;
    for case in full_drive() {
        let wish = Wish { error: 1e-2, posture: true, casing: true };
        let plan = Plan::choose(&case.parameters, 48e3, &wish);
        let p = &case.parameters;
        let late = p.electrical_time() * 2.2 * p.stall_torque(p.rated_volts)
            / p.effective_inertia()
            / p.rated_speed();
        let out = plan.left_out[1].map(|out| out.why);
        assert_eq!(plan.inductance, late >= 1e-2);
        assert_eq!(out.is_none(), plan.inductance, "{}", case.name);
        if let Some(Why::Small(said)) = out {
            assert!((said / late - 1.0).abs() < 1e-12);
            let error = speed_error(&case, &plan, 48e3);
            assert!(error < late && error < wish.error, "{}: {error:e} {late:e}", case.name);
            seen += 1;
        }
    }
    assert!(seen >= 5);
}

#[test]
fn a_level_is_chosen_by_the_error_that_is_wished() {
    for case in full_drive() {
        for rate in [4e3, 8e3, 48e3] {
            for error in [1e-2, 1e-4, 1e-6, 1e-8] {
                let wish = Wish { error, posture: true, casing: true };
                let plan = Plan::choose(&case.parameters, rate, &wish);
                let is = speed_error(&case, &plan, rate);
                // At the fine level there is nothing finer.
                assert!(
                    is < error || plan.level == Level::Fine,
                    "{} {rate} {error}: {is:e} {plan:?}",
                    case.name
                );
                assert_eq!(plan.left_out[2].is_none(), plan.casing);
            }
        }
    }
}

#[test]
fn what_is_not_needed_is_left_out_and_said() {
    let coin = cases().into_iter().find(|c| c.name == "coin10_g_reversal_gravity_fric").unwrap().parameters;
    let wish = Wish { error: 1e-2, posture: false, casing: false };
    let plan = Plan::choose(&coin, 48e3, &wish);
    assert_eq!(
        (plan.level, plan.gravity, plan.inductance, plan.casing),
        (Level::Economy, false, false, false)
    );
    let said: Vec<String> = plan.left_out.iter().flatten().map(ToString::to_string).collect();
    let expected = [
        "gravity: nobody said how the device is held",
        "inductance: it changes the speed by 7.55e-4 of the rated",
        "casing: nobody asked",
    ];
    assert_eq!(said, expected);
    assert_eq!(plan.error(&coin, 48e3), 0.0);
    // A light mass on a strong motor, held still, no inductance.
    let strong = pacinian::actuator::motor::Parameters {
        eccentric: 1e-9,
        inductance: 0.0,
        casing: Casing::Held,
        ..coin
    };
    let plan = Plan::choose(&strong, 48e3, &Wish { error: 1e-2, posture: true, casing: true });
    let why: Vec<_> = plan.left_out.iter().flatten().map(|out| (out.part, out.why)).collect();
    let heavy = strong.weight() / strong.stall_torque(3.0);
    let expected =
        [(Part::Gravity, Why::Small(heavy)), (Part::Inductance, Why::None), (Part::Casing, Why::None)];
    assert_eq!(why, expected);
    let whole = Plan::whole(Level::Default);
    assert!(whole.gravity && whole.inductance && whole.casing && whole.left_out == [None; 3]);
}
