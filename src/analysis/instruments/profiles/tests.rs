use super::*;
use crate::analysis::instruments::Series;
use crate::analysis::instruments::test_system::{instrument, measure as run, report, unlike_spheres};
use crate::analysis::statistics::tests::fits;
use crate::model::SpeciesId;
use crate::model::space::Space;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

const FRAMES: usize = 400;

fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

fn measure(
    system: &SystemDescription,
    plan: &plan::Profile,
    mut frame: impl FnMut() -> (Vec<Vector>, Vec<Vector>),
) -> (Profile, Measured) {
    let species: Vec<SpeciesId> = system.species.iter().copied().map(SpeciesId).collect();
    let (positions, velocities) = frame();
    let sample = Sample { species: &species, positions: &positions, velocities: &velocities, ..Sample::default() };
    let mut profile = Profile::new(plan, &Setup { system, sample, duration: FRAMES as f64 });
    for k in 1..=FRAMES {
        let (positions, velocities) = frame();
        let sample = Sample {
            time: k as f64,
            species: &species,
            positions: &positions,
            velocities: &velocities,
            ..Sample::default()
        };
        profile.sample(&sample, system);
    }
    let measured = report(&profile, system);
    (profile, measured)
}

fn plan(bins: [u64; 3]) -> plan::Profile {
    let name = "p".to_owned();
    plan::Profile { name, bins, lower: None, upper: None, species: None, interval: Some(1.0) }
}

#[test]
fn the_temperature_of_individual_diameters_is_that_of_the_simulation() {
    let (system, mut simulation) = unlike_spheres(40);
    let mut profile = instrument(&simulation, &system, 5.0, |setup| Profile::new(&plan([1, 1, 1]), setup));
    run(&mut simulation, &system, &mut profile, 5.0);
    let measured = report(&profile, &system);
    let temperature = measured.curves[0].series.last().unwrap().values[0].unwrap();
    // The momentum is conserved.
    let expected = 2.0 * simulation.energy().kinetic / f64::from(3 * 40 - 3);
    assert!((temperature / expected - 1.0).abs() < 1e-12, "{temperature} {expected}");
}

#[test]
fn a_shear_flow_of_hot_particles_is_found_within_its_errors() {
    let mut system = SystemDescription::of_points(Space::periodic_cube(4.0), 60);
    system.conserved_axes = [false; 3];
    system.species = (0..60).map(|k| k % 2).collect();
    system.species_masses = vec![1.0, 3.0];
    system.masses = (0..60).map(|k| if k % 2 == 0 { 1.0 } else { 3.0 }).collect();
    let mut random = ChaCha8Rng::seed_from_u64(11);
    // In the cells 0, 1 and 2 along y, the flow velocity along x is 0, 1 and 2. The cell 3 is empty. The temperature is
    // 1/12.
    let frame = || {
        let (mut positions, mut velocities) = (Vec::new(), Vec::new());
        for mass in &system.masses {
            let position = Vector::from_fn(|k, _| uniform(&mut random) * if k == 1 { 3.0 } else { 4.0 });
            let thermal = Vector::from_fn(|_, _| (uniform(&mut random) - 0.5) / mass.sqrt());
            positions.push(position);
            velocities.push(thermal + Vector::new(position.y.floor(), 0.0, 0.5));
        }
        (positions, velocities)
    };
    let (_, measured) = measure(&system, &plan([1, 4, 1]), frame);
    let curve = &measured.curves[0];
    assert_eq!((curve.name.as_str(), curve.variables.len()), ("profile_p", 1));
    assert_eq!(curve.variables[0].values, [0.5, 1.5, 2.5, 3.5]);
    let [density, x, y, z, temperature] = &curve.series[..] else { panic!("five series") };
    let is = |series: &Series, cell: usize, expected: f64, largest: f64| {
        let (value, error) = (series.values[cell].unwrap(), series.standard_errors[cell].unwrap());
        assert!(error < largest, "{} {cell}: {error}", series.name);
        assert!((value - expected).abs() < 4.0 * error, "{} {cell}: {value} +- {error}, {expected}", series.name);
    };
    for cell in 0..3 {
        // The exact standard error of the density is sqrt(20 2/3 / 400) / 16. The standard error of the velocity is at
        // most sqrt(1/12 / 8000), for the lighter particles. The bounds are twice these errors.
        is(density, cell, 1.25, 0.023);
        is(x, cell, cell as f64, 0.0065);
        is(y, cell, 0.0, 0.0065);
        is(z, cell, 0.5, 0.0065);
        // The square of a thermal velocity component has the variance 1/180. The bound is twice the standard error
        // sqrt(1/180 / 24000) of 24,000 components.
        is(temperature, cell, 1.0 / 12.0, 0.001);
    }
    assert_eq!((density.values[3], density.standard_errors[3]), (Some(0.0), None));
    assert!(curve.series[1..].iter().all(|series| series.values[3].is_none() && series.standard_errors[3].is_none()));
}

