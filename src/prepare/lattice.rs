//! Lattices as initial positions. A lattice is stretched over its region.

mod inside;

use crate::Vector;
use crate::base::numbers::trunc_to_usize;
use crate::model::Region;
use crate::model::space::{Boundary, Space};
use crate::prepare::NoPlace;

pub(crate) use inside::{sites_around, sites_inside};

/// A crystal lattice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Lattice {
    /// One site per cubic cell.
    #[doc(alias = "sc")]
    SimpleCubic,
    /// Two sites per cubic cell.
    #[doc(alias = "bcc")]
    BodyCentredCubic,
    /// Four sites per cubic cell. No lattice is denser; [`Lattice::HexagonalClosePacked`] is equally dense.
    #[doc(alias = "fcc")]
    FaceCentredCubic,
    /// Four sites per unit cell with edges in the ratio `1 : sqrt(3) : sqrt(8/3)`.
    #[doc(alias = "hcp")]
    HexagonalClosePacked,
    /// One site per square cell, for scenes with one flat axis.
    Square,
    /// Two sites per unit cell with edges in the ratio `1 : sqrt(3)`, for scenes with one flat axis.
    #[doc(alias = "triangular")]
    Hexagonal,
    /// Sites at equal distances on a line, for scenes with two flat axes.
    Line,
}

impl Lattice {
    /// Number of axes that are not flat.
    #[must_use]
    pub fn dimensions(self) -> usize {
        match self {
            Self::Line => 1,
            Self::Square | Self::Hexagonal => 2,
            _ => 3,
        }
    }

    /// Edges of the unit cell, relative to the first edge.
    fn edges(self) -> &'static [f64] {
        const TALL: f64 = 1.732_050_807_568_877_2;
        const HIGH: f64 = 1.632_993_161_855_452;
        match self {
            Self::Line => &[1.0],
            Self::Square => &[1.0, 1.0],
            Self::Hexagonal => &[1.0, TALL],
            Self::HexagonalClosePacked => &[1.0, TALL, HIGH],
            _ => &[1.0, 1.0, 1.0],
        }
    }

    fn basis(self) -> &'static [[f64; 3]] {
        const SIXTH: f64 = 1.0 / 6.0;
        match self {
            Self::SimpleCubic | Self::Square | Self::Line => &[[0.0; 3]],
            Self::BodyCentredCubic => &[[0.0; 3], [0.5, 0.5, 0.5]],
            Self::FaceCentredCubic => &[[0.0; 3], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]],
            Self::Hexagonal => &[[0.0; 3], [0.5, 0.5, 0.0]],
            Self::HexagonalClosePacked => {
                &[[0.0; 3], [0.5, 0.5, 0.0], [0.0, 2.0 * SIXTH, 0.5], [0.5, 5.0 * SIXTH, 0.5]]
            }
        }
    }
}

pub(crate) struct Sites {
    pub count: usize,
    /// Diameter of the largest particle `[length]`.
    pub diameter: f64,
    /// Smallest permitted distance between two sites `[length]`; `None` if sites may overlap.
    pub contact: Option<f64>,
}

/// Returns the sites of a lattice that is stretched over a region.
pub(crate) fn sites(lattice: Lattice, space: &Space, region: &Region, sites: Sites) -> Result<Vec<Vector>, NoPlace> {
    let Sites { count, diameter, contact } = sites;
    let fit = Fit::new(lattice, space, region, diameter, count);
    match contact {
        // The tolerance admits sites at exactly the contact distance.
        Some(contact) if fit.spacing < contact * (1.0 - 1e-12) => {
            Err(NoPlace::TooTight { count, spacing: fit.spacing, contact })
        }
        _ => Ok(fit.sites()),
    }
}

#[derive(Clone, Copy)]
struct Axis {
    index: usize,
    /// Lowest possible coordinate of a site.
    lower: f64,
    /// Length over which sites can be distributed.
    length: f64,
    /// Whether the lattice is periodic along this axis.
    is_closed: bool,
    /// Largest coordinate of a site in the unit cell, divided by the edge of the cell.
    top: f64,
}

impl Axis {
    fn edge(&self, cells: usize) -> f64 {
        let cells = cells as f64;
        if self.is_closed {
            self.length / cells
        } else if cells - 1.0 + self.top > 0.0 {
            self.length / (cells - 1.0 + self.top)
        } else {
            f64::INFINITY
        }
    }
}

