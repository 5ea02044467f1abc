//! Which of several processes on one folder renders which frame.
//!
//! A claim is a file beside the picture: the process that makes it first renders the frame.
//! Its owner changes it all the time. If it has not changed for as long as a watcher waits, by the
//! watcher's own clock, the owner is dead, and another process takes the frame over: clocks of two
//! machines are never compared. A claim holds a hash of what the frame is rendered from: two versions
//! of a scene do not share a folder. No lock of the system is needed, so that it works wherever
//! creating a new file, and renaming, are atomic: on local disks, NFS and SMB.
//!
//! The claim belongs to the process whose token it holds. Should two processes render one frame after
//! all, both make the same picture.

mod claim;
mod left;
mod note;
mod pulse;
#[cfg(test)]
mod tests;

pub(crate) use claim::{Claim, Claims, Taken};
pub(crate) use left::Left;
pub(crate) use note::Worker;
