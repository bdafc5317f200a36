//! Steady rolling against closed forms, quadrature in another program, and its own derivatives.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

use crate::tyre::{LENGTH, bristle, curve as tyre_curve, frbd, loaded as patch, motion, table};
use bristle::curve::{Coulomb, CoulombParameters, Knot, Tabulated};
use bristle::regularisation::SquareRoot;
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::signal::Function;
use bristle::{Bristle, Dahl, DahlParameters, FrBd, LuGre, Rule, paper};
use bristle_rolling::{
    FunctionPressure, Motion, Patch, PatchParameters, PolynomialExponential,
    PolynomialExponentialParameters, Pressure,
};
use bristle_specimens::{assert_within, check};

const ROLLING_SPEED: f64 = 16.0;
const DAMPING: f64 = 0.3;

fn exponential() -> PolynomialExponential<f64, 1> {
    PolynomialExponential::exponential(bristle_rolling::TYRE_PRESSURE_DECAY).unwrap()
}

fn trapezoidal() -> impl Pressure<f64> + Copy {
    table([(0.0, 0.0), (0.125, 3.0), (0.75, 3.0), (1.0, 0.0)])
}

/// The motion at a slip ratio.
fn at(slip_ratio: f64) -> Motion<f64> {
    Motion { slip_velocity: slip_ratio * ROLLING_SPEED, rolling_speed: ROLLING_SPEED }
}

/// F/F_z in steady rolling.
fn force_ratio<M: Bristle<f64, Deflection = f64>, P: Pressure<f64>>(
    patch: &Patch<f64, M, P>,
    motion: Motion<f64>,
) -> f64 {
    patch.steady(motion).unwrap().force / patch.normal_force()
}

#[test]
fn the_tyre_has_the_force_of_the_paper_at_two_slips() {
    // Romano et al., table 1 with L V = 16 m/s, by quadrature with mpmath.
    let constant = patch(frbd(0.0), PolynomialExponential::constant());
    let exponential = patch(frbd(0.0), exponential());
    for (slip, c, e) in [(0.05, 0.348_954, 0.344_852), (1.0, 0.257_045, 0.256_912)] {
        // Half of the last printed digit.
        assert!((force_ratio(&constant, at(slip)) - c).abs() <= 5e-7);
        assert!((force_ratio(&exponential, at(slip)) - e).abs() <= 5e-7);
    }
}

const SLIPS: [f64; 10] = [1e-12, 1e-9, 1e-6, 1e-3, 0.03, 0.05, 0.3, 1.0, 30.0, 1000.0];

/// F/F_z at [`SLIPS`] for Table 1 with L V = 16 m/s and σ1 = 0 ("frbd0") or 0.3 s/m: ∫ p (c₀ z +
/// c₂ v) dξ by mpmath's Gauss–Legendre quadrature with 40 digits on panels graded in 1/κ, from the
/// double-precision values of all parameters.
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
    fn model<M: Bristle<f64, Deflection = f64>>(name: &str, model: M) -> usize {
        let mut seen = 0;
        for (_, pressure, forces) in FORCES.iter().filter(|row| row.0 == name) {
            for (&slip, &want) in SLIPS.iter().zip(forces) {
                let got = match *pressure {
                    "constant" => ratio(&model, PolynomialExponential::constant(), slip),
                    "exponential" => ratio(&model, exponential(), slip),
                    "parabolic" => ratio(&model, PolynomialExponential::parabolic(), slip),
                    _ => ratio(&model, trapezoidal(), slip),
                };
                // Measured 9e-16 at most.
                assert_within(1e-14, want, got, want, || format!("{name} {pressure} {slip:e}"));
                seen += 1;
            }
        }
        seen
    }
    fn ratio<M: Bristle<f64, Deflection = f64>, P: Pressure<f64>>(
        model: &M,
        pressure: P,
        slip: f64,
    ) -> f64 {
        let patch = patch(model.clone(), pressure);
        let ratio = force_ratio(&patch, at(slip));
        assert_eq!(force_ratio(&patch, at(-slip)), -ratio, "at the slip −{slip:e}");
        ratio
    }
    let seen = model("frbd0", frbd(0.0))
        + model("frbd", frbd(DAMPING))
        + model("classical", LuGre::classical(tyre_curve(), bristle(DAMPING)))
        + model(
            "inside",
            LuGre::with_viscous_friction(tyre_curve(), bristle(DAMPING), 0.0).unwrap(),
        );
    assert_eq!(seen, 160);
}

