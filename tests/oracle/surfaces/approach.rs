//! Motions that are chosen at the time of contact and traced back to their start.

use super::feature::{Feature, State};
use crate::random::Random;
use carom::Vector;
use carom::physics::overlap::Side;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    Point,
    Line,
    Segment,
    Face,
    Plane,
}

/// A contact of a sphere with a feature. The first component of a vector is perpendicular to a line, the second is
/// along the line, and the third is perpendicular to both. For a face, the last two are in its plane.
#[derive(Debug, Clone)]
pub struct Approach {
    pub target: Target,
    pub side: Side,
    pub frame: [Vector; 3],
    /// All numbers are small binary fractions, and the directions are coordinate axes. Nothing is rounded.
    pub is_exact: bool,
    pub length: f64,
    pub corners: [[f64; 2]; 3],
    /// Foot of the perpendicular, in coordinates of the feature.
    pub foot: [f64; 2],
    pub contact: f64,
    /// `(distance - contact) / contact`.
    pub gap: f64,
    pub velocity: [f64; 3],
    pub acceleration: [f64; 3],
    pub time: f64,
    /// Position of the feature. Far from the origin, relative positions lose digits.
    pub offset: Vector,
}

const EXACT_FRAME: [Vector; 3] = [Vector::new(1.0, 0.0, 0.0), Vector::new(0.0, 1.0, 0.0), Vector::new(0.0, 0.0, 1.0)];

impl Approach {
    /// Returns a contact in which all numbers are of order one. The foot of the perpendicular is on the feature.
    pub fn new(random: &mut Random, target: Target) -> Self {
        let is_exact = random.chance(0.35);
        let frame = if is_exact {
            random.turned(EXACT_FRAME)
        } else {
            let (first, second) = random.directions();
            [first, second, first.cross(&second)]
        };
        let side = if matches!(target, Target::Point | Target::Line) && random.chance(0.4) {
            Side::Negative
        } else {
            Side::Positive
        };
        let mut approach = Self {
            target,
            side,
            frame,
            is_exact,
            length: if is_exact { random.power_of_two(-1, 1) } else { random.between(0.3, 2.0) },
            corners: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            foot: [0.0; 2],
            contact: if is_exact { random.power_of_two(-2, 1) } else { random.between(0.2, 1.5) },
            gap: 0.0,
            velocity: [0.0; 3],
            acceleration: [0.0; 3],
            time: if is_exact { random.below(9) as f64 / 4.0 } else { random.between(0.0, 3.0) },
            offset: Vector::zeros(),
        };
        approach.velocity = approach.triple(random);
        let falls = random.chance(0.6);
        if falls {
            approach.acceleration = approach.triple(random);
        }
        if approach.velocity[0] > 0.0 {
            approach.velocity[0] *= -1.0;
        }
        if side == Side::Negative {
            approach.velocity[0] *= -1.0;
        }
        approach.draw_corners(random);
        approach.put_inside(random);
        approach
    }

    pub fn number(&self, random: &mut Random) -> f64 {
        if self.is_exact { (random.below(17) as f64 - 8.0) / 8.0 } else { random.between(-1.0, 1.0) }
    }

    pub fn triple(&self, random: &mut Random) -> [f64; 3] {
        [(); 3].map(|()| self.number(random))
    }

    fn draw_corners(&mut self, random: &mut Random) {
        while !self.is_exact {
            self.corners = [(); 3].map(|()| [random.between(-1.0, 1.0), random.between(-1.0, 1.0)]);
            let [[a, b], [c, d], [e, f]] = self.corners;
            if ((c - a) * (f - b) - (e - a) * (d - b)).abs() > 0.1 {
                break;
            }
        }
    }

    /// Puts the foot of the perpendicular on the feature.
    pub fn put_inside(&mut self, random: &mut Random) {
        let [a, b, c] = self.corners;
        let (mut p, mut q) = (self.number(random).abs(), self.number(random).abs());
        if p + q > 1.0 {
            (p, q) = (1.0 - p, 1.0 - q);
        }
        self.foot = match self.target {
            Target::Segment => [self.length * p, 0.0],
            Target::Face => [0, 1].map(|k| a[k] + p * (b[k] - a[k]) + q * (c[k] - a[k])),
            _ => [self.number(random), self.number(random)],
        };
    }

    /// Puts the foot of the perpendicular on an end, a side or a corner of the feature.
    pub fn put_on_end(&mut self, random: &mut Random) {
        let first = random.below(3);
        let [a, b] = [self.corners[first], self.corners[(first + 1) % 3]];
        let part = if random.chance(0.4) { 0.0 } else { self.number(random).abs() };
        self.foot = match self.target {
            Target::Segment => [if random.chance(0.5) { 0.0 } else { self.length }, 0.0],
            Target::Face => [0, 1].map(|k| a[k] + part * (b[k] - a[k])),
            _ => [self.number(random), self.number(random)],
        };
    }

    /// Moves the foot of the perpendicular along the feature by up to `size`, in a random direction.
    pub fn nudge(&mut self, random: &mut Random, size: f64) {
        for x in &mut self.foot {
            *x += size * (random.below(9) as f64 - 4.0) / 4.0;
        }
    }

    fn vector(&self, [out, along, third]: [f64; 3]) -> Vector {
        self.frame[0] * out + self.frame[1] * along + self.frame[2] * third
    }

    pub fn state(&self, random: &mut Random) -> State {
        let (velocity, acceleration, t) = (self.vector(self.velocity), self.vector(self.acceleration), self.time);
        let foot = match self.target {
            Target::Point => [0.0; 2],
            Target::Line | Target::Segment => [self.foot[0], 0.0],
            Target::Face | Target::Plane => self.foot,
        };
        let at = self.vector([self.contact * (1.0 + self.gap), foot[0], foot[1]]);
        let position = self.offset + (at - velocity * t + acceleration * (0.5 * t * t));
        let feature = match self.target {
            Target::Point => Feature::Point(self.side),
            Target::Line => Feature::Line(self.frame[1], self.side),
            Target::Segment => Feature::Segment(self.frame[1], self.length),
            Target::Plane => Feature::Plane(self.frame[0]),
            Target::Face => self.face(random, &position),
        };
        let position = position - self.offset;
        State { feature, position, velocity: velocity - acceleration * t, acceleration, contact: self.contact }
    }

    /// Returns a face whose normal points to a random side.
    fn face(&self, random: &mut Random, position: &Vector) -> Feature {
        let corners = self.corners.map(|[x, y]| self.offset + self.vector([0.0, x, y]));
        let along = |side: usize| corners[(side + 1) % 3] - corners[side];
        let normal = along(0).cross(&along(1)).try_normalize(0.0).unwrap_or(self.frame[0]);
        let inward = |side: usize| normal.cross(&along(side)).try_normalize(0.0).unwrap_or(self.frame[1]);
        let sides = [0, 1, 2].map(|side| (inward(side), position - corners[side]));
        Feature::Face(if random.chance(0.5) { normal } else { -normal }, sides)
    }
}
