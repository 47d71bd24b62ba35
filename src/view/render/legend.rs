//! The scale of an image that is coloured by speed.

use super::colour::{self, Colour};
use super::stroke::Stroke;
use crate::base::numbers::{trunc_to_i32, trunc_to_usize};

/// Height of the strip that the scale takes, relative to the shorter side of the largest image.
pub(super) const STRIP: f32 = 0.085;

/// Share of the sum of squared speeds that may lie beyond the upper end of the scale.
const FASTER: f64 = 0.05;

/// The speed at the upper end of the scale `[length / time]`, in two digits: high enough for the few that fall while all
/// others rest, and low enough that a thermal fluid shows all colours.
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
    // The decimal text, read back, is the round number that is meant.
    format!("{:.1e}", (speed / step).ceil() * step).parse().unwrap_or(speed)
}

/// Draws the scale into the lowest `height` rows: from 0 to `fastest`, with an arrow if there is more beyond.
pub(super) fn draw(pixels: &mut [Colour], width: usize, height: f32, fastest: f64, is_exceeded: bool) {
    let ink = colour::linear(colour::INK);
    let size = 0.25 * height;
    let label = if (1e-3..1e5).contains(&fastest) { format!("{fastest}") } else { format!("{fastest:e}") };
    let bottom = pixels.len() as f32 / width as f32;
    let (middle, half) = (bottom - 0.6 * height, 0.17 * height);
    let length = (4.0 * height).min(0.45 * width as f32);
    let left = 0.5 * (width as f32 - length);
    let arrow = if is_exceeded { half * 1.2 } else { 0.0 };
    let (first, last) = (trunc_to_usize(left), trunc_to_usize(left + length + arrow).min(width));
    for column in first..last {
        let x = column as f32 + 0.5 - left;
        let half = if x > length { half * (1.0 - (x - length) / arrow) } else { half };
        let stroke = Stroke {
            ends: [[column as f32 + 0.5, middle - half], [column as f32 + 0.5, middle + half]],
            width: 1.0,
            colour: colour::viridis(x / length),
            opacity: 1.0,
        };
        let rows = [middle - half, middle + half].map(|y| trunc_to_usize(y.round()).min(trunc_to_usize(bottom)));
        for row in rows[0]..rows[1] {
            pixels[row * width + column] = stroke.colour;
        }
    }
    let gap = 0.5 * size;
    write(pixels, width, "speed 0", [left - gap - text_width("speed 0", size), middle], size, ink);
    write(pixels, width, &label, [left + length + arrow + gap, middle], size, ink);
}

/// Width of a letter and the space after it, relative to its height.
const ADVANCE: f32 = 0.9;

fn text_width(text: &str, size: f32) -> f32 {
    text.chars().count() as f32 * ADVANCE * size - 0.25 * size
}

/// Writes letters of a height; the place is the middle of the left edge.
fn write(pixels: &mut [Colour], width: usize, text: &str, place: [f32; 2], size: f32, ink: Colour) {
    for (index, letter) in text.chars().enumerate() {
        let corner = [place[0] + index as f32 * ADVANCE * size, place[1] - 0.5 * size];
        for path in glyph(letter).split(' ') {
            let points: Vec<[f32; 2]> = path
                .as_bytes()
                .chunks_exact(2)
                .map(|xy| {
                    let unit = |digit: u8| f32::from(digit.saturating_sub(b'0')) * size / 6.0;
                    [corner[0] + unit(xy[0]), corner[1] + unit(xy[1])]
                })
                .collect();
            for ends in points.windows(2) {
                let stroke = Stroke { ends: [ends[0], ends[1]], width: 0.11 * size, colour: ink, opacity: 1.0 };
                stroke.draw(pixels, width, |_, _, _| 1.0);
            }
        }
    }
}

/// Polylines through points `xy`, with `x` from 0 to 4 to the right and `y` from 0 at the top to 6 on the base line.
fn glyph(letter: char) -> &'static str {
    match letter {
        '0' => "103041453616050110",
        '1' => "112026",
        '2' => "01103041420646",
        '3' => "01103041423323 334445361605",
        '4' => "36300444",
        '5' => "40000312324345361605",
        '6' => "413010010516364544331304",
        '7' => "004016",
        '8' => "103041423313020110 3344453616050413",
        '9' => "051636454130100102133342",
        '.' => "2626",
        '-' => "0343",
        'e' => "04444332120305163645",
        's' => "43321203143445361605",
        'p' => "0208 0312324345361605",
        'd' => "4046 4332120305163645",
        _ => "",
    }
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
        // 3 + 3 + ... + 4 squared: the one at 4 is 16 of 916.
        assert_eq!(fastest([vec![3.0; 100], vec![4.0]].concat()), 3.0);
        assert_eq!(fastest([vec![0.01; 100], vec![4.0, 4.5]].concat()), 4.5);
    }
}
