use super::{Chains, MOST_GROUPS};
use crate::analysis::instruments::bins::Bins;
use crate::analysis::instruments::quantity::{Curve, Measured, Normalisation, Number};
use crate::analysis::statistics::Estimate;
use crate::base::text::digits;

fn with_density(
    curve: Curve,
    symbol: &str,
    bins: Bins,
    densities: &[Option<Estimate>],
    normalisation: Normalisation,
) -> Curve {
    curve
        .variable(symbol, "length", bins.centres())
        .series(&format!("p({symbol})"), "1 / length", densities)
        .normalised(normalisation.by("bin_width", "length", bins.width()))
}

impl Chains {
    pub(super) fn report_bonds(&self, bonds: f64, measured: &mut Measured) {
        let mut number = |name: &str, title: &str, unit: &str, element: usize, method: &str| {
            measured.numbers.push(Number::estimated(name, title, unit, self.bonds.estimate(element), method));
        };
        let method = "mean distance of two bonded particles, b = <|r_ij|>";
        number("bond_length", "Bond length", "length", 0, method);
        let method = "mean square distance of two bonded particles, <r_ij^2>";
        number("mean_square_bond_length", "Mean square bond length", "length^2", 1, method);
        let method =
            "probability density of the distance of two bonded particles, over the range of their bond potentials";
        measured.curves.push(with_density(
            Curve::new("bond_length", "Distribution of bond lengths", method),
            "b",
            self.bins_of_bonds(),
            &self.bonds.estimates(2..self.bonds.len()),
            Normalisation::of("bonds in the bin, over all samples")
                .by("samples", "1", self.bonds.most())
                .by("bonds", "1", bonds),
        ));
    }

    pub(super) fn report_sizes(&self, measured: &mut Measured) {
        let mut particles: Vec<u32> = self.groups.iter().map(|group| group.particles).collect();
        particles.sort_unstable();
        particles.dedup();
        let method = format!(
            "R^2 = <|r_n - r_1|^2> of linear chains of n particles, Rg^2 = <sum_i |r_i - mean r|^2 / n>, unwrapped along \
             the bonds; the first {MOST_GROUPS} kinds"
        );
        let mut curve = Curve::new("chain_size", "Mean square sizes of chains", &method)
            .variable("n", "1", particles.iter().copied().map(f64::from).collect())
            .logarithmic([true; 2]);
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
            let squares: Vec<_> = particles.iter().map(|n| self.sizes.estimate(element(n)?)).collect();
            curve = curve.series(name, "length^2", &squares).normalised(
                Normalisation::of("squares, over all samples and chains")
                    .by_each("samples", "1", particles.iter().map(|n| samples(element(n))).collect())
                    .by_each("chains", "1", particles.iter().map(|n| chains(element(n))).collect()),
            );
        }
        measured.curves.push(curve);
    }

    pub(super) fn report_ends(&self, measured: &mut Measured) {
        for (index, group) in self.groups.iter().enumerate() {
            let Some((place, longest)) = group.distribution else { continue };
            let n = group.particles;
            let squares = [
                ("end_to_end_distance", "end-to-end distance", "R^2 = <|r_n - r_1|^2>"),
                ("radius_of_gyration", "radius of gyration", "Rg^2 = <sum_i |r_i - mean r|^2 / n>"),
            ];
            for (offset, (name, title, definition)) in squares.into_iter().enumerate() {
                measured.numbers.push(Number::estimated(
                    &format!("mean_square_{name}_{n}"),
                    &format!("Mean square {title} of {n} particles"),
                    "length^2",
                    self.sizes.estimate(2 * index + offset),
                    &format!("{definition}, unwrapped along the bonds"),
                ));
            }
            let (name, title) = (
                format!("end_to_end_distance_{n}"),
                format!("Distribution of the end-to-end distance of {n} particles"),
            );
            let method = format!(
                "probability density of |r_n - r_1| over {} linear chains of {n} particles, for distances up to {}",
                group.components,
                digits(longest)
            );
            let chains = f64::from(group.components);
            measured.curves.push(with_density(
                Curve::new(&name, &title, &method),
                "R",
                Bins::over(0.0, longest, self.bins),
                &self.ends.estimates(place * self.bins..(place + 1) * self.bins),
                Normalisation::of("chains in the bin, over all samples")
                    .by("samples", "1", self.ends.most())
                    .by("chains", "1", chains),
            ));
        }
    }
}
