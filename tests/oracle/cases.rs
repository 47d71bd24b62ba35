//! Families of pair states for which detection is difficult.

use super::exact::State;
use super::hard_cases;
use super::random::Random;
use carom::Vector;

/// Returns a random state of a family, with or without relative acceleration.
pub type Family = fn(&mut Random, falling: bool) -> State;

pub const FAMILIES: [(&str, Family); 21] = [
    ("fluid", fluid),
    ("30 decades of every scale", scales),
    ("100 decades of every scale", all_scales),
    ("exact zeros", zeros),
    ("contact", contact),
    ("one float from contact", beside_contact),
    ("grazing", hard_cases::grazing),
    ("overlapped", overlapped),
    ("tiny or huge terms", unequal_terms),
    ("a along or across v", aligned),
    ("pendulum start", hard_cases::pendulum_start),
    ("x^3 + 1", hard_cases::cube),
    ("triple root of f'", hard_cases::triple_root),
    ("double root of f'", hard_cases::double_root),
    ("roots 1 ulp apart", hard_cases::close_roots),
    ("events at 1e-15 and 1e15", extreme_times),
    ("1e8 diameters away", far_away),
    ("diameter ratio 1e6", size_ratio),
    ("resting contact", hard_cases::resting),
    ("parabola through contact", hard_cases::return_to_contact),
    ("thrown straight up", hard_cases::straight_throw),
];

pub fn state(position: Vector, velocity: Vector, acceleration: Vector, distance: f64) -> State {
    State { position, velocity, acceleration, distance }
}

pub fn if_falling(falling: bool, acceleration: Vector) -> Vector {
    if falling { acceleration } else { Vector::zeros() }
}

fn fluid(random: &mut Random, falling: bool) -> State {
    let acceleration = random.vector();
    state(2.0 * random.vector(), random.vector(), if_falling(falling, acceleration), random.between(0.5, 1.5))
}

/// Returns a vector of any order of magnitude. Half of the vectors have a different scale in each component.
fn of_any_scale(random: &mut Random, decades: f64) -> Vector {
    let own = random.chance(0.5);
    let scale = random.scale(-decades, decades);
    let vector = random.vector();
    if own {
        Vector::from_fn(|k, _| vector[k].signum() * random.scale(-decades, decades))
    } else {
        // A component may be much smaller than the scale, so it is limited to the range that scenes allow.
        vector.map(|x| x.signum() * (x * scale).abs().clamp(SMALLEST, 1.0 / SMALLEST))
    }
}

const SMALLEST: f64 = 1e-50;

fn of_scales(random: &mut Random, falling: bool, decades: f64) -> State {
    let [position, velocity, acceleration] = [(); 3].map(|()| of_any_scale(random, decades));
    // At random contact distances, most pairs would miss.
    let near = (position.norm() * random.scale(-1.0, 1.0)).clamp(SMALLEST, 1.0 / SMALLEST);
    let distance = if random.chance(0.5) { near } else { random.scale(-decades, decades) };
    state(position, velocity, if_falling(falling, acceleration), distance)
}

fn scales(random: &mut Random, falling: bool) -> State {
    of_scales(random, falling, 15.0)
}

fn all_scales(random: &mut Random, falling: bool) -> State {
    of_scales(random, falling, 50.0)
}

fn zeros(random: &mut Random, falling: bool) -> State {
    let mut s = fluid(random, falling);
    for vector in [&mut s.position, &mut s.velocity, &mut s.acceleration] {
        for component in vector.iter_mut() {
            if random.chance(0.5) {
                *component = random.sign() * 0.0;
            }
        }
    }
    s
}

const EXACT_LENGTHS: [([f64; 3], f64); 6] = [
    ([1.0, 0.0, 0.0], 1.0),
    ([3.0, 4.0, 0.0], 5.0),
    ([1.0, 2.0, 2.0], 3.0),
    ([2.0, 3.0, 6.0], 7.0),
    ([1.0, 4.0, 8.0], 9.0),
    ([2.0, 6.0, 9.0], 11.0),
];

