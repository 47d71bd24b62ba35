use super::*;
use crate::Vector;
use crate::analysis::instruments::quantity::Divisor;
use crate::analysis::instruments::test_system::{
    equilibrate, instrument, measure as system_measure, report, unlike_spheres,
};
use crate::base::numbers::{id, trunc_to_usize};
use crate::engine::{Simulation, Until};
use crate::model::Thermostat;
use crate::model::potential::Potential;
use crate::model::space::{Space, nearest_image};
use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

fn measure(system: &SystemDescription, plan: &plan::RadialDistribution, frames: &[Vec<Vector>]) -> Measured {
    measure_sheared(system, plan, frames, 0.0)
}

/// In a sheared box, the periodic image above the box is shifted along x by `displacement`.
fn measure_sheared(
    system: &SystemDescription,
    plan: &plan::RadialDistribution,
    frames: &[Vec<Vector>],
    displacement: f64,
) -> Measured {
    let velocities = vec![Vector::zeros(); frames[0].len()];
    let sample = |k: usize| Sample {
        time: k as f64,
        positions: &frames[k],
        velocities: &velocities,
        displacement,
        ..Sample::default()
    };
    let setup = Setup { system, sample: sample(0), duration: frames.len() as f64 };
    let mut instrument = RadialDistribution::new(plan, &setup);
    (1..frames.len()).for_each(|k| instrument.sample(&sample(k), system));
    report(&instrument, system)
}

fn plan(cutoff: f64, bins: u64) -> plan::RadialDistribution {
    plan::RadialDistribution { cutoff: Some(cutoff), bins: Some(bins), interval: Some(1.0), scaled: false }
}

fn random_frames(count: usize, particles: usize, space: &Space) -> Vec<Vec<Vector>> {
    let mut random = ChaCha8Rng::seed_from_u64(21);
    let mut next = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let mut frame = || (0..particles).map(|_| space.lower + Vector::from_fn(|k, _| next() * space.size[k])).collect();
    (0..count).map(|_| frame()).collect()
}

#[test]
fn a_curve_times_its_divisors_is_the_number_of_pairs_in_each_bin() {
    let space =
        Space { boundary: [Boundary::Periodic, Boundary::OPEN, Boundary::Periodic], ..Space::periodic_cube(6.0) };
    let frames = random_frames(7, 30, &space);
    let curve = &measure(&SystemDescription::of_points(space.clone(), 30), &plan(2.0, 5), &frames).curves[0];
    let mut counts = [0.0; 5];
    for frame in &frames[1..] {
        for (a, position) in frame.iter().enumerate() {
            for other in &frame[..a] {
                let distance = nearest_image(position - other, &space.periods(), 0.0).norm();
                if let Some(count) = counts.get_mut(trunc_to_usize(distance / 2.0 * 5.0)) {
                    *count += 1.0;
                }
            }
        }
    }
    let normalisation = curve.series[0].normalisation.as_ref().unwrap();
    assert_eq!(normalisation.divisors[0].values, [6.0]);
    for (bin, count) in counts.into_iter().enumerate() {
        let product = |divisor: &Divisor| divisor.values[if divisor.values.len() == 1 { 0 } else { bin }];
        let undone = curve.series[0].values[bin].unwrap() * normalisation.divisors.iter().map(product).product::<f64>();
        assert!((undone - count).abs() < 1e-12 * count && count > 0.0, "{bin}: {undone} and {count}");
    }
}

