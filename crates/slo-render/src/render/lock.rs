//! Locks that a panic elsewhere leaves usable.

use std::sync::{Mutex, MutexGuard};

/// Locks a mutex, even if a thread has panicked. Sums are consistent at every moment, so a panic
/// leaves nothing broken behind a lock.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}
