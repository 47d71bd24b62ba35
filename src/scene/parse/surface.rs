//! Parses the tables of surfaces, and reads the files of their meshes.

use std::path::Path;

use nalgebra::Rotation3;

use super::contact_law::contact_law;
use super::materials::Materials;
use super::motion::parse_motions;
use super::{Keys, variant, vector};
use crate::mesh::read::{MeshFileError, read_mesh, unread_bytes};
use crate::mesh::report::{MeshReport, Orientation};
use crate::mesh::revolution::revolution;
use crate::model::surface_motion::{sine_and_cosine, turn};
use crate::model::{InputFile, SurfaceLaw, SurfaceShape, SurfaceVelocity, TriangleMesh};
use crate::scene::brought;
use crate::scene::config_path::ConfigPath;
use crate::scene::coordinates::unchanged;
use crate::scene::diagnostic::{SceneError, SceneErrorKind, refuse};
use crate::scene::file::{RotationFile, SurfaceFile, SurfaceVelocityFile, TurningFile};
use crate::scene::limits::{corners, direction, finite, finite_vector, not_negative, parallelogram, positive};
use crate::scene::surface_draft::SurfaceDraft;

pub(crate) const SHAPES: [(&str, &[&str]); 10] = [
    ("plane", &["point", "normal"]),
    ("sphere", &["centre", "radius", "side"]),
    ("cylinder", &["base", "axis", "radius", "side", "length", "tolerance"]),
    ("capsule", &["start", "end", "radius"]),
    ("box", &["lower", "upper"]),
    ("parallelogram", &["corner", "edge_1", "edge_2"]),
    ("disc", &["centre", "axis", "radius", "tolerance"]),
    ("cone", &["base", "axis", "radii", "length", "tolerance"]),
    ("revolution", &["base", "axis", "profile", "tolerance"]),
    ("mesh", &["path", "closed", "weld", "scale", "rotation", "translation", "checksum"]),
];

/// Words for the side of a surface with the particles, and whether this side is the inside.
pub(crate) const SIDES: [(&str, bool); 2] = [("outside", false), ("inside", true)];

/// Default distance between a round surface and its triangles, relative to the largest radius.
const TOLERANCE: f64 = 1e-3;

pub(super) fn parse_surface(
    file: SurfaceFile,
    materials: &Materials,
    index: usize,
    directory: &Path,
) -> Result<(SurfaceDraft, Option<InputFile>), SceneError> {
    let at = ConfigPath::entry("surface", index);
    let (word, keys) = Keys::of_kind(&SHAPES, "shape", &file.shape, &at, &file)?;
    let law = surface_law(&file, materials, &at)?;
    let mut input = None;
    let shape = match word {
        "mesh" => {
            let source = MeshSource {
                path: keys.need("path")?,
                closed: (file.closed == Some(true)).then_some("because of `closed`"),
                weld: file.weld,
                scale: file.scale,
                rotation: file.rotation,
                translation: file.translation,
                checksum: file.checksum.as_deref(),
            };
            let (mesh, read) = mesh(&source, &at, directory)?;
            input = Some(read);
            SurfaceShape::Mesh(mesh)
        }
        _ => parse_shape(word, &file, &keys)?,
    };
    let draft = SurfaceDraft {
        name: file.name.unwrap_or_else(|| format!("surface {}", index + 1)),
        shape,
        species: file.species.unwrap_or_default(),
        law,
        stages: file.stages.unwrap_or_default(),
        motions: parse_motions(file.motion.unwrap_or_default(), &at)?,
        surface_velocity: file.surface_velocity.as_ref().map(surface_velocity),
    };
    Ok((draft, input))
}