/// Returns a random separation with an exact length, and this length.
pub fn touching(random: &mut Random) -> (Vector, f64) {
    let (separation, length) = EXACT_LENGTHS[random.below(EXACT_LENGTHS.len())];
    let scale = if length == 1.0 { random.between(0.5, 2.0) } else { random.power_of_two(-8, 8) };
    let position = Vector::from(separation) * scale;
    let [position, ..] = random.turned([position, Vector::zeros(), Vector::zeros()]);
    (position, length * scale)
}

fn contact(random: &mut Random, falling: bool) -> State {
    let (position, distance) = touching(random);
    let mut velocity = random.vector() * random.scale(-8.0, 2.0);
    if random.chance(0.3) {
        // Removes the velocity along the line of centres.
        velocity -= position * (velocity.dot(&position) / position.norm_squared());
    }
    let acceleration = random.vector() * random.scale(-4.0, 2.0);
    state(position, velocity, if_falling(falling, acceleration), distance)
}

fn beside_contact(random: &mut Random, falling: bool) -> State {
    let mut s = contact(random, falling);
    s.distance = random.neighbour(s.distance);
    for k in 0..3 {
        s.position[k] = random.neighbour(s.position[k]);
    }
    s
}

/// The distance differs from the contact distance by a fraction of 1e-16 to 1. The particles approach or separate.
fn overlapped(random: &mut Random, falling: bool) -> State {
    let (along, across) = random.directions();
    let depth = random.sign() * random.scale(-16.0, 0.0);
    let (toward, aside) = (random.between(-1.0, 1.0), random.between(-1.0, 1.0) * random.scale(-3.0, 0.0));
    let acceleration =
        (random.between(-1.0, 1.0) * along + random.between(-1.0, 1.0) * across) * random.scale(-3.0, 1.0);
    state(along * (1.0 + depth), along * toward + across * aside, if_falling(falling, acceleration), 1.0)
}

fn unequal_terms(random: &mut Random, falling: bool) -> State {
    let mut s = fluid(random, falling);
    let factor = |random: &mut Random| if random.chance(0.4) { 1.0 } else { random.scale(-12.0, 12.0) };
    s.velocity *= factor(random);
    s.acceleration *= factor(random);
    if random.chance(0.5) {
        // Without aiming, fast particles would miss.
        s.velocity = -s.position * (s.velocity.norm() / s.position.norm()) + s.velocity * 1e-3;
    }
    s
}

fn aligned(random: &mut Random, falling: bool) -> State {
    let mut s = fluid(random, falling);
    if falling {
        let size = random.scale(-3.0, 3.0);
        s.acceleration = match random.below(3) {
            0 => s.velocity * size,
            1 => s.velocity * -size,
            _ => s.velocity.cross(&s.position) * size,
        };
    }
    s
}

fn extreme_times(random: &mut Random, falling: bool) -> State {
    let mut s = fluid(random, falling);
    let stretch = if random.chance(0.5) { random.scale(14.0, 16.0) } else { random.scale(-16.0, -14.0) };
    s.velocity /= stretch;
    if random.chance(0.7) {
        s.acceleration /= stretch * stretch;
    }
    s
}

fn far_away(random: &mut Random, falling: bool) -> State {
    let (along, across) = random.directions();
    let length = 1e8 * random.between(0.5, 2.0);
    let impact = random.between(0.0, 1.2);
    let time = length / random.scale(-2.0, 4.0);
    let acceleration = if_falling(falling, random.vector() * (length / (time * time)));
    let position = along * length;
    state(position, (across * impact - position - acceleration * (0.5 * time * time)) / time, acceleration, 1.0)
}

fn size_ratio(random: &mut Random, falling: bool) -> State {
    let (along, _) = random.directions();
    let distance = if random.chance(0.5) { 1e6 } else { 1e-6 };
    let gap = random.sign() * random.scale(-6.0, 0.0);
    let acceleration = if_falling(falling, random.vector());
    let velocity = random.vector() - along * random.between(-1.0, 1.0);
    state(along * (distance + gap), velocity, acceleration, distance)
}
