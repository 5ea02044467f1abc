//! A texture in a file of the format OpenEXR.

use libfuzzer_sys::Corpus;
use slo_fuzz::readers;

pub(crate) fn run(data: &[u8]) -> Corpus {
    if !data.starts_with(b"\x76\x2f\x31\x01") {
        return Corpus::Reject;
    }
    readers::texture(data);
    Corpus::Keep
}
