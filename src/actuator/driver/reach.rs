//! How far a push through a carrier turns the mass, with all that is on its way: samples, converter, amplifier, diodes and the motor's own coil.
//!
//! A push is solved for the volts that a carrier comes to on average, once it has settled. It begins and ends within a turn of the carrier, and what is
//! wanted changes from one engine sample to the next: the shorter it is, and the fewer half-waves pass, the less it is that mean.

use super::coast::Coast;
use super::order::{Order, Pieces};
use super::setup::Setup;
use super::turner::Turner;
use crate::actuator::drive::Drive;
use crate::actuator::fault::Fault;
use crate::actuator::link::amplifier::Amplifier;
use crate::actuator::link::carrier::Carrier;
use crate::actuator::link::converter::{Converter, LATE};
use crate::actuator::link::coupling::Corners;
use crate::actuator::link::diodes::Diodes;
use crate::actuator::link::fineness::parts;
use crate::actuator::link::wave::Wave;
use crate::actuator::link::{Chain, Link};
use crate::actuator::motor::{Level, Motor, Plan};

/// As well as it is known how fast the motor becomes.
const ERROR: f64 = 1e-3;

/// Seconds after a push at which a coil still has its current that are waited for.
const PATIENCE: f64 = 1.0;

/// What is between what is ordered and the diodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Way {
    /// The carrier, and what is behind it.
    pub carrier: Carrier,
    /// Samples of the device in a second.
    pub rate: f64,
    /// Volts before the diodes for each sample of 1.
    pub per_sample: f64,
    /// The largest sample.
    pub most: f64,
    /// The most volts that the amplifier gives; `None`: any.
    pub peak: Option<f64>,
}

impl Way {
    /// How many turns the mass has made when it stands, after a click that begins so many engine samples after one of them, 0 to 1. The motor lies flat.
    ///
    /// # Errors
    /// A figure of the way or of the motor that cannot be.
    pub fn turns(&self, setup: &Setup, click: &Pieces, after: f64) -> Result<f64, Fault> {
        let mut setup = *setup;
        setup.parameters.gravity = 0.0;
        let p = &setup.parameters;
        let each = (self.rate / setup.rate).round().max(1.0) as usize;
        let (fine, _) = parts(self.carrier.hertz, self.rate, ERROR);
        let rate = self.rate * f64::from(fine);
        let mut turner = Turner::new(&setup, 0)?;
        let mut wave = Wave::new(&self.carrier, p.electrical_time(), self.rate, self.per_sample)?;
        let mut converter = Converter::new(fine)?;
        let amplifier =
            Amplifier { gain: 1.0, inverted: false, drive: Drive::Voltage, volts: self.peak, amperes: None };
        let chain = Chain { full_scale: self.per_sample, corners: Corners::none(), amplifier };
        let mut link = Link::new(&chain, rate)?;
        let diodes = Diodes::new(self.carrier.rectifier, rate);
        let plan = Plan { casing: false, gravity: false, ..Plan::whole(Level::Default) };
        let mut motor = Motor::<false>::new(p, &plan, rate)?;
        turner.order(after.clamp(0.0, 1.0), 0, Order::Click(*click));
        let lasts: f64 = click.list.iter().map(|piece| piece.0).sum();
        let ends = turner.late() + (lasts * setup.rate).ceil() as usize + 2 + (2 * LATE).div_ceil(each);
        let most = ends + (PATIENCE * setup.rate) as usize;
        let (mut sent, mut volts) = (vec![0.0; each], vec![0.0; fine as usize]);
        let mut done = 0;
        while done < ends || (motor.current() > 0.0 && done < most) {
            turner.step(0.0, &mut sent);
            let emf = turner.emf();
            for sent in &sent {
                let (sample, _) = wave.step(*sent, emf, self.most);
                converter.step(link.cut(sample), &mut volts);
                link.parts(&mut volts);
                volts.iter().for_each(|volts| diodes.step(&mut motor, *volts, |_, _, _| {}));
            }
            done += 1;
        }
        Ok((motor.turned() + Coast::new(p).angle(motor.speed())) / std::f64::consts::TAU)
    }
}

#[cfg(test)]
mod tests {
    use super::{Carrier, Order, Setup, Turner, Way};
    use crate::actuator::drive::Drive;
    use crate::actuator::driver::book::Book;
    use crate::actuator::driver::setup::{Shaping, Stage};
    use crate::actuator::link::carrier::Rectifier;
    use crate::actuator::link::conduction::Conduction;
    use crate::actuator::motor::{Casing, Parameters};
    use std::f64::consts::TAU;

    fn setup(inductance: f64) -> Setup {
        let parameters = Parameters {
            resistance: 10.42,
            inductance,
            gain: 0.011,
            inertia: 1.15e-7,
            viscous: 1e-6,
            coulomb: 6e-4,
            stiction: 8e-4,
            rated_volts: 6.0,
            casing: Casing::Held,
            ..Parameters::COIN
        };
        Setup {
            parameters,
            imposes: Drive::Voltage,
            one_way: true,
            diode_drop: 1.4,
            half_wave: false,
            limit: 6.0,
            compliance: 6.0,
            shaping: Shaping::Inverse,
            stage: Stage::default(),
            park: None,
            look_ahead: None,
            ordered: true,
            rate: 8000.0,
        }
    }

