//! Wall time, on platforms that have a clock.

#[cfg(not(target_arch = "wasm32"))]
pub use std::time::Instant;

/// Stands in for the clock on a platform without one, such as WebAssembly in a browser. It never advances.
#[cfg(target_arch = "wasm32")]
#[derive(Debug, Clone, Copy)]
pub struct Instant;

#[cfg(target_arch = "wasm32")]
impl Instant {
    /// The present.
    #[must_use]
    pub fn now() -> Self {
        Self
    }

    /// Always zero.
    #[must_use]
    pub fn elapsed(&self) -> std::time::Duration {
        std::time::Duration::ZERO
    }
}
