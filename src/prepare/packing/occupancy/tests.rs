use super::*;
use crate::model::SpeciesId;
use crate::model::random::{Purpose, Random};
use crate::model::space::nearest_image;

fn kind(species: u32) -> Kind {
    Kind::of_species(SpeciesId(species))
}

#[test]
fn overlaps_match_brute_force() {
    let mut contacts = Contacts::new(2);
    contacts.set(0, 0, 1.0);
    contacts.set(0, 1, 0.7);
    let mut random = Random::new(5, Purpose::Placement, 0);
    for boundary in [Boundary::Periodic, Boundary::OPEN] {
        for length in [2.5, 5.0] {
            let mut space = Space::periodic_cube(length);
            space.boundary[1] = boundary;
            // With many particles, another overlap could hide a missed overlap.
            for _ in 0..2000 {
                let mut occupancy = Occupancy::new(&space, &contacts, 3);
                let mut taken: Vec<(Vector, u32)> = Vec::new();
                for _ in 0..3 {
                    let position = Vector::from_fn(|_, _| length * random.uniform());
                    let species = id(random.below(2));
                    let expected = taken.iter().any(|(there, other)| {
                        minimum_image(position - there, &space.periods()).norm()
                            < contacts.get(species as usize, *other as usize)
                    });
                    assert_eq!(occupancy.overlap(&position, &kind(species), |_| true).is_some(), expected);
                    occupancy.take(position, kind(species));
                    taken.push((position, species));
                }
            }
        }
    }
}

#[test]
fn very_different_sizes_use_separate_grids() {
    let mut contacts = Contacts::new(4);
    for (a, b, contact) in [(0, 0, 0.02), (0, 1, 1.01), (1, 1, 2.0), (0, 2, 0.3), (1, 2, 1.1)] {
        contacts.set(a, b, contact);
    }
    let mut random = Random::new(6, Purpose::Placement, 0);
    for boundary in [Boundary::Periodic, Boundary::OPEN] {
        let mut space = Space::periodic_cube(4.5);
        space.boundary[2] = boundary;
        let mut found = 0;
        for _ in 0..300 {
            let mut occupancy = Occupancy::new(&space, &contacts, 300);
            let mut taken: Vec<(Vector, u32)> = Vec::new();
            for _ in 0..300 {
                let position = Vector::from_fn(|_, _| 4.5 * random.uniform());
                let species = [0, 0, 0, 0, 2, 3, 1][random.below(7)];
                let overlaps = |(there, other): &(Vector, u32)| {
                    let contact = contacts.get(species as usize, *other as usize);
                    minimum_image(position - there, &space.periods()).norm() < contact
                };
                let expected: Vec<u32> =
                    (0..).zip(&taken).filter(|(_, taken)| overlaps(taken)).map(|(number, _)| number).collect();
                let overlap = occupancy.overlap(&position, &kind(species), |_| true);
                assert_eq!(overlap.is_some(), !expected.is_empty());
                assert!(overlap.is_none_or(|overlap| expected.contains(&overlap.other)));
                found += expected.len();
                if expected.is_empty() || random.below(10) == 0 {
                    occupancy.take(position, kind(species));
                    taken.push((position, species));
                }
            }
        }
        assert!(found > 1000, "{found}");
    }
}

#[test]
fn small_particle_among_large_ones_is_compared_with_few() {
    let mut contacts = Contacts::new(2);
    contacts.set(0, 0, 1.0);
    contacts.set(0, 1, 500.5);
    contacts.set(1, 1, 1000.0);
    let space = Space::periodic_cube(4000.0);
    let mut random = Random::new(7, Purpose::Placement, 0);
    let mut occupancy = Occupancy::new(&space, &contacts, 10_000);
    for _ in 0..10_000 {
        occupancy.take(Vector::from_fn(|_, _| 4000.0 * random.uniform()), kind(0));
    }
    let asked = std::cell::Cell::new(0);
    let grid = &occupancy.grids[occupancy.grid_of[0].unwrap()];
    let _ = grid.find(&occupancy.taken, &Vector::repeat(2000.0), 1.0, |_| {
        asked.set(asked.get() + 1);
        None::<()>
    });
    assert!(asked.get() < 100, "{}", asked.get());
}

