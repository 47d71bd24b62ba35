use serde::{Deserialize, Serialize};

use super::bins::Bins;
use super::histogram::Histogram;
use super::instrument::{Instrument, Setup};
use super::quantity::{Curve, Measured, Normalisation, Number, Published};
use super::system::{Sample, SystemDescription};
use crate::Vector;
use crate::analysis::statistics::{BlockAverage, Estimate};
use crate::engine::event::{Event, EventKind};
use crate::model::measurement_plan::{BINS, FreePaths as Plan};
use crate::physics::response::Outcome;

/// Number of flights per block. The error of the mean follows from the scatter of the blocks.
const BLOCK: u64 = 64;

/// Free paths and free times between the contacts of each particle.
///
/// A flight is the motion between two Core events. The length of the path is measured along all straight pieces between
/// other events. If momentum is conserved, lengths are relative to the centre of mass. Flights that are incomplete at
/// the start or the end are left out. Lengths are not measured if particles accelerate or the box is sheared.
///
/// If `n` flights of `N` particles end in a time `t`, the mean free time has the same relative error as `N t / n`. The
/// error of the mean free path follows in the same way from the total distance. The scatter of single flights would
/// give a poor estimate, because a long flight leaves less time for other flights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct FreePaths {
    /// One per particle.
    flights: Vec<Flight>,
    /// Statistics of the times and, if measured, of the lengths of finished flights.
    ended_flights: Vec<EndedFlights>,
    /// Velocity of the centre of mass, if it is conserved.
    drift: Vector,
    /// Time of the last event or scaling, sum of all speeds, and number of flights that ended in the current block.
    now: f64,
    speeds: f64,
    ended: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Flight {
    /// Time of the last Core event; `None` before the first Core event.
    begin: Option<f64>,
    /// Time of the last event of any kind, and length of the path from the last Core event to this event.
    turned: f64,
    path: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct EndedFlights {
    histogram: Histogram,
    /// In each block, the time or distance flown by all particles, divided by the number of finished flights. `flown`
    /// is the time or distance in the current block.
    per_flight: BlockAverage,
    flown: f64,
}

impl EndedFlights {
    fn new(bins: usize) -> Self {
        Self { histogram: Histogram::new(bins), per_flight: BlockAverage::new(1.0), flown: 0.0 }
    }

    fn close_block(&mut self, ended: u64) {
        self.per_flight.add(self.flown / ended as f64, 1.0);
        self.flown = 0.0;
    }

    fn estimate(&self) -> Option<Estimate> {
        let mean = self.histogram.mean()?;
        let relative = self.per_flight.estimate().and_then(|all| Some(all.standard_error? / all.mean));
        Some(Estimate { mean, standard_error: relative.map(|error| error * mean) })
    }
}

impl FreePaths {
    pub fn new(plan: &Plan, setup: &Setup<'_>) -> Self {
        let bins = Bins::planned(plan.bins, BINS);
        let flight = Flight { begin: None, turned: setup.sample.time, path: 0.0 };
        let drift = setup.system.drift(setup.sample.velocities);
        let has_paths = !setup.system.is_accelerated && setup.system.shear_rate == 0.0;
        Self {
            flights: vec![flight; setup.system.masses.len()],
            ended_flights: vec![EndedFlights::new(bins); if has_paths { 2 } else { 1 }],
            drift,
            now: setup.sample.time,
            speeds: speeds(&setup.sample, &drift, setup.system),
            ended: 0,
        }
    }

    fn fly(&mut self, time: f64, system: &SystemDescription) {
        let duration = (time - self.now).max(0.0);
        let flown = [system.moving.len() as f64 * duration, self.speeds * duration];
        self.ended_flights.iter_mut().zip(flown).for_each(|(flights, flown)| flights.flown += flown);
        self.now = time;
    }

    fn turn(&mut self, id: u32, time: f64, speed: f64, is_core: bool) {
        let Some(flight) = self.flights.get_mut(id as usize) else { return };
        flight.path += speed * (time - flight.turned).max(0.0);
        flight.turned = time;
        if !is_core {
            return;
        }
        if let Some(begin) = flight.begin {
            let lengths = [(time - begin).max(0.0), flight.path];
            self.ended_flights.iter_mut().zip(lengths).for_each(|(flights, length)| flights.histogram.add(length));
        }
        (flight.begin, flight.path) = (Some(time), 0.0);
    }
}

impl Instrument for FreePaths {
    fn next_sample(&self) -> f64 {
        f64::INFINITY
    }

    fn sample(&mut self, _: &Sample<'_>, _: &SystemDescription) {}

    fn has_events(&self) -> bool {
        true
    }

    fn scaled(&mut self, before: &Sample<'_>, after: &Sample<'_>, system: &SystemDescription) {
        self.fly(before.time, system);
        self.speeds = speeds(after, &self.drift, system);
        for &id in &system.moving {
            self.turn(id, before.time, (before.velocities[id as usize] - self.drift).norm(), false);
        }
    }

    fn event(&mut self, event: &Event, system: &SystemDescription) {
        let is_core = event.kind == EventKind::Pair(Outcome::Core);
        self.fly(event.time, system);
        let velocities = event.before.iter().zip(&event.after);
        for (id, (before, after)) in [Some(event.particle), event.partner()].into_iter().zip(velocities) {
            if let Some(id) = id.filter(|id| system.masses.get(id.0 as usize).is_some_and(|mass| mass.is_finite())) {
                let speed = (before - self.drift).norm();
                self.turn(id.0, event.time, speed, is_core);
                self.speeds += (after - self.drift).norm() - speed;
                self.ended += u64::from(is_core);
            }
        }
        if self.ended >= BLOCK {
            self.ended_flights.iter_mut().for_each(|flights| flights.close_block(self.ended));
            self.ended = 0;
        }
    }

    fn report(&self, _: &SystemDescription, measured: &mut Measured) {
        let ended_flights = self.ended_flights.iter().map(Some).chain([None]);
        let kinds = [("time", ["t", "time"], TIME), ("path", ["l", "length"], PATH)];
        for ((name, of, method), flights) in kinds.into_iter().zip(ended_flights) {
            let (mean, title) = (flights.and_then(EndedFlights::estimate), format!("Mean free {name}"));
            measured.numbers.push(Number::estimated(&format!("mean_free_{name}"), &title, of[1], mean, method));
            measured.curves.extend(flights.map(|flights| curve(name, of, flights, method)));
        }
    }
}

fn speeds(sample: &Sample<'_>, drift: &Vector, system: &SystemDescription) -> f64 {
    system.moving.iter().map(|&id| (sample.velocities[id as usize] - drift).norm()).sum()
}

fn curve(name: &str, [variable, unit]: [&str; 2], ended: &EndedFlights, method: &str) -> Curve {
    let (width, densities) = ended.histogram.density();
    let centres: Vec<f64> = Bins::of_width(0.0, width, densities.len()).centres();
    let flights = ended.histogram.count as f64;
    let mean = ended.histogram.mean().filter(|mean| *mean > 0.0);
    let exponential = |mean: f64| Published {
        label: "exponential distribution with the same mean".to_owned(),
        source: EXPONENTIAL.to_owned(),
        y: centres.iter().map(|x| libm::exp(-x / mean) / mean).collect(),
        x: centres.clone(),
    };
    let published = mean.map(exponential);
    let method = format!(
        "{method} The bins end at eight times the mean of the first flights. Errors are computed as for independent flights."
    );
    Curve::new(&format!("free_{name}s"), &format!("Distribution of free {name}s"), &method)
        .variable(variable, unit, centres)
        .series(&format!("p({variable})"), &format!("1 / {unit}"), &densities)
        .normalised(Normalisation::of("flights in the bin").by("flights", "1", flights).by("bin_width", unit, width))
        .logarithmic([false, true])
        .beside(published)
}

const TIME: &str = "Time between two successive Core events of a particle.";
const PATH: &str = "Length of the path between two successive Core events of a particle, relative to the centre of mass if momentum is conserved. Not \
     measured if particles accelerate or the box is sheared.";
const EXPONENTIAL: &str = "Exact if all particles collided at the same constant rate. In a dilute gas, fast particles collide more \
    often than slow ones, so the longest times are more frequent: Visco, van Wijland and Trizac, Phys. Rev. E 77, 041117 (2008), \
    doi:10.1103/PhysRevE.77.041117";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;
    use crate::analysis::instruments::test_system::{
        Recorded, equilibrate, estimate, hard_spheres, instrument, measure, number, report, start,
    };
    use crate::analysis::published::HardSphereFluid;
    use crate::engine::Simulation;
    use crate::model::measurement_plan as plan;
    use crate::model::space::{Boundary, Space};
    use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

    fn free_paths(simulation: &Simulation, system: &SystemDescription) -> FreePaths {
        instrument(simulation, system, 1.0, |setup| FreePaths::new(&plan::FreePaths { bins: Some(40) }, setup))
    }

    #[test]
    fn free_times_are_the_inverse_of_the_collision_rate() {
        let (system, mut simulation) = hard_spheres(256, 0.05);
        equilibrate(&mut simulation, 50);
        let mut instrument = free_paths(&simulation, &system);
        let core = simulation.event_counts().core;
        measure(&mut simulation, &system, &mut instrument, 100.0);
        let measured = report(&instrument, &system);
        let (time, error) = estimate(&measured, "mean_free_time");
        let rate = 2.0 * (simulation.event_counts().core - core) as f64 / (256.0 * 100.0);
        // Each particle has about 80 flights. The mean may be too small by 1/80, because unfinished flights are long.
        assert!((time * rate - 1.0).abs() < 4.0 * error * rate + 1.0 / 80.0, "{time} {error} {rate}");
        let fluid = HardSphereFluid::reduced(0.05);
        assert!((time * fluid.collision_rate() - 1.0).abs() < 4.0 * error / time + 1.0 / 80.0);
        let (path, error) = estimate(&measured, "mean_free_path");
        assert!((path / fluid.mean_free_path() - 1.0).abs() < 4.0 * error / path + 1.0 / 80.0, "{path} {error}");
        let curve = &measured.curves[1];
        let width = curve.variables[0].values[1] - curve.variables[0].values[0];
        let sum: f64 = curve.series[0].values.iter().flatten().map(|p| p * width).sum();
        // In an exponential distribution, the fraction beyond eight means is exp(-8) = 3e-4.
        assert!(sum <= 1.0 && sum > 0.997, "{sum}");
        assert_eq!(curve.published[0].x.len(), 40);
    }

    #[test]
    fn a_path_goes_on_past_walls_and_falling_particles_have_none() {
        let walls = Space { boundary: [Boundary::walls(1.0), Boundary::Flat, Boundary::Flat], ..line() };
        let scene = |gravity: f64| {
            SceneBuilder::new("line")
                .space(walls.clone())
                .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
                .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
                .gravity(Vector::new(gravity, 0.0, 0.0))
                .particle("A", Vector::new(3.0, 0.0, 0.0), Vector::new(1.0, 0.0, 0.0))
                .particle("A", Vector::new(7.0, 0.0, 0.0), Vector::new(-1.0, 0.0, 0.0))
                .build()
                .unwrap()
        };
        let measured = |gravity: f64| {
            let (system, mut simulation) = start(scene(gravity));
            let mut instrument = free_paths(&simulation, &system);
            measure(&mut simulation, &system, &mut instrument, 20.0);
            report(&instrument, &system)
        };
        // The particles meet at x = 5 every 8 time units. In between, each particle travels 4 to a wall and 4 back.
        let still = measured(0.0);
        assert_eq!(number(&still, "mean_free_path").mean, Some(8.0));
        assert_eq!(number(&still, "mean_free_time").mean, Some(8.0));
        let falling = measured(-0.01);
        assert!(number(&falling, "mean_free_time").mean.is_some());
        assert_eq!(number(&falling, "mean_free_path").mean, None);
        assert_eq!(falling.curves.len(), 1);
    }

    #[test]
    fn paths_are_relative_to_the_centre_of_mass() {
        let measured = |drift: f64| {
            let flat = Space { boundary: [Boundary::Periodic, Boundary::Flat, Boundary::Flat], ..line() };
            let scene = SceneBuilder::new("line")
                .space(flat)
                .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
                .species(SpeciesDraft::new("B").mass(3.0).diameter(1.0))
                .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
                .interaction(InteractionDraft::new(Model::HardSphere).between("A", "B"))
                .interaction(InteractionDraft::new(Model::HardSphere).between("B", "B"))
                .particle("A", Vector::new(2.0, 0.0, 0.0), Vector::new(1.5 + drift, 0.0, 0.0))
                .particle("B", Vector::new(7.0, 0.0, 0.0), Vector::new(-0.5 + drift, 0.0, 0.0));
            let (system, mut simulation) = start(scene.build().unwrap());
            let mut instrument = free_paths(&simulation, &system);
            measure(&mut simulation, &system, &mut instrument, 50.0);
            let measured = report(&instrument, &system);
            number(&measured, "mean_free_path").mean.unwrap()
        };
        // Between two collisions, A travels 6 and B travels 2, so the mean free path is 4.
        for drift in [0.0, 5.0] {
            assert!((measured(drift) - 4.0).abs() < 1e-10, "{drift} {}", measured(drift));
        }
    }

    #[test]
    fn scaling_the_velocities_on_the_way_changes_times_and_no_path() {
        let walls = Space { boundary: [Boundary::walls(1.0), Boundary::Flat, Boundary::Flat], ..line() };
        let scene = SceneBuilder::new("line")
            .space(walls)
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .particle("A", Vector::new(3.0, 0.0, 0.0), Vector::new(1.0, 0.0, 0.0))
            .particle("A", Vector::new(7.0, 0.0, 0.0), Vector::new(-1.0, 0.0, 0.0));
        let (system, mut simulation) = start(scene.build().unwrap());
        let mut instrument = free_paths(&simulation, &system);
        // When the speed doubles at t = 4.5, the particles have travelled 3 of the 8 units to the next collision.
        measure(&mut simulation, &system, &mut instrument, 4.5);
        let before = simulation.snapshot();
        simulation.scale_velocities(2.0, &Vector::zeros());
        let after = simulation.snapshot();
        instrument.scaled(&Sample::of(&before), &Sample::of(&after), &system);
        measure(&mut simulation, &system, &mut instrument, 3.0);
        let measured = report(&instrument, &system);
        assert_eq!(number(&measured, "mean_free_path").mean, Some(8.0));
        assert_eq!(number(&measured, "mean_free_time").mean, Some(5.5));
    }

    #[test]
    fn restored_free_paths_continue_bitwise() {
        let (system, mut simulation) = hard_spheres(108, 0.3);
        let mut both = Recorded::new(free_paths(&simulation, &system));
        for _ in 0..4 {
            measure(&mut simulation, &system, &mut both, 1.0);
        }
        assert!(number(&report(&both, &system), "mean_free_path").standard_error.is_some());
        assert_eq!(both.again, both.instrument);
    }

    fn line() -> Space {
        Space { size: Vector::new(10.0, 0.0, 0.0), ..Space::periodic_cube(10.0) }
    }
}
