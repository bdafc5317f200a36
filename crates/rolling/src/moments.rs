//! Moments of decaying and of rising profiles, without loss of digits.
//!
//! | moment | of |
//! |---|---|
//! | ψ_k(x) = ∫₀¹ tᵏ e^(−xt) dt | a decaying weight |
//! | χ_k(α, x) = ∫₀¹ tᵏ⁺¹ φ1(xt) e^(−αt) dt = (ψ_k(α) − ψ_k(α + x))/x | 1 − e^(−xt), per x |
//!
//! with φ1(x) = (1 − e⁻ˣ)/x. ψ_k follows from ψ_{k−1} without loss where |x| > k, and ψ_{k−1} from
//! ψ_k where |x| < k. χ is taken from its power series, from the difference where that keeps its
//! digits, and else by quadrature.

use nalgebra::{Complex, ComplexField};

use super::quadrature::integrate;
use bristle::Scalar;
use bristle::rheology::Weights;
use bristle::scalar::{is_zero, lit};

/// Below this sum of exponents a power series needs at most [`TERMS`] terms.
const SMALL: f64 = 0.7;
const TERMS: usize = 16;
/// Sums of exponents below which fewer terms do.
const TERMS_UP_TO: [(f64, usize); 5] = [(1e-4, 4), (0.01, 7), (0.03, 8), (0.1, 10), (0.3, 13)];

/// ψ₀ … ψ_{N−1} at any real x.
#[inline]
pub(super) fn decaying<T: Scalar, const N: usize>(x: T) -> [T; N] {
    if N == 1 && x < lit(0.5) && x > lit(-0.5) {
        return [Weights::relaxed(x).1; N];
    }
    let (mut psi, decay) = ([T::zero(); N], (-x).exp());
    let top = N as f64;
    if x > lit(2.0 * top) || x < lit(-2.0 * top) {
        upwards(x, decay, psi.iter_mut());
        return psi;
    }
    // The highest from a series of positive terms, the others by ψ_{k−1} = (x ψ_k + e⁻ˣ)/k.
    let mut term = T::one();
    let mut last = T::one() / lit(top);
    if x < T::zero() {
        // Σ |x|ⁿ/(n! (k + n + 1))
        for n in 1..RECIPROCALS.len().saturating_sub(N) {
            term *= -x * lit(RECIPROCALS[n]);
            let next = last + term * lit(RECIPROCALS[N + n]);
            if next == last {
                break;
            }
            last = next;
        }
    } else {
        // e⁻ˣ Σ xⁿ/((k + 1) … (k + 1 + n))
        term = last;
        for n in 1..RECIPROCALS.len().saturating_sub(N) {
            term *= x * lit(RECIPROCALS[N + n]);
            let next = last + term;
            if next == last {
                break;
            }
            last = next;
        }
        last *= decay;
    }
    // Downwards errors grow by |x|/k for x < 0, upwards they shrink by k/|x|.
    let mut open = 0;
    for (k, psi) in psi.iter_mut().enumerate().rev() {
        if k + 1 < N {
            let above: T = lit((k + 1) as f64);
            if !(above >= -x) {
                open = k + 1;
                break;
            }
            last = (x * last + decay) / above;
        }
        *psi = last;
    }
    if open > 0 {
        upwards(x, decay, psi.iter_mut().take(open));
    }
    psi
}

/// ψ₀, ψ₁, … by ψ_k = (k ψ_{k−1} − e⁻ˣ)/x, which shrinks errors where |x| > k.
#[inline]
fn upwards<'a, C>(x: C, decay: C, psi: impl Iterator<Item = &'a mut C>)
where
    C: ComplexField<RealField: Scalar> + Copy,
{
    let inverse = C::one() / x;
    let mut last = (C::one() - decay) * inverse;
    for (k, psi) in psi.enumerate() {
        if k > 0 {
            last = (last.scale(lit(k as f64)) - decay) * inverse;
        }
        *psi = last;
    }
}