#[test]
fn an_ideal_gas_has_no_structure_in_any_dimension_and_any_box() {
    let flat = Boundary::Flat;
    for (boundary, size) in [
        ([Boundary::Periodic; 3], Vector::repeat(6.0)),
        ([Boundary::Periodic, Boundary::Periodic, flat], Vector::new(6.0, 7.0, 0.0)),
        ([flat, Boundary::Periodic, flat], Vector::new(0.0, 9.0, 0.0)),
        ([Boundary::OPEN; 3], Vector::new(4.0, 5.0, 6.0)),
        ([Boundary::OPEN, Boundary::Periodic, flat], Vector::new(4.0, 8.0, 0.0)),
        ([flat, flat, Boundary::OPEN], Vector::new(0.0, 0.0, 5.0)),
        // Slits and channels narrower than the cutoff.
        ([Boundary::OPEN, Boundary::Periodic, Boundary::Periodic], Vector::new(0.2, 9.0, 9.0)),
        ([flat, Boundary::Periodic, Boundary::OPEN], Vector::new(0.0, 9.0, 0.7)),
        ([Boundary::Periodic, Boundary::OPEN, Boundary::OPEN], Vector::new(9.0, 0.6, 0.9)),
    ] {
        let space = Space { lower: Vector::new(1.0, -2.0, 0.5), size, boundary };
        let frames = random_frames(129, 40, &space);
        let curve = &measure(&SystemDescription::of_points(space, 40), &plan(3.0, 6), &frames).curves[0];
        assert_eq!(curve.variables[0].values[5], 2.75, "{boundary:?}");
        assert!(!curve.method.contains("the cutoff is"), "{}", curve.method);
        for bin in 0..6 {
            let (value, error) = (curve.series[0].values[bin].unwrap(), curve.series[0].standard_errors[bin].unwrap());
            assert!(error < 0.15 && (value - 1.0).abs() < 4.0 * error, "{boundary:?} {bin}: {value} +- {error}");
        }
    }
}

#[test]
fn cutoff_shortened_by_a_period_is_reported() {
    let space =
        Space { boundary: [Boundary::OPEN, Boundary::Periodic, Boundary::Periodic], ..Space::periodic_cube(6.0) };
    let system = SystemDescription::of_points(space.clone(), 5);
    let curve = &measure(&system, &plan(4.0, 6), &random_frames(9, 5, &space)).curves[0];
    assert_eq!(curve.variables[0].values[5], 2.75);
    let why = "the cutoff is 3 instead of 4, because it cannot exceed half of the period along y";
    assert!(curve.method.ends_with(why), "{}", curve.method);
    assert_eq!(shortened_cutoff(&plan(4.0, 6), &system).as_deref(), Some(why));
    assert_eq!(shortened_cutoff(&plan(3.0, 6), &system), None);
    let box_of_walls = SystemDescription::of_points(Space { boundary: [Boundary::OPEN; 3], ..space }, 5);
    let beyond = shortened_cutoff(&plan(20.0, 6), &box_of_walls).unwrap();
    assert!(beyond.ends_with("instead of 20, because it cannot exceed the diagonal of the box"), "{beyond}");
}

#[test]
fn two_species_are_told_apart_and_a_static_one_counts_as_a_partner() {
    let space = Space::periodic_cube(6.0);
    let mut system = SystemDescription::of_points(space.clone(), 5);
    system.species_names = ["A", "B", "wall"].map(str::to_owned).to_vec();
    (system.diameters, system.cores) = (vec![1.0; 3], crate::model::SpeciesPairs::new(3));
    (system.species, system.moving) = (vec![0, 1, 1, 2, 2], vec![0, 1, 2]);
    let positions: Vec<Vector> = [0.0, 0.6, 1.6, 5.5, 5.0].iter().map(|&x| Vector::new(x, 0.0, 0.0)).collect();
    let curve = &measure(&system, &plan(2.0, 2), &vec![positions; 9]).curves[0];
    let shell = |bin: usize| 4.0 / 3.0 * std::f64::consts::PI * [1.0, 7.0][bin] / 216.0;
    // Distances in the bins [0, 1) and [1, 2): A-B 0.6 and 1.6; A-wall 0.5 and 1.0; B-B 1.0; B-wall 1.1 and 1.6.
    for (name, bins, pairs) in [
        ("g(r) A-A", [None; 2], 0.0),
        ("g(r) A-B", [Some(1.0), Some(1.0)], 2.0),
        ("g(r) A-wall", [Some(1.0), Some(1.0)], 2.0),
        ("g(r) B-B", [Some(0.0), Some(1.0)], 1.0),
        ("g(r) B-wall", [Some(0.0), Some(2.0)], 4.0),
    ] {
        let series = curve.series.iter().find(|series| series.name == name).unwrap();
        for (bin, expected) in bins.into_iter().enumerate() {
            let expected = expected.map(|count| count / (pairs * shell(bin)));
            let error = series.values[bin].zip(expected).map(|(value, expected)| (value - expected).abs());
            assert_eq!(series.values[bin].is_some(), expected.is_some(), "{name} {bin}");
            assert!(error.is_none_or(|error| error < 1e-9), "{name} {bin}: {:?} but {expected:?}", series.values[bin]);
        }
    }
    assert_eq!(curve.series.len(), 5, "static pairs do not count");
}

