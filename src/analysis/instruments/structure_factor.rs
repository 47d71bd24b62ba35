mod vectors;

use super::budgeted_times::budgeted_times;
use super::instrument::{Instrument, Setup};
use super::quantity::{Curve, Measured, Normalisation};
use super::system::{Sample, SystemDescription};
use crate::analysis::sampling_times::SamplingTimes;
use crate::analysis::statistics::CurveAverage;
use crate::base::numbers::trunc_to_usize;
use crate::model::measurement_plan as plan;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use vectors::Shell;

const MOST_VECTORS: f64 = 20.0;

/// Limit of the number of particles times the number of wave vectors. Shells may have six wave vectors in any case.
const MOST_PRODUCTS: f64 = 4e8;

const FEWEST_VECTORS: f64 = 6.0;

/// The static structure factor `S(q) = |sum_j exp(i q.r_j)|^2 / N` of the moving particles, by shells of `|q|`.
///
/// Wave vectors exist only along periodic axes. In a sheared box they change, because the periodic images slide.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct StructureFactor {
    times: SamplingTimes,
    /// Measured shells of wave vectors. In a sheared box, each sample replaces them.
    shells: Vec<Shell>,
    curve: CurveAverage,
    sliding: Option<Sliding>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Sliding {
    largest: f64,
    per_shell: usize,
    wave_numbers: CurveAverage,
}

impl StructureFactor {
    pub fn new(plan: &plan::StructureFactor, setup: &Setup<'_>) -> Self {
        let system = setup.system;
        let count = system.moving.len().max(1) as f64;
        let diameter = system.moving.iter().map(|&id| system.diameter_of(id));
        let diameter = diameter.fold(0.0, f64::max);
        let default = if diameter > 0.0 { 6.0 * PI / diameter } else { f64::INFINITY };
        let per_shell = (MOST_PRODUCTS / count / vectors::MOST_SHELLS).clamp(FEWEST_VECTORS, MOST_VECTORS);
        let (largest, per_shell) = (plan.largest.unwrap_or(default), trunc_to_usize(per_shell));
        let is_sliding = system.shear_rate != 0.0;
        let shells = if is_sliding {
            vectors::all_shells(&system.space, setup.sample.displacement, largest, per_shell)
        } else {
            vectors::shells(&system.space, largest, per_shell)
        };
        let products: usize = shells.iter().map(|shell| shell.vectors.len()).sum();
        let powers: usize = longest(&shells).iter().sum();
        Self {
            // For each particle, a sample costs two complex products per wave vector, and one per tabulated power.
            times: budgeted_times(setup, plan.interval, count * (4 * products + 4 * powers) as f64),
            curve: CurveAverage::new(shells.len()),
            sliding: is_sliding.then(|| Sliding { largest, per_shell, wave_numbers: CurveAverage::new(shells.len()) }),
            shells,
        }
    }

    fn measured_shells(&self) -> Vec<(usize, f64)> {
        match &self.sliding {
            None => self.shells.iter().map(|shell| shell.wave_number).enumerate().collect(),
            Some(sliding) => {
                let means = sliding.wave_numbers.means().into_iter().enumerate();
                means.filter_map(|(index, mean)| Some((index, mean?))).collect()
            }
        }
    }

    fn normalisation(&self, shells: &[(usize, f64)], system: &SystemDescription) -> Normalisation {
        let particles = system.moving.len() as f64;
        let samples = shells.iter().map(|&(index, _)| self.curve.count(index)).collect();
        let (sum, vectors) = match &self.sliding {
            None => {
                let vectors = shells.iter().map(|&(index, _)| self.shells[index].vectors.len() as f64).collect();
                ("|sum_j exp(i q.r_j)|^2, over all samples and wave vectors of the shell", Some(vectors))
            }
            // The number of wave vectors in a shell changes from sample to sample.
            Some(_) => ("mean of |sum_j exp(i q.r_j)|^2 over the wave vectors of the shell, over all samples", None),
        };
        let normalisation = Normalisation::of(sum).by_each("samples", "1", samples).by("particles", "1", particles);
        match vectors {
            Some(vectors) => normalisation.by_each("wave_vectors", "1", vectors),
            None => normalisation,
        }
    }

