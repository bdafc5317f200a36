//! Steady rolling against closed forms, quadrature in another program, and its own derivatives.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

mod common;

use bristle::rolling::{
    FunctionPressure, Motion, Patch, PatchParameters, PolynomialExponential,
    PolynomialExponentialParameters, Pressure, PressureKnot, RateDependent, Slip,
    TabulatedPressure, Trapezoidal, TrapezoidalParameters,
};
use bristle::{
    Bristle, Coulomb, CoulombParameters, Dahl, DahlParameters, FrBd, KelvinVoigt,
    KelvinVoigtParameters, LuGre, Rule, SquareRoot, Stribeck, paper,
};
use common::{assert_within, check};
use proptest::prelude::*;

const ROLLING_SPEED: f64 = 16.0;
const DAMPING: f64 = 0.3;

fn tyre_curve() -> Stribeck<f64> {
    Stribeck::new(paper::TYRE_CURVE).unwrap()
}

fn bristle(micro_damping: f64) -> KelvinVoigt<f64> {
    KelvinVoigt::new(KelvinVoigtParameters { micro_damping, ..paper::TYRE_BRISTLE }).unwrap()
}

fn frbd(damping: f64) -> FrBd<Stribeck<f64>, KelvinVoigt<f64>> {
    FrBd::new(tyre_curve(), bristle(damping))
}

fn patch<M, P: Pressure<f64>>(model: M, pressure: P) -> Patch<f64, M, P> {
    let length = paper::TYRE_LENGTH;
    Patch::new(PatchParameters { model, length, pressure }).unwrap().carrying(4000.0).unwrap()
}

fn exponential() -> PolynomialExponential<f64, 1> {
    PolynomialExponential::exponential(paper::TYRE_PRESSURE_DECAY).unwrap()
}

fn trapezoidal() -> Trapezoidal<f64> {
    Trapezoidal::new(TrapezoidalParameters { rising_part: 0.125, falling_part: 0.25, plateau: 3.0 })
        .unwrap()
}

fn at(slip: f64) -> Slip<f64> {
    Slip { slip, rolling_speed: ROLLING_SPEED }
}

#[test]
fn the_tyre_has_the_force_of_the_paper_at_two_slips() {
    // Romano et al., table 1 with L V = 16 m/s, by quadrature with mpmath.
    let constant = patch(frbd(0.0), PolynomialExponential::constant());
    let exponential = patch(frbd(0.0), exponential());
    for (slip, c, e) in [(0.05, 0.348_954, 0.344_852), (1.0, 0.257_045, 0.256_912)] {
        // Half of the last printed digit.
        assert!((constant.force_ratio(at(slip)).unwrap() - c).abs() <= 5e-7);
        assert!((exponential.force_ratio(at(slip)).unwrap() - e).abs() <= 5e-7);
    }
}

const SLIPS: [f64; 10] = [1e-12, 1e-9, 1e-6, 1e-3, 0.03, 0.05, 0.3, 1.0, 30.0, 1000.0];

