use super::*;
use crate::Vector;
use crate::analysis::instruments::test_system::{mean, report, sample};
use crate::model::space::{Boundary, Space};

/// The sites are in units of the edges of the cell.
fn lattice(cell: Vector, sites: &[[f64; 3]], cells: u32) -> (SystemDescription, Vec<Vector>) {
    let size = cell * f64::from(cells);
    let space = Space { lower: Vector::zeros(), size, boundary: [Boundary::Periodic; 3] };
    let corner =
        |k: u32| Vector::new(f64::from(k % cells), f64::from(k / cells % cells), f64::from(k / (cells * cells)));
    let at = |k: u32| sites.iter().map(move |site| (corner(k) + Vector::from(*site)).component_mul(&cell));
    let positions: Vec<Vector> = (0..cells * cells * cells).flat_map(at).collect();
    (SystemDescription::of_points(space, u32::try_from(positions.len()).unwrap()), positions)
}

#[test]
fn crystals_have_their_exact_order() {
    let cube = Vector::repeat(1.0);
    let fcc = [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]];
    let bcc = [[0.0; 3], [0.5; 3]];
    // Two layers of a triangular lattice in an orthogonal unit cell.
    let hcp = [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 1.0 / 3.0, 0.5], [0.5, 5.0 / 6.0, 0.5]];
    let hcp_cell = Vector::new(1.0, 3.0_f64.sqrt(), (8.0_f64 / 3.0).sqrt());
    // Each cutoff includes the nearest neighbours, and in bcc also the second neighbours.
    for (name, cell, sites, cutoff, q6, q4) in [
        ("fcc", cube, &fcc[..], 0.85, 0.57452, 0.19094),
        ("bcc", cube, &bcc[..], 1.2, 0.51069, 0.03637),
        ("sc", cube, &[[0.0; 3]][..], 1.2, 0.35355, 0.76376),
        ("hcp", hcp_cell, &hcp[..], 1.2, 0.48476, 0.09722),
    ] {
        let (system, positions) = lattice(cell, sites, 4);
        for (degree, expected) in [(6, q6), (4, q4)] {
            let values = per_particle(&system, &sample(0.0, &positions, &[]), cutoff, degree);
            // The reference values have five decimals.
            assert!(values.iter().all(|&value| (value - expected).abs() < 6e-6), "{name}: {}", values[0]);
        }
    }
}

#[test]
fn triangular_lattice_has_full_hexatic_order() {
    let (mut system, positions) = lattice(Vector::new(1.0, 3.0_f64.sqrt(), 1.0), &[[0.0; 3], [0.5, 0.5, 0.0]], 4);
    system.space.boundary[2] = Boundary::Flat;
    system.space.size[2] = 0.0;
    let positions: Vec<Vector> = positions[..32].to_vec();
    let system = SystemDescription::of_points(system.space, 32);
    let velocities = vec![Vector::zeros(); 32];
    let plan = plan::BondOrder { cutoff: None, bins: Some(10), interval: Some(1.0) };
    let setup = Setup { system: &system, sample: sample(0.0, &positions, &velocities), duration: 20.0 };
    let mut instrument = BondOrder::new(&plan, &setup);
    (1..=20).for_each(|k| instrument.sample(&sample(f64::from(k), &positions, &velocities), &system));
    let measured = report(&instrument, &system);
    let value = |name| mean(&measured, name);
    assert_eq!(value("neighbours"), 6.0);
    assert!((value("psi6") - 1.0).abs() < 1e-12 && (value("psi6_global") - 1.0).abs() < 1e-12);
    assert!(value("psi4") < 1e-12 && value("psi4_global") < 1e-12);
    let [six, four] = &measured.curves[0].series[..] else { panic!("two degrees") };
    assert_eq!((six.values[9], six.values[0]), (Some(10.0), Some(0.0)), "all in the last bin, of width 0.1");
    assert_eq!(four.values[0], Some(10.0));
    assert_eq!(six.standard_errors[9], Some(0.0));
}

#[test]
fn triangular_lattice_in_a_commensurate_sheared_box_is_hexatic() {
    // The number of rows is odd, so the image of the first row above the box is shifted by half a spacing.
    let height = 0.75_f64.sqrt();
    let boundary = [Boundary::Periodic, Boundary::Periodic, Boundary::Flat];
    let space = Space { lower: Vector::zeros(), size: Vector::new(6.0, 5.0 * height, 0.0), boundary };
    let site = |k: u32| Vector::new(f64::from(k % 6) + 0.5 * f64::from(k / 6 % 2), f64::from(k / 6) * height, 0.0);
    let positions: Vec<Vector> = (0..30).map(site).collect();
    let system = SystemDescription::of_points(space, 30);
    for (displacement, is_perfect) in [(0.5, true), (-1.5, true), (0.0, false)] {
        let sample = Sample { displacement, ..sample(0.0, &positions, &[]) };
        let values = per_particle(&system, &sample, 1.2, 6);
        assert_eq!(values.iter().all(|value| *value > 1.0 - 1e-6), is_perfect, "{displacement}: {values:?}");
    }
}

#[test]
fn without_neighbours_there_is_no_order_and_no_nan() {
    let system = SystemDescription::of_points(Space::periodic_cube(50.0), 2);
    let positions = [Vector::zeros(), Vector::repeat(20.0)];
    let velocities = [Vector::zeros(); 2];
    assert_eq!(per_particle(&system, &sample(0.0, &positions, &velocities), 1.4, 6), [0.0, 0.0]);
    assert_eq!(per_particle(&system, &sample(0.0, &positions, &velocities), 100.0, 99), [0.0, 0.0]);
    let setup = Setup { system: &system, sample: sample(0.0, &positions, &velocities), duration: 20.0 };
    let mut instrument = BondOrder::new(&plan::BondOrder::default(), &setup);
    instrument.sample(&sample(10.0, &positions, &velocities), &system);
    let measured = report(&instrument, &system);
    assert_eq!(measured.numbers[0].mean, Some(0.0));
    assert!(measured.numbers[1..].iter().all(|number| number.mean.is_none()));
    assert!(measured.curves[0].series.iter().all(|series| series.values.iter().all(Option::is_none)));
}

#[test]
fn trajectory_columns_hold_the_bond_order_of_their_degree() {
    // In a square lattice, each particle has four neighbours at right angles.
    let boundary = [Boundary::Periodic, Boundary::Periodic, Boundary::Flat];
    let space = Space { lower: Vector::zeros(), size: Vector::new(6.0, 6.0, 0.0), boundary };
    let positions: Vec<Vector> = (0..36).map(|k| Vector::new(f64::from(k % 6), f64::from(k / 6), 0.0)).collect();
    let system = SystemDescription::of_points(space, 36);
    let plan = plan::BondOrder { cutoff: Some(1.2), ..plan::BondOrder::default() };
    let scalars = scalars(&plan, &system, &sample(0.0, &positions, &[]));
    let values = |name: &str| scalars.iter().find(|scalar| scalar.name == name).unwrap().values.clone();
    assert_eq!(scalars.len(), 2);
    assert!(values("psi6").iter().all(|value| value.abs() < 1e-12));
    assert!(values("psi4").iter().all(|value| (value - 1.0).abs() < 1e-12));
    let line = SystemDescription::of_points(
        Space { boundary: [Boundary::Periodic, Boundary::Flat, Boundary::Flat], ..system.space },
        36,
    );
    assert!(super::scalars(&plan, &line, &sample(0.0, &positions, &[])).is_empty());
}
