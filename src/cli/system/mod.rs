//! Influences of the machine and its user on a run: signals, panics, memory, disks, threads.

pub(crate) mod crash;
pub(crate) mod interrupt;
pub(crate) mod memory;
pub(crate) mod patience;
pub(crate) mod room;
pub(crate) mod threads;
