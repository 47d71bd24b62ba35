//! Batch prediction: the earliest contact of a particle with many others. SIMD lanes predict several pairs at once.

use super::Streamed;
use crate::Vector;
use crate::engine::array::Array;
use crate::engine::images::lanes::nearest;
use crate::engine::neighbours::cells::NO_PARTICLE;
use crate::engine::pairs::rules::{Reaches, Rules};
use crate::engine::pairs::states::PairState;
use crate::engine::prediction::Prediction;
use crate::engine::state::Body;
use crate::model::diameters::scaled_distance;
use crate::physics::detection::lanes::{Lanes, MOST_LANES, Simd, Work, negative, positive};
use crate::physics::overlap::Side;

/// Number of pairs in a batch. Longer lists are split.
pub(super) const TOGETHER: usize = 32;

/// Input of a batch prediction for one particle, `me`.
pub(in crate::engine) struct Batch<'a> {
    pub width: Simd,
    pub bodies: &'a Array<Body>,
    pub periods: &'a Vector,
    /// Whether the nearest image of a particle may lie across a side of the box.
    pub wraps: bool,
    /// Acceleration of `me`. The lanes assume that its partners have the same acceleration.
    pub acceleration: Vector,
    /// Contact distances of `me` with the particles of each table row. Contacts that cannot be predicted in a batch are
    /// excluded.
    pub reaches: Reaches<'a>,
    /// Radii of all particles `[length]`; empty unless particles have individual diameters.
    pub radii: &'a Array<f64>,
    /// Whether all particles have the same table row.
    pub has_one_row: bool,
    /// Table rows of all particles. Empty if the engine has no table.
    pub rows: &'a Array<u16>,
}

/// The earliest contact of a particle with the particles of a batch. If there is none, `other` is [`NO_PARTICLE`].
#[derive(Debug, Clone, Copy)]
pub(in crate::engine) struct Earliest {
    pub time: f64,
    pub other: u32,
}

