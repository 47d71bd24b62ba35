//! Prefetching and large memory pages. They affect the speed, but not the results.

pub mod pages;
pub mod prefetch;
