//! Without std the exponentials, powers and hyperbolic functions are those of the crate libm: what
//! depends on them, beside values of 40 digits.
//!
//! The parameters are sums of a few powers of two, so that they mean the same in `f32`, in `f64`
//! and in the program that made the values (mpmath):
//!
//! ```python
//! from mpmath import mp, mpf, exp, tanh, coth
//! mp.dps = 40
//! mu_s, mu_d, v_s, s2, k, d = mpf(3)/2, mpf(1), mpf(2)**-7, mpf(2)**-5, mpf(2)**13, mpf(64)
//! def mu(v, delta): return mu_d + (mu_s - mu_d)*exp(-(abs(v)/v_s)**delta) + s2*abs(v)
//! def step(v, z, h, delta):
//!     g = d*abs(v) + mu(v, delta); r = mu(v, delta)/g; x = k*abs(v)/g*h
//!     phi1 = (1 - exp(-x))/x; phi2 = (1 - phi1)/x
//!     end, mean = exp(-x)*z + phi1*h*r*v, phi1*z + phi2*h*r*v
//!     return end, r*(k*end + d*v), r*(k*mean + d*v), k*r*phi1*z, r*(k*r*phi2*h + d)
//! v, z = 3*v_s/4, mpf(2)**-14
//! print([mu(v, delta) for delta in (2, 1, mpf(3)/4)], v*coth(v/v_s), tanh(v/v_s))
//! print(step(v, z, mpf(2)**-10, 2), step(-3*v, z, mpf(2)**-5, 2))
//! print(step(v, z, mpf(2)**-10, mpf(3)/4))
//! ```

use bristle::curve::{FrictionCurve, Stribeck, StribeckParameters};
use bristle::regularisation::{HyperbolicTangent, Regularisation};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, Contact, FrBd, Scalar};
use nalgebra::{ComplexField, convert};

const STRIBECK_VELOCITY: f64 = 0.007_812_5;
const VELOCITY: f64 = 0.75 * STRIBECK_VELOCITY;
const DEFLECTION: f64 = 1.0 / 16_384.0;
const MILLISECOND: f64 = 1.0 / 1024.0;

fn curve<T: Scalar>(exponent: f64) -> Stribeck<T> {
    Stribeck::new(StribeckParameters {
        static_coefficient: convert(1.5),
        dynamic_coefficient: convert(1.0),
        stribeck_velocity: convert(STRIBECK_VELOCITY),
        stribeck_exponent: convert(exponent),
        viscous_friction: convert(0.031_25),
    })
    .unwrap()
}

fn contact<T: Scalar>(exponent: f64) -> Contact<T, FrBd<Stribeck<T>, KelvinVoigt<T>>> {
    let bristle = KelvinVoigt::new(KelvinVoigtParameters {
        micro_stiffness: convert(8192.0),
        micro_damping: convert(64.0),
    })
    .unwrap();
    FrBd::new(curve(exponent), bristle).under_load(convert(1.0)).unwrap()
}

/// In units of the last place of a number of this size, if its mantissa were 1: between one and two
/// of them.
fn assert_ulps<T: Scalar>(what: &str, got: T, want: f64, most: f64) {
    let value: f64 = got.to_subset_unchecked();
    let off = (value - want).abs() / want.abs();
    let epsilon: f64 = T::default_epsilon().to_subset_unchecked();
    assert!(off <= most * epsilon, "{what}: {got}, off {want} by {} ulps", off / epsilon);
}

#[test]
fn the_mathematics_is_that_of_libm() {
    // What a std switched on by mistake would replace.
    for index in 1..2000 {
        let x = 1e-2 * f64::from(index);
        assert_eq!(ComplexField::exp(-x), libm::exp(-x));
        assert_eq!(ComplexField::powf(x, 0.75), libm::pow(x, 0.75));
        assert_eq!(ComplexField::tanh(x), libm::tanh(x));
        assert_eq!(ComplexField::exp(-x as f32), libm::expf(-x as f32));
        assert_eq!(ComplexField::powf(x as f32, 0.75), libm::powf(x as f32, 0.75));
    }
}

