//! The run that a scene starts from.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{InputFile, InteractionId, ParticleId};

/// Predecessor of a run: the run whose last state is the start of a scene.
///
/// Particles, bonds, box and time of that state are those of the scene; what else belongs to it is kept here until a simulation has begun.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Predecessor {
    /// Its checkpoint, with the checksum that the checkpoint ends with.
    pub checkpoint: InputFile,
    /// Number of random streams that its thermostats, and those of its own predecessors, may have used. Later streams are unused.
    pub(crate) streams: usize,
    /// `None` where a simulation has begun from it.
    #[serde(skip)]
    pub(crate) state: Option<Arc<LastState>>,
}

/// Last state of a run, besides particles, bonds, box and time.
#[derive(Debug, PartialEq)]
pub(crate) struct LastState {
    /// Periods travelled by each particle.
    pub images: Vec<[i32; 3]>,
    /// The pairs that were not in state 0, ascending.
    pub captured: Vec<([ParticleId; 2], u16)>,
    /// For each interaction of the scene, whether its pairs had the same discontinuities. If so, they keep their states.
    pub is_kept: Vec<bool>,
    /// Differences from that run, in words.
    pub differences: Vec<&'static str>,
    /// The whole simulation, serialized; `None` where something differs that it depends on.
    pub simulation: Option<Vec<u8>>,
}

impl LastState {
    /// The state of a pair that keeps it; `None` of one whose distance decides.
    pub fn state_of(&self, pair: [ParticleId; 2], interaction: InteractionId) -> Option<u16> {
        let is_kept = self.is_kept.get(interaction.0 as usize).copied().unwrap_or(false);
        let [a, b] = pair;
        let found = self.captured.binary_search_by_key(&[a.min(b), a.max(b)], |(pair, _)| *pair);
        is_kept.then(|| found.map_or(0, |at| self.captured[at].1))
    }
}

impl Predecessor {
    /// Differences between the scene and that run, in words, that require a new engine to start from its last state. Empty without any, or where
    /// a simulation has begun already.
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
