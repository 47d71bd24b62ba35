//! The first of many others that a particle meets, many at a time.

use super::predict::Streamed;
use super::prediction::Prediction;
use super::state::Body;
use crate::Vector;
use crate::engine::neighbours::cells::NOBODY;
use crate::engine::pairs::memory::Known;
use crate::engine::pairs::rules::Steps;
use crate::physics::detection::many::{MOST, Many, Width, Work, negative, positive};
use crate::physics::overlap::Side;

/// Others that are looked at before any of them is kept: longer lists come in parts.
const TOGETHER: usize = 32;

/// What others are to a particle that looks for its first meeting.
pub(super) struct Others<'a> {
    pub width: Width,
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

/// The first of those that a particle meets, or nobody.
#[derive(Debug, Clone, Copy)]
pub(super) struct Met {
    pub time: f64,
    pub other: u32,
}

impl Others<'_> {
    /// The earliest meeting of `me` with any of `strangers`, if there is one that comes no later than `before`.
    ///
    /// Their number is a multiple of [`MOST`]; `me` itself fills it up, and only the first `length` are looked at.
    #[inline]
    pub fn first_met<const FALLING: bool, const TABLE: bool>(
        &self,
        me: &Streamed,
        strangers: &[u32],
        length: usize,
        before: f64,
    ) -> Met {
        let width = if length > 4 { self.width } else { self.width.at_most_four() };
        width.run(FirstMet::<FALLING, TABLE> { others: self, me, strangers, length, before })
    }

    /// Keeps the earliest event of `me` with any of those that it knows, none of which accelerates relative to it.
    #[inline]
    pub fn first_known(&self, me: &Streamed, known: &[Known], steps: &[Steps], prediction: &mut Prediction) {
        self.width.run(FirstKnown { others: self, me, known, steps, prediction });
    }

    /// The user's id of a particle.
    fn name(&self, particle: u32) -> u32 {
        self.bodies[particle as usize].name
    }

    #[inline(always)]
    fn offer_all<F: Many>(&self, me: &Streamed, ids: &[u32], due: F, side: Side, prediction: &mut Prediction) {
        if due.at_most(prediction.contact_time) != 0 {
            let mut times = [f64::INFINITY; MOST];
            due.write(&mut times);
            for (due, other) in times.into_iter().zip(ids) {
                self.offer(me, *other, due, side, prediction);
            }
        }
    }

    /// Where `me` is from others, and how it moves.
    #[inline(always)]
    fn seen_from<F: Many, const FALLING: bool>(&self, me: &Streamed, ids: &[u32]) -> ([F; 3], [F; 3]) {
        let [x, y, z, vx, vy, vz, time, _] = F::columns(|k| self.bodies[ids[k] as usize].numbers());
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

/// The search of [`Others::first_met`].
struct FirstMet<'a, const FALLING: bool, const TABLE: bool> {
    others: &'a Others<'a>,
    me: &'a Streamed,
    strangers: &'a [u32],
    length: usize,
    before: f64,
}

impl<const FALLING: bool, const TABLE: bool> Work for FirstMet<'_, FALLING, TABLE> {
    type Output = Met;

    #[inline(always)]
    fn run<F: Many>(self) -> Met {
        let Self { others, me, strangers, length, before } = self;
        let mut first = Met { time: before, other: NOBODY };
        let mut due = [f64::INFINITY; TOGETHER];
        for some in strangers[..length.next_multiple_of(F::COUNT)].chunks(TOGETHER) {
            let mut least = F::all(f64::INFINITY);
            // No branch depends on what is found before all are done: the processor would guess it wrong.
            for (due, ids) in due.chunks_exact_mut(F::COUNT).zip(some.chunks_exact(F::COUNT)) {
                let squared = if TABLE {
                    let squared: [f64; MOST] = std::array::from_fn(|k| {
                        others.squared[usize::from(others.species[ids[k % F::COUNT] as usize])]
                    });
                    F::each(&squared)
                } else {
                    F::all(others.squared[0])
                };
                let (r, v) = others.seen_from::<F, FALLING>(me, ids);
                let dt = positive(dot(&r, &r).sub(squared), dot(&v, &r), dot(&v, &v));
                let times = F::all(me.time).add(dt);
                times.write(due);
                least = times.least(least);
            }
            let least = least.smallest();
            if least <= first.time && least < f64::INFINITY {
                // Nor does one depend on where it is.
                let mut bits = 0;
                for (at, due) in due.chunks_exact(F::COUNT).take(some.len() / F::COUNT).enumerate() {
                    bits |= F::each(due).at_most(least) << (at * F::COUNT);
                }
                while bits != 0 {
                    let other = some[bits.trailing_zeros() as usize];
                    if least < first.time || first.other == NOBODY || others.name(other) < others.name(first.other) {
                        first = Met { time: least, other };
                    }
                    bits &= bits - 1;
                }
            }
        }
        first
    }
}

