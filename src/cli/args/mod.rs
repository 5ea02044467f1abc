//! The command line as typed.

mod commands;
mod help;
mod parse;
mod program;
mod settings;
mod short_forms;
#[cfg(test)]
mod tests;
mod tips;

pub(crate) use commands::{
    BakeArgs, Command, CompareArgs, DenoiseArgs, GenerateArgs, GenerateWhat, ImportArgs, MergeArgs,
    RelightArgs, SheetArgs, VerifyArgs, ViewArgs, WhyArgs,
};
pub(crate) use parse::{command_line, parse};
pub(crate) use program::Args;
pub(crate) use settings::{LookArgs, SettingArgs};
