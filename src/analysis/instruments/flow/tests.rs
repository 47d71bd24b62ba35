use super::*;
use crate::analysis::instruments::test_system::{Recorded, hard_spheres, instrument, measure, number, report, start};
use crate::engine::Simulation;
use crate::model::space::Space;
use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

fn plan(axis: &str, at: f64) -> Plan {
    Plan {
        name: "gate".into(),
        axis: Some(axis.into()),
        normal: None,
        at,
        lower: None,
        upper: None,
        species: None,
        interval: None,
        direction: None,
        window: None,
        outlet: None,
    }
}

/// Two particles that never meet, in a periodic cube of edge 10. In 10 time units, A goes around twice along x, and B
/// goes around 3.5 times backwards along y.
fn two() -> (SystemDescription, Simulation) {
    let scene = SceneBuilder::new("two")
        .space(Space::periodic_cube(10.0))
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(2.7).diameter(1.0))
        .interaction(InteractionDraft::new(Model::None).between("A", "A"))
        .interaction(InteractionDraft::new(Model::None).between("A", "B"))
        .interaction(InteractionDraft::new(Model::None).between("B", "B"))
        .particle("A", Vector::new(1.0, 5.0, 2.5), Vector::new(2.0, 0.5, 0.0))
        .particle("B", Vector::new(5.0, 4.0, 7.5), Vector::new(0.0, -3.5, 0.0));
    start(scene.build().unwrap())
}

fn counted(plan: &Plan, duration: f64) -> Option<f64> {
    let (system, mut simulation) = two();
    let mut flow = instrument(&simulation, &system, duration, |setup| Flow::new(plan, setup));
    measure(&mut simulation, &system, &mut flow, duration);
    number(&report(&flow, &system), "flow_gate_count").mean
}

#[test]
fn passages_are_signed_and_go_around_the_box() {
    assert_eq!(counted(&plan("x", 4.0), 10.0), Some(2.0));
    assert_eq!(counted(&plan("x", 0.5), 10.0), Some(2.0));
    // Particle A moves from y = 5 to 10 and does not pass the plane. Particle B moves from y = 4 to -31. It passes the
    // plane y = 3, and periodic images of the plane at -7, -17 and -27.
    assert_eq!(counted(&plan("y", 3.0), 10.0), Some(-4.0));
    assert_eq!(counted(&plan("z", 5.0), 10.0), Some(0.0));
    let a = Plan { species: Some("A".into()), ..plan("y", 7.0) };
    assert_eq!(counted(&a, 10.0), Some(1.0));
    assert_eq!(counted(&plan("w", 4.0), 10.0), Some(0.0));
    // With a long interval, particle B passes the plane several times between two samples.
    let coarse = Plan { interval: Some(50.0), ..plan("y", 3.0) };
    assert_eq!(counted(&coarse, 10.0), Some(-4.0));
}

#[test]
fn more_crossings_between_two_samples_than_are_handled_one_by_one_are_all_counted() {
    let scene = SceneBuilder::new("fast")
        .space(Space::periodic_cube(10.0))
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0));
    let scene = scene.interaction(InteractionDraft::new(Model::None).between("A", "A")).particle(
        "A",
        Vector::new(1.0, 5.0, 2.5),
        Vector::new(-25_003.0, 0.0, 0.0),
    );
    let coarse = Plan { interval: Some(50.0), ..plan("x", 4.0) };
    for lower in [None, Some([-f64::MAX, 0.0, 0.0])] {
        let plan = Plan { lower, ..coarse.clone() };
        let (system, mut simulation) = start(scene.clone().build().unwrap());
        let mut flow = instrument(&simulation, &system, 10.0, |setup| Flow::new(&plan, setup));
        measure(&mut simulation, &system, &mut flow, 10.0);
        // The particle moves from x = 1 to x = 1 - 250,030.
        assert_eq!(number(&report(&flow, &system), "flow_gate_count").mean, Some(-25_003.0));
    }
}

#[test]
fn tilted_plane_counts_crossings_inside_its_bounds() {
    let open = Space { boundary: [Boundary::OPEN; 3], ..Space::periodic_cube(10.0) };
    let scene = SceneBuilder::new("one")
        .space(open)
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::None).between("A", "A"))
        .particle("A", Vector::new(1.0, 5.0, 2.5), Vector::new(2.0, 0.5, 0.0));
    let scene = scene.build().unwrap();
    // The particle crosses the plane `x + y = 10` at t = 1.6, where x = 4.2.
    let tilted = Plan { axis: None, normal: Some([3.0, 3.0, 0.0]), ..plan("", 50.0_f64.sqrt()) };
    let within = |lower: [f64; 3], upper: [f64; 3]| Plan { lower: Some(lower), upper: Some(upper), ..tilted.clone() };
    let backwards = Plan { direction: Some("-".into()), ..tilted.clone() };
    let near = within([4.1, 5.0, 0.0], [4.3, 6.0, 5.0]);
    let beside = within([4.3, 5.0, 0.0], [5.0, 6.0, 5.0]);
    for (plan, duration, expected) in
        [(&tilted, 1.5, 0.0), (&tilted, 1.7, 1.0), (&backwards, 9.0, -1.0), (&near, 9.0, 1.0), (&beside, 9.0, 0.0)]
    {
        let (system, mut simulation) = start(scene.clone());
        let mut flow = instrument(&simulation, &system, duration, |setup| Flow::new(plan, setup));
        measure(&mut simulation, &system, &mut flow, duration);
        assert_eq!(number(&report(&flow, &system), "flow_gate_count").mean, Some(expected), "{plan:?}");
    }
}

