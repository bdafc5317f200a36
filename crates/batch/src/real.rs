//! The exponential of a batch: without branches, in plain operations that every instruction set
//! rounds alike.
//!
//! eˣ = 2ⁿ (1 + q),  n = round(x/ln 2),  r = x − n ln 2,  q = r + r² Q(r)
//!
//! for x ≤ 0. Adding 1.5 · 2⁵² (2²³ in `f32`) rounds x/ln 2 to an integer and leaves it in the
//! lowest bits, from where a shift takes it to the exponent of 2ⁿ. ln 2 is split into a head of so
//! few bits that n times it is exact, and a tail.
//!
//! For n = 0 the polynomial Q(r) = (eʳ − 1 − r)/r² is also the φ2(−r) that a held step needs. This
//! is why Q was fitted and not eʳ itself.
//!
//! # Where the coefficients come from
//!
//! Remez' exchange algorithm with 60 digits (mpmath), for Q(r) = ½ + r P(r), so that the first
//! coefficient is exactly ½:
//!
//! For P of degree d take d + 2 points, at first xₖ = a cos(πk/(d + 1)) with a = 1.0005 · ½ ln 2.
//! Solve Σ cⱼ xₖʲ + (−1)ᵏ E Q(xₖ)/|xₖ| = P(xₖ) for all cⱼ and E. Move each point to the largest
//! relative error of Q between two changes of its sign. Repeat until no point moves by 1e-6.
//!
//! For `f64` Q has degree 9 and a relative error of 2.4e-16, for `f32` degree 4 and 1.3e-7. In eʳ
//! less than a tenth of this is left.

use bristle::Scalar;

/// The scalars of a batch: `f32` and `f64`.
pub trait Real: Scalar + sealed::Parts {}

impl Real for f32 {}
impl Real for f64 {}

/// Elements of a block: a multiple of every vector in use (16 `f32` in 512 bits), and few enough
/// for a last block that is not full to cost little.
pub(super) const BLOCK: usize = 32;

pub(super) mod sealed {
    use super::BLOCK;

    /// What differs between the two types. It cannot be named outside the crate.
    pub trait Parts: Sized + Send + Sync + 'static {
        /// A block of ones.
        const ONES: &[Self; BLOCK];
        /// 1/ln 2
        const PER_LN_2: Self;
        /// 1.5 · 2ᵐ with the mantissa's m bits.
        const ROUND: Self;
        /// ln 2, its leading bits.
        const HEAD: Self;
        /// ln 2, the rest.
        const TAIL: Self;
        /// ln of the smallest normal number, or the next number above.
        const LEAST: Self;
        /// Q's leading coefficient of even power, and the others of even power down to ½.
        const EVEN: (Self, &[Self]);
        /// Q's leading coefficient of odd power, and the others of odd power down.
        const ODD: (Self, &[Self]);
        /// 2ⁿ for n + ROUND; of no meaning beyond the normal numbers.
        fn power_of_two(shifted: Self) -> Self;
        /// |x|
        fn size(self) -> Self;
    }
}

impl sealed::Parts for f64 {
    const ONES: &[f64; BLOCK] = &[1.0; BLOCK];
    const PER_LN_2: f64 = core::f64::consts::LOG2_E;
    const ROUND: f64 = 6_755_399_441_055_744.0;
    // 42 bits: n has 11.
    const HEAD: f64 = 0.693_147_180_559_890_330_187_045;
    const TAIL: f64 = 5.497_923_018_708_371_174_712_472e-14;
    const LEAST: f64 = -708.396_418_532_264_1;
    const EVEN: (f64, &[f64]) = (
        2.761_852_498_809_844_455_6e-7,
        &[
            2.480_152_549_911_453_255_5e-5,
            1.388_888_891_347_260_939_1e-3,
            4.166_666_666_663_628_415_5e-2,
            0.5,
        ],
    );
    const ODD: (f64, &[f64]) = (
        2.506_617_153_646_118_165_3e-8,
        &[
            2.755_735_923_096_403_141_9e-6,
            1.984_126_978_370_565_693e-4,
            8.333_333_333_355_083_282_9e-3,
            0.166_666_666_666_666_479_1,
        ],
    );

    #[inline(always)]
    fn power_of_two(shifted: f64) -> f64 {
        f64::from_bits((shifted.to_bits() << 52).wrapping_add(1.0_f64.to_bits()))
    }

    #[inline(always)]
    fn size(self) -> f64 {
        self.abs()
    }
}

