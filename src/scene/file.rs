//! What was typed: the TOML of a scene, key by key, before anything is made of it.

mod drive;
mod measure;
mod sizes;

pub(crate) use drive::{GrowthFile, StageFile, ThermostatFile};
pub(crate) use measure::MeasureFile;
pub(crate) use sizes::{DiameterFile, DistributionFile};

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};

/// A whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SceneFile {
    pub name: Option<String>,
    pub seed: Option<u64>,
    pub start_time: Option<f64>,
    #[serde(default)]
    pub allow_invalid_start: bool,
    #[serde(default)]
    pub space: SpaceFile,
    #[serde(default)]
    pub dynamics: DynamicsFile,
    #[serde(default)]
    pub species: Vec<SpeciesFile>,
    #[serde(default)]
    pub interaction: Vec<InteractionFile>,
    #[serde(default)]
    pub particle: Vec<ParticleFile>,
    #[serde(default)]
    pub file: Vec<CoordinatesFile>,
    #[serde(default)]
    pub chain: Vec<ChainFile>,
    #[serde(default)]
    pub fill: Vec<FillFile>,
    #[serde(default)]
    pub mesh: Vec<MeshFile>,
    #[serde(default)]
    pub bond: Vec<BondFile>,
    #[serde(default)]
    pub audit: AuditFile,
    #[serde(default)]
    pub stage: Vec<StageFile>,
    pub run: Option<RunFile>,
    #[serde(default)]
    pub measure: MeasureFile,
    #[serde(default)]
    pub output: OutputFile,
}

/// `[space]`
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpaceFile {
    pub size: Option<[f64; 3]>,
    pub lower: Option<[f64; 3]>,
    pub shear_rate: Option<f64>,
    pub x: Option<AxisFile>,
    pub y: Option<AxisFile>,
    pub z: Option<AxisFile>,
}

/// `"periodic"`, or `{ lower = "wall", upper = "open", restitution = 0.5 }`
#[derive(Debug)]
pub(crate) enum AxisFile {
    Word(String),
    Sides(SidesFile),
}

/// The two sides of an axis.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SidesFile {
    pub lower: String,
    pub upper: String,
    pub restitution: Option<f64>,
}

impl<'de> Deserialize<'de> for AxisFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct WordOrSides;
        impl<'de> Visitor<'de> for WordOrSides {
            type Value = AxisFile;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("\"periodic\", \"open\", \"walls\", \"flat\" or { lower = ..., upper = ... }")
            }

            fn visit_str<E: Error>(self, word: &str) -> Result<AxisFile, E> {
                Ok(AxisFile::Word(word.to_owned()))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<AxisFile, A::Error> {
                SidesFile::deserialize(MapAccessDeserializer::new(map)).map(AxisFile::Sides)
            }
        }
        deserializer.deserialize_any(WordOrSides)
    }
}

/// `[dynamics]`
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DynamicsFile {
    pub gravity: Option<[f64; 3]>,
    pub contact_time: Option<f64>,
}

/// `[[species]]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpeciesFile {
    pub name: String,
    pub diameter: DiameterFile,
    pub mass: Option<f64>,
    #[serde(default, rename = "static")]
    pub is_static: bool,
    pub acceleration: Option<[f64; 3]>,
}

/// `[[interaction]]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct InteractionFile {
    pub name: Option<String>,
    pub species: Option<[String; 2]>,
    pub potential: String,
    pub diameter: Option<f64>,
    pub lambda: Option<f64>,
    pub well_depth: Option<f64>,
    pub height: Option<f64>,
    pub shortest: Option<f64>,
    pub longest: Option<f64>,
    pub radii: Option<Vec<f64>>,
    pub energies: Option<Vec<f64>>,
    pub cutoff: Option<f64>,
    pub steps: Option<u64>,
    pub core_energy: Option<f64>,
    pub restitution: Option<f64>,
}

/// `[[particle]]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParticleFile {
    pub species: String,
    pub position: [f64; 3],
    #[serde(default)]
    pub velocity: [f64; 3],
}

/// `[[file]]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CoordinatesFile {
    pub path: String,
    #[serde(default)]
    pub frame: u64,
}

/// `[[chain]]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ChainFile {
    pub species: String,
    pub length: u64,
    pub count: Option<u64>,
    pub bond: String,
    pub spacing: Option<f64>,
    pub start: Option<[f64; 3]>,
    pub direction: Option<[f64; 3]>,
    pub temperature: Option<f64>,
}

/// `[[fill]]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FillFile {
    pub species: Option<String>,
    pub composition: Option<BTreeMap<String, f64>>,
    pub arrangement: String,
    pub count: Option<u64>,
    pub number_density: Option<f64>,
    pub packing_fraction: Option<f64>,
    pub region: Option<RegionFile>,
    pub temperature: Option<f64>,
    pub velocity: Option<[f64; 3]>,
}

/// `{ lower = [...], upper = [...] }`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RegionFile {
    pub lower: [f64; 3],
    pub upper: [f64; 3],
}

/// `[[mesh]]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MeshFile {
    pub name: Option<String>,
    pub species: String,
    pub surface: String,
    pub spacing: Option<f64>,
    pub corner: Option<[f64; 3]>,
    pub edge_1: Option<[f64; 3]>,
    pub edge_2: Option<[f64; 3]>,
    pub lower: Option<[f64; 3]>,
    pub upper: Option<[f64; 3]>,
    pub open: Option<Vec<String>>,
    pub base: Option<[f64; 3]>,
    pub axis: Option<[f64; 3]>,
    pub length: Option<f64>,
    pub radii: Option<[f64; 2]>,
    pub radius: Option<f64>,
    pub centre: Option<[f64; 3]>,
    pub points: Option<Vec<[f64; 3]>>,
}

/// `[[bond]]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BondFile {
    pub particles: [u32; 2],
    pub interaction: String,
}

/// `[audit]`
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct AuditFile {
    pub energy: Option<f64>,
    pub momentum: Option<f64>,
    pub overlap: Option<f64>,
}

/// `[run]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RunFile {
    pub equilibration_time: Option<f64>,
    pub equilibration_events: Option<u64>,
    pub until_time: Option<f64>,
    pub until_events: Option<u64>,
    pub thermostat: Option<ThermostatFile>,
}

/// `[output]`
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct OutputFile {
    pub thermo_interval: Option<f64>,
    pub frame_interval: Option<f64>,
    #[serde(default)]
    pub contacts: bool,
    #[serde(default)]
    pub count: Vec<CountFile>,
}

/// `[[output.count]]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CountFile {
    pub name: String,
    pub lower: [f64; 3],
    pub upper: [f64; 3],
}
