//! The run that a scene continues.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{InputFile, InteractionId, ParticleId};

/// The run that a scene continues. The scene contains the particles, bonds, box and time of the last state. The rest of
/// the state is stored here until a simulation begins.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Predecessor {
    /// Checkpoint of the run, identified by a checksum.
    pub checkpoint: InputFile,
    /// Number of random streams that this run and earlier runs may have used. A new run uses later streams.
    pub(crate) streams: usize,
    /// Last state of the run; `None` once a simulation has begun from it.
    #[serde(skip)]
    pub(crate) state: Option<Arc<LastState>>,
}

/// Last state of a run, without the particles, bonds, box and time.
#[derive(Debug, PartialEq)]
pub(crate) struct LastState {
    /// Periods that each particle has travelled.
    pub images: Vec<[i32; 3]>,
    /// Pairs with a state other than 0 and their states, in ascending order.
    pub captured: Vec<([ParticleId; 2], u16)>,
    /// For each interaction, whether the discontinuities are unchanged, so that pairs keep their states.
    pub is_kept: Vec<bool>,
    pub differences: Vec<&'static str>,
    /// Serialized simulation at the end of the run; `None` if the scene differs from the scene of the run.
    pub simulation: Option<Vec<u8>>,
}

impl LastState {
    /// Returns the state of a pair at the end of the run. Returns `None` if the discontinuities have changed. The state
    /// then follows from the distance.
    pub fn state_of(&self, pair: [ParticleId; 2], interaction: InteractionId) -> Option<u16> {
        let is_kept = self.is_kept.get(interaction.0 as usize).copied().unwrap_or(false);
        let [a, b] = pair;
        let found = self.captured.binary_search_by_key(&[a.min(b), a.max(b)], |(pair, _)| *pair);
        is_kept.then(|| found.map_or(0, |at| self.captured[at].1))
    }
}

impl Predecessor {
    /// Differences between the scene and the predecessor. The list is empty after a simulation has begun.
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
