//! The radial distribution function and its value at contact.

mod contact;
mod room;
mod scaled;
mod unequal;

use super::bins::Bins;
use super::budgeted_times::budgeted_times;
use super::instrument::{Instrument, Setup};
use super::quantity::{Curve, Measured, Normalisation, Number};
use super::system::{Sample, SystemDescription};
use crate::analysis::sampling_times::SamplingTimes;
use crate::analysis::statistics::CurveAverage;
use crate::base::numbers::{id, trunc_to_usize};
use crate::base::text::digits;
use crate::engine::CellList;
use crate::model::measurement_plan as plan;
use crate::model::measurement_plan::RADIAL_BINS;
use crate::model::space::{Boundary, Space};
use contact::{CONTACT_BINS, Shell};
use room::Room;
use scaled::{contact_distance, largest_contact_distance, mean_contact_volume};
use serde::{Deserialize, Serialize};
use unequal::Rooms;

/// With more species than this, all moving particles are treated as one species.
const MOST_SPECIES: usize = 8;

/// `g(r)` of each pair of species, except pairs of two static species.
///
/// `g_AB(r) = n_AB(r) / n_ideal(r)`. `n_AB` is the number of pairs in a bin, out of `N_A (N_A - 1) / 2` pairs within
/// one species or `N_A N_B` pairs between two. `n_ideal` is the expected number for uncorrelated points in the same
/// volume.
///
/// If distances are scaled, `r` is the distance of a pair divided by its contact distance. Pairs without hard cores are
/// then left out.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct RadialDistribution {
    times: SamplingTimes,
    asked: f64,
    /// The requested cutoff, or the longest that the box allows `[length]`; if distances are scaled, in units of the
    /// contact distance.
    cutoff: f64,
    /// The largest contact distance of a pair `[length]`, if distances are scaled.
    scaled_by: Option<f64>,
    bins: usize,
    ids: Vec<u32>,
    /// Class of each species; `None` for species that are in no pair.
    classes: Vec<Option<usize>>,
    pairs: Vec<Pair>,
    /// Expected number of pairs in each bin for uncorrelated points. The bins near contact come last.
    ideal: Vec<f64>,
    curve: CurveAverage,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Pair {
    classes: [usize; 2],
    names: [String; 2],
    /// The shell just outside contact. `None` without a core, or if the contact distance is too long for the box.
    shell: Option<Shell>,
}

/// Particles that are treated as one species.
struct Class {
    name: String,
    species: Vec<usize>,
    count: f64,
    is_moving: bool,
}

impl RadialDistribution {
    pub fn new(plan: &plan::RadialDistribution, setup: &Setup<'_>) -> Self {
        let system = setup.system;
        let all = classes(system);
        let scaled_by = plan.scaled.then(|| largest_contact_distance(system));
        let reach = reach(system, scaled_by);
        let asked = plan.cutoff.unwrap_or_else(|| default_cutoff(system, scaled_by));
        let cutoff = asked.min(reach);
        let bins = Bins::planned(plan.bins, RADIAL_BINS);
        let mut pairs = Vec::new();
        let (mut ideal, mut ideal_contact) = (Vec::new(), Vec::new());
        for (a, first) in all.iter().enumerate() {
            for (b, second) in all.iter().enumerate().skip(a).filter(|(_, second)| first.is_moving || second.is_moving)
            {
                let Some(probability) = probability(system, [first, second], (a == b, plan.scaled)) else { continue };
                let number = if a == b { 0.5 * first.count * (first.count - 1.0) } else { first.count * second.count };
                let shell = shell(system, [first, second], plan.scaled).filter(|shell| shell.end <= reach);
                ideal.extend(edges(Bins::over(0.0, cutoff, bins)).map(|[from, to]| number * probability(from, to)));
                let near = shell.map(|shell| edges(shell.bins())).into_iter().flatten();
                let before = ideal_contact.len();
                ideal_contact.extend(near.map(|[from, to]| number * probability(from, to)));
                ideal_contact.resize(before + CONTACT_BINS, 0.0);
                pairs.push(Pair { classes: [a, b], names: [first.name.clone(), second.name.clone()], shell });
            }
        }
        ideal.extend(ideal_contact);
        let mut of_species = vec![None; system.species_names.len()];
        all.iter().enumerate().for_each(|(class, Class { species, .. })| {
            species.iter().for_each(|&species| of_species[species] = Some(class));
        });
        let counts = |&id: &u32| of_species[system.species[id as usize] as usize].is_some();
        let ids: Vec<u32> = (0..id(system.species.len())).filter(counts).collect();
        let mut new = Self {
            times: budgeted_times(setup, plan.interval, 0.0),
            asked,
            cutoff,
            scaled_by,
            bins,
            classes: of_species,
            pairs,
            curve: CurveAverage::new(ideal.len()),
            ideal,
            ids,
        };
        new.times = budgeted_times(setup, plan.interval, new.work(system));
        new
    }

