//! Places the particles of static surfaces, fills and chains.

use crate::Vector;
use crate::base::numbers::{self, trunc_to_u64};
use crate::engine::surfaces::Surfaces;
use crate::model::diameters::{Diameters, diameters_of_newcomers, ranges_of_diameters};
use crate::model::random::{Purpose, Random};
use crate::model::space::Space;
use crate::model::{Inlet, Particle, Potential, Species, SpeciesId};
use crate::prepare::chain::{self, Links};
use crate::prepare::packing::RandomFill;
use crate::prepare::packing::occupancy::{Contacts, Kind, Occupancy};
use crate::prepare::surface::{Layout, tight_spacing};
use crate::scene::builder::SceneBuilder;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing, refuse};
use crate::scene::filling::Filling;
use crate::scene::interactions::{Interactions, species_named};
use crate::scene::limits::{
    affordable, finite_vector, motion, not_negative, on_flat_axes, positive, positive_if_given,
};
use crate::scene::unvalidated::{Arrangement, Chain, Group, LocatedGroup, SurfaceFill};

pub(super) fn is_random(placed: &LocatedGroup) -> bool {
    match &placed.group {
        Group::Fill(fill) => fill.arrangement == Arrangement::Random,
        Group::Chain(chain) => chain.straight.is_none(),
        Group::Listed(_) | Group::Surface(_) => false,
    }
}

pub(crate) struct Placing<'a> {
    pub scene: &'a SceneBuilder,
    pub species: &'a [Species],
    pub space: &'a Space,
    pub contacts: &'a Contacts,
    pub surfaces: &'a Surfaces,
    /// Layout of each static surface, with the index of its group.
    pub layouts: Vec<(usize, Layout)>,
}

impl<'a> Placing<'a> {
    /// Rejects groups of particles that do not fit into memory, before any particle is created.
    pub(super) fn check_amounts(&self) -> Result<(), SceneError> {
        let mut total = 0_u64;
        for placed in &self.scene.groups {
            total = total.saturating_add(self.count(placed)?);
            affordable(total, &placed.at)?;
        }
        Ok(())
    }

    /// Expected number of particles in a group. Returns 0 for a static surface, which has no layout yet.
    fn count(&self, LocatedGroup { at, group }: &LocatedGroup) -> Result<u64, SceneError> {
        match group {
            Group::Listed(listed) => Ok(listed.particles.len() as u64),
            Group::Fill(fill) => Filling::count(fill, self, at),
            Group::Chain(chain) => Ok(chain.length.saturating_mul(chain.count)),
            Group::Surface(_) => Ok(0),
        }
    }

    fn at_rest(&self, Kind { species, diameter }: Kind, position: Vector) -> Particle {
        Particle { diameter, ..Particle::new(species, self.space.wrapped(position), Vector::zeros()) }
    }

    /// Returns the range of diameters of each species in all groups.
    pub(super) fn ranges_of_diameters(&self) -> Result<Vec<Diameters>, SceneError> {
        Ok(ranges_of_diameters(self.species, self.diameters_of_groups()?.into_iter()))
    }

    /// Returns the contact distances of the particles of all groups and inlets.
    fn contacts_with_newcomers(&self) -> Result<Contacts, SceneError> {
        let drafts = self.scene.inlets.iter().flat_map(|inlet| &inlet.composition);
        let entering = drafts.filter_map(|(name, _)| Some(SpeciesId(numbers::id(self.named(name)?))));
        let entering = entering.chain(self.scene.parts.inlets.iter().flat_map(Inlet::species));
        let diameters = self.diameters_of_groups()?.into_iter().chain(diameters_of_newcomers(self.species, entering));
        Ok(self.contacts.clone().among(self.species, ranges_of_diameters(self.species, diameters)))
    }

    fn named(&self, name: &String) -> Option<usize> {
        self.species.iter().position(|species| species.name == *name)
    }

