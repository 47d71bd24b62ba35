//! Letters in an image: drawn as strokes, so that no font is needed.

use super::colour::Colour;
use super::stroke::Stroke;

/// A number beside a scale: plain where that is short.
pub(super) fn label(number: f64) -> String {
    if (1e-3..1e5).contains(&number) { format!("{number}") } else { format!("{number:e}") }
}

/// Width of a letter and the space after it, relative to its height.
const ADVANCE: f32 = 0.9;

/// Width of a word in letters of a height.
pub(super) fn text_width(text: &str, size: f32) -> f32 {
    text.chars().count() as f32 * ADVANCE * size - 0.25 * size
}

/// Writes letters of a height; the place is the middle of the left edge.
pub(super) fn write(pixels: &mut [Colour], width: usize, text: &str, place: [f32; 2], size: f32, ink: Colour) {
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
                stroke.draw(pixels, width);
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
        'g' => "4247381807 4332120305163645",
        'h' => "0006 0312324346",
        'i' => "2226 2020",
        'l' => "2026",
        'm' => "0206 03122326 23324346",
        'n' => "0206 0312324346",
        't' => "10152636 0232",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_that_is_written_has_strokes() {
        for letter in "speed time length 0123456789.-e".chars().filter(|letter| *letter != ' ') {
            assert!(glyph(letter).len() >= 4, "{letter}");
            assert!(glyph(letter).bytes().all(|b| b == b' ' || (b'0'..=b'8').contains(&b)), "{letter}");
        }
    }
}