#[test]
fn a_crystal_has_its_neighbours_at_exact_distances() {
    let sites = [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]].map(Vector::from);
    let corner = |k: u32| Vector::new(f64::from(k % 4), f64::from(k / 4 % 4), f64::from(k / 16));
    // The unit cell has an edge of sqrt(2), so the distances between neighbours are sqrt(n) with integer n.
    let edge = 2.0_f64.sqrt();
    let positions: Vec<Vector> = (0..64).flat_map(|k| sites.map(|site| edge * (corner(k) + site))).collect();
    let system = SystemDescription::of_points(Space::periodic_cube(4.0 * edge), 256);
    let (cutoff, bins) = (2.5, 250);
    let curve = &measure(&system, &plan(cutoff, bins), &vec![positions; 9]).curves[0];
    let width = cutoff / bins as f64;
    let mut found = [0.0; 7];
    for (r, value) in curve.variables[0].values.iter().zip(&curve.series[0].values) {
        let shell = 4.0 / 3.0 * std::f64::consts::PI * ((r + 0.5 * width).powi(3) - (r - 0.5 * width).powi(3));
        let neighbours = value.unwrap() * shell * 255.0 / system.space.volume();
        if neighbours > 0.0 {
            let number = (r * r).round();
            assert!((r - number.sqrt()).abs() < 1.01 * width, "neighbours at {r}");
            found[trunc_to_usize(number)] += neighbours;
        }
    }
    let exact = [0.0, 12.0, 6.0, 24.0, 12.0, 24.0, 8.0];
    assert!(found.iter().zip(exact).all(|(found, exact)| (found - exact).abs() < 1e-9), "{found:?}");
}

fn triples([x, y, z]: [std::ops::Range<i32>; 3]) -> Vec<[i32; 3]> {
    z.flat_map(|k| y.clone().map(move |j| (j, k))).flat_map(|(j, k)| x.clone().map(move |i| [i, j, k])).collect()
}

#[test]
fn a_sheared_crystal_has_the_neighbours_of_its_lattice() {
    let flat = [Boundary::Periodic, Boundary::Periodic, Boundary::Flat];
    for (boundary, displacement) in
        [([Boundary::Periodic; 3], 1.3), ([Boundary::Periodic; 3], -2.1), (flat, 0.7), (flat, -2.9), (flat, 3.0)]
    {
        let is_flat = boundary[2] == Boundary::Flat;
        let space = Space {
            lower: Vector::new(-1.0, 2.0, 0.5),
            size: Vector::new(6.0, 5.5, if is_flat { 0.0 } else { 4.4 }),
            boundary,
        };
        // 6 x 5 x 4 unit cells with an oblique second lattice vector.
        let site = |[i, j, k]: [i32; 3]| {
            let [i, j, k] = [i, j, k].map(f64::from);
            Vector::new(i + displacement * j / 5.0, 1.1 * j, 1.1 * k)
        };
        let inside = |site: Vector| space.lower + Vector::new((site.x + 0.1).rem_euclid(6.0), site.y, site.z);
        let cells = triples([0..6, 0..5, if is_flat { 0..1 } else { 0..4 }]);
        let positions: Vec<Vector> = cells.into_iter().map(|cell| inside(site(cell))).collect();
        let around = triples([-9..10, -9..10, if is_flat { 0..1 } else { -9..10 }]);
        let distances: Vec<f64> = around.into_iter().map(|cell| site(cell).norm()).filter(|r| *r > 0.0).collect();
        let count = positions.len();
        let system = SystemDescription::of_points(space.clone(), id(count));
        let (cutoff, bins) = (2.15, 215);
        let curve = &measure_sheared(&system, &plan(cutoff, bins), &vec![positions; 3], displacement).curves[0];
        let (room, width) = (Room::new(&space, 1.0), cutoff / bins as f64);
        for (bin, value) in curve.series[0].values.iter().enumerate() {
            let [from, to] = [bin, bin + 1].map(|edge| edge as f64 * width);
            let neighbours = value.unwrap() * (count as f64 - 1.0) * room.probability(from, to);
            // Round-off may move a distance across the border between two bins.
            let within = |by: f64| distances.iter().filter(|&&r| from - by <= r && r < to + by).count() as f64;
            let is_right = within(-1e-9) - 1e-6 <= neighbours && neighbours <= within(1e-9) + 1e-6;
            assert!(is_right, "{displacement} {from}: {neighbours}");
        }
    }
}