    /// Number of operations per sample, about ten for each pair of particles in neighbouring cells.
    fn work(&self, system: &SystemDescription) -> f64 {
        let count = self.ids.len() as f64;
        let cube = (0..system.space.dimensions()).fold(1.0, |product, _| product * 3.0 * self.range());
        let near = count * cube / system.space.volume();
        50.0 * count + 5.0 * count * near.min(count)
    }

    /// Longest distance at which the instrument needs pairs, for the distribution or for a shell at contact.
    fn range(&self) -> f64 {
        let shells = self.pairs.iter().filter_map(|pair| pair.shell);
        shells.map(|shell| shell.end).fold(self.cutoff, f64::max) * self.scaled_by.unwrap_or(1.0)
    }

    /// Returns the length in whose units the distance of two particles is given; 1 if distances are not scaled.
    fn unit_of(&self, ids: [u32; 2], system: &SystemDescription) -> Option<f64> {
        if self.scaled_by.is_none() {
            return Some(1.0);
        }
        contact_distance(system, ids.map(|id| (system.species[id as usize] as usize, system.diameter_of(id))))
    }

    fn pair_table(&self) -> Vec<Option<usize>> {
        let count = self.classes.iter().flatten().max().map_or(0, |last| last + 1);
        let mut table = vec![None; count * count];
        for (index, &Pair { classes: [a, b], .. }) in self.pairs.iter().enumerate() {
            (table[a * count + b], table[b * count + a]) = (Some(index), Some(index));
        }
        table
    }
}

impl Instrument for RadialDistribution {
    fn next_sample(&self) -> f64 {
        self.times.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        if !self.times.is_due(sample.time) {
            return;
        }
        let table = self.pair_table();
        let count = table.len().isqrt();
        let class = |id: u32| self.classes[system.species[id as usize] as usize];
        let mut numbers = vec![0_u64; self.ideal.len()];
        let first_contact = self.pairs.len() * self.bins;
        let scale = self.bins as f64 / self.cutoff;
        let found = sample.for_each_pair_within(self.range(), &system.space, &self.ids, |near| {
            let ([a, b], square) = (near.ids, near.square);
            let Some(pair) = class(a).zip(class(b)).and_then(|(a, b)| table[a * count + b]) else { return };
            let Some(unit) = self.unit_of([a, b], system) else { return };
            let distance = square.sqrt() / unit;
            let bin = trunc_to_usize(distance * scale);
            if bin < self.bins {
                numbers[pair * self.bins + bin] += 1;
            }
            if let Some(bin) = self.pairs[pair].shell.and_then(|shell| shell.bin(distance)) {
                numbers[first_contact + pair * CONTACT_BINS + bin] += 1;
            }
        });
        // The only possible error is a distance that is too long for the box. No pairs are then counted.
        found.unwrap_or_default();
        self.curve.add_all(numbers.iter().zip(&self.ideal).map(|(&number, ideal)| number as f64 / ideal));
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        if self.pairs.is_empty() {
            return;
        }
        let bins = Bins::over(0.0, self.cutoff, self.bins);
        let centres = edges(bins).map(|[from, to]| 0.5 * (from + to)).collect();
        let (variable, unit) = if self.scaled_by.is_some() { ("r / sigma", "1") } else { ("r", "length") };
        let mut curve = Curve::new("radial_distribution", "Radial distribution function", &self.method(system))
            .variable(variable, unit, centres);
        for (index, pair) in self.pairs.iter().enumerate() {
            let range = index * self.bins..(index + 1) * self.bins;
            let normalisation = Normalisation::of("pairs in the bin, over all samples")
                .by("samples", "1", self.curve.most())
                .by_each("ideal_pairs", "1", self.ideal[range.clone()].to_vec());
            let name = format!("g({}) {}-{}", variable.replace(' ', ""), pair.names[0], pair.names[1]);
            curve = curve.series(&name, "1", &self.curve.estimates(range)).normalised(normalisation);
            measured.numbers.extend(self.contact_value(index, pair));
        }
        measured.curves.push(curve);
    }
}

