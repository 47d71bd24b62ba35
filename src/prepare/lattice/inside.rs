//! Lattice sites in a region that is not a box.

use super::{Fit, Lattice, Sites};
use crate::Vector;
use crate::base::numbers::trunc_to_usize;
use crate::model::FillRegion;
use crate::model::space::Space;
use crate::prepare::NoPlace;

/// With each attempt, the number of sites in the bounding box grows by this factor.
const STEP: f64 = 1.02;

/// Largest number of lattice sites, divided by the number expected from the volume of the region.
const MOST_SITES: f64 = 20.0;

/// Number of lattice sites in the bounding box of a region with about `count` sites.
pub(crate) fn sites_around(region: &FillRegion, space: &Space, count: usize) -> f64 {
    count as f64 * FillRegion::Box(region.bounds(space)).volume(space) / region.volume(space)
}

/// Returns lattice sites inside a region, one for each particle. The lattice is the widest lattice with enough sites.
pub(crate) fn sites_inside(
    lattice: Lattice,
    space: &Space,
    region: &FillRegion,
    sites: Sites,
) -> Result<Vec<Vector>, NoPlace> {
    let Sites { count, diameter, contact } = sites;
    let bounds = region.bounds(space);
    let wanted = sites_around(region, space, count);
    let most = MOST_SITES * wanted + 1e4;
    let mut total = (0.5 * wanted).max(count as f64);
    loop {
        let mut fit = Fit::new(lattice, space, &bounds, diameter, trunc_to_usize(total.ceil()));
        let is_tight = contact.is_some_and(|contact| fit.spacing < contact * (1.0 - 1e-12));
        if is_tight || total > most {
            return Err(NoPlace::TooTight { count, spacing: fit.spacing, contact: contact.unwrap_or(0.0) });
        }
        fit.count = fit.all();
        let inside: Vec<Vector> = fit.sites().into_iter().filter(|site| region.holds(site, 0.5 * diameter)).collect();
        if inside.len() >= count {
            let site = |particle: usize| inside[particle * inside.len() / count];
            return Ok((0..count).map(site).collect());
        }
        total = (total * STEP).max(fit.count as f64 + 1.0);
    }
}

#[cfg(test)]
pub(super) fn least_distance(sites: &[Vector], space: &Space) -> f64 {
    let mut least = f64::INFINITY;
    for (i, a) in sites.iter().enumerate() {
        for b in &sites[..i] {
            least = least.min(crate::model::space::minimum_image(a - b, &space.periods()).norm());
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn region_is_filled_with_sites_of_one_lattice() {
        let cube = Space::periodic_cube(20.0);
        let axis = Vector::new(0.0, 1.0, 1.0);
        for (region, lattice, count) in [
            (FillRegion::Sphere { centre: Vector::repeat(10.0), radius: 5.0 }, Lattice::FaceCentredCubic, 300),
            (
                FillRegion::Cone { base: Vector::repeat(6.0), axis, radii: [3.0, 3.0], length: 9.0 },
                Lattice::SimpleCubic,
                100,
            ),
            (
                FillRegion::Cone { base: Vector::repeat(6.0), axis, radii: [5.0, 1.0], length: 9.0 },
                Lattice::SimpleCubic,
                1,
            ),
        ] {
            let fill = |contact| sites_inside(lattice, &cube, &region, Sites { count, diameter: 1.0, contact });
            let sites = fill(Some(1.0)).unwrap();
            assert_eq!(sites.len(), count);
            assert!(sites.iter().all(|site| region.holds(site, 0.5)), "{region:?}");
            assert!(count == 1 || least_distance(&sites, &cube) >= 1.0 - 1e-12, "{region:?}");
            assert!(count == 1 || matches!(fill(Some(2.0)), Err(NoPlace::TooTight { .. })), "{region:?}");
        }
        // In half of the sphere, the sites would be closer.
        let sphere = FillRegion::Sphere { centre: Vector::repeat(10.0), radius: 5.0 };
        let sites =
            sites_inside(Lattice::FaceCentredCubic, &cube, &sphere, Sites { count: 350, diameter: 1.0, contact: None });
        assert!(least_distance(&sites.unwrap(), &cube) > 1.0);
    }
}
