//! Locks that a panic elsewhere leaves usable.

use std::sync::{Mutex, MutexGuard};

/// Sums are whole at every moment, so a panic elsewhere leaves nothing broken behind a lock.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}
