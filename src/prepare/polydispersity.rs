//! Classes of a distribution of diameters. Each class is a species.

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Class {
    pub diameter: f64,
    pub share: f64,
}

pub(crate) fn mean_diameter(classes: &[Class]) -> f64 {
    classes.iter().map(|class| class.share * class.diameter).sum()
}

/// Mass of a particle of a class. It is proportional to the volume, and equals `mass` at the mean diameter.
pub(crate) fn mass_of(class: &Class, mean_diameter: f64, mass: f64, dimensions: usize) -> f64 {
    mass * libm::pow(class.diameter / mean_diameter, dimensions as f64)
}

/// Returns the order in which classes receive the particles that remain after an equal division. Classes on either side
/// of the middle alternate, so that the mean diameter hardly changes.
pub(crate) fn spread(count: usize) -> impl Iterator<Item = usize> {
    let bits = count.next_power_of_two().trailing_zeros();
    let reversed =
        (0..1_usize << bits).map(move |k| if bits == 0 { 0 } else { k.reverse_bits() >> (usize::BITS - bits) });
    let half = count.div_ceil(2);
    reversed.filter(move |&k| k < half).flat_map(move |k| {
        let mirror = count - 1 - k;
        std::iter::once(k).chain((mirror != k).then_some(mirror))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_classes_are_spread_around_the_middle() {
        let first = |count: usize| spread(count).collect::<Vec<_>>();
        assert_eq!(first(1), [0]);
        assert_eq!(first(2), [0, 1]);
        assert_eq!(first(3), [0, 2, 1]);
        assert_eq!(first(8), [0, 7, 2, 5, 1, 6, 3, 4]);
        for count in 1..=64 {
            let mut all = first(count);
            all.sort_unstable();
            assert_eq!(all, (0..count).collect::<Vec<_>>());
        }
    }
}
