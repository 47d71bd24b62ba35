//! The regions of threads, and the distances at which steps can affect each other.

use crate::Vector;
use crate::engine::neighbours::Neighbours;
use crate::engine::parts::Engine;
use crate::model::space::Boundary;

/// Number of positions from which the faces of the slabs are determined.
const SAMPLE: usize = 65_536;

/// A slab of the box: an interval along the axis that is cut. It may extend across a side of the box.
#[derive(Debug, Clone, Copy)]
pub struct Slab {
    from: f64,
    width: f64,
    period: f64,
}

impl Slab {
    /// The whole box.
    const ALL: Self = Self { from: 0.0, width: f64::INFINITY, period: f64::INFINITY };

    #[inline]
    fn behind(&self, x: f64) -> f64 {
        let behind = x - self.from;
        match () {
            () if behind < 0.0 => behind + self.period,
            () if behind >= self.period => behind - self.period,
            () => behind,
        }
    }

    /// Distance from the nearer face of the slab. Negative outside.
    #[inline]
    pub fn depth(&self, x: f64) -> f64 {
        if self.width == f64::INFINITY {
            return f64::INFINITY;
        }
        let behind = self.behind(x);
        behind.min(self.width - behind)
    }
}

impl Slab {
    fn middle(&self) -> f64 {
        self.from + 0.5 * self.width
    }

    /// Whether no place in the slab is deeper than this.
    pub fn is_within(&self, depth: f64) -> bool {
        0.5 * self.width <= depth
    }
}

/// The region around a place.
#[derive(Debug, Clone, Copy)]
pub enum Near {
    /// Within this squared distance.
    Ball(f64),
    /// Within these distances along the axes.
    Block(Vector),
}

impl Near {
    #[inline]
    pub fn has(&self, apart: &Vector) -> bool {
        match self {
            Self::Ball(squared) => apart.norm_squared() < *squared,
            Self::Block(half) => (0..3).all(|k| apart[k].abs() < half[k]),
        }
    }

    /// Largest distance along an axis.
    pub fn along(&self, axis: usize) -> f64 {
        match self {
            Self::Ball(squared) => squared.sqrt(),
            Self::Block(half) => half[axis],
        }
    }
}

/// How the box is cut. The *place* of a particle is the centre of its Verlet list, or the middle of its cell.
#[derive(Debug, Clone)]
pub struct Geometry {
    pub axis: usize,
    pub lower: Vector,
    pub size: Vector,
    /// Periods of the box; infinite along axes that are not periodic.
    pub periods: Vector,
    /// One slab per thread. Slabs do not overlap, and cover the box.
    pub slabs: Vec<Slab>,
    /// One strip per thread. A strip reaches from the middle of a slab to the middle of the next slab.
    pub strips: Vec<Slab>,
    pub all: Slab,
    /// A step can affect another step only if the places of two of their particles are this near.
    pub reach: Near,
    /// Steps this near to a step that is held back are held back, too.
    pub around_held: Near,
    /// Depth below which contacts and transitions are held back.
    pub of_contact: f64,
    pub of_transition: f64,
}

impl Geometry {
    /// Cuts the box into as many slabs as possible, at most `threads`. Returns `None` if this is fewer than two.
    pub fn of<const FALLING: bool, const TABLE: bool>(
        engine: &Engine<FALLING, TABLE>,
        threads: usize,
        narrowest: f64,
    ) -> Option<Self> {
        let space = &engine.state.space;
        let is_cut = |axis: &usize| space.boundary[*axis] == Boundary::Periodic || space.walls(*axis) == 2;
        let axis = (0..3).filter(is_cut).max_by(|a, b| space.size[*a].total_cmp(&space.size[*b]))?;
        let (reach, around_held, of_contact, of_transition) = distances(engine, axis);
        let mut geometry = Self {
            axis,
            lower: space.lower,
            size: space.size,
            periods: engine.state.periods,
            slabs: Vec::new(),
            strips: Vec::new(),
            all: Slab::ALL,
            reach,
            around_held,
            of_contact,
            of_transition,
        };
        let step = (engine.particles().len() / SAMPLE).max(1);
        let moving = engine.particles().filter(|particle| !engine.is_static(*particle));
        let along = moving.step_by(step).map(|particle| geometry.along(engine, particle));
        let mut along: Vec<f64> = along.collect();
        along.sort_unstable_by(f64::total_cmp);
        (2..=threads).rev().find_map(|count| geometry.cut(&along, count, narrowest)).map(|(slabs, strips)| {
            (geometry.slabs, geometry.strips) = (slabs, strips);
            geometry
        })
    }

