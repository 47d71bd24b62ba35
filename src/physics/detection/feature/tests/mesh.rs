//! Triangle meshes as sets of features: the next contact of a ball, and the distance from a position.

use super::super::{across, face, point, segment};
use crate::Vector;
use crate::physics::detection::stretch::Parabola;
use crate::physics::motion::RelativeState;
use crate::physics::overlap::Side;

struct Face {
    corners: [Vector; 3],
    normal: Vector,
    inwards: [Vector; 3],
}

pub struct Mesh {
    faces: Vec<Face>,
    edges: Vec<[Vector; 2]>,
    points: Vec<Vector>,
}

/// Vertices and triangles of a subdivided icosahedron on a sphere of radius 1.
pub fn sphere(divisions: usize) -> (Vec<Vector>, Vec<[usize; 3]>) {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut points = Vec::new();
    for (a, b) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
        points.extend([Vector::new(0.0, a, b), Vector::new(a, b, 0.0), Vector::new(b, 0.0, a)]);
    }
    let mut faces = Vec::new();
    let near = |a: usize, b: usize, points: &[Vector]| (points[a] - points[b]).norm() < 2.1;
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b, &points) && near(b, c, &points) && near(c, a, &points) {
                    faces.push([a, b, c]);
                }
            }
        }
    }
    for _ in 0..divisions {
        let mut middles = std::collections::BTreeMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in faces {
            let mut middle = |i: usize, j: usize| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    points.push((points[i].normalize() + points[j].normalize()) * 0.5);
                    points.len() - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        faces = finer;
    }
    (points.into_iter().map(|point| point.normalize()).collect(), faces)
}

impl Mesh {
    pub fn new(points: Vec<Vector>, triangles: &[[usize; 3]]) -> Self {
        let mut edges = std::collections::BTreeSet::new();
        let faces = triangles.iter().map(|triangle| {
            let corners = triangle.map(|k| points[k]);
            let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).normalize();
            let inwards = [0, 1, 2].map(|k| normal.cross(&(corners[(k + 1) % 3] - corners[k])).normalize());
            for k in 0..3 {
                let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
                edges.insert([a.min(b), a.max(b)]);
            }
            Face { corners, normal, inwards }
        });
        let faces = faces.collect();
        Self { faces, edges: edges.into_iter().map(|edge| edge.map(|k| points[k])).collect(), points }
    }

    /// Returns the time of the first contact, and the unit vector from the feature to the ball.
    pub fn next(&self, ball: &RelativeState, g: &Vector, contact: f64) -> Option<(f64, Vector)> {
        let squared = contact * contact;
        let from = |p: &Vector| RelativeState { position: ball.position - p, velocity: ball.velocity };
        let at = |t: f64| ball.position + ball.velocity * t + g * (0.5 * t * t);
        let mut first: Option<(f64, Vector)> = None;
        let mut keep = |met: Option<f64>, apart: &dyn Fn(Vector) -> Vector| {
            if let Some(t) = met.filter(|t| first.is_none_or(|(earlier, _)| *t < earlier)) {
                first = Some((t, apart(at(t)).normalize()));
            }
        };
        for Face { corners, normal, inwards } in &self.faces {
            let extents = [0, 1, 2].map(|k| Parabola::along(&inwards[k], &from(&corners[k]), g));
            let height = Parabola::along(normal, &from(&corners[0]), g);
            keep(face(&height, contact, &extents), &|at| normal * normal.dot(&(at - corners[0])).signum());
        }
        for [start, end] in &self.edges {
            let axis = (end - start).normalize();
            keep(segment(&axis, (end - start).norm(), &from(start), g, squared), &|at| across(&axis, &(at - start)));
        }
        for place in &self.points {
            keep(point(&from(place), g, squared, Side::Positive), &|at| at - place);
        }
        first
    }

    pub fn distance(&self, at: &Vector) -> f64 {
        let on = |face: &&Face| (0..3).all(|k| face.inwards[k].dot(&(at - face.corners[k])) >= 0.0);
        let faces = self.faces.iter().filter(on).map(|face| face.normal.dot(&(at - face.corners[0])).abs());
        let edges = self.edges.iter().map(|[a, b]| {
            let along = ((at - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
            (at - a - (b - a) * along).norm()
        });
        faces.chain(edges).fold(f64::INFINITY, f64::min)
    }

    /// Whether a position is inside the mesh. A ray from an inside position crosses an odd number of faces.
    pub fn is_inside(&self, at: &Vector) -> bool {
        let along = Vector::new(0.3, 0.5, 0.81).normalize();
        let crossings = self.faces.iter().filter(|face| {
            let [a, b, c] = face.corners.map(|corner| corner - at);
            let signs = [a.cross(&b), b.cross(&c), c.cross(&a)].map(|n| n.dot(&along) > 0.0);
            let is_through = signs.iter().all(|sign| *sign == signs[0]);
            is_through && a.dot(&face.normal) * along.dot(&face.normal) > 0.0
        });
        crossings.count() % 2 == 1
    }
}
