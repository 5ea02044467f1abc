//! Tests from outside: the library's public face and the program itself.

mod analytic;
mod any_split;
mod determinism;
mod estimators;
mod oracle;
mod program;
mod scene_fuzz;
mod scene_language;
mod scene_mistakes;
mod support;
