//! From a place in a patch to a channel of the rig.
