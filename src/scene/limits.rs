//! Checks the ranges of numbers in a scene.

use crate::Vector;
use crate::base::memory;
use crate::base::text::shortest;
use crate::model::limits::MOST_PARTICLES;
use crate::model::limits::{LARGEST, is_positive};
use crate::model::space::{Boundary, Space};
use crate::model::{ContactLaw, Restitution, Roughness, Species};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind, missing, refuse};

/// Memory per particle in a simulation `[bytes]`. Hard spheres at a packing fraction of 0.5 need up to 560 bytes.
const BYTES_PER_PARTICLE: u64 = 600;

/// Memory per ordered pair of species in the tables of the event loop `[bytes]`.
const BYTES_PER_PAIR: u64 = 64;

/// Maximum number of species with particles. The event loop numbers them with 16 bits.
const MOST_ROWS: u64 = 1 << 16;

/// Rejects more particles than the memory of the machine or the ids of the engine allow.
pub(crate) fn affordable(particles: u64, at: &ConfigPath) -> Result<(), SceneError> {
    affordable_with(particles, memory::total(), at)
}

fn affordable_with(particles: u64, budget: u64, at: &ConfigPath) -> Result<(), SceneError> {
    let bytes = particles.saturating_mul(BYTES_PER_PARTICLE);
    if bytes > budget {
        return Err(SceneError::new(at.clone(), SceneErrorKind::TooMany { particles, bytes, budget }));
    }
    if particles > MOST_PARTICLES {
        let expected = format!("at most {MOST_PARTICLES}, even with more memory");
        return refuse(at.clone(), format!("a scene of {particles} particles"), expected);
    }
    Ok(())
}

/// Rejects too many species with particles. Ranges of individual diameters count as species. Species numbers have 16
/// bits, and tables of pairs must fit into memory.
pub(crate) fn affordable_species(species: usize) -> Result<(), SceneError> {
    let (species, budget) = (species as u64, memory::total());
    let bytes = species.saturating_mul(species).saturating_mul(BYTES_PER_PAIR);
    if species > MOST_ROWS || bytes > budget {
        let expected = format!(
            "at most {MOST_ROWS}, and pair tables that fit into memory: here the tables need {} of {} GiB",
            bytes >> 30,
            budget >> 30
        );
        let value = format!("{species} species with particles, or ranges of individual diameters");
        return refuse(ConfigPath::root().key("species"), value, expected);
    }
    Ok(())
}

fn check(value: f64, is_good: bool, expected: &str, at: ConfigPath) -> Result<f64, SceneError> {
    if is_good { Ok(value) } else { refuse(at, shortest(value), expected) }
}

/// Returns the expected value for a message: the range if only the range is violated, otherwise the kind of number.
fn instead(is_of_kind: bool, kind: &'static str, range: &'static str) -> &'static str {
    if is_of_kind { range } else { kind }
}

pub(crate) fn finite(value: f64, at: ConfigPath) -> Result<f64, SceneError> {
    let expected = instead(value.is_finite(), "a finite number", "a number from -1e50 to 1e50");
    check(value, value.abs() <= LARGEST, expected, at)
}

pub(crate) fn positive(value: f64, at: ConfigPath) -> Result<f64, SceneError> {
    let is_of_kind = value > 0.0 && value.is_finite();
    let expected = instead(is_of_kind, "a positive finite number", "a number from 1e-50 to 1e50");
    check(value, is_positive(value), expected, at)
}

pub(crate) fn positive_if_given(value: Option<f64>, at: ConfigPath) -> Result<(), SceneError> {
    value.map_or(Ok(()), |value| positive(value, at).map(drop))
}

/// Requires finite corners of a box, with `upper` above `lower` along the given axes.
pub(crate) fn corners(
    lower: &Vector,
    upper: &Vector,
    mut axes: impl Iterator<Item = usize>,
    at: &ConfigPath,
) -> Result<(), SceneError> {
    finite_vector(lower, &at.key("lower"))?;
    finite_vector(upper, &at.key("upper"))?;
    match axes.find(|&k| lower[k] >= upper[k]) {
        Some(k) => refuse(at.key("upper").index(k), upper[k], format!("more than the lower end, {}", lower[k])),
        None => Ok(()),
    }
}

