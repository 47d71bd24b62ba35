//! The system that an instrument measures: its constant description, and its state at one time.

use crate::Vector;
use crate::analysis::observables::ApplicableObservables;
use crate::base::numbers::id;
use crate::base::text::identifiers;
use crate::engine::surfaces::FIRST_SURFACE;
use crate::engine::{CellList, Simulation, Snapshot};
use crate::model::scene::mass_by_volume;
use crate::model::space::{AXES, Boundary, Space};
use crate::model::{
    Bond, ContactLaw, InteractionId, Particle, ParticleId, Scene, SceneSurface, Species, SpeciesId, SpeciesPairs,
    SurfaceLaw, SurfaceShape, Units,
};
use std::convert::Infallible;
use std::f64::consts::PI;

/// Description of the simulated system. It is constant during a measurement, but swap moves change `species` and
/// `masses`.
///
/// Lists over particles are in the order of the ids. If particles enter or leave, the lists contain the particles at
/// the start of the measurement. The particles of a [`Sample`] then have other indices.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct SystemDescription {
    /// Names of the units of length, mass and time.
    pub units: Units,
    /// The box.
    pub space: Space,
    /// Names of the species.
    pub species_names: Vec<String>,
    /// Diameters of the species `[length]`.
    pub diameters: Vec<f64>,
    /// Diameter of each particle `[length]`; empty unless particles have individual diameters. Swap moves change it.
    pub own_diameters: Vec<f64>,
    /// Species of each particle, as an index into the names. Swap moves change it.
    pub species: Vec<u32>,
    /// Masses `[mass]`; infinite for static particles.
    pub masses: Vec<f64>,
    /// For each species, the volume of the box divided by the volume that centres can reach.
    pub crowding: Vec<f64>,
    /// Ids of the moving particles, ascending.
    pub moving: Vec<u32>,
    /// Mass of each species `[mass]`; infinite for static species.
    pub species_masses: Vec<f64>,
    /// For each species, whether the mass of a particle is proportional to its volume.
    pub(crate) has_masses_by_volume: Vec<bool>,
    /// Whether particles enter or leave.
    pub has_flow: bool,
    /// For each pair of species with hard cores, the contact distance of the cores `[length]`.
    pub cores: SpeciesPairs<f64>,
    /// For each pair of species with hard cores, the smallest distance outside the core at which their potential, or
    /// the potential of a bond between them, has a step `[length]`.
    pub(crate) steps_outside_cores: SpeciesPairs<f64>,
    /// The walls of the box and the other surfaces of the scene.
    pub surfaces: Vec<DescribedSurface>,
    /// The two ends of each bond.
    pub bonds: Vec<[u32; 2]>,
    /// The shortest and the longest distance that any bond allows `[length]`; zeros without bonds.
    pub bond_lengths: [f64; 2],
    /// Whether the total momentum is conserved.
    pub conserves_momentum: bool,
    /// Axes along which the momentum is conserved; in a sheared box, relative to the streaming velocity.
    pub conserved_axes: [bool; 3],
    /// Acceleration of each species between events, usually gravity `[length / time^2]`.
    pub accelerations: Vec<Vector>,
    /// Whether particles accelerate between events.
    pub is_accelerated: bool,
    /// Whether the fluid is homogeneous and unconfined: periodic, without gravity, walls or static particles.
    pub is_homogeneous: bool,
    /// Whether contacts between particles and with walls of the box are smooth and dissipate no energy.
    pub is_elastic: bool,
    /// Whether some pairs can have a potential energy.
    pub has_wells: bool,
    /// Shear rate of the box `[1 / time]`; 0 without shear.
    pub shear_rate: f64,
    /// Time between two scalings of all velocities by a thermostat `[time]`, if any.
    pub scaling_interval: Option<f64>,
    /// Whether swap moves exchange the species of particles.
    pub has_swaps: bool,
    /// Contact time of the TC model `[time]`, if the scene has one.
    pub contact_time: Option<f64>,
    /// Seed of the scene, for measurements on a random choice of particles.
    pub seed: u64,
}

/// A wall or another surface that is no outlet.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct DescribedSurface {
    /// Number of the surface in events.
    pub number: u32,
    /// Name of the surface. A wall of the box is named after its axis and side, such as `wall x lower`.
    pub name: String,
    /// Area of the surface `[length^2]`. `None` for walls of the box, for infinite surfaces, and in fewer than three
    /// dimensions.
    pub area: Option<f64>,
}

