use super::*;
use crate::analysis::instruments::quantity::Curve;
use crate::analysis::instruments::test_system::{
    Recorded, equilibrate, instrument, measure, report, sample, start, unlike_spheres,
};
use crate::engine::Simulation;
use crate::model::potential::Potential;
use crate::model::random::{Purpose, Random};
use crate::model::space::{Boundary, Space};
use crate::scene::{Arrangement, Fill, InteractionDraft, Model, SceneBuilder, SpeciesDraft};

/// Products with these masses are rounded, because the masses are not powers of two.
const MASSES: [f64; 2] = [0.7, 3.3];

fn space(dimensions: usize) -> Space {
    let mut space = Space::periodic_cube(30.0);
    space.boundary[dimensions..].fill(Boundary::Flat);
    for k in dimensions..3 {
        space.size[k] = 0.0;
    }
    space
}

fn mixture(space: Space, counts: &[u64], is_hard: bool, drawn: impl Fn(SceneBuilder) -> SceneBuilder) -> SceneBuilder {
    let names: Vec<String> = (0..counts.len()).map(|k| format!("S{k}")).collect();
    let mut scene = SceneBuilder::new("mixture").space(space).seed(3);
    for (k, name) in names.iter().enumerate() {
        scene = scene.species(SpeciesDraft::new(name).mass(MASSES[k % 2] + (k / 2) as f64).diameter(1.0));
    }
    for (k, a) in names.iter().enumerate() {
        for b in &names[k..] {
            scene = match is_hard {
                true => scene.interaction(InteractionDraft::new(Potential::hard_sphere(1.0).unwrap()).between(a, b)),
                false => scene.interaction(InteractionDraft::new(Model::None).between(a, b)),
            };
        }
    }
    for (name, count) in names.iter().zip(counts) {
        scene = scene.fill(Fill::new(Arrangement::Random, name).count(*count));
    }
    drawn(scene)
}

fn plan(windows: u64, bins: u64) -> plan::Speeds {
    plan::Speeds { windows: Some(windows), bins: Some(bins), ..plan::Speeds::default() }
}

fn speeds(plan: &plan::Speeds, simulation: &Simulation, system: &SystemDescription, duration: f64) -> Speeds {
    instrument(simulation, system, duration, |setup| Speeds::new(plan, setup))
}

fn width(curve: &Curve) -> f64 {
    2.0 * curve.variables[0].values[0]
}

fn integral(curve: &Curve, window: usize) -> f64 {
    curve.series[window].values.iter().flatten().sum::<f64>() * width(curve)
}

#[test]
fn free_particles_of_one_speed_are_in_one_bin_in_every_dimension() {
    for dimensions in 1..=3 {
        let scene = mixture(space(dimensions), &[48, 10], false, |scene| scene.speed(0.9)).build().unwrap();
        let (system, mut simulation) = start(scene);
        let mut instrument = speeds(&plan(3, 100), &simulation, &system, 6.0);
        measure(&mut simulation, &system, &mut instrument, 6.0);
        let measured = report(&instrument, &system);
        assert_eq!(measured.curves.len(), 2);
        for (name, curve) in ["speeds_S0", "speeds_S1"].into_iter().zip(&measured.curves) {
            assert_eq!((curve.name.as_str(), curve.series.len()), (name, 3));
            let bin = trunc_to_usize(0.9 / width(curve));
            for (window, series) in curve.series.iter().enumerate() {
                assert!((series.values[bin].unwrap() * width(curve) - 1.0).abs() < 4.0 * f64::EPSILON);
                let others = series.values.iter().enumerate().filter(|(k, _)| *k != bin);
                assert!(others.flat_map(|(_, value)| value).all(|value| *value == 0.0));
                assert!((integral(curve, window) - 1.0).abs() < 4.0 * f64::EPSILON);
            }
            let names: Vec<_> = curve.series.iter().map(|series| series.name.as_str()).collect();
            assert_eq!(names, ["p(v) from 0 to 2", "p(v) from 2 to 4", "p(v) from 4 to 6"]);
            // The published curve lacks the tail beyond four thermal speeds: a fraction of 6e-5 in one dimension, and
            // 1e-3 in three.
            let published = &curve.published[0];
            let sum = published.y.iter().sum::<f64>() * width(curve);
            assert!(sum <= 1.0 + 1e-12 && sum > 0.998, "{sum}");
        }
    }
}

/// Passes frames of independent normal velocities of temperature 1.5 to an instrument, at times 1, 2, ...
fn drawn(system: &SystemDescription, plan: &plan::Speeds, frames: u32) -> Measured {
    let mut random = Random::new(11, Purpose::Velocities, 0);
    let positions = vec![Vector::zeros(); system.masses.len()];
    let mut frame = || -> Vec<Vector> {
        system.masses.iter().map(|mass| random.normal_vector(&system.space) * (1.5 / mass).sqrt()).collect()
    };
    let at_rest = vec![Vector::zeros(); system.masses.len()];
    let setup = Setup { system, sample: sample(0.0, &positions, &at_rest), duration: f64::from(frames) };
    let mut instrument = Speeds::new(plan, &setup);
    for k in 1..=frames {
        let velocities = frame();
        instrument.sample(&sample(f64::from(k), &positions, &velocities), system);
    }
    report(&instrument, system)
}

