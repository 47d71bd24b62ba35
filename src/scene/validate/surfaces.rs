use super::motions::{check_motions, check_surface_velocity};
use crate::Vector;
use crate::base::numbers::id;
use crate::base::text::shortest;
use crate::engine::surfaces::{MOST_FEATURES, Surfaces};
use crate::model::diameters::diameters_of_newcomers;
use crate::model::run_plan::MEASUREMENT;
use crate::model::space::{AXES, Boundary, Space};
use crate::model::{Inlet, SceneSurface, Species, SpeciesId, SurfaceLaw, SurfaceMotion, SurfaceShape, TriangleMesh};
use crate::scene::builder::SceneBuilder;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, refuse, unknown};
use crate::scene::interactions::species_named;
use crate::scene::limits::{contact_law, direction, finite_vector, not_negative, positive};
use crate::scene::names::{self, Taken};
use crate::scene::surface_draft::SurfaceDraft;
use crate::scene::validate::start::Configuration;

/// Smallest ratio of a particle's radius to the largest coordinate of a surface. It keeps round-off below the radius.
const LEAST_RADIUS: f64 = 1e-9;

impl SceneBuilder {
    pub(in crate::scene) fn checked_surfaces(
        &self,
        species: &[Species],
        space: &Space,
    ) -> Result<Surfaces, SceneError> {
        let drafts = self.surfaces.iter().enumerate().map(|(index, draft)| self.resolved(draft, index, species));
        let surfaces =
            self.parts.surfaces.iter().cloned().map(Ok).chain(drafts).collect::<Result<Vec<SceneSurface>, _>>()?;
        let mut taken = Taken::default();
        let mut features = 0;
        for (index, surface) in surfaces.iter().enumerate() {
            let at = ConfigPath::entry("surface", index);
            names::words(&surface.name, &at.key("name"))?;
            taken.take(&surface.name, &at)?;
            check_law(surface.law, &at)?;
            check_shape(&surface.shape, &at)?;
            check_space(&surface.shape, space, &at)?;
            check_radii(surface, species, &at)?;
            self.check_stages(&surface.stages, &at)?;
            check_motions(surface, space, &at)?;
            check_surface_velocity(surface, space, &at)?;
            if let SurfaceShape::Mesh(mesh) = &surface.shape {
                features += mesh.triangles.len();
            }
        }
        if features > MOST_FEATURES {
            let at = ConfigPath::root().key("surface");
            return refuse(
                at,
                format!("{features} triangles"),
                format!("at most {MOST_FEATURES} in all meshes together"),
            );
        }
        let ids: Vec<SpeciesId> = (0..species.len()).map(|index| SpeciesId(id(index))).collect();
        let stage = self.parts.run.first_stage();
        Ok(Surfaces::of_parts((space, &self.parts.wall_temperatures, self.parts.start_time), &surfaces, &ids, stage))
    }

    fn check_stages(&self, named: &[String], at: &ConfigPath) -> Result<(), SceneError> {
        let mut named = named.iter().enumerate();
        named.try_for_each(|(index, name)| self.check_stage(name, &at.key("stages").index(index)))
    }

    fn check_stage(&self, name: &str, at: &ConfigPath) -> Result<(), SceneError> {
        let known: Vec<&str> =
            self.parts.run.stages.iter().map(|stage| stage.name.as_str()).chain([MEASUREMENT]).collect();
        if known.contains(&name) { Ok(()) } else { Err(unknown(at, "stage", name, known)) }
    }

