//! Colour key of a family of curves.

use std::fmt::Write;

use super::{Axis, BOTTOM, TOP, WIDTH, name, px};

/// Number of colours of a family in the style sheet, from dark to light.
const TONES: usize = 16;

/// Right edge of the plot area, and left and right edges of the key `[pixels]`.
pub(super) const RIGHT: f64 = WIDTH - 108.0;
const SCALE: [f64; 2] = [WIDTH - 92.0, WIDTH - 76.0];

#[derive(Debug, Clone, PartialEq)]
pub(in crate::view::report) struct Key {
    pub title: String,
    /// Smallest and largest value of the parameter.
    pub ends: [f64; 2],
    pub is_logarithmic: bool,
}

impl Key {
    fn axis(&self) -> Axis {
        Axis::new(self.ends, self.is_logarithmic).between(BOTTOM, TOP)
    }

    pub fn tone(&self, value: f64) -> usize {
        let tone = (self.axis().fraction(value) * (TONES - 1) as f64).round();
        crate::base::numbers::trunc_to_usize(tone.max(0.0)).min(TONES - 1)
    }

    pub(super) fn draw(&self, svg: &mut String) {
        let ([left, right], axis) = (SCALE, self.axis());
        let height = (BOTTOM - TOP) / TONES as f64;
        for tone in 0..TONES {
            let top = px(BOTTOM - (tone + 1) as f64 * height);
            let (width, height) = (right - left, px(height + 0.3));
            let _ = write!(
                svg,
                "<rect class=\"tone f{tone}\" x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/>"
            );
        }
        for (value, is_labelled) in axis.marks() {
            let (at, text) = (px(axis.place(value)), super::escape(&axis.label(value)));
            let _ = write!(svg, "<path class=\"axis\" d=\"M{right} {at}h4\"/>");
            if is_labelled {
                let _ = write!(svg, "<text x=\"{}\" y=\"{at}\" dy=\".32em\">{text}</text>", right + 7.0);
            }
        }
        name(svg, [WIDTH - 6.0, 0.5 * (TOP + BOTTOM)], &self.title, BOTTOM - TOP, true);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tones_follow_the_colour_scale() {
        let key = |is_logarithmic| Key { title: String::new(), ends: [0.01, 1.0], is_logarithmic };
        assert_eq!([0.01, 0.1, 1.0].map(|value| key(true).tone(value)), [0, 8, TONES - 1]);
        assert_eq!([0.01, 0.1, 1.0].map(|value| key(false).tone(value)), [0, 1, TONES - 1]);
        assert_eq!([-7.0, 7.0].map(|value| key(false).tone(value)), [0, TONES - 1]);
    }
}
