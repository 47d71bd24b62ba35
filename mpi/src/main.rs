//! The program `carom-mpi`. It has all commands of `carom`. The command `run` uses all processes that `mpiexec` starts.

use std::process::ExitCode;
use std::sync::Arc;

use carom::cli::{exhaustion::Reporting, program};
use carom::engine::Communicator;
use carom_mpi::Mpi;

/// Reports a lack of memory as an error, with exit code 1.
#[global_allocator]
static ALLOCATOR: Reporting = Reporting;

fn main() -> ExitCode {
    program(|| Mpi::join().map(|mpi| Arc::new(mpi) as Arc<dyn Communicator>))
}
