//! Single trajectories with exact solutions.

use super::state_point::{Compared, StatePointError, Watch, advance, build};
use super::{Comparison, Effort, Source};
use crate::Vector;
use crate::engine::{Simulation, Until};
use crate::model::ContactLaw;
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Face, Space};
use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};
use std::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2};

pub(super) const BALL: &[&str] = &["time of rest"];
pub(super) const THREE_SPHERES: &[&str] = &["contacts", "time of the last", "x_1", "x_2", "x_3", "energy"];
pub(super) const PENDULUM: &[&str] = &["period"];

const BOUNCES: Source = Source {
    short: "exact, bounces",
    full: "a ball dropped from h comes to rest at t = sqrt(2 h / g) (1 + e) / (1 - e)",
};
const BAMME: Source = Source {
    short: "exact, by hand",
    full: "three elastic spheres, calculated by hand: Bamme and Sbalzarini, A Mathematical Definition of Particle Methods, section 3",
};
const SWINGS: Source =
    Source { short: "exact, pendulum", full: "a rigid pendulum has the period 4 sqrt(L / g) K(sin(theta_0 / 2))" };

/// The TC model prevents flights shorter than this time, so the number of flights is finite.
const CONTACT_TIME: f64 = 1e-9;
/// Largest number of bounces. The flight time reaches the contact time after about `20 / ln(1 / e)` bounces.
const MOST_BOUNCES: u64 = 1000;

pub(super) fn ball(restitution: f64, _: Effort, _: u64, _: Watch<'_>) -> Compared {
    let floor = Boundary::Bounded { lower: Face::Wall(ContactLaw::smooth(restitution)), upper: Face::Open };
    let space =
        Space { lower: Vector::zeros(), size: Vector::repeat(4.0), boundary: [Boundary::OPEN, Boundary::OPEN, floor] };
    let scene = SceneBuilder::new("validate")
        .space(space)
        .gravity(Vector::new(0.0, 0.0, -1.0))
        .contact_time(CONTACT_TIME)
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .particle("A", Vector::new(2.0, 2.0, 1.5), Vector::zeros());
    let mut simulation = Simulation::without_plan(build(&scene)?);
    let expected = SQRT_2 * (1.0 + restitution) / (1.0 - restitution);
    // `rest` is the time of the first contact after which the next flight would be shorter than the contact time.
    let (mut last, mut rest, mut bounces) = (f64::NEG_INFINITY, None, 0.0);
    simulation.advance_with(Until::time(2.0 * expected).or_events(MOST_BOUNCES), |event| {
        if rest.is_none() {
            bounces += 1.0;
            rest = (restitution * (event.time - last) < CONTACT_TIME).then_some(event.time);
        }
        last = event.time;
    })?;
    // Neglected flights would last at most 1, e, e^2, ... contact times. Each bounce rounds a time and a speed.
    let allowance = CONTACT_TIME / (1.0 - restitution) + 8.0 * bounces * expected * f64::EPSILON;
    Ok(vec![
        Comparison::exact(BALL[0], rest, expected, BOUNCES)
            .allow(allowance, "flights shorter than 1e-9, the contact time of the TC model"),
    ])
}

pub(super) fn three_spheres(_: f64, _: Effort, _: u64, _: Watch<'_>) -> Compared {
    let space = Space {
        lower: Vector::new(-1.0, 0.0, 0.0),
        size: Vector::new(4.0, 0.0, 0.0),
        boundary: [Boundary::OPEN, Boundary::Flat, Boundary::Flat],
    };
    let mut builder = SceneBuilder::new("validate")
        .space(space)
        .allow_invalid_start(true)
        .species(SpeciesDraft::new("A").mass(1.0).diameter(0.5))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"));
    for (x, v) in [(0.0, 2.0), (0.49, -1.0), (2.0, 1.0)] {
        builder = builder.particle("A", Vector::new(x, 0.0, 0.0), Vector::new(v, 0.0, 0.0));
    }
    let mut simulation = Simulation::without_plan(build(&builder)?);
    let mut times = Vec::new();
    simulation.advance_with(Until::time(10.0), |event| times.push(event.time))?;
    let end = simulation.snapshot().positions;
    let energy = simulation.energy().kinetic;
    let exact = |k: usize, measured, expected| Comparison::exact(THREE_SPHERES[k], measured, expected, BAMME);
    let mut compared = vec![exact(0, Some(times.len() as f64), 2.0), exact(1, times.get(1).copied(), 1.01)];
    let place = |(k, x)| exact(k + 2, end.get(k).map(|position: &Vector| position.x), x);
    compared.extend([-10.0, 11.5, 20.99].into_iter().enumerate().map(place));
    compared.push(exact(5, Some(energy), 3.0));
    // Two events and a free flight each cause a rounding error, of up to 16 epsilon for numbers below 32.
    let rounding = 3.0 * 16.0 * f64::EPSILON;
    Ok(compared.into_iter().map(|comparison| comparison.allow(rounding, "round-off")).collect())
}

