//! Pairs that are predicted one by one, because they accelerate relative to each other or grow: which of them can meet at all before the earliest
//! contact so far, several at a time in SIMD lanes.

use super::batch::{Batch, dot};
use super::parts::Engine;
use super::predict::Streamed;
use super::prediction::Prediction;
use crate::physics::detection::lanes::{Lanes, MOST_LANES, Work};

/// The distances at which others are met that can only be predicted one by one.
pub(super) struct Reach<'a> {
    /// By species, their squares `[length^2]`; infinite for one that is always looked at, negative infinity for one that is not met so.
    pub squared: &'a [f64],
    /// The factor of the distances now, and how fast it grows `[1, 1 / time]`.
    pub growth: [f64; 2],
}

/// The search of [`Batch::within_reach`].
struct WithinReach<'a> {
    batch: &'a Batch<'a>,
    me: &'a Streamed,
    others: &'a [u32],
    reach: &'a Reach<'a>,
    horizon: f64,
}

/// Much more than what rounding makes of a squared distance, so that no pair is left out that one by one would be within reach.
const SLACK: f64 = 1.0 + 1e-9;

impl Work for WithinReach<'_> {
    type Output = u32;

    #[inline(always)]
    fn run<F: Lanes>(self) -> u32 {
        let Self { batch, me, others, reach: Reach { squared, growth: [scale, rate] }, horizon } = self;
        let gained = F::all(0.5 * batch.acceleration.norm() * horizon);
        let factor = F::all(scale + rate * horizon);
        let mut bits = 0;
        for (at, ids) in others.chunks_exact(F::COUNT).enumerate() {
            let squared: [f64; MOST_LANES] = std::array::from_fn(|k| squared[batch.species_of(ids[k % F::COUNT])]);
            // Those that accelerate themselves are not where this says, but have an infinite range; that of those that are not met is no number.
            let (r, v) = batch.seen_from::<F, false>(me, ids);
            let reach = F::each(&squared).sqrt().mul(factor).add(dot(&v, &v).sqrt().add(gained).mul(F::all(horizon)));
            let beyond = dot(&r, &r).sub(reach.mul(reach).mul(F::all(SLACK)));
            bits |= beyond.at_most(0.0) << (at * F::COUNT);
        }
        bits
    }
}

impl Batch<'_> {
    /// Which of [`MOST_LANES`] others, as bits, `me` can meet within a finite time, at the sum of all speeds:
    /// `|r| <= s + (|v| + |a| T / 2 + growth) T`. It may say so of one that cannot be met, never the other way round.
    #[inline]
    pub fn within_reach(&self, me: &Streamed, others: &[u32], reach: &Reach<'_>, horizon: f64) -> u32 {
        self.width.run(WithinReach { batch: self, me, others, reach, horizon })
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// The first contact with any of some uncaptured others of which each has to be predicted by itself: those within reach before the
    /// earliest contact so far.
    pub(super) fn predict_within_reach(
        &self,
        me: &Streamed,
        wraps: bool,
        others: &[u32],
        reach: &Reach<'_>,
        prediction: &mut Prediction,
    ) {
        let batch = self.others(me, wraps);
        for some in others.chunks_exact(MOST_LANES) {
            let is_met = |k: usize| reach.squared[batch.species_of(some[k])] >= 0.0;
            let mut bits = (0..MOST_LANES).fold(0, |bits, k| bits | u32::from(is_met(k)) << k);
            let horizon = prediction.contact_time - me.time;
            if bits != 0 && horizon < f64::INFINITY {
                bits = batch.within_reach(me, some, reach, horizon);
            }
            while bits != 0 {
                self.predict_uncaptured_pair(me, some[bits.trailing_zeros() as usize], prediction);
                bits &= bits - 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Until;
    use crate::engine::batch::tests::falling;
    use crate::engine::predict::is_out_of_reach;
    use crate::physics::detection::lanes::Simd;

    #[test]
    fn all_that_one_by_one_is_within_reach_is_so_in_lanes() {
        let mut engine = Engine::<true, true>::new(&falling());
        let others: Vec<u32> = engine.particles().collect();
        let (mut within, mut beyond) = (0, 0);
        for part in 1..=20 {
            engine.advance(Until::events(100 * part), &mut None).unwrap();
            let now = engine.clock.now;
            for particle in engine.particles().filter(|&particle| !engine.is_static(particle)) {
                let me = engine.streamed(particle, now);
                let species = |id: u32| engine.row(id);
                let squared = engine.pairs.rules.accelerated_squared(species(particle)).unwrap();
                let reach = Reach { squared, growth: [1.0, 0.0] };
                for (width, horizon) in Simd::all().into_iter().zip([0.01, 0.1, 1.0].into_iter().cycle()) {
                    let batch = Batch { width, ..engine.others(&me, true) };
                    for some in others.chunks_exact(MOST_LANES) {
                        let bits = batch.within_reach(&me, some, &reach, horizon);
                        for (k, &other) in some.iter().enumerate() {
                            let meeting = engine.pairs.rules.meeting(species(particle), species(other));
                            let (state, _) = engine.relative(&me, other);
                            let is_reached = meeting.is_accelerated
                                && !is_out_of_reach(&state, &me.acceleration, meeting.squared, horizon);
                            let is_kept = bits >> k & 1 == 1;
                            assert_eq!(is_kept, is_reached, "{particle} {other} {horizon}");
                            within += u32::from(is_kept);
                            beyond += u32::from(!is_kept && meeting.is_accelerated);
                        }
                    }
                }
            }
        }
        assert!(within > 1_000 && beyond > 1_000, "{within} {beyond}");
    }
}
