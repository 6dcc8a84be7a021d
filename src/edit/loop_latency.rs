//! The latency of a loop into the text of a rig.

use super::value::{make_room, put};
use super::{EditError, broken, parse};
use crate::rig::Rig;

/// The text of a rig with `loop_latency` under `[device]`, seconds, to a ten-millionth.
///
/// # Errors
/// A text without `[device]`, and one that is no rig then.
pub fn loop_latency(source: &str, seconds: f64) -> Result<String, EditError> {
    let key = "loop_latency";
    let mut document = parse(source)?;
    let item = document.get_mut("device").ok_or_else(|| EditError::Missing("[device]".into()))?;
    make_room(item, key);
    let device = item.as_table_like_mut().ok_or_else(|| EditError::Form("`device`".into()))?;
    put(device, key, ((seconds * 1e7).round() / 1e7).into());
    let text = document.to_string();
    Rig::parse("", text.as_bytes()).map_err(broken)?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::{EditError, loop_latency};

    #[test]
    fn a_rig_keeps_everything_but_the_figure() {
        let rig = "# mine\nformat = \"pacinian-rig/1\"\n[device]  # the card\nchannels = 8 # eight\n\n# the first\n[[tactor]]\nname = \"a\"\nchannel = 1\n";
        let with = loop_latency(rig, 0.001_234_567_89).unwrap();
        assert_eq!(with, rig.replace("# eight\n", "# eight\nloop_latency = 0.0012346\n"));
        let again = loop_latency(&with.replace("0.0012346", "0.5   # before"), 0.002).unwrap();
        assert_eq!(again, with.replace("0.0012346", "0.002   # before"));
        let head = "format = \"pacinian-rig/1\"\n";
        let inline = loop_latency(&format!("{head}device = {{ channels = 2 }} # x\n"), 0.5).unwrap();
        assert_eq!(inline, format!("{head}device = {{ channels = 2, loop_latency = 0.5 }} # x\n"));
        assert_eq!(loop_latency("x = 1\n", 0.1), Err(EditError::Missing("[device]".into())));
        assert!(matches!(loop_latency("[", 0.1), Err(EditError::Unreadable(_))));
        assert!(matches!(loop_latency(rig, f64::NAN), Err(EditError::Broken(_))));
    }
}