#[test]
fn a_report_fits_no_more_spectra_than_it_has_errors() {
    let system = SystemDescription::of_points(Space::periodic_cube(4.0), 60);
    let mut random = ChaCha8Rng::seed_from_u64(12);
    let frame = || {
        let mut vectors = || (0..60).map(|_| Vector::from_fn(|_, _| 4.0 * uniform(&mut random))).collect();
        (vectors(), vectors())
    };
    let (profile, _) = measure(&system, &plan([2, 2, 2]), frame);
    let before = fits();
    let mut measured = Measured::default();
    profile.report(&system, &mut measured);
    // The five spectra of a cell are density, three velocity components and temperature.
    assert_eq!(fits() - before, 5 * 8);
}

#[test]
fn the_density_of_a_grid_adds_up_and_has_its_cells_in_order() {
    let mut space = Space::periodic_cube(6.0);
    space.lower = Vector::new(-3.0, 0.0, 0.0);
    let mut system = SystemDescription::of_points(space, 2);
    system.species_names.push("B".to_owned());
    let frame = || {
        // The first particle is below the box by one rounding error. The second is in the third cell along x and the
        // second cell along z.
        let positions = vec![Vector::new((-3.0_f64).next_down(), 1.0, 5.9), Vector::new(0.1, 5.0, 3.1)];
        (positions, vec![Vector::new(2.0, 0.0, 0.0); 2])
    };
    let (_, measured) = measure(&system, &plan([4, 1, 2]), frame);
    let curve = &measured.curves[0];
    let names: Vec<&str> = curve.variables.iter().map(|variable| variable.name.as_str()).collect();
    assert_eq!(names, ["x", "z"]);
    let filled: Vec<[f64; 2]> = (0..8)
        .filter(|&cell| curve.series[0].values[cell] == Some(1.0 / 27.0))
        .map(|cell| [curve.variables[0].values[cell], curve.variables[1].values[cell]])
        .collect();
    assert_eq!(filled, [[0.75, 4.5], [2.25, 4.5]]);
    let other = plan::Profile { species: Some("B".to_owned()), ..plan([4, 1, 2]) };
    let (_, measured) = measure(&system, &other, frame);
    assert!(measured.curves[0].series[0].values.iter().all(|value| *value == Some(0.0)));
    // Static particles, whose mass is infinite, are not counted.
    system.species_masses[0] = f64::INFINITY;
    let (_, measured) = measure(&system, &plan([4, 1, 2]), frame);
    assert!(measured.curves[0].series[0].values.iter().all(|value| *value == Some(0.0)));
}

#[test]
fn partial_grid_counts_only_its_volume() {
    let system = SystemDescription::of_points(Space::periodic_cube(6.0), 1);
    let part = plan::Profile { lower: Some([4.0, 0.0, 0.0]), upper: Some([7.0, 6.0, 6.0]), ..plan([3, 1, 1]) };
    let (_, measured) = measure(&system, &part, || (vec![Vector::new(0.5, 1.0, 1.0)], vec![Vector::zeros()]));
    assert_eq!(measured.curves[0].series[0].values, [Some(0.0), Some(0.0), Some(1.0 / 36.0)]);
}

#[test]
fn two_velocities_leave_one_degree_of_freedom_per_axis() {
    let system =
        SystemDescription { conserved_axes: [false; 3], ..SystemDescription::of_points(Space::periodic_cube(6.0), 1) };
    let mut sign = 1.0;
    let frame = || {
        sign = -sign;
        (vec![Vector::repeat(1.0)], vec![Vector::new(5.0 + sign, 0.0, 0.0)])
    };
    // The two samples, at t = 199 and 398, have the velocities 4 and 6. The squared deviations from the mean add up to
    // 2, and the number of free velocity components is 3 (2 - 1).
    let (_, measured) = measure(&system, &plan::Profile { interval: Some(199.0), ..plan([1; 3]) }, frame);
    let curve = &measured.curves[0];
    assert!((curve.series[4].values[0].unwrap() - 2.0 / 3.0).abs() < 1e-12, "{:?}", curve.series[4]);
    assert_eq!((curve.series[1].values[0], curve.variables.len()), (Some(5.0), 1));
}

#[test]
fn shear_streaming_does_not_count_as_temperature() {
    // All particles are in one cell and move with the streaming velocity, which differs by up to 8 within the cell.
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let system = SystemDescription { shear_rate: 2.0, ..SystemDescription::of_points(Space::periodic_cube(4.0), 100) };
    let (_, measured) = measure(&system, &plan([1, 1, 1]), || {
        let positions: Vec<Vector> = (0..100).map(|_| Vector::from_fn(|_, _| 4.0 * uniform(&mut random))).collect();
        let velocities = positions.iter().map(|position| system.streaming_velocity(position)).collect();
        (positions, velocities)
    });
    let series =
        |name: &str| measured.curves[0].series.iter().find(|series| series.name == name).unwrap().values[0].unwrap();
    assert!(series("temperature") < 1e-12, "{}", series("temperature"));
    // The standard error of 40,000 velocities, uniform over a range of 8, is 8 / sqrt(12 * 40,000) = 0.012.
    assert!(series("velocity x").abs() < 4.0 * 0.012);
}
