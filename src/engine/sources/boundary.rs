//! Walls of the box: contacts of particles with them, reflecting or thermal.

use crate::Vector;
use crate::engine::audit::unit_of_wall;
use crate::engine::event::{CountedKind, Event, EventKind};
use crate::engine::neighbours::grid::Face;
use crate::engine::observe::{Observe, show};
use crate::engine::parts::Engine;
use crate::engine::predict::Streamed;
use crate::engine::prediction::Prediction;
use crate::engine::sources::pair::Arrival;
use crate::engine::{Invariant, InvariantBroken};
use crate::model::random::{Purpose, Random};
use crate::model::space::{Boundary, Face as SpaceFace};
use crate::model::{ParticleId, Scene};
use crate::physics::detection::plane;
use crate::physics::response::Leaving;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// The random numbers of walls are those of a stage that no scene has.
const STAGE: usize = 1 << 40;

/// A wall of the box.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(in crate::engine) struct Wall {
    pub face: Face,
    /// Coordinate along its axis.
    pub at: f64,
    pub restitution: f64,
    /// Of the velocities that it gives; `None` if it reflects.
    pub temperature: Option<f64>,
}

/// The walls of a scene.
pub(super) fn walls(scene: &Scene) -> Vec<Wall> {
    let mut walls = Vec::new();
    for (face_axis, axis) in (0..).zip(0..3) {
        if let Boundary::Bounded { lower, upper } = scene.space.boundary[axis] {
            let [below, above] = scene.wall_temperatures[axis];
            for (is_upper, side, at, temperature) in
                [(false, lower, scene.space.lower[axis], below), (true, upper, scene.space.upper()[axis], above)]
            {
                if let SpaceFace::Wall { restitution } = side {
                    walls.push(Wall { face: Face { axis: face_axis, is_upper }, at, restitution, temperature });
                }
            }
        }
    }
    walls
}

/// Random numbers of thermal walls. Each contact has its own, by the particle and the number of its contacts so far: the order of contacts of different particles decides nothing.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::engine) struct WallRandom {
    stream: Random,
    /// Contacts with thermal walls so far, by name.
    contacts: Vec<u32>,
}

impl WallRandom {
    /// Random numbers of the walls of a scene, if some are thermal.
    pub fn of(scene: &Scene) -> Option<Self> {
        scene.has_thermal_walls().then(|| Self {
            stream: Random::new(scene.seed, Purpose::Thermostat, STAGE + scene.first_stream()),
            contacts: vec![0; scene.particles.len()],
        })
    }

