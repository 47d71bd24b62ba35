#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Rectangle {
    pub left: usize,
    pub top: usize,
    pub width: usize,
    pub height: usize,
}

impl Rectangle {
    /// Returns the smallest rectangle with all pixels that differ, or the first pixel.
    fn around_changes<T: PartialEq>(previous: &[T], image: &[T], width: usize) -> Self {
        let rows = || previous.chunks(width).zip(image.chunks(width)).enumerate();
        let (mut left, mut right, mut top, mut bottom) = (width, 0, usize::MAX, 0);
        for (row, (old, new)) in rows().filter(|(_, (old, new))| old != new) {
            let differs = |(old, new): (&T, &T)| old != new;
            left = left.min(old.iter().zip(new).position(differs).unwrap_or(width));
            right = right.max(old.iter().zip(new).rposition(differs).unwrap_or(0));
            top = top.min(row);
            bottom = row;
        }
        if top == usize::MAX {
            return Self { left: 0, top: 0, width: 1, height: 1 };
        }
        Self { left, top, width: right - left + 1, height: bottom - top + 1 }
    }

    /// Returns the changed rectangle and its pixels. Equal pixels are replaced by `unchanged`. Without a previous
    /// image, the rectangle is the whole image.
    pub fn changes<T: PartialEq + Copy>(
        previous: Option<&[T]>,
        image: &[T],
        [width, height]: [usize; 2],
        unchanged: T,
    ) -> (Self, Vec<T>) {
        let Some(previous) = previous else {
            return (Self { left: 0, top: 0, width, height }, image.to_vec());
        };
        let rectangle = Self::around_changes(previous, image, width);
        let pixels = rectangle.pixels(image, width).zip(rectangle.pixels(previous, width));
        (rectangle, pixels.map(|(new, old)| if new == old { unchanged } else { *new }).collect())
    }

    fn pixels<'a, T>(&self, image: &'a [T], width: usize) -> impl Iterator<Item = &'a T> {
        let Self { left, top, width: columns, height } = *self;
        image.chunks(width).skip(top).take(height).flat_map(move |row| &row[left..left + columns])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_in_the_smallest_rectangle() {
        let before = [0; 20];
        let rectangle = |changed: &[usize]| {
            let mut after = before;
            changed.iter().for_each(|place| after[*place] = 1);
            let found = Rectangle::around_changes(&before, &after, 5);
            let within = found.pixels(&after, 5).filter(|pixel| **pixel == 1).count();
            assert_eq!(within, changed.len());
            [found.left, found.top, found.width, found.height]
        };
        assert_eq!(rectangle(&[]), [0, 0, 1, 1]);
        assert_eq!(rectangle(&[0]), [0, 0, 1, 1]);
        assert_eq!(rectangle(&[19]), [4, 3, 1, 1]);
        assert_eq!(rectangle(&[7, 13]), [2, 1, 2, 2]);
        assert_eq!(rectangle(&[4, 15]), [0, 0, 5, 4]);
    }

    #[test]
    fn unchanged_pixels_in_the_rectangle_are_marked() {
        let whole = Rectangle { left: 0, top: 0, width: 3, height: 2 };
        let image = [1, 2, 3, 4, 5, 6];
        assert_eq!(Rectangle::changes(None, &image, [3, 2], 0), (whole, image.to_vec()));
        let corner = Rectangle { left: 1, top: 0, width: 2, height: 2 };
        assert_eq!(Rectangle::changes(Some(&[1, 2, 7, 4, 8, 6]), &image, [3, 2], 0), (corner, vec![0, 3, 5, 0]));
    }
}
