//! The program `carom`.

use std::process::ExitCode;

use carom::cli::{exhaustion::Reporting, program};

/// Reports exhausted memory as an error, in one line and with exit code 1.
#[global_allocator]
static ALLOCATOR: Reporting = Reporting;

fn main() -> ExitCode {
    program(|| None)
}
