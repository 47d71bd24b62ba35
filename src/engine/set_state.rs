//! Methods that set the positions and velocities of a simulation.

use super::parts::Engine;
use super::{Chosen, Overlap, Simulation};
use crate::Vector;
use crate::base::numbers::trunc_to_i32;
use crate::engine::pairs::states::CapturedPairs;
use crate::model::limits::{LARGEST, MOST_PARTICLES};
use crate::model::space::Boundary;
use crate::model::{ParticleId, Scene, SpeciesId};
use thiserror::Error;

/// How the states of captured pairs change when positions are set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum PairStates {
    /// Pairs keep their states. Positions that contradict a state are rejected as overlaps.
    Keep,
    /// Pairs get the states that follow from their distances, as at the start of a scene.
    FromDistances,
}

/// Reasons to reject positions or velocities. After a rejection, the simulation is unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum SetStateError {
    /// The number of vectors differs from the number of particles.
    #[error("{found} vectors, expected one for each of {expected} particles")]
    Count {
        /// The number of particles.
        expected: usize,
        /// The number of vectors in the call.
        found: usize,
    },
    /// A component is not a number from -1e50 to 1e50.
    #[error("a component of particle {} is not a number from -1e50 to 1e50", particle.0)]
    NotFinite {
        /// The particle.
        particle: ParticleId,
    },
    /// A static particle would move, or a particle would move along a flat axis.
    #[error("particle {} cannot move along axis {axis}", particle.0)]
    Fixed {
        /// The particle.
        particle: ParticleId,
        /// The axis of the wrong component: 0, 1 or 2.
        axis: usize,
    },
    /// A position is beyond the sliding sides of a sheared box, where the velocity of the particle would be different.
    #[error("particle {} is outside of the sheared box along y", particle.0)]
    OutsideOfShearedBox {
        /// The particle.
        particle: ParticleId,
    },
    /// Two particles, or a particle and a wall, overlap or are in another invalid state.
    #[error(
        "particle {} overlaps with {} by {:e} of their smallest allowed distance",
        .0.particle.0,
        .0.partner.map_or("a wall".to_owned(), |partner| format!("particle {}", partner.0)),
        .0.depth
    )]
    Overlap(Overlap),
    /// Diameters are growing. Meanwhile, positions cannot be set, and particles cannot enter or leave.
    #[error("the diameters are growing, expected a change of the particles when they have grown")]
    Growing,
    /// A new particle has an unknown species. In a scene of more than 256 species, this includes species that had no
    /// particles at the start.
    #[error("particle {} has species number {}, expected a species of the scene", particle.0, species.0)]
    Species {
        /// The particle.
        particle: ParticleId,
        /// The species of this particle.
        species: SpeciesId,
    },
    /// A new particle needs an individual diameter within the range of its species at the start and in inlets, unless the
    /// species has one diameter for all particles.
    #[error(
        "particle {} has a wrong diameter, expected {}",
        particle.0,
        range.map_or_else(|| "none".to_owned(), |[smallest, largest]| format!("one from {smallest} to {largest}"))
    )]
    Diameter {
        /// The particle.
        particle: ParticleId,
        /// The smallest and the largest diameter of the species `[length]`; `None` if its particles are equal.
        range: Option<[f64; 2]>,
    },
    /// A new particle has a spin, but no contact of the scene is rough.
    #[error("particle {} has a spin, expected none in a scene without rough contacts", particle.0)]
    NoSpins {
        /// The particle.
        particle: ParticleId,
    },
    /// A particle to remove does not exist, or its id is given twice.
    #[error("no particle {} to remove, expected each id of a present particle once", particle.0)]
    NoParticle {
        /// The particle.
        particle: ParticleId,
    },
    /// The ids of new particles would be too large.
    #[error("too many particles, expected at most {MOST_PARTICLES} from the start of the simulation on")]
    TooMany,
}

impl Simulation {
    /// Sets the velocities of all particles, in the order of their ids.
    ///
    /// The gain in kinetic energy is added to [`EventCounts::supplied`](super::event::EventCounts::supplied).
    ///
    /// # Errors
    /// [`SetStateError::Count`] and [`SetStateError::NotFinite`]. [`SetStateError::Fixed`] if a static particle would
    /// move, or if a particle would move along a flat axis.
    #[doc(alias = "velocity create")]
    pub fn set_velocities(&mut self, velocities: &[Vector]) -> Result<(), SetStateError> {
        self.check_vectors(velocities, |_| Vector::zeros(), &Vector::zeros())?;
        with_engine!(&mut self.engine, engine => engine.set_velocities(velocities));
        Ok(())
    }

