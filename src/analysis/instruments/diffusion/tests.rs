use super::*;
use crate::analysis::instruments::quantity::Measured;
use crate::analysis::instruments::test_system::{
    Recorded, equilibrate, estimate, hard_spheres, instrument, measure, number, report, start,
};
use crate::analysis::published::HardSphereFluid;
use crate::engine::Simulation;
use crate::model::space::Space;
use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

fn diffusion(simulation: &Simulation, system: &SystemDescription, plan: &Plan, duration: f64) -> Diffusion {
    instrument(simulation, system, duration, |setup| Diffusion::new(plan, setup))
}

#[test]
fn a_hard_sphere_fluid_diffuses_as_published() {
    let (system, mut simulation) = hard_spheres(500, 0.3);
    equilibrate(&mut simulation, 50);
    let mut instrument = diffusion(&simulation, &system, &Plan::default(), 40.0);
    measure(&mut simulation, &system, &mut instrument, 40.0);
    let measured = report(&instrument, &system);
    let (einstein, error) = estimate(&measured, "diffusion_coefficient");
    let published = HardSphereFluid::reduced(0.3).simulated_diffusion_coefficient();
    // The finite box slows particles down by a few per cent, and the published fit is accurate to a few per cent.
    assert!((einstein - published).abs() < 4.0 * error + 0.05 * published, "{einstein} {error} {published}");
    assert!(error < 0.05 * published);
    let (integral, other) = estimate(&measured, "diffusion_coefficient_green_kubo");
    assert!((integral - einstein).abs() < 4.0 * (error + other), "{integral} {other} {einstein}");
}

#[test]
fn cubics_are_integrated_exactly_and_few_points_by_trapezoids() {
    let whole = |t: f64| t * (2.0 + t * (-1.5 + t * (0.4 - 0.07 * t)));
    let function = |t: f64| 2.0 + t * (-3.0 + t * (1.2 - 0.28 * t));
    for count in [4, 5, 9] {
        let values: Vec<f64> = (0..count).map(|k| function(f64::from(k))).collect();
        for (k, integral) in (0..).zip(integrals(&values)) {
            assert!((integral - whole(f64::from(k))).abs() < 1e-12, "{k} of {count}");
        }
        assert_eq!(integrals(&values).count(), values.len());
    }
    assert_eq!(integrals(&[3.0, 1.0, 4.0]).collect::<Vec<_>>(), [0.0, 2.0, 4.5]);
    assert_eq!(integrals(&[3.0]).collect::<Vec<_>>(), [0.0]);
}

#[test]
fn start_is_ballistic_and_matches_the_temperature() {
    let (system, mut simulation) = hard_spheres(108, 0.3);
    let mut instrument = diffusion(&simulation, &system, &Plan::default(), 4.0);
    measure(&mut simulation, &system, &mut instrument, 4.0);
    let measured = report(&instrument, &system);
    let curve = |name: &str| measured.curve(name).unwrap();
    // The temperature is exactly 1 at the start, and kinetic energy is conserved, so <v^2> is 3.
    let vacf = &curve("velocity_autocorrelation").series[0];
    assert!((vacf.values[0].unwrap() - 3.0).abs() < 1e-12);
    assert!(vacf.standard_errors[0].unwrap() < 1e-12);
    assert_eq!(curve("mean_squared_displacement").series[0].values[0], Some(0.0));
    let logarithmic = curve("mean_squared_displacement_logarithmic");
    let (times, values) = (&logarithmic.variables[0].values, &logarithmic.series[0].values);
    assert!((times[0] / 0.02 * 32.0 - 1.0).abs() < 1e-12);
    // At short times `<v(0).v(t)> = 3 (1 - a t)`, where `a` is about 2/3 of the collision rate, or 6.7. Therefore
    // <dr^2> at the shortest lag is less than 3 t^2 by the fraction a t / 3 = 0.0014. The statistical error of this
    // fraction is about 0.0007.
    let ratio = values[0].unwrap() / (3.0 * times[0] * times[0]);
    assert!(ratio < 1.0 && ratio > 0.997, "{ratio}");
    let linear = curve("mean_squared_displacement");
    let common = times.iter().position(|t| (t / linear.variables[0].values[1] - 1.0).abs() < 1e-12).unwrap();
    let (a, b) = (values[common].unwrap(), linear.series[0].values[1].unwrap());
    // The averages at logarithmic lags also use origins that are younger than the span.
    assert!((a / b - 1.0).abs() < 0.05, "{a} {b}");
}

