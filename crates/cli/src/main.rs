//! The `dsslam` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(dsslam_cli::main(std::env::args_os()))
}
