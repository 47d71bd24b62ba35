//! Caption of an image of a movie: simulated time and scale bar.

use super::Style;
use super::camera::Camera;
use super::colour::{self, Colour};
use super::legend::STRIP;
use super::letters::{label, text_width, write};
use super::stroke::Stroke;
use crate::base::numbers::{single, trunc_to_i32};

const LEAST_ROW: f32 = 32.0;

const LARGEST_ROW: f32 = 0.2;

/// Largest width of the scale bar, relative to the image.
const LONGEST_BAR: f64 = 0.16;

#[derive(Debug, Clone)]
pub(super) struct Caption {
    pub height: f32,
    pub row: f32,
    /// Length of the scale bar, and its width in pixels.
    bar: Option<(f64, f32)>,
}

impl Caption {
    pub fn of(style: &Style) -> Self {
        let row = (STRIP * style.width.min(style.height) as f32).max(LEAST_ROW).min(LARGEST_ROW * style.height as f32);
        let rows = if style.colour_by.has_scale() { 2.0 } else { 1.0 };
        Self { height: rows * row, row, bar: None }
    }

    /// Chooses the scale bar. In perspective, its length is correct in the middle of the scene.
    pub fn measure(&mut self, camera: &Camera) {
        let scale = camera.pixels_per_length();
        let length = round_length(LONGEST_BAR * f64::from(camera.width) / scale);
        self.bar = length.map(|length| (length, single(length * scale)));
    }

    pub fn draw(&self, pixels: &mut [Colour], width: usize, style: &Style, time: &str) {
        let ink = colour::linear(colour::INK);
        let bottom = pixels.len() as f32 / width as f32;
        // In a single row at the border of the image, the text is slightly higher than the middle.
        let middle = bottom - self.height + (if self.height > self.row { 0.5 } else { 0.4 }) * self.row;
        let (size, rim) = (0.25 * self.row, 0.5 * self.row);
        let time = style.with_unit(format!("time {time}"), "time", 3);
        write(pixels, width, &time, [rim, middle], size, ink);
        let Some((length, bar)) = self.bar else { return };
        let right = width as f32 - rim;
        let text = style.with_unit(format!("length {}", label(length)), "length", 3);
        let place = [right - bar - 0.6 * size - text_width(&text, size), middle];
        write(pixels, width, &text, place, size, ink);
        let line = |ends| Stroke { ends, width: (0.12 * size).max(1.0), colour: ink, opacity: 1.0 };
        let (left, high, low) = (right - bar, middle - 0.4 * size, middle + 0.4 * size);
        for ends in [[[left, middle], [right, middle]], [[left, high], [left, low]], [[right, high], [right, low]]] {
            line(ends).draw(pixels, width);
        }
    }
}

/// Returns the largest length up to `most` that is 1, 2 or 5 times a power of ten.
fn round_length(most: f64) -> Option<f64> {
    if !(most.is_normal() && (1e-300..1e300).contains(&most)) {
        return None;
    }
    let power = trunc_to_i32(most.log10().floor());
    // Parsing gives the nearest number. Neighbouring powers are tried, because the logarithm is rounded.
    let candidates = (power - 1..=power + 1).flat_map(|power| [1, 2, 5].map(|digit| format!("{digit}e{power}")));
    candidates.filter_map(|text| text.parse().ok()).rfind(|length| *length <= most)
}

#[cfg(test)]
mod tests {
    use super::round_length;

    #[test]
    fn bars_have_the_largest_round_length_that_fits() {
        let of = |most: f64| round_length(most).unwrap();
        assert_eq!([9.99, 10.0, 19.9, 20.0, 0.3, 0.05, 7e8].map(of), [5.0, 10.0, 10.0, 20.0, 0.2, 0.05, 5e8]);
        for power in -299..299 {
            let exact: f64 = format!("1e{power}").parse().unwrap();
            assert_eq!(of(exact), exact);
            assert!(of(exact.next_down()) < exact);
        }
        assert_eq!([0.0, f64::NAN, f64::INFINITY, -1.0].map(round_length), [None; 4]);
    }
}