/// Properties of a particle.
struct Described {
    species: u32,
    mass: f64,
    diameter: f64,
}

impl Described {
    fn of(scene: &Scene, particle: &Particle) -> Self {
        Self { species: particle.species.0, mass: scene.mass(particle), diameter: scene.diameter(particle) }
    }
}

fn described_now(simulation: &Simulation) -> Vec<Described> {
    let (scene, mut all) = (simulation.scene(), Vec::new());
    let Ok(()) = simulation.for_each_now(|now| {
        let diameter = now.diameter.unwrap_or(scene.species[now.species.0 as usize].diameter);
        all.push(Described { species: now.species.0, mass: simulation.mass_of(&now), diameter });
        Ok::<(), Infallible>(())
    });
    all
}

/// Diameters of the particles; empty unless particles have individual diameters.
fn own_diameters(scene: &Scene, particles: &[Described]) -> Vec<f64> {
    if !scene.has_individual_diameters() {
        return Vec::new();
    }
    particles.iter().map(|particle| particle.diameter).collect()
}

fn described(scene: &Scene) -> Vec<DescribedSurface> {
    let sides = [0, 1, 2].into_iter().flat_map(|axis| [(axis, 0), (axis, 1)]);
    let walls =
        sides.filter(|&(axis, side)| scene.space.walled_sides(axis)[side]).map(|(axis, side)| DescribedSurface {
            number: id(2 * axis + side),
            name: format!("wall {} {}", AXES[axis], ["lower", "upper"][side]),
            area: None,
        });
    let others = scene.surfaces.iter().zip(FIRST_SURFACE..).map(|(surface, number)| {
        let area = match &surface.shape {
            SurfaceShape::Mesh(mesh) => Some(mesh.area()),
            SurfaceShape::Sphere { radius, .. } => Some(4.0 * PI * radius * radius),
            SurfaceShape::Capsule { ends: [start, end], radius } => {
                Some(2.0 * PI * radius * ((end - start).norm() + 2.0 * radius)).filter(|area| *area > 0.0)
            }
            SurfaceShape::Plane { .. } | SurfaceShape::Cylinder { .. } => None,
        };
        let area = area.filter(|_| scene.space.dimensions() == 3);
        DescribedSurface { number, name: surface.name.clone(), area }
    });
    let is_outlet = |(_, surface): &(DescribedSurface, &SceneSurface)| surface.law == SurfaceLaw::Outlet;
    let others = others.zip(&scene.surfaces).filter(|it| !is_outlet(it)).map(|(described, _)| described);
    walls.chain(others).collect()
}

impl SystemDescription {
    /// Lower and upper end of the box along an axis `[length]`.
    pub(crate) fn extent(&self, axis: usize) -> (f64, f64) {
        (self.space.lower[axis], self.space.upper()[axis])
    }

