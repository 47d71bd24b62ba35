//! The stages of a replay, with their ends, surfaces and gravity.

use crate::Vector;
use crate::model::run_plan::MEASUREMENT;
use crate::model::{Equilibration, RunPlan, SceneSurface, StagePlan, Until};

/// A time interval of a run: the equilibration or the measurement of a stage.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stretch {
    /// Name of the stage. The stage determines which surfaces are present.
    pub stage: String,
    /// Gravitational acceleration in the interval; `None` keeps the previous value `[length / time^2]`.
    pub gravity: Option<Vector>,
    pub limit: Until,
}

/// Returns the intervals of a run in reverse order. `None` if surfaces or gravity change after an automatic
/// equilibration, whose end is unknown.
pub(super) fn schedule(plan: &RunPlan, surfaces: &[SceneSurface]) -> Option<Vec<Stretch>> {
    let all = stretches(plan);
    let first_open = all.iter().position(|(_, is_open)| *is_open);
    if let Some(((open, _), later)) = first_open.and_then(|at| all[at..].split_first()) {
        let has_same = |other: &Stretch| {
            let are_same = surfaces.iter().all(|it| it.is_in(&open.stage) == it.is_in(&other.stage));
            are_same && other.gravity.is_none_or(|gravity| open.gravity == Some(gravity))
        };
        if !later.iter().all(|(other, _)| has_same(other)) {
            return None;
        }
    }
    let planned = all.iter().take(first_open.unwrap_or(all.len())).map(|(stretch, _)| stretch);
    let mut ends: Vec<Stretch> = planned.filter(|stretch| stretch.limit != Until::default()).cloned().collect();
    // The last interval has no limit if it is an automatic equilibration, or if no interval has a limit.
    let open = first_open.and_then(|at| all.get(at)).or(if ends.is_empty() { all.last() } else { None });
    ends.extend(open.map(|(stretch, _)| Stretch { limit: Until::default(), ..stretch.clone() }));
    ends.reverse();
    Some(ends)
}

/// Returns the equilibration and the measurement of each stage, in order. The flag marks automatic equilibrations.
fn stretches(plan: &RunPlan) -> Vec<(Stretch, bool)> {
    let both = |name: &str, gravity: Option<Vector>, before: Equilibration, limit: Until| {
        let stretch = |limit| Stretch { stage: name.to_owned(), gravity, limit };
        [(stretch(before.limit), before.until_stationary), (stretch(limit), false)]
    };
    let listed = plan.stages.iter().flat_map(|stage| {
        let StagePlan { name, gravity, measured, limit, .. } = stage;
        both(name, *gravity, measured.unwrap_or_default(), *limit)
    });
    listed.chain(both(MEASUREMENT, plan.gravity, plan.last_equilibration(), plan.limit)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{ContactLaw, SurfaceLaw, SurfaceShape};

    fn of(stages: &[(&str, bool)], gate: &[&str]) -> Option<Vec<Stretch>> {
        let stage = |&(name, until_stationary): &(&str, bool)| StagePlan {
            name: name.to_owned(),
            limit: Until::events(7),
            measured: until_stationary.then_some(Equilibration { until_stationary, ..Equilibration::default() }),
            ..StagePlan::default()
        };
        let shape = SurfaceShape::Plane { point: Vector::zeros(), normal: Vector::z() };
        let mut surface = SceneSurface::new("gate", shape, SurfaceLaw::Reflecting(ContactLaw::smooth(1.0)));
        surface.stages = gate.iter().map(|name| (*name).to_owned()).collect();
        let stages = stages.iter().map(stage).collect();
        schedule(&RunPlan { stages, limit: Until::time(2.0), ..RunPlan::default() }, &[surface])
    }

    #[test]
    fn stages_come_in_their_order_with_their_names() {
        let found = of(&[("a", false), ("b", false)], &["a"]).unwrap();
        let stretch = |stage: &str, limit| Stretch { stage: stage.to_owned(), gravity: None, limit };
        let expected =
            [stretch(MEASUREMENT, Until::time(2.0)), stretch("b", Until::events(7)), stretch("a", Until::events(7))];
        assert_eq!(found, expected);
    }

    #[test]
    fn stage_of_measured_length_must_not_precede_surface_changes() {
        let open = |gate: &[&str]| of(&[("a", false), ("b", true)], gate);
        let expected = [("b", Until::default()), ("a", Until::events(7))];
        for gate in [&[][..], &["a"], &["b", MEASUREMENT]] {
            let found = open(gate).unwrap();
            let found: Vec<(&str, Until)> = found.iter().map(|it| (it.stage.as_str(), it.limit)).collect();
            assert_eq!(found, expected, "{gate:?}");
        }
        assert_eq!(open(&["b"]), None);
        assert_eq!(open(&[MEASUREMENT]), None);
    }

    #[test]
    fn stage_of_measured_length_must_not_precede_gravity_changes() {
        let found = |open: Option<Vector>, later: Option<Vector>| {
            let measured = Some(Equilibration { until_stationary: true, ..Equilibration::default() });
            let first = StagePlan { name: "a".to_owned(), gravity: open, measured, ..StagePlan::default() };
            let plan = RunPlan { stages: vec![first], gravity: later, limit: Until::time(2.0), ..RunPlan::default() };
            let found = schedule(&plan, &[]);
            found.map(|all| all.iter().map(|it| it.gravity).collect::<Vec<_>>())
        };
        let [down, aside] = [-Vector::z(), Vector::x()].map(Some);
        assert_eq!(found(down, down), Some(vec![down]));
        assert_eq!(found(down, None), Some(vec![down]));
        assert_eq!(found(down, aside), None);
        assert_eq!(found(None, aside), None);
    }
}