impl Batch<'_> {
    /// Returns the earliest contact of `me` with any of `others` up to the time `before`.
    ///
    /// The length of `others` is a multiple of [`MOST_LANES`]. Only the first `length` particles are tested. The rest
    /// is padding and repeats `me`.
    #[inline]
    pub fn earliest_contact<const FALLING: bool, const TABLE: bool>(
        &self,
        me: &Streamed,
        others: &[u32],
        length: usize,
        before: f64,
    ) -> Earliest {
        if TABLE && self.has_sizes() {
            return self.earliest_contact_of_sizes::<FALLING>(me, others, length, before);
        }
        let width = if length > 4 { self.width } else { self.width.at_most_four() };
        width.run(EarliestContact::<FALLING, TABLE, false> { batch: self, me, others, length, before })
    }

    /// Like [`Self::earliest_contact`], for particles with individual diameters.
    #[inline(never)]
    fn earliest_contact_of_sizes<const FALLING: bool>(
        &self,
        me: &Streamed,
        others: &[u32],
        length: usize,
        before: f64,
    ) -> Earliest {
        let width = if length > 4 { self.width } else { self.width.at_most_four() };
        width.run(EarliestContact::<FALLING, true, true> { batch: self, me, others, length, before })
    }

    /// Finds the earliest event of `me` with its captured partners. `prediction` is replaced if this event is earlier.
    /// Partners that accelerate relative to `me` are skipped.
    #[inline]
    pub fn earliest_of_captured<const FALLING: bool>(
        &self,
        me: &Streamed,
        captured: &[PairState],
        rules: &Rules,
        prediction: &mut Prediction,
    ) {
        if self.has_sizes() {
            self.width.run(EarliestOfCaptured::<FALLING, true> { batch: self, me, captured, rules, prediction });
        } else {
            self.width.run(EarliestOfCaptured::<FALLING, false> { batch: self, me, captured, rules, prediction });
        }
    }

    #[inline(always)]
    pub fn row_of(&self, particle: u32) -> usize {
        self.rows.get(particle as usize).map_or(0, |row| usize::from(*row))
    }

    fn id(&self, particle: u32) -> u32 {
        self.bodies[particle as usize].id
    }

    /// Whether particles have individual diameters. Lanes are compiled for both cases, because a branch in their loops
    /// would cost time: 2 % of the instructions of a sheared gas.
    #[inline]
    pub fn has_sizes(&self) -> bool {
        !self.reaches.slopes.is_empty()
    }

    /// Returns the squared contact distances of `me` with some particles `[length^2]`; negative infinity for excluded pairs.
    #[inline(always)]
    pub fn squares<F: Lanes, const SIZED: bool>(&self, me: &Streamed, reaches: &Reaches<'_>, numbers: &[u32]) -> F {
        if SIZED {
            return self.squares_of_sizes(me, reaches, numbers);
        }
        let of = |k: usize| reaches.squared[self.row_of(numbers[k % F::COUNT])];
        F::each(&std::array::from_fn::<f64, MOST_LANES, _>(of))
    }

    /// Returns the squared contact distances of `me` with some particles by their table rows `[length^2]`.
    #[inline(always)]
    pub fn squares_of_rows<F: Lanes>(&self, squared: &[f64], numbers: &[u32]) -> F {
        let of = |k: usize| squared[usize::from(self.rows[numbers[k % F::COUNT] as usize])];
        F::each(&std::array::from_fn::<f64, MOST_LANES, _>(of))
    }

    /// Like [`Self::squares`], for particles with individual diameters. Uses the same operations as
    /// [`scaled_distance`](crate::model::diameters::scaled_distance).
    #[inline(always)]
    pub fn squares_of_sizes<F: Lanes>(&self, me: &Streamed, reaches: &Reaches<'_>, numbers: &[u32]) -> F {
        let slopes = &reaches.slopes[self.row_of(me.number)];
        let own = F::all(self.radii[me.number as usize]);
        let radii = F::each(&std::array::from_fn::<f64, MOST_LANES, _>(|k| self.radii[numbers[k % F::COUNT] as usize]));
        if let Some(slope) = slopes.common {
            let distance = F::all(slope).mul(own.add(radii));
            return distance.mul(distance);
        }
        let slope = |k: usize| slopes.of_rows[self.row_of(numbers[k % F::COUNT])];
        let slope = F::each(&std::array::from_fn::<f64, MOST_LANES, _>(slope));
        let distance = slope.mul(own.add(radii));
        slope.if_less(F::all(0.0), F::all(f64::NEG_INFINITY), distance.mul(distance))
    }

    /// Returns the position and velocity of `me` relative to each of several particles.
    #[inline(always)]
    pub fn seen_from<F: Lanes, const FALLING: bool>(&self, me: &Streamed, numbers: &[u32]) -> ([F; 3], [F; 3]) {
        let [x, y, z, vx, vy, vz, time, _] = F::columns(|k| self.bodies[numbers[k] as usize].numbers());
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
            nearest(&mut r, self.periods);
        }
        (r, v)
    }
}

struct EarliestContact<'a, const FALLING: bool, const TABLE: bool, const SIZED: bool> {
    batch: &'a Batch<'a>,
    me: &'a Streamed,
    others: &'a [u32],
    length: usize,
    before: f64,
}

