//! Checks the conservation laws and the overlaps of a run.
//!
//! The dissipated energy and the supplied energy are added up during the run. The sum
//! `kinetic + potential + dissipated - supplied` is therefore constant within round-off.

use std::convert::Infallible;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::Vector;
use crate::analysis::observables::Row;
use crate::engine::event::EventCounts;
use crate::engine::{Energy, Overlap, Simulation};
use crate::model::AuditPlan;

/// Upper bound for the number of roundings in a physical event.
const ROUNDINGS: f64 = 32.0;

/// Largest relative error that round-off explains after a number of events.
///
/// Each rounding has a relative error of at most `eps / 2` with a random sign. The errors of `n` events add up to a
/// random walk with a standard deviation below `s = ROUNDINGS eps / 2 sqrt(n)`. The limit is `4 s`, plus
/// `4 ROUNDINGS eps / 2` for the sums themselves.
fn round_off(events: u64) -> f64 {
    4.0 * ROUNDINGS * 0.5 * f64::EPSILON * (1.0 + (events as f64).sqrt())
}

/// Largest errors that an audit accepts. The defaults are estimates of round-off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Largest accepted error of the energy balance, relative to the largest energy during the run.
    pub energy: f64,
    /// Largest accepted drift of the total momentum, relative to the sum of `m |v|` over all particles.
    pub momentum: f64,
    /// Largest accepted overlap, relative to the contact distance. `None` only accepts overlaps within round-off.
    pub overlap: Option<f64>,
}

impl Limits {
    /// Returns the limits for a run with this number of events. Cell transitions count as events.
    #[must_use]
    pub fn new(plan: &AuditPlan, events: u64) -> Self {
        Self {
            energy: plan.energy.unwrap_or_else(|| round_off(events)),
            momentum: plan.momentum.unwrap_or_else(|| round_off(events)),
            overlap: plan.overlap,
        }
    }
}

/// Overlaps of the initial configuration, and the time at which they were resolved.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Initial {
    /// Number of pairs that overlap at the start by more than round-off.
    pub overlaps: usize,
    /// Time from the start until no particles overlapped `[time]`. `None` if overlaps remain, or if there were none.
    pub resolved_after: Option<f64>,
}

/// Audit of a whole run: conservation of energy and momentum, and overlaps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Audit {
    /// Sum of kinetic and potential energy at the start `[energy]`.
    pub initial_energy: f64,
    /// Kinetic and potential energy at the end `[energy]`.
    pub energy: Energy,
    /// Kinetic energy that contacts dissipated by restitution `[energy]`.
    pub dissipated: f64,
    /// Change of `kinetic + potential + dissipated - supplied` energy, relative to the largest of these energies during
    /// the run.
    pub ledger_error: f64,
    /// Change of the total momentum, relative to the largest sum of `m |v|` over all particles. A new balance starts
    /// after each growth stage, and the largest change is reported. `None` if walls, gravity or static particles change
    /// the momentum.
    pub momentum_drift: Option<f64>,
    /// Event counts of the whole run.
    pub event_counts: EventCounts,
    /// The deepest overlap at the end.
    pub deepest_final: Option<Overlap>,
    /// Number of pairs that overlap at the end by more than round-off.
    pub final_overlaps: usize,
    /// Overlaps at the start of the run.
    pub initial: Initial,
    /// Largest errors that the audit accepts.
    pub limits: Limits,
}

/// Fault found by an audit.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum AuditFault {
    /// An energy, an error or a depth is infinite or NaN.
    #[error("a quantity is not finite")]
    NotFinite,
    /// The energy balance has an error beyond its limit.
    #[error("the energy ledger is off by {error:.1e}, more than the limit of {limit:.1e}")]
    Ledger {
        /// Relative error.
        error: f64,
        /// Largest allowed error.
        limit: f64,
    },
    /// The total momentum drifted beyond its limit.
    #[error("the total momentum drifted by {drift:.1e}, more than the limit of {limit:.1e}")]
    Momentum {
        /// Relative drift.
        drift: f64,
        /// Largest allowed drift.
        limit: f64,
    },
    /// An overlap is deeper than the limit in the scene.
    #[error("an overlap of {depth:.1e} of the contact distance, more than the limit of {limit:.1e}")]
    Overlap {
        /// Relative depth.
        depth: f64,
        /// Largest allowed depth.
        limit: f64,
    },
    /// Particles overlap by more than round-off explains, although no particles overlapped at the start.
    #[error(
        "{events} events in invalid states and {pairs} overlaps at the end, deeper than round-off explains, the deepest \
         {depth:.1e} of the contact distance"
    )]
    InvalidState {
        /// Number of events executed while the pair was in an invalid state.
        events: u64,
        /// Number of pairs in an invalid state at the end.
        pairs: usize,
        /// Depth of the deepest overlap, relative to the contact distance.
        depth: f64,
    },
}

