//! Audit of a run on its page.

use std::borrow::Cow;

use super::html::{escape, number};
use crate::analysis::observables::{Answer, Equilibrium};
use crate::base::text::{digits, tiny};
use crate::io::Summary;
use crate::model::Scene;
use crate::view::describe::momentum_changes;

/// The section of the page.
pub(super) fn section(summary: &Summary, scene: Option<&Scene>) -> String {
    let verdict = if summary.faults.is_empty() {
        "<p class=\"sound\"><strong>✓ Sound.</strong> Everything that must be conserved was, to within the rounding of its arithmetic, \
         and no particles overlapped deeper than rounding explains or the scene allows.</p>\n"
            .to_owned()
    } else {
        let faults: String = summary.faults.iter().map(|fault| format!("<li>{}</li>\n", escape(fault))).collect();
        format!(
            "<p class=\"failed\"><strong>✗ Failed.</strong> These results cannot be trusted:</p>\n<ul>\n{faults}</ul>\n"
        )
    };
    let state = state(&summary.equilibrated);
    let rows: String = invariants(summary, scene).iter().map(Row::html).collect();
    format!(
        "{verdict}{state}<details>\n<summary>The audit in numbers</summary>\n<div class=\"wide\"><table class=\"audit\">\n<caption>Audit of the whole run, its equilibration included</caption>\n\
         <thead><tr><th scope=\"col\">what</th><th scope=\"col\" class=\"n\">value</th><th scope=\"col\" class=\"n\">limit</th>\
         <th scope=\"col\">verdict</th></tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n</details>\n"
    )
}

/// Whether the measurement was in equilibrium, which no audit of single events can show.
fn state(equilibrium: &Equilibrium) -> String {
    let reasons: Vec<String> = equilibrium.reasons.iter().map(|reason| escape(&number(reason))).collect();
    let reasons = reasons.join(", ");
    match equilibrium.verdict {
        Answer::Yes => {
            "<p class=\"sound\"><strong>✓ Equilibrated: yes.</strong> No observable drifts while it is measured.</p>\n"
                .to_owned()
        }
        Answer::No if equilibrium.reasons.iter().any(|reason| reason == Equilibrium::COOLS) => format!(
            "<p class=\"failed\"><strong>✗ Equilibrated: no.</strong> Between the first quarter and the second half of the \
             measurement {reasons}: means are those over the time of the measurement.</p>\n"
        ),
        Answer::No => format!(
            "<p class=\"failed\"><strong>✗ Equilibrated: no.</strong> Between the first quarter and the second half of the \
             measurement {reasons}: means and errors are not those of a steady state. A longer equilibration, or a longer run, is the cure.</p>\n"
        ),
        Answer::Unknown => {
            let reasons = if reasons.is_empty() { "this run does not tell".to_owned() } else { reasons };
            format!("<p><strong>Equilibrated: unknown</strong> ({reasons}).</p>\n")
        }
    }
}

/// A line of the table.
struct Row {
    what: &'static str,
    how: Cow<'static, str>,
    value: String,
    limit: String,
    /// `None` where there is nothing to judge.
    is_sound: Option<bool>,
}

impl Row {
    fn html(&self) -> String {
        let verdict = match self.is_sound {
            Some(true) => "<td class=\"sound\">✓ within</td>",
            Some(false) => "<td class=\"failed\">✗ beyond</td>",
            None => "<td></td>",
        };
        format!(
            "<tr><th scope=\"row\">{}<small>{}</small></th><td class=\"n\">{}</td><td class=\"n limit\">{}</td>{verdict}</tr>\n",
            self.what,
            self.how,
            escape(&number(&self.value)),
            escape(&number(&self.limit)),
        )
    }
}

/// Scale of the drift of momentum; or the reasons why momentum is not conserved, as far as the scene could be read.
fn how_momentum(drift: Option<f64>, scene: Option<&Scene>) -> Cow<'static, str> {
    let reasons = scene.filter(|_| drift.is_none()).map(momentum_changes).filter(|reasons| !reasons.is_empty());
    reasons.map_or("drift, relative to the sum of m |v|".into(), |reasons| {
        format!("changed by {}", escape(&reasons)).into()
    })
}

