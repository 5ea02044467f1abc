//! A texture in a file of the format Radiance HDR.

use libfuzzer_sys::Corpus;
use slo_fuzz::readers;

pub(crate) fn run(data: &[u8]) -> Corpus {
    if !data.starts_with(b"#?") {
        return Corpus::Reject;
    }
    readers::texture(data);
    Corpus::Keep
}
