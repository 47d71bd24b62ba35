//! The bits of a run depend only on the scene, not on observers, names of particles or the start time.

use crate::fingerprints::fingerprint;
use crate::listed::{fluid, hard_sphere, listed, particles, well};
use carom::Vector;
use carom::engine::Simulation;
use carom::engine::event::{Event, EventKind};
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Face, Space};
use carom::model::{ContactLaw, OutputPlan, RunPlan, Scene, Thermostat, Until};
use carom::run;
use carom::scene::{
    Amount, Arrangement, Chain, Fill, InteractionDraft, Model, SceneBuilder, SpeciesDraft, Surface, SurfaceFill,
};
use std::ops::ControlFlow;

pub fn named(name: &str) -> Scene {
    if name == "everything" { everything() } else { Scene::from_file(format!("configs/{name}.toml")).unwrap() }
}

fn mixture(builder: SceneBuilder) -> SceneBuilder {
    let steps = Potential::stepped_lennard_jones(1.1, 1.0, 2.5, 5, 50.0).unwrap();
    builder
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(2.5).diameter(1.2))
        .species(SpeciesDraft::new("C").mass(0.5).diameter(0.8))
        .species(SpeciesDraft::new("S").diameter(1.0).fixed())
        .interaction(InteractionDraft::new(well()).between("A", "A").restitution(0.9))
        .interaction(InteractionDraft::new(steps).between("A", "B").restitution(0.9))
        .interaction(InteractionDraft::new(Potential::square_shoulder(1.2, 1.3, 0.4).unwrap()).between("B", "B"))
        .interaction(InteractionDraft::new(Potential::penetrable(0.9, 0.7).unwrap()).between("A", "C"))
        .interaction(InteractionDraft::new(Model::HardSphere).between("B", "C").restitution(0.5))
        .interaction(InteractionDraft::new(Model::HardSphere).between("C", "C").restitution(0.9))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "S").restitution(0.7))
        .interaction(
            InteractionDraft::new(Potential::square_well(1.1, 1.4, 0.5).unwrap()).between("B", "S").restitution(0.7),
        )
        .interaction(InteractionDraft::new(Model::HardSphere).between("C", "S"))
        .interaction(InteractionDraft::new(Potential::bond(0.8, 1.0).unwrap()).named("link").restitution(0.95))
}

pub fn everything() -> Scene {
    let floor = Boundary::Bounded { lower: Face::Wall(ContactLaw::smooth(0.8)), upper: Face::Open };
    let space = Space {
        lower: Vector::new(-5.0, -5.0, 0.0),
        size: Vector::new(10.0, 10.0, 20.0),
        boundary: [Boundary::Periodic, Boundary::walls(0.9), floor],
    };
    let fill = |species, count, lower: f64, upper: f64| {
        let region = (Vector::new(-4.9, -4.3, lower), Vector::new(4.9, 4.3, upper));
        Fill::new(Arrangement::Random, species).count(count).region(region.0, region.1)
    };
    let chain = Chain {
        species: "C".into(),
        length: 6,
        count: 3,
        bond: "link".into(),
        spacing: None,
        straight: None,
        temperature: None,
        speed: None,
    };
    let dish = SurfaceFill {
        name: None,
        species: "S".into(),
        shape: Surface::Plane { corner: Vector::new(-2.0, -2.0, 3.0), edges: [Vector::x() * 4.0, Vector::y() * 4.0] },
        spacing: None,
    };
    mixture(SceneBuilder::new("everything"))
        .space(space)
        .gravity(Vector::new(0.1, 0.0, -1.0))
        .contact_time(1e-3)
        .static_surface(dish)
        .fill(fill("A", 60, 5.0, 12.0))
        .fill(fill("B", 40, 12.5, 19.0))
        .chain(chain)
        .temperature(1.0)
        .build()
        .unwrap()
}

