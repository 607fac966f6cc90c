//! The program `isolux`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(isolux::run(std::env::args_os()))
}
