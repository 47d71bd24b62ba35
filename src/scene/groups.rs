//! Places the particles of a scene, group by group. Groups with random positions are placed last and fill the remaining
//! space. Ids follow the order of the groups in the scene.

mod placing;

pub(crate) use self::placing::Placing;
use self::placing::is_random;
use crate::Vector;
use crate::base::numbers::id;
use crate::engine::surfaces::Surfaces;
use crate::model::StaticSurface;
use crate::model::diameters::{Diameters, diameters_of_newcomers, ranges_of_diameters};
use crate::model::limits::{LARGEST, is_positive};
use crate::model::scene::population_of;
use crate::model::space::{Boundary, Space};
use crate::model::{Bond, Inlet, Particle, ParticleId, Species, SpeciesId};
use crate::prepare::velocity::Drawn;
use crate::scene::builder::SceneBuilder;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind, missing, refuse};
use crate::scene::interactions::{Interactions, species_named};
use crate::scene::limits::{self, affordable, motion, on_flat_axes};
use crate::scene::unvalidated::{Group, Listed, LocatedGroup, SurfaceFill};
use crate::scene::validate::start;

pub(crate) struct Groups {
    pub particles: Vec<Particle>,
    pub bonds: Vec<(Bond, ConfigPath)>,
    pub static_surfaces: Vec<StaticSurface>,
    /// First particle and config path of each group. Empty if the particles have no groups.
    pub starts: Vec<(usize, ConfigPath)>,
}

impl Groups {
    pub(crate) fn place(
        scene: &SceneBuilder,
        species: &[Species],
        (space, surfaces): (&Space, &Surfaces),
        interactions: &mut Interactions<'_>,
    ) -> Result<Self, SceneError> {
        let contacts = interactions.contacts();
        let mut placing = Placing { scene, species, space, contacts: &contacts, surfaces, layouts: Vec::new() };
        let mut parts: Vec<Vec<Particle>> = vec![Vec::new(); scene.groups.len()];
        placing.check_amounts()?;
        let sized;
        if species.iter().any(|species| species.individual.is_some()) {
            sized = contacts.clone().among(species, placing.ranges_of_diameters()?);
            placing.contacts = &sized;
        }
        let mut total = 0;
        for at_random in [false, true] {
            let mut occupancy = None;
            for (index, placed) in scene.groups.iter().enumerate().filter(|(_, it)| is_random(it) == at_random) {
                if at_random && occupancy.is_none() {
                    occupancy = Some(placing.occupied(&parts));
                }
                parts[index] = match &placed.group {
                    Group::Listed(particles) => listed(particles, species, space, &placed.at)?,
                    Group::Surface(surface) => placing.surface(index, surface, &placed.at)?,
                    Group::Fill(_) => placing.fill(index, placed, occupancy.as_mut())?,
                    Group::Chain(chain) => {
                        placing.chains(index, chain, &placed.at, interactions, occupancy.as_mut())?
                    }
                };
                // The number of particles of a static surface was unknown before, so the total is checked again.
                total += parts[index].len() as u64;
                affordable(total, &placed.at)?;
            }
        }
        Self::joined(placing, parts, interactions)
    }

    fn joined(
        placing: Placing<'_>,
        parts: Vec<Vec<Particle>>,
        interactions: &mut Interactions<'_>,
    ) -> Result<Self, SceneError> {
        let scene = placing.scene;
        let particles = Vec::with_capacity(parts.iter().map(Vec::len).sum());
        let mut groups = Self { particles, bonds: Vec::new(), static_surfaces: Vec::new(), starts: Vec::new() };
        for (index, (part, LocatedGroup { at, group })) in parts.into_iter().zip(&scene.groups).enumerate() {
            let first = groups.particles.len();
            groups.starts.push((first, at.clone()));
            match group {
                Group::Chain(chain) => {
                    for k in (1..part.len()).filter(|k| !(*k as u64).is_multiple_of(chain.length)) {
                        let kind = part[k].species;
                        let interaction = interactions.bond(&chain.bond, kind, kind, &at.key("bond"))?;
                        let pair = [first + k - 1, first + k].map(|index| ParticleId(id(index)));
                        groups.bonds.push((Bond { pair, interaction }, at.clone()));
                    }
                }
                Group::Surface(surface) => {
                    let layout = placing.layouts.iter().find(|(of, _)| *of == index).map(|(_, layout)| layout);
                    groups.static_surfaces.extend(layout.map(|layout| {
                        StaticSurface::new(surface_name(surface, index), part[0].species, first, layout)
                    }));
                }
                Group::Listed(_) | Group::Fill(_) => {}
            }
            groups.particles.extend(part);
        }
        let is_filled = scene.inlets.iter().any(|inlet| inlet.rate.is_some())
            || scene.parts.inlets.iter().any(Inlet::has_new_particles);
        if groups.particles.is_empty() && !is_filled {
            let why = "give [[particle]], [[file]], [[chain]], [[fill]] or an [[inlet]] with a rate";
            return Err(missing(&ConfigPath::root(), "particle", why));
        }
        start::list_bonds(&mut groups, &scene.bonds, interactions)?;
        Ok(groups)
    }

    /// Returns the range of diameters of each species.
    pub(crate) fn ranges_of_diameters(&self, species: &[Species]) -> Vec<Diameters> {
        self.ranges_with(species, &[])
    }

