//! Compares searches on several levels with a search over all particles.

use super::*;
use crate::base::numbers::id;
use crate::engine::neighbours::verlet::VerletLists;
use crate::model::ContactLaw;
use crate::model::space::{Boundary, Face, minimum_image};
use proptest::prelude::*;

const SIZE: f64 = 40.0;
const HALF_SKIN: f64 = 0.3;
const DIAMETERS: [f64; 4] = [0.1, 0.7, 1.0, 12.0];

/// Ranges of additive spheres. The second and third never meet each other.
fn ranges() -> Ranges {
    let between = |a: usize, b: usize| {
        if [a, b] == [1, 2] || [a, b] == [2, 1] { -1.0 } else { 0.5 * (DIAMETERS[a] + DIAMETERS[b]) }
    };
    Ranges::of_matrix((0..16).map(|pair| between(pair / 4, pair % 4)).collect())
}

fn space(boundary: [Boundary; 3], lower: f64) -> Space {
    let is_flat = |k: usize| boundary[k] == Boundary::Flat;
    Space { lower: Vector::repeat(lower), size: Vector::from_fn(|k, _| if is_flat(k) { 0.0 } else { SIZE }), boundary }
}

fn boundaries() -> impl Strategy<Value = [Boundary; 3]> {
    let (periodic, flat) = (Boundary::Periodic, Boundary::Flat);
    let heap = Boundary::Bounded { lower: Face::Wall(ContactLaw::smooth(0.9)), upper: Face::Open };
    prop::sample::select(vec![
        [periodic; 3],
        [Boundary::OPEN; 3],
        [periodic, Boundary::walls(1.0), heap],
        [periodic, periodic, flat],
        [Boundary::walls(1.0), flat, flat],
        [periodic, flat, flat],
    ])
}

proptest! {
    #[test]
    fn search_finds_the_particles_in_reach_on_all_levels(
        start in prop::collection::vec((prop::array::uniform3(0.0..SIZE), 0..4_u16), 2..150),
        moves in prop::collection::vec((0..150_usize, prop::array::uniform3(0.0..SIZE)), 0..150),
        boundary in boundaries(),
        lower in prop::sample::select(vec![0.0, -20.0, 1e4]),
        pushed in 0..20_usize,
    ) {
        let (space, ranges) = (space(boundary, lower), ranges());
        prop_assert_eq!(ranges.levels(), &[0, 1, 1, 2]);
        let place = |at: [f64; 3]| {
            Vector::from_fn(|k, _| if boundary[k] == Boundary::Flat { lower } else { lower + at[k] })
        };
        let (mut centres, rows): (Vec<Vector>, Vec<u16>) = start.into_iter().map(|(at, row)| (place(at), row)).unzip();
        let first = centres.len() - pushed.min(centres.len() - 1);
        let mut verlet =
            VerletLists::new(&space, HALF_SKIN, (&ranges, 1.0), centres[..first].to_vec(), &rows[..first]);
        (first..centres.len()).for_each(|particle| verlet.push(centres[particle], rows[particle]));
        for (particle, to) in moves {
            let particle = particle % centres.len();
            centres[particle] = place(to);
            verlet.relocate(id(particle), centres[particle]);
        }
        let reversed: Vec<u32> = (0..id(centres.len())).rev().collect();
        prop_assert!(verlet.is_sound(centres.len(), 4));
        let permuted = verlet.permuted(&Order::of(reversed, centres.len()));
        prop_assert!(permuted.is_sound(centres.len(), 4));
        let last = centres.len() - 1;
        let reversed_rows: Vec<u16> = rows.iter().rev().copied().collect();
        let (mut near, mut candidates) = (Candidates::default(), Candidates::default());
        for (a, centre) in centres.iter().enumerate() {
            verlet.find_neighbours_within(centre, rows[a], |b| rows[b as usize], &mut near);
            let mut found = near.found().to_vec();
            found.sort_unstable();
            let is_near = |b: &usize| {
                let range = ranges.at(usize::from(rows[a]), usize::from(rows[*b]));
                let apart = minimum_image(centre - centres[*b], &space.periods()).norm();
                range >= 0.0 && apart < range + 2.0 * HALF_SKIN
            };
            let expected: Vec<u32> = (0..centres.len()).filter(is_near).map(id).collect();
            prop_assert_eq!(&found, &expected, "from {}", a);
            verlet.levels.find_candidates(centre, rows[a], &mut candidates);
            prop_assert!(expected.iter().all(|b| candidates.found().iter().filter(|other| *other == b).count() == 1));
            permuted.find_neighbours_within(centre, rows[a], |b| reversed_rows[b as usize], &mut near);
            let mut found: Vec<u32> = near.found().iter().map(|b| id(last) - b).collect();
            found.sort_unstable();
            prop_assert_eq!(&found, &expected, "from {} in another order", a);
        }
    }
}

#[test]
fn small_particles_far_from_a_large_one_are_not_its_candidates() {
    let (space, ranges) = (space([Boundary::OPEN; 3], 0.0), ranges());
    let at = |k: u32| Vector::new(f64::from(k % 20) * 2.0, f64::from(k / 20 % 20) * 2.0, f64::from(k / 400) * 2.0);
    let mut centres: Vec<Vector> = (0..8_000).map(at).collect();
    let mut rows = vec![0; 8_000];
    centres.push(Vector::repeat(19.0));
    rows.push(3);
    let verlet = VerletLists::new(&space, HALF_SKIN, (&ranges, 1.0), centres, &rows);
    let mut near = Candidates::default();
    let mut candidates = |particle: u32| {
        let (centre, row) = (verlet.centres[particle as usize], rows[particle as usize]);
        verlet.levels.find_candidates(&centre, row, &mut near);
        near.found().len()
    };
    // A small particle in the corner has its 8 neighbours and the large particle as candidates.
    assert!(candidates(0) <= 30, "{}", candidates(0));
    // The large one has the particles in a cube around it, about (2 * 6.65 / 2)^3.
    assert!((150..800).contains(&candidates(8_000)), "{}", candidates(8_000));
}
