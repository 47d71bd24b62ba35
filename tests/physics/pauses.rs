//! Runs that pause and continue.

use carom::model::{Scene, Until};
use carom::run::{Finished, Run};

/// Runs a scene to its end. With `pause`, the run pauses after every `pause` events.
pub fn finished_with_pauses(scene: &Scene, threads: usize, pause: Option<u64>) -> Finished {
    let mut run = Run::new(scene.clone()).threads(threads);
    let mut events = 0;
    while let Some(step) = pause {
        events += step;
        let (paused, ending) = run.advance(Until::events(events), &mut ()).unwrap();
        run = paused;
        if ending.is_some() {
            break;
        }
    }
    run.finish().unwrap()
}
