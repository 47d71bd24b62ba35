//! Snapshots: positions, velocities and energies at one time.

use super::hardware::prefetch::prefetch;
use super::pairs::rules::SpeciesRules;
use super::pairs::states::PairState;
use super::parts::Engine;
use super::state::State;
use super::{Chosen, Simulation};
use crate::Vector;
use crate::base::sum::Sum;
use crate::model::{ParticleId, SpeciesId};
use std::convert::Infallible;

/// Number of particles to prefetch in advance. About ten particles are processed while one is loaded from memory.
const AHEAD: usize = 16;

/// All particles at one time, in the order of their ids.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Snapshot {
    /// Simulated time `[time]`.
    pub time: f64,
    /// Ids of the particles in ascending order. The other arrays have the same order. If particles have left, ids
    /// differ from indices: use [`Self::index`].
    pub ids: Vec<ParticleId>,
    /// Species of the particles.
    pub species: Vec<SpeciesId>,
    /// Positions `[length]`, `N x 3`. Along periodic axes, they are inside the box within round-off.
    pub positions: Vec<Vector>,
    /// Velocities `[length / time]`, `N x 3`.
    pub velocities: Vec<Vector>,
    /// Spins `[1 / time]`, `N x 3`; empty if the scene has no spins.
    #[doc(alias = "angular velocity")]
    pub spins: Vec<Vector>,
    /// Current diameters `[length]`, `N`; empty unless particles have individual diameters.
    pub diameters: Vec<f64>,
    /// Number of periods that each particle has travelled along each axis since the start. Unwrapped positions are
    /// `position + image_x (L_x, 0, 0) + image_y (displacement, L_y, 0) + image_z (0, 0, L_z)` in a box with edges `L`.
    pub images: Vec<[i32; 3]>,
    /// Displacement along x of the next periodic image above a sheared box `[length]`. Whole periods are subtracted, so
    /// the value is in the range `(-L_x / 2, L_x / 2]`. It is 0 without shear.
    pub displacement: f64,
    /// Edge lengths of the box `[length]`; 0 along flat axes.
    pub size: Vector,
    /// Factor by which the diameters have grown since the start of the scene.
    pub scale: f64,
    /// Whether each surface of the scene is present now. Empty if all surfaces are always present.
    pub surfaces: Vec<bool>,
}

impl Snapshot {
    /// Returns the index of a particle in the arrays, or `None` if the particle is not present.
    #[must_use]
    pub fn index(&self, particle: ParticleId) -> Option<usize> {
        self.ids.binary_search(&particle).ok()
    }
}

/// State of one particle at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ParticleNow {
    /// Id of the particle.
    pub id: ParticleId,
    /// Species of the particle.
    pub species: SpeciesId,
    /// Position `[length]`, inside the box along periodic axes.
    pub position: Vector,
    /// Velocity `[length / time]`.
    pub velocity: Vector,
    /// Spin `[1 / time]`; zero if the scene has no spins.
    pub spin: Vector,
    /// Number of periods travelled along each axis, as in [`Snapshot::images`].
    pub image: [i32; 3],
    /// Current individual diameter of the particle `[length]`, if its species has individual diameters.
    pub diameter: Option<f64>,
}

/// Energies of all particles at one time `[energy]`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Energy {
    /// Kinetic energy of the motion of the centres, `sum m/2 |v|^2`.
    pub kinetic: f64,
    /// Kinetic energy of the rotation about the centres, `sum I/2 |w|^2`; 0 if the scene has no spins.
    pub rotational: f64,
    /// Kinetic energy relative to the streaming velocity `u` of a sheared box, `sum m/2 |v - u|^2`.
    pub thermal: f64,
    /// Energy of all pairs, plus `- m a . r` for accelerated particles at the unwrapped position `r`.
    pub potential: f64,
    /// The part of `potential` from pairs.
    pub pair: f64,
    /// For each axis between two walls, `sum m v^2 / V` with velocities `v` along this axis `[energy / length^D]`. Zero
    /// for other axes. `V` is the volume that is accessible to the centres of a species.
    pub confined: Vector,
    /// Total momentum `[mass length / time]`.
    pub momentum: Vector,
    /// Momentum relative to the streaming velocity `u` of a sheared box, `sum m (v - u)`.
    pub peculiar_momentum: Vector,
}

