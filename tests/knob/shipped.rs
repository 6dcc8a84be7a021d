//! Every knob that ships, as its file says it is.

use pacinian::knob::governor::device::{Delay as Late, Device};
use pacinian::knob::governor::{Governor, MARGIN};
use pacinian::knob::plant::Plant;
use pacinian::knob::plant::encoder::{Delay, Encoder};
use pacinian::knob::plant::parameters::Parameters;
use pacinian::knob::plant::parts::{Build, Hand, Shaft};
use pacinian::knob::plant::rotor::Rotor;
use pacinian::rig::Rig;
use pacinian::rig::knob::made::Pace;

const RATE: f64 = 48_000.0;
const BLOCKS: [u32; 6] = [16, 32, 64, 128, 256, 512];

/// Their names, what must be known of each, and its stiction, N m.
fn shipped() -> Vec<(String, Device, f64)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/rigs");
    let names = |folder: &str| -> Vec<String> {
        let all = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
        let mut names: Vec<String> = all.map(|name| name.into_string().unwrap()).collect();
        names.sort();
        names
    };
    let rigs = names(folder).into_iter().filter(|name| name.starts_with("knob") && name.ends_with(".toml"));
    let rigs = rigs.map(|name| (name.clone(), std::fs::read_to_string(format!("{folder}/{name}")).unwrap()));
    let motors = names(&format!("{folder}/knobs")).into_iter().flat_map(|name| {
        let motor = name.strip_suffix(".toml").unwrap().to_string();
        ["drive = \"voltage\"", "drive = \"current\""].map(|drive| {
            let rig = format!(
                "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\nrate = 48000\n[[output]]\nname = \"a\"\nchannel = 1\n\
                 kind = \"torque\"\n[knob]\nmotor = \"{motor}\"\nknob_inertia = 5e-6\nrate = 48000\n{drive}\n"
            );
            (format!("{motor}, {drive}"), rig)
        })
    });
    rigs.chain(motors)
        .map(|(name, text)| {
            let rig = Rig::parse(&name, text.as_bytes()).unwrap_or_else(|why| panic!("{name}: {why}")).value;
            let knob = rig.knob.unwrap_or_else(|| panic!("{name} has no knob"));
            let stiction = knob.build().parameters.stiction;
            let device = knob.device(&Pace::of(RATE));
            assert_eq!(device.low_pass, None, "{name}: what is simulated has none");
            (name, device, stiction)
        })
        .collect()
}

/// An encoder, blocks, and a spring on a knob that a hand pushes; gives the true angle to a watcher until it says stop.
fn simulate(
    d: &Device,
    dry: [f64; 2],
    k: f64,
    hand: f64,
    start: f64,
    mut watch: impl FnMut(u64, f64) -> bool,
) {
    let [coulomb, stiction] = dry;
    let parameters =
        Parameters { inertia: d.inertia, viscous: d.damping, coulomb, stiction, ..Parameters::default() };
    let encoder = Encoder::of_counts((std::f64::consts::TAU / d.count).round()).unwrap();
    let mut line = Delay::new(d.delay.total() as usize, -k * encoder.read(start)).unwrap();
    let mut held = move |angle: f64| line.pass(-k * encoder.read(angle)) + hand;
    let mut plant = Rotor::<false>::new(&parameters, RATE).unwrap();
    plant.place(start, 0.0).unwrap();
    let Some(resonance) = d.resonance else {
        let mut tick = 0;
        while {
            plant.step(held(plant.angle()));
            !watch(tick, plant.angle())
        } {
            tick += 1;
        }
        return;
    };
    // What is told is the motor's, with the shaft clamped at its other end.
    let motor = d.inertia - resonance.knob;
    let stiffness = motor * (std::f64::consts::TAU * resonance.clamped).powi(2);
    let shaft = Shaft { inertia: resonance.knob, viscous: 0.0, stiffness, damping: resonance.loss };
    let parameters = Parameters { inertia: motor, ..parameters };
    let mut plant = Plant::new(&Build { parameters, shaft: Some(shaft), ..Build::default() }, RATE).unwrap();
    plant.place(start, 0.0).unwrap();
    let mut tick = 0;
    while {
        plant.step(held(plant.angle()), &Hand::default());
        !watch(tick, plant.angle())
    } {
        tick += 1;
    }
}

