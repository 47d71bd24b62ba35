use super::contact::Contact;
use super::facet::{Facet, facets};
use super::moving::Motions;
use crate::Vector;
use crate::engine::States;
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Face};
use crate::model::{
    ContactLaw, Interaction, InteractionId, ParticleId, Scene, Species, SpeciesId, SurfaceLaw, SurfaceVelocity,
};
use std::borrow::Cow;
use std::collections::BTreeMap;

#[derive(Debug, Clone, Copy)]
pub(super) struct Wall {
    pub axis: u8,
    pub is_upper: bool,
    /// Coordinate of the wall along its axis `[length]`.
    pub at: f64,
    pub law: ContactLaw,
}

impl Wall {
    /// Returns the direction from the wall into the box, along the axis: 1 or -1.
    pub fn inwards(&self) -> f64 {
        if self.is_upper { -1.0 } else { 1.0 }
    }
}

/// Data of the scene. `inverse_masses`, `inverse_inertias` and `accelerations` have an entry for each particle.
#[derive(Debug)]
pub(super) struct World {
    scene: Scene,
    pub inverse_masses: Vec<f64>,
    /// Inverse moments of inertia; 0 for static particles `[1 / (mass length^2)]`.
    pub inverse_inertias: Vec<f64>,
    pub accelerations: Vec<Vector>,
    pub moving: Vec<u32>,
    /// Acceleration of all moving particles, if a stage has set it.
    gravity: Option<Vector>,
    /// Interactions of bonded pairs, with the lower id first.
    pub bonds: BTreeMap<(u32, u32), InteractionId>,
    pub walls: Vec<Wall>,
    pub facets: Vec<Facet>,
    pub motions: Motions,
    /// For each species and each surface, whether the two interact in the current stage.
    meetings: Vec<Vec<bool>>,
    /// Lengths of the box along periodic axes, 0 along other axes `[length]`.
    pub periods: Vector,
    /// The shortest period; infinite if no axis is periodic `[length]`.
    pub shortest_period: f64,
    /// Diagonal of a fully periodic box, otherwise infinite `[length]`.
    pub diagonal: f64,
    /// Largest distance at which an uncaptured pair interacts `[length]`.
    pub longest_range: f64,
    /// Largest range of the interactions, or the largest diameter of a moving particle if longer `[length]`.
    pub longest_length: f64,
    pub farthest_wall: f64,
    pub farthest_facet: f64,
    /// Whether any pair can be in a state other than 0.
    pub has_states: bool,
    /// Whether two species interact by a bond, so that all of their pairs have a nonzero state at any distance.
    pub holds_all_pairs: bool,
}

impl World {
    pub fn new(scene: &Scene, start_time: f64) -> Self {
        let species: Vec<Cow<'_, Species>> =
            scene.particles.iter().map(|particle| scene.own_species(particle)).collect();
        let bonds = scene.bonds.iter().map(|bond| {
            let [a, b] = bond.pair.map(|id| id.0);
            ((a.min(b), a.max(b)), bond.interaction)
        });
        let potentials = scene.table.iter().map(|(_, id)| &scene.interactions[id.0 as usize].potential);
        let periods = scene.space.periods().map(|period| if period.is_finite() { period } else { 0.0 });
        let facets = facets(scene, &periods);
        let mut world = Self {
            inverse_masses: species.iter().map(|species| species.mass.recip()).collect(),
            inverse_inertias: species.iter().map(|species| species.inverse_inertia(scene.space.dimensions())).collect(),
            accelerations: species.iter().map(|species| species.acceleration).collect(),
            moving: (0..).zip(&species).filter(|(_, species)| !species.is_static()).map(|(i, _)| i).collect(),
            bonds: bonds.collect(),
            gravity: None,
            walls: walls(scene),
            farthest_facet: facets.iter().map(|facet| facet.farthest).fold(0.0, f64::max),
            facets,
            motions: Motions::of(&scene.surfaces, start_time),
            meetings: Vec::new(),
            periods,
            shortest_period: scene.space.periods().min(),
            diagonal: if scene.space.is_fully_periodic() { scene.space.size.norm() } else { f64::INFINITY },
            longest_range: scene.longest_range_of_pairs(),
            longest_length: scene.longest_range(),
            farthest_wall: walls(scene).iter().map(|wall| wall.at.abs()).fold(0.0, f64::max),
            has_states: potentials.clone().any(|potential| *potential.accessible_states().end() > 0),
            holds_all_pairs: potentials.clone().any(Potential::is_bond),
            scene: scene.clone(),
        };
        world.enter_stage(scene.run.first_stage());
        world
    }

