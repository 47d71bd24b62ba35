//! Prefetching and large memory pages, which affect only the speed.

pub mod pages;
pub mod prefetch;
