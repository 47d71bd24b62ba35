//! What a run finds out about its own correctness.
//!
//! Energy and momentum are compared with the exact ledger: what restitution dissipated is counted at every contact, so that
//! kinetic and potential energy and the dissipated energy add up to the same sum, but for round-off.

use thiserror::Error;

use crate::Vector;
use crate::event::Tally;
use crate::observe::Row;
use crate::simulation::{Energy, Overlap, Simulation};

/// Relative error of the ledger, or drift of the momentum, that round-off explains, per physical event: 16 roundings
/// of one event, as if all of them went the same way. Their number is more than it is in the simulation of any pair; that
/// they go different ways leaves a run of a million events a factor of a thousand below.
const ROUND_OFF_PER_EVENT: f64 = 16.0 * f64::EPSILON;

/// What round-off explains before the first event: sums over the particles.
const ROUND_OFF: f64 = 1e-12;

/// Overlap, relative to the discontinuity's distance, that round-off explains in a scene with a valid start: where a pair
/// grazes, the time of contact is known to the root of the round-off, and so is the distance.
const DEEPEST_BY_ROUND_OFF: f64 = 1e-7;

/// What a run found out about itself, over its whole length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Audit {
    /// Kinetic and potential energy at the start `[energy]`.
    pub initial_energy: f64,
    /// The energies at the end `[energy]`.
    pub energy: Energy,
    /// Kinetic energy lost to restitution `[energy]`.
    pub dissipated: f64,
    /// `|E + dissipated - E_initial|`, relative to the largest of `|E|`, kinetic and dissipated energy along the run.
    pub ledger_error: f64,
    /// Change of the total momentum relative to the sum of all `m |v|`; `None` where walls, gravity or static particles
    /// change it.
    pub momentum_drift: Option<f64>,
    /// Everything that happened.
    pub tally: Tally,
    /// The deepest overlap at the end.
    pub deepest_final: Option<Overlap>,
    /// Whether the scene started without overlaps.
    pub had_valid_start: bool,
}

/// What an audit objects to.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum Fault {
    /// Something is not a number.
    #[error("a quantity is not finite")]
    NotFinite,
    /// Energy came from nowhere or went away.
    #[error("the energy ledger is off by {error:.1e}, more than the {bound:.1e} that round-off explains")]
    Ledger {
        /// Relative error.
        error: f64,
        /// What is allowed.
        bound: f64,
    },
    /// Momentum came from nowhere or went away.
    #[error("the total momentum drifted by {drift:.1e}, more than the {bound:.1e} that round-off explains")]
    Momentum {
        /// Relative drift.
        drift: f64,
        /// What is allowed.
        bound: f64,
    },
    /// Particles overlap though they did not at the start.
    #[error("an overlap of {depth:.1e} of the contact distance, more than the {bound:.1e} that round-off explains")]
    Overlap {
        /// Relative depth.
        depth: f64,
        /// What is allowed.
        bound: f64,
    },
}

impl Audit {
    /// What is wrong with the run; empty if it is sound.
    #[must_use]
    pub fn faults(&self) -> Vec<Fault> {
        let mut faults = Vec::new();
        let momentum_drift = self.momentum_drift.unwrap_or(0.0);
        let depth = self.tally.deepest_overlap.max(self.deepest_final.map_or(0.0, |overlap| overlap.depth));
        let all = [self.energy.kinetic, self.energy.potential, self.ledger_error, momentum_drift, depth];
        if all.iter().any(|x| !x.is_finite()) {
            faults.push(Fault::NotFinite);
        }
        let bound = ROUND_OFF + ROUND_OFF_PER_EVENT * self.tally.physical() as f64;
        if self.ledger_error > bound {
            faults.push(Fault::Ledger { error: self.ledger_error, bound });
        }
        if momentum_drift > bound {
            faults.push(Fault::Momentum { drift: momentum_drift, bound });
        }
        if self.had_valid_start && depth > DEEPEST_BY_ROUND_OFF {
            faults.push(Fault::Overlap { depth, bound: DEEPEST_BY_ROUND_OFF });
        }
        faults
    }
}

/// The books of a run while it goes on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ledger {
    initial_energy: f64,
    /// The total momentum at the start, if it is conserved.
    initial_momentum: Option<Vector>,
    scale: f64,
}

