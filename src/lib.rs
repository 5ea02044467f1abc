//! slo-rt: a distributed ray tracer for animations.

pub mod cli;
