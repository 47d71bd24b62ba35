//! Numbers that vary inside lists and tables of the scene. Each number has a column in the tables of the sweep.

use std::collections::BTreeMap;

use toml::Value;

use super::plan::{Point, Sweep};
use super::value::value_of;

/// A number that varies inside a list or table of the scene. For example, `gravity_2` is the number at index 2 of
/// `dynamics.gravity`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    key: String,
    name: String,
    /// Place of the number in the value: `2`, or `0_1` in a list of lists. It is empty for a plain number.
    place: String,
}

impl Entry {
    /// Unique name of the column: the name of the key, then the place of the number in the value.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Key of the value in the scene, such as `dynamics.gravity`.
    #[must_use]
    pub fn key(&self) -> &str {
        &self.key
    }

    /// Returns the number at a point of the sweep; `None` if the value at this point lacks the number.
    #[must_use]
    pub fn of(&self, point: &Point) -> Option<f64> {
        let (_, value) = point.settings().iter().find(|(key, _)| *key == self.key)?;
        numbers(value).remove(&self.place)
    }
}

impl Sweep {
    /// Returns the numbers that vary inside lists and tables. Plain numbers are not included.
    #[must_use]
    pub fn entries(&self) -> Vec<Entry> {
        self.numbers().into_iter().filter(|entry| !entry.place.is_empty()).collect()
    }

    /// Returns all numbers that vary, in the order of the keys. Plain numbers are included.
    pub(crate) fn numbers(&self) -> Vec<Entry> {
        let names = self.state_point_names();
        let keys = self.points().first().into_iter().flat_map(Point::state_point).map(|(key, _)| key);
        keys.zip(names).flat_map(|(key, name)| self.numbers_of(key, &name)).collect()
    }

    fn numbers_of(&self, key: &str, name: &str) -> Vec<Entry> {
        let settings = self.points().iter().flat_map(Point::settings).filter(|(other, _)| other == key);
        let mut all: Vec<BTreeMap<String, f64>> = settings.map(|(_, value)| numbers(value)).collect();
        let Some(first) = all.pop() else { return Vec::new() };
        let varies = |place: &String, number: f64| {
            let others: Option<Vec<f64>> = all.iter().map(|it| it.get(place).copied()).collect();
            others.is_some_and(|others| others.iter().any(|other| *other != number))
        };
        let entry = |place: String| {
            let name = if place.is_empty() { name.to_owned() } else { format!("{name}_{place}") };
            Entry { key: key.to_owned(), name, place }
        };
        first.into_iter().filter(|(place, number)| varies(place, *number)).map(|(place, _)| entry(place)).collect()
    }
}

fn numbers(text: &str) -> BTreeMap<String, f64> {
    let mut all = BTreeMap::new();
    gather(&value_of(text), String::new(), &mut all);
    all
}

fn gather(value: &Value, place: String, all: &mut BTreeMap<String, f64>) {
    let within = |entry: String| if place.is_empty() { entry } else { format!("{place}_{entry}") };
    match value {
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(at, it)| gather(it, within(at.to_string()), all));
        }
        Value::Table(table) => table.iter().for_each(|(word, it)| gather(it, within(word.clone()), all)),
        #[expect(clippy::cast_precision_loss, reason = "an axis, not a checksum")]
        Value::Integer(number) => drop(all.insert(place, *number as f64)),
        Value::Float(number) if number.is_finite() => drop(all.insert(place, *number)),
        _ => {}
    }
}
