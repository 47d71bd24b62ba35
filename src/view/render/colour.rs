//! Colours. They are linear for mixing, and sRGB in files.

use std::sync::LazyLock;

use crate::base::numbers::{trunc_to_u8, trunc_to_usize};
use nalgebra::Vector3;

/// Red, green and blue in linear light, 0 to 1.
pub(super) type Colour = Vector3<f32>;

/// Palette of Okabe and Ito, for colour-blind eyes (<https://jfly.uni-koeln.de/color/>).
pub(super) const PALETTE: [[u8; 3]; 8] = [
    [86, 180, 233],
    [230, 159, 0],
    [0, 158, 115],
    [213, 94, 0],
    [0, 114, 178],
    [204, 121, 167],
    [240, 228, 66],
    [120, 120, 120],
];

pub(super) const STATIC: [u8; 3] = [144, 153, 168];

pub(super) const SURFACE: [u8; 3] = [156, 174, 198];

pub(in crate::view) const BACKGROUND: [u8; 3] = [247, 248, 250];

pub(in crate::view) const INK: [u8; 3] = [70, 76, 86];

/// The colour map viridis (Smith and van der Walt, matplotlib) at even intervals.
const VIRIDIS: [[u8; 3]; 11] = [
    [68, 1, 84],
    [72, 36, 117],
    [65, 68, 135],
    [53, 95, 141],
    [42, 120, 142],
    [33, 145, 140],
    [34, 168, 132],
    [68, 191, 112],
    [122, 209, 81],
    [189, 223, 38],
    [253, 231, 37],
];

/// Returns the colour for a value from 0 to 1.
pub(super) fn viridis(value: f32) -> Colour {
    let place = value.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f32;
    let index = trunc_to_usize(place).min(VIRIDIS.len() - 2);
    let fraction = place - index as f32;
    let mix = |k: usize| f32::from(VIRIDIS[index][k]) * (1.0 - fraction) + f32::from(VIRIDIS[index + 1][k]) * fraction;
    Colour::from_fn(|k, _| to_linear(mix(k) / 255.0))
}

pub(super) fn linear(colour: [u8; 3]) -> Colour {
    Colour::from(colour.map(|byte| to_linear(f32::from(byte) / 255.0)))
}

/// Converts linear light to an opaque sRGB pixel.
pub(super) fn encode(colour: &Colour) -> [u8; 4] {
    let steps = &*STEPS;
    let byte = |x: f32| steps.byte(x.clamp(0.0, 1.0));
    [byte(colour.x), byte(colour.y), byte(colour.z), 255]
}

/// Lookup table from linear light to sRGB bytes, which saves much time. `least` contains the smallest intensity of each
/// byte value, and `begins` the byte value at the start of each step of intensity.
struct Steps {
    least: [f32; 256],
    begins: Vec<u8>,
}

static STEPS: LazyLock<Steps> = LazyLock::new(|| {
    let least = std::array::from_fn(|byte| if byte == 0 { 0.0 } else { to_linear((byte as f32 - 0.5) / 255.0) });
    let begin = |step: usize| {
        let light = step as f32 / STEP_COUNT as f32;
        trunc_to_u8(least.iter().skip(1).take_while(|least| **least <= light).count() as f32)
    };
    Steps { least, begins: (0..=STEP_COUNT).map(begin).collect() }
});

/// Number of equal steps of intensity. Only a few byte values begin in each step.
const STEP_COUNT: usize = 2048;

impl Steps {
    fn byte(&self, light: f32) -> u8 {
        let mut byte = self.begins.get(trunc_to_usize(light * STEP_COUNT as f32)).copied().unwrap_or(0);
        while self.least.get(usize::from(byte) + 1).is_some_and(|least| *least <= light) {
            byte += 1;
        }
        byte
    }
}

/// Converts sRGB to linear light (IEC 61966-2-1).
fn to_linear(x: f32) -> f32 {
    if x <= 0.04045 { x / 12.92 } else { libm::powf((x + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_survives_linear_light() {
        for byte in 0..=255 {
            assert_eq!(encode(&linear([byte, 0, 255])), [byte, 0, 255, 255]);
        }
    }

    #[test]
    fn viridis_matches_its_table_and_increases_in_luminance() {
        assert_eq!(encode(&viridis(0.0))[..3], VIRIDIS[0]);
        assert_eq!(encode(&viridis(0.3))[..3], VIRIDIS[3]);
        assert_eq!(encode(&viridis(7.0))[..3], VIRIDIS[10]);
        let luminance = |value: f32| viridis(value).dot(&Colour::new(0.2126, 0.7152, 0.0722));
        assert!((0..100).all(|k| luminance(k as f32 / 100.0) < luminance((k + 1) as f32 / 100.0)));
    }
}
