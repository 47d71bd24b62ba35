use serde::Serialize;

use crate::Vector;
use crate::engine::Simulation;
use crate::mesh::{report, shown};
use crate::model::space::{Boundary, Face};
use crate::model::surface_motion::Timeline;
use crate::model::{LivePlan, Scene, SceneSurface, SurfaceShape};
use crate::run::Stage;
use crate::view::report::base64;
use crate::view::report::recording::{MOST_TRIANGLES, SurfaceData, SurfaceHead, upwards};
use crate::view::surfaces::{Skin, Surfaces};

/// Data of a simulation for the page that shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// Constant data as JSON, such as species, box, bonds, surfaces and stages.
    pub head: String,
    surfaces: Surfaces,
}

impl Shown {
    /// Describes a simulation at its current time.
    #[must_use]
    pub fn of(simulation: &Simulation) -> Self {
        let surfaces = surfaces(simulation.scene());
        let head = serde_json::to_string(&Head::of(simulation, &surfaces)).unwrap_or_default();
        Self { head, surfaces }
    }

    /// Returns the position of each surface at a time; `None` for an absent surface. A position is a rotation `R` and a
    /// displacement `d`, which move a point `x` of the surface to `R x + d`. The numbers are the columns of `R`, then
    /// `d`. The list is empty if all surfaces are present and at rest.
    #[must_use]
    pub fn poses(&self, time: f64, present: &[bool]) -> Vec<Option<[f64; 12]>> {
        self.surfaces.poses(time, present)
    }
}

