//! `slo-rt import` of a `.glb` file, with the files that it names.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slo_fuzz::readers;

fuzz_target!(|data: &[u8]| readers::import("a.glb", data));
