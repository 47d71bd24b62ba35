//! The baseline: velocity Verlet with neighbour lists.

use super::fluid::{Fluid, State, Thermodynamics};
use super::{CUTOFF, Plan};
use crate::neighbours::{List, Periods};
use carom::Vector;
use carom::engine::Simulation;
use carom::model::potential::Potential;
use carom::scene::{Fill, InteractionDraft, Lattice, SceneBuilder, SpeciesDraft};

const PARTICLES: u64 = 864;

pub struct Verlet {
    volume: f64,
    periods: Periods,
    skin: f64,
    dt: f64,
    positions: Vec<Vector>,
    velocities: Vec<Vector>,
    forces: Vec<Vector>,
    list: List,
    /// Positions when the list was built.
    listed: Vec<Vector>,
    potential: f64,
    virial: f64,
}

/// The potential at a squared distance, before the shift.
pub fn energy_of_pair(squared: f64) -> f64 {
    let sixth = (1.0 / squared) * (1.0 / squared) * (1.0 / squared);
    4.0 * sixth * (sixth - 1.0)
}

impl Verlet {
    pub fn new(plan: &Plan, start: &State, dt: f64) -> Self {
        let mut fluid = Self {
            volume: start.box_length.powi(3),
            periods: Periods::new(&Vector::repeat(start.box_length)),
            skin: plan.skin,
            dt,
            positions: start.positions.clone(),
            velocities: start.velocities.clone(),
            forces: vec![Vector::zeros(); start.positions.len()],
            list: List::default(),
            listed: Vec::new(),
            potential: 0.0,
            virial: 0.0,
        };
        fluid.relist();
        fluid.find_forces();
        fluid
    }

    fn relist(&mut self) {
        for position in &mut self.positions {
            *position = self.periods.wrapped(position);
        }
        self.list.build(&self.positions, &self.periods, CUTOFF + self.skin);
        self.listed.clone_from(&self.positions);
    }

    fn find_forces(&mut self) {
        let shift = energy_of_pair(CUTOFF * CUTOFF);
        self.forces.fill(Vector::zeros());
        let (mut potential, mut virial) = (0.0, 0.0);
        for i in 0..self.positions.len() {
            let (position, mut force) = (self.positions[i], self.forces[i]);
            for &j in &self.list.partners[self.list.starts[i]..self.list.starts[i + 1]] {
                let r = self.periods.separation(&position, &self.positions[j as usize]);
                let squared = r.norm_squared();
                // A factor of 0 or 1 replaces a branch, which would be mispredicted for every third pair.
                let is_near = f64::from(u8::from(squared < CUTOFF * CUTOFF));
                let inverse = 1.0 / squared;
                let sixth = inverse * inverse * inverse;
                let strength = is_near * 48.0 * sixth * (sixth - 0.5);
                potential += is_near * (4.0 * sixth * (sixth - 1.0) - shift);
                virial += strength;
                let pair = r * (strength * inverse);
                force += pair;
                self.forces[j as usize] -= pair;
            }
            self.forces[i] = force;
        }
        (self.potential, self.virial) = (potential, virial);
    }

    fn step(&mut self) {
        let (dt, half) = (self.dt, 0.5 * self.dt);
        let limit = 0.25 * self.skin * self.skin;
        let mut is_old = false;
        for i in 0..self.positions.len() {
            self.velocities[i] += self.forces[i] * half;
            self.positions[i] += self.velocities[i] * dt;
            is_old |= (self.positions[i] - self.listed[i]).norm_squared() > limit;
        }
        if is_old {
            self.relist();
        }
        self.find_forces();
        for (velocity, force) in self.velocities.iter_mut().zip(&self.forces) {
            *velocity += force * half;
        }
    }

    fn kinetic(&self) -> f64 {
        0.5 * self.velocities.iter().map(Vector::norm_squared).sum::<f64>()
    }

    fn thermodynamics(&self, kinetic: f64, potential: f64, virial: f64) -> Thermodynamics {
        Thermodynamics::new(self.positions.len() as f64, self.volume, kinetic, potential, virial)
    }
}

impl Fluid for Verlet {
    fn advance(&mut self, time: f64) -> Thermodynamics {
        let steps = (time / self.dt).round().max(1.0);
        let (mut kinetic, mut potential, mut virial) = (0.0, 0.0, 0.0);
        #[expect(clippy::cast_possible_truncation, reason = "more steps could not be waited for")]
        for _ in 0..steps as usize {
            self.step();
            kinetic += self.kinetic();
            potential += self.potential;
            virial += self.virial;
        }
        self.thermodynamics(kinetic / steps, potential / steps, virial / steps)
    }
}

/// Melts a lattice, repeatedly scales the velocities to the temperature of the plan, and then lets the fluid relax.
pub fn equilibrate(plan: &Plan) -> State {
    let scene = SceneBuilder::new("start")
        .species(SpeciesDraft::new("atom").mass(1.0).diameter(1.0))
        .interaction(
            InteractionDraft::new(Potential::hard_sphere(0.5).expect("a valid potential")).between("atom", "atom"),
        )
        .fill(Fill::new(Lattice::FaceCentredCubic, "atom").count(PARTICLES).number_density(plan.density))
        .temperature(plan.temperature);
    let simulation = Simulation::without_plan(scene.build().expect("a valid scene"));
    let snapshot = simulation.snapshot();
    let mut state = State {
        box_length: simulation.scene().space().size.x,
        positions: snapshot.positions,
        velocities: snapshot.velocities,
        energy: f64::NAN,
    };
    let mut fluid = Verlet::new(plan, &state, 0.002);
    for _ in 0..100 {
        let temperature = fluid.advance(0.2).temperature;
        fluid.velocities.iter_mut().for_each(|velocity| *velocity *= (plan.temperature / temperature).sqrt());
    }
    fluid.advance(10.0);
    fluid.relist();
    let now = fluid.thermodynamics(fluid.kinetic(), fluid.potential, fluid.virial);
    state.energy = now.total;
    (state.positions, state.velocities) = (fluid.positions, fluid.velocities);
    state
}
