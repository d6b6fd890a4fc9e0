//! The program.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(pennate::cli::run(std::env::args_os()))
}