/// Checks slopes against central differences of the force.
fn check_slopes<M: Bristle<f64, Deflection = f64>, P: Pressure<f64>>(
    model: M,
    pressure: P,
    name: &str,
) {
    let patch = patch(model, pressure);
    for (v, transport) in [(-3.0, 40.0), (1e-3, 160.0), (0.4, 160.0), (2.0, 160.0), (30.0, 5.0)] {
        let force = |v: f64, transport: f64| {
            patch
                .steady(Motion { slip_velocity: v, rolling_speed: LENGTH * transport })
                .unwrap()
                .force
        };
        let about = patch.linearised(motion(v, transport)).unwrap();
        let [by_slip, by_speed] = [about.by_slip_velocity(0.0), about.by_rolling_speed(0.0)];
        assert_eq!((by_slip.im, by_speed.im), (0.0, 0.0));
        // Third order in a step of 1e-5, beside a rounding of the force over it.
        let (dv, dt) = (1e-5 * v, 1e-5 * transport);
        let by_v = (force(v + dv, transport) - force(v - dv, transport)) / (2.0 * dv);
        let by_t = (force(v, transport + dt) - force(v, transport - dt)) / (2.0 * dt);
        let size = force(v, transport).abs();
        let name = |what| move || format!("{name} {what} at v = {v}, V = {transport}");
        assert_within(1e-9, size / v.abs(), by_slip.re, by_v, name("∂F/∂v"));
        assert_within(1e-9, size / transport, by_speed.re * LENGTH, by_t, name("∂F/∂V"));
    }
}

#[test]
fn the_slopes_are_those_of_the_force() {
    check_slopes(frbd(0.0), PolynomialExponential::constant(), "FrBD");
    check_slopes(frbd(DAMPING), PolynomialExponential::parabolic(), "damped FrBD");
    check_slopes(frbd(DAMPING), trapezoidal(), "damped FrBD, trapezoidal");
    check_slopes(LuGre::classical(tyre_curve(), bristle(DAMPING)), exponential(), "LuGre");
    check_slopes(
        LuGre::with_viscous_friction(tyre_curve(), bristle(DAMPING), 0.0).unwrap(),
        PolynomialExponential::parabolic(),
        "LuGre, viscous part inside",
    );
    check_slopes(dahl(), trapezoidal(), "Dahl");
    let regularised = frbd(DAMPING).regularised(SquareRoot::new(1e-2).unwrap());
    check_slopes(regularised, exponential(), "regularised");
}

fn dahl() -> Dahl<f64> {
    Dahl::new(DahlParameters { dynamic_coefficient: 0.4, micro_stiffness: 252.0 }).unwrap()
}

#[test]
fn slip_stiffness_is_that_of_the_springs_and_the_dashpots() {
    // L² (σ0 ∫ p ξ dξ + c₂ V ∫ p dξ) with ∫ p dξ = F_z/L and ∫ p ξ dξ = F_z/(2 L) for symmetric
    // pressure.
    let (load, length) = (4000.0, bristle_rolling::TYRE_LENGTH);
    for (damping, speed) in [(0.0, 1.0), (0.0, 16.0), (0.3, 16.0)] {
        let springs = load * length * 252.0 / 2.0;
        let want = springs + load * damping * speed;
        let parabola = patch(frbd(damping), PolynomialExponential::parabolic());
        let constant = patch(frbd(damping), PolynomialExponential::constant());
        for got in [parabola.slip_stiffness(speed), constant.slip_stiffness(speed)] {
            assert_within(1e-14, want, got.unwrap(), want, || format!("σ1 = {damping}"));
        }
        // The viscous friction of the classical model acts from rest on.
        let lugre = LuGre::classical(tyre_curve(), bristle(damping));
        let got = patch(lugre, PolynomialExponential::constant()).slip_stiffness(speed).unwrap();
        assert_within(1e-14, want, got, want + load * 0.0018 * speed, || "LuGre".into());
        // It is the limit of force over slip.
        let small = Motion { slip_velocity: 1e-9 * speed, rolling_speed: speed };
        let secant = parabola.steady(small).unwrap().force / 1e-9;
        // The curvature σ0 L/(μ) of 40 or so, times the slip.
        assert_within(1e-7, want, secant, want, || format!("secant, σ1 = {damping}"));
    }
}

