//! A frame of a trajectory: all particles at one time.

use std::collections::HashMap;

use serde::{Deserialize, Serialize};

use crate::Vector;
use crate::analysis::instruments::Scalar;
use crate::base::numbers::id;
use crate::model::space::{Boundary, Space, nearest_image};
use crate::model::{ParticleId, Scene, SpeciesId, Units};

/// Names of the scalars that contain the components of the spins `[1 / time]`. LAMMPS uses the same names.
pub(crate) const SPINS: [&str; 3] = ["omegax", "omegay", "omegaz"];

#[cfg(test)]
mod tests;

/// Names of columns, arrays and files in the output formats.
const TAKEN: [&str; 47] = [
    "bond_kinds",
    "bond_names",
    "bonds",
    "box",
    "diameter",
    "element",
    "frame",
    "id",
    "ids",
    "image",
    "images",
    "ix",
    "iy",
    "iz",
    "map_shift",
    "mass",
    "masses",
    "numbers",
    "periodic",
    "pos",
    "position",
    "positions",
    "radius",
    "species",
    "species_mass",
    "species_names",
    "species_static",
    "static",
    "symbols",
    "time",
    "times",
    "timevalue",
    "type",
    "typeid",
    "types",
    "units",
    "velo",
    "velocities",
    "velocity",
    "vx",
    "vy",
    "vz",
    "x",
    "xs",
    "y",
    "z",
    "zs",
];

/// A species in a frame: name and mass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrameSpecies {
    /// Name, unique in the frame.
    pub name: String,
    /// Whether the species never moves.
    pub is_static: bool,
    /// Mass of the particles, infinite for a static species `[mass]`; `None` if the trajectory file lacks it.
    pub mass: Option<f64>,
}

/// A particle in a frame: id, species, radius, position and velocity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FrameParticle {
    /// Id, which is the same in all output.
    pub id: ParticleId,
    /// Index into [`Frame::species`].
    pub species: SpeciesId,
    /// Position `[length]`.
    pub position: Vector,
    /// Velocity `[length / time]`.
    pub velocity: Vector,
    /// Half of the diameter `[length]`.
    pub radius: f64,
}

/// A frame of a trajectory: all particles at one time, and the box.
#[doc(alias = "snapshot")]
#[doc(alias = "configuration")]
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Simulated time `[time]`.
    pub time: f64,
    /// Lower corner of the box `[length]`.
    pub lower: Vector,
    /// Edge lengths of the box `[length]`; 0 along flat axes.
    pub size: Vector,
    /// Whether each axis is periodic. A particle that leaves on one side enters on the opposite side.
    pub periodic: [bool; 3],
    /// Displacement along x of the next image of the box along y, due to shear, in `(-L_x / 2, L_x / 2]` `[length]`.
    pub displacement: f64,
    /// Species of the particles.
    pub species: Vec<FrameSpecies>,
    /// Particles of the frame, in any order.
    pub particles: Vec<FrameParticle>,
    /// Ids of the two ends of each bond.
    pub bonds: Vec<[ParticleId; 2]>,
    /// Names of the interactions of the bonds.
    pub bond_names: Vec<String>,
    /// Index of the interaction of each bond in `bond_names`; empty if a file lacks it.
    pub bond_kinds: Vec<u32>,
    /// Number of periods that each particle has travelled along each axis, see [`Frame::unwrapped`]. Empty if a file
    /// lacks these numbers.
    #[doc(alias = "image flags")]
    pub images: Vec<[i32; 3]>,
    /// Additional scalars of the particles, such as the bond order.
    pub scalars: Vec<Scalar>,
    /// Whether each surface of the scene is present at this time. Empty if all surfaces are present.
    pub surfaces: Vec<bool>,
    /// Names of the units of all numbers. The default has no names.
    pub units: Units,
}

impl Frame {
    /// Spins of the particles `[1 / time]`, from the scalars `omegax`, `omegay` and `omegaz`. `None` if a scalar is missing.
    pub(crate) fn spins(&self) -> Option<Vec<Vector>> {
        let values = |name: &str| self.scalars.iter().find(|scalar| scalar.name == name).map(|scalar| &scalar.values);
        let [x, y, z] = SPINS.map(values);
        Some(x?.iter().zip(y?).zip(z?).map(|((x, y), z)| Vector::new(*x, *y, *z)).collect())
    }

    /// The particles of a scene at its start, in the order of their ids.
    #[must_use]
    pub fn start_of(scene: &Scene) -> Self {
        let particle = |(id, particle): (u32, &crate::model::Particle)| FrameParticle {
            id: ParticleId(id),
            species: particle.species,
            position: particle.position,
            velocity: particle.velocity,
            radius: 0.5 * scene.diameter(particle),
        };
        Self {
            particles: (0..).zip(&scene.particles).map(particle).collect(),
            images: vec![[0; 3]; scene.particles.len()],
            ..Self::without_particles(scene)
        }
    }

    pub(crate) fn without_particles(scene: &Scene) -> Self {
        let (bond_names, bond_kinds) = Self::kinds_of_bonds(scene);
        Self {
            time: scene.start_time,
            lower: scene.space.lower,
            size: scene.space.size,
            periodic: scene.space.boundary.map(|boundary| boundary == Boundary::Periodic),
            displacement: scene.displacement,
            species: scene
                .species
                .iter()
                .map(|species| FrameSpecies {
                    name: species.name.clone(),
                    is_static: species.is_static(),
                    // Masses that differ from particle to particle follow from the radii.
                    mass: if species.has_different_masses() { None } else { Some(species.mass) },
                })
                .collect(),
            particles: Vec::new(),
            bonds: scene.bonds.iter().map(|bond| bond.pair).collect(),
            bond_names,
            bond_kinds,
            images: Vec::new(),
            scalars: Vec::new(),
            surfaces: Vec::new(),
            units: scene.units.clone(),
        }
    }

