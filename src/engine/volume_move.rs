//! Volume moves: the box and the centres of all molecules are scaled.

use std::collections::HashSet;
use std::convert::Infallible;

use super::set_state::PairStates;
use super::{Chosen, Simulation};
use crate::Vector;
use crate::base::numbers::id;
use crate::engine::neighbours::cell_list::CellList;
use crate::model::limits::LARGEST;
use crate::model::molecules::Molecules;
use crate::model::space::{Boundary, Space, minimum_image};
use crate::model::{Bond, InteractionId, Potential, Scene, SpeciesId};

/// Constant data for the volume moves of a simulation.
#[derive(Debug, Clone)]
pub(crate) struct Scaling {
    molecules: Molecules,
    /// Species and radius of each particle, in the order of ids.
    kinds: Vec<(SpeciesId, f64)>,
    /// Pairs with a bond, the lower id first.
    bonded: HashSet<[u32; 2]>,
    /// Longest interaction range of pairs without a bond `[length]`.
    range: f64,
    /// Shortest allowed period of the box `[length]`. In a smaller box, a pair could interact through two images.
    shortest: f64,
}

/// Proposed state: a box of another size, and the positions in this box.
#[derive(Debug, Clone)]
pub(crate) struct Scaled {
    pub space: Space,
    /// Change of the potential energy of pairs `[energy]`.
    pub energy_change: f64,
    /// New positions, in the order of ids. Image numbers do not change.
    positions: Vec<Vector>,
}

impl Scaling {
    pub fn of(simulation: &Simulation) -> Self {
        let scene = &simulation.scene;
        let (mut kinds, mut masses) = (Vec::new(), Vec::new());
        let mut largest = vec![0.0_f64; scene.species.len()];
        let Ok(()) = simulation.for_each_now(|particle| {
            let number = particle.species.0 as usize;
            let radius = 0.5 * particle.diameter.unwrap_or(scene.species[number].diameter);
            kinds.push((particle.species, radius));
            masses.push(simulation.mass_of(&particle));
            largest[number] = largest[number].max(radius);
            Ok::<(), Infallible>(())
        });
        let counts = simulation.population();
        let meet = |[a, b]: [usize; 2]| if a == b { counts[a] > 1 } else { counts[a] > 0 && counts[b] > 0 };
        let kind = |number: usize| (SpeciesId(id(number)), largest[number]);
        let pairs = scene.table.iter().map(|(pair, _)| pair).filter(|pair| meet(*pair));
        let range = pairs.map(|[a, b]| scene.range_with(kind(a), kind(b))).fold(0.0, f64::max);
        let of_bond = |bond: &Bond| scene.potential_between(bond.interaction, bond.pair.map(|id| kinds[id.0 as usize]));
        let longest = scene.bonds.iter().map(|bond| of_bond(bond).range()).fold(range, f64::max);
        Self {
            molecules: Molecules::of(scene, masses),
            kinds,
            bonded: scene.bonds.iter().map(|bond| bond.pair.map(|id| id.0)).collect(),
            range,
            shortest: (2.0 * longest).max(1.0 / LARGEST),
        }
    }

    /// Number of molecules. A particle without bonds counts as a molecule.
    pub fn molecules(&self) -> usize {
        self.molecules.count
    }
}

impl Simulation {
    /// Returns the current volume of the box `[length^D]`: an area in two dimensions, a length in one dimension.
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.scene.space.volume()
    }

    /// Returns the box with the logarithm of its volume changed by `change`. Returns `None` if a pair could interact
    /// through two images. This limit is part of the ensemble, like a stop for a piston: moves across it are rejected
    /// in both directions.
    pub(crate) fn scaled_box(&self, scaling: &Scaling, change: f64) -> Option<Space> {
        let from = &self.scene.space;
        let factor = libm::exp(change / from.dimensions() as f64);
        let is_flat = |k: usize| from.boundary[k] == Boundary::Flat;
        let space =
            Space { size: Vector::from_fn(|k, _| if is_flat(k) { 0.0 } else { from.size[k] * factor }), ..*from };
        let fits = (0..3).all(|k| is_flat(k) || (scaling.shortest..=LARGEST).contains(&space.size[k]));
        fits.then_some(space)
    }

    /// Scales the positions of all molecules to another box of the same shape. Returns `None` if particles overlap.
    pub(crate) fn scaled(&self, scaling: &Scaling, space: Space) -> Option<Scaled> {
        let snapshot = self.snapshot();
        let positions = scaling.molecules.scaled(&snapshot.positions, &self.scene.space, &space);
        let energy = self.energy_in(scaling, &space, &positions)?;
        Some(Scaled { energy_change: energy - self.energy().pair, space, positions })
    }

    fn energy_in(&self, scaling: &Scaling, space: &Space, positions: &[Vector]) -> Option<f64> {
        let scene = &self.scene;
        let inside: Vec<Vector> = positions.iter().map(|position| space.wrapped(*position)).collect();
        let potential = |id: InteractionId| &scene.interactions[id.0 as usize].potential;
        let (mut energy, mut overlap) = (0.0, false);
        let mut add = |potential: &Potential, distance: f64| {
            overlap |= potential.violation_at(distance) > 0.0;
            energy += potential.energies()[potential.state_at(distance)];
        };
        if scaling.range > 0.0 {
            let cells = CellList::new(space, 0.0, scaling.range, (0..).zip(inside.iter().copied()));
            cells.for_each_pair(|a, b, _, square| {
                let pair = [a, b].map(|id| scaling.kinds[id as usize]);
                let is_bonded = || scaling.bonded.contains(&[a.min(b), a.max(b)]);
                let distance = square.sqrt();
                if let Some(id) = scene.interaction_of(pair[0].0, pair[1].0).filter(|_| !is_bonded())
                    && distance <= scene.range_with(pair[0], pair[1])
                {
                    add(&scene.potential_between(id, pair), distance);
                }
            });
        }
        let periods = space.periods();
        let (held, loose): (Vec<&Bond>, _) = scene.bonds.iter().partition(|bond| potential(bond.interaction).is_bond());
        for bond in loose {
            let [a, b] = bond.pair.map(|id| inside[id.0 as usize]);
            let kinds = bond.pair.map(|id| scaling.kinds[id.0 as usize]);
            add(&scene.potential_between(bond.interaction, kinds), minimum_image(a - b, &periods).norm());
        }
        // A volume move does not change the lengths of bonds.
        let state = |bond: &Bond| usize::from(self.pair_state(bond.pair[0], bond.pair[1]));
        energy += held.iter().map(|bond| potential(bond.interaction).energies()[state(bond)]).sum::<f64>();
        (!overlap).then_some(energy)
    }

    /// Accepts a volume move. Velocities, the time and event counts are unchanged. The energy change is added to the
    /// supplied energy.
    pub(crate) fn take_scaled(&mut self, scaled: Scaled) {
        let Scaled { space, positions, .. } = scaled;
        self.scene.space = space;
        let scene: &Scene = &self.scene;
        with_engine!(&mut self.engine, engine => engine.set_positions(scene, &positions, PairStates::FromDistances));
    }
}