fn invariants(summary: &Summary, scene: Option<&Scene>) -> Vec<Row> {
    let (energy, momentum, events) = (&summary.energy, &summary.momentum, &summary.events);
    let none = String::new;
    let mut rows = vec![
        Row {
            what: "energy ledger",
            how: "error of kinetic and potential energy, with what was dissipated and supplied, relative".into(),
            value: tiny(energy.ledger_error_relative),
            limit: format!("{:.1e}", energy.ledger_limit),
            is_sound: Some(energy.ledger_error_relative <= energy.ledger_limit),
        },
        Row {
            what: "momentum",
            how: how_momentum(momentum.drift, scene),
            value: momentum.drift.map_or_else(|| "not conserved".to_owned(), tiny),
            limit: momentum.drift.map_or_else(none, |_| format!("{:.1e}", momentum.limit)),
            is_sound: momentum.drift.map(|drift| drift <= momentum.limit),
        },
    ];
    rows.extend(overlaps(summary));
    let counts = [
        ("events at turning points", "grazing, decided by the rule of the paper", events.turning_point),
        ("contacts altered by the TC model", "made elastic or slowed down", events.tc_altered),
    ];
    for (what, how, count) in counts.into_iter().filter(|(_, _, count)| *count > 0) {
        rows.push(Row { what, how: how.into(), value: count.to_string(), limit: none(), is_sound: None });
    }
    if energy.dissipated > 0.0 {
        let (what, how) = ("energy dissipated", "by restitution, and counted in the ledger");
        rows.push(Row { what, how: how.into(), value: digits(energy.dissipated), limit: none(), is_sound: None });
    }
    if energy.supplied != 0.0 {
        let (what, how) =
            ("energy supplied", "by thermostats, walls, growth or shear, less what they took; counted in the ledger");
        rows.push(Row { what, how: how.into(), value: digits(energy.supplied), limit: none(), is_sound: None });
    }
    rows
}

fn overlaps(summary: &Summary) -> Vec<Row> {
    let (overlap, invalid) = (&summary.overlap, summary.events.in_invalid_state);
    let is_judged_by_rounding = overlap.limit.is_none() && overlap.initial == 0;
    let limit = || overlap.limit.map_or_else(|| "round-off".to_owned(), |limit| format!("{limit:.1e}"));
    // Without a limit of the scene, each overlap was judged by the round-off of its own coordinates.
    let is_sound = |depth: f64, number: u64| match overlap.limit {
        Some(limit) => Some(depth <= limit),
        None => is_judged_by_rounding.then_some(number == 0),
    };
    let mut rows = vec![
        Row {
            what: "deepest overlap at an event",
            how: "relative to the contact distance".into(),
            value: tiny(overlap.deepest_executed),
            limit: limit(),
            is_sound: if overlap.initial == 0 { is_sound(overlap.deepest_executed, invalid) } else { None },
        },
        Row {
            what: "deepest overlap at the end",
            how: "relative to the contact distance".into(),
            value: tiny(overlap.deepest_final),
            limit: limit(),
            is_sound: is_sound(overlap.deepest_final, overlap.r#final as u64),
        },
        Row {
            what: "events in invalid states",
            how: "deeper in an overlap than rounding explains".into(),
            value: invalid.to_string(),
            limit: if is_judged_by_rounding { "0".to_owned() } else { String::new() },
            is_sound: is_judged_by_rounding.then_some(invalid == 0),
        },
    ];
    if overlap.initial > 0 {
        let left = format!("{} at the end", overlap.r#final);
        let end = overlap.resolved_after.map_or(left, |time| format!("gone after t = {}", digits(time)));
        rows.push(Row {
            what: "overlapping pairs at the start",
            how: "allowed by the scene".into(),
            value: format!("{}, {end}", overlap.initial),
            limit: String::new(),
            is_sound: None,
        });
    }
    rows
}
