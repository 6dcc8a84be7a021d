//! More than anybody plays, for tests of what the audio thread may not do.

use pacinian::engine::event::{Event, Move};
use pacinian::node::motion::Motion;
use pacinian::schedule::Instant;

use super::play;

/// The `i`th event: voices of two instruments on 16 places, releases, controls, and hands that move, by far not all of them fitting.
pub fn event(i: u32) -> Event {
    match i % 10 {
        0 => Event::Control(0, f64::from(i % 7) / 7.0),
        1 => Event::Release(u64::from(i.wrapping_sub(1))),
        2 | 3 => Event::Touch(Move {
            id: u64::from(i.wrapping_sub(8 + i % 50 / 10)),
            motion: Motion::ALL[i as usize / 10 % 3],
            value: f64::from(i % 97) / 50.0 - 0.5,
        }),
        _ => Event::Play(play(i % 2, i % 16, 40.0 + f64::from(i % 300), 0.003, u64::from(i))),
    }
}

/// When it is due, with `clock` the next sample.
pub fn due(clock: u64, i: u32) -> Instant {
    Instant { sample: clock + u64::from(i % 80), fraction: i.wrapping_mul(2_654_435_761) }
}

/// Wants something of the gate.
#[cfg(feature = "live")]
pub fn pull(board: &pacinian::live::board::Board, i: u32) {
    match i % 6 {
        0 => board.lever.open(),
        1 => board.lever.gain(0.5, 0),
        2 => board.lever.panic(0),
        3 => board.lever.calm(),
        4 => board.lever.release(0),
        _ => board.lever.gain(1.0, 0),
    }
}

/// What a card brings and an engine on another clock hears, for four seconds: with pauses, in which it runs dry, and floods, in which nothing
/// has room. Gives the loudest that was heard.
#[cfg(feature = "live")]
pub fn listen(
    intake: &mut pacinian::live::intake::Intake,
    feed: &mut impl pacinian::live::intake::Hearing,
    board: &pacinian::live::board::Board,
) -> f32 {
    use pacinian::live::stamp::Stamp;
    let (frames, mut output) = ([0.25_f32; 256], [0.0_f32; 192]);
    let (mut heard, mut next) = (0.0_f32, 1.0);
    for n in 0..3000_u32 {
        let now = 1.0 + f64::from(n) * 64.0 / 48_000.0;
        while next < now && n % 1000 < 900 {
            intake.take(Stamp((next * 1e9) as u64), 0.003, &frames);
            next += 128.0 / 44_100.0;
        }
        if n % 1000 == 950 {
            board.gap_of_input();
            (0..500).for_each(|_| intake.take(Stamp((now * 1e9) as u64), 0.0, &frames));
        }
        feed.hear(now, 3, &mut output);
        heard = heard.max(output[0]);
    }
    heard
}