/// Returns chi-squared per bin, `sum (n - e)^2 / e`, and the number of bins. Bins with at most 20 expected particles
/// are left out. `all` is the number of particles, summed over all samples.
fn chi_squared(curve: &Curve, window: usize, all: f64) -> (f64, f64) {
    let each = curve.series[window].values.iter().zip(&curve.published[0].y);
    let terms = each.map(|(value, expected)| (value.unwrap() * width(curve) * all, expected * width(curve) * all));
    let terms: Vec<f64> = terms.filter(|(_, e)| *e > 20.0).map(|(n, e)| (n - e) * (n - e) / e).collect();
    (terms.iter().sum::<f64>() / terms.len() as f64, terms.len() as f64)
}

#[test]
fn thermal_speeds_match_maxwell_for_few_unequal_particles() {
    for dimensions in 1..=3 {
        let scene = mixture(space(dimensions), &[5, 4], false, |scene| scene.temperature(1.5)).build().unwrap();
        let system = SystemDescription::of(&scene);
        let frames = 6000;
        // A single window of 6001 frames. In the first frame, all particles are at rest.
        let measured = drawn(&system, &plan::Speeds { interval: Some(1.0), ..plan(1, 100) }, frames);
        for (curve, count) in measured.curves.iter().zip([5.0, 4.0]) {
            let (chi, bins) = chi_squared(curve, 0, count * f64::from(frames));
            let first = curve.series[0].values[0].unwrap();
            // The first bin contains the particles at rest. They are one in 6001, so the expected numbers are too large
            // by this fraction.
            assert!(first > 0.0 && bins > 25.0);
            let deviation = (2.0 / bins).sqrt();
            assert!((chi - 1.0).abs() < 5.0 * deviation, "{dimensions} {}: {chi} of {bins}", curve.name);
        }
    }
}

#[test]
fn many_species_share_one_curve_and_a_sum_of_maxwells() {
    let scene = mixture(space(2), &[6; 10], false, |scene| scene.temperature(1.5)).build().unwrap();
    let system = SystemDescription::of(&scene);
    let measured = drawn(&system, &plan::Speeds { interval: Some(1.0), ..plan(1, 60) }, 600);
    assert_eq!(measured.curves.len(), 1);
    assert_eq!(measured.curves[0].name, "speeds");
    let (chi, bins) = chi_squared(&measured.curves[0], 0, 60.0 * 601.0);
    assert!(bins > 20.0 && (chi - 1.0).abs() < 5.0 * (2.0 / bins).sqrt(), "{chi} of {bins}");
}

#[test]
fn individual_masses_have_a_sum_of_maxwells() {
    let (system, _) = unlike_spheres(24);
    let each = system.masses.iter().copied().fold([f64::INFINITY, 0.0], |[a, b], mass| [mass.min(a), mass.max(b)]);
    assert!(each[1] > 10.0 * each[0], "{each:?}");
    let measured = drawn(&system, &plan::Speeds { interval: Some(1.0), ..plan(1, 60) }, 2000);
    assert_eq!(measured.curves[0].name, "speeds");
    let (chi, bins) = chi_squared(&measured.curves[0], 0, 24.0 * 2001.0);
    assert!(bins > 20.0 && (chi - 1.0).abs() < 5.0 * (2.0 / bins).sqrt(), "{chi} of {bins}");
}

#[test]
fn nearly_equal_masses_are_replaced_by_their_mean() {
    assert_eq!(counted(vec![0.7; 3]), [(0.7, 3)]);
    let counts = counted(vec![3.3, 0.7, 1.0011, 1.0, 0.7, 1.0, 1.0021]);
    let expected = [(0.7, 2), (3.0011 / 3.0, 3), (1.0021, 1), (3.3, 1)];
    for ((mass, count), (exact, number)) in counts.iter().zip(expected) {
        assert!((mass - exact).abs() < 1e-15 && *count == number, "{counts:?}");
    }
    assert_eq!(counts.len(), 4);
}

