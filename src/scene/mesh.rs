//! Whether the meshes of a scene hold what moves in it.

use std::ops::Range;

use crate::scene::draft::MeshDraft;
use crate::scene::occupancy::Contacts;
use crate::scene::surface::Layout;
use crate::scene::{ParticleId, Scene, SpeciesId};

/// A surface of static spheres.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Its name, or its number among the meshes.
    pub name: String,
    /// The static species.
    pub species: SpeciesId,
    /// Ids of its spheres.
    pub particles: Range<u32>,
    /// Largest circumradius of a hole between them `[length]`; `None` for spheres at given places.
    pub hole: Option<f64>,
    /// The spheres along its open ends.
    pub rim: Vec<ParticleId>,
}

impl Mesh {
    pub(crate) fn new(draft: &MeshDraft, species: SpeciesId, first: usize, layout: &Layout, number: usize) -> Self {
        let id = |index: usize| (first + index) as u32;
        Self {
            name: draft.name.clone().unwrap_or_else(|| format!("mesh {number}")),
            species,
            particles: id(0)..id(layout.points.len()),
            hole: layout.hole,
            rim: layout.rim.iter().map(|&index| ParticleId(id(index))).collect(),
        }
    }
}

/// A mesh that a species passes through.
#[derive(Debug, Clone, PartialEq)]
pub struct Leak {
    /// The mesh, by name.
    pub mesh: String,
    /// The species, by name.
    pub species: String,
    /// Circumradius of the largest hole `[length]`.
    pub hole: f64,
    /// Contact distance of the species and the mesh `[length]`; 0 if they do not collide at all.
    pub contact: f64,
}

/// Two meshes that come near each other but leave a gap: a joint that leaks, unless it is meant as an opening.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    /// The mesh whose open end it is, by name.
    pub mesh: String,
    /// The mesh nearest to it, by name.
    pub other: String,
    /// Distance of the sphere on the rim to the nearest one of the other mesh `[length]`.
    pub width: f64,
    /// The sphere on the rim.
    pub at: ParticleId,
    /// The species that passes, by name.
    pub species: String,
}

impl Scene {
    /// The meshes that leak, and what they leak.
    ///
    /// A species passes a hole of circumradius `R` if its contact distance `s` with the mesh spheres is less than `R`.
    #[must_use]
    pub fn leaks(&self) -> Vec<Leak> {
        let contacts = self.contacts();
        let mut leaks = Vec::new();
        for mesh in &self.meshes {
            let Some(hole) = mesh.hole else { continue };
            for (index, species) in self.species.iter().enumerate().filter(|(_, species)| !species.is_static()) {
                let contact = contacts.get(index, mesh.species.0 as usize);
                if contact < hole {
                    leaks.push(Leak { mesh: mesh.name.clone(), species: species.name.clone(), hole, contact });
                }
            }
        }
        leaks
    }

    /// The distances that cores keep.
    pub(crate) fn contacts(&self) -> Contacts {
        let mut contacts = Contacts::new(self.species.len());
        for a in 0..self.species.len() {
            for b in a..self.species.len() {
                if let Some(id) = self.interaction_of(SpeciesId(a as u32), SpeciesId(b as u32)) {
                    let core = self.interactions[id.0 as usize].potential.core();
                    contacts.set(a, b, core.unwrap_or(0.0));
                }
            }
        }
        contacts
    }
}
