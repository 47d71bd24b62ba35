//! Pair potentials: step functions given by radii and energies.

use super::diameters::scaled_distance;
use crate::model::error::PotentialError;
use serde::{Deserialize, Serialize};

/// A stepped potential: spherically symmetric, constant between discontinuities.
///
/// The radii are `s_1 > s_2 > ... > s_n > 0` `[length]`, and the energies are `U_0, U_1, ..., U_n` `[energy]`. The
/// energy is `U_k` for `s_{k+1} <= r < s_k`, and `U_0` outside. Hard spheres, wells, shoulders, bonds and stepped
/// approximations of smooth potentials have this form (Bannerman and Strobl, section 1).
///
/// The *pair state* `k` is the number of radii through which the pair has been captured. In state `k`, the pair can
/// reach the outer radius `s_k` and the inner radius `s_{k+1}`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Potential {
    radii: Vec<f64>,
    energies: Vec<f64>,
}

impl Potential {
    /// Creates a potential from radii and energies, from outside to inside. The first energy is for distances beyond
    /// all radii.
    ///
    /// # Errors
    /// [`PotentialError`] unless the radii are positive, finite and descending, and there is one more energy than
    /// radii. The first energy must be 0 or positive infinity. The last energy must be finite or positive infinity, and
    /// all others finite. At least one energy must be finite.
    pub fn new(radii: Vec<f64>, energies: Vec<f64>) -> Result<Self, PotentialError> {
        if radii.is_empty() {
            return Err(PotentialError::NoRadius);
        }
        if energies.len() != radii.len() + 1 {
            return Err(PotentialError::Count { radii: radii.len(), energies: energies.len() });
        }
        for (index, &radius) in radii.iter().enumerate() {
            if !(radius.is_finite() && radius > 0.0 && (radius * radius).is_normal()) {
                return Err(PotentialError::Radius { index, radius });
            }
            if index > 0 && radius >= radii[index - 1] {
                return Err(PotentialError::Order { index, radius, outer: radii[index - 1] });
            }
        }
        let last = energies.len() - 1;
        for (index, &energy) in energies.iter().enumerate() {
            let may_be_infinite = index == last || index == 0;
            if energy.is_nan() || energy == f64::NEG_INFINITY || (energy.is_infinite() && !may_be_infinite) {
                return Err(PotentialError::Energy { index, energy });
            }
        }
        if energies.iter().all(|energy| energy.is_infinite()) {
            return Err(PotentialError::Inaccessible);
        }
        if energies[0].is_finite() && energies[0] != 0.0 {
            return Err(PotentialError::Outside { energy: energies[0] });
        }
        Ok(Self { radii, energies })
    }

    /// Returns the potential of a pair of particles, see [`scaled_distance`]. `of_pair` is the sum of their radii. The
    /// energies stay the same.
    pub(crate) fn scaled(&self, of_species: f64, of_pair: f64) -> Self {
        let radii = self.radii.iter().map(|radius| scaled_distance(*radius, of_species, of_pair));
        Self { radii: radii.collect(), energies: self.energies.clone() }
    }

    pub(crate) fn grow(&mut self, factor: f64) {
        self.radii.iter_mut().for_each(|radius| *radius *= factor);
    }

    /// Hard spheres that touch at `diameter`. The energy is 0 outside and infinite inside.
    ///
    /// # Errors
    /// [`PotentialError`] if the diameter is not finite and positive.
    pub fn hard_sphere(diameter: f64) -> Result<Self, PotentialError> {
        Self::new(vec![diameter], vec![0.0, f64::INFINITY])
    }

    /// A hard core in a well of depth `well_depth`, which reaches to `lambda * diameter`.
    ///
    /// # Errors
    /// [`PotentialError`] if the diameter is not positive or `lambda <= 1`.
    pub fn square_well(diameter: f64, lambda: f64, well_depth: f64) -> Result<Self, PotentialError> {
        Self::new(vec![lambda * diameter, diameter], vec![0.0, -well_depth, f64::INFINITY])
    }

    /// A hard core inside a shoulder of height `height`, which reaches to `lambda * diameter`.
    ///
    /// # Errors
    /// [`PotentialError`] if the diameter is not positive or `lambda <= 1`.
    pub fn square_shoulder(diameter: f64, lambda: f64, height: f64) -> Result<Self, PotentialError> {
        Self::square_well(diameter, lambda, -height)
    }