impl<const FALLING: bool, const TABLE: bool, const SIZED: bool> Work for EarliestContact<'_, FALLING, TABLE, SIZED> {
    type Output = Earliest;

    #[inline(always)]
    fn run<F: Lanes>(self) -> Earliest {
        let Self { batch, me, others, length, before } = self;
        let mut first = Earliest { time: before, other: NO_PARTICLE };
        let mut due = [f64::INFINITY; TOGETHER];
        let is_mixture = TABLE && !batch.has_one_row;
        let own = if TABLE { batch.row_of(me.number) } else { 0 };
        for some in others[..length.next_multiple_of(F::COUNT)].chunks(TOGETHER) {
            let mut least = F::all(f64::INFINITY);
            // A branch on a single lane would often be mispredicted, so there is no branch until all lanes are done.
            for (due, numbers) in due.chunks_exact_mut(F::COUNT).zip(some.chunks_exact(F::COUNT)) {
                let squared = if SIZED {
                    batch.squares_of_sizes(me, &batch.reaches, numbers)
                } else if is_mixture {
                    batch.squares_of_rows(batch.reaches.squared, numbers)
                } else {
                    F::all(batch.reaches.squared[own])
                };
                if FALLING && TABLE && squared.at_most(0.0) == (1 << F::COUNT) - 1 {
                    // No contact can be predicted, for example of a falling grain with a static particle.
                    F::all(f64::INFINITY).write(due);
                    continue;
                }
                let (r, v) = batch.seen_from::<F, FALLING>(me, numbers);
                let dt = positive(dot(&r, &r).sub(squared), dot(&v, &r), dot(&v, &v));
                let times = F::all(me.time).add(dt);
                times.write(due);
                least = times.least(least);
            }
            let least = least.smallest();
            if least <= first.time && least < f64::INFINITY {
                // A bit mask finds all times that equal the minimum. Branches would often be mispredicted here.
                let mut bits = which_at_most::<F>(&due[..some.len()], least);
                while bits != 0 {
                    let other = some[bits.trailing_zeros() as usize];
                    if least < first.time || first.other == NO_PARTICLE || batch.id(other) < batch.id(first.other) {
                        first = Earliest { time: least, other };
                    }
                    bits &= bits - 1;
                }
            }
        }
        first
    }
}

struct EarliestOfCaptured<'a, const FALLING: bool, const SIZED: bool> {
    batch: &'a Batch<'a>,
    me: &'a Streamed,
    captured: &'a [PairState],
    rules: &'a Rules,
    prediction: &'a mut Prediction,
}

impl<const FALLING: bool, const SIZED: bool> Work for EarliestOfCaptured<'_, FALLING, SIZED> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        let Self { batch, me, captured, rules, prediction } = self;
        let row = |number: u32| batch.rows[number as usize];
        let steps = &rules.steps[..];
        let (mut of_inner, mut of_outer) = ([f64::INFINITY; TOGETHER], [f64::INFINITY; TOGETHER]);
        for together in captured.chunks(TOGETHER) {
            let mut least = F::all(prediction.contact_time);
            let times = of_inner.chunks_exact_mut(F::COUNT).zip(of_outer.chunks_exact_mut(F::COUNT));
            for ((of_inner, of_outer), some) in times.zip(together.chunks(F::COUNT)) {
                let mut numbers = [me.number; MOST_LANES];
                let (mut inner, mut outer) = ([f64::NEG_INFINITY; MOST_LANES], [f64::INFINITY; MOST_LANES]);
                for (k, captured) in some.iter().enumerate() {
                    numbers[k] = captured.partner;
                    if FALLING && rules.meeting(row(me.number), row(captured.partner)).is_accelerated {
                        continue;
                    }
                    let edges = steps[usize::from(captured.interaction)].edges(captured.state);
                    (inner[k], outer[k]) = (edges.inner, edges.outer);
                    if SIZED {
                        let [own, other] = [me.number, captured.partner].map(|number| batch.radii[number as usize]);
                        let of_species = rules.sum_of_species_radii(row(me.number), row(captured.partner));
                        let of_pair = |squared: f64| {
                            let distance = scaled_distance(squared.sqrt(), of_species, own + other);
                            if squared < 0.0 { squared } else { distance * distance }
                        };
                        (inner[k], outer[k]) = (of_pair(edges.inner), of_pair(edges.outer));
                    }
                }
                let (r, v) = batch.seen_from::<F, FALLING>(me, &numbers[..F::COUNT]);
                let (squared, b, v2) = (dot(&r, &r), dot(&v, &r), dot(&v, &v));
                let time = F::all(me.time).add(positive(squared.sub(F::each(&inner)), b, v2));
                time.write(of_inner);
                least = time.least(least);
                let distance = F::each(&outer);
                let dt = negative(squared.sub(distance), b, v2);
                let dt = distance.if_less(F::all(f64::INFINITY), dt, F::all(f64::INFINITY));
                let time = F::all(me.time).add(dt);
                time.write(of_outer);
                least = time.least(least);
            }
            let least = least.smallest();
            if least > prediction.contact_time || least == f64::INFINITY {
                continue;
            }
            for (side, times) in [(Side::Positive, &of_inner), (Side::Negative, &of_outer)] {
                let mut bits = which_at_most::<F>(&times[..together.len().next_multiple_of(F::COUNT)], least);
                while bits != 0 {
                    let other = together[bits.trailing_zeros() as usize].partner;
                    if prediction.is_before(me.number, other, least, batch.bodies) {
                        prediction.meet(me.number, other, side, least, batch.bodies);
                    }
                    bits &= bits - 1;
                }
            }
        }
    }
}