#[test]
fn where_a_simulation_pauses_changes_nothing() {
    for name in ["everything", "granular_cooling", "pendulum"] {
        let until = Until::events(10_000);
        let mut whole = Simulation::without_plan(named(name));
        whole.advance(until).unwrap();
        let (mut paused, mut seen, mut pauses) = (Simulation::without_plan(named(name)), 0_u64, 0_u64);
        let mut count = |_: &Event| {
            seen += 1;
            ControlFlow::Continue(())
        };
        while paused.advance_for_with(7, until, &mut count).unwrap().is_none() {
            assert!(paused.event_counts().physical() + paused.event_counts().transition <= 7 * (pauses + 1));
            let _ = (paused.snapshot(), paused.energy());
            pauses += 1;
        }
        assert_eq!(seen, 10_000);
        assert!(pauses > 10_000 / 7, "{name}");
        assert_eq!(fingerprint(&paused.snapshot()), fingerprint(&whole.snapshot()), "{name}");
    }
}

#[test]
fn observers_change_no_bit() {
    for name in ["everything", "granular_cooling", "pendulum"] {
        let plain = |until| {
            let mut simulation = Simulation::without_plan(named(name));
            simulation.advance(until).unwrap();
            simulation.snapshot()
        };
        let expected = plain(Until::events(10_000));
        let mut watched = Simulation::without_plan(named(name));
        let mut seen = 0_u64;
        for until in (1..=100).map(|part| Until::events(100 * part)) {
            watched.advance_with(until, |_| seen += 1).unwrap();
            let _ = (watched.snapshot(), watched.energy(), watched.deepest_overlap(), watched.real_overlaps());
        }
        assert_eq!(seen, 10_000);
        assert_eq!(fingerprint(&watched.snapshot()), fingerprint(&expected), "{name}");

        let mut parts = named(name).into_parts();
        parts.run = RunPlan { equilibration: Until::events(1_000), limit: Until::events(9_000), ..RunPlan::default() };
        parts.output = OutputPlan {
            thermo_interval: Some(expected.time / 300.0),
            frame_interval: Some(expected.time / 70.0),
            ..OutputPlan::default()
        };
        let finished = run::run(Scene::new(parts).unwrap(), &mut (), &mut |_| ControlFlow::Continue(())).unwrap();
        assert_eq!(fingerprint(&finished.simulation.snapshot()), fingerprint(&expected), "{name}");
    }
}

/// Few particles in a heat bath or a sheared box. The event queue is often empty before the end of an epoch.
fn driven(count: u64, is_sheared: bool, bath: Option<[bool; 3]>) -> Simulation {
    let fill = Fill::new(Arrangement::Random, "A").count(count);
    let mut builder = SceneBuilder::new("driven")
        .space(Space::periodic_cube(6.0))
        .species(SpeciesDraft::new("A").mass(1.7).diameter(1.0))
        .interaction(InteractionDraft::new(hard_sphere()).between("A", "A").restitution(if is_sheared {
            0.9
        } else {
            1.0
        }))
        .fill(fill)
        .temperature(1.0);
    if is_sheared {
        builder = builder.shear(0.3);
    }
    let mut simulation = Simulation::without_plan(builder.build().unwrap());
    let bath = bath.map(|axes| Thermostat::Andersen { temperature: 1.0, rate: 0.7, axes });
    simulation.set_thermostat(bath.as_ref(), 0).unwrap();
    simulation
}

