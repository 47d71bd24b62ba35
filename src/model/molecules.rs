//! Molecules: particles connected by bonds. A volume move shifts a molecule without changing its shape.

use super::components::{Component, components};
use super::scene::{Bond, Scene};
use super::space::{Space, minimum_image};
use crate::Vector;

/// The molecules of a scene, including particles without bonds. Bonds with a finite outer barrier are ignored.
#[derive(Debug, Clone)]
pub(crate) struct Molecules {
    /// Molecules of two or more particles.
    components: Vec<Component>,
    masses: Vec<f64>,
    pub count: usize,
}

impl Molecules {
    pub fn of(scene: &Scene, masses: Vec<f64>) -> Self {
        let bonds: Vec<[u32; 2]> = held(scene).map(|bond| bond.pair.map(|id| id.0)).collect();
        let components = components(masses.len(), &bonds);
        let joined: usize = components.iter().map(|component| component.ids.len() - 1).sum();
        Self { count: masses.len() - joined, components, masses }
    }

    /// Returns a bond that closes a ring around the periodic box. The length of such a ring depends on the volume.
    pub fn bond_around_the_box(&self, scene: &Scene) -> Option<Bond> {
        let positions: Vec<Vector> = scene.particles.iter().map(|particle| particle.position).collect();
        let periods = scene.space.periods();
        let mut unwrapped = positions.clone();
        for component in &self.components {
            let path = component.path(&positions, |apart| minimum_image(apart, &periods));
            let first = positions[component.ids[0] as usize];
            component.ids.iter().zip(path).for_each(|(&id, step)| unwrapped[id as usize] = first + step);
        }
        let apart = |at: &[Vector], bond: &Bond| at[bond.pair[0].0 as usize] - at[bond.pair[1].0 as usize];
        // Along each axis, the difference is zero or a whole number of periods.
        let goes_around = |bond: &&Bond| {
            let difference = apart(&unwrapped, bond) - minimum_image(apart(&positions, bond), &periods);
            difference.amax() > 0.5 * periods.min()
        };
        held(scene).find(goes_around).copied()
    }

    /// Returns the positions in a box of another size. The centres of mass are scaled, and molecules keep their shapes.
    /// Image numbers stay the same, so positions may lie outside the box.
    pub fn scaled(&self, positions: &[Vector], from: &Space, to: &Space) -> Vec<Vector> {
        let (lower, periods) = (from.lower, from.periods());
        let factor = Vector::from_fn(|k, _| if from.size[k] > 0.0 { to.size[k] / from.size[k] } else { 1.0 });
        let wider = to.size - from.size;
        let mut scaled: Vec<Vector> =
            positions.iter().map(|position| lower + (position - lower).component_mul(&factor)).collect();
        for component in &self.components {
            let path = component.path(positions, |apart| minimum_image(apart, &periods));
            let first = positions[component.ids[0] as usize];
            let masses = || component.ids.iter().map(|&id| self.masses[id as usize]);
            let moment: Vector = masses().zip(&path).map(|(mass, step)| step * mass).sum();
            let centre = first + moment / masses().sum::<f64>() - lower;
            let shift = centre.component_mul(&factor) - centre;
            for (&id, step) in component.ids.iter().zip(&path) {
                let position = positions[id as usize];
                // Number of periods from the particle to its image in the unwrapped molecule; 0 for the first particle.
                let turns = Vector::from_fn(|k, _| {
                    if periods[k].is_finite() { ((first[k] + step[k] - position[k]) / periods[k]).round() } else { 0.0 }
                });
                scaled[id as usize] = position + shift - turns.component_mul(&wider);
            }
        }
        scaled
    }
}

fn held(scene: &Scene) -> impl Iterator<Item = &Bond> {
    scene.bonds.iter().filter(|bond| scene.interactions[bond.interaction.0 as usize].potential.is_bond())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Potential;
    use crate::model::space::Boundary;
    use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

    fn molecules(at: &[f64], bonds: &[[u32; 2]]) -> (Scene, Molecules) {
        let mut scene = SceneBuilder::new("line")
            .space(Space {
                size: Vector::new(9.0, 9.0, 0.0),
                boundary: [Boundary::Periodic, Boundary::Periodic, Boundary::Flat],
                ..Space::periodic_cube(9.0)
            })
            .species(SpeciesDraft::new("A").mass(1.3).diameter(0.1))
            .species(SpeciesDraft::new("B").mass(2.9).diameter(0.1))
            .interaction(InteractionDraft::new(Model::None).between("A", "A"))
            .interaction(InteractionDraft::new(Model::None).between("A", "B"))
            .interaction(InteractionDraft::new(Model::None).between("B", "B"))
            .interaction(InteractionDraft::new(Potential::bond(0.5, 3.5).unwrap()).named("link"));
        for (index, x) in at.iter().enumerate() {
            let (species, y) = (["A", "B"][index % 2], 1.0 + 0.25 * index as f64);
            scene.insert_particle(species, Vector::new(*x, y, 0.0), Vector::zeros());
        }
        for pair in bonds {
            scene = scene.bond(*pair, "link");
        }
        let scene = scene.build().unwrap();
        let masses = scene.particles.iter().map(|it| scene.mass(it)).collect();
        let molecules = Molecules::of(&scene, masses);
        (scene, molecules)
    }

    #[test]
    fn scaling_moves_molecule_centres_and_keeps_shapes_across_periodic_sides() {
        let at = [7.5, 1.0, 3.9, 6.5, 8.0];
        let (scene, molecules) = molecules(&at, &[[0, 1], [1, 2]]);
        assert_eq!((molecules.count, molecules.bond_around_the_box(&scene)), (3, None));
        let positions: Vec<Vector> = scene.particles.iter().map(|particle| particle.position).collect();
        let to = Space { size: Vector::new(12.0, 12.0, 0.0), ..scene.space.clone() };
        let scaled = molecules.scaled(&positions, &scene.space, &to);
        let factor = 12.0 / 9.0;
        for free in [3, 4] {
            assert!((scaled[free].xy() - positions[free].xy() * factor).norm() < 1e-14);
        }
        let periods = [scene.space.periods(), to.periods()];
        let bond = |at: &[Vector], a: usize, b: usize, box_: usize| minimum_image(at[b] - at[a], &periods[box_]);
        for (a, b) in [(0, 1), (1, 2)] {
            assert!((bond(&positions, a, b, 0) - bond(&scaled, a, b, 1)).norm() < 1e-14, "{a}-{b}");
        }
        let centre = |at: &[Vector], box_: usize| {
            let steps = [Vector::zeros(), bond(at, 0, 1, box_), bond(at, 0, 1, box_) + bond(at, 1, 2, box_)];
            at[0] + (steps[1] * 2.9 + steps[2] * 1.3) / 5.5
        };
        let apart = centre(&scaled, 1) - centre(&positions, 0) * factor;
        assert!(minimum_image(apart, &periods[1]).xy().norm() < 1e-13, "{apart}");
    }

    #[test]
    fn ring_of_bonds_around_a_periodic_box_is_detected() {
        let (scene, molecules) = molecules(&[0.5, 3.5, 6.5], &[[0, 1], [1, 2], [0, 2]]);
        assert!(molecules.bond_around_the_box(&scene).is_some());
        let (scene, molecules) = self::molecules(&[0.5, 1.5, 2.5], &[[0, 1], [1, 2], [0, 2]]);
        assert!(molecules.bond_around_the_box(&scene).is_none());
    }
}
