//! Surfaces made of static spheres, arranged so that they do not leak.
//!
//! A moving sphere passes through a hole only if its contact distance is less than the circumradius `R` of the hole.
//! `R` is the distance from the middle of the hole to the nearest static spheres.
//!
//! Spheres are placed in rows, with the spacing `d` in a row and the distance `h` between rows. All holes then have `R
//! <= sqrt(d^2 + h^2) / 2`, for any shift of the rows. Proof: the middle of a hole is at most `h / 2` from the nearest
//! row, and the circle of radius `R` around it cuts this row in a chord of at most `d`.

pub(crate) mod curve;
pub(crate) mod leak;

use std::collections::BTreeSet;
use std::f64::consts::{SQRT_2, TAU};

use crate::Vector;
use crate::base::numbers::trunc_to_usize;
use crate::model::{Space, Species, SpeciesId};
use crate::prepare::packing::occupancy::Contacts;

/// Default circumradius of the holes, relative to the contact distance. Particles sink into the surface by at most `1 -
/// sqrt(1 - 0.65^2) = 24 %` of the contact distance.
const HOLE_TO_CONTACT: f64 = 0.65;

/// Default spacing of a square grid for a surface of this species `[length]`. No moving particle fits through a hole.
pub(crate) fn tight_spacing(surface: SpeciesId, species: &[Species], contacts: &Contacts) -> f64 {
    // The species with the shortest contact distance would leak first.
    let moving = (0..species.len()).filter(|&other| !species[other].is_static());
    let contacts = moving.map(|other| contacts.smallest(other, surface.0 as usize)).filter(|contact| *contact > 0.0);
    default_spacing(contacts.reduce(f64::min).unwrap_or(species[surface.0 as usize].diameter))
}

/// Spacing of a square grid whose holes are [`HOLE_TO_CONTACT`] times the contact distance `[length]`.
fn default_spacing(contact: f64) -> f64 {
    HOLE_TO_CONTACT * contact * SQRT_2
}

/// One side of a box or rectangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct BoxSide {
    /// Index of the axis normal to the side: 0, 1 or 2.
    pub axis: usize,
    /// Whether the side is at the upper end of this axis.
    pub is_upper: bool,
}

impl BoxSide {
    pub(crate) const ALL: [Self; 6] = [
        Self { axis: 0, is_upper: false },
        Self { axis: 0, is_upper: true },
        Self { axis: 1, is_upper: false },
        Self { axis: 1, is_upper: true },
        Self { axis: 2, is_upper: false },
        Self { axis: 2, is_upper: true },
    ];
}

/// Shape of a surface made of static spheres. Positions and sizes are in `[length]`.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Surface {
    /// A parallelogram.
    Plane {
        /// One corner.
        corner: Vector,
        /// The two edges that start at `corner`.
        edges: [Vector; 2],
    },
    /// The sides of a box, except the open ones.
    Box {
        /// Lower corner.
        lower: Vector,
        /// Upper corner.
        upper: Vector,
        /// Open sides of the box, without spheres.
        open: Vec<BoxSide>,
    },
    /// A conical frustum without ends: a funnel, or a cylinder if the radii are equal.
    Cone {
        /// Centre of the first end of the cone.
        base: Vector,
        /// Direction from the first end of the cone to the second, of any length.
        axis: Vector,
        /// Radii at the first and the second end.
        radii: [f64; 2],
        /// Distance between the two ends along the axis.
        length: f64,
    },
    /// A hollow sphere.
    Sphere {
        /// Centre of the sphere.
        centre: Vector,
        /// Radius of the sphere.
        radius: f64,
    },
    /// A straight line of disks in a plane, from one end to the other.
    Line {
        /// The two ends of the line.
        ends: [Vector; 2],
    },
    /// A closed circle of disks in a plane.
    Ring {
        /// Centre of the circle.
        centre: Vector,
        /// Radius of the circle.
        radius: f64,
    },
    /// The sides of a rectangle of disks in a plane, except the open ones.
    Rectangle {
        /// Lower corner.
        lower: Vector,
        /// Upper corner.
        upper: Vector,
        /// Open sides of the rectangle, without spheres.
        open: Vec<BoxSide>,
    },
    /// Spheres at given positions.
    Points(Vec<Vector>),
}

#[derive(Debug, Clone, Default)]
pub(crate) struct Layout {
    pub points: Vec<Vector>,
    /// Largest circumradius of a hole; `None` if the spheres do not form a surface.
    pub hole: Option<f64>,
    /// Indices of the spheres along each open edge of the surface.
    pub rims: Vec<Vec<usize>>,
}

