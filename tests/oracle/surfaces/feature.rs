//! A sphere and a feature of a surface, and the exact polynomials that are compared with Carom's answer.
//!
//! All given numbers are exact. Positions are relative to a point of the feature. The exact polynomials use the
//! expressions of the code, without rounding: `across(d, x) = x - d (d . x)` for a line, the height `n . x` above a
//! plane or face, the extents `d . x` and `L - d . x` of a segment, and `w . x` for each side of a face. A sphere
//! touches a face if `|h| <= s` and `|h|` falls.

use super::question::{Form, Question, Shape};
use super::rounded::{Rounded, across, dot, triple};
use carom::Vector;
use carom::physics::detection::stretch::Parabola;
use carom::physics::detection::{feature, plane};
use carom::physics::motion::RelativeState;
use carom::physics::overlap::{Quadratic, Quartic, Side};

#[derive(Debug, Clone, Copy)]
pub enum Feature {
    Point(Side),
    Line(Vector, Side),
    Segment(Vector, f64),
    /// The normal of the face. For each side, a direction into the face and the position relative to one end.
    Face(Vector, [(Vector, Vector); 3]),
    Plane(Vector),
}

/// A motion of a sphere relative to a feature.
#[derive(Debug, Clone, Copy)]
pub struct State {
    pub feature: Feature,
    pub position: Vector,
    pub velocity: Vector,
    pub acceleration: Vector,
    pub contact: f64,
}

/// Number of roundings of each coefficient in Algorithms 2 and 3. Each product in `D = B^2 - V2 R2` is rounded once.
const OF_QUADRATIC: [u32; 3] = [1, 1, 1];

/// Number of roundings of each coefficient in Horner's rule for a quartic, plus one for the factor 3 of `t^3`.
const OF_QUARTIC: [u32; 5] = [1, 3, 5, 8, 8];

/// Number of roundings of each coefficient for a plane. Each product in `D = v^2 - 2 a h` is rounded once. The last
/// number is for the contact distance, which is subtracted from the height.
const OF_PLANE: [u32; 4] = [1, 1, 1, 0];

/// Number of roundings of each coefficient of an extent. Horner's rule adds 1, 3 and 4 to the coefficients of degree 0,
/// 1 and 2. The discriminant adds 2 to each coefficient. The rate at the start of an interval adds 1 to degree 1 and 2
/// to degree 2. The extent is evaluated within 3 ulp of the root, which adds `6 k` to degree `k`.
const OF_EXTENT: [u32; 3] = [3, 6 + 6, 8 + 12];

impl State {
    fn relative(&self) -> RelativeState {
        RelativeState { position: self.position, velocity: self.velocity }
    }

    fn side(&self) -> Side {
        match self.feature {
            Feature::Point(side) | Feature::Line(_, side) => side,
            _ => Side::Positive,
        }
    }

    pub fn ask(&self) -> Option<f64> {
        let (state, a, squared) = (self.relative(), &self.acceleration, self.contact * self.contact);
        match &self.feature {
            Feature::Point(side) => feature::point(&state, a, squared, *side),
            Feature::Line(direction, side) => feature::line(direction, &state, a, squared, *side),
            Feature::Segment(direction, length) => feature::segment(direction, *length, &state, a, squared),
            Feature::Face(normal, sides) => {
                let extents = sides.map(|(inward, from)| self.along(&inward, &from));
                feature::face(&self.along(normal, &self.position), self.contact, &extents)
            }
            Feature::Plane(normal) => {
                let height = normal.dot(&self.position) - self.contact;
                plane::next_event(height, normal.dot(&self.velocity), normal.dot(a))
            }
        }
    }

    fn along(&self, direction: &Vector, position: &Vector) -> Parabola {
        let state = RelativeState { position: *position, velocity: self.velocity };
        Parabola::along(direction, &state, &self.acceleration)
    }