#[test]
fn one_sided_slopes_meet_at_rest() {
    for damping in [0.0, 0.3] {
        let patch = patch(frbd(damping), exponential());
        let slope = |v| {
            let motion = Motion { slip_velocity: v, rolling_speed: 16.0 };
            patch.linearised(motion).unwrap().by_slip_velocity(0.0).re
        };
        let want = slope(0.0);
        for v in [1e-12, -1e-12] {
            // Linear in v, by κ of 1e-12.
            assert_within(1e-10, want, slope(v), want, || format!("σ1 = {damping}, v = {v}"));
        }
    }
}

#[test]
fn without_rolling_the_patch_slides_and_without_slip_there_is_no_force() {
    for damping in [0.0, 0.3] {
        let patch = patch(frbd(damping), PolynomialExponential::parabolic());
        for v in [1e-9, 0.5, -20.0] {
            let locked = Motion { slip_velocity: v, rolling_speed: 0.0 };
            let steady = patch.steady(locked).unwrap();
            let want = 4000.0 * frbd(damping).stationary_coefficient(v);
            assert_within(1e-15, want.abs(), steady.force, want, || format!("locked at {v}"));
            assert_eq!(steady.deflection(0.5), frbd(damping).stationary(v));
            assert_eq!(patch.pneumatic_trail(locked).unwrap().map(|x| x.abs() < 1e-16), Some(true));
            // The limit of slow rolling, which leaves its mark at the inlet: about V μ/(σ0 |v|) =
            // 1e-6.
            let slow = Motion { slip_velocity: v, rolling_speed: 1e-5 * v.abs() };
            assert_within(1e-5, want.abs(), patch.steady(slow).unwrap().force, want, || {
                "slow".into()
            });
            let barely = Motion { slip_velocity: v, rolling_speed: 1e-100 };
            assert_within(1e-15, want.abs(), patch.steady(barely).unwrap().force, want, || {
                "barely".into()
            });
        }
        for rolling_speed in [0.0, 1e-90, 16.0] {
            let still = Motion { slip_velocity: 0.0, rolling_speed };
            let steady = patch.steady(still).unwrap();
            assert_eq!(
                (steady.force, steady.deflection(1.0), steady.coefficient(0.3)),
                (0.0, 0.0, 0.0)
            );
        }
        let still = Motion { slip_velocity: 0.0, rolling_speed: 0.0 };
        assert_eq!(patch.pneumatic_trail(still).unwrap(), None);
    }
}

#[test]
fn the_profile_solves_its_equation() {
    // V z' = −λ z + r v, by the difference of neighbours.
    let patch = patch(frbd(0.3), exponential());
    let motion = at(0.05);
    let (steady, affine) = (patch.steady(motion).unwrap(), frbd(0.3).affine((0.8).into(), 0.0));
    for place in [0.1, 0.5, 0.9] {
        let (h, z) = (1e-5, steady.deflection(place));
        let slope = (steady.deflection(place + h) - steady.deflection(place - h)) / (2.0 * h);
        let want = (affine.drive * 0.8 - affine.relaxation * z) / (motion.rolling_speed / LENGTH);
        assert_within(1e-9, want, slope, want, || format!("z' at {place}"));
        let coefficient = affine.stiffness * z + affine.damping * 0.8;
        assert_within(1e-14, 1.0, steady.coefficient(place), coefficient, || "μ_b".into());
    }
}

#[test]
fn the_peak_is_the_highest_force() {
    fn peak<M: Bristle<f64, Deflection = f64>, P: Pressure<f64>>(model: M, pressure: P) {
        let patch = patch(model, pressure);
        let up_to = at(0.9);
        let peak = patch.peak(up_to).unwrap().unwrap();
        let force_at = |motion| patch.steady(motion).unwrap().force;
        let height = force_at(peak);
        // Twenty thousand slips around it: parabolic within, so that none is higher by rounding.
        for i in 1..=20_000 {
            let slip = 0.9 * f64::from(i) / 20_000.0;
            let force = force_at(at(slip));
            assert!(force <= height * (1.0 + 1e-14), "{slip}: {force} > {}", height);
        }
        let slope = patch.linearised(peak).unwrap().by_slip_velocity(0.0).re;
        // F'' is about F/slip²: the place to eleven digits.
        assert!(slope.abs() * peak.slip_velocity < 1e-11 * height);
        let mirrored = patch.peak(at(-0.9)).unwrap().unwrap();
        assert_eq!((mirrored.slip_velocity, force_at(mirrored)), (-peak.slip_velocity, -height));
    }
    peak(frbd(0.0), PolynomialExponential::constant());
    peak(frbd(0.3), PolynomialExponential::parabolic());
    peak(frbd(0.01), trapezoidal());
    peak(LuGre::classical(tyre_curve(), bristle(0.01)), exponential());
    peak(LuGre::with_viscous_friction(tyre_curve(), bristle(0.01), 0.0).unwrap(), exponential());
}

