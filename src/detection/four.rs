//! Algorithms 2 and 3 for four pairs at once: the same operations in the same order as one by one, and so the same bits.
//!
//! [`Four`] is written down twice: for any processor, and for those with AVX2, which compute four numbers with one instruction.
//! No operation is fused, and all are correctly rounded, so the two agree to the bit.

use std::array::from_fn;

/// Four numbers, one per pair.
pub trait Four: Copy {
    /// The same number for all.
    fn all(x: f64) -> Self;
    /// One number each.
    fn each(x: [f64; 4]) -> Self;
    /// Four rows of eight become eight columns of four.
    fn columns(rows: [&[f64; 8]; 4]) -> [Self; 8];
    /// Sums.
    fn add(self, other: Self) -> Self;
    /// Differences.
    fn sub(self, other: Self) -> Self;
    /// Products.
    fn mul(self, other: Self) -> Self;
    /// Quotients.
    fn div(self, other: Self) -> Self;
    /// Square roots.
    fn sqrt(self) -> Self;
    /// Where `self < limit`, the one, elsewhere the other.
    fn if_less(self, limit: Self, then: Self, otherwise: Self) -> Self;
    /// The smaller ones of two times four.
    fn least(self, other: Self) -> Self;
    /// Which are at most `limit`, as bits.
    fn at_most(self, limit: f64) -> u32;
    /// The numbers.
    fn numbers(self) -> [f64; 4];
}

/// Four numbers for any processor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plain([f64; 4]);

impl Plain {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(from_fn(|k| f(self.0[k], other.0[k])))
    }
}

impl Four for Plain {
    #[inline(always)]
    fn all(x: f64) -> Self {
        Self([x; 4])
    }
    #[inline(always)]
    fn each(x: [f64; 4]) -> Self {
        Self(x)
    }
    #[inline(always)]
    fn columns(rows: [&[f64; 8]; 4]) -> [Self; 8] {
        from_fn(|column| Self(rows.map(|row| row[column])))
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
    fn at_most(self, limit: f64) -> u32 {
        (0..4).fold(0, |bits, k| bits | u32::from(self.0[k] <= limit) << k)
    }
    #[inline(always)]
    fn numbers(self) -> [f64; 4] {
        self.0
    }
}

/// Four numbers for processors with AVX2; the code that makes them has asked for it.
#[cfg(target_arch = "x86_64")]
pub mod avx2 {
    use super::Four;
    use std::arch::x86_64::*;

    /// Four numbers in one register.
    #[derive(Debug, Clone, Copy)]
    pub struct Wide(__m256d);

    // SAFETY, of all that follows: only functions compiled for AVX2 call these, as the module says; loads are of whole references.
    impl Four for Wide {
        #[inline(always)]
        fn all(x: f64) -> Self {
            unsafe { Self(_mm256_set1_pd(x)) }
        }
        #[inline(always)]
        fn each(x: [f64; 4]) -> Self {
            unsafe { Self(_mm256_loadu_pd(x.as_ptr())) }
        }
        #[inline(always)]
        fn columns(rows: [&[f64; 8]; 4]) -> [Self; 8] {
            // Two rows in each register, two numbers of each: the processor puts them there as it loads.
            let pair = |a: &[f64; 8], b: &[f64; 8], at: usize| unsafe {
                let low = _mm256_castpd128_pd256(_mm_loadu_pd(a.as_ptr().add(at)));
                _mm256_insertf128_pd::<1>(low, _mm_loadu_pd(b.as_ptr().add(at)))
            };
            let two = |at: usize| {
                let (even, odd) = (pair(rows[0], rows[2], at), pair(rows[1], rows[3], at));
                unsafe { [Self(_mm256_unpacklo_pd(even, odd)), Self(_mm256_unpackhi_pd(even, odd))] }
            };
            let ([a, b], [c, d], [e, f], [g, h]) = (two(0), two(2), two(4), two(6));
            [a, b, c, d, e, f, g, h]
        }
        #[inline(always)]
        fn add(self, other: Self) -> Self {
            unsafe { Self(_mm256_add_pd(self.0, other.0)) }
        }
        #[inline(always)]
        fn sub(self, other: Self) -> Self {
            unsafe { Self(_mm256_sub_pd(self.0, other.0)) }
        }
        #[inline(always)]
        fn mul(self, other: Self) -> Self {
            unsafe { Self(_mm256_mul_pd(self.0, other.0)) }
        }
        #[inline(always)]
        fn div(self, other: Self) -> Self {
            unsafe { Self(_mm256_div_pd(self.0, other.0)) }
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            unsafe { Self(_mm256_sqrt_pd(self.0)) }
        }
        #[inline(always)]
        fn if_less(self, limit: Self, then: Self, otherwise: Self) -> Self {
            unsafe {
                let is_less = _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, limit.0);
                Self(_mm256_blendv_pd(otherwise.0, then.0, is_less))
            }
        }
        #[inline(always)]
        fn least(self, other: Self) -> Self {
            unsafe { Self(_mm256_min_pd(self.0, other.0)) }
        }
        #[inline(always)]
        fn at_most(self, limit: f64) -> u32 {
            unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(self.0, _mm256_set1_pd(limit))) as u32 }
        }
        #[inline(always)]
        fn numbers(self) -> [f64; 4] {
            let mut numbers = [0.0; 4];
            unsafe { _mm256_storeu_pd(numbers.as_mut_ptr(), self.0) };
            numbers
        }
    }
}

