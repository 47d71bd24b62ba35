use serde::{Deserialize, Serialize};

use super::error::StartError;
use crate::Vector;
use crate::engine::{EngineError, Simulation, Until};
use crate::model::random::{Purpose, Random};
use crate::model::{ExchangePlan, Particle, Scene, Species, Thermostat};
use crate::run::audit::Ledger;

/// Number of engine steps between two checks for a pause. The steps take a few milliseconds.
const STEPS: u64 = 1 << 14;

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Replica {
    pub simulation: Simulation,
    ledger: Ledger,
}

impl Replica {
    pub fn new(scene: &Scene, plan: &ExchangePlan, seed: u64, number: usize) -> Result<Self, StartError> {
        let mut own = scene.clone();
        own.exchange = None;
        let temperature = plan.temperatures_of_places()[number];
        own.run.thermostat = Some(bath(plan, temperature));
        let mut random = Random::new(seed, Purpose::Exchange, 1 + number);
        let velocity = |particle: &Particle| match scene.is_static(particle) {
            true => Vector::zeros(),
            false => random.normal_vector(&scene.space) * (temperature / scene.mass(particle)).sqrt(),
        };
        let velocities: Vec<Vector> = scene.particles.iter().map(velocity).collect();
        let keeps_start = scene.species.iter().any(Species::is_static);
        let mut simulation = Simulation::begin(own, keeps_start);
        let mut ledger = Ledger::open(&simulation, false);
        simulation.set_velocities(&velocities)?;
        ledger.note(&simulation, &simulation.energy());
        Ok(Self { simulation, ledger })
    }

    /// Records the energy of the replica for its audit, and returns the potential energy `[energy]`.
    pub fn note(&mut self) -> f64 {
        let energy = self.simulation.energy();
        self.ledger.note(&self.simulation, &energy);
        energy.potential
    }

    pub fn scale_velocities(&mut self, factor: f64) {
        self.simulation.scale_velocities(factor, &Vector::zeros());
        self.note();
    }

    pub fn faults(&self) -> Vec<String> {
        self.ledger.close(&self.simulation).faults().iter().map(ToString::to_string).collect()
    }

    pub fn go(&mut self, time: f64, mut pauses: impl FnMut() -> bool) -> Result<bool, EngineError> {
        loop {
            if self.simulation.advance_for(STEPS, Until::time(time))?.is_some() {
                return Ok(true);
            }
            if pauses() {
                return Ok(false);
            }
        }
    }
}

pub(super) fn bath(plan: &ExchangePlan, temperature: f64) -> Thermostat {
    Thermostat::Andersen { temperature, rate: plan.rate, axes: [true; 3] }
}
