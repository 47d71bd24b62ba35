//! How many frames a run writes where its scene leaves that open.

use serde::{Deserialize, Serialize};

use super::stage::Stage;
use crate::base::numbers::trunc_to_u32;
use crate::model::Scene;
use crate::trajectory::extended_xyz::frame_bytes;

/// A measurement that chooses its interval itself aims at this many frames, and at most twice as many.
const AIM: u32 = 20;

/// Largest size of all frames of a run unless the scene gives their interval `[bytes]`; the last one is written in any case.
pub(crate) const MOST_BYTES: f64 = 2e8;

/// Reason for the limit, in words.
const REASON: &str = "no more than fit into 200 MB, because output.frame_interval is not given";

/// The most frames of each measured stage of a run, by what they take on the disk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct FrameLimit {
    /// `None` where the scene gives the interval.
    most: Option<u32>,
}

impl FrameLimit {
    /// That of a scene at its start.
    pub fn of(scene: &Scene) -> Self {
        let measured = Stage::all(&scene.run).filter(|stage| stage.is_measured()).count() as f64;
        let most = trunc_to_u32(MOST_BYTES / frame_bytes(scene) / measured);
        Self { most: scene.output.frame_interval.is_none().then_some(most) }
    }

    /// Whether a measurement has a frame of its beginning.
    pub fn has_first(self) -> bool {
        self.most.is_none_or(|most| most >= 2)
    }

    /// Whether a stage has a frame of its end; the last one always has.
    pub fn has_last(self, stage: Stage) -> bool {
        stage == Stage::Measurement || self.most.is_none_or(|most| most >= 1)
    }

    /// How many there may be between the first and the last; as many as one likes if there is no limit.
    pub fn between(self) -> u32 {
        self.most.map_or(u32::MAX, |most| most.saturating_sub(2))
    }

    /// How many of them are aimed at.
    pub fn aim(self) -> u32 {
        AIM.min(self.between()).max(1)
    }

    /// The most frames that are expected of a stage, with the first and the last, where it chooses their interval itself.
    pub fn most(self, stage: Stage) -> f64 {
        let ends = u32::from(self.has_first()) + u32::from(self.has_last(stage));
        f64::from(self.between().saturating_add(ends).min(2 * AIM))
    }

    /// Why there are fewer than of a smaller system, if there are.
    pub fn reason(self) -> Option<&'static str> {
        (self.between() < 2 * AIM).then_some(REASON)
    }
}
