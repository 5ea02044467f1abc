//! Every fuzzer for a moment, without libFuzzer: what it begins with, and random changes of it.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use slo_fuzz::{ALL, Run, changed, prepare, remove_folder, seeds};

/// Changed inputs of each fuzzer.
const INPUTS: usize = 1000;

/// The same of slow fuzzers.
const INPUTS_OF_SLOW: [(&str, usize); 3] = [("edit", 100), ("structures", 100), ("splits", 20)];

// One test: memory is counted for the whole process, and one thread does all work.
#[test]
fn changed_inputs_break_no_promise() {
    prepare();
    let folder = tempfile::tempdir().expect("a folder");
    seeds::write_all(folder.path());
    for (name, run) in ALL {
        let slow = INPUTS_OF_SLOW.iter().find(|(slow, _)| slow == name);
        let inputs = slow.map_or(INPUTS, |(_, inputs)| *inputs);
        let seeds = read(&folder.path().join(name));
        assert!(!seeds.is_empty(), "{name} has nothing to begin with");
        seeds.iter().for_each(|seed| check(name, *run, seed));
        let mut rng = StdRng::seed_from_u64(7);
        for _ in 0..inputs {
            let [one, other] = [(); 2].map(|()| &seeds[rng.random_range(0..seeds.len())]);
            let input = changed(&mut rng, one, other);
            check(name, *run, &input);
        }
    }
    remove_folder();
}

fn read(folder: &Path) -> Vec<Vec<u8>> {
    let files = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<_> = files.map(|file| file.path()).collect();
    paths.sort();
    paths.iter().map(|path| fs::read(path).expect("a file")).collect()
}

/// Runs a fuzzer; keeps an input that breaks a promise.
fn check(name: &str, run: Run, input: &[u8]) {
    if catch_unwind(AssertUnwindSafe(|| run(input))).is_err() {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("broken-{name}"));
        fs::write(&path, input).expect("a file");
        panic!("{name} breaks a promise with {}", path.display());
    }
}