/// F/F_z at [`SLIPS`] for Table 1 with L V = 16 m/s and σ1 = 0 ("frbd0") or 0.3 s/m: ∫ p (c₀ z + c₂ v) dξ by
/// mpmath's Gauss–Legendre quadrature with 40 digits on panels graded in 1/κ, from the double-precision
/// values of all parameters.
#[rustfmt::skip]
const FORCES: [(&str, &str, [f64; 10]); 16] = [
    ("frbd0", "constant", [
        1.259_999_999_982_359_9e-11,
        1.259_999_982_360_000_2e-8,
        1.259_982_360_186_065_0e-5,
        1.242_544_474_620_910_6e-2,
        2.588_745_807_332_033_5e-1,
        3.489_541_600_590_515_5e-1,
        4.896_835_821_622_917_4e-1,
        2.570_450_920_759_729_8e-1,
        1.062_502_518_518_518_4,
        2.896_662_698_412_698_2e1,
    ]),
    ("frbd0", "exponential", [
        1.239_003_499_149_674_4e-11,
        1.239_003_481_966_332_1e-8,
        1.238_986_298_804_261_6e-5,
        1.221_981_937_061_347_5e-2,
        2.553_776_874_949_775_8e-1,
        3.448_515_447_519_687_2e-1,
        4.880_871_324_913_173_5e-1,
        2.569_119_176_556_454_2e-1,
        1.062_426_618_190_065_2,
        2.896_493_456_242_910_0e1,
    ]),
    ("frbd0", "parabolic", [
        1.259_999_999_984_124_0e-11,
        1.259_999_984_124_000_3e-8,
        1.259_984_124_148_936_9e-5,
        1.244_271_792_997_221_1e-2,
        2.675_727_277_465_182_5e-1,
        3.656_427_742_887_377_0e-1,
        5.131_511_931_146_755_0e-1,
        2.595_597_785_400_573_0e-1,
        1.063_987_390_195_279_9,
        2.899_977_009_763_239_3e1,
    ]),
    ("frbd0", "trapezoidal", [
        1.187_307_692_292_861_5e-11,
        1.187_307_677_476_947_4e-8,
        1.187_292_861_702_292_7e-5,
        1.172_615_660_105_459_0e-2,
        2.531_429_844_523_798_2e-1,
        3.470_572_864_839_411_3e-1,
        5.053_792_921_032_930_2e-1,
        2.594_502_592_035_072_3e-1,
        1.063_979_248_575_709_6,
        2.899_962_185_398_375_8e1,
    ]),
    ("frbd", "constant", [
        1.739_999_999_958_359_8e-11,
        1.739_999_958_360_001_0e-8,
        1.739_958_360_883_201_4e-5,
        1.699_226_289_923_788_7e-2,
        2.961_747_863_582_587_8e-1,
        3.776_210_686_158_463_2e-1,
        4.904_674_273_655_389_4e-1,
        2.570_634_831_965_952_2e-1,
        1.062_510_685_073_110_1,
        2.896_680_771_900_790_0e1,
    ]),
    ("frbd", "exponential", [
        1.719_003_499_126_010_2e-11,
        1.719_003_458_302_276_8e-8,
        1.718_962_635_430_817_3e-5,
        1.678_985_484_255_876_6e-2,
        2.936_417_365_942_745_6e-1,
        3.749_442_602_883_080_2e-1,
        4.895_234_464_446_994_7e-1,
        2.569_815_302_442_718_9e-1,
        1.062_463_641_972_921_4,
        2.896_575_853_471_740_6e1,
    ]),
    ("frbd", "parabolic", [
        1.739_999_999_960_124_0e-11,
        1.739_999_960_124_001_0e-8,
        1.739_960_124_803_739_1e-5,
        1.700_913_089_313_331_1e-2,
        3.012_777_108_008_988_8e-1,
        3.855_175_678_827_622_0e-1,
        4.970_294_504_551_511_2e-1,
        2.577_610_503_461_919_6e-1,
        1.062_924_571_693_724_1,
        2.897_604_738_121_071_6e1,
    ]),
    ("frbd", "trapezoidal", [
        1.667_307_692_270_024_5e-11,
        1.667_307_654_640_024_9e-8,
        1.667_270_025_394_919_9e-5,
        1.630_381_766_333_753_2e-2,
        2.911_404_217_096_348_3e-1,
        3.741_497_210_822_031_2e-1,
        4.921_393_565_283_713_2e-1,
        2.573_144_317_508_300_2e-1,
        1.062_666_318_494_141_2,
        2.897_028_646_830_769_5e1,
    ]),
    ("classical", "constant", [
        1.742_879_999_972_280_1e-11,
        1.742_879_972_280_000_4e-8,
        1.742_852_280_326_336_8e-5,
        1.715_483_279_367_802_4e-2,
        3.414_168_849_184_008_9e-1,
        4.499_684_297_161_967_7e-1,
        5.894_836_117_151_698_3e-1,
        3.015_909_509_200_582_8e-1,
        1.102_042_328_042_327_9,
        2.903_809_365_079_364_8e1,
    ]),
    ("classical", "exponential", [
        1.721_883_499_139_762_5e-11,
        1.721_883_472_054_304_3e-8,
        1.721_856_386_913_045_5e-5,
        1.695_085_262_794_881_0e-2,
        3.387_626_398_207_739_3e-1,
        4.475_187_980_316_930_3e-1,
        5.922_427_245_976_676_9e-1,
        3.036_790_083_267_977_3e-1,
        1.103_975_083_560_187_6,
        2.904_003_004_098_292_7e1,
    ]),
    ("classical", "parabolic", [
        1.742_879_999_974_044_0e-11,
        1.742_879_974_044_000_4e-8,
        1.742_854_044_275_181_6e-5,
        1.717_196_859_699_618_4e-2,
        3.480_283_259_935_942_3e-1,
        4.599_555_509_959_129_5e-1,
        5.487_214_864_978_167_1e-1,
        2.619_817_261_654_446_8e-1,
        1.064_060_352_698_137_1,
        2.900_000_181_395_457_6e1,
    ]),
    ("classical", "trapezoidal", [
        1.670_187_692_283_363_2e-11,
        1.670_187_667_978_485_9e-8,
        1.670_163_363_358_687_2e-5,
        1.646_114_025_760_762_5e-2,
        3.370_732_934_961_419_6e-1,
        4.488_527_590_698_049_9e-1,
        5.620_466_992_960_618_8e-1,
        2.634_995_645_534_509_7e-1,
        1.064_099_092_755_177_4,
        2.900_000_297_679_322_3e1,
    ]),
    ("inside", "constant", [
        1.739_999_999_972_280_0e-11,
        1.739_999_972_280_000_5e-8,
        1.739_972_280_327_667_4e-5,
        1.712_604_578_974_867_6e-2,
        3.407_388_261_878_849_8e-1,
        4.491_133_651_111_989_8e-1,
        5.899_361_606_072_628_4e-1,
        3.065_159_294_430_815_4e-1,
        1.265_169_185_185_185_2,
        3.449_043_650_793_650_8e1,
    ]),
    ("inside", "exponential", [
        1.719_003_499_139_762_4e-11,
        1.719_003_472_054_304_4e-8,
        1.718_976_386_914_346_6e-5,
        1.692_206_534_100_865_9e-2,
        3.380_812_664_188_093_7e-1,
        4.466_548_425_004_479_6e-1,
        5.927_075_096_704_953_5e-1,
        3.088_439_923_191_883_5e-1,
        1.275_365_509_760_174_2,
        3.476_886_905_692_254_0e1,
    ]),
    ("inside", "parabolic", [
        1.739_999_999_974_043_9e-11,
        1.739_999_974_044_000_5e-8,
        1.739_974_044_276_427_6e-5,
        1.714_318_079_443_844_7e-2,
        3.473_492_211_851_940_1e-1,
        4.591_141_408_005_380_8e-1,
        5.491_976_751_970_110_1e-1,
        2.625_559_243_033_293_0e-1,
        1.065_693_980_307_762_7,
        2.903_782_290_330_492_8e1,
    ]),
    ("inside", "trapezoidal", [
        1.667_307_692_283_363_1e-11,
        1.667_307_667_978_486_0e-8,
        1.667_283_363_359_854_8e-5,
        1.643_235_169_078_833_8e-2,
        3.363_829_426_504_657_5e-1,
        4.479_766_495_712_130_8e-1,
        5.626_892_690_624_687_4e-1,
        2.644_704_654_067_245_9e-1,
        1.066_787_712_013_506_3,
        2.906_221_153_943_058_5e1,
    ]),
];