impl Energy {
    /// Total energy: kinetic, rotational and potential.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.kinetic + self.rotational + self.potential
    }
}

impl Simulation {
    /// Mass of a particle `[mass]`; infinite if its species is static.
    #[must_use]
    pub(crate) fn mass_of(&self, particle: &ParticleNow) -> f64 {
        if particle.diameter.is_none() {
            return self.scene.species[particle.species.0 as usize].mass;
        }
        // Diameters may be growing, but masses are constant.
        with_engine!(&self.engine, engine => engine.awake_rules(engine.number(particle.id)).inverse_mass.recip())
    }

    /// Returns the current positions and velocities of all particles.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let snapshot = with_engine!(&self.engine, engine => engine.snapshot());
        Snapshot { scale: self.scale(), ..snapshot }
    }

    /// Whether the particles have spins: a contact of the scene is rough, or a particle had a spin at the start.
    #[must_use]
    pub fn has_spins(&self) -> bool {
        with_engine!(&self.engine, engine => engine.pairs.rules.has_spins)
    }

    /// Calls `visit` with the current state of each particle, in the order of ids. This allocates no memory.
    ///
    /// # Errors
    /// Returns the first error of `visit`, which ends the iteration.
    pub fn for_each_now<E>(&self, visit: impl FnMut(ParticleNow) -> Result<(), E>) -> Result<(), E> {
        with_engine!(&self.engine, engine => engine.for_each_now(visit))
    }

    /// Displacement along x of the next periodic image above `[length]`, as in [`Snapshot::displacement`].
    #[must_use]
    pub fn displacement(&self) -> f64 {
        with_engine!(&self.engine, engine => engine.displacement().0)
    }

    /// The current energies.
    #[must_use]
    pub fn energy(&self) -> Energy {
        with_engine!(&self.engine, engine => engine.energy())
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    pub(super) fn snapshot(&self) -> Snapshot {
        let count = self.state.numbers.len();
        let mut snapshot = Snapshot {
            time: self.time(),
            ids: Vec::with_capacity(count),
            species: Vec::with_capacity(count),
            positions: Vec::with_capacity(count),
            velocities: Vec::with_capacity(count),
            spins: Vec::with_capacity(self.state.spins.len()),
            diameters: Vec::new(),
            images: Vec::with_capacity(count),
            displacement: self.displacement().0,
            size: self.state.space.size,
            scale: self.scale(),
            surfaces: self.sources.surfaces.presence(),
        };
        let Ok(()) = self.for_each_now(|particle| {
            snapshot.ids.push(particle.id);
            snapshot.species.push(particle.species);
            snapshot.positions.push(particle.position);
            snapshot.velocities.push(particle.velocity);
            snapshot.images.push(particle.image);
            if !self.state.spins.is_empty() {
                snapshot.spins.push(particle.spin);
            }
            if self.has_sizes() {
                snapshot.diameters.push(2.0 * self.radius(self.number(particle.id)) * self.scale());
            }
            Ok::<(), Infallible>(())
        });
        snapshot
    }

    pub(super) fn for_each_now<E>(&self, mut visit: impl FnMut(ParticleNow) -> Result<(), E>) -> Result<(), E> {
        let (_, periods) = self.displacement();
        for particle in self.by_id() {
            let (position, velocity) = self.state_at(particle, self.clock.now);
            let image = self.image_numbers(particle, periods);
            let species = self.species_of(particle);
            let spin = self.spin(particle);
            let diameter = self.own_diameter(particle);
            visit(ParticleNow { id: self.id(particle), species, position, velocity, spin, image, diameter })?;
        }
        Ok(())
    }

    pub(super) fn by_id(&self) -> impl Iterator<Item = u32> + '_ {
        let State { numbers, bodies, .. } = &self.state;
        numbers.iter().enumerate().map(move |(id, &particle)| {
            if let Some(&coming) = numbers.get(id + AHEAD) {
                prefetch(bodies, coming as usize);
            }
            particle
        })
    }

    pub(super) fn energy(&self) -> Energy {
        let mut kinetic = Sum::default();
        let mut rotational = Sum::default();
        let mut thermal = Sum::default();
        let mut external = Sum::default();
        let mut pair = Sum::default();
        let mut momentum = [Sum::default(); 3];
        let mut streaming_momentum = [Sum::default(); 3];
        let has_static = self.pairs.rules.species.iter().any(SpeciesRules::is_static);
        for particle in self.by_id().filter(|&particle| !has_static || !self.is_of_static_species(particle)) {
            let species = self.awake_rules(particle);
            let mass = species.inverse_mass.recip();
            let (position, velocity) = self.state_at(particle, self.clock.now);
            kinetic.add(0.5 * mass * velocity.norm_squared());
            if let Some(spin) = self.state.spins.get(particle as usize) {
                rotational.add(rotational_energy(spin, species.inverse_inertia));
            }
            if self.images.are_sliding() {
                let streaming = self.streaming_velocity(&position);
                thermal.add(0.5 * mass * (velocity - streaming).norm_squared());
                streaming_momentum.iter_mut().zip(&streaming).for_each(|(sum, component)| sum.add(mass * component));
            }
            for (sum, component) in momentum.iter_mut().zip(velocity.iter()) {
                sum.add(mass * component);
            }
            if FALLING {
                self.external_energies(particle, &position).for_each(|energy| external.add(energy));
            }
            if TABLE {
                self.add_energies_of_pairs(particle, has_static, &mut pair);
            }
        }
        let pair = pair.total();
        Energy {
            kinetic: kinetic.total(),
            rotational: rotational.total(),
            thermal: if self.images.are_sliding() { thermal.total() } else { kinetic.total() },
            potential: pair + external.total(),
            pair,
            confined: self.confined_kinetic(),
            momentum: Vector::from_fn(|k, _| momentum[k].total()),
            peculiar_momentum: Vector::from_fn(|k, _| momentum[k].total() - streaming_momentum[k].total()),
        }
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Returns the energy `- m a_k r_k` of a particle at a position for each axis along which it accelerates.
    pub(super) fn external_energies(&self, particle: u32, position: &Vector) -> impl Iterator<Item = f64> {
        let species = self.awake_rules(particle);
        let mass = species.inverse_mass.recip();
        (0..3).filter(move |&axis| species.acceleration[axis] != 0.0).map(move |axis| {
            let image = self.state.images.of(particle)[axis];
            // Without periods, the image number is 0, and its product with the infinite period would be NaN.
            let unwrapped = position[axis] + if image == 0 { 0.0 } else { f64::from(image) * self.state.periods[axis] };
            -mass * species.acceleration[axis] * unwrapped
        })
    }

    /// Adds the energies of the pairs of a mobile particle. `has_static` tells whether any partner may be static.
    #[inline]
    fn add_energies_of_pairs(&self, particle: u32, has_static: bool, total: &mut Sum) {
        let mut sum = *total;
        for captured in self.pairs.states.of(particle) {
            // Two mobile particles both store the state of the pair, so each contributes half of the energy.
            let share = if has_static && self.is_static(captured.partner) { 1.0 } else { 0.5 };
            sum.add(share * self.energy_of_pair(captured));
        }
        *total = sum;
    }

    pub(super) fn energy_of_pair(&self, captured: &PairState) -> f64 {
        self.pairs.rules.steps[usize::from(captured.interaction)].energy(captured.state)
    }
}

/// Returns `I/2 |w|^2`; 0 for particles that cannot turn.
pub(super) fn rotational_energy(spin: &Vector, inverse_inertia: f64) -> f64 {
    if inverse_inertia > 0.0 { 0.5 * spin.norm_squared() / inverse_inertia } else { 0.0 }
}
