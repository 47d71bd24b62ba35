//! Carom's engine as WebAssembly: the text of a scene goes in, positions and velocities come out, with the bits of the program.
//!
//! The module has no imports. A page writes a request in JSON into [`room`], makes a call, and reads the answer in JSON at [`message`]; positions and
//! velocities are at [`numbers`] after [`look`]. Pointers hold until the next call. One simulation at a time; a page that wants several makes as many
//! instances.

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

/// Room for a request of a number of bytes.
#[unsafe(no_mangle)]
pub extern "C" fn room(length: usize) -> *mut u8 {
    PAGE.with_borrow_mut(|page| {
        page.room = vec![0; length];
        page.room.as_mut_ptr()
    })
}

/// Gives scenes a file: the room holds its name, with a number of bytes, and then its content.
#[unsafe(no_mangle)]
pub extern "C" fn bring(name_length: usize) {
    PAGE.with_borrow_mut(|page| page.bring(name_length));
}

/// Starts the scene `{"text", "changes"}`: 1, and what there is in it; or 0, and the error, its line and its cure.
#[unsafe(no_mangle)]
pub extern "C" fn start() -> u32 {
    answer(Page::start)
}

/// Whether the scene `{"text", "changes"}` has no mistake; the simulation stays as it is.
#[unsafe(no_mangle)]
pub extern "C" fn check() -> u32 {
    answer(Page::check)
}

/// Goes on with the scene `{"text", "changes"}` from where everything is.
#[unsafe(no_mangle)]
pub extern "C" fn change() -> u32 {
    answer(Page::change)
}

/// Gives a particle `{"id", "position", "velocity"}` another position, velocity or both.
#[unsafe(no_mangle)]
pub extern "C" fn set() -> u32 {
    answer(Page::set)
}

/// The next events, which a copy runs ahead for.
#[unsafe(no_mangle)]
pub extern "C" fn upcoming(count: u32) -> u32 {
    answer(|page| page.upcoming(count))
}

/// The scene `{"text"}` with the present positions and velocities in place of those that it begins with.
#[unsafe(no_mangle)]
pub extern "C" fn scene() -> u32 {
    answer(Page::scene)
}

/// Where the surfaces are now.
#[unsafe(no_mangle)]
pub extern "C" fn poses() -> u32 {
    answer(|page| Ok(page.poses()))
}

/// Runs for a number of physical events more, or until a simulated time, and says which came first: 0 the events, 1 the time, 2 nothing happens any more,
/// 3 the dynamics cannot go on, which the message explains, 4 the run that the scene plans is over. After that one it goes on without a plan.
#[unsafe(no_mangle)]
pub extern "C" fn advance(events: f64, time: f64) -> u32 {
    PAGE.with_borrow_mut(|page| page.advance(events, time)) as u32
}

/// Puts the state into the numbers; how many there are.
#[unsafe(no_mangle)]
pub extern "C" fn look() -> usize {
    PAGE.with_borrow_mut(Page::look)
}

/// Where the numbers are that [`look`] has put there.
#[unsafe(no_mangle)]
pub extern "C" fn numbers() -> *const f64 {
    PAGE.with_borrow(|page| page.numbers.as_ptr())
}

/// Where the periods travelled are, three of each particle, that [`look`] has put there.
#[unsafe(no_mangle)]
pub extern "C" fn images() -> *const i32 {
    PAGE.with_borrow(|page| page.images.as_ptr())
}

/// Where the answer of the last call is, UTF-8.
#[unsafe(no_mangle)]
pub extern "C" fn message() -> *const u8 {
    PAGE.with_borrow(|page| page.message.as_ptr())
}

/// Its length in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn message_length() -> usize {
    PAGE.with_borrow(|page| page.message.len())
}
