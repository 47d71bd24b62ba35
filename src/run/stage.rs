//! The stages of a run, their order and their settings.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::Vector;
use crate::model::run_plan::{EQUILIBRATION, MEASUREMENT};
use crate::model::{Barostat, Growth, RunPlan, StagePlan, Swap, Thermostat, Until};

/// A stage of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stage {
    /// A stage of the scene that is not measured, by its index in the list of stages.
    Preparation(u32),
    /// The equilibration before a measured stage of the scene, by its index in the list of stages.
    EquilibrationOf(u32),
    /// The measurement in a measured stage of the scene, by its index in the list of stages.
    MeasurementOf(u32),
    /// The equilibration before the last measurement.
    Equilibration,
    /// The last measurement.
    Measurement,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Settings {
    pub limit: Until,
    pub thermostat: Option<Thermostat>,
    pub barostat: Option<Barostat>,
    pub swap: Option<Swap>,
    pub growth: Option<Growth>,
    pub gravity: Option<Vector>,
    /// Whether the stage ends as soon as no observable drifts.
    pub until_stationary: bool,
    /// Index of the stage's stream of random numbers, relative to the first stream of the scene.
    pub stream: usize,
}

impl Settings {
    /// Whether the stage has a limit, growth or an automatic end. A stage without an end is skipped.
    pub fn has_end(&self) -> bool {
        self.limit != Until::default() || self.growth.is_some() || self.until_stationary
    }

    pub fn is_endless(&self) -> bool {
        self.until_stationary && self.limit == Until::default()
    }
}

impl Stage {
    pub(super) fn first(plan: &RunPlan) -> Self {
        Self::listed(plan, 0)
    }

    /// Returns the stages of a plan that are simulated, in order.
    pub fn simulated(plan: &RunPlan) -> impl Iterator<Item = Self> + '_ {
        Self::all(plan).filter(|stage| stage.settings(plan).has_end())
    }

    pub(crate) fn all(plan: &RunPlan) -> impl Iterator<Item = Self> + '_ {
        std::iter::successors(Some(Self::first(plan)), |stage| stage.next(plan))
    }

    /// Returns the first stage of `plan.stages[number]`. After the last entry, this is the final equilibration.
    fn listed(plan: &RunPlan, number: u32) -> Self {
        match plan.stages.get(number as usize) {
            Some(stage) if stage.measured.is_some() => Self::EquilibrationOf(number),
            Some(_) => Self::Preparation(number),
            None => Self::Equilibration,
        }
    }

    pub(super) fn next(self, plan: &RunPlan) -> Option<Self> {
        match self {
            Self::Preparation(number) | Self::MeasurementOf(number) => Some(Self::listed(plan, number + 1)),
            Self::EquilibrationOf(number) => Some(Self::MeasurementOf(number)),
            Self::Equilibration => Some(Self::Measurement),
            Self::Measurement => None,
        }
    }

    /// Whether this stage is a measurement.
    #[must_use]
    pub fn is_measured(self) -> bool {
        matches!(self, Self::MeasurementOf(_) | Self::Measurement)
    }

    pub(crate) fn settings(self, plan: &RunPlan) -> Settings {
        let listed = |number: u32| (&plan.stages[number as usize], plan.first_stream_of(number as usize));
        let plain = |limit, (thermostat, barostat, swap, gravity), stream| Settings {
            limit,
            thermostat,
            barostat,
            swap,
            growth: None,
            gravity,
            until_stationary: false,
            stream,
        };
        let of_stage = |stage: &StagePlan| (stage.thermostat, stage.barostat, stage.swap, stage.gravity);
        let of_run = (plan.thermostat, plan.barostat, plan.swap, plan.gravity);
        match self {
            Self::Preparation(number) => {
                let (stage, stream) = listed(number);
                Settings { growth: stage.growth, ..plain(stage.limit, of_stage(stage), stream) }
            }
            Self::EquilibrationOf(number) => {
                let (stage, stream) = listed(number);
                let before = stage.measured.unwrap_or_default();
                Settings { until_stationary: before.until_stationary, ..plain(before.limit, of_stage(stage), stream) }
            }
            Self::MeasurementOf(number) => {
                let (stage, stream) = listed(number);
                plain(stage.limit, of_stage(stage), stream + 1)
            }
            Self::Equilibration => {
                let (before, stream) = (plan.last_equilibration(), plan.first_stream_of(plan.stages.len()));
                Settings { until_stationary: before.until_stationary, ..plain(before.limit, of_run, stream) }
            }
            Self::Measurement => plain(plan.limit, of_run, plan.first_stream_of(plan.stages.len()) + 1),
        }
    }

    /// Returns the name in the scene file. An equilibration has the name of its measurement.
    pub(crate) fn listed_name(self, plan: &RunPlan) -> &str {
        match self {
            Self::Preparation(number) | Self::EquilibrationOf(number) | Self::MeasurementOf(number) => {
                plan.stages.get(number as usize).map_or("", |stage| stage.name.as_str())
            }
            Self::Equilibration | Self::Measurement => MEASUREMENT,
        }
    }

    /// Returns the name of the stage in output files.
    #[must_use]
    pub fn name(self, plan: &RunPlan) -> Cow<'_, str> {
        let listed = |number: u32| plan.stages.get(number as usize).map_or("", |stage| stage.name.as_str());
        match self {
            Self::Preparation(number) | Self::MeasurementOf(number) => Cow::Borrowed(listed(number)),
            Self::EquilibrationOf(number) => Cow::Owned(format!("{} {EQUILIBRATION}", listed(number))),
            Self::Equilibration => Cow::Borrowed(EQUILIBRATION),
            Self::Measurement => Cow::Borrowed(MEASUREMENT),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Equilibration, StagePlan};

    fn plan() -> RunPlan {
        let stage = |name: &str, measured| StagePlan { name: name.into(), measured, ..StagePlan::default() };
        let before = Equilibration { limit: Until::events(7), until_stationary: false };
        let second = StagePlan { limit: Until::time(2.0), ..stage("b", Some(before)) };
        RunPlan { stages: vec![stage("a", None), second, stage("c", None)], ..RunPlan::default() }
    }

    #[test]
    fn a_measured_stage_has_an_equilibration_and_two_streams() {
        let plan = plan();
        let stages: Vec<Stage> = Stage::all(&plan).collect();
        let names: Vec<_> = stages.iter().map(|stage| stage.name(&plan)).collect();
        assert_eq!(names, ["a", "b equilibration", "b", "c", "equilibration", "measurement"]);
        let streams: Vec<_> = stages.iter().map(|stage| stage.settings(&plan).stream).collect();
        assert_eq!((streams, plan.streams()), (vec![0, 1, 2, 3, 4, 5], 6));
        let measured: Vec<_> = stages.iter().map(|stage| stage.is_measured()).collect();
        assert_eq!(measured, [false, false, true, false, false, true]);
        assert_eq!(stages[1].settings(&plan).limit, Until::events(7));
        assert_eq!(stages[2].settings(&plan).limit, Until::time(2.0));
    }
}
