//! Measurements in a scene file. Each kind is `true`, or a table of settings.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer};

use super::either::Either;
use crate::model::measurement_plan as plan;

/// In a scene file, these types replace the containers of a plan.
mod container {
    pub type Option<T> = super::Switch<T>;
    pub type Vec<T> = std::vec::Vec<T>;
}

macro_rules! measure_file {
    ($($(#[$doc:meta])* $key:ident = $field:ident: $container:ident<$settings:ident> $rules:tt)*) => {
        /// `[measure]`: what to measure; nothing by default.
        #[derive(Debug, Default, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub(crate) struct MeasureFile {
            $($(#[$doc])* $key: container::$container<plan::$settings>,)*
        }

        impl From<MeasureFile> for plan::MeasurementPlan {
            fn from(file: MeasureFile) -> Self {
                Self { $($field: file.$key.into(),)* }
            }
        }
    };
}

plan::with_instruments!(measure_file);

/// A measurement: `true`, `false`, or a table of settings.
#[derive(Debug, Default)]
pub(crate) struct Switch<T>(Option<T>);

impl<T> From<Switch<T>> for Option<T> {
    fn from(switch: Switch<T>) -> Self {
        switch.0
    }
}

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