    /// Replaces names of species by ids. Converts times since the beginning of a stage to simulated times.
    fn resolved(&self, draft: &SurfaceDraft, index: usize, species: &[Species]) -> Result<SceneSurface, SceneError> {
        let SurfaceDraft { name, shape, species: named, law, stages, motions, surface_velocity } = draft.clone();
        let at = ConfigPath::entry("surface", index);
        let find = |name: &String| species_named(species, name, &at.key("species"));
        let species = named.iter().map(find).collect::<Result<Vec<_>, _>>()?;
        let moved = |(index, (stage, motion)): (usize, (Option<String>, SurfaceMotion))| match stage {
            None => Ok(motion),
            Some(stage) => {
                let since = self.start_of_stage(&stage, &at.key("motion").index(index).key("stage"))?;
                Ok(SurfaceMotion { from: since + motion.from, until: since + motion.until, ..motion })
            }
        };
        let motions = motions.into_iter().enumerate().map(moved).collect::<Result<Vec<_>, _>>()?;
        Ok(SceneSurface { name, shape, species, law, stages, motions, surface_velocity })
    }

    /// Simulated time at which a stage begins `[time]`. The durations of earlier stages must be known.
    pub(super) fn start_of_stage(&self, name: &str, at: &ConfigPath) -> Result<f64, SceneError> {
        self.check_stage(name, at)?;
        let (mut time, stages) = (self.parts.start_time, &self.parts.run.stages);
        for stage in stages.iter().take_while(|stage| stage.name != name) {
            let Some(duration) = stage.duration() else {
                let value = format!("\"{name}\", which begins when \"{}\" has ended", stage.name);
                return refuse(
                    at.clone(),
                    value,
                    "earlier stages that end at `until_time` only, so that their durations are known",
                );
            };
            time += duration;
        }
        Ok(time)
    }
}

fn check_law(law: SurfaceLaw, at: &ConfigPath) -> Result<(), SceneError> {
    match law {
        SurfaceLaw::Reflecting(law) => contact_law(&law, at),
        SurfaceLaw::Thermal { temperature } => positive(temperature, at.key("temperature")).map(drop),
        SurfaceLaw::Outlet => Ok(()),
    }
}

fn check_shape(shape: &SurfaceShape, at: &ConfigPath) -> Result<(), SceneError> {
    match shape {
        SurfaceShape::Plane { point, normal } => {
            finite_vector(point, &at.key("point"))?;
            direction(normal, &at.key("normal"))
        }
        SurfaceShape::Sphere { centre, radius, .. } => {
            finite_vector(centre, &at.key("centre"))?;
            positive(*radius, at.key("radius")).map(drop)
        }
        SurfaceShape::Cylinder { point, axis, radius, .. } => {
            finite_vector(point, &at.key("base"))?;
            direction(axis, &at.key("axis"))?;
            positive(*radius, at.key("radius")).map(drop)
        }
        SurfaceShape::Capsule { ends, radius } => {
            finite_vector(&ends[0], &at.key("start"))?;
            finite_vector(&ends[1], &at.key("end"))?;
            not_negative(*radius, at.key("radius"))?;
            if *radius == 0.0 && ends[0] == ends[1] {
                return refuse(at.key("end"), "the same as start", "a different point, or a positive radius");
            }
            Ok(())
        }
        SurfaceShape::Mesh(mesh) => check_mesh(mesh, at),
    }
}

fn check_mesh(mesh: &TriangleMesh, at: &ConfigPath) -> Result<(), SceneError> {
    let at = at.key("path");
    if mesh.triangles.is_empty() {
        return refuse(at, "a mesh without triangles", "at least one");
    }
    for (index, vertex) in mesh.vertices.iter().enumerate() {
        finite_vector(vertex, &at).map_err(|_| {
            let value = format!("a mesh with vertex {index} (from 0) at {:?}", vertex.as_slice());
            SceneError::new(at.clone(), crate::scene::SceneErrorKind::value(value, "coordinates from -1e50 to 1e50"))
        })?;
    }
    let count = mesh.vertices.len();
    let missing = |triangle: &[u32; 3]| triangle.iter().find(|vertex| **vertex as usize >= count).copied();
    match mesh.triangles.iter().enumerate().find_map(|(index, triangle)| Some((index, missing(triangle)?))) {
        Some((index, vertex)) => refuse(
            at,
            format!("a mesh with vertex {vertex} in triangle {index} (from 0)"),
            format!("a number below {count}"),
        ),
        None => Ok(()),
    }
}

