use super::*;
use crate::analysis::instruments::test_system::{
    Recorded, equilibrate, estimate, hard_spheres, instrument, measure, report, start,
};
use crate::model::space::{Boundary, Space};
use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

fn series(measured: &Measured, curve: &str, name: &str) -> Vec<(f64, f64, f64)> {
    let curve = measured.curve(curve).unwrap();
    let series = curve.series.iter().find(|series| series.name == name).unwrap();
    let values = series.values.iter().zip(&series.standard_errors);
    let rows = curve.variables[0].values.iter().zip(values);
    rows.filter_map(|(time, (value, error))| Some((*time, (*value)?, error.unwrap_or(0.0)))).collect()
}

/// Two particles that fly apart at a relative speed `2 v` from their centre of mass.
#[test]
fn free_flight_is_exact_in_one_two_and_three_dimensions() {
    for dimensions in 1..=3 {
        let mut space = Space::periodic_cube(1e6);
        for axis in dimensions..3 {
            (space.boundary[axis], space.size[axis]) = (Boundary::Flat, 0.0);
        }
        let (velocity, drift) = (0.35, 0.2);
        let scene = SceneBuilder::new("two")
            .space(space)
            .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .particle("A", Vector::new(3e5, 0.0, 0.0), Vector::new(drift - velocity, 0.0, 0.0))
            .particle("A", Vector::new(6e5, 0.0, 0.0), Vector::new(drift + velocity, 0.0, 0.0));
        let (system, mut simulation) = start(scene.build().unwrap());
        let settings =
            plan::Relaxation { wave_number: Some(2.3), overlap: Some(0.9), interval: Some(0.1), span: Some(20.0) };
        let mut relaxation =
            Recorded::new(instrument(&simulation, &system, 100.0, |setup| Relaxation::new(&settings, setup)));
        measure(&mut simulation, &system, &mut relaxation, 100.0);
        let measured = report(&relaxation, &system);
        let scattering = series(&measured, "relaxation", "F_s(q,t)");
        assert_eq!(scattering.len(), 15, "1, 2, 3, 4, 6, ... 192 ticks");
        for (time, value, _) in scattering {
            let x = 2.3 * velocity * time;
            let exact = [libm::cos(x), libm::j0(x), libm::sin(x) / x][dimensions - 1];
            // Positions of about 1e6 have rounding errors of about 1e-10.
            assert!((value - exact).abs() < 1e-8, "{dimensions} {time} {value} {exact}");
        }
        for (time, value, _) in series(&measured, "relaxation", "Q(t)") {
            assert_eq!(value, if velocity * time < 0.9 { 1.0 } else { 0.0 }, "{time}");
        }
        assert!(series(&measured, "four_point_susceptibility", "chi_4(t)").iter().all(|(_, value, _)| *value == 0.0));
    }
}

/// After one passage through a box, a particle between walls has moved from `x` to `L - x`. The displacement is uniform
/// in `[-L, L]`.
#[test]
fn susceptibility_of_one_particle_between_walls_is_exact() {
    let length = 2.0;
    let boundary = [Boundary::walls(1.0), Boundary::Flat, Boundary::Flat];
    let space = Space { lower: Vector::zeros(), size: Vector::new(length + 1.0, 0.0, 0.0), boundary };
    let scene = SceneBuilder::new("one")
        .space(space)
        .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .particle("A", Vector::new(1.1, 0.0, 0.0), Vector::new(1.0, 0.0, 0.0));
    let (system, mut simulation) = start(scene.build().unwrap());
    let settings =
        plan::Relaxation { wave_number: Some(1.7), overlap: Some(0.6), interval: Some(length), span: Some(5.0) };
    let mut relaxation = instrument(&simulation, &system, 4_000.0, |setup| Relaxation::new(&settings, setup));
    // One passage takes the time `L`. The interval is one passage, so the origins would always be at the same place.
    relaxation.ticks.tick = length / 64.0 * 1.000_618;
    relaxation.longest = 64;
    relaxation.apart = 64 + 13;
    relaxation.origins.clear();
    relaxation.look(&crate::analysis::instruments::Sample::of(&simulation.snapshot()), &system, 0);
    measure(&mut simulation, &system, &mut relaxation, 4_000.0);
    let measured = report(&relaxation, &system);
    let last = |curve: &str, name: &str| *series(&measured, curve, name).last().unwrap();
    let (time, scattering, _) = last("relaxation", "F_s(q,t)");
    assert!((time / length - 1.000_618).abs() < 1e-12);
    let x = 1.7 * length;
    // The lag is longer than a passage by 0.06 %, and about 1,600 origins are spread evenly over the box.
    assert!((scattering - libm::sin(x) / x).abs() < 0.01, "{scattering}");
    let (_, overlap, _) = last("relaxation", "Q(t)");
    let exact = 0.6 / length;
    assert!((overlap - exact).abs() < 0.01, "{overlap} {exact}");
    let (_, susceptibility, _) = last("four_point_susceptibility", "chi_4(t)");
    assert!((susceptibility - exact * (1.0 - exact)).abs() < 0.01, "{susceptibility}");
}

/// At short times, `F_s = exp(-q^2 T t^2 / (2 m))`, and the relaxation time is `sqrt(2 m / T) / q`.
#[test]
fn relaxation_at_a_large_wave_number_is_that_of_free_flight() {
    let (system, mut simulation) = hard_spheres(108, 0.05);
    equilibrate(&mut simulation, 20);
    let settings = plan::Relaxation {
        wave_number: Some(40.0),
        interval: Some(4e-3),
        span: Some(0.2),
        ..plan::Relaxation::default()
    };
    let mut relaxation =
        Recorded::new(instrument(&simulation, &system, 50.0, |setup| Relaxation::new(&settings, setup)));
    measure(&mut simulation, &system, &mut relaxation, 50.0);
    let (time, error) = estimate(&report(&relaxation, &system), "relaxation_time");
    let exact = 2.0_f64.sqrt() / 40.0;
    // Linear interpolation between times that differ by a factor of 4/3 is wrong by up to 1 %.
    assert!((time / exact - 1.0).abs() < 0.01 + 5.0 * error / exact, "{time} {error} {exact}");
    assert!(error < 0.02 * exact, "{error}");
}

#[test]
fn defaults_follow_from_diameters_and_free_times() {
    let (system, simulation) = hard_spheres(500, 0.3);
    let relaxation =
        instrument(&simulation, &system, 100.0, |setup| Relaxation::new(&plan::Relaxation::default(), setup));
    assert_eq!((relaxation.wave_number, relaxation.overlap), (TAU, 0.3));
    assert!((relaxation.ticks.tick / 0.0199 - 1.0).abs() < 0.02, "{}", relaxation.ticks.tick);
    assert_eq!(relaxation.longest, trunc_to_u64(25.0 / relaxation.ticks.tick));
    assert_eq!(relaxation.apart, relaxation.longest.div_ceil(64));
}
