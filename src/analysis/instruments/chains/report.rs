//! What the sizes of chains are called.

use super::{Chains, MOST_GROUPS};
use crate::analysis::instruments::quantity::{Curve, Measured, Number, Series, Variable};
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
    values: &[Option<f64>],
    errors: &[Option<f64>],
) -> Curve {
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
        }],
        is_logarithmic: [false; 2],
        published: Vec::new(),
    }
}

impl Chains {
    pub(super) fn report_bonds(&self, measured: &mut Measured) {
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
            &self.bonds.means()[2..],
            &self.bonds.standard_errors()[2..],
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
            series.push(Series {
                name: name.to_owned(),
                unit: "length^2".to_owned(),
                values: particles.iter().map(|n| means[element(n)?]).collect(),
                standard_errors: particles.iter().map(|n| errors[element(n)?]).collect(),
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
                &means[range.clone()],
                &errors[range],
            ));
        }
    }
}
