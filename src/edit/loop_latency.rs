//! The latency of a loop into the text of a rig.

use super::text::Text;
use super::value::{put, table};
use super::{EditError, broken};
use crate::rig::Rig;

/// The text of a rig with `loop_latency` under `[device]`, seconds, to a ten-millionth.
///
/// # Errors
/// A text without `[device]`, and one that is no rig then.
pub fn loop_latency(source: &str, seconds: f64) -> Result<String, EditError> {
    let mut text = Text::of(source);
    text.change(|document| {
        let item = document.get_mut("device").ok_or_else(|| EditError::Missing("[device]".into()))?;
        table(item, "`device`", |device| put(device, "loop_latency", ((seconds * 1e7).round() / 1e7).into()))
    })?;
    let text = text.finish();
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
        let crlf = |text: &str| format!("\u{feff}{}", text.replace('\n', "\r\n"));
        assert_eq!(loop_latency(&crlf(rig), 0.001_234_567_89).unwrap(), crlf(&with));
        let again = loop_latency(&with.replace("0.0012346", "0.5   # before"), 0.002).unwrap();
        assert_eq!(again, with.replace("0.0012346", "0.002   # before"));
        let head = "format = \"pacinian-rig/1\"\n";
        let inline = loop_latency(&format!("{head}device = {{ channels = 2 }} # x\n"), 0.5).unwrap();
        assert_eq!(inline, format!("{head}device = {{ channels = 2, loop_latency = 0.5 }} # x\n"));
        let tables = rig.replace("# the first", "[device.loop_latency]\nx = 1\n# the first");
        assert_eq!(loop_latency(&tables, 0.1), Err(EditError::Form("`loop_latency`".into())));
        assert_eq!(loop_latency("x = 1\n", 0.1), Err(EditError::Missing("[device]".into())));
        assert!(matches!(loop_latency("[", 0.1), Err(EditError::Unreadable(_))));
        assert!(matches!(loop_latency(rig, f64::NAN), Err(EditError::Broken(_))));
    }
}
