//! Hash of the state point of a system.

use super::space::Boundary;
use super::{ContactLaw, IndividualDiameters, Roughness, Scene, TcRule};

/// Systems with different hashes draw different random numbers from the same seed. The hash does not depend on names,
/// the order of species, species without particles, or the division into stages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct StatePoint(u64);

impl StatePoint {
    pub fn new(number: u64) -> Self {
        Self(number)
    }

    pub fn number(self) -> u64 {
        self.0
    }

    pub fn of(scene: &Scene, population: &[usize]) -> Self {
        let species = |id: usize| {
            let species = &scene.species[id];
            let state = Self(population[id] as u64).with(&[species.mass, species.diameter]);
            let state = species.individual.iter().fold(state, Self::with_individual);
            state.with(species.acceleration.as_slice()).with(species.moment_of_inertia.as_slice())
        };
        let interaction = |id: usize| {
            let interaction = &scene.interactions[id];
            let potential = &interaction.potential;
            Self(0).with(potential.radii()).with(potential.energies()).with_law(&interaction.law)
        };
        let present = (0..scene.species.len()).filter(|&id| population[id] > 0);
        let meet = |pair: [usize; 2]| pair.iter().all(|&id| population[id] > 0);
        let pairs = scene.table.iter().filter(|(pair, _)| meet(*pair)).map(|(pair, id)| {
            let [a, b] = pair.map(|id| species(id).0);
            interaction(id.0 as usize).and(a.wrapping_add(b))
        });
        let walls = scene.space.boundary.iter().flat_map(Boundary::contact_laws).flatten();
        let walls = walls.map(|law| Self(1).with_law(&law));
        let of_surfaces = scene.surfaces.iter().filter_map(|surface| surface.law.temperature());
        let belts = scene.surfaces.iter().filter_map(|surface| surface.surface_velocity);
        let belts: Vec<Self> = belts.map(|velocity| Self(4).with(&velocity.numbers())).collect();
        let temperatures = scene.wall_temperatures.iter().flatten().flatten().copied().chain(of_surfaces);
        let temperatures = temperatures.map(|temperature| Self(2).with(&[temperature]));
        let inlets = scene.inlets.iter().map(|inlet| {
            let shares = inlet.composition.iter().map(|(id, share)| species(id.0 as usize).with(&[*share]));
            let flow = Self(3).with(&[inlet.rate, inlet.temperature]).with(inlet.velocity.as_slice());
            let flow = flow.and(sum(shares));
            if inlet.recirculate.is_empty() { flow } else { flow.and(6) }
        });
        let inlets: Vec<Self> = inlets.collect();
        let all = Self(0)
            .with(scene.space.size.as_slice())
            .with(&[scene.shear_rate.unwrap_or(0.0), scene.contact_time.unwrap_or(0.0)])
            .and(sum(present.map(species)))
            .and(sum(pairs))
            .and(sum(scene.bonds.iter().map(|bond| interaction(bond.interaction.0 as usize))))
            .and(sum(walls.chain(temperatures)));
        let all = if scene.tc_rule == TcRule::default() { all } else { all.and(5) };
        let all = scene.sleep.map_or(all, |sleep| all.and(6).with(&sleep.numbers()));
        // Scenes without these keep their random numbers.
        [belts, inlets]
            .into_iter()
            .filter(|parts| !parts.is_empty())
            .fold(all, |all, parts| all.and(sum(parts.into_iter())))
    }

    pub fn at_start(scene: &Scene) -> Self {
        Self::of(scene, &scene.population())
    }

    fn with_individual(self, individual: &IndividualDiameters) -> Self {
        let masses = self.and(individual.masses as u64);
        individual.distribution.as_ref().map_or(masses, |distribution| masses.with(&distribution.numbers()))
    }

    fn with_law(self, law: &ContactLaw) -> Self {
        let of_law = self.with(&law.restitution.numbers());
        let add = |rough: Roughness| of_law.with(&[rough.tangential_restitution, rough.friction]);
        law.roughness.map_or(of_law, add)
    }

    pub fn with(self, values: &[f64]) -> Self {
        values.iter().fold(self, |hash, value| hash.and((value + 0.0).to_bits()))
    }

    pub fn seed(self, seed: u64) -> u64 {
        self.and(seed).0
    }

