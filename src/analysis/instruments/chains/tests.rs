use super::*;
use crate::analysis::instruments::test_system::{mean, number, report};
use crate::model::space::Space;

/// Two straight chains of four beads that cross the sides of the box, a ring of three, and a single particle.
fn scene(displacement: f64) -> (SystemDescription, Vec<Vector>) {
    let system = SystemDescription {
        bonds: vec![[0, 1], [1, 2], [2, 3], [4, 5], [5, 6], [6, 7], [8, 9], [9, 10], [8, 10]],
        bond_lengths: [0.5, 1.5],
        ..SystemDescription::of_points(Space::periodic_cube(5.0), 12)
    };
    let mut positions: Vec<Vector> = (0..4).map(|k| Vector::new((3.5 + f64::from(k)) % 5.0, 0.0, 4.9)).collect();
    positions.extend((0..4).map(|k| {
        let y = 8.25 - 1.25 * f64::from(k);
        Vector::new((1.0 - (y / 5.0).floor() * displacement).rem_euclid(5.0), y % 5.0, 2.0)
    }));
    positions.extend([Vector::zeros(), Vector::new(1.0, 0.0, 0.0), Vector::new(0.5, 0.75_f64.sqrt(), 0.0)]);
    positions.push(Vector::repeat(2.5));
    (system, positions)
}

fn sample(time: f64, positions: &[Vector], displacement: f64) -> Sample<'_> {
    Sample { time, positions, displacement, ..Sample::default() }
}

#[test]
fn sizes_are_those_of_straight_chains_and_triangles() {
    // In a sheared box, the second chain crosses into a displaced image.
    [0.0, 0.9, -2.2].into_iter().for_each(check_sizes);
}

fn check_sizes(displacement: f64) {
    let (system, positions) = scene(displacement);
    let plan = plan::Chains { bins: Some(10), interval: Some(1.0) };
    let setup = Setup { system: &system, sample: sample(0.0, &positions, displacement), duration: 10.0 };
    let mut instrument = Chains::new(&plan, &setup);
    for k in 1..=10 {
        instrument.sample(&sample(f64::from(k), &positions, displacement), &system);
        let record = serde_json::to_string(&instrument).unwrap();
        instrument = serde_json::from_str(&record).unwrap();
    }
    let measured = report(&instrument, &system);
    let is = |name: &str, expected: f64| (mean(&measured, name) - expected).abs() < 1e-12;
    assert!(is("bond_length", (6.0 + 3.75) / 9.0) && is("mean_square_bond_length", (6.0 + 3.0 * 1.5625) / 9.0));
    assert!(is("mean_square_end_to_end_distance_4", 0.5 * (9.0 + 9.0 * 1.5625)));
    // The four beads are 1.5, 0.5, 0.5 and 1.5 bonds from the centre. For bonds of length 1, the squared radius of
    // gyration is (1.5^2 + 0.5^2) 2 / 4.
    assert!(is("mean_square_radius_of_gyration_4", 0.5 * (1.25 + 1.25 * 1.5625)));
    assert!(number(&measured, "bond_length").standard_error.unwrap() < 1e-12);
    let curve = |name: &str| measured.curve(name).unwrap();
    let sizes = curve("chain_size");
    assert_eq!(sizes.variables[0].values, [3.0, 4.0]);
    assert_eq!(sizes.series.len(), 3);
    assert_eq!((sizes.series[0].values[0], sizes.series[1].values[0], sizes.series[2].values[1]), (None, None, None));
    // The corners of the triangle are 1 / sqrt(3) from the centre.
    assert!((sizes.series[2].values[0].unwrap() - 1.0 / 3.0).abs() < 1e-12);
    // Bond lengths are 1 and 1.25, in bins of 0.1 from 0.5 on. End-to-end distances are 3 and 3.75, in bins of 0.45.
    let lengths = &curve("bond_length").series[0].values;
    assert!((lengths[7].unwrap() - 10.0 / 3.0).abs() < 1e-9);
    assert!((lengths[4].unwrap() + lengths[5].unwrap() - 20.0 / 3.0).abs() < 1e-9, "1 is between two bins");
    let ends = &curve("end_to_end_distance_4").series[0].values;
    assert!((ends[6].unwrap() - 0.5 / 0.45).abs() < 1e-9 && (ends[8].unwrap() - 0.5 / 0.45).abs() < 1e-9);
}

#[test]
fn system_without_bonds_reports_nothing() {
    let system = SystemDescription::of_points(Space::periodic_cube(5.0), 2);
    let positions = [Vector::zeros(), Vector::repeat(1.0)];
    let setup = Setup { system: &system, sample: sample(0.0, &positions, 0.0), duration: 10.0 };
    let mut instrument = Chains::new(&plan::Chains::default(), &setup);
    let next = instrument.next_sample();
    instrument.sample(&sample(next, &positions, 0.0), &system);
    assert!(instrument.next_sample() > next);
    assert_eq!(report(&instrument, &system), Measured::default());
}