#[test]
fn free_flight_is_exact_for_each_species_also_across_the_box() {
    let particle = |x: f64, y: f64| crate::Vector::new(x, y, 0.0);
    let scene = SceneBuilder::new("free")
        .space(Space {
            boundary: [
                crate::model::space::Boundary::Periodic,
                crate::model::space::Boundary::Periodic,
                crate::model::space::Boundary::Flat,
            ],
            size: crate::Vector::new(10.0, 10.0, 0.0),
            ..Space::periodic_cube(10.0)
        })
        .species(SpeciesDraft::new("A").mass(1.0).diameter(0.1))
        .species(SpeciesDraft::new("B").mass(3.0).diameter(0.1))
        .interaction(InteractionDraft::new(Model::None).between("A", "A"))
        .interaction(InteractionDraft::new(Model::None).between("A", "B"))
        .interaction(InteractionDraft::new(Model::None).between("B", "B"))
        .particle("A", particle(1.0, 1.0), particle(7.0, 1.0))
        .particle("B", particle(5.0, 5.0), particle(3.0, 1.0))
        .build()
        .unwrap();
    let (system, mut simulation) = start(scene);
    let plan = Plan { interval: Some(0.5), span: Some(8.0) };
    let mut instrument = diffusion(&simulation, &system, &plan, 40.0);
    measure(&mut simulation, &system, &mut instrument, 40.0);
    let measured = report(&instrument, &system);
    let curve = &measured.curves[0];
    assert_eq!(curve.series.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(), ["<dr^2>", "<dr^2> A", "<dr^2> B"]);
    // The centre of mass moves at (4, 1). Relative to it, A has the speed 3 and B the speed 1. The squared speeds
    // divided by `1 - m / M` are 9 / (1 - 1/4) = 12 for A and 1 / (1 - 3/4) = 4 for B, with the mean 8.
    for (series, square) in curve.series.iter().zip([8.0, 12.0, 4.0]) {
        for (t, value) in curve.variables[0].values.iter().zip(&series.values) {
            assert!((value.unwrap() - square * t * t).abs() < 1e-10 * (1.0 + t * t), "{t} {value:?}");
        }
    }
    assert_eq!(number(&measured, "diffusion_coefficient").mean, None, "a parabola is not straight");
    let green_kubo = number(&measured, "diffusion_coefficient_green_kubo");
    assert_eq!(green_kubo.mean, None, "an autocorrelation that stays as it is");
}

#[test]
fn in_a_sheared_box_the_flight_across_the_flow_is_exact() {
    let scene = SceneBuilder::new("free")
        .space(Space::periodic_cube(10.0))
        .shear(0.3)
        .species(SpeciesDraft::new("A").mass(1.0).diameter(0.1))
        .species(SpeciesDraft::new("B").mass(3.0).diameter(0.1))
        .interaction(InteractionDraft::new(Model::None).between("A", "A"))
        .interaction(InteractionDraft::new(Model::None).between("A", "B"))
        .interaction(InteractionDraft::new(Model::None).between("B", "B"))
        .particle("A", crate::Vector::repeat(1.0), crate::Vector::new(7.0, 5.0, 2.0))
        .particle("B", crate::Vector::repeat(5.0), crate::Vector::new(3.0, 1.0, -1.0))
        .build()
        .unwrap();
    let (system, mut simulation) = start(scene);
    let plan = Plan { interval: Some(0.5), span: Some(8.0) };
    let mut instrument = diffusion(&simulation, &system, &plan, 40.0);
    measure(&mut simulation, &system, &mut instrument, 40.0);
    let measured = report(&instrument, &system);
    // The centre of mass moves at (2, -1/4) along (y, z). Relative to it, A moves at (3, 9/4) and B at (-1, -3/4). The
    // squared speeds divided by `1 - m / M` are 225/16 / (1 - 1/4) for A and 25/16 / (1 - 3/4) for B, with the mean
    // 12.5.
    for (curve, power) in [(0, 2), (2, 0)] {
        for (series, square) in measured.curves[curve].series.iter().zip([12.5, 18.75, 6.25]) {
            for (t, value) in measured.curves[curve].variables[0].values.iter().zip(&series.values) {
                let expected = square * t.powi(power);
                assert!((value.unwrap() - expected).abs() < 1e-10 * (1.0 + expected), "{t} {value:?} {expected}");
            }
        }
    }
    // The autocorrelation has the constant value 12.5. The integral, divided by the number of axes, is 6.25 t.
    let integral = &measured.curves[3];
    assert!((integral.series[0].values[16].unwrap() - 6.25 * 8.0).abs() < 1e-9);
    assert!(measured.numbers[0].method.contains("across the flow"), "{}", measured.numbers[0].method);
}

