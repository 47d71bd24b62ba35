//! Normals and sharp edges of a surface mesh.

use crate::Vector;
use crate::base::numbers::id;
use crate::model::TriangleMesh;
use crate::model::surface_motion::Timeline;
use crate::model::triangle_mesh::{EdgeUse, twice_area};
use crate::view::render::{corners, joined};

/// Cosine of 35 degrees, the largest angle between adjacent triangles of a smooth surface.
const SMOOTH: f64 = 0.819;

/// With more edges than this, no edges are drawn, because they would cover the surface.
const MOST_EDGES: usize = 20_000;

/// A mesh with a normal at each corner of each triangle. Normals vary smoothly where triangles meet at small angles.
/// Elsewhere, the surface has an edge.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::view) struct Skin {
    /// Positions of the vertices, one per normal `[length]`.
    pub vertices: Vec<Vector>,
    pub normals: Vec<Vector>,
    pub triangles: Vec<[u32; 3]>,
    /// End points of rims and of sharp edges.
    pub edges: Vec<[Vector; 2]>,
    pub bounds: [Vector; 2],
    /// Index of the surface in the scene, if known.
    pub number: Option<usize>,
    /// Motion of the surface, if any. All other fields describe the surface before the motion.
    pub timeline: Option<Timeline>,
}

impl Skin {
    /// Leaves out triangles without area.
    pub fn of(mesh: &TriangleMesh) -> Self {
        let normal =
            |corners: &[Vector; 3]| twice_area(corners).try_normalize(0.0).filter(|n| n.iter().all(|x| x.is_finite()));
        let normals: Vec<Option<Vector>> = mesh.all_corners().map(|corners| normal(&corners)).collect();
        let around = corners_around(mesh, &normals);
        let mut skin = Self { bounds: mesh.bounds(), edges: sharp_edges(mesh, &normals), ..Self::default() };
        // A vertex is copied for each different normal.
        let mut copies: Vec<Vec<u32>> = vec![Vec::new(); mesh.vertices.len()];
        for (triangle, own) in mesh.triangles.iter().zip(&normals) {
            let Some(own) = own else { continue };
            let corner = |vertex: u32| {
                let place = vertex as usize;
                let mut sum = Vector::zeros();
                for (normal, weight) in around.get(place).into_iter().flatten() {
                    let cosine = normal.dot(own);
                    if cosine.abs() > SMOOTH {
                        sum += normal * (weight * cosine.signum());
                    }
                }
                let mean = sum.try_normalize(0.0).unwrap_or(*own);
                let known = copies.get_mut(place)?;
                let same = known.iter().find(|copy| skin.normals.get(**copy as usize) == Some(&mean));
                if let Some(same) = same {
                    return Some(*same);
                }
                let copy = id(skin.vertices.len());
                known.push(copy);
                skin.vertices.push(*mesh.vertices.get(place)?);
                skin.normals.push(mean);
                Some(copy)
            };
            if let [Some(a), Some(b), Some(c)] = triangle.map(corner) {
                skin.triangles.push([a, b, c]);
            }
        }
        skin
    }

    /// Whether this surface is present. The argument tells which surfaces of the scene are present.
    pub fn is_among(&self, surfaces: &[bool]) -> bool {
        self.number.and_then(|number| surfaces.get(number)).copied().unwrap_or(true)
    }

    pub fn bounds_at(&self, time: f64) -> [Vector; 2] {
        let Some(timeline) = &self.timeline else { return self.bounds };
        let (pose, [lower, upper]) = (timeline.at(time).pose, self.bounds);
        let places = corners(&lower, &(upper - lower)).map(|corner| [pose.place(&corner); 2]);
        places.into_iter().fold(places[0], joined)
    }

    pub fn at(&self, time: f64) -> Self {
        let Some(timeline) = &self.timeline else { return self.clone() };
        let pose = timeline.at(time).pose;
        let vertices: Vec<Vector> = self.vertices.iter().map(|vertex| pose.place(vertex)).collect();
        Self {
            normals: self.normals.iter().map(|normal| pose.direction(normal)).collect(),
            triangles: self.triangles.clone(),
            edges: self.edges.iter().map(|ends| ends.map(|end| pose.place(&end))).collect(),
            bounds: vertices.iter().map(|vertex| [*vertex; 2]).reduce(joined).unwrap_or(self.bounds),
            vertices,
            number: self.number,
            timeline: None,
        }
    }

    #[cfg(test)]
    pub fn corners(&self, triangle: usize) -> [(Vector, Vector); 3] {
        self.triangles[triangle].map(|vertex| (self.vertices[vertex as usize], self.normals[vertex as usize]))
    }
}

/// Returns the normals of the triangles around each vertex, weighted by the angles of the triangles at the vertex.
fn corners_around(mesh: &TriangleMesh, normals: &[Option<Vector>]) -> Vec<Vec<(Vector, f64)>> {
    let mut around = vec![Vec::new(); mesh.vertices.len()];
    for ((triangle, corners), normal) in mesh.triangles.iter().zip(mesh.all_corners()).zip(normals) {
        let Some(normal) = normal else { continue };
        let [a, b, c] = corners;
        for (vertex, [at, one, other]) in triangle.iter().zip([[a, b, c], [b, c, a], [c, a, b]]) {
            if let Some(around) = around.get_mut(*vertex as usize) {
                around.push((*normal, (one - at).angle(&(other - at))));
            }
        }
    }
    around
}