    fn way(hertz: f64, full_wave: bool) -> Way {
        let carrier = Carrier { hertz, rectifier: Rectifier { full_wave, drop: 1.4 } };
        Way { carrier, rate: 48_000.0, per_sample: 20.0, most: 1.0, peak: None }
    }

    /// Through a bridge a push turns the mass as far as it was ordered, be its coil small or one that keeps its current for half as long as it is pushed; and so what
    /// sends it takes it to be.
    #[test]
    fn a_push_comes_to_what_was_ordered() {
        for inductance in [0.0, 1e-4, 4.2e-3, 2e-2] {
            let setup = Setup {
                parameters: Parameters { gravity: 0.0, ..setup(inductance).parameters },
                ..setup(inductance)
            };
            for turns in [0.25, 1.0] {
                let book = Book::new(&setup, turns).unwrap();
                for level in [1.0, book.weakest()] {
                    let click = book.at(level).unwrap();
                    let mut turner = Turner::new(&setup, 0).unwrap();
                    turner.order(0.0, 0, Order::Click(click));
                    (0..8000).for_each(|_| turner.step(0.0, &mut [0.0; 6]));
                    let model = turner.motor().map_or(0.0, |motor| motor.turned()) / TAU;
                    let through = way(4000.0, true).turns(&setup, &click, 0.4).unwrap();
                    for is in [model, through] {
                        let off = (is / turns - 1.0).abs();
                        assert!(off < 0.02, "{inductance} {turns} {level}: {model} {through}");
                    }
                }
            }
        }
    }

    /// Through one diode too, where its half-waves are many: the coil keeps nothing from one of them to the next, be its own time a third of the carrier's or
    /// eight times that.
    #[test]
    fn one_diode_keeps_nothing_from_one_half_wave_to_the_next() {
        for inductance in [0.0, 1e-3, 4.2e-3, 2e-2] {
            let setup = Setup { half_wave: true, ..setup(inductance) };
            for turns in [0.25, 1.0] {
                let book = Book::new(&setup, turns).unwrap();
                for level in [0.3, book.weakest()] {
                    let click = book.at(level).unwrap();
                    for instant in [0.0, 0.4] {
                        let way = Way { per_sample: 1e5, ..way(4000.0, false) };
                        let through = way.turns(&setup, &click, instant).unwrap();
                        assert!(
                            (through / turns - 1.0).abs() < 0.025,
                            "{inductance} {turns} {level}: {through}"
                        );
                    }
                }
            }
        }
    }

    /// What is left is how few half-waves there are, and that they cannot be cut: of what an amplifier can give, a push through a bridge is within 2.5 % of what
    /// was ordered, one through a single diode within an eighth.
    #[test]
    fn few_half_waves_are_as_far_off_as_is_said() {
        let mut farthest = [0.0_f64; 2];
        for (full_wave, within) in [(true, 0.025), (false, 0.125)] {
            for hertz in [2000.0, 4000.0, 16_000.0] {
                for inductance in [0.0, 1e-3, 4.2e-3] {
                    for peak in [18.0, 100.0] {
                        let way = Way { peak: Some(peak), per_sample: 1e3, ..way(hertz, full_wave) };
                        let setup = Setup { half_wave: !full_wave, ..setup(inductance) };
                        let conduction =
                            Conduction::new(&way.carrier, setup.parameters.electrical_time()).unwrap();
                        let setup = Setup { limit: conduction.mean(peak, 0.0).min(setup.limit), ..setup };
                        let Ok(book) = Book::new(&setup, 0.25) else { continue };
                        for level in [1.0, 0.6, book.weakest()] {
                            for instant in [0.0, 0.55] {
                                let click = book.at(level).unwrap();
                                let off = way.turns(&setup, &click, instant).unwrap() / 0.25 - 1.0;
                                assert!(
                                    off.abs() < within,
                                    "{full_wave} {hertz} {inductance} {peak} {level}: {off}"
                                );
                                let most = &mut farthest[usize::from(full_wave)];
                                *most = most.max(off.abs());
                            }
                        }
                    }
                }
            }
        }
        assert!(farthest[0] > 0.1 && farthest[1] > 0.015, "{farthest:?}");
    }

    /// A sample that may not be as large as it takes, and an amplifier that gives less, take from a push.
    #[test]
    fn what_keeps_a_carrier_small_keeps_a_push_short() {
        let setup = setup(1e-4);
        let click = Book::new(&setup, 0.25).unwrap().strongest();
        let whole = way(4000.0, true).turns(&setup, &click, 0.0).unwrap();
        for less in [Way { most: 0.4, ..way(4000.0, true) }, Way { peak: Some(8.0), ..way(4000.0, true) }] {
            let is = less.turns(&setup, &click, 0.0).unwrap();
            assert!(is < 0.9 * whole && is > 0.2 * whole, "{is} of {whole}");
        }
        let none = Way { peak: Some(1.0), ..way(4000.0, true) };
        assert_eq!(none.turns(&setup, &click, 0.0), Ok(0.0));
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let click = Default::default();
        let refused = |way: Way| way.turns(&setup(0.0), &click, 0.0).unwrap_err().field;
        assert_eq!(refused(Way { per_sample: 0.0, ..way(4000.0, true) }), "full_scale_volts");
        assert_eq!(refused(way(22_000.0, true)), "carrier");
        assert_eq!(refused(Way { rate: f64::NAN, ..way(4000.0, true) }), "rate");
    }
}
