//! What happens when the program is wrong about itself.

use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::sync::atomic::{AtomicBool, Ordering};

/// The exit code of a bug, `EX_SOFTWARE` of `sysexits.h`.
pub const BUG: u8 = 70;

static PANICKED: AtomicBool = AtomicBool::new(false);

/// Whether a thread of the program has panicked.
pub fn has_panicked() -> bool {
    PANICKED.load(Ordering::Relaxed)
}

/// Runs `work`. A panic in it is told as the bug it is; files that are being written are completed as far as they are.
pub fn guarded(work: impl FnOnce() -> u8) -> u8 {
    set_hook(Box::new(|info| {
        PANICKED.store(true, Ordering::Relaxed);
        super::screen::tty::give_back();
        let place = info.location().map(ToString::to_string).unwrap_or_default();
        let payload = info.payload();
        let text = payload.downcast_ref::<String>().map(String::as_str);
        let what = text.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or("no more is known");
        // Where nobody can be told, nobody is.
        let _ = writeln!(
            std::io::stderr(),
            "error: this is a bug in pacinian {}, not in your files: {what} ({place})\n  \
             help: please report it with this message, the command and, if you may share them, the patch and the rig",
            env!("CARGO_PKG_VERSION"),
        );
    }));
    catch_unwind(AssertUnwindSafe(work)).unwrap_or(BUG)
}

#[cfg(test)]
mod tests {
    use super::guarded;

    #[test]
    fn a_panic_is_a_bug_and_has_its_code() {
        assert_eq!(guarded(|| panic!("out of cheese")), 70);
        assert_eq!(guarded(|| 3), 3);
    }
}
