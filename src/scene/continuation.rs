//! Builds a scene that starts from the end of a run, and checks the inherited state.

use std::collections::HashMap;
use std::convert::Infallible;
use std::path::Path;
use std::sync::Arc;

use crate::Vector;
use crate::base::numbers::id as id_of;
use crate::engine::Simulation;
use crate::model::predecessor::LastState;
use crate::model::space::{AXES, Boundary, Space};
use crate::model::{
    Bond, InputFile, Interaction, InteractionId, Particle, ParticleId, Potential, Predecessor, Scene, SceneSurface,
    Species, SpeciesId, StaticSurface, Units,
};
use crate::scene::builder::SceneBuilder;
use crate::scene::classes::expand_families;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind, refuse};
use crate::scene::groups::Groups;
use crate::scene::interactions::Interactions;
use crate::scene::limits::motion;
use crate::scene::parse;
use crate::scene::source::Source;
use crate::scene::unvalidated::{SpeciesDraft, UnvalidatedStart};
use crate::scene::validate::start::Configuration;

pub(crate) struct LastRun {
    pub simulation: Simulation,
    pub checkpoint: InputFile,
}

struct Left {
    particles: Vec<Particle>,
    images: Vec<[i32; 3]>,
    /// Ids of the particles in the run.
    ids: Vec<ParticleId>,
}

fn at_start() -> ConfigPath {
    ConfigPath::root().key("start").key("from")
}

impl Scene {
    /// Reads a scene that continues a simulation. Particles, bonds and static meshes come from the simulation, and
    /// everything else from the text and the overrides.
    pub(crate) fn from_toml_after(
        text: &str,
        name: &Path,
        overrides: &[(&str, &str)],
        simulation: &Simulation,
    ) -> Result<Self, SceneError> {
        let source = Source::new(&name.to_string_lossy(), text.to_owned(), overrides);
        let file = source.read()?.starting_from("");
        let last = |_: &Path| {
            let checkpoint = InputFile {
                path: String::new(),
                checksum: String::new(),
                unused: Vec::new(),
                extra_bytes: 0,
                merged_vertices: 0,
            };
            Ok(LastRun { simulation: simulation.clone(), checkpoint })
        };
        let parts = parse::parts(file, &simulation.scene().name, Path::new(""), None);
        Self::of_builder(parts, &last).map_err(|error| source.located(error))
    }
}

impl SceneBuilder {
    pub(crate) fn continued(
        &self,
        start: &UnvalidatedStart,
        open: &dyn Fn(&Path) -> Result<LastRun, SceneErrorKind>,
    ) -> Result<Scene, SceneError> {
        let last = open(&start.from).map_err(|kind| SceneError::new(at_start(), kind))?;
        let found = &last.checkpoint.checksum;
        if let Some(expected) = start.checksum.as_ref().filter(|expected| *expected != found) {
            let (found, expected) = (found.clone(), expected.clone());
            let kind = SceneErrorKind::RunChanged { path: start.from.clone(), found, expected };
            return Err(SceneError::new(ConfigPath::root().key("start").key("checksum"), kind));
        }
        let next = self.inheriting(start, &last.simulation)?;
        next.starting_from(&last).map_err(|error| next.origins.located(error))
    }

    fn inheriting(&self, start: &UnvalidatedStart, simulation: &Simulation) -> Result<Self, SceneError> {
        let (mut next, run) = (self.clone(), simulation.scene());
        (next.parts.start_time, next.parts.displacement) = (simulation.time(), simulation.displacement());
        if !start.has_seed {
            next.parts.seed = run.seed;
        }
        next.parts.units = self.inherited_units(run)?;
        next.size = next.size.or(Some(run.space.size));
        if !start.has_lower {
            next.parts.space.lower = run.space.lower;
        }
        if !start.has_space {
            next.parts.space.boundary = run.space.boundary;
            (next.parts.wall_temperatures, next.parts.shear_rate) = (run.wall_temperatures, run.shear_rate);
        }
        if !start.has_dynamics {
            (next.parts.contact_time, next.parts.tc_rule) = (run.contact_time, run.tc_rule);
            next.parts.sleep = run.sleep;
        }
        let gravity = next.gravity;
        if next.species.is_empty() {
            next.species = run.species.iter().map(SpeciesDraft::of).collect();
            expand_families(&mut next)?;
            if start.has_dynamics {
                let moving = next.species.iter_mut().filter(|species| species.mass.is_some());
                moving.for_each(|species| species.acceleration = Some(gravity));
            }
        } else if !start.has_dynamics {
            for species in next.species.iter_mut().filter(|species| species.mass.is_some()) {
                let same = run.species.iter().find(|other| other.name == species.name);
                species.acceleration = species.acceleration.or(same.map(|same| same.acceleration));
            }
        }
        Ok(next)
    }