#[test]
fn memory_and_samples_are_bounded_in_a_long_run() {
    let scene = SceneBuilder::new("alone")
        .space(Space::periodic_cube(10.0))
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(Lattice::SimpleCubic, "A").count(2).packing_fraction(0.001))
        .temperature(1.0);
    let (system, mut simulation) = start(scene.build().unwrap());
    let plan = Plan { interval: Some(1.0), span: Some(4.0) };
    let mut instrument = diffusion(&simulation, &system, &plan, 1000.0);
    let mut samples = 0;
    while instrument.next_sample() <= 5000.0 {
        simulation.advance(crate::engine::Until::time(instrument.next_sample())).unwrap();
        instrument.sample(&Sample::of(&simulation.snapshot()), &system);
        assert!(instrument.origins.len() <= MOST_LONG + MOST_YOUNG);
        samples += 1;
    }
    // In the 4 time units between two origins, there are samples at 4 linear lags and at ten logarithmic lags.
    assert!((5000 / 4 * 14..5000 / 4 * 14 + 100).contains(&samples), "{samples}");
    let measured = report(&instrument, &system);
    let times = &measured.curves[1].variables[0].values;
    assert_eq!(times.last(), Some(&4096.0), "the first origin sees the whole run");
}

#[test]
fn restored_diffusion_continues_bitwise() {
    let (system, mut simulation) = hard_spheres(32, 0.2);
    let mut both = Recorded::new(diffusion(&simulation, &system, &Plan::default(), 4.0));
    measure(&mut simulation, &system, &mut both, 1.3);
    assert_eq!(both.again, both.instrument);
}

fn between_walls(walls: [bool; 3]) -> Measured {
    let wall = |axis: usize| match walls[axis] {
        true => crate::model::space::Boundary::walls(1.0),
        false => crate::model::space::Boundary::Periodic,
    };
    let scene = SceneBuilder::new("free")
        .space(Space { boundary: std::array::from_fn(wall), ..Space::periodic_cube(10.0) })
        .species(SpeciesDraft::new("A").mass(1.0).diameter(0.1))
        .interaction(InteractionDraft::new(Model::None).between("A", "A"))
        .particle("A", crate::Vector::repeat(1.0), crate::Vector::new(1.0, 2.0, 3.0))
        .particle("A", crate::Vector::repeat(5.0), crate::Vector::new(-1.0, -2.0, 1.0))
        .build()
        .unwrap();
    let (system, mut simulation) = start(scene);
    let plan = Plan { interval: Some(0.5), span: Some(8.0) };
    let mut instrument = diffusion(&simulation, &system, &plan, 40.0);
    measure(&mut simulation, &system, &mut instrument, 40.0);
    report(&instrument, &system)
}

#[test]
fn axes_between_walls_are_excluded_from_diffusion() {
    let slit = between_walls([false, false, true]);
    let curve = &slit.curves[0];
    // The particles move at (1, 2) and (-1, -2) along x and y. The squared speed divided by `1 - m / M` is 5 / (1 -
    // 1/2) = 10.
    for (t, value) in curve.variables[0].values.iter().zip(&curve.series[0].values) {
        assert!((value.unwrap() - 10.0 * t * t).abs() < 1e-10 * (1.0 + t * t), "{t} {value:?}");
    }
    assert!(curve.method.contains("Axes with walls"), "{}", curve.method);
    let closed = between_walls([true; 3]);
    assert!(closed.numbers.iter().all(|number| number.mean.is_none()));
    assert!(closed.curves[0].method.contains("All axes have walls"));
    // The square of the diagonal of the box is 300.
    assert!(closed.curves[0].series[0].values.iter().all(|value| value.unwrap() < 300.0));
}

#[test]
fn late_start_time_gives_the_same_curves_and_ends() {
    let measured = |start_time: f64, interval: f64| {
        let scene = SceneBuilder::new("fluid")
            .start_time(start_time)
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(32).packing_fraction(0.2))
            .temperature(1.0);
        let (system, mut simulation) = start(scene.build().unwrap());
        let plan = Plan { interval: Some(interval), span: Some(10.0 * interval) };
        let duration = 100.0 * interval;
        let mut instrument = diffusion(&simulation, &system, &plan, duration);
        while instrument.next_sample() <= start_time + duration {
            let due = instrument.next_sample();
            simulation.advance(crate::engine::Until::time(due)).unwrap();
            let time = simulation.time().max(due);
            instrument.sample(&Sample { time, ..Sample::of(&simulation.snapshot()) }, &system);
            assert!(instrument.next_sample() > due, "it asks for what it has just been shown");
        }
        let measured = report(&instrument, &system);
        measured.curves[0].series[0].values.iter().flatten().copied().collect::<Vec<f64>>()
    };
    let early = measured(0.0, 0.02);
    // Times near 1e7 are rounded to multiples of 2e-9. Positions therefore have errors of about 1e-8, and squared
    // displacements have errors of up to 1e-7.
    for (early, late) in early.iter().zip(measured(1e7, 0.02)) {
        assert!((early - late).abs() < 1e-7, "{early} {late}");
    }
    assert_eq!(measured(1e12, 1.0).len(), early.len());
    // If the interval is shorter than the spacing of floating-point times, nothing is measured, but the loop ends.
    measured(1e12, 1e-5);
}

