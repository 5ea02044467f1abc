//! A texture in a file of the format OpenEXR.
#![no_main]

use libfuzzer_sys::{Corpus, fuzz_target};
use slo_fuzz::readers;

fuzz_target!(|data: &[u8]| -> Corpus {
    if !data.starts_with(b"\x76\x2f\x31\x01") {
        return Corpus::Reject;
    }
    readers::texture(data);
    Corpus::Keep
});
