//! Text in an image.
//!
//! The font is a part of Inter, under the SIL Open Font License: `letters/OFL.txt`. All digits have the same width, so
//! that changing numbers do not shift.

use std::sync::LazyLock;

use ttf_parser::{Face, OutlineBuilder};

use super::colour::Colour;
use crate::base::numbers::trunc_to_usize;

static FONT: &[u8] = include_bytes!("letters/letters.ttf");

/// Outlines of all letters; empty if the font is damaged.
static LETTERS: LazyLock<Vec<Letter>> = LazyLock::new(|| letters(FONT));

/// Line segments per curve of an outline, and scan lines per row of pixels.
const PIECES: u32 = 6;
const SAMPLES: usize = 5;

/// First character and number of characters of the font.
const FIRST: char = ' ';
const COUNT: u32 = 95;

/// Outline of a letter, in units of the height of capitals.
#[derive(Debug, Default)]
struct Letter {
    advance: f32,
    /// Line segments of the outline. `y` points up from the base line.
    lines: Vec<[[f32; 2]; 2]>,
}

pub(super) fn label(number: f64) -> String {
    if number == 0.0 || (1e-3..1e5).contains(&number) { format!("{number}") } else { format!("{number:e}") }
}

/// Whether the font has all letters of a text.
pub(super) fn can_write(text: &str) -> bool {
    text.chars().all(|letter| of(letter).is_some())
}

/// Returns the width of a text with capitals of the height `size`.
pub(super) fn text_width(text: &str, size: f32) -> f32 {
    text.chars().map(|letter| of(letter).map_or(0.0, |letter| letter.advance * size)).sum()
}

/// Writes a text with capitals of the height `size`. `place` is the middle of the left edge.
pub(super) fn write(pixels: &mut [Colour], width: usize, text: &str, place: [f32; 2], size: f32, ink: Colour) {
    let (mut x, base) = (place[0], place[1] + 0.5 * size);
    for letter in text.chars().filter_map(of) {
        let pixel = |[across, up]: [f32; 2]| [x + across * size, base - up * size];
        let lines: Vec<_> = letter.lines.iter().map(|ends| ends.map(pixel)).collect();
        fill(pixels, width, &lines, ink);
        x += letter.advance * size;
    }
}

fn of(letter: char) -> Option<&'static Letter> {
    let letter = if letter == '\u{2212}' { '-' } else { letter };
    LETTERS.get(u32::from(letter).checked_sub(u32::from(FIRST))? as usize)
}

/// Fills closed outlines by the nonzero winding rule.
fn fill(pixels: &mut [Colour], width: usize, lines: &[[[f32; 2]; 2]], ink: Colour) {
    let range = |axis: usize| {
        let ends = || lines.iter().flatten().map(|end| end[axis]);
        let (low, high) = (ends().fold(f32::MAX, f32::min), ends().fold(f32::MIN, f32::max));
        [trunc_to_usize(low), trunc_to_usize(high + 1.0)]
    };
    if lines.is_empty() || width == 0 || !lines.iter().flatten().flatten().all(|x| x.is_finite()) {
        return;
    }
    let ([left, right], [top, bottom]) = (range(0), range(1));
    let mut coverage = vec![0.0_f32; right.min(width).saturating_sub(left)];
    for row in top..bottom.min(pixels.len() / width) {
        coverage.fill(0.0);
        for sample in 0..SAMPLES {
            let y = row as f32 + (sample as f32 + 0.5) / SAMPLES as f32;
            for [from, to] in spans(lines, y) {
                for (column, coverage) in (left..).zip(&mut coverage) {
                    let (start, end) = (from.max(column as f32), to.min((column + 1) as f32));
                    *coverage += (end - start).max(0.0) / SAMPLES as f32;
                }
            }
        }
        for (pixel, coverage) in pixels[row * width..].iter_mut().skip(left).zip(&coverage) {
            *pixel = *pixel * (1.0 - coverage) + ink * *coverage;
        }
    }
}

/// Returns the parts of the line at height `y` that are inside the outlines.
fn spans(lines: &[[[f32; 2]; 2]], y: f32) -> Vec<[f32; 2]> {
    let mut crossings: Vec<(f32, i32)> = Vec::new();
    for [a, b] in lines {
        if (a[1] <= y) != (b[1] <= y) {
            let x = a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1]));
            crossings.push((x, if a[1] <= y { 1 } else { -1 }));
        }
    }
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut sum, mut spans) = (0, Vec::new());
    for pair in crossings.windows(2) {
        sum += pair[0].1;
        if sum != 0 {
            spans.push([pair[0].0, pair[1].0]);
        }
    }
    spans
}

