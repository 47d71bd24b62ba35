//! A scene that runs in a browser: what its page shows, and the page itself.

mod head;

pub use head::Shown;
