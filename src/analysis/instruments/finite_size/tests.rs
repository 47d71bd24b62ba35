use super::*;
use crate::Vector;
use crate::analysis::instruments::diffusion::Diffusion;
use crate::analysis::instruments::quantity::Curve;
use crate::analysis::instruments::test_system::{self, equilibrate, hard_spheres, instrument, measure, report};
use crate::model::measurement_plan::Diffusion as Plan;
use crate::model::space::{Boundary, Space};

fn number(name: &str, mean: f64, error: Option<f64>) -> Number {
    let estimate = Some(Estimate { mean, standard_error: error });
    Number::estimated(name, "Title", "1", estimate, "")
}

/// Returns a mean squared displacement and a velocity autocorrelation at the temperature 1.5. Only the times of the
/// displacement and the first value of the autocorrelation are used.
fn curves(system: &SystemDescription, interval: f64) -> [Curve; 2] {
    let inverse_mass: f64 = system.masses.iter().map(|mass| 1.0 / mass).sum::<f64>() / system.masses.len() as f64;
    let squares = [Estimate { mean: system.space.dimensions() as f64 * 1.5 * inverse_mass, standard_error: None }; 9];
    let curve = |name: &str| {
        let times = (0..9).map(|k| interval * f64::from(k)).collect();
        Curve::new(name, "", "").variable("t", "time", times).series("", "1", &squares.map(Some))
    };
    [curve(DISPLACEMENT), curve(CORRELATION)]
}

/// Corrects a measurement in which both diffusion coefficients are 0.1 ± 0.003.
fn extended_over(interval: f64, system: &SystemDescription, viscosity: Option<Number>) -> Measured {
    let mut measured = Measured::default();
    measured.numbers.extend([number(COEFFICIENT, 0.1, Some(0.003)), number(GREEN_KUBO, 0.1, Some(0.003))]);
    measured.numbers.extend([number("diffusion_coefficient_A", 0.2, None)]);
    measured.numbers.extend(viscosity);
    measured.curves.extend(curves(system, interval));
    complete_diffusion(&mut measured, system);
    measured
}

/// The span is so long that all flows have decayed.
fn extended(system: &SystemDescription, viscosity: Option<Number>) -> Measured {
    extended_over(100.0, system, viscosity)
}

/// One particle of species A, with half of the total mass, and seven particles of species B.
fn cube() -> SystemDescription {
    let mut system = SystemDescription::of_points(Space::periodic_cube(10.0), 8);
    system.species_names.push("B".to_owned());
    system.diameters.push(1.3);
    (system.species, system.masses) = (vec![1; 8], vec![1.0; 8]);
    (system.species[3], system.masses[3]) = (0, 7.0);
    system
}

fn viscosity() -> Number {
    number(VISCOSITY, 2.0, Some(0.4))
}

fn names(measured: &Measured) -> Vec<&str> {
    measured.numbers.iter().map(|number| number.name.as_str()).collect()
}

#[test]
fn cubic_box_has_the_yeh_hummer_correction_with_both_errors() {
    let measured = extended(&cube(), Some(viscosity()));
    let all = [
        "diffusion_coefficient",
        "diffusion_coefficient_infinite",
        "diffusion_coefficient_green_kubo",
        "diffusion_coefficient_A",
        "diffusion_coefficient_infinite_A",
        "shear_viscosity",
    ];
    assert_eq!(names(&measured), all);
    // The finite-size term is 2.837297 * 1.5 / (6 pi * 2 * 10) = 4.2559455 / 376.991118, times nu / (nu + 0.1) with nu
    // = 2 * 1000 / 14. It has the relative error of the viscosity, 0.4 / 2.
    let whole = 0.011_289_246;
    let term = whole * 0.999_300_49;
    let infinite = measured.number("diffusion_coefficient_infinite").unwrap();
    // In the frame of the centre of mass, D of eight particles is smaller by the factor 7/8.
    assert!((infinite.mean.unwrap() - (0.0875 + term)).abs() < 1e-9, "{infinite:?}");
    let error = (0.875 * 0.003_f64 * (0.875 * 0.003) + 0.04 * term * term).sqrt();
    assert!((infinite.standard_error.unwrap() - error).abs() < 3e-6, "{infinite:?}");
    assert_eq!((infinite.unit.as_str(), infinite.title.as_str()), ("1", "Title, infinite system"));
    // The measured coefficient of A has no error, so the corrected coefficient has no error either.
    let of_species = measured.number("diffusion_coefficient_infinite_A").unwrap();
    assert!(
        (of_species.mean.unwrap() - (0.5 * 0.2 + whole * 0.998_601_96)).abs() < 1e-9
            && of_species.standard_error.is_none()
    );
}

#[test]
fn no_correction_without_a_known_viscosity() {
    assert_eq!(names(&extended(&cube(), None)).len(), 3);
    for unknown in [number(VISCOSITY, 2.0, Some(0.7)), number(VISCOSITY, 2.0, None), number(VISCOSITY, -1.0, Some(0.1))]
    {
        let measured = extended(&cube(), Some(unknown));
        assert_eq!(measured.number("diffusion_coefficient_infinite").unwrap().mean, None);
    }
    let insufficient = Number::estimated(VISCOSITY, "", "1", None, "");
    let measured = extended(&cube(), Some(insufficient));
    assert_eq!(measured.number("diffusion_coefficient_infinite").unwrap().mean, None);
}

