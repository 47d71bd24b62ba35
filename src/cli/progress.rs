//! Progress of a run: a bar on a terminal, lines elsewhere.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use super::verify::VerifyStep;
use crate::base::text::{clock, short};
use crate::check::verify;
use crate::model::Scene;
use crate::run::{self, Stage};
use crate::view::movie;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

const LINE_INTERVAL: Duration = Duration::from_secs(5);
const BAR_INTERVAL: Duration = Duration::from_millis(100);
const STEPS: u64 = 1000;

/// Returns a progress bar, hidden if `is_quiet` is set or standard error is not a terminal.
pub fn bar(steps: u64, template: &str, is_quiet: bool) -> ProgressBar {
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    let is_shown = !is_quiet && std::io::stderr().is_terminal();
    let target = if is_shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    ProgressBar::with_draw_target(Some(steps), target).with_style(style)
}

pub struct Display {
    name: String,
    bar: ProgressBar,
    is_quiet: bool,
    shown: Option<Instant>,
    stage: Option<Begun>,
    events: Rate,
    done: Rate,
}

struct Begun {
    name: &'static str,
    since: Instant,
    fraction: f64,
}

pub struct State {
    stage: &'static str,
    time: f64,
    events: u64,
    fraction: f64,
    unit: &'static str,
}

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

/// Growth rate of a count, averaged over a recent time.
struct Rate {
    since: Instant,
    count: f64,
    per_second: f64,
    memory: f64,
}

/// Averaging time of the event rate `[s]`, long enough for a readable number.
const MEMORY_OF_EVENTS: f64 = 0.5;
/// Averaging time of the progress rate `[s]`. Shorter times would make the remaining time jump between unequal tasks.
const MEMORY_OF_DONE: f64 = 10.0;

impl Display {
    pub fn new(scene: &Scene, is_quiet: bool) -> Self {
        Self::named(scene.name().to_owned(), is_quiet)
    }

    pub fn named(name: String, is_quiet: bool) -> Self {
        let bar = bar(STEPS, "{prefix} {wide_bar:.cyan/blue} {percent:>3} %\n  {msg}", is_quiet);
        let now = Instant::now();
        let (events, done) = (Rate::new(now, 0.0, MEMORY_OF_EVENTS), Rate::new(now, 0.0, MEMORY_OF_DONE));
        Self { name, bar, is_quiet, shown: None, stage: None, events, done }
    }

    pub fn show(&mut self, progress: impl Into<State>) {
        let progress = progress.into();
        if self.is_quiet {
            return;
        }
        let now = Instant::now();
        let started = self.began(&progress, now);
        let interval = if self.bar.is_hidden() { LINE_INTERVAL } else { BAR_INTERVAL };
        if now - *self.shown.get_or_insert(now) < interval {
            return;
        }
        self.shown = Some(now);
        self.events.see(progress.events as f64, now);
        self.done.see(progress.fraction, now);
        let State { fraction, stage, unit, .. } = progress;
        // Events are frequent enough for a recent rate. Frames are rare, so their rate is an average over the stage.
        let rate = match unit {
            EVENTS => short(self.events.per_second),
            _ => format!("{:.1}", progress.events as f64 / (now - started).as_secs_f64().max(1e-3)),
        };
        let text = format!(
            "t = {:.4}, {} {unit}, {rate} {unit}/s{}",
            progress.time,
            short(progress.events as f64),
            left(fraction, self.done.per_second),
        );
        if self.bar.is_hidden() {
            // If standard error is closed, the work continues.
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

    /// Returns the start time of the current stage. A new stage has another name or a smaller fraction.
    fn began(&mut self, progress: &State, now: Instant) -> Instant {
        let same = self.stage.take().filter(|it| it.name == progress.stage && it.fraction <= progress.fraction);
        let since = same.map_or(now, |it| it.since);
        if since == now {
            self.events = Rate::new(now, progress.events as f64, MEMORY_OF_EVENTS);
            self.done = Rate::new(now, progress.fraction, MEMORY_OF_DONE);
        }
        self.stage = Some(Begun { name: progress.stage, since, fraction: progress.fraction });
        since
    }

    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

impl Rate {
    fn new(since: Instant, count: f64, memory: f64) -> Self {
        Self { since, count, per_second: 0.0, memory }
    }

    fn see(&mut self, count: f64, now: Instant) {
        let seconds = (now - self.since).as_secs_f64();
        if seconds > 0.0 {
            let latest = (count - self.count).max(0.0) / seconds;
            let keep = if self.per_second > 0.0 { libm::exp(-seconds / self.memory) } else { 0.0 };
            self.per_second = keep * self.per_second + (1.0 - keep) * latest;
        }
        (self.since, self.count) = (now, count);
    }
}

fn left(fraction: f64, per_second: f64) -> String {
    if fraction <= 0.0 || per_second <= 0.0 {
        return String::new();
    }
    format!(", {} left", clock((1.0 - fraction) / per_second))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_left_follows_the_latest_speed() {
        let start = Instant::now();
        let mut done = Rate::new(start, 0.0, MEMORY_OF_DONE);
        assert_eq!(left(0.0, done.per_second), "");
        done.see(0.25, start + Duration::from_secs(10));
        assert_eq!(left(0.25, done.per_second), ", 30 s left");
        for k in 1..=7_u32 {
            done.see(0.25 + 0.1 * f64::from(k), start + Duration::from_secs(10 + 8 * u64::from(k)));
        }
        assert_eq!(left(0.5, 0.0125), ", 40 s left");
        assert!((done.per_second / 0.0125 - 1.0).abs() < 0.01, "{}", done.per_second);
    }

    #[test]
    fn each_stage_has_a_speed_of_its_own() {
        let mut display = Display::named("run".to_owned(), true);
        let state = |fraction: f64| State { stage: "preparing", time: 0.0, events: 0, fraction, unit: EVENTS };
        let start = Instant::now();
        let at = |seconds: u64| start + Duration::from_secs(seconds);
        assert_eq!(display.began(&state(0.1), at(0)), at(0));
        assert_eq!(display.began(&state(0.9), at(9)), at(0));
        assert_eq!(display.began(&state(0.2), at(10)), at(10));
        assert_eq!(display.began(&state(0.3), at(11)), at(10));
    }
}
