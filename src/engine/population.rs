//! Particles that enter and leave a simulation.

use super::build::rounding_of_distances;
use super::columns::records::Record;
use super::contact::apply::{Change, With};
use super::event::CountedKind;
use super::neighbours::candidates::Candidates;
use super::observe::Observe;
use super::parts::Engine;
use super::sizes::Size;
use super::snapshot::rotational_energy;
use super::{Chosen, Overlap, SetStateError, Simulation};
use crate::Vector;
use crate::engine::surfaces::Surface;
use crate::model::limits::{LARGEST, MOST_PARTICLES};
use crate::model::space::Boundary;
use crate::model::{Particle, ParticleId, Scene, SpeciesId};
use std::ops::{ControlFlow, Range, RangeInclusive};

impl Simulation {
    /// Inserts particles at the current time, and returns their ids.
    ///
    /// New ids follow the largest id that was ever used. Ids are never reused, so an id is not the index of a particle
    /// in arrays, see [`Snapshot::ids`](super::Snapshot::ids). Positions beyond the sides of periodic axes are wrapped.
    /// The state of a new pair follows from its distance. The kinetic and potential energy of the new particles is
    /// added to [`EventCounts::supplied`](super::event::EventCounts::supplied).
    ///
    /// The cost does not depend on the number of particles in the system, unless pairs can have states, the box is
    /// sheared, a particle is the first of its species, or the system runs on several threads.
    ///
    /// # Errors
    /// [`SetStateError::Species`] for a species that the scene does not have, or that has no row in its tables.
    /// [`SetStateError::NotFinite`]. [`SetStateError::Fixed`] for a static particle that moves, for components along
    /// flat axes, and for spins about other axes in two dimensions. [`SetStateError::NoSpins`] for a spin in a scene of
    /// smooth contacts. [`SetStateError::OutsideOfShearedBox`]. [`SetStateError::Overlap`] with a particle, a wall or
    /// a surface. [`SetStateError::TooMany`]. While diameters grow, [`SetStateError::Growing`]. The errors name the
    /// particle by the id that it would get. After an error, the simulation is unchanged.
    ///
    /// ```
    /// use carom::Vector;
    /// use carom::engine::{Simulation, Until};
    /// use carom::model::{Particle, Potential, SpeciesId};
    /// use carom::scene::{Fill, InteractionDraft, Model, SpeciesDraft, Amount, Lattice, SceneBuilder};
    ///
    /// let scene = SceneBuilder::new("fluid")
    ///     .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
    ///     .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
    ///     .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.1))
    ///     .build()?;
    /// let mut simulation = Simulation::new(scene)?;
    /// let leaving = simulation.snapshot().ids[0];
    /// let place = simulation.snapshot().positions[0];
    /// simulation.remove(&[leaving])?;
    /// let new = Particle::new(SpeciesId(0), place, Vector::new(0.3, 0.0, 0.0));
    /// let ids = simulation.insert(&[new])?;
    /// assert_eq!((ids[0].0, simulation.snapshot().ids.len()), (108, 108));
    /// simulation.advance(Until::events(100))?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[doc(alias = "inlet")]
    pub fn insert(&mut self, particles: &[Particle]) -> Result<Vec<ParticleId>, SetStateError> {
        if self.is_growing() {
            return Err(SetStateError::Growing);
        }
        let first = with_engine!(&self.engine, engine => engine.state.next_id);
        if u64::from(first) + particles.len() as u64 > MOST_PARTICLES {
            return Err(SetStateError::TooMany);
        }
        for (particle, id) in particles.iter().zip(first..) {
            self.check_new(particle, ParticleId(id))?;
        }
        let scene = &self.scene;
        with_engine!(&mut self.engine, engine => {
            engine.join();
            if let Some(overlap) = engine.overlap_of_new(scene, particles) {
                return Err(SetStateError::Overlap(overlap));
            }
            engine.insert_particles(scene, particles);
        });
        Ok((first..).take(particles.len()).map(ParticleId).collect())
    }