#[test]
fn no_correction_if_mean_free_path_exceeds_the_box() {
    let system = cube();
    let measured = |coefficient: f64| {
        let mut measured = Measured::default();
        measured.numbers.extend([number(COEFFICIENT, coefficient, Some(0.003)), viscosity()]);
        measured.curves.extend(curves(&system, 1e4));
        complete_diffusion(&mut measured, &system);
        measured.number("diffusion_coefficient_infinite").unwrap().mean
    };
    // The mean free path `l` follows from `D = 0.95778 sqrt(<v^2> / 3) l`. For `D = 1.7641`, it equals `L / (2 pi)`
    // with `L = 10`. For one mass of 7 and seven masses of 1, `<v^2> / 3 = 1.5 (7 + 1 / 7) / 8`.
    assert!(measured(1.76).is_some() && measured(1.77).is_none(), "{:?} {:?}", measured(1.76), measured(1.77));
}

#[test]
fn no_correction_for_unsupported_systems() {
    let is_there = |system: &SystemDescription| names(&extended(system, Some(viscosity()))).len() > 4;
    assert!(is_there(&cube()));
    let changed = |change: fn(&mut SystemDescription)| {
        let mut system = cube();
        change(&mut system);
        system
    };
    for change in [
        (|system| system.space.size = Vector::new(10.0, 10.0, 10.001)) as fn(&mut SystemDescription),
        |system| (system.space.boundary[2], system.space.size.z) = (Boundary::Flat, 0.0),
        |system| system.is_homogeneous = false,
        |system| system.is_accelerated = true,
        |system| system.is_elastic = false,
        |system| system.conserves_momentum = false,
        |system| system.shear_rate = 0.1,
    ] {
        assert!(!is_there(&changed(change)));
    }
}

#[test]
fn flows_that_have_not_decayed_are_added_and_are_in_the_error() {
    let system = cube();
    // Lags from 0.01 to 0.04, a total mass of 14, and a volume of 1000.
    let tail = |viscosity: f64, coefficient: f64| VelocityTail {
        temperature_by_mass: 1.5 / 14.0,
        spreading: viscosity * 1000.0 / 14.0 + coefficient,
        periods: &[10.0; 3],
    };
    let measured = extended_over(0.005, &system, Some(viscosity()));
    let missed = tail(2.0, 0.1).beyond_slope([0.01, 0.04]);
    let coefficient = measured.number(COEFFICIENT).unwrap();
    assert!(missed > 1e-3 && coefficient.mean == Some(0.1));
    let error = coefficient.standard_error.unwrap();
    assert!((error / libm::hypot(0.003, missed) - 1.0).abs() < 1e-12, "{error} {missed}");
    let integral = measured.number(GREEN_KUBO).unwrap().standard_error.unwrap();
    assert!((integral / libm::hypot(0.003, tail(2.0, 0.1).beyond(0.04)) - 1.0).abs() < 1e-12);
    let infinite = measured.number("diffusion_coefficient_infinite").unwrap();
    assert!(
        (infinite.mean.unwrap() - (0.875 * (0.1 + missed) + 0.011_289_246 * 0.999_25)).abs() < 1e-6,
        "{infinite:?}"
    );
    assert_eq!(measured.number("diffusion_coefficient_A").unwrap().standard_error, None);

    let guessed = free_time::viscosity(&system, 1.5).unwrap();
    let missed = tail(guessed, 0.1).beyond_slope([0.01, 0.04]);
    let error = extended_over(0.005, &system, None).number(COEFFICIENT).unwrap().standard_error.unwrap();
    assert!((error / libm::hypot(0.003, missed) - 1.0).abs() < 1e-12, "{error} {missed}");
}

#[test]
fn span_missing_over_a_tenth_gives_no_infinite_system_value() {
    let system = cube();
    let slow = number(VISCOSITY, 0.2, Some(0.001));
    let measured = extended_over(0.005, &system, Some(slow));
    let missed = measured.number(COEFFICIENT).unwrap().standard_error.unwrap();
    assert!(missed > 0.01, "{missed}");
    assert_eq!(measured.number("diffusion_coefficient_infinite").unwrap().mean, None);
}

#[test]
fn a_short_span_and_a_long_one_have_the_same_infinite_system() {
    let duration = 600.0;
    let of_span = |span: f64| {
        let (system, mut simulation) = hard_spheres(256, 0.35);
        equilibrate(&mut simulation, 50);
        let plan = Plan { interval: Some(0.05), span: Some(span) };
        let mut diffusion = instrument(&simulation, &system, duration, |setup| Diffusion::new(&plan, setup));
        measure(&mut simulation, &system, &mut diffusion, duration);
        let mut measured = report(&diffusion, &system);
        let raw = test_system::estimate(&measured, COEFFICIENT);
        measured.numbers.push(number(VISCOSITY, 1.08, Some(0.01)));
        complete_diffusion(&mut measured, &system);
        (
            raw,
            test_system::estimate(&measured, COEFFICIENT).1,
            test_system::estimate(&measured, "diffusion_coefficient_infinite"),
        )
    };
    let [(short, with_tail, first), (long, without, second)] = [1.5, 10.0].map(of_span);
    // Both runs have the same particles at the same times, so their noise is nearly the same. The short span misses
    // about a twentieth of the coefficient.
    assert!(long.0 - short.0 > 0.04 * long.0, "{short:?} {long:?}");
    assert!(with_tail > 3.0 * short.1 && without < 1.1 * long.1, "{with_tail} {without} {short:?} {long:?}");
    // The theory of the tail requires long times. At ten mean free times, the error is up to a tenth of the tail.
    let tail = libm::sqrt(with_tail * with_tail - short.1 * short.1);
    let error = libm::hypot(long.1, 0.1 * tail);
    assert!((first.0 - second.0).abs() < 3.0 * error, "{first:?} {second:?} {error}");
    assert!(tail > 3.0 * error, "{tail} {error}");
}