/// Returns the law of a surface: an outlet, a temperature, a material, or a contact law of its own.
fn surface_law(file: &SurfaceFile, materials: &Materials, at: &ConfigPath) -> Result<SurfaceLaw, SceneError> {
    let is_outlet = file.outlet == Some(true);
    let given = [
        ("restitution", file.restitution.is_some()),
        ("temperature", file.temperature.is_some()),
        ("tangential_restitution", file.tangential_restitution.is_some()),
        ("friction", file.friction.is_some()),
        ("material", file.material.is_some()),
    ];
    if let Some((key, _)) = given.into_iter().find(|(_, is_given)| is_outlet && *is_given) {
        return refuse(at.key(key), "given for an outlet", "none: particles leave at an outlet");
    }
    if let Some((key, _)) = given.into_iter().find(|(key, is_given)| *is_given && *key != "material")
        && file.material.is_some()
    {
        let expected = match key {
            "temperature" => "either the material or the temperature",
            _ => "either the material, or the keys of the contact law",
        };
        return refuse(at.key(key), "given for a material", expected);
    }
    Ok(match (&file.restitution, file.temperature) {
        _ if is_outlet => SurfaceLaw::Outlet,
        (Some(_), Some(_)) => {
            return refuse(at.key("temperature"), "given as well", "either temperature or restitution");
        }
        (_, Some(_)) if file.tangential_restitution.is_some() || file.friction.is_some() => {
            return refuse(at.key("temperature"), "given for a rough surface", "none: thermal surfaces are smooth");
        }
        (_, Some(temperature)) => SurfaceLaw::Thermal { temperature },
        (restitution, None) => SurfaceLaw::Reflecting(match &file.material {
            Some(material) => materials.of_surface(material, file.species.as_deref().unwrap_or_default(), at)?,
            None => contact_law(restitution.as_ref(), file.tangential_restitution, file.friction, at)?,
        }),
    })
}

fn surface_velocity(file: &SurfaceVelocityFile) -> SurfaceVelocity {
    match *file {
        SurfaceVelocityFile::Velocity(velocity) => SurfaceVelocity::Translation { velocity: vector(velocity) },
        SurfaceVelocityFile::Turning(TurningFile { point, axis, frequency }) => {
            SurfaceVelocity::Rotation { point: vector(point), axis: vector(axis), frequency }
        }
    }
}

fn parse_shape(word: &str, file: &SurfaceFile, keys: &Keys<'_>) -> Result<SurfaceShape, SceneError> {
    let at = keys.at;
    let is_inside = || match &file.side {
        Some(side) => variant(&SIDES, "side", side, &at.key("side")).copied(),
        None => Ok(false),
    };
    Ok(match word {
        "plane" => SurfaceShape::Plane { point: keys.vector("point")?, normal: keys.vector("normal")? },
        "sphere" => SurfaceShape::Sphere {
            centre: keys.vector("centre")?,
            radius: keys.need("radius")?,
            is_inside: is_inside()?,
        },
        "cylinder" if file.length.is_none() => {
            if file.tolerance.is_some() {
                return refuse(
                    at.key("tolerance"),
                    "given",
                    "to be absent if there is no `length`, because an infinite cylinder is exactly round",
                );
            }
            SurfaceShape::Cylinder {
                point: keys.vector("base")?,
                axis: keys.vector("axis")?,
                radius: keys.need("radius")?,
                is_inside: is_inside()?,
            }
        }
        "capsule" => {
            SurfaceShape::Capsule { ends: [keys.vector("start")?, keys.vector("end")?], radius: keys.need("radius")? }
        }
        "box" => {
            let (lower, upper) = (keys.vector("lower")?, keys.vector("upper")?);
            corners(&lower, &upper, 0..3, at)?;
            SurfaceShape::Mesh(TriangleMesh::cuboid(&lower, &upper))
        }
        "parallelogram" => {
            let (corner, edges) = (keys.vector("corner")?, [keys.vector("edge_1")?, keys.vector("edge_2")?]);
            parallelogram(&corner, &edges, at)?;
            let vertices = vec![corner, corner + edges[0], corner + edges[0] + edges[1], corner + edges[1]];
            SurfaceShape::Mesh(TriangleMesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]] })
        }
        "disc" => {
            let radius = positive(keys.need("radius")?, at.key("radius"))?;
            turned("centre", &[[0.0, 0.0], [radius, 0.0]], file, keys)?
        }
        "cone" | "cylinder" => {
            if file.side.is_some() {
                return refuse(
                    at.key("side"),
                    "given",
                    "none: particles can touch a surface of finite length from both sides",
                );
            }
            let length = positive(keys.need("length")?, at.key("length"))?;
            let radii = keys.radii_of_ends(word)?;
            turned("base", &[[radii[0], 0.0], [radii[1], length]], file, keys)?
        }
        _ => turned("base", &keys.need::<Vec<[f64; 2]>>("profile")?, file, keys)?,
    })
}