    /// Returns the units of the earlier run. If it has none, the scene may name them.
    fn inherited_units(&self, run: &Scene) -> Result<Units, SceneError> {
        let own = &self.parts.units;
        if run.units.are_unnamed() {
            return Ok(own.clone());
        }
        if !own.are_unnamed() && *own != run.units {
            let Units { length, mass, time } = &run.units;
            let expected = format!("the units of the earlier run, {length}, {mass} and {time}: no number is converted");
            return refuse(ConfigPath::root().key("units"), "other units", expected);
        }
        Ok(run.units.clone())
    }

    fn starting_from(&self, last: &LastRun) -> Result<Scene, SceneError> {
        let run = last.simulation.scene();
        self.check_header()?;
        check_flat_axes(&self.parts.space.boundary, &run.space)?;
        let mut species = self.checked_species()?;
        let space = self.checked_space(&species)?;
        check_box(&space, &run.space)?;
        self.set_accelerations(&mut species, &space)?;
        let inherits = self.interactions.is_empty();
        let mut interactions = if inherits {
            Interactions::given(run.interactions.clone(), &run.table, &species)?
        } else {
            Interactions::new(&self.interactions, &species)?
        };
        let Left { particles, images, ids } = left(&last.simulation, &species, &space)?;
        let bonds = if inherits { run.bonds.clone() } else { bonds(run, &particles, &mut interactions)? };
        let wrapped = particles.iter().map(|it| Particle { position: space.wrapped(it.position), ..*it }).collect();
        let groups = Groups {
            particles: wrapped,
            bonds: bonds.iter().map(|bond| (*bond, at_start())).collect(),
            static_surfaces: static_surfaces(run, (&particles, &ids), &species)?,
            starts: vec![(0, at_start())],
        };
        // If a side opens or becomes periodic, distances across this side change. The new distances then determine
        // which pairs are captured.
        let is_kept = if has_same_periods(&space, &run.space) {
            kept(run, &species, &interactions, &bonds)
        } else {
            vec![false; interactions.len()]
        };
        let inlets = self.checked_inlets(&species, &space)?;
        if !inherits || !inlets.is_empty() {
            interactions.check_complete(&groups.counts(species.len(), &inlets))?;
        }
        let is_as_it_was = is_kept.iter().all(|kept| *kept) && has_same_walls(run, &species, &space);
        let mut with_surfaces = self.clone();
        if !self.has_surfaces {
            with_surfaces.parts.surfaces = surfaces_of(run, &species);
        }
        let surfaces = with_surfaces.checked_surfaces(&species, &space)?;
        let is_as_it_was = is_as_it_was && surfaces.of_scene() == run.surfaces;
        let displacement = self.parts.displacement;
        let start = Configuration { groups, interactions, space, displacement, surfaces, inlets };
        self.check_plan(&start)?;
        // With the same interactions, walls and surfaces as in the run, the positions need no check.
        if !is_as_it_was {
            self.check_places(&start)?;
        }
        let mut scene = self.assembled(start);
        scene.particles = particles;
        scene.inputs.insert(0, last.checkpoint.clone());
        let differences = differences(&scene, run);
        // Serialization into memory cannot fail.
        let simulation = if differences.is_empty() { postcard::to_allocvec(&last.simulation).ok() } else { None };
        // The particles of a scene are numbered from 0.
        let here = |id| ParticleId(place_of(&ids, id));
        let captured = last.simulation.captured_pairs();
        let captured = captured.into_iter().map(|(pair, state)| (pair.map(here), state)).collect();
        let state = Some(Arc::new(LastState { images, captured, is_kept, differences, simulation }));
        let (checkpoint, streams) = (last.checkpoint.clone(), run.next_stream());
        scene.predecessor = Some(Predecessor { checkpoint, streams, state });
        self.settled(scene)
    }
}

/// Returns the place of an id in an ascending list.
fn place_of(ids: &[ParticleId], id: ParticleId) -> u32 {
    id_of(ids.binary_search(&id).unwrap_or(0))
}

/// Returns the surfaces of a run, with the species ids of the new scene.
fn surfaces_of(run: &Scene, species: &[Species]) -> Vec<SceneSurface> {
    let here = |id: &SpeciesId| {
        let there = run.species.get(id.0 as usize)?;
        species.iter().position(|species| species.name == there.name).map(|index| SpeciesId(id_of(index)))
    };
    let meets_some =
        |surface: &&SceneSurface| surface.species.is_empty() || surface.species.iter().any(|id| here(id).is_some());
    let of_here = |surface: &SceneSurface| SceneSurface {
        species: surface.species.iter().filter_map(here).collect(),
        ..surface.clone()
    };
    run.surfaces.iter().filter(meets_some).map(of_here).collect()
}

