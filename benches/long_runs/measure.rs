use super::row::{self, HEADER, Row};
use carom::Vector;
use carom::engine::{Reason, Simulation, Until};
use carom::model::Scene;
use std::error::Error;
use std::fs;
use std::io::Write;
use std::time::Instant;

/// Rows per factor of ten in the number of events.
const PER_DECADE: u32 = 8;

pub fn run(name: &str, scene: &str, most: u64) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(super::FOLDER)?;
    let mut file = fs::File::create(row::file(name))?;
    writeln!(file, "{HEADER}")?;
    let mut simulation = Simulation::without_plan(Scene::from_file(scene)?);
    let start = Start::of(&simulation);
    let started = Instant::now();
    for step in 0.. {
        #[expect(clippy::cast_possible_truncation, reason = "the largest number stands for all beyond it")]
        let events = (1000.0 * 10_f64.powf(f64::from(step) / f64::from(PER_DECADE))).round() as u64;
        let events = events.min(most);
        let reason = simulation.advance(Until::events(events))?;
        let row = start.row(&simulation, started.elapsed().as_secs_f64());
        writeln!(file, "{row}")?;
        println!("{name}: {row}");
        if events == most || reason == Reason::Idle {
            break;
        }
    }
    Ok(())
}

/// Energy and momentum at the start of a run.
pub struct Start {
    energy: f64,
    momentum: Vector,
    conserves_momentum: bool,
}

impl Start {
    pub fn of(simulation: &Simulation) -> Self {
        let energy = simulation.energy();
        let scene = simulation.scene();
        let has_no_frame = scene.space().is_fully_periodic()
            && scene.species().iter().all(|s| !s.is_static() && s.acceleration.norm() == 0.0);
        Self { energy: energy.kinetic + energy.potential, momentum: energy.momentum, conserves_momentum: has_no_frame }
    }

    pub fn row(&self, simulation: &Simulation, seconds: f64) -> Row {
        let (energy, event_counts) = (simulation.energy(), simulation.event_counts());
        let dissipated = event_counts.dissipated.total();
        let scale = self.energy.abs().max(energy.kinetic).max(dissipated);
        let scene = simulation.scene();
        let masses = scene.particles().iter().map(|particle| scene.species()[particle.species.0 as usize].mass);
        let speeds = simulation.snapshot().velocities;
        let momenta: f64 = masses.zip(&speeds).map(|(mass, velocity)| mass * velocity.norm()).sum();
        Row {
            events: event_counts.physical() as f64,
            time: simulation.time(),
            energy: (energy.kinetic + energy.potential + dissipated - self.energy) / scale,
            momentum: if self.conserves_momentum {
                (energy.momentum - self.momentum).norm() / momenta
            } else {
                f64::NAN
            },
            overlap: event_counts.deepest_overlap,
            invalid: event_counts.in_invalid_state as f64,
            seconds,
        }
    }
}
