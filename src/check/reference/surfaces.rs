//! Surfaces by Algorithm 1 on every feature: faces, edges and corners, each with its own overlap function, and all of them, flat edges too.

use super::algorithm_1::{Polynomial, next_event};
use super::rules::Side;
use crate::Vector;
use crate::model::{SceneSurface, SurfaceShape};

/// A quartic has four roots.
const MOST_ROOTS: usize = 4;

/// One feature of a surface, of which a sphere's centre keeps a distance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Feature {
    /// Number of the surface among those of the scene.
    pub surface: usize,
    shape: Shape,
}

#[derive(Debug, Clone, Copy)]
enum Shape {
    /// A point, at a distance and from a side.
    Point { centre: Vector, radius: f64, side: Side },
    /// A line through a point along a unit vector, whole or between the point and a length.
    Line { start: Vector, along: Vector, length: Option<f64>, radius: f64, side: Side },
    /// A half space, or with `corners` a face that is met from both sides.
    Plane { point: Vector, normal: Vector, corners: Option<[Vector; 3]> },
}

/// The motion of a sphere: position, velocity, acceleration, radius.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    pub position: Vector,
    pub velocity: Vector,
    pub acceleration: Vector,
    pub radius: f64,
}

/// How a sphere in contact sees a feature.
#[derive(Debug, Clone, Copy)]
pub(super) struct Contact {
    /// Unit vector from the point, the line or the plane to the centre of the sphere.
    pub normal: Vector,
    pub side: Side,
    /// `1 / distance` for the part of the velocity across the feature, 0 for a plane `[1 / length]`.
    pub curvature: f64,
    /// The direction in which the feature does not curve, if it is a line.
    pub along: Option<Vector>,
}

/// All features of the surfaces of a scene.
pub(super) fn features(surfaces: &[SceneSurface]) -> Vec<Feature> {
    let of = |(surface, of): (usize, &SceneSurface)| {
        let shapes = shapes(&of.shape);
        shapes.into_iter().map(move |shape| Feature { surface, shape })
    };
    surfaces.iter().enumerate().flat_map(of).collect()
}

fn shapes(shape: &SurfaceShape) -> Vec<Shape> {
    let side = |is_inside: bool| if is_inside { Side::Negative } else { Side::Positive };
    let point = |centre| Shape::Point { centre, radius: 0.0, side: Side::Positive };
    match shape {
        SurfaceShape::Plane { point, normal } => {
            vec![Shape::Plane { point: *point, normal: normal.normalize(), corners: None }]
        }
        &SurfaceShape::Sphere { centre, radius, is_inside } => {
            vec![Shape::Point { centre, radius, side: side(is_inside) }]
        }
        &SurfaceShape::Cylinder { point, axis, radius, is_inside } => {
            vec![Shape::Line { start: point, along: axis.normalize(), length: None, radius, side: side(is_inside) }]
        }
        &SurfaceShape::Capsule { ends, radius } => {
            let ball = |centre| Shape::Point { centre, radius, side: Side::Positive };
            line(ends, radius).into_iter().chain(ends.map(ball)).collect()
        }
        SurfaceShape::Mesh(mesh) => {
            let mut shapes: Vec<Shape> = mesh.vertices.iter().copied().map(point).collect();
            for corners @ [a, b, c] in mesh.all_corners() {
                shapes.extend([[a, b], [b, c], [c, a]].into_iter().filter_map(|ends| line(ends, 0.0)));
                let normal = (b - a).cross(&(c - a)).try_normalize(0.0);
                shapes.extend(normal.map(|normal| Shape::Plane { point: a, normal, corners: Some(corners) }));
            }
            shapes
        }
    }
}

fn line([start, end]: [Vector; 2], radius: f64) -> Option<Shape> {
    let along = (end - start).try_normalize(0.0)?;
    Some(Shape::Line { start, along, length: Some((end - start).norm()), radius, side: Side::Positive })
}

