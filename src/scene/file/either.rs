//! Values of a scene file that may be written as a boolean, a number, a word, a vector or a table.

use std::fmt;

use serde::Deserialize;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Unexpected, Visitor};

/// Deserializer of a value with several possible types. Types without a function are rejected.
pub(super) struct Either<T, V> {
    /// Permitted notations of the value, for error messages.
    pub expected: &'static str,
    pub of_bool: Option<fn(bool) -> V>,
    pub of_number: Option<fn(f64) -> V>,
    pub of_word: Option<fn(String) -> V>,
    pub of_vector: Option<fn([f64; 3]) -> V>,
    pub of_table: Option<fn(T) -> V>,
}

impl<'de, T: Deserialize<'de>, V> Either<T, V> {
    pub fn new(expected: &'static str, of_table: fn(T) -> V) -> Self {
        Self { of_table: Some(of_table), ..Self::plain(expected) }
    }

    pub fn plain(expected: &'static str) -> Self {
        Self { expected, of_bool: None, of_number: None, of_word: None, of_vector: None, of_table: None }
    }

    pub fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<V, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de, T: Deserialize<'de>, V> Visitor<'de> for Either<T, V> {
    type Value = V;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.expected)
    }

    fn visit_bool<E: Error>(self, is_on: bool) -> Result<V, E> {
        self.of_bool.map(|of| of(is_on)).ok_or_else(|| E::invalid_type(Unexpected::Bool(is_on), &self))
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<V, E> {
        self.of_number.map(|of| of(number)).ok_or_else(|| E::invalid_type(Unexpected::Float(number), &self))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<V, E> {
        self.of_number.map(|of| of(number as f64)).ok_or_else(|| E::invalid_type(Unexpected::Signed(number), &self))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<V, E> {
        self.of_number.map(|of| of(number as f64)).ok_or_else(|| E::invalid_type(Unexpected::Unsigned(number), &self))
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<V, E> {
        self.of_word.map(|of| of(word.to_owned())).ok_or_else(|| E::invalid_type(Unexpected::Str(word), &self))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<V, A::Error> {
        match self.of_vector {
            Some(of) => <[f64; 3]>::deserialize(SeqAccessDeserializer::new(seq)).map(of),
            None => Err(A::Error::invalid_type(Unexpected::Seq, &self)),
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<V, A::Error> {
        match self.of_table {
            Some(of) => T::deserialize(MapAccessDeserializer::new(map)).map(of),
            None => Err(A::Error::invalid_type(Unexpected::Map, &self)),
        }
    }
}