fn curves<T: Scalar>() {
    let velocity: T = convert(VELOCITY);
    // One rounding of each of three terms, and those of the exponential.
    let wanted =
        [1.285_074_517_834_211_504_9, 1.236_366_381_839_257_353_6, 1.223_519_839_265_042_142_1];
    for (exponent, want) in [2.0, 1.0, 0.75].into_iter().zip(wanted) {
        assert_ulps("μ", curve::<T>(exponent).at(velocity), want, 1.0);
        assert_ulps("μ", curve::<T>(exponent).at(-velocity), want, 1.0);
    }
    let tanh = HyperbolicTangent::new(convert::<f64, T>(STRIBECK_VELOCITY)).unwrap();
    assert_ulps("|v|", tanh.speed(velocity.into()), 0.009_225_198_243_619_549_738_3, 2.0);
    assert_ulps("sgn v", tanh.sign(velocity.into()), 0.635_148_952_387_287_319_21, 1.0);
}

fn steps<T: Scalar>(most: f64) {
    let lit = |value: f64| convert::<f64, T>(value);
    let cases = [
        (
            (2.0, VELOCITY, MILLISECOND),
            [
                6.370_335_111_904_693_854_7e-5,
                0.694_263_516_375_322_544_58,
                0.685_843_177_211_007_026_42,
            ],
        ),
        (
            (2.0, -3.0 * VELOCITY, 32.0 * MILLISECOND),
            [
                -1.003_571_798_510_419_205_1e-4,
                -0.918_093_187_973_266_538_29,
                -0.708_817_146_658_502_227_31,
            ],
        ),
        (
            (0.75, VELOCITY, MILLISECOND),
            [
                6.358_745_603_908_020_979_2e-5,
                0.685_735_468_164_441_606_15,
                0.677_772_831_443_180_918_41,
            ],
        ),
    ];
    for ((exponent, velocity, duration), [deflection, end, mean]) in cases {
        let step = contact(exponent).hold(lit(velocity), lit(DEFLECTION), lit(duration));
        assert_ulps("z", step.deflection, deflection, most);
        assert_ulps("F", step.end_force, end, most);
        assert_ulps("mean F", step.mean_force, mean, most);
    }
    let companion = contact(2.0).companion(lit(1.0)).unwrap();
    for (velocity, duration, bias, damping) in [
        (VELOCITY, MILLISECOND, 0.381_639_785_148_234_457_01, 51.917_378_912_046_518_514),
        (
            -3.0 * VELOCITY,
            32.0 * MILLISECOND,
            0.098_056_210_594_034_924_975,
            45.902_128_768_144_335_775,
        ),
    ] {
        let step = companion.step(lit(velocity), lit(DEFLECTION), lit(duration));
        assert_ulps("bias", step.bias(), bias, most);
        assert_ulps("damping", step.damping(), damping, most);
    }
}

#[test]
fn curves_and_regularised_signs_keep_their_digits() {
    curves::<f32>();
    curves::<f64>();
}

#[test]
fn held_and_passive_steps_keep_their_digits() {
    // A dozen roundings; the exponent of the long step has an error of a few, times λh = 2.9.
    steps::<f32>(6.0);
    steps::<f64>(6.0);
}

/// Numbers that no sensor should give: the answer may be NaN, but it comes.
#[test]
fn inputs_that_are_no_numbers_come_out_of_a_fixed_number_of_operations() {
    use bristle::exponential::Exponential;
    fn all<T: Scalar>(odd: &[T]) {
        let contact = contact::<T>(0.75);
        let companion = contact.companion(convert(1.0)).unwrap();
        for &v in odd {
            for &z in odd {
                for &h in odd {
                    let hold = contact.hold(v, z, h);
                    let nan = |x: T| !(x >= x);
                    let done = companion.step(v, z, h).commit(v);
                    let drag = Exponential::<3>.ramp(&contact, v..z, z, h);
                    // NaN does not turn into a plausible number.
                    if nan(v) || nan(z) || nan(h) {
                        assert!(
                            nan(hold.end_force) && nan(done.force) && nan(drag.end),
                            "{v} {z} {h}"
                        );
                    }
                    let smooth = |part: T| v + (z - v) * part;
                    let _ = Exponential::<3>.step(&contact, smooth, z, h);
                }
            }
        }
    }
    let (inf, nan) = (f64::INFINITY, f64::NAN);
    all(&[nan, inf, -inf, 0.0, -0.0, f64::MIN_POSITIVE, 5e-324, f64::MAX, -f64::MAX, -1.0, 1.0]);
    let (inf, nan) = (f32::INFINITY, f32::NAN);
    all(&[nan, inf, -inf, 0.0, -0.0, f32::MIN_POSITIVE, 1e-45, f32::MAX, -f32::MAX, -1.0, 1.0]);
}