impl Audit {
    /// Returns the faults that the audit found.
    #[must_use]
    pub fn faults(&self) -> Vec<AuditFault> {
        let mut faults = Vec::new();
        let drift = self.momentum_drift.unwrap_or(0.0);
        let depth = self.deepest();
        let all = [self.energy.total(), self.ledger_error, drift, depth];
        if all.iter().any(|x| !x.is_finite()) {
            faults.push(AuditFault::NotFinite);
        }
        let Limits { energy, momentum, overlap } = self.limits;
        if self.ledger_error > energy {
            faults.push(AuditFault::Ledger { error: self.ledger_error, limit: energy });
        }
        if drift > momentum {
            faults.push(AuditFault::Momentum { drift, limit: momentum });
        }
        let (events, pairs) = (self.event_counts.in_invalid_state, self.final_overlaps);
        match overlap {
            Some(limit) if depth > limit => faults.push(AuditFault::Overlap { depth, limit }),
            None if self.initial.overlaps == 0 && events + pairs as u64 > 0 => {
                faults.push(AuditFault::InvalidState { events, pairs, depth });
            }
            _ => {}
        }
        faults
    }

    /// Deepest overlap at any time. If particles overlap at the start, only overlaps at the end are considered.
    fn deepest(&self) -> f64 {
        let last = self.deepest_final.map_or(0.0, |overlap| overlap.depth);
        if self.initial.overlaps == 0 { last.max(self.event_counts.deepest_overlap) } else { last }
    }
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Ledger {
    initial_energy: f64,
    /// Total momentum at the start, or after the last growth stage; `None` if the momentum is not conserved.
    initial_momentum: Option<Vector>,
    /// Largest sum of `m |v|` since the start or the last growth stage. Rounding errors are proportional to this sum.
    largest_momenta: f64,
    /// Largest relative drift of the momentum up to the end of the last growth stage.
    earlier_drift: f64,
    scale: f64,
    initial: Initial,
}

impl Ledger {
    pub fn open(simulation: &Simulation, conserves_momentum: bool) -> Self {
        let energy = simulation.energy();
        let initial_energy = energy.total();
        // Without `allow_invalid_start`, scenes with overlaps were rejected.
        let is_valid = !simulation.scene().allow_invalid_start;
        let overlaps = if is_valid { 0 } else { simulation.real_overlaps().len() };
        Self {
            initial_energy,
            initial_momentum: conserves_momentum.then_some(energy.momentum),
            largest_momenta: if conserves_momentum { sum_of_momenta(simulation) } else { 0.0 },
            earlier_drift: 0.0,
            scale: initial_energy.abs().max(energy.kinetic).max(energy.rotational),
            initial: Initial { overlaps, resolved_after: None },
        }
    }

    /// Starts a new momentum balance after a growth stage, because growth changes the speeds.
    pub fn start_again(&mut self, simulation: &Simulation) {
        if self.initial_momentum.is_some() {
            let momentum = simulation.energy().momentum;
            self.earlier_drift = self.momentum_drift(&momentum, simulation).unwrap_or(0.0);
            self.initial_momentum = Some(momentum);
            self.largest_momenta = sum_of_momenta(simulation);
        }
    }

    fn momentum_drift(&self, momentum: &Vector, simulation: &Simulation) -> Option<f64> {
        self.initial_momentum.map(|initial| {
            let drift = relative((momentum - initial).norm(), self.largest_momenta.max(sum_of_momenta(simulation)));
            if drift >= self.earlier_drift || drift.is_nan() { drift } else { self.earlier_drift }
        })
    }

    pub fn has_overlaps(&self) -> bool {
        self.initial.overlaps > 0 && self.initial.resolved_after.is_none()
    }

    pub fn see_overlaps(&mut self, simulation: &Simulation) {
        if self.has_overlaps() && simulation.real_overlaps().is_empty() {
            self.initial.resolved_after = Some(simulation.time() - simulation.scene().start_time);
        }
    }

    /// Updates the largest energy and the largest sum of momenta at times without a row.
    pub fn note(&mut self, simulation: &Simulation, energy: &Energy) {
        self.scale = self.scale.max(energy.total().abs()).max(energy.kinetic).max(energy.rotational);
        if self.initial_momentum.is_some() {
            self.largest_momenta = self.largest_momenta.max(sum_of_momenta(simulation));
        }
    }

    pub fn see(&mut self, row: &Row) {
        let energy = row.kinetic + row.rotational + row.potential;
        let dissipated = row.ledger - energy;
        self.scale = self.scale.max(energy.abs()).max(row.kinetic).max(row.rotational).max(dissipated.abs());
    }