#[test]
fn only_crossings_inside_the_rectangle_count() {
    // Particle A passes x = 4 at t = 1.5, 6.5 and 11.5, with y = 5.75, 8.25 and 10.75. The last point is at y = 0.75 in
    // the box.
    let gate = |lower: [f64; 3], upper: [f64; 3]| Plan { lower: Some(lower), upper: Some(upper), ..plan("x", 4.0) };
    assert_eq!(counted(&gate([0.0, 5.7, 2.0], [0.0, 5.8, 3.0]), 12.0), Some(1.0));
    assert_eq!(counted(&gate([0.0, 5.0, 2.0], [0.0, 9.0, 3.0]), 12.0), Some(2.0));
    assert_eq!(counted(&gate([0.0, 0.7, 2.0], [0.0, 0.8, 3.0]), 12.0), Some(1.0));
    assert_eq!(counted(&gate([0.0, 5.0, 3.0], [0.0, 9.0, 4.0]), 12.0), Some(0.0));
    assert_eq!(counted(&Plan { upper: Some([0.0, 7.0, 9.0]), ..plan("x", 4.0) }, 10.0), Some(1.0));
}

#[test]
fn a_steady_flow_has_its_rate_and_curve() {
    let (system, mut simulation) = two();
    let mut flow = instrument(&simulation, &system, 1000.0, |setup| Flow::new(&plan("x", 4.0), setup));
    measure(&mut simulation, &system, &mut flow, 1000.0);
    let measured = report(&flow, &system);
    let rate = number(&measured, "flow_gate_rate");
    // Particle A passes the plane every 5 time units.
    assert!((rate.mean.unwrap() - 0.2).abs() < 1e-9, "{rate:?}");
    // There is a passage in every fifth row. If the rows were independent, the error would be sqrt(0.16 / 1000) =
    // 0.0126.
    let error = rate.standard_error.unwrap();
    assert!(error < 0.0126 / 4.0, "{error}");
    let curve = &measured.curves[0];
    assert_eq!(curve.name, "flow_gate");
    assert_eq!(curve.series[0].values.last(), Some(&Some(200.0)));
    assert_eq!(curve.variables[0].values.last(), Some(&1000.0));
}

#[test]
fn flow_counts_by_species_mass_direction_and_window() {
    let (system, mut simulation) = two();
    // Only particle B moves downwards. At t = 2, 4.857 and 7.714, it passes y = -3, -13 and -23, which are periodic
    // images of the plane.
    let plan = Plan { direction: Some("-".into()), window: Some([3.0, 8.0]), ..plan("y", 7.0) };
    let mut flow = instrument(&simulation, &system, 10.0, |setup| Flow::new(&plan, setup));
    measure(&mut simulation, &system, &mut flow, 10.0);
    let measured = report(&flow, &system);
    let mean = |name: &str| number(&measured, name).mean.unwrap();
    assert_eq!(mean("flow_gate_count"), 2.0);
    assert_eq!((mean("flow_gate_count_A"), mean("flow_gate_count_B")), (-1.0, 3.0));
    assert!((mean("flow_gate_mass") - (3.0 * 2.7 - 1.0)).abs() < 1e-12);
    assert_eq!(mean("flow_gate_rate"), (2.0 - 1.0) / 5.0);
    assert!((mean("flow_gate_mass_rate") - (2.0 * 2.7 - 1.0) / 5.0).abs() < 1e-12);
    let of_mass = &measured.curves[0].series[1];
    assert_eq!((of_mass.unit.as_str(), of_mass.values[0]), ("mass", Some(0.0)));
    assert_eq!(of_mass.values.last(), Some(&Some(mean("flow_gate_mass"))));
}

#[test]
fn restored_flow_continues_bitwise() {
    let (system, mut simulation) = hard_spheres(32, 0.2);
    let mut both = Recorded::new(instrument(&simulation, &system, 10.0, |setup| Flow::new(&plan("x", 1.0), setup)));
    measure(&mut simulation, &system, &mut both, 1.0);
    assert_eq!(both.again, both.instrument);
    assert!(both.instrument.passages.now().passed[NUMBER] != 0.0 || both.instrument.passages.rate(NUMBER).is_some());
}
