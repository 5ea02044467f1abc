//! `slo-rt import` of a `.gltf` file, with the files that it names.

use crate::readers;

pub(crate) fn run(data: &[u8]) {
    readers::import("a.gltf", data);
}