pub(crate) fn not_negative(value: f64, at: ConfigPath) -> Result<f64, SceneError> {
    let is_of_kind = value > 0.0 && value.is_finite();
    let expected = instead(is_of_kind, "zero or a positive finite number", "zero or a number up to 1e50");
    check(value, (0.0..=LARGEST).contains(&value), expected, at)
}

pub(crate) fn restitution(value: f64, at: ConfigPath) -> Result<f64, SceneError> {
    check(value, (0.0..=1.0).contains(&value), "a number from 0 to 1", at)
}

/// Checks the numbers of a contact law.
pub(crate) fn contact_law(law: &ContactLaw, at: &ConfigPath) -> Result<(), SceneError> {
    let key = at.key("restitution");
    match law.restitution {
        Restitution::Constant(value) => restitution(value, key).map(drop)?,
        Restitution::Viscoelastic { viscous_time, stiffness } => {
            not_negative(viscous_time, key.key("viscous_time"))?;
            positive(stiffness, key.key("stiffness"))?;
        }
        Restitution::Table(_) => {}
    }
    let Some(Roughness { tangential_restitution: tangential, friction }) = law.roughness else { return Ok(()) };
    let key = at.key("tangential_restitution");
    check(tangential, (-1.0..=1.0).contains(&tangential), "a number from -1 to 1", key)?;
    check(friction, friction >= 0.0, "zero or a positive number", at.key("friction")).map(drop)
}

pub(crate) fn above_one(value: f64, at: ConfigPath) -> Result<f64, SceneError> {
    let is_of_kind = value > 1.0 && value.is_finite();
    let expected = instead(is_of_kind, "a finite number above 1", "a number above 1, up to 1e50");
    check(value, value > 1.0 && value <= LARGEST, expected, at)
}

pub(crate) fn finite_vector(vector: &Vector, at: &ConfigPath) -> Result<(), SceneError> {
    for (k, &component) in vector.iter().enumerate() {
        finite(component, at.index(k))?;
    }
    Ok(())
}

/// Requires a finite vector other than zero.
pub(crate) fn direction(vector: &Vector, at: &ConfigPath) -> Result<(), SceneError> {
    finite_vector(vector, at)?;
    positive(vector.norm(), at.clone()).map(drop)
}

/// Requires a finite corner and two finite edges in different directions.
pub(crate) fn parallelogram(corner: &Vector, edges: &[Vector; 2], at: &ConfigPath) -> Result<(), SceneError> {
    finite_vector(corner, &at.key("corner"))?;
    finite_vector(&edges[0], &at.key("edge_1"))?;
    finite_vector(&edges[1], &at.key("edge_2"))?;
    // The cross product of parallel edges may be nonzero because of round-off.
    if edges[0].cross(&edges[1]).norm() <= 1e-9 * edges[0].norm() * edges[1].norm() {
        return refuse(at.key("edge_2"), "zero, or parallel to edge_1", "an edge in another direction");
    }
    Ok(())
}

/// Checks a spin. Static particles have no spin. In two dimensions, spins are along the flat axis.
pub(crate) fn spin(spin: &Vector, species: &Species, space: &Space, at: &ConfigPath) -> Result<(), SceneError> {
    finite_vector(spin, at)?;
    let wrong = |k: &usize| spin[*k] != 0.0 && (species.is_static() || !space.turns_about(*k));
    match (0..3).find(wrong) {
        None => Ok(()),
        Some(k) if species.is_static() => refuse(at.index(k), shortest(spin[k]), "0: static particles do not turn"),
        Some(k) => refuse(at.index(k), shortest(spin[k]), "0, because particles turn about a flat axis only"),
    }
}

/// Checks the diameter that is given for a particle. `at` is the config path of the diameter, and `of` is the config
/// path of the particle.
pub(crate) fn diameter(
    given: Option<f64>,
    species: &Species,
    at: ConfigPath,
    of: &ConfigPath,
) -> Result<(), SceneError> {
    match (given, &species.individual) {
        (Some(diameter), Some(_)) => positive(diameter, at).map(drop),
        (None, None) => Ok(()),
        (None, Some(_)) => {
            let why = format!("the species `{}` has individual diameters", species.name);
            Err(missing(of, "diameter", why))
        }
        (Some(diameter), None) => {
            let expected = format!("no diameter: the species `{}` has none of its own for each particle", species.name);
            refuse(at, shortest(diameter), expected)
        }
    }
}