/// The largest of them, worked out by as many threads as there are processors.
fn worst_of(all: Vec<u32>, swing: impl Fn(u32) -> f64 + Sync) -> f64 {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let share = |part: &[u32]| part.iter().map(|n| swing(*n)).fold(0.0, f64::max);
        let parts = all.chunks(all.len().div_ceil(threads));
        let running: Vec<_> = parts.map(|part| scope.spawn(move || share(part))).collect();
        running.into_iter().map(|one| one.join().unwrap()).fold(0.0, f64::max)
    })
}

/// Places within a count, at which it is let go of: twenty, or as many as `PACINIAN_HANDS` says.
fn hands() -> u32 {
    std::env::var("PACINIAN_HANDS").ok().and_then(|hands| hands.parse().ok()).unwrap_or(20)
}

/// At half of what the governor grants it settles within two counts, the worst of all hands; at one and a half times the edge, without its
/// friction, it swings.
#[test]
fn every_knob_that_ships_rests_at_half_its_limit_and_swings_beyond_the_edge() {
    let all = shipped();
    assert!(all.len() >= 8, "{}", all.len());
    for (name, device, stiction) in all {
        // Without damping there is no stiffness that comes to rest, and none is granted.
        if device.damping == 0.0 {
            assert_eq!(Governor::new(&device, MARGIN).unwrap().most_stiffness(0.0), 0.0, "{name}");
            continue;
        }
        for block in BLOCKS {
            let d = Device {
                delay: Late { fixed: 0.0, block, frames: 1.0, blocks: 2.0, local: None },
                ..device.clone()
            };
            let k = 0.5 * Governor::new(&d, MARGIN).unwrap().most_stiffness(0.0);
            let sampled = d.sampled().unwrap();
            let rest = -sampled.growth(k, 0.0);
            assert!(k > 0.0 && rest > 0.0, "{name}, {block}: {k}");
            // By then a third of a count is left of what it starts off by.
            let settle = (3.0 / rest * RATE) as u64;
            let look = (0.3 / rest * RATE) as u64 + (20.0 * RATE * (d.inertia / k).sqrt()) as u64;
            let dry = [d.friction.unwrap_or(0.0), stiction.max(d.friction.unwrap_or(0.0))];
            let swing = |n: u32| {
                // Each at another place within a count, since whole counts more or less are the same again.
                let hand = k * d.count * (f64::from(n) + 0.37) / f64::from(hands());
                let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
                simulate(&d, dry, k, hand, hand / k + 6.0 * d.count, |tick, angle| {
                    if tick >= settle {
                        (low, high) = (low.min(angle), high.max(angle));
                    }
                    tick > settle + look
                });
                (high - low) / d.count
            };
            let worst = worst_of((0..hands()).collect(), swing);
            println!("{name}, block {block}: {k:.2e} N m/rad, {worst:.2} counts, {settle} ticks");
            assert!(worst <= 2.0, "{name}, block {block}: {worst} counts at {k} N m/rad");
            let free = Device { friction: None, ..d.clone() }.sampled().unwrap();
            let k = 1.5 * free.edge(0.0).gain;
            let limit = (3.0 * 60f64.ln() / free.growth(k, 0.0) * RATE) as u64 + 1000;
            for n in 0..5 {
                let hand = k * d.count * f64::from(n) * 0.73;
                let mut far = 0.0f64;
                simulate(&d, [0.0; 2], k, hand, hand / k + 3.0 * d.count, |tick, angle| {
                    far = far.max((angle - hand / k).abs() / d.count);
                    tick > limit || far > 100.0
                });
                assert!(far > 50.0, "{name}, block {block}: {far} counts at {k} N m/rad");
            }
        }
    }
}
