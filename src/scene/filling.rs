//! Numbers, species and positions of the particles of a fill.

use crate::Vector;
use crate::base::numbers::{index, trunc_to_u64};
use crate::model::FillRegion;
use crate::model::scene::own_volume;
use crate::model::space::Space;
use crate::model::{Species, SpeciesId};
use crate::prepare::composition::{edges, largest_packing_fraction, mean_volume, realised, whole_numbers};
use crate::prepare::lattice::{self, Sites};
use crate::prepare::packing::occupancy::Kind;
use crate::scene::builder::SceneBuilder;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind, missing, refuse};
use crate::scene::groups::Placing;
use crate::scene::interactions::species_named;
use crate::scene::limits::{affordable, positive};
use crate::scene::region::region;
use crate::scene::unvalidated::{Amount, Arrangement, Fill, Group, Lattice};

/// Maximum number of lattice sites in the bounding box of a region, unless at least a tenth of the sites are used. With
/// this number of sites, a fill takes a few seconds and about a gigabyte of memory.
const MOST_SITES: f64 = 2e7;

/// Relative round-off when the mean of two diameters is compared with a contact distance.
const ROUNDING: f64 = 1e-12;

/// A fill with a known number of particles of each species.
pub(crate) struct Filling {
    shares: Vec<(SpeciesId, usize)>,
    /// The particles, sorted by species and diameter.
    pub kinds: Vec<Kind>,
    pub region: FillRegion,
}

impl Filling {
    pub(crate) fn new(fill: &Fill, placing: &Placing<'_>, at: &ConfigPath) -> Result<Self, SceneError> {
        let count = index(Self::count(fill, placing, at)?);
        let shares = shares(fill, placing.species, at)?;
        let shares = whole_numbers(&shares, count);
        let kinds = kinds(&shares, placing.species, at)?;
        let filling = Self { shares, kinds, region: region(fill, placing.space, at)? };
        let largest = filling.largest(placing.species);
        if !filling.region.has_room(0.5 * largest) {
            let kind = SceneErrorKind::RegionTooSmall { diameter: largest };
            return Err(SceneError::new(at.key("region"), kind));
        }
        Ok(filling)
    }

    /// Number of particles of a fill. With `as_many_as_fit`, it is an upper bound.
    pub(crate) fn count(fill: &Fill, placing: &Placing<'_>, at: &ConfigPath) -> Result<u64, SceneError> {
        let (species, space) = (placing.species, placing.space);
        if fill.as_many_as_fit && fill.arrangement != Arrangement::Random {
            return refuse(
                at.key("as_many_as_fit"),
                true,
                "`arrangement = \"random\"`, or no such key: a lattice always contains all particles of the fill",
            );
        }
        let region = region(fill, space, at)?;
        let shares = shares(fill, species, at)?;
        if fill.as_many_as_fit && shares.iter().any(|(id, _)| species[id.0 as usize].individual.is_some()) {
            return refuse(
                at.key("as_many_as_fit"),
                true,
                "a number of particles: it determines how their individual diameters divide the distribution",
            );
        }
        let count = match (fill.count, fill.amount) {
            (Some(0), _) => return refuse(at.key("count"), 0, "at least 1"),
            (Some(count), _) => count,
            (None, Some(amount)) => {
                let volume = region.volume(space);
                let count = (volume / volume_per_particle((amount, None), &shares, species, space, at)?).round();
                if count < 1.0 {
                    return refuse(
                        at.key(key_of(amount)),
                        format!("too low for one particle in a volume of {volume}"),
                        "more",
                    );
                }
                trunc_to_u64(count)
            }
            (None, None) if fill.as_many_as_fit => most_that_fit(region.volume(space), &shares, placing, at)?,
            (None, None) => {
                return Err(missing(at, "count", "give count, number_density or packing_fraction"));
            }
        };
        affordable(count, at)?;
        Ok(count)
    }