impl Surface {
    /// Approximate number of spheres, at least half of the true number. Very large surfaces are rejected early.
    pub(crate) fn estimate(&self, spacing: f64) -> f64 {
        let patch = |a: f64, b: f64| (a / spacing + 2.0) * (b / spacing + 2.0);
        match self {
            Self::Plane { edges: [a, b], .. } => patch(a.norm(), b.norm()),
            Self::Box { lower, upper, .. } => {
                let size = upper - lower;
                2.0 * (patch(size.x, size.y) + patch(size.y, size.z) + patch(size.z, size.x))
            }
            Self::Cone { radii: [a, b], length, .. } => patch(TAU * a.max(*b), libm::hypot(*length, b - a)),
            Self::Sphere { radius, .. } => patch(TAU * radius, 0.5 * TAU * radius),
            Self::Line { ends } => (ends[1] - ends[0]).norm() / spacing + 2.0,
            Self::Ring { radius, .. } => TAU * radius / spacing + 3.0,
            Self::Rectangle { lower, upper, .. } => 2.0 * (upper - lower).sum() / spacing + 4.0,
            Self::Points(points) => points.len() as f64,
        }
    }

    pub(crate) fn is_plane_curve(&self) -> bool {
        matches!(self, Self::Line { .. } | Self::Ring { .. } | Self::Rectangle { .. })
    }

    /// Spacing at which the holes of this surface are as large as the holes of a square grid with the spacing
    /// `of_grid`. The radius of a hole is `d / 2` in a curve with the spacing `d`, and `d / sqrt(2)` in a grid.
    pub(crate) fn spacing(&self, of_grid: f64) -> f64 {
        if self.is_plane_curve() { SQRT_2 * of_grid } else { of_grid }
    }

    /// Places the spheres, with neighbours at most `spacing` apart. Curves in a plane need a two-dimensional space.
    pub(crate) fn layout(&self, spacing: f64, space: &Space) -> Layout {
        let axes = curve::plane_axes(space).unwrap_or([0, 1]);
        match self {
            Self::Plane { corner, edges } => plane(corner, edges, spacing),
            Self::Box { lower, upper, open } => sides(lower, upper, open, spacing),
            Self::Cone { base, axis, radii, length } => cone(base, axis, *radii, *length, spacing),
            Self::Sphere { centre, radius } => sphere(centre, *radius, spacing),
            Self::Line { ends } => curve::line(ends, spacing),
            Self::Ring { centre, radius } => curve::ring(centre, *radius, axes, spacing),
            Self::Rectangle { lower, upper, open } => curve::rectangle(lower, upper, open, axes, spacing),
            Self::Points(points) => Layout { points: points.clone(), ..Layout::default() },
        }
    }
}

/// Number of equal intervals of at most `spacing` in a length.
fn intervals(length: f64, spacing: f64) -> usize {
    // If the length is a multiple of the spacing, rounding must not add an interval.
    trunc_to_usize((length / spacing - 1e-9).ceil()).max(1)
}

fn plane(corner: &Vector, edges: &[Vector; 2], spacing: f64) -> Layout {
    let [columns, rows] = edges.map(|edge| intervals(edge.norm(), spacing));
    let (a, b) = (edges[0] / columns as f64, edges[1] / rows as f64);
    let mut layout = Layout { rims: vec![Vec::new(); 4], ..Layout::default() };
    for row in 0..=rows {
        for column in 0..=columns {
            for (edge, is_on_edge) in [row == 0, row == rows, column == 0, column == columns].into_iter().enumerate() {
                if is_on_edge {
                    layout.rims[edge].push(layout.points.len());
                }
            }
            layout.points.push(corner + a * column as f64 + b * row as f64);
        }
    }
    layout.hole = Some(hole_of_cell(&a, &b));
    layout
}

/// Circumradius of the holes in a grid of parallelograms with the edges `a` and `b`. The shorter diagonal `a - b`
/// divides a parallelogram into two triangles. If they are not obtuse, `R = |a| |b| |a - b| / (2 |a x b|)`.
fn hole_of_cell(a: &Vector, b: &Vector) -> f64 {
    let b = if a.dot(b) < 0.0 { -b } else { *b };
    let diagonal = a - b;
    let circumradius = a.norm() * b.norm() * diagonal.norm() / (2.0 * a.cross(&b).norm());
    let longest = a.norm().max(b.norm());
    if diagonal.norm_squared() + a.norm_squared().min(b.norm_squared()) >= longest * longest {
        circumradius
    } else {
        // Bound for shifted rows, `sqrt(d^2 + h^2) / 2`. The edge `|b|` is at least the distance `h` of the rows.
        0.5 * libm::hypot(a.norm(), b.norm())
    }
}

