//! Results of a run as text for `report.txt`.

use std::fmt::Write;

use crate::analysis::instruments::Measured;
use crate::analysis::observables::OBSERVABLES;
use crate::analysis::statistics::{Estimate, Stationarity};
use crate::base::text::{clock, short};
use crate::engine::event::EventCounts;
use crate::engine::{InletCounts, Simulation};
use crate::io::Summary;
use crate::io::rates::{Rate, rates, told_apart};
use crate::model::{Inlet, Scene, StageSwaps, VolumeMoves};
use crate::run::{Ending, Finished, Stage};
use crate::view::{audit, describe};

type Means<T> = [(&'static str, T)];

/// Maximum number of lines for the results of instruments.
const MOST_NUMBERS: usize = 48;

const MOST_RATES: usize = 12;

/// Returns the results of a run: the system, the end of the run, means and the audit.
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
    lines.threads(simulation);
    lines.pair("ended", &ending(finished));
    let event_counts = &measurement.event_counts;
    let seconds = measurement.wall_seconds;
    let rate = if seconds > 0.0 { event_counts.physical() as f64 / seconds } else { 0.0 };
    let measured =
        format!("a time of {}, {} events", scene.units().of_time(measurement.duration), event_counts.physical());
    lines.pair("measured", &format!("{measured}, {} ({} events/s)", clock(seconds), short(rate)));
    let EventCounts { core, capture, release, bounce, wall, transition, exit, entry, .. } = *event_counts;
    let kinds = kinds([core, capture, release, bounce, wall], |count| count.to_string());
    if !kinds.is_empty() {
        lines.pair("events", &kinds);
    }
    if scene.has_flow() {
        lines.pair("particles", &format!("{entry} entered, {exit} left"));
    }
    for (inlet, counts) in scene.inlets().iter().zip(simulation.inlets()) {
        lines.pair(&format!("inlet {}", inlet.name), &of_inlet(inlet, &counts));
    }
    lines.pair("cell or list transitions", &transition.to_string());
    if let Some(reason) = finished.frames_limit {
        lines.pair("frames", reason);
    }
    if !finished.observables.is_empty() {
        lines.title("mean and standard error");
        lines.means(&finished.observables, &finished.stationarity, event_counts, scene);
    }
    lines.moves(finished.volume_moves.as_ref());
    lines.swaps(&finished.swaps);
    lines.instruments("results of instruments", &finished.measured);
    lines.rates(&rates(simulation, &finished.event_counts_by_species, finished.measurement.duration));
    for stage in &finished.stages {
        let event_counts = &stage.measurement.event_counts;
        let (duration, events) = (scene.units().of_time(stage.measurement.duration), event_counts.physical());
        lines.title(&format!("stage {}, a time of {duration}, {events} events", stage.name));
        lines.means(&stage.observables, &stage.stationarity, event_counts, scene);
        lines.moves(stage.volume_moves.as_ref());
        lines.pair("equilibrated", &stage.equilibrium.to_string());
        lines.instruments("results of instruments in this stage", &stage.measured);
        lines.rates(&rates(simulation, &stage.event_counts_by_species, stage.measurement.duration));
    }
    lines.title("state of the measurement");
    lines.pair("equilibrated", &finished.equilibrium.to_string());
    lines.audit(finished);
    lines.text()
}

fn of_inlet(inlet: &Inlet, counts: &InletCounts) -> String {
    let mut words = format!("{} entered in all", counts.entered);
    if !inlet.recirculate.is_empty() {
        words += &format!(", including {} that returned", counts.returned);
    }
    match counts.waiting {
        0 => {}
        waiting if inlet.recirculate.is_empty() => {
            words += &format!(", and {waiting} wait for a free place: the inlet cannot keep its rate");
        }
        waiting => words += &format!(", and {waiting} wait for a free place"),
    }
    words
}

/// Describes numbers of core, capture, release, bounce and wall events, such as `12 core, 3 wall`.
#[must_use]
pub fn kinds(counts: [u64; 5], shown: fn(u64) -> String) -> String {
    let kinds = ["core", "capture", "release", "bounce", "wall"].into_iter().zip(counts);
    let kinds = kinds.filter(|(_, count)| *count > 0).map(|(name, count)| format!("{} {name}", shown(count)));
    kinds.collect::<Vec<_>>().join(", ")
}

fn ending(finished: &Finished) -> String {
    let time = finished.simulation.scene().units().of_time(finished.simulation.time());
    let stage = if finished.stage == Stage::Measurement { "" } else { " before the measurement" };
    match &finished.ending {
        Ending::Time => format!("at t = {time}, the requested time"),
        Ending::Events => format!("at t = {time}, after the requested number of events"),
        Ending::Condition => format!("at t = {time}, where an instrument ended the run"),
        Ending::Idle => format!("at t = {time}, because nothing will happen any more"),
        Ending::GaveUp => {
            format!(
                "GAVE UP at t = {time}{stage}: no event happened during a million rows of output, or for a very long time"
            )
        }
        Ending::Unsettled => {
            format!(
                "GAVE UP at t = {time}{stage}: the equilibration did not end, because an observable still drifts, or \
                 its drift is unknown"
            )
        }
        Ending::Interrupted => format!("INTERRUPTED at t = {time}{stage}"),
        Ending::Jammed(jam) => format!("FAILED at t = {time}{stage}: {jam}"),
        Ending::Blocked(blocked) => format!("FAILED at t = {time}{stage}: {blocked}"),
        Ending::Arrested(arrest) => {
            format!("FAILED at t = {time}{stage}: {}", arrest.told(finished.simulation.scene()))
        }
        Ending::Broken(broken) => format!("FAILED at t = {time}{stage}: {broken}"),
    }
}

/// Lines of text with names and values in two columns.
#[derive(Debug, Clone, Default)]
pub struct Lines(String);

impl Lines {
    /// Adds a line with a name and its value.
    pub fn pair(&mut self, name: &str, value: &str) {
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

    fn means(&mut self, means: &Means<Estimate>, verdicts: &Means<Stationarity>, counted: &EventCounts, scene: &Scene) {
        for (name, estimate) in means {
            let unit = OBSERVABLES.iter().find(|(known, _)| known == name).map_or("1", |(_, unit)| unit);
            let verdict = verdicts.iter().find(|(known, _)| known == name).map(|(_, verdict)| *verdict);
            let words = describe::observable(name, estimate, verdict, counted.physical());
            self.pair(&name.replace('_', " "), &format!("{words} [{}]", scene.unit_of(unit)));
        }
    }

    fn moves(&mut self, moves: Option<&VolumeMoves>) {
        if let Some(moves) = moves {
            self.pair("volume moves", &describe::volume_moves(moves));
        }
    }

    fn swaps(&mut self, swaps: &[StageSwaps]) {
        for StageSwaps { stage, moves } in swaps {
            self.pair(&format!("swap moves in {stage}"), &describe::swap_moves(moves));
        }
    }

    fn instruments(&mut self, title: &str, measured: &Measured) {
        let numbers = &measured.numbers;
        if numbers.is_empty() {
            return;
        }
        self.title(title);
        let longest = numbers.iter().take(MOST_NUMBERS).map(|number| number.title.chars().count()).max();
        let width = longest.map_or(32, |longest| (longest + 1).max(32));
        for number in numbers.iter().take(MOST_NUMBERS) {
            let unit = &number.unit;
            let words = number.estimate().map(|estimate| format!("{} [{unit}]", describe::estimate(&estimate)));
            self.line(&format!("{:<width$}{}", number.title, words.as_deref().unwrap_or("insufficient data")));
        }
        if numbers.len() > MOST_NUMBERS {
            self.pair("", &format!("and {} more in measurements.json", numbers.len() - MOST_NUMBERS));
        }
    }

    fn rates(&mut self, all: &[Rate]) {
        let all = told_apart(all);
        if all.is_empty() {
            return;
        }
        self.title("events by kind and species, per time");
        for rate in all.iter().take(MOST_RATES) {
            self.pair(&rate.title(), &rate.words());
        }
        if all.len() > MOST_RATES {
            self.pair("", &format!("and {} more in summary.json", all.len() - MOST_RATES));
        }
    }

    fn threads(&mut self, simulation: &Simulation) {
        let threads = match simulation.processes() {
            1 => simulation.threads().to_string(),
            processes => format!("{} in each of {processes} processes", simulation.threads()),
        };
        let is_asked = simulation.threads() > 1 || simulation.processes() > 1;
        let text = match simulation.single_thread().filter(|_| is_asked) {
            Some(why) => format!("1 of {threads}: {why}"),
            None => match (simulation.thread_work(), simulation.domain_work()) {
                (Some(work), _) => format!("{threads}: {work}"),
                (_, Some(work)) => format!("{threads}: {work}"),
                _ if is_asked => format!("1 of {threads}: one thread was faster"),
                _ if simulation.chooses_threads() => format!("1: {}", describe::AUTO_THREADS),
                _ => return,
            },
        };
        for (line, name) in text.lines().zip(["threads", "", ""]) {
            self.pair(name, line);
        }
    }

    fn audit(&mut self, finished: &Finished) {
        self.title("audit of the whole run");
        let summary = Summary::of(finished);
        for row in audit::rows(&summary, Some(finished.simulation.scene())) {
            let why = row.why.map_or_else(String::new, |why| format!(": {why}"));
            let limit = if row.limit.is_empty() { String::new() } else { format!("; the limit is {}", row.limit) };
            let relative = if row.is_relative { ", relative" } else { "" };
            self.pair(row.what, &format!("{}{relative}{why}{limit}", row.value));
        }
        self.pair("verdict", if summary.faults.is_empty() { "sound" } else { "FAILED" });
        for fault in &summary.faults {
            self.pair("", fault);
        }
    }

    /// Returns all lines.
    #[must_use]
    pub fn text(self) -> String {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::instruments::Number;

    #[test]
    fn every_requested_quantity_has_a_line_even_without_data() {
        let number = |title: &str, mean: Option<f64>| {
            let estimate = mean.map(|mean| Estimate { mean, standard_error: Some(0.25) });
            Number::estimated("x", title, "length^2 / time", estimate, "")
        };
        let mut measured = Measured::default();
        let mut lines = Lines::default();
        lines.instruments("results", &measured);
        assert_eq!(lines.clone().text(), "");
        measured.numbers.extend([number("Diffusion coefficient", Some(2.0)), number("Viscosity", None)]);
        lines.instruments("results", &measured);
        let expected = format!(
            "\nresults\n{:<32}2.00 +- 0.25 [length^2 / time]\n{:<32}insufficient data\n",
            "Diffusion coefficient", "Viscosity"
        );
        assert_eq!(lines.text(), expected);
        let mut lines = Lines::default();
        measured.numbers = vec![number("Many", None); MOST_NUMBERS + 3];
        lines.instruments("results", &measured);
        let text = lines.text();
        assert!(text.ends_with("and 3 more in measurements.json\n") && text.matches("Many").count() == MOST_NUMBERS);
    }
}
