//! The static structure factor.

mod vectors;

use super::instrument::{Instrument, Setup};
use super::plan;
use super::quantity::{Curve, Measured, Series, Variable};
use super::schedule::Schedule;
use super::subject::{Sample, Subject};
use crate::statistics::CurveAverage;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use vectors::Shell;

/// Vectors of one shell.
const MOST_VECTORS: f64 = 20.0;

/// A sample has no more products of particles and vectors than this, if a shell can do with six vectors.
const MOST_PRODUCTS: f64 = 4e8;

const FEWEST_VECTORS: f64 = 6.0;

/// `S(q) = |sum_j exp(i q.r_j)|^2 / N` over the particles that move, at wave vectors of the periodic axes, by shells of `|q|`.
///
/// Without a periodic axis there are no wave vectors, and nothing is measured.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct StructureFactor {
    schedule: Schedule,
    shells: Vec<Shell>,
    curve: CurveAverage,
}

impl StructureFactor {
    pub fn new(plan: &plan::StructureFactor, setup: &Setup<'_>) -> Self {
        let subject = setup.subject;
        let count = subject.moving.len().max(1) as f64;
        let diameter = subject.moving.iter().map(|&id| subject.diameters[subject.species[id as usize] as usize]);
        let diameter = diameter.fold(0.0, f64::max);
        let default = if diameter > 0.0 { 6.0 * PI / diameter } else { f64::INFINITY };
        let per_shell = (MOST_PRODUCTS / count / vectors::MOST_SHELLS).clamp(FEWEST_VECTORS, MOST_VECTORS);
        let shells = vectors::shells(&subject.space, plan.largest.unwrap_or(default), per_shell as usize);
        let products: usize = shells.iter().map(|shell| shell.vectors.len()).sum();
        let powers: usize = longest(&shells).iter().sum();
        Self {
            // Two complex products for each vector, and one for each power.
            schedule: Schedule::new(setup, plan.interval, count * (4 * products + 4 * powers) as f64),
            curve: CurveAverage::new(shells.len()),
            shells,
        }
    }
}

/// The largest multiples along the axes.
fn longest(shells: &[Shell]) -> [usize; 3] {
    let along = |k: usize| shells.iter().flat_map(move |shell| shell.vectors.iter().map(move |n| n[k].unsigned_abs()));
    std::array::from_fn(|k| along(k).max().unwrap_or(0) as usize)
}

impl Instrument for StructureFactor {
    fn next_sample(&self) -> f64 {
        self.schedule.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, subject: &Subject) {
        if !self.schedule.is_due(sample.time) {
            return;
        }
        let sums = density_modes(&self.shells, sample, subject);
        let count = subject.moving.len() as f64;
        let mut rest = &sums[..];
        let mut values = Vec::with_capacity(self.shells.len());
        for shell in &self.shells {
            let (own, after) = rest.split_at(shell.vectors.len());
            let squares: f64 = own.iter().map(|[re, im]| re * re + im * im).sum();
            values.push(squares / (count * own.len() as f64));
            rest = after;
        }
        self.curve.add_all(values);
    }

    fn report(&self, _subject: &Subject, measured: &mut Measured) {
        if self.shells.is_empty() {
            return;
        }
        measured.curves.push(Curve {
            name: "structure_factor".to_owned(),
            title: "Static structure factor".to_owned(),
            method: format!(
                "S(q) = <|sum_j exp(i q.r_j)|^2> / N over the particles that move, at {} wave vectors of the periodic box in {} \
                 shells of |q|, those along the axes and diagonals of the box first; a crystal has most of its peaks between them",
                self.shells.iter().map(|shell| shell.vectors.len()).sum::<usize>(),
                self.shells.len()
            ),
            variables: vec![Variable {
                name: "q".to_owned(),
                unit: "1 / length".to_owned(),
                values: self.shells.iter().map(|shell| shell.wave_number).collect(),
            }],
            series: vec![Series {
                name: "S(q)".to_owned(),
                unit: "1".to_owned(),
                values: self.curve.means(),
                standard_errors: self.curve.standard_errors(),
            }],
            is_logarithmic: [false; 2],
            published: Vec::new(),
        });
    }
}

fn product([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c - b * d, a * d + b * c]
}

