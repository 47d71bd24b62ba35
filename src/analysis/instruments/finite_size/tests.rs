use super::*;
use crate::Vector;
use crate::model::space::{Boundary, Space};

fn number(name: &str, mean: f64, error: Option<f64>) -> Number {
    let estimate = Some(Estimate { mean, standard_error: error });
    Number::estimated(name, "Title", "1", estimate, "")
}

/// Points in a cube of edge 10 with a diffusion coefficient of 0.1 ± 0.003, by both methods, and a viscosity.
fn extended(system: &SystemDescription, viscosity: Option<Number>) -> Measured {
    let mut measured = Measured::default();
    measured.numbers.extend([number(COEFFICIENT, 0.1, Some(0.003)), number(GREEN_KUBO, 0.1, Some(0.003))]);
    measured.numbers.extend([number("diffusion_coefficient_A", 0.2, None)]);
    measured.numbers.extend(viscosity);
    add_infinite_diffusion(&mut measured, system, 1.5);
    measured
}

/// A particle of A with half of the mass, and seven of B.
fn cube() -> SystemDescription {
    let mut system = SystemDescription::of_points(Space::periodic_cube(10.0), 8);
    system.species_names.push("B".to_owned());
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
fn a_cube_has_the_term_of_yeh_and_hummer_with_both_errors() {
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
    // By hand: 2.837297 * 1.5 / (6 pi * 2 * 10) = 4.2559455 / 376.991118, with an error of a fifth.
    let term = 0.011_289_246;
    let infinite = measured.number("diffusion_coefficient_infinite").unwrap();
    // Eight particles: seven eighths of D are in the frame of the centre of mass.
    assert!((infinite.mean.unwrap() - (0.0875 + term)).abs() < 1e-9, "{infinite:?}");
    let error = (0.875 * 0.003_f64 * (0.875 * 0.003) + 0.04 * term * term).sqrt();
    assert!((infinite.standard_error.unwrap() - error).abs() < 1e-9, "{infinite:?}");
    assert_eq!((infinite.unit.as_str(), infinite.title.as_str()), ("1", "Title, infinite system"));
    // The term is that of the species, too, and an error that is not known stays so.
    let of_species = measured.number("diffusion_coefficient_infinite_A").unwrap();
    assert!((of_species.mean.unwrap() - (0.5 * 0.2 + term)).abs() < 1e-9 && of_species.standard_error.is_none());
}

#[test]
fn there_is_none_without_a_viscosity_that_is_known() {
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
fn there_is_none_for_another_box() {
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
