//! In debug builds, and in tests that ask for it, a single engine repeats randomly chosen windows.

use super::Domains;
use crate::engine::Until;
use crate::engine::parts::Engine;
use crate::engine::prediction::Prediction;

/// On average, one of this many windows is checked.
const ONE_OF: u64 = 32;

impl<const FALLING: bool, const TABLE: bool> Domains<FALLING, TABLE> {
    /// Returns a copy of the single engine if the next window is to be checked.
    pub(super) fn copy_to_check(&mut self, whole: &mut Engine<FALLING, TABLE>) -> Option<Engine<FALLING, TABLE>> {
        // All processes must choose the same windows, so the random number depends on the number of windows only.
        let random = self.work.windows.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
        let checked = self.checked.filter(|checked| *checked != self.work.windows)?;
        if !random.is_multiple_of(ONE_OF) {
            return None;
        }
        self.checked = Some(checked.max(self.work.windows));
        self.join(whole);
        Some(whole.clone())
    }

    pub(super) fn check_window(
        &mut self,
        whole: &mut Engine<FALLING, TABLE>,
        until: Until,
        other: Option<Engine<FALLING, TABLE>>,
    ) {
        let Some(mut other) = other else { return };
        self.settle(whole);
        self.settle_plans(whole);
        let Some(cut) = &self.cut else { return };
        let time = whole.clock.start + (whole.clock.epoch + cut.now);
        let result = other.advance(Until { time: Some(time), ..until }, &mut None);
        // Because of rounding, the two engines may stop at different times or in different epochs.
        if other.clock.epoch != whole.clock.epoch || other.since_epoch(time) != cut.now || cut.now <= 0.0 {
            return;
        }
        assert_eq!(result.map(|_| other.counts.executed), Ok(whole.counts.executed), "at time {time}");
        for particle in whole.particles() {
            let [one, two] = [&*whole, &other].map(|engine| all_of(engine, particle));
            assert_eq!(one, two, "after a window at time {time}");
        }
    }
}

/// Returns the state of a particle as text. The data of a contact are left out if no contact is predicted.
fn all_of<const FALLING: bool, const TABLE: bool>(engine: &Engine<FALLING, TABLE>, particle: u32) -> String {
    let mut record = engine.record(particle);
    record.captured.iter_mut().for_each(|captured| captured.sort_by_key(|pair| pair.partner));
    if let Some(prediction) = record.prediction.as_mut().filter(|prediction| prediction.contact_time == f64::INFINITY) {
        *prediction = Prediction { transition_time: prediction.transition_time, ..Prediction::NONE };
    }
    format!("{record:?}")
}