    /// Describes the system of a scene.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let particle = |particle: &Particle| Described::of(scene, particle);
        let particles = scene.particles.iter().map(particle).collect();
        Self::with(scene, particles, &ApplicableObservables::of(scene))
    }

    /// Uses the current particles, because the simulation may have dropped the initial state.
    pub(crate) fn of_simulation(simulation: &Simulation, applicable: &ApplicableObservables) -> Self {
        Self::with(simulation.scene(), described_now(simulation), applicable)
    }

    /// Updates the species, masses and diameters of the particles after an exchange.
    pub(crate) fn take_species(&mut self, simulation: &Simulation) {
        let particles = described_now(simulation);
        self.species = particles.iter().map(|particle| particle.species).collect();
        self.masses = particles.iter().map(|particle| particle.mass).collect();
        self.own_diameters = own_diameters(simulation.scene(), &particles);
    }

    fn with(scene: &Scene, particles: Vec<Described>, applicable: &ApplicableObservables) -> Self {
        let species: Vec<u32> = particles.iter().map(|particle| particle.species).collect();
        let potential = |id: &InteractionId| &scene.interactions[id.0 as usize].potential;
        let lengths = |bond: &Bond| {
            let ends = bond.pair.map(|id| &particles[id.0 as usize]);
            let kinds = ends.map(|end| (SpeciesId(end.species), 0.5 * end.diameter));
            let potential = scene.potential_between(bond.interaction, kinds);
            [potential.core().unwrap_or(0.0), potential.range()]
        };
        let bond_lengths = scene.bonds.iter().map(lengths).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
        let masses: Vec<f64> = particles.iter().map(|particle| particle.mass).collect();
        let steps_outside_cores = steps_outside_cores(scene, &species);
        let is_soft = |boundary: &Boundary| boundary.contact_laws().iter().flatten().any(ContactLaw::dissipates);
        Self {
            units: scene.units.clone(),
            space: scene.space.clone(),
            species_names: scene.species.iter().map(|species| species.name.clone()).collect(),
            diameters: scene.species.iter().map(|species| species.diameter).collect(),
            own_diameters: own_diameters(scene, &particles),
            crowding: scene
                .species
                .iter()
                .map(|species| scene.space.volume() / scene.space.accessible_volume(species.diameter))
                .collect(),
            moving: (0..).zip(&masses).filter(|(_, mass)| mass.is_finite()).map(|(id, _)| id).collect(),
            species,
            masses,
            species_masses: scene.species.iter().map(|species| species.mass).collect(),
            has_masses_by_volume: scene.species.iter().map(Species::has_different_masses).collect(),
            has_flow: scene.has_flow(),
            cores: scene.table.map(|id| potential(&id).core()),
            steps_outside_cores,
            surfaces: described(scene),
            bond_lengths: bond_lengths.unwrap_or_default(),
            bonds: scene.bonds.iter().map(|bond| bond.pair.map(|id| id.0)).collect(),
            conserves_momentum: applicable.conserves_momentum,
            conserved_axes: applicable.conserved_axes,
            accelerations: scene.species.iter().map(|species| species.acceleration).collect(),
            is_accelerated: scene.species.iter().any(|species| species.acceleration != Vector::zeros()),
            is_homogeneous: applicable.is_homogeneous,
            is_elastic: scene.has_elastic_pairs() && !scene.is_rough() && !scene.space.boundary.iter().any(is_soft),
            has_wells: applicable.has_wells,
            shear_rate: scene.shear_rate.unwrap_or(0.0),
            scaling_interval: applicable.scaling_interval,
            has_swaps: applicable.has_swaps,
            contact_time: scene.contact_time,
            seed: scene.seed,
        }
    }

    /// Whether the moving particles fill a defined volume, which is necessary for a pressure.
    pub(crate) fn has_volume(&self) -> bool {
        self.space.is_closed() && self.moving.len() == self.masses.len()
    }

    /// Reason why Einstein-Helfand relations are not valid; `None` if they are.
    pub(crate) fn obstacle_to_transport(&self) -> Option<&'static str> {
        let obstacles = [
            (self.moving.len() < 2, "with fewer than two moving particles"),
            (self.is_accelerated, "with gravity"),
            (!self.is_homogeneous, "in a box with non-periodic axes, surfaces or static particles"),
            (!self.is_elastic, "with contacts that lose energy or are rough"),
            (!self.conserves_momentum, "with a heat bath that changes the momentum"),
        ];
        obstacles.into_iter().find(|(is_one, _)| *is_one).map(|(_, words)| words)
    }

    /// The species whose particles move, even if there are none at present.
    pub(super) fn moving_species(&self) -> impl Iterator<Item = u32> + '_ {
        (0..).zip(&self.species_masses).filter(|(_, mass)| mass.is_finite()).map(|(species, _)| species)
    }

    /// Returns endings of names and of titles for results of all particles, and then of the given species.
    pub(super) fn titles_of_all_and_of(&self, species: impl Iterator<Item = u32>) -> Vec<(String, String)> {
        let names: Vec<&str> = species.map(|species| self.species_names[species as usize].as_str()).collect();
        let keys = identifiers(names.iter().copied());
        let each = keys.iter().zip(&names).map(|(key, name)| (format!("_{key}"), format!(" of {name}")));
        [(String::new(), String::new())].into_iter().chain(each).collect()
    }

    pub(super) fn axes(&self) -> impl Iterator<Item = usize> + '_ {
        (0..3).filter(|&axis| self.space.boundary[axis] != Boundary::Flat)
    }

    /// The axes over which the pressure is averaged: the axes between two walls, or all axes without such walls.
    pub(super) fn pressed_axes(&self) -> Vec<usize> {
        let walled: Vec<usize> = self.axes().filter(|&axis| self.space.walls(axis) == 2).collect();
        if walled.is_empty() { self.axes().collect() } else { walled }
    }

    pub(super) fn crowding_of(&self, id: u32) -> f64 {
        if let Some(diameter) = self.own_diameters.get(id as usize) {
            return self.space.volume() / self.space.accessible_volume(*diameter);
        }
        self.crowding[self.species[id as usize] as usize]
    }

    /// Diameter of a particle `[length]`.
    pub(super) fn diameter_of(&self, id: u32) -> f64 {
        let own = self.own_diameters.get(id as usize).copied();
        own.unwrap_or_else(|| self.diameters[self.species[id as usize] as usize])
    }

    /// Diameter of the particle with an index in a sample `[length]`.
    pub(super) fn diameter_in(&self, sample: &Sample<'_>, index: usize) -> f64 {
        let own = sample.diameters.get(index).copied();
        own.unwrap_or_else(|| self.diameters[sample.species[index].0 as usize])
    }

    /// Mass of the particle with an index in a sample `[mass]`; infinite if it is static.
    pub(super) fn mass_in(&self, sample: &Sample<'_>, index: usize) -> f64 {
        let species = sample.species[index].0 as usize;
        let mass = self.species_masses[species];
        match sample.diameters.get(index) {
            Some(diameter) if self.has_masses_by_volume.get(species) == Some(&true) => {
                mass_by_volume(mass, [self.diameters[species], *diameter], self.space.dimensions())
            }
            _ => mass,
        }
    }

    pub(super) fn moving_mass(&self) -> f64 {
        self.moving.iter().map(|&id| self.masses[id as usize]).sum()
    }

    /// Streaming velocity at a position in a sheared box: `rate (y - y_middle)` along x `[length / time]`.
    pub(super) fn streaming_velocity(&self, position: &Vector) -> Vector {
        if self.shear_rate == 0.0 {
            return Vector::zeros();
        }
        let middle = self.space.lower.y + 0.5 * self.space.size.y;
        Vector::new(self.shear_rate * (position.y - middle), 0.0, 0.0)
    }

    /// Velocity of the centre of mass along axes with conserved momentum `[length / time]`. Zero along other axes, for
    /// a single particle, and in a sheared box.
    pub(super) fn drift(&self, velocities: &[Vector]) -> Vector {
        if self.shear_rate == 0.0 && self.moving.len() > 1 { self.common_velocity(velocities) } else { Vector::zeros() }
    }

    /// Velocity of the centre of mass along axes with conserved momentum `[length / time]`; zero along other axes.
    pub(super) fn common_velocity(&self, velocities: &[Vector]) -> Vector {
        if self.moving.is_empty() || self.conserved_axes == [false; 3] {
            return Vector::zeros();
        }
        let momentum: Vector = self.moving.iter().map(|&id| velocities[id as usize] * self.masses[id as usize]).sum();
        let common = momentum / self.moving_mass();
        Vector::from_fn(|k, _| if self.conserved_axes[k] { common[k] } else { 0.0 })
    }

    /// In a sheared box, velocity of the centre of mass relative to the streaming velocity, along axes with conserved
    /// momentum `[length / time]`. Zero in other boxes.
    pub(super) fn common_peculiar_velocity(&self, sample: &Sample<'_>) -> Vector {
        if self.shear_rate == 0.0 || self.moving.len() < 2 {
            return Vector::zeros();
        }
        let peculiar = |id: &u32| {
            let (position, velocity) = (&sample.positions[*id as usize], &sample.velocities[*id as usize]);
            (velocity - self.streaming_velocity(position)) * self.masses[*id as usize]
        };
        let common = self.moving.iter().map(peculiar).sum::<Vector>() / self.moving_mass();
        Vector::from_fn(|k, _| if self.conserved_axes[k] { common[k] } else { 0.0 })
    }

    /// Mean square of a velocity component, divided by `T / m`. With conserved momentum, the result is `1 - m / M`,
    /// where `M` is the total moving mass; otherwise it is 1.
    pub(super) fn free_part(&self, mass: f64, axis: usize) -> f64 {
        if self.conserved_axes[axis] { 1.0 - mass / self.moving_mass() } else { 1.0 }
    }

    #[cfg(test)]
    pub(crate) fn of_points(space: Space, count: u32) -> Self {
        Self {
            units: Units::default(),
            surfaces: Vec::new(),
            space,
            species_names: vec!["A".to_owned()],
            diameters: vec![1.0],
            own_diameters: Vec::new(),
            crowding: vec![1.0],
            species: vec![0; count as usize],
            masses: vec![1.0; count as usize],
            moving: (0..count).collect(),
            species_masses: vec![1.0],
            has_masses_by_volume: vec![false],
            has_flow: false,
            cores: SpeciesPairs::new(1),
            steps_outside_cores: SpeciesPairs::new(1),
            bonds: Vec::new(),
            bond_lengths: [0.0; 2],
            conserves_momentum: true,
            conserved_axes: [true; 3],
            accelerations: vec![Vector::zeros()],
            is_accelerated: false,
            is_homogeneous: true,
            is_elastic: true,
            has_wells: false,
            shear_rate: 0.0,
            scaling_interval: None,
            has_swaps: false,
            contact_time: None,
            seed: 1,
        }
    }
}

