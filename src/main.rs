//! The program.

use std::process::ExitCode;

fn main() -> ExitCode {
    pennate::memory::reserve();
    ExitCode::from(pennate::cli::run(std::env::args_os()))
}
