//! Prefetching and large memory pages, which affect only the speed.

pub mod pages;
pub mod prefetch;

use super::array::Array;

/// The memory of successive elements.
pub struct Extent<T> {
    pub first: *const T,
    /// Number of elements, and number of elements for which there is memory.
    #[cfg_attr(not(target_os = "linux"), allow(dead_code, reason = "large pages are requested only on Linux"))]
    pub filled: usize,
    #[cfg_attr(not(target_os = "linux"), allow(dead_code, reason = "as above"))]
    pub capacity: usize,
}

/// Arrays of successive elements in memory.
pub trait Memory {
    type Element;

    fn extent(&self) -> Extent<Self::Element>;
}

impl<T> Memory for Vec<T> {
    type Element = T;

    #[inline(always)]
    fn extent(&self) -> Extent<T> {
        Extent { first: self.as_ptr(), filled: self.len(), capacity: self.capacity() }
    }
}

impl<T> Memory for Array<T> {
    type Element = T;

    #[inline(always)]
    fn extent(&self) -> Extent<T> {
        Extent { first: self.as_ptr(), filled: self.len(), capacity: self.capacity() }
    }
}
