//! The final table of a run: the content of `report.txt`.

use std::fmt::Write;

use crate::analysis::observables::OBSERVABLES;
use crate::base::text::{self, clock, digits, short, tiny};
use crate::io::rates::{rates_of, told_apart};
use crate::run::{Ending, Finished, Stage};
use crate::view::describe;

/// Rates that have a line.
const MOST_RATES: usize = 12;

/// Table of the results of a run: the system, the ending, the means and the audit.
#[must_use]
pub fn text(finished: &Finished) -> String {
    let simulation = &finished.simulation;
    let scene = simulation.scene();
    let measurement = &finished.measurement;
    let mut lines = Lines::default();
    lines.pair("scene", &format!("{}, seed {}", scene.name(), scene.seed()));
    lines.pair("particles", &describe::population_of(scene, &simulation.population()));
    lines.pair("engine", &simulation.engine().to_string());
    lines.pair("", &describe::reasons(scene, simulation.engine()));
    lines.pair("ended", &ending(finished));
    let event_counts = &measurement.event_counts;
    let seconds = measurement.wall_seconds;
    let rate = if seconds > 0.0 { event_counts.physical() as f64 / seconds } else { 0.0 };
    let measured = format!("a time of {}, {} events", digits(measurement.duration), event_counts.physical());
    lines.pair("measured", &format!("{measured}, {} ({} events/s)", clock(seconds), short(rate)));
    let kinds =
        kinds(event_counts.core, event_counts.capture, event_counts.release, event_counts.bounce, event_counts.wall);
    if !kinds.is_empty() {
        lines.pair("events", &kinds);
    }
    lines.pair("cell or list transitions", &event_counts.transition.to_string());
    if let Some(reason) = finished.frames_limit {
        lines.pair("frames", reason);
    }
    if !finished.observables.is_empty() {
        lines.title("mean and standard error");
        for (name, estimate) in &finished.observables {
            let unit = OBSERVABLES.iter().find(|(known, _)| known == name).map_or("1", |(_, unit)| unit);
            let unit = text::unit(unit, scene.space().dimensions());
            let verdict = finished.stationarity.iter().find(|(known, _)| known == name).map(|(_, verdict)| *verdict);
            let words = describe::observable(name, estimate, verdict, event_counts.physical());
            lines.pair(&name.replace('_', " "), &format!("{words} [{unit}]"));
        }
    }
    let all = rates_of(finished);
    let all = told_apart(&all);
    if !all.is_empty() {
        lines.title("events by kind and species, by time");
        for rate in all.iter().take(MOST_RATES) {
            lines.pair(&rate.title(), &rate.words());
        }
        if all.len() > MOST_RATES {
            lines.pair("", &format!("and {} more in summary.json", all.len() - MOST_RATES));
        }
    }
    stages(&mut lines, finished);
    lines.title("state of the measurement");
    lines.pair("equilibrated", &finished.equilibrium.to_string());
    audit(&mut lines, finished);
    lines.text()
}

/// The means of the measured stages before the last measurement.
fn stages(lines: &mut Lines, finished: &Finished) {
    let dimensions = finished.simulation.scene().space().dimensions();
    for stage in &finished.stages {
        let events = stage.measurement.event_counts.physical();
        lines.title(&format!(
            "stage {}, a time of {}, {events} events",
            stage.name,
            digits(stage.measurement.duration)
        ));
        for (name, estimate) in &stage.observables {
            let unit = OBSERVABLES.iter().find(|(known, _)| known == name).map_or("1", |(_, unit)| unit);
            let verdict = stage.stationarity.iter().find(|(known, _)| known == name).map(|(_, verdict)| *verdict);
            let words = describe::observable(name, estimate, verdict, events);
            lines.pair(&name.replace('_', " "), &format!("{words} [{}]", text::unit(unit, dimensions)));
        }
        lines.pair("equilibrated", &stage.equilibrium.to_string());
    }
}

/// Numbers of events by kind: `12 core, 3 wall`.
#[must_use]
pub fn kinds(core: u64, capture: u64, release: u64, bounce: u64, wall: u64) -> String {
    let kinds = [("core", core), ("capture", capture), ("release", release), ("bounce", bounce), ("wall", wall)];
    let kinds: Vec<String> = kinds.iter().filter(|(_, n)| *n > 0).map(|(name, n)| format!("{n} {name}")).collect();
    kinds.join(", ")
}