/// Returns the surfaces of static spheres. `ids` are the ids of the particles in the run.
fn static_surfaces(
    run: &Scene,
    (particles, ids): (&[Particle], &[ParticleId]),
    species: &[Species],
) -> Result<Vec<StaticSurface>, SceneError> {
    let mut surfaces = run.static_surfaces.clone();
    for surface in &mut surfaces {
        // Static spheres never leave. Their ids follow one another, so that their new ids do as well.
        let first = place_of(ids, ParticleId(surface.particles.start));
        let moved = |id: u32| first + (id - surface.particles.start);
        surface.particles = moved(surface.particles.start)..moved(surface.particles.end);
        surface.rims.iter_mut().flatten().for_each(|id| *id = ParticleId(place_of(ids, *id)));
        let Some(sphere) = particles.get(surface.particles.start as usize) else { continue };
        surface.species = sphere.species;
        if !species[surface.species.0 as usize].is_static() {
            let value = format!("a run with static spheres of the mesh `{}`", surface.name);
            return refuse(at_start(), value, "the species of these spheres to be static in the new scene, too");
        }
    }
    Ok(surfaces)
}

fn check_flat_axes(boundary: &[Boundary; 3], run: &Space) -> Result<(), SceneError> {
    let word = |boundary: Boundary| if boundary == Boundary::Flat { "flat" } else { "not flat" };
    for (k, axis) in AXES.into_iter().enumerate() {
        let (here, there) = (word(boundary[k]), word(run.boundary[k]));
        if here != there {
            let expected = format!("{there}, as in the run given by [start]");
            return refuse(ConfigPath::root().key("space").key(axis), here, expected);
        }
    }
    Ok(())
}

fn check_box(space: &Space, run: &Space) -> Result<(), SceneError> {
    for (key, here, there) in [("size", space.size, run.size), ("lower", space.lower, run.lower)] {
        if let Some(k) = (0..3).find(|&k| here[k] != there[k]) {
            let expected = format!("{}, as in the run given by [start]; leave `{key}` out", there[k]);
            return refuse(ConfigPath::root().key("space").key(key).index(k), here[k], expected);
        }
    }
    Ok(())
}

/// Returns the particles at the end of a run, with the species ids of the new scene. Species are matched by name.
fn left(simulation: &Simulation, species: &[Species], space: &Space) -> Result<Left, SceneError> {
    let run = simulation.scene();
    let named: HashMap<&str, SpeciesId> =
        species.iter().zip(0..).map(|(it, id)| (it.name.as_str(), SpeciesId(id))).collect();
    let of_run: Vec<Option<SpeciesId>> = run.species.iter().map(|it| named.get(it.name.as_str()).copied()).collect();
    for (old, count) in run.species.iter().zip(simulation.population()) {
        if count > 0 && !named.contains_key(old.name.as_str()) {
            let known: Vec<&str> = species.iter().map(|species| species.name.as_str()).collect();
            let value = format!("a run with {count} particles of species `{}`", old.name);
            let expected = format!("only species of the scene: {}", known.join(", "));
            return refuse(at_start(), value, expected);
        }
    }
    let is_periodic = |space: &Space, k: usize| space.boundary[k] == Boundary::Periodic;
    let count = simulation.population().iter().sum();
    let mut left = Left {
        particles: Vec::with_capacity(count),
        images: Vec::with_capacity(count),
        ids: Vec::with_capacity(count),
    };
    let Ok(()) = simulation.for_each_now(|now| {
        let (mut position, mut image) = (now.position, now.image);
        for k in 0..3 {
            match (is_periodic(&run.space, k), is_periodic(space, k)) {
                (true, false) => image[k] = 0,
                (false, true) => position[k] = space.wrapped(position)[k],
                _ => {}
            }
        }
        // All species with particles were found above, so the default is never used.
        let species = of_run.get(now.species.0 as usize).copied().flatten().unwrap_or(SpeciesId(0));
        let particle = Particle { diameter: now.diameter, ..Particle::new(species, position, now.velocity) };
        left.particles.push(particle.spin(now.spin));
        left.images.push(image);
        left.ids.push(now.id);
        Ok::<(), Infallible>(())
    });
    for particle in &mut left.particles {
        let species = &species[particle.species.0 as usize];
        if species.individual.is_some() != particle.diameter.is_some() {
            let word = if particle.diameter.is_some() { "with" } else { "without" };
            let value = format!("a run {word} individual diameters of `{}`", species.name);
            return refuse(at_start(), value, format!("a scene {word} them, too"));
        }
        if particle.velocity != Vector::zeros() {
            motion(species, &particle.velocity, &at_start())?;
        }
        if species.is_static() {
            particle.spin = Vector::zeros();
        }
    }
    Ok(left)
}

