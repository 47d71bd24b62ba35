//! The program `carom` for processes of MPI: all that it does, and `carom-mpi run` in as many processes as `mpiexec` starts.

use std::process::ExitCode;
use std::sync::Arc;

use carom::cli::{self, exhaustion};
use carom::engine::Transport;
use carom_mpi::Mpi;

/// Memory that ends is an error like any other, with exit code 1.
#[global_allocator]
static ALLOCATOR: exhaustion::Reporting = exhaustion::Reporting;

fn main() -> ExitCode {
    exhaustion::take_stack();
    exhaustion::give_back_large_arrays();
    let arguments: Vec<_> = std::env::args_os().collect();
    ExitCode::from(cli::main(&arguments, || Mpi::join().map(|mpi| Arc::new(mpi) as Arc<dyn Transport>)))
}
