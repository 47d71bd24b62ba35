//! The threads that domains run on.

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::Arc;

/// Threads that wait for work; none where everything is done in the one that asks.
#[derive(Debug, Clone)]
pub struct Workers(Option<Arc<ThreadPool>>);

impl Workers {
    /// So many threads, or none if the system gives none.
    pub fn new(threads: usize) -> Self {
        let pool = (threads > 1).then(|| ThreadPoolBuilder::new().num_threads(threads).build().ok()).flatten();
        Self(pool.map(Arc::new))
    }

    /// How many there are, the one that asks being one if it is alone.
    pub fn threads(&self) -> usize {
        self.0.as_ref().map_or(1, |pool| pool.current_num_threads())
    }

    /// Does something on one of the threads: what it has the others do begins sooner from there.
    pub fn within<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.0 {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// Does something with each of some items, and collects the results in their order.
    pub fn each<I: Send, R: Send>(&self, items: Vec<I>, work: impl Fn(I) -> R + Send + Sync) -> Vec<R> {
        match &self.0 {
            Some(pool) if items.len() > 1 => pool.install(|| items.into_par_iter().with_max_len(1).map(work).collect()),
            _ => items.into_iter().map(work).collect(),
        }
    }
}
