//! MPI processes that simulate one system together: see `docs/parallel.md`.

use carom::engine::Communicator;
use mpi::Threading;
use mpi::datatype::{Partition, PartitionMut};
use mpi::environment::Universe;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator as _, CommunicatorCollectives};
use std::fmt;
use std::io::Write;

/// Environment variables that `mpiexec` and batch systems set.
const STARTED: [&str; 4] = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK", "MPI_LOCALNRANKS"];

/// All processes that `mpiexec` has started together (`MPI_COMM_WORLD`). Dropping this value finalises MPI.
pub struct Mpi {
    _universe: Universe,
    rank: usize,
    size: usize,
}

impl Mpi {
    /// Joins the other processes. Returns `None` if there are no other processes, or if this process has joined before.
    ///
    /// Use the communicator from one thread at a time.
    #[must_use]
    pub fn join() -> Option<Self> {
        if STARTED.iter().all(|name| std::env::var_os(name).is_none()) {
            return None;
        }
        let (universe, _) = mpi::initialize_with_threading(Threading::Serialized)?;
        let world = universe.world();
        let [rank, size] = [world.rank(), world.size()].map(|number| usize::try_from(number).unwrap_or(0));
        (size > 1).then_some(Self { _universe: universe, rank, size })
    }

    /// Returns the counts and offsets that MPI needs, and the total length.
    fn offsets(&self, lengths: &[u64]) -> (Vec<i32>, Vec<i32>, usize) {
        let (mut counts, mut offsets, mut sum) = (Vec::new(), Vec::new(), 0_usize);
        for &length in lengths {
            let end = usize::try_from(length).ok().and_then(|length| sum.checked_add(length));
            let [count, offset] = [i32::try_from(length).ok(), i32::try_from(sum).ok()];
            let (Some(end), Some(count), Some(offset)) = (end, count, offset) else {
                self.abort("messages of more than 2 GB");
            };
            counts.push(count);
            offsets.push(offset);
            sum = end;
        }
        (counts, offsets, sum)
    }
}

/// Allocates even for an empty vector. An empty `Vec<u8>` has the address 1, which is `MPI_IN_PLACE` in Open MPI.
fn at_an_address(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.reserve(1);
    bytes
}

fn pieces(mut bytes: &[u8], lengths: &[i32]) -> Vec<Vec<u8>> {
    let mut piece = |length: &i32| {
        let (piece, rest) = bytes.split_at(usize::try_from(*length).unwrap_or(0));
        bytes = rest;
        piece.to_vec()
    };
    lengths.iter().map(&mut piece).collect()
}

impl Communicator for Mpi {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn exchange(&self, messages: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        let world = SimpleCommunicator::world();
        let lengths: Vec<u64> = messages.iter().map(|message| message.len() as u64).collect();
        let mut coming = vec![0; self.size];
        world.all_to_all_into(&lengths[..], &mut coming[..]);
        let (counts, offsets, _) = self.offsets(&lengths);
        let sent = at_an_address(messages.concat());
        let (coming, places, sum) = self.offsets(&coming);
        let mut received = at_an_address(vec![0; sum]);
        world.all_to_all_varcount_into(
            &Partition::new(&sent[..], counts, offsets),
            &mut PartitionMut::new(&mut received[..], &coming[..], places),
        );
        pieces(&received, &coming)
    }

    fn share(&self, message: Vec<u8>) -> Vec<Vec<u8>> {
        let world = SimpleCommunicator::world();
        let message = at_an_address(message);
        let mut coming = vec![0; self.size];
        world.all_gather_into(&(message.len() as u64), &mut coming[..]);
        let (coming, places, sum) = self.offsets(&coming);
        let mut received = at_an_address(vec![0; sum]);
        world.all_gather_varcount_into(&message[..], &mut PartitionMut::new(&mut received[..], &coming[..], places));
        pieces(&received, &coming)
    }

    fn abort(&self, reason: &str) -> ! {
        let _ = writeln!(std::io::stderr().lock(), "process {} of {}: {reason}", self.rank, self.size);
        SimpleCommunicator::world().abort(1)
    }
}

impl fmt::Debug for Mpi {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Mpi").field("rank", &self.rank).field("size", &self.size).finish_non_exhaustive()
    }
}
