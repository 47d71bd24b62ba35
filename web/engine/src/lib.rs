//! Carom's engine as WebAssembly. Positions and velocities are bit-identical to the results of the native program.
//!
//! The module has no imports. A page writes a request in JSON into the buffer from [`room`], calls a function, and
//! reads the answer in JSON at [`message`]. [`look`] writes positions and velocities, which the page reads at
//! [`numbers`]. Pointers are valid until the next call. An instance of the module contains one simulation.

mod export;
mod page;

use std::cell::RefCell;

use page::Page;

thread_local! {
    static PAGE: RefCell<Page> = RefCell::default();
}

fn answer(of: impl FnOnce(&mut Page) -> Result<serde_json::Value, serde_json::Value>) -> u32 {
    PAGE.with_borrow_mut(|page| {
        let answer = of(page);
        page.message = answer.as_ref().unwrap_or_else(|error| error).to_string();
        u32::from(answer.is_ok())
    })
}

/// Allocates a request buffer of `length` bytes, and returns its address.
#[unsafe(no_mangle)]
pub extern "C" fn room(length: usize) -> *mut u8 {
    PAGE.with_borrow_mut(|page| {
        page.room = vec![0; length];
        page.room.as_mut_ptr()
    })
}

/// Provides a file that scenes can read. The request buffer contains its name (`name_length` bytes) and its content.
#[unsafe(no_mangle)]
pub extern "C" fn bring(name_length: usize) {
    PAGE.with_borrow_mut(|page| page.bring(name_length));
}

/// Starts the scene `{"text", "changes"}`. Returns 1 and a description, or 0 and the error with its line and a remedy.
#[unsafe(no_mangle)]
pub extern "C" fn start() -> u32 {
    answer(Page::start)
}

/// Checks the scene `{"text", "changes"}` without changing the simulation.
#[unsafe(no_mangle)]
pub extern "C" fn check() -> u32 {
    answer(Page::check)
}

/// Continues with the scene `{"text", "changes"}` from the current state.
#[unsafe(no_mangle)]
pub extern "C" fn change() -> u32 {
    answer(Page::change)
}

/// Changes the position, the velocity or both of the particle `{"id", "position", "velocity"}`.
#[unsafe(no_mangle)]
pub extern "C" fn set() -> u32 {
    answer(Page::set)
}

/// Returns the next events of a copy of the simulation.
#[unsafe(no_mangle)]
pub extern "C" fn upcoming(count: u32) -> u32 {
    answer(|page| page.upcoming(count))
}

/// Returns the scene `{"text"}`, changed to start with the current positions and velocities.
#[unsafe(no_mangle)]
pub extern "C" fn scene() -> u32 {
    answer(Page::scene)
}

/// Returns the current positions of the surfaces.
#[unsafe(no_mangle)]
pub extern "C" fn poses() -> u32 {
    answer(|page| Ok(page.poses()))
}

/// Runs for a number of physical events, or until a simulated time. Returns why the run ended: 0 number of events, 1
/// time, 2 no further events, 3 error, 4 end of the planned run. After 4, the next call continues without a plan.
#[unsafe(no_mangle)]
pub extern "C" fn advance(events: f64, time: f64) -> u32 {
    PAGE.with_borrow_mut(|page| page.advance(events, time)) as u32
}

/// Writes the state to [`numbers`] and [`images`]. Returns the number of values in [`numbers`].
#[unsafe(no_mangle)]
pub extern "C" fn look() -> usize {
    PAGE.with_borrow_mut(Page::look)
}

/// Address of the values written by [`look`].
#[unsafe(no_mangle)]
pub extern "C" fn numbers() -> *const f64 {
    PAGE.with_borrow(|page| page.numbers.as_ptr())
}

/// Address of the image counts written by [`look`]: the periods travelled along x, y and z by each particle.
#[unsafe(no_mangle)]
pub extern "C" fn images() -> *const i32 {
    PAGE.with_borrow(|page| page.images.as_ptr())
}

/// Address of the answer of the last call, in UTF-8.
#[unsafe(no_mangle)]
pub extern "C" fn message() -> *const u8 {
    PAGE.with_borrow(|page| page.message.as_ptr())
}

/// Length of the answer of the last call, in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn message_length() -> usize {
    PAGE.with_borrow(|page| page.message.len())
}