impl sealed::Parts for f32 {
    const ONES: &[f32; BLOCK] = &[1.0; BLOCK];
    const PER_LN_2: f32 = core::f32::consts::LOG2_E;
    const ROUND: f32 = 12_582_912.0;
    // 15 bits: n has 7.
    const HEAD: f32 = 0.693_145_751_953_125;
    const TAIL: f32 = 1.428_606_820_309_417_232e-6;
    const LEAST: f32 = -87.336_54;
    const EVEN: (f32, &[f32]) = (1.390_549_990_048_934_8e-3, &[4.166_676_454_342_353_4e-2, 0.5]);
    const ODD: (f32, &[f32]) = (8.362_955_430_512_907_9e-3, &[0.166_665_793_176_985_66]);

    #[inline(always)]
    fn power_of_two(shifted: f32) -> f32 {
        f32::from_bits((shifted.to_bits() << 23).wrapping_add(1.0_f32.to_bits()))
    }

    #[inline(always)]
    fn size(self) -> f32 {
        self.abs()
    }
}

/// eˣ for x ≤ 0, and what a held step needs beside it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Decay<T> {
    /// eˣ; 0 where that would be no normal number, with which processors take their time. NaN for
    /// NaN.
    pub(super) decay: T,
    /// 1 − eˣ without loss of digits.
    pub(super) loss: T,
    /// (eˣ − 1 − x)/x², only where |x| < ½ ln 2.
    pub(super) curvature: T,
    /// Whether |x| < ½ ln 2, n = 0.
    pub(super) is_near: bool,
}

/// eˣ for x ≤ 0.
#[inline(always)]
pub(super) fn decay<T: Real>(x: T) -> Decay<T> {
    let (zero, one) = (T::zero(), T::one());
    let shifted = x * T::PER_LN_2 + T::ROUND;
    let n = shifted - T::ROUND;
    let r = (x - n * T::HEAD) - n * T::TAIL;
    // Apart, so that neither half waits for the other.
    let square = r * r;
    let half =
        |(leading, others): (T, &[T])| others.iter().fold(leading, |sum, &c| sum * square + c);
    let curvature = half(T::EVEN) + r * half(T::ODD);
    let q = r + square * curvature;
    let scale = T::power_of_two(shifted);
    // NaN is not below, and stays.
    let gone = x < T::LEAST;
    Decay {
        decay: if gone { zero } else { scale + scale * q },
        loss: if gone { one } else { (one - scale) - scale * q },
        curvature,
        is_near: n == zero,
    }
}

#[cfg(test)]
mod tests {
    use super::{Decay, Real, decay};
    use bristle::scalar::{lit, to_f64};

    /// Units in the last place of `want` between it and `got`, both normal.
    fn ulps<T: Real>(got: T, want: f64) -> f64 {
        let epsilon = to_f64(T::default_epsilon());
        let unit = epsilon * 2f64.powi(want.abs().log2().floor() as i32);
        (to_f64(got) - want).abs() / unit
    }

    /// x, eˣ, 1 − eˣ and (eˣ − 1 − x)/x² by mpmath with 40 digits, of the doubles x.
    const GOLDEN: [(f64, f64, f64, f64); 14] = [
        (-1e-300, 1.0, 1e-300, 0.5),
        (
            -1e-9,
            0.999_999_999_000_000_000_5,
            9.999_999_995_000_000_624_5e-10,
            0.499_999_999_833_333_333_37,
        ),
        (
            -1e-3,
            0.999_000_499_833_374_991_65,
            9.995_001_666_250_083_527_4e-4,
            0.499_833_374_991_668_055_35,
        ),
        (
            -0.1,
            0.904_837_418_035_959_568_14,
            0.095_162_581_964_040_431_859,
            0.483_741_803_595_957_315_54,
        ),
        (
            -0.34,
            0.711_770_322_762_609_697_7,
            0.288_229_677_237_390_302_3,
            0.447_840_162_306_312_410_74,
        ),
        (
            -0.3465,
            0.707_158_819_287_271_339_29,
            0.292_841_180_712_728_660_71,
            0.446_924_985_057_928_881_21,
        ),
        (
            -0.347,
            0.706_805_328_257_749_480_19,
            0.293_194_671_742_250_519_81,
            0.446_854_705_692_676_320_15,
        ),
        (
            -0.5,
            0.606_530_659_712_633_423_6,
            0.393_469_340_287_366_576_4,
            0.426_122_638_850_533_694_42,
        ),
        (
            -1.0,
            0.367_879_441_171_442_321_6,
            0.632_120_558_828_557_678_4,
            0.367_879_441_171_442_321_6,
        ),
        (
            -3.25,
            0.038_774_207_831_722_009_887,
            0.961_225_792_168_277_990_11,
            0.216_688_682_398_269_539_4,
        ),
        (
            -20.125,
            1.818_961_687_553_045_900_8e-9,
            0.999_999_998_181_038_312_45,
            0.047_220_400_452_004_689_171,
        ),
        (-100.0, 3.720_075_976_020_835_963e-44, 1.0, 0.0099),
        (-700.5, 5.980_196_118_639_791_206_4e-305, 1.0, 1.425_513_844_755_530_489_3e-3),
        (-708.39, 2.239_401_498_880_467_844_5e-308, 1.0, 1.409_659_013_010_149_162_9e-3),
    ];

