//! All fuzzers in one program: what takes long is to compile and link what they fuzz.
//!
//! `SLO_FUZZ_TARGET` names the one that runs. `SLO_FUZZ_SEEDS` names a folder; the inputs that fuzzing begins
//! with are written to it, and nothing runs. libFuzzer takes the arguments.
#![no_main]

use std::path::Path;
use std::sync::OnceLock;

use libfuzzer_sys::{Corpus, fuzz_target};
use slo_fuzz::{ALL, Run, Worth, seeds};

static CHOSEN: OnceLock<Run> = OnceLock::new();

fuzz_target!(
    init: begin(),
    |data: &[u8]| -> Corpus {
        match CHOSEN.get().map(|run| run(data)) {
            Some(Worth::Kept) => Corpus::Keep,
            Some(Worth::Nothing) | None => Corpus::Reject,
        }
    }
);

/// Does what the environment asks for. Ends the program unless a fuzzer is to run.
fn begin() {
    if let Some(folder) = std::env::var_os("SLO_FUZZ_SEEDS") {
        seeds::write_all(Path::new(&folder));
        std::process::exit(0);
    }
    let name = std::env::var("SLO_FUZZ_TARGET").unwrap_or_default();
    let Some((_, run)) = ALL.iter().find(|(known, _)| *known == name) else {
        let names: Vec<_> = ALL.iter().map(|(name, _)| *name).collect();
        eprintln!("SLO_FUZZ_TARGET must be one of {}", names.join(", "));
        std::process::exit(2);
    };
    CHOSEN.get_or_init(|| *run);
}
