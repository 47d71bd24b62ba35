//! The first of many others that a particle meets, four at a time.

use super::body::Body;
use super::predict::Streamed;
use super::prediction::Prediction;
use crate::Vector;
#[cfg(target_arch = "x86_64")]
use crate::detection::four::avx2::Wide;
use crate::detection::four::{Four, Plain, negative, positive};
use crate::interaction::memory::Known;
use crate::interaction::rules::{Edges, Steps};
use crate::overlap::Side;

/// Fours that are looked at before any of them is kept: longer lists come in parts.
const TOGETHER: usize = 8;

/// What others are to a particle that looks for its first meeting.
pub(super) struct Others<'a> {
    pub bodies: &'a [Body],
    /// Periods of the box, infinite where it has none.
    pub periods: &'a Vector,
    /// Whether the nearest image of a stranger may be another one than itself.
    pub wraps: bool,
    /// Their common acceleration.
    pub acceleration: Vector,
    /// By species, the square of the distance at which a stranger is met `[length^2]`; negative infinity for one that is not met here.
    pub squared: &'a [f64],
    /// The species of all, read only where there is more than one.
    pub species: &'a [u16],
}

impl Others<'_> {
    /// Keeps the earliest meeting of `me` with any of `others`, if it comes before the one predicted so far.
    #[inline]
    pub fn first_met<const FALLING: bool, const TABLE: bool>(
        &self,
        me: &Streamed,
        others: &[[u32; 4]],
        prediction: &mut Prediction,
    ) {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has just been asked for AVX2.
            return unsafe { self.first_met_avx2::<FALLING, TABLE>(me, others, prediction) };
        }
        self.first_met_of::<Plain, FALLING, TABLE>(me, others, prediction);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn first_met_avx2<const FALLING: bool, const TABLE: bool>(
        &self,
        me: &Streamed,
        others: &[[u32; 4]],
        prediction: &mut Prediction,
    ) {
        self.first_met_of::<Wide, FALLING, TABLE>(me, others, prediction);
    }

    #[inline(always)]
    fn first_met_of<F: Four, const FALLING: bool, const TABLE: bool>(
        &self,
        me: &Streamed,
        others: &[[u32; 4]],
        prediction: &mut Prediction,
    ) {
        for others in others.chunks(TOGETHER) {
            let mut due = [F::all(f64::INFINITY); TOGETHER];
            let mut least = F::all(f64::INFINITY);
            // No branch depends on what is found before all are done: the processor would guess it wrong.
            for (due, ids) in due.iter_mut().zip(others) {
                let squared = if TABLE {
                    F::each(ids.map(|id| self.squared[usize::from(self.species[id as usize])]))
                } else {
                    F::all(self.squared[0])
                };
                let (r, v) = self.seen_from::<F, FALLING>(me, *ids);
                let dt = positive(dot(&r, &r).sub(squared), dot(&v, &r), dot(&v, &v));
                *due = F::all(me.time).add(dt);
                least = due.least(least);
            }
            let [a, b, c, d] = least.numbers();
            let least = a.min(b).min(c.min(d));
            if least <= prediction.contact_time && least < f64::INFINITY {
                for (due, ids) in due.iter().zip(others) {
                    self.offer_those(me, ids, due.at_most(least), least, Side::Positive, prediction);
                }
            }
        }
    }

    /// Keeps the earliest event of `me` with any of those that it knows, none of which accelerates relative to it.
    #[inline]
    pub fn first_known(&self, me: &Streamed, known: &[Known], steps: &[Steps], prediction: &mut Prediction) {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has just been asked for AVX2.
            return unsafe { self.first_known_avx2(me, known, steps, prediction) };
        }
        self.first_known_of::<Plain>(me, known, steps, prediction);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn first_known_avx2(&self, me: &Streamed, known: &[Known], steps: &[Steps], prediction: &mut Prediction) {
        self.first_known_of::<Wide>(me, known, steps, prediction);
    }

    #[inline(always)]
    fn first_known_of<F: Four>(&self, me: &Streamed, known: &[Known], steps: &[Steps], prediction: &mut Prediction) {
        let nobody = Edges { inner: f64::NEG_INFINITY, outer: f64::INFINITY };
        for four in known.chunks(4) {
            let (mut ids, mut edges) = ([me.id; 4], [nobody; 4]);
            for (k, known) in four.iter().enumerate() {
                ids[k] = known.partner;
                edges[k] = steps[usize::from(known.interaction)].edges(known.state);
            }
            let (r, v) = self.seen_from::<F, false>(me, ids);
            let (squared, b, v2) = (dot(&r, &r), dot(&v, &r), dot(&v, &v));
            let inner = positive(squared.sub(F::each(edges.map(|edges| edges.inner))), b, v2);
            self.offer_four(me, &ids, F::all(me.time).add(inner), Side::Positive, prediction);
            let distance = F::each(edges.map(|edges| edges.outer));
            let outer = negative(squared.sub(distance), b, v2);
            let outer = distance.if_less(F::all(f64::INFINITY), outer, F::all(f64::INFINITY));
            self.offer_four(me, &ids, F::all(me.time).add(outer), Side::Negative, prediction);
        }
    }

    #[inline(always)]
    fn offer_four<F: Four>(&self, me: &Streamed, ids: &[u32; 4], due: F, side: Side, prediction: &mut Prediction) {
        if due.at_most(prediction.contact_time) != 0 {
            for (due, other) in due.numbers().into_iter().zip(*ids) {
                self.offer(me, other, due, side, prediction);
            }
        }
    }

    /// Keeps the earliest of the meetings at one time with those of four others that some bits stand for.
    #[inline(always)]
    fn offer_those(
        &self,
        me: &Streamed,
        ids: &[u32; 4],
        bits: u32,
        time: f64,
        side: Side,
        prediction: &mut Prediction,
    ) {
        let mut bits = bits;
        while bits != 0 {
            self.offer(me, ids[bits.trailing_zeros() as usize & 3], time, side, prediction);
            bits &= bits - 1;
        }
    }

    /// Where `me` is from four others, and how it moves.
    #[inline(always)]
    fn seen_from<F: Four, const FALLING: bool>(&self, me: &Streamed, ids: [u32; 4]) -> ([F; 3], [F; 3]) {
        let [x, y, z, vx, vy, vz, time, _] = F::columns(ids.map(|id| self.bodies[id as usize].numbers()));
        let (positions, velocities) = ([x, y, z], [vx, vy, vz]);
        let dt = F::all(me.time).sub(time);
        let (mut r, mut v) = (positions, velocities);
        for k in 0..3 {
            let (position, velocity) = if FALLING {
                let a = F::all(self.acceleration[k]);
                let mean = velocities[k].add(a.mul(F::all(0.5).mul(dt)));
                (positions[k].add(mean.mul(dt)), velocities[k].add(a.mul(dt)))
            } else {
                (positions[k].add(velocities[k].mul(dt)), velocities[k])
            };
            r[k] = F::all(me.position[k]).sub(position);
            v[k] = F::all(me.velocity[k]).sub(velocity);
        }
        if self.wraps {
            for (apart, period) in r.iter_mut().zip(self.periods) {
                *apart = minimum_image(*apart, *period);
            }
        }
        (r, v)
    }

    /// Keeps a meeting if it is the earliest so far; between simultaneous ones the lower ids come first.
    #[inline(always)]
    fn offer(&self, me: &Streamed, other: u32, time: f64, side: Side, prediction: &mut Prediction) {
        if time < f64::INFINITY && prediction.is_before(me.id, other, time, self.bodies) {
            prediction.meet(me.id, other, side, time, self.bodies);
        }
    }
}

#[inline(always)]
fn dot<F: Four>(a: &[F; 3], b: &[F; 3]) -> F {
    a[0].mul(b[0]).add(a[1].mul(b[1])).add(a[2].mul(b[2]))
}

/// The same as [`crate::space::minimum_image`] for one coordinate of four.
#[inline(always)]
fn minimum_image<F: Four>(apart: F, period: f64) -> F {
    let half = F::all(0.5 * period);
    let below = apart.if_less(F::all(-0.5 * period), F::all(-period), F::all(0.0));
    apart.sub(half.if_less(apart, F::all(period), below))
}
