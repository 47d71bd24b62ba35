//! Behaviour when memory or disk space is exhausted.
//!
//! By default, Rust aborts with a core dump when memory is exhausted. Carom prints one line and exits with the code of
//! a failure. The run can be resumed from its last checkpoint.

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;

/// The system's allocator, which ends the program with a message when memory is exhausted.
pub struct Reporting;

// SAFETY: every call is forwarded to the system, and its result is returned unless it is null.
unsafe impl GlobalAlloc for Reporting {
    #[inline]
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller fulfils the contract of `alloc`, which is also the contract of this call.
        given(unsafe { System.alloc(layout) }, layout.size())
    }

    #[inline]
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller fulfils the contract of `alloc_zeroed`, which is also the contract of this call.
        given(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    #[inline]
    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller fulfils the contract of `realloc`, which is also the contract of this call.
        given(unsafe { System.realloc(memory, layout, size) }, size)
    }

    #[inline]
    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller fulfils the contract of `dealloc`, which is also the contract of this call.
        unsafe { System.dealloc(memory, layout) }
    }
}

/// Makes the GNU allocator return large arrays to the system when they are freed. By default, arrays of up to 32 MB are
/// kept, which can be a large part of the memory.
pub(super) fn give_back_large_arrays() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        /// Smallest array to return `[bytes]`. Keeping smaller arrays is faster.
        const LARGE: libc::c_int = 4 << 20;
        // SAFETY: the calls set two parameters of the allocator before there is a second thread.
        unsafe {
            libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE);
            libc::mallopt(libc::M_TRIM_THRESHOLD, 2 * LARGE);
        }
    }
}

/// Turns the signal of a file-size limit (`ulimit -f`), which would end the program, into a write error.
pub(super) fn report_full_files() {
    #[cfg(target_os = "linux")]
    // SAFETY: the call makes the process ignore `SIGXFSZ`, before there is a second thread.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
}

/// Allocates the stack in advance. Without free memory, a growing stack would end the program with a signal.
#[inline(never)] // in the caller's frame, the array would not extend the stack for later calls
pub(super) fn take_stack() {
    /// Allocated stack `[bytes]`. Reading a checkpoint needs 0.7 MB.
    const NEEDED: usize = 3 << 19;
    std::hint::black_box(&mut [0_u8; NEEDED]);
}

#[inline]
fn given(memory: *mut u8, size: usize) -> *mut u8 {
    if memory.is_null() {
        end(size);
    }
    memory
}

/// Reports exhausted memory without allocating memory, and exits.
#[cold]
#[inline(never)]
fn end(size: usize) -> ! {
    let mut line = [0; 160];
    let mut rest = &mut line[..];
    let _ = writeln!(
        rest,
        "Error: out of memory: {size} more bytes were requested; the output is complete up to the last checkpoint"
    );
    let left = rest.len();
    let length = line.len() - left;
    let _ = std::io::stderr().write_all(&line[..length]);
    std::process::exit(1)
}
