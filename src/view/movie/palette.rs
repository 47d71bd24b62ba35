//! Colours of a GIF. They are the same in all images, to avoid flicker.

use color_quant::NeuQuant;

use crate::base::numbers::trunc_to_u32;
use crate::view::render::{BACKGROUND, INK, Image, Style};

/// Number of images from which the colours of a GIF are chosen.
pub(super) const PILOTS: usize = 8;

const PILOT_SIZE: f64 = 320.0;

pub(super) const UNCHANGED: u8 = 0;

const EXACT: [[u8; 3]; 2] = [BACKGROUND, INK];

/// Number of neurons of the network that chooses the other colours.
const NEURONS: usize = 256 - 1 - EXACT.len();

/// Bits per component in the lookup table of nearest colours.
const BITS: usize = 6;

pub(super) fn pilot_style(style: &Style) -> Style {
    let scale = (PILOT_SIZE / f64::from(style.width.max(style.height))).min(1.0);
    let scaled = |size: u32| trunc_to_u32((f64::from(size) * scale).round()).max(16);
    Style { width: scaled(style.width), height: scaled(style.height), ..style.clone() }
}

#[derive(Debug, Clone)]
pub(super) struct Palette {
    colours: Vec<[u8; 3]>,
    /// Index of the nearest colour, by the upper bits of red, green and blue.
    nearest: Vec<u8>,
}

impl Palette {
    pub fn of(images: &[Image]) -> Self {
        let pixels = images.iter().flat_map(Image::pixels).filter(|pixel| !EXACT.contains(&rgb(pixel)));
        let mut pixels: Vec<u8> = pixels.flatten().copied().collect();
        if pixels.is_empty() {
            pixels.extend([BACKGROUND[0], BACKGROUND[1], BACKGROUND[2], 255]);
        }
        let network = NeuQuant::new(1, NEURONS, &pixels);
        let chosen = network.color_map_rgb();
        let chosen = chosen.chunks_exact(3).map(|colour| [colour[0], colour[1], colour[2]]);
        // The first entry stands for unchanged pixels.
        let colours: Vec<[u8; 3]> = [[0; 3]].into_iter().chain(EXACT).chain(chosen).collect();
        let nearest = nearest(&colours);
        Self { colours, nearest }
    }

    pub fn bytes(&self) -> &[u8] {
        self.colours.as_flattened()
    }

    pub fn indices(&self, image: &Image) -> Vec<u8> {
        let index = |pixel: &[u8; 4]| {
            let colour = rgb(pixel);
            let exact = (1..).zip(EXACT).find(|(_, exact)| *exact == colour);
            exact.map_or_else(|| self.nearest[cell(colour)], |(index, _)| index)
        };
        image.pixels().iter().map(index).collect()
    }
}

fn rgb(pixel: &[u8; 4]) -> [u8; 3] {
    [pixel[0], pixel[1], pixel[2]]
}

fn cell(colour: [u8; 3]) -> usize {
    colour.into_iter().fold(0, |cell, component| cell << BITS | usize::from(component) >> (8 - BITS))
}

/// Returns the index of the colour nearest to each cell of the lookup table, except the first colour.
fn nearest(colours: &[[u8; 3]]) -> Vec<u8> {
    let squares = |component: usize| -> Vec<Vec<i32>> {
        let middles = (0..1 << BITS).map(|step: i32| (step << (8 - BITS)) + (1 << (7 - BITS)));
        let square =
            |middle: i32| colours.iter().skip(1).map(|colour| (i32::from(colour[component]) - middle).pow(2)).collect();
        middles.map(square).collect()
    };
    let [reds, greens, blues] = [0, 1, 2].map(squares);
    let mut nearest = Vec::with_capacity(1 << (3 * BITS));
    for red in &reds {
        for green in &greens {
            // A key is the squared distance of two colours, shifted by a byte, plus the index of the colour.
            let keys: Vec<i32> = (1..).zip(red.iter().zip(green)).map(|(index, (r, g))| (r + g) << 8 | index).collect();
            let index = |blue: &Vec<i32>| keys.iter().zip(blue).map(|(key, b)| key + (b << 8)).min();
            nearest.extend(blues.iter().map(|blue| index(blue).map_or(1, |key| key.to_le_bytes()[0])));
        }
    }
    nearest
}
