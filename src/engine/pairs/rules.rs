//! The interactions of a scene in the form that the event loop needs.

use super::rows::Rows;
use super::states::PairState;
use crate::Vector;
use crate::model::{Interaction, Scene, Species, SpeciesId};
use crate::physics::overlap::Side;
use crate::physics::response::ContactLaw;
use serde::{Deserialize, Serialize};

/// A discontinuity of a potential, as seen by a pair in a given state.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Discontinuity {
    /// Distance `s` of the particles at the discontinuity `[length]`.
    pub distance: f64,
    /// `s^2` `[length^2]`.
    pub squared: f64,
    /// Change of the potential energy when the pair crosses the discontinuity `[energy]`.
    pub energy_step: f64,
}

/// Discontinuities and energies of a potential for each pair state.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Steps {
    /// Outer discontinuity of each pair state; `None` in state 0.
    outer: Vec<Option<Discontinuity>>,
    /// Inner discontinuity of each pair state; `None` in the last state.
    inner: Vec<Option<Discontinuity>>,
    edges: Vec<Edges>,
    energies: Vec<f64>,
    /// Contact law of infinite energy steps.
    pub law: ContactLaw,
}

impl Steps {
    /// Whether a pair can enter a state other than state 0.
    pub fn can_capture(&self) -> bool {
        self.inner.iter().flatten().any(|step| step.energy_step < f64::INFINITY)
    }

    fn new(interaction: &Interaction) -> Self {
        let (radii, energies) = (interaction.potential.radii(), interaction.potential.energies());
        let at = |radius: usize, from: usize, to: usize| Discontinuity {
            distance: radii[radius],
            squared: radii[radius] * radii[radius],
            energy_step: energies[to] - energies[from],
        };
        let states = 0..=radii.len();
        let outer: Vec<_> = states.clone().map(|k| (k > 0).then(|| at(k - 1, k, k - 1))).collect();
        let inner: Vec<_> = states.map(|k| (k < radii.len()).then(|| at(k, k, k + 1))).collect();
        let squared = |seen: &Option<Discontinuity>, none: f64| seen.map_or(none, |seen| seen.squared);
        let edges = inner.iter().zip(&outer).map(|(inner, outer)| Edges {
            inner: squared(inner, f64::NEG_INFINITY),
            outer: squared(outer, f64::INFINITY),
        });
        Self { edges: edges.collect(), outer, inner, energies: energies.to_vec(), law: interaction.law }
    }

    /// Number of pair states; `None` if the arrays have different lengths.
    fn states(&self) -> Option<usize> {
        let count = self.energies.len();
        let lengths = [self.outer.len(), self.inner.len(), self.edges.len()];
        (lengths == [count; 3]).then_some(count)
    }

    /// Returns the discontinuity of a pair in `state`: the inner one on the positive side, the outer one on the
    /// negative side.
    #[inline]
    #[must_use]
    pub fn seen_from(&self, state: u16, side: Side) -> Option<Discontinuity> {
        match side {
            Side::Positive => self.inner[usize::from(state)],
            Side::Negative => self.outer[usize::from(state)],
        }
    }

    #[inline]
    #[must_use]
    pub fn edges(&self, state: u16) -> Edges {
        self.edges[usize::from(state)]
    }

    #[must_use]
    pub fn energy(&self, state: u16) -> f64 {
        self.energies[usize::from(state)]
    }
}

/// The squared distances of the discontinuities of a pair in a given state `[length^2]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Edges {
    /// Squared distance of the inner discontinuity; negative infinity if there is none.
    pub inner: f64,
    /// Squared distance of the outer discontinuity; infinite if there is none.
    pub outer: f64,
}

/// The outermost discontinuity of a potential, at which an uncaptured pair meets.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Meeting {
    /// Squared range of the potential `[length^2]`.
    pub squared: f64,
    pub interaction: u16,
    /// True if the two species interact.
    pub exists: bool,
    /// True if the two species have different accelerations.
    pub is_accelerated: bool,
}

