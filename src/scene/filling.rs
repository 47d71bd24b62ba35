//! How many particles a fill has, of which species and where: any two of box, count and density give the third.

use std::f64::consts::PI;

use crate::Vector;
use crate::base::numbers::{index, trunc_to_u64, trunc_to_usize};
use crate::model::Region;
use crate::model::scene::own_volume;
use crate::model::space::{Boundary, Space};
use crate::model::{Species, SpeciesId};
use crate::scene::builder::SceneBuilder;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind};
use crate::scene::interactions::species_named;
use crate::scene::lattice::{Fit, root};
use crate::scene::limits::{AXES, affordable, finite_vector, positive};
use crate::scene::packing::occupancy::Contacts;
use crate::scene::unvalidated::{Amount, Fill, Group, Lattice};

/// A fill whose numbers are known.
pub(crate) struct Filling {
    /// Species and how many of each.
    shares: Vec<(SpeciesId, usize)>,
    pub region: Region,
}

impl Filling {
    pub(crate) fn new(fill: &Fill, species: &[Species], space: &Space, at: &ConfigPath) -> Result<Self, SceneError> {
        let count = index(Self::count(fill, species, space, at)?);
        let shares = shares(fill, species, at)?;
        Ok(Self { shares: whole_numbers(&shares, count), region: region(fill, space, at)? })
    }

    /// Number of particles.
    pub(crate) fn count(fill: &Fill, species: &[Species], space: &Space, at: &ConfigPath) -> Result<u64, SceneError> {
        let region = region(fill, space, at)?;
        let shares = shares(fill, species, at)?;
        let count = match (fill.count, fill.amount) {
            (Some(0), _) => return Err(SceneError::new(at.key("count"), SceneErrorKind::value(0, "at least 1"))),
            (Some(count), _) => count,
            (None, Some(amount)) => {
                let volume: f64 = (0..3)
                    .filter(|&k| space.boundary[k] != Boundary::Flat)
                    .map(|k| region.upper[k] - region.lower[k])
                    .product();
                let count = (volume / volume_per_particle(amount, &shares, species, space, at)?).round();
                if count < 1.0 {
                    let kind =
                        SceneErrorKind::value(format!("too low for one particle in a volume of {volume}"), "more");
                    return Err(SceneError::new(at.key(key_of(amount)), kind));
                }
                trunc_to_u64(count)
            }
            (None, None) => {
                let why = "or number_density or packing_fraction".to_owned();
                return Err(SceneError::new(at.clone(), SceneErrorKind::Missing { key: "count", why }));
            }
        };
        affordable(count, at)?;
        Ok(count)
    }

    /// The species of each particle, in order.
    pub(crate) fn kinds(&self) -> Vec<SpeciesId> {
        self.shares.iter().flat_map(|&(species, count)| std::iter::repeat_n(species, count)).collect()
    }

    /// The species.
    pub(crate) fn species(&self) -> impl Iterator<Item = SpeciesId> + '_ {
        self.shares.iter().filter(|(_, count)| *count > 0).map(|(species, _)| *species)
    }

    /// The sites of a lattice; with `contacts`, they have to be far enough apart for every species.
    pub(crate) fn on_lattice(
        &self,
        lattice: Lattice,
        space: &Space,
        species: &[Species],
        contacts: Option<&Contacts>,
        at: &ConfigPath,
    ) -> Result<Vec<Vector>, SceneError> {
        if lattice.dimensions() != space.dimensions() {
            let expected = match space.dimensions() {
                3 => "`sc`, `bcc`, `fcc`, `hcp` or `random` because no axis is flat",
                2 => "`square`, `hexagonal` or `random` because one axis is flat",
                _ => "`line` or `random` because two axes are flat",
            };
            let value = format!("a lattice of {} dimensions", lattice.dimensions());
            return Err(SceneError::new(at.key("arrangement"), SceneErrorKind::value(value, expected)));
        }
        let count = self.shares.iter().map(|(_, count)| count).sum();
        let largest = self.species().map(|kind| species[kind.0 as usize].diameter).fold(0.0, f64::max);
        let fit = Fit::new(lattice, space, &self.region, largest, count);
        if let Some(contacts) = contacts {
            let mut is_here = vec![false; species.len()];
            self.species().for_each(|kind| is_here[kind.0 as usize] = true);
            let here = contacts.iter().filter(|([a, b], _)| is_here[*a] && is_here[*b]);
            let contact = here.map(|(_, contact)| contact).fold(0.0, f64::max);
            // Sites at exactly the contact distance, but for rounding, are not too close.
            if fit.spacing < contact * (1.0 - 1e-12) {
                let kind = SceneErrorKind::LatticeTooTight { count, spacing: fit.spacing, contact };
                return Err(SceneError::new(at.clone(), kind));
            }
        }
        Ok(fit.sites())
    }
}

