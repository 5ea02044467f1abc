//! Decides which of several processes on one folder renders which frame.
//!
//! A claim is a file beside the picture. The process that makes it first renders the frame, and
//! changes the file at regular intervals. If the file has not changed for as long as a watcher
//! waits, its owner counts as dead, and another process takes over the frame. Each watcher uses
//! its own clock: clocks of two machines are never compared. A claim holds a hash of what the
//! frame is rendered from, because two versions of a scene can't share a folder. No system lock is
//! needed. Claims work wherever creating a new file and renaming are atomic: on local disks, NFS
//! and SMB.
//!
//! A claim belongs to the process whose token it holds. If two processes render one frame after
//! all, both make the same picture.

mod claim;
mod left;
mod note;
mod pulse;
#[cfg(test)]
mod tests;

pub(crate) use claim::{Claim, Claims, Taken};
pub(crate) use left::Left;
pub(crate) use note::{Worker, owner_of};