#[test]
fn a_force_that_only_grows_has_no_peak() {
    let coulomb = |viscous_friction| {
        let curve =
            Coulomb::new(CoulombParameters { dynamic_coefficient: 0.4, viscous_friction }).unwrap();
        FrBd::new(curve, bristle(0.0))
    };
    for up_to in [1e-6, 1e-2, 1.0, 1e6, 1e20] {
        for viscous in [0.0, 0.01] {
            let constant = patch(coulomb(viscous), PolynomialExponential::constant());
            let parabola = patch(coulomb(viscous), PolynomialExponential::parabolic());
            assert_eq!(constant.peak(at(up_to)).unwrap(), None, "{up_to} {viscous}");
            assert_eq!(parabola.peak(at(up_to)).unwrap(), None, "{up_to} {viscous}");
        }
        assert_eq!(patch(dahl(), exponential()).peak(at(up_to)).unwrap(), None, "{up_to}");
        assert_eq!(patch(dahl(), trapezoidal()).peak(at(up_to)).unwrap(), None, "{up_to}");
        let curve = *coulomb(0.0).curve();
        let lugre = patch(LuGre::classical(curve, bristle(1e-3)), exponential());
        let damped = patch(FrBd::new(curve, bristle(1e-3)), exponential());
        assert_eq!(damped.peak(at(up_to)).unwrap(), None, "{up_to}");
        if let Some(peak) = lugre.peak(at(up_to)).unwrap() {
            // LuGre's damping lifts the force above the curve: a peak of its own.
            let force = lugre.steady(peak).unwrap().force;
            assert!(force > 0.4 * 4000.0, "{peak:?} {up_to}");
        }
    }
    // Before its peak a tyre's force only grows too.
    assert_eq!(patch(frbd(0.0), exponential()).peak(at(0.05)).unwrap(), None);
}

#[test]
fn the_trail_is_that_of_the_brush_model_and_vanishes_in_sliding() {
    // Of z = v ξ/V: L (∫ p ξ²/∫ p ξ − ½), a sixth of the length for constant pressure, a tenth for
    // a parabola.
    let constant = patch(frbd(0.0), PolynomialExponential::constant());
    let parabola = patch(frbd(0.0), PolynomialExponential::parabolic());
    for slip in [0.0, 1e-12] {
        let trail = |motion| constant.pneumatic_trail(motion).unwrap().unwrap();
        // The terms of ξ − ½ cancel to a sixth.
        assert_within(1e-10, 0.1, trail(at(slip)), 0.1 / 6.0, || "constant".into());
        let trail = parabola.pneumatic_trail(at(slip)).unwrap().unwrap();
        assert_within(1e-10, 0.1, trail, 0.01, || "parabola".into());
    }
    // The dashpot adds σ1 v to σ0 z, without a moment: L/10/(1 + 2 σ1 U/(σ0 L)).
    let damped = patch(frbd(DAMPING), PolynomialExponential::parabolic());
    let spring = paper::TYRE_BRISTLE.micro_stiffness * bristle_rolling::TYRE_LENGTH;
    let want = 0.01 / (1.0 + 2.0 * DAMPING * ROLLING_SPEED / spring);
    let got = damped.pneumatic_trail(at(0.0)).unwrap().unwrap();
    assert_within(1e-10, 0.1, got, want, || "parabola with a dashpot".into());
    // In between, by quadrature of p and z with the stationary values of the model.
    for slip in [1e-3, 0.05, 0.3] {
        let v = slip * ROLLING_SPEED;
        let kappa = frbd(0.0).affine(v.into(), 0.0).relaxation
            / (ROLLING_SPEED / bristle_rolling::TYRE_LENGTH);
        let part = |power: i32| {
            bristle_specimens::integral(0.0, 1.0, 400, |x| {
                6.0 * x * (1.0 - x) * (x - 0.5).powi(power) * -(-kappa * x).exp_m1()
            })
        };
        let want = bristle_rolling::TYRE_LENGTH * part(1) / part(0);
        let got = parabola.pneumatic_trail(at(slip)).unwrap().unwrap();
        // Some hundred roundings of a sum that is ten times the moment.
        assert_within(1e-13, 0.01, got, want, || format!("trail at {slip}"));
        assert!(got > 0.0 && got < 0.01, "{slip}: {got}");
    }
}

