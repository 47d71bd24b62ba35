use super::*;
use crate::engine::Until;
use crate::engine::event::Event;
use crate::model::space::{Space, minimum_image};
use crate::model::{Growth, GrowthTarget, Potential};
use crate::scene::{Chain, Fill, InteractionDraft, Lattice, SceneBuilder, SpeciesDraft};
use proptest::prelude::*;

/// Number of events to compare. It is small, because each event multiplies rounding errors by about ten.
const COMPARED: u64 = 30;

fn fluid(potential: Potential, restitution: f64) -> SceneBuilder {
    SceneBuilder::new("set")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(potential).between("A", "A").restitution(restitution))
}

fn hard() -> Potential {
    Potential::hard_sphere(1.0).unwrap()
}

fn well() -> Potential {
    Potential::square_well(1.0, 1.5, 1.0).unwrap()
}

fn scene(which: usize, seed: u64) -> Scene {
    let fill = |builder: SceneBuilder, density: f64| {
        builder
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(density))
            .temperature(1.0)
            .seed(seed)
    };
    let in_walls = |builder: SceneBuilder| {
        let space = Space {
            boundary: [Boundary::Periodic, Boundary::Periodic, Boundary::walls(1.0)],
            ..Space::periodic_cube(8.0)
        };
        fill_region(builder.space(space), seed)
    };
    let builder = match which {
        0 => fill(fluid(hard(), 1.0), 0.1),
        1 => fill(fluid(hard(), 1.0), 0.45),
        2 => fill(fluid(well(), 1.0), 0.2),
        3 => in_walls(fluid(hard(), 0.9).gravity(Vector::new(0.0, 0.0, -1.0))),
        4 => in_walls(fluid(well(), 1.0).gravity(Vector::new(0.1, 0.0, -1.0))),
        5 => fill(fluid(hard(), 0.8).shear(0.5), 0.1),
        _ => fluid(hard(), 1.0)
            .interaction(InteractionDraft::new(Potential::bond(1.0, 1.4).unwrap()).named("rope"))
            .space(Space::periodic_cube(12.0))
            .chain(Chain {
                species: "A".into(),
                length: 8,
                count: 6,
                bond: "rope".into(),
                spacing: None,
                straight: None,
                temperature: Some(1.0),
                speed: None,
            })
            .seed(seed),
    };
    builder.build().unwrap()
}

fn fill_region(builder: SceneBuilder, seed: u64) -> SceneBuilder {
    let fill = crate::scene::Fill::new(Lattice::SimpleCubic, "A")
        .count(64)
        .region(Vector::new(0.0, 0.0, 0.6), Vector::new(8.0, 8.0, 7.4));
    builder.fill(fill).temperature(1.0).seed(seed)
}

fn next_events(simulation: &mut Simulation, count: u64) -> Vec<Event> {
    let mut events = Vec::new();
    let until = Until::events(simulation.event_counts().physical() + count);
    simulation.advance_with(until, |event| events.push(*event)).unwrap();
    events
}

fn assert_same(ours: &[Event], theirs: &[Event], name: &str) {
    assert_eq!(ours.len(), theirs.len(), "{name}");
    for (k, (a, b)) in ours.iter().zip(theirs).enumerate() {
        let pair = |event: &Event| {
            let partner = event.partner().unwrap_or(event.particle);
            (event.kind, event.particle.min(partner), event.particle.max(partner))
        };
        assert_eq!(pair(a), pair(b), "{name}, event {k}");
        assert!((a.time - b.time).abs() < 1e-8, "{name}, event {k}: {} {}", a.time, b.time);
    }
}

