use super::colour::{self, Colour};
use super::letters::{label, text_width, write};
use crate::base::numbers::{trunc_to_i32, trunc_to_usize};

/// Height of the scale or of a caption row, relative to the shorter side of the image before cropping.
pub(super) const STRIP: f32 = 0.085;

/// Fraction of the sum of squared speeds that may lie above the scale.
const FASTER: f64 = 0.05;

/// Returns the upper end of the scale, with two significant digits `[length / time]`.
pub(crate) fn fastest(mut speeds: Vec<f64>) -> f64 {
    speeds.sort_by(f64::total_cmp);
    let highest = speeds.last().copied().unwrap_or(0.0);
    if !(highest.is_normal() && highest < 1e300) {
        return 1.0;
    }
    let square = |speed: f64| (speed / highest).powi(2);
    let mut rest = FASTER * speeds.iter().copied().map(square).sum::<f64>();
    let is_slower = |speed: &f64| {
        rest -= square(*speed);
        rest <= 0.0
    };
    let speed = speeds.iter().rev().copied().find(is_slower).unwrap_or(highest);
    let step = 10_f64.powi(trunc_to_i32(speed.log10().floor()) - 1);
    // Parsing removes the round-off of the multiplication.
    format!("{:.1e}", (speed / step).ceil() * step).parse().unwrap_or(speed)
}

/// Draws the scale into the lowest `height` rows. An arrow marks higher speeds.
pub(super) fn draw(pixels: &mut [Colour], width: usize, height: f32, fastest: f64, is_exceeded: bool) {
    let ink = colour::linear(colour::INK);
    let size = 0.25 * height;
    let label = label(fastest);
    let bottom = pixels.len() as f32 / width as f32;
    let (middle, half) = (bottom - 0.6 * height, 0.17 * height);
    let length = (4.0 * height).min(0.45 * width as f32);
    let left = 0.5 * (width as f32 - length);
    let arrow = if is_exceeded { half * 1.2 } else { 0.0 };
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
    let gap = 0.5 * size;
    write(pixels, width, "speed 0", [left - gap - text_width("speed 0", size), middle], size, ink);
    write(pixels, width, &label, [left + length + arrow + gap, middle], size, ink);
}

#[cfg(test)]
mod tests {
    use super::fastest;

    #[test]
    fn scale_ends_at_a_round_speed_that_few_exceed() {
        assert_eq!(
            [vec![], vec![0.0; 3], vec![f64::MAX], vec![0.314_15], vec![1e-9]].map(fastest),
            [1.0, 1.0, 1.0, 0.32, 1e-9]
        );
        // The particle with speed 4 contributes less than 5 % to the sum of squared speeds.
        assert_eq!(fastest([vec![3.0; 100], vec![4.0]].concat()), 3.0);
        assert_eq!(fastest([vec![0.01; 100], vec![4.0, 4.5]].concat()), 4.5);
    }
}