fn check_space(shape: &SurfaceShape, space: &Space, at: &ConfigPath) -> Result<(), SceneError> {
    for k in 0..3 {
        let axis = AXES[k];
        match space.boundary[k] {
            Boundary::Flat => check_flat(shape, space, k, at)?,
            Boundary::Periodic => {
                check_images(shape, space, k, at)?;
                let refused = |key: &'static str, value: &str, expected: &str| {
                    refuse(at.key(key), value, format!("{expected}, because the box is periodic along {axis}"))
                };
                match *shape {
                    SurfaceShape::Plane { normal, .. } if normal[k] != 0.0 => {
                        return refused("normal", "oblique", &format!("a normal across {axis}"));
                    }
                    SurfaceShape::Cylinder { axis: along, .. }
                        if along[k] != 0.0 && along.iter().filter(|component| **component != 0.0).count() > 1 =>
                    {
                        return refused("axis", "oblique", &format!("an axis parallel or perpendicular to {axis}"));
                    }
                    SurfaceShape::Sphere { centre, radius, is_inside: true }
                    | SurfaceShape::Cylinder { point: centre, radius, is_inside: true, .. } => {
                        let is_along = matches!(*shape, SurfaceShape::Cylinder { axis, .. } if axis[k] != 0.0);
                        let (lower, upper) = (space.lower[k], space.upper()[k]);
                        if !is_along && (centre[k] - radius < lower || centre[k] + radius > upper) {
                            return refused(
                                "side",
                                "the inside of a surface that extends beyond the box",
                                "a surface within the box",
                            );
                        }
                    }
                    _ => {}
                }
            }
            Boundary::Bounded { .. } => {}
        }
    }
    Ok(())
}

/// Largest distance that a surface may extend beyond the box, in periods, which limits the number of images in memory.
const MOST_PERIODS: f64 = 30.0;

fn check_images(shape: &SurfaceShape, space: &Space, k: usize, at: &ConfigPath) -> Result<(), SceneError> {
    let (key, ends) = match shape {
        SurfaceShape::Plane { .. } => return Ok(()),
        SurfaceShape::Sphere { centre, radius, .. } => ("centre", [centre[k] - radius, centre[k] + radius]),
        // A cylinder is infinite along its axis.
        SurfaceShape::Cylinder { axis, .. } if axis[k] != 0.0 => return Ok(()),
        SurfaceShape::Cylinder { point, radius, .. } => ("base", [point[k] - radius, point[k] + radius]),
        SurfaceShape::Capsule { ends, radius } => {
            let [a, b] = ends.map(|end| end[k]);
            (if a.abs() > b.abs() { "start" } else { "end" }, [a.min(b) - radius, a.max(b) + radius])
        }
        SurfaceShape::Mesh(mesh) => ("shape", mesh.bounds().map(|corner| corner[k])),
    };
    let room = MOST_PERIODS * space.size[k];
    let (lowest, highest) = (space.lower[k] - room, space.upper()[k] + room);
    let Some(end) = ends.into_iter().find(|end| !(lowest..=highest).contains(end)) else { return Ok(()) };
    let expected = format!(
        "{lowest} to {highest}, at most {MOST_PERIODS} periods outside the box, which is periodic along {}",
        AXES[k]
    );
    refuse(at.key(key), format!("at {} = {}", AXES[k], shortest(end)), expected)
}