#[test]
fn equal_speeds_of_a_mixture_become_maxwells_distribution() {
    for (dimensions, scale) in [(2, 0.6), (3, 0.3)] {
        let space = Space { size: space(dimensions).size * scale, ..space(dimensions) };
        let scene = mixture(space, &[90, 60], true, |scene| scene.speed(1.1)).build().unwrap();
        let (system, mut simulation) = start(scene);
        let first = plan::Speeds { window: Some(0.2), windows: Some(2), ..plan::Speeds::default() };
        let mut instrument = speeds(&first, &simulation, &system, 3.0);
        measure(&mut simulation, &system, &mut instrument, 3.0);
        for curve in &report(&instrument, &system).curves {
            let bin = trunc_to_usize(1.1 / width(curve));
            let [early, late] = [0, 1].map(|window| curve.series[window].values[bin].unwrap());
            assert!(early > 1.5 * late && early > 3.0 * curve.published[0].y[bin], "{early} {late}");
            assert_eq!(curve.series[1].name, "p(v) from 0.2 to 3");
        }
        equilibrate(&mut simulation, 60);
        let mut instrument = speeds(&plan(2, 60), &simulation, &system, 160.0);
        measure(&mut simulation, &system, &mut instrument, 160.0);
        for curve in &report(&instrument, &system).curves {
            for (window, series) in curve.series.iter().enumerate() {
                assert!((integral(curve, window) - 1.0).abs() < 1e-12);
                let bins = series.values.iter().zip(&series.standard_errors).zip(&curve.published[0].y);
                let terms: Vec<f64> = bins
                    .filter(|(_, expected)| **expected * width(curve) > 0.004)
                    .map(|((value, error), expected)| ((value.unwrap() - expected) / error.unwrap()).powi(2))
                    .collect();
                let chi = terms.iter().sum::<f64>() / terms.len() as f64;
                // There are about 25 bins. The error of each bin is uncertain by at least an eighth.
                assert!(terms.len() > 20 && (0.4..2.0).contains(&chi), "{} {window}: {chi}", curve.name);
            }
        }
    }
}

#[test]
fn bins_grow_with_the_fastest_particle_unless_the_end_is_given() {
    let scene = mixture(space(2), &[40], false, |scene| scene.temperature(1.0)).build().unwrap();
    let system = SystemDescription::of(&scene);
    let positions = vec![Vector::zeros(); 40];
    let show = |plan: &plan::Speeds| {
        let mut velocities: Vec<Vector> = (0..40).map(|k| Vector::x() * if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let setup = Setup { system: &system, sample: sample(0.0, &positions, &velocities), duration: 10.0 };
        let mut instrument = Speeds::new(plan, &setup);
        for k in 1..=10 {
            (velocities[0], velocities[1]) = (Vector::x() * f64::from(k * k), -Vector::x() * f64::from(k * k));
            instrument.sample(&sample(f64::from(k), &positions, &velocities), &system);
        }
        report(&instrument, &system).curves.remove(0)
    };
    let every = plan::Speeds { interval: Some(1.0), ..plan(2, 50) };
    let grown = show(&every);
    assert!((integral(&grown, 0) - 1.0).abs() < 1e-14 && (integral(&grown, 1) - 1.0).abs() < 1e-14);
    // The second window has five frames. The two fast particles have bins of their own.
    let at = |speed: f64| grown.series[1].values[trunc_to_usize(speed / width(&grown))].unwrap() * width(&grown);
    assert!((at(1.0) - 0.95).abs() < 1e-12 && at(100.0) > 0.008 && width(&grown) * 50.0 > 100.0);
    let ended = show(&plan::Speeds { largest: Some(2.0), ..every });
    assert_eq!((ended.variables[0].values.len(), width(&ended)), (50, 0.04));
    assert!((integral(&ended, 1) - 0.95).abs() < 1e-12, "{}", integral(&ended, 1));
    assert!(ended.method.contains("faster ones included"));
}

#[test]
fn resting_particles_give_no_curve_and_one_species_can_be_selected() {
    let scene = mixture(space(3), &[4, 3], false, |scene| scene).build().unwrap();
    let (system, mut simulation) = start(scene);
    let mut instrument = speeds(&plan(4, 10), &simulation, &system, 1.0);
    measure(&mut simulation, &system, &mut instrument, 1.0);
    assert_eq!(report(&instrument, &system), Measured::default());
    let scene = mixture(space(3), &[4, 3], false, |scene| scene.temperature(1.0)).build().unwrap();
    let (system, simulation) = start(scene);
    let only = plan::Speeds { species: Some("S1".to_owned()), ..plan(4, 10) };
    let measured = report(&speeds(&only, &simulation, &system, 1.0), &system);
    assert_eq!(measured.curves.len(), 1);
    assert!(measured.curves[0].name == "speeds" && measured.curves[0].method.contains("all 3 of them"));
    let scene = mixture(space(2), &[1], false, |scene| scene.speed(1.0)).build().unwrap();
    let (system, simulation) = start(scene);
    let measured = report(&speeds(&plan(1, 10), &simulation, &system, 1.0), &system);
    assert_eq!(measured.curves[0].published[0].label, "Maxwell at T = 0.35");
}

#[test]
fn restored_speeds_continue_bitwise() {
    let scene = mixture(space(2), &[20, 20], true, |scene| scene.speed(1.0)).build().unwrap();
    let (system, mut simulation) = start(scene);
    let mut both = Recorded::new(speeds(&plan(3, 40), &simulation, &system, 4.0));
    for _ in 0..4 {
        measure(&mut simulation, &system, &mut both, 1.0);
    }
    assert_eq!(report(&both.again, &system), report(&both.instrument, &system));
    assert_eq!(report(&both, &system).curves[0].series.len(), 3);
}
