//! What of a card's samples reaches a motor, and how it is turned.

use crate::actuator::drive::Drive as Imposed;
use crate::actuator::driver::setup::Setup;
use crate::actuator::motor::Parameters;
use crate::rig::Output;
use crate::rig::output::Turning;
use crate::rig::terminals::Terminals;
use crate::text::Problem;

/// A motor on an output.
#[derive(Debug, Clone, PartialEq)]
pub struct Wiring {
    /// How it is turned.
    pub turning: Turning,
    /// The motor; its gravity is that of the tilt, 0 where that is unknown.
    pub parameters: Parameters,
    /// Whether the amplifier imposes a current: then figures of the drive are amperes.
    pub is_current: bool,
    /// Volts or amperes at the motor for a sample of 1.0, negative where the amplifier turns it upside down; behind a bridge, for a pulse that
    /// never ends, and behind a rectifier the peak of a carrier.
    pub per_sample: f64,
    /// What makes the volts at its terminals.
    pub terminals: Terminals,
    /// The most that reaches the motor, volts or amperes; behind a rectifier, volts on average, whatever its speed.
    pub limit: f64,
    /// The most voltage that the amplifier gives, V; that of the motor's limit where it is not known.
    pub compliance: f64,
}

impl Wiring {
    /// What turns it, at so many samples a second.
    pub fn setup(&self, rate: f64) -> Setup {
        Setup {
            parameters: self.parameters,
            imposes: if self.is_current { Imposed::Current } else { Imposed::Voltage },
            one_way: matches!(self.terminals, Terminals::Carrier(_)),
            diode_drop: match self.terminals {
                Terminals::Carrier(carrier) => carrier.rectifier.drop,
                Terminals::Straight | Terminals::Bridge(_) | Terminals::Coupled(_) => 0.0,
            },
            half_wave: matches!(self.terminals, Terminals::Carrier(carrier) if !carrier.rectifier.full_wave),
            limit: self.limit,
            compliance: self.compliance,
            shaping: self.turning.shaping,
            stage: self.turning.stage,
            park: self.turning.park,
            look_ahead: self.turning.look_ahead,
            // An order may come with any patch that takes over.
            ordered: true,
            rate,
        }
    }

    /// The same, if there is enough to turn the motor at all.
    pub(in crate::rig) fn turns(self, output: &Output) -> Result<Self, Problem> {
        let p = &self.parameters;
        let starts = p.running_volts() / if self.is_current { p.resistance } else { 1.0 };
        if self.limit > starts {
            return Ok(self);
        }
        let (unit, share) = (if self.is_current { "A" } else { "V" }, 100.0 * self.limit / starts);
        let what = format!(
            "at most {:.3} {unit} reach the motor of `{}`, {share:.0} % of what turns it at all",
            self.limit, output.name
        );
        let help = "raise the amplifier's `gain`, `max_volts` or `max_level`, or the motor's `max_volts`; or `max_amperes` of either";
        Err(Problem::error(&output.span, what).help(help.to_string()))
    }
}
