//! Pairs: the table of interactions by species, the states of captured pairs, and contact times of the TC
//! model.

pub mod bias;
pub mod contacts;
pub mod rows;
pub mod rules;
pub mod states;

use crate::model::Scene;
use bias::Bias;
use contacts::ContactTimes;
use rules::Rules;
use serde::{Deserialize, Serialize};
use states::CapturedPairs;

/// All data about pairs.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Pairs {
    /// The table of interactions.
    pub rules: Rules,
    /// The states of captured pairs.
    pub states: CapturedPairs,
    /// When each particle last had a contact, for the TC model.
    pub contact_times: Option<ContactTimes>,
    /// Whether there are pairs with interactions of their own that do not hold them together.
    pub has_own_interactions: bool,
    /// Weights that replace the potential energy.
    pub bias: Option<Box<Bias>>,
}

impl Pairs {
    /// Pairs of a scene, none of them captured yet; `has_states` tells whether pairs can be captured.
    #[must_use]
    pub fn of(scene: &Scene, has_states: bool) -> Self {
        let count = scene.particles().len();
        Self {
            rules: Rules::new(scene),
            states: CapturedPairs::new(if has_states { count } else { 0 }),
            contact_times: scene.contact_time().map(|contact_time| ContactTimes::new(contact_time, count)),
            has_own_interactions: scene.has_loose_bonds(),
            bias: None,
        }
    }
}
