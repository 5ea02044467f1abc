//! Pictures against theory, against a plain recursive renderer, and against themselves.

mod analytic;
mod any_split;
mod determinism;
mod estimators;
mod oracle;
mod support;
