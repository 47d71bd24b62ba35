//! A run with reversed velocities returns to its start, unless chaos amplifies round-off too much.

use crate::listed::{State, fluid, hard_sphere, listed, particles, states, well};
use carom::Vector;
use carom::engine::{Simulation, Until};
use carom::model::potential::Potential;
use carom::model::space::{Space, minimum_image};
use carom::scene::Amount;

struct Fluid {
    space: Space,
    potential: Potential,
}

impl Fluid {
    fn run(&self, start: &[State], until: Until) -> Simulation {
        let mut simulation = Simulation::without_plan(
            listed(&self.space, &self.potential, 1.0, start)
                // At the reversal, round-off may leave a small overlap.
                .allow_invalid_start(true)
                .build()
                .unwrap(),
        );
        simulation.advance(until).unwrap();
        simulation
    }

    fn largest(&self, a: &[State], b: &[State]) -> f64 {
        let apart = |(a, b): (&State, &State)| minimum_image(a.0 - b.0, &self.space.periods()).amax();
        a.iter().zip(b).map(apart).fold(0.0, f64::max)
    }
}

/// A run to a later time, and a second run back to the start with reversed velocities.
struct Retraced {
    events: u64,
    events_back: u64,
    /// Largest difference between the coordinates at the start and at the end of the second run.
    error: f64,
    /// Growth of small shifts of all coordinates during the second run.
    amplification: f64,
}

fn there_and_back(fluid: &Fluid, start: &[State], time: f64) -> Retraced {
    let there = fluid.run(start, Until::time(time));
    let turned: Vec<State> = states(&there.snapshot()).iter().map(|(r, v)| (*r, -v)).collect();
    let back = fluid.run(&turned, Until::time(time));
    let end = states(&back.snapshot());
    let shift = 1e-10;
    // The signs must be unrelated to the motion.
    let sign = |k: usize| if (k * k % 7).is_multiple_of(2) { shift } else { -shift };
    let shifted: Vec<State> = turned
        .iter()
        .enumerate()
        .map(|(k, (r, v))| (r + Vector::new(sign(3 * k), sign(3 * k + 1), sign(3 * k + 2)), *v))
        .collect();
    let shifted_end = states(&fluid.run(&shifted, Until::time(time)).snapshot());
    Retraced {
        events: there.event_counts().physical(),
        events_back: back.event_counts().physical(),
        error: fluid.largest(&end, start),
        amplification: fluid.largest(&shifted_end, &end) / shift,
    }
}

fn warm(density: f64, potential: Potential) -> (Fluid, Vec<State>) {
    let scene = fluid(108, Amount::NumberDensity(density));
    let fluid = Fluid { space: scene.space().clone(), potential };
    let warm = fluid.run(&particles(&scene), Until::time(2.0 / density));
    let start = states(&warm.snapshot());
    (fluid, start)
}

#[test]
fn reversed_velocities_retrace_the_run() {
    for (name, density, potential) in [
        ("dilute hard spheres", 0.05, hard_sphere()),
        ("hard spheres", 0.7, hard_sphere()),
        ("square wells", 0.7, well()),
    ] {
        let (fluid, start) = warm(density, potential);
        println!("{name}:     events   back   loss of memory   amplification");
        for doubling in 0..8 {
            let time = 0.02 / density * f64::from(1 << doubling);
            let Retraced { events, events_back, error, amplification } = there_and_back(&fluid, &start, time);
            println!("{name}: {events:10} {events_back:6}   {error:14.1e}   {amplification:13.1e}");
            // Each event adds a round-off error of about ten units in the last place of the box length. Chaos
            // multiplies the errors by `amplification`. The factor is known only for small shifts.
            let rounded = 10.0 * fluid.space.size.x * f64::EPSILON * (events + 1) as f64;
            if amplification < 1e5 {
                assert_eq!(events, events_back);
                assert!(error < amplification.max(1.0) * rounded, "{error:e} after {events} events");
            }
        }
    }
}