    /// Penetrable spheres. The energy inside `diameter` is `height`.
    ///
    /// # Errors
    /// [`PotentialError`] if the diameter is not positive, or if the height is not finite.
    pub fn penetrable(diameter: f64, height: f64) -> Result<Self, PotentialError> {
        Self::new(vec![diameter], vec![0.0, height])
    }

    /// A bond, the infinite square well: the pair stays between `shortest` and `longest`.
    ///
    /// # Errors
    /// [`PotentialError`] unless `0 < shortest < longest`.
    pub fn bond(shortest: f64, longest: f64) -> Result<Self, PotentialError> {
        Self::new(vec![longest, shortest], vec![f64::INFINITY, 0.0, f64::INFINITY])
    }

    /// Lennard-Jones potential in steps of equal width, between the cut-off and a hard core.
    ///
    /// `u(r) = 4 eps [(sigma/r)^12 - (sigma/r)^6]`, cut at `cutoff` (not shifted). The energy of a step from `r_b` to
    /// `r_a` is the average of `u` over the shell, `3 int u r^2 dr / (r_a^3 - r_b^3)` (Chapela, Scriven and Davis, J.
    /// Chem. Phys. 91, 4307, 1989). The hard core begins where `u` reaches `core_energy`.
    ///
    /// # Errors
    /// [`PotentialError`] if a length or energy is not positive and finite, `steps` is 0, or `cutoff` is inside the
    /// core.
    pub fn stepped_lennard_jones(
        diameter: f64,
        well_depth: f64,
        cutoff: f64,
        steps: usize,
        core_energy: f64,
    ) -> Result<Self, PotentialError> {
        for (name, value) in
            [("diameter", diameter), ("well_depth", well_depth), ("cutoff", cutoff), ("core_energy", core_energy)]
        {
            if !(value.is_finite() && value > 0.0) {
                return Err(PotentialError::Parameter { name, value });
            }
        }
        if steps == 0 {
            return Err(PotentialError::NoRadius);
        }
        // With `x = (sigma/r)^6`, `u(r) = core_energy` is the quadratic equation `4 eps (x^2 - x) = core_energy`.
        let x = 0.5 * (1.0 + (1.0 + core_energy / well_depth).sqrt());
        let core = diameter / libm::cbrt(x).sqrt();
        if cutoff <= core {
            return Err(PotentialError::Order { index: 1, radius: core, outer: cutoff });
        }
        let width = (cutoff - core) / steps as f64;
        let radius = |k: usize| if k == steps { core } else { cutoff - k as f64 * width };
        // Integral of `u(r) r^2` from infinity to `r`: `4 eps sigma^3 (s^3/3 - s^9/9)` with `s = sigma/r`.
        let integral = |r: f64| {
            let s3 = (diameter / r) * (diameter / r) * (diameter / r);
            4.0 * well_depth * diameter * diameter * diameter * (s3 / 3.0 - s3 * s3 * s3 / 9.0)
        };
        let cube = |r: f64| r * r * r;
        let mut radii = Vec::with_capacity(steps + 1);
        let mut energies = vec![0.0];
        for k in 0..steps {
            let (outer, inner) = (radius(k), radius(k + 1));
            radii.push(outer);
            energies.push(3.0 * (integral(outer) - integral(inner)) / (cube(outer) - cube(inner)));
        }
        radii.push(core);
        energies.push(f64::INFINITY);
        Self::new(radii, energies)
    }

    /// The discontinuities `s_1 > s_2 > ... > s_n` `[length]`.
    #[must_use]
    pub fn radii(&self) -> &[f64] {
        &self.radii
    }

    /// The energies `U_0 ... U_n` `[energy]`.
    #[must_use]
    pub fn energies(&self) -> &[f64] {
        &self.energies
    }

    /// The outermost radius `[length]`. Uncaptured pairs beyond this distance do not interact.
    #[must_use]
    pub fn range(&self) -> f64 {
        self.radii[0]
    }

    /// The radius of the hard core, if the innermost energy is infinite `[length]`.
    #[must_use]
    pub fn core(&self) -> Option<f64> {
        (self.energies[self.radii.len()] == f64::INFINITY).then(|| self.radii[self.radii.len() - 1])
    }

    /// Whether the potential has no steps outside the hard core.
    #[must_use]
    pub fn is_hard_sphere(&self) -> bool {
        self.energies[1] == f64::INFINITY
    }