/// The species of a fill and their shares.
fn shares(fill: &Fill, species: &[Species], at: &ConfigPath) -> Result<Vec<(SpeciesId, f64)>, SceneError> {
    let several = fill.composition.len() != 1;
    let mut shares = Vec::with_capacity(fill.composition.len());
    for (name, share) in &fill.composition {
        let at = if several { at.key("composition").key(name.clone()) } else { at.key("species") };
        let id = species_named(species, name, &at)?;
        if shares.iter().any(|(other, _)| *other == id) {
            let kind = SceneErrorKind::Duplicate { name: name.clone(), first: at.clone() };
            return Err(SceneError::new(at, kind));
        }
        shares.push((id, positive(*share, at)?));
    }
    if shares.is_empty() {
        let why = "a fill needs species or composition".to_owned();
        return Err(SceneError::new(at.clone(), SceneErrorKind::Missing { key: "species", why }));
    }
    Ok(shares)
}

/// Whole numbers in these shares that add up to `count`: rounded down, the rest to the largest remainders.
fn whole_numbers(shares: &[(SpeciesId, f64)], count: usize) -> Vec<(SpeciesId, usize)> {
    let total: f64 = shares.iter().map(|(_, share)| share).sum();
    let exact: Vec<f64> = shares.iter().map(|(_, share)| share / total * count as f64).collect();
    let mut numbers: Vec<usize> = exact.iter().map(|&number| trunc_to_usize(number).min(count)).collect();
    let mut order: Vec<usize> = (0..shares.len()).collect();
    order.sort_by(|&a, &b| exact[b].fract().total_cmp(&exact[a].fract()));
    let mut rest = count.saturating_sub(numbers.iter().sum());
    for &index in order.iter().cycle() {
        if rest == 0 {
            break;
        }
        numbers[index] += 1;
        rest -= 1;
    }
    shares.iter().zip(numbers).map(|((species, _), number)| (*species, number)).collect()
}

/// The shares that whole numbers of particles have, so that the box fits them exactly.
fn realised(shares: Vec<(SpeciesId, f64)>, count: u64) -> Vec<(SpeciesId, f64)> {
    let total: f64 = shares.iter().map(|(_, share)| share).sum();
    let numbers = whole_numbers(&shares, index(count));
    let is_exact = |((_, share), (_, number)): (&(SpeciesId, f64), &(SpeciesId, usize))| {
        // But for rounding, which would change the last digits of the box for nothing.
        (share / total * count as f64 - *number as f64).abs() < 1e-6
    };
    if shares.iter().zip(&numbers).all(is_exact) {
        return shares;
    }
    numbers.into_iter().map(|(species, number)| (species, number as f64)).collect()
}