impl Meeting {
    /// Returns the squared range `[length^2]`. Negative infinity excludes pairs without interaction, and pairs with a
    /// relative acceleration.
    fn inertial_squared(&self) -> f64 {
        if self.exists && !self.is_accelerated { self.squared } else { f64::NEG_INFINITY }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SpeciesRules {
    /// Inverse mass; 0 for a static species.
    pub inverse_mass: f64,
    /// Half the diameter, which is the distance of the centre from a wall at contact `[length]`.
    pub radius: f64,
    pub acceleration: Vector,
    /// Inverse moment of inertia; 0 for a static species `[1 / (mass length^2)]`.
    pub inverse_inertia: f64,
}

impl SpeciesRules {
    fn new(species: &Species, dimensions: usize) -> Self {
        Self {
            inverse_mass: species.inverse_mass(),
            radius: 0.5 * species.diameter,
            acceleration: species.acceleration,
            inverse_inertia: species.inverse_inertia(dimensions),
        }
    }

    /// Returns the rules of sleeping particles: they do not move.
    fn asleep(&self) -> Self {
        Self { inverse_mass: 0.0, acceleration: Vector::zeros(), inverse_inertia: 0.0, ..*self }
    }

    #[inline]
    #[must_use]
    pub fn is_static(&self) -> bool {
        self.inverse_mass == 0.0
    }
}

/// The distances at which a particle meets uncaptured particles of each table row.
#[derive(Debug, Clone, Copy)]
pub struct Reaches<'a> {
    /// Squared contact distances `[length^2]`. Negative infinity excludes pairs.
    pub squared: &'a [f64],
    /// Divided contact distances of each table row; empty unless particles have individual diameters.
    pub slopes: &'a Vec<Slopes>,
}

/// Contact distances of a particle with particles of each table row, divided by the sum of the two radii.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Slopes {
    /// For each table row; negative for excluded pairs.
    pub of_rows: Vec<f64>,
    /// The slope of all pairs, if it is the same for all.
    pub common: Option<f64>,
}

impl Slopes {
    fn new(of_rows: Vec<f64>) -> Self {
        let first = of_rows.first().copied().filter(|first| *first >= 0.0);
        Self { common: first.filter(|first| of_rows.iter().all(|slope| slope == first)), of_rows }
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Rules {
    pub rows: Rows,
    /// Constants of the species, by table row.
    pub species: Vec<SpeciesRules>,
    pub steps: Vec<Steps>,
    /// Discontinuities at which uncaptured pairs meet, for all pairs of table rows.
    meetings: Vec<Meeting>,
    inertial: Vec<f64>,
    accelerated: Vec<f64>,
    /// Like `inertial` and `accelerated`, for each table row. Empty unless particles have individual diameters.
    slopes: [Vec<Slopes>; 2],
    /// For each table row, whether any pair has a relative acceleration.
    is_met_accelerated: Vec<bool>,
    /// For each table row, whether its species has individual diameters.
    pub is_individual: Vec<bool>,
    /// Whether the particles have spins.
    pub has_spins: bool,
    /// Whether particles have individual diameters.
    pub has_sizes: bool,
}

impl Rules {
    /// Checks tables and pair states that were read from a file. `species` is the number of species.
    #[must_use]
    pub fn is_sound<'p>(&self, species: usize, mut pairs: impl Iterator<Item = &'p PairState>) -> bool {
        let rows = self.rows.species().len();
        let squares = [self.meetings.len(), self.inertial.len(), self.accelerated.len()];
        let lengths = [self.species.len(), self.is_met_accelerated.len(), self.is_individual.len()];
        let states = |interaction: u16| self.steps.get(usize::from(interaction)).and_then(Steps::states);
        self.rows.are_sound(species)
            && lengths == [rows; 3]
            && squares == [rows * rows; 3]
            && self.slopes.iter().all(|slopes| {
                slopes.len() == if self.has_sizes { rows } else { 0 }
                    && slopes.iter().all(|slopes| slopes.of_rows.len() == rows)
            })
            && self.steps.iter().all(|steps| steps.states().is_some())
            && self.meetings.iter().all(|meeting| !meeting.exists || states(meeting.interaction).is_some())
            && pairs.all(|pair| states(pair.interaction).is_some_and(|states| usize::from(pair.state) < states))
    }

    /// Whether a species has individual diameters.
    #[must_use]
    pub fn has_individual_diameters(&self, species: SpeciesId) -> bool {
        self.rows.species().iter().zip(&self.is_individual).any(|(id, individual)| *id == species && *individual)
    }

    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        Self::with_rows(scene, Rows::of(scene))
    }

