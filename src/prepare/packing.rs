//! Random packings: sequential insertion, and compression of small spheres if insertion finds no room.

pub(crate) mod compression;
pub(crate) mod insertion;
pub(crate) mod occupancy;

use self::compression::Compression;
use self::insertion::{insert, no_room};
use self::occupancy::{Contacts, Kind, Occupancy};
use crate::Vector;
use crate::model::FillRegion;
use crate::model::random::{Purpose, Random};
use crate::model::scene::own_volume;
use crate::model::{Space, Species};
use crate::prepare::NoPlace;

pub(crate) struct RandomFill<'a> {
    pub kinds: &'a [Kind],
    pub species: &'a [Species],
    pub contacts: &'a Contacts,
    pub space: &'a Space,
    pub region: FillRegion,
    /// Whether to insert as many particles as fit. If not, all particles must fit.
    pub as_many_as_fit: bool,
    /// Whether the region is the whole box, without other particles and surfaces.
    pub has_box: bool,
    pub seed: u64,
    /// Index of the group of particles, which selects the random numbers.
    pub group: usize,
}

impl RandomFill<'_> {
    /// Places particles one by one. If this fails or is hopeless, small spheres are inserted and grow to full size, see
    /// [`Self::compression`]. With `as_many_as_fit`, there is no compression, and some particles may have no position.
    pub(crate) fn positions(&self, occupancy: &mut Occupancy<'_>) -> Result<Vec<Vector>, NoPlace> {
        let dense = if self.as_many_as_fit { None } else { self.compression() };
        if let Some(dense) = &dense
            && dense.is_too_dense_to_insert()
        {
            return dense.positions();
        }
        let mut random = Random::new(self.seed, Purpose::Placement, self.group);
        let positions = insert(self.sizes(), &self.region, occupancy, &mut random);
        let (placed, count) = (positions.len(), self.kinds.len());
        match dense {
            _ if placed == count || (self.as_many_as_fit && placed > 0) => Ok(positions),
            Some(dense) => dense.positions(),
            None => Err(no_room(placed, count)),
        }
    }

    fn sizes(&self) -> impl ExactSizeIterator<Item = (f64, Kind)> {
        self.kinds.iter().map(|kind| (0.5 * self.diameter(kind), *kind))
    }

    fn diameter(&self, kind: &Kind) -> f64 {
        kind.diameter_among(self.species)
    }

    /// Returns `None` unless the box is periodic and contains only these particles, all of them moving.
    fn compression(&self) -> Option<Compression<'_>> {
        let is_moving = self.kinds.iter().all(|kind| !self.species[kind.index()].is_static());
        (self.has_box && self.space.is_fully_periodic() && is_moving).then(|| {
            let volumes = self.kinds.iter().map(|kind| own_volume(self.diameter(kind), self.space.dimensions()));
            let packing_fraction = volumes.sum::<f64>() / self.space.volume();
            Compression { fill: self, packing_fraction }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Particle, Region, SpeciesId};
    use crate::prepare::packing::occupancy::first_overlap;

    fn fill(count: usize, packing_fraction: f64, has_box: bool) -> Result<Vec<Vector>, NoPlace> {
        let species = [Species::new("A", 1.0, 1.0)];
        let kinds = vec![Kind::of_species(SpeciesId(0)); count];
        let space = Space::periodic_cube(libm::cbrt(count as f64 * own_volume(1.0, 3) / packing_fraction));
        let mut contacts = Contacts::new(1);
        contacts.set(0, 0, 1.0);
        let fill = RandomFill {
            kinds: &kinds,
            species: &species,
            contacts: &contacts,
            space: &space,
            region: FillRegion::Box(Region { lower: space.lower, upper: space.upper() }),
            as_many_as_fit: false,
            has_box,
            seed: 3,
            group: 0,
        };
        let positions = fill.positions(&mut Occupancy::new(&space, &contacts, count))?;
        let particle = |&position| Particle::new(SpeciesId(0), position, Vector::zeros());
        let particles: Vec<Particle> = positions.iter().map(particle).collect();
        assert_eq!(particles.len(), count);
        assert!(particles.iter().all(|particle| space.wrapped(particle.position) == particle.position));
        assert_eq!(first_overlap(&particles, &contacts, &space, 0.0, |_, _| false), None);
        Ok(positions)
    }

    #[test]
    fn fill_too_dense_for_insertion_is_compressed_if_it_has_the_whole_box() {
        assert!(fill(60, 0.2, false).is_ok());
        assert!(fill(60, 0.5, true).is_ok());
        let error = fill(60, 0.5, false).unwrap_err();
        assert!(matches!(error, NoPlace::NoRoom { placed: 30..60, count: 60, .. }), "{error:?}");
    }

    #[test]
    fn impossible_packing_reports_the_reason() {
        assert!(matches!(fill(60, 0.7, true), Err(NoPlace::Jammed { reached: 0.6..0.7, .. })));
        assert!(matches!(fill(3, 0.5, true), Err(NoPlace::SmallBox { axis: 0, range: 1.0, .. })));
    }
}