fn balance(simulation: &Simulation) -> f64 {
    let (energy, event_counts) = (simulation.energy(), simulation.event_counts());
    energy.kinetic + energy.potential + event_counts.dissipated.total() - event_counts.supplied.total()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn resetting_the_current_state_does_not_change_later_events(seed in 1_u64..1_000, before in 0_u64..600) {
        for which in 0..7 {
            let mut simulation = Simulation::new(scene(which, seed)).unwrap();
            next_events(&mut simulation, before);
            let snapshot = simulation.snapshot();
            let captured = simulation.captured_pairs();
            for states in [PairStates::Keep, PairStates::FromDistances] {
                let mut again = simulation.clone();
                again.set_velocities(&snapshot.velocities).unwrap();
                again.set_positions(&snapshot.positions, states).unwrap();
                assert_eq!(again.captured_pairs(), captured, "scene {which}, {states:?}");
                assert_eq!(again.snapshot().velocities, snapshot.velocities);
                for (position, expected) in again.snapshot().positions.iter().zip(&snapshot.positions) {
                    let apart = minimum_image(position - expected, &simulation.scene().space().periods());
                    assert!(apart.norm() < 1e-14, "scene {which}: {position} {expected}");
                }
                let name = format!("scene {which}, seed {seed}, {states:?}");
                assert_same(&next_events(&mut again, COMPARED), &next_events(&mut simulation.clone(), COMPARED), &name);
            }
            let mut parts = scene(which, seed).into_parts();
            (parts.start_time, parts.displacement) = (snapshot.time, snapshot.displacement);
            parts.allow_invalid_start = true;
            for (particle, (position, velocity)) in
                parts.particles.iter_mut().zip(snapshot.positions.iter().zip(&snapshot.velocities))
            {
                (particle.position, particle.velocity) = (*position, *velocity);
            }
            let mut fresh = Simulation::new(Scene::new(parts).unwrap()).unwrap();
            simulation.set_positions(&snapshot.positions, PairStates::FromDistances).unwrap();
            let name = format!("scene {which}, seed {seed}, fresh");
            assert_same(&next_events(&mut simulation, COMPARED), &next_events(&mut fresh, COMPARED), &name);
        }
    }

    #[test]
    fn energy_balance_holds_after_setting_velocities_or_positions(seed in 1_u64..1_000, factor in 0.0_f64..3.0) {
        for which in 0..7 {
            let mut simulation = Simulation::new(scene(which, seed)).unwrap();
            let start = balance(&simulation);
            next_events(&mut simulation, 200);
            let snapshot = simulation.snapshot();
            let faster: Vec<Vector> = snapshot.velocities.iter().map(|velocity| velocity * factor).collect();
            simulation.set_velocities(&faster).unwrap();
            let at_start: Vec<Vector> = simulation.scene().particles().iter().map(|it| it.position).collect();
            simulation.set_positions(&at_start, PairStates::FromDistances).unwrap();
            if factor > 0.1 {
                next_events(&mut simulation, 200);
            }
            let scale = simulation.energy().kinetic + simulation.event_counts().supplied.total().abs() + start.abs();
            assert!((balance(&simulation) - start).abs() < 1e-12 * scale, "scene {which}, seed {seed}");
        }
    }
}

#[test]
fn a_pair_that_is_taken_apart_keeps_its_state_only_if_that_is_possible() {
    let pair = |distance: f64| {
        let scene = fluid(well(), 1.0)
            .space(Space::periodic_cube(10.0))
            .particle("A", Vector::new(1.0, 1.0, 1.0), Vector::new(0.1, 0.0, 0.0))
            .particle("A", Vector::new(1.0 + distance, 1.0, 1.0), Vector::zeros());
        Simulation::new(scene.build().unwrap()).unwrap()
    };
    let apart = |distance: f64| [Vector::new(1.0, 1.0, 1.0), Vector::new(1.0 + distance, 1.0, 1.0)];
    let mut simulation = pair(1.2);
    assert_eq!(simulation.energy().potential, -1.0);
    let error = simulation.set_positions(&apart(3.0), PairStates::Keep).unwrap_err();
    assert!(matches!(error, SetStateError::Overlap(Overlap { depth, .. }) if (depth - 1.0).abs() < 1e-9), "{error}");
    assert_eq!(simulation.snapshot(), pair(1.2).snapshot(), "it is as it was");
    assert_eq!(next_events(&mut simulation.clone(), 1), next_events(&mut pair(1.2), 1));
    simulation.set_positions(&apart(1.4), PairStates::Keep).unwrap();
    assert_eq!((simulation.energy().potential, simulation.event_counts().supplied.total()), (-1.0, 0.0));
    simulation.set_positions(&apart(3.0), PairStates::FromDistances).unwrap();
    assert_eq!((simulation.energy().potential, simulation.event_counts().supplied.total()), (0.0, 1.0));
    let error = simulation.set_positions(&apart(0.9), PairStates::FromDistances).unwrap_err();
    assert!(matches!(error, SetStateError::Overlap(Overlap { depth, .. }) if (depth - 0.1).abs() < 1e-9), "{error}");
    let mut far = apart(3.0);
    far[1].x -= 30.0;
    simulation.set_positions(&far, PairStates::Keep).unwrap();
    let snapshot = simulation.snapshot();
    assert!((snapshot.positions[1] - apart(3.0)[1]).norm() < 1e-14);
    assert_eq!(snapshot.images[1], [-3, 0, 0]);
}