    /// Sets the positions of all particles, in the order of their ids.
    ///
    /// Positions beyond the sides of periodic axes are wrapped, and the image numbers count the wraps. The gain in
    /// potential energy is added to [`EventCounts::supplied`](super::event::EventCounts::supplied).
    ///
    /// # Errors
    /// [`SetStateError::Count`] and [`SetStateError::NotFinite`]. [`SetStateError::Fixed`] if a static particle would
    /// move, or if a particle would move along a flat axis. [`SetStateError::Overlap`] with the deepest overlap beyond
    /// round-off, unless the scene allows an invalid start. In a sheared box, [`SetStateError::OutsideOfShearedBox`].
    /// While diameters grow, [`SetStateError::Growing`].
    pub fn set_positions(&mut self, positions: &[Vector], states: PairStates) -> Result<(), SetStateError> {
        if self.is_growing() {
            return Err(SetStateError::Growing);
        }
        let scene = &self.scene;
        let fixed = |particle| with_engine!(&self.engine, engine => engine.state.bodies[engine.number(particle) as usize].position);
        self.check_vectors(positions, fixed, &scene.space.lower)?;
        if scene.shear_rate.is_some() {
            let (lower, upper) = (scene.space.lower.y, scene.space.upper().y);
            let is_outside = |(position, _): &(&Vector, ParticleId)| !(lower..upper).contains(&position.y);
            if let Some((_, particle)) = positions.iter().zip(self.ids()).find(is_outside) {
                return Err(SetStateError::OutsideOfShearedBox { particle });
            }
        }
        let before = self.engine.clone();
        let scene = &self.scene;
        with_engine!(&mut self.engine, engine => engine.set_positions(scene, positions, states));
        let deepest = self.real_overlaps().into_iter().max_by(|a, b| a.depth.total_cmp(&b.depth));
        match deepest.filter(|_| !self.scene.allow_invalid_start) {
            None => Ok(()),
            Some(overlap) => {
                self.engine = before;
                Err(SetStateError::Overlap(overlap))
            }
        }
    }

    fn ids(&self) -> Vec<ParticleId> {
        with_engine!(&self.engine, engine => engine.by_id().map(|particle| engine.id(particle)).collect())
    }

    /// Checks vectors in the order of ids. A static particle must have the vector `fixed`. Components along flat axes
    /// must equal the components of `flat`.
    fn check_vectors(
        &self,
        vectors: &[Vector],
        fixed: impl Fn(ParticleId) -> Vector,
        flat: &Vector,
    ) -> Result<(), SetStateError> {
        let expected = self.population().iter().sum();
        if vectors.len() != expected {
            return Err(SetStateError::Count { expected, found: vectors.len() });
        }
        for (vector, particle) in vectors.iter().zip(self.ids()) {
            if !vector.iter().all(|component| component.abs() <= LARGEST) {
                return Err(SetStateError::NotFinite { particle });
            }
            let is_static = with_engine!(&self.engine, engine => engine.is_of_static_species(engine.number(particle)));
            let is_flat = |axis: usize| self.scene.space.boundary[axis] == Boundary::Flat;
            let is_wrong = |axis: &usize| {
                (is_flat(*axis) && vector[*axis] != flat[*axis])
                    || (is_static && vector[*axis] != fixed(particle)[*axis])
            };
            if let Some(axis) = (0..3).find(is_wrong) {
                return Err(SetStateError::Fixed { particle, axis });
            }
        }
        Ok(())
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    fn set_velocities(&mut self, velocities: &[Vector]) {
        self.join();
        self.wake_all();
        for (particle, velocity) in self.state.numbers.clone().into_iter().zip(velocities) {
            if !self.is_static(particle) {
                self.stream(particle, self.clock.now);
                self.give_velocity(particle, *velocity);
            }
        }
        self.move_again();
    }

    pub(super) fn set_positions(&mut self, scene: &Scene, positions: &[Vector], states: PairStates) {
        self.join();
        self.wake_all();
        let before = self.energy();
        let is_other_box = self.state.space != scene.space;
        if is_other_box {
            (self.state.space, self.state.periods) = (scene.space.clone(), scene.space.periods());
        }
        for (particle, position) in self.state.numbers.clone().into_iter().zip(positions) {
            if !self.is_static(particle) {
                self.stream(particle, self.clock.now);
                self.state.bodies[particle as usize].position = *position;
                self.bring_in(particle);
            }
        }
        let search = if is_other_box { self.best_search() } else { self.neighbours.search() };
        self.reorder();
        self.sort_in(search);
        if states == PairStates::FromDistances {
            self.pairs.states = CapturedPairs::new(if TABLE { self.state.bodies.len() } else { 0 });
            if TABLE {
                self.set_pair_states(scene);
            }
        }
        self.fill_lists();
        self.enlarge();
        self.move_again();
        let after = self.energy();
        self.note_energies(after.pair - before.pair, 0.0, after.potential - before.potential);
    }

    pub(super) fn bring_in(&mut self, particle: u32) {
        self.keep_between_sliding_sides(particle);
        let (position, images) = self.wrapped(self.state.bodies[particle as usize].position);
        self.state.bodies[particle as usize].position = position;
        for axis in (0..3).filter(|&axis| images[axis] != 0) {
            self.state.images.add(particle, axis, images[axis]);
        }
    }

    /// Wraps a position into the box. Returns how many periods were subtracted along each axis.
    pub(super) fn wrapped(&self, mut position: Vector) -> (Vector, [i32; 3]) {
        let mut images = [0; 3];
        for axis in (0..3).filter(|&axis| self.state.periods[axis].is_finite()) {
            let (lower, period) = (self.state.space.lower[axis], self.state.periods[axis]);
            let periods = ((position[axis] - lower) / period).floor();
            position[axis] -= periods * period;
            images[axis] = trunc_to_i32(periods);
            // Because of round-off, the position may be just outside the box.
            let sign = i32::from(position[axis] >= lower + period) - i32::from(position[axis] < lower);
            position[axis] -= f64::from(sign) * period;
            images[axis] = images[axis].saturating_add(sign);
        }
        (position, images)
    }

    /// Predicts all events anew, and restarts the count of events without progress in time.
    fn move_again(&mut self) {
        self.clock.standstill.lost_speed = None;
        (self.clock.standstill.since, self.clock.standstill.events) = (self.clock.now, 0);
        self.start_anew();
    }
}

#[cfg(test)]
mod tests;