/// χ₀ … χ_{N−1} for α ≥ −50 and x ≥ 0.
#[inline]
pub(super) fn rising<T: Scalar, const N: usize>(alpha: T, x: T) -> [T; N] {
    if N == 1 && is_zero(alpha) {
        return [Weights::relaxed(x).2; N];
    }
    if x + alpha < lit(SMALL) && alpha > lit(-SMALL) {
        // Σ (−1)ⁿ⁺¹ dₙ/(n! (k + n + 1)) from n = 1, with dₙ = ((α + x)ⁿ − αⁿ)/x.
        let both = alpha + x;
        let mut chi = [T::zero(); N];
        // dₙ (−1)ⁿ⁺¹/n! and αⁿ (−1)ⁿ⁺¹/n!, of which the next follow.
        let mut term = T::one();
        let mut power = alpha;
        // The last term of each choice is below a rounding of the first.
        let size = if alpha < T::zero() { x - alpha } else { both };
        let terms = TERMS_UP_TO.iter().find(|(most, _)| size < lit(*most));
        let terms = terms.map_or(TERMS, |&(_, terms)| terms);
        for n in 1..=terms {
            for (k, chi) in chi.iter_mut().enumerate() {
                *chi += term * lit(RECIPROCALS[(k + n + 1).min(RECIPROCALS.len() - 1)]);
            }
            // In this order the next term waits for the last one as little as can be.
            let inverse = lit::<T>(-RECIPROCALS[(n + 1).min(RECIPROCALS.len() - 1)]);
            power *= inverse;
            term = term * (both * inverse) + power;
            power *= alpha;
        }
        return chi;
    }
    // The weight is spread over a length of about 1/(1 + α), over which the rise has to be felt for
    // the difference to keep its digits.
    let rises = lit::<T>(0.5) * T::one().larger(T::one() + alpha);
    if x > rises {
        let inverse = T::one() / x;
        let (slow, fast) = (decaying::<T, N>(alpha), decaying::<T, N>(alpha + x));
        return core::array::from_fn(|k| (slow[k] - fast[k]) * inverse);
    }
    // A slow rise under a steep weight.
    let mut chi = [T::zero(); N];
    integrate(alpha.abs() + x, |t, weight| {
        let mut value = weight * t * phi1(x * t) * (-alpha * t).exp();
        for chi in &mut chi {
            *chi += value;
            value *= t;
        }
    });
    chi
}

/// 1/n for small n; 0 is never asked for.
const RECIPROCALS: [f64; 128] = {
    let mut table = [1.0; 128];
    let mut n = 1;
    while n < 128 {
        table[n] = 1.0 / n as f64;
        n += 1;
    }
    table
};

/// φ1(x) = (1 − e⁻ˣ)/x.
pub(super) fn phi1<T: Scalar>(x: T) -> T {
    decaying::<T, 1>(x)[0]
}

/// ψ₀ … ψ_{N−1} at a complex x.
pub(super) fn complex_decaying<T: Scalar, const N: usize>(x: Complex<T>) -> [Complex<T>; N] {
    let zero = Complex::new(T::zero(), T::zero());
    let (mut psi, decay, size) = ([zero; N], (-x).exp(), x.modulus());
    if size > lit(2.0 * N as f64 + 2.0) {
        upwards(x, decay, psi.iter_mut());
        return psi;
    }
    integrate(size, |t, weight| {
        let mut value = (-x.scale(t)).exp().scale(weight);
        for psi in &mut psi {
            *psi += value;
            value = value.scale(t);
        }
    });
    psi
}