impl Feature {
    /// Time from now to the next event of a sphere with the feature.
    pub fn next_event(&self, motion: &Motion) -> Option<f64> {
        let Motion { position, velocity, acceleration, radius } = *motion;
        match self.shape {
            Shape::Point { centre, radius: own, side } => {
                let distance = own + side.sign() * radius;
                next_event(&Polynomial::overlap(side, distance, &(position - centre), &velocity, &acceleration))
            }
            Shape::Line { start, along, radius: own, side, .. } => {
                let across = |vector: Vector| vector - along * along.dot(&vector);
                let [r, v, a] = [position - start, velocity, acceleration].map(across);
                // Along the line there is no acceleration across it but rounding.
                let a = if a.norm() > 1e-14 * acceleration.norm() { a } else { Vector::zeros() };
                let f = Polynomial::overlap(side, own + side.sign() * radius, &r, &v, &a);
                self.first_on(&f, motion)
            }
            Shape::Plane { point, normal, corners: None } => {
                let f =
                    [normal.dot(&(position - point)) - radius, normal.dot(&velocity), 0.5 * normal.dot(&acceleration)];
                next_event(&Polynomial::new(&f))
            }
            Shape::Plane { point, normal, corners: Some(_) } => {
                // From either side: the square of the height, as of a pair on a line.
                let [r, v, a] = [position - point, velocity, acceleration].map(|vector| normal * normal.dot(&vector));
                self.first_on(&Polynomial::overlap(Side::Positive, radius, &r, &v, &a), motion)
            }
        }
    }

    /// The first event of an overlap function whose foot is on the feature.
    fn first_on(&self, f: &Polynomial, motion: &Motion) -> Option<f64> {
        let mut time = next_event(f)?;
        loop {
            let at = motion.position + (motion.velocity + motion.acceleration * (0.5 * time)) * time;
            if self.holds(&at) {
                return Some(time);
            }
            // On to the next one at which it becomes negative.
            let derivative = f.derivative();
            // Rounding may leave a root behind the time where it was found, to be found again.
            let after = |time: f64| f.next_root(time * (1.0 + 8.0 * f64::EPSILON));
            time = std::iter::successors(after(time), |root| after(*root))
                .take(MOST_ROOTS)
                .find(|root| derivative.value(*root) < 0.0)?;
        }
    }

    /// Whether the foot of a position is on the feature, its ends included.
    fn holds(&self, position: &Vector) -> bool {
        match self.shape {
            Shape::Line { start, along, length: Some(length), .. } => {
                (0.0..=length).contains(&along.dot(&(position - start)))
            }
            Shape::Plane { normal, corners: Some([a, b, c]), .. } => {
                [[a, b], [b, c], [c, a]].iter().all(|[a, b]| normal.cross(&(b - a)).dot(&(position - a)) >= 0.0)
            }
            _ => true,
        }
    }

    /// A contact at a position.
    pub fn contact(&self, position: &Vector) -> Contact {
        let round = |apart: Vector, side: Side, along: Option<Vector>| Contact {
            normal: apart.try_normalize(0.0).unwrap_or(Vector::x()),
            side,
            curvature: 1.0 / apart.norm().max(f64::MIN_POSITIVE),
            along,
        };
        match self.shape {
            Shape::Point { centre, side, .. } => round(position - centre, side, None),
            Shape::Line { start, along, side, .. } => {
                let apart = position - start;
                round(apart - along * along.dot(&apart), side, Some(along))
            }
            Shape::Plane { point, normal, corners } => {
                let is_behind = corners.is_some() && normal.dot(&(position - point)) < 0.0;
                let normal = if is_behind { -normal } else { normal };
                Contact { normal, side: Side::Positive, curvature: 0.0, along: None }
            }
        }
    }
}

impl Contact {
    /// The curvature for a velocity, of which the part along a line does not curve `[1 / length]`.
    pub fn curvature_for(&self, velocity: &Vector) -> f64 {
        let tangential = velocity - self.normal * self.normal.dot(velocity);
        let across = self.along.map_or(tangential, |along| tangential - along * along.dot(&tangential));
        let share = across.norm_squared() / tangential.norm_squared();
        if share.is_finite() { self.curvature * share } else { 0.0 }
    }
}