    /// Random numbers of the next contact of a particle.
    fn next(&mut self, name: u32) -> &mut Random {
        let count = &mut self.contacts[name as usize];
        self.stream.seek(name, *count);
        *count = count.wrapping_add(1);
        &mut self.stream
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Predicts contacts with walls, but for those that `is_near` leaves out.
    pub(in crate::engine) fn predict_walls(
        &self,
        me: &Streamed,
        is_near: impl Fn(Face) -> bool,
        prediction: &mut Prediction,
    ) {
        for wall in self.sources.walls.iter().filter(|wall| is_near(wall.face)) {
            let axis = usize::from(wall.face.axis);
            let radius = self.pairs.rules.species[usize::from(self.row(me.id))].radius;
            let inwards = wall.face.inwards();
            let height = inwards * (me.position[axis] - wall.at) - radius;
            if let Some(dt) = plane::next_event(height, inwards * me.velocity[axis], inwards * me.acceleration[axis])
                && me.time + dt < prediction.contact_time
            {
                prediction.reach(wall.face, me.time + dt, self.state.bodies[me.id as usize].name);
            }
        }
    }

    /// A particle reaches a wall.
    pub(in crate::engine) fn execute_wall(
        &mut self,
        i: u32,
        face: Face,
        time: f64,
        observe: &mut Observe<'_>,
    ) -> Result<ControlFlow<()>, InvariantBroken> {
        let flown = time - self.state.bodies[i as usize].time;
        self.stream(i, time);
        let axis = usize::from(face.axis);
        let inwards = face.inwards();
        let Some(&wall) = self.sources.walls.iter().find(|wall| wall.face == face) else {
            return Err(self.broken(i, None, Invariant::Wall));
        };
        let Wall { at, temperature, .. } = wall;
        let species = self.pairs.rules.species[usize::from(self.row(i))];
        let body = self.state.bodies[i as usize];
        let vn = inwards * body.velocity[axis];
        let depth = species.radius - inwards * (body.position[axis] - at);
        if depth > 0.0 {
            let unit = unit_of_wall(species.radius);
            self.counts.totals.deepest_overlap = self.counts.totals.deepest_overlap.max(depth / unit);
            self.note_overlap(depth, unit, self.round_off_of_wall(i, axis, at, flown));
        }
        if vn >= 0.0 {
            self.counts.totals.turning_point += 1;
        }
        if let Some(temperature) = temperature {
            return self.execute_thermal_wall(i, face, temperature, observe);
        }
        let Leaving { speed: after, tangential_scale } = self.leave_wall(i, wall, vn, time);
        let before = body.velocity;
        let body = &mut self.state.bodies[i as usize];
        if tangential_scale != 1.0 {
            body.velocity *= tangential_scale;
        }
        body.velocity[axis] = inwards * after;
        body.events = body.events.wrapping_add(1);
        let dissipated =
            if tangential_scale == 1.0 { 0.5 / species.inverse_mass * (vn - after) * (vn + after) } else { 0.0 };
        let (position, velocity) = (body.position, body.velocity);
        self.note_dissipated(dissipated);
        self.note_confined_change(i, &before);
        self.count_wall(i, face, (after - vn) / species.inverse_mass, -dissipated);
        let mut normal = Vector::zeros();
        normal[axis] = inwards;
        Ok(show(observe, || Event {
            time: self.time(),
            kind: EventKind::Wall { axis: face.axis, is_upper: face.is_upper },
            particle: self.name(i),
            partner: None,
            normal,
            impulse: (after - vn) / species.inverse_mass,
            distance: species.radius,
            energy_step: 0.0,
            dissipated,
            positions: [position, Vector::zeros()],
            before: [before, Vector::zeros()],
            after: [velocity, Vector::zeros()],
        }))
    }

    /// The normal speed with which a particle leaves a wall that reflects, and the factor of its tangential velocity.
    #[inline]
    fn leave_wall(&mut self, i: u32, wall: Wall, vn: f64, time: f64) -> Leaving {
        let restitution = wall.restitution;
        if self.pairs.contact_times.is_none() {
            return Leaving { speed: if vn < 0.0 { -restitution * vn } else { vn }, tangential_scale: 1.0 };
        }
        let velocity = self.state.bodies[i as usize].velocity;
        let inwards = wall.face.inwards();
        let closing = -inwards * self.acceleration(i)[usize::from(wall.face.axis)];
        let tangential = (velocity.norm_squared() - vn * vn).max(0.0).sqrt();
        let arriving = (-vn).max(0.0);
        let leaving = self.tc_model(&[i], restitution, Arrival { speed: arriving, tangential, closing }, time);
        // What the model leaves as it is, or makes elastic: a particle that recedes within round-off keeps its speed.
        Leaving { speed: if leaving.speed == arriving { vn.abs() } else { leaving.speed }, ..leaving }
    }

    fn count_wall(&mut self, i: u32, face: Face, impulse: f64, gained: f64) {
        self.counts.totals.wall += 1;
        self.note_push(i, face, impulse);
        if gained != 0.0 {
            self.counts.totals.wall_heat[usize::from(face.axis)][usize::from(face.is_upper)].add(gained);
        }
        if TABLE {
            self.counts.by_species.note_single(usize::from(self.row(i)), CountedKind::Wall);
        }
    }

    /// A particle leaves a wall with a velocity from the flux of a gas of the wall's temperature: its normal component has the density
    /// `(m v / T) exp(- m v^2 / 2 T)`, the others are normal.
    fn execute_thermal_wall(
        &mut self,
        i: u32,
        face: Face,
        temperature: f64,
        observe: &mut Observe<'_>,
    ) -> Result<ControlFlow<()>, InvariantBroken> {
        let axis = usize::from(face.axis);
        let inwards = face.inwards();
        let species = self.pairs.rules.species[usize::from(self.row(i))];
        let width = (temperature * species.inverse_mass).sqrt();
        let body = self.state.bodies[i as usize];
        let (body_position, before) = (body.position, body.velocity);
        let name = self.name(i).0;
        let Some(walls) = &mut self.sources.wall_random else {
            return Err(self.broken(i, None, Invariant::WallRandom));
        };
        let random = walls.next(name);
        let mut after = random.normal_vector(&self.state.space) * width;
        after[axis] = inwards * width * (2.0 * random.exponential()).sqrt();
        let mut normal = Vector::zeros();
        normal[axis] = inwards;
        let gained = 0.5 / species.inverse_mass * (after - before).dot(&(after + before));
        let impulse = (after[axis] - before[axis]) * inwards / species.inverse_mass;
        self.count_wall(i, face, impulse, gained);
        self.note_supplied(gained);
        let body = &mut self.state.bodies[i as usize];
        body.velocity = after;
        body.events = body.events.wrapping_add(1);
        self.note_confined_change(i, &before);
        Ok(show(observe, || Event {
            time: self.time(),
            kind: EventKind::Wall { axis: face.axis, is_upper: face.is_upper },
            particle: ParticleId(name),
            partner: None,
            normal,
            impulse,
            distance: species.radius,
            energy_step: gained,
            dissipated: 0.0,
            positions: [body_position, Vector::zeros()],
            before: [before, Vector::zeros()],
            after: [after, Vector::zeros()],
        }))
    }
}