    /// Selects the surfaces of a stage. Returns whether they differ from the surfaces of the previous stage.
    pub fn enter_stage(&mut self, stage: &str) -> bool {
        let species = (0..).map(SpeciesId).zip(&self.scene.species);
        let surfaces = &self.scene.surfaces;
        let of = |id: SpeciesId| surfaces.iter().map(|it| it.is_in(stage) && it.meets(id)).collect();
        let meetings = species.map(|(id, _)| of(id)).collect();
        std::mem::replace(&mut self.meetings, meetings) != self.meetings
    }

    /// Sets the acceleration of the moving particles. Returns whether this changes any acceleration.
    pub fn turn_gravity(&mut self, gravity: &Vector) -> bool {
        let is_other = self.moving.iter().any(|&i| self.accelerations[i as usize] != *gravity);
        self.moving.iter().for_each(|&i| self.accelerations[i as usize] = *gravity);
        self.gravity = Some(*gravity);
        is_other
    }

    pub fn meets(&self, i: u32) -> &[bool] {
        &self.meetings[self.scene.particles[i as usize].species.0 as usize]
    }

    /// Contact law of a particle and a surface; `None` without interaction, or if the surface has a temperature.
    pub fn law_of_surface(&self, i: u32, surface: u32) -> Option<ContactLaw> {
        let surface = surface as usize;
        let is_met = self.meets(i).get(surface).copied().unwrap_or(false) && !self.is_static(i);
        match self.scene.surfaces.get(surface).filter(|_| is_met)?.law {
            SurfaceLaw::Reflecting(law) => Some(law),
            SurfaceLaw::Thermal { .. } | SurfaceLaw::Outlet => None,
        }
    }

    pub fn velocity_of_surface(&self, surface: u32) -> Option<SurfaceVelocity> {
        self.scene.surfaces.get(surface as usize)?.surface_velocity
    }

    /// Makes a particle static until it wakes up.
    pub fn fall_asleep(&mut self, i: u32) {
        let at = i as usize;
        (self.inverse_masses[at], self.inverse_inertias[at], self.accelerations[at]) = (0.0, 0.0, Vector::zeros());
        self.moving.retain(|&other| other != i);
    }

    pub fn wake(&mut self, i: u32) {
        let (at, species) = (i as usize, self.species_of(i));
        let acceleration = species.acceleration;
        let inverses = (species.inverse_mass(), species.inverse_inertia(self.scene.space.dimensions()));
        (self.inverse_masses[at], self.inverse_inertias[at]) = inverses;
        self.accelerations[at] = self.gravity.unwrap_or(acceleration);
        let place = self.moving.partition_point(|&other| other < i);
        self.moving.insert(place, i);
    }