    /// Whether the pair is held together by an infinite outer barrier.
    #[must_use]
    pub fn is_bond(&self) -> bool {
        self.energies[0] == f64::INFINITY
    }

    /// Range of the states with finite energy. A hard core limits the highest state, and a bond the lowest.
    #[must_use]
    pub fn accessible_states(&self) -> std::ops::RangeInclusive<usize> {
        let lowest = usize::from(self.energies[0].is_infinite());
        let highest = self.radii.len() - usize::from(self.energies[self.radii.len()].is_infinite());
        lowest..=highest
    }

    /// Initial state of a pair at `distance`; the nearest accessible state if this distance is forbidden.
    #[must_use]
    pub fn state_at(&self, distance: f64) -> usize {
        let captured = self.radii.iter().take_while(|&&radius| distance < radius).count();
        let states = self.accessible_states();
        captured.clamp(*states.start(), *states.end())
    }

    /// How far a distance is in the forbidden region, relative to the radius of the discontinuity. 0 if allowed.
    #[must_use]
    pub fn violation_at(&self, distance: f64) -> f64 {
        let inside = self.core().map_or(0.0, |core| (core - distance) / core);
        let outside = if self.is_bond() { (distance - self.radii[0]) / self.radii[0] } else { 0.0 };
        inside.max(outside).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_well_has_a_well_between_two_radii() {
        let well = Potential::square_well(2.0, 1.5, 0.5).unwrap();
        assert_eq!(well.radii(), [3.0, 2.0]);
        assert_eq!(well.energies(), [0.0, -0.5, f64::INFINITY]);
        assert_eq!(well.accessible_states(), 0..=1);
        assert_eq!(well.core(), Some(2.0));
    }

    #[test]
    fn the_state_at_a_distance_changes_one_float_inside_the_discontinuity() {
        let well = Potential::square_well(1.0, 1.5, 1.0).unwrap();
        assert_eq!(well.state_at(1.5), 0);
        assert_eq!(well.state_at(1.5_f64.next_down()), 1);
        assert_eq!(well.state_at(0.9), 1, "no pair is captured through a hard core");
        let bond = Potential::bond(1.0, 1.06).unwrap();
        assert_eq!(bond.state_at(2.0), 1, "a bonded pair is always within the range of its bond");
    }

    #[test]
    fn invalid_radii_or_energies_are_rejected() {
        let inf = f64::INFINITY;
        assert_eq!(Potential::new(vec![], vec![0.0]), Err(PotentialError::NoRadius));
        assert!(matches!(Potential::new(vec![1.0], vec![0.0]), Err(PotentialError::Count { .. })));
        assert!(matches!(Potential::new(vec![1.0, 1.0], vec![0.0; 3]), Err(PotentialError::Order { .. })));
        assert!(matches!(Potential::new(vec![1.0], vec![0.0, -inf]), Err(PotentialError::Energy { .. })));
        assert!(matches!(Potential::new(vec![2.0, 1.0], vec![0.0, inf, 1.0]), Err(PotentialError::Energy { .. })));
        assert!(matches!(Potential::new(vec![1.0], vec![inf, inf]), Err(PotentialError::Inaccessible)));
        assert!(matches!(Potential::new(vec![f64::NAN], vec![0.0, 1.0]), Err(PotentialError::Radius { .. })));
        assert!(matches!(Potential::new(vec![1e-200], vec![0.0, 1.0]), Err(PotentialError::Radius { .. })));
        assert!(matches!(Potential::new(vec![1.0], vec![1.0, 0.0]), Err(PotentialError::Outside { .. })));
    }

    #[test]
    fn stepped_lennard_jones_keeps_the_volume_integral() {
        let (sigma, eps, cutoff) = (1.0, 1.0, 2.5);
        let lj = Potential::stepped_lennard_jones(sigma, eps, cutoff, 40, 50.0).unwrap();
        let core = lj.core().unwrap();
        let sum: f64 =
            (0..40).map(|k| lj.energies()[k + 1] * (lj.radii()[k].powi(3) - lj.radii()[k + 1].powi(3)) / 3.0).sum();
        let exact = |r: f64| 4.0 * (r.powi(-9) / -9.0 + r.powi(-3) / 3.0);
        assert!((sum - (exact(cutoff) - exact(core))).abs() < 1e-13);
        let at_core = 4.0 * (core.powi(-12) - core.powi(-6));
        assert!((at_core - 50.0).abs() < 1e-11);
    }
}
