//! Comparison with published and exact results: whole runs at known state points, with a verdict on each quantity.
//!
//! [`points`] lists the state points. [`StatePoint::measure`] runs one state point and returns a [`Comparison`] for
//! each quantity. A quantity passes if it deviates by at most four standard errors plus an [`Allowance`] for known
//! systematic differences. Results depend only on the seed.
//!
//! ```
//! use std::ops::ControlFlow;
//! use carom::check::validate::{self, Effort};
//!
//! let points = validate::points(Effort::Brief);
//! let ball = points.iter().find(|point| point.name.starts_with("bouncing_ball")).ok_or("no ball")?;
//! for comparison in ball.measure(1, &mut || ControlFlow::Continue(()))? {
//!     assert!(comparison.verdict().is_pass(), "{comparison:?}");
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bodies;
mod comparison;
mod cooling;
mod dilute;
mod fluids;
mod heat_flux;
mod lennard_jones;
mod rods;
mod state_point;
mod steps;

pub use comparison::{Allowance, Comparison, Source, Verdict};
use state_point::Compared;
pub use state_point::{StatePointError, Watch};

/// Length of the runs of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Effort {
    /// Takes seconds in total, with fewer events at fewer state points.
    Brief,
    /// Takes about a minute in total.
    Usual,
    /// Takes a quarter of an hour in total, with more particles, more events and more state points.
    Long,
}

impl Effort {
    /// Number of particles in a fluid: `4 n^3`, which fills a lattice of `n^3` face-centred cubic cells.
    fn particles(self) -> u64 {
        [500, 1372, 4000][self as usize]
    }

    fn events(self) -> u64 {
        [200_000, 3_000_000, 30_000_000][self as usize]
    }
}

/// A state point, or a single trajectory, with known results.
#[derive(Debug, Clone)]
pub struct StatePoint {
    /// Name, such as `hard_spheres/0.30`.
    pub name: String,
    /// The simulated system, in words.
    pub state: String,
    /// Compared quantities.
    pub quantities: &'static [&'static str],
    effort: Effort,
    /// Density, temperature or restitution that distinguishes the state point from others of its kind.
    parameter: f64,
    compare: Compare,
}

