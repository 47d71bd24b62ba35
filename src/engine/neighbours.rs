//! Neighbour search: finds the particles that a particle could meet.
//!
//! A thin fluid uses only [`cells`], because a Verlet list would be outdated before its second use. A dense fluid uses
//! Verlet lists with a skin ([`lists`]). Mixtures of very different sizes also use lists at lower densities, because
//! lists are built from separate cells for each level of sizes ([`levels`]).

pub mod candidates;
pub mod cell_list;
pub mod cells;
mod choice;
mod divisor;
pub mod grid;
mod levels;
pub mod lists;
pub mod packed;
pub mod ranges;
pub mod verlet;

use crate::Vector;
use crate::engine::slabs::Rooms;
use crate::model::space::Space;
use candidates::Candidates;
use cells::Cells;
use lists::Lists;
use serde::{Deserialize, Serialize};
use std::fmt;
use verlet::VerletLists;

/// Method of the neighbour search.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Search {
    /// Cells: the neighbours of a particle are in its own cell and in the adjacent cells.
    Cells,
    /// Verlet lists: each moving particle has a list of its neighbours.
    Lists {
        /// Half of the skin: the distance that a particle may move before its list is rebuilt `[length]`.
        half_skin: f64,
    },
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant, reason = "there is one in an engine, and it is reached without a detour")]
pub enum Neighbours {
    Cells(Cells),
    Lists(VerletLists),
}

/// Place of a particle in the neighbour search: its cell, or the centre of its Verlet list.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Place {
    Cell(u32),
    Centre(Vector),
}

impl Neighbours {
    /// Turns a bitwise copy into a search in shared arrays, with the room of one thread.
    ///
    /// # Safety
    /// As for [`Array::become_alias`](super::array::Array::become_alias). The copy must not be dropped.
    pub unsafe fn share(&mut self, rooms: &mut Rooms) {
        match self {
            Self::Cells(cells) => cells.become_alias(),
            Self::Lists(verlet) => {
                verlet.centres.become_alias();
                // SAFETY: as above.
                unsafe {
                    verlet.lists.become_alias(rooms);
                    verlet.levels.become_alias(rooms);
                }
            }
        }
    }

    /// Whether room for several threads is affordable.
    pub fn can_make_rooms(&self) -> bool {
        self.verlet().is_none_or(|verlet| verlet.lists.can_make_rooms())
    }

    /// Makes room in the arrays for one thread with `share` particles. `threads` is the number of threads without room.
    pub fn make_room(&mut self, rooms: &mut Rooms, share: usize, threads: usize) {
        if let Self::Lists(verlet) = self {
            verlet.lists.make_room(rooms, share, threads);
            verlet.levels.make_room(rooms, share);
        }
    }

    /// Takes back the room of a thread.
    pub fn take_room(&mut self, rooms: &mut Rooms) {
        if let Self::Lists(verlet) = self {
            verlet.lists.take_room(rooms);
            verlet.levels.take_room(rooms);
        }
    }

    /// Gives the memory that an alias has not used back to its part.
    pub fn give_back(&mut self, rooms: &mut Rooms) {
        if let Self::Lists(verlet) = self {
            verlet.lists.give_back(rooms);
            verlet.levels.give_back(rooms);
        }
    }

    /// Whether the memory of this thread may be too small for a transition of a particle.
    #[inline]
    pub fn is_short(&self, particle: u32) -> bool {
        self.verlet().is_some_and(|verlet| verlet.lists.is_short() || verlet.levels.are_short(particle))
    }

    #[must_use]
    pub fn place(&self, particle: u32) -> Place {
        match self {
            Self::Cells(cells) => Place::Cell(cells.home(particle)),
            Self::Lists(verlet) => Place::Centre(verlet.centres[particle as usize]),
        }
    }

