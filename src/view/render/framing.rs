//! The region shown by an image, and the edges of the box.

use super::camera::Extent;
use super::style::{Framing, Style};
use crate::Vector;
use crate::trajectory::Frame;
use crate::view::Surfaces;

/// Empty space along an axis is cropped only if the particles fill at least this fraction of the box length.
const FILLED: f64 = 0.34;

pub(super) fn framed(frame: &Frame, surfaces: &Surfaces, style: &Style) -> Vec<Extent> {
    let has_all = style.framing == Framing::Particles || frame.size.iter().all(|&edge| edge == 0.0);
    let mut framed: Vec<Extent> = particles(frame, has_all).collect();
    if !has_all {
        let (lower, size) = match style.framing {
            Framing::Fitted => fitted((frame.lower, frame.size), frame.periodic, &reach(frame, surfaces), style),
            _ => (frame.lower, frame.size),
        };
        framed.extend(corners(&lower, &size).map(|position| Extent { position, radius: 0.0 }));
    }
    with_surfaces(framed, surfaces)
}

/// Returns the particles in the box, or all particles.
fn particles(frame: &Frame, has_all: bool) -> impl Iterator<Item = Extent> {
    let upper = frame.lower + frame.size;
    let is_inside = move |position: &Vector| (0..3).all(|k| (frame.lower[k]..=upper[k]).contains(&position[k]));
    let particles = frame.particles.iter().filter(move |particle| has_all || is_inside(&particle.position));
    particles.map(|particle| Extent { position: particle.position, radius: particle.radius })
}

pub(in crate::view) fn with_surfaces(mut framed: Vec<Extent>, surfaces: &Surfaces) -> Vec<Extent> {
    if let Some(region) = framed.iter().map(Extent::corners).reduce(joined) {
        framed.extend(surfaces.framed(region).into_iter().map(|position| Extent { position, radius: 0.0 }));
    }
    framed
}

/// Returns the corners of the smallest box that contains two boxes, each given by its corners.
pub(in crate::view) fn joined([a, b]: [Vector; 2], [c, d]: [Vector; 2]) -> [Vector; 2] {
    [a.inf(&c), b.sup(&d)]
}

/// Returns the corners of a box. If bit `k` of an index is set, the corner is on the upper side along axis `k`.
pub(in crate::view) fn corners(lower: &Vector, size: &Vector) -> [Vector; 8] {
    std::array::from_fn(|index| Vector::from_fn(|k, _| lower[k] + if index >> k & 1 == 1 { size[k] } else { 0.0 }))
}

/// Returns the corners of a region with the particles in the box, and with surfaces that do not extend far beyond it.
pub(in crate::view) fn reach(frame: &Frame, surfaces: &Surfaces) -> [Vector; 2] {
    let particles = particles(frame, false).map(|particle| particle.corners());
    let surfaces = surfaces.framed([frame.lower, frame.lower + frame.size]).into_iter().map(|corner| [corner; 2]);
    particles.chain(surfaces).fold([Vector::repeat(f64::MAX), Vector::repeat(f64::MIN)], joined)
}

/// Crops a box to the region between the corners `from` and `to`. A box is given by its lower corner and its edges.
pub(in crate::view) fn fitted(
    (lower, size): (Vector, Vector),
    periodic: [bool; 3],
    [from, to]: &[Vector; 2],
    style: &Style,
) -> (Vector, Vector) {
    let (mut first, mut last) = (lower, lower + size);
    if style.has_box && size.iter().any(|edge| *edge == 0.0) {
        return (lower, size);
    }
    for axis in (0..3).filter(|&axis| !periodic[axis] && size[axis] > 0.0) {
        let [low, high] = [from[axis].max(lower[axis]), to[axis].min(lower[axis] + size[axis])];
        let down = style.gravity.map_or(0.0, |gravity| gravity[axis]);
        if high - low < FILLED * size[axis] {
            continue;
        }
        // Along gravity, only the top is cropped, so that a heap keeps its floor.
        if down > 0.0 || down == 0.0 && !style.has_box {
            first[axis] = low;
        }
        if down < 0.0 || down == 0.0 && !style.has_box {
            last[axis] = high;
        }
    }
    (first, last - first)
}

/// Returns the edges of the box with the outward normals of the adjacent sides. Edges of a flat box have no normals.
pub(super) fn box_edges(frame: &Frame) -> Vec<([Vector; 2], Vec<Vector>)> {
    let corners = corners(&frame.lower, &frame.size);
    let is_solid = (0..3).all(|axis| !frame.is_flat(axis));
    let mut edges = Vec::new();
    for axis in (0..3).filter(|&axis| !frame.is_flat(axis)) {
        let is_start =
            |index: &usize| index >> axis & 1 == 0 && (0..3).all(|k| !frame.is_flat(k) || index >> k & 1 == 0);
        edges.extend((0..8).filter(is_start).map(|index| {
            let normal = |k: usize| Vector::ith(k, if index >> k & 1 == 1 { 1.0 } else { -1.0 });
            let sides = (0..3).filter(|&k| is_solid && k != axis).map(normal).collect();
            ([corners[index], corners[index | 1 << axis]], sides)
        }));
    }
    edges
}