fn turned(
    base_key: &'static str,
    profile: &[[f64; 2]],
    file: &SurfaceFile,
    keys: &Keys<'_>,
) -> Result<SurfaceShape, SceneError> {
    let at = keys.at;
    let (base, axis) = (keys.vector(base_key)?, keys.vector("axis")?);
    finite_vector(&base, &at.key(base_key))?;
    direction(&axis, &at.key("axis"))?;
    let key = at.key(match (&file.profile, &file.radii) {
        (Some(_), _) => "profile",
        (None, Some(_)) => "radii",
        (None, None) => "radius",
    });
    for [radius, height] in profile {
        not_negative(*radius, key.clone())?;
        finite(*height, key.clone())?;
    }
    let largest = positive(profile.iter().map(|[radius, _]| *radius).fold(0.0, f64::max), key.clone())?;
    let tolerance = positive(file.tolerance.unwrap_or(TOLERANCE * largest), at.key("tolerance"))?;
    match revolution(&base, &axis, profile, tolerance) {
        Some(mesh) if !mesh.triangles.is_empty() => Ok(SurfaceShape::Mesh(mesh)),
        Some(_) => refuse(key, "a profile of zero length", "two different points, at least one of them off the axis"),
        None => refuse(at.key("tolerance"), tolerance, "a larger tolerance: a circle would have more than 4096 sides"),
    }
}

const MOST_WELDED: f64 = 0.01;

pub(super) struct MeshSource<'f> {
    pub path: String,
    /// Reason why the mesh must be closed, for messages. `None` if the mesh may be open.
    pub closed: Option<&'static str>,
    pub weld: Option<f64>,
    pub scale: Option<f64>,
    pub rotation: Option<RotationFile>,
    pub translation: Option<[f64; 3]>,
    pub checksum: Option<&'f str>,
}

pub(super) fn mesh(
    file: &MeshSource<'_>,
    at: &ConfigPath,
    directory: &Path,
) -> Result<(TriangleMesh, InputFile), SceneError> {
    let path = directory.join(&file.path);
    let unreadable = |source| SceneErrorKind::Unreadable { path: path.clone(), source };
    let content = brought::read(&path).map_err(|source| SceneError::new(at.key("path"), unreadable(source)))?;
    let mut input = unchanged(&path, &content, file.checksum, at)?;
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    let unusable = |error: MeshFileError| {
        SceneError::new(at.key("path"), SceneErrorKind::Mesh { path: path.clone(), problem: Box::new(error.problem) })
    };
    let mut read = read_mesh("", extension, &content).map_err(unusable)?;
    input.extra_bytes = unread_bytes(extension, &content);
    let weld = file.weld.unwrap_or(0.0);
    if !(0.0..=MOST_WELDED).contains(&weld) {
        return refuse(
            at.key("weld"),
            weld,
            format!("a fraction of the largest extent of the mesh, from 0 to {MOST_WELDED}"),
        );
    }
    if weld > 0.0 {
        let [lower, upper] = read.bounds();
        (read, input.merged_vertices) = read.merged(weld * (upper - lower).amax());
    }
    if let Some(why) = file.closed {
        check_closed(&read, &path, why, at)?;
    }
    let scale = positive(file.scale.unwrap_or(1.0), at.key("scale"))?;
    let translation = vector(file.translation.unwrap_or_default());
    finite_vector(&translation, &at.key("translation"))?;
    let rotation = match file.rotation {
        None => Rotation3::identity(),
        Some(rotation) => {
            let key = at.key("rotation");
            let axis = vector(rotation.axis);
            finite_vector(&axis, &key.key("axis"))?;
            finite(rotation.angle, key.key("angle"))?;
            let Some(axis) = axis.try_normalize(0.0) else {
                return refuse(key.key("axis"), "zero", "a direction");
            };
            Rotation3::from_matrix_unchecked(turn(&axis, sine_and_cosine(rotation.angle / 360.0)))
        }
    };
    Ok((read.transformed(scale, &rotation, &translation), input))
}

/// Rejects a mesh that is open, intersects itself, or has wrong normals or faces.
fn check_closed(mesh: &TriangleMesh, path: &Path, why: &str, at: &ConfigPath) -> Result<(), SceneError> {
    let report = MeshReport::of(mesh);
    let refused = |value: String, cure: &str| {
        let expected = format!("the closed surface of one or more bodies, {why}: {cure}");
        refuse(at.key("path"), format!("{}: {value}", path.display()), expected)
    };
    match report.findings().first() {
        Some(finding) => refused(finding.to_string(), finding.cure()),
        None if report.orientation() != Some(Orientation::Outwards) => {
            refused("the normals of the mesh point inwards".to_owned(), "flip them, so that all point outwards")
        }
        None => Ok(()),
    }
}