impl Ledger {
    pub fn open(simulation: &Simulation, conserves_momentum: bool) -> Self {
        let energy = simulation.energy();
        let initial_energy = energy.kinetic + energy.potential;
        Self {
            initial_energy,
            initial_momentum: conserves_momentum.then_some(energy.momentum),
            scale: initial_energy.abs().max(energy.kinetic),
        }
    }

    /// Takes note of the size of the energies.
    pub fn see(&mut self, row: &Row) {
        let energy = row.kinetic + row.potential;
        let dissipated = row.ledger - energy;
        self.scale = self.scale.max(energy.abs()).max(row.kinetic).max(dissipated);
    }

    pub fn close(mut self, simulation: &Simulation) -> Audit {
        let (energy, tally) = (simulation.energy(), *simulation.tally());
        let (total, dissipated) = (energy.kinetic + energy.potential, tally.dissipated.total());
        self.scale = self.scale.max(total.abs()).max(energy.kinetic).max(dissipated);
        let relative = |error: f64, scale: f64| if error == 0.0 { 0.0 } else { error / scale };
        Audit {
            initial_energy: self.initial_energy,
            energy,
            dissipated,
            ledger_error: relative((total + dissipated - self.initial_energy).abs(), self.scale),
            momentum_drift: self
                .initial_momentum
                .map(|initial| relative((energy.momentum - initial).norm(), momentum_scale(simulation))),
            tally,
            deepest_final: simulation.deepest_overlap(),
            had_valid_start: !simulation.scene().allow_invalid_start,
        }
    }
}

/// `sum m |v|`, at the start or now, whichever is more.
fn momentum_scale(simulation: &Simulation) -> f64 {
    let scene = simulation.scene();
    let masses = || {
        let species = scene.particles.iter().map(|particle| &scene.species[particle.species.0 as usize]);
        species.map(|species| if species.is_static() { 0.0 } else { species.mass })
    };
    let initial: f64 = masses().zip(&scene.particles).map(|(mass, particle)| mass * particle.velocity.norm()).sum();
    let now: f64 = masses().zip(&simulation.snapshot().velocities).map(|(mass, velocity)| mass * velocity.norm()).sum();
    initial.max(now)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::potential::Potential;
    use crate::scene::{Amount, Lattice, SceneBuilder};
    use crate::simulation::Until;

    fn audit() -> Audit {
        let scene = SceneBuilder::new("gas")
            .species("A", 1.0, 1.0)
            .interaction("A", "A", Potential::hard_sphere(1.0).unwrap(), 0.9)
            .fill(Lattice::FaceCentredCubic, "A", 108, Amount::PackingFraction(0.2))
            .temperature(1.0)
            .build()
            .unwrap();
        let mut simulation = Simulation::new(scene);
        let ledger = Ledger::open(&simulation, true);
        simulation.advance(Until::events(1000)).unwrap();
        ledger.close(&simulation)
    }

    #[test]
    fn a_sound_run_has_no_faults_though_it_dissipates() {
        let audit = audit();
        assert!(audit.dissipated > 0.0);
        assert_eq!(audit.faults(), []);
        assert!(audit.ledger_error < 1e-13 && audit.momentum_drift.unwrap() < 1e-13);
    }

    #[test]
    fn every_kind_of_fault_is_found() {
        let sound = audit();
        let has = |audit: Audit, is_it: fn(&Fault) -> bool| audit.faults().iter().any(is_it);
        assert!(has(Audit { ledger_error: 1e-9, ..sound }, |fault| matches!(fault, Fault::Ledger { .. })));
        assert!(has(Audit { momentum_drift: Some(1e-9), ..sound }, |fault| matches!(fault, Fault::Momentum { .. })));
        assert!(has(Audit { ledger_error: f64::NAN, ..sound }, |fault| *fault == Fault::NotFinite));
        let mut deep = sound;
        deep.tally.deepest_overlap = 1e-6;
        assert!(has(deep, |fault| matches!(fault, Fault::Overlap { .. })));
        assert_eq!(Audit { had_valid_start: false, ..deep }.faults(), [], "the stable rule resolves overlaps");
    }
}
