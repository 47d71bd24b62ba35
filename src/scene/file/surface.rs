//! `[[surface]]`: a surface that particles collide with.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::restitution::RestitutionFile;
use super::surface_velocity::SurfaceVelocityFile;
use crate::scene::names::WORDS;
use crate::scene::parse::motion::MOTIONS;
use crate::scene::parse::surface::{SHAPES, SIDES};
use crate::scene::schema::{keys_by_kind, words};

/// `[[surface]]`: a surface that particles collide with, in addition to the walls of the box.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = keys_by_kind("shape", &SHAPES)))]
pub(crate) struct SurfaceFile {
    /// Unique name: up to 100 letters, digits, blanks and any of `_ - + . ( )`, beginning with a letter or a digit. If
    /// not given, it is `surface 1` for the first surface, and so on.
    #[schemars(regex(pattern = WORDS))]
    pub name: Option<String>,
    /// Shape of the surface. It determines which other keys are allowed.
    #[schemars(extend("enum" = words(&SHAPES)))]
    pub shape: String,
    /// Names of the species that collide with the surface; all species if not given.
    #[schemars(length(min = 1))]
    pub species: Option<Vec<String>>,
    /// Names of the stages in which the surface exists; all stages if not given. `measurement` is the part of the run
    /// after all stages. A surface may appear only where there are no particles.
    #[schemars(length(min = 1))]
    pub stages: Option<Vec<String>>,
    /// Motions of the surface in order of time. The surface is at rest before, between and after its motions.
    #[schemars(length(min = 1))]
    pub motion: Option<Vec<MotionFile>>,
    /// Velocity of the material along a rough or thermal surface, for example of a belt or a drum `[length / time]`. The shape of
    /// the surface does not move with it.
    pub surface_velocity: Option<SurfaceVelocityFile>,
    /// Ratio of the normal speeds after and before a contact.
    #[schemars(extend("default" = 1.0))]
    pub restitution: Option<RestitutionFile>,
    /// Tangential restitution of a rough surface: a contact without sliding multiplies the tangential velocity of
    /// the surfaces by minus this number. If not given, it is 0 with `friction`; without both keys, contacts are smooth.
    #[schemars(range(min = -1, max = 1))]
    pub tangential_restitution: Option<f64>,
    /// Friction coefficient of a rough surface: the largest ratio of the tangential to the normal impulse. If not
    /// given, contacts with a tangential restitution never slide.
    #[schemars(range(min = 0))]
    pub friction: Option<f64>,
    /// Material of the surface, which determines the contact law with the species that touch it.
    pub material: Option<String>,
    /// Whether the surface is an outlet: particles that touch it leave the system. An outlet has no contact law, no
    /// temperature and no surface velocity.
    pub outlet: Option<bool>,
    /// Temperature of a thermal surface `[energy]`, instead of a restitution.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub temperature: Option<f64>,
    /// Whether the particles are `inside` or `outside` a sphere or an endless cylinder.
    #[schemars(extend("enum" = json!(words(&SIDES)), "default" = "outside"))]
    pub side: Option<String>,
    /// A point of a plane `[length]`.
    pub point: Option<[f64; 3]>,
    /// Direction from a plane towards the particles, of any length.
    pub normal: Option<[f64; 3]>,
    /// Centre of a sphere or disc `[length]`.
    pub centre: Option<[f64; 3]>,
    /// Radius of a sphere, cylinder, capsule or disc `[length]`. A capsule with radius 0 is a line.
    #[schemars(range(min = 0))]
    pub radius: Option<f64>,
    /// Centre of the first end of a cylinder or cone, or a point on the axis of a surface of revolution `[length]`.
    pub base: Option<[f64; 3]>,
    /// Direction of the axis, from the first end to the second, of any length.
    pub axis: Option<[f64; 3]>,
    /// Distance between the ends of a cylinder or cone `[length]`. A cylinder without a length is endless.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub length: Option<f64>,
    /// Radii of the two ends of a cone `[length]`.
    #[schemars(inner(range(min = 0)))]
    pub radii: Option<[f64; 2]>,
    /// Points of the profile that is turned about the axis `[length]`: distance from the axis, and height above `base`.
    #[schemars(length(min = 2))]
    pub profile: Option<Vec<[f64; 2]>>,
    /// Largest distance between a round surface and the triangles that approximate it `[length]`; a thousandth of the
    /// largest radius if not given.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub tolerance: Option<f64>,
    /// First end of a capsule `[length]`.
    pub start: Option<[f64; 3]>,
    /// Second end of a capsule `[length]`.
    pub end: Option<[f64; 3]>,
    /// Corner of a parallelogram `[length]`.
    pub corner: Option<[f64; 3]>,
    /// First edge of a parallelogram, from its corner `[length]`.
    pub edge_1: Option<[f64; 3]>,
    /// Second edge of a parallelogram, from its corner `[length]`.
    pub edge_2: Option<[f64; 3]>,
    /// Lower corner of a box `[length]`.
    pub lower: Option<[f64; 3]>,
    /// Upper corner of a box `[length]`.
    pub upper: Option<[f64; 3]>,
    /// STL or OBJ file of a mesh, relative to the folder of the scene.
    pub path: Option<String>,
    /// Whether the mesh must be closed, have outward normals and not intersect itself.
    #[schemars(extend("default" = false))]
    pub closed: Option<bool>,
    /// Largest distance at which vertices of the file are merged, as a fraction of the largest extent of the mesh; none
    /// are merged if not given.
    #[schemars(range(min = 0, max = 0.01), extend("default" = 0.0))]
    pub weld: Option<f64>,
    /// Factor by which the mesh is scaled before its rotation.
    #[schemars(extend("exclusiveMinimum" = 0, "default" = 1.0))]
    pub scale: Option<f64>,
    /// Axis and angle in degrees of the rotation of the mesh, after its scaling.
    pub rotation: Option<RotationFile>,
    /// Displacement of the mesh after its rotation `[length]`.
    #[schemars(extend("default" = [0.0, 0.0, 0.0]))]
    pub translation: Option<[f64; 3]>,
    /// Checksum that the file must have: `crc32:` and eight hexadecimal digits. A run adds it to its copy of the scene.
    #[schemars(regex(pattern = "^crc32:[0-9a-f]{8}$"))]
    pub checksum: Option<String>,
}