/// Requires a finite vector that equals `flat` along the flat axes.
pub(crate) fn on_flat_axes(vector: &Vector, flat: &Vector, space: &Space, at: &ConfigPath) -> Result<(), SceneError> {
    finite_vector(vector, at)?;
    for k in 0..3 {
        if space.boundary[k] == Boundary::Flat && vector[k] != flat[k] {
            let expected = format!("{} because {} is flat", flat[k], AXES[k]);
            return refuse(at.index(k), vector[k], expected);
        }
    }
    Ok(())
}

pub(crate) fn motion(species: &Species, velocity: &Vector, at: &ConfigPath) -> Result<(), SceneError> {
    if species.is_static() && *velocity != Vector::zeros() {
        return refuse(at.clone(), format!("{:?}", velocity.as_slice()), "none: a static species does not move");
    }
    Ok(())
}

pub(crate) const AXES: [char; 3] = ['x', 'y', 'z'];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_one_float_outside_of_their_range_are_refused() {
        let at = ConfigPath::root;
        assert!(restitution(1.0, at()).is_ok() && restitution(0.0, at()).is_ok());
        assert!(restitution(1.0_f64.next_up(), at()).is_err() && restitution(-1e-300, at()).is_err());
        assert!(above_one(1.0, at()).is_err() && above_one(1.0_f64.next_up(), at()).is_ok());
        assert!(positive(0.0, at()).is_err() && positive(f64::INFINITY, at()).is_err());
        assert!(not_negative(0.0, at()).is_ok() && not_negative(f64::NAN, at()).is_err());
        assert!(finite(f64::NEG_INFINITY, at()).is_err() && finite(-1.0, at()).is_ok());
    }

    #[test]
    fn range_errors_state_the_limits() {
        assert!(LARGEST == 1e50 && positive(1e-50, ConfigPath::root()).is_ok());
        for (result, expected) in [
            (positive(1e300, ConfigPath::root()), "is 1e300, expected a number from 1e-50 to 1e50"),
            (positive(1e-300, ConfigPath::root()), "is 1e-300, expected a number from 1e-50 to 1e50"),
            (positive(-1e300, ConfigPath::root()), "is -1e300, expected a positive finite number"),
            (positive(f64::INFINITY, ConfigPath::root()), "is inf, expected a positive finite number"),
            (finite(-1e51, ConfigPath::root()), "is -1e51, expected a number from -1e50 to 1e50"),
            (not_negative(2.5e60, ConfigPath::root()), "is 2.5e60, expected zero or a number up to 1e50"),
            (above_one(1e60, ConfigPath::root()), "is 1e60, expected a number above 1, up to 1e50"),
            (above_one(0.25, ConfigPath::root()), "is 0.25, expected a finite number above 1"),
        ] {
            assert_eq!(result.unwrap_err().kind().to_string(), expected);
        }
    }

    #[test]
    fn products_of_four_allowed_numbers_are_finite_and_not_zero() {
        let (largest, smallest) = (LARGEST, 1.0 / LARGEST);
        assert!(finite(largest, ConfigPath::root()).is_ok() && finite(largest.next_up(), ConfigPath::root()).is_err());
        assert!(positive(smallest.next_down(), ConfigPath::root()).is_err());
        assert!((9.0 * largest.powi(4)).is_finite() && smallest.powi(4).is_normal());
    }

    #[test]
    fn species_tables_beyond_memory_are_rejected() {
        assert!(affordable_species(1000).is_ok());
        assert!(affordable_species(65_537).is_err() && affordable_species(usize::MAX).is_err());
    }

    #[test]
    fn the_budget_is_checked_without_overflow() {
        assert!(affordable(1_000_000, &ConfigPath::root()).is_ok());
        assert!(affordable(u64::MAX, &ConfigPath::root()).is_err());
    }

    #[test]
    fn more_particles_than_engine_maximum_are_rejected() {
        let with_any_memory = |particles| affordable_with(particles, u64::MAX, &ConfigPath::root());
        assert!(with_any_memory(MOST_PARTICLES).is_ok());
        let error = with_any_memory(MOST_PARTICLES + 1).unwrap_err().to_string();
        assert!(error.contains("a scene of 500000001 particles, expected at most 500000000"), "{error}");
        // The numbers of cells and slots must stay below `u32::MAX`, which marks an empty entry.
        assert!(8 * MOST_PARTICLES + 64 < u64::from(u32::MAX));
    }
}
