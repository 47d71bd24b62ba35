//! The program `carom`.

use std::process::ExitCode;

use carom::cli::{self, exhaustion};

/// Memory that ends is an error like any other, with exit code 1.
#[global_allocator]
static ALLOCATOR: exhaustion::Reporting = exhaustion::Reporting;

fn main() -> ExitCode {
    exhaustion::take_stack();
    exhaustion::give_back_large_arrays();
    let arguments: Vec<_> = std::env::args_os().collect();
    ExitCode::from(cli::main(&arguments, || None))
}
