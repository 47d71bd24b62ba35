//! SIMD lanes: Algorithms 2 and 3 for many pairs at once. [`Lanes`] is implemented for any processor, for AVX2 and for
//! AVX-512. All implementations perform the scalar operations in the same order, so results agree bit for bit.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;

use std::array::from_fn;

/// The SIMD instructions in use, which determine the number of lanes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Simd(Instructions);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Instructions {
    Any,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Simd {
    /// All instruction sets of the processor, the widest last. Results do not depend on the choice.
    #[must_use]
    pub fn all() -> Vec<Self> {
        #[cfg_attr(not(target_arch = "x86_64"), expect(unused_mut, reason = "nothing else is known there"))]
        let mut all = vec![Self(Instructions::Any)];
        #[cfg(target_arch = "x86_64")]
        {
            if std::arch::is_x86_feature_detected!("avx2") {
                all.push(Self(Instructions::Avx2));
                if std::arch::is_x86_feature_detected!("avx512f") && std::arch::is_x86_feature_detected!("avx512dq") {
                    all.push(Self(Instructions::Avx512));
                }
            }
        }
        all
    }

    #[must_use]
    pub fn most() -> Self {
        Self::all().pop().unwrap_or(Self(Instructions::Any))
    }

    /// Whether AVX2 is available, for code that has no AVX-512 version.
    #[cfg_attr(not(target_arch = "x86_64"), allow(dead_code, reason = "other processors have no AVX2"))]
    #[inline]
    #[must_use]
    pub fn has_avx2(self) -> bool {
        self.0 != Instructions::Any
    }

    /// Returns the same instructions, limited to four lanes. Four lanes are cheaper than eight for a few numbers.
    #[inline]
    #[must_use]
    pub fn at_most_four(self) -> Self {
        match self.0 {
            // [`Self::all`] lists AVX-512 only if the processor also has AVX2.
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx512 => Self(Instructions::Avx2),
            _ => self,
        }
    }

    #[inline]
    pub fn run<W: Work>(self, work: W) -> W::Output {
        match self.0 {
            Instructions::Any => work.run::<Plain>(),
            // SAFETY: [`Self::all`] has checked that the processor supports these instructions.
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx2 => unsafe { in_fours(work) },
            // SAFETY: [`Self::all`] has checked that the processor supports these instructions.
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx512 => unsafe { in_eights(work) },
        }
    }
}

/// A calculation that can run with any SIMD instructions.
pub trait Work {
    type Output;

    /// Runs the calculation with lanes of the type `F`. This function must be inlined to use the instructions of `F`.
    fn run<F: Lanes>(self) -> Self::Output;
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn in_fours<W: Work>(work: W) -> W::Output {
    work.run::<avx2::Wide>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq")]
fn in_eights<W: Work>(work: W) -> W::Output {
    work.run::<avx512::Widest>()
}

pub const MOST_LANES: usize = 8;

/// A SIMD vector with one number per lane.
pub trait Lanes: Copy {
    const COUNT: usize;
    fn all(x: f64) -> Self;
    fn each(x: &[f64]) -> Self;
    /// Transposes rows of eight numbers: each vector holds one column.
    fn columns<'a>(row: impl Fn(usize) -> &'a [f64; 8]) -> [Self; 8];
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    fn sqrt(self) -> Self;
    /// Selects `then` in lanes where `self < limit`, and `otherwise` in all other lanes.
    fn if_less(self, limit: Self, then: Self, otherwise: Self) -> Self;
    fn least(self, other: Self) -> Self;
    fn smallest(self) -> f64;
    /// Returns a bit mask of the lanes that are at most `limit`.
    fn at_most(self, limit: f64) -> u32;
    fn write(self, to: &mut [f64]);
}

/// Four numbers in an array. Every processor supports this type.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plain([f64; 4]);

impl Plain {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(from_fn(|k| f(self.0[k], other.0[k])))
    }
}

impl Lanes for Plain {
    const COUNT: usize = 4;
    #[inline(always)]
    fn all(x: f64) -> Self {
        Self([x; 4])
    }
    #[inline(always)]
    fn each(x: &[f64]) -> Self {
        Self(from_fn(|k| x[k]))
    }
    #[inline(always)]
    fn columns<'a>(row: impl Fn(usize) -> &'a [f64; 8]) -> [Self; 8] {
        from_fn(|column| Self(from_fn(|k| row(k)[column])))
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }
    #[inline(always)]
    fn if_less(self, limit: Self, then: Self, otherwise: Self) -> Self {
        Self(from_fn(|k| if self.0[k] < limit.0[k] { then.0[k] } else { otherwise.0[k] }))
    }
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        self.if_less(other, self, other)
    }
    #[inline(always)]
    fn smallest(self) -> f64 {
        let [a, b, c, d] = self.0;
        a.min(b).min(c.min(d))
    }
    #[inline(always)]
    fn at_most(self, limit: f64) -> u32 {
        (0..4).fold(0, |bits, k| bits | u32::from(self.0[k] <= limit) << k)
    }
    #[inline(always)]
    fn write(self, to: &mut [f64]) {
        to[..4].copy_from_slice(&self.0);
    }
}

