use serde::Serialize;

use crate::Vector;
use crate::base::numbers::trunc_to_u16;
use crate::view::surfaces::{Skin, Surfaces};

/// Largest number of triangles on a page: one or two megabytes.
pub(in crate::view) const MOST_TRIANGLES: usize = 50_000;

/// Number of steps along each edge of the box around all surfaces.
const STEPS: f64 = 65_535.0;

#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::view) struct SurfaceHead {
    pub triangles: usize,
    pub edges: usize,
    pub vertices: usize,
    /// Numbers of triangles, edges and vertices of each surface.
    pub parts: Vec<[usize; 3]>,
    pub lower: [f64; 3],
    pub size: [f64; 3],
}

#[derive(Debug, Clone, PartialEq)]
pub(in crate::view) struct SurfaceData {
    pub head: SurfaceHead,
    /// Little-endian bytes: three vertex indices (u32) per triangle, positions (u16) of the ends of each edge and of
    /// each vertex, and a normal (i8) per vertex. Positions are in units of 1 / `STEPS` of the box.
    pub bytes: Vec<u8>,
}

impl SurfaceData {
    pub fn of(surfaces: &Surfaces) -> Option<Self> {
        let skins = &surfaces.skins;
        let lower = skins.iter().map(|skin| skin.bounds[0]).reduce(|a, b| a.inf(&b))?;
        let size = skins.iter().map(|skin| skin.bounds[1]).reduce(|a, b| a.sup(&b))? - lower;
        let count = |number: fn(&Skin) -> usize| skins.iter().map(number).sum();
        let head = SurfaceHead {
            triangles: count(|skin| skin.triangles.len()),
            edges: count(|skin| skin.edges.len()),
            vertices: count(|skin| skin.vertices.len()),
            parts: skins.iter().map(|skin| [skin.triangles.len(), skin.edges.len(), skin.vertices.len()]).collect(),
            lower: lower.into(),
            size: size.into(),
        };
        let mut bytes = Vec::with_capacity(12 * (head.triangles + head.edges + head.vertices));
        let mut first = 0;
        for skin in skins {
            let corners = skin.triangles.iter().flatten();
            bytes.extend(corners.flat_map(|corner| corner.saturating_add(first).to_le_bytes()));
            first = u32::try_from(skin.vertices.len()).unwrap_or(u32::MAX).saturating_add(first);
        }
        let steps = |position: &Vector| {
            let fraction = |k: usize| if size[k] > 0.0 { (position[k] - lower[k]) / size[k] } else { 0.0 };
            [0, 1, 2].map(|k| trunc_to_u16((fraction(k) * STEPS).round()).to_le_bytes())
        };
        let edges = skins.iter().flat_map(|skin| skin.edges.iter().flatten());
        let places = edges.chain(skins.iter().flat_map(|skin| &skin.vertices));
        bytes.extend(places.flat_map(steps).flatten());
        let normals = skins.iter().flat_map(|skin| skin.normals.iter().flatten());
        // The bits of a signed byte from -127 to 127.
        bytes.extend(normals.map(|x| (trunc_to_u16((127.0 * x).round() + 256.0) & 255).to_le_bytes()[0]));
        Some(Self { head, bytes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::TriangleMesh;

    #[test]
    fn positions_and_normals_are_stored_within_quantisation_step() {
        let cube = TriangleMesh::cuboid(&Vector::new(-1.0, 2.0, 0.0), &Vector::new(3.0, 5.0, 1.0));
        let far = TriangleMesh::cuboid(&Vector::new(7.3, 2.1, 0.4), &Vector::new(8.0, 2.5, 0.6));
        let surfaces = Surfaces::of([&cube, &far]);
        let SurfaceData { head, bytes } = SurfaceData::of(&surfaces).unwrap();
        assert_eq!((head.triangles, head.edges, head.vertices), (24, 24, 48));
        assert_eq!(head.parts, [[12, 12, 24]; 2]);
        assert_eq!((head.lower, head.size), ([-1.0, 2.0, 0.0], [9.0, 3.0, 1.0]));
        assert_eq!(bytes.len(), 24 * 12 + 24 * 12 + 48 * 9);
        let corner = |k: usize| u32::from_le_bytes(bytes[4 * k..4 * k + 4].try_into().unwrap()) as usize;
        let place = |k: usize| {
            Vector::from_fn(|axis, _| {
                let at = 24 * 24 + 6 * k + 2 * axis;
                head.lower[axis] + f64::from(u16::from_le_bytes([bytes[at], bytes[at + 1]])) / STEPS * head.size[axis]
            })
        };
        let normal = |k: usize| {
            Vector::from_fn(|axis, _| f64::from(bytes[24 * 24 + 48 * 6 + 3 * k + axis].cast_signed()) / 127.0)
        };
        for (triangle, corners) in cube.all_corners().chain(far.all_corners()).enumerate() {
            let up = crate::model::triangle_mesh::twice_area(&corners).normalize();
            for (k, expected) in corners.iter().enumerate() {
                let vertex = corner(3 * triangle + k);
                assert!(
                    (place(vertex) - expected).component_div(&Vector::from(head.size)).amax() <= 0.5 / STEPS + 1e-9
                );
                assert!((normal(vertex) - up).amax() < 1e-9);
            }
        }
    }

    #[test]
    fn no_surfaces_are_no_data() {
        assert_eq!(SurfaceData::of(&Surfaces::default()), None);
    }
}
