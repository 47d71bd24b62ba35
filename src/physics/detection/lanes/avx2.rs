//! Four numbers, for processors with AVX2. Only [`super::Simd::run`] uses this type, after a check of the processor.

use super::Lanes;
use std::arch::x86_64::*;

#[derive(Debug, Clone, Copy)]
pub struct Wide(__m256d);

// SAFETY, for everything below: only functions compiled for AVX2 call these methods, because no other code
// can name the type. Loads and stores are of 4 numbers within slices of at least that length.
#[allow(clippy::undocumented_unsafe_blocks, reason = "said once, above")]
impl Lanes for Wide {
    const COUNT: usize = 4;
    #[inline(always)]
    fn all(x: f64) -> Self {
        unsafe { Self(_mm256_set1_pd(x)) }
    }
    #[inline(always)]
    fn each(x: &[f64]) -> Self {
        unsafe { Self(_mm256_loadu_pd(x[..4].as_ptr())) }
    }
    #[inline(always)]
    fn columns<'a>(row: impl Fn(usize) -> &'a [f64; 8]) -> [Self; 8] {
        // A macro, because a closure would not use AVX2.
        macro_rules! pairs {
            ($first:expr, $at:expr) => {{
                let pairs = _mm256_castpd128_pd256(_mm_loadu_pd(row($first).as_ptr().add($at)));
                _mm256_insertf128_pd::<1>(pairs, _mm_loadu_pd(row($first + 2).as_ptr().add($at)))
            }};
        }
        macro_rules! two {
            ($at:expr) => {{
                let (even, odd) = unsafe { (pairs!(0, $at), pairs!(1, $at)) };
                unsafe { [Self(_mm256_unpacklo_pd(even, odd)), Self(_mm256_unpackhi_pd(even, odd))] }
            }};
        }
        let ([a, b], [c, d], [e, f], [g, h]) = (two!(0), two!(2), two!(4), two!(6));
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
    fn smallest(self) -> f64 {
        let mut numbers = [0.0; 4];
        self.write(&mut numbers);
        let [a, b, c, d] = numbers;
        a.min(b).min(c.min(d))
    }
    #[inline(always)]
    fn at_most(self, limit: f64) -> u32 {
        unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(self.0, _mm256_set1_pd(limit))) as u32 }
    }
    #[inline(always)]
    fn write(self, to: &mut [f64]) {
        unsafe { _mm256_storeu_pd(to[..4].as_mut_ptr(), self.0) };
    }
}
