//! Measurements in a scene file. Each kind is `true`, or a table of settings.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer};

use super::either::Either;
use crate::model::measurement_plan::{
    BondOrder, Chains, Diffusion, Flow, FreePaths, PressureTensor, Profile, RadialDistribution, Speeds,
    StructureFactor, SurfaceForces, Transport,
};

/// `[measure]`: what to measure; nothing by default.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct MeasureFile {
    /// Pressure tensor, compressibility factor and rates of events.
    pub pressure_tensor: Switch<PressureTensor>,
    /// Radial distribution function of each pair of species.
    pub radial_distribution: Switch<RadialDistribution>,
    /// Static structure factor.
    pub structure_factor: Switch<StructureFactor>,
    /// Mean squared displacement, velocity autocorrelation and diffusion coefficient.
    pub diffusion: Switch<Diffusion>,
    /// Shear and bulk viscosity and thermal conductivity.
    pub transport: Switch<Transport>,
    /// Distributions of free paths and free times.
    pub free_paths: Switch<FreePaths>,
    /// Distributions of speeds in time windows.
    pub speeds: Switch<Speeds>,
    /// Bond lengths, end-to-end distance and radius of gyration of bonded particles.
    pub chains: Switch<Chains>,
    /// Bond-orientational order.
    pub bond_order: Switch<BondOrder>,
    /// Density, velocity and temperature on grids.
    pub profile: Vec<Profile>,
    /// Flow of particles through planes.
    pub flow: Vec<Flow>,
    /// Forces on walls and other surfaces.
    pub surface_forces: Switch<SurfaceForces>,
}

/// A measurement: `true`, `false`, or a table of settings.
#[derive(Debug, Default)]
pub(crate) struct Switch<T>(pub Option<T>);

impl<'de, T: Deserialize<'de> + Default> Deserialize<'de> for Switch<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let either = Either::new("true, false or a table", |table| Self(Some(table)));
        Either { of_bool: Some(|is_on| Self(is_on.then(T::default))), ..either }.deserialize(deserializer)
    }
}

impl<T: JsonSchema> JsonSchema for Switch<T> {
    fn schema_name() -> Cow<'static, str> {
        format!("Switch_{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({ "anyOf": [{ "type": "boolean" }, generator.subschema_for::<T>()], "default": false })
    }
}
