use super::describe::momentum_changes;
use crate::base::text::{digits, tiny};
use crate::io::Summary;
use crate::io::summary::Events;
use crate::model::{Scene, Separated};

pub(super) struct Row {
    pub what: &'static str,
    pub how: &'static str,
    pub value: String,
    /// Whether `value` is a ratio. Its divisor is given in `how`.
    pub is_relative: bool,
    pub why: Option<String>,
    /// Limit above which the audit fails; may be empty.
    pub limit: String,
    /// Verdict: whether the value is within the limit.
    pub is_sound: Option<bool>,
}

impl Row {
    fn judged(what: &'static str, how: &'static str, value: String, limit: String, is_sound: Option<bool>) -> Self {
        Self { what, how, value, is_relative: true, why: None, limit, is_sound }
    }

    fn told(what: &'static str, how: &'static str, value: String) -> Self {
        Self { is_relative: false, ..Self::judged(what, how, value, String::new(), None) }
    }
}

/// If `scene` is known, the rows explain why momentum is not conserved.
pub(super) fn rows(summary: &Summary, scene: Option<&Scene>) -> Vec<Row> {
    let (energy, events) = (&summary.energy, &summary.events);
    let how = "relative error of the sum of kinetic, potential and dissipated energy, minus the supplied energy";
    let (error, limit) = (energy.ledger_error_relative, energy.ledger_limit);
    let mut rows = vec![Row::judged("energy ledger", how, tiny(error), format!("{limit:.1e}"), Some(error <= limit))];
    rows.push(momentum(summary, scene));
    rows.extend(overlaps(summary));
    if events.turning_point > 0 {
        let how = "grazing events, decided as in the published algorithm";
        rows.push(Row::told("events at turning points", how, events.turning_point.to_string()));
    }
    rows.extend(tc_model(events));
    for (what, how, count) in [
        ("grains that fell asleep", "grains at rest that stopped; counted in the ledger as dissipated", events.rest),
        ("grains that woke up", "by impacts, or because a neighbour moved away", events.wake),
    ] {
        rows.extend(count.map(|count| Row::told(what, how, count.to_string())));
    }
    if energy.dissipated > 0.0 {
        let how = "by restitution; counted in the ledger";
        rows.push(Row::told("energy dissipated", how, digits(energy.dissipated)));
    }
    if energy.supplied != 0.0 {
        let how =
            "by thermostats, walls, growth, shear or the TC model, minus what they removed; counted in the ledger";
        rows.push(Row::told("energy supplied", how, digits(energy.supplied)));
    }
    rows
}

/// Contacts that each rule of the TC model altered.
fn tc_model(events: &Events) -> Vec<Row> {
    let elastic = events.tc_altered.saturating_sub(events.tc_kept + events.tc_slid + events.tc_lifted);
    let part = 100.0 * events.tc_altered as f64 / events.tc_contacts.max(1) as f64;
    let rules = [
        ("altered by the TC model", "contacts whose speed or roughness it changed", events.tc_altered),
        ("elastic by the TC model", "contacts less than tc after the previous one", elastic),
        ("kept apart by the TC model", "contacts that kept speed, to stay apart for tc", events.tc_kept),
        ("sliding by the TC model", "contacts at which particles slide along a barrier", events.tc_slid),
        ("lifted by the TC model", "contacts of grains at rest, which left at the speed g tc / 2", events.tc_lifted),
        (
            "rattling by the TC model",
            "elastic contacts in which the energy of friction went into the normal motion",
            events.tc_returned,
        ),
    ];
    let mut rows = Vec::new();
    for (what, how, count) in rules.into_iter().filter(|(.., count)| *count > 0) {
        let value = if count == events.tc_altered && rows.is_empty() {
            format!("{count} ({part:.2} %)")
        } else {
            count.to_string()
        };
        rows.push(Row::told(what, how, value));
    }
    rows
}

fn momentum(summary: &Summary, scene: Option<&Scene>) -> Row {
    let (what, how) = ("momentum", "drift relative to the sum of m |v|");
    let limit = summary.momentum.limit;
    match summary.momentum.drift {
        Some(drift) => Row::judged(what, how, tiny(drift), format!("{limit:.1e}"), Some(drift <= limit)),
        None => {
            let why = scene.map(momentum_changes).filter(|reasons| !reasons.is_empty());
            Row { why, ..Row::told(what, how, "not conserved".to_owned()) }
        }
    }
}

fn overlaps(summary: &Summary) -> Vec<Row> {
    let (overlap, invalid) = (&summary.overlap, summary.events.in_invalid_state);
    let is_judged_by_rounding = overlap.limit.is_none() && overlap.initial == 0;
    let limit = overlap.limit.map_or_else(|| "round-off".to_owned(), |limit| format!("{limit:.1e}"));
    // Without a limit, round-off decides. If particles overlap at the start, there is no verdict.
    let is_sound = |depth: f64, number: u64| match overlap.limit {
        Some(limit) => Some(depth <= limit),
        None => is_judged_by_rounding.then_some(number == 0),
    };
    let deepest = |what, depth, is_sound| {
        Row::judged(what, "relative to the contact distance", tiny(depth), limit.clone(), is_sound)
    };
    let (executed, last) = (overlap.deepest_executed, overlap.deepest_final);
    let executed_is_sound = if overlap.initial == 0 { is_sound(executed, invalid) } else { None };
    let most = if is_judged_by_rounding { "0".to_owned() } else { String::new() };
    let mut rows = vec![
        deepest("deepest overlap at an event", executed, executed_is_sound),
        deepest("deepest overlap at the end", last, is_sound(last, overlap.r#final as u64)),
        Row {
            limit: most,
            is_sound: is_judged_by_rounding.then_some(invalid == 0),
            ..Row::told("events in invalid states", "overlaps too deep to be round-off", invalid.to_string())
        },
    ];
    if let Some(separated) = overlap.separated {
        let Separated { overlaps, deepest, farthest } = separated;
        let value =
            format!("{overlaps}, up to {}; particles were moved by up to {}", digits(deepest), digits(farthest));
        rows.push(Row::told("overlaps removed at the start", "with separate_overlaps", value));
    }
    if overlap.initial > 0 {
        let end = overlap.resolved_after.map_or_else(
            || format!("{} left at the end", overlap.r#final),
            |time| format!("all resolved after a time of {}", digits(time)),
        );
        let value = format!("{}, {end}", overlap.initial);
        rows.push(Row::told("overlapping pairs at the start", "allowed by the scene", value));
    }
    rows
}
