//! Prefetching and large memory pages. Both change the speed, but no result.

pub mod pages;
pub mod prefetch;