/// The search of [`Others::first_known`].
struct FirstKnown<'a> {
    others: &'a Others<'a>,
    me: &'a Streamed,
    known: &'a [Known],
    steps: &'a [Steps],
    prediction: &'a mut Prediction,
}

impl Work for FirstKnown<'_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Many>(self) {
        let Self { others, me, known, steps, prediction } = self;
        for some in known.chunks(F::COUNT) {
            let mut ids = [me.id; MOST];
            let (mut inner, mut outer) = ([f64::NEG_INFINITY; MOST], [f64::INFINITY; MOST]);
            for (k, known) in some.iter().enumerate() {
                ids[k] = known.partner;
                let edges = steps[usize::from(known.interaction)].edges(known.state);
                (inner[k], outer[k]) = (edges.inner, edges.outer);
            }
            let ids = &ids[..F::COUNT];
            let (r, v) = others.seen_from::<F, false>(me, ids);
            let (squared, b, v2) = (dot(&r, &r), dot(&v, &r), dot(&v, &v));
            let dt = positive(squared.sub(F::each(&inner)), b, v2);
            others.offer_all(me, ids, F::all(me.time).add(dt), Side::Positive, prediction);
            let distance = F::each(&outer);
            let dt = negative(squared.sub(distance), b, v2);
            let dt = distance.if_less(F::all(f64::INFINITY), dt, F::all(f64::INFINITY));
            others.offer_all(me, ids, F::all(me.time).add(dt), Side::Negative, prediction);
        }
    }
}

#[inline(always)]
fn dot<F: Many>(a: &[F; 3], b: &[F; 3]) -> F {
    a[0].mul(b[0]).add(a[1].mul(b[1])).add(a[2].mul(b[2]))
}

/// The same as [`crate::model::space::minimum_image`] for one coordinate of many.
#[inline(always)]
fn minimum_image<F: Many>(apart: F, period: f64) -> F {
    let half = F::all(0.5 * period);
    let below = apart.if_less(F::all(-0.5 * period), F::all(-period), F::all(0.0));
    apart.sub(half.if_less(apart, F::all(period), below))
}

#[cfg(test)]
mod tests {
    use crate::Vector;
    use crate::engine::Until;
    use crate::engine::event_loop::Engine;
    use crate::model::potential::Potential;
    use crate::physics::detection::many::Width;
    use crate::scene::{Amount, Lattice, SceneBuilder};
    use std::ops::ControlFlow;

    /// Where a fluid is after some events, for every set of instructions that the processor has.
    fn ends<const TABLE: bool>(potential: &Potential, packing_fraction: f64) -> Vec<(Vec<Vector>, f64)> {
        let scene = SceneBuilder::new("fluid")
            .species("A", 1.0, 1.0)
            .interaction("A", "A", potential.clone(), 1.0)
            .fill(Lattice::FaceCentredCubic, "A", 500, Amount::PackingFraction(packing_fraction))
            .temperature(1.0)
            .build()
            .unwrap();
        let run = |width| {
            let mut engine = Engine::<false, TABLE>::new(&scene);
            engine.hardware.width = width;
            engine.advance(Until::events(5_000), &mut |_| ControlFlow::Continue(())).unwrap();
            (engine.snapshot().positions, engine.clock.now)
        };
        Width::all().into_iter().map(run).collect()
    }

    #[test]
    fn what_the_processor_can_do_at_once_changes_nothing() {
        let (hard, well) = (Potential::hard_sphere(1.0).unwrap(), Potential::square_well(1.0, 1.5, 1.0).unwrap());
        for packing_fraction in [0.1, 0.45] {
            for ends in [ends::<false>(&hard, packing_fraction), ends::<true>(&well, packing_fraction)] {
                assert!(ends.iter().all(|end| *end == ends[0]));
            }
        }
    }
}
