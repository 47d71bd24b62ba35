//! Measured against published and exact results: whole runs at known state points, with a verdict on each quantity.
//!
//! [`points`] lists what can be measured; [`Point::measure`] runs one and returns a [`Comparison`] for each of its quantities. A
//! quantity passes if it is off by no more than four of its own standard errors and an [`Allowance`] that is derived, never guessed: the effect of a
//! finite number of particles, an approximation of the theory, round-off. What is measured is a function of the seed.
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
mod finite_size;
mod fluids;
mod heat_flux;
mod lennard_jones;
mod rods;
mod state_point;
mod steps;

pub use comparison::{Allowance, Comparison, Source, Verdict};
pub use state_point::{StatePointError, Watch};

/// Length of the runs of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Effort {
    /// Seconds in all: fewer events at fewer points.
    Brief,
    /// About a minute in all.
    Usual,
    /// A quarter of an hour in all: more particles, more events, more points.
    Long,
}

impl Effort {
    /// Particles of a fluid: `4 n^3`, for a lattice of cubic cells.
    fn particles(self) -> u64 {
        match self {
            Self::Brief => 500,
            Self::Usual => 1372,
            Self::Long => 4000,
        }
    }

    /// Measured physical events of a fluid.
    fn events(self) -> u64 {
        match self {
            Self::Brief => 200_000,
            Self::Usual => 3_000_000,
            Self::Long => 30_000_000,
        }
    }
}

/// A state point, or a single motion, with known results.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Name, such as `hard_spheres/0.30`.
    pub name: String,
    /// Simulated system, in words.
    pub state: String,
    /// Compared quantities.
    pub quantities: &'static [&'static str],
    effort: Effort,
    experiment: Experiment,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Experiment {
    Spheres { packing_fraction: f64 },
    Crystal { number_density: f64 },
    Disks { packing_fraction: f64 },
    Rods { number_density: f64 },
    SquareWell { temperature: f64 },
    DiluteWells { temperature: f64 },
    HeatFlux { packing_fraction: f64 },
    LennardJones,
    Cooling { restitution: f64 },
    Ball { restitution: f64 },
    ThreeSpheres,
    Pendulum,
}

impl Experiment {
    fn point(self, effort: Effort) -> Point {
        let n = effort.particles();
        let (name, state, quantities) = match self {
            Self::Spheres { packing_fraction: phi } => (
                format!("hard_spheres/{phi:.2}"),
                format!("phi = {phi:.2}, N = {n}"),
                fluids::quantities_of_spheres(phi),
            ),
            Self::Crystal { number_density: rho } => {
                (format!("fcc_crystal/{rho:.4}"), format!("rho = {rho:.4}, N = {n}"), fluids::CRYSTAL)
            }
            Self::Disks { packing_fraction: eta } => {
                (format!("hard_disks/{eta:.2}"), format!("eta = {eta:.2}, N = {n}"), fluids::DISKS)
            }
            Self::Rods { number_density: rho } => {
                (format!("hard_rods/{rho:.2}"), format!("rho = {rho:.2}, N = {}", rods::COUNT), rods::QUANTITIES)
            }
            Self::SquareWell { temperature: t } => {
                (format!("square_well/{t:.1}"), format!("T = {t:.1} before melting, N = {n}"), steps::QUANTITIES)
            }
            Self::DiluteWells { temperature: t } => (
                format!("square_well_gas/{t:.1}"),
                format!("T = {t:.1}, rho = {}, N = {n}", dilute::NUMBER_DENSITY),
                dilute::QUANTITIES,
            ),
            Self::HeatFlux { packing_fraction: phi } => (
                format!("heat_flux/{phi:.2}"),
                format!("phi = {phi:.2}, plates {} apart", heat_flux::distance(phi)),
                heat_flux::QUANTITIES,
            ),
            Self::LennardJones => (
                "lennard_jones".to_owned(),
                format!("cut at 2.5 and shifted, rho = 0.75, T = 1, N = {}", lennard_jones::COUNT),
                lennard_jones::QUANTITIES,
            ),
            Self::Cooling { restitution: e } => (
                format!("granular_cooling/{e:.2}"),
                format!("e = {e:.2}, phi = 0.10, N = {}", cooling::COUNT),
                cooling::QUANTITIES,
            ),
            Self::Ball { restitution: e } => {
                (format!("bouncing_ball/{e:.1}"), format!("e = {e:.1}, h = g = 1"), bodies::BALL)
            }
            Self::ThreeSpheres => {
                ("three_spheres".to_owned(), "on a line, first pair overlapped".to_owned(), bodies::THREE_SPHERES)
            }
            Self::Pendulum => {
                ("pendulum".to_owned(), format!("from 90 degrees, slack {:.0e}", bodies::SLACK), bodies::PENDULUM)
            }
        };
        Point { name, state, quantities, effort, experiment: self }
    }
}

