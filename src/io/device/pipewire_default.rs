//! Which device PipeWire plays on by default now, and which it hears. cpal has names of its own for these, and says of each that it has two
//! channels.

use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::sync::Once;
use std::time::Duration;

use cpal::Device;
use cpal::traits::HostTrait;
use pipewire::context::ContextRc;
use pipewire::core::PW_ID_CORE;
use pipewire::main_loop::MainLoopRc;
use pipewire::metadata::{Metadata, MetadataListener};
use pipewire::types::ObjectType;

/// A server that takes longer to answer is not asked.
const PATIENCE: Duration = Duration::from_secs(2);

/// Under which key the server tells what a default of cpal's is now.
fn key(id: &str) -> Option<&'static str> {
    match id {
        "pipewire:output_default" | "pipewire:sink_default" => Some("default.audio.sink"),
        "pipewire:input_default" => Some("default.audio.source"),
        _ => None,
    }
}

/// The device that a default of cpal's is now; `None` of what is no default, or where that is not known.
pub(super) fn device(id: &str) -> Option<Device> {
    let name = node(key(id)?)?;
    let host = cpal::host_from_id(cpal::HostId::PipeWire).ok()?;
    host.device_by_id(&format!("pipewire:{name}").parse().ok()?)
}

/// What the server has under a key of its `default`s: the name of a node.
fn node(key: &'static str) -> Option<String> {
    static ONCE: Once = Once::new();
    ONCE.call_once(pipewire::init);
    let turns = MainLoopRc::new(None).ok()?;
    let context = ContextRc::new(&turns, None).ok()?;
    let core = context.connect_rc(None).ok()?;
    let registry = core.get_registry_rc().ok()?;
    let found = Rc::new(RefCell::new(None));
    let bound: Rc<RefCell<Option<(MetadataListener, Metadata)>>> = Rc::default();
    let (binds, finds, binder) = (Rc::clone(&bound), Rc::clone(&found), registry.clone());
    let _listens = registry
        .add_listener_local()
        .global(move |global| {
            let name = global.props.and_then(|props| props.get("metadata.name"));
            if global.type_ != ObjectType::Metadata || name != Some("default") {
                return;
            }
            let Ok(metadata) = binder.bind::<Metadata, _>(global) else { return };
            let finds = Rc::clone(&finds);
            let listener = metadata.add_listener_local().property(move |_, own, _, value| {
                if own == Some(key) {
                    *finds.borrow_mut() = value.and_then(named);
                }
                0
            });
            let listener = listener.register();
            // In the order in which they are dropped.
            binds.borrow_mut().replace((listener, metadata));
        })
        .register();
    // First the server tells what there is, then what is in it.
    let (asker, ends, rounds) = (core.clone(), turns.clone(), Cell::new(0));
    let _answers = core
        .add_listener_local()
        .done(move |id, _| {
            if id != PW_ID_CORE {
                return;
            }
            rounds.set(rounds.get() + 1);
            if rounds.get() > 1 || asker.sync(0).is_err() {
                ends.quit();
            }
        })
        .register();
    core.sync(0).ok()?;
    let ends = turns.clone();
    let timer = turns.loop_().add_timer(move |_| ends.quit());
    timer.update_timer(Some(PATIENCE), None).into_result().ok()?;
    turns.run();
    // Before the core that it is from.
    drop(bound.borrow_mut().take());
    found.take()
}

/// The name in what the server says: `{"name":"alsa_output.usb"}`.
fn named(value: &str) -> Option<String> {
    let value: serde_json::Value = serde_json::from_str(value).ok()?;
    value.get("name")?.as_str().map(String::from)
}

#[cfg(test)]
mod tests {
    use super::{key, named};

    #[test]
    fn defaults_are_known_by_cpals_names_and_devices_by_the_servers() {
        assert_eq!(key("pipewire:output_default"), Some("default.audio.sink"));
        assert_eq!(key("pipewire:input_default"), Some("default.audio.source"));
        assert_eq!((key("pipewire:glove"), key("alsa:output_default")), (None, None));
        assert_eq!(named("{\"name\":\"alsa_output.usb\"}").as_deref(), Some("alsa_output.usb"));
        let bad = ["", "{}", "{\"name\":3}", "[]", "alsa_output.usb"];
        assert!(bad.iter().all(|value| named(value).is_none()));
    }
}
