//! Families of difficult states for the detection of contacts with surfaces.

use super::approach::{Approach, Target};
use super::feature::{Feature, State};
use crate::random::Random;
use carom::Vector;

pub type Family = fn(&mut Random, &mut Approach);

pub const FAMILIES: [(&str, Family); 20] = [
    ("order one", |_, _| ()),
    ("beside", beside),
    ("grazing", grazing),
    ("foot on an end", on_end),
    ("foot ulps from an end", near_end),
    ("foot turns at an end", turns_at_end),
    ("along the feature", parallel),
    ("at rest", resting),
    ("slight overlap", slight_overlap),
    ("enters while inside", entering),
    ("deep inside", deep),
    ("tiny", tiny),
    ("sliver", sliver),
    ("coordinates of 1e6", offset),
    ("from 1e6 away", far),
    ("acceleration along or across", aligned),
    ("exact zeros", zeros),
    ("slow or fast", speeds),
    ("20 decades of length and time", |_, _| ()),
    ("20 decades of every component", |_, _| ()),
];

pub fn draw(random: &mut Random, target: Target, number: usize) -> State {
    let mut approach = Approach::new(random, target);
    match FAMILIES[number].0 {
        "20 decades of length and time" => {
            FAMILIES[random.below(18)].1(random, &mut approach);
            let state = approach.state(random);
            rescaled(random, state)
        }
        "20 decades of every component" => {
            let state = approach.state(random);
            of_any_scale(random, state)
        }
        _ => {
            FAMILIES[number].1(random, &mut approach);
            approach.state(random)
        }
    }
}

/// Returns zero, or a few units in the last place of 1.
fn ulps(random: &mut Random) -> f64 {
    if random.chance(0.3) { 0.0 } else { f64::EPSILON * (random.below(17) as f64 - 8.0) * 0.5 }
}

fn beside(random: &mut Random, approach: &mut Approach) {
    approach.nudge(random, 1.0);
}

/// The smallest distance and the contact distance differ by a few ulps, or sometimes by 10^4 times as much.
fn grazing(random: &mut Random, approach: &mut Approach) {
    approach.velocity[0] = 0.0;
    if random.chance(0.3) {
        approach.acceleration[0] = 0.0;
    }
    approach.gap = ulps(random) * if random.chance(0.2) { 1e4 } else { 1.0 };
    if random.chance(0.3) {
        on_end(random, approach);
    }
}

fn on_end(random: &mut Random, approach: &mut Approach) {
    approach.put_on_end(random);
}

fn near_end(random: &mut Random, approach: &mut Approach) {
    approach.put_on_end(random);
    let size = f64::EPSILON * random.power_of_two(-1, 4);
    approach.nudge(random, size);
}

/// The foot of the perpendicular reverses its motion within a few ulps of an end of the feature.
fn turns_at_end(random: &mut Random, approach: &mut Approach) {
    approach.put_on_end(random);
    let slip = ulps(random);
    approach.nudge(random, slip);
    for k in 1..3 {
        approach.velocity[k] = ulps(random);
    }
    approach.acceleration = approach.triple(random);
    if random.chance(0.5) {
        inside(random, approach);
    }
}

/// The sphere is closer than the contact distance, and the distance changes slowly.
fn inside(random: &mut Random, approach: &mut Approach) {
    approach.gap = -if approach.is_exact { random.below(8) as f64 / 8.0 } else { random.between(0.0, 1.0) };
    let slow = random.power_of_two(-8, 0) * random.sign();
    approach.velocity[0] *= slow;
    approach.acceleration[0] *= if random.chance(0.3) { 0.0 } else { slow };
}

fn parallel(random: &mut Random, approach: &mut Approach) {
    let noise = |random: &mut Random| if random.chance(0.6) { 0.0 } else { ulps(random) };
    approach.gap = match random.below(4) {
        0 => ulps(random),
        1 => -random.uniform(),
        _ => random.between(-1.0, 2.0),
    };
    approach.velocity[0] = noise(random);
    approach.acceleration[0] = noise(random);
    if random.chance(0.8) {
        approach.velocity[2] = noise(random);
        approach.acceleration[2] = noise(random);
    }
    if random.chance(0.4) {
        approach.acceleration = [0.0; 3];
    }
    if random.chance(0.3) {
        near_end(random, approach);
    }
}

/// The sphere is in contact from the start, almost at rest. It may be pressed against the feature.
fn resting(random: &mut Random, approach: &mut Approach) {
    approach.time = 0.0;
    approach.gap = ulps(random);
    approach.acceleration = match random.below(4) {
        0 => [0.0; 3],
        1 => approach.triple(random),
        _ => [approach.number(random), 0.0, 0.0],
    };
    let small = if random.chance(0.5) { 0.0 } else { random.scale(-18.0, -6.0) };
    approach.velocity = approach.velocity.map(|v| v * small);
    match random.below(3) {
        0 => on_end(random, approach),
        1 => near_end(random, approach),
        _ => {}
    }
}

fn slight_overlap(random: &mut Random, approach: &mut Approach) {
    approach.time = 0.0;
    approach.gap = -random.scale(-16.0, -9.0);
    approach.velocity[0] *= random.sign() * if random.chance(0.5) { random.scale(-10.0, 0.0) } else { 1.0 };
    match random.below(4) {
        0 => on_end(random, approach),
        1 => near_end(random, approach),
        2 => beside(random, approach),
        _ => {}
    }
}

