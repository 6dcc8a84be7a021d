//! The figures of an effect, read from its keys.

use crate::actuator::fault::Fault;
use crate::knob::effect::program::Any;
use crate::knob::effect::{
    constant, damper, detent, friction, hertz, inertia, magnet, snap, spin, spring, table, texture,
    transient, wall,
};
use crate::text::reader::Reader;

/// The figures of an effect; `None` where one that it needs cannot be read, which has been told.
pub(super) fn figures(word: &str, reader: &Reader) -> Option<Result<Any, Fault>> {
    let number = |key: &str| reader.number(key);
    let or = |key: &str| reader.number_or_default(key);
    let damping = || if reader.has("damping") { reader.number("damping") } else { Some(0.0) };
    let below = || reader.word("side") == 1;
    Some(Ok(match word {
        "spring" => spring::Spring { stiffness: number("stiffness")?, centre: or("centre") }.into(),
        "damper" => damper::Damper { damping: number("damping")? }.into(),
        "wall" => {
            let (angle, stiffness) = (number("angle")?, number("stiffness")?);
            wall::Wall { angle, below: below(), stiffness, damping: damping()? }.into()
        }
        "end-stops" => {
            let (low, high) = (number("low")?, number("high")?);
            wall::Stops { low, high, stiffness: number("stiffness")?, damping: damping()? }.into()
        }
        "detents" => {
            let shape = match reader.at("table") {
                Some(_) => detent::Shape::Table(numbers(reader, "table")?.into()),
                None if reader.word("shape") == 1 => detent::Shape::Triangle,
                None => detent::Shape::Sine,
            };
            let (count, amplitude) = (number("count")?, number("torque")?);
            detent::Detent { count, amplitude, centre: or("centre"), shape, hysteresis: or("hysteresis") }
                .into()
        }
        "snap" => {
            let (width, stiffness, most) = (number("width")?, number("stiffness")?, number("torque")?);
            snap::Snap { width, stiffness, most, point: or("point"), centre: or("centre") }.into()
        }
        "magnet" => {
            magnet::Magnet { centre: or("centre"), stiffness: number("stiffness")?, reach: number("reach")? }
                .into()
        }
        "friction" => {
            let law = if reader.word("law") == 1 { friction::Law::Dahl } else { friction::Law::Adhesion };
            friction::Friction { torque: number("torque")?, stretch: or("stretch"), law }.into()
        }
        "inertia" => {
            let (inertia, stiffness) = (number("inertia")?, number("stiffness")?);
            // Critically damped, so that it does not swing behind its spring.
            let damping =
                if reader.has("damping") { number("damping")? } else { 2.0 * (inertia * stiffness).sqrt() };
            inertia::Inertia { inertia, stiffness, damping }.into()
        }
        "constant" => constant::Constant { torque: number("torque")? }.into(),
        "spin" => {
            spin::Spin { speed: number("speed")?, damping: number("damping")?, most: number("torque")? }
                .into()
        }
        "ripple" => {
            texture::Ripple { amplitude: number("torque")?, wavelength: number("wavelength")? }.into()
        }
        "texture" => texture::Fed { scale: number("torque")? }.into(),
        "table" => return Some(table::Table::new(&points(reader)?).map(Into::into)),
        "contact" => {
            let (angle, factor) = (number("angle")?, number("factor")?);
            hertz::Hertz { angle, below: below(), factor, most: number("torque")? }.into()
        }
        _ => {
            let (strength, hertz) = (number("strength")?, number("frequency")?);
            let most = if reader.has("torque") { number("torque")? } else { 1e3 };
            transient::Transient { strength, hertz, decay: number("decay")?, least: or("least"), most }.into()
        }
    }))
}

fn numbers(reader: &Reader, key: &str) -> Option<Vec<f64>> {
    let value = reader.at(key)?;
    let list: Option<Vec<f64>> = value.list().and_then(|list| list.map(|v| v.number()).collect());
    if list.is_none() {
        reader.mistaken(key, &value, "a list of numbers");
    }
    list
}

fn points(reader: &Reader) -> Option<Vec<(f64, f64)>> {
    let value = reader.at("points")?;
    let pair = |value: crate::text::reader::At| {
        let pair: Vec<f64> = value.list()?.map(|v| v.number()).collect::<Option<_>>()?;
        if let [angle, torque] = pair[..] { Some((angle, torque)) } else { None }
    };
    let list: Option<Vec<_>> = value.list().and_then(|list| list.map(pair).collect());
    if list.is_none() {
        reader.mistaken("points", &value, "pairs of an angle and a torque: [[-0.5, 0.02], [0.5, -0.02]]");
    }
    list
}
