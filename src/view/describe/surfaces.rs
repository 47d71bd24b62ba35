use super::{contact_law, vector};
use crate::Vector;
use crate::base::text::{digits, listed, plural};
use crate::mesh::MeshReport;
use crate::mesh::report::{Finding, Inside, Orientation, Thinnest};
use crate::model::space::{AXES, Boundary, Face};
use crate::model::{
    MotionKind, Scene, SceneSurface, SpeciesId, SurfaceLaw, SurfaceMotion, SurfaceShape, SurfaceVelocity, TriangleMesh,
};

/// If a mesh is smaller than the particles or larger than the box by this factor, its units are probably wrong.
const OTHER_UNITS: f64 = 100.0;

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
        SurfaceLaw::Reflecting(law) => contact_law(&law),
        SurfaceLaw::Thermal { temperature } => format!("temperature {}", digits(temperature)),
        SurfaceLaw::Outlet => "an outlet".to_owned(),
    };
    let names: Vec<&str> = surface.species.iter().map(|id| scene.species[id.0 as usize].name.as_str()).collect();
    let who = if names.is_empty() { String::new() } else { format!(", for {} only", listed(&names)) };
    let when = match surface.stages.as_slice() {
        [] => String::new(),
        stages => format!(", in {} only", listed(&stages.iter().map(String::as_str).collect::<Vec<_>>())),
    };
    let motions: Vec<String> = surface.motions.iter().map(motion).collect();
    let moves = if motions.is_empty() { String::new() } else { format!(", {}", motions.join(", ")) };
    let material = surface.surface_velocity.as_ref().map(material).unwrap_or_default();
    format!("{}: {shape}, {law}{who}{when}{moves}{material}", surface.name)
}

fn material(velocity: &SurfaceVelocity) -> String {
    match velocity {
        SurfaceVelocity::Translation { velocity } => {
            format!(", its material moves with velocity {}", vector(velocity))
        }
        SurfaceVelocity::Rotation { point, axis, frequency } => format!(
            ", its material turns about {} through {} with frequency {}",
            vector(axis),
            vector(point),
            digits(*frequency)
        ),
    }
}

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

/// Describes the meshes of a scene: volume, area, walls and gaps. Also returns warnings, for example about faults,
/// wrong units, or particles that start inside.
#[must_use]
pub fn meshes(scene: &Scene) -> (Vec<String>, Vec<String>) {
    let (mut lines, mut warnings) = (Vec::new(), Vec::new());
    let sizes = scene.diameters_of_species();
    for surface in &scene.surfaces {
        let SurfaceShape::Mesh(mesh) = &surface.shape else { continue };
        let report = MeshReport::of(mesh);
        let species = (0..).map(SpeciesId).zip(&sizes).zip(scene.occurring_species());
        let meeting = species.filter(|((id, _), occurs)| *occurs && surface.meets(*id));
        let largest = meeting.map(|((_, sizes), _)| sizes.largest).fold(0.0, f64::max);
        lines.push(format!("{}: {}", surface.name, about(&report, largest)));
        // An open rim is not a fault. For example, funnels have one.
        let faults = report.findings().into_iter().filter(|finding| !matches!(finding, Finding::Open(_)));
        warnings.extend(faults.map(|finding| format!("mesh `{}`: {finding}; {}", surface.name, finding.cure())));
        warnings.extend(nearly_closed(surface, mesh, &report));
        warnings.extend(other_units(scene, surface, mesh));
        warnings.extend(started_inside(scene, surface, mesh, &report));
    }
    let merged = scene.inputs.iter().filter(|input| input.merged_vertices > 0);
    lines.extend(merged.map(|input| {
        format!(
            "{}: {} merged with others nearby, because of `weld`",
            input.path,
            plural(input.merged_vertices, "corner")
        )
    }));
    (lines, warnings)
}

/// Vertices closer than this fraction of the size of a mesh are probably the same vertex.
const NEARLY: f64 = 1e-6;

fn nearly_closed(surface: &SceneSurface, mesh: &TriangleMesh, report: &MeshReport) -> Option<String> {
    let open = report.open_edges.count;
    if open == 0 {
        return None;
    }
    let [lower, upper] = mesh.bounds();
    let (merged, count) = mesh.merged(NEARLY * (upper - lower).amax());
    let left = if count > 0 { merged.edges().iter().filter(|uses| uses.len() == 1).count() } else { open };
    (left < open).then(|| {
        format!(
            "mesh `{}`: {} of the {open} edges at its rim would close if vertices within 1e-6 of its extent were merged: add weld = 1e-6",
            surface.name,
            open - left
        )
    })
}

/// Warns of surfaces that no particle can touch, and of motions without effect.
#[must_use]
pub fn idle_surfaces(scene: &Scene) -> Vec<String> {
    let mut warnings = Vec::new();
    for surface in &scene.surfaces {
        if let Some(axis) = beyond_walls(scene, surface) {
            warnings.push(format!("surface `{}` is beyond the walls of {axis}: no particle meets it", surface.name));
        }
        let is_smooth = surface.law.contact().is_some_and(|law| law.roughness.is_none()) && surface.moves();
        if is_smooth && surface.motions.iter().all(|motion| is_along_itself(&surface.shape, motion)) {
            warnings.push(format!(
                "surface `{}` moves only along itself, which has no effect on smooth spheres",
                surface.name
            ));
        }
    }
    warnings
}