/// Returns the rims and the sharp edges, or no edges if there are too many.
fn sharp_edges(mesh: &TriangleMesh, normals: &[Option<Vector>]) -> Vec<[Vector; 2]> {
    let normal = |side: &EdgeUse| normals.get(side.triangle as usize).copied().flatten();
    let is_sharp = |uses: &&[EdgeUse]| match uses {
        [one, other] => match (normal(one), normal(other)) {
            (Some(a), Some(b)) => a.dot(&b) * if one.is_forward == other.is_forward { -1.0 } else { 1.0 } < SMOOTH,
            _ => false,
        },
        _ => true,
    };
    let edges = mesh.edges();
    let sharp: Vec<[u32; 2]> =
        edges.iter().filter(is_sharp).filter_map(|uses| uses.first()).map(|side| side.ends).collect();
    if sharp.len() > MOST_EDGES {
        return Vec::new();
    }
    let place = |vertex: u32| mesh.vertices.get(vertex as usize).copied();
    sharp.iter().filter_map(|[a, b]| Some([place(*a)?, place(*b)?])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::revolution::revolution;

    #[test]
    fn normals_are_smooth_on_a_tube_and_flat_on_a_box() {
        let tube = revolution(&Vector::zeros(), &Vector::z(), &[[2.0, 0.0], [2.0, 5.0]], 0.02).unwrap();
        let skin = Skin::of(&tube);
        assert_eq!((skin.vertices.len(), skin.triangles.len()), (tube.vertices.len(), tube.triangles.len()));
        for (vertex, normal) in skin.vertices.iter().zip(&skin.normals) {
            assert!((normal - Vector::new(vertex.x, vertex.y, 0.0) / 2.0).norm() < 1e-6);
        }
        assert_eq!(skin.edges.len(), tube.vertices.len());
        let cube = Skin::of(&TriangleMesh::cuboid(&Vector::zeros(), &Vector::repeat(1.0)));
        assert_eq!((cube.vertices.len(), cube.edges.len()), (24, 12));
        for triangle in 0..12 {
            let corners = cube.corners(triangle);
            assert!(corners.iter().all(|(_, normal)| normal.amax() == 1.0 && *normal == corners[0].1));
        }
    }

    #[test]
    fn turned_triangles_shade_as_their_neighbours_do() {
        let mut tube = revolution(&Vector::zeros(), &Vector::z(), &[[2.0, 0.0], [2.0, 5.0]], 0.02).unwrap();
        tube.triangles.iter_mut().step_by(3).for_each(|[_, b, c]| std::mem::swap(b, c));
        let skin = Skin::of(&tube);
        assert_eq!(skin.edges.len(), tube.vertices.len());
        for (vertex, normal) in skin.vertices.iter().zip(&skin.normals) {
            assert!((normal.dot(&Vector::new(vertex.x, vertex.y, 0.0)) / 2.0).abs() > 0.999);
        }
    }

    #[test]
    fn invalid_triangles_are_omitted() {
        let vertices = vec![Vector::zeros(), Vector::x(), Vector::y(), Vector::repeat(f64::NAN)];
        let triangles = vec![[0, 1, 2], [0, 0, 1], [0, 1, 3], [0, 1, 9]];
        let skin = Skin::of(&TriangleMesh { vertices, triangles });
        assert_eq!(skin.triangles, [[0, 1, 2]]);
    }

    #[test]
    fn moving_skin_has_its_position_at_the_given_time() {
        use crate::model::{MotionKind, SurfaceMotion};
        let mut skin = Skin::of(&TriangleMesh::cuboid(&Vector::zeros(), &Vector::new(1.0, 2.0, 3.0)));
        assert_eq!(skin.at(7.0), skin, "at rest");
        let kind = MotionKind::Rotation { point: Vector::x(), axis: Vector::z(), frequency: 0.25 };
        skin.timeline = Some(Timeline::of(&[SurfaceMotion { from: 1.0, until: 2.0, kind }]));
        let bounds = |time: f64| skin.at(time).bounds;
        assert_eq!(bounds(1.0), [Vector::zeros(), Vector::new(1.0, 2.0, 3.0)]);
        // A quarter turn about the point (1, 0) moves `(x, y)` to `(1 - y, x - 1)`.
        assert_eq!(bounds(9.0), [Vector::new(-1.0, -1.0, 0.0), Vector::new(1.0, 0.0, 3.0)]);
        let turned = skin.at(9.0);
        let outwards = |normal: &Vector, place: &Vector| normal.dot(&(place - Vector::new(0.0, -0.5, 1.5))) > 0.0;
        assert!(turned.normals.iter().zip(&turned.vertices).all(|(normal, place)| outwards(normal, place)));
        assert!(turned.edges.iter().flatten().all(|end| turned.vertices.contains(end)));
    }
}
