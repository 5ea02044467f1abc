//! Influences of the machine and its user on a run: signals, panics, memory, disks, threads, and viewers
//! that show what is rendered.

pub(crate) mod crash;
pub(crate) mod display;
pub(crate) mod interrupt;
pub(crate) mod memory;
pub(crate) mod patience;
pub(crate) mod room;
pub(crate) mod threads;
