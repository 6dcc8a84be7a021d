//! Patches that keep an engine busy.

/// Nodes of many kinds, shared ones, an input, a control and a hand in one voice, and a second, plain voice, which a node sets off some 200
/// times a second; so many of either.
pub fn busy(beats: u32, plain: u32) -> String {
    format!(
        r#"
[control.strength]
default = 0.7
range = [0.0, 1.0]
[shared.nodes]
wobble = {{ type = "lfo", rate = 3 }}
ear = {{ type = "input" }}
hiss = {{ type = "white" }}
[voice.beat]
voices = {beats}
output = "out"
[voice.beat.nodes]
tone = {{ type = "sawtooth", frequency = "event.frequency * touch.bend + 20 * wobble" }}
rough = {{ type = "white", amplitude = "1 - 0.5 * touch.pressure" }}
hit = {{ type = "envelope", attack = 0.004, decay = 0.03, sustain = 0.4, release = 0.02 }}
soft = {{ type = "lowpass", input = "tone + 0.2 * rough + ear", cutoff = "400 + 100 * wobble" }}
echo = {{ type = "delay", input = "soft", time = 0.01, longest = 0.05 }}
out = {{ type = "multiply", inputs = ["soft + 0.5 * echo", "hit", "strength"] }}
[voice.plain]
voices = {plain}
output = "tone"
[voice.plain.nodes]
tone = {{ type = "sine", frequency = "event.frequency" }}
[[trigger]]
on = "node.hiss rises 0.8"
play = "plain"
place = 1
hold = 0.003
set = {{ duration = 0.005, level = 0.1 }}
"#
    )
}

/// One of each unit of fundsp in one voice, and a second voice that is a string; so many of either. Strings are tuned at every
/// start.
#[cfg(feature = "fundsp-nodes")]
pub fn leaves(bodies: u32, strings: u32) -> String {
    format!(
        r#"
[voice.body]
voices = {bodies}
output = "out"
[voice.body.nodes]
string = {{ type = "pluck", frequency = "event.frequency" }}
orbit = {{ type = "chaos", frequency = "event.frequency" }}
turn = {{ type = "chaos", frequency = 3, system = "roessler" }}
rumble = {{ type = "brown", corner = "event.frequency" }}
soft = {{ type = "ladder", input = "string + rumble", cutoff = "300 + 100 * orbit", resonance = "0.5 + 0.3 * turn" }}
body = {{ type = "bell", input = "soft", frequency = 180, gain = "6 * turn" }}
hit = {{ type = "envelope", attack = 0.004, release = 0.02 }}
out = {{ type = "multiply", inputs = ["body", "hit"] }}
[voice.string]
voices = {strings}
output = "string"
[voice.string.nodes]
string = {{ type = "pluck", frequency = "event.frequency" }}
"#
    )
}

/// A voice of every other node whose states are copied when a plan takes over, so loud; `hum` stands for a recording.
pub fn every(level: f64) -> String {
    format!(
        r#"
[voice.every]
voices = 12
output = "out"
[voice.every.nodes]
tri = {{ type = "triangle", frequency = 60, amplitude = {level} }}
edge = {{ type = "pulse", frequency = 45, width = 0.3 }}
pink = {{ type = "pink" }}
band = {{ type = "band_noise", low = 80, high = 250 }}
rise = {{ type = "sweep", law = "exponential", from = 40, to = 300, duration = 1.5 }}
scrape = {{ type = "sample", file = "hum", speed = 0.7, loop = true }}
weave = {{ type = "scan", file = "hum", position = "0.01 + 0.001 * tri" }}
swell = {{ type = "breakpoints", points = [{{ at = 0.1, value = 1, shape = "slow" }}, {{ at = 0.5, value = 0.5 }}] }}
ring = {{ type = "decay", time = 0.04 }}
tap = {{ type = "burst", attack = 0.001, decay = 0.03, decay_curve = -4 }}
on = {{ type = "gate", rise = 0.002, fall = 0.002 }}
loud = {{ type = "follow", input = "pink", attack = 0.002, release = 0.1 }}
bell = {{ type = "resonator", input = "tap", frequency = 180, decay = 0.2 }}
less = {{ type = "notch", input = "edge", frequency = 50, q = 10 }}
high = {{ type = "highpass", input = "less", cutoff = 30 }}
mid = {{ type = "bandpass", input = "band", frequency = 150, q = 2 }}
echo = {{ type = "delay", input = "high + 0.3 * echo", time = 0.02, longest = 0.05 }}
both = {{ type = "crossfade", a = "echo", b = "mid", position = "loud" }}
sum = {{ type = "add", inputs = ["tri", "rise", "scrape", "weave", "ring", "bell", "both"] }}
out = {{ type = "multiply", inputs = ["sum", "on", "swell"] }}
"#
    )
}

/// Two motors and a tactor, on three channels: a coin motor, one of a game pad that is wired the other way round, and what vibrates.
pub const MOTORS: &str = r#"
format = "pacinian-rig/1"
title = "Two motors and a tactor"
[device]
channels = 3
full_scale_volts = 5.0
coupling = "dc"
[amplifier.bridge]
gain = 3.0
max_volts = 12.0
coupling = "dc"
[amplifier.turned]
gain = -3.0
coupling = "dc"
[actuator.coin]
part = "coin-10mm"
[actuator.pad]
model = "rumble-motor"
rated_volts = 12.5
resistance = 10.42
inductance = 4.2e-3
torque_constant = 0.011
inertia = 1.15e-7
viscous_friction = 1e-6
coulomb_friction = 6e-4
static_friction = 8e-4
eccentric_moment = 1.38e-5
mass = 0.25
[[output]]
kind = "drive"
name = "coin"
channel = 1
actuator = "coin"
amplifier = "bridge"
[[output]]
kind = "drive"
name = "pad"
channel = 3
actuator = "pad"
amplifier = "turned"
shaping = "overdrive"
[[tactor]]
name = "skin"
channel = 2
"#;

/// What may be done to motors: a click, a thump backward, a spin, a switch, a brake, and an envelope.
pub const MOVES: &str = r#"
[voice.click]
output = "tap"
[voice.click.nodes]
tap = { type = "drive-click" }
[voice.thump]
output = "tap"
[voice.thump.nodes]
tap = { type = "drive-click", turns = -1.5 }
[voice.spin]
output = "buzz"
[voice.spin.nodes]
buzz = { type = "drive-spin" }
[voice.switch]
output = "on"
[voice.switch.nodes]
on = { type = "drive-on" }
[voice.stop]
output = "stop"
[voice.stop.nodes]
stop = { type = "drive-brake" }
[voice.swell]
output = "hit"
[voice.swell.nodes]
hit = { type = "envelope", attack = 0.2, decay = 0.1, sustain = 0.6, release = 0.1 }
"#;
