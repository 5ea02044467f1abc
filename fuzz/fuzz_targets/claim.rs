//! Claims on frames and ledgers of times, which other processes leave in a folder.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slo_fuzz::{file, within_limits};
use slo_rt::cli::fuzzing;

fuzz_target!(|data: &[u8]| {
    within_limits(data, |data| {
        let path = file("claim", data);
        fuzzing::read_claim(&path);
        fuzzing::read_ledger(&path);
    });
});
