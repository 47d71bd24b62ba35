//! Creates a scene from its parts, with the same checks as for a scene from a file.

use std::collections::HashSet;
use std::mem::take;

use crate::Vector;
use crate::model::{Bond, Inlet, Particle, ParticleId, Scene, SceneParts, Space, Species, StaticSurface, Until};
use crate::scene::builder::SceneBuilder;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind, missing, refuse};
use crate::scene::groups::Groups;
use crate::scene::interactions::Interactions;
use crate::scene::limits::{affordable, diameter, motion, on_flat_axes, spin};
use crate::scene::validate::plan;
use crate::scene::validate::start::Configuration;

impl Scene {
    /// Validates parts and creates a scene. The parts may come from another scene and may be modified.
    ///
    /// Positions are wrapped into the box along periodic axes. The scene does not continue an earlier run, even if the
    /// parts come from a scene that does.
    ///
    /// ```
    /// # use carom::model::Scene;
    /// # use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
    /// # let fluid = SceneBuilder::new("fluid")
    /// #     .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
    /// #     .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
    /// #     .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.3))
    /// #     .temperature(1.0)
    /// #     .build()?;
    /// let mut parts = fluid.into_parts();
    /// parts.particles[0].velocity.x += 10.0;
    /// let hotter = Scene::new(parts)?;
    /// # assert!(hotter.particles()[0].velocity.x > 5.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`SceneError`] for the first error, as for a scene from a file.
    pub fn new(parts: SceneParts) -> Result<Self, SceneError> {
        let mut builder = SceneBuilder::of_parts(SceneParts { predecessor: None, ..parts });
        builder.check_header()?;
        let mut species = builder.checked_species()?;
        let space = builder.checked_space(&species)?;
        builder.set_accelerations(&mut species, &space)?;
        let parts = &mut builder.parts;
        let interactions = Interactions::given(take(&mut parts.interactions), &parts.table, &species)?;
        let (mut particles, static_surfaces) = (take(&mut parts.particles), take(&mut parts.static_surfaces));
        if particles.is_empty() && !parts.inlets.iter().any(Inlet::has_new_particles) {
            return Err(missing(&ConfigPath::root(), "particle", "a scene needs at least one particle"));
        }
        check_particles(&mut particles, &species, &space)?;
        let bonds = take(&mut parts.bonds).into_iter().enumerate();
        let bonds: Vec<_> =
            bonds.map(|(index, bond)| (bond, ConfigPath::entry("bond", index).key("particles"))).collect();
        check_bonds(&bonds, &particles, &interactions)?;
        check_surfaces(&static_surfaces, &particles, &species)?;
        let groups = Groups { particles, bonds, static_surfaces, starts: Vec::new() };
        let surfaces = builder.checked_surfaces(&species, &space)?;
        let displacement = builder.parts.displacement;
        let inlets = builder.checked_inlets(&species, &space)?;
        let mut start = Configuration { groups, interactions, space, displacement, surfaces, inlets };
        builder.check_plan(&start)?;
        let separated = builder.separate(&mut start)?;
        builder.check_places(&start)?;
        builder.settled(Scene { separated, ..builder.assembled(start) })
    }

    /// Returns the scene with a different limit of the measurement.
    ///
    /// # Errors
    /// [`SceneErrorKind::Value`] if the time is not positive or the number of events is 0. In a replica exchange, the
    /// time must also be a whole number of exchange intervals, and a number of events is not allowed.
    pub fn with_limit(self, limit: Until) -> Result<Self, SceneError> {
        let at = ConfigPath::root().key("run");
        plan::check_limit(limit, at.key("until_time"), at.key("until_events"))?;
        let mut parts = self.into_parts();
        parts.run.limit = limit;
        parts.check_exchange()?;
        Ok(Self::of_parts(parts))
    }
}

fn check_particles(particles: &mut [Particle], species: &[Species], space: &Space) -> Result<(), SceneError> {
    let at = ConfigPath::root().key("particle");
    affordable(particles.len() as u64, &at)?;
    for (index, particle) in particles.iter_mut().enumerate() {
        let Some(species) = species.get(particle.species.0 as usize) else {
            let expected = format!("below {}, the number of species", species.len());
            return refuse(at.index(index).key("species"), particle.species.0, expected);
        };
        on_flat_axes(&particle.position, &space.lower, space, &at.index(index).key("position"))?;
        let key = at.index(index).key("velocity");
        on_flat_axes(&particle.velocity, &Vector::zeros(), space, &key)?;
        motion(species, &particle.velocity, &key)?;
        spin(&particle.spin, species, space, &at.index(index).key("spin"))?;
        diameter(particle.diameter, species, at.index(index).key("diameter"), &at.index(index))?;
        particle.position = space.wrapped(particle.position);
    }
    Ok(())
}