/// A shape must be symmetric about the plane or line of the scene, so that contact normals have no component along the
/// flat axis.
fn check_flat(shape: &SurfaceShape, space: &Space, k: usize, at: &ConfigPath) -> Result<(), SceneError> {
    let (axis, flat) = (AXES[k], space.lower[k]);
    let off = |point: &Vector, key: &'static str| match point[k] == flat {
        true => Ok(()),
        false => refuse(at.key(key).index(k), point[k], format!("{flat}, because {axis} is flat")),
    };
    match shape {
        SurfaceShape::Plane { normal, .. } if normal[k] != 0.0 => {
            refuse(at.key("normal").index(k), normal[k], format!("0, because {axis} is flat"))
        }
        SurfaceShape::Plane { .. } => Ok(()),
        SurfaceShape::Sphere { centre, .. } => off(centre, "centre"),
        SurfaceShape::Cylinder { axis: along, .. } => {
            let across = (0..3).any(|other| other != k && along[other] != 0.0);
            if across {
                refuse(at.key("axis"), "in another direction", format!("an axis along {axis}, which is flat"))
            } else {
                Ok(())
            }
        }
        SurfaceShape::Capsule { ends, .. } => off(&ends[0], "start").and_then(|()| off(&ends[1], "end")),
        SurfaceShape::Mesh(_) => {
            let expected = format!("`plane`, `sphere`, `capsule`, or `cylinder` along {axis}, which is flat");
            refuse(at.key("shape"), "a mesh of triangles", expected)
        }
    }
}

/// Particles with individual diameters that an inlet lets in must fit inside each hollow sphere and cylinder.
pub(super) fn check_newcomers(start: &Configuration<'_>) -> Result<(), SceneError> {
    let species = start.interactions.species;
    for (id, diameter) in diameters_of_newcomers(species, start.inlets.iter().flat_map(Inlet::species)) {
        for (index, surface) in start.surfaces.of_scene().iter().enumerate().filter(|(_, surface)| surface.meets(id)) {
            if let Some(room) = hollow(&surface.shape).filter(|room| *room <= 0.5 * diameter) {
                let name = &species[id.0 as usize].name;
                let expected = format!("more than {}, the largest radius of `{name}` at inlets", 0.5 * diameter);
                return refuse(ConfigPath::entry("surface", index).key("radius"), room, expected);
            }
        }
    }
    Ok(())
}

/// Radius of a sphere or cylinder with particles inside.
fn hollow(shape: &SurfaceShape) -> Option<f64> {
    match *shape {
        SurfaceShape::Sphere { radius, is_inside: true, .. }
        | SurfaceShape::Cylinder { radius, is_inside: true, .. } => Some(radius),
        _ => None,
    }
}

/// Particles must fit inside a hollow sphere or cylinder. Particles with individual diameters are checked for this with
/// their positions, or by [`check_newcomers`]. The radius of a particle must be well above the round-off of coordinates.
fn check_radii(surface: &SceneSurface, species: &[Species], at: &ConfigPath) -> Result<(), SceneError> {
    let meeting =
        (0..).zip(species).filter(|(index, species)| surface.meets(SpeciesId(*index)) && !species.is_static());
    let largest_coordinate = match &surface.shape {
        SurfaceShape::Mesh(mesh) => mesh.vertices.iter().map(Vector::amax).fold(0.0, f64::max),
        SurfaceShape::Capsule { ends, radius: 0.0 } => ends[0].amax().max(ends[1].amax()),
        _ => 0.0,
    };
    for (_, species) in meeting {
        let (name, radius) = (&species.name, 0.5 * species.diameter);
        let room = hollow(&surface.shape).filter(|room| *room <= radius && species.individual.is_none());
        if let Some(room) = room {
            return refuse(
                at.key("radius"),
                room,
                format!("more than {radius}, the radius of the particles of `{name}` inside the surface"),
            );
        }
        if radius < LEAST_RADIUS * largest_coordinate {
            let value = format!("a surface with coordinates up to {largest_coordinate}");
            let expected = format!(
                "a surface closer to the origin: round-off at these coordinates is too large for `{name}` of diameter {}",
                species.diameter
            );
            return refuse(at.key("shape"), value, expected);
        }
    }
    Ok(())
}
