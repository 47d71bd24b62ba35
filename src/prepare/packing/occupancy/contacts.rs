use crate::model::species_pairs::SpeciesPairs;

/// Contact distance of each pair of species `[length]`, or 0 for pairs without a hard core.
#[derive(Debug, Clone)]
pub(crate) struct Contacts(SpeciesPairs<f64>);

impl Contacts {
    pub(crate) fn of(pairs: SpeciesPairs<f64>) -> Self {
        Self(pairs)
    }

    #[cfg(test)]
    pub(crate) fn new(species: usize) -> Self {
        Self(SpeciesPairs::new(species))
    }

    #[cfg(test)]
    pub(crate) fn set(&mut self, a: usize, b: usize, distance: f64) {
        self.0.set(a, b, distance);
    }

    #[inline]
    pub(crate) fn get(&self, a: usize, b: usize) -> f64 {
        self.0.get(a, b).unwrap_or(0.0)
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = ([usize; 2], f64)> + '_ {
        self.0.iter()
    }

    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self(self.0.map(|distance| Some(distance * factor)))
    }

    /// Shortest contact distance that is not 0; infinite without hard cores.
    pub(crate) fn shortest(&self) -> f64 {
        self.iter().map(|(_, distance)| distance).filter(|distance| *distance > 0.0).fold(f64::INFINITY, f64::min)
    }

    pub(crate) fn largest(&self) -> f64 {
        self.iter().map(|(_, distance)| distance).fold(0.0, f64::max)
    }
}
