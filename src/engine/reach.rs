//! Pairs that are predicted one by one, because they accelerate relative to each other or grow, or meet in several images of a small box: which of
//! them can meet at all before the earliest contact so far, several at a time in SIMD lanes.

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

/// The search of [`Batch::within_reach_of_another_image`].
struct AnotherImage<'a, const FALLING: bool> {
    batch: &'a Batch<'a>,
    me: &'a Streamed,
    others: &'a [u32],
    horizon: f64,
}

impl<const FALLING: bool> Work for AnotherImage<'_, FALLING> {
    type Output = u32;

    #[inline(always)]
    fn run<F: Lanes>(self) -> u32 {
        let Self { batch, me, others, horizon } = self;
        let mut bits = 0;
        for (at, ids) in others.chunks_exact(F::COUNT).enumerate() {
            let squared: [f64; MOST_LANES] =
                std::array::from_fn(|k| batch.squared[batch.species_of(ids[k % F::COUNT])]);
            let (r, v) = batch.seen_from::<F, FALLING>(me, ids);
            // The nearest of the other images is across one side: `(L - |x|)^2 - x^2 = L^2 - 2 L |x|`.
            let mut further = F::all(f64::INFINITY);
            for (&apart, &period) in r.iter().zip(batch.periods).filter(|(_, period)| period.is_finite()) {
                let distance = F::all(0.0).if_less(apart, apart, F::all(0.0).sub(apart));
                further = F::all(period * period).sub(distance.mul(F::all(2.0 * period))).least(further);
            }
            let reach = F::each(&squared).sqrt().add(dot(&v, &v).sqrt().mul(F::all(horizon)));
            let beyond = dot(&r, &r).add(further).sub(reach.mul(reach).mul(F::all(SLACK)));
            bits |= beyond.at_most(0.0) << (at * F::COUNT);
        }
        bits
    }
}

impl Batch<'_> {
    /// Which of [`MOST_LANES`] others, as bits, `me` can meet within a finite time in any image but the nearest one, in a periodic box. It may say
    /// so of one that cannot be met, never the other way round.
    #[inline]
    fn within_reach_of_another_image<const FALLING: bool>(&self, me: &Streamed, others: &[u32], horizon: f64) -> u32 {
        self.width.run(AnotherImage::<FALLING> { batch: self, me, others, horizon })
    }

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

    /// The first contact with any of some uncaptured others in another image than the nearest, before the particle leaves its cell at the time
    /// `leaves` and is predicted anew.
    pub(super) fn predict_further_images(
        &self,
        me: &Streamed,
        others: &[u32],
        leaves: f64,
        prediction: &mut Prediction,
    ) {
        let batch = self.others(me, true);
        for some in others.chunks_exact(MOST_LANES) {
            let horizon = prediction.contact_time.min(leaves) - me.time;
            let mut bits = if horizon < f64::INFINITY {
                batch.within_reach_of_another_image::<FALLING>(me, some, horizon)
            } else {
                (1 << MOST_LANES) - 1
            };
            while bits != 0 {
                let other = some[bits.trailing_zeros() as usize];
                let squared = batch.squared[batch.species_of(other)];
                if other != me.id && squared >= 0.0 {
                    let (state, _) = self.relative(me, other);
                    self.predict_in_further_images(me, other, &state, squared, prediction);
                }
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
    use crate::engine::predict::{Scratch, is_out_of_reach};
    use crate::model::Scene;
    use crate::model::potential::Potential;
    use crate::physics::detection::lanes::Simd;
    use crate::scene::{Amount, Fill, Lattice, SceneBuilder};

    /// Spheres of one kind or two in a box of so few cells that they meet in several images.
    fn in_a_small_box(count: u64, packing_fraction: f64, is_mixture: bool) -> Scene {
        let hard_sphere = |diameter| Potential::hard_sphere(diameter).unwrap();
        let mut scene = SceneBuilder::new("small").species("A", 1.0, 1.0).interaction("A", "A", hard_sphere(1.0), 1.0);
        let mut fill = Fill::new(Lattice::FaceCentredCubic, "A");
        if is_mixture {
            fill.composition.push(("B".to_owned(), 1.0));
            scene = scene.species("B", 0.7, 0.6).interaction("A", "B", hard_sphere(0.8), 0.9).interaction(
                "B",
                "B",
                hard_sphere(0.6),
                1.0,
            );
        }
        fill = fill.count(count).amount(Amount::PackingFraction(packing_fraction));
        scene.add_fill(fill).temperature(1.0).build().unwrap()
    }

    fn meets_in_all_images<const TABLE: bool>(scene: &Scene) {
        let mut engine = Engine::<false, TABLE>::new(scene);
        assert!(!engine.ranges.further_images.is_empty());
        let mut scratch = Scratch::new(scene.particles().len());
        let mut met = 0;
        for part in 1..=30 {
            engine.advance(Until::events(50 * part), &mut None).unwrap();
            let now = engine.clock.now;
            for particle in engine.particles() {
                let mut one_by_one = Prediction::NONE;
                let me = engine.streamed(particle, now);
                engine.particles().for_each(|other| engine.predict_uncaptured_pair(&me, other, &mut one_by_one));
                let prediction = engine.predict(particle, now, &mut scratch);
                if one_by_one.contact_time < prediction.transition_time {
                    assert_eq!(prediction.contact_time, one_by_one.contact_time, "{particle}");
                    assert_eq!(prediction.partner, one_by_one.partner, "{particle}");
                    met += 1;
                } else {
                    assert!(prediction.is_transition() || prediction.contact_time == one_by_one.contact_time);
                }
            }
        }
        assert!(met > 100, "{met}");
    }

    #[test]
    fn in_a_small_box_a_particle_meets_all_images() {
        for (count, packing_fraction) in [(2, 0.05), (4, 0.1), (8, 0.3), (16, 0.2), (32, 0.45)] {
            meets_in_all_images::<false>(&in_a_small_box(count, packing_fraction, false));
            meets_in_all_images::<true>(&in_a_small_box(count, packing_fraction, true));
        }
    }

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
