//! A symmetric table: one value for each pair of species.

use crate::base::numbers::id;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Largest number of species for a dense table.
const FEW: usize = 256;

/// A symmetric table over pairs of species. With many species, only pairs with a value use memory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpeciesPairs<T> {
    species: usize,
    values: Values<T>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum Values<T> {
    /// Table with a row for each species. Only entries with row <= column are used.
    All(Vec<Option<T>>),
    /// Values by pair of species, with the lower species index first.
    Some(BTreeMap<(u32, u32), T>),
}

impl<T: Copy> Default for SpeciesPairs<T> {
    fn default() -> Self {
        Self::new(0)
    }
}

impl<T: Copy> SpeciesPairs<T> {
    /// A table for this number of species, without values.
    #[must_use]
    pub fn new(species: usize) -> Self {
        let values = match species {
            0..=FEW => Values::All(vec![None; species * species]),
            _ => Values::Some(BTreeMap::new()),
        };
        Self { species, values }
    }

    pub(crate) fn species(&self) -> usize {
        self.species
    }

    /// Returns the value for two species, in any order.
    #[inline]
    #[must_use]
    pub fn get(&self, a: usize, b: usize) -> Option<T> {
        let (a, b) = (a.min(b), a.max(b));
        match &self.values {
            Values::All(values) => values[a * self.species + b],
            Values::Some(values) => values.get(&(id(a), id(b))).copied(),
        }
    }

    /// Sets the value for two species, in any order.
    pub fn set(&mut self, a: usize, b: usize, value: T) {
        let (a, b) = (a.min(b), a.max(b));
        match &mut self.values {
            Values::All(values) => values[a * self.species + b] = Some(value),
            Values::Some(values) => {
                values.insert((id(a), id(b)), value);
            }
        }
    }

    /// Returns all pairs with a value in ascending order, each pair once.
    pub fn iter(&self) -> impl Iterator<Item = ([usize; 2], T)> + Clone + '_ {
        let (all, some) = match &self.values {
            Values::All(values) => (Some(values), None),
            Values::Some(values) => (None, Some(values)),
        };
        let species = self.species;
        let cells = all.into_iter().flat_map(|values| values.iter().enumerate());
        let few = cells.filter_map(move |(cell, value)| value.map(|value| ([cell / species, cell % species], value)));
        let entries = some.into_iter().flat_map(BTreeMap::iter);
        few.chain(entries.map(|(&(a, b), &value)| ([a as usize, b as usize], value)))
    }

    /// Replaces each value by the result of `of`. If the result is `None`, the pair has no value in the new table.
    #[must_use]
    pub fn map<U: Copy>(&self, of: impl Fn(T) -> Option<U>) -> SpeciesPairs<U> {
        let mut mapped = SpeciesPairs::new(self.species);
        for ([a, b], value) in self.iter() {
            if let Some(value) = of(value) {
                mapped.set(a, b, value);
            }
        }
        mapped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_and_many_species_have_the_same_table() {
        for species in [3, FEW, FEW + 1, 1_000_000] {
            let mut pairs = SpeciesPairs::new(species);
            pairs.set(2, 0, 'a');
            pairs.set(1, 1, 'b');
            pairs.set(0, 2, 'c');
            assert_eq!(
                [pairs.get(0, 2), pairs.get(2, 0), pairs.get(1, 1), pairs.get(1, 2)],
                [Some('c'), Some('c'), Some('b'), None]
            );
            assert_eq!(pairs.iter().collect::<Vec<_>>(), [([0, 2], 'c'), ([1, 1], 'b')], "{species}");
            let mapped = pairs.map(|value| (value == 'b').then_some(1));
            assert_eq!(mapped.iter().collect::<Vec<_>>(), [([1, 1], 1)]);
        }
    }
}
