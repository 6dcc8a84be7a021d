//! Protection of one actuator: the last that touches its samples before the converter.
//!
//! | file | holds |
//! |---|---|
//! | [`bounds`] | what an actuator bears, and what is known of it |
//! | [`counts`] | what protection did |
//! | [`kernel`] | [`Protection`](kernel::Protection): a block of samples in place, at the device's rate |
//! | [`budget`] | [`Budget`](budget::Budget): heat and mean square of a motor whose samples are not its volts, at the engine's rate |
//!
//! **Where nothing acts, every bit stays.** Otherwise, in this order, for each sample:
//!
//! 1. *Mask*: what is not finite is 0. Where a mean is kept, of squares, heat or the signal, what is more than 16 times full scale is
//!    held there, so that one wild sample does not silence what comes after it.
//! 2. *Alternating*: what is faster than a motor follows only heats it. The mean passes, the rest of it is lowered to its own budget.
//!    It stands first, so that the budgets behind it need not turn the mean down for what does not move anything.
//! 3. *Budgets*: heat and mean square each hold a gain; the lower one counts.
//! 4. *Steady*: the mean of what leaves, beyond what is allowed, is taken off. It stands behind the gains, and watches what leaves behind
//!    everything, so that what the stages after it do to the mean, by clipping a lopsided wave, is taken off as well.
//! 5. *Peak*: held within. Then the *caps* of the budgets, which no signal may pass during a tick.
//! 6. *Slew*: the change from the last sample that left is held within. What results lies between that sample and the one wanted,
//!    both of which keep to the peak: so it does too, and clipping in front of it cannot make it steeper. But a cap that falls
//!    is reached no faster than the slew allows.
//! 7. *Stroke*: the sample is moved towards a share ρ of the last one, which always is safe, as far as it must. That share keeps to
//!    peak and slew by the choice of ρ, so what lies between keeps to both.
//!
//! Everything that has a memory, the model, the mean and the budgets, is fed with the sample that truly leaves, rounded as it is.
//!
//! **Budgets.** A tick is 10 ms, or 1/400 of the shortest time of a budget, but at least 8 samples. At each, temperatures pass the tick
//! exactly. The budget then allows the mean square with which the winding approaches its limit with an eighth of its time constant: dT/dt =
//! 8 (most − T) / τ. At the limit this is what it sheds, so the gain comes to rest there and does not chatter; what it bears for ever is never
//! turned down. The gain follows from the mean square wanted lately (25 ms, or 1/32 of the time where that is less; released over 1/8 of the
//! time), and glides over a tick. What comes too suddenly for that meets the cap: the magnitude that, held through the whole tick, brings
//! the winding to no more than 1.02 times its limit. *Proof:* from the last instant of the tick at which the winding was no warmer than at its
//! start T₀, it sheds at least (T₀ − T_h) / R, T_h the warmest that the housing can become meanwhile, and gets at most b² R₀ (1 + α most); the cap
//! makes the difference C (1.02 most − T₀) / tick, so after a tick at most 1.02 `most` is reached. By induction it never is passed, for any
//! input. Runaway needs no case of its own: it takes a temperature beyond the limit. The mean square budget is the same with one node.
//!
//! What is added to these 2 %: half a tick over the time, of the limit, as what comes late in a tick had less time to go than is reckoned, and
//! as much for a winding that cools within a tick (0.25 % where a tick is 1/400, up to 7 % for 10 ms at 6 kHz); with a slew, what one way
//! down from the peak heats, at most peak² / R × peak / (2 slew) joules; with a coil's plant, whose currents come later than its volts, the energy stored in it (R∫i² ≤ ∫V²/R + that, as it is passive).
//!
//! **Stroke.** A model steps in parallel. Without a slew, a drive is admitted if after the sample the energy in the model is no
//! more than E, the least that a displacement by the stroke takes. *Proof:* shorted terminals are always admitted, since an actuator is
//! passive: its energy then only falls. So by induction the energy never passes E, and the displacement at the samples not the stroke, for any input,
//! rate and Q. Nearest to the drive wanted, the admitted one is the root of a quadratic. At rest, below and at the resonance that gives the whole
//! stroke. Above it, speed is held to ω₀ times the stroke, and so displacement to about stroke × f₀ / f. Between two samples the
//! displacement passes the stroke by no more than (π f₀ / rate)² / 8 of it: 0.3 % at 20 samples a period, 0.02 % at 80.
//!
//! With a slew the terminals cannot be shorted at once, but the voltage be lowered to a share ρ of it each sample, ρ ≥ 1 − slew / (rate peak).
//! That has a motion of its own, x = G V with G = ρ (ρ − A)⁻¹ B; what remains, w = x − G V, moves as with shorted terminals. So
//! ‖w‖ + |G_y| |V| never grows while the voltage is lowered (‖·‖² the energy, so scaled that it bounds the displacement), and a drive is
//! admitted if this is no more than the stroke after it. With ρ = 0 it is the rule above; with ρ = 1 the voltage stays and all comes to
//! rest at X₀ V. Four such ρ are tried, and what one of them admits is safe by that one. At rest and well below the resonance the whole stroke
//! remains; at it 94 to 99 % where the way from the peak to 0 V takes 1/50 of a period, 80 % (Q 3) to 97 % (Q 20) where it takes a third, but
//! 40 % at a Q of 0.7.

pub mod bounds;
pub mod budget;
pub mod counts;
mod governor;
pub mod kernel;
mod motion;
mod store;
mod way;