#[test]
fn first_overlap_has_the_lowest_id() {
    let mut contacts = Contacts::new(1);
    contacts.set(0, 0, 1.0);
    let space = Space::periodic_cube(33.0);
    let mut random = Random::new(8, Purpose::Placement, 0);
    let mut places: Vec<u32> = (0..27_000).collect();
    random.shuffle(&mut places);
    let at = |place: &u32| {
        let position = Vector::new(f64::from(place % 30), f64::from(place / 30 % 30), f64::from(place / 900));
        Particle::new(crate::model::SpeciesId(0), 1.1 * position, Vector::zeros())
    };
    let mut particles: Vec<Particle> = places.iter().map(at).collect();
    let first = |particles: &[Particle]| first_overlap(particles, &contacts, &space, 0.0, |a, b| (a, b) == (5, 9000));
    assert_eq!(first(&particles), None);
    particles[9000].position = particles[5].position;
    assert_eq!(first(&particles), None, "bonded");
    for (one, other) in [(20_000, 26_000), (700, 15_000)] {
        particles[other].position = particles[one].position + Vector::new(0.5, 0.0, 0.0);
    }
    let (second, overlapping) = first(&particles).unwrap();
    assert_eq!(second, 15_000);
    // The moved particle overlaps particle 700 and its neighbour along x. The search may report either of them.
    assert!(overlapping.distance < 1.0 && overlapping.other < 15_000, "{overlapping:?}");
}

#[test]
fn first_overlap_is_found_exactly_if_one_exists() {
    let mut random = Random::new(9, Purpose::Placement, 0);
    let mut counts = [0; 2];
    // With a contact distance of 0.3, sizes differ too much for a cell list.
    for (third, displacement, boundary) in [
        (0.8, 0.0, Boundary::Periodic),
        (0.8, 1.3, Boundary::Periodic),
        (0.8, 0.0, Boundary::OPEN),
        (0.3, 0.0, Boundary::Periodic),
    ] {
        let mut contacts = Contacts::new(4);
        for (a, b, contact) in [(0, 0, 1.0), (0, 1, 0.7), (1, 1, 1.1), (2, 2, third), (0, 2, 0.9)] {
            contacts.set(a, b, contact);
        }
        let mut space = Space::periodic_cube(4.5);
        space.boundary[2] = boundary;
        for _ in 0..500 {
            let particle = |_| {
                Particle::new(
                    crate::model::SpeciesId(id(random.below(4))),
                    Vector::from_fn(|_, _| 4.5 * random.uniform()),
                    Vector::zeros(),
                )
            };
            let particles: Vec<Particle> = (0..8).map(particle).collect();
            let is_bonded = |a, b| (a, b) == (1, 4);
            let is_overlap = |a: usize, b: usize| {
                let [one, other] = [&particles[a], &particles[b]];
                let separation = one.position - other.position;
                let contact = contacts.get(one.species.0 as usize, other.species.0 as usize);
                nearest_image(separation, &space.periods(), displacement).norm() < contact && !is_bonded(id(a), id(b))
            };
            let expected = (0..8).find(|&b| (0..b).any(|a| is_overlap(a, b)));
            let found = first_overlap(&particles, &contacts, &space, displacement, is_bonded);
            assert_eq!(found.map(|(second, _)| second as usize), expected, "{particles:?}");
            counts[usize::from(expected.is_some())] += 1;
        }
    }
    assert!(counts.iter().all(|count| *count > 300), "{counts:?}");
}

#[test]
fn contact_is_not_an_overlap_but_penetration_beyond_rounding_is() {
    let mut contacts = Contacts::new(1);
    contacts.set(0, 0, 1.0);
    let space = Space::periodic_cube(10.0);
    let mut occupancy = Occupancy::new(&space, &contacts, 1);
    occupancy.take(Vector::repeat(0.3), kind(0));
    let at = |x: f64| occupancy.overlap(&Vector::new(x, 0.3, 0.3), &kind(0), |_| true);
    assert_eq!(at(1.3_f64.next_down()), None);
    assert!(at(1.3 - 1e-12).is_some());
    assert!(at(9.4).is_some(), "across the periodic side");
    assert_eq!(at(9.2), None);
}

#[test]
fn extremely_distant_particles_are_handled() {
    let mut contacts = Contacts::new(1);
    contacts.set(0, 0, 1.0);
    let mut space = Space::periodic_cube(1.0);
    space.boundary = [Boundary::OPEN; 3];
    let mut occupancy = Occupancy::new(&space, &contacts, 1);
    occupancy.take(Vector::new(1e300, -1e300, 0.0), kind(0));
    assert!(occupancy.overlap(&Vector::zeros(), &kind(0), |_| true).is_none());
}
