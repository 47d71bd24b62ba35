//! SIMD filter for pairs that must be predicted one by one. Such pairs accelerate relative to each other, or meet in
//! several images of a small box. The filter skips pairs that cannot meet before the earliest contact found so far.

use super::batch::{Batch, dot};
use super::{SLACK_FACTOR, Streamed};
use crate::engine::images::lanes::{Sliding, are_apart, nearest_sheared, squared_distance_to_others};
use crate::engine::pairs::rules::Reaches;
use crate::engine::parts::Engine;
use crate::engine::prediction::Prediction;
use crate::physics::detection::lanes::{Lanes, MOST_LANES, Work};

#[inline(always)]
fn select<F: Lanes>(others: &[u32], is_selected: impl Fn(&[u32]) -> u32) -> u32 {
    let in_lanes = others.chunks_exact(F::COUNT).enumerate();
    in_lanes.fold(0, |bits, (at, numbers)| bits | is_selected(numbers) << (at * F::COUNT))
}

/// Returns `squared - reach^2`, with a margin for round-off.
#[inline(always)]
fn beyond<F: Lanes>(squared: F, reach: F) -> F {
    squared.sub(reach.mul(reach).mul(F::all(SLACK_FACTOR)))
}

struct WithinReach<'a, const SIZED: bool> {
    batch: &'a Batch<'a>,
    me: &'a Streamed,
    others: &'a [u32],
    /// Contact distances with each table row. Infinity selects every pair, and excluded pairs are not selected.
    reaches: &'a Reaches<'a>,
    horizon: f64,
}

impl<const SIZED: bool> Work for WithinReach<'_, SIZED> {
    type Output = u32;

    #[inline(always)]
    fn run<F: Lanes>(self) -> u32 {
        let Self { batch, me, others, reaches, horizon } = self;
        let gained = F::all(0.5 * batch.acceleration.norm() * horizon);
        select::<F>(others, |numbers| {
            // Accelerated partners have an infinite contact distance, so they are always selected. A negative infinite
            // square makes the reach NaN, so the comparison is false.
            let (r, v) = batch.seen_from::<F, false>(me, numbers);
            let path = dot(&v, &v).sqrt().add(gained).mul(F::all(horizon));
            beyond(dot(&r, &r), batch.squares::<F, SIZED>(me, reaches, numbers).sqrt().add(path)).at_most(0.0)
        })
    }
}

struct AnotherImage<'a, const FALLING: bool, const SIZED: bool> {
    batch: &'a Batch<'a>,
    me: &'a Streamed,
    others: &'a [u32],
    horizon: f64,
}

impl<const FALLING: bool, const SIZED: bool> Work for AnotherImage<'_, FALLING, SIZED> {
    type Output = u32;

    #[inline(always)]
    fn run<F: Lanes>(self) -> u32 {
        let Self { batch, me, others, horizon } = self;
        select::<F>(others, |numbers| {
            let (r, v) = batch.seen_from::<F, FALLING>(me, numbers);
            let further = squared_distance_to_others(&r, batch.periods);
            let path = dot(&v, &v).sqrt().mul(F::all(horizon));
            beyond(dot(&r, &r).add(further), batch.squares::<F, SIZED>(me, &batch.reaches, numbers).sqrt().add(path))
                .at_most(0.0)
        })
    }
}

struct HalfAPeriodAway<'a, const FALLING: bool> {
    batch: &'a Batch<'a>,
    me: &'a Streamed,
    others: &'a [u32],
    least: [f64; 3],
}

impl<const FALLING: bool> Work for HalfAPeriodAway<'_, FALLING> {
    type Output = u32;

    #[inline(always)]
    fn run<F: Lanes>(self) -> u32 {
        let Self { batch, me, others, least } = self;
        select::<F>(others, |numbers| are_apart(&batch.seen_from::<F, FALLING>(me, numbers).0, least))
    }
}

struct AcrossSlidingSides<'a, const FALLING: bool, const SIZED: bool> {
    batch: &'a Batch<'a>,
    me: &'a Streamed,
    others: &'a [u32],
    sliding: Sliding,
    horizon: f64,
}

impl<const FALLING: bool, const SIZED: bool> Work for AcrossSlidingSides<'_, FALLING, SIZED> {
    type Output = u32;

    #[inline(always)]
    fn run<F: Lanes>(self) -> u32 {
        let Self { batch, me, others, sliding, horizon } = self;
        select::<F>(others, |numbers| {
            let (mut r, mut v) = batch.seen_from::<F, FALLING>(me, numbers);
            nearest_sheared(&mut r, &mut v, batch.periods, &sliding);
            let path = dot(&v, &v).sqrt().mul(F::all(horizon));
            beyond(dot(&r, &r), batch.squares::<F, SIZED>(me, &batch.reaches, numbers).sqrt().add(path)).at_most(0.0)
        })
    }
}

