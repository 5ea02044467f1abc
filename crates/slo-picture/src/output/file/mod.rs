//! Files, whatever is in them.

mod atomic;
mod candid;

pub use atomic::{
    check_free, check_writable, open_regular, remove_abandoned, remove_leftovers, sweep_abandoned,
    write_atomically, write_new,
};
pub(super) use candid::Candid;
