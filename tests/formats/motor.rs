//! Rumble motors in rigs: what they are made of, what reaches them, and what is refused.

use pacinian::Rig;
use pacinian::actuator::motor::{Casing, GRAVITY};
use pacinian::rig::{Shaping, Wiring};

const DEVICE: &str = "channels = 2\nfull_scale_volts = 1.5\ncoupling = \"dc\"";
const BRIDGE: &str = "gain = 4\nmax_volts = 5\ncoupling = \"dc\"";
const COIN: &str = "part = \"coin-10mm\"";

fn source([device, amplifier, actuator, output]: [&str; 4]) -> String {
    format!(
        "format = \"pacinian-rig/1\"\ntitle = \"A motor\"\n[device]\n{device}\n[amplifier.bridge]\n{amplifier}\n\
         [actuator.motor]\n{actuator}\n[[output]]\nkind = \"drive\"\nname = \"wrist\"\nchannel = 1\n{output}\n"
    )
}

const WIRED: &str = "actuator = \"motor\"\namplifier = \"bridge\"";

fn wiring(parts: [&str; 4]) -> Wiring {
    let rig = Rig::parse("r.toml", source(parts).as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    rig.wiring(&rig.outputs[0]).unwrap().unwrap()
}

fn refused(parts: [&str; 4]) -> String {
    Rig::parse("r.toml", source(parts).as_bytes()).unwrap_err().to_string()
}

#[test]
fn a_part_fills_in_what_the_rig_does_not_say() {
    let wiring = wiring([DEVICE, BRIDGE, "part = \"coin-10mm\"\nresistance = 40\nmass = 0.05", WIRED]);
    let p = wiring.parameters;
    assert_eq!((p.resistance, p.gain, p.casing), (40.0, 0.955e-3, Casing::Free { mass: 0.05 }));
    assert_eq!((p.gravity, wiring.turning.shaping, wiring.turning.look_ahead), (0.0, Shaping::Inverse, None));
    // 1.5 V times 4, of which the part takes 3 V.
    assert_eq!((wiring.per_sample, wiring.limit, wiring.compliance), (6.0, 3.0, 5.0));
}

#[test]
fn limits_are_the_lowest_of_all_that_are_named() {
    let limit = |device: &str, amplifier: &str, actuator: &str, output: &str| {
        let device = format!("{DEVICE}\n{device}");
        let output = format!("{WIRED}\n{output}");
        wiring([&device, &format!("coupling = \"dc\"\n{amplifier}"), &format!("{COIN}\n{actuator}"), &output])
            .limit
    };
    assert_eq!(limit("", "gain = 4", "", ""), 3.0);
    assert_eq!(limit("", "gain = 4", "max_volts = 5", ""), 5.0);
    assert_eq!(limit("", "gain = -4\nmax_volts = 4.5", "max_volts = 5", ""), 4.5);
    assert_eq!(limit("", "gain = 4", "max_volts = 5", "max_level = 0.5"), 3.0);
    assert_eq!(limit("max_level = 0.25", "gain = 4", "max_volts = 5", "max_level = 0.5"), 1.5);
    // By current: what flows at a standstill with the most it bears, unless something says less.
    assert_eq!(limit("", "gain = 1\ndrive = \"current\"", "", ""), 0.1);
    assert_eq!(limit("", "gain = 1\ndrive = \"current\"\nmax_amperes = 0.08", "", ""), 0.08);
    // By voltage: what 30 ohm take of the motor's amperes at a standstill, and of the amplifier's in a brake from full speed, where the motor adds
    // k²/(k² + b R) of the voltage.
    assert_eq!(limit("", "gain = 4", "max_amperes = 0.05", ""), 1.5);
    let adds = 0.955e-3_f64.powi(2) / (0.955e-3_f64.powi(2) + 2.15e-8 * 30.0);
    let brakes = limit("", "gain = 4\nmax_amperes = 0.1", "", "");
    assert!((brakes - 3.0 / (1.0 + adds)).abs() < 1e-12, "{brakes}");
    let by = |amplifier| wiring([DEVICE, amplifier, COIN, WIRED]);
    assert_eq!(by("gain = -4\ncoupling = \"dc\"").per_sample, -6.0);
    assert!(by("gain = 1\ndrive = \"current\"\ncoupling = \"dc\"").is_current);
}

#[test]
fn tilt_is_the_share_of_gravity_in_the_plane_of_rotation() {
    let gravity =
        |tilt: &str| wiring([DEVICE, BRIDGE, COIN, &format!("{WIRED}\ntilt = {tilt}")]).parameters.gravity;
    assert_eq!(gravity("0"), GRAVITY);
    assert!((gravity("1.0471975511965976") - 0.5 * GRAVITY).abs() < 1e-12);
    assert!(gravity("1.5707963267948966") < 1e-12);
}

/// A motor known from outside moves as one of any other resistance would: same time constant, speed and acceleration.
#[test]
fn a_motor_known_from_outside_moves_as_it_was_seen_to() {
    let seen = "model = \"rumble-motor\"\nrated_volts = 3\ntime_constant = 0.035\nspeed_per_volt = 600\nrunning_volts = 0.4\n\
                start_volts = 0.6\neccentric_per_mass = 7e-6";
    let p = wiring([DEVICE, BRIDGE, seen, WIRED]).parameters;
    let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
    near(p.mechanical_time(), 0.035);
    near(p.steady_speed(3.0), 600.0 * 2.6);
    near(p.start_volts(), 0.6);
    near(p.rated_acceleration().unwrap(), 7e-6 * (600.0_f64 * 2.6).powi(2));
}

/// How a motor is seen to move goes before what its part is made of; what is not seen is as that part's, on what the rig says that it moves.
#[test]
fn what_was_seen_of_a_motor_goes_before_its_part() {
    let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    let of = |more: &str| wiring([DEVICE, BRIDGE, &format!("{COIN}\n{more}"), WIRED]).parameters;
    let part = of("mass = 0.05");
    let running = part.coulomb * part.resistance / part.gain;
    let seen = of("mass = 0.05\ntime_constant = 0.02\nspeed_per_volt = 500");
    near(seen.mechanical_time(), 0.02);
    near(seen.steady_speed(3.0), 500.0 * (3.0 - running));
    near(seen.start_volts(), part.start_volts());
    near(seen.eccentric / seen.casing.mass().unwrap(), 7.3e-7 / 0.05);
    // Who says what it is made of after all is believed.
    let made = of("time_constant = 0.02\ntorque_constant = 1e-3");
    assert_eq!((made.gain, made.inertia, made.resistance), (1e-3, 1.8e-9, 30.0));
}

/// Who is about to measure a motor has a rig without its figures; everything else must be right.
#[test]
fn a_draft_may_lack_what_a_motor_is_made_of() {
    let bare = "model = \"rumble-motor\"\nrated_volts = 3";
    let draft = |parts| Rig::draft("r.toml", source(parts).as_bytes());
    assert!(refused([DEVICE, BRIDGE, bare, WIRED]).contains("lacks `resistance`"));
    assert_eq!(draft([DEVICE, BRIDGE, bare, WIRED]).unwrap().value.outputs[0].name, "wrist");
    assert!(draft([DEVICE, BRIDGE, "model = \"rumble-motor\"\nrated_volts = -3", WIRED]).is_err());
    assert!(draft([DEVICE, "gain = 0\ncoupling = \"dc\"", COIN, WIRED]).is_err());
    assert!(draft([DEVICE, BRIDGE, "model = \"lra\"", WIRED]).is_err());
    let (known, checked) = (draft([DEVICE, BRIDGE, COIN, WIRED]), source([DEVICE, BRIDGE, COIN, WIRED]));
    assert_eq!(known.unwrap().value, Rig::parse("r.toml", checked.as_bytes()).unwrap().value);
}

/// What every beginner gets wrong, and everything else that keeps a motor from being turned: said before anything plays, with what helps.
#[test]
fn what_cannot_turn_is_refused_with_the_reason() {
    let dc = |text: &str| text.replace("coupling = \"dc\"", "");
    let ac = |text: &str| text.replace("\"dc\"", "{ high_pass = 8 }");
    for (parts, fragments) in [
        (
            [&*ac(DEVICE), BRIDGE, COIN, WIRED],
            ["high-pass at 8 Hz a voltage is at 37 % after 20 ms", "DC-coupled card"],
        ),
        (
            [&*dc(DEVICE), BRIDGE, COIN, WIRED],
            ["not known to let a steady voltage through", "most cards do not"],
        ),
        ([DEVICE, &*ac(BRIDGE), COIN, WIRED], ["`bridge` is an AC amplifier", "turns by a steady voltage"]),
        ([DEVICE, &*dc(BRIDGE), COIN, WIRED], ["`bridge` is not known to let", "audio amplifiers do not"]),
        (
            [DEVICE, BRIDGE, COIN, "amplifier = \"bridge\""],
            ["a drive without an actuator", "[actuator.NAME]"],
        ),
        (
            [DEVICE, BRIDGE, COIN, "actuator = \"motor\""],
            ["a drive without an amplifier", "more current than a card gives"],
        ),
        ([DEVICE, BRIDGE, "model = \"lra\"", WIRED], ["is of model lra", "[[tactor]]"]),
        (
            ["channels = 1\ncoupling = \"dc\"", BRIDGE, COIN, WIRED],
            ["`full_scale_volts` of the device", "hold a meter"],
        ),
        (
            [DEVICE, BRIDGE, "model = \"rumble-motor\"\nrated_volts = 3", WIRED],
            ["lacks `resistance`", "name a part"],
        ),
        (
            [DEVICE, BRIDGE, "part = \"coin-10m\"", WIRED],
            ["which is not among those that ship", "`coin-10mm`"],
        ),
        (
            [DEVICE, BRIDGE, "part = \"coin-10mm\"\nmodel = \"lra\"", WIRED],
            ["but the part `coin-10mm` is of model rumble-motor", "leave `model` out"],
        ),
        (
            [DEVICE, BRIDGE, "part = \"coin-10mm\"\nforce_factor = 1", WIRED],
            ["which has no `force_factor`", "voice-coil, inertial-motor"],
        ),
        (
            [DEVICE, BRIDGE, "part = \"coin-10mm\"\ninertia = 0", WIRED],
            ["`inertia` of actuator `motor` is 0", "from 0.000000000000000001"],
        ),
        (
            [DEVICE, BRIDGE, "part = \"coin-10mm\"\nmass = 2e-4", WIRED],
            ["actuator `motor` cannot be: `mass` is 0.0002", "must be above 0.000296"],
        ),
        (
            [DEVICE, BRIDGE, "part = \"coin-10mm\"\nstatic_friction = 1e-6", WIRED],
            ["`static_friction` is 0.000001", "no less than holds it while it turns"],
        ),
        (
            [DEVICE, BRIDGE, "part = \"coin-10mm\"\ntorque_constant = 300", WIRED],
            ["`inertia` is 1.8e-9, but must be at least", "`torque_constant`, in N m/A, is too large"],
        ),
        (
            [DEVICE, BRIDGE, "part = \"coin-10mm\"\ntime_constant = 5e-5", WIRED],
            ["`time_constant` is 0.00005, but must be at least 0.0001", "no motor is at its speed sooner"],
        ),
        (
            [
                DEVICE,
                BRIDGE,
                "model = \"rumble-motor\"\nrated_volts = 3\ntime_constant = 0.03\nspeed_per_volt = 500\neccentric_per_mass = 7e-6\n\
                 running_volts = 0.5\nstart_volts = 0.2",
                WIRED,
            ],
            ["`start_volts` is 0.2, but must be at least 0.5: in V", "`running_volts`"],
        ),
        ([DEVICE, "gain = 0\ncoupling = \"dc\"", COIN, WIRED], ["has a gain of 0", "nothing reaches"]),
        ([DEVICE, "gain = 0.2\ncoupling = \"dc\"", COIN, WIRED], ["of what turns it at all", "raise"]),
        (
            [DEVICE, BRIDGE, COIN, "actuator = \"motor\"\namplifier = \"bridge\"\nmarker = \"x\""],
            ["only a trigger has `marker`", "of kind drive"],
        ),
    ] {
        let told = refused(parts);
        for fragment in fragments {
            assert!(told.contains(fragment), "{parts:?}: {told}");
        }
    }
    let tactor = "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\n[[output]]\nkind = \"raw\"\nname = \"a\"\nchannel = 1\ntilt = 0\n";
    let told = Rig::parse("r.toml", tactor.as_bytes()).unwrap_err().to_string();
    assert!(told.contains("of kind raw; only a drive has `tilt`"), "{told}");
}