/// A motion of a surface.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = keys_by_kind("kind", &MOTIONS)))]
pub(crate) struct MotionFile {
    /// Kind of motion. In a time `t`, a `translation` moves the surface by `v t + a t^2 / 2`, with the velocity `v` and
    /// the acceleration `a`. An `oscillation` moves the surface by `A (sin(2 pi f t + phase) - sin(phase))`, with the
    /// amplitude `A` and the frequency `f`. A `rotation` turns the surface by the angle `2 pi f t`.
    #[schemars(extend("enum" = words(&MOTIONS)))]
    pub kind: String,
    /// Stage at whose start the times of the motion begin. `measurement` is the part of the run after all stages. All
    /// earlier stages must end at given times.
    pub stage: Option<String>,
    /// Time at which the motion begins `[time]`. The default is the end of the previous motion of the same stage, or 0.
    pub from: Option<f64>,
    /// Time at which the motion ends `[time]`. If not given, the motion never ends.
    pub until: Option<f64>,
    /// Initial velocity of a translation `[length / time]`.
    #[schemars(extend("default" = [0.0, 0.0, 0.0]))]
    pub velocity: Option<[f64; 3]>,
    /// Acceleration of a translation `[length / time^2]`.
    #[schemars(extend("default" = [0.0, 0.0, 0.0]))]
    pub acceleration: Option<[f64; 3]>,
    /// Amplitude of an oscillation `[length]`.
    pub amplitude: Option<[f64; 3]>,
    /// Frequency of an oscillation, or turns per unit of time `[1 / time]`; negative values reverse a rotation.
    pub frequency: Option<f64>,
    /// Initial phase of an oscillation, in degrees.
    #[schemars(extend("default" = 0.0))]
    pub phase: Option<f64>,
    /// A point on the axis of a rotation `[length]`.
    pub point: Option<[f64; 3]>,
    /// Direction of the rotation axis, of any length. Rotations are counterclockwise if the axis points at the viewer.
    pub axis: Option<[f64; 3]>,
}

/// A rotation.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RotationFile {
    /// Axis of the rotation, of any length. The rotation is counterclockwise when the axis points at the viewer.
    pub axis: [f64; 3],
    /// Angle in degrees.
    pub angle: f64,
}