/// Algorithm 2: the times from now to the next events on the positive side, infinite where there is none, of four pairs with
/// overlap functions `V2 dt^2 + 2 B dt + R2`.
#[inline(always)]
#[must_use]
pub fn positive<F: Four>(r2: F, b: F, v2: F) -> F {
    let (zero, never) = (F::all(0.0), F::all(f64::INFINITY));
    let discriminant = b.mul(b).sub(v2.mul(r2));
    let root = r2.div(discriminant.sqrt().sub(b));
    let outside = zero.if_less(discriminant, root, never);
    let approaching = zero.if_less(r2, outside, zero);
    b.if_less(zero, approaching, never)
}

/// Algorithm 3: the times from now to the next events on the negative side, of four pairs.
#[inline(always)]
#[must_use]
pub fn negative<F: Four>(r2: F, b: F, v2: F) -> F {
    let (zero, never) = (F::all(0.0), F::all(f64::INFINITY));
    let discriminant = b.mul(b).sub(v2.mul(r2));
    let root = discriminant.sqrt();
    let q = b.add(b.if_less(zero, zero.sub(root), root));
    let (one, other) = (zero.sub(q).div(v2), zero.sub(r2).div(q));
    let last = one.if_less(other, other, one);
    let dt = zero.if_less(discriminant, last, zero.sub(b).div(v2));
    zero.if_less(v2, dt.if_less(zero, zero, dt), never)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detection::inertial;
    use crate::overlap::Quadratic;
    use proptest::prelude::*;

    /// Exact zeros, contact and grazing come up often.
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
                1e-50
            ]),
            -4.0..4.0_f64
        ]
    }

    fn found<F: Four>(f: [[f64; 4]; 3]) -> [[f64; 4]; 2] {
        let [r2, b, v2] = f.map(F::each);
        [positive(r2, b, v2).numbers(), negative(r2, b, v2).numbers()]
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn found_wide(f: [[f64; 4]; 3]) -> [[f64; 4]; 2] {
        found::<avx2::Wide>(f)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn columns_wide(rows: [&[f64; 8]; 4]) -> [[f64; 4]; 8] {
        avx2::Wide::columns(rows).map(Four::numbers)
    }

    proptest! {
        #[test]
        fn four_at_once_are_one_by_one(f in prop::array::uniform4((coefficient(), coefficient(), coefficient()))) {
            let f = f.map(|(r2, b, v2)| [r2, b, v2.abs()]);
            let columns = [0, 1, 2].map(|k| f.map(|f| f[k]));
            let mut ways = vec![found::<Plain>(columns)];
            #[cfg(target_arch = "x86_64")]
            if std::arch::is_x86_feature_detected!("avx2") {
                // SAFETY: the processor has AVX2.
                ways.push(unsafe { found_wide(columns) });
            }
            for found in ways {
                for (k, [r2, b, v2]) in f.into_iter().enumerate() {
                    let f = Quadratic { r2, b, v2 };
                    let alone = [inertial::positive(&f), inertial::negative(&f)].map(|dt| dt.unwrap_or(f64::INFINITY));
                    prop_assert_eq!(found.map(|found| found[k]), alone, "{:?}", f);
                }
            }
        }
    }

    #[test]
    fn rows_become_columns() {
        let rows: [[f64; 8]; 4] = from_fn(|row| from_fn(|column| (10 * row + column) as f64));
        let expected: [[f64; 4]; 8] = from_fn(|column| from_fn(|row| (10 * row + column) as f64));
        let rows = rows.each_ref();
        assert_eq!(Plain::columns(rows).map(Four::numbers), expected);
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has AVX2.
            assert_eq!(unsafe { columns_wide(rows) }, expected);
        }
    }
}