fn entering(random: &mut Random, approach: &mut Approach) {
    near_end(random, approach);
    inside(random, approach);
}

fn deep(random: &mut Random, approach: &mut Approach) {
    approach.nudge(random, 1.0);
    inside(random, approach);
    if random.chance(0.5) {
        approach.time = 0.0;
    }
}

fn shrink(approach: &mut Approach, factors: [f64; 2]) {
    approach.length *= factors[0];
    for point in approach.corners.iter_mut().chain([&mut approach.foot]) {
        *point = [point[0] * factors[0], point[1] * factors[1]];
    }
}

fn tiny(random: &mut Random, approach: &mut Approach) {
    if random.chance(0.3) {
        on_end(random, approach);
    }
    shrink(approach, [1e-6; 2]);
    if random.chance(0.5) {
        approach.nudge(random, 1e-6);
    }
    if random.chance(0.3) {
        inside(random, approach);
    }
}

fn sliver(random: &mut Random, approach: &mut Approach) {
    if random.chance(0.5) {
        on_end(random, approach);
    }
    shrink(approach, [1.0, 1e-6]);
    if approach.target != Target::Face {
        approach.contact *= 1e-6;
    }
    if random.chance(0.3) {
        inside(random, approach);
    }
}

/// The feature is far from the origin, so relative positions lose their last digits.
fn offset(random: &mut Random, approach: &mut Approach) {
    approach.offset = random.vector() * 1e6;
    match random.below(5) {
        0 => on_end(random, approach),
        1 => near_end(random, approach),
        2 => grazing(random, approach),
        3 => inside(random, approach),
        _ => {}
    }
}

fn far(random: &mut Random, approach: &mut Approach) {
    approach.time = random.scale(5.0, 6.5);
    let curve = random.scale(-14.0, -5.0);
    approach.acceleration = approach.acceleration.map(|a| a * curve);
    if random.chance(0.3) {
        grazing(random, approach);
    }
    if random.chance(0.4) {
        on_end(random, approach);
    }
}

/// The acceleration is along an axis of the frame. The other two components are zero or small.
fn aligned(random: &mut Random, approach: &mut Approach) {
    let (axis, size) = (random.below(3), random.sign() * random.scale(-2.0, 2.0));
    let rest = match random.below(3) {
        0 => 0.0,
        1 => f64::EPSILON * random.power_of_two(-2, 5),
        _ => random.scale(-16.0, -6.0),
    };
    approach.acceleration = approach.triple(random).map(|a| a * rest * size);
    approach.acceleration[axis] = size;
    match random.below(4) {
        0 => on_end(random, approach),
        1 => grazing(random, approach),
        2 => inside(random, approach),
        _ => {}
    }
}

fn zeros(random: &mut Random, approach: &mut Approach) {
    let Approach { velocity, acceleration, foot, time, .. } = approach;
    for x in velocity.iter_mut().chain(acceleration).chain(foot) {
        if random.chance(0.5) {
            *x = random.sign() * 0.0;
        }
    }
    if random.chance(0.3) {
        *time = 0.0;
    }
}

fn speeds(random: &mut Random, approach: &mut Approach) {
    let factor = |random: &mut Random| if random.chance(0.4) { 1.0 } else { random.scale(-10.0, 10.0) };
    let (speed, push) = (factor(random), factor(random));
    approach.velocity = approach.velocity.map(|v| v * speed);
    approach.acceleration = approach.acceleration.map(|a| a * push);
    approach.time /= speed;
}

/// Changes the units of length and time. All factors are between `1e-20` and `1e20`.
fn rescaled(random: &mut Random, mut state: State) -> State {
    let (length, time) = loop {
        let (length, time) = (random.scale(-20.0, 20.0), random.scale(-20.0, 20.0));
        if [length / time, length / time / time].iter().all(|x| (1e-20..1e20).contains(x)) {
            break (length, time);
        }
    };
    for x in [&mut state.position, &mut state.velocity, &mut state.acceleration] {
        *x *= length;
    }
    state.contact *= length;
    match &mut state.feature {
        Feature::Segment(_, own) => *own *= length,
        Feature::Face(_, sides) => sides.iter_mut().for_each(|(_, from)| *from *= length),
        _ => {}
    }
    state.velocity /= time;
    state.acceleration /= time * time;
    state
}

fn of_any_scale(random: &mut Random, mut state: State) -> State {
    let mut scaled = |x: &Vector| {
        let scale = random.scale(-20.0, 20.0);
        if random.chance(0.5) { x * scale } else { x.map(|x| x.signum() * random.scale(-20.0, 20.0)) }
    };
    let (position, velocity, acceleration) = (state.position, state.velocity, state.acceleration);
    [state.position, state.velocity] = [scaled(&position), scaled(&velocity)];
    if acceleration != Vector::zeros() {
        state.acceleration = scaled(&acceleration);
    }
    if let Feature::Face(_, sides) = &mut state.feature {
        sides.iter_mut().for_each(|(_, from)| *from = scaled(from));
    }
    if let Feature::Segment(_, length) = &mut state.feature {
        *length = random.scale(-20.0, 20.0);
    }
    let near = state.position.norm() * random.scale(-1.0, 1.0);
    state.contact = if random.chance(0.5) { near } else { random.scale(-20.0, 20.0) };
    state
}
