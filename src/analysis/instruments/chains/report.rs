//! Report of the sizes of chains.

use super::{Chains, MOST_GROUPS};
use crate::analysis::instruments::quantity::{Curve, Measured, Normalisation, Number, Series, Variable};
use crate::analysis::statistics::Estimate;

fn number(name: String, title: String, unit: &str, estimate: Option<Estimate>, method: &str) -> Number {
    Number {
        name,
        title,
        unit: unit.to_owned(),
        mean: estimate.map(|estimate| estimate.mean),
        standard_error: estimate.and_then(|estimate| estimate.standard_error),
        method: method.to_owned(),
    }
}

/// Centres of even bins.
fn centres([from, to]: [f64; 2], bins: usize) -> Vec<f64> {
    (0..bins).map(|k| from + (to - from) * ((k as f64 + 0.5) / bins as f64)).collect()
}

/// A probability density over even bins.
fn distribution(
    [name, title, symbol]: [&str; 3],
    method: String,
    ends: [f64; 2],
    [values, errors]: [&[Option<f64>]; 2],
    normalisation: Normalisation,
) -> Curve {
    let width = (ends[1] - ends[0]) / values.len() as f64;
    Curve {
        name: name.to_owned(),
        title: title.to_owned(),
        method,
        variables: vec![Variable {
            name: symbol.to_owned(),
            unit: "length".to_owned(),
            values: centres(ends, values.len()),
        }],
        series: vec![Series {
            name: format!("p({symbol})"),
            unit: "1 / length".to_owned(),
            values: values.to_vec(),
            standard_errors: errors.to_vec(),
            normalisation: Some(normalisation.by("bin_width", "length", width)),
        }],
        is_logarithmic: [false; 2],
        published: Vec::new(),
    }
}

impl Chains {
    pub(super) fn report_bonds(&self, bonds: f64, measured: &mut Measured) {
        let length = "mean distance of two bonded particles, b = <|r_ij|>";
        let square = "mean square distance of two bonded particles, <r_ij^2>";
        measured.numbers.extend([
            number("bond_length".to_owned(), "Bond length".to_owned(), "length", self.bonds.estimate(0), length),
            number(
                "mean_square_bond_length".to_owned(),
                "Mean square bond length".to_owned(),
                "length^2",
                self.bonds.estimate(1),
                square,
            ),
        ]);
        measured.curves.push(distribution(
            ["bond_length", "Distribution of bond lengths", "b"],
            "probability density of the distance of two bonded particles, between the ends of their potentials"
                .to_owned(),
            self.bond_lengths,
            [&self.bonds.means()[2..], &self.bonds.standard_errors()[2..]],
            Normalisation::of("bonds in the bin, over all samples")
                .by("samples", "1", self.bonds.most())
                .by("bonds", "1", bonds),
        ));
    }

    pub(super) fn report_sizes(&self, measured: &mut Measured) {
        let (means, errors) = (self.sizes.means(), self.sizes.standard_errors());
        let mut particles: Vec<u32> = self.groups.iter().map(|group| group.particles).collect();
        particles.sort_unstable();
        particles.dedup();
        let mut series = Vec::new();
        for (is_linear, offset, name) in
            [(true, 0, "R^2"), (true, 1, "Rg^2"), (false, 1, "Rg^2 of branched or closed ones")]
        {
            if !self.groups.iter().any(|group| group.is_linear == is_linear) {
                continue;
            }
            let element = |&n: &u32| {
                let group = self.groups.iter().position(|group| group.is_linear == is_linear && group.particles == n);
                group.map(|group| 2 * group + offset)
            };
            let samples = |element: Option<usize>| element.map_or(0.0, |element| self.sizes.count(element));
            let chains =
                |element: Option<usize>| element.map_or(0.0, |element| f64::from(self.groups[element / 2].components));
            series.push(Series {
                name: name.to_owned(),
                unit: "length^2".to_owned(),
                values: particles.iter().map(|n| means[element(n)?]).collect(),
                standard_errors: particles.iter().map(|n| errors[element(n)?]).collect(),
                normalisation: Some(
                    Normalisation::of("squares, over all samples and chains")
                        .by_each("samples", "1", particles.iter().map(|n| samples(element(n))).collect())
                        .by_each("chains", "1", particles.iter().map(|n| chains(element(n))).collect()),
                ),
            });
        }
        measured.curves.push(Curve {
            name: "chain_size".to_owned(),
            title: "Mean square sizes of chains".to_owned(),
            method: format!(
                "R^2 = <|r_n - r_1|^2> of linear chains of n particles, Rg^2 = <sum_i |r_i - mean r|^2 / n>, unwrapped along \
                 the bonds; the first {MOST_GROUPS} kinds"
            ),
            variables: vec![Variable {
                name: "n".to_owned(),
                unit: "1".to_owned(),
                values: particles.into_iter().map(f64::from).collect(),
            }],
            series,
            is_logarithmic: [true; 2],
            published: Vec::new(),
        });
    }

    /// Numbers and distributions of the shortest linear chains.
    pub(super) fn report_ends(&self, measured: &mut Measured) {
        let (means, errors) = (self.ends.means(), self.ends.standard_errors());
        for (index, group) in self.groups.iter().enumerate() {
            let Some((place, longest)) = group.distribution else { continue };
            let n = group.particles;
            measured.numbers.extend([
                number(
                    format!("mean_square_end_to_end_distance_{n}"),
                    format!("Mean square end-to-end distance of {n} particles"),
                    "length^2",
                    self.sizes.estimate(2 * index),
                    "R^2 = <|r_n - r_1|^2>, unwrapped along the bonds",
                ),
                number(
                    format!("mean_square_radius_of_gyration_{n}"),
                    format!("Mean square radius of gyration of {n} particles"),
                    "length^2",
                    self.sizes.estimate(2 * index + 1),
                    "Rg^2 = <sum_i |r_i - mean r|^2 / n>, unwrapped along the bonds",
                ),
            ]);
            let range = place * self.bins..(place + 1) * self.bins;
            measured.curves.push(distribution(
                [
                    &format!("end_to_end_distance_{n}"),
                    &format!("Distribution of the end-to-end distance of {n} particles"),
                    "R",
                ],
                format!(
                    "probability density of |r_n - r_1| over {} linear chains of {n} particles, up to {longest}",
                    group.components
                ),
                [0.0, longest],
                [&means[range.clone()], &errors[range]],
                Normalisation::of("chains in the bin, over all samples").by("samples", "1", self.ends.most()).by(
                    "chains",
                    "1",
                    f64::from(group.components),
                ),
            ));
        }
    }
}