fn region(fill: &Fill, space: &Space, at: &ConfigPath) -> Result<Region, SceneError> {
    let whole = Region { lower: space.lower, upper: space.upper() };
    let Some(region) = fill.region else { return Ok(whole) };
    let at = at.key("region");
    finite_vector(&region.lower, &at.key("lower"))?;
    finite_vector(&region.upper, &at.key("upper"))?;
    for k in (0..3).filter(|&k| space.boundary[k] != Boundary::Flat) {
        if region.lower[k] >= region.upper[k] {
            let kind = SceneErrorKind::value(region.upper[k], format!("more than the lower end, {}", region.lower[k]));
            return Err(SceneError::new(at.key("upper").index(k), kind));
        }
        let is_bounded = space.boundary[k] != Boundary::OPEN;
        for (key, value) in [("lower", region.lower[k]), ("upper", region.upper[k])] {
            if is_bounded && !(whole.lower[k]..=whole.upper[k]).contains(&value) {
                let expected = format!("{} from {} to {} as the box", AXES[k], whole.lower[k], whole.upper[k]);
                return Err(SceneError::new(at.key(key).index(k), SceneErrorKind::value(value, expected)));
            }
        }
    }
    Ok(region)
}

fn key_of(amount: Amount) -> &'static str {
    match amount {
        Amount::NumberDensity(_) => "number_density",
        Amount::PackingFraction(_) => "packing_fraction",
    }
}

fn volume_per_particle(
    amount: Amount,
    shares: &[(SpeciesId, f64)],
    species: &[Species],
    space: &Space,
    at: &ConfigPath,
) -> Result<f64, SceneError> {
    match amount {
        Amount::NumberDensity(density) => Ok(1.0 / positive(density, at.key("number_density"))?),
        Amount::PackingFraction(fraction) => {
            let at = at.key("packing_fraction");
            positive(fraction, at.clone())?;
            // Equal spheres: pi / (3 sqrt 2); disks: pi / (2 sqrt 3). Mixtures can fill the holes as well.
            let limit = match (space.dimensions(), shares.len()) {
                (3, 1) => PI / (3.0 * std::f64::consts::SQRT_2),
                (2, 1) => PI / 12.0_f64.sqrt(),
                _ => 1.0,
            };
            if fraction > limit {
                return Err(SceneError::new(at, SceneErrorKind::PackingFraction { value: fraction, limit }));
            }
            let total: f64 = shares.iter().map(|(_, share)| share).sum();
            let mean: f64 = shares
                .iter()
                .map(|(id, share)| share / total * own_volume(species[id.0 as usize].diameter, space.dimensions()))
                .sum();
            Ok(mean / fraction)
        }
    }
}

impl SceneBuilder {
    /// The cube, square or line that the one fill with a count and a density needs.
    pub(crate) fn derived_size(&self, species: &[Species], space: &Space) -> Result<Vector, SceneError> {
        let mut deciding = self.groups.iter().filter_map(|placed| match &placed.group {
            Group::Fill(fill @ Fill { count: Some(count), amount: Some(amount), region: None, .. }) => {
                Some((fill, *count, *amount, &placed.at))
            }
            _ => None,
        });
        let (Some((fill, count, amount, at)), None) = (deciding.next(), deciding.next()) else {
            let why = "it follows only if exactly one [[fill]] gives both a count and a density".to_owned();
            let at = ConfigPath::root().key("space");
            return Err(SceneError::new(at, SceneErrorKind::Missing { key: "size", why }));
        };
        affordable(count, at)?;
        let shares = shares(fill, species, at)?;
        let volume = count as f64 * volume_per_particle(amount, &realised(shares, count), species, space, at)?;
        let edge = root(volume, space.dimensions());
        Ok(Vector::from_fn(|k, _| if space.boundary[k] == Boundary::Flat { 0.0 } else { edge }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_become_whole_numbers_that_add_up() {
        let shares = [(SpeciesId(0), 0.5), (SpeciesId(1), 0.25), (SpeciesId(2), 0.25)];
        let numbers = |count| whole_numbers(&shares, count).iter().map(|(_, n)| *n).collect::<Vec<_>>();
        assert_eq!(numbers(8), [4, 2, 2]);
        assert_eq!(numbers(7), [3, 2, 2]);
        assert_eq!(numbers(1), [1, 0, 0]);
    }
}
