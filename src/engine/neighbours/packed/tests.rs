//! Compares searches among packed centres with a search over all particles.

use super::*;
use crate::model::space::minimum_image;
use proptest::prelude::*;

const SIZE: f64 = 7.3;
const REACH: f64 = 1.3;

fn space(is_periodic: bool, lower: f64) -> Space {
    let mut space = Space::periodic_cube(SIZE);
    space.lower = Vector::repeat(lower);
    if !is_periodic {
        space.boundary = [Boundary::OPEN; 3];
    }
    space
}

fn filled(space: &Space, centres: &[Vector]) -> Packed {
    let mut packed = Packed::new(space, REACH, centres);
    centres.iter().zip(0..).for_each(|(centre, particle)| packed.put(particle, centre));
    packed
}

/// Returns the particles near `centre`, and whether all are certainly within reach. All instruction sets must agree.
fn found(packed: &mut Packed, centre: &Vector) -> (Vec<u32>, bool) {
    let mut ways = Simd::all().into_iter().map(|width| {
        let mut near = Candidates::default();
        packed.width = width;
        let are_certain = packed.add_within(centre, REACH, true, &mut near);
        (near.found().to_vec(), are_certain)
    });
    let first = ways.next().unwrap();
    assert!(ways.all(|way| way == first));
    first
}

proptest! {
    #[test]
    fn search_finds_every_particle_in_reach_and_few_others(
        start in prop::collection::vec(prop::array::uniform3(0.0..SIZE), 2..120),
        moves in prop::collection::vec((0..120_usize, prop::array::uniform3(0.0..SIZE)), 0..200),
        is_periodic: bool,
        lower in prop::sample::select(vec![0.0, -3.65, 1e4, -1e6]),
    ) {
        let space = space(is_periodic, lower);
        let mut centres: Vec<Vector> = start.into_iter().map(|x| Vector::from(x).add_scalar(lower)).collect();
        let mut packed = filled(&space, &centres);
        for (particle, to) in moves {
            let particle = particle % centres.len();
            packed.lift(id(particle), &centres[particle]);
            centres[particle] = Vector::from(to).add_scalar(lower);
            packed.put(id(particle), &centres[particle]);
        }
        let slack = 30.0 * ROUNDING * (lower.abs() + SIZE);
        for (a, centre) in centres.iter().enumerate() {
            let (found, are_certain) = found(&mut packed, centre);
            let mut furthest: f64 = 0.0;
            for (b, other) in centres.iter().enumerate() {
                let apart = minimum_image(centre - other, &space.periods()).norm();
                let times = found.iter().filter(|other| **other == id(b)).count();
                prop_assert!(times <= 1);
                prop_assert!(times == 1 || apart > REACH, "{} is not found from {}", b, a);
                prop_assert!(times == 0 || apart < REACH + slack, "{} is found from {} at {}", b, a, apart);
                if times == 1 {
                    furthest = furthest.max(apart);
                }
            }
            prop_assert!(!are_certain || furthest < REACH, "{}", furthest);
            prop_assert!(are_certain || furthest > REACH - slack, "{}", furthest);
        }
    }
}

#[test]
fn distant_particles_in_open_box_are_found() {
    let far = |x: f64| Vector::new(x, 0.5, 0.5);
    for x in [1e9, 1e14, 1e30] {
        let centres = [far(0.1), far(0.1 + SIZE), far(x), far(x.next_up()), far(2.0 * x)];
        let mut packed = filled(&space(false, 0.0), &centres[..2]);
        for particle in 2..5 {
            packed.put(particle, &centres[particle as usize]);
        }
        let (near, are_certain) = found(&mut packed, &centres[2]);
        assert!(!are_certain);
        assert!(near.contains(&2) && near.contains(&3) && !near.contains(&0), "{x} {near:?}");
    }
}

#[test]
fn empty_blocks_are_reused() {
    let at = |k: u32, x: f64| Vector::new(x, 0.01 * f64::from(k), 0.01 * f64::from(k));
    let mut packed = filled(&space(true, 0.0), &(0..40).map(|k| at(k, 0.1)).collect::<Vec<_>>());
    let blocks = packed.blocks.len();
    for [from, to] in [[0.1, 2.0], [2.0, 0.1], [0.1, 3.5], [3.5, 0.1]] {
        for particle in 0..40 {
            packed.lift(particle, &at(particle, from));
            packed.put(particle, &at(particle, to));
        }
        let mut near = Candidates::default();
        packed.add_candidates(&at(0, to), REACH, &mut near);
        assert_eq!(near.found().len(), 40);
    }
    assert!(packed.blocks.len() <= 2 * blocks, "{} blocks of {blocks} at first", packed.blocks.len());
}
