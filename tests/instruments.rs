//! Instruments defined outside of the crate.

use std::ops::ControlFlow;
use std::path::Path;

use carom::analysis::SamplingTimes;
use carom::analysis::instruments::{Curve, Instrument, InstrumentError, Measured, Number, Sample, SystemDescription};
use carom::analysis::statistics::{BlockAverage, Estimate};
use carom::engine::event::Event;
use carom::io::{Existing, Folder};
use carom::model::{RunPlan, Scene, Until};
use carom::run::{Ending, Finished, Progress, Run, Stage};
use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
use serde::{Deserialize, Serialize};

/// Averages speeds, adds up impulses, and ends the run after a number of events.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Probe {
    times: SamplingTimes,
    speed: BlockAverage,
    impulses: f64,
    events: u64,
    most: u64,
}

impl Probe {
    fn new(start: f64, most: u64) -> Self {
        let times = SamplingTimes::given(start, 0.05);
        Self { times, speed: BlockAverage::new(1.0), impulses: 0.0, events: 0, most }
    }
}

impl Instrument for Probe {
    fn next_sample(&self) -> f64 {
        self.times.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, _system: &SystemDescription) {
        self.speed.add(sample.velocities.iter().map(|velocity| velocity.norm()).sum(), 1.0);
        self.times.pass(sample.time);
    }

    fn has_events(&self) -> bool {
        true
    }

    fn event(&mut self, event: &Event, _system: &SystemDescription) {
        self.impulses += event.normal_impulse();
        self.events += 1;
    }

    fn is_done(&self) -> bool {
        self.events >= self.most
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        let exact = |mean: f64| Some(Estimate { mean, standard_error: None });
        measured.numbers.push(Number::estimated(
            "speed",
            "Speed",
            "length / time",
            self.speed.estimate(),
            "sum of |v|",
        ));
        measured.numbers.push(Number::estimated("impulses", "Impulses", "1", exact(self.impulses), "sum of all"));
        measured.numbers.push(Number::estimated("events", "Events", "1", exact(self.events as f64), "all"));
        let curve = Curve::new("masses", "Masses by number", "the masses of the particles")
            .variable("id", "1", vec![0.0, 1.0])
            .series("m", "mass", &[exact(system.masses[0]), exact(system.masses[1])]);
        measured.curves.push(curve);
    }
}

fn scene() -> Scene {
    SceneBuilder::new("probed")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.3))
        .temperature(1.0)
        .run(RunPlan { equilibration: Until::events(2_000), limit: Until::time(4.0), ..RunPlan::default() })
        .build()
        .unwrap()
}

fn probed(run: Run, most: u64) -> Run {
    run.instrument("probe", move |setup| Probe::new(setup.sample.time, most))
}