/// A lattice stretched over a region, with a site for each particle.
struct Fit {
    lattice: Lattice,
    axes: Vec<Axis>,
    cells: Vec<usize>,
    count: usize,
    lower: Vector,
    /// Distance between nearest sites of the stretched lattice `[length]`.
    spacing: f64,
}

impl Fit {
    /// Chooses the numbers of cells that give the largest distance between nearest sites. Along axes that are not
    /// periodic, sites keep half a diameter from the sides of the region.
    fn new(lattice: Lattice, space: &Space, region: &Region, diameter: f64, count: usize) -> Self {
        let basis = lattice.basis();
        let moving = (0..3).filter(|&k| space.boundary[k] != Boundary::Flat);
        let axes: Vec<Axis> = moving
            .zip(0..lattice.dimensions())
            .map(|(index, k)| {
                let full = region.lower[index] == space.lower[index] && region.upper[index] == space.upper()[index];
                let is_closed = full && space.boundary[index] == Boundary::Periodic;
                let margin = if is_closed { 0.0 } else { 0.5 * diameter };
                let length = (region.upper[index] - region.lower[index] - 2.0 * margin).max(0.0);
                let top = basis.iter().map(|site| site[k]).fold(0.0, f64::max);
                Axis { index, lower: region.lower[index] + margin, length, is_closed, top }
            })
            .collect();
        let volume: f64 = axes.iter().map(|axis| axis.length).product();
        let cell_volume: f64 = lattice.edges().iter().product();
        let cells_needed = count as f64 / basis.len() as f64;
        let edge = root(volume / (cells_needed * cell_volume), axes.len());
        let choices: Vec<Vec<usize>> = axes
            .iter()
            .zip(lattice.edges())
            .map(|(axis, relative)| {
                let ideal = axis.length / (edge * relative);
                // More cells than particles are never needed. In a flat region, the ideal number can be infinite.
                let ideal = if ideal.is_finite() { trunc_to_usize(ideal).min(count) } else { count };
                (ideal.saturating_sub(1).max(1)..=ideal + 2).collect()
            })
            .collect();
        let mut best = Self { lattice, axes, cells: Vec::new(), count, lower: space.lower, spacing: 0.0 };
        let mut cells = vec![0; choices.len()];
        best.search(&choices, 0, &mut cells, &mut 0);
        best
    }

    fn search(&mut self, choices: &[Vec<usize>], axis: usize, cells: &mut Vec<usize>, sites: &mut usize) {
        if axis < choices.len() {
            for &choice in &choices[axis] {
                cells[axis] = choice;
                self.search(choices, axis + 1, cells, sites);
            }
            return;
        }
        let these = cells.iter().product::<usize>().saturating_mul(self.lattice.basis().len());
        if these < self.count {
            return;
        }
        let spacing = self.nearest(cells);
        if spacing > self.spacing || (spacing == self.spacing && these < *sites) || self.cells.is_empty() {
            *sites = these;
            self.spacing = spacing;
            self.cells.clone_from(cells);
        }
    }

    fn nearest(&self, cells: &[usize]) -> f64 {
        let basis = self.lattice.basis();
        let mut least = f64::INFINITY;
        for (first, a) in basis.iter().enumerate() {
            for b in &basis[first..] {
                let all: usize = self.axes.iter().map(|_| 3).product();
                for shift in 0..all {
                    let mut shift = shift;
                    let mut squared = 0.0;
                    for (k, axis) in self.axes.iter().enumerate() {
                        let step = (shift % 3) as f64 - 1.0;
                        shift /= 3;
                        let steps = b[k] - a[k] + step;
                        if steps != 0.0 {
                            let distance = steps * axis.edge(cells[k]);
                            squared += distance * distance;
                        }
                    }
                    if squared > 0.0 {
                        least = least.min(squared);
                    }
                }
            }
        }
        least.sqrt()
    }

    fn all(&self) -> usize {
        self.cells.iter().product::<usize>() * self.lattice.basis().len()
    }

    /// Returns the positions of the particles. If there are more sites than particles, empty sites are evenly spaced.
    fn sites(&self) -> Vec<Vector> {
        let basis = self.lattice.basis();
        let sites = self.all();
        let edges: Vec<f64> = self.axes.iter().zip(&self.cells).map(|(axis, &cells)| axis.edge(cells)).collect();
        (0..self.count)
            .map(|particle| {
                let site = (particle as u128 * sites as u128 / self.count as u128) as usize;
                let (mut cell, offset) = (site / basis.len(), basis[site % basis.len()]);
                let mut position = self.lower;
                for (k, axis) in self.axes.iter().enumerate() {
                    let coordinate = (cell % self.cells[k]) as f64 + offset[k];
                    cell /= self.cells[k];
                    let along = if edges[k].is_finite() { coordinate * edges[k] } else { 0.5 * axis.length };
                    let centring = if axis.is_closed { 0.5 * (1.0 - axis.top) * edges[k] } else { 0.0 };
                    position[axis.index] = axis.lower + along + centring;
                }
                position
            })
            .collect()
    }
}