impl Batch<'_> {
    /// Selects candidates whose nearest image is at least `least` away along some axis. Returns a bit mask.
    #[inline]
    pub fn half_a_period_away<const FALLING: bool>(&self, me: &Streamed, others: &[u32], least: [f64; 3]) -> u32 {
        self.width.run(HalfAPeriodAway::<FALLING> { batch: self, me, others, least })
    }

    /// Selects all candidates that `me` may meet within a finite time `horizon` in a sheared box. Returns a bit mask.
    #[inline]
    fn within_reach_across<const FALLING: bool>(
        &self,
        me: &Streamed,
        others: &[u32],
        sliding: Sliding,
        horizon: f64,
    ) -> u32 {
        if self.has_sizes() {
            self.width.run(AcrossSlidingSides::<FALLING, true> { batch: self, me, others, sliding, horizon })
        } else {
            self.width.run(AcrossSlidingSides::<FALLING, false> { batch: self, me, others, sliding, horizon })
        }
    }

    /// Like [`Self::within_reach_across`], for contacts in images other than the nearest image.
    #[inline]
    fn within_reach_of_another_image<const FALLING: bool>(&self, me: &Streamed, others: &[u32], horizon: f64) -> u32 {
        if self.has_sizes() {
            self.width.run(AnotherImage::<FALLING, true> { batch: self, me, others, horizon })
        } else {
            self.width.run(AnotherImage::<FALLING, false> { batch: self, me, others, horizon })
        }
    }

    /// Selects candidates that could reach `me` within a finite time `horizon` by flying straight at `me`. Returns a
    /// bit mask.
    #[inline]
    pub fn within_reach(&self, me: &Streamed, others: &[u32], reaches: &Reaches<'_>, horizon: f64) -> u32 {
        if self.has_sizes() {
            self.width.run(WithinReach::<true> { batch: self, me, others, reaches, horizon })
        } else {
            self.width.run(WithinReach::<false> { batch: self, me, others, reaches, horizon })
        }
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Predicts the first contact with uncaptured candidates, one by one. Distant candidates are skipped.
    pub(in crate::engine) fn predict_within_reach(
        &self,
        me: &Streamed,
        wraps: bool,
        others: &[u32],
        reaches: &Reaches<'_>,
        prediction: &mut Prediction,
    ) {
        let batch = self.batch_of(me, wraps);
        let rows = &self.state.rows;
        let is_met = |other: &u32| reaches.squared[usize::from(rows[*other as usize])] >= 0.0;
        let kept = |some: &[u32], horizon: f64| {
            let bits = (0..).zip(some).fold(0, |bits, (k, other)| bits | u32::from(is_met(other)) << k);
            if bits == 0 || horizon == f64::INFINITY { bits } else { batch.within_reach(me, some, reaches, horizon) }
        };
        for_each_kept(others, [me.time, f64::INFINITY], prediction, kept, |other, prediction| {
            self.predict_uncaptured_pair(me, other, prediction);
        });
    }

    /// Predicts the first contact of a particle near the sliding sides of a sheared box. At the time `leaves`, the
    /// particle leaves its cell and is predicted again, so later contacts are ignored.
    pub(in crate::engine) fn predict_next_to_sliding_sides(
        &self,
        me: &Streamed,
        others: &[u32],
        sliding: Sliding,
        leaves: f64,
        prediction: &mut Prediction,
    ) {
        let batch = self.batch_of(me, false);
        let kept = |some: &[u32], horizon: f64| match horizon {
            f64::INFINITY => ALL,
            _ => batch.within_reach_across::<FALLING>(me, some, sliding, horizon),
        };
        for_each_kept(others, [me.time, leaves], prediction, kept, |other, prediction| {
            self.predict_uncaptured_pair(me, other, prediction);
        });
    }

    pub(in crate::engine) fn predict_further_images(
        &self,
        me: &Streamed,
        others: &[u32],
        leaves: f64,
        prediction: &mut Prediction,
    ) {
        let batch = self.batch_of(me, true);
        let kept = |some: &[u32], horizon: f64| match horizon {
            f64::INFINITY => ALL,
            _ => batch.within_reach_of_another_image::<FALLING>(me, some, horizon),
        };
        for_each_kept(others, [me.time, leaves], prediction, kept, |other, prediction| {
            let squared = batch.reaches.squared[batch.row_of(other)];
            if other != me.number && squared >= 0.0 {
                let squared = self.squared_of_pair(squared, [me.number, other]);
                let (state, _) = self.relative(me, other);
                self.predict_in_further_images(me, other, (&state, false), squared, prediction);
            }
        });
    }
}

const ALL: u32 = (1 << MOST_LANES) - 1;

/// Calls `predict` for the candidates that `kept` selects. `kept` receives a horizon: the time from `now` to the
/// earliest contact found so far, or to `last` if that is earlier.
#[inline]
fn for_each_kept(
    others: &[u32],
    [now, last]: [f64; 2],
    prediction: &mut Prediction,
    kept: impl Fn(&[u32], f64) -> u32,
    predict: impl Fn(u32, &mut Prediction),
) {
    for some in others.chunks_exact(MOST_LANES) {
        let mut bits = kept(some, prediction.contact_time.min(last) - now);
        while bits != 0 {
            predict(some[bits.trailing_zeros() as usize], prediction);
            bits &= bits - 1;
        }
    }
}

#[cfg(test)]
pub(in crate::engine) mod tests;