fn steps_outside_cores(scene: &Scene, species: &[u32]) -> SpeciesPairs<f64> {
    let potential = |id: &InteractionId| &scene.interactions[id.0 as usize].potential;
    let next = |core: f64, radii: &[f64]| radii.iter().copied().filter(|radius| *radius > core).reduce(f64::min);
    let mut steps = scene.table.map(|id| next(potential(&id).core()?, potential(&id).radii()));
    for bond in &scene.bonds {
        let [a, b] = bond.pair.map(|id| species[id.0 as usize] as usize);
        let core = scene.table.get(a, b).and_then(|id| potential(&id).core());
        if let Some(step) = core.and_then(|core| next(core, potential(&bond.interaction).radii())) {
            steps.set(a, b, steps.get(a, b).map_or(step, |other| other.min(step)));
        }
    }
    steps
}

/// State of all particles at one time, in the order of the ids.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sample<'a> {
    /// Simulated time `[time]`.
    pub time: f64,
    /// Ids of the particles, ascending. They differ from indices if particles have left.
    pub ids: &'a [ParticleId],
    /// Species of the particles.
    pub species: &'a [SpeciesId],
    /// Positions `[length]`, `N x 3`; inside the box along periodic axes, within round-off.
    pub positions: &'a [Vector],
    /// Velocities `[length / time]`, `N x 3`.
    pub velocities: &'a [Vector],
    /// Spins `[1 / time]`, `N x 3`; empty if the scene has no spins.
    pub spins: &'a [Vector],
    /// Diameters of the particles `[length]`; empty unless particles have individual diameters.
    pub diameters: &'a [f64],
    /// Periods travelled since the start, along each axis.
    pub images: &'a [[i32; 3]],
    /// Displacement along x of the periodic image above `[length]`, in `(-L_x / 2, L_x / 2]`; 0 without shear.
    pub displacement: f64,
}

