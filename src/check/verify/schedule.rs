//! The stages that a replay goes through: when each ends, and which surfaces are there.

use crate::model::run_plan::MEASUREMENT;
use crate::model::{Equilibration, Limit, RunPlan, SceneSurface};

/// A stretch of a run that is left to replay.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stretch {
    /// The stage that it belongs to, as surfaces have it.
    pub stage: String,
    pub limit: Limit,
}

/// All stretches of a run, the next one last. `None` if the end of one is not planned and the surfaces after it are others.
pub(super) fn schedule(plan: &RunPlan, surfaces: &[SceneSurface]) -> Option<Vec<Stretch>> {
    let all = stretches(plan);
    let first_open = all.iter().position(|(_, stage)| stage.until_stationary);
    if let Some(((stage, _), later)) = first_open.and_then(|at| all[at..].split_first()) {
        let are_same = |other: &str| surfaces.iter().all(|it| it.is_in(stage) == it.is_in(other));
        if !later.iter().all(|(other, _)| are_same(other)) {
            return None;
        }
    }
    let planned = all.iter().take(first_open.unwrap_or(all.len()));
    let mut ends: Vec<Stretch> = planned
        .filter(|(_, stage)| stage.limit != Limit::default())
        .map(|(stage, planned)| Stretch { stage: (*stage).to_owned(), limit: planned.limit })
        .collect();
    // A scene that does not say how long to run, or whose equilibration ends by what it measures, can be replayed for ever.
    let open = first_open.and_then(|at| all.get(at)).or(if ends.is_empty() { all.last() } else { None });
    ends.extend(open.map(|(stage, _)| Stretch { stage: (*stage).to_owned(), limit: Limit::default() }));
    ends.reverse();
    Some(ends)
}

/// Equilibrations and measurements in their order, those without an end too, each with the name of its stage.
fn stretches(plan: &RunPlan) -> Vec<(&str, Equilibration)> {
    let until = |limit| Equilibration { limit, until_stationary: false };
    let listed = plan.stages.iter().flat_map(|stage| {
        let name = stage.name.as_str();
        [(name, stage.measured.unwrap_or_default()), (name, until(stage.limit))]
    });
    listed.chain([(MEASUREMENT, plan.last_equilibration()), (MEASUREMENT, until(plan.limit))]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;
    use crate::model::{StagePlan, SurfaceLaw, SurfaceShape};

    fn of(stages: &[(&str, bool)], gate: &[&str]) -> Option<Vec<Stretch>> {
        let stage = |&(name, until_stationary): &(&str, bool)| StagePlan {
            name: name.to_owned(),
            limit: Limit::events(7),
            measured: until_stationary.then_some(Equilibration { until_stationary, ..Equilibration::default() }),
            ..StagePlan::default()
        };
        let shape = SurfaceShape::Plane { point: Vector::zeros(), normal: Vector::z() };
        let mut surface = SceneSurface::new("gate", shape, SurfaceLaw::Reflecting { restitution: 1.0 });
        surface.stages = gate.iter().map(|name| (*name).to_owned()).collect();
        let stages = stages.iter().map(stage).collect();
        schedule(&RunPlan { stages, limit: Limit::time(2.0), ..RunPlan::default() }, &[surface])
    }

    #[test]
    fn stages_come_in_their_order_with_their_names() {
        let found = of(&[("a", false), ("b", false)], &["a"]).unwrap();
        let stretch = |stage: &str, limit| Stretch { stage: stage.to_owned(), limit };
        let expected =
            [stretch(MEASUREMENT, Limit::time(2.0)), stretch("b", Limit::events(7)), stretch("a", Limit::events(7))];
        assert_eq!(found, expected);
    }

    #[test]
    fn a_stage_that_ends_by_what_it_measures_goes_on_unless_surfaces_change_after_it() {
        let open = |gate: &[&str]| of(&[("a", false), ("b", true)], gate);
        let expected = [("b", Limit::default()), ("a", Limit::events(7))];
        for gate in [&[][..], &["a"], &["b", MEASUREMENT]] {
            let found = open(gate).unwrap();
            let found: Vec<(&str, Limit)> = found.iter().map(|it| (it.stage.as_str(), it.limit)).collect();
            assert_eq!(found, expected, "{gate:?}");
        }
        assert_eq!(open(&["b"]), None);
        assert_eq!(open(&[MEASUREMENT]), None);
    }
}
