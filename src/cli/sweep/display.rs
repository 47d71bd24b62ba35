//! Shows the progress of a sweep: a bar on a terminal, lines elsewhere.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::base::text::printable;
use crate::sweep::{Fate, News, Share, Sweep};
use indicatif::ProgressBar;

use crate::cli::progress::bar;
use crate::cli::warn;

const INTERVAL: Duration = Duration::from_millis(100);
/// Steps of the progress bar per run.
const STEPS: u64 = 1000;
const MOST_NAMED: usize = 3;

pub struct Display {
    bar: ProgressBar,
    is_quiet: bool,
    total: usize,
    state: Mutex<State>,
}

struct State {
    over: usize,
    running: BTreeMap<usize, f64>,
    shown: Instant,
}

impl Display {
    pub fn new(sweep: &Sweep, share: Share, is_quiet: bool) -> Self {
        let total = (0..sweep.points().len()).filter(|place| share.has(*place)).count();
        let template = "{prefix} {wide_bar:.cyan/blue} {percent:>3} %, {eta} left\n  {msg}";
        let bar = bar(total as u64 * STEPS, template, is_quiet);
        let state = State { over: 0, running: BTreeMap::new(), shown: Instant::now() };
        Self { bar, is_quiet, total, state: Mutex::new(state) }
    }

    pub fn show(&self, sweep: &Sweep, place: usize, news: &News<'_>) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        match news {
            News::Progress(progress) => {
                state.running.insert(place, progress.fraction());
            }
            News::Over(fate) => {
                state.running.remove(&place);
                state.over += 1;
                self.line(sweep, place, fate, state.over);
            }
        }
        let is_over = matches!(news, News::Over(_));
        if self.bar.is_hidden() || !is_over && state.shown.elapsed() < INTERVAL {
            return;
        }
        state.shown = Instant::now();
        let all = state.over as f64 + state.running.values().sum::<f64>();
        #[expect(clippy::cast_possible_truncation, reason = "at most the number of points times STEPS")]
        let position = (all * STEPS as f64) as u64;
        let named = state.running.iter().take(MOST_NAMED);
        let mut words: Vec<String> =
            named.map(|(place, part)| format!("{} {:.0} %", sweep.points()[*place].folder(), 100.0 * part)).collect();
        if state.running.len() > MOST_NAMED {
            words.push(format!("and {} more", state.running.len() - MOST_NAMED));
        }
        self.bar.set_prefix(format!("{} of {} runs", state.over, self.total));
        self.bar.set_message(words.join(", "));
        self.bar.set_position(position);
    }

    fn line(&self, sweep: &Sweep, place: usize, fate: &Fate, over: usize) {
        let words = match fate {
            Fate::Done => "done".to_owned(),
            Fate::Kept => return,
            Fate::Failed(why) => format!("failed: {why}"),
            Fate::Elsewhere => "running in another process".to_owned(),
            _ => "interrupted".to_owned(),
        };
        let text = format!("[{over}/{}] {}: {words}", self.total, sweep.points()[place].folder());
        if !self.bar.is_hidden() && matches!(fate, Fate::Failed(_)) {
            self.bar.println(printable(&text));
        } else if self.bar.is_hidden() && !self.is_quiet {
            warn(&text);
        }
    }

    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}