impl RadialDistribution {
    fn method(&self, system: &SystemDescription) -> String {
        let shell = match system.space.dimensions() {
            3 => "4 pi r^2 dr",
            2 => "2 pi r dr",
            _ => "2 dr",
        };
        let room = if self.scaled_by.is_some() {
            format!(
                "which is the number of pairs times {shell} / V, integrated over the bin, with the mean over the pairs; r is in \
                 units of the contact distance of each pair"
            )
        } else if system.space.is_fully_periodic() {
            format!("which is the number of pairs times {shell} / V, integrated over the bin")
        } else {
            format!(
                "for points spread evenly over the box, less half a diameter at walls: the number of pairs times {shell} / V \
                 with the part of the shell that is inside; without a correction for meshes or for a density profile"
            )
        };
        format!(
            "g(r) = n(r) / n_ideal(r): pairs in a bin of {} divided by the number expected without correlations, {room}; \
             N (N - 1) / 2 pairs of one species, N_A N_B of two{}",
            digits(Bins::over(0.0, self.cutoff, self.bins).width()),
            shortened([self.asked, self.cutoff], &system.space, self.scaled_by)
                .map_or_else(String::new, |why| format!("; {why}"))
        )
    }

    fn contact_value(&self, index: usize, pair: &Pair) -> Option<Number> {
        let shell = pair.shell?;
        let first = self.pairs.len() * self.bins + index * CONTACT_BINS;
        let estimate = contact::extrapolate(&self.curve, &self.ideal, first);
        let [a, b] = &pair.names;
        let method = format!(
            "ln g(r) at r = {}, from a quadratic fit over at most the {CONTACT_BINS} bins up to {}, as far as g(r) is \
             above half of its first values",
            digits(shell.core),
            digits(shell.end)
        );
        let (name, title) = (format!("contact_value_{a}_{b}"), format!("Contact value g(sigma+) {a}-{b}"));
        Some(Number::estimated(&name, &title, "1", estimate, &method))
    }
}

fn edges(bins: Bins) -> impl Iterator<Item = [f64; 2]> {
    (0..bins.count).map(move |bin| [bins.edge(bin), bins.edge(bin + 1)])
}

fn classes(system: &SystemDescription) -> Vec<Class> {
    let mut counts = vec![0_u64; system.species_names.len()];
    system.species.iter().for_each(|&species| counts[species as usize] += 1);
    let mut is_moving = vec![false; counts.len()];
    system.moving.iter().for_each(|&id| is_moving[system.species[id as usize] as usize] = true);
    let present = (0..counts.len()).filter(|&species| counts[species] > 0);
    let one = |species: usize| Class {
        name: system.species_names[species].clone(),
        species: vec![species],
        count: counts[species] as f64,
        is_moving: is_moving[species],
    };
    let all: Vec<Class> = present.clone().map(one).collect();
    if all.len() <= MOST_SPECIES {
        return all;
    }
    let species = present.filter(|&species| is_moving[species]).collect();
    vec![Class { name: "all".to_owned(), species, count: system.moving.len() as f64, is_moving: true }]
}

fn mean_diameter(system: &SystemDescription, class: &Class) -> f64 {
    class.species.iter().map(|&species| system.diameters[species]).sum::<f64>() / class.species.len().max(1) as f64
}

/// The probability that a distance is in a range.
type Probability = Box<dyn Fn(f64, f64) -> f64>;

/// Returns the probability that the distance of two random points, for the particles of two classes, is in a range. If
/// distances are scaled, returns `None` for pairs without hard cores.
fn probability(
    system: &SystemDescription,
    pair: [&Class; 2],
    (is_same, is_scaled): (bool, bool),
) -> Option<Probability> {
    if !is_scaled {
        return Some(room_of(system, pair.map(|class| mean_diameter(system, class))));
    }
    // The box is periodic. In units of the contact distance `sigma`, a shell has a volume proportional to `sigma^D` in `D`
    // dimensions.
    let volume = mean_contact_volume(system, pair, is_same)?;
    let room = Room::new(&system.space, 0.0);
    Some(Box::new(move |from, to| volume * room.probability(from, to)))
}

