//! What was typed about measurements: for each kind `true`, or a table of what is to differ.

use std::fmt;
use std::marker::PhantomData;

use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};

use crate::measure::plan::{
    BondOrder, Chains, Diffusion, Flow, FreePaths, PressureTensor, Profile, RadialDistribution, StructureFactor,
    Transport,
};

/// `[measure]`
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct MeasureFile {
    pub pressure_tensor: Switch<PressureTensor>,
    pub radial_distribution: Switch<RadialDistribution>,
    pub structure_factor: Switch<StructureFactor>,
    pub diffusion: Switch<Diffusion>,
    pub transport: Switch<Transport>,
    pub free_paths: Switch<FreePaths>,
    pub chains: Switch<Chains>,
    pub bond_order: Switch<BondOrder>,
    pub profile: Vec<Profile>,
    pub flow: Vec<Flow>,
}

/// `true`, `false`, or a table that says how.
#[derive(Debug, Default)]
pub(crate) struct Switch<T>(pub Option<T>);

impl<'de, T: Deserialize<'de> + Default> Deserialize<'de> for Switch<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct BoolOrTable<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de> + Default> Visitor<'de> for BoolOrTable<T> {
            type Value = Switch<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("true, false or a table")
            }

            fn visit_bool<E: Error>(self, is_on: bool) -> Result<Switch<T>, E> {
                Ok(Switch(is_on.then(T::default)))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Switch<T>, A::Error> {
                T::deserialize(MapAccessDeserializer::new(map)).map(|table| Switch(Some(table)))
            }
        }
        deserializer.deserialize_any(BoolOrTable(PhantomData))
    }
}