/// Sides of a box. Adjacent sides share the spheres on their common edge.
fn sides(lower: &Vector, upper: &Vector, open: &[BoxSide], spacing: f64) -> Layout {
    let size = upper - lower;
    let cells = [0, 1, 2].map(|k| intervals(size[k], spacing));
    let mut sites = BTreeSet::new();
    for side in BoxSide::ALL.iter().filter(|side| !open.contains(side)) {
        let (u, v) = ((side.axis + 1) % 3, (side.axis + 2) % 3);
        for i in 0..=cells[u] {
            for j in 0..=cells[v] {
                let mut site = [0; 3];
                site[side.axis] = if side.is_upper { cells[side.axis] } else { 0 };
                (site[u], site[v]) = (i, j);
                // Sites are sorted from bottom to top, so that ids increase with height.
                sites.insert([site[2], site[1], site[0]]);
            }
        }
    }
    let mut layout = Layout { rims: vec![Vec::new(); open.len()], ..Layout::default() };
    for [z, y, x] in sites {
        let site = [x, y, z];
        for (rim, side) in open.iter().enumerate() {
            if site[side.axis] == if side.is_upper { cells[side.axis] } else { 0 } {
                layout.rims[rim].push(layout.points.len());
            }
        }
        layout.points.push(Vector::from_fn(|k, _| lower[k] + size[k] * (site[k] as f64 / cells[k] as f64)));
    }
    let edge = |k: usize| size[k] / cells[k] as f64;
    layout.hole = BoxSide::ALL
        .iter()
        .filter(|side| !open.contains(side))
        .map(|side| 0.5 * libm::hypot(edge((side.axis + 1) % 3), edge((side.axis + 2) % 3)))
        .reduce(f64::max);
    layout
}

/// Returns a ring of spheres and the distance between neighbours. The ring is turned by `turn` times this distance.
/// Most holes are smaller if every second ring is turned by half the distance.
fn ring(centre: &Vector, [u, v]: &[Vector; 2], radius: f64, spacing: f64, turn: f64) -> (Vec<Vector>, f64) {
    let count = if radius > 0.0 { intervals(TAU * radius, spacing) } else { 1 };
    let points = (0..count)
        .map(|k| {
            let angle = TAU * (k as f64 + turn) / count as f64;
            centre + u * (radius * libm::cos(angle)) + v * (radius * libm::sin(angle))
        })
        .collect();
    (points, TAU * radius / count as f64)
}

fn across(axis: &Vector) -> [Vector; 2] {
    let least = if axis.x.abs() <= axis.y.abs() && axis.x.abs() <= axis.z.abs() {
        Vector::x()
    } else if axis.y.abs() <= axis.z.abs() {
        Vector::y()
    } else {
        Vector::z()
    };
    let u = axis.cross(&least).normalize();
    [u, axis.cross(&u).normalize()]
}

fn cone(base: &Vector, axis: &Vector, radii: [f64; 2], length: f64, spacing: f64) -> Layout {
    let axis = axis.normalize();
    let directions = across(&axis);
    let slant = libm::hypot(length, radii[1] - radii[0]);
    let rows = intervals(slant, spacing);
    let mut layout = Layout::default();
    let mut widest: f64 = 0.0;
    for row in 0..=rows {
        let part = row as f64 / rows as f64;
        let radius = radii[0] + (radii[1] - radii[0]) * part;
        let (points, step) =
            ring(&(base + axis * (length * part)), &directions, radius, spacing, 0.5 * (row % 2) as f64);
        if (row == 0 || row == rows) && radius > 0.0 {
            layout.rims.push((layout.points.len()..layout.points.len() + points.len()).collect());
        }
        layout.points.extend(points);
        widest = widest.max(step);
    }
    layout.hole = Some(0.5 * libm::hypot(widest, slant / rows as f64));
    layout
}

