//! Contacts with the faces, edges and corners of surfaces by Algorithm 1. Edges between coplanar faces are included.

use super::algorithm_1::{Polynomial, first_on};
use super::rules::Side;
use crate::Vector;
use crate::model::{SceneSurface, SurfaceShape};

/// A point, line or plane of a surface, which limits the position of a sphere.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Feature {
    pub surface: usize,
    shape: Shape,
}

#[derive(Debug, Clone, Copy)]
enum Shape {
    /// The points at distance `radius` from `centre`, approached from one side.
    Point { centre: Vector, radius: f64, side: Side },
    /// The points at distance `radius` from a line of a given or infinite `length`, approached from one side.
    Line { start: Vector, along: Vector, length: Option<f64>, radius: f64, side: Side },
    /// A half space or, with `corners`, the space on one side of a triangular face.
    Plane { point: Vector, normal: Vector, corners: Option<[Vector; 3]> },
}

#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Motion {
    pub position: Vector,
    pub velocity: Vector,
    pub acceleration: Vector,
    pub radius: f64,
}

/// The components of a motion perpendicular to a feature, which determine its overlap function.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Across {
    pub position: Vector,
    pub velocity: Vector,
    pub acceleration: Vector,
    pub barrier: Barrier,
}

/// The condition for contact between a particle and a feature, in the coordinates of [`Across`].
#[derive(Debug, Clone, Copy)]
pub(in super::super) enum Barrier {
    /// Contact at this distance from the origin, reached from one side.
    Round { distance: f64, side: Side },
    /// Contact where the first coordinate, the height, is zero.
    Flat,
}

/// Geometry of the contact between a sphere and a feature.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Touch {
    /// Unit vector from the point, the line or the plane to the centre of the sphere.
    pub normal: Vector,
    pub side: Side,
    /// Curvature across the feature: the inverse distance from its point or line, 0 for a plane `[1 / length]`.
    pub curvature: f64,
    /// The direction of the line, along which the feature has no curvature; `None` for a point or a plane.
    pub along: Option<Vector>,
}

/// Distances of a particle's projection from the sides of a feature, as coefficients of polynomials in time. A distance
/// is negative if the projection is off the feature. Unused rows are zero.
pub(in super::super) type Extents = [[f64; 3]; 4];

pub(in super::super) fn features(surfaces: &[SceneSurface]) -> Vec<Feature> {
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
            let mut is_corner = vec![false; mesh.vertices.len()];
            let corners = mesh.triangles.iter().flatten().map(|vertex| *vertex as usize);
            corners.for_each(|vertex| is_corner[vertex] = true);
            let corners = mesh.vertices.iter().zip(is_corner).filter(|(_, is_corner)| *is_corner);
            let mut shapes: Vec<Shape> = corners.map(|(vertex, _)| point(*vertex)).collect();
            for corners @ [a, b, c] in mesh.all_corners() {
                shapes.extend([[a, b], [b, c], [c, a]].into_iter().filter_map(|ends| line(ends, 0.0)));
                shapes.extend(face(corners).into_iter().flatten());
            }
            shapes
        }
    }
}

fn line([start, end]: [Vector; 2], radius: f64) -> Option<Shape> {
    let along = (end - start).try_normalize(0.0)?;
    Some(Shape::Line { start, along, length: Some((end - start).norm()), radius, side: Side::Positive })
}

/// Returns the front and the back of a triangle; `None` if its area is only round-off.
fn face(corners: [Vector; 3]) -> Option<[Shape; 2]> {
    let [a, b, c] = corners;
    if slenderness(&corners) > 0.25 / f64::EPSILON {
        return None;
    }
    let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
    Some([normal, -normal].map(|normal| Shape::Plane { point: a, normal, corners: Some(corners) }))
}

/// Longest side of a triangle divided by the height above this side. The round-off of the normal grows by this factor.
fn slenderness([a, b, c]: &[Vector; 3]) -> f64 {
    let longest = [b - a, c - b, a - c].iter().map(Vector::norm_squared).fold(0.0, f64::max);
    longest / (b - a).cross(&(c - a)).norm()
}

impl Feature {
    pub fn next_event(&self, motion: &Motion) -> Option<f64> {
        let Across { position, velocity, acceleration, barrier } = self.across(motion);
        let f = match barrier {
            Barrier::Round { distance, side } => {
                Polynomial::overlap(side, distance, &position, &velocity, &acceleration)
            }
            Barrier::Flat => Polynomial::new(&[position.x, velocity.x, 0.5 * acceleration.x]),
        };
        let extents = self.extents(motion).map(|extents| extents.map(|extent| Polynomial::new(&extent)));
        first_on(&f, extents.as_ref().map_or(&[][..], |extents| extents.as_slice()))
    }

