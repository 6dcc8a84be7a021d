//! What PulseAudio is asked that cpal does not ask it: where it leads channels, and where streams have gone.

mod client;
pub(super) mod map;
pub(super) mod streams;