#[test]
fn the_moment_of_a_sliding_patch_is_that_of_its_boundary_layer() {
    // Without a dashpot μ_b = μ_ss (1 − e^(−κξ)), and for κ ≥ 1e3, where e^(−κ) is nothing, the
    // moment is L F_z μ_ss times −∫ p (ξ − ½) e^(−κξ) dξ: 1/(2κ) − 1/κ² for p = 1, and 3/κ² −
    // 18/κ³ + 36/κ⁴ for p = 6 ξ (1 − ξ).
    let constant = patch(frbd(0.0), PolynomialExponential::constant());
    let parabola = patch(frbd(0.0), PolynomialExponential::parabolic());
    for kappa in [1e3_f64, 1e4, 1e5, 1e6] {
        for v in [-2.0, 7.0] {
            let affine = frbd(0.0).affine(v.into(), 0.0);
            let motion = motion(v, affine.relaxation / kappa);
            let coefficient = frbd(0.0).stationary_coefficient(v);
            let unit = bristle_rolling::TYRE_LENGTH * 4000.0 * coefficient.abs();
            let k = kappa.recip();
            let flat = (0.5 * k - k * k, 1.0 - k);
            let arch =
                (k * k * (3.0 - 18.0 * k + 36.0 * k * k), 1.0 - 6.0 * k * k + 12.0 * k * k * k);
            for (trail, steady, (moment, force)) in [
                (constant.pneumatic_trail(motion), constant.steady(motion), flat),
                (parabola.pneumatic_trail(motion), parabola.steady(motion), arch),
            ] {
                let trail = trail.unwrap().unwrap();
                let turning = steady.unwrap().force * trail;
                // The halves of the patch before and behind its middle cancel to this: roundings
                // of an eighth.
                let want = unit * coefficient.signum() * moment;
                assert_within(1e-16, unit, turning, want, || format!("moment at κ = {kappa}"));
                let want = bristle_rolling::TYRE_LENGTH * moment / force;
                assert_within(1e-16, bristle_rolling::TYRE_LENGTH, trail, want, || {
                    format!("trail, {kappa}")
                });
            }
        }
    }
}

#[test]
fn of_two_maxima_the_peak_is_the_higher_one() {
    // Friction with two humps; the force follows it, a little behind.
    let humps = |first, second| {
        let knots = [
            (0.0, 0.2),
            (1.0, 0.3),
            (2.0, first),
            (4.0, 0.3),
            (8.0, second),
            (16.0, 0.2),
            (32.0, 0.2),
        ];
        let curve =
            Tabulated::new(knots.map(|(speed, coefficient)| Knot { speed, coefficient })).unwrap();
        patch(FrBd::new(curve, bristle(0.0)), PolynomialExponential::constant())
    };
    for (first, second) in [(0.8, 0.6), (0.5, 0.9)] {
        let patch = humps(first, second);
        let best = |from: f64, to: f64| {
            (0..=20_000)
                .map(|number| from + (to - from) * f64::from(number) / 2e4)
                .map(|v| (patch.steady(at(v / ROLLING_SPEED)).unwrap().force, v))
                .fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a })
        };
        let (low, high) = (best(0.1, 5.0), best(5.0, 20.0));
        let want = if low.0 > high.0 { low } else { high };
        assert_eq!(low.0 > high.0, first > second);
        for sign in [1.0, -1.0] {
            let peak = patch.peak(at(sign * 2.0)).unwrap().unwrap();
            // The scan misses the place by 7e-4 m/s and the force, whose curvature is about 1e4,
            // by half the square of that.
            let v = peak.slip_velocity * sign;
            assert!((v - want.1).abs() < 1e-3, "{peak:?} {want:?}");
            let force = patch.steady(peak).unwrap().force * sign;
            assert!(force >= want.0 && force < want.0 + 5e-3, "{peak:?} {want:?}");
        }
    }
}

