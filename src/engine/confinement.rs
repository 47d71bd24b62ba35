//! Geometry for the pressure between walls.

use super::parts::Engine;
use crate::Vector;
use crate::base::sum::Sum;
use crate::engine::pairs::rows::Rows;
use crate::model::{Scene, Space};
use serde::{Deserialize, Serialize};

/// The region that particle centres can reach between the walls.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Confinement {
    /// The axes with walls on both sides.
    pub axes: [bool; 3],
    pub middle: Vector,
    /// Inverse of the volume that the centres of a species can reach `[length^-D]`, by table row.
    pub per_volume: Vec<f64>,
    /// Inverse of the wall area that the centres of a species can reach `[length^(1 - D)]`, by table row and axis.
    pub per_area: Vec<[f64; 3]>,
}

impl Confinement {
    pub fn of(scene: &Scene, rows: &Rows) -> Option<Self> {
        let space = &scene.space;
        let diameters = || rows.species().iter().map(|id| scene.species[id.0 as usize].diameter);
        let is_walled = (0..3).any(|axis| space.walls(axis) > 0);
        is_walled.then(|| Self {
            axes: std::array::from_fn(|axis| space.walls(axis) == 2),
            middle: space.lower + 0.5 * space.size,
            per_volume: diameters().map(|diameter| inverse_volume(space, diameter)).collect(),
            per_area: diameters()
                .map(|diameter| std::array::from_fn(|axis| inverse_area(space, axis, diameter)))
                .collect(),
        })
    }
}

/// Without accessible volume, no pressure is defined, and the result is 0.
fn inverse_volume(space: &Space, diameter: f64) -> f64 {
    let volume = space.accessible_volume(diameter);
    if volume > 0.0 { 1.0 / volume } else { 0.0 }
}

fn inverse_area(space: &Space, axis: usize, diameter: f64) -> f64 {
    space.accessible_area(axis, diameter).map_or(0.0, f64::recip)
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Inverse of the volume that the centre of a particle can reach `[length^-D]`.
    pub(super) fn per_volume(&self, confinement: &Confinement, particle: u32) -> f64 {
        if self.has_sizes() {
            return inverse_volume(&self.state.space, 2.0 * self.radius(particle));
        }
        confinement.per_volume[usize::from(self.row(particle))]
    }

    /// Inverse of the wall area that the centre of a particle can reach `[length^(1 - D)]`.
    pub(super) fn per_area(&self, confinement: &Confinement, particle: u32, axis: usize) -> f64 {
        if self.has_sizes() {
            return inverse_area(&self.state.space, axis, 2.0 * self.radius(particle));
        }
        confinement.per_area[usize::from(self.row(particle))][axis]
    }

    /// Returns the sum of `m v^2 / V` along each axis `[energy / length^D]`. A particle's centre can reach the volume
    /// `V`.
    pub(super) fn confined_kinetic(&self) -> Vector {
        let Some(confinement) = &self.sources.confinement else { return Vector::zeros() };
        let mut sums = [Sum::default(); 3];
        for particle in self.by_id().filter(|&particle| !self.is_static(particle)) {
            let (_, velocity) = self.state_at(particle, self.clock.now);
            let share = self.per_volume(confinement, particle) / self.inverse_mass(particle);
            for axis in (0..3).filter(|&axis| confinement.axes[axis]) {
                sums[axis].add(share * velocity[axis] * velocity[axis]);
            }
        }
        Vector::from_fn(|axis, _| sums[axis].total())
    }
}

#[cfg(test)]
mod tests {
    use crate::Vector;
    use crate::engine::event::CountedKind;
    use crate::engine::{Simulation, Snapshot, Until};
    use crate::model::potential::Potential;
    use crate::model::space::{Boundary, Space};
    use crate::model::{SpeciesId, Thermostat};
    use crate::scene::{InteractionDraft, SceneBuilder, SpeciesDraft};

    /// Simulates two species between walls. The scene begins with `unused` species without particles.
    fn after(unused: u32) -> Simulation {
        let space = Space { boundary: [Boundary::walls(1.0); 3], ..Space::periodic_cube(12.0) };
        let hard = |diameter| Potential::hard_sphere(diameter).unwrap();
        let empty = (0..unused).fold(SceneBuilder::new("many").space(space), |scene, k| {
            scene.species(SpeciesDraft::new(&format!("S{k}")).mass(1.0).diameter(0.1))
        });
        let mut scene = empty
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .species(SpeciesDraft::new("B").mass(2.0).diameter(3.0))
            .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"))
            .interaction(InteractionDraft::new(hard(2.0)).between("A", "B"))
            .interaction(InteractionDraft::new(hard(3.0)).between("B", "B"));
        for k in 0..4 {
            let x = 2.0 + 2.5 * f64::from(k);
            scene = scene.particle("A", Vector::new(x, 3.0, 4.0), Vector::new(1.0, 0.3 - x, 0.5)).particle(
                "B",
                Vector::new(4.0 + 4.0 * f64::from(k % 2), 7.0, 4.0 + 4.0 * f64::from(k / 2)),
                Vector::zeros(),
            );
        }
        let mut simulation = Simulation::without_plan(scene.build().unwrap());
        let bath = Thermostat::Andersen { temperature: 1.0, rate: 0.5, axes: [true; 3] };
        simulation.set_thermostat(Some(&bath), 0).unwrap();
        simulation.advance(Until::events(500)).unwrap();
        simulation
    }

    #[test]
    fn unused_species_change_neither_events_nor_counts() {
        let (few, many) = (after(0), after(300));
        let of_many = many.snapshot();
        let species = of_many.species.iter().map(|id| SpeciesId(id.0 - 300)).collect();
        assert_eq!(few.snapshot(), Snapshot { species, ..of_many });
        assert_eq!(few.event_counts(), many.event_counts());
        let named = |simulation: &Simulation, first: u32| {
            let entries = simulation.event_counts_by_species().entries().into_iter();
            entries
                .map(|(kind, ids, n)| (kind, ids.iter().map(|id| id - first).collect(), n))
                .collect::<Vec<(_, Vec<_>, _)>>()
        };
        let counts = named(&few, 0);
        assert_eq!(counts, named(&many, 300));
        for kind in [CountedKind::Core, CountedKind::Wall, CountedKind::Thermostat] {
            assert!(counts.iter().any(|(counted, ids, _)| *counted == kind && ids.contains(&1)), "{kind:?}");
        }
    }
}