    /// Returns the names of the interactions of all bonds, and the index of each bond's interaction. Both lists are
    /// empty if an interaction has no name.
    #[must_use]
    pub fn kinds_of_bonds(scene: &Scene) -> (Vec<String>, Vec<u32>) {
        let mut names: Vec<String> = Vec::new();
        let mut index_of = HashMap::new();
        let kinds: Option<Vec<u32>> = scene
            .bonds
            .iter()
            .map(|bond| {
                let name = scene.interactions.get(bond.interaction.0 as usize)?.name.as_deref()?;
                Some(*index_of.entry(name).or_insert_with(|| {
                    names.push(name.to_owned());
                    id(names.len() - 1)
                }))
            })
            .collect();
        kinds.map_or_else(Default::default, |kinds| (names, kinds))
    }

    /// Unwrapped position of the particle with index `place` `[length]`. The vectors of the box are `(L_x, 0, 0)`,
    /// `(displacement, L_y, 0)` and `(0, 0, L_z)`. If [`Frame::images`] is empty, returns the position in the box.
    #[must_use]
    pub fn unwrapped(&self, place: usize) -> Vector {
        let position = self.particles[place].position;
        self.images.get(place).map_or(position, |image| {
            let [x, y, z] = image.map(f64::from);
            position + Vector::new(x * self.size.x + y * self.displacement, y * self.size.y, z * self.size.z)
        })
    }

    pub(crate) fn wrapped(&self, position: &Vector) -> Vector {
        let mut position = *position;
        if self.displacement != 0.0 {
            // In a sheared box, a shift by a period along y changes x.
            position.x -= self.displacement * ((position.y - self.lower.y) / self.size.y).floor();
        }
        Vector::from_fn(|k, _| {
            let (edge, x) = (self.size[k], position[k] - self.lower[k]);
            if !self.periodic[k] || edge <= 0.0 {
                return position[k];
            }
            let inside = x.rem_euclid(edge);
            self.lower[k] + if inside < edge { inside } else { 0.0 }
        })
    }

    /// Returns true if the box has no extent along an axis.
    #[must_use]
    pub fn is_flat(&self, axis: usize) -> bool {
        self.size[axis] == 0.0
    }

    /// Axes that are neither periodic nor flat are open.
    pub(crate) fn space(&self) -> Space {
        let boundary = |axis: usize| match self.periodic[axis] {
            true => Boundary::Periodic,
            false if self.is_flat(axis) => Boundary::Flat,
            false => Boundary::OPEN,
        };
        Space { lower: self.lower, size: self.size, boundary: [0, 1, 2].map(boundary) }
    }

    /// Returns the shortest periodic image of a separation vector `[length]`.
    #[must_use]
    pub fn nearest_image(&self, separation: Vector) -> Vector {
        nearest_image(separation, &self.space().periods(), self.displacement)
    }

    /// Extent of the box along flat axes, for readers that reject a box without volume: the largest diameter, or 1.
    pub(super) fn thickness(&self) -> f64 {
        Self::thickness_for(self.particles.iter().map(|particle| particle.radius))
    }

    pub(crate) fn thickness_for(radii: impl Iterator<Item = f64>) -> f64 {
        let widest = radii.map(|radius| 2.0 * radius).fold(0.0, f64::max);
        if widest > 0.0 && widest.is_finite() { widest } else { 1.0 }
    }

    /// Corners of the box `[length]`. Along flat axes, the box extends by half the largest diameter to either side.
    pub(crate) fn thickened(&self) -> (Vector, Vector) {
        let half = 0.5 * self.thickness();
        let extent = |axis: usize| if self.is_flat(axis) { (-half, half) } else { (0.0, self.size[axis]) };
        let corner = |offset: [f64; 3]| self.lower + Vector::from(offset);
        let extents = [extent(0), extent(1), extent(2)];
        (corner(extents.map(|(lower, _)| lower)), corner(extents.map(|(_, upper)| upper)))
    }

    /// Returns true if every output format accepts this name for a scalar.
    pub(super) fn is_name_of_scalar(name: &str) -> bool {
        let is_word = name.bytes().all(|c| c.is_ascii_alphanumeric() || c == b'_');
        !name.is_empty() && is_word && !TAKEN.contains(&name.to_ascii_lowercase().as_str())
    }

    /// The mass of each particle, if all masses are known. Static particles have the mass 0, so sums stay finite.
    pub(crate) fn masses(&self) -> Option<Vec<f64>> {
        let mass = |particle: &FrameParticle| self.species.get(particle.species.0 as usize)?.mass;
        let finite = |mass: f64| if mass.is_finite() { mass } else { 0.0 };
        self.particles.iter().map(|particle| mass(particle).map(finite)).collect()
    }

    /// Returns true for a particle of a static species.
    #[must_use]
    pub fn is_static(&self, particle: &FrameParticle) -> bool {
        self.species.get(particle.species.0 as usize).is_some_and(|species| species.is_static)
    }
}
