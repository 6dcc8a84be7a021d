//! A graph made in code, with no patch and no rig: nodes and wires, the passes that compile them, a plan, an engine.
//!
//! Run it with `cargo run --example own_graph`.

use pacinian::patch::Pitch;
use pacinian::space::law::Law;
use pacinian::space::spot::Spot;
use std::error::Error;
use std::sync::Arc;

use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Source};
use pacinian::graph::plan::{Instrument, Output, OutputKind, Plan, Precision, compile};
use pacinian::graph::program::Program;
use pacinian::graph::start::{StartProgram, Step};
use pacinian::graph::{Graph, Node, Settings, Wire};
use pacinian::node::NodeKind;
use pacinian::node::spec::Kind;
use pacinian::schedule::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    // A sine whose frequency the event brings, an envelope, their product; and a node that nothing needs.
    let mut graph = Graph::default();
    graph.starts.push(StartProgram::new(vec![Step::Own(0)])?);
    graph.nodes.push(node("tone", "sine", &[("frequency", Wire::start(0))])?);
    graph.nodes.push(node("hit", "envelope", &[("attack", Wire::constant(0.01))])?);
    graph.nodes.push(Node { inputs: vec![Wire::node(0), Wire::node(1)], ..node("felt", "multiply", &[])? });
    graph.nodes.push(node("spare", "sine", &[("frequency", Wire::constant(50.0))])?);
    graph.outputs.push(Wire::node(2));
    let compiled = compile(graph, true, 8000.0)?;
    println!(
        "{} ops, {} buffers; left out: {:?}",
        compiled.program.ops.len(),
        compiled.program.buffers,
        compiled.pruned
    );

    let plan = Plan {
        device_rate: 48_000.0,
        ratio: 6,
        channels: 1,
        precision: Precision::Single,
        taps: 6,
        seed: 0,
        shared: Vec::new(),
        shared_program: Program::default(),
        controls: Vec::new(),
        watches: Vec::new(),
        answering: Vec::new(),
        answer: 0,
        instruments: vec![Instrument {
            name: "voice".into(),
            program: compiled.program,
            voices: 8,
            fields: vec!["frequency".into()],
            defaults: vec![250.0],
            place: Spot::Row(0),
            law: Law::Energy,
            width: 0.0,
            steered: false,
            level: 1.0,
            felt: None,
            pitch: Pitch::OfEvent,
            tail: 0.0,
            always: false,
        }],
        places: vec![vec![(0, 0.8)]],
        together: Vec::new(),
        spread: None,
        paths: vec![],
        gauges: [].into(),
        outputs: vec![Output {
            name: "wrist".into(),
            channel: 0,
            kind: OutputKind::Vibration,
            equaliser: Vec::new(),
            keeps_dc_off: false,
            max_level: 1.0,
        }],
        drives: Vec::new(),
        clicks: Vec::new(),
        swells: Vec::new(),
        homes: Vec::new(),
        homeless: Vec::new(),
        protections: Vec::new(),
        markers: Vec::new(),
        knob: None,
        left_out: Vec::new(),
    };

    let mut engine = Engine::new(&plan)?;
    let play = plan.play("voice", &[("frequency", 120.0), ("duration", 2.0)])?;
    engine.schedule(Instant::default(), Source::Program, Event::Play(play));
    let mut frames = vec![0.0_f32; 72_000];
    engine.process(&mut frames);

    // A second from the middle of it: 120 times through zero upwards, and as high as the output stage is designed to let through.
    let second = &frames[12_000..60_000];
    let cycles = second.windows(2).filter(|w| w[0] < 0.0 && w[1] >= 0.0).count();
    let peak = second.iter().fold(0.0_f32, |peak, x| peak.max(x.abs()));
    let response = engine.stage().vibration().response(0, 120.0);
    let wanted = 0.8 * response.re.hypot(response.im);
    println!("{cycles} cycles in a second, peak {peak:.4} where the design says {wanted:.4}");
    assert!(cycles == 120 && (f64::from(peak) - wanted).abs() < 1e-3);
    Ok(())
}

/// A node with some wires given and defaults for the rest.
fn node(name: &str, kind: &str, given: &[(&str, Wire)]) -> Result<Node, String> {
    let kind = NodeKind::find(kind).ok_or_else(|| format!("there is no node type `{kind}`"))?;
    let mut node =
        Node { name: name.into(), kind, settings: Arc::new(Settings::default()), inputs: Vec::new() };
    for param in kind.spec().params {
        let (Kind::Signal(n) | Kind::Frequency(n) | Kind::Start(n)) = param.kind else { continue };
        let wire = given.iter().find(|(key, _)| *key == param.name).map(|(_, wire)| *wire);
        let default = n.default.map(Wire::constant);
        node.inputs.push(wire.or(default).ok_or_else(|| format!("`{name}` lacks `{}`", param.name))?);
    }
    Ok(node)
}