#[test]
fn times_at_which_a_run_stops_change_nothing() {
    let all = Some([true; 3]);
    let systems =
        [(4, false, all), (10, false, all), (20, false, all), (4, true, None), (10, true, None), (30, true, None)];
    for (count, is_sheared, bath) in systems.into_iter().chain([(10, true, Some([false, true, true]))]) {
        let start = || driven(count, is_sheared, bath);
        let mut whole = start();
        whole.advance(Until::time(100.0)).unwrap();
        for interval in [0.0123, 0.1, 0.37, 1.9] {
            let mut stopped = start();
            let mut time = interval;
            while time < 100.0 {
                stopped.advance(Until::time(time)).unwrap();
                time += interval;
            }
            stopped.advance(Until::time(100.0)).unwrap();
            let ends = [&stopped, &whole].map(|end| (end.event_counts(), fingerprint(&end.snapshot())));
            assert_eq!(ends[0], ends[1], "{count} particles, sheared: {is_sheared}, bath: {bath:?}, every {interval}");
        }
    }
}

fn start(potential: &Potential, gravity: f64, order: &[usize], start_time: f64) -> Scene {
    let fluid = fluid(256, Amount::NumberDensity(0.6));
    let original = particles(&fluid);
    let shuffled: Vec<_> = order.iter().map(|&k| original[k]).collect();
    let mut space = fluid.space().clone();
    if gravity != 0.0 {
        space.lower.z -= 1.0;
        space.size.z += 2.0;
        space.boundary[2] = Boundary::walls(1.0);
    }
    let builder = listed(&space, potential, 1.0, &shuffled).gravity(Vector::new(0.0, 0.0, gravity));
    builder.start_time(start_time).build().unwrap()
}

#[test]
fn trajectory_does_not_depend_on_particle_numbers() {
    let orders: [Vec<usize>; 3] =
        [(0..256).collect(), (0..256).rev().collect(), (0..256).map(|k| k * 101 % 256).collect()];
    for (potential, gravity) in [(hard_sphere(), 0.0), (well(), 0.0), (hard_sphere(), -1.0), (well(), -1.0)] {
        let ends = orders.each_ref().map(|order| {
            let mut simulation = Simulation::without_plan(start(&potential, gravity, order, 0.0));
            simulation.advance(Until::time(10.0)).unwrap();
            let now = simulation.snapshot();
            let mut sorted = vec![(Vector::zeros(), Vector::zeros()); 256];
            for (at, &k) in order.iter().enumerate() {
                sorted[k] = (now.positions[at], now.velocities[at]);
            }
            (simulation.event_counts().physical(), sorted)
        });
        assert!(ends[0].0 > 5_000, "{}", ends[0].0);
        assert_eq!(ends[0], ends[1]);
        assert_eq!(ends[0], ends[2]);
    }
}

fn timeless(event: &Event) -> (EventKind, u32, Option<u32>, [u64; 4]) {
    let numbers = [event.impulse.x, event.normal.x, event.energy_step, event.dissipated].map(f64::to_bits);
    (event.kind, event.particle.0, event.partner().map(|partner| partner.0), numbers)
}

#[test]
fn start_time_does_not_change_the_run() {
    let order: Vec<usize> = (0..256).collect();
    let scene = |which: usize, start_time: f64| match which {
        0 => start(&hard_sphere(), 0.0, &order, start_time),
        1 => start(&well(), -1.0, &order, start_time),
        _ => {
            let mut parts = everything().into_parts();
            parts.start_time = start_time;
            Scene::new(parts).unwrap()
        }
    };
    for which in 0..3 {
        let run = |start_time: f64| {
            let mut simulation = Simulation::without_plan(scene(which, start_time));
            let mut events = Vec::new();
            simulation.advance_with(Until::events(20_000), |event| events.push(*event)).unwrap();
            (events, simulation.snapshot())
        };
        let ((events, end), (late_events, late_end)) = (run(0.0), run(1e12));
        assert!(events.iter().map(timeless).eq(late_events.iter().map(timeless)));
        assert_eq!((&end.positions, &end.velocities), (&late_end.positions, &late_end.velocities));
        // The start time plus the elapsed time is rounded once.
        for (event, late) in events.iter().zip(&late_events) {
            assert!((late.time - 1e12 - event.time).abs() <= 1e12 * f64::EPSILON);
        }
    }
}
