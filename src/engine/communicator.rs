use std::fmt;

/// Sends messages between processes that simulate a system together, for example with MPI.
///
/// All processes must make the same calls in the same order: they start from the same scene, have the same instruments,
/// and advance to the same times. Each process runs a share of the domains. All results of a
/// [`Simulation`](super::Simulation) are equal in all processes.
pub trait Communicator: fmt::Debug + Send + Sync {
    /// Index of this process, from 0.
    fn rank(&self) -> usize;

    /// Number of processes.
    fn size(&self) -> usize;

    /// Sends `messages[rank]` to each process, and returns the bytes received from each process, by rank.
    fn exchange(&self, messages: Vec<Vec<u8>>) -> Vec<Vec<u8>>;

    /// Sends the same bytes to all processes, and returns the bytes received from each process, by rank.
    fn share(&self, message: Vec<u8>) -> Vec<Vec<u8>> {
        self.exchange(vec![message; self.size()])
    }

    /// Ends all processes, because this process cannot continue.
    fn abort(&self, reason: &str) -> !;
}

#[cfg(test)]
pub mod tests {
    use super::Communicator;
    use std::sync::mpsc::{Receiver, Sender, channel};
    use std::sync::{Arc, Mutex};

    #[derive(Debug)]
    struct Channels {
        rank: usize,
        to: Vec<Sender<Vec<u8>>>,
        from: Vec<Mutex<Receiver<Vec<u8>>>>,
    }

    impl Communicator for Channels {
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

    /// Runs a function in `count` threads that act as processes.
    pub fn in_processes<R: Send>(count: usize, work: impl Fn(Arc<dyn Communicator>) -> R + Send + Sync) -> Vec<R> {
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