    pub fn across(&self, motion: &Motion) -> Across {
        let Motion { position, velocity, acceleration, radius } = *motion;
        let round = |own: f64, side: Side| Barrier::Round { distance: own + side.sign() * radius, side };
        match self.shape {
            Shape::Point { centre, radius: own, side } => {
                Across { position: position - centre, velocity, acceleration, barrier: round(own, side) }
            }
            Shape::Line { start, along, radius: own, side, .. } => {
                let across = |vector: Vector| vector - along * along.dot(&vector);
                let [position, velocity, push] = [position - start, velocity, acceleration].map(across);
                // If the acceleration is along the line, its component across the line is only round-off.
                let acceleration = if push.norm() > 1e-14 * acceleration.norm() { push } else { Vector::zeros() };
                Across { position, velocity, acceleration, barrier: round(own, side) }
            }
            Shape::Plane { point, normal, .. } => {
                let along = |length: f64| Vector::new(length, 0.0, 0.0);
                Across {
                    position: along(normal.dot(&(position - point)) - radius),
                    velocity: along(normal.dot(&velocity)),
                    acceleration: along(normal.dot(&acceleration)),
                    barrier: Barrier::Flat,
                }
            }
        }
    }

    /// Distances of the particle's projection from the sides of the feature, as polynomials in time. For a face, the
    /// fourth polynomial is the height above the face. `None` for a feature without sides.
    pub fn extents(&self, motion: &Motion) -> Option<Extents> {
        let Motion { position, velocity, acceleration, .. } = *motion;
        let along = |direction: &Vector, from: &Vector| {
            [direction.dot(&(position - from)), direction.dot(&velocity), 0.5 * direction.dot(&acceleration)]
        };
        match self.shape {
            Shape::Line { start, along: line, length: Some(length), .. } => {
                let [foot, rate, bend] = along(&line, &start);
                Some([[foot, rate, bend], [length - foot, -rate, -bend], [0.0; 3], [0.0; 3]])
            }
            Shape::Plane { normal, corners: Some([a, b, c]), point } => {
                // The sign is 1 if the corners run counterclockwise about `normal`.
                let turn = (b - a).cross(&(c - a)).dot(&normal).signum();
                let inwards = |from: Vector, to: Vector| {
                    let direction = normal.cross(&(to - from)).try_normalize(0.0).unwrap_or_default() * turn;
                    along(&direction, &from)
                };
                Some([inwards(a, b), inwards(b, c), inwards(c, a), along(&normal, &point)])
            }
            _ => None,
        }
    }

    pub fn contact(&self, position: &Vector) -> Touch {
        let round = |apart: Vector, side: Side, along: Option<Vector>| Touch {
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
            Shape::Plane { normal, .. } => Touch { normal, side: Side::Positive, curvature: 0.0, along: None },
        }
    }

    /// Returns two opposite corners of a bounding box. The box is infinite for a feature that is approached from
    /// inside.
    pub fn bounds(&self) -> [Vector; 2] {
        let endless = |is_endless: &dyn Fn(usize) -> bool, at: &Vector, radius: f64| {
            let end = |sign: f64| Vector::from_fn(|k, _| sign * if is_endless(k) { f64::INFINITY } else { radius });
            [at + end(-1.0), at + end(1.0)]
        };
        match self.shape {
            Shape::Point { centre, radius, side } => endless(&|_| side == Side::Negative, &centre, radius),
            Shape::Line { start, along, length: None, radius, side } => {
                endless(&|k| side == Side::Negative || along[k] != 0.0, &start, radius)
            }
            Shape::Line { start, along, length: Some(length), radius, .. } => {
                let end = start + along * length;
                [start.inf(&end).add_scalar(-radius), start.sup(&end).add_scalar(radius)]
            }
            Shape::Plane { corners: Some([a, b, c]), .. } => [a.inf(&b).inf(&c), a.sup(&b).sup(&c)],
            Shape::Plane { point, corners: None, .. } => endless(&|_| true, &point, 0.0),
        }
    }

    /// Returns the largest coordinate of the points that define the feature, plus its radius `[length]`.
    pub fn farthest(&self) -> f64 {
        match self.shape {
            Shape::Point { centre, radius, .. } => centre.amax() + radius,
            Shape::Line { start, length, radius, .. } => start.amax() + length.unwrap_or(0.0) + radius,
            Shape::Plane { point, corners, .. } => {
                corners.iter().flatten().map(Vector::amax).fold(point.amax(), f64::max)
            }
        }
    }

    pub fn slenderness(&self) -> f64 {
        match self.shape {
            Shape::Plane { corners: Some(corners), .. } => slenderness(&corners),
            _ => 1.0,
        }
    }

    pub fn moved(&self, by: &Vector) -> Self {
        let mut moved = *self;
        match &mut moved.shape {
            Shape::Point { centre: at, .. } | Shape::Line { start: at, .. } => *at += by,
            Shape::Plane { point, corners, .. } => {
                *point += by;
                corners.iter_mut().flatten().for_each(|corner| *corner += by);
            }
        }
        moved
    }
}

impl Touch {
    /// Curvature of the feature in the direction of a velocity `[1 / length]`; 0 along the line of a line feature.
    pub fn curvature_for(&self, velocity: &Vector) -> f64 {
        let tangential = velocity - self.normal * self.normal.dot(velocity);
        let across = self.along.map_or(tangential, |along| tangential - along * along.dot(&tangential));
        let share = across.norm_squared() / tangential.norm_squared();
        if share.is_finite() { self.curvature * share } else { 0.0 }
    }
}
