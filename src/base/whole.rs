//! Integers as users write them: `100000`, `1e5` or `8.0`.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Deserialize, Deserializer, Error, Unexpected, Visitor};

use super::numbers;

pub(crate) fn number<'de, D: Deserializer<'de>, T: Integer<'de>>(deserializer: D) -> Result<T, D::Error> {
    Whole::deserialize(deserializer).map(|Whole(number)| number)
}

pub(crate) fn given<'de, D: Deserializer<'de>, T: Integer<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
    Option::deserialize(deserializer).map(|given| given.map(|Whole(number)| number))
}

pub(crate) fn several<'de, D, T, const N: usize>(deserializer: D) -> Result<[T; N], D::Error>
where
    D: Deserializer<'de>,
    T: Integer<'de>,
    [Whole<T>; N]: Deserialize<'de>,
{
    <[Whole<T>; N]>::deserialize(deserializer).map(|numbers| numbers.map(|Whole(number)| number))
}

pub(crate) fn lists<'de, D, T, const N: usize>(deserializer: D) -> Result<[Vec<T>; N], D::Error>
where
    D: Deserializer<'de>,
    T: Integer<'de>,
    [Vec<Whole<T>>; N]: Deserialize<'de>,
{
    let lists = <[Vec<Whole<T>>; N]>::deserialize(deserializer)?;
    Ok(lists.map(|list| list.into_iter().map(|Whole(number)| number).collect()))
}

pub(crate) trait Integer<'de>: TryFrom<i64> + Deserialize<'de> {}

impl<'de, T: TryFrom<i64> + Deserialize<'de>> Integer<'de> for T {}

pub(crate) struct Whole<T>(T);

impl<'de, T: Integer<'de>> Deserialize<'de> for Whole<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        // Binary formats, such as the checkpoint format, store plain integers.
        if !deserializer.is_human_readable() {
            return T::deserialize(deserializer).map(Self);
        }
        deserializer.deserialize_any(Typed(PhantomData))
    }
}

struct Typed<T>(PhantomData<T>);

impl<'de, T: Integer<'de>> Visitor<'de> for Typed<T> {
    type Value = Whole<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(std::any::type_name::<T>())
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Whole<T>, E> {
        T::try_from(number).map(Whole).map_err(|_| E::invalid_value(Unexpected::Signed(number), &self))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Whole<T>, E> {
        let signed = i64::try_from(number).ok().and_then(|number| T::try_from(number).ok());
        signed.map(Whole).ok_or_else(|| E::invalid_value(Unexpected::Unsigned(number), &self))
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Whole<T>, E> {
        let is_whole = number.fract() == 0.0 && number.abs() < numbers::MOST_EXACT;
        let whole = is_whole.then(|| numbers::trunc_to_i64(number)).and_then(|number| T::try_from(number).ok());
        whole.map(Whole).ok_or_else(|| E::invalid_type(Unexpected::Float(number), &self))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Serialize;

    #[derive(Debug, PartialEq, serde::Deserialize, Serialize)]
    struct Keys {
        #[serde(deserialize_with = "number")]
        count: u64,
        #[serde(deserialize_with = "number")]
        frame: i64,
        #[serde(default, deserialize_with = "given")]
        bins: Option<u64>,
        #[serde(deserialize_with = "several")]
        pair: [u32; 2],
    }

    fn read(count: &str, frame: &str, bins: &str, pair: &str) -> Result<Keys, String> {
        let text = format!("count = {count}\nframe = {frame}\n{bins}\npair = {pair}\n");
        toml::from_str(&text).map_err(|error| error.message().to_owned())
    }

    #[test]
    fn whole_numbers_may_have_an_exponent_or_a_decimal_point() {
        let keys = Keys { count: 100_000, frame: -1, bins: Some(8), pair: [0, 4_294_967_295] };
        for (count, frame, bins, pair) in [
            ("100_000", "-1", "bins = 8", "[0, 4294967295]"),
            ("1e5", "-1.0", "bins = 8.0", "[0.0, 4.294967295e9]"),
            ("0.1e6", "-1e0", "bins = 80E-1", "[-0.0, 4294967295.0]"),
        ] {
            assert_eq!(read(count, frame, bins, pair).as_ref(), Ok(&keys), "{count}");
        }
        assert_eq!(read("9007199254740991.0", "0", "", "[0, 0]").unwrap().count, 9_007_199_254_740_991);
        let bytes = postcard::to_stdvec(&keys).unwrap();
        assert_eq!(postcard::from_bytes::<Keys>(&bytes).unwrap(), keys, "the keys, read back from a checkpoint");
    }

    #[test]
    fn invalid_whole_numbers_are_quoted_as_typed() {
        let refused = |count: &str, pair: &str| read(count, "0", "", pair).unwrap_err();
        assert_eq!(refused("8.5", "[0, 0]"), "invalid type: floating point `8.5`, expected u64");
        assert_eq!(
            refused("9007199254740992.0", "[0, 0]"),
            "invalid type: floating point `9007199254740992.0`, expected u64"
        );
        assert_eq!(refused("-8", "[0, 0]"), "invalid value: integer `-8`, expected u64");
        assert_eq!(refused("-8.0", "[0, 0]"), "invalid type: floating point `-8.0`, expected u64");
        assert_eq!(refused("inf", "[0, 0]"), "invalid type: floating point `inf`, expected u64");
        assert_eq!(refused("'8'", "[0, 0]"), "invalid type: string \"8\", expected u64");
        assert_eq!(refused("8", "[0, 1e10]"), "invalid type: floating point `10000000000.0`, expected u32");
    }
}