    #[test]
    fn a_decay_its_loss_and_its_curvature_are_right_to_a_few_units_in_the_last_place() {
        for (x, exp, loss, curvature) in GOLDEN {
            let got: Decay<f64> = decay(x);
            assert!(ulps(got.decay, exp) <= 2.0, "{x}: {}", got.decay);
            assert!(ulps(got.loss, loss) <= 2.0, "{x}: {}", got.loss);
            assert_eq!(got.is_near, x > -0.3466);
            if got.is_near {
                // Fitted to one unit or two, and a few roundings.
                assert!(ulps(got.curvature, curvature) <= 4.0, "{x}: {}", got.curvature);
            }
        }
    }

    fn special_values_are_exact<T: Real>(below: f64) {
        let t = |x: f64| lit::<T>(x);
        let of = |x: T| decay(x).decay;
        assert!(of(t(0.0)) == T::one() && of(t(-0.0)) == T::one());
        assert!(decay(t(0.0)).loss == T::zero() && decay(t(0.0)).curvature == t(0.5));
        assert!(of(t(f64::NEG_INFINITY)) == T::zero() && of(t(-1e30)) == T::zero());
        assert!(decay(t(f64::NEG_INFINITY)).loss == T::one());
        let nan = decay(t(f64::NAN));
        assert!(to_f64(nan.decay).is_nan() && to_f64(nan.loss).is_nan());
        // A normal number, and nothing beyond.
        let least = to_f64(of(T::LEAST));
        let smallest =
            if size_of::<T>() == 8 { f64::MIN_POSITIVE } else { f32::MIN_POSITIVE.into() };
        assert!(least >= smallest && least < 1.00001 * smallest, "{least:e}");
        assert!(of(t(below)) == T::zero());
    }

    #[test]
    fn zero_infinity_nan_and_underflow_come_out_exactly() {
        special_values_are_exact::<f64>(-708.3965);
        special_values_are_exact::<f32>(-87.33656);
    }

    #[cfg(feature = "std")]
    #[test]
    fn the_decay_of_an_f64_is_right_to_two_units_in_the_last_place() {
        // The platform's own is right to less than one.
        let mut worst = 0.0_f64;
        for k in 0..200_000 {
            let k = f64::from(k);
            for x in [-k * 708.39 / 2e5, -(k / 2e5 * 40.0 - 39.0).exp2()] {
                worst = worst.max(ulps(decay(x).decay, x.exp()));
            }
        }
        assert!(worst <= 2.0, "{worst}");
    }

    /// The largest error over every so manieth `f32` from −0 down to underflow.
    #[cfg(feature = "std")]
    fn worst_of_f32(stride: usize) -> (f64, usize) {
        let (first, last) = ((-0.0_f32).to_bits(), (-87.336_54_f32).to_bits());
        (first..=last).step_by(stride).fold((0.0, 0), |(worst, count), bits| {
            let x = f32::from_bits(bits);
            (f64::max(worst, ulps(decay(x).decay, f64::from(x).exp())), count + 1)
        })
    }

    #[cfg(feature = "std")]
    #[test]
    fn the_decay_of_an_f32_is_right_to_two_units_in_the_last_place() {
        let (worst, count) = worst_of_f32(4999);
        assert!(worst <= 2.0 && count > 200_000, "{worst} of {count}");
    }

    #[cfg(feature = "std")]
    #[test]
    #[ignore = "all 1 118 743 632: cargo test --release -p bristle-batch every_f32 -- --ignored"]
    fn the_decay_of_every_f32_is_right_to_two_units_in_the_last_place() {
        let (worst, count) = worst_of_f32(1);
        assert!(worst <= 2.0, "{worst} of {count}");
    }
}
