//! How far a run has come, on the terminal or in lines.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use super::verify::VerifyStep;
use crate::base::text::{clock, short};
use crate::check::verify;
use crate::model::Scene;
use crate::run::{self, Stage};
use crate::view::movie;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Between two lines where there is no terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(5);
/// Between two states of the bar.
const BAR_INTERVAL: Duration = Duration::from_millis(100);
/// Steps of the bar.
const STEPS: u64 = 1000;

/// A bar on a terminal, hidden elsewhere.
pub fn bar(steps: u64, template: &str, is_quiet: bool) -> ProgressBar {
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    let is_shown = !is_quiet && std::io::stderr().is_terminal();
    let target = if is_shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    ProgressBar::with_draw_target(Some(steps), target).with_style(style)
}

/// Shows progress: a bar on a terminal, a line every few seconds elsewhere, always on standard error.
pub struct Display {
    name: String,
    bar: ProgressBar,
    is_quiet: bool,
    shown: Option<Instant>,
    stage: Option<(&'static str, Instant)>,
    rate: Rate,
}

/// How far something is.
pub struct State {
    stage: &'static str,
    time: f64,
    events: u64,
    fraction: f64,
    /// Unit of the counter.
    unit: &'static str,
}

/// Unit of the counter of runs.
const EVENTS: &str = "events";

impl From<&run::Progress> for State {
    fn from(progress: &run::Progress) -> Self {
        let stage = match progress.stage {
            Stage::Preparation(_) => "preparing",
            Stage::EquilibrationOf(_) | Stage::Equilibration => "equilibrating",
            Stage::MeasurementOf(_) | Stage::Measurement => "measuring",
        };
        Self { stage, time: progress.time, events: progress.events, fraction: progress.fraction(), unit: EVENTS }
    }
}

impl From<&verify::VerifyProgress> for State {
    fn from(progress: &verify::VerifyProgress) -> Self {
        let stage = if progress.is_proving { "proving" } else { "replaying" };
        Self { stage, time: progress.time, events: progress.events, fraction: progress.fraction(), unit: EVENTS }
    }
}

impl From<&VerifyStep<'_>> for State {
    fn from(step: &VerifyStep<'_>) -> Self {
        match step {
            VerifyStep::Proof(progress) => Self::from(*progress),
            VerifyStep::Files(progress) => Self { stage: "comparing files", ..Self::from(*progress) },
        }
    }
}

impl From<&movie::MovieProgress> for State {
    fn from(progress: &movie::MovieProgress) -> Self {
        let movie::MovieProgress { is_drawing, frames, time, fraction } = *progress;
        Self { stage: if is_drawing { "drawing" } else { "reading" }, time, events: frames, fraction, unit: "frames" }
    }
}

/// Events per second of late.
struct Rate {
    since: Instant,
    events: u64,
    per_second: f64,
}

impl Display {
    pub fn new(scene: &Scene, is_quiet: bool) -> Self {
        Self::named(scene.name().to_owned(), is_quiet)
    }

    /// For work of a name.
    pub fn named(name: String, is_quiet: bool) -> Self {
        let bar = bar(STEPS, "{prefix} {wide_bar:.cyan/blue} {percent:>3} %\n  {msg}", is_quiet);
        let rate = Rate { since: Instant::now(), events: 0, per_second: 0.0 };
        Self { name, bar, is_quiet, shown: None, stage: None, rate }
    }

    /// Shows how far the run is, if it is time to.
    pub fn show(&mut self, progress: impl Into<State>) {
        let progress = progress.into();
        if self.is_quiet {
            return;
        }
        let now = Instant::now();
        let started = match self.stage {
            Some((stage, started)) if stage == progress.stage => started,
            _ => {
                self.stage = Some((progress.stage, now));
                self.rate = Rate { since: now, events: progress.events, per_second: 0.0 };
                now
            }
        };
        let interval = if self.bar.is_hidden() { LINE_INTERVAL } else { BAR_INTERVAL };
        if now - *self.shown.get_or_insert(now) < interval {
            return;
        }
        self.shown = Some(now);
        self.rate.see(progress.events, now);
        let State { fraction, stage, unit, .. } = progress;
        // Few are counted on the average.
        let rate = match unit {
            EVENTS => short(self.rate.per_second),
            _ => format!("{:.1}", progress.events as f64 / (now - started).as_secs_f64().max(1e-3)),
        };
        let text = format!(
            "t = {:.4}, {} {unit}, {rate} {unit}/s{}",
            progress.time,
            short(progress.events as f64),
            left(fraction, now - started),
        );
        if self.bar.is_hidden() {
            // A closed standard error is no reason to stop.
            let percent = 100.0 * fraction;
            let _ = writeln!(std::io::stderr(), "{}, {stage}: {percent:.1} %, {text}", self.name);
            return;
        }
        self.bar.set_prefix(format!("{}, {stage}", self.name));
        self.bar.set_message(text);
        #[expect(clippy::cast_possible_truncation, reason = "a fraction of STEPS")]
        let position = (fraction * STEPS as f64) as u64;
        self.bar.set_position(position);
    }

    /// Removes the bar.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

impl Rate {
    fn see(&mut self, events: u64, now: Instant) {
        let seconds = (now - self.since).as_secs_f64();
        if seconds > 0.0 {
            let latest = events.saturating_sub(self.events) as f64 / seconds;
            // Half a second of memory in the bar, so that the number can be read.
            let keep = if self.per_second > 0.0 { libm::exp(-seconds / 0.5) } else { 0.0 };
            self.per_second = keep * self.per_second + (1.0 - keep) * latest;
        }
        (self.since, self.events) = (now, events);
    }
}

/// Remaining time at the speed so far.
fn left(fraction: f64, elapsed: Duration) -> String {
    if fraction <= 0.0 {
        return String::new();
    }
    let seconds = elapsed.as_secs_f64() * (1.0 - fraction) / fraction;
    format!(", {} left", clock(seconds))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_follows_from_the_speed_so_far() {
        assert_eq!(left(0.25, Duration::from_secs(10)), ", 30 s left");
        assert_eq!(left(0.0, Duration::from_secs(10)), "");
    }
}
