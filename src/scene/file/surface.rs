//! `[[surface]]`: a surface that particles meet.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::scene::names::WORDS;
use crate::scene::parse::motion::MOTIONS;
use crate::scene::parse::surface::{SHAPES, SIDES};
use crate::scene::schema::{keys_by_kind, words};

/// `[[surface]]`: a surface that particles meet, besides the walls of the box.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = keys_by_kind("shape", &SHAPES)))]
pub(crate) struct SurfaceFile {
    /// Name, unique among the surfaces: up to 100 letters, digits, blanks and any of `_ - + . ( )`, beginning with a letter or a digit. `surface 1` for
    /// the first if not given, and so on.
    #[schemars(regex(pattern = WORDS))]
    pub name: Option<String>,
    /// The shape; it decides which of the other keys there are.
    #[schemars(extend("enum" = words(&SHAPES)))]
    pub shape: String,
    /// Names of the species that meet it; all if not given.
    #[schemars(length(min = 1))]
    pub species: Option<Vec<String>>,
    /// Names of the stages in which it is there, `measurement` for what comes after those; all if not given. One that is put in later needs free room.
    #[schemars(length(min = 1))]
    pub stages: Option<Vec<String>>,
    /// Its motions, in the order of time; it rests before, between and after them.
    #[schemars(length(min = 1))]
    pub motion: Option<Vec<MotionFile>>,
    /// Ratio of the normal speeds after and before a contact.
    #[schemars(range(min = 0, max = 1), extend("default" = 1.0))]
    pub restitution: Option<f64>,
    /// Temperature of a thermal surface in place of a restitution `[energy]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub temperature: Option<f64>,
    /// The side of a sphere or an endless cylinder on which particles are.
    #[schemars(extend("enum" = json!(words(&SIDES)), "default" = "outside"))]
    pub side: Option<String>,
    /// A point of a plane `[length]`.
    pub point: Option<[f64; 3]>,
    /// Direction from a plane towards the particles, of any length.
    pub normal: Option<[f64; 3]>,
    /// Centre of a sphere or disc `[length]`.
    pub centre: Option<[f64; 3]>,
    /// Radius of a sphere, cylinder, capsule or disc `[length]`; 0 makes a capsule a line.
    #[schemars(range(min = 0))]
    pub radius: Option<f64>,
    /// Centre of the first end of a cylinder or cone, a point of the axis of a revolution `[length]`.
    pub base: Option<[f64; 3]>,
    /// Direction of the axis, of any length: from the first end to the second.
    pub axis: Option<[f64; 3]>,
    /// Distance of the ends of a cylinder or cone `[length]`; a cylinder without it has no ends.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub length: Option<f64>,
    /// Radii of the two ends of a cone `[length]`.
    #[schemars(inner(range(min = 0)))]
    pub radii: Option<[f64; 2]>,
    /// Points of a line that is turned about the axis: distance from the axis, and height along it from the base `[length]`.
    #[schemars(length(min = 2))]
    pub profile: Option<Vec<[f64; 2]>>,
    /// Largest distance of the triangles from a round surface `[length]`; a thousandth of the largest radius if not given.
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
    /// File of a mesh, STL or OBJ; a relative path starts at the folder of the scene.
    pub path: Option<String>,
    /// Whether it is refused unless it is the closed surface of bodies, with normals outwards, that nowhere passes through itself.
    #[schemars(extend("default" = false))]
    pub closed: Option<bool>,
    /// Vertices of the file that are nearer to each other than this part of the largest extent of the mesh become one; none if not given.
    #[schemars(range(min = 0, max = 0.01), extend("default" = 0.0))]
    pub weld: Option<f64>,
    /// Factor by which the mesh of the file is made larger, first.
    #[schemars(extend("exclusiveMinimum" = 0, "default" = 1.0))]
    pub scale: Option<f64>,
    /// Direction about which the mesh of the file is turned, and by how many degrees, second.
    pub rotation: Option<RotationFile>,
    /// How far the mesh of the file is moved, last `[length]`.
    #[schemars(extend("default" = [0.0, 0.0, 0.0]))]
    pub translation: Option<[f64; 3]>,
    /// Checksum that the file must have: `crc32:` and eight hexadecimal digits. Runs keep it with their scene.
    #[schemars(regex(pattern = "^crc32:[0-9a-f]{8}$"))]
    pub checksum: Option<String>,
}

/// A motion of a surface.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = keys_by_kind("kind", &MOTIONS)))]
pub(crate) struct MotionFile {
    /// `"translation"` is `v t + a t^2 / 2`, `"oscillation"` `A (sin(2 pi f t + phase) - sin(phase))`, `"rotation"` turns by `2 pi f t`, by the time `t`
    /// since its beginning.
    #[schemars(extend("enum" = words(&MOTIONS)))]
    pub kind: String,
    /// Stage since whose beginning its times count; `measurement` is what comes after the stages that are listed. Those before it end at given times.
    pub stage: Option<String>,
    /// Simulated time at which it begins `[time]`; the end of the motion before in the same stage if not given, 0 for the first.
    pub from: Option<f64>,
    /// Simulated time at which it ends `[time]`; never if not given.
    pub until: Option<f64>,
    /// Velocity of a translation at its beginning `[length / time]`.
    #[schemars(extend("default" = [0.0, 0.0, 0.0]))]
    pub velocity: Option<[f64; 3]>,
    /// Acceleration of a translation `[length / time^2]`.
    #[schemars(extend("default" = [0.0, 0.0, 0.0]))]
    pub acceleration: Option<[f64; 3]>,
    /// Amplitude of an oscillation `[length]`.
    pub amplitude: Option<[f64; 3]>,
    /// Periods of an oscillation by time; turns by time of a rotation, negative for the other sense `[1 / time]`.
    pub frequency: Option<f64>,
    /// Phase of an oscillation at its beginning, in degrees.
    #[schemars(extend("default" = 0.0))]
    pub phase: Option<f64>,
    /// A point of the axis of a rotation `[length]`.
    pub point: Option<[f64; 3]>,
    /// Direction of that axis, of any length; it turns counterclockwise seen against it.
    pub axis: Option<[f64; 3]>,
}

/// A rotation.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RotationFile {
    /// Direction about which it turns, of any length; counterclockwise seen against it.
    pub axis: [f64; 3],
    /// Angle, in degrees.
    pub angle: f64,
}
