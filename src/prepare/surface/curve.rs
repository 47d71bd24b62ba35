//! Curves of static disks: the walls of two-dimensional scenes.
//!
//! A moving disk passes between static disks with a spacing `d` only if the contact distance is less than `d / 2`.

use std::f64::consts::PI;

use super::{BoxSide, Layout, intervals};
use crate::Vector;
use crate::model::space::{Boundary, Space};

/// The two axes of a two-dimensional space; `None` in one or three dimensions.
pub(crate) fn plane_axes(space: &Space) -> Option<[usize; 2]> {
    let mut axes = (0..3).filter(|&axis| space.boundary[axis] != Boundary::Flat);
    match (axes.next(), axes.next(), axes.next()) {
        (Some(u), Some(v), None) => Some([u, v]),
        _ => None,
    }
}

pub(super) fn line(ends: &[Vector; 2], spacing: f64) -> Layout {
    let along = ends[1] - ends[0];
    let steps = intervals(along.norm(), spacing);
    let points = (0..=steps).map(|step| ends[0] + along * (step as f64 / steps as f64)).collect();
    Layout { points, hole: Some(0.5 * along.norm() / steps as f64), rims: vec![vec![0], vec![steps]] }
}

pub(super) fn ring(centre: &Vector, radius: f64, [u, v]: [usize; 2], spacing: f64) -> Layout {
    // Chords are shorter than arcs, so neighbours are at most `spacing` apart.
    let count = intervals(2.0 * PI * radius, spacing).max(3);
    let point = |k: usize| {
        let angle = 2.0 * PI * k as f64 / count as f64;
        let mut point = *centre;
        point[u] += radius * libm::cos(angle);
        point[v] += radius * libm::sin(angle);
        point
    };
    let hole = Some(radius * libm::sin(PI / count as f64));
    Layout { points: (0..count).map(point).collect(), hole, rims: Vec::new() }
}

pub(super) fn rectangle(lower: &Vector, upper: &Vector, open: &[BoxSide], axes: [usize; 2], spacing: f64) -> Layout {
    let size = axes.map(|axis| upper[axis] - lower[axis]);
    let steps = size.map(|edge| intervals(edge, spacing));
    let is_open = |k: usize, is_upper: bool| open.contains(&BoxSide { axis: axes[k], is_upper });
    let mut layout = Layout::default();
    for j in 0..=steps[1] {
        for i in 0..=steps[0] {
            let site = [i, j];
            let at_end = |k: usize, is_upper: bool| site[k] == if is_upper { steps[k] } else { 0 };
            let sides =
                || [(0, false), (0, true), (1, false), (1, true)].into_iter().filter(|&(k, end)| at_end(k, end));
            if !sides().any(|(k, end)| !is_open(k, end)) {
                continue;
            }
            // Each end of the curve is a rim of a single disk.
            layout.rims.extend(sides().filter(|&(k, end)| is_open(k, end)).map(|_| vec![layout.points.len()]));
            let mut point = *lower;
            for (k, &axis) in axes.iter().enumerate() {
                point[axis] += size[k] * (site[k] as f64 / steps[k] as f64);
            }
            layout.points.push(point);
        }
    }
    let edges = (0..2).filter(|&k| !(is_open(1 - k, false) && is_open(1 - k, true)));
    layout.hole = edges.map(|k| 0.5 * size[k] / steps[k] as f64).reduce(f64::max);
    layout
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::surface::{Surface, default_spacing};

    fn plane() -> Space {
        let mut space = Space::periodic_cube(20.0);
        space.boundary[1] = Boundary::Flat;
        space
    }

    fn at(x: f64, z: f64) -> Vector {
        Vector::new(x, 0.0, z)
    }

    fn check(shape: &Surface, spacing: f64, count: usize, along: &dyn Fn(f64) -> Vector) -> Layout {
        let layout = shape.layout(spacing, &plane());
        assert_eq!(layout.points.len(), count, "{shape:?}");
        assert!(shape.estimate(spacing) >= 0.5 * count as f64);
        let nearest = |point: Vector| layout.points.iter().map(|p| (p - point).norm()).fold(f64::INFINITY, f64::min);
        let widest = (0..=10_000).map(|k| nearest(along(f64::from(k) / 10_000.0))).fold(0.0, f64::max);
        let hole = layout.hole.unwrap();
        assert!(hole <= 0.5 * spacing * (1.0 + 1e-9), "{shape:?}: {hole}");
        // In a ring, the checked points lie on arcs, which are slightly farther from the disks than chords.
        assert!(
            widest >= 0.99 * hole && widest <= 1.05 * hole,
            "{shape:?}: the widest hole is {widest}, but {hole} was claimed"
        );
        layout
    }

    #[test]
    fn no_curve_has_a_gap_wider_than_it_claims() {
        let ends = [at(1.0, 2.0), at(4.0, 6.0)];
        let line = check(&Surface::Line { ends }, 0.8, 8, &|part| ends[0] + (ends[1] - ends[0]) * part);
        assert_eq!((line.points[0], line.points[7]), (ends[0], ends[1]));
        assert_eq!(line.rims, [vec![0], vec![7]]);
        check(&Surface::Ring { centre: at(5.0, 5.0), radius: 3.0 }, 1.0, 19, &|part| {
            let angle = 2.0 * PI * part;
            at(5.0 + 3.0 * angle.cos(), 5.0 + 3.0 * angle.sin())
        });
        let (lower, upper) = (at(0.0, 0.0), at(4.0, 2.0));
        let top = BoxSide { axis: 2, is_upper: true };
        let closed = Surface::Rectangle { lower, upper, open: Vec::new() };
        assert!(check(&closed, 1.0, 12, &|part| at(4.0 * part, 0.0)).rims.is_empty());
        let cup = Surface::Rectangle { lower, upper, open: vec![top] };
        let cup = check(&cup, 1.0, 9, &|part| at(4.0 * part, 0.0));
        let ends: Vec<Vector> = cup.rims.iter().map(|rim| cup.points[rim[0]]).collect();
        assert_eq!(ends, [at(0.0, 2.0), at(4.0, 2.0)]);
    }

    #[test]
    fn corner_belongs_to_the_closed_side() {
        let (lower, upper) = (at(0.0, 0.0), at(4.0, 2.0));
        let side = |axis, is_upper| BoxSide { axis, is_upper };
        let open = vec![side(0, false), side(0, true), side(2, true)];
        let floor = Surface::Rectangle { lower, upper, open }.layout(1.0, &plane());
        assert_eq!(floor.points, [0.0, 1.0, 2.0, 3.0, 4.0].map(|x| at(x, 0.0)));
        assert_eq!(floor.hole, Some(0.5));
        let open = vec![side(2, false), side(2, true)];
        let walls = Surface::Rectangle { lower, upper, open }.layout(0.5, &plane());
        assert_eq!((walls.points.len(), walls.rims.len(), walls.hole), (10, 4, Some(0.25)));
    }

    #[test]
    fn small_ring_becomes_a_triangle_and_default_spacing_is_tight() {
        let ring = |radius| Surface::Ring { centre: at(5.0, 5.0), radius };
        let triangle = ring(0.1).layout(10.0, &plane());
        assert_eq!(triangle.points.len(), 3);
        let spacing = ring(0.1).spacing(default_spacing(1.0));
        let holes = [ring(7.0).layout(spacing, &plane()).hole, ring(0.3).layout(spacing, &plane()).hole];
        assert!(holes.into_iter().flatten().all(|hole| hole < 0.66), "{holes:?}");
        assert!(ring(7.0).layout(2.1, &plane()).hole.unwrap() > 1.0);
    }
}
