//! The patch format for people: its topics in the order in which one learns them.

use super::{control, event, motion, node, pattern, trigger, voice, way};
use crate::text::reference::{Defined, Topic};

/// What stands where a key refers to something with a topic of its own.
pub const DEFINED: Defined = &[
    ("format", "\"pacinian-patch/1\""),
    ("place", "a place: \"top\", 3, [0, -0.2], [\"a\", \"b\"] or a path"),
    ("points", "points in metres: [[0, 0], [0.1, 0]]"),
    ("times", "a list of seconds, one for each point"),
    ("places", "a list of places: [\"left\", 3, [0.1, 0], [\"a\", \"b\"]]"),
    ("range", "[least, most]"),
    ("notes", "two notes: [36, \"D#3\"]"),
    ("set", "a table of numbers and expressions"),
    ("events", "a list of events, or \"FILE.csv\""),
    ("nodes", "nodes by name"),
    ("signal", "a number, or an expression of shared nodes, controls and `knob.speed`"),
    ("numbers", "a list of numbers"),
    ("curve", "pairs of an angle and a torque: [[-0.5, 0.02], [0.5, -0.02]]"),
    ("shape", "`linear`, `slow`, `fast`, `exponential` or a number, -20 to 20"),
];

/// All topics.
pub const TOPICS: &[Topic] = &[
    Topic {
        name: "patch",
        written: "",
        doc: "A TOML file that says what is felt and when.",
        text: "Voices are what is felt: each is a graph of nodes. Patterns are when: lists of events in time. Without a trigger, the first \
               pattern plays; `--pattern NAME` plays another.\n\n\
               An event needs to say little: without more it has level 1, lasts 0.1 s, has a frequency of 250 Hz and is felt on the first \
               tactor.\n\n\
               Numbers have no unit in them. Frequencies are in Hz, times in seconds (or beats), positions in metres, shares from 0 to 1. \
               Texts stand in quotes.\n\n\
               A table is written with its name, [voice.tap]; a list of tables one by one, [[trigger]].",
        tables: &[&super::TABLE],
        example: "format = \"pacinian-patch/1\"\n\
                  title = \"A tap\"\n\
                  \n\
                  [voice.tap]\n\
                  output = \"felt\"\n\
                  \n\
                  [voice.tap.nodes]\n\
                  tone = { type = \"sine\", frequency = \"event.frequency\" }\n\
                  hit = { type = \"envelope\", attack = 0.004, decay = 0.08, sustain = 0 }\n\
                  felt = { type = \"multiply\", inputs = [\"tone\", \"hit\"] }\n\
                  \n\
                  [pattern.walk]\n\
                  events = [\n\
                  \x20 { at = 0.0, voice = \"tap\", place = \"t1\" },\n\
                  \x20 { at = 0.3, voice = \"tap\", place = \"t2\", frequency = 120 },\n\
                  ]",
    },
    Topic {
        name: "voice",
        written: "[voice.NAME]",
        doc: "What is felt: a node graph that sounds once for every event.",
        text: "`output` names the node that is felt. The level of the event multiplies it: no node has to. Under `defaults` stands what an \
               event has that says nothing, and further fields of one's own, 8 at most with `frequency`; nodes read them all as event.NAME.\n\n\
               A voice sounds until its envelopes have ended after the release, which comes `duration` after the onset, and then for \
               `tail`. If more events come than `voices`, one fades for the new one: of those released the quietest, else the oldest.",
        tables: &[&voice::TABLE, &voice::DEFAULTS],
        example: "[voice.growl]\n\
                  voices = 4\n\
                  output = \"felt\"\n\
                  place = \"t3\"\n\
                  tail = 0.1\n\
                  defaults = { level = 0.6, duration = 0.5, frequency = 80, depth = 20 }\n\
                  \n\
                  [voice.growl.nodes]\n\
                  wobble = { type = \"sine\", frequency = 6 }\n\
                  tone = { type = \"sine\", frequency = \"event.frequency + event.depth * wobble\" }\n\
                  edge = { type = \"envelope\", attack = 0.01, release = 0.05 }\n\
                  felt = { type = \"multiply\", inputs = [\"tone\", \"edge\"] }",
    },
    Topic {
        name: "node",
        written: "NAME = { type = \"...\", ... } under [voice.NAME.nodes] or [shared.nodes]",
        doc: "A building block of a voice: an oscillator, an envelope, a filter, a sum.",
        text: "Which types there are and what they take, `pacinian nodes` lists; `pacinian nodes sine` explains one.\n\n\
               A parameter is a number, the name of another node or of a control, or an expression of them. That is all the wiring there is. \
               The name of a node is a letter, then letters, digits and `_`.\n\n\
               Nodes of a voice must not read each other in a circle, except through the input of a `delay`.",
        tables: &[],
        example: "[voice.buzz]\n\
                  output = \"felt\"\n\
                  \n\
                  [voice.buzz.nodes]\n\
                  tone = { type = \"sine\", frequency = 250 }\n\
                  edge = { type = \"envelope\", attack = 0.01, release = 0.05 }\n\
                  felt = { type = \"multiply\", inputs = [\"tone\", \"edge\"] }",
    },
    Topic {
        name: "point",
        written: "points = [{ at, value, shape }, ...]",
        doc: "A breakpoint of the node `breakpoints`.",
        text: "`shape` is that of the way from the point before: `linear`, `slow` (starts slowly), `fast` (starts fast), `exponential` \
               (faster still), or a number, 0 for linear, more than 0 to start slowly, less than 0 to start fast.",
        tables: &[&node::POINT],
        example: "[voice.swell]\n\
                  output = \"felt\"\n\
                  \n\
                  [voice.swell.nodes]\n\
                  tone = { type = \"sine\", frequency = 200 }\n\
                  rise = { type = \"breakpoints\", points = [{ at = 0.5, value = 1, shape = \"slow\" }, { at = 0.8, value = 0 }] }\n\
                  felt = { type = \"multiply\", inputs = [\"tone\", \"rise\"] }",
    },
    Topic {
        name: "expression",
        written: "\"60 + 20 * wobble\"",
        doc: "A short sum in quotes wherever a parameter of a node may stand.",
        text: "It has numbers, + - * / and parentheses, names of nodes and controls, fields of the event (event.level, event.duration, \
               event.frequency and those that the voice declares under `defaults`), what the hand does that holds the voice (touch.bend, \
               touch.pressure, touch.timbre), what the knob does (knob.angle in rad, knob.speed in rad/s, knob.torque in N m; knob.detent, 1 or -1 in the very sample in which a notch is passed, and knob.wall, the speed in rad/s with which a wall is hit in that sample, else 0), and these functions:\n\n\
               - `min(a, b)`: the lesser of two\n\
               - `max(a, b)`: the greater of two\n\
               - `clamp(x, least, most)`: x, but no less and no more than those\n\
               - `abs(x)`: x without its sign\n\
               - `floor(x)`: the greatest whole number that is not greater\n\
               - `sqrt(x)`: the square root\n\
               - `pow(base, exponent)`: a power\n\
               - `exp(x)`: e to the power x\n\
               - `log(x)`: the natural logarithm\n\
               - `sin(x)`: the sine of an angle in radians\n\n\
               A hand is a note of MIDI, or a program: touch.bend is the ratio by which it bends the frequency, 1 at rest; \
               touch.pressure goes from 0, at rest, to 1, and touch.timbre from 0 to 1, 64/127 at rest. They take 10 ms to each new value; \
               the node `touch` takes as long as it is told. MPE speaks of each note apart, a wheel of all notes of its channel.\n\n\
               What a node reads at the onset alone (kind \"at onset\" in `pacinian nodes NAME`) may be made of numbers and fields of the \
               event only. 1,000 characters are the most.",
        tables: &[],
        example: "[voice.buzz]\n\
                  output = \"felt\"\n\
                  defaults = { bend = 0.3 }\n\
                  \n\
                  [voice.buzz.nodes]\n\
                  wobble = { type = \"sine\", frequency = 5 }\n\
                  edge = { type = \"envelope\", attack = \"max(0.01, event.duration / 4)\", release = 0.05 }\n\
                  tone = { type = \"sine\", frequency = \"event.frequency * (1 + event.bend * wobble)\" }\n\
                  felt = { type = \"multiply\", inputs = [\"tone\", \"edge\", \"min(1, event.level * 2)\"] }",
    },
    Topic {
        name: "felt",
        written: "felt = 20",
        doc: "How strongly something is felt, in dB above the threshold, in place of a level.",
        text: "An event, the defaults of a voice or `set` of a trigger say it in place of `level`: 0 is just felt, 20 is ten times that amplitude. Every tactor then \
               gets what it takes of it: the displacement is that of the threshold at its site, under its contactor, at that frequency, and 20 dB more, by its \
               calibration ([calibration.NAME] of the rig). So what is played on tactors that are unlike, on a fingertip and on an arm, is felt alike, as far as \
               thresholds are known: for an average of adults up to 250 Hz within 6 dB on the hand and 12 dB elsewhere, 3 dB more under a contactor below 0.02 or above 5 cm², and \
               9 dB more at 1000 Hz, as slopes above 250 Hz are a judgement and nothing was at hand above 600 Hz. One person differs by some 5 to 10 dB (a judgement). \
               Curves, sources and errors: docs/felt.md.\n\n\
               Thresholds hold for tones of about 1 s. Above some 60 Hz shorter ones are felt weaker, and `felt` does not make up for it: one of 0.1 s likely by 4 to 10 dB. \
               `pacinian check` says by how much, where an event is shorter than 0.5 s.\n\n\
               It holds at `felt_at` of the voice, else at the frequency of the event, which the voice must read then (event.frequency); and for a voice whose output is a sine of \
               amplitude 1: what its nodes make of that, an envelope or half the amplitude, comes on top, and so do the gain of a pattern and jitter of \
               `level`. Of what is no tone it is as true as its strongest part is.\n\n\
               At a position that several tactors share, the law of the voice divides what is felt: with `energy` the sum of the squares stays, each as a ratio to its \
               own threshold.\n\n\
               What a tactor cannot give is capped: where the limiter still lets a tone pass as it is (0.9 of its `max_level` up to 475 Hz, 0.69 at 800 Hz, nearly nothing at 950 Hz), and at what amplifier and \
               actuator bear. `pacinian check` says by how many dB, of paths and bursts too, and who was not measured. Between the points of a table it is straight in dB over the logarithm of \
               the frequency; beyond them, and beyond 10 to 1000 Hz, an event is refused, and a frequency that wanders there (jitter) is felt as at the \
               end.\n\n\
               A tactor without a calibration is relative: a level of 1 at 250 Hz counts for 40 dB, whatever it really is, and other frequencies follow the threshold \
               of its site and the model of its actuator; without a model it is taken to give the same acceleration for each volt at all of them.\n\n\
               `felt` counts dB above the threshold, and no strength: how fast that grows depends on the frequency, and measurements disagree by more than \
               an equal strength would gain.",
        tables: &[],
        example: "[voice.alert]\n\
                  output = \"felt\"\n\
                  felt_at = 250\n\
                  defaults = { felt = 20, duration = 0.3 }\n\
                  \n\
                  [voice.alert.nodes]\n\
                  tone = { type = \"sine\", frequency = 250 }\n\
                  edge = { type = \"envelope\", attack = 0.02, release = 0.05 }\n\
                  felt = { type = \"multiply\", inputs = [\"tone\", \"edge\"] }\n\
                  \n\
                  [pattern.two]\n\
                  events = [\n\
                  \x20 { at = 0, voice = \"alert\", place = \"t1\" },\n\
                  \x20 { at = 1, voice = \"tap\", place = \"t2\", frequency = 80, felt = 12 },\n\
                  ]",
    },
    Topic {
        name: "place",
        written: "place = \"top\", place = 3, place = [0, -0.2], place = [\"left\", \"right\"] or place = { path = [[0, 0], [0.1, 0]] }",
        doc: "Where on the body.",
        text: "- a name: the tactor or the group of the rig that is called so; on each tactor of a group it has the whole level\n\
               - a whole number: what hangs on that channel of the device, from 1\n\
               - two or three numbers: a position in metres, which the tactors about it share\n\
               - a list of names: all of those, each with the whole level\n\
               - a path, { path = [[x, y], ...] }: the voice goes along it, shared all the way by the tactors about it. It takes as long as its \
               event, or `over` seconds, whatever the pattern's time and rate; an event that is held, and says no `over`, takes one second\n\n\
               How a position is shared, the `law` and the `width` of the voice say. Of tactors in a line the two neighbours share it: the way from \
               one to the other is divided at β, and their weights are 1 − β and β. Of tactors in a plane, or a gently curved sheet, the corners of a \
               rectangle share what lies within by their parts of the way across and up, and elsewhere the corners of the triangles between them; of \
               any others those nearby, the nearer the more. The law makes gains of weights: √w (`energy`, which keeps the power), \
               log₂(1 + w) (`logarithmic`), w (`linear`), or all for the nearest (`nearest`). A `width` is the standard deviation of a Gaussian of weights about \
               the position (so of the power by the energy law, whose gains reach 1.4 times as far); up to half of the tactors' spacing it goes over from the neighbours alone. What lies beside the tactors sounds at the nearest point \
               between them. Where no tactor is at a position that two share, it is felt in between: the phantom sensation.\n\n\
               A node `place` moves its voice by what other nodes and controls say: `pacinian nodes place`.\n\n\
               Without a rig there is a line of tactors `t1`, `t2`, ... on channels 1, 2, ..., 40 mm apart: 8, or as many as the patch \
               names.",
        tables: &[&way::TABLE],
        example: "[pattern.around]\n\
                  events = [\n\
                  \x20 { at = 0.0, voice = \"tap\", place = \"t2\" },\n\
                  \x20 { at = 0.2, voice = \"tap\", place = 3 },\n\
                  \x20 { at = 0.4, voice = \"tap\", place = [0.12, 0.0] },\n\
                  \x20 { at = 0.6, voice = \"tap\", place = { path = [[0.0, 0.0], [0.12, 0.0]], over = 0.5 } },\n\
                  ]",
    },
    Topic {
        name: "motion",
        written: "stroke = { ... }, apparent = { ... } or saltation = { ... } in an event",
        doc: "Illusions of motion: one event that is several bursts of its voice, timed so that something is felt to move.",
        text: "In place of `place`, an event of a voice may have one of these. Each burst is the voice with all that the event says, at a place and for a time of its \
               own:\n\n\
               - `stroke`: something moves along a path, over a line or a grid of tactors (Tactile Brush; Israr and Poupyrev, 2011). Where the path crosses the \
               edges between tactors, a burst is felt between them, and the next begins before it is over. It takes as long as the event, or `over`, or has `times`\n\
               - `apparent`: bursts at two places or more, one after the other, from each to the next 0.32 of its duration and 47.3 ms. They take as long as the event, \
               or each of them as long as `burst`\n\
               - `saltation`: the cutaneous rabbit (Geldard and Sherrick, 1972), short taps that seem to hop where nothing touches. Where nothing is said, five of 2 ms at each place, \
               50 ms apart (40 to 80 ms as reported), also where the place changes\n\n\
               `pacinian check` says where a stroke is too fast for its tactors, and where bursts are shorter or longer than what the law of onsets is told to be measured for, about 40 to 200 ms. \
               Seconds are seconds at the tempo and the rate of their pattern; another pattern that plays it faster has all of it faster. `jitter` moves all bursts \
               as one, and leaves their durations.\n\n\
               Bursts that overlap on a tactor add up as waves do, and may weaken each other there. A voice that declares the fields `since` and `burst` hears in them \
               how many seconds after the event a burst begins, and how many came before it. With `burst * burst / 4` in its phase, every other burst is a quarter of a \
               wave further: then two that follow each other add up as powers, the first and the third, where so many overlap, as waves in step, and none cancel.",
        tables: &[&motion::APPARENT, &motion::SALTATION],
        example: "[voice.brush]\n\
                  voices = 16\n\
                  output = \"felt\"\n\
                  defaults = { frequency = 200, since = 0, burst = 0 }\n\
                  \n\
                  [voice.brush.nodes]\n\
                  tone = { type = \"sine\", frequency = \"event.frequency\", phase = \"event.frequency * event.since + event.burst * event.burst / 4\" }\n\
                  edge = { type = \"envelope\", attack = 0.01, release = 0.02 }\n\
                  felt = { type = \"multiply\", inputs = [\"tone\", \"edge\"] }\n\
                  \n\
                  [pattern.show]\n\
                  events = [\n\
                  \x20 { at = 0, voice = \"brush\", stroke = { path = [[0, 0], [0.1, 0]], over = 1.0 } },\n\
                  \x20 { at = 2, voice = \"brush\", apparent = { places = [1, 2, 3], burst = 0.1 } },\n\
                  \x20 { at = 3, voice = \"brush\", saltation = { places = [1, 3] } },\n\
                  ]",
    },
    Topic {
        name: "pattern",
        written: "[pattern.NAME]",
        doc: "Events in time.",
        text: "Times are counted in seconds, or with time = \"beats\" in beats of `tempo` a minute, durations too.\n\n\
               With clock = \"midi\" a pattern plays when a sequencer's song does: start, stop, continue and song position move it, and its \
               beats, durations too, are those of the MIDI clock, jitter taken out. What it plays moves with it, and is released where the song stops or jumps. Where a trigger plays it \
               while that song runs, it joins in at once; while none runs, and in a rendering without --midi, it has its own tempo. Of \
               several ports, the one counts whose song runs; another may start one when that stands. With \
               --midi, the tempo of that song counts.\n\n\
               A pattern that repeats without `times` goes on for ever; then no other pattern can play it. `every` is counted from \
               one beginning to the next.\n\n\
               `shuffle` draws anew each time the pattern plays; `jitter` for each event each time. What is drawn follows from the seed: the \
               same seed gives the same.",
        tables: &[&pattern::TABLE, &event::REPEAT, &pattern::JITTER],
        example: "[pattern.rain]\n\
                  time = \"beats\"\n\
                  tempo = 90\n\
                  shuffle = true\n\
                  jitter = { at = 0.05, level = 0.3 }\n\
                  repeat = { every = 4, times = 3 }\n\
                  events = [{ at = 0, voice = \"tap\" }, { at = 1.5, voice = \"tap\", level = 0.4 }, { at = 3, voice = \"tap\" }]",
    },
    Topic {
        name: "event",
        written: "{ at = 0.5, voice = \"tap\" } in the `events` of a pattern",
        doc: "Something that happens: a voice, another pattern, a marker, or a choice among them.",
        text: "It has exactly one of `voice`, `pattern`, `marker` and `choose`. What goes with them:\n\n\
               - with `voice`: `level` or `felt`, `duration`, `place`, `frequency` and any field that the voice declares\n\
               - with `pattern`: `gain` and `rate`\n\
               - with `choose`: nothing; the alternatives have those keys themselves, and a `weight`\n\n\
               `delay` differs from `at` in one thing: a shuffle permutes what lands on the `at`s of a pattern, and the delay goes with what \
               it belongs to. `repeat` must say how many `times`.",
        tables: &[&event::TABLE, &event::ALTERNATIVE],
        example: "[pattern.many]\n\
                  events = [\n\
                  \x20 { at = 0.0, voice = \"tap\", level = 0.6, duration = 0.1, place = \"t2\", frequency = 180 },\n\
                  \x20 { at = 1.0, voice = \"tap\", delay = 0.02, repeat = { every = 0.25, times = 4 } },\n\
                  \x20 { at = 2.0, pattern = \"other\", gain = 0.5, rate = 2 },\n\
                  \x20 { at = 3.0, marker = \"trial 1\" },\n\
                  \x20 { at = 4.0, choose = [{ voice = \"tap\", weight = 3 }, { pattern = \"other\" }] },\n\
                  ]\n\
                  \n\
                  [pattern.other]\n\
                  events = [{ at = 0, voice = \"tap\" }]",
    },
    Topic {
        name: "table",
        written: "events = \"FILE.csv\"",
        doc: "A file of events, one a line, for patterns too long to write into a patch.",
        text: "The first line names the columns: `at` and `voice` or `marker`, and as one likes `level`, `duration`, `place`, `delay`, \
               `frequency` and other fields of the voices. Cells are divided by commas and may stand in double quotes; an empty cell is \
               as if it were not there. A place is a name, a channel, or two or three coordinates with blanks between them. Lines need \
               not be in the order of time; those that begin with # count for nothing.\n\n\
               at,voice,level,place\n\
               0.0,tap,0.5,t1\n\
               0.4,tap,,0.12 0.0",
        tables: &[],
        example: "[pattern.walk]\n\
                  events = \"footsteps.csv\"",
    },
    Topic {
        name: "control",
        written: "[control.NAME]",
        doc: "A live parameter, which nodes read by its name and a program may move while the patch plays.",
        text: "In a rendering it stays at its default, or where `--set NAME=VALUE` put it, unless a `[[bind]]` and `--midi` move it.",
        tables: &[&control::TABLE],
        example: "[control.strength]\n\
                  default = 0.5\n\
                  range = [0, 1]\n\
                  unit = \"of full\"\n\
                  smoothing = 0.02",
    },
    Topic {
        name: "shared",
        written: "[shared.nodes]",
        doc: "Nodes that run once for the whole engine and that every voice may read.",
        text: "They belong to no event, so they cannot read event.NAME.",
        tables: &[&super::SHARED],
        example: "[shared.nodes]\n\
                  breath = { type = \"lfo\", rate = 0.2, low = 0.3 }",
    },
    Topic {
        name: "trigger",
        written: "[[trigger]]",
        doc: "What starts a voice or a pattern.",
        text: "`on` is one of these:\n\n\
               - start: the beginning. Where any trigger says so, only those patterns play by themselves\n\
               - node.NAME rises 0.3, node.NAME falls 0.3: a shared node, or a control, passes a threshold; `set` may read `value`, which is \
               the threshold\n\
               - midi.note: a note begins; `set` may read `note`, `pitch` (its frequency in Hz, with its bend unless the voice reads \
               touch.bend by itself), `velocity`, `channel`, and how it is bent and pressed then: `bend` (semitones), `pressure` and `timbre` \
               (0 to 1)\n\
               - midi.program 3: program 3 is chosen, of those from 0 to 127 as they are sent (many instruments show one more); `set` may read `program` and `channel`\n\
               - midi.controller 80 rises 0.5, or falls: a controller, 0 to 119, passes a position from 0 to 1; `set` may read `value` and \
               `channel`. What it means to others it then means no more, as for a `[[bind]]`\n\
               - osc./address: a message to that address; `set` may read `value`, its first number, or 1 where it has none. Where `set` does not, a 0 \
               sets off nothing, which surfaces send when a button is let go\n\
               - key.1: a key of the computer, from 1\n\
               - knob.detent, knob.wall: a knob passes a notch, runs into a wall; knob.wall ENDS for that effect alone. `set` may read `angle` \
               (rad), `speed` (rad/s, without a sign), `way` (1 or -1) and, of a notch, `index`, counted from the one at rest. A voice begins \
               at the tick of the servo that felt it\n\n\
               A note sounds as long as its key or the pedal holds it, unless `set` gives it a `duration`; its velocity is its level, unless \
               `set` gives it a `level`: so a curve is written, `level = \"pow(velocity, 0.5)\"` for a soft hand, with 2 in its place for a hard one, and \
               `\"0.2 + 0.8 * velocity\"` where the softest touch is to be felt. Of a pattern, `set` gives `gain` and `rate`. A pattern that ends plays to its end; one that repeats \
               without `times` plays as long as the key or the pedal holds it, and where no key does, the next hit begins it anew. At most \
               256 patterns play at a time.\n\n\
               A voice that a node or a knob sets off is begun by the engine itself. A pattern has to be told first, so it begins a fixed time after \
               the threshold, the notch or the wall: 10 ms and one block of the card, 256 frames where nobody says how long that is \
               (15.4 ms at 48 kHz in a rendering, 11.4 ms with --block 64). `pacinian check` and `pacinian knob` say how long. However long the card's \
               calls are, it is always as long; should the machine be too late for that, the pattern's first events are played as soon as may be, \
               and counted as late. What is to be felt at once is a voice of its own.\n\n\
               Controllers 120 (all sound off) and 123 (all notes off, which 124 to 127 imply) are a panic, pedals or not, and not the note-offs \
               that the standard has for 123, since panic buttons send it: each \
               silences what its channel has started, voices that die away and patterns included, and a reset what its port has started: to exact zeros within 5 ms where \
               nothing else sounds, and else to less than a hundredth of what it was within 5 ms up to 200 Hz, 10 at 500 and 30 at 800, as the band limit \
               rings near its edge. Voices that are always on, what plays from the beginning and what other ports, keys or programs have \
               started go on. A cable that had promised to stay (active sensing) and says nothing for 0.33 s is more than that: nobody is left who \
               could stop what it plays. It shuts the whole output, as the key p does in `pacinian play`, until somebody opens it.\n\n\
               A node is looked at sample by sample, at the engine's rate. Where one sample lies short of the threshold and the next on it or \
               beyond, the instant is where a straight line between the two passes it, and the voice begins 8 samples of the engine after \
               that, 1 ms at 8000 Hz: always the same, however the card asks for its frames. To set off a voice again it must have come \
               back, below the threshold for one that rises, or as far as `rearm`; within `hold` seconds of an onset nothing is set off \
               again, which keeps the tremble of a sensor from many onsets. Where it stands at the beginning, or as another text of the \
               patch takes over, sets nothing off. A value that is no number sets nothing off, and a node that never moves is left out. \
               More than 1024 voices in 8 ms are not set off: the rest is counted as dropped.\n\n\
               In `pacinian play` and with `--midi`, no pattern begins by \
               itself in a patch that has triggers, but those with start, unless all of them are set off by nodes or a knob and play voices. Where one of \
               those plays a pattern, none begins by itself anywhere.",
        tables: &[&trigger::TABLE],
        example: "[shared.nodes]\n\
                  breath = { type = \"lfo\", rate = 0.5 }\n\
                  \n\
                  [[trigger]]\n\
                  on = \"node.breath rises 0.3\"\n\
                  play = \"tap\"\n\
                  place = \"t2\"\n\
                  hold = 0.05\n\
                  set = { frequency = 80, level = 0.5 }",
    },
    Topic {
        name: "bind",
        written: "[[bind]]",
        doc: "What moves a control from outside.",
        text: "`from` is one of these:\n\n\
               - midi.controller 21: a controller, 0 to 119; of a pair of 14 bits the lower number, from 0 to 31. One from 32 to 63 that is \
               named itself is a controller of 7 bits of its own, and then its partner has 7 bits too\n\
               - midi.bend, midi.pressure: the wheel, and how hard keys are pressed\n\
               - osc./address: the first number of a message; osc./address 2 is its second, of a pad or a tracker that says several at once; a text among \
               them takes a place, and moves nothing. They go from 0 to 1, or as far as `sends` says: sends = [-0.5, 0.5]\n\n\
               A controller that a binding or a trigger names has no other meaning on its channel: 64 and 66 are then no pedals that hold \
               notes, 0 and 32 choose no bank, and 6, 38 and 96 to 101 no numbered parameter. Timbre (74) stays timbre as well. Numbered \
               parameters (NRPN, RPN) move nothing but the bend range and the zones of MPE: their values are counted and told.\n\n\
               With `pickup` a fader moves its control only from where that stands. Each port and channel has its own; where a port was away, its faders are picked up anew. What a reset, or a cable that is gone, puts back to rest (wheel, pressure; of a reset controllers 1 and 11 too) goes there with what it moves, if that is in hand. Turn it off for a wheel that comes back to its rest. A control that \
               is a stream has none.\n\n\
               An endless knob may tell steps in place of positions, in one of three ways, which its editor or `pacinian learn` says: \
               twos-complement (1 is a step up, 127 one down), binary-offset (65 and 63) or signed-bit (1 and 65). With `encoder` it moves its \
               control on from where that stands, whoever moved it before, by `step` of the range for each.",
        tables: &[&super::bind::TABLE],
        example: "[control.strength]\n\
                  default = 0.8\n\
                  \n\
                  [[bind]]\n\
                  from = \"midi.controller 7\"\n\
                  control = \"strength\"\n\
                  range = [0.1, 1]\n\
                  \n\
                  [[bind]]\n\
                  from = \"midi.controller 16\"\n\
                  encoder = \"twos-complement\"\n\
                  control = \"strength\"",
    },
    Topic {
        name: "knob",
        written: "[knob.effects]",
        doc: "What a force-feedback knob feels like: effects whose torques add up.",
        text: "Each effect has a `type`, and the keys of that type; `gain` and `shift` go with any:\n\n\
               - spring: -K (angle - centre). stiffness, centre\n\
               - damper: -B times the speed. damping\n\
               - wall: pushes where the angle is beyond `angle`, and never pulls. angle, side, stiffness, damping\n\
               - end-stops: two walls. low, high, stiffness, damping\n\
               - detents: so many notches a turn. count, torque (the strongest pull), centre, shape or table, hysteresis\n\
               - snap: a spring to the nearest of places `width` apart. width, stiffness, torque (the most), point, centre\n\
               - magnet: a pull to an angle, smooth everywhere. centre, stiffness, reach\n\
               - friction: dry friction, of displacement alone. torque, stretch, law\n\
               - inertia: a flywheel behind a spring and a damper. inertia, stiffness, damping (critical where nothing is said)\n\
               - constant: a torque. torque\n\
               - spin: a pull to a speed, so that it turns by itself. speed, damping, torque (the most)\n\
               - ripple: a sine over the angle. torque, wavelength\n\
               - texture: a signal times a torque. torque, signal\n\
               - table: torque over angle, point by point. points\n\
               - contact: a round body in the way (Hertz). angle, side, factor, torque (the most)\n\
               - transient: a ringing as a wall is hit, as strong as that was fast. strength, frequency, decay, least, torque (the most)\n\n\
               Angles are in rad, positive torques turn to larger angles. The servo runs at some 8 kHz on the engine's clock, whatever the card's \
               blocks are, and nodes read knob.angle, knob.speed, knob.torque, knob.detent and knob.wall of that very sample: the last two are clicks for what rings or remembers, such as a resonator. What the patch sends the other way, `gain`, \
               `shift` and `signal`, is expressions of shared nodes and controls, and half a millisecond late (4 samples of the engine). The signal \
               \"voices\" is what is played at the knob's output: a voice with place = \"NAME\" of an output of kind torque is felt in the fingers.\n\n\
               However stiff it is written, a governor lets the knob have no more than it bears at its rate, delay, friction and encoder: half of what makes it swing. \
               `pacinian knob PATCH` says how much that is, what binds, and what would lift it.\n\n\
               The rig says what the knob is. Where it says nothing, a small one is simulated, and the control `hand`, which such a patch has by \
               itself, is the angle of the hand that holds it: move it by keys, MIDI or OSC.",
        tables: &[&super::knob::TABLE, &super::knob::EFFECT],
        example: "[knob.effects]\n\
                  notches = { type = \"detents\", count = 24, torque = 0.01 }\n\
                  ends = { type = \"end-stops\", low = -2.5, high = 2.5, stiffness = 0.3 }\n\
                  \n\
                  [[trigger]]\n\
                  on = \"knob.detent notches\"\n\
                  play = \"tap\"\n\
                  set = { level = \"min(1, speed / 10)\" }",
    },
    Topic {
        name: "render",
        written: "[render]",
        doc: "How to render the patch where the person says nothing else.",
        text: "What the command line says goes before it.",
        tables: &[&super::RENDER],
        example: "[render]\n\
                  duration = 10\n\
                  seed = 7\n\
                  tail = 0.5",
    },
];
