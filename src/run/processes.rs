//! Runs that are shared by several processes.

use std::sync::Arc;

use super::begin::Origin;
use super::{Run, RunState};
use crate::analysis::instruments::Registry;
use crate::engine::{Communicator, Simulation};

/// Number of bytes sent to other processes at once.
const PIECE: usize = 1 << 26;

impl Run {
    /// Shares the run between processes. Every process must have set up the same run with the same number of threads:
    /// see [`Simulation::set_communicator`].
    ///
    /// All processes obtain the same results as a single process, bit for bit. The recorder and the `watch` of the
    /// first process decide when to write a checkpoint and when to stop. Recorders of other processes need not record
    /// anything.
    pub fn communicator(mut self, communicator: Arc<dyn Communicator>) -> Self {
        self.simulation.set_communicator(communicator);
        self
    }

    /// Shares the run of the first process between all processes. Custom instruments are not sent.
    pub fn shared(run: Option<Self>, communicator: &Arc<dyn Communicator>) -> Option<Self> {
        let mut content = Vec::new();
        if let Some(run) = &run {
            content = postcard::to_stdvec(&(&run.simulation, &run.state, run.origin))
                .unwrap_or_else(|error| communicator.abort(&format!("the run cannot be sent: {error}")));
        }
        let mut received = Vec::new();
        let mut pieces = content.chunks(PIECE);
        loop {
            let piece = pieces.next().unwrap_or_default();
            let mut all = communicator.share(if communicator.rank() == 0 { piece.to_vec() } else { Vec::new() });
            let first = all.swap_remove(0);
            if first.is_empty() {
                break;
            }
            if communicator.rank() > 0 {
                received.extend(first);
            }
        }
        if communicator.rank() == 0 {
            return run.map(|run| run.communicator(communicator.clone()));
        }
        if received.is_empty() {
            return None;
        }
        let (simulation, state, origin): (Simulation, RunState, Origin) = postcard::from_bytes(&received)
            .unwrap_or_else(|error| {
                communicator.abort(&format!(
                    "the run sent by the first process cannot be read, perhaps because the programs differ: {error}"
                ))
            });
        simulation.enlarge();
        Some(Self { simulation, state, registry: Registry::default(), origin }.communicator(communicator.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::observables::Row;
    use crate::engine::Snapshot;
    use crate::engine::communicator::tests::in_processes;
    use crate::engine::event::Event;
    use crate::model::{Growth, GrowthTarget, OutputPlan, RunPlan, Scene, StagePlan, Thermostat, Until};
    use crate::run::{Ending, Recorder, Scalar, Stage};
    use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
    use std::convert::Infallible;
    use std::ops::ControlFlow;

    #[derive(Debug, Default, PartialEq)]
    struct All {
        rows: Vec<String>,
        frames: Vec<Snapshot>,
        events: Vec<Event>,
        checkpoints: usize,
    }

    impl Recorder for All {
        type Error = Infallible;

        fn row(&mut self, stage: Stage, row: &Row) -> Result<(), Infallible> {
            self.rows.push(format!("{stage:?} {row:?}"));
            Ok(())
        }

        fn frame(&mut self, snapshot: &Snapshot, _: Vec<Scalar>) -> Result<(), Infallible> {
            self.frames.push(snapshot.clone());
            Ok(())
        }

        fn has_events(&self) -> bool {
            true
        }

        fn event(&mut self, event: &Event) -> Result<(), Infallible> {
            self.events.push(*event);
            Ok(())
        }

        fn is_checkpoint_due(&self) -> bool {
            self.rows.len() % 3 == 1
        }

        fn checkpoint(&mut self, _: &Simulation, _: &RunState) -> Result<(), Infallible> {
            self.checkpoints += 1;
            Ok(())
        }
    }

    /// Spheres grow on one thread, and are then held at a temperature.
    fn scene() -> Scene {
        let growth = Growth { rate: 0.1, until: GrowthTarget::PackingFraction(0.4) };
        let grow = StagePlan { name: "growth".into(), growth: Some(growth), ..StagePlan::default() };
        let thermostat = Thermostat::Andersen { temperature: 1.3, rate: 0.1, axes: [true; 3] };
        SceneBuilder::new("fluid")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(500).packing_fraction(0.3))
            .temperature(1.0)
            .run(RunPlan {
                stages: vec![grow],
                equilibration: Until::events(5_000),
                limit: Until::events(20_000),
                thermostat: Some(thermostat),
                ..RunPlan::default()
            })
            .output(OutputPlan { thermo_interval: Some(0.05), frame_interval: Some(0.2), ..OutputPlan::default() })
            .build()
            .unwrap()
    }

    /// Runs the scene on several processes. The first process interrupts the run after `asked` calls of `watch`.
    fn run_in(processes: usize, asked: usize) -> (All, Vec<(Ending, Snapshot)>) {
        let mut results = in_processes(processes, |communicator| {
            let (mut all, mut left) = (All::default(), asked);
            let is_first = communicator.rank() == 0;
            let run = Run::shared(is_first.then(|| Run::new(scene())), &communicator).unwrap();
            let mut watch = |_: &_| {
                left -= 1;
                if left == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            let finished = if is_first {
                run.execute(&mut all, &mut watch)
            } else {
                run.execute(&mut (), &mut |_| ControlFlow::Continue(()))
            };
            let finished = finished.unwrap();
            assert_eq!(finished.simulation.processes(), processes);
            assert!(finished.simulation.domain_work().unwrap().windows > 20 || asked < usize::MAX);
            (all, (finished.ending, finished.simulation.snapshot()))
        });
        let (all, _) = &mut results[0];
        let all = std::mem::take(all);
        (all, results.into_iter().map(|(_, end)| end).collect())
    }

    #[test]
    fn run_output_is_the_same_on_several_processes() {
        let mut one = All::default();
        let finished = Run::new(scene()).execute(&mut one, &mut |_| ControlFlow::Continue(())).unwrap();
        let counts = [one.rows.len(), one.frames.len(), one.events.len(), one.checkpoints];
        assert!(counts.iter().zip([10, 2, 20_000, 2]).all(|(count, least)| *count >= least), "{counts:?}");
        for processes in [2, 3] {
            let (all, ends) = run_in(processes, usize::MAX);
            assert_eq!(all.rows, one.rows);
            assert!(all.frames == one.frames && all.events == one.events, "{processes}");
            for (ending, snapshot) in ends {
                assert_eq!(ending, Ending::Events);
                assert!(snapshot == finished.simulation.snapshot(), "{processes}");
            }
        }
    }

    #[test]
    fn interrupting_the_first_process_ends_all_processes() {
        for asked in [1, 7, 60] {
            let (_, ends) = run_in(2, asked);
            assert_eq!(ends[0].0, Ending::Interrupted);
            assert!(ends[0] == ends[1], "{asked}");
        }
    }

    #[test]
    fn no_process_has_a_run_if_the_first_has_none() {
        assert!(
            in_processes(3, |communicator| Run::shared(None, &communicator).is_none()).into_iter().all(|none| none)
        );
    }
}