    /// Adds a particle with an empty list at `place`, or at `position` if `place` does not fit the search method.
    pub fn push(&mut self, position: &Vector, place: Option<Place>, row: u16) {
        match (self, place) {
            (Self::Cells(cells), Some(Place::Cell(cell))) => cells.push(cell),
            (Self::Cells(cells), _) => cells.push(cells.grid.cell_at(position)),
            (Self::Lists(verlet), Some(Place::Centre(centre))) => verlet.push(centre, row),
            (Self::Lists(verlet), _) => verlet.push(*position, row),
        }
    }

    /// Moves a particle to another cell, or the centre of its list. The lists do not change.
    pub fn relocate(&mut self, particle: u32, place: Place) {
        match (self, place) {
            (Self::Cells(cells), Place::Cell(cell)) => cells.relocate(particle, cell),
            (Self::Lists(verlet), Place::Centre(centre)) => verlet.relocate(particle, centre),
            _ => debug_assert!(false, "a search with cells needs a cell, and a search with lists needs a centre"),
        }
    }

    /// Cells without particles.
    #[must_use]
    pub fn none(space: &Space) -> Self {
        Self::Cells(Cells::new(space, 0.0, &[]))
    }

    #[must_use]
    pub fn search(&self) -> Search {
        match self {
            Self::Cells(_) => Search::Cells,
            Self::Lists(verlet) => Search::Lists { half_skin: verlet.half_skin },
        }
    }

    #[inline]
    #[must_use]
    pub fn verlet(&self) -> Option<&VerletLists> {
        match self {
            Self::Cells(_) => None,
            Self::Lists(verlet) => Some(verlet),
        }
    }

    #[inline]
    #[must_use]
    pub fn lists_mut(&mut self) -> Option<&mut Lists> {
        match self {
            Self::Cells(_) => None,
            Self::Lists(verlet) => Some(&mut verlet.lists),
        }
    }

    /// Finds all particles in the cell of a particle and in the adjacent cells. With lists, finds all particles that
    /// could be in its list, and others nearby. `row` is the table row of the particle.
    pub fn find_candidates(&self, particle: u32, row: u16, near: &mut Candidates) {
        match self {
            Self::Cells(cells) => cells.find_candidates(cells.home(particle), near),
            Self::Lists(verlet) => verlet.levels.find_candidates(&verlet.centres[particle as usize], row, near),
        }
    }

    /// Finds all particles that could be within the interaction range of a new particle at `position`. `row` is the
    /// table row of the new particle.
    pub fn find_candidates_at(&self, position: &Vector, row: u16, near: &mut Candidates) {
        match self {
            Self::Cells(cells) => cells.find_candidates(cells.grid.cell_at(position), near),
            Self::Lists(verlet) => verlet.levels.find_candidates(position, row, near),
        }
    }

    /// Takes a moving particle out of its cell and out of all lists. Its captured pairs must have been removed.
    pub fn withdraw(&mut self, particle: u32) {
        match self {
            Self::Cells(cells) => cells.lift(particle),
            Self::Lists(verlet) => verlet.withdraw(particle),
        }
    }

    pub fn enlarge(&self) {
        match self {
            Self::Cells(cells) => cells.enlarge(),
            Self::Lists(verlet) => verlet.enlarge(),
        }
    }
}

impl fmt::Display for Search {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cells => f.write_str("cells"),
            Self::Lists { half_skin } => {
                let skin = 2.0 * half_skin;
                let is_plain = (0.1..1e4).contains(&skin) || !skin.is_normal();
                f.write_str("neighbour lists with a skin of ")?;
                if is_plain { write!(f, "{skin:.2}") } else { write!(f, "{skin:.2e}") }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skin_is_printed_with_two_digits_in_any_unit() {
        let skin = |skin: f64| Search::Lists { half_skin: 0.5 * skin }.to_string();
        assert_eq!(skin(0.256), "neighbour lists with a skin of 0.26");
        assert_eq!(skin(2.56e-6), "neighbour lists with a skin of 2.56e-6");
        assert_eq!(skin(2.56e7), "neighbour lists with a skin of 2.56e7");
    }
}