#[test]
fn a_pressure_has_the_same_integrals_in_every_form() {
    fn same<P: Pressure<f64>, Q: Pressure<f64>>(a: &P, b: &Q) {
        let total = b.total();
        let near = |got: f64, want: f64, what: &str, x: f64| {
            // Up to a thousand terms of a quadrature.
            assert_within(1e-14, want.abs(), got, want, || format!("{what}({x}) of {a:?}, {b:?}"));
        };
        near(a.total(), total, "P", 0.0);
        for kappa in [1e-12, 1e-3, 0.4, 0.9, 1.1, 3.0, 40.0, 200.0, 1e5] {
            near(a.rise(kappa), b.rise(kappa), "R", kappa);
            near(a.remaining(kappa), b.remaining(kappa), "P − R", kappa);
            near(a.lever(kappa), b.lever(kappa), "R'", kappa);
            for theta in [0.0, 1e-6, 0.3, 2.0, 30.0, 1000.0] {
                let s = nalgebra::Complex::new(kappa, theta);
                // To rounding of the whole, times that of the phase.
                let close = |got: nalgebra::Complex<f64>,
                             want: nalgebra::Complex<f64>,
                             scale: f64,
                             what| {
                    let off = (got - want).norm() / scale;
                    assert!(off < 3e-14, "{what}({s}) of {a:?}: off by {off:e}");
                };
                close(a.transform(s), b.transform(s), total, "P");
                let scale =
                    b.transform_slope(kappa, s).norm().max(0.1 * total / s.norm_sqr().max(1.0));
                close(a.transform_slope(kappa, s), b.transform_slope(kappa, s), scale, "Q");
                let (got, want) = (a.transform_slope(0.0, s), b.transform_slope(0.0, s));
                close(got, want, want.norm(), "Q");
            }
        }
        assert_eq!((a.rise(f64::INFINITY), a.remaining(f64::INFINITY)), (a.total(), 0.0));
        assert_eq!(a.lever(f64::INFINITY), 0.0);
        for i in 0..=20 {
            let place = f64::from(i) / 20.0;
            let (got, want) = (a.at_and_slope(place), b.at_and_slope(place));
            assert_within(1e-14, 6.0, got.0, want.0, || format!("p({place})"));
            assert_within(1e-14, 24.0, got.1, want.1, || format!("p'({place})"));
        }
    }
    let arch = |x: f64| (6.0 * x * (1.0 - x), 6.0 - 12.0 * x);
    same(
        &FunctionPressure::new(Function::new(arch, [])).unwrap(),
        &PolynomialExponential::parabolic(),
    );
    same(
        &FunctionPressure::new(Function::new(arch, [0.25, 0.7])).unwrap(),
        &PolynomialExponential::parabolic(),
    );
    let steep = PolynomialExponentialParameters { coefficients: [1.0, 2.0], decay: 8.0 };
    let falling = |x: f64| {
        let weight = (-8.0 * x).exp();
        (weight * (1.0 + 2.0 * x), weight * (2.0 - 8.0 * (1.0 + 2.0 * x)))
    };
    let steep = PolynomialExponential::new(steep).unwrap();
    same(&FunctionPressure::new(Function::new(falling, [])).unwrap(), &steep);
    let piecewise = |x: f64| match x {
        x if x < 0.125 => (24.0 * x, 24.0),
        x if x < 0.75 => (3.0, 0.0),
        x => (12.0 * (1.0 - x), -12.0),
    };
    same(&FunctionPressure::new(Function::new(piecewise, [0.125, 0.75])).unwrap(), &trapezoidal());
    same(
        &FunctionPressure::new(Function::new(|_| (1.0, 0.0), [])).unwrap(),
        &PolynomialExponential::constant(),
    );
    let wedge = PolynomialExponentialParameters { coefficients: [2.0, -2.0], decay: 0.0 };
    let ramp = FunctionPressure::new(Function::new(|x| (2.0 - 2.0 * x, -2.0), [])).unwrap();
    same(&ramp, &PolynomialExponential::new(wedge).unwrap());
}