/// φ1(x) = (1 − e⁻ˣ)/x at a complex x.
pub(super) fn complex_phi1<T: Scalar>(x: Complex<T>) -> Complex<T> {
    if x.modulus() < lit(0.5) {
        // Σ (−x)ⁿ/(n + 1)!, cut below 1e-19.
        let one = Complex::new(T::one(), T::zero());
        (2..=14).rev().fold(one, |sum, n| one - (x * sum).scale(lit(1.0 / f64::from(n))))
    } else {
        (Complex::new(T::one(), T::zero()) - (-x).exp()) / x
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    // Gauss–Legendre quadrature by mpmath with 40 digits, k = 0, 1, 5, 11.
    const ORDERS: [usize; 4] = [0, 1, 5, 11];

    #[rustfmt::skip]
    const PSI: [(f64, [f64; 4]); 12] = [
        (-50.0, [
            1.036_941_105_717_414_5e20, 1.016_202_283_603_066_2e20,
            9.410_643_033_445_131_9e19, 8.473_769_819_556_61e19,
        ]),
        (-24.5, [
            1.782_578_738_638_629_2e9, 1.709_820_422_816_644_2e9,
            1.471_478_367_154_849_1e9, 1.219_157_902_442_804_8e9,
        ]),
        (-13.0, [
            3.403_172_246_222_465_8e4, 3.141_397_458_051_506_7e4,
            2.417_265_716_702_869e4, 1.807_274_219_394_660_4e4,
        ]),
        (-3.0, [
            6.361_845_641_062_555_7, 4.574_563_760_708_370_5,
            2.313_678_847_748_474_9, 1.356_385_375_181_025_5,
        ]),
        (-1e-09, [
            1.000_000_000_5, 5.000_000_003_333_333_6e-1,
            1.666_666_668_095_238e-1, 8.333_333_341_025_640_8e-2,
        ]),
        (0.0, [1.0, 5.0e-1, 1.666_666_666_666_666_6e-1, 8.333_333_333_333_332_9e-2]),
        (1e-09, [
            9.999_999_994_999_999_6e-1, 4.999_999_996_666_666_9e-1,
            1.666_666_665_238_095_1e-1, 8.333_333_325_641_025e-2,
        ]),
        (0.7, [
            7.191_638_517_265_578_3e-1, 3.179_693_541_930_690_4e-1,
            9.182_536_074_374_349_2e-2, 4.372_722_591_159_085_3e-2,
        ]),
        (5.0, [
            1.986_524_106_001_829e-1, 3.838_289_272_021_949e-2,
            2.949_422_170_882_075_1e-3, 8.915_762_351_030_763_7e-4,
        ]),
        (23.9, [
            4.184_100_418_235_474_4e-2, 1.750_669_629_315_190_7e-3,
            6.438_613_705_118_108_1e-7, 1.146_090_507_857_382_5e-9,
        ]),
        (24.1, [
            4.149_377_593_219_257_7e-2, 1.721_733_439_752_437_6e-3,
            6.124_600_108_712_526_4e-7, 1.037_324_395_341_524e-9,
        ]),
        (1000.0, [1.0e-3, 9.999_999_999_999_999_5e-7, 1.2e-16, 3.991_68e-29]),
    ];

    #[rustfmt::skip]
    const CHI: [(f64, f64, [f64; 4]); 17] = [
        (0.0, 1e-12, [
            4.999_999_999_998_333_6e-1, 3.333_333_333_332_083_6e-1,
            1.428_571_428_570_803_4e-1, 7.692_307_692_304_120_6e-2,
        ]),
        (0.0, 0.3, [
            4.535_357_853_524_207_3e-1, 2.986_550_698_604_898_4e-1,
            1.256_671_753_881_063_4e-1, 6.714_226_914_697_252_2e-2,
        ]),
        (0.0, 0.69, [
            4.023_861_984_164_157_6e-1, 2.609_169_207_590_472_7e-1,
            1.073_351_644_729_504_4e-1, 5.681_481_373_559_340_4e-2,
        ]),
        (0.0, 0.71, [
            4.000_083_266_434_538_7e-1, 2.591_749_838_877_551_2e-1,
            1.064_994_677_876_074_7e-1, 5.634_686_369_089_019_6e-2,
        ]),
        (0.0, 3.0, [
            2.277_541_187_075_404_5e-1, 1.370_054_916_100_539e-1,
            5.095_100_455_246_620_6e-2, 2.599_048_261_146_730_6e-2,
        ]),
        (0.0, 10000.0, [
            9.998_999_999_999_999_6e-5, 4.999_999_9e-5,
            1.666_666_666_666_666_7e-5, 8.333_333_333_333_333_7e-6,
        ]),
        (0.1, 0.4, [
            4.117_178_476_641_777_9e-1, 2.676_699_358_006_187_1e-1,
            1.105_028_110_799_616_1e-1, 5.856_816_282_292_427_7e-2,
        ]),
        (0.14, 0.57, [
            3.809_848_655_332_518_4e-1, 2.451_030_004_603_800_5e-1,
            9.963_222_472_360_306e-2, 5.246_934_769_353_059_1e-2,
        ]),
        (0.6, 0.6, [
            2.827_374_162_835_406e-1, 1.738_805_500_058_743_5e-1,
            6.607_965_102_658_987_2e-2, 3.384_530_839_473_133_5e-2,
        ]),
        (3.0, 0.1, [
            8.688_999_488_203_784_4e-2, 4.144_995_493_832_733e-2,
            1.058_708_556_573_682_2e-2, 4.637_036_452_155_108_3e-3,
        ]),
        (50.0, 0.6, [
            3.952_569_169_960_474_3e-4, 1.571_653_986_158_196_6e-5,
            8.840_987_727_100_76e-10, 3.634_307_873_249_283_1e-14,
        ]),
        (50.0, 20.0, [
            2.857_142_857_142_857_4e-4, 9.795_918_367_346_938_7e-6,
            3.330_008_414_861_152_8e-10, 8.030_765_958_218_142_4e-15,
        ]),
        (50.0, 30.0, [
            2.500_000_000_000_000_1e-4, 8.124_999_999_999_999_3e-6,
            2.407_412_109_374_998_8e-10, 5.430_611_563_510_008e-15,
        ]),
        (-0.6, 1.2, [
            5.151_811_617_840_769_1e-1, 3.454_886_518_385_155_1e-1,
            1.496_227_065_245_467_6e-1, 8.098_709_576_356_849_5e-2,
        ]),
        (-5.0, 0.3, [
            2.100_794_120_872_234_7e1, 1.775_019_336_944_164_6e1,
            1.119_297_478_318_633_3e1, 7.288_374_307_855_972,
        ]),
        (-50.0, 0.2, [
            9.227_799_644_227_452_9e19, 9.046_666_884_727_775_2e19,
            8.389_193_015_097_347_3e19, 7.566_764_156_266_006_1e19,
        ]),
        (-50.0, 40.0, [
            2.592_352_764_293_536_3e18, 2.540_505_709_007_665_7e18,
            2.352_660_758_361_283_1e18, 2.118_442_454_889_152_3e18,
        ]),
    ];

    /// Just below the sizes at which the series takes more terms, where the last one is largest.
    #[rustfmt::skip]
    const CHI_OF_SERIES: [(f64, f64, [f64; 4]); 12] = [
        (8.91e-05, 9.9e-06, [
            4.999_686_511_066_684_4e-1, 3.333_098_217_186_671_6e-1,
            1.428_453_870_989_939_5e-1, 7.691_635_936_104_437_6e-2,
        ]),
        (-8.91e-05, 9.9e-06, [
            5.000_280_508_861_936_8e-1, 3.333_543_715_422_889_4e-1,
            1.428_676_620_010_078_2e-1, 7.692_908_787_368_186_6e-2,
        ]),
        (0.00891, 0.00099, [
            4.968_760_392_098_947_7e-1, 3.309_909_137_774_594_7e-1,
            1.416_864_226_333_163_1e-1, 7.625_423_372_830_484_6e-2,
        ]),
        (-0.00891, 0.00099, [
            5.028_138_817_041_725_9e-1, 3.354_441_893_630_641_1e-1,
            1.439_129_663_920_771_7e-1, 7.752_651_772_265_541_7e-2,
        ]),
        (0.02691, 0.00299, [
            4.906_318_537_565_618_4e-1, 3.263_122_077_279_214_3e-1,
            1.393_510_033_497_040_4e-1, 7.492_083_018_722_352_5e-2,
        ]),
        (-0.02691, 0.00299, [
            5.085_530_520_982_547_1e-1, 3.397_522_101_495_141_3e-1,
            1.460_702_199_619_390_8e-1, 7.876_016_226_791_088e-2,
        ]),
        (0.08991, 0.00999, [
            4.694_638_943_871_238_7e-1, 3.104_852_781_167_058_9e-1,
            1.314_808_839_628_548_1e-1, 7.043_592_504_732_727_2e-2,
        ]),
        (-0.08991, 0.00999, [
            5.292_282_082_802_646_3e-1, 3.553_013_538_069_821_1e-1,
            1.538_830_079_045_871_4e-1, 8.323_559_363_784_289e-2,
        ]),
        (0.26991, 0.02999, [
            4.144_582_352_512_704_4e-1, 2.696_250_394_257_963_3e-1,
            1.113_950_088_806_382e-1, 5.905_474_979_997_693_6e-2,
        ]),
        (-0.26991, 0.02999, [
            5.936_886_861_774_722_8e-1, 4.040_559_568_904_333_5e-1,
            1.786_297_015_865_511_1e-1, 9.748_393_825_931_120_6e-2,
        ]),
        (0.62991, 0.06999, [
            3.250_754_547_943_612_5e-1, 2.042_154_393_606_911_7e-1,
            8.007_689_208_804_249_4e-2, 4.153_644_003_267_851_3e-2,
        ]),
        (-0.62991, 0.06999, [
            7.506_133_868_273_476_2e-1, 5.242_010_938_519_655_5e-1,
            2.409_633_593_916_874_9e-1, 1.337_765_652_036_821_5e-1,
        ]),
    ];

    type Row = (f64, f64, [(f64, f64); 4]);

    #[rustfmt::skip]
    const COMPLEX_PSI: [Row; 9] = [
        (0.0, 1e-06, [
            (9.999_999_999_998_333_6e-1, -4.999_999_999_999_582_6e-7),
            (4.999_999_999_998_749_9e-1, -3.333_333_333_333e-7),
            (1.666_666_666_666_041_8e-1, -1.428_571_428_571_243_4e-7),
            (8.333_333_333_329_762_1e-2, -7.692_307_692_306_580_5e-8),
        ]),
        (0.0, 3.0, [
            (4.704_000_268_662_240_9e-2, -6.633_308_322_001_484_3e-1),
            (-1.740_702_747_134_270_9e-1, -3.456_774_997_623_559_6e-1),
            (-1.320_432_812_664_220_6e-1, -8.265_120_324_407_415_6e-2),
            (-7.596_703_882_565_440_7e-2, -2.944_833_483_581_279_7e-2),
        ]),
        (2.0, 5.0, [
            (4.394_274_324_150_480_2e-2, -1.747_450_022_607_616_2e-1),
            (-5.212_068_864_886_756_2e-2, -2.195_892_366_521_152_6e-2),
            (-1.239_209_808_701_212_7e-2, 2.073_410_610_884_652_8e-2),
            (-1.700_493_721_469_804e-3, 1.219_310_180_194_512_6e-2),
        ]),
        (0.0, 25.0, [
            (-5.294_070_003_910_920_7e-3, -3.518_875_254_610_560_7e-4),
            (-5.308_145_504_929_363_3e-3, 3.985_987_527_469_538e-2),
            (2.651_083_316_920_673_1e-3, 3.943_010_260_100_524_7e-2),
            (1.068_488_554_222_851_2e-2, 3.544_420_809_108_459_6e-2),
        ]),
        (0.0, 27.0, [
            (3.542_133_068_164_826e-2, -4.785_699_291_606_800_7e-2),
            (3.364_884_946_253_463e-2, -1.213_185_701_538_831_3e-2),
            (3.248_643_712_109_548_1e-2, -1.697_738_176_347_669_1e-2),
            (2.667_081_336_747_287e-2, -2.212_016_281_067_126_8e-2),
        ]),
        (10.0, 20.0, [
            (2.000_128_736_807_152_8e-2, -3.999_842_997_111_705e-2),
            (-1.198_624_083_411_723_6e-3, -1.598_450_065_262_255_2e-3),
            (2.638_811_081_545_867_3e-6, 1.046_133_517_438_193_4e-6),
            (2.177_933_355_620_582_4e-6, 8.442_420_362_408_146_6e-7),
        ]),
        (-50.0, 30.0, [
            (-3.343_887_454_834_038_4e19, 8.238_973_574_805_826_8e19),
            (-3.222_015_813_661_721_4e19, 8.147_317_088_013_100_6e19),
            (-2.784_160_865_302_602_5e19, 7.787_203_773_633_830_9e19),
            (-2.252_499_458_947_566e19, 7.275_104_948_621_846_1e19),
        ]),
        (-8.0, 3.0, [
            (-3.062_327_379_910_611_9e2, -1.674_213_786_413_297_4e2),
            (-2.794_437_274_704_516_2e2, -1.364_478_273_659_349_3e2),
            (-2.038_183_046_035_094_3e2, -7.554_825_175_995_728_2e1),
            (-1.442_666_361_922_833_3e2, -4.288_975_630_071_999_5e1),
        ]),
        (1.0, 500.0, [
            (-3.388_653_053_071_981_9e-4, -2.650_977_684_190_129_1e-3),
            (-3.481_685_789_237_051_9e-4, -6.503_185_601_267_479_3e-4),
            (-3.493_544_440_130_338_8e-4, -6.475_180_406_458_973_8e-4),
            (-3.570_471_618_575_175_5e-4, -6.431_870_542_391_115e-4),
        ]),
    ];

    #[test]
    fn the_moments_of_a_decay_keep_their_digits() {
        for (x, want) in PSI {
            let (twelve, six) = (decaying::<f64, 12>(x), decaying::<f64, 6>(x));
            let (two, one) = (decaying::<f64, 2>(x), decaying::<f64, 1>(x));
            for (k, want) in ORDERS.into_iter().zip(want) {
                for psi in [&twelve[..], &six[..], &two[..], &one[..]] {
                    let Some(got) = psi.get(k) else { continue };
                    // A recurrence of up to eleven steps of two roundings each.
                    assert!((got / want - 1.0).abs() < 3e-15, "ψ_{k}({x}) = {got:e}, not {want:e}");
                }
            }
        }
        assert_eq!(decaying::<f64, 3>(f64::INFINITY), [0.0; 3]);
    }

    #[test]
    fn the_moments_of_a_rise_keep_their_digits() {
        for (alpha, x, want) in CHI {
            let (twelve, two) = (rising::<f64, 12>(alpha, x), rising::<f64, 2>(alpha, x));
            for (k, want) in ORDERS.into_iter().zip(want) {
                for chi in [&twelve[..], &two[..]] {
                    let Some(got) = chi.get(k) else { continue };
                    // The difference of two decays loses a factor of five or less.
                    let off = (got / want - 1.0).abs();
                    assert!(off < 1e-14, "χ_{k}({alpha}, {x}) = {got:e}, not {want:e}: {off:e}");
                }
            }
        }
    }

    #[test]
    fn the_series_of_a_rise_has_as_many_terms_as_its_size_asks_for() {
        for (alpha, x, want) in CHI_OF_SERIES {
            let (twelve, two) = (rising::<f64, 12>(alpha, x), rising::<f64, 2>(alpha, x));
            for (k, want) in ORDERS.into_iter().zip(want) {
                for chi in [&twelve[..], &two[..]] {
                    let Some(got) = chi.get(k) else { continue };
                    // Two or three roundings of 1.1e-16 each, measured 4.4e-16 at most. One term
                    // less costs more, but for the sizes up to 0.3, where it is such a rounding.
                    let off = (got / want - 1.0).abs();
                    assert!(off < 5e-16, "χ_{k}({alpha}, {x}) = {got:e}, not {want:e}: {off:e}");
                }
            }
        }
    }

    #[test]
    fn the_moments_of_a_damped_wave_are_exact_to_rounding_of_their_size() {
        for (re, im, want) in COMPLEX_PSI {
            let got = complex_decaying::<f64, 12>(Complex::new(re, im));
            for (k, want) in ORDERS.into_iter().zip(want) {
                // Of the size of what a recurrence adds up, e⁻ˣ/x, or of the integral itself. The
                // argument of a wave is off by a rounding of its phase.
                let scale = got[k].modulus().max((-re).exp() / re.hypot(im).max(1.0));
                let off = (got[k] - Complex::new(want.0, want.1)).modulus() / scale;
                assert!(off < 2e-14, "ψ_{k}({re} + {im}i) = {}, off by {off:e}", got[k]);
            }
        }
    }

    #[test]
    fn the_complex_mean_decay_is_smooth_where_its_forms_meet() {
        for phase in [0.0, 0.7, 1.5, 2.0] {
            for size in [0.0, 1e-9, 0.1, 0.499_999, 0.500_001, 2.0] {
                let x = Complex::from_polar(size, phase);
                let (got, want) = (complex_phi1(x), complex_decaying::<f64, 1>(x)[0]);
                // The closed form loses a factor of two at ½.
                assert!((got - want).modulus() < 2e-15, "{x}");
            }
        }
    }
}