/// Edge of the cube, square or line segment with this volume `[length]`.
pub(crate) fn root(volume: f64, dimensions: usize) -> f64 {
    match dimensions {
        3 => libm::cbrt(volume),
        2 => volume.sqrt(),
        _ => volume,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::lattice::inside::least_distance;

    fn fit(lattice: Lattice, space: &Space, count: usize) -> Fit {
        Fit::new(lattice, space, &Region { lower: space.lower, upper: space.upper() }, 1.0, count)
    }

    #[test]
    fn whole_cells_fill_a_cube_at_the_known_spacing() {
        let cube = Space::periodic_cube(6.0);
        for (lattice, count, spacing) in [
            (Lattice::SimpleCubic, 216, 1.0),
            (Lattice::BodyCentredCubic, 2 * 64, 1.5 * 0.75_f64.sqrt()),
            (Lattice::FaceCentredCubic, 4 * 27, 2.0_f64.sqrt()),
        ] {
            let fit = fit(lattice, &cube, count);
            assert!((fit.spacing - spacing).abs() < 1e-12, "{lattice:?}: {} for {spacing}", fit.spacing);
            let sites = fit.sites();
            assert_eq!(sites.len(), count);
            assert!((least_distance(&sites, &cube) - spacing).abs() < 1e-12, "{lattice:?}");
        }
    }

    #[test]
    fn site_distance_is_never_below_the_reported_spacing() {
        let mut walled = Space::periodic_cube(7.0);
        walled.boundary[2] = Boundary::walls(1.0);
        for space in [Space::periodic_cube(7.0), walled] {
            for lattice in [Lattice::SimpleCubic, Lattice::FaceCentredCubic, Lattice::HexagonalClosePacked] {
                for count in [1, 2, 3, 50, 101] {
                    let fit = fit(lattice, &space, count);
                    let sites = fit.sites();
                    assert_eq!(sites.len(), count);
                    assert!(least_distance(&sites, &space) >= fit.spacing - 1e-12, "{lattice:?} {count}");
                    assert!(sites.iter().all(|s| (0..3).all(|k| (0.0..=7.0).contains(&s[k]))), "{lattice:?} {count}");
                }
            }
        }
    }

    #[test]
    fn close_packed_lattices_have_unit_spacing_in_their_cells() {
        // A lattice of 4 x 4 x 4 unit cells of hexagonal close packing, with edges 1, sqrt(3) and sqrt(8/3).
        let mut space = Space::periodic_cube(4.0);
        space.size = Vector::new(4.0, 4.0 * 3.0_f64.sqrt(), 4.0 * (8.0_f64 / 3.0).sqrt());
        assert!((fit(Lattice::HexagonalClosePacked, &space, 256).spacing - 1.0).abs() < 1e-12);
        space.boundary[2] = Boundary::Flat;
        assert!((fit(Lattice::Hexagonal, &space, 32).spacing - 1.0).abs() < 1e-12);
    }

    #[test]
    fn sites_keep_half_a_spacing_from_walls() {
        let mut space = Space::periodic_cube(4.0);
        space.boundary = [Boundary::walls(1.0); 3];
        let sites = fit(Lattice::SimpleCubic, &space, 64).sites();
        let least = sites.iter().map(|s| s.min()).fold(f64::INFINITY, f64::min);
        assert!((least - 0.5).abs() < 1e-12);
    }

    #[test]
    fn sites_may_touch_but_not_overlap() {
        let cube = Space::periodic_cube(6.0);
        let region = Region { lower: cube.lower, upper: cube.upper() };
        let simple = |contact| {
            sites(Lattice::SimpleCubic, &cube, &region, Sites { count: 216, diameter: 1.0, contact: Some(contact) })
        };
        assert_eq!(simple(1.0).map(|sites| sites.len()), Ok(216));
        assert_eq!(simple(1.0 + 1e-9), Err(NoPlace::TooTight { count: 216, spacing: 1.0, contact: 1.0 + 1e-9 }));
    }
}
