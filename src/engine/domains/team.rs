use crate::base::numbers::trunc_to_u32;
use crate::engine::communicator::Communicator;
use crate::model::Threads;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Threads of this process, and its connection to other processes. Each process has the same number of domains.
#[derive(Debug, Clone)]
pub struct Team {
    /// Worker threads; `None` if the calling thread does all work.
    pool: Option<Arc<ThreadPool>>,
    communicator: Option<Arc<dyn Communicator>>,
    /// Number of domains of each process.
    share: usize,
    sent: Arc<AtomicU64>,
}

impl Team {
    /// Creates a team with `domains` domains in each process, up to 64 in all.
    pub fn new(domains: usize, threads: usize, communicator: Option<Arc<dyn Communicator>>) -> Self {
        let processes = communicator.as_ref().map_or(1, |communicator| communicator.size());
        let share = domains.clamp(1, (Threads::MOST / processes).max(1));
        let pool = (threads > 1).then(|| ThreadPoolBuilder::new().num_threads(threads).build().ok()).flatten();
        Self { pool: pool.map(Arc::new), communicator, share, sent: Arc::default() }
    }

    pub fn sent(&self) -> u64 {
        self.sent.load(Ordering::Relaxed)
    }

    fn count_sent(&self, bytes: usize) {
        self.sent.fetch_add(bytes as u64, Ordering::Relaxed);
    }

    /// Number of domains in all processes.
    pub fn domains(&self) -> usize {
        self.share * self.communicator.as_ref().map_or(1, |communicator| communicator.size())
    }

    pub fn numbers(&self) -> Range<usize> {
        let rank = self.communicator.as_ref().map_or(0, |communicator| communicator.rank());
        rank * self.share..(rank + 1) * self.share
    }

    fn domains_of(&self, rank: usize) -> u64 {
        (rank * self.share..(rank + 1) * self.share).fold(0, |set, domain| set | 1 << domain)
    }

    pub fn has_others(&self) -> bool {
        self.communicator.is_some()
    }

    pub fn busy_threads(&self, domains: usize) -> u32 {
        let threads = self.pool.as_ref().map_or(1, |pool| pool.current_num_threads());
        trunc_to_u32(threads.min(domains).max(1) as f64)
    }

    /// Runs `work` on a worker thread, from which parallel work starts faster.
    pub fn within<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// Returns the results in the order of the items.
    pub fn each<I: Send, R: Send>(&self, items: Vec<I>, work: impl Fn(I) -> R + Send + Sync) -> Vec<R> {
        match &self.pool {
            Some(pool) if items.len() > 1 => pool.install(|| items.into_par_iter().with_max_len(1).map(work).collect()),
            _ => items.into_iter().map(work).collect(),
        }
    }

    /// Sends the items of this process to all processes, and returns the items of all processes, ordered by process.
    pub fn all<T: Serialize + DeserializeOwned>(&self, mine: Vec<T>) -> Vec<T> {
        let Some(communicator) = &self.communicator else { return mine };
        let message = encode(&**communicator, &mine);
        self.count_sent(message.len() * (communicator.size() - 1));
        let shared = communicator.share(message);
        shared.iter().flat_map(|bytes| decode::<Vec<T>>(&**communicator, bytes)).collect()
    }

    /// Exchanges messages between processes. Returns the messages to the domains of this process, ordered by sender.
    /// `to` returns the set of domains that receive a message.
    pub fn deliver<T: Serialize + DeserializeOwned>(&self, mine: Vec<T>, to: impl Fn(&T) -> u64) -> Vec<T> {
        let Some(communicator) = &self.communicator else { return mine };
        let of_rank = |rank: usize| {
            let domains = self.domains_of(rank);
            let messages: Vec<&T> = mine.iter().filter(|message| to(message) & domains != 0).collect();
            encode(&**communicator, &messages)
        };
        let messages: Vec<Vec<u8>> = (0..communicator.size()).map(of_rank).collect();
        self.count_sent(messages.iter().map(Vec::len).sum::<usize>() - messages[communicator.rank()].len());
        let received = communicator.exchange(messages);
        received.iter().flat_map(|bytes| decode::<Vec<T>>(&**communicator, bytes)).collect()
    }
}

fn encode<T: Serialize>(communicator: &dyn Communicator, message: &T) -> Vec<u8> {
    postcard::to_stdvec(message)
        .unwrap_or_else(|error| communicator.abort(&format!("a message cannot be written: {error}")))
}

fn decode<T: DeserializeOwned>(communicator: &dyn Communicator, bytes: &[u8]) -> T {
    postcard::from_bytes(bytes).unwrap_or_else(|error| {
        communicator.abort(&format!("cannot read the message of another process, which is out of step: {error}"))
    })
}
