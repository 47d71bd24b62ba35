//! Prefetching and large memory pages, which affect only the speed.

pub mod pages;
pub mod prefetch;

use super::array::Array;

/// Successive elements in memory.
#[cfg_attr(not(target_os = "linux"), allow(dead_code, reason = "large pages are requested only on Linux"))]
pub trait Memory {
    type Element;

    /// Address of the first element.
    fn start(&self) -> *const Self::Element;

    /// Number of elements.
    fn filled(&self) -> usize;

    /// Number of elements for which there is memory.
    fn room(&self) -> usize;
}

impl<T> Memory for Vec<T> {
    type Element = T;

    #[inline(always)]
    fn start(&self) -> *const T {
        self.as_ptr()
    }

    fn filled(&self) -> usize {
        self.len()
    }

    fn room(&self) -> usize {
        self.capacity()
    }
}

impl<T> Memory for Array<T> {
    type Element = T;

    #[inline(always)]
    fn start(&self) -> *const T {
        self.as_ptr()
    }

    fn filled(&self) -> usize {
        self.len()
    }

    fn room(&self) -> usize {
        self.capacity()
    }
}
