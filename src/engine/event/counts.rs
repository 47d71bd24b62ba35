//! Event counts by kind and species.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::EventCounts;
use crate::base::numbers::id;
use crate::model::SpeciesId;

/// Kinds of events that are counted separately.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum CountedKind {
    /// Two particles collide at their hard core.
    Core,
    /// Two particles cross a step of their potential inwards.
    Capture,
    /// Two particles cross a step of their potential outwards.
    Release,
    /// Two particles are reflected by a step of their potential.
    Bounce,
    /// Two bonded particles are reflected at the maximum length of their bond.
    Bond,
    /// A particle collides with a wall of the box or with another surface.
    Wall,
    /// A thermostat gives a particle a new velocity.
    Thermostat,
    /// A particle leaves at an outlet.
    Exit,
    /// A particle enters at an inlet.
    Entry,
    /// A particle at rest falls asleep.
    Rest,
    /// A sleeping particle wakes up.
    Wake,
}

impl CountedKind {
    /// Kinds of pair events, in the order of storage.
    const OF_PAIRS: [Self; 5] = [Self::Core, Self::Capture, Self::Release, Self::Bounce, Self::Bond];
    const OF_ONE: [Self; 6] = [Self::Wall, Self::Thermostat, Self::Exit, Self::Entry, Self::Rest, Self::Wake];

    /// Returns the name of this kind of event in files and tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Core => "core",
            Self::Capture => "capture",
            Self::Release => "release",
            Self::Bounce => "bounce",
            Self::Bond => "bond",
            Self::Wall => "wall",
            Self::Thermostat => "thermostat",
            Self::Exit => "exit",
            Self::Entry => "entry",
            Self::Rest => "rest",
            Self::Wake => "wake",
        }
    }
}

/// Numbers of events, by kind and by the species involved.
///
/// Reflections at the maximum length of a bond are counted as [`CountedKind::Bond`] here. [`EventCounts`] counts
/// them as bounces.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct EventCountsBySpecies {
    /// Counts of pair events. The species with the lower index comes first.
    pairs: Pairs,
    singles: BTreeMap<u32, [u64; 6]>,
}

/// Largest number of species for which all pairs are stored. With more species, only pairs with events are stored.
const MOST_LISTED: usize = 128;

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
enum Pairs {
    Listed(Vec<[u64; 5]>),
    Sparse(BTreeMap<(u32, u32), [u64; 5]>),
}

impl Default for Pairs {
    fn default() -> Self {
        Self::Sparse(BTreeMap::new())
    }
}

/// Index of the pair of species `a` and `b`, with `a <= b`, in a triangular array.
fn place(a: usize, b: usize) -> usize {
    b * (b + 1) / 2 + a
}

impl EventCountsBySpecies {
    /// Creates counts of zero for this number of species.
    #[must_use]
    pub fn new(species: usize) -> Self {
        let pairs = if species <= MOST_LISTED {
            Pairs::Listed(vec![[0; 5]; species * (species + 1) / 2])
        } else {
            Pairs::default()
        };
        Self { pairs, singles: BTreeMap::new() }
    }

    pub(crate) fn of_one_species(species: usize, event_counts: &EventCounts) -> Self {
        let mut counts = Self::new(0);
        counts.pairs = Pairs::Sparse(BTreeMap::from([((id(species), id(species)), [event_counts.core, 0, 0, 0, 0])]));
        let EventCounts { wall, thermostat, exit, entry, rest, wake, .. } = *event_counts;
        counts.singles.insert(id(species), [wall, thermostat, exit, entry, rest, wake]);
        counts
    }

    /// Converts counts by table row to counts by species.
    pub(crate) fn of_rows(&self, species: &[SpeciesId]) -> Self {
        if species.iter().zip(0..).all(|(id, row)| id.0 == row) {
            return self.clone();
        }
        let named = |row: u32| species.get(row as usize).map_or(row, |id| id.0);
        let (mut pairs, mut singles) = (BTreeMap::new(), BTreeMap::new());
        // Several rows may belong to one species.
        self.for_each_pair(|[a, b], counts| {
            let (a, b) = (named(a), named(b));
            more(pairs.entry((a.min(b), a.max(b))).or_default(), counts);
        });
        self.singles.iter().for_each(|(row, counts)| more(singles.entry(named(*row)).or_default(), counts));
        Self { pairs: Pairs::Sparse(pairs), singles }
    }

    fn for_each_pair(&self, mut visit: impl FnMut([u32; 2], &[u64; 5])) {
        match &self.pairs {
            Pairs::Sparse(map) => map.iter().for_each(|((a, b), counts)| visit([*a, *b], counts)),
            Pairs::Listed(list) => {
                let pairs = (0..).flat_map(|b| (0..=b).map(move |a| [a, b]));
                pairs.zip(list).for_each(|(pair, counts)| visit(pair, counts));
            }
        }
    }

