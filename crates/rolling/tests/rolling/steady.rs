//! Steady rolling against closed forms, quadrature in another program, and its own derivatives.

use crate::tyre::{
    LENGTH, LOAD, Model, STIFFNESS, constant, coulomb, dahl, frbd, function, loaded as patch,
    lugre, lugre_inside, motion, parabolic, polynomial, table,
};
use bristle::curve::{Coulomb, CoulombParameters};
use bristle::signal::Function;
use bristle::{Bristle, FrBd, LuGre, Rule};
use bristle_rolling::{
    FunctionPressure, Motion, Patch, PatchParameters, PolynomialExponential, Pressure,
};
use bristle_specimens::{assert_within, integral, specimens};
use nalgebra::Complex;

const ROLLING_SPEED: f64 = 16.0;
const DAMPING: f64 = 0.3;

fn exponential() -> PolynomialExponential<f64, 1> {
    crate::tyre::exponential(bristle_rolling::TYRE_PRESSURE_DECAY)
}

fn trapezoidal() -> impl Pressure<f64> + Copy {
    table([(0.0, 0.0), (0.125, 3.0), (0.75, 3.0), (1.0, 0.0)])
}

/// The motion at a slip ratio.
fn at(slip_ratio: f64) -> Motion<f64> {
    Motion { slip_velocity: slip_ratio * ROLLING_SPEED, rolling_speed: ROLLING_SPEED }
}

/// F/F_z in steady rolling.
fn force_ratio<M: Model, P: Pressure<f64>>(patch: &Patch<f64, M, P>, motion: Motion<f64>) -> f64 {
    patch.steady(motion).unwrap().force / patch.normal_force()
}

/// Slips from adhesion to full sliding, of them 0.05 and 1 as in the paper.
const SLIPS: [f64; 6] = [1e-12, 1e-3, 0.05, 0.3, 1.0, 1000.0];

