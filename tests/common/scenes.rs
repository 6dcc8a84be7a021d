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
