//! States with roots that coincide exactly. All numbers are small binary fractions.

use super::cases::{if_falling, state, touching};
use super::exact::State;
use super::random::Random;
use carom::Vector;

fn integer(random: &mut Random, most: usize) -> f64 {
    random.sign() * (1 + random.below(most)) as f64
}

fn axes(random: &mut Random, r: [f64; 3], v: [f64; 3], a: [f64; 3], distance: f64) -> State {
    let [r, v, a] = random.turned([Vector::from(r), Vector::from(v), Vector::from(a)]);
    state(r, v, a, distance)
}

/// A pair at the contact distance, with a velocity perpendicular to the line of centres. Some pairs miss the contact
/// distance by one floating-point number.
pub fn grazing(random: &mut Random, falling: bool) -> State {
    let (there, distance) = touching(random);
    // With small integer components, the cross product is exact.
    let across = there.cross(&Vector::new(integer(random, 3), integer(random, 3), 1.0));
    let time = integer(random, 8);
    let strength = random.power_of_two(-3, 3) * random.sign() / distance;
    let acceleration = if_falling(falling, there * strength + across * random.below(2) as f64);
    let velocity = across - acceleration * time;
    let position = there - across * time + acceleration * (0.5 * time * time);
    let distance = if random.chance(0.5) { distance } else { random.neighbour(distance) };
    state(position, velocity, acceleration, distance)
}

/// A pair with `v = 0` and `r` perpendicular to `a`, so `f' ~ t^3`.
pub fn pendulum_start(random: &mut Random, falling: bool) -> State {
    let length = random.between(0.1, 2.0);
    let distance = if random.chance(0.2) { length } else { length * random.between(0.5, 2.0) };
    let speed = if falling { 0.0 } else { random.between(0.0, 1.0) };
    let acceleration = if falling { random.scale(-6.0, 6.0) } else { 0.0 };
    axes(random, [length, 0.0, 0.0], [0.0, speed, 0.0], [0.0, 0.0, acceleration], distance)
}

/// A pair with `a.v = 0` and `a.r + v^2 = 0`, so `f'` has neither a linear nor a quadratic term.
pub fn cube(random: &mut Random, falling: bool) -> State {
    let (x, w) = (integer(random, 8) * 0.5, integer(random, 4) * 0.5);
    let g = if falling { random.power_of_two(-4, 4) } else { 0.0 };
    let z = if falling { w * w / g } else { random.between(-2.0, 2.0) };
    let (distance, _) = around(random, x.hypot(z));
    axes(random, [x, 0.0, z], [w, 0.0, 0.0], [0.0, 0.0, -g], distance)
}

/// Returns a length near the given length, and true if the two lengths are equal.
fn around(random: &mut Random, length: f64) -> (f64, bool) {
    let same = random.chance(0.2);
    (if same { length } else { length * random.between(0.3, 1.7) }, same)
}

/// A motion along a line that stops at the centre, where `f'` has a triple root.
pub fn triple_root(random: &mut Random, falling: bool) -> State {
    let (time, scale) = (integer(random, 6) * 0.5, random.power_of_two(-6, 6) * random.sign());
    let curve = if falling { scale } else { 0.0 };
    let (distance, _) = around(random, scale.abs() * time * time);
    axes(random, [scale * time * time, 0.0, 0.0], [-2.0 * scale * time, 0.0, 0.0], [2.0 * curve, 0.0, 0.0], distance)
}

/// `f'` has a double root at `p` and a simple root at `q`. It is proportional to `t^3 + e2 t^2 + e1 t + e0`.
pub fn double_root(random: &mut Random, falling: bool) -> State {
    if !falling {
        return grazing(random, false);
    }
    let p = integer(random, 6) * 0.5;
    let q = p + 3.0 * integer(random, 4) * 0.5;
    let (e2, e1, e0) = (-(2.0 * p + q), p * p + 2.0 * p * q, -p * p * q);
    let w = random.power_of_two(-2, 2);
    let vz = e2 / 3.0;
    let z = 0.5 * e1 - w * w - vz * vz;
    let x = (0.5 * e0 - vz * z) / w;
    let (distance, _) = around(random, x.hypot(z));
    axes(random, [x, 0.0, z], [w, 0.0, vz], [0.0, 0.0, 1.0], distance)
}

/// The contact distance is so small that the time of the contact is between two adjacent floating-point numbers.
pub fn close_roots(random: &mut Random, falling: bool) -> State {
    let time = random.power_of_two(-2, 4);
    let size = f64::EPSILON * random.power_of_two(-2, 2);
    let speed = integer(random, 4);
    let g = if falling { integer(random, 4) * 0.25 } else { 0.0 };
    let (position, velocity) = (-speed * time + 0.5 * g * time * time, speed - g * time);
    axes(random, [position, 0.0, 0.0], [velocity, 0.0, 0.0], [g, 0.0, 0.0], size)
}

/// A grain that rests on another grain or hangs on a bond. The distance of the grains is the contact distance, or an
/// adjacent floating-point number.
pub fn resting(random: &mut Random, falling: bool) -> State {
    let (position, distance) = touching(random);
    let g = random.sign() * random.power_of_two(-6, 6);
    let distance = if random.chance(0.5) { distance } else { random.neighbour(distance) };
    let velocity = match random.below(3) {
        0 => Vector::zeros(),
        1 => position * (random.sign() * random.scale(-18.0, -6.0)),
        _ => random.vector() * random.scale(-18.0, -6.0),
    };
    state(position, velocity, if_falling(falling, position * g), distance)
}

/// A pair that leaves a contact and returns. The root at time zero is no event.
pub fn return_to_contact(random: &mut Random, falling: bool) -> State {
    let (position, distance) = touching(random);
    let speed = random.scale(-12.0, 1.0);
    let g = random.scale(-6.0, 2.0);
    let up = position / distance;
    let aside = random.vector() * speed * random.scale(-6.0, 0.0);
    let distance = random.neighbour(distance);
    state(position, up * (speed * random.sign()) + aside, if_falling(falling, up * (g * random.sign())), distance)
}

pub fn straight_throw(random: &mut Random, falling: bool) -> State {
    let a = if falling { random.between(-2.0, 2.0) } else { 0.0 };
    let (x, v) = (random.between(-3.0, 3.0), random.between(-2.0, 2.0));
    axes(random, [x, 0.0, 0.0], [v, 0.0, 0.0], [a, 0.0, 0.0], 1.0)
}
