//! A run on several processes.

use std::sync::Arc;

use super::{Run, RunState};
use crate::analysis::instruments::Registry;
use crate::engine::{Simulation, Transport};

/// Bytes that are sent at once.
const PIECE: usize = 1 << 26;

impl Run {
    /// Spreads the run over processes that all have put it together in the same way, each with as many threads: [`Simulation::set_transport`].
    ///
    /// The results are the same in all of them, with the bits of one process. What a recorder decides (to pause for a checkpoint, that no more can be kept)
    /// and what `watch` returns holds of the first process; the recorders of others need not keep anything.
    pub fn transport(mut self, transport: Arc<dyn Transport>) -> Self {
        self.simulation.set_transport(transport);
        self
    }

    /// Gives a run that one process has put together to all: what the first one calls this with, all of them have then, spread over them. Instruments of
    /// one's own are not sent.
    pub fn shared(run: Option<Self>, transport: &Arc<dyn Transport>) -> Option<Self> {
        let mut content = Vec::new();
        if let Some(run) = &run {
            content = postcard::to_stdvec(&(&run.simulation, &run.state, run.is_new))
                .unwrap_or_else(|error| transport.abort(&format!("the run cannot be sent: {error}")));
        }
        let mut received = Vec::new();
        let mut pieces = content.chunks(PIECE);
        loop {
            let piece = pieces.next().unwrap_or_default();
            let mut all = transport.share(if transport.rank() == 0 { piece.to_vec() } else { Vec::new() });
            let first = all.swap_remove(0);
            if first.is_empty() {
                break;
            }
            if transport.rank() > 0 {
                received.extend(first);
            }
        }
        if transport.rank() == 0 {
            return run.map(|run| run.transport(transport.clone()));
        }
        if received.is_empty() {
            return None;
        }
        let (simulation, state, is_new): (Simulation, RunState, bool) =
            postcard::from_bytes(&received).unwrap_or_else(|error| {
                transport.abort(&format!("the run cannot be read, by another program perhaps: {error}"))
            });
        simulation.enlarge();
        Some(Self { simulation, state, registry: Registry::default(), is_new }.transport(transport.clone()))
    }
}
