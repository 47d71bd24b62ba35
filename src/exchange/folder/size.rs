//! Expected size of an exchange on disk.

use super::ExchangeFolder;
use crate::analysis::instruments::chains::ChainSizes;
use crate::exchange::replicas::frame_every;
use crate::model::Scene;
use crate::run::FrameLimit;
use crate::trajectory::extended_xyz::frame_bytes;

impl ExchangeFolder {
    /// Expected total size of the files of an exchange, without checkpoints `[bytes]`.
    #[must_use]
    pub fn expected_bytes(scene: &Scene) -> f64 {
        // Approximate size of a number and a comma in a table `[bytes]`.
        const NUMBER: f64 = 12.0;
        let Some(plan) = scene.exchange() else { return 0.0 };
        let (temperatures, time) = (plan.replicas() as f64, scene.run().limit.time.unwrap_or(0.0));
        let measured = ChainSizes::of(scene).names().len() as f64 + f64::from(plan.umbrella.is_some());
        let rows = time / plan.interval;
        let of_frames = Self::expected_frames(scene) * frame_bytes(scene);
        rows * NUMBER * (1.0 + (2.0 + measured) * temperatures) + of_frames
    }

    /// Number of frames that an exchange will write at all temperatures.
    #[must_use]
    pub fn expected_frames(scene: &Scene) -> f64 {
        let Some(plan) = scene.exchange() else { return 0.0 };
        let measured = scene.run().limit.time.and_then(|time| plan.attempts(time)).unwrap_or(0);
        let each = measured / frame_every(scene, plan, measured).max(1);
        each as f64 * plan.replicas() as f64
    }

    /// Reason why an exchange writes fewer frames than intended, if any.
    #[must_use]
    pub fn frames_limit(scene: &Scene) -> Option<&'static str> {
        let temperatures = scene.exchange()?.replicas();
        FrameLimit::of_replicas(scene, temperatures).reason_of_exchange()
    }
}
