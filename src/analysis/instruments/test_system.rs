//! Short simulations for the tests of instruments.

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::instrument::{Instrument, Setup};
use super::quantity::{Measured, Number};
use super::system::{Sample, SystemDescription};
use crate::Vector;
use crate::engine::event::Event;
use crate::engine::{Simulation, Until};
use crate::model::{DiameterDistribution, MassRule, Scene};
use crate::scene::{Arrangement, Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

/// Hard spheres of diameter, mass and temperature 1 in a periodic cube, starting from a crystal.
pub(super) fn hard_spheres(count: u64, packing_fraction: f64) -> (SystemDescription, Simulation) {
    start(
        SceneBuilder::new("fluid")
            .seed(5)
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(count).packing_fraction(packing_fraction))
            .temperature(1.0)
            .build()
            .unwrap(),
    )
}

/// Hard spheres with individual diameters at a temperature of 1.
pub(super) fn unlike_spheres(count: u64) -> (SystemDescription, Simulation) {
    let diameters = DiameterDistribution::Uniform { lower: 0.5, upper: 1.3 };
    start(
        SceneBuilder::new("fluid")
            .seed(5)
            .species(SpeciesDraft::new("A").mass(1.3).individual_diameters(MassRule::Volume).distributed(diameters))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .fill(Fill::new(Arrangement::Random, "A").count(count).packing_fraction(0.2))
            .temperature(1.0)
            .build()
            .unwrap(),
    )
}

pub(super) fn start(scene: Scene) -> (SystemDescription, Simulation) {
    (SystemDescription::of(&scene), Simulation::without_plan(scene))
}

pub(super) fn equilibrate(simulation: &mut Simulation, events_per_particle: u64) {
    let events = simulation.event_counts().physical() + events_per_particle * simulation.moving() as u64;
    simulation.advance(Until::events(events)).unwrap();
}

pub(super) fn instrument<I>(
    simulation: &Simulation,
    system: &SystemDescription,
    duration: f64,
    new: impl FnOnce(&Setup<'_>) -> I,
) -> I {
    let snapshot = simulation.snapshot();
    new(&Setup { system, sample: Sample::of(&snapshot), duration })
}

pub(super) fn sample<'a>(time: f64, positions: &'a [Vector], velocities: &'a [Vector]) -> Sample<'a> {
    Sample { time, positions, velocities, ..Sample::default() }
}

pub(super) fn measure(
    simulation: &mut Simulation,
    system: &SystemDescription,
    instrument: &mut dyn Instrument,
    duration: f64,
) {
    let end = simulation.time() + duration;
    loop {
        let time = instrument.next_sample().min(end);
        let has_events = instrument.has_events();
        let show = |event: &_| {
            if has_events {
                instrument.event(event, system);
            }
        };
        simulation.advance_with(Until::time(time), show).unwrap();
        instrument.sample(&Sample::of(&simulation.snapshot()), system);
        if time >= end {
            return;
        }
    }
}

/// Number of initial samples. The copy of a [`Recorded`] instrument is saved and restored after each of them.
const FIRST_SAMPLES: usize = 200;
/// Number of later samples between two saves of the copy. Saving and restoring takes much longer than a sample.
/// Instruments often do something at each power of two, so this number is odd.
const LATER_SAMPLES: usize = 17;

/// An instrument and a copy. After many samples, the copy is saved and restored.
pub(super) struct Recorded<I> {
    pub instrument: I,
    pub again: I,
    samples: usize,
}

impl<I: Instrument + Clone + Serialize + DeserializeOwned> Recorded<I> {
    pub fn new(instrument: I) -> Self {
        Self { again: instrument.clone(), instrument, samples: 0 }
    }
}

impl<I: Instrument + Serialize + DeserializeOwned> Instrument for Recorded<I> {
    fn next_sample(&self) -> f64 {
        self.instrument.next_sample()
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        self.instrument.sample(sample, system);
        self.again.sample(sample, system);
        self.samples += 1;
        if self.samples <= FIRST_SAMPLES || self.samples.is_multiple_of(LATER_SAMPLES) {
            self.again = serde_json::from_str(&serde_json::to_string(&self.again).unwrap()).unwrap();
        }
    }

    fn has_events(&self) -> bool {
        self.instrument.has_events()
    }

    fn event(&mut self, event: &Event, system: &SystemDescription) {
        self.instrument.event(event, system);
        self.again.event(event, system);
    }

    fn scaled(&mut self, before: &Sample<'_>, after: &Sample<'_>, system: &SystemDescription) {
        self.instrument.scaled(before, after, system);
        self.again.scaled(before, after, system);
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        self.again.report(system, measured);
    }
}

/// Returns the report of an instrument. Checks that all numbers are finite and that columns have equal lengths.
pub(super) fn report(instrument: &dyn Instrument, system: &SystemDescription) -> Measured {
    let mut measured = Measured::default();
    instrument.report(system, &mut measured);
    let numbers = measured.numbers.iter().flat_map(|number| [number.mean, number.standard_error]);
    let series = measured.curves.iter().flat_map(|curve| &curve.series);
    let values = series.flat_map(|series| series.values.iter().chain(&series.standard_errors).copied());
    assert!(numbers.chain(values).flatten().all(f64::is_finite), "only finite values are reported");
    for curve in &measured.curves {
        for series in &curve.series {
            assert_eq!(series.values.len(), curve.variables[0].values.len());
            assert_eq!(series.values.len(), series.standard_errors.len());
        }
    }
    measured
}

pub(super) fn number<'a>(measured: &'a Measured, name: &str) -> &'a Number {
    measured.number(name).unwrap()
}

pub(super) fn mean(measured: &Measured, name: &str) -> f64 {
    number(measured, name).mean.unwrap()
}

pub(super) fn estimate(measured: &Measured, name: &str) -> (f64, f64) {
    let number = number(measured, name);
    (number.mean.unwrap(), number.standard_error.unwrap())
}
