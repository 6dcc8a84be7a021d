//! The rig format for people: its topics in the order in which one learns them.

use super::{actuator, amplifier, calibration, device, even, group, knob, output};
use crate::text::reference::{Defined, Topic};

/// What stands where a key refers to something with a topic of its own.
pub const DEFINED: Defined = &[
    ("format", "\"pacinian-rig/1\""),
    ("position", "[x, y] or [x, y, z]"),
    ("names", "[\"thumb\", \"index\"]"),
    ("polarity", "1, -1 or \"invert\""),
    ("site", "`thenar`, `fingertip`, `palm`, `wrist`, `forearm`, `shoulder`, `torso` or `ankle`"),
    ("date", "a day: 2026-03-14"),
    ("table", "[[Hz, output], ...] or \"FILE.csv\""),
    ("coupling", "\"dc\" or { high_pass = 8.0 }"),
    ("harmonics", "a list: [{ periods = 7, amplitude = 0.002, phase = 0 }]"),
    ("torque output", "{ name = \"knob\", newton_metres = 0.15 }"),
];

/// All topics.
pub const TOPICS: &[Topic] = &[
    Topic {
        name: "rig",
        written: "",
        doc: "A TOML file that says which tactor hangs on which channel, and where on the body it sits.",
        text: "It is given with `--rig`: `pacinian render PATCH --rig RIG -o OUT.wav`. Only the device and a [[tactor]] for each channel \
               are needed. A list of tables is written one by one: [[tactor]] before each tactor, [[output]] before each output.",
        tables: &[&super::TABLE],
        example: "format = \"pacinian-rig/1\"\n\
                  title = \"Two on a wrist\"\n\
                  \n\
                  [device]\n\
                  channels = 2\n\
                  \n\
                  [[tactor]]\n\
                  name = \"inside\"\n\
                  channel = 1\n\
                  position = [0.0, 0.025]\n\
                  \n\
                  [[tactor]]\n\
                  name = \"outside\"\n\
                  channel = 2\n\
                  position = [0.0, -0.025]",
    },
    Topic {
        name: "device",
        written: "[device]",
        doc: "The sound card.",
        text: "`rate` may be left out; then `--rate` says it, or it is 48,000 Hz.\n\n\
               Most cards let nothing through below some 5 to 20 Hz: coupling = { high_pass = 15.0 }; say coupling = \"dc\" if yours lets steady \
               voltages through. Where nothing is said, `play` takes a card to do so, the virtual one too, and `render` takes it not to. A coil that holds one does not move and gets hot, so every tactor then has a high-pass at 1 Hz, unless it \
               says dc = true. It is of first order, far below what is felt as vibration: at 20 Hz it takes away 0.011 dB and turns by 2.9°, at \
               250 Hz it makes envelopes 2.5 µs later; of a voltage that stays, 37 % is left after 0.16 s and -80 dB after 1.5 s. \
               Outputs of kind `raw` and `trigger` are declared for steady voltages by their kind.\n\n\
               `max_level` is the most that leaves any output, as a share of full scale (of `full_scale_volts`, if that is known). \
               See [[output]].",
        tables: &[&device::TABLE, &device::COUPLING],
        example: "[device]\n\
                  channels = 8\n\
                  rate = 48000\n\
                  full_scale_volts = 1.0\n\
                  coupling = \"dc\"\n\
                  max_level = 0.5",
    },
    Topic {
        name: "tactor",
        written: "[[tactor]]",
        doc: "An output for vibration.",
        text: "Events find it by its `name`, by its `channel` or by that of a [group.NAME] it is in. What is played at a position, in metres from wherever the origin was put, is shared by the tactors about it that have a `position`. On a body, x goes to the wearer's right, y up and z ahead: docs/body.svg \
               draws it, with the tactors of `pacinian rig new`. What is done to what \
               goes out, and in which order, stands at [[output]].",
        tables: &[&output::TACTOR],
        example: "[device]\n\
                  channels = 2\n\
                  \n\
                  [[tactor]]\n\
                  name = \"top\"\n\
                  channel = 2\n\
                  position = [0.0, 0.1]\n\
                  gain = 0.8\n\
                  polarity = -1\n\
                  max_level = 0.7",
    },
    Topic {
        name: "output",
        written: "[[output]]",
        doc: "A channel of the device and what hangs on it.",
        text: "What its `kind` means:\n\n\
               - `vibration`: for the skin, band-limited to 1 kHz and limited to `max_level`; the same as a [[tactor]]\n\
               - `trigger`: a pulse at each marker, or at those called `marker`, `max_level` high and aligned with the vibration; for EEG \
               amplifiers, cameras, loggers\n\
               - `raw`: what is played there as it comes, steady voltages too, without equaliser, limiter and band limit, cut at `max_level`; for measuring, \
               not for skin\n\
               - `drive`: a rumble motor is turned by what is played: see below\n\
               - `torque`: the torque of the [knob], in shares of its peak where `output` of that says nothing else\n\n\
               What is played on an output for vibration goes, in this order, through its `gain` and `polarity`, the high-pass that keeps \
               steady voltages off (if the device's coupling is \"dc\" and the output does not say dc = true), the actuator's equaliser, the \
               limiter, which acts at `max_level` and lets what stays below pass as it is, and the band limit. When it is played live, \
               a gate comes last, which opens and closes in a ramp: what is behind it is zero when it is closed, whatever the filters hold.\n\n\
               Whatever stops a session (its end, Ctrl-C, a terminal that is closed, a panic, a device that is lost) and all sound off stop motors: for \
               4 ms they are braked with the full drive backward, no longer than until they stand, and then exact zeros leave. At a voltage zero is a short circuit through the amplifier, which \
               goes on braking with the mechanical time constant; at a current zero lets a motor roll, and those 4 ms are all that brakes it. Behind a \
               rectifier nothing brakes. A coin motor of 10 mm so stands 59 ms after its rated speed; shorted from the beginning after 64, \
               with the full drive backward until it stands after 19, which `drive-brake` does where there is time for it.\n\n\
               On a drive, a level is the share of the rated vibration of its motor (negative: backward), and `shaping` makes volts of it: \
               `inverse` does what is played as far as the motor can, and brakes it in time, for which it must know a little ahead; \
               `overdrive` gives as much as there may be until the motor is as fast as it is to be, and as much backward until it is as \
               slow; `switching` gives the most either way at every sample; `plain` gives what holds the speed, by a voltage or a current (`by`), and while the motor is to be slower what is said in `after`: a short circuit or open terminals; `on-off` gives the most there is (or a `share` of it, by a voltage or a current) \
               from a level of `on_at` on until it falls to `off_at`, and then what `after` says; `clicks` plays no levels and no spins, but clicks alone, and those also through AC coupling (a card that lets nothing steady through): what that takes of them is given beforehand. Voices order clicks, spins, brakes and the way home \
               with the nodes `drive-click`, `drive-spin`, `drive-swell` (an envelope, by inverse dynamics or as any `shaping` does it), `drive-on`, `drive-brake` and `drive-home`, whatever levels are shaped by. A drive needs a rumble motor whose figures are \
               known, an amplifier, `full_scale_volts`, and coupling = \"dc\" of device and amplifier, but where there is a rectifier (see \
               [amplifier.NAME]) or clicks alone are played: anything else is refused, with the reason. How late it is stands in `pacinian check`.\n\n\
               Where `full_scale_volts` and figures of the actuator are known, protection comes last: no more voltage, slew, power, heat or \
               travel than the actuator bears leaves the device, and what was held back is told. What it bears leaves as it is, to the bit. Motors behind \
               a bridge or a rectifier, or at a current, are kept to their volts or amperes, and to the heat and the mean square that they bear (no slew is \
               kept to there): what flows is what their model says, with what ripples about it, so it is not known of a motor that is blocked. The mean \
               square is that of the volts that are given, as they would warm a motor that stands; at a current, that of the volts on the winding. \
               Of a warm motor a click is as much weaker as a whole as its heat takes, so that it never loses its brake alone; what then would not turn the mass is \
               not begun. Both are counted.\n\n\
               Of the device's `max_level` and the output's own, the lower one holds. No sample is ever beyond it, whatever a patch, a control \
               or what comes in may do (in a file of 16 or 24 bits the dither adds up to a step and a half). A rig that is saved with another \
               `max_level` while it plays takes over like anything else: raw outputs and pulses keep to it at once, and vibration glides \
               there within 100 ms, on whose way it keeps to the higher of both, and what is louder is turned down without a step (what follows within a quarter of a second of it is turned down with it).",
        tables: &[&output::TABLE],
        example: "[device]\n\
                  channels = 2\n\
                  \n\
                  [[tactor]]\n\
                  name = \"top\"\n\
                  channel = 1\n\
                  \n\
                  [[output]]\n\
                  kind = \"trigger\"\n\
                  name = \"eeg\"\n\
                  channel = 2\n\
                  marker = \"go\"\n\
                  pulse = 0.01",
    },
    Topic {
        name: "group",
        written: "[group.NAME]",
        doc: "Tactors that go by one name.",
        text: "What is played at the group's name sounds on all of them, on each with the whole level. A patch makes groups for itself with lists: \
               place = [\"left\", \"right\"]. Outputs of any kind but triggers may be in one; each may be in several.",
        tables: &[&group::TABLE],
        example: "[device]\n\
                  channels = 2\n\
                  \n\
                  [[tactor]]\n\
                  name = \"thumb\"\n\
                  channel = 1\n\
                  \n\
                  [[tactor]]\n\
                  name = \"index\"\n\
                  channel = 2\n\
                  \n\
                  [group.pinch]\n\
                  tactors = [\"thumb\", \"index\"]",
    },
    Topic {
        name: "actuator",
        written: "[actuator.NAME]",
        doc: "What moves.",
        text: "A tactor names it with actuator = \"NAME\". Its equaliser, up to 16 peaking filters, is rendered; and with \
               `even_out`, what its own model asks for: the resonance is taken out of what is felt (of a voice coil its displacement, of what shakes the \
               acceleration of its casing), as far as amplifier and actuator bear it. A resonance that is moved to a low quality also begins and \
               ends faster: what starts is overdriven and what stops is braked, within the limits. `pacinian check` says what became of it. Its figures say how it moves \
               (what a drive needs, and `pacinian motor` shows) and what it bears (see [[output]]); `part` names one that ships, and figures that are \
               given go before its own; `pacinian identify` finds figures in a recording. Of a motor either what it is made of is given \
               (`torque_constant` and what goes with it), or how it is seen to move (`time_constant` and what goes with it), which goes before \
               what its part is made of. The models:\n\n\
               - `generic`: nothing is known of it\n\
               - `voice-coil`: a coil that pushes the skin itself\n\
               - `inertial-motor`: a mass on a spring, moved by a coil; an exciter\n\
               - `rumble-motor`: a motor with an eccentric mass\n\
               - `lra`: a linear resonant actuator\n\
               - `piezo`: a piezo-electric element",
        tables: &[&actuator::TABLE, &even::TABLE, &actuator::PEAK],
        example: "[device]\n\
                  channels = 1\n\
                  \n\
                  [actuator.coil]\n\
                  model = \"voice-coil\"\n\
                  resonance = 200\n\
                  q = 3\n\
                  rated_volts = 2\n\
                  equaliser = [{ frequency = 200, gain_db = -6, q = 2 }]\n\
                  \n\
                  [[tactor]]\n\
                  name = \"wrist\"\n\
                  channel = 1\n\
                  actuator = \"coil\"",
    },
    Topic {
        name: "amplifier",
        written: "[amplifier.NAME]",
        doc: "What stands between sound card and actuator.",
        text: "An output names it with amplifier = \"NAME\". What its gain makes of `full_scale_volts` is what an actuator gets; a motor \
               also needs its coupling to be \"dc\", but for clicks alone.\n\n\
               A motor behind a card or an amplifier that lets nothing steady through takes a rectifier between amplifier and motor, and drive = \"carrier\": what is \
               sent is a tone far above what is felt, as large as it takes for the current that is wanted, on average, against what the \
               turning motor makes itself. It turns one way, and nothing brakes it: a level that rises is followed, one that falls faster than \
               the motor rolls out is not; a click is a push after which it rolls to where it is to stand; `drive-brake` lets it roll; \
               negative levels and orders are nothing and are counted, and clicks backward and `drive-home` are refused. Where the amplifier gives what it \
               takes, a click through four diodes turns the mass within 2.5 % of as far as was ordered; through one within an eighth, as its \
               half-waves are few and cannot be cut. What a click comes to where that is more than 5 % from what is ordered, says \
               `pacinian check`. Of the amplifier `max_volts` is the peak, of the motor the mean. What vibrates goes through neither a rectifier nor a bridge.",
        tables: &[&amplifier::TABLE],
        example: "[device]\n\
                  channels = 1\n\
                  \n\
                  [amplifier.board]\n\
                  gain = 4\n\
                  max_volts = 5\n\
                  drive = \"voltage\"\n\
                  \n\
                  [[tactor]]\n\
                  name = \"wrist\"\n\
                  channel = 1\n\
                  amplifier = \"board\"",
    },
    Topic {
        name: "calibration",
        written: "[calibration.NAME]",
        doc: "What a tactor was measured to give.",
        text: "A tactor names it with calibration = \"NAME\", and says with `site` where on the body it sits. Then an event may say how strongly it is to be \
               felt, `felt = 20`, in dB above the threshold there, and every tactor is given what that takes of it (see `pacinian format felt`).\n\n\
               Measure what the contactor does while it lies on the skin, with a laser vibrometer or an accelerometer, at several frequencies, and divide \
               by the volts at the tactor, by the amperes, or by full scale of the device (then the volts need not be known, but the calibration holds \
               for this card and this amplifier alone). An actuator's `equaliser` and `even_out`, the output's `gain` and known coupling are counted apart: \
               measure without them.\n\n\
               A file has a line of column names, two of them `frequency` (Hz) and `output`, and a line for each frequency; what is measured besides \
               may stand in other columns. It lies in the rig's folder or below.",
        tables: &[&calibration::TABLE],
        example: "[device]\n\
                  channels = 1\n\
                  full_scale_volts = 1.0\n\
                  \n\
                  [calibration.left]\n\
                  date = \"2026-03-14\"\n\
                  method = \"laser vibrometer on the contactor, on the fingertip, 0.5 N\"\n\
                  site = \"fingertip\"\n\
                  area = 2e-5\n\
                  unit = \"um/V\"\n\
                  table = [[50, 31.0], [100, 28.5], [250, 22.1], [400, 6.0]]\n\
                  \n\
                  [[tactor]]\n\
                  name = \"left\"\n\
                  channel = 1\n\
                  calibration = \"left\"",
    },
    Topic {
        name: "knob",
        written: "[knob]",
        doc: "A force-feedback knob: its motor, its encoder, its amplifier, and what it must keep to.",
        text: "What it feels like stands in the patch (see there, [knob.effects]); here stands what it is. Two motors ship with pacinian, and every \
               figure may be said otherwise. `pacinian knob PATCH --rig RIG` turns it, simulated, and says what it bears: how stiff effects may \
               be at its rate, delay, friction and encoder, what binds, and what would lift it.\n\n\
               Peak torque over friction is its dynamic range. A motor that a current drives has no short-circuit damping: what data sheets \
               call viscous damping with shorted terminals is `viscous_shorted` here, and counts under drive = \"voltage\" alone. A knob in which \
               little damps bears little stiffness: some 1e-4 N m s/rad of bearings or grease are worth more than a faster servo.\n\n\
               Torque passes, in this order: what is no number becomes 0, the governor, the slew, the low-pass, a budget of torque squared \
               that spares the winding, the peak, a soft start, a stale reading, over-speed, and a latch that stays until somebody asks for torque again.\n\n\
               Where a `sensor` says by which inputs of a sound card the angle comes in, `pacinian play` with an input device reads a knob that is there, \
               and its torque leaves by the output: not before somebody asks (`--torque`, the key `t`, OSC `/torque`), and no longer than the angle is \
               known and the card keeps to `delay`. What the card takes is most of what keeps such a knob soft: small blocks help.\n\n\
               Where a `controller` names a serial port, `pacinian play` opens that, hears the angle as input and gives torque back on the line, asked for in \
               the same way. Torque ends where an answer is missing for longer than `patience`, and with every angle that is older than `delay`. An \
               ODrive's own watchdog stops its motor where the program has died; a SmartKnob renders by itself, and is told what to be.",
        tables: &[
            &knob::table::TABLE,
            &knob::table::HARMONIC,
            &knob::sensor::SENSOR,
            &knob::controller::CONTROLLER,
            &knob::table::OUTPUT,
        ],
        example: "[device]\n\
                  channels = 2\n\
                  coupling = \"dc\"\n\
                  \n\
                  [[output]]\n\
                  kind = \"torque\"\n\
                  name = \"knob\"\n\
                  channel = 2\n\
                  \n\
                  [knob]\n\
                  motor = \"pittman-8693\"\n\
                  drive = \"current\"\n\
                  knob_inertia = 4e-6\n\
                  viscous = 1e-4\n\
                  cogging = [{ periods = 14, amplitude = 0.0005 }]\n\
                  compensate = true\n\
                  output = { name = \"knob\", newton_metres = 0.15 }",
    },
];