    fn species_of(&self, i: u32) -> Cow<'_, Species> {
        self.scene.own_species(&self.scene.particles[i as usize])
    }

    pub fn is_asleep(&self, i: u32) -> bool {
        self.is_static(i) && !self.scene.species_of(ParticleId(i)).is_static()
    }

    pub fn asleep(&self) -> impl Iterator<Item = u32> {
        (0..).take(self.inverse_masses.len()).filter(|&i| self.is_asleep(i))
    }

    /// Whether two particles interact, and a distance is at most their range.
    pub fn touches(&self, i: u32, j: u32, distance: f64) -> bool {
        self.interaction(i, j).is_some_and(|interaction| distance <= interaction.potential.range())
    }

    pub fn is_static(&self, i: u32) -> bool {
        self.inverse_masses[i as usize] == 0.0
    }

    /// Whether a loop over all moving `i` and all `j` must include this pair, to visit each pair once.
    pub fn is_first(&self, i: u32, j: u32) -> bool {
        i < j || (i > j && self.is_static(j))
    }

    pub fn radius(&self, i: u32) -> f64 {
        0.5 * self.scene.diameter(&self.scene.particles[i as usize])
    }

    /// The interaction of two particles, with distances scaled to their diameters.
    pub fn interaction(&self, i: u32, j: u32) -> Option<Cow<'_, Interaction>> {
        let bond = if self.bonds.is_empty() { None } else { self.bonds.get(&(i.min(j), i.max(j))).copied() };
        let species = |i: u32| self.scene.particles[i as usize].species;
        let id = bond.or_else(|| self.scene.interaction_of(species(i), species(j)))?;
        let interaction = self.scene.interactions.get(id.0 as usize)?;
        if !self.scene.has_individual_diameters() {
            return Some(Cow::Borrowed(interaction));
        }
        let potential = self.scene.potential_between(id, [i, j].map(|k| (species(k), self.radius(k)))).into_owned();
        Some(Cow::Owned(Interaction { potential, ..interaction.clone() }))
    }

    pub fn is_bonded(&self, i: u32, j: u32) -> bool {
        self.bonds.contains_key(&(i.min(j), i.max(j)))
    }

    pub fn wall(&self, contact: &Contact) -> Option<Wall> {
        let Contact::Wall { axis, is_upper, .. } = *contact else { return None };
        self.walls.iter().find(|wall| wall.axis == axis && wall.is_upper == is_upper).copied()
    }

    pub fn has_state(&self, i: u32, j: u32, state: usize) -> bool {
        let count = self.scene.particles.len();
        let exist = i != j && (i as usize) < count && (j as usize) < count;
        exist
            && self
                .interaction(i, j)
                .is_some_and(|interaction| interaction.potential.accessible_states().contains(&state))
    }

    pub fn nearest(&self, states: &States, i: u32, j: u32) -> Vector {
        self.shortest(states.positions[i as usize] - states.positions[j as usize])
    }

    /// Returns the nearest image of a separation vector of any length.
    pub fn shortest(&self, mut apart: Vector) -> Vector {
        for k in 0..3 {
            let period = self.periods[k];
            if apart[k].abs() > 0.5 * period && period > 0.0 {
                // Only particles far outside the box need a division.
                let is_next = apart[k].abs() <= 1.5 * period;
                apart[k] -= if is_next { period.copysign(apart[k]) } else { period * (apart[k] / period).round() };
            }
        }
        apart
    }

    /// Returns the images of a separation vector that are within `reach` along each axis; `None` if there are more than
    /// `most`. Images are counted before memory is allocated, because a very long flight passes too many images.
    pub fn images(&self, nearest: &Vector, reach: &Vector, most: f64) -> Option<Vec<Vector>> {
        let periodic = || (0..3).filter(|&k| self.periods[k] > 0.0);
        let ends = |k: usize| {
            let period = self.periods[k];
            [((-reach[k] - nearest[k]) / period).ceil(), ((reach[k] - nearest[k]) / period).floor()]
        };
        let count: f64 = periodic().map(ends).map(|[first, last]| (last - first + 1.0).max(0.0)).product();
        if count.is_nan() || count > most {
            return None;
        }
        let mut images = vec![*nearest];
        for k in periodic() {
            let [first, last] = ends(k);
            let numbers: Vec<f64> =
                std::iter::successors(Some(first), |n| Some(n + 1.0)).take_while(|n| *n <= last).collect();
            let of = |image: Vector| {
                numbers.iter().map(move |n| {
                    let mut image = image;
                    image[k] += n * self.periods[k];
                    image
                })
            };
            images = images.into_iter().flat_map(of).collect();
        }
        Some(images)
    }

    /// Moves a position back by whole periods, if it is outside the range in which the engine keeps particles.
    pub fn brought_back(&self, mut position: Vector) -> Vector {
        if !self.is_in_box(&position) {
            for k in (0..3).filter(|&k| self.periods[k] > 0.0) {
                let periods = ((position[k] - self.scene.space.lower[k]) / self.periods[k]).floor();
                position[k] -= periods * self.periods[k];
            }
        }
        position
    }

    /// Whether a position is in the range in which the engine keeps particles, at most half a period outside the box.
    pub fn is_in_box(&self, position: &Vector) -> bool {
        (0..3).filter(|&k| self.periods[k] > 0.0).all(|k| {
            let fraction = (position[k] - self.scene.space.lower[k]) / self.periods[k];
            (-0.5..1.5).contains(&fraction)
        })
    }
}

fn walls(scene: &Scene) -> Vec<Wall> {
    let mut walls = Vec::new();
    for axis in 0..3_u8 {
        let k = usize::from(axis);
        let Boundary::Bounded { lower, upper } = scene.space.boundary[k] else { continue };
        let ends = [(false, lower, scene.space.lower[k]), (true, upper, scene.space.upper()[k])];
        for (is_upper, face, at) in ends {
            if let Face::Wall(law) = face {
                walls.push(Wall { axis, is_upper, at, law });
            }
        }
    }
    walls
}