/// F/F_z at [`SLIPS`] for Table 1 with L V = 16 m/s and σ1 = 0 ("frbd0") or 0.3 s/m: ∫ p (c₀ z +
/// c₂ v) dξ by mpmath's Gauss–Legendre quadrature with 40 digits on panels graded in 1/κ, from the
/// double-precision values of all parameters.
#[rustfmt::skip]
const FORCES: [(&str, &str, [f64; 6]); 16] = [
    ("frbd0", "constant", [
        1.2599999999823599e-11, 1.2425444746209106e-2, 3.4895416005905155e-1,
        4.8968358216229174e-1, 2.5704509207597298e-1, 2.8966626984126982e1,
    ]),
    ("frbd0", "exponential", [
        1.2390034991496744e-11, 1.2219819370613475e-2, 3.4485154475196872e-1,
        4.8808713249131735e-1, 2.5691191765564542e-1, 2.8964934562429100e1,
    ]),
    ("frbd0", "parabolic", [
        1.2599999999841240e-11, 1.2442717929972211e-2, 3.6564277428873770e-1,
        5.1315119311467550e-1, 2.5955977854005730e-1, 2.8999770097632393e1,
    ]),
    ("frbd0", "trapezoidal", [
        1.1873076922928615e-11, 1.1726156601054590e-2, 3.4705728648394113e-1,
        5.0537929210329302e-1, 2.5945025920350723e-1, 2.8999621853983758e1,
    ]),
    ("frbd", "constant", [
        1.7399999999583598e-11, 1.6992262899237887e-2, 3.7762106861584632e-1,
        4.9046742736553894e-1, 2.5706348319659522e-1, 2.8966807719007900e1,
    ]),
    ("frbd", "exponential", [
        1.7190034991260102e-11, 1.6789854842558766e-2, 3.7494426028830802e-1,
        4.8952344644469947e-1, 2.5698153024427189e-1, 2.8965758534717406e1,
    ]),
    ("frbd", "parabolic", [
        1.7399999999601240e-11, 1.7009130893133311e-2, 3.8551756788276220e-1,
        4.9702945045515112e-1, 2.5776105034619196e-1, 2.8976047381210716e1,
    ]),
    ("frbd", "trapezoidal", [
        1.6673076922700245e-11, 1.6303817663337532e-2, 3.7414972108220312e-1,
        4.9213935652837132e-1, 2.5731443175083002e-1, 2.8970286468307695e1,
    ]),
    ("classical", "constant", [
        1.7428799999722801e-11, 1.7154832793678024e-2, 4.4996842971619677e-1,
        5.8948361171516983e-1, 3.0159095092005828e-1, 2.9038093650793648e1,
    ]),
    ("classical", "exponential", [
        1.7218834991397625e-11, 1.6950852627948810e-2, 4.4751879803169303e-1,
        5.9224272459766769e-1, 3.0367900832679773e-1, 2.9040030040982927e1,
    ]),
    ("classical", "parabolic", [
        1.7428799999740440e-11, 1.7171968596996184e-2, 4.5995555099591295e-1,
        5.4872148649781671e-1, 2.6198172616544468e-1, 2.9000001813954576e1,
    ]),
    ("classical", "trapezoidal", [
        1.6701876922833632e-11, 1.6461140257607625e-2, 4.4885275906980499e-1,
        5.6204669929606188e-1, 2.6349956455345097e-1, 2.9000002976793223e1,
    ]),
    ("inside", "constant", [
        1.7399999999722800e-11, 1.7126045789748676e-2, 4.4911336511119898e-1,
        5.8993616060726284e-1, 3.0651592944308154e-1, 3.4490436507936508e1,
    ]),
    ("inside", "exponential", [
        1.7190034991397624e-11, 1.6922065341008659e-2, 4.4665484250044796e-1,
        5.9270750967049535e-1, 3.0884399231918835e-1, 3.4768869056922540e1,
    ]),
    ("inside", "parabolic", [
        1.7399999999740439e-11, 1.7143180794438447e-2, 4.5911414080053808e-1,
        5.4919767519701101e-1, 2.6255592430332930e-1, 2.9037822903304928e1,
    ]),
    ("inside", "trapezoidal", [
        1.6673076922833631e-11, 1.6432351690788338e-2, 4.4797664957121308e-1,
        5.6268926906246874e-1, 2.6447046540672459e-1, 2.9062211539430585e1,
    ]),
];

#[test]
fn the_closed_form_is_the_quadrature_from_no_slip_to_full_sliding() {
    fn ratio<M: Model, P: Pressure<f64>>(model: M, pressure: P, slip: f64) -> f64 {
        let patch = patch(model, pressure);
        let ratio = force_ratio(&patch, at(slip));
        assert_eq!(force_ratio(&patch, at(-slip)), -ratio, "at the slip −{slip:e}");
        ratio
    }
    fn under<M: Model>(model: M, pressure: &str, slip: f64) -> f64 {
        match pressure {
            "constant" => ratio(model, constant(), slip),
            "exponential" => ratio(model, exponential(), slip),
            "parabolic" => ratio(model, parabolic(), slip),
            _ => ratio(model, trapezoidal(), slip),
        }
    }
    for (model, pressure, forces) in FORCES {
        for (slip, want) in SLIPS.into_iter().zip(forces) {
            let got = match model {
                "frbd0" => under(frbd(0.0), pressure, slip),
                "frbd" => under(frbd(DAMPING), pressure, slip),
                "classical" => under(lugre(DAMPING), pressure, slip),
                _ => under(lugre_inside(DAMPING), pressure, slip),
            };
            // Measured 9e-16 at most.
            assert_within(1e-14, want, got, want, || format!("{model} {pressure} {slip:e}"));
        }
    }
}

