//! Things of another scene, taken over into the text with all that they need.

mod catalog;
mod edit;
mod needs;
#[cfg(test)]
mod tests;

pub(crate) use catalog::{Catalog, Sort, Thing};
pub(crate) use edit::{Merged, merge};
