//! What lies under the name of a file that is to be written.

mod found;
mod origin;

pub use found::{Found, find_picture, find_state, find_timed_picture};
pub use origin::made_by_others;