fn brownian(seed: u64, spans: f64) -> crate::analysis::statistics::Estimate {
    let mut system = SystemDescription::of_points(Space::periodic_cube(10.0), 4);
    (system.conserves_momentum, system.conserved_axes) = (false, [false; 3]);
    let mut random = crate::analysis::statistics::tests::correlated(0.0, 200_000, seed).into_iter();
    let mut positions = vec![Vector::zeros(); 4];
    let (velocities, images) = (vec![Vector::zeros(); 4], vec![[0; 3]; 4]);
    let plan = Plan { interval: Some(1.0), span: Some(20.0) };
    let sample = |time: f64, positions: &[Vector], see: &mut dyn FnMut(&Sample<'_>)| {
        see(&Sample { time, positions, velocities: &velocities, images: &images, ..Sample::default() });
    };
    let mut instrument = None;
    sample(0.0, &positions, &mut |sample| {
        instrument = Some(Diffusion::new(&plan, &Setup { system: &system, sample: *sample, duration: 20.0 * spans }));
    });
    let (mut instrument, mut now) = (instrument.unwrap(), 0.0);
    while instrument.next_sample() <= 20.0 * spans {
        let time = instrument.next_sample();
        // The variance of a uniform number between -1/2 and 1/2 is 1/12.
        let step = (12.0 * (time - now)).sqrt();
        for position in &mut positions {
            *position += Vector::from_fn(|_, _| random.next().unwrap() * step);
        }
        sample(time, &positions, &mut |sample| instrument.sample(sample, &system));
        now = time;
    }
    let measured = report(&instrument, &system);
    let number = number(&measured, "diffusion_coefficient");
    crate::analysis::statistics::Estimate { mean: number.mean.unwrap_or(0.5), standard_error: number.standard_error }
}

#[test]
fn the_error_of_few_spans_is_that_of_brownian_motion() {
    // With few origins and few particles, only the scatter of axes gives an error. The exact diffusion coefficient is
    // 1/2.
    for spans in [4.0, 8.0] {
        let estimates: Vec<_> = (1..=150).map(|seed| brownian(seed, spans)).collect();
        let given: Vec<[f64; 2]> = estimates
            .iter()
            .filter_map(|estimate| Some([(estimate.mean - 0.5).powi(2), estimate.standard_error?.powi(2)]))
            .collect();
        let [scatter, claimed] = [0, 1].map(|k| given.iter().map(|both| both[k]).sum::<f64>());
        let ratio = (scatter / claimed).sqrt();
        println!("{spans} spans: {ratio:.2}, given {}", given.len());
        // A run gives no estimate if its curve is bent by chance. The scatter of 150 estimates is known to 6 %.
        // Student's factor increases the errors by up to 10 %.
        assert!(given.len() > 100 && (0.7..1.25).contains(&ratio), "{spans} spans: {ratio}, {}", given.len());
    }
}

#[test]
fn beads_of_one_chain_count_as_one_sample() {
    let (chains, beads) = (16_u32, 8_u32);
    let mut system = SystemDescription::of_points(Space::periodic_cube(10.0), chains * beads);
    system.bonds =
        (0..chains * beads - 1).filter(|id| !(id + 1).is_multiple_of(beads)).map(|id| [id, id + 1]).collect();
    // The first bead of each chain is in a different cell, and the other beads are spread over the whole box.
    let place = |id: u32| {
        let cell = if id.is_multiple_of(beads) { id / beads } else { (7 * id) % 27 };
        Vector::new(f64::from(cell % 3), f64::from(cell / 3 % 3), f64::from(cell / 9)) * 3.3 + Vector::repeat(1.0)
    };
    let positions: Vec<Vector> = (0..chains * beads).map(place).collect();
    let velocities = vec![Vector::zeros(); positions.len()];
    let images = vec![[0; 3]; positions.len()];
    let sample = Sample { positions: &positions, velocities: &velocities, images: &images, ..Sample::default() };
    let tracers = Tracers::new(&sample, &system, usize::MAX);
    let of_chain = crate::analysis::statistics::tests::correlated(0.0, chains as usize, 5);
    let mean = of_chain.iter().sum::<f64>() / f64::from(chains);
    let variance = of_chain.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / f64::from(chains * (chains - 1));
    let scale = 1.0 / tracers.free_part_of(0).unwrap();
    let found = tracers.variance_of_mean(0, |bead| of_chain[bead / beads as usize]).unwrap();
    assert!((found / (variance * scale * scale) - 1.0).abs() < 1e-10, "{found} {variance}");
}
