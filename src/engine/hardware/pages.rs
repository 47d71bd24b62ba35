//! Large pages for large arrays.
//!
//! Events are scattered over memory, and the processor has to look up where each page is. With pages of two megabytes instead of four
//! kilobytes it keeps most of them at hand; that makes a system of 10^5 particles or more a tenth to a fifth faster.

/// Asks for large pages under an array that has just been filled, where the system has such. Changes nothing but speed.
pub fn enlarge<T>(array: &[T]) {
    #[cfg(target_os = "linux")]
    {
        const PAGE: usize = 2 << 20;
        let bytes = array.as_ptr_range();
        let first = (bytes.start as usize).next_multiple_of(PAGE);
        let last = bytes.end as usize / PAGE * PAGE;
        if first < last {
            // SAFETY: advice about whole pages within the array changes none of its bytes; a system without them says so.
            unsafe {
                libc::madvise(first as *mut libc::c_void, last - first, libc::MADV_HUGEPAGE);
                libc::madvise(first as *mut libc::c_void, last - first, libc::MADV_COLLAPSE);
            }
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = array;
}

/// Asks for large pages under the room that an array has, before it is filled.
pub fn enlarge_room<T>(array: &Vec<T>) {
    #[cfg(target_os = "linux")]
    {
        const PAGE: usize = 2 << 20;
        let first = (array.as_ptr() as usize).next_multiple_of(PAGE);
        let last = (array.as_ptr() as usize + array.capacity() * size_of::<T>()) / PAGE * PAGE;
        if first < last {
            // SAFETY: advice about whole pages of the array's room changes nothing in it.
            unsafe { libc::madvise(first as *mut libc::c_void, last - first, libc::MADV_HUGEPAGE) };
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = array;
}