#[test]
fn invalid_positions_and_velocities_are_rejected() {
    let scene = fluid(hard(), 1.0)
        .species(SpeciesDraft::new("S").diameter(1.0).fixed())
        .interaction(InteractionDraft::new(hard()).between("A", "S"))
        .space(Space {
            boundary: [Boundary::Periodic, Boundary::walls(1.0), Boundary::Flat],
            size: Vector::new(10.0, 10.0, 0.0),
            ..Space::periodic_cube(10.0)
        })
        .particle("A", Vector::new(1.0, 5.0, 0.0), Vector::new(1.0, 0.0, 0.0))
        .particle("S", Vector::new(5.0, 5.0, 0.0), Vector::zeros());
    let mut simulation = Simulation::new(scene.build().unwrap()).unwrap();
    let snapshot = simulation.snapshot();
    let changed = |particle: usize, by: Vector| {
        let (mut positions, mut velocities) = (snapshot.positions.clone(), snapshot.velocities.clone());
        positions[particle] += by;
        velocities[particle] += by;
        (positions, velocities)
    };
    let fixed = |particle, axis| SetStateError::Fixed { particle: ParticleId(particle), axis };
    let not_finite = SetStateError::NotFinite { particle: ParticleId(0) };
    for (particle, by, expected) in [
        (0, Vector::new(f64::NAN, 0.0, 0.0), not_finite),
        (0, Vector::new(1e51, 0.0, 0.0), not_finite),
        (0, Vector::new(0.0, 0.0, 1.0), fixed(0, 2)),
        (1, Vector::new(0.0, 1.0, 0.0), fixed(1, 1)),
    ] {
        let (positions, velocities) = changed(particle, by);
        assert_eq!(simulation.set_positions(&positions, PairStates::Keep), Err(expected));
        assert_eq!(simulation.set_velocities(&velocities), Err(expected));
    }
    let count = SetStateError::Count { expected: 2, found: 1 };
    assert_eq!(simulation.set_positions(&snapshot.positions[..1], PairStates::Keep), Err(count));
    assert_eq!(simulation.set_velocities(&snapshot.velocities[..1]), Err(count));
    let (in_wall, _) = changed(0, Vector::new(0.0, -4.8, 0.0));
    let error = simulation.set_positions(&in_wall, PairStates::Keep).unwrap_err();
    assert!(matches!(error, SetStateError::Overlap(Overlap { partner: None, .. })), "{error}");
    assert_eq!(simulation.snapshot(), snapshot);
    simulation.grow(&Growth { rate: 0.1, until: GrowthTarget::PackingFraction(0.2) }, 1.1);
    assert_eq!(simulation.set_positions(&snapshot.positions, PairStates::Keep), Err(SetStateError::Growing));
}

#[test]
fn a_simulation_can_be_copied_and_sent() {
    fn is_clone_and_send<T: Clone + Send + 'static>() {}
    is_clone_and_send::<Simulation>();
}
