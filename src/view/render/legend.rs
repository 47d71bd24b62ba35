use super::colour::{self, Colour};
use super::letters::{label, text_width, write};
use super::{ColourBy, Scale, Style};
use crate::base::numbers::{trunc_to_i32, trunc_to_usize};

/// Height of the scale or of a caption row, relative to the shorter side of the image before cropping.
pub(super) const STRIP: f32 = 0.085;

/// Fraction of the sum of squares that may lie above the scale.
const ABOVE: f64 = 0.05;

/// Returns the upper end of the scale for positive numbers, with two significant digits.
pub(crate) fn top(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    let highest = numbers.last().copied().unwrap_or(0.0);
    if !(highest.is_normal() && highest < 1e300) {
        return 1.0;
    }
    let square = |number: f64| (number / highest).powi(2);
    let mut rest = ABOVE * numbers.iter().copied().map(square).sum::<f64>();
    let is_lower = |number: &f64| {
        rest -= square(*number);
        rest <= 0.0
    };
    let number = numbers.iter().rev().copied().find(is_lower).unwrap_or(highest);
    let step = 10_f64.powi(trunc_to_i32(number.log10().floor()) - 1);
    // Parsing removes the round-off of the multiplication.
    format!("{:.1e}", (number / step).ceil() * step).parse().unwrap_or(number)
}

/// Draws the scale into the lowest `height` rows, unless colours show the species. An arrow marks higher numbers.
pub(super) fn draw(pixels: &mut [Colour], width: usize, height: f32, style: &Style, scale: &Scale) {
    let (name, unit) = match style.colour_by {
        ColourBy::Species => return,
        ColourBy::Speed => ("speed 0", "length / time"),
        ColourBy::Pressure => ("pressure 0", "energy / length^D"),
    };
    let (top, is_exceeded) = (scale.top, scale.is_exceeded());
    let ink = colour::linear(colour::INK);
    let label = style.with_unit(label(top), unit, scale.dimensions);
    let bottom = pixels.len() as f32 / width as f32;
    let middle = bottom - 0.6 * height;
    // Sizes relative to the height. In a narrow image, all of them shrink.
    let (size, gap, half) = (0.25, 0.125, 0.17);
    let length = (0.45 * width as f32 / height).min(4.0);
    let arrow = if is_exceeded { half * 1.2 } else { 0.0 };
    let reach = 0.5 * length + gap + text_width(name, size).max(arrow + text_width(&label, size));
    let unit = height.min(0.49 * width as f32 / reach);
    let [size, gap, half, length, arrow] = [size, gap, half, length, arrow].map(|part| part * unit);
    let left = 0.5 * (width as f32 - length);
    let (first, last) = (trunc_to_usize(left), trunc_to_usize(left + length + arrow).min(width));
    for column in first..last {
        let x = column as f32 + 0.5 - left;
        let half = if x > length { half * (1.0 - (x - length) / arrow) } else { half };
        let colour = colour::viridis(x / length);
        let rows = [middle - half, middle + half].map(|y| trunc_to_usize(y.round()).min(trunc_to_usize(bottom)));
        for row in rows[0]..rows[1] {
            pixels[row * width + column] = colour;
        }
    }
    write(pixels, width, name, [left - gap - text_width(name, size), middle], size, ink);
    write(pixels, width, &label, [left + length + arrow + gap, middle], size, ink);
}

#[cfg(test)]
mod tests {
    use super::top;

    #[test]
    fn scale_ends_at_a_round_speed_that_few_exceed() {
        assert_eq!(
            [vec![], vec![0.0; 3], vec![f64::MAX], vec![0.314_15], vec![1e-9]].map(top),
            [1.0, 1.0, 1.0, 0.32, 1e-9]
        );
        // The particle with speed 4 contributes less than 5 % to the sum of squared speeds.
        assert_eq!(top([vec![3.0; 100], vec![4.0]].concat()), 3.0);
        assert_eq!(top([vec![0.01; 100], vec![4.0, 4.5]].concat()), 4.5);
    }
}
