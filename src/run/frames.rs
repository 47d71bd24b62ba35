//! Number of frames of a run without a frame interval.

use serde::{Deserialize, Serialize};

use super::stage::Stage;
use crate::base::numbers::trunc_to_u32;
use crate::model::Scene;
use crate::trajectory::extended_xyz::frame_bytes;

/// Target number of frames in a measurement. The number of frames may be up to twice as large.
const AIM: u32 = 20;

/// Largest total size of all frames `[bytes]`. The last frame is always written.
pub(crate) const MOST_BYTES: f64 = 2e8;

const REASON: &str = "limited to 200 MB, because output.frame_interval is not given";
const REASON_BEYOND: &str = "only the last frame, because a single frame exceeds the limit of 200 MB that applies if output.frame_interval is not given";

/// Limits the number of frames in each measured stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct FrameLimit {
    /// Maximum number of frames; `None` if the scene gives the interval.
    most: Option<u32>,
    /// True if a single frame is larger than `MOST_BYTES`.
    is_beyond: bool,
}

impl FrameLimit {
    pub fn of(scene: &Scene) -> Self {
        let measured = Stage::all(&scene.run).filter(|stage| stage.is_measured()).count() as f64;
        Self::with(scene, frame_bytes(scene), measured)
    }

    pub fn of_replicas(scene: &Scene, temperatures: usize) -> Self {
        Self::with(scene, frame_bytes(scene) * temperatures as f64, 1.0)
    }

    fn with(scene: &Scene, bytes: f64, stages: f64) -> Self {
        let most = trunc_to_u32(MOST_BYTES / (bytes * stages));
        let is_open = scene.output.frame_interval.is_none();
        Self { most: is_open.then_some(most), is_beyond: is_open && bytes > MOST_BYTES }
    }

    pub fn has_first(self) -> bool {
        self.most.is_none_or(|most| most >= 2)
    }

    pub fn has_last(self, stage: Stage) -> bool {
        stage == Stage::Measurement || self.most.is_none_or(|most| most >= 1)
    }

    /// Maximum number of frames between the first and the last.
    pub fn between(self) -> u32 {
        self.most.map_or(u32::MAX, |most| most.saturating_sub(2))
    }

    pub fn aim(self) -> u32 {
        AIM.min(self.between()).max(1)
    }

    /// Returns the largest number of frames of a stage.
    pub fn most(self, stage: Stage) -> f64 {
        let ends = u32::from(self.has_first()) + u32::from(self.has_last(stage));
        f64::from(self.between().saturating_add(ends).min(2 * AIM))
    }

    /// Returns the number of frames for each temperature of a replica exchange. The start has no frame.
    pub fn of_exchange(self) -> u32 {
        self.most.map_or(AIM, |most| most.clamp(1, AIM))
    }

    /// Explains why there are few frames; `None` if the size on disk does not limit the number.
    pub fn reason(self) -> Option<&'static str> {
        self.reason_of(self.between() < 2 * AIM)
    }

    /// Explains why a replica exchange has fewer frames than the target; `None` if the target is reached.
    pub fn reason_of_exchange(self) -> Option<&'static str> {
        self.reason_of(self.of_exchange() < AIM)
    }

    fn reason_of(self, are_fewer: bool) -> Option<&'static str> {
        are_fewer.then_some(if self.is_beyond { REASON_BEYOND } else { REASON })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::RunPlan;
    use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};
    use crate::{Vector, model::Until};

    fn scene(count: usize) -> Scene {
        let scene = SceneBuilder::new("many")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .space(crate::model::space::Space::periodic_cube(9.0))
            .particle("A", Vector::zeros(), Vector::zeros())
            .run(RunPlan { limit: Until::time(1.0), ..RunPlan::default() });
        let mut scene = scene.build().unwrap();
        scene.particles = vec![scene.particles[0]; count];
        scene
    }

    #[test]
    fn frame_above_the_size_limit_is_reported() {
        for (count, reason) in [(1_000, None), (100_000, Some(REASON)), (2_000_000, Some(REASON_BEYOND))] {
            let mut scene = scene(count);
            assert_eq!(FrameLimit::of(&scene).reason(), reason, "{count}");
            scene.output.frame_interval = Some(0.5);
            assert_eq!(FrameLimit::of(&scene).reason(), None, "{count}");
        }
        assert_eq!(FrameLimit::of(&scene(2_000_000)).most(Stage::Measurement), 1.0);
    }

    #[test]
    fn frames_of_all_exchange_temperatures_share_the_size_limit() {
        let of = |count, temperatures| FrameLimit::of_replicas(&scene(count), temperatures);
        assert_eq!((of(1_000, 8).of_exchange(), of(1_000, 8).reason_of_exchange()), (AIM, None));
        let some = of(20_000, 16);
        assert!((2..AIM).contains(&some.of_exchange()) && some.reason_of_exchange() == Some(REASON));
        let bytes = frame_bytes(&scene(20_000)) * 16.0;
        assert!(bytes * f64::from(some.of_exchange()) <= MOST_BYTES);
        assert!(bytes * f64::from(some.of_exchange() + 1) > MOST_BYTES);
        let large = of(500_000, 16);
        assert_eq!((large.of_exchange(), large.reason_of_exchange()), (1, Some(REASON_BEYOND)));
    }
}