/// Returns a bit mask of the times up to `limit`. The length of `times` is a multiple of the number of lanes.
#[inline(always)]
fn which_at_most<F: Lanes>(times: &[f64], limit: f64) -> u32 {
    let in_lanes = times.chunks_exact(F::COUNT).enumerate();
    in_lanes.fold(0, |bits, (at, times)| bits | F::each(times).at_most(limit) << (at * F::COUNT))
}

#[inline(always)]
pub(in crate::engine) fn dot<F: Lanes>(a: &[F; 3], b: &[F; 3]) -> F {
    a[0].mul(b[0]).add(a[1].mul(b[1])).add(a[2].mul(b[2]))
}

#[cfg(test)]
pub(in crate::engine) mod tests {
    use super::*;
    use crate::engine::Until;
    use crate::engine::parts::Engine;
    use crate::model::Scene;
    use crate::model::potential::Potential;
    use crate::model::space::{Boundary, Space};
    use crate::scene::{Fill, InteractionDraft, Lattice, SceneBuilder, SpeciesDraft};

    /// Returns the final state of a fluid after a number of events, for each instruction set of the processor.
    fn ends<const TABLE: bool>(potential: &Potential, packing_fraction: f64) -> Vec<(Vec<Vector>, f64)> {
        let scene = SceneBuilder::new("fluid")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(potential.clone()).between("A", "A"))
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(500).packing_fraction(packing_fraction))
            .temperature(1.0)
            .build()
            .unwrap();
        let run = |width| {
            let mut engine = Engine::<false, TABLE>::new(&scene);
            engine.hardware.width = width;
            engine.advance(Until::events(5_000), &mut None).unwrap();
            (engine.snapshot().positions, engine.clock.now)
        };
        Simd::all().into_iter().map(run).collect()
    }

    #[test]
    fn simd_width_does_not_change_results() {
        let (hard, well) = (Potential::hard_sphere(1.0).unwrap(), Potential::square_well(1.0, 1.5, 1.0).unwrap());
        for packing_fraction in [0.1, 0.45] {
            for ends in [ends::<false>(&hard, packing_fraction), ends::<true>(&well, packing_fraction)] {
                assert!(ends.iter().all(|end| *end == ends[0]));
            }
        }
    }

    /// Sticky grains that fall between walls onto sticky static spheres.
    pub(in crate::engine) fn falling() -> Scene {
        let well = Potential::square_well(1.0, 1.5, 0.5).unwrap();
        let mut scene = SceneBuilder::new("falling")
            .gravity(Vector::new(0.0, -1.0, 0.0))
            .species(SpeciesDraft::new("grain").mass(1.0).diameter(1.0))
            .species(SpeciesDraft::new("floor").diameter(1.0).fixed())
            .interaction(InteractionDraft::new(well.clone()).between("grain", "grain").restitution(0.9))
            .interaction(InteractionDraft::new(well).between("grain", "floor").restitution(0.9));
        for k in 0..40 {
            let at = |n: u32| 0.8 + 1.6 * f64::from(n);
            let velocity = Vector::new(0.3 * f64::from(k % 7) - 0.9, 0.1, 0.2 * f64::from(k % 5) - 0.4);
            scene = scene.particle("grain", Vector::new(at(k % 5), 3.0 + at(k / 25), at(k / 5 % 5)), velocity);
        }
        for k in 0..25 {
            let at = |n: u32| 0.8 + 1.6 * f64::from(n);
            scene = scene.particle("floor", Vector::new(at(k % 5), 0.7, at(k / 5)), Vector::zeros());
        }
        let boundary = [Boundary::walls(0.9), Boundary::walls(0.9), Boundary::Periodic];
        scene.space(Space { lower: Vector::zeros(), size: Vector::new(8.0, 12.0, 8.0), boundary }).build().unwrap()
    }

    #[test]
    fn simd_width_does_not_change_results_under_gravity() {
        let scene = falling();
        let run = |width| {
            let mut engine = Engine::<true, true>::new(&scene);
            engine.hardware.width = width;
            engine.advance(Until::events(5_000), &mut None).unwrap();
            assert!(
                engine.counts.totals.capture > 500 && engine.counts.totals.core > 100,
                "{:?}",
                engine.counts.totals
            );
            (engine.snapshot().positions, engine.clock.now)
        };
        let ends: Vec<_> = Simd::all().into_iter().map(run).collect();
        assert!(ends.iter().all(|end| *end == ends[0]));
    }

    /// Returns the time and the partner of the first contact of a particle at rest in the middle of a box.
    fn first_met(potential: &Potential, others: &[(Vector, Vector)], middle: usize) -> (f64, u32) {
        let mut scene = SceneBuilder::new("middle")
            .space(Space { lower: Vector::zeros(), size: Vector::repeat(16.0), boundary: [Boundary::Periodic; 3] })
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(potential.clone()).between("A", "A"));
        let (before, after) = others.split_at(middle);
        let at_rest = (Vector::zeros(), Vector::zeros());
        for (position, velocity) in before.iter().chain([&at_rest]).chain(after) {
            scene = scene.particle("A", Vector::repeat(8.0) + position, *velocity);
        }
        let engine = Engine::<false, true>::new(&scene.build().unwrap());
        let particle = engine.state.numbers[middle];
        let mut ends = Simd::all().into_iter().map(|width| {
            let mut engine = engine.clone();
            engine.hardware.width = width;
            engine.predict_anew(particle, 0.0);
            let prediction = engine.schedule.predictions[particle as usize];
            (prediction.contact_time, engine.state.bodies[prediction.partner as usize].id)
        });
        let first = ends.next().unwrap();
        assert!(ends.all(|end| end == first));
        first
    }

    #[test]
    fn first_event_is_found_among_many_captured_partners() {
        let at = |k: i32| 1.25 * Vector::new(f64::from(k % 5 - 2), f64::from(k / 5 % 5 - 2), f64::from(k / 25 - 2));
        let places: Vec<Vector> = (0..125).map(at).filter(|at| at.norm() > 0.0 && at.norm() < 2.9).collect();
        assert!(places.len() > TOGETHER, "{}", places.len());
        let well = Potential::square_well(1.0, 3.0, 1.0).unwrap();
        for moving in 0..places.len() {
            let velocity =
                |k: usize, sign: f64| if k == moving { places[k].normalize() * sign } else { Vector::zeros() };
            for (sign, edge) in [(-1.0, 1.0), (1.0, 3.0)] {
                let others: Vec<_> = (0..places.len()).map(|k| (places[k], velocity(k, sign))).collect();
                let (time, met) = first_met(&well, &others, 0);
                // Lengths are about 3 and times are at most 2, so the tolerance allows a few rounding errors.
                assert!((time - (edge - places[moving].norm()).abs()).abs() < 1e-14, "{moving} {time}");
                assert_eq!(met as usize, moving + 1);
            }
        }
    }

    #[test]
    fn simultaneous_contacts_are_ordered_by_lowest_id() {
        let (hard, well) = (Potential::hard_sphere(1.0).unwrap(), Potential::square_well(1.0, 1.5, 1.0).unwrap());
        // Six particles surround the particle in the middle, at equal distance and speed. The three cases are contacts
        // from outside, with the core of the well, and with the outer edge of the well.
        for (potential, distance, speed, time) in
            [(&hard, 2.0, -1.0, 1.0), (&well, 1.25, -0.5, 0.5), (&well, 1.25, 1.0, 0.25)]
        {
            let side = |k: usize| Vector::ith(k % 3, if k < 3 { 1.0 } else { -1.0 });
            for turn in 0..6 {
                let others = [0, 1, 2, 3, 4, 5].map(|k| side((k + turn) % 6)).map(|at| (distance * at, speed * at));
                for middle in 0..=6 {
                    let lowest = u32::from(middle == 0);
                    assert_eq!(first_met(potential, &others, middle), (time, lowest), "{turn} {middle}");
                }
            }
        }
    }
}