/// `sum_j exp(i q.r_j)` for all vectors of all shells, one after the other.
///
/// One sine and cosine for each particle and axis; powers follow by multiplication, with errors of `n` units in the last place.
fn density_modes(shells: &[Shell], sample: &Sample<'_>, subject: &Subject) -> Vec<[f64; 2]> {
    let longest = longest(shells);
    let multiples: Vec<[i32; 3]> = shells.iter().flat_map(|shell| shell.vectors.iter().copied()).collect();
    // Where the power of each axis is in its table, which begins with the most negative one.
    let place = |n: &[i32; 3]| std::array::from_fn(|k| (n[k] + longest[k] as i32) as usize);
    let places: Vec<[usize; 3]> = multiples.iter().map(place).collect();
    let mut tables = longest.map(|most| vec![[1.0, 0.0]; 2 * most + 1]);
    let mut sums = vec![[0.0; 2]; multiples.len()];
    for &id in &subject.moving {
        let position = sample.positions[id as usize];
        for k in (0..3).filter(|&k| longest[k] > 0) {
            let phase = 2.0 * PI * ((position[k] - subject.space.lower[k]) / subject.space.size[k]);
            let (sine, cosine) = libm::sincos(phase);
            let mut power = [1.0, 0.0];
            for n in 1..=longest[k] {
                power = product(power, [cosine, sine]);
                tables[k][longest[k] + n] = power;
                tables[k][longest[k] - n] = [power[0], -power[1]];
            }
        }
        for (sum, &[x, y, z]) in sums.iter_mut().zip(&places) {
            let [re, im] = product(product(tables[0][x], tables[1][y]), tables[2][z]);
            sum[0] += re;
            sum[1] += im;
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;
    use crate::space::{Boundary, Space};
    use rand_chacha::ChaCha8Rng;
    use rand_core::{Rng, SeedableRng};

    fn measure(space: &Space, frames: &[Vec<Vector>]) -> StructureFactor {
        let subject = Subject::of_points(space.clone(), frames[0].len() as u32);
        let velocities = vec![Vector::zeros(); frames[0].len()];
        let sample = |k: usize| Sample {
            time: k as f64,
            positions: &frames[k],
            velocities: &velocities,
            images: &[],
            displacement: 0.0,
        };
        let plan = plan::StructureFactor { largest: Some(9.0), interval: Some(1.0) };
        let setup = Setup { subject: &subject, sample: sample(0), duration: frames.len() as f64 };
        let mut instrument = StructureFactor::new(&plan, &setup);
        (1..frames.len()).for_each(|k| instrument.sample(&sample(k), &subject));
        instrument
    }

    #[test]
    fn modes_are_the_sums_of_their_definition() {
        let boundary = [Boundary::Periodic, Boundary::walls(1.0), Boundary::Periodic];
        let space = Space { lower: Vector::new(-1.0, 3.0, 0.5), size: Vector::new(8.0, 5.0, 6.0), boundary };
        let positions: Vec<Vector> =
            (0..20).map(|k| Vector::from_fn(|axis, _| (f64::from(k) * (1.3 + axis as f64)).rem_euclid(5.0))).collect();
        let subject = Subject::of_points(space.clone(), 20);
        let sample = Sample { time: 0.0, positions: &positions, velocities: &[], images: &[], displacement: 0.0 };
        let shells = vectors::shells(&space, 20.0, 20);
        let sums = density_modes(&shells, &sample, &subject);
        let all: Vec<[i32; 3]> = shells.iter().flat_map(|shell| shell.vectors.clone()).collect();
        assert_eq!(sums.len(), all.len());
        for (n, [re, im]) in all.iter().zip(sums) {
            assert_eq!(n[1], 0, "walls have no wave vectors");
            let q = Vector::from_fn(|k, _| 2.0 * PI * f64::from(n[k]) / space.size[k]);
            let phase = |position: &Vector| q.dot(&(position - space.lower));
            let exact: [f64; 2] = [
                positions.iter().map(|position| phase(position).cos()).sum(),
                positions.iter().map(|position| phase(position).sin()).sum(),
            ];
            // Powers up to 25, 20 particles, phases up to 200 that are rounded.
            assert!((exact[0] - re).abs() < 1e-12 && (exact[1] - im).abs() < 1e-12, "{n:?}");
        }
    }

    #[test]
    fn a_lattice_scatters_into_its_reciprocal_lattice_only() {
        // A simple cubic lattice of spacing 1: 2 pi is the only wave number up to 7, in the directions of the axes.
        let site = |k: u32| Vector::new(f64::from(k % 6), f64::from(k / 6 % 6), f64::from(k / 36));
        let frame: Vec<Vector> = (0..216).map(site).collect();
        let instrument = measure(&Space::periodic_cube(6.0), &vec![frame; 10]);
        let means = instrument.curve.means();
        for (shell, mean) in instrument.shells.iter().zip(means) {
            let is_peak = |n: &&[i32; 3]| n.iter().all(|n| n % 6 == 0);
            let peaks = shell.vectors.iter().filter(is_peak).count() as f64;
            let expected = 216.0 * peaks / shell.vectors.len() as f64;
            assert!((mean.unwrap() - expected).abs() < 1e-9, "q = {}", shell.wave_number);
            assert!((shell.wave_number - 2.0 * PI).abs() > 0.6 || peaks >= 3.0);
        }
    }

    #[test]
    fn an_ideal_gas_has_no_structure() {
        let mut random = ChaCha8Rng::seed_from_u64(8);
        let mut next = || 7.0 * (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        let frames: Vec<Vec<Vector>> =
            (0..65).map(|_| (0..50).map(|_| Vector::from_fn(|_, _| next())).collect()).collect();
        let instrument = measure(&Space::periodic_cube(7.0), &frames);
        let (means, errors) = (instrument.curve.means(), instrument.curve.standard_errors());
        assert!(means.len() >= 9);
        for (shell, (mean, error)) in instrument.shells.iter().zip(means.into_iter().zip(errors)) {
            // |sum|^2 / N is distributed exponentially, with mean and deviation 1.
            let exact = (1.0 / (64.0 * shell.vectors.len() as f64)).sqrt();
            assert!((mean.unwrap() - 1.0).abs() < 4.0 * exact, "{mean:?} +- {exact}");
            assert!((error.unwrap() / exact - 1.0).abs() < 0.6, "{error:?} but {exact}");
        }
    }
}