#[test]
fn slip_stiffness_is_that_of_the_springs_and_the_dashpots() {
    // L² (σ0 ∫ p ξ dξ + c₂ V ∫ p dξ) with ∫ p dξ = F_z/L and ∫ p ξ dξ = F_z/(2 L) for symmetric
    // pressure.
    for (damping, speed) in [(0.0, 1.0), (0.0, 16.0), (0.3, 16.0)] {
        let springs = LOAD * LENGTH * STIFFNESS / 2.0;
        let want = springs + LOAD * damping * speed;
        let parabola = patch(frbd(damping), parabolic());
        let even = patch(frbd(damping), constant());
        for got in [parabola.slip_stiffness(speed), even.slip_stiffness(speed)] {
            assert_within(1e-14, want, got.unwrap(), want, || format!("σ1 = {damping}"));
        }
        // The viscous friction of the classical model acts from rest on.
        let got = patch(lugre(damping), constant()).slip_stiffness(speed).unwrap();
        assert_within(1e-14, want, got, want + LOAD * 0.0018 * speed, || "LuGre".into());
        // It is the limit of force over slip.
        let small = Motion { slip_velocity: 1e-9 * speed, rolling_speed: speed };
        let secant = parabola.steady(small).unwrap().force / 1e-9;
        // The curvature σ0 L/(μ) of 40 or so, times the slip.
        assert_within(1e-7, want, secant, want, || format!("secant, σ1 = {damping}"));
    }
}

