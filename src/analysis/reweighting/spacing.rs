//! Temperatures for replica exchange with a given swap probability.

use super::density_of_states::DensityOfStates;

const MOST_TEMPERATURES: usize = 1000;

const HALVINGS: u32 = 60;

impl DensityOfStates {
    /// Probability that two replicas in equilibrium at two temperatures `[energy]` are swapped: `sum p_1(E)
    /// p_2(E') min(1, exp((1/T_1 - 1/T_2) (E - E')))` over all pairs of levels. `p_i(E)` is the probability of the
    /// level `E` at the temperature `T_i`.
    ///
    /// C. Predescu, M. Predescu and C. V. Ciobanu, J. Chem. Phys. 120, 4119 (2004), [doi:10.1063/1.1644093](https://doi.org/10.1063/1.1644093).
    #[must_use]
    pub fn acceptance(&self, temperatures: [f64; 2]) -> f64 {
        let [cold, hot] = [f64::min, f64::max].map(|of| of(temperatures[0], temperatures[1]));
        let difference = cold.recip() - hot.recip();
        let [of_cold, of_hot] = [cold, hot].map(|temperature| self.probabilities_at(temperature));
        let mut above: f64 = of_cold.iter().sum();
        // For each level `E'` of the hot replica, `below` is the sum of `p_1(E) exp((1/T_1 - 1/T_2) (E - E'))` over the
        // levels `E < E'` of the cold replica.
        let (mut below, mut last, mut sum) = (0.0, f64::NEG_INFINITY, 0.0);
        for ((energy, _), (cold, hot)) in self.levels().zip(of_cold.iter().zip(&of_hot)) {
            if below > 0.0 {
                below *= libm::exp(-difference * (energy - last));
            }
            sum += hot * (above + below);
            (above, below, last) = (above - cold, below + cold, energy);
        }
        sum.min(1.0)
    }

    /// Finds the fewest temperatures from the lowest to the highest `[energy]`, with an equal
    /// [acceptance](Self::acceptance) of at least `acceptance` between neighbours. `None` for more than a thousand.
    #[must_use]
    pub fn temperatures_for(&self, [lowest, highest]: [f64; 2], acceptance: f64) -> Option<Vec<f64>> {
        if !(0.0 < lowest && lowest < highest && highest.is_finite() && 0.0 < acceptance && acceptance < 1.0) {
            return None;
        }
        let fewest = self.ladder(lowest, highest, acceptance, MOST_TEMPERATURES)?;
        // Finds the largest acceptance with which this number of steps reaches the highest temperature.
        let steps = fewest.len() - 1;
        let (mut from, mut to, mut best) = (acceptance, 1.0, fewest);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (from + to);
            match self.ladder(lowest, highest, middle, steps + 1) {
                Some(found) => (from, best) = (middle, found),
                None => to = middle,
            }
        }
        Some(best)
    }

    /// Lists temperatures up to the highest, as far apart as the acceptance allows. `None` if there are too many.
    fn ladder(&self, lowest: f64, highest: f64, acceptance: f64, most: usize) -> Option<Vec<f64>> {
        let mut temperatures = vec![lowest];
        let mut last = lowest;
        while last < highest {
            if temperatures.len() == most {
                return None;
            }
            let next = if self.acceptance([last, highest]) >= acceptance {
                highest
            } else {
                let (mut near, mut far) = (last, highest);
                for _ in 0..HALVINGS {
                    let middle = (near * far).sqrt();
                    let is_near = self.acceptance([last, middle]) >= acceptance;
                    if is_near { near = middle } else { far = middle }
                }
                near
            };
            if next <= last {
                return None;
            }
            temperatures.push(next);
            last = next;
        }
        Some(temperatures)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Levels 0, 1, ... with the density of states `C(60, k)`: sixty spins in a field.
    fn spins() -> DensityOfStates {
        let logarithm = |k: u32| (1..=k).map(|i| (f64::from(61 - i) / f64::from(i)).ln()).sum::<f64>();
        DensityOfStates::of_levels((0..=60).map(|k| (0.7 * f64::from(k), logarithm(k))))
    }

    #[test]
    fn the_acceptance_is_the_sum_over_all_pairs_of_levels() {
        let density = spins();
        for [one, other] in [[0.3, 0.4], [0.9, 0.5], [0.2, 3.0], [1.0, 1.0]] {
            let [p, q] = [one, other].map(|t| density.probabilities_at(t));
            let mut expected = 0.0;
            for (k, p) in p.iter().enumerate() {
                for (l, q) in q.iter().enumerate() {
                    let difference = 0.7 * (k as f64 - l as f64);
                    expected += p * q * ((1.0 / one - 1.0 / other) * difference).exp().min(1.0);
                }
            }
            let found = density.acceptance([one, other]);
            assert!((found - expected).abs() < 1e-12, "{one} {other}: {found}, expected {expected}");
        }
    }

    #[test]
    fn temperatures_have_the_same_acceptance_and_are_as_few_as_can_be() {
        let density = spins();
        for asked in [0.2, 0.35, 0.6] {
            let found = density.temperatures_for([0.15, 2.0], asked).unwrap();
            assert_eq!((found[0], found[found.len() - 1]), (0.15, 2.0));
            let all: Vec<f64> = found.windows(2).map(|pair| density.acceptance([pair[0], pair[1]])).collect();
            assert!(all.iter().all(|it| *it >= asked && (it - all[0]).abs() < 1e-6), "{all:?}");
            assert!(density.ladder(0.15, 2.0, asked, found.len() - 1).is_none());
        }
        for (ends, asked) in
            [([2.0, 0.15], 0.3), ([0.15, 2.0], 1.0), ([0.15, 2.0], 0.0), ([0.0, 2.0], 0.3), ([0.1, f64::NAN], 0.3)]
        {
            assert_eq!(density.temperatures_for(ends, asked), None);
        }
    }
}