#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
struct Head {
    name: String,
    seed: u64,
    time: f64,
    species: Vec<SpeciesHead>,
    /// Species index of each particle.
    particles: Vec<u32>,
    /// Lower corner of the box `[length]`.
    lower: [f64; 3],
    /// Edges of the box `[length]`; 0 along flat axes.
    size: [f64; 3],
    periodic: [bool; 3],
    flat: [bool; 3],
    /// Whether the lower and the upper side of each axis are walls.
    walls: [[bool; 2]; 3],
    /// Whether momentum along each axis is conserved in the last stage.
    conserved: [bool; 3],
    /// Velocity gradient of a sheared box `[1 / time]`.
    shear_rate: Option<f64>,
    /// Planes that count passing particles.
    flows: Vec<FlowHead>,
    /// True if a surface encloses the particles.
    is_contained: bool,
    /// Corners of the camera's view `[length]`.
    view: [[f64; 3]; 2],
    up: usize,
    /// True if the axis `up` points down in the picture.
    is_upside_down: bool,
    bonds: Vec<[u32; 2]>,
    stages: Vec<String>,
    live: LivePlan,
    until_time: Option<f64>,
    until_events: Option<u64>,
    /// Layout of the bytes in `surface_data`.
    #[serde(skip_serializing_if = "Option::is_none")]
    surfaces: Option<SurfaceHead>,
    /// Triangles, edges and vertices of the surfaces in base64.
    #[serde(skip_serializing_if = "String::is_empty")]
    surface_data: String,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct FlowHead {
    name: String,
    axis: usize,
    /// Position along the axis `[length]`.
    at: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
struct SpeciesHead {
    name: String,
    /// Initial diameter `[length]`.
    diameter: f64,
    mass: Option<f64>,
    acceleration: [f64; 3],
    is_static: bool,
}

impl Head {
    fn of(simulation: &Simulation, surfaces: &Surfaces) -> Self {
        let scene = simulation.scene();
        let (space, plan) = (scene.space(), scene.run());
        let species = scene.species().iter().map(|species| SpeciesHead {
            name: species.name.clone(),
            diameter: species.diameter,
            mass: (!species.is_static()).then_some(species.mass),
            acceleration: species.acceleration.into(),
            is_static: species.is_static(),
        });
        let is = |kind: Boundary| space.boundary.map(|boundary| boundary == kind);
        let flat = is(Boundary::Flat);
        let (up, is_upside_down) = upwards(flat, Some(scene));
        let data = SurfaceData::of(surfaces).filter(|data| data.head.triangles <= MOST_TRIANGLES);
        let mut surface_data = String::new();
        if let Some(data) = &data {
            base64::encode(&data.bytes, &mut surface_data);
        }
        Self {
            name: scene.name().to_owned(),
            seed: scene.seed(),
            time: simulation.time(),
            species: species.collect(),
            particles: scene.particles().iter().map(|particle| particle.species.0).collect(),
            lower: space.lower.into(),
            size: space.size.into(),
            periodic: is(Boundary::Periodic),
            flat,
            walls: space.boundary.map(walls),
            conserved: scene.conserved_axes(),
            shear_rate: scene.shear_rate(),
            flows: flows(scene),
            is_contained: scene.surfaces().iter().any(|surface| is_container(surface, scene, up)),
            view: view(scene, surfaces).map(Into::into),
            up,
            is_upside_down,
            bonds: scene.bonds().iter().map(|bond| bond.pair.map(|id| id.0)).collect(),
            stages: Stage::simulated(plan).map(|stage| stage.name(plan).into_owned()).collect(),
            live: scene.live().clone(),
            until_time: plan.limit.time,
            until_events: plan.limit.events,
            surfaces: data.map(|data| data.head),
            surface_data,
        }
    }
}

fn walls(boundary: Boundary) -> [bool; 2] {
    match boundary {
        Boundary::Bounded { lower, upper } => [lower, upper].map(|face| face != Face::Open),
        Boundary::Periodic | Boundary::Flat => [false; 2],
    }
}

fn flows(scene: &Scene) -> Vec<FlowHead> {
    let of_axis = |name: &str| ["x", "y", "z"].iter().position(|axis| *axis == name);
    let planes = scene.measure().flows.iter().filter_map(|flow| {
        let axis = of_axis(flow.axis.as_deref()?)?;
        Some(FlowHead { name: flow.name.clone(), axis, at: flow.at })
    });
    planes.collect()
}

/// Returns true if a surface encloses the particles. For a closed mesh, only one particle is checked.
fn is_container(surface: &SceneSurface, scene: &Scene, up: usize) -> bool {
    match &surface.shape {
        SurfaceShape::Sphere { is_inside, .. } => *is_inside,
        SurfaceShape::Cylinder { is_inside, axis, .. } => *is_inside && axis[up].abs() < 0.5 * axis.norm(),
        SurfaceShape::Mesh(mesh) => {
            let particle = scene.particles().iter().find(|particle| surface.meets(particle.species));
            let is_closed = mesh.edges().iter().all(|uses| uses.len() == 2);
            is_closed && particle.is_some_and(|particle| report::contains(mesh, &particle.position))
        }
        SurfaceShape::Plane { .. } | SurfaceShape::Capsule { .. } => false,
    }
}

fn surfaces(scene: &Scene) -> Surfaces {
    let skins = scene.surfaces().iter().zip(shown(scene)).enumerate().map(|(number, (surface, (_, mesh)))| Skin {
        number: Some(number),
        timeline: surface.moves().then(|| Timeline::of(&surface.motions)),
        ..Skin::of(&mesh)
    });
    Surfaces { skins: skins.filter(|skin| !skin.triangles.is_empty()).collect() }
}

/// Returns the corners of the region to show. It contains the box, or the centres of the particles if the box has no
/// size. It also contains surfaces, unless they extend far beyond this region.
fn view(scene: &Scene, surfaces: &Surfaces) -> [Vector; 2] {
    let space = scene.space();
    let mut view = [space.lower, space.upper()];
    if space.size.iter().all(|edge| *edge == 0.0) {
        let positions = scene.particles().iter().map(|particle| [particle.position; 2]);
        view = positions.reduce(|[a, b], [c, d]| [a.inf(&c), b.sup(&d)]).unwrap_or(view);
    }
    surfaces.framed(view).iter().fold(view, |[lower, upper], corner| [lower.inf(corner), upper.sup(corner)])
}
