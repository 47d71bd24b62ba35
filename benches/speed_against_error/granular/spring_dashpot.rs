//! The baseline: grains as linear springs and dashpots, integrated by leapfrog.

use crate::neighbours::{List, Periods};
use carom::Vector;

/// Range of the neighbour list beyond contact `[sigma]`.
const SKIN: f64 = 0.3;

/// Initial state of grains with diameter 1 and mass 1.
#[derive(Debug, Clone)]
pub struct Start {
    /// Edge lengths of the box; infinite along open axes.
    pub periods: Vector,
    pub gravity: f64,
    pub has_floor: bool,
    pub positions: Vec<Vector>,
    pub velocities: Vec<Vector>,
}

pub struct SpringDashpot {
    start: Start,
    periods: Periods,
    stiffness: f64,
    /// Damping force divided by the speed of approach, for two grains and for a grain at the floor.
    damping: [f64; 2],
    dt: f64,
    forces: Vec<Vector>,
    list: List,
    listed: Vec<Vector>,
    pub dissipated: f64,
    pub deepest: f64,
    elastic: f64,
}

impl SpringDashpot {
    pub fn new(start: Start, stiffness: f64, restitution: f64, steps_per_contact: f64) -> Self {
        let periods = Periods::new(&start.periods);
        let forces = vec![Vector::zeros(); start.positions.len()];
        let damping = [0.5, 1.0].map(|mass| 2.0 * mass * decay(stiffness, mass, restitution));
        let dt = contact_duration(stiffness, restitution) / steps_per_contact;
        let (list, listed) = (List::default(), Vec::new());
        let (dissipated, deepest, elastic) = (0.0, 0.0, 0.0);
        let mut grains =
            Self { start, periods, stiffness, damping, dt, forces, list, listed, dissipated, deepest, elastic };
        grains.relist();
        grains.find_forces();
        grains
    }

    /// Advances by `time`. Shortens the time steps so that a whole number of them fits.
    pub fn advance(&mut self, time: f64) {
        let steps = (time / self.dt).ceil();
        self.dt = time / steps;
        #[expect(clippy::cast_possible_truncation, reason = "more steps could not be waited for")]
        for _ in 0..steps as u64 {
            self.step();
        }
    }

    fn step(&mut self) {
        let (dt, half) = (self.dt, 0.5 * self.dt);
        let mut is_old = false;
        for i in 0..self.forces.len() {
            self.start.velocities[i] += self.forces[i] * half;
            self.start.positions[i] += self.start.velocities[i] * dt;
            is_old |= (self.start.positions[i] - self.listed[i]).norm_squared() > 0.25 * SKIN * SKIN;
        }
        if is_old {
            self.relist();
        }
        self.find_forces();
        for (velocity, force) in self.start.velocities.iter_mut().zip(&self.forces) {
            *velocity += force * half;
        }
    }

    fn relist(&mut self) {
        for position in &mut self.start.positions {
            *position = self.periods.wrapped(position);
        }
        self.list.build(&self.start.positions, &self.periods, 1.0 + SKIN);
        self.listed.clone_from(&self.start.positions);
    }

    fn find_forces(&mut self) {
        self.forces.fill(Vector::new(0.0, 0.0, -self.start.gravity));
        self.elastic = 0.0;
        for i in 0..self.forces.len() {
            for k in self.list.starts[i]..self.list.starts[i + 1] {
                self.meet(i, self.list.partners[k] as usize);
            }
            let height = self.start.positions[i].z;
            if self.start.has_floor && height < 0.5 {
                let force = self.contact(0.5 - height, self.start.velocities[i].z, 1);
                self.forces[i].z += force;
            }
        }
    }

    fn meet(&mut self, i: usize, j: usize) {
        let r = self.periods.separation(&self.start.positions[i], &self.start.positions[j]);
        let squared = r.norm_squared();
        if squared < 1.0 {
            let distance = squared.sqrt();
            let normal = r / distance;
            let speed = (self.start.velocities[i] - self.start.velocities[j]).dot(&normal);
            let force = normal * self.contact(1.0 - distance, speed, 0);
            self.forces[i] += force;
            self.forces[j] -= force;
        }
    }

    /// The repulsive force at an overlap `depth` that decreases at the rate `speed`.
    fn contact(&mut self, depth: f64, speed: f64, kind: usize) -> f64 {
        self.deepest = self.deepest.max(depth);
        self.elastic += 0.5 * self.stiffness * depth * depth;
        self.dissipated += self.damping[kind] * speed * speed * self.dt;
        self.stiffness * depth - self.damping[kind] * speed
    }

    pub fn positions(&self) -> &[Vector] {
        &self.start.positions
    }

    pub fn kinetic(&self) -> f64 {
        0.5 * self.start.velocities.iter().map(Vector::norm_squared).sum::<f64>()
    }

    pub fn energy(&self) -> f64 {
        let heights: f64 = self.start.positions.iter().map(|x| x.z).sum();
        self.kinetic() + self.elastic + self.start.gravity * heights
    }
}

/// The decay rate `eta` of a damped spring. The restitution is `e = exp(-eta t)`, where `t` is half a period.
fn decay(stiffness: f64, mass: f64, restitution: f64) -> f64 {
    let logarithm = -restitution.ln();
    (stiffness / mass).sqrt() * logarithm / std::f64::consts::PI.hypot(logarithm)
}

pub fn contact_duration(stiffness: f64, restitution: f64) -> f64 {
    let eta = decay(stiffness, 0.5, restitution);
    std::f64::consts::PI / (2.0 * stiffness - eta * eta).sqrt()
}