    pub fn close(mut self, simulation: &Simulation) -> Audit {
        self.see_overlaps(simulation);
        let (energy, event_counts) = (simulation.energy(), *simulation.event_counts());
        let (total, dissipated) = (energy.total(), event_counts.dissipated.total());
        let supplied = event_counts.supplied.total();
        self.scale = self.scale.max(total.abs()).max(energy.kinetic).max(energy.rotational);
        self.scale = self.scale.max(dissipated).max(supplied.abs());
        Audit {
            initial_energy: self.initial_energy,
            energy,
            dissipated,
            ledger_error: relative((total + dissipated - supplied - self.initial_energy).abs(), self.scale),
            momentum_drift: self.momentum_drift(&energy.momentum, simulation),
            event_counts,
            deepest_final: simulation.deepest_overlap(),
            final_overlaps: simulation.real_overlaps().len(),
            initial: self.initial,
            limits: Limits::new(&simulation.scene().audit, event_counts.physical() + event_counts.transition),
        }
    }
}

fn relative(error: f64, scale: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / scale }
}

/// `sum m |v|`.
fn sum_of_momenta(simulation: &Simulation) -> f64 {
    let mut sum = 0.0;
    let Ok(()) = simulation.for_each_now(|particle| {
        let mass = simulation.mass_of(&particle);
        sum += if mass.is_finite() { mass } else { 0.0 } * particle.velocity.norm();
        Ok::<(), Infallible>(())
    });
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Until;
    use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

    fn audit() -> Audit {
        let scene = SceneBuilder::new("gas")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A").restitution(0.9))
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.2))
            .temperature(1.0)
            .build()
            .unwrap();
        let mut simulation = Simulation::without_plan(scene);
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
        let has = |audit: Audit, is_it: fn(&AuditFault) -> bool| audit.faults().iter().any(is_it);
        assert!(has(Audit { ledger_error: 1e-9, ..sound }, |fault| matches!(fault, AuditFault::Ledger { .. })));
        assert!(has(Audit { momentum_drift: Some(1e-9), ..sound }, |fault| matches!(
            fault,
            AuditFault::Momentum { .. }
        )));
        assert!(has(Audit { ledger_error: f64::NAN, ..sound }, |fault| *fault == AuditFault::NotFinite));
        let mut deep = sound;
        deep.event_counts.in_invalid_state = 1;
        deep.event_counts.deepest_overlap = 1e-6;
        assert!(has(deep, |fault| matches!(fault, AuditFault::InvalidState { events: 1, pairs: 0, .. })));
        assert!(has(Audit { final_overlaps: 2, ..sound }, |fault| matches!(
            fault,
            AuditFault::InvalidState { pairs: 2, .. }
        )));
        let overlapping = Initial { overlaps: 3, resolved_after: Some(1.0) };
        assert_eq!(Audit { initial: overlapping, ..deep }.faults(), [], "the stable rule resolves overlaps");
    }

    #[test]
    fn the_limits_of_the_scene_replace_those_of_round_off() {
        let sound = audit();
        let plan = AuditPlan { energy: Some(1e-18), momentum: Some(1e-19), overlap: Some(1e-17) };
        let strict = Audit { limits: Limits::new(&plan, 1000), ledger_error: 1e-17, ..sound };
        assert_eq!(strict.faults().len(), 3, "{:?}", strict.faults());
        let mut deep = sound;
        deep.event_counts.deepest_overlap = 1e-6;
        deep.limits.overlap = Some(1e-5);
        assert_eq!(deep.faults(), []);
        let half =
            Limits::new(&AuditPlan::default(), 10_000).energy / Limits::new(&AuditPlan::default(), 40_000).energy;
        assert!((half - 0.5).abs() < 0.01, "a random walk grows with the square root of the number of events");
    }

    #[test]
    fn overlaps_of_the_start_are_counted_until_they_are_gone() {
        let scene = SceneBuilder::new("overlap")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .space(crate::model::space::Space::periodic_cube(8.0))
            .particle("A", Vector::new(1.0, 1.0, 1.0), Vector::new(-1.0, 0.0, 0.0))
            .particle("A", Vector::new(1.5, 1.0, 1.0), Vector::new(1.0, 0.0, 0.0))
            .allow_invalid_start(true)
            .build()
            .unwrap();
        let mut simulation = Simulation::without_plan(scene);
        let mut ledger = Ledger::open(&simulation, true);
        simulation.advance(Until::time(0.2)).unwrap();
        ledger.see_overlaps(&simulation);
        assert!(ledger.has_overlaps());
        simulation.advance(Until::time(0.3)).unwrap();
        let audit = ledger.close(&simulation);
        assert_eq!(audit.initial, Initial { overlaps: 1, resolved_after: Some(0.3) });
        assert_eq!(audit.faults(), []);
    }
}
