//! Measured stages of a run: a table of their means, and a section for each stage.

mod plots;

pub(super) use plots::{TEMPERATURE, is_long, is_spread};

use super::html::{cell, escape, quantity, table};
use super::inputs::{Inputs, Results};
use super::{figures, results};
use crate::analysis::observables::{Answer, OBSERVABLES};

pub(super) fn section(inputs: &Inputs) -> Option<String> {
    let stages: Vec<Results<'_>> = inputs.of_stages().collect();
    if stages.is_empty() {
        return None;
    }
    let parts: String = stages.iter().map(part).collect();
    let all: Vec<Results<'_>> = stages.into_iter().chain([inputs.last()]).collect();
    Some(comparison(&all) + &plots::plots(&all) + &parts)
}

fn comparison(all: &[Results<'_>]) -> String {
    let is_there = |name: &str| all.iter().any(|results| results.observables.contains_key(name));
    let columns: Vec<(&str, &str)> = OBSERVABLES.iter().copied().filter(|(name, _)| is_there(name)).collect();
    let head = |(name, unit): &(&str, &str)| {
        let unit = all.first().map_or_else(|| (*unit).to_owned(), |results| results.unit_of(unit));
        ("n", escape(&quantity(&name.replace('_', " "), &unit)))
    };
    let line = |results: &Results<'_>| {
        let name = results.stage.map_or_else(
            || "<a href=\"#results\">measurement</a>".to_owned(),
            |name| format!("<a href=\"#{}\">{}</a>", escape(&anchor(name)), escape(name)),
        );
        let shown = |(name, _): &(&str, &str)| {
            let observable = results.observables.get(*name);
            let shown = observable.map(|observable| results::shown(name, observable, results.events));
            cell("td", "n", &name.replace('_', " "), &shown.unwrap_or_default())
        };
        let verdict = match results.equilibrated.verdict {
            Answer::Yes => cell("td", "sound", "equilibrated", "✓ yes"),
            Answer::No => cell("td", "failed", "equilibrated", "✗ no"),
            Answer::Unknown => cell("td", "", "equilibrated", "unknown"),
        };
        format!("<tr><th scope=\"row\">{name}</th>{verdict}{}</tr>\n", columns.iter().map(shown).collect::<String>())
    };
    let heads = ["stage", "equilibrated"].map(|name| ("", name.to_owned())).into_iter().chain(columns.iter().map(head));
    let lines: String = all.iter().map(line).collect();
    table("results", "Means over each measured stage and their standard errors", heads, &lines)
}

fn part(stage: &Results<'_>) -> String {
    let name = stage.stage.unwrap_or_default();
    let reasons = match stage.equilibrated.verdict {
        Answer::Yes => String::new(),
        _ => format!(
            "<p class=\"aside\">Equilibrated: {} ({}).</p>\n",
            stage.equilibrated.verdict,
            escape(&stage.equilibrated.reasons.join("; "))
        ),
    };
    format!(
        "<details>\n<summary>Stage {}: {} events</summary>\n<div id=\"{}\">{reasons}{}{}</div></details>\n",
        escape(name),
        stage.events,
        escape(&anchor(name)),
        results::section(stage),
        figures::section(stage),
    )
}

fn anchor(stage: &str) -> String {
    format!("stage-{stage}")
}
