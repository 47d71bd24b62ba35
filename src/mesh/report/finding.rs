use std::fmt;

use super::{EdgeFault, MOST_INTERSECTIONS, MOST_PAIRS, MeshReport, PairFault, TriangleFault};
use crate::Vector;
use crate::base::text::plural;

/// Fault of a mesh. The message names the first place where the fault occurs.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Finding {
    /// The mesh has no triangles.
    NoTriangle,
    /// A vertex is missing, not finite or too far away.
    Unusable(TriangleFault),
    /// The surface has an open edge, so it does not enclose a volume.
    Open(EdgeFault),
    /// More than two triangles meet at an edge.
    Crowded(EdgeFault),
    /// Adjacent triangles have normals on different sides of the surface.
    NotOriented(EdgeFault),
    /// Triangles have no area, so they have no normal.
    Degenerate(TriangleFault),
    /// Triangles are duplicated.
    Duplicates(PairFault),
    /// The surface intersects itself.
    SelfIntersections(PairFault),
    /// Too many triangles are close to each other, so not all pairs were tested.
    NotSearched,
}

pub(super) fn of(report: &MeshReport) -> Vec<Finding> {
    let is_left = report.triangles > 0 && report.unusable.count == 0 && !report.is_searched;
    let faults = [
        (usize::from(report.triangles == 0), Finding::NoTriangle),
        (report.unusable.count, Finding::Unusable(report.unusable)),
        (report.open_edges.count, Finding::Open(report.open_edges)),
        (report.crowded_edges.count, Finding::Crowded(report.crowded_edges)),
        (report.turned_edges.count, Finding::NotOriented(report.turned_edges)),
        (report.degenerate.count, Finding::Degenerate(report.degenerate)),
        (report.duplicates.count, Finding::Duplicates(report.duplicates)),
        (report.self_intersections.count, Finding::SelfIntersections(report.self_intersections)),
        (usize::from(is_left && report.self_intersections.count < MOST_INTERSECTIONS), Finding::NotSearched),
    ];
    faults.into_iter().filter(|(count, _)| *count > 0).map(|(_, finding)| finding).collect()
}

impl Finding {
    /// Returns advice on how to repair the mesh.
    #[must_use]
    pub fn cure(&self) -> &'static str {
        match self {
            Self::NoTriangle => "export a surface with triangles",
            Self::Unusable(_) => "export the mesh again: some vertices are missing or have invalid coordinates",
            Self::Open(_) => {
                "fill the holes, or merge vertices that should coincide; change nothing if the surface is meant to be open"
            }
            Self::Crowded(_) => "separate or unite bodies that touch along an edge, and delete faces inside the bodies",
            Self::NotOriented(_) => "recalculate the normals of the mesh, so that all point outwards",
            Self::Degenerate(_) => "dissolve faces of zero area, or merge vertices by distance",
            Self::Duplicates(_) => "delete one of the faces",
            Self::SelfIntersections(_) => "unite overlapping bodies with a boolean operation, or move them apart",
            Self::NotSearched => {
                "remesh the surface with triangles whose edges have similar lengths, and check it again"
            }
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoTriangle => write!(f, "the mesh has no triangle"),
            Self::Unusable(fault) => {
                write!(f, "{} has a vertex that is missing, not finite or too far away", First(fault.first))
            }
            Self::Open(fault) => edges(f, fault, "on one triangle only: the surface has a rim"),
            Self::Crowded(fault) => edges(f, fault, "on more than two triangles"),
            Self::NotOriented(fault) => {
                edges(f, fault, "between triangles whose normals point to opposite sides of the surface")
            }
            Self::Degenerate(fault) => {
                let (are, all) = (is_or_are(fault.count), plural(fault.count, "triangle"));
                write!(f, "{all} {are} of zero area, first {}", First(fault.first))
            }
            Self::Duplicates(fault) => {
                let all = plural(fault.count, "triangle");
                write!(f, "{all} with the same vertices as another triangle, first {}", Pair(fault.first))
            }
            Self::NotSearched => write!(
                f,
                "only the first {MOST_PAIRS} pairs of triangles were checked for self-intersections and distances: too many triangles are long and thin"
            ),
            Self::SelfIntersections(fault) => {
                let least = if fault.count == MOST_INTERSECTIONS { "at least " } else { "" };
                let all = plural(fault.count, "pair");
                write!(f, "{least}{all} of triangles intersect or overlap, first {}", Pair(fault.first))
            }
        }
    }
}

fn edges(f: &mut fmt::Formatter<'_>, fault: &EdgeFault, what: &str) -> fmt::Result {
    write!(f, "{} {} {what}", plural(fault.count, "edge"), is_or_are(fault.count))?;
    let Some([from, to]) = fault.first else { return Ok(()) };
    let place = |v: &Vector| format!("({}, {}, {})", v.x, v.y, v.z);
    write!(f, ", first from {} to {}", place(&from), place(&to))
}

fn is_or_are(count: usize) -> &'static str {
    if count == 1 { "is" } else { "are" }
}

struct First(Option<usize>);

impl fmt::Display for First {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |number| write!(f, "triangle {number} (from 0)"))
    }
}

struct Pair(Option<[usize; 2]>);

impl fmt::Display for Pair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |[one, other]| write!(f, "triangles {one} and {other} (from 0)"))
    }
}
