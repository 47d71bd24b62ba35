use super::fluid::{Fluid, State, Thermodynamics};
use super::{CUTOFF, verlet};
use crate::Outcome;
use carom::engine::{Simulation, Until};
use carom::model::Scene;
use carom::model::potential::Potential;
use carom::model::space::Space;
use carom::scene::{InteractionDraft, SceneBuilder, SpeciesDraft};

/// Energy at the hard core. Its Boltzmann weight of exp(-50/1.5) is so small that no pair reaches the core.
const CORE_ENERGY: f64 = 50.0;

pub struct Stepped {
    simulation: Simulation,
    count: f64,
    volume: f64,
}

impl Stepped {
    /// Starts from `state`, with velocities for the energy `state.energy`. `None` if the potential energy alone is
    /// larger.
    pub fn new(state: &State, steps: usize) -> Outcome<Option<Self>> {
        let potential = potential(steps)?;
        let energy = Simulation::without_plan(scene(state, &potential, 1.0)?).energy();
        let kinetic = state.energy * state.particles() - energy.pair;
        if kinetic <= 0.0 {
            return Ok(None);
        }
        let simulation = Simulation::without_plan(scene(state, &potential, (kinetic / energy.kinetic).sqrt())?);
        Ok(Some(Self { simulation, count: state.particles(), volume: state.box_length.powi(3) }))
    }
}

/// Carom's stepped potential, shifted by the same energy as the smooth potential.
fn potential(steps: usize) -> Outcome<Potential> {
    let cut = Potential::stepped_lennard_jones(1.0, 1.0, CUTOFF, steps, CORE_ENERGY)?;
    let shift = verlet::energy_of_pair(CUTOFF * CUTOFF);
    let energies = cut.energies().iter().enumerate().map(|(k, energy)| if k == 0 { 0.0 } else { energy - shift });
    Ok(Potential::new(cut.radii().to_vec(), energies.collect())?)
}

fn scene(state: &State, potential: &Potential, scale: f64) -> Outcome<Scene> {
    let mut builder = SceneBuilder::new("stepped-lennard-jones")
        .space(Space::periodic_cube(state.box_length))
        .species(SpeciesDraft::new("atom").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(potential.clone()).between("atom", "atom"));
    for (position, velocity) in state.positions.iter().zip(&state.velocities) {
        builder = builder.particle("atom", *position, velocity * scale);
    }
    Ok(builder.build()?)
}

impl Fluid for Stepped {
    fn advance(&mut self, time: f64) -> Thermodynamics {
        let simulation = &mut self.simulation;
        let (start, before) = (simulation.time(), simulation.event_counts().virial.total());
        let energy = simulation.energy();
        let (mut kinetic, mut integral, mut now) = (energy.kinetic, 0.0, start);
        let end = start + time;
        let outcome = simulation.advance_with(Until::time(end), |event| {
            integral += kinetic * (event.time - now);
            kinetic -= event.energy_step;
            now = event.time;
        });
        outcome.expect("an elastic fluid does not arrest");
        integral += kinetic * (end - now);
        let kinetic = integral / time;
        let potential = energy.kinetic + energy.pair - kinetic;
        let virial = (simulation.event_counts().virial.total() - before) / time;
        Thermodynamics::new(self.count, self.volume, kinetic, potential, virial)
    }
}