    /// Removes particles at the current time, with their bonds and captured pairs.
    ///
    /// The energy of the particles is subtracted from [`EventCounts::supplied`](super::event::EventCounts::supplied).
    /// The cost is proportional to the total number of particles. It is cheaper to remove many particles in one call.
    ///
    /// # Errors
    /// [`SetStateError::NoParticle`] for an unknown id, or an id that is given twice. While diameters grow,
    /// [`SetStateError::Growing`]. After an error, the simulation is unchanged.
    #[doc(alias = "outlet")]
    pub fn remove(&mut self, particles: &[ParticleId]) -> Result<(), SetStateError> {
        if self.is_growing() {
            return Err(SetStateError::Growing);
        }
        let mut sorted = particles.to_vec();
        sorted.sort_unstable();
        let twice = sorted.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0]);
        with_engine!(&mut self.engine, engine => {
            let is_there = |particle: &&ParticleId| engine.state.number(particle.0).is_some();
            if let Some(particle) = twice.or(particles.iter().find(|it| !is_there(it)).copied()) {
                return Err(SetStateError::NoParticle { particle });
            }
            engine.join();
            engine.leave_system(particles);
        });
        Ok(())
    }

    fn check_new(&self, new: &Particle, particle: ParticleId) -> Result<(), SetStateError> {
        let has_row = with_engine!(&self.engine, engine => engine.pairs.rules.rows.has_row(new.species));
        let Some(species) = self.scene.species.get(new.species.0 as usize).filter(|_| has_row) else {
            return Err(SetStateError::Species { particle, species: new.species });
        };
        let components = || new.position.iter().chain(&new.velocity).chain(&new.spin);
        if !components().all(|component| component.abs() <= LARGEST) {
            return Err(SetStateError::NotFinite { particle });
        }
        let allowed = self.range_of_diameters(new.species);
        let is_allowed = match (&species.individual, new.diameter) {
            (None, None) => true,
            (Some(_), Some(diameter)) => allowed.contains(&diameter),
            _ => false,
        };
        if !is_allowed {
            let range = species.individual.as_ref().map(|_| [*allowed.start(), *allowed.end()]);
            return Err(SetStateError::Diameter { particle, range });
        }
        let space = &self.scene.space;
        let is_wrong = |axis: &usize| {
            let is_flat = space.boundary[*axis] == Boundary::Flat;
            (is_flat && new.position[*axis] != space.lower[*axis])
                || ((is_flat || species.is_static()) && new.velocity[*axis] != 0.0)
        };
        if let Some(axis) = (0..3).find(is_wrong) {
            return Err(SetStateError::Fixed { particle, axis });
        }
        if new.spin != Vector::zeros() {
            if !self.has_spins() {
                return Err(SetStateError::NoSpins { particle });
            }
            if let Some(axis) =
                (0..3).find(|axis| new.spin[*axis] != 0.0 && (species.is_static() || !space.turns_about(*axis)))
            {
                return Err(SetStateError::Fixed { particle, axis });
            }
        }
        if self.scene.shear_rate.is_some() && !(space.lower.y..space.upper().y).contains(&new.position.y) {
            return Err(SetStateError::OutsideOfShearedBox { particle });
        }
        Ok(())
    }
}