type Compare = fn(f64, Effort, u64, Watch<'_>) -> Compared;

/// Parameters of one kind of state point, for a brief, a usual and a long comparison.
type Parameters = [&'static [f64]; 3];

/// Returns all state points that are compared at this effort.
#[must_use]
pub fn points(effort: Effort) -> Vec<StatePoint> {
    const ONE: Parameters = [&[0.0]; 3];
    let n = effort.particles();
    let mut points = Vec::new();
    let mut add = |parameters: Parameters, compare: Compare, describe: &dyn Fn(f64) -> Description| {
        for &parameter in parameters[effort as usize] {
            let Description(name, state, quantities) = describe(parameter);
            points.push(StatePoint { name, state, quantities, effort, parameter, compare });
        }
    };
    let spheres: Parameters = [&[0.30], &[0.10, 0.30, 0.40, 0.49], &[0.10, 0.20, 0.30, 0.40, 0.45, 0.49]];
    add(spheres, fluids::spheres, &|phi| {
        let quantities = fluids::quantities_of_spheres(phi);
        Description(format!("hard_spheres/{phi:.2}"), format!("phi = {phi:.2}, N = {n}"), quantities)
    });
    add([&[1.0376], &[1.0376], &[1.0376, 1.1, 1.2]], fluids::crystal, &|rho| {
        Description(format!("fcc_crystal/{rho:.4}"), format!("rho = {rho:.4}, N = {n}"), fluids::CRYSTAL)
    });
    add([&[0.50], &[0.30, 0.50], &[0.30, 0.50, 0.60]], fluids::disks, &|eta| {
        Description(format!("hard_disks/{eta:.2}"), format!("eta = {eta:.2}, N = {n}"), fluids::DISKS)
    });
    add([&[0.5]; 3], rods::compare, &|rho| {
        Description(format!("hard_rods/{rho:.2}"), format!("rho = {rho:.2}, N = {}", rods::COUNT), rods::QUANTITIES)
    });
    add([&[3.6], &[3.6], &[3.0, 3.6, 5.0]], steps::compare, &|t| {
        Description(format!("square_well/{t:.1}"), format!("T = {t:.1} before melting, N = {n}"), steps::QUANTITIES)
    });
    add([&[1.5], &[1.5], &[1.5, 2.0, 5.0]], dilute::compare, &|t| {
        let state = format!("T = {t:.1}, rho = {}, N = {n}", dilute::NUMBER_DENSITY);
        Description(format!("square_well_gas/{t:.1}"), state, dilute::QUANTITIES)
    });
    add([&[0.02], &[0.01, 0.02, 0.05], &[0.01, 0.02, 0.05]], heat_flux::compare, &|phi| {
        let state = format!("phi = {phi:.2}, plates {} apart", heat_flux::distance(phi));
        Description(format!("heat_flux/{phi:.2}"), state, heat_flux::QUANTITIES)
    });
    add([&[], &[], &[0.0]], lennard_jones::compare, &|_| {
        let state = format!("cut at 2.5 and shifted, rho = 0.75, T = 1, N = {}", lennard_jones::COUNT);
        Description("lennard_jones".to_owned(), state, lennard_jones::QUANTITIES)
    });
    add([&[0.98, 0.95]; 3], cooling::compare, &|e| {
        let state = format!("e = {e:.2}, phi = 0.10, N = {}", cooling::COUNT);
        Description(format!("granular_cooling/{e:.2}"), state, cooling::QUANTITIES)
    });
    add([&[0.5, 0.9]; 3], bodies::ball, &|e| {
        Description(format!("bouncing_ball/{e:.1}"), format!("e = {e:.1}, h = g = 1"), bodies::BALL)
    });
    add(ONE, bodies::three_spheres, &|_| {
        let state = "three spheres on a line; the first two overlap".to_owned();
        Description("three_spheres".to_owned(), state, bodies::THREE_SPHERES)
    });
    add(ONE, bodies::pendulum, &|_| {
        let state = format!("from 90 degrees, slack {:.0e}", bodies::SLACK);
        Description("pendulum".to_owned(), state, bodies::PENDULUM)
    });
    points
}

struct Description(String, String, &'static [&'static str]);

impl StatePoint {
    /// Runs the state point and compares the results. `watch` is called repeatedly and may stop the run.
    ///
    /// # Errors
    /// [`StatePointError`] if the run was interrupted, could not continue, or failed its own audit.
    pub fn measure(&self, seed: u64, watch: Watch<'_>) -> Result<Vec<Comparison>, StatePointError> {
        (self.compare)(self.parameter, self.effort, seed, watch)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn point_names_are_unique() {
        for effort in [Effort::Brief, Effort::Usual, Effort::Long] {
            let points = points(effort);
            let names: HashSet<&str> = points.iter().map(|point| point.name.as_str()).collect();
            assert_eq!(names.len(), points.len());
            assert!(points.iter().all(|point| !point.quantities.is_empty()));
        }
    }

    #[test]
    fn single_particle_points_pass_and_list_their_quantities() {
        for point in points(Effort::Brief) {
            if !["bouncing_ball", "three_spheres"].iter().any(|kind| point.name.starts_with(kind)) {
                continue;
            }
            let compared = point.measure(1, &mut || std::ops::ControlFlow::Continue(())).unwrap();
            let names: Vec<&str> = compared.iter().map(|comparison| comparison.quantity).collect();
            assert_eq!(names, point.quantities, "{}", point.name);
            for comparison in compared {
                assert!(comparison.verdict().is_pass(), "{}: {comparison:?}", point.name);
            }
        }
    }
}