    /// Returns the individual diameters of the particles of all groups, with their species.
    fn diameters_of_groups(&self) -> Result<Vec<(SpeciesId, f64)>, SceneError> {
        let mut all = Vec::new();
        for LocatedGroup { at, group } in &self.scene.groups {
            match group {
                Group::Listed(listed) => {
                    let known: Vec<Option<usize>> = listed.names.iter().map(|name| self.named(name)).collect();
                    let sized = |particle: &Particle| {
                        let found = known.get(particle.species.0 as usize).copied().flatten()?;
                        Some((SpeciesId(numbers::id(found)), particle.diameter?))
                    };
                    all.extend(listed.particles.iter().filter_map(sized));
                }
                Group::Fill(fill) => {
                    let kinds = Filling::new(fill, self, at)?.kinds;
                    all.extend(kinds.iter().filter_map(|kind| Some((kind.species, kind.diameter?))));
                }
                Group::Chain(_) | Group::Surface(_) => {}
            }
        }
        Ok(all)
    }

    pub(super) fn occupied(&self, parts: &[Vec<Particle>]) -> Occupancy<'a> {
        let filled: usize = parts.iter().map(Vec::len).sum();
        let random = self.scene.groups.iter().filter(|placed| is_random(placed));
        let to_come: u64 = random.map(|placed| self.count(placed).unwrap_or(0)).sum();
        let mut occupancy = Occupancy::new(self.space, self.contacts, filled + numbers::index(to_come));
        if !self.surfaces.of_scene().is_empty() {
            occupancy =
                occupancy.among(self.surfaces, self.species.iter().map(|species| 0.5 * species.diameter).collect());
        }
        for particle in parts.iter().flatten() {
            occupancy.take(particle.position, Kind::of(particle));
        }
        occupancy
    }

    pub(super) fn surface(
        &mut self,
        index: usize,
        surface: &SurfaceFill,
        at: &ConfigPath,
    ) -> Result<Vec<Particle>, SceneError> {
        let species = species_named(self.species, &surface.species, &at.key("species"))?;
        let kind = &self.species[species.0 as usize];
        self.refuse_individual(species, "the spheres of a mesh are equal", at)?;
        if !kind.is_static() {
            let expected = "a static species (static = true)";
            return refuse(at.key("species"), &surface.species, expected);
        }
        surface.shape.check(self.space, at)?;
        positive_if_given(surface.spacing, at.key("spacing"))?;
        let spacing = match surface.spacing {
            Some(spacing) => spacing,
            None => surface.shape.spacing(tight_spacing(species, self.species, &self.contacts_with_newcomers()?)),
        };
        let estimate = surface.shape.estimate(spacing);
        affordable(trunc_to_u64(estimate), at)?;
        let layout = surface.shape.layout(spacing, self.space);
        let mut particles = Vec::with_capacity(layout.points.len());
        for point in &layout.points {
            finite_vector(point, at)?;
            on_flat_axes(point, &self.space.lower, self.space, at)?;
            particles.push(self.at_rest(Kind::of_species(species), *point));
        }
        self.layouts.push((index, layout));
        Ok(particles)
    }

    fn refuse_individual(&self, species: SpeciesId, why: &str, at: &ConfigPath) -> Result<(), SceneError> {
        let species = &self.species[species.0 as usize];
        if species.individual.is_none() {
            return Ok(());
        }
        let value = format!("`{}`, which has individual diameters", species.name);
        refuse(at.key("species"), value, format!("a species with one diameter, because {why}"))
    }

    pub(super) fn fill(
        &self,
        index: usize,
        placed: &LocatedGroup,
        occupancy: Option<&mut Occupancy<'_>>,
    ) -> Result<Vec<Particle>, SceneError> {
        let (Group::Fill(fill), at) = (&placed.group, &placed.at) else { return Ok(Vec::new()) };
        let filling = Filling::new(fill, self, at)?;
        let mut kinds = filling.kinds.clone();
        Random::new(self.scene.parts.seed, Purpose::Composition, index).shuffle(&mut kinds);
        let positions = match (fill.arrangement, occupancy) {
            (Arrangement::Lattice(lattice), _) => filling.on_lattice(lattice, self, at)?,
            (Arrangement::Random, Some(occupancy)) => {
                let random = RandomFill {
                    kinds: &kinds,
                    species: self.species,
                    contacts: self.contacts,
                    space: self.space,
                    region: filling.region,
                    as_many_as_fit: fill.as_many_as_fit,
                    has_box: self.scene.groups.len() == 1
                        && fill.region.is_none()
                        && self.surfaces.of_scene().is_empty(),
                    seed: self.scene.parts.seed,
                    group: index,
                };
                random.positions(occupancy).map_err(|error| SceneError::new(at.clone(), error))?
            }
            (Arrangement::Random, None) => Vec::new(),
        };
        for kind in filling.species() {
            motion(&self.species[kind.0 as usize], &fill.velocity, &at.key("velocity"))?;
        }
        on_flat_axes(&fill.velocity, &Vector::zeros(), self.space, &at.key("velocity"))?;
        self.check_speeds((fill.temperature, fill.speed), filling.species(), at)?;
        let placed = positions.into_iter().zip(kinds);
        Ok(placed.map(|(position, kind)| self.at_rest(kind, position)).collect())
    }

    pub(super) fn chains(
        &self,
        index: usize,
        chain: &Chain,
        at: &ConfigPath,
        interactions: &mut Interactions<'_>,
        occupancy: Option<&mut Occupancy<'_>>,
    ) -> Result<Vec<Particle>, SceneError> {
        let species = species_named(self.species, &chain.species, &at.key("species"))?;
        self.refuse_individual(species, "the beads of a chain are equal", at)?;
        for (value, key) in [(chain.length, "length"), (chain.count, "count")] {
            if value == 0 {
                return refuse(at.key(key), 0, "at least 1");
            }
        }
        let bond = interactions.bond(&chain.bond, species, species, &at.key("bond"))?;
        let spacing = spacing(chain, &interactions.get(bond).potential, at)?;
        let positions = match (chain.straight, occupancy) {
            (Some((start, direction)), _) => self.straight(chain, &start, &direction, spacing, at)?,
            (None, Some(occupancy)) => {
                let links = Links {
                    length: numbers::index(chain.length),
                    spacing,
                    radius: 0.5 * self.species[species.0 as usize].diameter,
                    kind: Kind::of_species(species),
                    contact: self.contacts.get(species.0 as usize, species.0 as usize),
                };
                let mut random = Random::new(self.scene.parts.seed, Purpose::Placement, index);
                let grown = chain::grow_all(&links, chain.count, occupancy, &mut random);
                grown.map_err(|no_room| SceneError::new(at.clone(), no_room))?
            }
            (None, None) => Vec::new(),
        };
        self.check_speeds((chain.temperature, chain.speed), [species], at)?;
        let kind = Kind::of_species(species);
        Ok(positions.into_iter().map(|position| self.at_rest(kind, position)).collect())
    }

    fn straight(
        &self,
        chain: &Chain,
        start: &Vector,
        direction: &Vector,
        spacing: f64,
        at: &ConfigPath,
    ) -> Result<Vec<Vector>, SceneError> {
        on_flat_axes(start, &self.space.lower, self.space, &at.key("start"))?;
        on_flat_axes(direction, &Vector::zeros(), self.space, &at.key("direction"))?;
        positive(direction.norm(), at.key("direction"))?;
        if chain.count != 1 {
            let expected = "1: several chains cannot start at one place";
            return refuse(at.key("count"), chain.count, expected);
        }
        Ok(chain::straight(start, direction, chain.length, spacing))
    }

    fn check_speeds(
        &self,
        own: (Option<f64>, Option<f64>),
        species: impl IntoIterator<Item = SpeciesId>,
        at: &ConfigPath,
    ) -> Result<(), SceneError> {
        let (temperature, speed) = self.scene.motion(own);
        if let Some(temperature) = temperature {
            not_negative(temperature, at.key("temperature"))?;
        }
        let Some(speed) = speed else { return Ok(()) };
        not_negative(speed, at.key("speed"))?;
        if temperature.is_some() {
            return refuse(at.key("speed"), "given as well", "either speed or temperature");
        }
        match species.into_iter().find(|kind| self.species[kind.0 as usize].is_static()) {
            Some(_) if speed > 0.0 => refuse(at.key("speed"), speed, "none: a static species does not move"),
            _ => Ok(()),
        }
    }
}

/// Distance between neighbours in a chain `[length]`. By default, the middle between shortest and longest bond.
fn spacing(chain: &Chain, bond: &Potential, at: &ConfigPath) -> Result<f64, SceneError> {
    let why = "give it, because the pairs of this interaction can separate and have no bond length";
    match chain.spacing {
        Some(spacing) => positive(spacing, at.key("spacing")),
        None if bond.is_bond() => Ok(0.5 * (bond.range() + bond.core().unwrap_or(0.0))),
        None => Err(missing(at, "spacing", why)),
    }
}