    /// Like [`Self::ranges_of_diameters`], with the particles that inlets let in.
    pub(crate) fn ranges_with(&self, species: &[Species], inlets: &[Inlet]) -> Vec<Diameters> {
        let own = self.particles.iter().filter_map(|particle| Some((particle.species, particle.diameter?)));
        ranges_of_diameters(species, own.chain(diameters_of_newcomers(species, inlets.iter().flat_map(Inlet::species))))
    }

    /// Removes the spins of the particles of each `[[file]]`.
    pub(crate) fn forget_spins_of_files(&mut self) {
        let ends = self.starts.iter().skip(1).map(|(first, _)| *first).chain([self.particles.len()]);
        for ((first, at), end) in self.starts.iter().zip(ends) {
            if at.is_in("file") {
                self.particles[*first..end].iter_mut().for_each(|particle| particle.spin = Vector::zeros());
            }
        }
    }

    /// Number of particles of each species. Entering species count two more per inlet, so that checks cover their pairs.
    pub(crate) fn counts(&self, species: usize, inlets: &[Inlet]) -> Vec<usize> {
        let mut counts = population_of(&self.particles, species);
        inlets.iter().flat_map(Inlet::species).for_each(|species| counts[species.0 as usize] += 2);
        counts
    }

    /// Settings for the random velocities of fills and chains.
    pub(crate) fn drawn(&self, scene: &SceneBuilder) -> Vec<Drawn> {
        let ends = self.starts.iter().skip(1).map(|(first, _)| *first).chain([self.particles.len()]);
        let ids = self.starts.iter().zip(ends).map(|((first, _), end)| *first..end);
        ids.zip(&scene.groups)
            .enumerate()
            .filter_map(|(group, (ids, placed))| {
                let (own, velocity) = match &placed.group {
                    Group::Fill(fill) => ((fill.temperature, fill.speed), fill.velocity),
                    Group::Chain(chain) => ((chain.temperature, chain.speed), Vector::zeros()),
                    Group::Listed(_) | Group::Surface(_) => return None,
                };
                let (temperature, speed) = scene.motion(own);
                Some(Drawn { ids, group, temperature, speed, velocity })
            })
            .collect()
    }

    pub(crate) fn path_of(&self, id: usize) -> ConfigPath {
        if self.starts.is_empty() {
            return ConfigPath::entry("particle", id);
        }
        let group = self.starts.partition_point(|(first, _)| *first <= id);
        self.starts.get(group.wrapping_sub(1)).map_or_else(ConfigPath::root, |(_, at)| at.clone())
    }
}

/// Checks particles with given positions, and wraps the positions into the box.
fn listed(listed: &Listed, species: &[Species], space: &Space, at: &ConfigPath) -> Result<Vec<Particle>, SceneError> {
    let named = |name: &String| species.iter().position(|candidate| candidate.name == *name);
    let known: Vec<Option<usize>> = listed.names.iter().map(named).collect();
    let mut particles = Vec::with_capacity(listed.particles.len());
    for (row, particle) in listed.particles.iter().enumerate() {
        let found = known.get(particle.species.0 as usize).copied().flatten();
        let Some(kind) = found.filter(|kind| is_right(particle, &species[*kind], space)) else {
            return Err(wrong(listed, row, (species, space), at));
        };
        let position = space.wrapped(particle.position);
        particles.push(Particle { species: SpeciesId(id(kind)), position, ..*particle });
    }
    Ok(particles)
}

fn is_right(particle: &Particle, species: &Species, space: &Space) -> bool {
    let Particle { position, velocity, spin, diameter, .. } = particle;
    let is_sized = species.individual.is_some() == diameter.is_some() && diameter.is_none_or(is_positive);
    let is_on_flat =
        |k: usize| space.boundary[k] != Boundary::Flat || (position[k] == space.lower[k] && velocity[k] == 0.0);
    let turns = |k: usize| spin[k] == 0.0 || (!species.is_static() && space.turns_about(k));
    position.iter().chain(velocity.iter()).chain(spin.iter()).all(|x| x.abs() <= LARGEST)
        && (0..3).all(|k| is_on_flat(k) && turns(k))
        && (!species.is_static() || *velocity == Vector::zeros())
        && is_sized
}

fn wrong(listed: &Listed, row: usize, (species, space): (&[Species], &Space), at: &ConfigPath) -> SceneError {
    let particle = &listed.particles[row];
    let place = |keys: [&'static str; 2]| listed.place(at, keys, row);
    let checked = || {
        let at_species = place(["species", "species"]);
        let Some(name) = listed.names.get(particle.species.0 as usize) else {
            return refuse(at_species, particle.species.0, format!("a number below {}", listed.names.len()));
        };
        let id = species_named(species, name, &at_species)?;
        let [position, velocity] = [["position", "positions"], ["velocity", "velocities"]].map(place);
        on_flat_axes(&particle.position, &space.lower, space, &position)?;
        on_flat_axes(&particle.velocity, &Vector::zeros(), space, &velocity)?;
        motion(&species[id.0 as usize], &particle.velocity, &velocity)?;
        limits::spin(&particle.spin, &species[id.0 as usize], space, &place(["spin", "spins"]))?;
        limits::diameter(particle.diameter, &species[id.0 as usize], place(["diameter", "diameters"]), at)
    };
    checked().err().unwrap_or_else(|| SceneError::new(at.clone(), SceneErrorKind::value("wrong", "a particle")))
}

fn surface_name(surface: &SurfaceFill, number: usize) -> String {
    surface.name.clone().unwrap_or_else(|| format!("mesh {number}"))
}