/// Relative slack of the pendulum's string.
pub(super) const SLACK: f64 = 1e-4;
const PERIODS: usize = 10;
const CHUNK: u64 = 1000;
/// Far more chunks than ten swings need.
const MOST_CHUNKS: usize = 10_000;

pub(super) fn pendulum(_: f64, _: Effort, _: u64, watch: Watch<'_>) -> Compared {
    let space = Space { lower: Vector::repeat(-2.0), size: Vector::repeat(4.0), boundary: [Boundary::OPEN; 3] };
    let scene = SceneBuilder::new("validate")
        .space(space)
        .gravity(Vector::new(0.0, 0.0, -1.0))
        .species(SpeciesDraft::new("pivot").diameter(0.1).fixed())
        .species(SpeciesDraft::new("bob").mass(1.0).diameter(0.1))
        .interaction(InteractionDraft::new(Model::None).between("pivot", "bob"))
        .interaction(InteractionDraft::new(Model::HardSphere).between("bob", "bob"))
        .interaction(InteractionDraft::new(Potential::bond(1.0 - SLACK, 1.0)?).named("string"))
        .particle("pivot", Vector::zeros(), Vector::zeros())
        .particle("bob", Vector::new(1.0 - 0.5 * SLACK, 0.0, 0.0), Vector::zeros())
        .bond([0, 1], "string");
    let passages = passages(Simulation::without_plan(build(&scene)?), watch)?;
    let period = passages.get(2 * PERIODS).zip(passages.first()).map(|(last, first)| (last - first) / PERIODS as f64);
    let expected = 4.0 * elliptic_integral(FRAC_1_SQRT_2);
    // The string has a length from 1 - slack to 1, and the period is proportional to the root of the length. The bob
    // starts in the middle of the slack, so the radial motion has the fraction slack^(3/2) of the energy.
    let allowance = expected * (0.5 * SLACK + SLACK.sqrt() * SLACK);
    Ok(vec![
        Comparison::exact(PENDULUM[0], period, expected, SWINGS)
            .allow(allowance, "the string has a slack of 1e-4 of its length"),
    ])
}

/// Times at which the bob passes the lowest point, interpolated between contacts. The speed is nearly constant there.
fn passages(mut simulation: Simulation, watch: Watch<'_>) -> Result<Vec<f64>, StatePointError> {
    let (mut passages, mut last) = (Vec::new(), (0.0, 1.0));
    for _ in 0..MOST_CHUNKS {
        if passages.len() > 2 * PERIODS {
            break;
        }
        advance(&mut simulation, CHUNK, watch, |event| {
            // The event's normal points from the partner to the particle, and either can be the pivot.
            let string = if event.partner().is_some_and(|id| id.0 == 0) { event.normal } else { -event.normal };
            if (string.x > 0.0) != (last.1 > 0.0) && string.z < 0.0 {
                passages.push(last.0 + (event.time - last.0) * last.1 / (last.1 - string.x));
            }
            last = (event.time, string.x);
        })?;
    }
    Ok(passages)
}

/// Returns the complete elliptic integral of the first kind of modulus `k`, by the arithmetic-geometric mean.
fn elliptic_integral(modulus: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - modulus * modulus).sqrt());
    // Each step doubles the number of correct digits of both means.
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    PI / (2.0 * a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;

    #[test]
    fn the_elliptic_integral_has_its_known_values() {
        assert!((elliptic_integral(0.0) - 0.5 * PI).abs() < 1e-15);
        assert!((elliptic_integral(FRAC_1_SQRT_2) - 1.854_074_677_301_372).abs() < 1e-14);
    }

    #[test]
    fn a_pendulum_swings_with_its_period() {
        let compared = pendulum(0.0, Effort::Brief, 1, &mut || ControlFlow::Continue(())).unwrap();
        assert!(compared[0].verdict().is_pass(), "{compared:?}");
        assert!(compared[0].allowance.amount < 1e-3 * compared[0].published);
    }

    #[test]
    fn interrupted_measurement_is_not_compared() {
        let interrupted = pendulum(0.0, Effort::Brief, 1, &mut || ControlFlow::Break(()));
        assert!(matches!(interrupted, Err(StatePointError::Interrupted)), "{interrupted:?}");
    }
}