/// Returns the bonds of a run, with the interactions of the new scene. Interactions are matched by name.
fn bonds(run: &Scene, particles: &[Particle], interactions: &mut Interactions<'_>) -> Result<Vec<Bond>, SceneError> {
    let mut bonds = Vec::with_capacity(run.bonds.len());
    for bond in &run.bonds {
        let Some(name) = &run.interactions[bond.interaction.0 as usize].name else {
            return refuse(
                at_start(),
                "a run with bonds whose interaction has no name",
                "a name for the interaction of each bond",
            );
        };
        let [a, b] = bond.pair.map(|id| particles[id.0 as usize].species);
        bonds.push(Bond { interaction: interactions.bond(name, a, b, &at_start())?, ..*bond });
    }
    Ok(bonds)
}

/// Whether two potentials have the same radii, and infinite barriers at the same steps. Finite energies may differ.
fn are_alike(a: &Potential, b: &Potential) -> bool {
    let are_finite =
        |potential: &Potential| potential.energies().iter().map(|energy| energy.is_finite()).collect::<Vec<_>>();
    a.radii() == b.radii() && a.is_bond() == b.is_bond() && are_finite(a) == are_finite(b)
}

/// Whether each interaction has the same discontinuities as in the earlier run. If so, pairs keep their states.
fn kept(run: &Scene, species: &[Species], interactions: &Interactions<'_>, bonds: &[Bond]) -> Vec<bool> {
    let in_run: HashMap<&str, usize> = run.species.iter().enumerate().map(|(k, it)| (it.name.as_str(), k)).collect();
    let mut is_kept = vec![true; interactions.len()];
    let mut compare = |id: InteractionId, before: Option<InteractionId>| {
        let before: Option<&Interaction> = before.map(|before| &run.interactions[before.0 as usize]);
        let now = &interactions.get(id).potential;
        is_kept[id.0 as usize] &= before.is_some_and(|before| are_alike(&before.potential, now));
    };
    // If diameters are individual, the distances of a pair depend on the diameters of its species, too.
    let is_scaled_alike = |now: usize, before: usize| {
        species[now].individual.is_none() || species[now].diameter == run.species[before].diameter
    };
    for ([a, b], id) in interactions.pairs() {
        let before = [a, b].map(|k| in_run.get(species[k].name.as_str()).copied());
        if let [Some(one), Some(other)] = before {
            let is_scaled_alike = is_scaled_alike(a, one) && is_scaled_alike(b, other);
            compare(id, run.table.get(one, other).filter(|_| is_scaled_alike));
        }
    }
    for (now, before) in bonds.iter().zip(&run.bonds) {
        compare(now.interaction, Some(before.interaction));
    }
    is_kept
}

fn has_same_periods(one: &Space, other: &Space) -> bool {
    let periodic = |space: &Space| space.boundary.map(|boundary| boundary == Boundary::Periodic);
    periodic(one) == periodic(other)
}

/// Whether walls and diameters are unchanged. If so, no particle overlaps a wall.
fn has_same_walls(run: &Scene, species: &[Species], space: &Space) -> bool {
    let diameters: HashMap<&str, f64> = run.species.iter().map(|it| (it.name.as_str(), it.diameter)).collect();
    let walls = |space: &Space| [0, 1, 2].map(|axis| space.walled_sides(axis));
    species.iter().all(|it| diameters.get(it.name.as_str()).is_none_or(|before| *before == it.diameter))
        && walls(space) == walls(&run.space)
}

/// Names the differences between a scene and a run that affect the dynamics.
fn differences(scene: &Scene, run: &Scene) -> Vec<&'static str> {
    let is_driven_by_walls = scene.has_thermal_walls();
    let differences = [
        ("the sides of the box", scene.space != run.space),
        ("the temperatures of the walls", scene.wall_temperatures != run.wall_temperatures),
        ("surfaces", scene.surfaces != run.surfaces),
        ("inlets", scene.inlets != run.inlets),
        ("the ids of the particles", run.has_flow()),
        ("the shear rate", scene.shear_rate != run.shear_rate),
        ("species or their accelerations", scene.species != run.species),
        (
            "interactions",
            scene.interactions != run.interactions || scene.table != run.table || scene.bonds != run.bonds,
        ),
        ("the contact time", scene.contact_time != run.contact_time),
        ("the rule of the TC model", scene.tc_rule != run.tc_rule),
        ("when grains fall asleep", scene.sleep != run.sleep),
        ("the seed of thermal walls", is_driven_by_walls && scene.seed != run.seed),
    ];
    differences.into_iter().filter(|(_, differs)| *differs).map(|(what, _)| what).collect()
}

#[cfg(test)]
mod tests;
