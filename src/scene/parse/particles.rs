//! Parses the tables of particles: chains, fills and static-sphere surfaces.

use std::collections::BTreeMap;

use super::{Keys, variant, vector};
use crate::model::FillRegion;
use crate::model::Region;
use crate::prepare::surface::{BoxSide, Surface};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing, refuse};
use crate::scene::file::{ChainFile, FillFile, MeshFile, RegionFile};
use crate::scene::unvalidated::{Amount, Arrangement, Chain, Fill, Lattice, SurfaceFill};

pub(super) fn parse_chain(file: ChainFile, at: &ConfigPath) -> Result<Chain, SceneError> {
    let straight = match (file.start, file.direction) {
        (Some(start), Some(direction)) => Some((vector(start), vector(direction))),
        (None, None) => None,
        (Some(_), None) => return Err(missing(at, "direction", "a straight chain needs a start and a direction")),
        (None, Some(_)) => return Err(missing(at, "start", "a straight chain needs a start and a direction")),
    };
    Ok(Chain {
        species: file.species,
        length: file.length,
        count: file.count.unwrap_or(1),
        bond: file.bond,
        spacing: file.spacing,
        straight,
        temperature: file.temperature,
        speed: file.speed,
    })
}

pub(crate) const ARRANGEMENTS: [(&str, Arrangement); 8] = [
    ("sc", Arrangement::Lattice(Lattice::SimpleCubic)),
    ("bcc", Arrangement::Lattice(Lattice::BodyCentredCubic)),
    ("fcc", Arrangement::Lattice(Lattice::FaceCentredCubic)),
    ("hcp", Arrangement::Lattice(Lattice::HexagonalClosePacked)),
    ("square", Arrangement::Lattice(Lattice::Square)),
    ("hexagonal", Arrangement::Lattice(Lattice::Hexagonal)),
    ("line", Arrangement::Lattice(Lattice::Line)),
    ("random", Arrangement::Random),
];

pub(super) fn parse_fill(file: FillFile, at: &ConfigPath, has_size: bool) -> Result<Fill, SceneError> {
    let arrangement = *variant(&ARRANGEMENTS, "arrangement", &file.arrangement, &at.key("arrangement"))?;
    let contradiction =
        |key: &'static str, given: &str| refuse(at.key(key), "given as well", format!("either {key} or {given}"));
    let amount = match (file.number_density, file.packing_fraction) {
        (Some(_), Some(_)) => return contradiction("packing_fraction", "number_density"),
        (Some(density), None) => Some(Amount::NumberDensity(density)),
        (None, Some(fraction)) => Some(Amount::PackingFraction(fraction)),
        (None, None) => None,
    };
    if amount.is_some() && file.count.is_some() && (has_size || file.region.is_some()) {
        return contradiction("count", "a density, because the volume is given");
    }
    Ok(Fill {
        composition: composition(file.species, file.composition, at)?,
        arrangement,
        count: file.count,
        amount,
        as_many_as_fit: file.as_many_as_fit,
        region: file.region.map(|region| parse_region(&region, &at.key("region"))).transpose()?,
        temperature: file.temperature,
        speed: file.speed,
        velocity: vector(file.velocity.unwrap_or_default()),
    })
}

/// Returns the species of a fill or inlet, and their relative numbers.
pub(super) fn composition(
    species: Option<String>,
    composition: Option<BTreeMap<String, f64>>,
    at: &ConfigPath,
) -> Result<Vec<(String, f64)>, SceneError> {
    match (species, composition) {
        (Some(_), Some(_)) => refuse(at.key("composition"), "given as well", "either composition or species"),
        (Some(species), None) => Ok(vec![(species, 1.0)]),
        (None, Some(composition)) => Ok(composition.into_iter().collect()),
        (None, None) => Err(missing(at, "species", "give it, or composition for a mixture")),
    }
}

pub(crate) const REGIONS: [(&str, &[&str]); 4] = [
    ("box", &["lower", "upper"]),
    ("cylinder", &["base", "axis", "radius", "length"]),
    ("cone", &["base", "axis", "radii", "length"]),
    ("sphere", &["centre", "radius"]),
];

pub(super) fn parse_region(file: &RegionFile, at: &ConfigPath) -> Result<FillRegion, SceneError> {
    let (word, keys) = Keys::of_kind(&REGIONS, "shape", file.shape.as_deref().unwrap_or("box"), at, file)?;
    Ok(match word {
        "box" => FillRegion::Box(Region { lower: keys.vector("lower")?, upper: keys.vector("upper")? }),
        "sphere" => FillRegion::Sphere { centre: keys.vector("centre")?, radius: keys.need("radius")? },
        _ => FillRegion::Cone {
            base: keys.vector("base")?,
            axis: keys.vector("axis")?,
            radii: keys.radii_of_ends(word)?,
            length: keys.need("length")?,
        },
    })
}

pub(crate) const SURFACES: [(&str, &[&str]); 9] = [
    ("plane", &["corner", "edge_1", "edge_2"]),
    ("box", &["lower", "upper", "open"]),
    ("cylinder", &["base", "axis", "radius", "length"]),
    ("cone", &["base", "axis", "radii", "length"]),
    ("sphere", &["centre", "radius"]),
    ("line", &["start", "end"]),
    ("ring", &["centre", "radius"]),
    ("rectangle", &["lower", "upper", "open"]),
    ("points", &["points"]),
];

pub(super) fn parse_surface(file: MeshFile, at: &ConfigPath) -> Result<SurfaceFill, SceneError> {
    let (word, keys) = Keys::of_kind(&SURFACES, "surface", &file.surface, at, &file)?;
    let open = || parse_sides(file.open.as_deref().unwrap_or_default(), at);
    let shape = match word {
        "plane" => {
            Surface::Plane { corner: keys.vector("corner")?, edges: [keys.vector("edge_1")?, keys.vector("edge_2")?] }
        }
        "box" => Surface::Box { lower: keys.vector("lower")?, upper: keys.vector("upper")?, open: open()? },
        "cylinder" | "cone" => Surface::Cone {
            base: keys.vector("base")?,
            axis: keys.vector("axis")?,
            radii: keys.radii_of_ends(word)?,
            length: keys.need("length")?,
        },
        "sphere" => Surface::Sphere { centre: keys.vector("centre")?, radius: keys.need("radius")? },
        "line" => Surface::Line { ends: [keys.vector("start")?, keys.vector("end")?] },
        "ring" => Surface::Ring { centre: keys.vector("centre")?, radius: keys.need("radius")? },
        "rectangle" => Surface::Rectangle { lower: keys.vector("lower")?, upper: keys.vector("upper")?, open: open()? },
        _ => Surface::Points(keys.need::<Vec<[f64; 3]>>("points")?.into_iter().map(vector).collect()),
    };
    Ok(SurfaceFill { name: file.name, species: file.species, shape, spacing: file.spacing })
}

fn parse_sides(words: &[String], at: &ConfigPath) -> Result<Vec<BoxSide>, SceneError> {
    let side =
        |(index, word): (usize, &String)| variant(&BoxSide::NAMES, "side", word, &at.key("open").index(index)).copied();
    words.iter().enumerate().map(side).collect()
}