    pub(crate) fn species(&self) -> impl Iterator<Item = SpeciesId> + '_ {
        self.shares.iter().filter(|(_, count)| *count > 0).map(|(species, _)| *species)
    }

    /// Returns positions on a lattice. Rejects sites at less than the contact distance, unless overlaps are allowed.
    pub(crate) fn on_lattice(
        &self,
        lattice: Lattice,
        placing: &Placing<'_>,
        at: &ConfigPath,
    ) -> Result<Vec<Vector>, SceneError> {
        let space = placing.space;
        if lattice.dimensions() != space.dimensions() {
            let expected = match space.dimensions() {
                3 => "`sc`, `bcc`, `fcc`, `hcp` or `random` because no axis is flat",
                2 => "`square`, `hexagonal` or `random` because one axis is flat",
                _ => "`line` or `random` because two axes are flat",
            };
            let value = format!("a lattice of {} dimensions", lattice.dimensions());
            return refuse(at.key("arrangement"), value, expected);
        }
        let count = self.shares.iter().map(|(_, count)| count).sum();
        let contact = (!placing.scene.parts.allow_invalid_start).then(|| self.longest_contact(placing));
        let around = lattice::sites_around(&self.region, space, count);
        if around > MOST_SITES.max(count as f64 * 10.0) {
            let value =
                format!("a lattice in a region that fills only {:.0e} of its bounding box", count as f64 / around);
            return refuse(at.key("arrangement"), value, "`random`");
        }
        let sites = Sites { count, diameter: self.largest(placing.species), contact };
        match &self.region {
            FillRegion::Box(region) => lattice::sites(lattice, space, region, sites),
            region => lattice::sites_inside(lattice, space, region, sites),
        }
        .map_err(|too_tight| SceneError::new(at.clone(), too_tight))
    }

    fn largest(&self, species: &[Species]) -> f64 {
        self.kinds.iter().map(|kind| kind.diameter_among(species)).fold(0.0, f64::max)
    }

    fn longest_contact(&self, placing: &Placing<'_>) -> f64 {
        let mut is_here = vec![false; placing.species.len()];
        self.species().for_each(|kind| is_here[kind.0 as usize] = true);
        let here = placing.contacts.iter().filter(|([a, b], _)| is_here[*a] && is_here[*b]);
        here.map(|(_, contact)| contact).fold(0.0, f64::max)
    }
}

/// Returns the particles of a fill. A distribution of individual diameters is divided among them.
fn kinds(shares: &[(SpeciesId, usize)], species: &[Species], at: &ConfigPath) -> Result<Vec<Kind>, SceneError> {
    let (mut kinds, at) = (Vec::new(), at.key("species"));
    for &(id, count) in shares {
        let Species { name, individual, .. } = &species[id.0 as usize];
        let Some(individual) = individual else {
            kinds.extend(std::iter::repeat_n(Kind::of_species(id), count));
            continue;
        };
        let Some(distribution) = &individual.distribution else {
            let value = format!("`{name}`, which has individual diameters");
            let expected = "a species whose `diameter` is a distribution, which the particles of a fill divide";
            return refuse(at, value, expected);
        };
        for diameter in distribution.divided(count) {
            kinds.push(Kind { species: id, diameter: Some(positive(diameter, at.clone())?) });
        }
    }
    Ok(kinds)
}

fn shares(fill: &Fill, species: &[Species], at: &ConfigPath) -> Result<Vec<(SpeciesId, f64)>, SceneError> {
    shares_of(&fill.composition, species, at, "a fill")
}

