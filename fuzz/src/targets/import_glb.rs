//! `slo-rt import` of a `.glb` file, with the files that it names.

use crate::readers;

pub(crate) fn run(data: &[u8]) {
    readers::import("a.glb", data);
}
