//! The stages of a run: preparation, equilibration and measurement.

use serde::{Deserialize, Serialize};

use super::barostat::Barostat;
use super::swap::Swap;
use super::thermostat::Thermostat;
use super::threads::Threads;
use crate::Vector;
use crate::model::until::Until;

pub(crate) const EQUILIBRATION: &str = "equilibration";

pub(crate) const MEASUREMENT: &str = "measurement";

/// Run plan of a scene: its stages, equilibration, limit and thermostat.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RunPlan {
    /// Stages before the last equilibration and the last measurement, in order.
    pub stages: Vec<StagePlan>,
    /// Limit of the equilibration before the last measurement.
    pub equilibration: Until,
    /// Whether the equilibration ends as soon as no observable drifts, at the latest at its limit.
    pub until_stationary: bool,
    /// Limit of the final measurement.
    pub limit: Until,
    /// Thermostat of the measurement.
    pub thermostat: Option<Thermostat>,
    /// Barostat of the measurement.
    pub barostat: Option<Barostat>,
    /// Swap moves of the measurement.
    pub swap: Option<Swap>,
    /// Gravity of the last equilibration and measurement `[length / time^2]`, instead of the accelerations of the
    /// species. Either all stages have their own gravity, or none.
    pub gravity: Option<Vector>,
    /// Number of threads for the whole run.
    pub threads: Threads,
}

impl RunPlan {
    /// The equilibration before the last measurement.
    #[must_use]
    pub fn last_equilibration(&self) -> Equilibration {
        Equilibration { limit: self.equilibration, until_stationary: self.until_stationary }
    }

    /// First random stream of a stage, or of the last equilibration if `stage` equals the number of stages.
    pub(crate) fn first_stream_of(&self, stage: usize) -> usize {
        self.stages.iter().take(stage).map(StagePlan::streams).sum()
    }

    /// Number of random streams of the whole run: one for each stage, equilibration and measurement.
    pub(crate) fn streams(&self) -> usize {
        self.first_stream_of(self.stages.len()) + EQUILIBRATION_AND_MEASUREMENT
    }

    /// Simulated time `[time]` by which a run that begins at `start` has ended; `None` if a stage or the measurement has
    /// no time limit. An equilibration without a time limit does not count.
    pub(crate) fn latest_end(&self, start: f64) -> Option<f64> {
        let measured = |limit: &Until, before: &Until| Some(limit.time? + before.time.unwrap_or(0.0));
        let of_stage = |stage: &StagePlan| measured(&stage.limit, &stage.measured.unwrap_or_default().limit);
        let durations = self.stages.iter().map(of_stage).chain([measured(&self.limit, &self.equilibration)]);
        durations.into_iter().try_fold(start, |end, duration| Some(end + duration?))
    }

    pub(crate) fn first_stage(&self) -> &str {
        self.stages.first().map_or(MEASUREMENT, |stage| &stage.name)
    }

    /// Whether the plan has a thermostat, growing diameters or gravity.
    #[must_use]
    pub fn is_driven(&self) -> bool {
        self.has_thermostat_or_growth() || self.gravities().next().is_some()
    }

    pub(crate) fn has_thermostat_or_growth(&self) -> bool {
        self.thermostats().next().is_some() || self.has_growth()
    }

    /// Whether the diameters grow in a stage.
    pub(crate) fn has_growth(&self) -> bool {
        self.stages.iter().any(|stage| stage.growth.is_some())
    }

    /// Thermostats of the stages and of the measurement, which comes last.
    pub(crate) fn thermostats(&self) -> impl Iterator<Item = Thermostat> + '_ {
        self.stages.iter().map(|stage| stage.thermostat).chain([self.thermostat]).flatten()
    }

    /// Whether a stage or the measurement has a barostat.
    #[must_use]
    pub fn has_barostat(&self) -> bool {
        self.barostat.is_some() || self.stages.iter().any(|stage| stage.barostat.is_some())
    }

    /// Whether a stage or the measurement has swap moves.
    #[must_use]
    pub fn has_swaps(&self) -> bool {
        self.swap.is_some() || self.stages.iter().any(|stage| stage.swap.is_some())
    }

    /// Gravitational accelerations that stages set. The measurement comes last.
    pub fn gravities(&self) -> impl Iterator<Item = Vector> + '_ {
        self.stages.iter().map(|stage| stage.gravity).chain([self.gravity]).flatten()
    }

    /// Whether a stage has an Andersen thermostat.
    #[must_use]
    pub fn has_andersen(&self) -> bool {
        self.thermostats().any(|thermostat| matches!(thermostat, Thermostat::Andersen { .. }))
    }
}

/// A stage before the last measurement.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct StagePlan {
    /// Name of the stage in progress reports and results.
    pub name: String,
    /// Limit of the stage, or of the measurement in a measured stage.
    pub limit: Until,
    /// Thermostat of the stage.
    pub thermostat: Option<Thermostat>,
    /// Barostat of the stage, which needs a thermostat.
    pub barostat: Option<Barostat>,
    /// Swap moves of the stage.
    pub swap: Option<Swap>,
    /// Gravity during the stage `[length / time^2]`, instead of the accelerations of the species.
    pub gravity: Option<Vector>,
    /// Growth of the diameters.
    pub growth: Option<Growth>,
    /// Equilibration of a measured stage; `None` if the stage is not measured.
    pub measured: Option<Equilibration>,
}

impl StagePlan {
    /// Duration of the stage, if it is known before the run `[time]`.
    #[must_use]
    pub fn duration(&self) -> Option<f64> {
        let of = |limit: &Until| limit.time.filter(|_| limit.events.is_none());
        let equilibration = match &self.measured {
            Some(measured) if !measured.is_empty() => of(&measured.limit).filter(|_| !measured.until_stationary)?,
            _ => 0.0,
        };
        of(&self.limit).filter(|_| self.growth.is_none()).map(|time| equilibration + time)
    }

    fn streams(&self) -> usize {
        if self.measured.is_some() { EQUILIBRATION_AND_MEASUREMENT } else { 1 }
    }
}

/// Equilibration of a measured stage.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Equilibration {
    /// Limit at which the equilibration ends.
    pub limit: Until,
    /// Whether the equilibration ends as soon as no observable drifts.
    pub until_stationary: bool,
}

impl Equilibration {
    /// Whether no equilibration is planned.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

const EQUILIBRATION_AND_MEASUREMENT: usize = 2;

/// Lubachevsky-Stillinger growth of the diameters: B. D. Lubachevsky and F. H. Stillinger, J. Stat. Phys. 60, 561
/// (1990), [doi:10.1007/BF01025983](https://doi.org/10.1007/BF01025983). All diameters grow by the factor
/// `1 + rate (t - t_0)` from the start `t_0` of the stage.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Growth {
    /// Growth rate, relative to the diameters at the start of the stage `[1 / time]`.
    pub rate: f64,
    /// Packing fraction or compressibility factor at which the growth ends.
    pub until: GrowthTarget,
}

/// Target of the growth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum GrowthTarget {
    /// The fraction of the box that the particles fill.
    PackingFraction(f64),
    /// The compressibility factor `p V / (N k T)`, which diverges at jamming.
    CompressibilityFactor(f64),
}