/// Algorithm 2 for `V2 dt^2 + 2 B dt + R2`. Returns the times to the next events on the positive side. A time is
/// infinite if there is no event.
#[inline(always)]
#[must_use]
pub fn positive<F: Lanes>(r2: F, b: F, v2: F) -> F {
    let (zero, never) = (F::all(0.0), F::all(f64::INFINITY));
    let discriminant = b.mul(b).sub(v2.mul(r2));
    let root = r2.div(discriminant.sqrt().sub(b));
    let outside = zero.if_less(discriminant, root, never);
    let approaching = zero.if_less(r2, outside, zero);
    b.if_less(zero, approaching, never)
}

/// Algorithm 3. Returns the times to the next events on the negative side, for the same coefficients as [`positive`].
#[inline(always)]
#[must_use]
pub fn negative<F: Lanes>(r2: F, b: F, v2: F) -> F {
    let (zero, never) = (F::all(0.0), F::all(f64::INFINITY));
    let discriminant = b.mul(b).sub(v2.mul(r2));
    let root = discriminant.sqrt();
    let q = b.add(b.if_less(zero, zero.sub(root), root));
    // Operands are selected first, so that a single division is enough. Divisions are slow.
    let (above, below) = (b.if_less(zero, q, r2), b.if_less(zero, v2, q));
    let (above, below) = (zero.if_less(discriminant, above, b), zero.if_less(discriminant, below, v2));
    let last = zero.sub(above).div(below);
    let dt = zero.if_less(discriminant, last, r2.if_less(zero, never, last));
    zero.if_less(v2, dt.if_less(zero, zero, dt), never)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::detection::inertial;
    use crate::physics::overlap::Quadratic;
    use proptest::prelude::*;

    /// Random coefficients. Exact zeros, contacts and grazing are frequent.
    fn coefficient() -> impl Strategy<Value = f64> {
        prop_oneof![
            prop::sample::select(vec![
                0.0,
                -0.0,
                1.0,
                -1.0,
                4.0,
                -2.0,
                f64::EPSILON,
                -f64::EPSILON,
                1e50,
                -1e50,
                1e-50,
                1e-170,
                -1e-170,
                1e-321
            ]),
            -4.0..4.0_f64
        ]
    }

    struct Find<'a>(&'a [[f64; 8]; 3]);

    impl Work for Find<'_> {
        type Output = [[f64; 8]; 2];

        #[inline(always)]
        fn run<F: Lanes>(self) -> Self::Output {
            let mut found = [[0.0; 8]; 2];
            for at in (0..8).step_by(F::COUNT) {
                let [r2, b, v2] = [0, 1, 2].map(|k| F::each(&self.0[k][at..]));
                positive(r2, b, v2).write(&mut found[0][at..]);
                negative(r2, b, v2).write(&mut found[1][at..]);
            }
            found
        }
    }

    proptest! {
        #[test]
        fn simd_detection_matches_scalar_detection(f in prop::array::uniform8((coefficient(), coefficient(), coefficient()))) {
            let f = f.map(|(r2, b, v2)| [r2, b, v2.abs()]);
            let coefficients = [0, 1, 2].map(|k| f.map(|f| f[k]));
            for width in Simd::all() {
                let found = width.run(Find(&coefficients));
                for (k, [r2, b, v2]) in f.into_iter().enumerate() {
                    let f = Quadratic { r2, b, v2 };
                    let alone = [inertial::positive(&f), inertial::negative(&f)].map(|dt| dt.unwrap_or(f64::INFINITY));
                    prop_assert_eq!(found.map(|found| found[k]), alone, "{:?}", f);
                }
            }
        }
    }

    struct Turn<'a>(&'a [[f64; 8]; 8]);

    impl Work for Turn<'_> {
        type Output = [[f64; 8]; 8];

        #[inline(always)]
        fn run<F: Lanes>(self) -> Self::Output {
            let mut columns = [[0.0; 8]; 8];
            for at in (0..8).step_by(F::COUNT) {
                for (to, column) in columns.iter_mut().zip(F::columns(|k| &self.0[at + k])) {
                    column.write(&mut to[at..]);
                }
            }
            columns
        }
    }

    #[test]
    fn simd_transpose_is_exact() {
        let rows: [[f64; 8]; 8] = from_fn(|row| from_fn(|column| (10 * row + column) as f64));
        let expected: [[f64; 8]; 8] = from_fn(|column| from_fn(|row| (10 * row + column) as f64));
        for width in Simd::all() {
            assert_eq!(width.run(Turn(&rows)), expected);
        }
    }

    struct Compare<'a>(&'a [f64; 8]);

    impl Work for Compare<'_> {
        type Output = (f64, u32);

        #[inline(always)]
        fn run<F: Lanes>(self) -> Self::Output {
            let (mut smallest, mut bits) = (f64::INFINITY, 0);
            for at in (0..8).step_by(F::COUNT) {
                let x = F::each(&self.0[at..]);
                smallest = smallest.min(x.smallest());
                bits |= x.at_most(3.0) << at;
            }
            (smallest, bits)
        }
    }

    #[test]
    fn simd_finds_minimum_and_mask_of_times() {
        let times = [4.0, 3.0, f64::INFINITY, 5.0, 3.5, 2.0, 9.0, 8.0];
        for width in Simd::all() {
            assert_eq!(width.run(Compare(&times)), (2.0, 0b10_0010));
        }
    }
}
