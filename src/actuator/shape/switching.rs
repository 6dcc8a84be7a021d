//! Switching drive: the full voltage one way or the other, whichever brings the motor nearer to its wish.

use crate::actuator::fault::{Fault, within};
use crate::actuator::motor::{Drive, Level, Motor, Parameters, Plan};

/// Variable structure: V = V_max sgn(ω* − ω + λ (θ* − θ)), decided at every sample on the motor's own model.
///
/// It needs no figures of the wish's slope, finds back from any disturbance the model knows of, and reaches the wish in finite time as long as
/// the voltage for it is below V_max. What it costs is chatter: the speed swings by about k V_max/(R J) / rate, and the motor hums at that.
#[derive(Debug, Clone, Copy)]
pub struct Switching {
    /// The motor.
    pub parameters: Parameters,
    /// The voltage that is switched, V.
    pub volts: f64,
    /// Samples a second.
    pub rate: f64,
    /// How strongly an angle that lags behind calls for speed, λ, 0 to 1e6 1/s; 0: only the speed counts.
    pub pull: f64,
    /// Half the width of the band of ω* − ω + λ (θ* − θ) in which it goes on as before, 0 to 1e6 rad/s. The wider, the slower it switches.
    pub band: f64,
    /// Where the mass hangs before, rad from straight down.
    pub angle: f64,
}

impl Switching {
    /// The voltages for speeds (rad/s) wished at the end of each sample, and the speeds at which the model was then. What is no number counts
    /// as 0. Behind the end it is for others to brake.
    ///
    /// # Errors
    /// A number beyond its limits.
    pub fn shape(&self, wished: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Fault> {
        within("volts", self.volts, (1e-6, 1e6), "V")?;
        within("pull", self.pull, (0.0, 1e6), "1/s")?;
        within("band", self.band, (0.0, 1e6), "rad/s")?;
        within("angle", self.angle, (-1e6, 1e6), "rad")?;
        let plan = Plan { casing: false, ..Plan::whole(Level::Fine) };
        let mut motor = Motor::<false>::new(&self.parameters, &plan, self.rate)?;
        motor.place(self.angle, 0.0);
        // How far the motor's angle is behind that of the wish.
        let (mut lag, mut forward) = (0.0, true);
        let (mut volts, mut speeds) = (Vec::with_capacity(wished.len()), Vec::with_capacity(wished.len()));
        for wish in wished.iter().map(|wish| if wish.abs() <= 1e9 { *wish } else { 0.0 }) {
            let off = wish - motor.speed() + self.pull * lag;
            if off.abs() > self.band {
                forward = off > 0.0;
            }
            // At rest nothing is nearer than to stay.
            let rests = wish == 0.0 && motor.is_stuck() && off.abs() <= self.band;
            let given = if rests { 0.0 } else { self.volts.copysign(if forward { 1.0 } else { -1.0 }) };
            let before = motor.speed();
            motor.drive(Drive::Voltage(given));
            motor.step();
            lag += (wish - 0.5 * (before + motor.speed())) / self.rate;
            volts.push(given);
            speeds.push(motor.speed());
        }
        Ok((volts, speeds))
    }
}