/// Replaces the names in a composition by ids. `what` has the composition, for messages.
pub(super) fn shares_of(
    composition: &[(String, f64)],
    species: &[Species],
    at: &ConfigPath,
    what: &str,
) -> Result<Vec<(SpeciesId, f64)>, SceneError> {
    let several = composition.len() != 1;
    let mut shares = Vec::with_capacity(composition.len());
    for (name, share) in composition {
        let at = if several { at.key("composition").key(name.clone()) } else { at.key("species") };
        let id = species_named(species, name, &at)?;
        if shares.iter().any(|(other, _)| *other == id) {
            let kind = SceneErrorKind::Duplicate { name: name.clone(), first: at.clone() };
            return Err(SceneError::new(at, kind));
        }
        shares.push((id, positive(*share, at)?));
    }
    if shares.is_empty() {
        return Err(missing(at, "species", format!("{what} needs species or composition")));
    }
    Ok(shares)
}

/// Upper bound of the number of particles: the volume of the region divided by the mean volume of a core.
fn most_that_fit(
    room: f64,
    shares: &[(SpeciesId, f64)],
    placing: &Placing<'_>,
    at: &ConfigPath,
) -> Result<u64, SceneError> {
    let here = || shares.iter().map(|(id, _)| *id);
    let contact = |a: SpeciesId, b: SpeciesId| placing.contacts.get(a.0 as usize, b.0 as usize);
    let own = |id: SpeciesId| contact(id, id).min(placing.species[id.0 as usize].diameter);
    let is_additive = here().all(|a| here().all(|b| 0.5 * (own(a) + own(b)) <= contact(a, b) * (1.0 + ROUNDING)));
    let least = here().flat_map(|a| here().map(move |b| contact(a, b).min(own(a)))).fold(f64::INFINITY, f64::min);
    let total: f64 = shares.iter().map(|(_, share)| share).sum();
    let volume = |diameter: f64| own_volume(diameter, placing.space.dimensions());
    let mean: f64 =
        shares.iter().map(|(id, share)| share / total * volume(if is_additive { own(*id) } else { least })).sum();
    if mean <= 0.0 {
        return Err(missing(at, "count", "these particles do not exclude each other, so any number of them would fit"));
    }
    Ok(trunc_to_u64(room / mean).saturating_add(1))
}

fn key_of(amount: Amount) -> &'static str {
    match amount {
        Amount::NumberDensity(_) => "number_density",
        Amount::PackingFraction(_) => "packing_fraction",
    }
}

fn volume_per_particle(
    (amount, count): (Amount, Option<u64>),
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
            let individual = shares.iter().filter(|(id, _)| species[id.0 as usize].individual.is_some()).count();
            let limit = largest_packing_fraction(space.dimensions(), shares.len() + individual);
            if fraction > limit {
                return Err(SceneError::new(at, SceneErrorKind::PackingFraction { value: fraction, limit }));
            }
            Ok(mean_volume(shares, count, species, space.dimensions()) / fraction)
        }
    }
}

impl SceneBuilder {
    /// Computes the edges of the box from the only fill with a count and a density. Edges that are not 0 are equal.
    pub(crate) fn derived_size(&self, species: &[Species], space: &Space) -> Result<Vector, SceneError> {
        let mut deciding = self.groups.iter().filter_map(|placed| match &placed.group {
            Group::Fill(fill @ Fill { count: Some(count), amount: Some(amount), region: None, .. }) => {
                Some((fill, *count, *amount, &placed.at))
            }
            _ => None,
        });
        let (Some((fill, count, amount, at)), None) = (deciding.next(), deciding.next()) else {
            let at = ConfigPath::root().key("space");
            let is_file = |at: &ConfigPath| at.to_string().starts_with("file");
            let why = if self.groups.iter().any(|placed| is_file(&placed.at)) {
                "the coordinates of the [[file]] have no box: give the edges of the box"
            } else {
                "give it, or both a count and a density in exactly one [[fill]]"
            };
            return Err(missing(&at, "size", why));
        };
        affordable(count, at)?;
        let shares = shares(fill, species, at)?;
        let volume =
            count as f64 * volume_per_particle((amount, Some(count)), &realised(shares, count), species, space, at)?;
        Ok(edges(volume, space))
    }
}
