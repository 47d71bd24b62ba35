//! Data about pairs: interactions by species, captured pairs, and contact times of the TC model.

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

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Pairs {
    pub rules: Rules,
    pub states: CapturedPairs,
    pub contact_times: Option<ContactTimes>,
    /// True if some bonds have no infinite outer barrier, so that the particles can separate.
    pub has_loose_bonds: bool,
    /// Multicanonical weights that replace the potential energy.
    pub bias: Option<Box<Bias>>,
}

impl Pairs {
    /// Creates the data of a scene without captured pairs. `has_states` tells whether pairs can be captured.
    #[must_use]
    pub fn of(scene: &Scene, has_states: bool) -> Self {
        let count = scene.particles().len();
        Self {
            rules: Rules::new(scene),
            states: CapturedPairs::new(if has_states { count } else { 0 }),
            contact_times: scene
                .contact_time()
                .map(|contact_time| ContactTimes::new(contact_time, scene.tc_rule(), count)),
            has_loose_bonds: scene.has_loose_bonds(),
            bias: None,
        }
    }
}