#[test]
fn the_closed_form_is_the_quadrature_from_no_slip_to_full_sliding() {
    fn model<M: RateDependent<f64>>(name: &str, model: M) -> usize {
        let mut seen = 0;
        for (_, pressure, forces) in FORCES.iter().filter(|row| row.0 == name) {
            for (&slip, &want) in SLIPS.iter().zip(forces) {
                let got = match *pressure {
                    "constant" => ratio(&model, PolynomialExponential::constant(), slip),
                    "exponential" => ratio(&model, exponential(), slip),
                    "parabolic" => ratio(&model, PolynomialExponential::parabolic(), slip),
                    _ => ratio(&model, trapezoidal(), slip),
                };
                // The issue of every digit; measured 2e-15 at most.
                assert_within(1e-14, want, got, want, || format!("{name} {pressure} {slip:e}"));
                seen += 1;
            }
        }
        seen
    }
    fn ratio<M: RateDependent<f64>, P: Pressure<f64>>(model: &M, pressure: P, slip: f64) -> f64 {
        let patch = patch(model.clone(), pressure);
        let ratio = patch.force_ratio(at(slip)).unwrap();
        let force = patch.steady(patch.motion_at(at(slip))).unwrap().force;
        assert_within(1e-15, force, force, ratio * 4000.0, || format!("force at {slip:e}"));
        let mirrored = patch.force_ratio(at(-slip)).unwrap();
        assert_eq!(mirrored, -ratio, "at the slip −{slip:e}");
        ratio
    }
    let seen = model("frbd0", frbd(0.0))
        + model("frbd", frbd(DAMPING))
        + model("classical", LuGre::classical(tyre_curve(), bristle(DAMPING)))
        + model("inside", LuGre::with_viscous_part_inside(tyre_curve(), bristle(DAMPING)));
    assert_eq!(seen, 160);
}
