//! The program: calls the library's command line and hands its result to the system.

use std::process::ExitCode;

fn main() -> ExitCode {
    slo_rt::cli::run(std::env::args_os()).into()
}
