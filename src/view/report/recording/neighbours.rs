//! How many neighbours of a particle are within the range of a finite step, by distance.

use std::collections::HashSet;

use super::frame::wrapped;
use crate::Vector;
use crate::base::numbers::{id, trunc_to_usize};
use crate::model::{Scene, SpeciesId};
use crate::trajectory::Frame;

/// The ranges within which particles are neighbours.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Neighbours {
    /// Species by species, negative for those that have no finite step.
    ranges: Vec<f64>,
    species: usize,
    longest: f64,
    /// Pairs with an interaction of their own.
    bonded: HashSet<[u32; 2]>,
}

impl Neighbours {
    /// The ranges of a scene; `None` if it has no finite steps, or if the species of the frame are not those of the scene.
    pub fn of(scene: &Scene, frame: &Frame) -> Option<Self> {
        let names = || frame.species.iter().map(|species| &species.name);
        if !names().eq(scene.species.iter().map(|species| &species.name)) {
            return None;
        }
        let species = scene.species.len();
        let mut ranges = Vec::new();
        for a in 0..species {
            for b in 0..species {
                let id = scene.interaction_of(SpeciesId(id(a)), SpeciesId(id(b)));
                let potential = id.and_then(|id| scene.interactions.get(id.0 as usize)).map(|found| &found.potential);
                let stepped = potential.filter(|potential| potential.accessible_states().count() > 1);
                ranges.push(stepped.map_or(-1.0, |potential| potential.range()));
            }
        }
        let longest = ranges.iter().copied().fold(-1.0, f64::max);
        let bonded = frame.bonds.iter().map(|[a, b]| [a.0.min(b.0), a.0.max(b.0)]).collect();
        (longest > 0.0).then_some(Self { ranges, species, longest, bonded })
    }

    /// The number of each moving particle, in the order of the frame. Bonded partners do not count.
    pub fn count(&self, frame: &Frame) -> Vec<f64> {
        let positions: Vec<Vector> =
            frame.particles.iter().map(|particle| wrapped(frame, &particle.position)).collect();
        let cells = Cells::of(frame, &positions, self.longest);
        let of = |(index, particle): (usize, &crate::trajectory::frame::FrameParticle)| {
            let is_neighbour = |other: &usize| {
                let (Some(partner), Some(position)) = (frame.particles.get(*other), positions.get(*other)) else {
                    return false;
                };
                let pair = particle.species.0 as usize * self.species + partner.species.0 as usize;
                let range = self.ranges.get(pair).copied().unwrap_or(-1.0);
                let ids = [particle.id.0.min(partner.id.0), particle.id.0.max(partner.id.0)];
                *other != index
                    && range > 0.0
                    && frame.nearest_image(positions[index] - position).norm_squared() < range * range
                    && !self.bonded.contains(&ids)
            };
            let around = cells.around(&positions[index]).into_iter();
            around.flat_map(|cell| cells.members(cell)).filter(is_neighbour).count() as f64
        };
        let all = frame.particles.iter().enumerate();
        all.filter(|(_, particle)| !frame.is_static(particle)).map(of).collect()
    }
}

/// Particles sorted into cells that are at least as wide as the longest range.
struct Cells {
    lower: Vector,
    width: Vector,
    number: [usize; 3],
    is_periodic: [bool; 3],
    /// Whether images along y are displaced along x.
    is_sliding: bool,
    first: Vec<usize>,
    sorted: Vec<usize>,
}

impl Cells {
    fn of(frame: &Frame, positions: &[Vector], range: f64) -> Self {
        let (mut lower, mut upper) = (frame.lower, frame.lower + frame.size);
        for position in positions {
            (lower, upper) = (lower.inf(position), upper.sup(position));
        }
        let size = upper - lower;
        // No more cells than some per particle, however empty the space is.
        let most = ((positions.len() as f64).cbrt() * 2.0).ceil();
        let number = [0, 1, 2].map(|k| match trunc_to_usize((size[k] / range).clamp(1.0, most)) {
            // Three periodic cells are the fewest that differ from their neighbours.
            few @ ..3 if frame.periodic[k] => few.min(1),
            many => many,
        });
        let width = Vector::from_fn(|k, _| size[k] / number[k] as f64);
        let (is_periodic, is_sliding) = (frame.periodic, frame.displacement != 0.0);
        let mut cells = Self { lower, width, number, is_periodic, is_sliding, first: Vec::new(), sorted: Vec::new() };
        let of: Vec<usize> = positions.iter().map(|position| cells.index(cells.coordinates(position))).collect();
        cells.first = vec![0; number.iter().product::<usize>() + 1];
        of.iter().for_each(|cell| cells.first[cell + 1] += 1);
        for cell in 1..cells.first.len() {
            cells.first[cell] += cells.first[cell - 1];
        }
        let mut next = cells.first.clone();
        cells.sorted = vec![0; positions.len()];
        for (particle, cell) in of.into_iter().enumerate() {
            cells.sorted[next[cell]] = particle;
            next[cell] += 1;
        }
        cells
    }

    fn coordinates(&self, position: &Vector) -> [usize; 3] {
        [0, 1, 2].map(|k| {
            let place = if self.width[k] > 0.0 { (position[k] - self.lower[k]) / self.width[k] } else { 0.0 };
            trunc_to_usize(place).min(self.number[k] - 1)
        })
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.number[1] + y) * self.number[0] + x
    }

    fn members(&self, cell: usize) -> impl Iterator<Item = usize> {
        self.sorted[self.first[cell]..self.first[cell + 1]].iter().copied()
    }

    /// The cell of a point and those beside it.
    fn around(&self, position: &Vector) -> Vec<usize> {
        let centre = self.coordinates(position);
        let along = |k: usize| -> Vec<usize> {
            let number = self.number[k];
            if number == 1 {
                return vec![0];
            }
            let wrap = |shifted: usize| match self.is_periodic[k] {
                true => Some((shifted + number - 1) % number),
                false => shifted.checked_sub(1).filter(|cell| *cell < number),
            };
            (0..3).filter_map(|offset| wrap(centre[k] + offset)).collect()
        };
        let (across, deep) = (along(0), along(1));
        let whole_row: Vec<usize> = (0..self.number[0]).collect();
        let mut cells = Vec::with_capacity(27);
        for z in along(2) {
            for &y in &deep {
                // Across the sides that slide any cell of the row may be near.
                let slides = self.is_sliding && (self.number[1] == 1 || y.abs_diff(centre[1]) > 1);
                let row = if slides { &whole_row } else { &across };
                cells.extend(row.iter().map(|x| self.index([*x, y, z])));
            }
        }
        cells
    }
}
