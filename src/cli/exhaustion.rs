//! What happens when memory or the room for files ends.
//!
//! Where memory ends, Rust aborts, with a signal and a core dump. A program that is used from scripts says so in one line and exits with the code of
//! failures instead. What it has written stays, and a run can be resumed from its last checkpoint, as after a kill.

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;

/// The allocator of the system; when memory is exhausted, it ends the program with a message.
pub struct Reporting;

// SAFETY: every call is the system's, and what it gives is handed on unless it is null.
unsafe impl GlobalAlloc for Reporting {
    #[inline]
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the contract.
        given(unsafe { System.alloc(layout) }, layout.size())
    }

    #[inline]
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the contract.
        given(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    #[inline]
    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller keeps the contract.
        given(unsafe { System.realloc(memory, layout, size) }, size)
    }

    #[inline]
    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract.
        unsafe { System.dealloc(memory, layout) }
    }
}

/// Has large arrays given back to the system when they are freed. By itself the allocator of the GNU system keeps up to 32 MB at a place once it has
/// freed so much, and what is left between arrays that stay is some of the memory of a large system.
pub(super) fn give_back_large_arrays() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        /// Below, it is faster to keep it `[bytes]`.
        const LARGE: libc::c_int = 4 << 20;
        // SAFETY: it sets two numbers of the allocator, before there is a second thread.
        unsafe {
            libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE);
            libc::mallopt(libc::M_TRIM_THRESHOLD, 2 * LARGE);
        }
    }
}

/// Reports a file that may grow no further (`ulimit -f`) as an error of writing, as a full disk is; by itself the system ends the program
/// with a signal.
pub(super) fn report_full_files() {
    #[cfg(target_os = "linux")]
    // SAFETY: it has the signal ignored, before there is a second thread.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
}

/// Takes as much of the stack as the program needs. It grows by itself, and where memory has ended by then the system ends the program with a signal.
#[inline(never)] // else the room would be that of the caller, and what follows beyond it
pub(super) fn take_stack() {
    /// To read a checkpoint takes 0.7 MB `[bytes]`.
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

/// Says that memory has ended, without allocating any, and exits with the code of failures.
#[cold]
#[inline(never)]
fn end(size: usize) -> ! {
    let mut line = [0; 160];
    let mut rest = &mut line[..];
    let _ = writeln!(
        rest,
        "Error: out of memory, {size} bytes more were asked for; what is written is complete up to the last checkpoint"
    );
    let left = rest.len();
    let length = line.len() - left;
    let _ = std::io::stderr().write_all(&line[..length]);
    std::process::exit(1)
}