    pub fn question(&self) -> Question {
        let (shape, first) = match &self.feature {
            Feature::Point(side) => (Shape::Square(unit(*side)), self.square(None, &self.acceleration)),
            Feature::Line(direction, side) => {
                (Shape::Square(unit(*side)), self.square(Some(direction), &self.acceleration))
            }
            Feature::Segment(direction, _) => (Shape::Square(1), self.square(Some(direction), &self.acceleration)),
            Feature::Face(normal, _) => (Shape::TwoSided, self.height(normal, true)),
            Feature::Plane(normal) => (Shape::Linear, self.height(normal, false)),
        };
        let mut forms = vec![first];
        match &self.feature {
            Feature::Segment(direction, length) => {
                let (terms, computed) = self.component(direction, &self.position);
                let [b0, b1, b2] = &terms;
                let rest = [&Rounded::of(*length) - b0, b1.negative(), b2.negative()];
                forms.push(Form::new(&terms, &computed.0, &OF_EXTENT));
                forms.push(Form::new(&rest, &computed.from_end(*length).0, &OF_EXTENT));
            }
            Feature::Face(_, sides) => {
                for (inward, from) in sides {
                    let (terms, computed) = self.component(inward, from);
                    forms.push(Form::new(&terms, &computed.0, &OF_EXTENT));
                }
            }
            _ => {}
        }
        let without_acceleration = match &self.feature {
            Feature::Line(direction, _) | Feature::Segment(direction, _) => self.without_acceleration(direction),
            _ => None,
        };
        Question { shape, forms, without_acceleration }
    }

    /// Returns the motion along a direction, exactly and as computed by Carom.
    fn component(&self, direction: &Vector, position: &Vector) -> ([Rounded; 3], Parabola) {
        let d = triple(direction);
        let component = |vector: &Vector| dot(&d, &triple(vector));
        let half = component(&self.acceleration).half();
        ([component(position), component(&self.velocity), half], self.along(direction, position))
    }

    fn height(&self, normal: &Vector, is_two_sided: bool) -> Form {
        let ([h0, h1, h2], computed) = self.component(normal, &self.position);
        let distance = Rounded::of(self.contact);
        let gap = &h0 - &distance;
        let [c0, c1, c2] = computed.0;
        if is_two_sided {
            // The rounding error of the difference is assigned to the contact distance.
            let distance = Rounded { error: gap.error - h0.error, ..distance };
            return Form::new(&[h0, h1, h2, distance], &[c0, c1, c2, self.contact], &OF_PLANE);
        }
        Form::new(&[gap, h1, h2], &[c0 - self.contact, c1, c2], &OF_PLANE)
    }

    /// Returns the overlap function of the squared distance to a point or a line.
    fn square(&self, direction: Option<&Vector>, acceleration: &Vector) -> Form {
        let [r, v, a] = [&self.position, &self.velocity, acceleration].map(|vector| {
            let vector = triple(vector);
            direction.map_or(vector.clone(), |direction| across(&triple(direction), &vector))
        });
        let c0 = &dot(&r, &r) - &Rounded::of(self.contact * self.contact);
        let c2 = &dot(&a, &r) + &dot(&v, &v);
        let mut terms = vec![c0, dot(&v, &r).double(), c2, dot(&a, &v), dot(&a, &a).half().half()];
        let is_quadratic = *acceleration == Vector::zeros();
        if is_quadratic {
            terms.truncate(3);
        }
        let mut computed = self.computed_square(direction, acceleration);
        if self.side() == Side::Negative {
            terms = terms.iter().map(Rounded::negative).collect();
            computed = computed.iter().map(|c| -c).collect();
        }
        Form::new(&terms, &computed, if is_quadratic { &OF_QUADRATIC } else { &OF_QUARTIC })
    }

    /// Returns the overlap function without acceleration if Carom may neglect the acceleration. Carom does so if the
    /// computed component across the line is at most 4 epsilon of the acceleration. Rounding may add 3 epsilon.
    fn without_acceleration(&self, direction: &Vector) -> Option<Form> {
        let size = self.acceleration.norm();
        let beside = across(&triple(direction), &triple(&self.acceleration));
        let square = beside.iter().map(|x| x.size * x.size).sum::<f64>();
        let can_be_dropped = size > 0.0 && square.sqrt() <= 7.0 * f64::EPSILON * size;
        can_be_dropped.then(|| self.square(Some(direction), &Vector::zeros()))
    }

    fn computed_square(&self, direction: Option<&Vector>, acceleration: &Vector) -> Vec<f64> {
        let project = |x: &Vector| direction.map_or(*x, |direction| feature::across(direction, x));
        let state = RelativeState { position: project(&self.position), velocity: project(&self.velocity) };
        let squared = self.contact * self.contact;
        if *acceleration == Vector::zeros() {
            let Quadratic { r2, b, v2 } = Quadratic::new(&state, squared);
            return vec![r2, 2.0 * b, v2];
        }
        Quartic::new(&state, &project(acceleration), squared).coefficients.to_vec()
    }
}

fn unit(side: Side) -> i32 {
    if side == Side::Positive { 1 } else { -1 }
}