impl Simulation {
    /// The range of diameters of a species at the start and in inlets `[length]`.
    pub(crate) fn range_of_diameters(&self, species: SpeciesId) -> RangeInclusive<f64> {
        with_engine!(&self.engine, engine => engine.pairs.rules.rows.diameters(species))
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Returns the deepest overlap of the first new particle that overlaps. Overlaps within round-off are ignored.
    fn overlap_of_new(&self, scene: &Scene, new: &[Particle]) -> Option<Overlap> {
        let now = self.clock.now;
        let present = |other: u32| {
            let (position, _) = self.state_at(other, now);
            (self.id(other), (self.species_of(other), self.radius(other)), position)
        };
        // A bond potential between two species limits the distance of every pair, so distant pairs can violate it.
        let has_bonds = scene.table.iter().any(|(_, id)| scene.interactions[id.0 as usize].potential.is_bond());
        let is_near = !has_bonds && !self.images.are_sliding();
        let mut near = Candidates::default();
        let mut added: Vec<(ParticleId, (SpeciesId, f64), Vector)> = Vec::new();
        for (particle, id) in new.iter().zip(self.state.next_id..) {
            let particle_id = ParticleId(id);
            let (position, _) = self.wrapped(particle.position);
            let row = self.pairs.rules.rows.row_of(particle);
            let radius = 0.5 * scene.diameter(particle);
            let mut deepest = self.overlap_with_surfaces((row, radius), &position, particle_id);
            let is_near = is_near && self.ranges.includes(row);
            if is_near {
                self.neighbours.find_candidates_at(&position, row, &mut near);
                near.found_mut().sort_unstable_by_key(|other| self.id(*other));
            }
            let found = if is_near { near.found().to_vec() } else { self.by_id().collect() };
            let others = found.into_iter().map(present).chain(added.iter().copied());
            for (other, (species, its_radius), there) in others {
                let Some(id) = scene.interaction_of(particle.species, species) else { continue };
                let pair = [(particle.species, radius), (species, its_radius)];
                let potential = scene.potential_between(id, pair);
                if scene.is_static(particle) && scene.species[species.0 as usize].is_static() {
                    continue;
                }
                let apart = self.nearest(position - there, Vector::zeros(), now).0.position.norm();
                let depth = potential.violation_at(apart);
                let largest = position.amax().max(there.amax());
                let round_off = rounding_of_distances(largest, &self.state.periods) / apart.max(f64::MIN_POSITIVE);
                let overlap = Overlap { particle: particle_id, partner: Some(other), depth, round_off };
                if overlap.is_real() && deepest.is_none_or(|other| depth > other.depth) {
                    deepest = Some(overlap);
                }
            }
            if deepest.is_some() {
                return deepest;
            }
            added.push((particle_id, (particle.species, radius), position));
        }
        None
    }

    /// Returns the deepest overlap of a particle with a surface. The particle is at `position` and has the given table
    /// row and radius. Overlaps within round-off are ignored.
    pub(super) fn overlap_with_surfaces(
        &self,
        (row, radius): (u16, f64),
        position: &Vector,
        particle: ParticleId,
    ) -> Option<Overlap> {
        if self.pairs.rules.species[usize::from(row)].is_static() {
            return None;
        }
        let mut deepest = None::<Overlap>;
        let unit = super::audit::unit_of_surface(radius);
        self.sources.surfaces.for_each_near((position, radius), row, self.time(), |surface, position| {
            let depth = -surface.shape.gap(position, radius) / unit;
            let terms = surface.shape.terms(position) + radius;
            let round_off = rounding_of_distances(terms, &self.state.periods) / unit;
            let overlap = Overlap { particle, partner: None, depth, round_off };
            if overlap.is_real() && deepest.is_none_or(|other| depth > other.depth) {
                deepest = Some(overlap);
            }
        });
        deepest
    }

    /// Adapts the neighbour search if any of the new particles is the first of its species.
    fn include_species_of(&mut self, particles: &[Particle]) {
        let rows = &self.pairs.rules.rows;
        let awake = particles.iter().map(|particle| rows.row_of(particle));
        let all = awake.flat_map(|row| [row, if rows.has_sleep() { rows.asleep(row) } else { row }]);
        if self.ranges.include(all) {
            self.sort_anew();
            self.start_anew();
        }
    }

    /// Inserts particles of a program without checks.
    fn insert_particles(&mut self, scene: &Scene, particles: &[Particle]) {
        self.include_species_of(particles);
        let before = if TABLE { self.energy().pair } else { 0.0 };
        let size = |particle: &Particle| Size::of(scene, particle);
        let sizes: Option<Vec<Size>> = self.has_sizes().then(|| particles.iter().map(size).collect());
        let set_states = |engine: &mut Self, added| {
            if TABLE {
                engine.set_states_of(scene, added);
            }
        };
        let _ = self.enter((particles, sizes.as_deref()), (With::Program, None), &mut None, set_states);
        if TABLE {
            self.note_pair_energy(before);
        }
    }

    /// Inserts particles without checks, and calls `set_states` with their indices. `sizes` is `None` if the
    /// particles of each species are equal. The energy of the inserted particles, without the energy of pairs, is
    /// added to the supplied energy. `how` is the origin of the particles and the kind of the counted event.
    pub(super) fn enter(
        &mut self,
        (particles, sizes): (&[Particle], Option<&[Size]>),
        how: (With, Option<CountedKind>),
        observe: &mut Observe<'_>,
        set_states: impl FnOnce(&mut Self, Range<u32>),
    ) -> ControlFlow<()> {
        let now = self.clock.now;
        let mut records = Vec::with_capacity(particles.len());
        for (particle, id) in particles.iter().zip(self.state.next_id..) {
            let (position, images) = self.wrapped(particle.position);
            let mut record = Record::new(id, position, Vector::zeros(), now);
            record.images = Some(images);
            record.spin = self.pairs.rules.has_spins.then_some(particle.spin);
            record.row = TABLE.then(|| self.pairs.rules.rows.row_of(particle));
            record.size = sizes.map(|sizes| sizes[records.len()]);
            record.captured = TABLE.then(Vec::new);
            records.push(record);
        }
        let added = self.push_records(&records);
        set_states(self, added.clone());
        let mut flow = ControlFlow::Continue(());
        let mut moving = 0;
        for (number, particle) in added.clone().zip(particles) {
            if !self.is_static(number) {
                moving += 1;
                if self.begin_motion(number, particle.velocity, how, observe).is_break() {
                    flow = ControlFlow::Break(());
                }
            }
        }
        self.predict_added(added);
        self.note_population(moving);
        flow
    }

    /// Sets the velocity of a particle that has entered the system or changed its species. The energy of the particle,
    /// without the energy of its pairs, counts as supplied energy.
    pub(super) fn begin_motion(
        &mut self,
        particle: u32,
        velocity: Vector,
        (other, counted): (With, Option<CountedKind>),
        observe: &mut Observe<'_>,
    ) -> ControlFlow<()> {
        let (position, inverse_mass) = (self.state.bodies[particle as usize].position, self.inverse_mass(particle));
        let change = Change::of_one(other, particle, &Vector::zeros(), velocity, inverse_mass);
        let supplied = change.supplied + self.energy_besides_motion(particle, &position);
        let distance = 2.0 * self.radius(particle);
        let flow = self.apply(&Change { counted, supplied, distance, ..change }, observe);
        self.forget_contacts(particle);
        self.search_again();
        flow
    }

    /// Stops a particle that leaves the system or changes its species. Its energy, without the energy of its pairs, is
    /// subtracted from the supplied energy. `line` points from the outlet to the particle.
    pub(super) fn end_motion(
        &mut self,
        particle: u32,
        line: &Vector,
        (other, counted): (With, Option<CountedKind>),
        observe: &mut Observe<'_>,
    ) -> ControlFlow<()> {
        let (body, inverse_mass) = (self.state.bodies[particle as usize], self.inverse_mass(particle));
        let inverse_inertia = self.inverse_inertia(particle);
        let change = Change::of_one(other, particle, &body.velocity, Vector::zeros(), inverse_mass);
        let supplied = change.supplied - self.energy_besides_motion(particle, &body.position);
        let of_spin = if inverse_inertia > 0.0 { -self.spin(particle) / inverse_inertia } else { Vector::zeros() };
        let torques = [of_spin, Vector::zeros()];
        self.apply(&Change { counted, supplied, torques, line: *line, squared: 1.0, ..change }, observe)
    }

    /// Returns the rotational energy of a particle, and its potential energy in gravity.
    fn energy_besides_motion(&self, particle: u32, position: &Vector) -> f64 {
        let external: f64 = if FALLING { self.external_energies(particle, position).sum() } else { 0.0 };
        rotational_energy(&self.spin(particle), self.inverse_inertia(particle)) + external
    }

    /// Removes particles without checks. Their energy is subtracted from the supplied energy.
    fn leave_system(&mut self, particles: &[ParticleId]) {
        let before = self.energy().pair;
        let numbers: Vec<u32> = particles.iter().map(|particle| self.number(*particle)).collect();
        let mut moving = 0;
        for &particle in &numbers {
            let _ = self.wake_neighbours(particle, &mut None);
        }
        let sleeping = numbers.iter().copied().filter(|&particle| self.is_asleep(particle)).collect();
        let _ = self.wake_some(sleeping, &mut None);
        for &particle in &numbers {
            if self.is_static(particle) {
                continue;
            }
            moving -= 1;
            self.stream(particle, self.clock.now);
            let _ = self.end_motion(particle, &Vector::zeros(), (With::Program, None), &mut None);
        }
        self.remove(&numbers);
        self.predict_partners_of_removed();
        self.note_pair_energy(before);
        self.note_population(moving);
    }

    /// Counts the change of the energy of all pairs as supplied energy.
    fn note_pair_energy(&mut self, before: f64) {
        let gained = self.energy().pair - before;
        self.note_energies(gained, 0.0, gained);
    }

    /// Adds `change` to the number of moving particles, and adapts the heat bath and the standstill watch.
    pub(super) fn note_population(&mut self, change: isize) {
        self.state.moving = self.state.moving.saturating_add_signed(change);
        if let Some(bath) = &mut self.sources.andersen {
            bath.act_on(self.state.moving, self.clock.now);
        }
        self.clock.watch_for(self.state.count());
        self.schedule_global();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{States, Until};
    use crate::model::Thermostat;
    use crate::model::space::Space;
    use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

    fn box_between_walls(particles: u32) -> Simulation {
        let space = Space { boundary: [Boundary::walls(1.0); 3], ..Space::periodic_cube(30.0) };
        let mut scene = SceneBuilder::new("few")
            .space(space)
            .species(SpeciesDraft::new("A").mass(1.3).diameter(0.5))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"));
        for k in 0..particles {
            let at = |n: u32| 1.5 + 3.0 * f64::from(n % 10);
            scene = scene.particle("A", Vector::new(at(k), at(k / 10), at(k / 100)), Vector::new(0.7, 0.0, 0.0));
        }
        Simulation::without_plan(scene.build().unwrap())
    }

    fn one(x: f64, vx: f64) -> Particle {
        Particle::new(SpeciesId(0), Vector::new(x, 29.0, 29.0), Vector::new(vx, 0.0, 0.0))
    }

    #[test]
    fn bath_collides_with_the_particles_that_are_there() {
        let mut simulation = box_between_walls(200);
        let bath = Thermostat::Andersen { temperature: 1.0, rate: 2.0, axes: [true; 3] };
        simulation.set_thermostat(Some(&bath), 0).unwrap();
        let gone: Vec<ParticleId> = (0..150).map(ParticleId).collect();
        simulation.remove(&gone).unwrap();
        simulation.advance(Until::time(40.0)).unwrap();
        // The number of collisions has a Poisson distribution with the mean 50 * 2 * 40.
        let collisions = simulation.event_counts().thermostat as f64;
        assert!((collisions - 4_000.0).abs() < 5.0 * 4_000.0_f64.sqrt(), "{collisions}");
        simulation.remove(&(150..200).map(ParticleId).collect::<Vec<_>>()).unwrap();
        let before = simulation.event_counts().thermostat;
        simulation.advance(Until::time(50.0)).unwrap();
        assert_eq!(simulation.event_counts().thermostat, before, "no particle is left");
        assert_eq!(simulation.insert(&[one(3.0, 0.0)]).unwrap(), [ParticleId(200)]);
        simulation.advance(Until::time(90.0)).unwrap();
        let collisions = (simulation.event_counts().thermostat - before) as f64;
        assert!((collisions - 80.0).abs() < 5.0 * 80.0_f64.sqrt(), "{collisions}");
    }

    #[test]
    fn kinetic_energy_between_walls_is_integrated_from_entry_to_exit() {
        let mut simulation = box_between_walls(1);
        simulation.advance(Until::time(3.0)).unwrap();
        let new = simulation.insert(&[one(7.0, -1.1)]).unwrap();
        simulation.advance(Until::time(10.0)).unwrap();
        simulation.remove(&new).unwrap();
        simulation.advance(Until::time(14.0)).unwrap();
        let volume = simulation.scene().space().accessible_volume(0.5);
        let heating = simulation.event_counts().confined_heating[0].total();
        let integral = simulation.energy().confined.x * 14.0 - heating;
        // The integral of m v^2 is 1.3 (0.7^2 * 14 + 1.1^2 * 7).
        let expected = 1.3 * (0.49 * 14.0 + 1.21 * 7.0) / volume;
        assert!((integral / expected - 1.0).abs() < 100.0 * f64::EPSILON, "{integral} {expected}");
        let supplied = simulation.event_counts().supplied.total();
        assert!(supplied.abs() < 100.0 * f64::EPSILON, "the particle removes the energy that it brought: {supplied}");
    }

    #[test]
    fn ids_are_never_used_again() {
        let mut simulation = box_between_walls(3);
        simulation.remove(&[ParticleId(2), ParticleId(0)]).unwrap();
        assert_eq!(simulation.insert(&[one(3.0, 0.0), one(9.0, 0.1)]).unwrap(), [ParticleId(3), ParticleId(4)]);
        simulation.remove(&[ParticleId(4)]).unwrap();
        assert_eq!(simulation.insert(&[]).unwrap(), []);
        assert_eq!(simulation.insert(&[one(15.0, 0.0)]).unwrap(), [ParticleId(5)]);
        let snapshot = simulation.snapshot();
        assert_eq!(snapshot.ids, [1, 3, 5].map(ParticleId));
        assert_eq!((snapshot.index(ParticleId(3)), snapshot.index(ParticleId(2))), (Some(1), None));
        let mut states = States::default();
        simulation.states(&mut states);
        simulation.states(&mut states);
        assert_eq!((states.ids, states.positions.len()), (snapshot.ids.clone(), 3));
        simulation.set_velocities(&[Vector::x(), Vector::y(), Vector::z()]).unwrap();
        assert_eq!(simulation.snapshot().velocities[2], Vector::z());
        assert_eq!(simulation.unsound_index(), None);
    }

    #[test]
    fn error_names_the_deepest_of_several_overlaps() {
        let mut simulation = box_between_walls(1);
        simulation.insert(&[one(10.0, 0.0), one(10.52, 0.0)]).unwrap();
        for (x, partner) in [(10.12, 1), (10.4, 2)] {
            let Err(SetStateError::Overlap(overlap)) = simulation.insert(&[one(x, 0.0)]) else { panic!("{x}") };
            assert_eq!((overlap.particle, overlap.partner), (ParticleId(3), Some(ParticleId(partner))));
            // The contact distance is 0.5, and the particles are 0.12 apart.
            assert!((overlap.depth - 0.76).abs() < 100.0 * f64::EPSILON, "{}", overlap.depth);
        }
    }
}
