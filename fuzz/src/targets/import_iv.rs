//! `slo-rt import` of a `.iv` file, with the files that it names.

use crate::readers;

pub(crate) fn run(data: &[u8]) {
    readers::import("a.iv", data);
}