    /// The finalizer of SplitMix64, a bijection of 64 bits in which each bit depends on all others (G. L. Steele, D.
    /// Lea, C. H. Flood, OOPSLA 2014, [doi:10.1145/2660193.2660195](https://doi.org/10.1145/2660193.2660195)).
    fn and(self, word: u64) -> Self {
        let mut hash = (self.0 ^ word).wrapping_add(0x9e37_79b9_7f4a_7c15);
        hash = (hash ^ (hash >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        hash = (hash ^ (hash >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Self(hash ^ (hash >> 31))
    }
}

/// Combines the hashes of several parts, independently of their order.
fn sum(parts: impl Iterator<Item = StatePoint>) -> u64 {
    parts.fold(0, |sum: u64, part| sum.wrapping_add(part.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;
    use crate::model::{Potential, SceneParts, Space};
    use crate::scene::{InteractionDraft, SceneBuilder, SpeciesDraft};

    const UNLIKE: [f64; 2] = [0.8, 0.75];

    /// `unlike` is the restitution and the contact distance of pairs of unlike particles.
    fn scene(names: [&str; 2], masses: [f64; 2], unlike: [f64; 2]) -> SceneBuilder {
        let hard = |diameter| Potential::hard_sphere(diameter).unwrap();
        let diameter = |mass: f64| if mass < 1.0 { 0.5 } else { 1.0 };
        let mut builder = SceneBuilder::new("scene").space(Space::periodic_cube(7.0));
        for (name, mass) in names.into_iter().zip(masses) {
            builder = builder
                .species(SpeciesDraft::new(name).mass(mass).diameter(diameter(mass)))
                .interaction(InteractionDraft::new(hard(diameter(mass))).between(name, name).restitution(0.9));
        }
        builder = builder
            .interaction(InteractionDraft::new(hard(unlike[1])).between(names[0], names[1]).restitution(unlike[0]));
        for (k, mass) in [0.7, 1.3, 1.3].into_iter().enumerate() {
            let name = if mass == masses[0] { names[0] } else { names[1] };
            builder = builder.particle(name, Vector::new(1.0 + 2.0 * k as f64, 0.0, 0.0), Vector::zeros());
        }
        builder
    }

    fn of(builder: SceneBuilder) -> StatePoint {
        StatePoint::at_start(&builder.build().unwrap())
    }

    #[test]
    fn state_point_ignores_names_order_and_unused_species() {
        let first = of(scene(["A", "B"], [0.7, 1.3], UNLIKE));
        assert_eq!(first, of(scene(["C", "A"], [1.3, 0.7], UNLIKE)));
        assert_eq!(
            first,
            of(scene(["A", "B"], [0.7, 1.3], UNLIKE).species(SpeciesDraft::new("unused").mass(2.0).diameter(0.1)))
        );
    }

    #[test]
    fn state_point_depends_on_every_physical_parameter() {
        let plain = || scene(["A", "B"], [0.7, 1.3], UNLIKE);
        let slit = Space {
            boundary: [Boundary::walls(0.9), Boundary::Periodic, Boundary::Periodic],
            ..Space::periodic_cube(7.0)
        };
        let slit = |temperature: Option<f64>| {
            let walls = plain().space(slit.clone());
            temperature.map_or(walls.clone(), |temperature| walls.wall_temperature(0, temperature))
        };
        let changed = |change: fn(&mut SceneParts)| {
            let mut parts = plain().build().unwrap().into_parts();
            change(&mut parts);
            StatePoint::at_start(&Scene::new(parts).unwrap())
        };
        let points = [
            of(plain()),
            of(plain().particle("A", Vector::new(1.0, 3.0, 3.0), Vector::zeros())),
            of(plain().particle("B", Vector::new(1.0, 3.0, 3.0), Vector::zeros())),
            of(scene(["A", "B"], [0.7, 1.3], [0.8, 0.74])),
            of(scene(["A", "B"], [0.7, 1.3], [0.7, 0.75])),
            of(plain().space(Space::periodic_cube(7.1))),
            of(slit(None)),
            of(slit(Some(1.0))),
            of(slit(Some(1.1))),
            changed(|parts| parts.interactions[0].law = parts.interactions[0].law.with_friction(0.3)),
            changed(|parts| parts.interactions[0].law = parts.interactions[0].law.with_friction(0.4)),
            changed(|parts| parts.interactions[0].law = parts.interactions[0].law.with_tangential_restitution(0.3)),
            changed(|parts| parts.species[1].moment_of_inertia = Some(0.1)),
        ];
        for (k, point) in points.iter().enumerate() {
            assert!(!points[..k].contains(point), "{k}");
            assert_ne!(point.seed(1), point.seed(2));
        }
    }
}
