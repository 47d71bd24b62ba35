//! The program `carom` for MPI: everything that `carom` does, and `carom-mpi run` in as many processes as
//! `mpiexec` starts.

use std::process::ExitCode;
use std::sync::Arc;

use carom::cli::{exhaustion::Reporting, program};
use carom::engine::Communicator;
use carom_mpi::Mpi;

/// Running out of memory is an error like any other, with exit code 1.
#[global_allocator]
static ALLOCATOR: Reporting = Reporting;

fn main() -> ExitCode {
    program(|| Mpi::join().map(|mpi| Arc::new(mpi) as Arc<dyn Communicator>))
}