    /// Uses given rows, because the scene may have lost its particles since they were chosen.
    #[must_use]
    pub fn with_rows(scene: &Scene, rows: Rows) -> Self {
        let dimensions = scene.space.dimensions();
        let of = |(row, id): (u16, &SpeciesId)| {
            let rules = SpeciesRules::new(&scene.species[id.0 as usize], dimensions);
            if rows.is_asleep(row) { rules.asleep() } else { rules }
        };
        let species: Vec<_> = (0..=u16::MAX).zip(rows.species()).map(of).collect();
        let of_rows = || rows.species().iter().copied().zip(&species);
        let pairs = of_rows().flat_map(|a| of_rows().map(move |b| (a, b)));
        let meetings: Vec<Meeting> = pairs
            .map(|((first, a), (second, b))| {
                let is_accelerated = a.acceleration != b.acceleration;
                match scene.interaction_of(first, second) {
                    Some(id) if !(a.is_static() && b.is_static()) => {
                        let range = scene.interactions[id.0 as usize].potential.range();
                        Meeting { squared: range * range, interaction: id.narrow(), exists: true, is_accelerated }
                    }
                    _ => Meeting { squared: 0.0, interaction: 0, exists: false, is_accelerated },
                }
            })
            .collect();
        let inertial: Vec<f64> = meetings.iter().map(|meeting| meeting.inertial_squared()).collect();
        let accelerated =
            meetings.iter().zip(species.iter().cycle()).map(|(meeting, second)| match meeting {
                Meeting { exists: true, is_accelerated: true, squared, .. } => {
                    if second.acceleration == Vector::zeros() { *squared } else { f64::INFINITY }
                }
                _ => f64::NEG_INFINITY,
            });
        let accelerated: Vec<f64> = accelerated.collect();
        let some = |squared: &[f64]| squared.iter().any(|squared| *squared >= 0.0);
        let is_met_accelerated = accelerated.chunks(species.len().max(1)).map(some).collect();
        let steps = scene.interactions.iter().map(Steps::new).collect();
        let (has_spins, has_sizes) = (scene.has_spins(), scene.has_individual_diameters());
        let slopes =
            if has_sizes { [&inertial, &accelerated].map(|all| slopes(all, &species)) } else { Default::default() };
        let is_individual = rows.species().iter().map(|id| scene.species[id.0 as usize].individual.is_some()).collect();
        Self {
            rows,
            species,
            steps,
            meetings,
            inertial,
            accelerated,
            slopes,
            is_met_accelerated,
            is_individual,
            has_spins,
            has_sizes,
        }
    }

    /// Returns the distances at which a particle of a given row meets uncaptured particles of each row. Excludes pairs
    /// that never meet and pairs with a relative acceleration.
    #[inline]
    #[must_use]
    pub fn inertial(&self, row: u16) -> Reaches<'_> {
        Reaches { squared: self.of_row(row, &self.inertial), slopes: &self.slopes[0] }
    }

    /// Like [`Self::inertial`], for pairs with a relative acceleration. Returns `None` if there are no such pairs.
    ///
    /// The result is the range if the other species has no acceleration, and infinity if it has one. Excludes pairs
    /// that never meet and pairs without a relative acceleration.
    #[inline]
    #[must_use]
    pub fn accelerated(&self, row: u16) -> Option<Reaches<'_>> {
        let reaches = || Reaches { squared: self.of_row(row, &self.accelerated), slopes: &self.slopes[1] };
        self.is_met_accelerated[usize::from(row)].then(reaches)
    }

    /// Sum of the radii of two species, by table row `[length]`.
    #[inline]
    #[must_use]
    pub fn sum_of_species_radii(&self, a: u16, b: u16) -> f64 {
        self.species[usize::from(a)].radius + self.species[usize::from(b)].radius
    }

    #[inline]
    fn of_row<'a>(&self, row: u16, squared: &'a [f64]) -> &'a [f64] {
        let first = usize::from(row) * self.species.len();
        &squared[first..first + self.species.len()]
    }

    #[inline]
    #[must_use]
    pub fn meeting(&self, a: u16, b: u16) -> &Meeting {
        &self.meetings[usize::from(a) * self.species.len() + usize::from(b)]
    }
}

/// Returns the distance of each pair of rows divided by the sum of the radii of the two species; -1 for excluded pairs.
fn slopes(squared: &[f64], species: &[SpeciesRules]) -> Vec<Slopes> {
    let of_row = |(a, squared): (&SpeciesRules, &[f64])| {
        let slope = |(&squared, b): (&f64, &SpeciesRules)| {
            if squared < 0.0 { -1.0 } else { squared.sqrt() / (a.radius + b.radius) }
        };
        Slopes::new(squared.iter().zip(species).map(slope).collect())
    };
    species.iter().zip(squared.chunks(species.len().max(1))).map(of_row).collect()
}
