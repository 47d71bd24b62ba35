//! Numbers of particles in the regions of a scene.

use serde::{Deserialize, Serialize};
use std::sync::OnceLock;

use crate::Vector;
use crate::mesh::report::Inside;
use crate::model::{CountRegion, CountSpace};

// Search structures are built on first use and are not saved.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub(super) struct Regions {
    regions: Vec<CountRegion>,
    #[serde(skip)]
    searches: OnceLock<Vec<Option<Inside<'static>>>>,
}

impl Clone for Regions {
    fn clone(&self) -> Self {
        Self::of(self.regions.clone())
    }
}

impl PartialEq for Regions {
    fn eq(&self, other: &Self) -> bool {
        self.regions == other.regions
    }
}

impl Regions {
    pub fn of(regions: Vec<CountRegion>) -> Self {
        Self { regions, searches: OnceLock::new() }
    }

    pub fn is_empty(&self) -> bool {
        self.regions.is_empty()
    }

    pub fn count<'p>(&self, points: impl Iterator<Item = &'p Vector> + Clone) -> Vec<usize> {
        let search = |region: &CountRegion| match &region.space {
            CountSpace::Box(_) => None,
            CountSpace::Mesh(mesh) => Some(Inside::of_own(mesh.clone())),
        };
        let searches = self.searches.get_or_init(|| self.regions.iter().map(search).collect());
        let inside = |(region, search): (&CountRegion, &Option<Inside<'static>>)| {
            let is_in = |point: &&Vector| match (&region.space, search) {
                (CountSpace::Box(region), _) => region.contains(point),
                (_, Some(search)) => search.contains(point),
                _ => false,
            };
            points.clone().filter(is_in).count()
        };
        self.regions.iter().zip(searches).map(inside).collect()
    }
}
