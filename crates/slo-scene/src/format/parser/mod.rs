//! Tokens -> syntax tree. Never stops at an error: what is broken is reported, the rest is kept.

mod ahead;
mod braces;
mod brackets;
mod foreign;
mod names;
mod state;
#[cfg(test)]
mod tests;

pub use names::written;
pub use state::parse;