fn ending(finished: &Finished) -> String {
    let time = digits(finished.simulation.time());
    let stage = if finished.stage == Stage::Measurement { "" } else { " before the measurement" };
    match &finished.ending {
        Ending::Time => format!("at t = {time}, the time asked for"),
        Ending::Events => format!("at t = {time}, after the number of events asked for"),
        Ending::Condition => format!("at t = {time}, where an instrument ended it"),
        Ending::Idle => format!("at t = {time}, because nothing will happen any more"),
        Ending::GaveUp => {
            format!("GAVE UP at t = {time}{stage}: nothing has happened for a million rows, or for very long")
        }
        Ending::Unsettled => {
            format!(
                "GAVE UP at t = {time}{stage}: the equilibration was to end by itself, and something never became stationary"
            )
        }
        Ending::Interrupted => format!("INTERRUPTED at t = {time}{stage}"),
        Ending::Jammed(jam) => format!("FAILED at t = {time}{stage}: {jam}"),
        Ending::Arrested(arrest) => format!("FAILED at t = {time}{stage}: {arrest}"),
        Ending::Broken(broken) => format!("FAILED at t = {time}{stage}: {broken}"),
    }
}

fn audit(lines: &mut Lines, finished: &Finished) {
    let audit = &finished.audit;
    let event_counts = &audit.event_counts;
    lines.title("audit of the whole run");
    lines.pair(
        "energy ledger",
        &format!("off by {}, relative; the limit is {:.1e}", tiny(audit.ledger_error), audit.limits.energy),
    );
    let limits = &audit.limits;
    let drift = audit.momentum_drift.map_or_else(
        || format!("not conserved: {}", describe::momentum_changes(finished.simulation.scene())),
        |drift| format!("drifted by {}, relative; the limit is {:.1e}", tiny(drift), limits.momentum),
    );
    lines.pair("momentum", &drift);
    let last = audit.deepest_final.map_or(0.0, |overlap| overlap.depth);
    let executed = tiny(event_counts.deepest_overlap);
    lines.pair("deepest overlap", &format!("{executed} at an event, {} at the end, of the distance", tiny(last)));
    if audit.initial.overlaps > 0 {
        let count = text::plural(audit.initial.overlaps, "pair");
        let end = audit.initial.resolved_after.map_or_else(
            || format!("{} left at the end", audit.final_overlaps),
            |time| format!("the last gone after a time of {}", digits(time)),
        );
        lines.pair("overlapping at the start", &format!("{count}, {end}"));
    }
    lines.pair("in invalid states", &text::plural(event_counts.in_invalid_state, "event"));
    lines.pair("at turning points", &text::plural(event_counts.turning_point, "event"));
    if finished.simulation.scene().contact_time().is_some() {
        let contacts = event_counts.tc_contacts.max(1) as f64;
        let fraction = 100.0 * event_counts.tc_altered as f64 / contacts;
        lines.pair("TC model altered", &format!("{} contacts, {fraction:.2} % of them", event_counts.tc_altered));
    }
    if audit.dissipated > 0.0 {
        lines.pair("dissipated", &format!("{} of energy", digits(audit.dissipated)));
    }
    let faults = audit.faults();
    lines.pair("verdict", if faults.is_empty() { "sound" } else { "FAILED" });
    for fault in &faults {
        lines.pair("", &fault.to_string());
    }
}

/// Lines of names and values, in two columns.
#[derive(Debug, Clone, Default)]
pub struct Lines(String);

impl Lines {
    /// Adds a name and its value.
    pub fn pair(&mut self, name: &str, value: &str) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{name:<32}{value}");
    }

    /// Adds a heading.
    pub fn title(&mut self, title: &str) {
        let _ = writeln!(self.0, "\n{title}");
    }

    /// Adds a line.
    pub fn line(&mut self, line: &str) {
        let _ = writeln!(self.0, "{line}");
    }

    /// All lines.
    #[must_use]
    pub fn text(self) -> String {
        self.0
    }
}