impl<'a> Sample<'a> {
    /// State of all particles in a snapshot.
    #[must_use]
    pub fn of(snapshot: &'a Snapshot) -> Self {
        Self {
            time: snapshot.time,
            ids: &snapshot.ids,
            species: &snapshot.species,
            positions: &snapshot.positions,
            velocities: &snapshot.velocities,
            spins: &snapshot.spins,
            diameters: &snapshot.diameters,
            images: &snapshot.images,
            displacement: snapshot.displacement,
        }
    }

    /// Builds a cell list for pairs of the given particles closer than `range`, at most half of the shortest period.
    pub(crate) fn cell_list(&self, space: &Space, range: f64, ids: &[u32]) -> CellList {
        CellList::new(space, self.displacement, range, ids.iter().map(|&id| (id, self.positions[id as usize])))
    }

    /// Unwrapped position of a particle `[length]`: position + image * period. In a sheared box, x includes the
    /// displacement of each image along y.
    #[must_use]
    pub fn unwrapped(&self, id: usize, space: &Space) -> Vector {
        let (position, image) = (self.positions[id], self.images[id]);
        // The image number is 0 along an axis that is not periodic.
        let travelled = |k: usize| if image[k] == 0 { 0.0 } else { f64::from(image[k]) * space.size[k] };
        let slid = if self.displacement == 0.0 { 0.0 } else { f64::from(image[1]) * self.displacement };
        position + Vector::new(travelled(0) + slid, travelled(1), travelled(2))
    }
}
