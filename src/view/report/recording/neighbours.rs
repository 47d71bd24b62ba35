//! Numbers of neighbours within the range of a potential with finite steps.

use std::collections::HashSet;

use crate::base::numbers::id;
use crate::engine::CellList;
use crate::model::{Scene, SpeciesId};
use crate::trajectory::Frame;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct WellNeighbours {
    /// Potential range for each pair of species. Negative if the potential has no finite steps.
    ranges: Vec<f64>,
    species: usize,
    longest: f64,
    bonded: HashSet<[u32; 2]>,
}

impl WellNeighbours {
    /// Returns `None` if no potential has finite steps, if particles have individual diameters, or if the frame and the
    /// scene have different species.
    pub fn of(scene: &Scene, frame: &Frame) -> Option<Self> {
        if scene.has_individual_diameters() {
            return None;
        }
        let names = || frame.species.iter().map(|species| &species.name);
        if !names().eq(scene.species.iter().map(|species| &species.name)) {
            return None;
        }
        let species = scene.species.len();
        let mut ranges = Vec::new();
        for a in 0..species {
            for b in 0..species {
                let id = scene.interaction_of(SpeciesId(id(a)), SpeciesId(id(b)));
                let potential = id.and_then(|id| scene.interactions.get(id.0 as usize)).map(|found| &found.potential);
                let stepped = potential.filter(|potential| potential.accessible_states().count() > 1);
                ranges.push(stepped.map_or(-1.0, |potential| potential.range()));
            }
        }
        let longest = ranges.iter().copied().fold(-1.0, f64::max);
        let bonded = frame.bonds.iter().map(|[a, b]| [a.0.min(b.0), a.0.max(b.0)]).collect();
        (longest > 0.0).then_some(Self { ranges, species, longest, bonded })
    }

    /// Counts the neighbours of each moving particle. Bonded partners are not counted.
    pub fn count(&self, frame: &Frame) -> Vec<f64> {
        let positions = frame.particles.iter().map(|particle| frame.wrapped(&particle.position));
        let cells = CellList::new(&frame.space(), frame.displacement, self.longest, (0..).zip(positions));
        let mut counts = vec![0.0; frame.particles.len()];
        cells.for_each_pair(|a, b, _, square| {
            let [one, other] = [a, b].map(|place| &frame.particles[place as usize]);
            let pair = one.species.0 as usize * self.species + other.species.0 as usize;
            let range = self.ranges.get(pair).copied().unwrap_or(-1.0);
            let ids = [one.id.0.min(other.id.0), one.id.0.max(other.id.0)];
            if range > 0.0 && square < range * range && !self.bonded.contains(&ids) {
                counts[a as usize] += 1.0;
                counts[b as usize] += 1.0;
            }
        });
        let all = frame.particles.iter().zip(counts);
        all.filter(|(particle, _)| !frame.is_static(particle)).map(|(_, count)| count).collect()
    }
}
