//! Contacts of growing spheres. SIMD lanes select a few pairs, and scalar code computes their contact times.

use super::Streamed;
use super::batch::{Batch, TOGETHER, dot};
use crate::engine::distances::growth::GrowingDiameters;
use crate::engine::parts::Engine;
use crate::engine::prediction::Prediction;
use crate::physics::detection::lanes::{Lanes, Work};

/// Relative uncertainty in SIMD lanes. Pairs closer to a limit are left to the scalar code.
const SLACK: f64 = 1e-9;

/// Relative uncertainty of contact times. It is larger than [`SLACK`], because of cancellation.
const SLACK_OF_TIMES: f64 = 1e-6;

struct GrowingContacts<'a, const SIZED: bool> {
    batch: &'a Batch<'a>,
    me: &'a Streamed,
    others: &'a [u32],
    /// Scale factor of all diameters, and its growth rate `[1, 1 / time]`.
    growth: [f64; 2],
    horizon: f64,
}

impl<const SIZED: bool> Work for GrowingContacts<'_, SIZED> {
    type Output = u32;

    #[inline(always)]
    fn run<F: Lanes>(self) -> u32 {
        let Self { batch, me, others, growth: [scale, rate], horizon } = self;
        let (zero, never) = (F::all(0.0), F::all(f64::INFINITY));
        let mut due = [f64::INFINITY; TOGETHER];
        let (mut least, mut unsure) = (F::all(horizon), 0);
        for (at, (due, numbers)) in due.chunks_exact_mut(F::COUNT).zip(others.chunks_exact(F::COUNT)).enumerate() {
            let squared: F = batch.squares::<F, SIZED>(me, &batch.reaches, numbers);
            let (r, v) = batch.seen_from::<F, false>(me, numbers);
            let distance = squared.sqrt();
            let (contact, speed) = (distance.mul(F::all(scale)), distance.mul(F::all(rate)));
            // See [`crate::engine::distances::growth::next_contact`].
            let r2 = dot(&r, &r).sub(contact.mul(contact));
            let b = dot(&r, &v).sub(contact.mul(speed));
            let v2 = dot(&v, &v).sub(speed.mul(speed));
            let squares = b.mul(b);
            let discriminant = squares.sub(v2.mul(r2));
            let root = r2.div(discriminant.sqrt().sub(b));
            let dt = b.if_less(zero, zero.if_less(discriminant, root, never), never);
            // The scalar code handles pairs in contact, grazing pairs, and receding pairs that growth may overtake.
            let is_touching = r2.sub(F::all(SLACK).mul(contact).mul(contact));
            let is_overtaken = b.if_less(zero, never, v2.sub(F::all(SLACK).mul(speed).mul(speed)));
            let is_grazing = discriminant.mul(discriminant).sub(F::all(SLACK * SLACK).mul(squares).mul(squares));
            let is_unsure = is_touching.at_most(0.0) | is_overtaken.at_most(0.0) | is_grazing.at_most(0.0);
            // Species that do not interact have a negative squared distance. The root is NaN, for which all comparisons
            // are false, so the pair is ignored.
            unsure |= is_unsure << (at * F::COUNT);
            let dt = zero.if_less(is_touching, dt, never);
            dt.write(due);
            least = dt.least(least);
        }
        let limit = least.smallest() * (1.0 + SLACK_OF_TIMES);
        let mut bits = 0;
        if limit < f64::INFINITY {
            for (at, due) in due.chunks_exact(F::COUNT).take(others.len() / F::COUNT).enumerate() {
                bits |= F::each(due).at_most(limit) << (at * F::COUNT);
            }
        }
        bits | unsure
    }
}

