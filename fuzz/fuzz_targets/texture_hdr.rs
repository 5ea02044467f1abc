//! A texture in a file of the format Radiance HDR.
#![no_main]

use libfuzzer_sys::{Corpus, fuzz_target};
use slo_fuzz::readers;

fuzz_target!(|data: &[u8]| -> Corpus {
    if !data.starts_with(b"#?") {
        return Corpus::Reject;
    }
    readers::texture(data);
    Corpus::Keep
});
