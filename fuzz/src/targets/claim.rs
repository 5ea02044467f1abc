//! Claims on frames and ledgers of times, which other processes leave in a folder.

use crate::{file, within_limits};
use slo_rt::cli::fuzzing;

pub(crate) fn run(data: &[u8]) {
    within_limits(data, |data| {
        let path = file("claim", data);
        fuzzing::read_claim(&path);
        fuzzing::read_ledger(&path);
    });
}
