//! The smallest program: the text of a patch, a player, a buffer. Run it with `cargo run --example hello`.

use pacinian::{NoAssets, Note, Options, Patch, Player, Rig};

const PATCH: &str = r#"
format = "pacinian-patch/1"
title  = "Hello, skin"

[voice.tap]
output = "felt"
[voice.tap.nodes]
tone = { type = "sine", frequency = "event.frequency" }
hit  = { type = "envelope", attack = 0.004, decay = 0.08, sustain = 0.0 }
felt = { type = "multiply", inputs = ["tone", "hit"] }
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let patch = Patch::parse("hello.toml", PATCH.as_bytes())?.value;
    let options = Options { live: true, ..Options::default() };
    let mut player = Player::new(&patch, &Rig::default_for(2), &options, &NoAssets)?;
    player.play("tap", &Note::default())?;
    let mut frames = vec![0.0_f32; 2 * 12_000];
    player.process(&mut frames);

    let peak = frames.iter().fold(0.0_f32, |peak, x| peak.max(x.abs()));
    println!("a tap of {:.2} of full scale, then silence: {}", peak, player.is_over());
    assert!(peak > 0.5 && player.is_over());
    Ok(())
}
