//! The interactions of a scene in the form that the event loop needs.

use super::rows::Rows;
use super::states::PairState;
use crate::Vector;
use crate::model::{Interaction, Scene, Species, SpeciesId};
use crate::physics::overlap::Side;
use serde::{Deserialize, Serialize};

/// A discontinuity as seen by a pair in a given state.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Discontinuity {
    /// Its distance `s` `[length]`.
    pub distance: f64,
    /// `s^2` `[length^2]`.
    pub squared: f64,
    /// Potential energy beyond the discontinuity minus the energy on this side, `dU` `[energy]`.
    pub energy_step: f64,
}

/// A potential in the form that the event loop needs: the outer and inner discontinuity of each pair state.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Steps {
    /// The outer discontinuity of each state, absent in state 0.
    outer: Vec<Option<Discontinuity>>,
    /// The inner discontinuity of each state, absent in the last state.
    inner: Vec<Option<Discontinuity>>,
    /// The squared distances of both discontinuities of each state.
    edges: Vec<Edges>,
    /// Potential energy by state `[energy]`.
    energies: Vec<f64>,
    /// Restitution of infinite steps.
    pub restitution: f64,
}

impl Steps {
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
        Self { edges: edges.collect(), outer, inner, energies: energies.to_vec(), restitution: interaction.restitution }
    }

    /// Number of states of a pair; `None` if the arrays have different lengths.
    fn states(&self) -> Option<usize> {
        let count = self.energies.len();
        let lengths = [self.outer.len(), self.inner.len(), self.edges.len()];
        (lengths == [count; 3]).then_some(count)
    }

    /// The discontinuity on one side of a pair in `state`.
    #[inline]
    #[must_use]
    pub fn seen_from(&self, state: u16, side: Side) -> Option<Discontinuity> {
        match side {
            Side::Positive => self.inner[usize::from(state)],
            Side::Negative => self.outer[usize::from(state)],
        }
    }

    /// The squared distances of both discontinuities.
    #[inline]
    #[must_use]
    pub fn edges(&self, state: u16) -> Edges {
        self.edges[usize::from(state)]
    }

    /// Potential energy of a pair in `state` `[energy]`.
    #[must_use]
    pub fn energy(&self, state: u16) -> f64 {
        self.energies[usize::from(state)]
    }
}

/// The squared distances of the discontinuities that a pair in a given state can reach `[length^2]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Edges {
    /// The inner discontinuity; negative infinity if there is none.
    pub inner: f64,
    /// The outer discontinuity; infinite if there is none.
    pub outer: f64,
}

/// First discontinuity of an uncaptured pair (in state 0) of given species.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Meeting {
    /// The square of the potential's range `[length^2]`.
    pub squared: f64,
    /// Index of the interaction.
    pub interaction: u16,
    /// Whether the two species interact at all.
    pub exists: bool,
    /// Whether the two particles accelerate relative to each other.
    pub is_accelerated: bool,
}

impl Meeting {
    /// Squared range of a pair without relative acceleration. It is negative infinity for other pairs, so
    /// that Algorithm 2 never finds a contact.
    fn inertial_squared(&self) -> f64 {
        if self.exists && !self.is_accelerated { self.squared } else { f64::NEG_INFINITY }
    }
}

/// The constants of a species.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SpeciesRules {
    /// `1 / m`, 0 for a static species.
    pub inverse_mass: f64,
    /// Half the diameter: the distance from walls at contact `[length]`.
    pub radius: f64,
    /// Constant acceleration.
    pub acceleration: Vector,
}

impl SpeciesRules {
    fn new(species: &Species) -> Self {
        Self {
            inverse_mass: species.inverse_mass(),
            radius: 0.5 * species.diameter,
            acceleration: species.acceleration,
        }
    }

    /// Whether particles of the species never move.
    #[inline]
    #[must_use]
    pub fn is_static(&self) -> bool {
        self.inverse_mass == 0.0
    }
}

/// All data about species and interactions that the event loop reads.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Rules {
    /// The species that have a row in the tables.
    pub rows: Rows,
    /// The constants of the species in each row.
    pub species: Vec<SpeciesRules>,
    /// The steps of each interaction.
    pub steps: Vec<Steps>,
    /// `species x species`, row by row.
    meetings: Vec<Meeting>,
    /// Squared ranges of pairs without relative acceleration, as a matrix `species x species`; negative
    /// infinity for other pairs.
    inertial: Vec<f64>,
    /// Squared ranges of pairs with a relative acceleration, as a matrix `species x species`; infinite if the
    /// second species accelerates, negative infinity for other pairs.
    accelerated: Vec<f64>,
    /// For each row, whether any value of `accelerated` is not negative.
    is_met_accelerated: Vec<bool>,
}

impl Rules {
    /// Checks data that was read: whether the tables have the right size, each interaction in them exists,
    /// and the states of `pairs` are valid.
    #[must_use]
    pub fn is_sound<'p>(&self, mut pairs: impl Iterator<Item = &'p PairState>) -> bool {
        let rows = self.rows.species().len();
        let squares = [self.meetings.len(), self.inertial.len(), self.accelerated.len()];
        let lengths = [self.species.len(), self.is_met_accelerated.len()];
        let states = |interaction: u16| self.steps.get(usize::from(interaction)).and_then(Steps::states);
        self.rows.are_sound()
            && lengths == [rows; 2]
            && squares == [rows * rows; 3]
            && self.steps.iter().all(|steps| steps.states().is_some())
            && self.meetings.iter().all(|meeting| !meeting.exists || states(meeting.interaction).is_some())
            && pairs.all(|pair| states(pair.interaction).is_some_and(|states| usize::from(pair.state) < states))
    }

    /// The rules of a scene.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let rows = Rows::of(scene);
        let of = |id: &SpeciesId| SpeciesRules::new(&scene.species[id.0 as usize]);
        let species: Vec<_> = rows.species().iter().map(of).collect();
        let pairs = rows.species().iter().flat_map(|a| rows.species().iter().map(move |b| (*a, *b)));
        let meetings: Vec<Meeting> = pairs
            .map(|(first, second)| {
                let (a, b) = (&species[usize::from(rows.row(first))], &species[usize::from(rows.row(second))]);
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
        let inertial = meetings.iter().map(|meeting| meeting.inertial_squared()).collect();
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
        Self { rows, inertial, accelerated, is_met_accelerated, species, steps, meetings }
    }

    /// Squared distances at which uncaptured particles of each species meet a particle of a given species.
    /// They are negative infinity for species that never meet it, or meet it only with a relative
    /// acceleration.
    #[inline]
    #[must_use]
    pub fn inertial_squared(&self, species: u16) -> &[f64] {
        let first = usize::from(species) * self.species.len();
        &self.inertial[first..first + self.species.len()]
    }

    /// Squared distances at which uncaptured particles of each species meet a particle of a given species
    /// that accelerates relative to them. They are infinite for species that accelerate themselves. They are
    /// negative infinity for species that never meet it, or meet it only without a relative acceleration.
    /// `None` if there are no such pairs.
    #[inline]
    #[must_use]
    pub fn accelerated_squared(&self, species: u16) -> Option<&[f64]> {
        let first = usize::from(species) * self.species.len();
        self.is_met_accelerated[usize::from(species)].then(|| &self.accelerated[first..first + self.species.len()])
    }

    /// First discontinuity of uncaptured pairs of two species.
    #[inline]
    #[must_use]
    pub fn meeting(&self, a: u16, b: u16) -> &Meeting {
        &self.meetings[usize::from(a) * self.species.len() + usize::from(b)]
    }
}
