//! The first failure of a device, which all that use it share.

use std::sync::{Arc, OnceLock};

/// Why a device cannot be used any more, once that is known.
#[derive(Clone, Debug, Default)]
pub(crate) struct Failure(Arc<OnceLock<String>>);

impl Failure {
    /// Notes a failure, unless there was one before.
    pub(crate) fn note(&self, reason: impl Into<String>) {
        // The first one counts: it has caused the others.
        let _ = self.0.set(reason.into());
    }

    /// Returns the failure.
    pub(crate) fn get(&self) -> Option<&str> {
        self.0.get().map(String::as_str)
    }

    /// Returns the failure as an error.
    pub(crate) fn check(&self) -> Result<(), String> {
        self.get().map_or(Ok(()), |reason| Err(reason.to_owned()))
    }
}
