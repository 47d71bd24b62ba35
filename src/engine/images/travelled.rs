use crate::base::numbers::id;
use crate::engine::array::Array;
use serde::{Deserialize, Serialize};

/// Image numbers: how many periods each particle has travelled along the axes. A particle takes three bytes. As soon as
/// one particle needs more, every particle takes twelve bytes. Image numbers wrap at 32 bits.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::engine) enum Travelled {
    Near(Array<[i8; 3]>),
    Far(Array<[i32; 3]>),
}

impl Travelled {
    pub fn new(particles: usize) -> Self {
        Self::Near(vec![[0; 3]; particles].into())
    }

    pub fn len(&self) -> usize {
        match self {
            Self::Near(images) => images.len(),
            Self::Far(images) => images.len(),
        }
    }

    #[inline]
    pub fn of(&self, particle: u32) -> [i32; 3] {
        match self {
            Self::Near(images) => images[particle as usize].map(i32::from),
            Self::Far(images) => images[particle as usize],
        }
    }

    /// Whether the next period of a particle may need a larger format.
    #[inline]
    pub fn is_full(&self, particle: u32) -> bool {
        let is_extreme = |number: &i8| *number == i8::MIN || *number == i8::MAX;
        matches!(self, Self::Near(images) if images[particle as usize].iter().any(is_extreme))
    }

    /// See [`Array::become_alias`].
    pub fn become_alias(&mut self) {
        match self {
            Self::Near(images) => images.become_alias(),
            Self::Far(images) => images.become_alias(),
        }
    }

    #[inline]
    pub fn add(&mut self, particle: u32, axis: usize, periods: i32) {
        if let Self::Near(images) = self {
            let image = &mut images[particle as usize][axis];
            if let Ok(sum) = i8::try_from(i32::from(*image).wrapping_add(periods)) {
                *image = sum;
                return;
            }
            *self = Self::extended(images);
        }
        if let Self::Far(images) = self {
            let image = &mut images[particle as usize][axis];
            *image = image.wrapping_add(periods);
        }
    }

    pub fn set(&mut self, image: impl Fn(u32) -> [i32; 3]) {
        *self = match self {
            Self::Near(images) => Self::new(images.len()),
            Self::Far(images) => Self::new(images.len()),
        };
        for particle in (0..).take(self.count()) {
            let image = image(particle);
            (0..3).filter(|&axis| image[axis] != 0).for_each(|axis| self.add(particle, axis, image[axis]));
        }
    }

    pub fn push(&mut self, images: [i32; 3]) {
        match self {
            Self::Near(near) => near.push([0; 3]),
            Self::Far(far) => far.push([0; 3]),
        }
        let particle = id(self.count() - 1);
        (0..3).filter(|&axis| images[axis] != 0).for_each(|axis| self.add(particle, axis, images[axis]));
    }

    pub fn put(&mut self, particle: u32, images: [i32; 3]) {
        let before = self.of(particle);
        (0..3).filter(|&axis| images[axis] != before[axis]).for_each(|axis| {
            self.add(particle, axis, images[axis].wrapping_sub(before[axis]));
        });
    }

    fn count(&self) -> usize {
        match self {
            Self::Near(images) => images.len(),
            Self::Far(images) => images.len(),
        }
    }

    /// Returns all image numbers in the larger format.
    #[cold]
    fn extended(images: &[[i8; 3]]) -> Self {
        Self::Far(images.iter().map(|image| image.map(i32::from)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::columns::{Column, Order};

    #[test]
    fn image_counts_extend_beyond_one_byte() {
        let mut images = Travelled::new(3);
        for _ in 0..127 {
            images.add(1, 0, 1);
            images.add(2, 2, -1);
        }
        images.add(2, 2, -1);
        assert!(matches!(images, Travelled::Near(_)));
        assert_eq!([0, 1, 2].map(|particle| images.of(particle)), [[0; 3], [127, 0, 0], [0, 0, -128]]);
        images.add(1, 0, 1);
        images.add(0, 1, 100_000);
        let far = [[0, 100_000, 0], [128, 0, 0], [0, 0, -128]];
        assert_eq!([0, 1, 2].map(|particle| images.of(particle)), far);
        images = images.permuted(&Order::of(vec![2, 0, 1], 3));
        assert_eq!([0, 1, 2].map(|particle| images.of(particle)), [far[2], far[0], far[1]]);
        images.set(|particle| [i32::MAX, -1, 0].map(|periods| if particle == 1 { periods } else { 0 }));
        images.add(1, 0, 1);
        assert_eq!([0, 1, 2].map(|particle| images.of(particle)), [[0; 3], [i32::MIN, -1, 0], [0; 3]]);
    }
}