/// Returns the probability that the distance between two random points is in a range. The points are uniformly
/// distributed over the region that the centre of a particle can reach between walls.
fn room_of(system: &SystemDescription, diameters: [f64; 2]) -> Probability {
    let room = Room::new(&system.space, diameters[0]);
    let shortest = room.shortest();
    if shortest == f64::INFINITY {
        return Box::new(move |from, to| room.probability(from, to));
    }
    let rooms = Rooms::new(&system.space, diameters);
    if diameters[0] != diameters[1] {
        return Box::new(move |from, to| rooms.probability(from, to));
    }
    Box::new(move |from, to| {
        let middle = shortest.clamp(from, to);
        let inside = if from < middle { room.probability(from, middle) } else { 0.0 };
        inside + if middle < to { rooms.probability(middle, to) } else { 0.0 }
    })
}

fn shell(system: &SystemDescription, [first, second]: [&Class; 2], is_scaled: bool) -> Option<Shell> {
    if is_scaled {
        let pairs = first.species.iter().flat_map(|&a| second.species.iter().map(move |&b| (a, b)));
        let step = |(a, b)| Some(system.steps_outside_cores.get(a, b)? / system.cores.get(a, b)?);
        return Some(Shell::new(1.0, pairs.filter_map(step).reduce(f64::min)));
    }
    if !system.own_diameters.is_empty() {
        // Without a common contact distance, there is no contact value.
        return None;
    }
    match (&first.species[..], &second.species[..]) {
        (&[a], &[b]) => system.cores.get(a, b).map(|core| Shell::new(core, system.steps_outside_cores.get(a, b))),
        _ => None,
    }
}

/// Half of the shortest period (without periodic axes, of the longest edge), but at most four of the largest diameters or
/// contact distances.
fn default_cutoff(system: &SystemDescription, scaled_by: Option<f64>) -> f64 {
    if scaled_by.is_some() {
        return reach(system, scaled_by).min(4.0);
    }
    let diameter = system.diameters.iter().copied().fold(0.0, f64::max);
    let half = CellList::largest_range(&system.space).min(0.5 * system.space.size.max());
    if diameter > 0.0 { half.min(4.0 * diameter) } else { half }
}

/// Longest measurable distance: half of the shortest period, or the diagonal of a box without periodic axes. If distances
/// are scaled, it is divided by the largest contact distance.
fn reach(system: &SystemDescription, scaled_by: Option<f64>) -> f64 {
    let reach = CellList::largest_range(&system.space).min(system.space.size.norm());
    scaled_by.filter(|unit| *unit > 0.0).map_or(reach, |unit| reach / unit)
}

/// Explains why a cutoff is shorter than requested.
pub(super) fn shortened([asked, cutoff]: [f64; 2], space: &Space, scaled_by: Option<f64>) -> Option<String> {
    (asked > cutoff).then(|| {
        let [asked, cutoff] = [asked, cutoff].map(digits);
        match (0..3)
            .filter(|&k| space.boundary[k] == Boundary::Periodic)
            .min_by(|&a, &b| space.size[a].total_cmp(&space.size[b]))
        {
            Some(axis) => {
                format!(
                    "the cutoff is {cutoff} instead of {asked}, because it cannot exceed half of the period along {}{}",
                    ["x", "y", "z"][axis],
                    if scaled_by.is_some() { ", divided by the largest contact distance" } else { "" }
                )
            }
            None => {
                format!("the cutoff is {cutoff} instead of {asked}, because it cannot exceed the diagonal of the box")
            }
        }
    })
}

pub(crate) fn shortened_cutoff(plan: &plan::RadialDistribution, system: &SystemDescription) -> Option<String> {
    let asked = plan.cutoff?;
    let scaled_by = plan.scaled.then(|| largest_contact_distance(system));
    shortened([asked, asked.min(reach(system, scaled_by))], &system.space, scaled_by)
}

#[cfg(test)]
mod tests;
