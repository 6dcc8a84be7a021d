//! A stream stays on the device that it was opened on.

/// What PipeWire's library reads the properties of a program's streams from.
#[cfg(feature = "pipewire")]
const PROPERTIES: &str = "PIPEWIRE_PROPS";

/// Asks PipeWire not to link a stream to another device where its own goes: what is played would reach that one until the news does. To be
/// called before there is any other thread.
#[cfg(feature = "pipewire")]
pub fn stay_on_one_device() {
    let asked = staying(&std::env::var(PROPERTIES).unwrap_or_default());
    // SAFETY: `main` calls this first, when there is no other thread that could read the environment.
    unsafe { std::env::set_var(PROPERTIES, asked) };
}

/// Properties that ask for it, and what the user asks for, who has the last word.
fn staying(given: &str) -> String {
    let given = given.trim();
    let bare = given.strip_prefix('{').and_then(|rest| rest.strip_suffix('}')).unwrap_or(given);
    format!("{{ node.dont-reconnect = true {} }}", bare.trim())
}

#[cfg(test)]
mod tests {
    use super::staying;

    #[test]
    fn the_user_has_the_last_word() {
        assert_eq!(staying(""), "{ node.dont-reconnect = true  }");
        let both = "{ node.dont-reconnect = true node.dont-reconnect=false media.role=Music }";
        for given in
            ["{ node.dont-reconnect=false media.role=Music }", " node.dont-reconnect=false media.role=Music"]
        {
            assert_eq!(staying(given), both);
        }
    }
}
