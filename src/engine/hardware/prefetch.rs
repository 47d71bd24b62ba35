//! Prefetching: the processor loads data before they are needed.
//!
//! Successive events are far apart in memory. Without prefetching, a large system waits for memory most of the time.

use super::Memory;

/// Begins to load an element of an array into the cache. An index beyond the array is harmless.
#[inline(always)]
pub fn prefetch(array: &impl Memory, index: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let address = array.extent().first.wrapping_add(index);
        // SAFETY: a prefetch never changes the state of the program, even if the address is invalid.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(address.cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (array, index);
}

/// Prefetches an element that fills two cache lines.
#[inline(always)]
pub fn prefetch_both(array: &impl Memory, index: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let address = array.extent().first.wrapping_add(index).cast::<i8>();
        // SAFETY: as above.
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(address);
            _mm_prefetch::<_MM_HINT_T0>(address.wrapping_add(64));
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (array, index);
}