/// Checks that each bond is listed once, with the lower id first, and that at least one of its particles moves.
fn check_bonds(
    bonds: &[(Bond, ConfigPath)],
    particles: &[Particle],
    interactions: &Interactions<'_>,
) -> Result<(), SceneError> {
    let mut seen = HashSet::new();
    for (bond, at) in bonds {
        let [a, b] = bond.pair;
        if let Some(id) = bond.pair.iter().find(|id| id.0 as usize >= particles.len()) {
            let kind = SceneErrorKind::NoParticle { id: id.0, particles: particles.len() };
            return Err(SceneError::new(at.clone(), kind));
        }
        let is_static = |id: &ParticleId| interactions.species[particles[id.0 as usize].species.0 as usize].is_static();
        if a >= b || bond.pair.iter().all(is_static) {
            let expected = "two different particles, the lower id first, at least one of them moving";
            return refuse(at.clone(), format!("[{}, {}]", a.0, b.0), expected);
        }
        if !interactions.has(bond.interaction) {
            return refuse(at.clone(), bond.interaction.0, "the number of an interaction");
        }
        if !seen.insert(bond.pair) {
            return Err(SceneError::new(at.clone(), SceneErrorKind::BondedTwice { first: a.0, second: b.0 }));
        }
    }
    Ok(())
}

fn check_surfaces(surfaces: &[StaticSurface], particles: &[Particle], species: &[Species]) -> Result<(), SceneError> {
    let count = particles.len();
    for (index, surface) in surfaces.iter().enumerate() {
        let is_there = surface.particles.start <= surface.particles.end && surface.particles.end as usize <= count;
        let has_rims = surface.rims.iter().flatten().all(|id| (id.0 as usize) < count);
        if !(is_there && has_rims) {
            let expected = format!("particles below {count}");
            return refuse(ConfigPath::entry("mesh", index), format!("{:?}", surface.particles), expected);
        }
        if !species.get(surface.species.0 as usize).is_some_and(Species::is_static) {
            return refuse(ConfigPath::entry("mesh", index).key("species"), surface.species.0, "a static species");
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::space::Boundary;
    use crate::model::{Bond, InteractionId, Potential, SpeciesId};
    use crate::scene::{Fill, InteractionDraft, Lattice, SpeciesDraft};

    fn fluid() -> Scene {
        SceneBuilder::new("fluid")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Potential::square_well(1.0, 1.5, 1.0).unwrap()).between("A", "A"))
            .interaction(InteractionDraft::new(Potential::bond(1.0, 1.8).unwrap()).named("rope"))
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.3))
            .temperature(1.0)
            .bond([0, 1], "rope")
            .build()
            .unwrap()
    }

    #[test]
    fn scene_survives_conversion_to_parts_and_back() {
        let scene = fluid();
        assert_eq!(Scene::new(scene.clone().into_parts()).unwrap(), scene);
    }

    #[test]
    fn a_position_beyond_a_side_is_wrapped() {
        let scene = fluid();
        let mut parts = scene.clone().into_parts();
        parts.particles[5].position.x -= 3.0 * parts.space.size.x;
        let moved = Scene::new(parts).unwrap();
        assert!((moved.particles()[5].position - scene.particles()[5].position).norm() < 1e-14);
    }

    #[test]
    fn invalid_scene_parts_are_rejected_at_their_key() {
        type Change = fn(&mut SceneParts);
        let changes: [(&str, Change, &str); 17] = [
            ("name", |p| p.name = "a/b".into(), "name"),
            ("diameter", |p| p.species[0].diameter = -1.0, "species[0].diameter"),
            ("no species", |p| p.species.clear(), ""),
            ("restitution", |p| p.interactions[0].law.restitution = 1.5.into(), "interaction[0].restitution"),
            ("no interaction", |p| drop(p.interactions.pop()), "bond[0].particles"),
            ("interactions", |p| p.interactions.clear(), "interaction"),
            ("box", |p| p.space.size.x = 2.9, "space.size[0]"),
            ("flat", |p| p.space.boundary[2] = Boundary::Flat, "space.size[2]"),
            ("species of a particle", |p| p.particles[3].species = SpeciesId(1), "particle[3].species"),
            ("position", |p| p.particles[3].position.y = f64::NAN, "particle[3].position[1]"),
            ("velocity", |p| p.particles[3].velocity.y = f64::INFINITY, "particle[3].velocity[1]"),
            ("overlap", |p| p.particles[9].position = p.particles[7].position, "particle[9]"),
            ("no particle", |p| p.particles.clear(), ""),
            ("bond", |p| p.bonds[0].pair[1].0 = 108, "bond[0].particles"),
            ("twice", |p| p.bonds.push(p.bonds[0]), "bond[1].particles"),
            (
                "alone",
                |p| p.bonds.push(Bond { pair: [ParticleId(4); 2], interaction: InteractionId(1) }),
                "bond[1].particles",
            ),
            ("limit", |p| p.run.limit.time = Some(-1.0), "run.until_time"),
        ];
        for (name, change, at) in changes {
            let mut parts = fluid().into_parts();
            change(&mut parts);
            let error = Scene::new(parts).expect_err(name);
            assert_eq!(error.config_path().to_string(), at, "{name}: {error}");
        }
    }
}
