//! Surfaces in words, and meshes looked at closely: what an engineer wants to know before a run.

use super::vector;
use crate::Vector;
use crate::base::text::{digits, listed, plural};
use crate::mesh::MeshReport;
use crate::mesh::report::{Finding, Inside, Orientation, Thinnest};
use crate::model::{MotionKind, Scene, SceneSurface, Species, SurfaceLaw, SurfaceMotion, SurfaceShape, TriangleMesh};

/// Beyond this ratio of its size to that of the particles, or of the box, a mesh probably has other units.
const OTHER_UNITS: f64 = 100.0;

/// A surface in a line: its shape, its law, and who meets it.
pub(super) fn surface(scene: &Scene, surface: &SceneSurface) -> String {
    let side = |is_inside: bool| if is_inside { ", met from inside" } else { "" };
    let shape = match &surface.shape {
        SurfaceShape::Plane { point, normal } => {
            format!("a plane through {}, normal {}", vector(point), vector(normal))
        }
        SurfaceShape::Sphere { centre, radius, is_inside } => {
            format!("a sphere of radius {} around {}{}", digits(*radius), vector(centre), side(*is_inside))
        }
        SurfaceShape::Cylinder { point, axis, radius, is_inside } => format!(
            "a cylinder of radius {} around the line through {} along {}{}",
            digits(*radius),
            vector(point),
            vector(axis),
            side(*is_inside)
        ),
        SurfaceShape::Capsule { ends: [start, end], radius } => {
            format!("a capsule of radius {} from {} to {}", digits(*radius), vector(start), vector(end))
        }
        SurfaceShape::Mesh(mesh) => {
            let [lower, upper] = mesh.bounds();
            format!("{} from {} to {}", plural(mesh.triangles.len(), "triangle"), vector(&lower), vector(&upper))
        }
    };
    let law = match surface.law {
        SurfaceLaw::Reflecting { restitution } => format!("restitution {restitution}"),
        SurfaceLaw::Thermal { temperature } => format!("temperature {}", digits(temperature)),
    };
    let names: Vec<&str> = surface.species.iter().map(|id| scene.species[id.0 as usize].name.as_str()).collect();
    let who = if names.is_empty() { String::new() } else { format!(", for {} only", listed(&names)) };
    let when = match surface.stages.as_slice() {
        [] => String::new(),
        stages => format!(", in {} only", listed(&stages.iter().map(String::as_str).collect::<Vec<_>>())),
    };
    let motions: Vec<String> = surface.motions.iter().map(motion).collect();
    let moves = if motions.is_empty() { String::new() } else { format!(", {}", motions.join(", ")) };
    format!("{}: {shape}, {law}{who}{when}{moves}", surface.name)
}

/// A motion in words: `moves with velocity (0, 0, 1) from t = 2 to 4`.
fn motion(motion: &SurfaceMotion) -> String {
    let how = match &motion.kind {
        MotionKind::Translation { velocity, acceleration } if *acceleration == Vector::zeros() => {
            format!("moves with velocity {}", vector(velocity))
        }
        MotionKind::Translation { velocity, acceleration } => {
            format!("moves with velocity {} and acceleration {}", vector(velocity), vector(acceleration))
        }
        MotionKind::Oscillation { amplitude, frequency, .. } => {
            format!("oscillates by {} with frequency {}", vector(amplitude), digits(*frequency))
        }
        MotionKind::Rotation { point, axis, frequency } => {
            format!("turns about {} through {} with frequency {}", vector(axis), vector(point), digits(*frequency))
        }
    };
    let until = if motion.until.is_finite() { format!(" to {}", digits(motion.until)) } else { String::new() };
    format!("{how} from t = {}{until}", digits(motion.from))
}

/// Lines about the meshes of a scene, and warnings: whether they are closed, volume, walls and gaps, faults, and what starts inside.
#[must_use]
pub fn meshes(scene: &Scene) -> (Vec<String>, Vec<String>) {
    let (mut lines, mut warnings) = (Vec::new(), Vec::new());
    for surface in &scene.surfaces {
        let SurfaceShape::Mesh(mesh) = &surface.shape else { continue };
        let report = MeshReport::of(mesh);
        lines.push(format!("{}: {}", surface.name, about(&report)));
        // A rim is a matter of fact: funnels have some.
        let faults = report.findings().into_iter().filter(|finding| !matches!(finding, Finding::Open(_)));
        warnings.extend(faults.map(|finding| format!("mesh `{}`: {finding}; {}", surface.name, finding.cure())));
        warnings.extend(other_units(scene, surface, mesh));
        warnings.extend(started_inside(scene, surface, mesh, &report));
    }
    (lines, warnings)
}

fn about(report: &MeshReport) -> String {
    let mut parts = Vec::new();
    parts.push(match (report.is_closed(), report.volume, report.orientation()) {
        (false, ..) if report.open_edges.count == 0 => "not closed".to_owned(),
        (false, ..) => format!("open, {} at its rim", plural(report.open_edges.count, "edge")),
        (true, Some(volume), Some(way)) => {
            let way = if way == Orientation::Outwards { "outwards" } else { "inwards" };
            format!("closed, looks {way}, encloses {}", digits(volume.abs()))
        }
        (true, ..) => "closed".to_owned(),
    });
    if report.parts > 1 {
        parts.push(format!("in {} parts", report.parts));
    }
    parts.push(format!("area {}", digits(report.area)));
    let thin = |what: &str, thinnest: &Thinnest| format!("{what} down to {}", digits(thinnest.distance));
    parts.extend(report.wall.iter().map(|wall| thin("walls", wall)));
    parts.extend(report.gap.iter().map(|gap| thin("gaps", gap)));
    if report.wall.is_none() && report.gap.is_none() {
        parts.extend(report.thinnest.iter().map(|thinnest| thin("distances", thinnest)));
    }
    parts.join(", ")
}

/// A mesh that is far smaller than the particles, or far larger than all that they fill.
fn other_units(scene: &Scene, surface: &SceneSurface, mesh: &TriangleMesh) -> Option<String> {
    let [lower, upper] = mesh.bounds();
    let size = (upper - lower).amax();
    let diameters =
        scene.species.iter().filter(|species| !species.is_static()).map(|species: &Species| species.diameter);
    let smallest = diameters.fold(f64::INFINITY, f64::min);
    let largest = scene.space.size.amax();
    let is_other = size * OTHER_UNITS < smallest || size > OTHER_UNITS * largest.max(smallest);
    is_other.then(|| {
        format!(
            "mesh `{}` is {} large, particles have diameters from {} on and the box is {}: its units may be others, see `scale`",
            surface.name,
            digits(size),
            digits(smallest),
            digits(largest)
        )
    })
}

/// Particles on both sides of a closed mesh.
fn started_inside(scene: &Scene, surface: &SceneSurface, mesh: &TriangleMesh, report: &MeshReport) -> Option<String> {
    report.volume?;
    let inside = Inside::of(mesh);
    let meeting = scene.particles.iter().filter(|particle| surface.meets(particle.species));
    let (all, within) = meeting.fold((0_usize, 0_usize), |(all, within), particle| {
        (all + 1, within + usize::from(inside.contains(&particle.position)))
    });
    (within > 0 && within < all).then(|| {
        format!("{} of {} start inside of mesh `{}`, the others outside", within, plural(all, "particle"), surface.name)
    })
}
