//! Cache of the colours of bodies in a pixel.

use super::super::colour::Colour;

/// Maximum number of bodies in the cache. The colours of further bodies are computed for each sample.
const MOST: usize = 12;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Seen {
    Nothing,
    Solid(u32),
    Veil(u32),
    Sheet(u32),
}

#[derive(Debug)]
pub(super) struct Memory {
    seen: [Seen; MOST],
    known: [(Colour, f32); MOST],
    count: usize,
}

impl Default for Memory {
    fn default() -> Self {
        Self { seen: [Seen::Nothing; MOST], known: [(Colour::zeros(), 0.0); MOST], count: 0 }
    }
}

impl Memory {
    pub fn recall(&mut self, seen: Seen, find: impl FnOnce() -> (Colour, f32)) -> (Colour, f32) {
        if let Some(place) = self.seen[..self.count].iter().position(|known| *known == seen) {
            return self.known[place];
        }
        let found = find();
        if self.count < MOST {
            (self.seen[self.count], self.known[self.count]) = (seen, found);
            self.count += 1;
        }
        found
    }
}