#[test]
fn cutoffs_stay_below_half_a_period_and_bins_below_their_limit() {
    let system = SystemDescription::of_points(Space::periodic_cube(6.0), 2);
    let positions = vec![Vector::zeros(), Vector::repeat(1.0)];
    let curve = &measure(&system, &plan(100.0, u64::MAX), &vec![positions; 2]).curves[0];
    assert_eq!(curve.variables[0].values.len(), 2000);
    assert!((curve.variables[0].values[1999] - (3.0 - 0.5 * 3.0 / 2000.0)).abs() < 1e-12);
}

#[test]
fn the_contact_value_of_hard_spheres_is_that_of_carnahan_and_starling() {
    let scene = SceneBuilder::new("fluid")
        .seed(5)
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(500).packing_fraction(0.3))
        .temperature(1.0)
        .build()
        .unwrap();
    let system = SystemDescription::of(&scene);
    let mut simulation = Simulation::without_plan(scene);
    simulation.advance(Until::time(10.0)).unwrap();
    let (start, before) = (simulation.snapshot(), *simulation.event_counts());
    let plan = plan::RadialDistribution { cutoff: Some(2.0), bins: Some(50), interval: Some(0.1), scaled: false };
    let setup = Setup { system: &system, sample: Sample::of(&start), duration: 40.0 };
    let mut instrument = RadialDistribution::new(&plan, &setup);
    for _ in 0..400 {
        simulation.advance(Until::time(instrument.next_sample())).unwrap();
        instrument.sample(&Sample::of(&simulation.snapshot()), &system);
    }
    let measured = report(&instrument, &system);
    let number = &measured.numbers[0];
    let (mean, error) = (number.mean.unwrap(), number.standard_error.unwrap());
    assert_eq!(number.name, "contact_value_A_A");
    // The contact value of an infinite system is (1 - phi / 2) / (1 - phi)^3. For 500 particles it is 0.4 % larger. The
    // value of this run follows from the virial: Z - 1 = 4 phi g.
    let exact = (1.0 - 0.15) / 0.7_f64.powi(3);
    assert!(error < 0.025 && (mean - exact).abs() < 4.0 * error, "{mean} +- {error}, {exact}");
    let temperature = simulation.energy().kinetic / (1.5 * 499.0);
    let virial = simulation.event_counts().virial.total() - before.virial.total();
    let of_virial = virial / (3.0 * 499.0 * temperature * (simulation.time() - start.time)) / (4.0 * 0.3);
    assert!((mean - of_virial).abs() < 4.0 * error, "{mean} +- {error}, {of_virial}");
    assert!(measured.curves[0].series[0].values[..24].iter().all(|value| *value == Some(0.0)));
}