#[test]
fn without_rolling_the_patch_slides_and_without_slip_there_is_no_force() {
    for damping in [0.0, 0.3] {
        let patch = patch(frbd(damping), parabolic());
        for v in [1e-9, 0.5, -20.0] {
            let locked = Motion { slip_velocity: v, rolling_speed: 0.0 };
            let steady = patch.steady(locked).unwrap();
            let want = 4000.0 * frbd(damping).stationary_coefficient(v);
            assert_within(1e-15, want.abs(), steady.force, want, || format!("locked at {v}"));
            assert_eq!(steady.deflection(0.5), frbd(damping).stationary(v));
            assert!(patch.pneumatic_trail(locked).unwrap().unwrap().abs() < 1e-16);
            // Slow rolling leaves its mark at the inlet: about V μ/(σ0 |v|) = 1e-6.
            for (rolling_speed, tolerance) in [(1e-5 * v.abs(), 1e-5), (1e-100, 1e-15)] {
                let got = patch.steady(Motion { rolling_speed, ..locked }).unwrap().force;
                assert_within(tolerance, want.abs(), got, want, || format!("{rolling_speed:e}"));
            }
        }
        for rolling_speed in [0.0, 1e-90, 16.0] {
            let still = Motion { slip_velocity: 0.0, rolling_speed };
            let steady = patch.steady(still).unwrap();
            let nothing = (steady.force, steady.deflection(1.0), steady.coefficient(0.3));
            assert_eq!(nothing, (0.0, 0.0, 0.0));
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
    fn peak<M: Model, P: Pressure<f64>>(model: M, pressure: P) {
        let patch = patch(model, pressure);
        let up_to = at(0.9);
        let peak = patch.peak(up_to).unwrap().unwrap();
        let force_at = |motion| patch.steady(motion).unwrap().force;
        let height = force_at(peak);
        // Twenty thousand slips around it: parabolic within, so that none is higher by rounding.
        for i in 1..=20_000 {
            let force = force_at(at(0.9 * f64::from(i) / 20_000.0));
            assert!(force <= height * (1.0 + 1e-14), "{i}: {force} > {height}");
        }
        let slope = patch.linearised(peak).unwrap().by_slip_velocity(0.0).re;
        // F'' is about F/slip²: the place to eleven digits.
        assert!(slope.abs() * peak.slip_velocity < 1e-11 * height);
        let mirrored = patch.peak(at(-0.9)).unwrap().unwrap();
        assert_eq!((mirrored.slip_velocity, force_at(mirrored)), (-peak.slip_velocity, -height));
    }
    peak(frbd(0.0), constant());
    peak(frbd(0.3), parabolic());
    peak(frbd(0.01), trapezoidal());
    peak(lugre(0.01), exponential());
    peak(lugre_inside(0.01), exponential());
}

#[test]
fn a_force_that_only_grows_has_no_peak() {
    fn none<M: Model, P: Pressure<f64>>(model: M, pressure: P, up_to: f64) {
        assert_eq!(patch(model, pressure).peak(at(up_to)).unwrap(), None, "{up_to}");
    }
    let viscous = CoulombParameters { dynamic_coefficient: 0.4, viscous_friction: 0.01 };
    let viscous = FrBd::new(Coulomb::new(viscous).unwrap(), *frbd(0.0).rheology());
    for up_to in [1e-6, 1e-2, 1.0, 1e6, 1e20] {
        none(coulomb(0.4, 0.0), constant(), up_to);
        none(coulomb(0.4, 0.0), parabolic(), up_to);
        none(coulomb(0.4, 1e-3), exponential(), up_to);
        none(viscous, constant(), up_to);
        none(viscous, parabolic(), up_to);
        none(dahl(), exponential(), up_to);
        none(dahl(), trapezoidal(), up_to);
        let damped = coulomb(0.4, 1e-3);
        let lugre = patch(LuGre::classical(*damped.curve(), *damped.rheology()), exponential());
        if let Some(peak) = lugre.peak(at(up_to)).unwrap() {
            // LuGre's damping lifts the force above the curve: a peak of its own.
            let force = lugre.steady(peak).unwrap().force;
            assert!(force > 0.4 * LOAD, "{peak:?} {up_to}");
        }
    }
    // Before its peak a tyre's force only grows too.
    none(frbd(0.0), exponential(), 0.05);
}

#[test]
fn the_trail_is_that_of_the_brush_model_and_vanishes_in_sliding() {
    // Of z = v ξ/V: L (∫ p ξ²/∫ p ξ − ½), a sixth of the length for constant pressure, a tenth for
    // a parabola.
    let constant = patch(frbd(0.0), constant());
    let parabola = patch(frbd(0.0), parabolic());
    for slip in [0.0, 1e-12] {
        // The terms of ξ − ½ cancel to a sixth.
        let trail = constant.pneumatic_trail(at(slip)).unwrap().unwrap();
        assert_within(1e-10, 0.1, trail, 0.1 / 6.0, || "constant".into());
        let trail = parabola.pneumatic_trail(at(slip)).unwrap().unwrap();
        assert_within(1e-10, 0.1, trail, 0.01, || "parabola".into());
    }
    // The dashpot adds σ1 v to σ0 z, without a moment: L/10/(1 + 2 σ1 U/(σ0 L)).
    let damped = patch(frbd(DAMPING), parabolic());
    let spring = STIFFNESS * LENGTH;
    let want = 0.01 / (1.0 + 2.0 * DAMPING * ROLLING_SPEED / spring);
    let got = damped.pneumatic_trail(at(0.0)).unwrap().unwrap();
    assert_within(1e-10, 0.1, got, want, || "parabola with a dashpot".into());
    // In between, by quadrature of p and z with the stationary values of the model.
    for slip in [1e-3, 0.05, 0.3] {
        let v = slip * ROLLING_SPEED;
        let kappa = frbd(0.0).affine(v.into(), 0.0).relaxation / (ROLLING_SPEED / LENGTH);
        let part = |power: i32| {
            integral(0.0, 1.0, 400, |x| {
                6.0 * x * (1.0 - x) * (x - 0.5).powi(power) * -(-kappa * x).exp_m1()
            })
        };
        let want = LENGTH * part(1) / part(0);
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
    let constant = patch(frbd(0.0), constant());
    let parabola = patch(frbd(0.0), parabolic());
    for kappa in [1e3_f64, 1e4, 1e5, 1e6] {
        for v in [-2.0, 7.0] {
            let affine = frbd(0.0).affine(v.into(), 0.0);
            let motion = motion(v, affine.relaxation / kappa);
            let coefficient = frbd(0.0).stationary_coefficient(v);
            let unit = LENGTH * 4000.0 * coefficient.abs();
            let k = kappa.recip();
            let flat = (0.5 * k - k * k, 1.0 - k);
            let k2 = k * k;
            let arch = (k2 * (3.0 - 18.0 * k + 36.0 * k2), 1.0 - 6.0 * k2 + 12.0 * k * k2);
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
                let want = LENGTH * moment / force;
                assert_within(1e-16, LENGTH, trail, want, || format!("trail, {kappa}"));
            }
        }
    }
}

#[test]
fn of_two_maxima_the_peak_is_the_higher_one() {
    // Friction with two humps; the force follows it, a little behind.
    let humps = |first, second| {
        let speeds = [0.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
        let coefficients = [0.2, 0.3, first, 0.3, second, 0.2, 0.2];
        let knot = |i: usize| (speeds[i], coefficients[i]);
        let curve = specimens::table([0, 1, 2, 3, 4, 5, 6].map(knot));
        patch(FrBd::new(curve, *frbd(0.0).rheology()), constant())
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
                let s = Complex::new(kappa, theta);
                // To rounding of the whole, times that of the phase.
                let close = |got: Complex<f64>, want: Complex<f64>, scale: f64, what| {
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
    same(&function(arch, []), &parabolic());
    same(&function(arch, [0.25, 0.7]), &parabolic());
    let falling = |x: f64| {
        let weight = (-8.0 * x).exp();
        (weight * (1.0 + 2.0 * x), weight * (2.0 - 8.0 * (1.0 + 2.0 * x)))
    };
    same(&function(falling, []), &polynomial([1.0, 2.0], 8.0));
    let piecewise = |x: f64| match x {
        x if x < 0.125 => (24.0 * x, 24.0),
        x if x < 0.75 => (3.0, 0.0),
        x => (12.0 * (1.0 - x), -12.0),
    };
    same(&function(piecewise, [0.125, 0.75]), &trapezoidal());
    same(&function(|_| (1.0, 0.0), []), &constant());
    same(&function(|x| (2.0 - 2.0 * x, -2.0), []), &polynomial([2.0, -2.0], 0.0));
}

#[test]
fn a_patch_works_in_single_precision() {
    let patch = crate::tyre::patch(coulomb::<f32>(0.5, 0.0), parabolic());
    for slip in [1e-6_f32, 1e-3, 0.1, 10.0] {
        let motion = Motion { slip_velocity: slip * 16.0, rolling_speed: 16.0 };
        let got = patch.steady(motion).unwrap().force / patch.normal_force();
        let want = 0.5 * parabolic::<f64>().rise(STIFFNESS * LENGTH * f64::from(slip) / 0.5);
        // A few roundings of 6e-8, and the cancellation of ξ and ξ².
        assert!((f64::from(got) / want - 1.0).abs() < 2e-6, "{slip}: {got} {want}");
    }
}

#[test]
fn bad_input_is_refused_by_name() {
    for length in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        let parameters = PatchParameters { model: frbd(0.0), length, pressure: constant() };
        assert_eq!(Patch::new(parameters).unwrap_err().name, "length");
    }
    let good = patch(frbd(0.0), constant());
    for force in [-1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(good.under_load(force).unwrap_err().name, "normal_force");
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
    let nothing = crate::tyre::patch(frbd(0.0), function(|_| (0.0, 0.0), []));
    assert_eq!(nothing.under_load(1.0).unwrap_err().name, "total pressure");
    let refused = |value: fn(f64) -> (f64, f64)| {
        FunctionPressure::new(Function::new(value, [0.5])).unwrap_err()
    };
    let negative = refused(|x| (0.9 - x, -1.0)).rule;
    assert!(matches!(negative, Rule::NonNegativeAt { place } if place > 0.9));
    assert_eq!(refused(|_| (f64::NAN, 0.0)).name, "pressure");
    assert_eq!(refused(|x| (x.sqrt(), 0.5 / x.sqrt())).name, "the pressure's slope");
}