fn sphere(centre: &Vector, radius: f64, spacing: f64) -> Layout {
    let rows = intervals(0.5 * TAU * radius, spacing).max(2);
    let directions = [Vector::x(), Vector::y()];
    let mut layout = Layout::default();
    let mut widest: f64 = 0.0;
    for row in 0..=rows {
        let angle = 0.5 * TAU * row as f64 / rows as f64;
        let across = if row == 0 || row == rows { 0.0 } else { radius * libm::sin(angle) };
        let height = Vector::z() * (radius * libm::cos(angle));
        let (points, step) = ring(&(centre + height), &directions, across, spacing, 0.5 * (row % 2) as f64);
        layout.points.extend(points);
        widest = widest.max(step);
    }
    layout.hole = Some(0.5 * libm::hypot(widest, 0.5 * TAU * radius / rows as f64));
    layout
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::random::{Purpose, Random};

    fn nearest(points: &[Vector], at: &Vector) -> f64 {
        points.iter().map(|point| (point - at).norm()).fold(f64::INFINITY, f64::min)
    }

    fn check(surface: &Surface, spacing: f64, on_surface: impl Fn(&mut Random) -> Vector) {
        let layout = surface.layout(spacing, &Space::periodic_cube(1.0));
        let claimed = layout.hole.unwrap();
        assert!(claimed <= spacing / SQRT_2 + 1e-9, "{surface:?}: {claimed}");
        assert!(surface.estimate(spacing) >= 0.5 * layout.points.len() as f64);
        let mut random = Random::new(1, Purpose::Placement, 0);
        let mut widest: f64 = 0.0;
        for _ in 0..2000 {
            widest = widest.max(nearest(&layout.points, &on_surface(&mut random)));
        }
        assert!(widest <= claimed * 1.05, "{surface:?}: the widest hole is {widest}, but {claimed} was claimed");
        assert!(widest >= claimed * 0.75, "{surface:?}: the widest hole is {widest}, but {claimed} was claimed");
    }

    #[test]
    fn no_surface_has_a_hole_larger_than_it_claims() {
        let edges = [Vector::new(10.0, 0.0, 0.0), Vector::new(0.0, 7.0, 7.0)];
        check(&Surface::Plane { corner: Vector::zeros(), edges }, 1.0, |random| {
            edges[0] * random.uniform() + edges[1] * random.uniform()
        });
        let slanted = [Vector::new(10.0, 0.0, 0.0), Vector::new(7.0, 7.0, 0.0)];
        check(&Surface::Plane { corner: Vector::zeros(), edges: slanted }, 1.0, |random| {
            slanted[0] * random.uniform() + slanted[1] * random.uniform()
        });
        let upper = Vector::new(6.0, 5.0, 4.0);
        check(&Surface::Box { lower: Vector::zeros(), upper, open: Vec::new() }, 0.9, |random| {
            let mut at = Vector::from_fn(|k, _| upper[k] * random.uniform());
            at[0] = upper[0];
            at
        });
        let funnel = Surface::Cone { base: Vector::zeros(), axis: Vector::z(), radii: [3.0, 8.0], length: 6.0 };
        check(&funnel, 0.7, |random| {
            let part = random.uniform();
            let (radius, angle) = (3.0 + 5.0 * part, TAU * random.uniform());
            Vector::new(radius * angle.cos(), radius * angle.sin(), 6.0 * part)
        });
        check(&Surface::Sphere { centre: Vector::zeros(), radius: 5.0 }, 0.8, |random| {
            let direction = random.direction(&crate::model::space::Space::periodic_cube(1.0));
            direction * 5.0
        });
    }

    #[test]
    fn the_sides_of_a_box_share_their_edges_and_an_open_side_has_a_rim() {
        let top = BoxSide::ALL[5];
        let surface = Surface::Box { lower: Vector::zeros(), upper: Vector::repeat(3.0), open: vec![top] };
        let layout = surface.layout(1.0, &Space::periodic_cube(9.0));
        // The bottom has 4 x 4 spheres. Each of the three levels above has a ring of 12 spheres.
        assert_eq!(layout.points.len(), 16 + 3 * 12);
        assert_eq!(layout.rims.len(), 1);
        assert_eq!(layout.rims[0].len(), 12);
        assert!(layout.rims[0].iter().all(|&index| layout.points[index].z == 3.0));
    }

    #[test]
    fn default_spacing_is_tight_and_wider_spacing_is_not() {
        let plane = |spacing| {
            let edges = [Vector::x() * 20.0, Vector::y() * 20.0];
            let plane = Surface::Plane { corner: Vector::zeros(), edges };
            plane.layout(spacing, &Space::periodic_cube(9.0)).hole.unwrap()
        };
        assert!(plane(default_spacing(1.0)) < 0.7);
        assert!(plane(1.6) > 1.0);
    }
}