    fn method(&self, shells: usize) -> String {
        let vectors = match &self.sliding {
            None => {
                let vectors = self.shells.iter().map(|shell| shell.vectors.len()).sum::<usize>();
                format!("{vectors} wave vectors of the periodic box")
            }
            Some(_) => "the wave vectors that the sheared box has at the time of each sample, 2 pi (n_x / L_x, (n_y - n_x d / L_x) / \
                        L_y, n_z / L_z) with the displacement d of its images, q being their mean,"
                .to_owned(),
        };
        format!(
            "S(q) = <|sum_j exp(i q.r_j)|^2> / N over the particles that move, at {vectors} in {shells} shells of |q|, those along the \
             axes and diagonals of the box first; a crystal has most of its peaks between them"
        )
    }
}

fn longest(shells: &[Shell]) -> [usize; 3] {
    let along = |k: usize| shells.iter().flat_map(move |shell| shell.vectors.iter().map(move |n| n[k].unsigned_abs()));
    std::array::from_fn(|k| along(k).max().unwrap_or(0) as usize)
}

impl Instrument for StructureFactor {
    fn next_sample(&self) -> f64 {
        self.times.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        if !self.times.is_due(sample.time) {
            return;
        }
        if let Some(sliding) = &mut self.sliding {
            let Sliding { largest, per_shell, wave_numbers } = sliding;
            self.shells = vectors::all_shells(&system.space, sample.displacement, *largest, *per_shell);
            // A shell without vectors adds nothing.
            let of = |shell: &Shell| if shell.vectors.is_empty() { f64::NAN } else { shell.wave_number };
            wave_numbers.add_all(self.shells.iter().map(of));
        }
        let sums = density_modes(&self.shells, sample, system);
        let count = system.moving.len() as f64;
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

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        let shells = self.measured_shells();
        if shells.is_empty() {
            return;
        }
        let (elements, wave_numbers): (Vec<_>, Vec<_>) = shells.iter().copied().unzip();
        measured.curves.push(
            Curve::new("structure_factor", "Static structure factor", &self.method(shells.len()))
                .variable("q", "1 / length", wave_numbers)
                .series("S(q)", "1", &self.curve.estimates(elements))
                .normalised(self.normalisation(&shells, system)),
        );
    }
}

fn product([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c - b * d, a * d + b * c]
}

/// `sum_j exp(i q.r_j)` for all wave vectors, shell by shell.
///
/// One sine and one cosine are calculated per particle and axis, and powers follow by multiplication. The `n`-th power
/// has a round-off error of `n` units in the last place.
fn density_modes(shells: &[Shell], sample: &Sample<'_>, system: &SystemDescription) -> Vec<[f64; 2]> {
    let longest = longest(shells);
    let multiples: Vec<[i32; 3]> = shells.iter().flat_map(|shell| shell.vectors.iter().copied()).collect();
    // Index of each power in the table of its axis. The table begins with the most negative power.
    let place = |n: &[i32; 3]| std::array::from_fn(|k| longest[k].saturating_add_signed(n[k] as isize));
    let places: Vec<[usize; 3]> = multiples.iter().map(place).collect();
    let mut tables = longest.map(|most| vec![[1.0, 0.0]; 2 * most + 1]);
    let mut sums = vec![[0.0; 2]; multiples.len()];
    for &id in &system.moving {
        let mut position = sample.positions[id as usize];
        if sample.displacement != 0.0 {
            // The phases below assume a box without shear. The shift grows linearly with the height.
            position.x -= sample.displacement * ((position.y - system.space.lower.y) / system.space.size.y);
        }
        for k in (0..3).filter(|&k| longest[k] > 0) {
            let phase = 2.0 * PI * ((position[k] - system.space.lower[k]) / system.space.size[k]);
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
mod tests;