fn beyond_walls(scene: &Scene, surface: &SceneSurface) -> Option<&'static str> {
    if surface.moves() {
        return None;
    }
    let [lower, upper] = match &surface.shape {
        SurfaceShape::Mesh(mesh) => mesh.bounds(),
        SurfaceShape::Capsule { ends: [start, end], radius } => {
            [start.inf(end).add_scalar(-radius), start.sup(end).add_scalar(*radius)]
        }
        SurfaceShape::Sphere { centre, radius, is_inside: false } => {
            [centre.add_scalar(-radius), centre.add_scalar(*radius)]
        }
        _ => return None,
    };
    let space = &scene.space;
    let has_wall = |face: &Face| matches!(face, Face::Wall(_));
    let is_beyond = |axis: usize| match &space.boundary[axis] {
        Boundary::Bounded { lower: below, upper: above } => {
            (has_wall(below) && upper[axis] < space.lower[axis])
                || (has_wall(above) && lower[axis] > space.upper()[axis])
        }
        _ => false,
    };
    (0..3).find(|&axis| is_beyond(axis)).map(|axis| AXES[axis])
}

const ROUNDING: f64 = 1e-12;

/// Whether a motion maps a surface onto itself. For example, a plane may slide along itself.
fn is_along_itself(shape: &SurfaceShape, motion: &SurfaceMotion) -> bool {
    let are_parallel = |a: &Vector, b: &Vector| a.cross(b).norm() <= ROUNDING * a.norm() * b.norm();
    let are_across = |a: &Vector, b: &Vector| a.dot(b).abs() <= ROUNDING * a.norm() * b.norm();
    let is_along = |direction: &Vector| match shape {
        SurfaceShape::Plane { normal, .. } => are_across(direction, normal),
        SurfaceShape::Cylinder { axis, .. } => are_parallel(direction, axis),
        _ => direction.norm() == 0.0,
    };
    match &motion.kind {
        MotionKind::Translation { velocity, acceleration } => is_along(velocity) && is_along(acceleration),
        MotionKind::Oscillation { amplitude, frequency, .. } => *frequency == 0.0 || is_along(amplitude),
        MotionKind::Rotation { frequency, .. } if *frequency == 0.0 => true,
        MotionKind::Rotation { point, axis, .. } => {
            let is_on_axis = |place: &Vector| are_parallel(&(place - point), axis) || (place - point).norm() == 0.0;
            match shape {
                SurfaceShape::Plane { normal, .. } => are_parallel(normal, axis),
                SurfaceShape::Sphere { centre, .. } => is_on_axis(centre),
                SurfaceShape::Cylinder { point: own, axis: along, .. } => are_parallel(along, axis) && is_on_axis(own),
                _ => false,
            }
        }
    }
}

/// `largest` is the diameter of the largest particle that can touch the mesh.
fn about(report: &MeshReport, largest: f64) -> String {
    let mut parts = Vec::new();
    parts.push(match (report.is_closed(), report.volume, report.orientation()) {
        (false, ..) if report.open_edges.count == 0 => "not closed".to_owned(),
        (false, ..) => format!("open, {} at its rim", plural(report.open_edges.count, "edge")),
        (true, Some(volume), Some(way)) => {
            let way = if way == Orientation::Outwards { "outwards" } else { "inwards" };
            format!("closed, normals point {way}, encloses {}", digits(volume.abs()))
        }
        (true, ..) => "closed".to_owned(),
    });
    if report.parts > 1 {
        parts.push(format!("in {} parts", report.parts));
    }
    parts.push(format!("area {}", digits(report.area)));
    let thin = |what: &str, thinnest: &Thinnest| format!("{what} down to {}", digits(thinnest.distance));
    parts.extend(report.wall.iter().map(|wall| thin("walls", wall)));
    let narrow = report.gap.iter().filter(|gap| gap.distance < largest);
    parts.extend(narrow.map(|gap| thin("gaps", gap)));
    if report.wall.is_none() && report.gap.is_none() {
        parts.extend(report.thinnest.iter().map(|thinnest| thin("distances", thinnest)));
    }
    parts.join(", ")
}

fn other_units(scene: &Scene, surface: &SceneSurface, mesh: &TriangleMesh) -> Option<String> {
    let [lower, upper] = mesh.bounds();
    let size = (upper - lower).amax();
    let ranges = scene.diameters_of_species();
    let moving = scene.species.iter().zip(&ranges).filter(|(species, _)| !species.is_static());
    let smallest = moving.map(|(_, range)| range.smallest).fold(f64::INFINITY, f64::min);
    let largest = scene.space.size.amax();
    let is_other = size * OTHER_UNITS < smallest || size > OTHER_UNITS * largest.max(smallest);
    is_other.then(|| {
        format!(
            "mesh `{}` has an extent of {}, the smallest diameter is {} and the box is {}: its units may differ, see `scale`",
            surface.name,
            digits(size),
            digits(smallest),
            digits(largest)
        )
    })
}

fn started_inside(scene: &Scene, surface: &SceneSurface, mesh: &TriangleMesh, report: &MeshReport) -> Option<String> {
    report.volume?;
    let inside = Inside::of(mesh);
    let meeting = scene.particles.iter().filter(|particle| surface.meets(particle.species));
    let (all, within) = meeting.fold((0_usize, 0_usize), |(all, within), particle| {
        (all + 1, within + usize::from(inside.contains(&particle.position)))
    });
    (within > 0 && within < all).then(|| {
        format!("{} of {} start inside mesh `{}`, the others outside", within, plural(all, "particle"), surface.name)
    })
}
