//! Runs at constant pressure: chains keep their bonds, pauses change nothing, and stages start with the last volume.

use carom::Vector;
use carom::engine::Snapshot;
use carom::model::potential::Potential;
use carom::model::space::{Space, minimum_image};
use carom::model::{Barostat, OutputPlan, RunPlan, Scene, StagePlan, Until};
use carom::run::Run;
use carom::scene::{Chain, Fill, InteractionDraft, Lattice, SceneBuilder, SpeciesDraft};

use crate::pauses::finished_with_pauses;

use super::{TEMPERATURE, bath, hard, observable, plan, space};

fn chains() -> SceneBuilder {
    let chain = |straight| Chain {
        species: "A".to_owned(),
        length: 12,
        count: 1,
        bond: "link".to_owned(),
        spacing: Some(1.1),
        straight: Some(straight),
        temperature: Some(1.0),
        speed: None,
    };
    let well = Potential::square_well(1.0, 1.4, 0.3).unwrap();
    let mut scene = SceneBuilder::new("chains")
        .space(Space { size: Vector::new(9.0, 7.0, 0.0), ..space(9.0, 2) })
        .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(well).between("A", "A"))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "B"))
        .interaction(InteractionDraft::new(hard(1.0)).between("B", "B"))
        .interaction(InteractionDraft::new(Potential::bond(1.0, 1.2).unwrap()).named("link"));
    scene.insert_chain(chain((Vector::new(6.2, 1.0, 0.0), Vector::new(1.0, 0.35, 0.0))));
    for y in 0..3 {
        scene.insert_particle("B", Vector::new(1.3 + f64::from(y), 0.6, 0.0), Vector::new(0.3, -0.2, 0.0));
    }
    scene
}

#[test]
fn chains_longer_than_the_box_keep_their_bonds() {
    let scene = chains().run(plan(0.2, 0.3, 0.2, 300)).build().unwrap();
    let (mut run, mut volumes) = (Run::new(scene), Vec::new());
    for step in 1..=60 {
        run = run.advance(Until::time(1.6 * f64::from(step)), &mut ()).unwrap().0;
        let simulation = run.simulation();
        assert_eq!(simulation.real_overlaps(), []);
        let (snapshot, space) = (simulation.snapshot(), simulation.scene().space());
        assert_eq!(snapshot.size, space.size);
        assert!((snapshot.size.y / snapshot.size.x - 7.0 / 9.0).abs() < 1e-12);
        volumes.push(simulation.volume());
        for bond in simulation.scene().bonds() {
            let [a, b] = bond.pair.map(|id| snapshot.positions[id.0 as usize]);
            let length = minimum_image(a - b, &space.periods()).norm();
            assert!((1.0 - 1e-12..1.2 + 1e-12).contains(&length), "{length}");
        }
    }
    let (least, most) = volumes.iter().fold((f64::MAX, 0.0_f64), |(a, b), volume| (a.min(*volume), b.max(*volume)));
    assert!(least < 0.8 * most, "{least} {most}");
}

/// Returns the final state and the results of a run.
fn end(scene: &Scene, threads: usize, pause: Option<u64>) -> (Snapshot, String) {
    let finished = finished_with_pauses(scene, threads, pause);
    (finished.simulation.snapshot(), format!("{:?} {:?}", finished.observables, finished.volume_moves))
}

#[test]
fn pauses_and_threads_do_not_change_an_isobaric_run() {
    let barostat = Barostat { pressure: 2.0, interval: 0.1, amplitude: None };
    let stage = StagePlan {
        name: "press".to_owned(),
        limit: Until::time(6.0),
        thermostat: bath(2.0),
        barostat: Some(barostat),
        ..StagePlan::default()
    };
    let plan = RunPlan {
        stages: vec![stage],
        equilibration: Until::time(1.0),
        limit: Until::time(3.0),
        thermostat: bath(1.0),
        barostat: Some(Barostat { interval: 0.07, ..barostat }),
        ..RunPlan::default()
    };
    let output = OutputPlan { thermo_interval: Some(0.25), frame_interval: Some(1.0), ..OutputPlan::default() };
    let scene = SceneBuilder::new("bits")
        .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
        .interaction(InteractionDraft::new(Potential::square_well(1.0, 1.5, 0.5).unwrap()).between("A", "A"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(500).packing_fraction(0.3))
        .temperature(1.0)
        .run(plan)
        .output(output)
        .build()
        .unwrap();
    let whole = end(&scene, 1, None);
    assert_eq!(end(&scene, 1, Some(2_345)), whole);
    assert_eq!(end(&scene, 2, Some(10_001)), whole);
}

#[test]
fn run_starts_at_the_volume_left_by_the_stage_before() {
    let stage = StagePlan {
        name: "press".to_owned(),
        limit: Until::time(60.0),
        thermostat: bath(2.0),
        barostat: Some(Barostat { pressure: 5.0, interval: 0.02, amplitude: Some(0.02) }),
        ..StagePlan::default()
    };
    let plan = RunPlan { stages: vec![stage], limit: Until::time(100.0), ..RunPlan::default() };
    let scene = SceneBuilder::new("pressed")
        .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.2))
        .temperature(TEMPERATURE)
        .run(plan)
        .build()
        .unwrap();
    let finished = Run::new(scene.clone()).finish().unwrap();
    assert!(finished.volume_moves.is_none() && finished.observable("volume").is_none());
    let volume = finished.simulation.volume();
    assert!(volume < 0.8 * scene.space().volume());
    // The pressure is `Z N T / V` with the current volume, not the initial one.
    let (pressure, _) = observable(&finished, "pressure");
    let (factor, _) = observable(&finished, "compressibility_factor");
    let (temperature, _) = observable(&finished, "temperature");
    assert!((pressure * volume / (108.0 * temperature) / factor - 1.0).abs() < 1e-9);
    assert!((pressure / 5.0 - 1.0).abs() < 0.25, "{pressure}");
}
