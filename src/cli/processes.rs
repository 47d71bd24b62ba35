//! Processes of a `carom run` that was started with MPI.

use std::ffi::OsString;
use std::ops::ControlFlow;
use std::sync::Arc;

use crate::engine::Communicator;
use crate::model::Threads;
use crate::run::Run;

use super::failure::Failure;
use super::signals;

pub fn refuse_others(arguments: &[OsString], communicator: &dyn Communicator) -> Result<(), Failure> {
    let arguments = arguments.iter().flat_map(|argument| [argument.as_encoded_bytes(), b"\0"].concat());
    let all = communicator.share(arguments.collect());
    if all.len() > Threads::MOST {
        let message = format!("{} processes were started together, expected at most {}", all.len(), Threads::MOST);
        return Err(Failure::bad_input(message, Some("start fewer processes, and set --threads for each")));
    }
    if all.iter().all(|other| *other == all[0]) {
        return Ok(());
    }
    let cure = "start all of them with the same arguments, or start each one separately without mpiexec";
    Err(Failure::bad_input("the processes that were started together have different arguments", Some(cure)))
}

/// Simulates together with the first process, which prints all messages.
pub fn take_part(communicator: &Arc<dyn Communicator>) -> Result<(), Failure> {
    let Some(run) = Run::shared(None, communicator) else { return Ok(()) };
    signals::watch();
    // Signals are ignored here, because the first process also receives them and ends the run.
    let result = run.execute(&mut (), &mut |_| {
        let _ = signals::flow();
        ControlFlow::Continue(())
    });
    result.map(|_| ()).map_err(|error| Failure::failed(error.to_string(), None))
}
