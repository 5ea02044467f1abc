//! A texture in a file of the format JPEG.
#![no_main]

use libfuzzer_sys::{Corpus, fuzz_target};
use slo_fuzz::readers;

fuzz_target!(|data: &[u8]| -> Corpus {
    if !data.starts_with(b"\xff\xd8\xff") {
        return Corpus::Reject;
    }
    readers::texture(data);
    Corpus::Keep
});