/// Runs the scene with output to a folder, until a number of events of a stage.
fn interrupted(folder: &Path, most: u64, (stage, events): (Stage, u64)) -> Finished {
    let scene = scene();
    let mut files = Folder::create(folder, &scene, Existing::Keep).unwrap();
    let finished = probed(Run::new(scene), most).execute(&mut files, &mut |progress: &Progress| {
        if progress.stage == stage && progress.events >= events {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    let finished = finished.unwrap();
    files.complete(&finished, "").unwrap();
    finished
}

fn go_on(_: &Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

#[test]
fn a_run_that_goes_on_has_the_results_of_one_that_was_never_interrupted() {
    let folder = tempfile::tempdir().unwrap();
    let whole = probed(Run::new(scene()), u64::MAX).finish().unwrap();
    assert_eq!(whole.ending, Ending::Time);
    assert_eq!(whole.measured.numbers[2].mean, Some(whole.measurement.event_counts.physical() as f64));
    for (k, at) in
        [(Stage::Equilibration, 100), (Stage::Measurement, 100), (Stage::Measurement, 600)].iter().enumerate()
    {
        let path = folder.path().join(k.to_string());
        let part = interrupted(&path, u64::MAX, *at);
        assert_eq!((part.ending, part.stage), (Ending::Interrupted, at.0));
        let (mut files, checkpoint) = Folder::resume(&path, None).unwrap();
        let finished = probed(Run::resume(checkpoint), u64::MAX).execute(&mut files, &mut go_on.clone()).unwrap();
        assert_eq!((finished.ending.clone(), &finished.measured), (Ending::Time, &whole.measured), "{at:?}");
        assert_eq!(finished.instrument::<Probe>("probe"), whole.instrument::<Probe>("probe"), "{at:?}");
        files.complete(&finished, "").unwrap();
        let text = std::fs::read_to_string(path.join("measurements.json")).unwrap();
        assert!(text.contains("\"impulses\"") && path.join("measurements/masses.csv").exists());
    }
}

#[test]
fn finished_run_returns_instruments_by_name_and_type() {
    let run = probed(Run::new(scene()), u64::MAX).instrument("other", |_| Other("kept".into()));
    let mut finished = run.finish().unwrap();
    let events = finished.measurement.event_counts.physical();
    assert_eq!(finished.instrument::<Probe>("probe").unwrap().events, events);
    assert_eq!(finished.instrument::<Other>("other").unwrap().0, "kept");
    assert!(finished.instrument::<Other>("probe").is_none() && finished.take_instrument::<Other>("probe").is_none());
    assert!(finished.instrument::<Probe>("nothing").is_none());
    let probe = finished.take_instrument::<Probe>("probe").unwrap();
    assert_eq!((probe.events, probe.speed.estimate()), (events, Some(measured_speed(&finished))));
    assert!(finished.take_instrument::<Probe>("probe").is_none() && finished.instrument::<Other>("other").is_some());

    let folder = tempfile::tempdir().unwrap();
    let early = interrupted(&folder.path().join("run"), u64::MAX, (Stage::Equilibration, 100));
    assert!(early.instrument::<Probe>("probe").is_none(), "its measurement has not begun");
}

fn measured_speed(finished: &Finished) -> Estimate {
    let speed = finished.measured.number("speed").unwrap();
    Estimate { mean: speed.mean.unwrap(), standard_error: speed.standard_error }
}

#[test]
fn resumed_instrument_is_restored_from_its_stored_state() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    interrupted(&path, 900, (Stage::Measurement, 300));
    let (_, checkpoint) = Folder::resume(&path, None).unwrap();
    // The limit of 900 events comes from the checkpoint, not from the argument 0.
    let finished = probed(Run::resume(checkpoint), 0).finish().unwrap();
    assert_eq!((finished.ending.clone(), finished.measurement.event_counts.physical()), (Ending::Condition, 900));
}

#[test]
fn a_run_does_not_go_on_with_other_instruments() {
    let folder = tempfile::tempdir().unwrap();
    for stage in [Stage::Equilibration, Stage::Measurement] {
        let path = folder.path().join(format!("{stage:?}"));
        interrupted(&path, u64::MAX, (stage, 100));
        let resumed = || Run::resume(Folder::resume(&path, None).unwrap().1);
        let error = resumed().finish().unwrap_err();
        assert!(matches!(&error, InstrumentError::NotRegistered { name } if name == "probe"));
        assert_eq!(
            error.to_string(),
            "the run began with the instrument `probe`, expected it to be registered before the run continues"
        );
        let more = probed(resumed(), 1).instrument("other", |setup| Probe::new(setup.sample.time, 1));
        let error = more.finish().unwrap_err();
        assert!(matches!(error, InstrumentError::NotInCheckpoint { name } if name == "other"));
    }
    let twice = probed(probed(Run::new(scene()), 1), 2).finish().unwrap_err();
    assert!(matches!(twice, InstrumentError::Duplicate { name } if name == "probe"));
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Other(String);

impl Instrument for Other {
    fn next_sample(&self) -> f64 {
        f64::INFINITY
    }

    fn sample(&mut self, _sample: &Sample<'_>, _system: &SystemDescription) {}

    fn report(&self, _system: &SystemDescription, _measured: &mut Measured) {}
}

#[test]
fn instrument_state_of_another_type_is_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    interrupted(&path, u64::MAX, (Stage::Measurement, 100));
    let (_, checkpoint) = Folder::resume(&path, None).unwrap();
    let error = Run::resume(checkpoint).instrument("probe", |_| Other(String::new())).finish().unwrap_err();
    assert!(matches!(error, InstrumentError::State { .. }), "{error}");
}

#[test]
fn instrument_ends_a_run_at_its_event_and_changes_no_bit() {
    let most = 777;
    let finished = probed(Run::new(scene()), most).finish().unwrap();
    assert_eq!((finished.ending.clone(), finished.measurement.event_counts.physical()), (Ending::Condition, most));
    assert!(finished.is_sound(), "{:?}", finished.audit.faults());
    let mut plain = scene().into_parts();
    plain.run.limit = Until::events(most);
    let plain = Run::new(Scene::new(plain).unwrap()).finish().unwrap();
    assert_eq!(finished.simulation.snapshot(), plain.simulation.snapshot());
}

#[test]
fn a_page_draws_what_an_instrument_has_measured() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let finished = interrupted(&path, 500, (Stage::Measurement, u64::MAX));
    assert_eq!(finished.ending, Ending::Condition);
    let page = carom::view::report::page(&path).unwrap().html;
    assert!(page.contains("Masses by number") && page.contains("the masses of the particles"));
    assert!(page.contains("Impulses") && page.contains("sum of |v|"));
}