/// Returns the extrapolated contact value with its error, and the contact value from the rate of Core events, `Gamma =
/// 4 rho sigma^2 g sqrt(pi T / m)`.
fn contact_and_rate(potential: Potential) -> ([f64; 2], f64) {
    let (mass, temperature) = (1.7, 1.3);
    let scene = SceneBuilder::new("fluid")
        .seed(9)
        .species(SpeciesDraft::new("A").mass(mass).diameter(1.0))
        .interaction(InteractionDraft::new(potential).between("A", "A"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(500).packing_fraction(0.15))
        .temperature(temperature)
        .build()
        .unwrap();
    let system = SystemDescription::of(&scene);
    let density = 500.0 / scene.space().volume();
    let mut simulation = Simulation::without_plan(scene);
    let bath = Thermostat::Andersen { temperature, rate: 0.5, axes: [true; 3] };
    simulation.set_thermostat(Some(&bath), 0).unwrap();
    simulation.advance(Until::time(20.0)).unwrap();
    let (start, before) = (simulation.snapshot(), *simulation.event_counts());
    let plan = plan::RadialDistribution { cutoff: Some(1.5), bins: Some(50), interval: Some(0.2), scaled: false };
    let setup = Setup { system: &system, sample: Sample::of(&start), duration: 160.0 };
    let mut instrument = RadialDistribution::new(&plan, &setup);
    for _ in 0..800 {
        simulation.advance(Until::time(instrument.next_sample())).unwrap();
        instrument.sample(&Sample::of(&simulation.snapshot()), &system);
    }
    let measured = report(&instrument, &system);
    let number = &measured.numbers[0];
    let core = (simulation.event_counts().core - before.core) as f64;
    let rate = 2.0 * core / (500.0 * (simulation.time() - start.time));
    let exact = rate / (4.0 * density * (std::f64::consts::PI * temperature / mass).sqrt());
    ([number.mean.unwrap(), number.standard_error.unwrap()], exact)
}

#[test]
fn contact_value_is_fitted_only_up_to_the_next_step() {
    let shoulder = Potential::square_shoulder(1.0, 1.05, 1.0).unwrap();
    let well = Potential::square_well(1.0, 1.03, 0.6).unwrap();
    for potential in [shoulder, well] {
        let ([mean, error], exact) = contact_and_rate(potential.clone());
        // About 20,000 contacts determine the rate to one per cent.
        assert!((mean - exact).abs() < 4.0 * error + 0.03 * exact, "{potential:?}: {mean} +- {error}, {exact}");
        assert!(error < 0.1 * exact);
    }
}

#[test]
fn steps_outside_cores_include_bonds() {
    let bond = |shortest, longest| Potential::bond(shortest, longest).unwrap();
    let scene = |shortest: f64, longest: f64| {
        SceneBuilder::new("pairs")
            .space(Space::periodic_cube(10.0))
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .species(SpeciesDraft::new("B").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .interaction(InteractionDraft::new(Potential::square_well(1.0, 1.5, 1.0).unwrap()).between("A", "B"))
            .interaction(InteractionDraft::new(Potential::penetrable(1.0, 1.0).unwrap()).between("B", "B"))
            .interaction(InteractionDraft::new(bond(shortest, longest)).named("link"))
            .particle("A", Vector::repeat(1.0), Vector::zeros())
            .particle("A", Vector::new(2.05, 1.0, 1.0), Vector::zeros())
            .bond([0, 1], "link")
            .particle("B", Vector::repeat(5.0), Vector::zeros())
            .build()
            .unwrap()
    };
    let steps = |shortest, longest| {
        let system = SystemDescription::of(&scene(shortest, longest));
        [(0, 0), (0, 1), (1, 1)].map(|(a, b)| system.steps_outside_cores.get(a, b))
    };
    assert_eq!(steps(0.9, 1.08), [Some(1.08), Some(1.5), None]);
    assert_eq!(steps(1.02, 1.08), [Some(1.02), Some(1.5), None]);
}

/// Returns the scaled distribution of random points with the particles of a system, and its instrument.
fn scaled_of_points(system: &SystemDescription, cutoff: f64) -> Measured {
    let frames = random_frames(4000, system.species.len(), &system.space);
    measure(system, &plan::RadialDistribution { scaled: true, ..plan(cutoff, 4) }, &frames)
}

#[test]
fn random_points_are_uncorrelated_in_units_of_contact_distances() {
    // Three species of unequal numbers. The interaction of A and B is not additive, and B and C do not interact.
    let cube = Space::periodic_cube(9.0);
    let plane = Space {
        boundary: [Boundary::Periodic, Boundary::Periodic, Boundary::Flat],
        size: Vector::new(9.0, 9.0, 0.0),
        ..cube
    };
    let line = Space {
        boundary: [Boundary::Periodic, Boundary::Flat, Boundary::Flat],
        size: Vector::new(40.0, 0.0, 0.0),
        ..cube
    };
    for space in [cube, plane, line] {
        let scene = SceneBuilder::new("points")
            .space(space)
            .allow_invalid_start(true)
            .species(SpeciesDraft::new("A").mass(1.0).diameter(0.5))
            .species(SpeciesDraft::new("B").mass(1.0).diameter(1.3))
            .species(SpeciesDraft::new("C").mass(1.0).diameter(0.9))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .interaction(InteractionDraft::new(Potential::hard_sphere(1.1).unwrap()).between("A", "B"))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "C"))
            .interaction(InteractionDraft::new(Model::HardSphere).between("B", "B"))
            .interaction(InteractionDraft::new(Model::None).between("B", "C"))
            .interaction(InteractionDraft::new(Model::HardSphere).between("C", "C"));
        let kinds = ["A", "A", "A", "B", "B", "C", "C", "C", "C", "C"];
        let scene = kinds.into_iter().fold(scene, |scene, kind| scene.particle(kind, Vector::zeros(), Vector::zeros()));
        let measured = scaled_of_points(&SystemDescription::of(&scene.build().unwrap()), 3.0);
        let curve = &measured.curves[0];
        let names: Vec<&str> = curve.series.iter().map(|series| series.name.as_str()).collect();
        assert_eq!(names, ["A-A", "A-B", "A-C", "B-B", "C-C"].map(|pair| format!("g(r/sigma) {pair}")));
        assert_eq!((curve.variables[0].unit.as_str(), curve.variables[0].values[3]), ("1", 2.625));
        check_uncorrelated(curve);
    }
}

