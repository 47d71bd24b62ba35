//! The program `carom`.

use std::process::ExitCode;

use carom::cli::{exhaustion::Reporting, program};

/// Running out of memory is an error like any other, with exit code 1.
#[global_allocator]
static ALLOCATOR: Reporting = Reporting;

fn main() -> ExitCode {
    program(|| None)
}