    /// Cuts the box into slabs with equal numbers of moving particles. Returns `None` if a slab is too narrow.
    fn cut(&self, along: &[f64], count: usize, least: f64) -> Option<(Vec<Slab>, Vec<Slab>)> {
        let (lower, period) = (self.lower[self.axis], self.size[self.axis]);
        let face = |number: usize| {
            if number == 0 { Some(lower) } else { along.get(number * along.len() / count).copied() }
        };
        let mut faces = (0..count).map(face).collect::<Option<Vec<f64>>>()?;
        faces.push(lower + period);
        let slabs = faces.windows(2).map(|face| Slab { from: face[0], width: face[1] - face[0], period });
        let slabs: Vec<Slab> = slabs.collect();
        let strips = (0..count).map(|number| {
            let (before, slab) = (&slabs[(number + count - 1) % count], &slabs[number]);
            Slab { from: before.middle(), width: 0.5 * (before.width + slab.width), period }
        });
        let strips: Vec<Slab> = strips.collect();
        let narrowest = slabs.iter().map(|slab| slab.width).fold(f64::INFINITY, f64::min);
        (narrowest >= least * self.of_transition).then_some((slabs, strips))
    }

    /// Number of the slab of a place. Each place is in exactly one slab.
    #[inline]
    pub fn slab_of(&self, along: f64) -> usize {
        self.slabs.iter().rposition(|slab| slab.from <= along).unwrap_or(0)
    }

    /// Number of the strip of a place. Each place is in exactly one strip.
    #[inline]
    pub fn strip_of(&self, along: f64) -> usize {
        let slab = self.slab_of(along);
        let is_in_lower_half = along < self.slabs[slab].middle();
        if is_in_lower_half { slab } else { (slab + 1) % self.slabs.len() }
    }

    /// Coordinate of the place of a particle along the axis that is cut.
    #[inline]
    pub fn along<const FALLING: bool, const TABLE: bool>(&self, engine: &Engine<FALLING, TABLE>, particle: u32) -> f64 {
        match &engine.neighbours {
            Neighbours::Lists(verlet) => verlet.centres[particle as usize][self.axis],
            Neighbours::Cells(cells) => cells.grid.middle(cells.home(particle), self.axis),
        }
    }

    #[inline]
    pub fn place<const FALLING: bool, const TABLE: bool>(
        &self,
        engine: &Engine<FALLING, TABLE>,
        particle: u32,
    ) -> Vector {
        match &engine.neighbours {
            Neighbours::Lists(verlet) => verlet.centres[particle as usize],
            Neighbours::Cells(cells) => {
                let home = cells.home(particle);
                Vector::from_fn(|axis, _| cells.grid.middle(home, axis))
            }
        }
    }
}

/// Returns the fields `reach`, `around_held`, `of_contact` and `of_transition` of [`Geometry`].
fn distances<const FALLING: bool, const TABLE: bool>(
    engine: &Engine<FALLING, TABLE>,
    axis: usize,
) -> (Near, Near, f64, f64) {
    let further = (engine.ranges.longest - engine.ranges.of_cells).max(0.0);
    match &engine.neighbours {
        Neighbours::Lists(verlet) => {
            // A rebuild moves a centre by half a skin, except for rounding.
            let moved = 1.01 * verlet.half_skin;
            let reach = (verlet.levels.largest_reach() + further) * (1.0 + 1e-9);
            let held = reach + 2.0 * moved;
            // A rebuild reads and changes the cells around the new centre.
            let cells = 2.0 * verlet.levels.widest_cell(axis) + moved;
            (Near::Ball(reach * reach), Near::Ball(held * held), held, cells.max(held))
        }
        Neighbours::Cells(cells) => {
            let width = Vector::from_fn(|k, _| cells.grid.width(k));
            // Captured partners may be several cells away.
            let range = |k: usize| {
                if further > 0.0 && width[k] > 0.0 { (engine.ranges.longest / width[k]).ceil() } else { 1.0 }
            };
            let block = |more: f64| {
                let half = |k: usize| if width[k] > 0.0 { (range(k) + more + 0.5) * width[k] } else { f64::INFINITY };
                Near::Block(Vector::from_fn(|k, _| half(k)))
            };
            let depth = |number: f64| (number + 0.5) * width[axis] * (1.0 + 1e-9);
            let along = range(axis);
            (block(0.0), block(1.0), depth(2.0 * along), depth(2.0 * along + 1.0))
        }
    }
}
