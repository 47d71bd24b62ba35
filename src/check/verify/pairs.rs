//! Pair states of the verifier. Initial states follow from the distances, later states from the outcomes of events.

use super::bounds::rounded;
use super::contact::Contact;
use super::violation::Fault;
use super::world::World;
use crate::engine::States;
use crate::model::ParticleId;
use crate::model::potential::Potential;
use std::collections::BTreeMap;

/// A pair at the start of the check.
struct Start {
    distance: f64,
    /// Scalar product of separation and relative velocity: positive if the two particles move apart.
    parting: f64,
    rounding: f64,
}

impl Start {
    fn of(world: &World, states: &States, i: u32, j: u32) -> Self {
        let apart = world.nearest(states, i, j);
        let [i, j] = [i as usize, j as usize];
        let parting = apart.dot(&(states.velocities[i] - states.velocities[j]));
        let periods = world.periods.iter().copied().filter(|period| period.is_finite());
        let largest = periods.chain([states.positions[i].amax(), states.positions[j].amax()]).fold(0.0, f64::max);
        Self { distance: apart.norm(), parting, rounding: rounded(largest) }
    }

    /// Returns the number of potential radii larger than the distance. If the distance equals a radius within
    /// round-off, the pair is inside the radius if the particles approach, and outside if they move apart.
    fn state(&self, potential: &Potential) -> usize {
        let captured = |radius: f64| match (self.distance - radius).abs() <= self.rounding {
            true if self.parting < 0.0 => true,
            true if self.parting > 0.0 => false,
            _ => self.distance < radius,
        };
        let count = potential.radii().iter().take_while(|&&radius| captured(radius)).count();
        let states = potential.accessible_states();
        count.clamp(*states.start(), *states.end())
    }
}

#[derive(Debug, Default)]
pub(super) struct Pairs {
    /// Pair states by particle and partner. Each pair is stored for both particles. Only bonds are stored in state 0.
    states: Vec<BTreeMap<u32, usize>>,
}

impl Pairs {
    pub fn from_distances(world: &World, states: &States) -> Self {
        let at_start = |i, j, bond: &Potential| Start::of(world, states, i, j).state(bond);
        let mut pairs = Self::bonded(world, states.positions.len(), at_start);
        if !world.has_states {
            return pairs;
        }
        for &i in &world.moving {
            for (j, _) in (0..).zip(&states.positions).filter(|(j, _)| world.is_first(i, *j)) {
                let start = Start::of(world, states, i, j);
                let is_far = start.distance > world.longest_range + start.rounding;
                if (is_far && !world.holds_all_pairs) || pairs.get(i, j).is_some() {
                    continue;
                }
                let state = world.interaction(i, j).map_or(0, |interaction| start.state(&interaction.potential));
                if state > 0 {
                    pairs.set(i, j, state);
                }
            }
        }
        pairs
    }

    /// Reads pair states from a list of captured pairs. All other pairs are uncaptured.
    ///
    /// # Errors
    /// [`Fault::Unknown`] if a pair cannot be in the given state.
    pub fn listed(world: &World, states: &States, captured: &[([ParticleId; 2], u16)]) -> Result<Self, Fault> {
        let mut pairs = Self::bonded(world, states.positions.len(), |_, _, _| 0);
        for &([a, b], state) in captured {
            if !world.has_state(a.0, b.0, state.into()) {
                return Err(Fault::Unknown { contact: Contact::pair(a, b), distance: 0.0, state: state.into() });
            }
            pairs.set(a.0, b.0, state.into());
        }
        Ok(pairs)
    }

    fn bonded(world: &World, particles: usize, state_of: impl Fn(u32, u32, &Potential) -> usize) -> Self {
        let mut pairs = Self { states: vec![BTreeMap::new(); particles] };
        for &(a, b) in world.bonds.keys() {
            if let Some(interaction) = world.interaction(a, b) {
                pairs.set(a, b, state_of(a, b, &interaction.potential));
            }
        }
        pairs
    }

    /// Returns the state of a captured or bonded pair; `None` for other pairs.
    pub fn get(&self, i: u32, j: u32) -> Option<usize> {
        self.states[i as usize].get(&j).copied()
    }

    pub fn set(&mut self, i: u32, j: u32, state: usize) {
        self.states[i as usize].insert(j, state);
        self.states[j as usize].insert(i, state);
    }

    pub fn forget(&mut self, i: u32, j: u32) {
        self.states[i as usize].remove(&j);
        self.states[j as usize].remove(&i);
    }

    pub fn of(&self, i: u32) -> impl Iterator<Item = (u32, usize)> {
        self.states[i as usize].iter().map(|(&j, &state)| (j, state))
    }

    /// Returns all pairs that are not in state 0, in ascending order. Each pair has the lower id first.
    pub fn captured(&self) -> Vec<([ParticleId; 2], usize)> {
        let mut captured = Vec::new();
        for (i, partners) in (0..).zip(&self.states) {
            for (&j, &state) in partners.range(i + 1..) {
                if state > 0 {
                    captured.push(([ParticleId(i), ParticleId(j)], state));
                }
            }
        }
        captured
    }
}
