//! Messages between processes that simulate one system together.

use std::fmt;

/// Carrier of messages between processes that simulate one system together: MPI, or anything else that brings bytes from each to each.
///
/// All processes do the same in the same order: they begin with the same scene, have the same instruments, and advance to the same times. Then each has
/// some of the domains, and all that a [`Simulation`](super::Simulation) tells is the same in each of them.
pub trait Transport: fmt::Debug + Send + Sync {
    /// The number of this process, from 0.
    fn rank(&self) -> usize;

    /// Number of processes.
    fn size(&self) -> usize;

    /// Sends each process the bytes that are for it, by rank, and returns what came from each. Returns when all have come.
    fn exchange(&self, messages: Vec<Vec<u8>>) -> Vec<Vec<u8>>;

    /// Sends all processes the same bytes, and returns what came from each, by rank.
    fn share(&self, message: Vec<u8>) -> Vec<Vec<u8>> {
        self.exchange(vec![message; self.size()])
    }

    /// Ends all processes, because this one cannot go on.
    fn abort(&self, reason: &str) -> !;
}

#[cfg(test)]
pub mod tests {
    use super::Transport;
    use std::sync::mpsc::{Receiver, Sender, channel};
    use std::sync::{Arc, Mutex};

    /// Threads as processes.
    #[derive(Debug)]
    struct Channels {
        rank: usize,
        to: Vec<Sender<Vec<u8>>>,
        from: Vec<Mutex<Receiver<Vec<u8>>>>,
    }

    impl Transport for Channels {
        fn rank(&self) -> usize {
            self.rank
        }

        fn size(&self) -> usize {
            self.to.len()
        }

        fn exchange(&self, messages: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
            self.to.iter().zip(messages).for_each(|(to, message)| to.send(message).unwrap());
            self.from.iter().map(|from| from.lock().unwrap().recv().unwrap()).collect()
        }

        fn abort(&self, reason: &str) -> ! {
            panic!("{reason}")
        }
    }

    /// Runs a function in a number of processes. Returns the result of each.
    pub fn in_processes<R: Send>(count: usize, work: impl Fn(Arc<dyn Transport>) -> R + Send + Sync) -> Vec<R> {
        let mut processes: Vec<Channels> =
            (0..count).map(|rank| Channels { rank, to: Vec::new(), from: Vec::new() }).collect();
        for from in 0..count {
            for to in 0..count {
                let (sender, receiver) = channel();
                processes[from].to.push(sender);
                processes[to].from.push(Mutex::new(receiver));
            }
        }
        let work = &work;
        std::thread::scope(|scope| {
            let begin = |process: Channels| scope.spawn(move || work(Arc::new(process)));
            let threads: Vec<_> = processes.into_iter().map(begin).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        })
    }
}
