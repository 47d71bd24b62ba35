//! Hardware: prefetching and large pages. Neither changes a result.

pub mod pages;
pub mod prefetch;
