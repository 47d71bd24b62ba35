//! The program `carom`.

use std::process::ExitCode;

use carom::cli::{exhaustion::Reporting, program};

/// Reports exhausted memory like any other error: one line and exit code 1.
#[global_allocator]
static ALLOCATOR: Reporting = Reporting;

fn main() -> ExitCode {
    program(|| None)
}
