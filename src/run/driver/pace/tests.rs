use std::convert::Infallible;
use std::ops::ControlFlow;

use super::*;
use crate::analysis::instruments::Scalar;
use crate::analysis::observables::Row;
use crate::engine::{Simulation, Snapshot};
use crate::model::{OutputPlan, RunPlan, Scene};
use crate::run::checkpoint::{Checkpoint, Manifest};
use crate::run::{Recorder, Run, RunState, Stage};
use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

#[test]
fn durations_are_rounded_to_two_digits() {
    assert_eq!(rounded(123.4), 120.0);
    assert_eq!(rounded(0.000_678_9), 0.000_68);
}

/// Keeps the rows, the times of the frames, and the last checkpoint with the numbers of rows and frames before it.
#[derive(Default)]
struct Kept {
    rows: Vec<Row>,
    frames: Vec<f64>,
    checkpoint: Option<(Simulation, RunState, [usize; 2])>,
}

impl Recorder for Kept {
    type Error = Infallible;

    fn row(&mut self, _: Stage, row: &Row) -> Result<(), Infallible> {
        self.rows.push(row.clone());
        Ok(())
    }

    fn frame(&mut self, snapshot: &Snapshot, _: Vec<Scalar>) -> Result<(), Infallible> {
        self.frames.push(snapshot.time);
        Ok(())
    }

    fn checkpoint(&mut self, simulation: &Simulation, state: &RunState) -> Result<(), Infallible> {
        let counts = [self.rows.len(), self.frames.len()];
        self.checkpoint = Some((simulation.clone(), state.clone(), counts));
        Ok(())
    }
}

impl Kept {
    /// Continues a run, and interrupts it at call number `questions` of `watch`.
    fn go_on(&mut self, run: Run, mut questions: u32) {
        let mut watch = |_: &crate::run::Progress| {
            questions = questions.saturating_sub(1);
            if questions == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        run.execute(self, &mut watch).unwrap();
    }

    fn resume(&mut self) {
        let (simulation, state, [rows, frames]) = self.checkpoint.take().unwrap();
        self.rows.truncate(rows);
        self.frames.truncate(frames);
        let manifest = Manifest { scene: None, files: Vec::new() };
        self.go_on(Run::resume(Checkpoint { simulation, state, manifest }), u32::MAX);
    }

    fn measured(&self) -> (&SamplingTimes, &SamplingTimes) {
        let measurement = self.checkpoint.as_ref().unwrap().1.measurement.as_ref().unwrap();
        (&measurement.rows, &measurement.frames)
    }
}

fn fluid(packing_fraction: f64, events: u64, output: OutputPlan) -> Scene {
    SceneBuilder::new("fluid")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(packing_fraction))
        .temperature(1.0)
        .run(RunPlan { limit: Until::events(events), ..RunPlan::default() })
        .output(output)
        .build()
        .unwrap()
}

fn run(scene: Scene) -> Kept {
    let mut kept = Kept::default();
    kept.go_on(Run::without_start(scene), u32::MAX);
    kept
}

#[test]
fn pilot_run_does_not_change_the_output() {
    // In the dense fluid, the stage continues from the pilot run. In the dilute gas, the first row is due before the
    // first event. In the short runs, the first row and the first event are almost simultaneous.
    let few = [0.1, 0.2, 0.3, 0.4].into_iter().flat_map(|phi| [101, 201, 203, 399].map(|events| (phi, events)));
    for (packing_fraction, events) in [(0.4, 80_000), (1e-4, 10_000)].into_iter().chain(few) {
        let chosen = run(fluid(packing_fraction, events, OutputPlan::default()));
        let (rows, frames) = chosen.measured();
        let intervals = (Some(rows.interval()), Some(frames.interval()));
        for (thermo_interval, frame_interval) in [intervals, (intervals.0, None), (None, intervals.1)] {
            let output = OutputPlan { thermo_interval, frame_interval, ..OutputPlan::default() };
            let given = run(fluid(packing_fraction, events, output));
            assert_eq!(given.rows, chosen.rows, "{packing_fraction} {events}");
            assert_eq!(given.frames, chosen.frames, "{packing_fraction} {events}");
        }
    }
}

#[test]
fn a_pilot_run_that_is_interrupted_goes_on() {
    let scene = || fluid(0.4, 200_000, OutputPlan::default());
    let whole = run(scene());
    let mut interrupted = 0;
    for questions in 1..8 {
        let mut kept = Kept::default();
        kept.go_on(Run::new(scene()), questions);
        interrupted += u32::from(kept.checkpoint.as_ref().unwrap().1.pilot.is_some());
        kept.resume();
        assert!(kept.rows == whole.rows && kept.frames == whole.frames, "{questions}");
    }
    assert!(interrupted > 1, "{interrupted} in the pilot run");
}

#[test]
fn default_frames_take_at_most_200_megabytes() {
    let scene = |limit: Until, frame_interval: Option<f64>| {
        SceneBuilder::new("large")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108_000).packing_fraction(0.4))
            .temperature(1.0)
            .run(RunPlan { limit, ..RunPlan::default() })
            .output(OutputPlan { frame_interval, ..OutputPlan::default() })
            .build()
            .unwrap()
    };
    let mut text = Vec::new();
    let start = Simulation::without_plan(scene(Until::events(1), None));
    crate::io::Frames::of_simulation(&start).write_now(&mut text, &start).unwrap();
    let most = 200_000_000 / text.len();
    assert!((8..16).contains(&most), "{most}");
    for limit in [Until::events(2_000), Until::time(2e-3)] {
        let frames = run(scene(limit, None)).frames.len();
        // The initial lattice has fewer events per time than the fluid, so the duration of a run limited by events is
        // overestimated.
        let least = if limit.time.is_some() { most / 2 } else { 1 };
        assert!((least..=most).contains(&frames), "{frames} of {most}");
    }
    assert!(run(scene(Until::time(2e-3), Some(1e-4))).frames.len() > 20, "as often as the scene asks for");
}