impl Batch<'_> {
    /// Returns a bit mask of particles in `others` that may be the first to meet `me` before `horizon`. The mask
    /// includes the true first contact. `others` has at most [`TOGETHER`] entries.
    #[inline]
    fn growing_contacts(&self, me: &Streamed, others: &[u32], growth: [f64; 2], horizon: f64) -> u32 {
        if self.has_sizes() {
            self.width.run(GrowingContacts::<true> { batch: self, me, others, growth, horizon })
        } else {
            self.width.run(GrowingContacts::<false> { batch: self, me, others, growth, horizon })
        }
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Predicts the first contact with an uncaptured particle while all diameters grow. The length of `others` is a
    /// multiple of [`MOST_LANES`].
    pub(in crate::engine) fn predict_growing(
        &self,
        me: &Streamed,
        growing: &GrowingDiameters,
        wraps: bool,
        others: &[u32],
        prediction: &mut Prediction,
    ) {
        let batch = self.batch_of(me, wraps);
        let growth = growing.factor(me.time);
        for some in others.chunks(TOGETHER) {
            let mut bits = batch.growing_contacts(me, some, growth, prediction.contact_time - me.time);
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
    use crate::engine::neighbours::Search;
    use crate::engine::neighbours::candidates::Candidates;
    use crate::engine::neighbours::cells::NO_PARTICLE;
    use crate::model::Scene;
    use crate::model::potential::Potential;
    use crate::physics::detection::lanes::Simd;
    use crate::scene::{Fill, InteractionDraft, Lattice, SceneBuilder, SpeciesDraft};

    fn mixture(packing_fraction: f64) -> Scene {
        let hard_sphere = |diameter| Potential::hard_sphere(diameter).unwrap();
        let mut fill = Fill::new(Lattice::FaceCentredCubic, "A");
        fill.composition = [("A", 4.0), ("B", 3.0), ("C", 1.0)].map(|(name, share)| (name.to_owned(), share)).to_vec();
        SceneBuilder::new("mixture")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .species(SpeciesDraft::new("B").mass(0.7).diameter(0.6))
            .species(SpeciesDraft::new("C").mass(1.3).diameter(0.8))
            .interaction(InteractionDraft::new(hard_sphere(1.0)).between("A", "A"))
            .interaction(InteractionDraft::new(hard_sphere(0.8)).between("A", "B"))
            .interaction(InteractionDraft::new(hard_sphere(0.6)).between("B", "B"))
            .interaction(InteractionDraft::new(hard_sphere(0.8)).between("C", "C"))
            .interaction(InteractionDraft::new(hard_sphere(0.9)).between("A", "C"))
            .interaction(InteractionDraft::new(hard_sphere(0.55)).between("B", "C"))
            .fill(fill.count(500).packing_fraction(packing_fraction))
            .temperature(1.0)
            .build()
            .unwrap()
    }

    /// Compares every prediction with tests of all pairs. Returns two flags: cells were used, lists were used.
    fn finds_what_one_by_one_finds<const TABLE: bool>(scene: &Scene, rate: f64, largest: f64) -> [bool; 2] {
        let mut used = [false; 2];
        for width in Simd::all() {
            let mut engine = Engine::<false, TABLE>::new(scene);
            engine.hardware.width = width;
            engine.advance(Until::events(2_000), &mut None).unwrap();
            engine.grow(rate, largest);
            let mut near = Candidates::default();
            let mut met = 0;
            for part in 1..=40 {
                engine.advance(Until::events(2_000 + 300 * part), &mut None).unwrap();
                used[usize::from(engine.neighbours.search() != Search::Cells)] = true;
                let now = engine.clock.now;
                let mut scratch = engine.take_scratch();
                for particle in engine.particles() {
                    let mut one_by_one = Prediction::NONE;
                    let me = engine.streamed(particle, now);
                    // The list is sufficient, because a particle must enter the list before a contact.
                    let others = if let Some(verlet) = engine.neighbours.verlet() {
                        verlet.lists.of(particle)
                    } else {
                        engine.neighbours.find_candidates(particle, engine.row(particle), &mut near);
                        near.found()
                    };
                    others.iter().for_each(|&other| engine.predict_uncaptured_pair(&me, other, &mut one_by_one));
                    let prediction = engine.predict(particle, now, &mut scratch);
                    assert_eq!(prediction.contact_time, one_by_one.contact_time, "{particle}");
                    assert_eq!(prediction.partner, one_by_one.partner, "{particle}");
                    met += u32::from(prediction.partner != NO_PARTICLE);
                }
            }
            assert!(met > 1_000, "{met}");
            assert!(engine.scale() > 1.0, "{}", engine.scale());
        }
        used
    }

    #[test]
    fn simd_finds_the_same_first_growth_contact_as_scalar_search() {
        let mut used = [false; 2];
        for (packing_fraction, largest) in [(0.1, 1.3), (0.3, 1.15), (0.42, 1.06)] {
            // At the lowest rate, the spheres grow more slowly than they move. At the highest rate, they grow faster.
            for rate in [0.002, 0.1, 3.0] {
                let scene = mixture(packing_fraction);
                let one = finds_what_one_by_one_finds::<true>(&scene, rate, largest);
                used = [used[0] || one[0], used[1] || one[1]];
            }
        }
        assert_eq!(used, [true; 2], "cells and lists");
    }
}
