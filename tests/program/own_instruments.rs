//! Runs with a user-defined instrument.

use std::ops::ControlFlow;

use super::place::{FLUID, Place, contents, when_free};
use carom::analysis::instruments::{Instrument, Measured, Sample, SystemDescription};
use carom::io::{Existing, Folder, read_scene};
use carom::run::{Ending, Progress, Run, Stage};
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Probe;

impl Instrument for Probe {
    fn next_sample(&self) -> f64 {
        f64::INFINITY
    }

    fn sample(&mut self, _sample: &Sample<'_>, _system: &SystemDescription) {}

    fn report(&self, _system: &SystemDescription, _measured: &mut Measured) {}
}

#[test]
fn resuming_a_run_with_user_instruments_is_rejected_without_changes() {
    let place = Place::with(FLUID);
    let scene = || read_scene(place.path().join("scene.toml"), &[]).unwrap();
    for (stage, end) in [(Stage::Equilibration, &[][..]), (Stage::Measurement, &["--until-events", "5000"])] {
        let path = place.path().join(format!("{stage:?}"));
        let mut files = when_free(|| Folder::create(&path, &scene(), Existing::Keep));
        let watch = |progress: &Progress| {
            let is_there = progress.stage == stage && progress.events >= 100;
            if is_there { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let finished =
            Run::new(scene()).instrument("probe", |_| Probe).execute(&mut files, &mut watch.clone()).unwrap();
        assert_eq!(finished.ending, Ending::Interrupted);
        files.complete(&finished, "").unwrap();
        let before = contents(&path);
        place.refused(
            &[&["run", "--resume", path.to_str().unwrap()], end].concat(),
            &["the run began with the instrument `probe`", "continue with the program that started the run"],
        );
        assert!(contents(&path) == before, "{stage:?}");
        let (mut files, checkpoint) = when_free(|| Folder::resume(&path, None));
        let run = Run::resume(checkpoint).instrument("probe", |_| Probe);
        let finished = run.execute(&mut files, &mut |_: &Progress| ControlFlow::Continue(())).unwrap();
        assert_eq!(finished.ending, Ending::Events);
    }
}