#[test]
fn random_points_with_individual_diameters_are_uncorrelated_in_units_of_contact_distances() {
    let (system, _) = unlike_spheres(40);
    let largest = system.own_diameters.iter().copied().fold(0.0, f64::max);
    check_uncorrelated(&scaled_of_points(&system, 0.49 * system.space.size.x / largest).curves[0]);
}

/// Each bin of each series is 1 within its error.
fn check_uncorrelated(curve: &Curve) {
    for series in &curve.series {
        for (value, error) in series.values.iter().zip(&series.standard_errors).skip(1) {
            let (value, error) = (value.unwrap(), error.unwrap());
            assert!((value - 1.0).abs() < 4.5 * error && error < 0.35, "{}: {value} +- {error}", series.name);
        }
    }
}

#[test]
fn contact_values_of_unequal_spheres_are_those_of_the_virial() {
    let (system, mut simulation) = unlike_spheres(200);
    equilibrate(&mut simulation, 100);
    let plan = plan::RadialDistribution { scaled: true, cutoff: None, bins: Some(50), interval: Some(0.1) };
    let mut radial = instrument(&simulation, &system, 60.0, |setup| RadialDistribution::new(&plan, setup));
    let (start, before) = (simulation.time(), simulation.event_counts().virial.total());
    system_measure(&mut simulation, &system, &mut radial, 60.0);
    let number = &report(&radial, &system).numbers[0];
    let (mean, error) = (number.mean.unwrap(), number.standard_error.unwrap());
    let count = 200.0;
    let temperature = simulation.energy().kinetic / (1.5 * (count - 1.0));
    let virial = simulation.event_counts().virial.total() - before;
    // Z - 1 = v (N - 1) / (2 V) <sigma^3> g(1), and Z - 1 = virial / (3 (N - 1) T t).
    let excess = virial / (3.0 * (count - 1.0) * temperature * (simulation.time() - start));
    let diameters = &system.own_diameters;
    let cubes =
        diameters.iter().enumerate().flat_map(|(i, a)| diameters[..i].iter().map(move |b| (0.5 * (a + b)).powi(3)));
    let mean_cube = cubes.sum::<f64>() / (0.5 * count * (count - 1.0));
    let volume = 4.0 * std::f64::consts::PI / 3.0;
    let exact = excess / (0.5 * volume * (count - 1.0) / system.space.volume() * mean_cube);
    assert!((mean - exact).abs() < 4.0 * error && error < 0.02 * exact, "{mean} +- {error}, {exact}");
    assert!(radial.pairs[0].shell.is_some_and(|shell| shell.core == 1.0));
}
