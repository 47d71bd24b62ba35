//! A moving particle as the engine keeps it.

use crate::Vector;
use serde::{Deserialize, Serialize};

/// A particle where an event last touched it: a *delayed state*, one cache line.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[repr(C, align(64))]
pub(super) struct Body {
    /// Position at the local time.
    pub position: Vector,
    /// Velocity at the local time.
    pub velocity: Vector,
    /// Local time, since the epoch.
    pub time: f64,
    /// Number of events that changed its motion: a prediction that names another number is void.
    pub events: u32,
    /// The user's id of it.
    pub name: u32,
}

impl Body {
    /// Position, velocity and time; the last number is none.
    #[inline(always)]
    pub fn numbers(&self) -> &[f64; 8] {
        const { assert!(size_of::<Self>() == size_of::<[f64; 8]>()) };
        // SAFETY: as large, aligned better, without padding, and any bits are a number.
        unsafe { &*std::ptr::from_ref(self).cast() }
    }
}
