//! What the machine and its user do to a run: signals, panics, memory, disks, threads.

pub(crate) mod crash;
pub(crate) mod interrupt;
pub(crate) mod memory;
pub(crate) mod patience;
pub(crate) mod room;
pub(crate) mod threads;