#[test]
fn force_and_slip_are_odd_and_bounded_by_the_curve() {
    check(200, (-12.0..3.0_f64, 0.0..0.5_f64, 0.01..100.0_f64), |(exponent, damping, speed)| {
        let patch = patch(frbd(damping), PolynomialExponential::parabolic());
        let v = 10.0_f64.powf(exponent) * speed;
        let motion = |slip_velocity| Motion { slip_velocity, rolling_speed: speed };
        let ratio = force_ratio(&patch, motion(v));
        let most = 0.6 + 0.0018 * v;
        assert!(ratio > 0.0 && ratio <= most * (1.0 + 1e-15), "{ratio} at {v}, {damping}");
        assert_eq!(force_ratio(&patch, motion(-v)), -ratio);
    });
}

#[test]
fn a_patch_works_in_single_precision() {
    let curve =
        Coulomb::new(CoulombParameters { dynamic_coefficient: 0.5_f32, viscous_friction: 0.0 });
    let spring = KelvinVoigtParameters { micro_stiffness: 252.0_f32, micro_damping: 0.0_f32 };
    let model = FrBd::new(curve.unwrap(), KelvinVoigt::new(spring).unwrap());
    let pressure = PolynomialExponential::parabolic();
    let patch = Patch::new(PatchParameters { model, length: 0.1_f32, pressure }).unwrap();
    for slip in [1e-6_f32, 1e-3, 0.1, 10.0] {
        let motion = Motion { slip_velocity: slip * 16.0, rolling_speed: 16.0 };
        let got = patch.steady(motion).unwrap().force / patch.normal_force();
        let k = 252.0 * 0.1 * f64::from(slip) / 0.5;
        let want = 0.5 * PolynomialExponential::<f64, 3>::parabolic().rise(k);
        // A few roundings of 6e-8, and the cancellation of ξ and ξ².
        assert!((f64::from(got) / want - 1.0).abs() < 2e-6, "{slip}: {got} {want}");
    }
}

#[test]
fn bad_input_is_refused_by_name() {
    let constant = PolynomialExponential::<f64, 1>::constant;
    for length in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        let parameters = PatchParameters { model: frbd(0.0), length, pressure: constant() };
        assert_eq!(Patch::new(parameters).unwrap_err().name, "length");
    }
    let good = patch(frbd(0.0), constant());
    for force in [-1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(good.under_load(force).unwrap_err().name, "normal_force");
    }
    for (bad, name) in [
        (motion(1.0, -1.0), "rolling_speed"),
        (motion(1.0, f64::NAN), "rolling_speed"),
        (motion(f64::INFINITY, 1.0), "slip_velocity"),
        (motion(f64::NAN, 1.0), "slip_velocity"),
    ] {
        assert_eq!(good.steady(bad).unwrap_err().name, name);
        assert_eq!(good.pneumatic_trail(bad).unwrap_err().name, name);
        assert_eq!(good.linearised(bad).unwrap_err().name, name);
    }
    assert_eq!(good.linearised(motion(1.0, 0.0)).unwrap_err().name, "rolling_speed");
    for slip in [f64::INFINITY, f64::NAN] {
        assert_eq!(good.peak(at(slip)).unwrap_err().name, "slip_velocity");
    }
    assert_eq!(good.peak(at(0.0)).unwrap_err().name, "magnitude of slip_velocity");
    for rolling_speed in [0.0, -1.0, f64::NAN] {
        let slip = Motion { slip_velocity: 0.1, rolling_speed };
        assert_eq!(good.peak(slip).unwrap_err().name, "rolling_speed");
        assert_eq!(good.slip_stiffness(rolling_speed).unwrap_err().name, "rolling_speed");
    }
    // Pressures.
    let pressure = FunctionPressure::new(Function::new(|_| (0.0, 0.0), [])).unwrap();
    let nothing = Patch::new(PatchParameters { model: frbd(0.0), length: 0.1, pressure });
    assert_eq!(nothing.unwrap().under_load(1.0).unwrap_err().name, "total pressure");
    let function = |value: fn(f64) -> (f64, f64)| {
        FunctionPressure::new(Function::new(value, [0.5])).unwrap_err()
    };
    assert!(
        matches!(function(|x| (0.9 - x, -1.0)).rule, Rule::NonNegativeAt { place } if place > 0.9)
    );
    assert_eq!(function(|_| (f64::NAN, 0.0)).name, "pressure");
    assert_eq!(function(|x| (x.sqrt(), 0.5 / x.sqrt())).name, "the pressure's slope");
}