/// All state points of an effort, in the order of the table.
#[must_use]
pub fn points(effort: Effort) -> Vec<Point> {
    let choose = |brief: &'static [f64], usual: &'static [f64], long: &'static [f64]| match effort {
        Effort::Brief => brief,
        Effort::Usual => usual,
        Effort::Long => long,
    };
    let spheres = choose(&[0.30], &[0.10, 0.30, 0.40, 0.49], &[0.10, 0.20, 0.30, 0.40, 0.45, 0.49]);
    let crystals = choose(&[1.0376], &[1.0376], &[1.0376, 1.1, 1.2]);
    let disks = choose(&[0.50], &[0.30, 0.50], &[0.30, 0.50, 0.60]);
    let wells = choose(&[3.6], &[3.6], &[3.0, 3.6, 5.0]);
    let mut all: Vec<Experiment> = Vec::new();
    all.extend(spheres.iter().map(|&packing_fraction| Experiment::Spheres { packing_fraction }));
    all.extend(crystals.iter().map(|&number_density| Experiment::Crystal { number_density }));
    all.extend(disks.iter().map(|&packing_fraction| Experiment::Disks { packing_fraction }));
    all.push(Experiment::Rods { number_density: 0.5 });
    all.extend(wells.iter().map(|&temperature| Experiment::SquareWell { temperature }));
    let gases = choose(&[1.5], &[1.5], &[1.5, 2.0, 5.0]);
    all.extend(gases.iter().map(|&temperature| Experiment::DiluteWells { temperature }));
    let conducting = choose(&[0.02], &[0.01, 0.02, 0.05], &[0.01, 0.02, 0.05]);
    all.extend(conducting.iter().map(|&packing_fraction| Experiment::HeatFlux { packing_fraction }));
    if effort == Effort::Long {
        all.push(Experiment::LennardJones);
    }
    all.extend([0.98, 0.95].map(|restitution| Experiment::Cooling { restitution }));
    all.extend([0.5, 0.9].map(|restitution| Experiment::Ball { restitution }));
    all.extend([Experiment::ThreeSpheres, Experiment::Pendulum]);
    all.into_iter().map(|experiment| experiment.point(effort)).collect()
}

impl Point {
    /// Runs the point and compares. `watch` is asked every few hundredths of a second whether to go on.
    ///
    /// # Errors
    /// [`StatePointError`] if the run was interrupted, could not go on, or did not pass its own audit.
    pub fn measure(&self, seed: u64, watch: Watch<'_>) -> Result<Vec<Comparison>, StatePointError> {
        match self.experiment {
            Experiment::Spheres { packing_fraction } => fluids::spheres(packing_fraction, self.effort, seed, watch),
            Experiment::Crystal { number_density } => fluids::crystal(number_density, self.effort, seed, watch),
            Experiment::Disks { packing_fraction } => fluids::disks(packing_fraction, self.effort, seed, watch),
            Experiment::Rods { number_density } => rods::compare(number_density, seed, watch),
            Experiment::SquareWell { temperature } => steps::compare(temperature, self.effort, seed, watch),
            Experiment::DiluteWells { temperature } => dilute::compare(temperature, self.effort, seed, watch),
            Experiment::HeatFlux { packing_fraction } => heat_flux::compare(packing_fraction, self.effort, seed, watch),
            Experiment::LennardJones => lennard_jones::compare(seed, watch),
            Experiment::Cooling { restitution } => cooling::compare(restitution, seed, watch),
            Experiment::Ball { restitution } => bodies::ball(restitution),
            Experiment::ThreeSpheres => bodies::three_spheres(),
            Experiment::Pendulum => bodies::pendulum(watch),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn points_have_names_of_their_own() {
        for effort in [Effort::Brief, Effort::Usual, Effort::Long] {
            let points = points(effort);
            let names: HashSet<&str> = points.iter().map(|point| point.name.as_str()).collect();
            assert_eq!(names.len(), points.len());
            assert!(points.iter().all(|point| !point.quantities.is_empty()));
        }
    }

    #[test]
    fn single_motions_are_what_they_were_announced_to_be() {
        for point in points(Effort::Brief) {
            if !matches!(point.experiment, Experiment::Ball { .. } | Experiment::ThreeSpheres) {
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
