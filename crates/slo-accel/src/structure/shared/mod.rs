//! What several structures are made of.

pub(crate) mod order;
pub(crate) mod pages;
pub(crate) mod single;
#[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
pub(crate) mod stops;
