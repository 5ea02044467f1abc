//! Validated options: what the commands work with.

mod job;
mod overrides;
mod replay;
mod task;
#[cfg(test)]
mod test_scene;

pub(crate) use job::Job;
pub(crate) use replay::Replay;
pub(crate) use task::{Options, Task};
#[cfg(test)]
pub(crate) use test_scene::{empty_scene, job};