    #[inline]
    pub(crate) fn note_pair(&mut self, a: usize, b: usize, kind: CountedKind) {
        let (a, b) = (a.min(b), a.max(b));
        let counts = match &mut self.pairs {
            Pairs::Listed(list) => list.get_mut(place(a, b)),
            Pairs::Sparse(map) => {
                #[expect(
                    clippy::cast_possible_truncation,
                    reason = "SceneBuilder::build accepts at most MOST_KINDS species"
                )]
                let pair = (a as u32, b as u32);
                Some(map.entry(pair).or_default())
            }
        };
        if let Some(count) = counts.and_then(|counts| counts.get_mut(kind as usize)) {
            *count += 1;
        }
    }

    pub(crate) fn note_single(&mut self, species: usize, kind: CountedKind) {
        #[expect(clippy::cast_possible_truncation, reason = "SceneBuilder::build accepts at most MOST_KINDS species")]
        let species = species as u32;
        let counts = self.singles.entry(species).or_default();
        if let Some(place) = CountedKind::OF_ONE.iter().position(|it| *it == kind) {
            counts[place] += 1;
        }
    }

    /// Returns the kind, the species and the count for each nonzero count. Two species are in ascending order.
    #[must_use]
    pub fn entries(&self) -> Vec<(CountedKind, Vec<u32>, u64)> {
        let mut entries = Vec::new();
        self.for_each_pair(|pair, counts| {
            for (kind, count) in CountedKind::OF_PAIRS.into_iter().zip(counts).filter(|(_, count)| **count > 0) {
                entries.push((kind, pair.to_vec(), *count));
            }
        });
        for (species, counts) in &self.singles {
            for (kind, count) in CountedKind::OF_ONE.into_iter().zip(counts).filter(|(_, count)| **count > 0) {
                entries.push((kind, vec![*species], *count));
            }
        }
        entries.sort();
        entries
    }

    pub(crate) fn merge(&mut self, part: &Self) {
        match (&mut self.pairs, &part.pairs) {
            (Pairs::Listed(all), Pairs::Listed(some)) => {
                all.iter_mut().zip(some).for_each(|(all, some)| more(all, some))
            }
            (Pairs::Sparse(all), Pairs::Sparse(some)) => {
                some.iter().for_each(|(pair, some)| more(all.entry(*pair).or_default(), some));
            }
            _ => debug_assert!(false, "of as many species"),
        }
        part.singles.iter().for_each(|(species, some)| more(self.singles.entry(*species).or_default(), some));
    }

    /// Returns the counts since `earlier`.
    #[must_use]
    pub fn since(&self, earlier: &Self) -> Self {
        let mut since = self.clone();
        match (&mut since.pairs, &earlier.pairs) {
            (Pairs::Listed(now), Pairs::Listed(before)) => now.iter_mut().zip(before).for_each(|(now, b)| less(now, b)),
            (Pairs::Sparse(now), Pairs::Sparse(before)) => {
                before.iter().for_each(|(pair, b)| less(now.entry(*pair).or_default(), b));
            }
            // The tables have different forms only if the earlier counts are empty.
            _ => {}
        }
        for (species, before) in &earlier.singles {
            less(since.singles.entry(*species).or_default(), before);
        }
        since
    }
}

fn more<const N: usize>(all: &mut [u64; N], some: &[u64; N]) {
    all.iter_mut().zip(some).for_each(|(all, some)| *all += some);
}

fn less<const N: usize>(now: &mut [u64; N], before: &[u64; N]) {
    now.iter_mut().zip(before).for_each(|(now, before)| *now = now.saturating_sub(*before));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn event_counts_are_equal_for_few_and_many_species() {
        let (mut few, mut many) = (EventCountsBySpecies::new(3), EventCountsBySpecies::new(MOST_LISTED + 1));
        for counts in [&mut few, &mut many] {
            counts.note_pair(2, 0, CountedKind::Core);
            let before = counts.clone();
            counts.note_pair(0, 2, CountedKind::Core);
            counts.note_pair(1, 1, CountedKind::Bond);
            counts.note_single(1, CountedKind::Thermostat);
            counts.note_single(2, CountedKind::Wall);
            let since = counts.since(&before);
            let of = |kind, species: &[u32]| {
                let entries = since.entries();
                entries.iter().find(|(k, s, _)| *k == kind && s == species).map_or(0, |(_, _, count)| *count)
            };
            assert_eq!((of(CountedKind::Core, &[0, 2]), of(CountedKind::Bond, &[1, 1])), (1, 1));
            assert_eq!((of(CountedKind::Thermostat, &[1]), of(CountedKind::Wall, &[2])), (1, 1));
        }
        assert_eq!(few.entries(), many.entries());
        assert_eq!(few.entries()[0], (CountedKind::Core, vec![0, 2], 2));
    }
}