fn letters(font: &[u8]) -> Vec<Letter> {
    let Ok(face) = Face::parse(font, 0) else { return Vec::new() };
    let glyph = |letter: char| face.glyph_index(letter);
    // The font does not state the height of capitals, so the letter H is measured.
    let capital =
        glyph('H').and_then(|glyph| face.glyph_bounding_box(glyph)).map_or(1.0, |bounds| f32::from(bounds.y_max));
    let letter = |code: u32| {
        let mut outline = Outline { scale: capital.recip(), ..Outline::default() };
        let Some(glyph) = char::from_u32(code).and_then(glyph) else { return Letter::default() };
        face.outline_glyph(glyph, &mut outline);
        let advance = face.glyph_hor_advance(glyph).map_or(0.0, f32::from) * outline.scale;
        Letter { advance, lines: outline.lines }
    };
    (u32::from(FIRST)..u32::from(FIRST) + COUNT).map(letter).collect()
}

#[derive(Debug, Default)]
struct Outline {
    scale: f32,
    first: [f32; 2],
    last: [f32; 2],
    lines: Vec<[[f32; 2]; 2]>,
}

impl Outline {
    fn add(&mut self, to: [f32; 2]) {
        self.lines.push([self.last, to]);
        self.last = to;
    }

    /// Approximates a curve by line segments. The parameter of `curve` runs from 0 to 1.
    fn follow(&mut self, curve: impl Fn(f32) -> [f32; 2]) {
        (1..=PIECES).for_each(|piece| self.add(curve(piece as f32 / PIECES as f32)));
    }
}

impl OutlineBuilder for Outline {
    fn move_to(&mut self, x: f32, y: f32) {
        self.last = [x, y].map(|x| x * self.scale);
        self.first = self.last;
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.add([x, y].map(|x| x * self.scale));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (a, [b, c]) = (self.last, [[x1, y1], [x, y]].map(|point| point.map(|x| x * self.scale)));
        self.follow(|t| [0, 1].map(|k| (1.0 - t) * ((1.0 - t) * a[k] + 2.0 * t * b[k]) + t * t * c[k]));
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let a = self.last;
        let [b, c, d] = [[x1, y1], [x2, y2], [x, y]].map(|point| point.map(|x| x * self.scale));
        self.follow(|t| {
            let s = 1.0 - t;
            [0, 1].map(|k| s * s * (s * a[k] + 3.0 * t * b[k]) + t * t * (3.0 * s * c[k] + t * d[k]))
        });
    }

    fn close(&mut self) {
        self.add(self.first);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_has_an_outline_and_digits_have_equal_width() {
        for code in u32::from(FIRST) + 1..u32::from(FIRST) + COUNT {
            let letter = of(char::from_u32(code).unwrap()).unwrap();
            assert!(letter.lines.len() >= 4 && letter.advance > 0.1, "{code}");
        }
        let figures: Vec<f32> = ('0'..='9').map(|figure| of(figure).unwrap().advance).collect();
        assert!(figures.iter().all(|width| *width == figures[0]));
        assert!(of(' ').unwrap().lines.is_empty() && of(' ').unwrap().advance > 0.1);
        assert_eq!(text_width("11.5", 10.0), text_width("80.0", 10.0));
        assert!(of('\u{3b1}').is_none() && letters(&FONT[..200]).is_empty());
    }

    #[test]
    fn letters_are_filled_and_their_holes_are_not() {
        let written = |text: &str, size: f32| {
            let mut pixels = vec![Colour::zeros(); 60 * 60];
            write(&mut pixels, 60, text, [10.0, 30.0], size, Colour::repeat(1.0));
            pixels
        };
        let ink = |pixels: &[Colour]| pixels.iter().map(|pixel| pixel.x).sum::<f32>();
        let bar = ink(&written("I", 30.0));
        assert!((60.0..300.0).contains(&bar), "{bar}");
        let ring = written("O", 30.0);
        let place = trunc_to_usize(10.0 + 0.5 * text_width("O", 30.0));
        assert_eq!(ring[30 * 60 + place].x, 0.0);
        assert!(ring[16 * 60 + place].x > 0.9 && ring[44 * 60 + place].x > 0.9);
        assert_eq!(ink(&written("mmmm", 1e9)), 0.0);
    }

    #[test]
    fn labels_are_short() {
        assert_eq!([0.0, 1.5, 1e-3, 1e-4, 2e5].map(label), ["0", "1.5", "0.001", "1e-4", "2e5"]);
    }
}
