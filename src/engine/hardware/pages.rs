//! Large pages for large arrays.
//!
//! Events are scattered over memory, and the processor has to look up where each page is. With pages of two megabytes instead of four
//! kilobytes it keeps most of them at hand; that makes a system of 10^5 particles or more a tenth to a fifth faster.

/// Asks for large pages under an array, and under the room that it has, where the system has such. Changes nothing but speed.
pub fn enlarge<T>(array: &Vec<T>) {
    #[cfg(target_os = "linux")]
    {
        const PAGE: usize = 2 << 20;
        let start = array.as_ptr() as usize;
        let first = start.next_multiple_of(PAGE);
        let last = |elements: usize| (start + elements * size_of::<T>()) / PAGE * PAGE;
        // The filled part is moved to large pages at once.
        for (last, advice) in [(last(array.capacity()), libc::MADV_HUGEPAGE), (last(array.len()), libc::MADV_COLLAPSE)]
        {
            if first < last {
                // SAFETY: advice about whole pages within the array's room changes none of its bytes; a system without them says so.
                unsafe { libc::madvise(first as *mut libc::c_void, last - first, advice) };
            }
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = array;
}
