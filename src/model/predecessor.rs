//! The run that a scene starts from.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{InputFile, InteractionId, ParticleId};

/// Predecessor of a run: the run whose last state is the start of a scene.
///
/// Particles, bonds, box and time of that state are in the scene. The rest is stored here until a simulation
/// has begun.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Predecessor {
    /// Its checkpoint, with the checksum at its end.
    pub checkpoint: InputFile,
    /// Number of random streams that the thermostats of the predecessor, and of all runs before it, may have
    /// used. Later streams are unused.
    pub(crate) streams: usize,
    /// `None` once a simulation has begun from it.
    #[serde(skip)]
    pub(crate) state: Option<Arc<LastState>>,
}

/// Last state of a run, except particles, bonds, box and time.
#[derive(Debug, PartialEq)]
pub(crate) struct LastState {
    /// Periods travelled by each particle.
    pub images: Vec<[i32; 3]>,
    /// The pairs that were not in state 0, in ascending order.
    pub captured: Vec<([ParticleId; 2], u16)>,
    /// For each interaction of the scene, whether its pairs had the same discontinuities. If so, they keep
    /// their states.
    pub is_kept: Vec<bool>,
    /// Differences between the scene and the run, in words.
    pub differences: Vec<&'static str>,
    /// The whole simulation, serialized; `None` if the scene differs in something that it depends on.
    pub simulation: Option<Vec<u8>>,
}

impl LastState {
    /// The state of a pair that keeps it; `None` if the distance decides.
    pub fn state_of(&self, pair: [ParticleId; 2], interaction: InteractionId) -> Option<u16> {
        let is_kept = self.is_kept.get(interaction.0 as usize).copied().unwrap_or(false);
        let [a, b] = pair;
        let found = self.captured.binary_search_by_key(&[a.min(b), a.max(b)], |(pair, _)| *pair);
        is_kept.then(|| found.map_or(0, |at| self.captured[at].1))
    }
}

impl Predecessor {
    /// Differences between the scene and the run, in words. Because of them, a new engine starts from the
    /// last state of the run. Empty without differences, or after a simulation has begun.
    #[must_use]
    pub fn differences(&self) -> &[&'static str] {
        self.state.as_ref().map_or(&[], |state| &state.differences)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_keep_their_states_where_the_discontinuities_are_the_same() {
        let pair = |a, b| [ParticleId(a), ParticleId(b)];
        let state = LastState {
            images: Vec::new(),
            captured: vec![(pair(0, 3), 2), (pair(1, 2), 1)],
            is_kept: vec![true, false],
            differences: Vec::new(),
            simulation: None,
        };
        assert_eq!(state.state_of(pair(3, 0), InteractionId(0)), Some(2));
        assert_eq!(state.state_of(pair(0, 1), InteractionId(0)), Some(0));
        assert_eq!(state.state_of(pair(1, 2), InteractionId(1)), None);
        assert_eq!(state.state_of(pair(1, 2), InteractionId(2)), None);
    }
}
