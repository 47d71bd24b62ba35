//! Writes numbers as the shortest text that reads back as the same number.

use std::fmt;
use std::io::Write;
use std::ops::Range;

/// Numbers of these magnitudes, and 0, are written without an exponent.
const PLAIN: Range<f64> = 1e-4..1e16;

/// A number with the fewest digits that read back as the same number, with an exponent if very large or small.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shortest(pub f64);

impl Shortest {
    #[inline]
    pub fn push(self, text: &mut Vec<u8>) {
        let mut buffer = zmij::Buffer::new();
        match self.plain(&mut buffer) {
            Some(plain) => text.extend_from_slice(plain.as_bytes()),
            None => {
                let _ = write!(text, "{:e}", self.0);
            }
        }
    }

    /// Formats the number without an exponent; `None` if the number is very large or small.
    #[inline]
    fn plain(self, buffer: &mut zmij::Buffer) -> Option<&str> {
        let Self(number) = self;
        let is_plain = number == 0.0 || PLAIN.contains(&number.abs());
        is_plain.then(|| {
            let text = buffer.format_finite(number);
            text.strip_suffix(".0").unwrap_or(text)
        })
    }
}

impl fmt::Display for Shortest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.plain(&mut zmij::Buffer::new()) {
            Some(plain) => f.write_str(plain),
            None => write!(f, "{:e}", self.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_core::{Rng, SeedableRng};

    fn expected(number: f64) -> String {
        if number == 0.0 || (1e-4..1e16).contains(&number.abs()) { format!("{number}") } else { format!("{number:e}") }
    }

    fn found(number: f64) -> String {
        let mut text = Vec::new();
        Shortest(number).push(&mut text);
        let text = String::from_utf8(text).unwrap();
        assert_eq!(text, Shortest(number).to_string());
        text
    }

    #[test]
    fn numbers_have_the_digits_of_the_standard_library() {
        for (number, text) in [(0.1, "0.1"), (-0.0, "-0"), (1e300, "1e300"), (-2.5e-9, "-2.5e-9"), (9999.0, "9999")] {
            assert_eq!(found(number), text);
        }
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let same = |number: f64| assert_eq!(found(number), expected(number), "{:x}", number.to_bits());
        for _ in 0..100_000 {
            let part = random.next_u32();
            same(f64::from(part) * 1e-7 * std::f64::consts::PI);
            same(f64::from(part % 100_000) / 1000.0);
            same(f64::from(part));
        }
    }

    #[test]
    fn numbers_read_back_as_the_same_from_the_shortest_text() {
        let mut random = ChaCha8Rng::seed_from_u64(8);
        let read = |number: f64| {
            let text = found(number);
            // Two shortest texts may be equally close, as for 2^50 + 1/4, so only the lengths are compared.
            assert_eq!(text.len(), expected(number).len(), "{:x}", number.to_bits());
            assert_eq!(text.parse::<f64>().unwrap().to_bits(), number.to_bits(), "{text}");
        };
        for edge in [1e-4, 1e-5, 1e15, 1e16, 1e17, 9_007_199_254_740_993.0, f64::MAX, f64::MIN_POSITIVE, 5e-324] {
            [edge, -edge, edge.next_up().min(f64::MAX), edge.next_down()].into_iter().for_each(read);
        }
        for power in -1074..1024 {
            let power = libm::ldexp(1.0, power);
            [power, power.next_up(), power.next_down()].into_iter().for_each(read);
        }
        for _ in 0..100_000 {
            let number = f64::from_bits(random.next_u64());
            if number.is_finite() {
                read(number);
            }
        }
    }
}
