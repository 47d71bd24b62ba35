//! The program `carom`.

mod cli;
mod exhaustion;

use std::process::ExitCode;

/// Memory that ends is an error like any other, with exit code 1.
#[global_allocator]
static ALLOCATOR: exhaustion::Reporting = exhaustion::Reporting;

fn main() -> ExitCode {
    exhaustion::take_stack();
    exhaustion::give_back_large_arrays();
    cli::main()
}
