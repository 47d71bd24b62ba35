//! Eight numbers, for processors with AVX-512 (F and DQ). Only [`super::Simd::run`] uses this type, after a check.

use super::Lanes;
use std::arch::x86_64::*;

#[derive(Debug, Clone, Copy)]
pub struct Widest(__m512d);

// SAFETY, for everything below: only functions compiled for AVX-512 call these methods, because no other code
// can name the type. Loads and stores are of 8 numbers within slices of at least that length.
#[allow(clippy::undocumented_unsafe_blocks, reason = "said once, above")]
impl Lanes for Widest {
    const COUNT: usize = 8;
    #[inline(always)]
    fn all(x: f64) -> Self {
        unsafe { Self(_mm512_set1_pd(x)) }
    }
    #[inline(always)]
    fn each(x: &[f64]) -> Self {
        unsafe { Self(_mm512_loadu_pd(x[..8].as_ptr())) }
    }
    #[inline(always)]
    fn columns<'a>(row: impl Fn(usize) -> &'a [f64; 8]) -> [Self; 8] {
        // A macro, because a closure would not use AVX-512.
        macro_rules! pairs {
            ($first:expr, $at:expr) => {{
                let pairs = _mm512_castpd128_pd512(_mm_loadu_pd(row($first).as_ptr().add($at)));
                let pairs = _mm512_insertf64x2::<1>(pairs, _mm_loadu_pd(row($first + 2).as_ptr().add($at)));
                let pairs = _mm512_insertf64x2::<2>(pairs, _mm_loadu_pd(row($first + 4).as_ptr().add($at)));
                _mm512_insertf64x2::<3>(pairs, _mm_loadu_pd(row($first + 6).as_ptr().add($at)))
            }};
        }
        macro_rules! two {
            ($at:expr) => {{
                let (even, odd) = unsafe { (pairs!(0, $at), pairs!(1, $at)) };
                unsafe { [Self(_mm512_unpacklo_pd(even, odd)), Self(_mm512_unpackhi_pd(even, odd))] }
            }};
        }
        let ([a, b], [c, d], [e, f], [g, h]) = (two!(0), two!(2), two!(4), two!(6));
        [a, b, c, d, e, f, g, h]
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        unsafe { Self(_mm512_add_pd(self.0, other.0)) }
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        unsafe { Self(_mm512_sub_pd(self.0, other.0)) }
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        unsafe { Self(_mm512_mul_pd(self.0, other.0)) }
    }
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        unsafe { Self(_mm512_div_pd(self.0, other.0)) }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        unsafe { Self(_mm512_sqrt_pd(self.0)) }
    }
    #[inline(always)]
    fn if_less(self, limit: Self, then: Self, otherwise: Self) -> Self {
        unsafe {
            let is_less = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, limit.0);
            Self(_mm512_mask_blend_pd(is_less, otherwise.0, then.0))
        }
    }
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        unsafe { Self(_mm512_min_pd(self.0, other.0)) }
    }
    #[inline(always)]
    fn smallest(self) -> f64 {
        unsafe { _mm512_reduce_min_pd(self.0) }
    }
    #[inline(always)]
    fn at_most(self, limit: f64) -> u32 {
        unsafe { u32::from(_mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, _mm512_set1_pd(limit))) }
    }
    #[inline(always)]
    fn write(self, to: &mut [f64]) {
        unsafe { _mm512_storeu_pd(to[..8].as_mut_ptr(), self.0) };
    }
}
