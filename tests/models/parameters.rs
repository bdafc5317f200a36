//! The gate: what every constructor refuses, in which words, and that what it lets through gives
//! finite answers.

use bristle::curve::{
    Coulomb, CoulombParameters, FrictionCurve, FunctionCurve, Knot, RationalStribeck,
    RationalStribeckParameters, Stribeck, StribeckParameters, Tabulated,
};
use bristle::regularisation::{HyperbolicTangent, Regularisation, SquareRoot};
use bristle::rheology::{Deflection, KelvinVoigt, KelvinVoigtParameters};
use bristle::{
    AnyBristle, Bounds, Branch, Bristle, Dahl, DahlParameters, ElastoPlastic, FrBd, LuGre,
    ParameterError, Rule, Scalar,
};
use bristle_specimens::lit;
use bristle_specimens::recipe::Recipe;
use bristle_specimens::specimens::{
    coulomb, dahl, hyperbolic_tangent, kelvin_voigt, lugre_inside, rational, specimens, spring,
    square_root, stribeck, table_2_frbd,
};

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Positive,
    NonNegative,
}

/// One parameter of one constructor: everything else is harmless.
struct Gate<T> {
    what: &'static str,
    name: &'static str,
    kind: Kind,
    build: Box<dyn Fn(T) -> Result<(), ParameterError>>,
}

/// A parameter struct with one field replaced, and its constructor.
macro_rules! gate {
    ($list:ident, $kind:ident, $type:ident, $parameters:expr, $field:ident) => {
        $list.push(Gate {
            what: stringify!($type),
            name: stringify!($field),
            kind: Kind::$kind,
            build: Box::new(move |value| {
                let mut parameters = $parameters;
                parameters.$field = value;
                $type::new(parameters).map(drop)
            }),
        })
    };
}

/// A constructor that takes the number itself.
fn plain<T: Scalar>(
    what: &'static str,
    name: &'static str,
    kind: Kind,
    build: impl Fn(T) -> Result<(), ParameterError> + 'static,
) -> Gate<T> {
    Gate { what, name, kind, build: Box::new(build) }
}

fn stribeck_parameters<T: Scalar>() -> StribeckParameters<T> {
    StribeckParameters {
        // As large as can be, so that it does not stand in the way of the dynamic coefficient.
        static_coefficient: lit(1e15),
        dynamic_coefficient: lit(1e-18),
        stribeck_velocity: lit(0.01),
        stribeck_exponent: lit(2.0),
        viscous_friction: lit(0.04),
    }
}

fn rational_parameters<T: Scalar>() -> RationalStribeckParameters<T> {
    let s = stribeck_parameters();
    RationalStribeckParameters {
        static_coefficient: s.static_coefficient,
        dynamic_coefficient: s.dynamic_coefficient,
        stribeck_velocity: s.stribeck_velocity,
        viscous_friction: s.viscous_friction,
    }
}

/// Every parameter of every constructor that is a number with a range of its own.
fn gates<T: Scalar>() -> Vec<Gate<T>> {
    let mut list = Vec::new();
    let c = CoulombParameters { dynamic_coefficient: lit::<T>(0.3), viscous_friction: lit(0.1) };
    gate!(list, Positive, Coulomb, c, dynamic_coefficient);
    gate!(list, NonNegative, Coulomb, c, viscous_friction);
    let s = stribeck_parameters::<T>();
    gate!(list, Positive, Stribeck, s, static_coefficient);
    gate!(list, Positive, Stribeck, s, dynamic_coefficient);
    gate!(list, Positive, Stribeck, s, stribeck_velocity);
    gate!(list, NonNegative, Stribeck, s, viscous_friction);
    let r = rational_parameters::<T>();
    gate!(list, Positive, RationalStribeck, r, static_coefficient);
    gate!(list, Positive, RationalStribeck, r, dynamic_coefficient);
    gate!(list, Positive, RationalStribeck, r, stribeck_velocity);
    gate!(list, NonNegative, RationalStribeck, r, viscous_friction);
    let d = DahlParameters { dynamic_coefficient: lit::<T>(0.3), micro_stiffness: lit(1e4) };
    gate!(list, Positive, Dahl, d, dynamic_coefficient);
    gate!(list, Positive, Dahl, d, micro_stiffness);
    let kv =
        KelvinVoigtParameters { micro_stiffness: lit::<T>(1e4), micro_damping: lit::<T>(60.0) };
    gate!(list, Positive, KelvinVoigt, kv, micro_stiffness);
    gate!(list, NonNegative, KelvinVoigt, kv, micro_damping);
    list.push(plain("SquareRoot", "regularisation", Kind::Positive, |e: T| {
        SquareRoot::new(e).map(drop)
    }));
    list.push(plain("HyperbolicTangent", "threshold_velocity", Kind::Positive, |v: T| {
        HyperbolicTangent::new(v).map(drop)
    }));
    let under = move |p: T| Dahl::new(d).unwrap().under_load(p);
    list.push(plain("Contact", "normal_force", Kind::NonNegative, move |p| under(p).map(drop)));
    list.push(plain("Contact", "normal_force", Kind::NonNegative, move |p| {
        under(T::one()).unwrap().reload(p, T::zero(), T::zero()).map(drop)
    }));
    list.push(plain("Contact", "normal_force", Kind::NonNegative, move |p| {
        under(T::one()).unwrap().renew(p, T::zero()).map(drop)
    }));
    list.push(plain("Contact", "reference_load", Kind::Positive, move |p| {
        under(T::one()).unwrap().measured_at(p).map(drop)
    }));
    list.push(plain("FunctionCurve", "bounds.min", Kind::Positive, |min: T| {
        let bounds = Bounds { min, max: lit(1e15) };
        FunctionCurve::new(|speed: T| (speed, T::one()), bounds).map(drop)
    }));
    list.push(plain("ElastoPlastic", "stick_limit", Kind::Positive, |stick_limit: T| {
        ElastoPlastic::new(
            // So that min μ/σ0 is as large as it can be.
            Coulomb::new(CoulombParameters {
                dynamic_coefficient: lit(1e15),
                viscous_friction: T::zero(),
            })
            .unwrap(),
            kelvin_voigt(lit::<T>(1e-18), T::zero()),
            stick_limit,
        )
        .map(drop)
    }));
    list
}

/// Asserts a refusal that names parameter, value and rule. NaN is the value it was given.
#[track_caller]
fn assert_refused(
    result: Result<(), ParameterError>,
    (name, component, value, rule): (&str, Option<usize>, f64, Rule),
    what: &str,
) {
    let error = result.expect_err(what);
    assert_eq!((error.name, error.component, error.rule), (name, component, rule), "{what}");
    assert!(
        error.value == value || (error.value.is_nan() && value.is_nan()),
        "{what}: says {:e}",
        error.value
    );
}

/// Puts every bad number into every parameter. `least` and `most` are the documented limits of
/// the scalar type, `subnormal` one of its subnormal numbers.
fn every_parameter_refuses<T: Scalar>(least: f64, most: f64, subnormal: T, largest: T) {
    // As this type prints them.
    let wide = |value: T| value.to_string().parse::<f64>().unwrap();
    for gate in gates::<T>() {
        let rule = match gate.kind {
            Kind::Positive => Rule::Between { least, most },
            Kind::NonNegative => Rule::Between { least: 0.0, most },
        };
        let infinity = T::one() / T::zero();
        let always = [
            infinity * T::zero(),
            infinity,
            -infinity,
            -T::one(),
            -lit::<T>(least),
            -subnormal,
            lit(most * 1.001),
            largest,
        ];
        let never_zero = [T::zero(), -T::zero(), subnormal, lit(least * 0.999)];
        let what = |value: T| format!("{}::{} = {value}", gate.what, gate.name);
        for value in always {
            let expected = (gate.name, None, wide(value), rule);
            assert_refused((gate.build)(value), expected, &what(value));
        }
        for value in never_zero {
            if gate.kind == Kind::Positive {
                let expected = (gate.name, None, wide(value), rule);
                assert_refused((gate.build)(value), expected, &what(value));
            } else {
                assert_eq!((gate.build)(value), Ok(()), "{}", what(value));
            }
        }
        // The limits themselves belong to the range. (The extremes of a static coefficient and of
        // a stick limit have another rule to keep, tested below.)
        if !["static_coefficient", "dynamic_coefficient", "stick_limit"].contains(&gate.name) {
            for value in [lit(least), T::one()] {
                assert_eq!((gate.build)(value), Ok(()), "{}", what(value));
            }
            if gate.name != "bounds.min" {
                assert_eq!((gate.build)(lit(most)), Ok(()), "{}", what(lit(most)));
            }
        }
    }
}

#[test]
fn every_parameter_refuses_what_is_out_of_its_range() {
    every_parameter_refuses::<f64>(1e-100, 1e100, 5e-324, f64::MAX);
    every_parameter_refuses::<f32>(1e-18, 1e15, 1e-45, f32::MAX);
}

#[test]
fn static_friction_is_at_least_dynamic_friction() {
    let just_below = 0.5_f64.next_down();
    let rule = Rule::AtLeast { other: "dynamic_coefficient", limit: 0.5 };
    let s = StribeckParameters { dynamic_coefficient: 0.5, ..stribeck_parameters() };
    let r = RationalStribeckParameters { dynamic_coefficient: 0.5, ..rational_parameters() };
    let with = |static_coefficient| {
        [
            Stribeck::new(StribeckParameters { static_coefficient, ..s }).map(drop),
            RationalStribeck::new(RationalStribeckParameters { static_coefficient, ..r }).map(drop),
        ]
    };
    for refused in with(just_below) {
        assert_refused(refused, ("static_coefficient", None, just_below, rule), "just below");
    }
    assert_eq!(with(0.5), [Ok(()), Ok(())]);
}

#[test]
fn the_stick_limit_lies_below_the_least_full_deflection() {
    // The least coefficient of a curve is not always μ_d: here 0.2 at the middle knot.
    let curve = Tabulated::new(
        [(0.0, 0.4), (0.1, 0.2), (1.0, 0.3)]
            .map(|(speed, coefficient)| Knot { speed, coefficient }),
    )
    .unwrap();
    let with =
        |stick_limit| ElastoPlastic::new(curve, kelvin_voigt(1e4, 60.0), stick_limit).map(drop);
    let limit = 0.2 / 1e4;
    let rule = Rule::Below { other: "min μ/σ0", limit };
    assert_refused(with(limit), ("stick_limit", None, limit, rule), "equal");
    assert_refused(with(1e-3), ("stick_limit", None, 1e-3, rule), "above");
    assert_eq!(with(limit.next_down()), Ok(()));
}

#[test]
fn bounds_are_in_order() {
    let curve = |min, max| {
        FunctionCurve::new(|speed: f64| (1.0 + speed, 1.0), Bounds { min, max }).map(drop)
    };
    for max in [0.5_f64.next_down(), -1.0, 0.0, f64::NAN, f64::NEG_INFINITY] {
        let rule = Rule::AtLeast { other: "bounds.min", limit: 0.5 };
        assert_refused(curve(0.5, max), ("bounds.max", None, max, rule), "bounds.max");
    }
    assert_eq!(curve(0.5, 0.5), Ok(()));
    assert_eq!(curve(0.5, f64::INFINITY), Ok(()));
}

#[test]
fn a_table_starts_at_rest_and_goes_on() {
    fn with<const N: usize>(knots: [(f64, f64); N]) -> Result<(), ParameterError> {
        Tabulated::new(knots.map(|(speed, coefficient)| Knot { speed, coefficient })).map(drop)
    }
    let nan = f64::NAN;
    let range = Rule::Between { least: 1e-100, most: 1e100 };
    let magnitude = Rule::Between { least: -1e100, most: 1e100 };
    let count = Rule::Count { least: 2 };
    assert_refused(with([]), ("knots", None, 0.0, count), "none");
    assert_refused(with([(0.0, 1.0)]), ("knots", None, 1.0, count), "one");
    for first in [1e-3, -1e-3, nan, f64::INFINITY, 5e-324] {
        let expected = ("speed", Some(0), first, Rule::Exactly { value: 0.0 });
        assert_refused(with([(first, 1.0), (1.0, 1.0)]), expected, "first");
    }
    for (speed, rule) in [
        (1.0, Rule::Increasing { previous: 1.0 }),
        (0.5, Rule::Increasing { previous: 1.0 }),
        (-2.0, Rule::Increasing { previous: 1.0 }),
        (nan, magnitude),
        (f64::INFINITY, magnitude),
        (1.1e100, magnitude),
    ] {
        let knots = [(0.0, 1.0), (1.0, 1.0), (speed, 1.0), (3.0, 1.0)];
        assert_refused(with(knots), ("speed", Some(2), speed, rule), "speed");
    }
    for coefficient in [0.0, -0.1, nan, f64::INFINITY, 1e-101, 1.1e100] {
        for component in 0..3 {
            let mut knots = [(0.0, 0.4), (0.1, 0.3), (0.2, 0.35)];
            knots[component].1 = coefficient;
            let expected = ("coefficient", Some(component), coefficient, range);
            assert_refused(with(knots), expected, "coefficient");
        }
    }
    // A slope between two knots that no curve of the crate could have.
    for (knots, component, slope) in [
        ([(0.0, 1.0), (1e-150, 2.0), (1.0, 1.5)], 1, 1e150),
        ([(0.0, 1.0), (1.0, 1e100), (1.0_f64.next_up(), 1.0)], 2, -1e100 / f64::EPSILON),
        ([(0.0, 1.0), (5e-324, 2.0), (1.0, 1.5)], 1, f64::INFINITY),
    ] {
        assert_refused(with(knots), ("slope", Some(component), slope, magnitude), "slope");
    }
    // Two knots so close that the cubic between them overflows, however gentle its slope.
    for spacing in [5e-324, 3e-116] {
        let knots = [(0.0, 1.0), (spacing, 1.0), (1.0, 1.5)];
        assert_refused(with(knots), ("spacing", Some(1), spacing, range), "spacing");
    }
    assert_eq!(with([(0.0, 1e-100), (1e100, 1e100)]), Ok(()));
    assert_eq!(with([(-0.0, 0.4), (0.1, 0.4)]), Ok(()));
}

#[test]
fn refusals_read_well() {
    fn spring<T: Scalar>(micro_stiffness: T) -> Result<(), ParameterError> {
        let micro_damping = T::zero();
        KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness, micro_damping }).map(drop)
    }
    fn stribeck<T: Scalar>(static_: f64, dynamic: f64) -> Result<(), ParameterError> {
        let curve = StribeckParameters {
            static_coefficient: lit::<T>(static_),
            dynamic_coefficient: lit(dynamic),
            ..stribeck_parameters()
        };
        Stribeck::new(curve).map(drop)
    }
    let table = |knots: [(f64, f64); 3]| {
        Tabulated::new(knots.map(|(speed, coefficient)| Knot { speed, coefficient })).map(drop)
    };
    let dry = CoulombParameters { dynamic_coefficient: 0.5, viscous_friction: 0.0 };
    let viscous = CoulombParameters { viscous_friction: -0.25, ..dry };
    let plastic = ElastoPlastic::new(Coulomb::new(dry).unwrap(), kelvin_voigt(1e4, 60.0), 6.25e-5);
    let refusals = [
        spring(f64::NAN),
        spring(f32::INFINITY),
        spring(1.5e200),
        // Singles with their own digits, not those of the double next to them.
        spring(-1e-7_f32),
        Coulomb::new(viscous).map(drop),
        stribeck::<f64>(0.4, 0.5),
        stribeck::<f32>(0.1, 0.3),
        table([(0.0, 0.4), (0.2, 0.3), (0.1, 0.3)]),
        table([(0.5, 0.4), (0.2, 0.3), (0.1, 0.3)]),
        table([(0.0, 0.4), (0.2, -3e-7), (0.3, 0.3)]),
        table([(0.0, 0.4), (1e300, 0.4), (0.3, 0.3)]),
        Tabulated::new([] as [Knot<f64>; 0]).map(drop),
        plastic.map(drop),
    ];
    let messages = [
        "micro_stiffness is NaN, but must lie between 1e-100 and 1e100",
        "micro_stiffness is inf, but must lie between 1e-18 and 1e15",
        "micro_stiffness is 1.5e200, but must lie between 1e-100 and 1e100",
        "micro_stiffness is -1e-7, but must lie between 1e-18 and 1e15",
        "viscous_friction is -0.25, but must lie between 0 and 1e100",
        "static_coefficient is 0.4, but must be at least dynamic_coefficient = 0.5",
        "static_coefficient is 0.1, but must be at least dynamic_coefficient = 0.3",
        "speed[2] is 0.1, but must be larger than its predecessor 0.2",
        "speed[0] is 0.5, but must be exactly 0",
        "coefficient[1] is -3e-7, but must lie between 1e-100 and 1e100",
        "speed[1] is 1e300, but must lie between -1e100 and 1e100",
        "there must be at least 2 knots, not 0",
        "stick_limit is 6.25e-5, but must be below min μ/σ0 = 5e-5",
    ];
    for (refused, message) in refusals.into_iter().zip(messages) {
        let error: Box<dyn std::error::Error> = Box::new(refused.unwrap_err());
        assert_eq!(error.to_string(), message);
    }
}

#[test]
fn a_stribeck_exponent_lies_between_a_tenth_and_a_hundred() {
    let with = |stribeck_exponent| {
        Stribeck::new(StribeckParameters { stribeck_exponent, ..stribeck_parameters::<f64>() })
    };
    for exponent in [0.1, 0.5, 100.0] {
        assert!(with(exponent).is_ok(), "{exponent}");
    }
    for exponent in [f64::NAN, f64::INFINITY, -1.0, 0.0, 0.099, 101.0, 1e9] {
        let rule = Rule::Between { least: 0.1, most: 100.0 };
        let expected = ("stribeck_exponent", None, exponent, rule);
        assert_refused(with(exponent).map(drop), expected, "exponent");
    }
}

/// Moderate parameters with one at a limit, with several Stribeck exponents.
fn single_extremes(least: f64, most: f64) -> impl Iterator<Item = (Recipe, f64)> {
    let moderate = Recipe { epsilon: 1e-6, threshold: 1e-6, ..Recipe::TABLE_2 };
    let mut list = vec![
        moderate,
        Recipe { viscous: 0.0, ..moderate },
        Recipe { damping: 0.0, ..moderate },
        Recipe { load: 0.0, ..moderate },
    ];
    for limit in [least, most] {
        list.extend([
            Recipe { dynamic: limit, static_: limit.max(1.5), ..moderate },
            Recipe { dynamic: limit, static_: limit, ..moderate },
            Recipe { static_: limit.max(1.0), ..moderate },
            Recipe { stribeck_velocity: limit, ..moderate },
            Recipe { viscous: limit, ..moderate },
            Recipe { stiffness: limit, ..moderate },
            Recipe { damping: limit, ..moderate },
            Recipe { epsilon: limit, threshold: limit, ..moderate },
            Recipe { load: limit, ..moderate },
        ]);
    }
    let exponents = [0.7, 1.0, 2.0, 3.3, 10.0, 100.0];
    list.into_iter().flat_map(move |r| exponents.map(|exponent| (r, exponent)))
}

fn velocities() -> [f64; 9] {
    [0.0, 1e-300, -1e-300, 1e-9, -1e-9, 1.0, -1.0, 1e3, -1e3]
}

/// Values and slopes of a curve and of a regularisation: finite, and positive where they must be.
fn assert_parts_finite<T: Scalar>(
    curve: &impl FrictionCurve<T>,
    regularisation: &impl Regularisation<T>,
    what: &dyn Fn() -> String,
) {
    for v in velocities() {
        for branch in [Branch::Free, Branch::towards(v)] {
            let sliding = branch.of(lit::<T>(v));
            let (mu, slope) = curve.coefficient_and_slope(sliding);
            assert!(mu > T::zero(), "μ({v:e}) = {mu} of {}", what());
            let (speed, sign) =
                (regularisation.speed_and_slope(sliding), regularisation.sign_and_slope(sliding));
            let all = [mu, slope, speed.0, speed.1, sign.0, sign.1];
            assert!(all.iter().all(|x| x.is_finite()), "{v:e}: {all:?} of {}", what());
        }
        let bounds = curve.bounds(lit(v.abs()));
        assert!(bounds.min > T::zero() && bounds.max.is_finite(), "bounds({v:e}) of {}", what());
    }
    assert!(curve.bounds(T::one() / T::zero()).min > T::zero(), "bounds of {}", what());
}

/// Rate, force and a step of a model: finite. (Derivatives of the force are products of three or
/// four parameters.)
fn assert_model_finite<T: Scalar>(model: AnyBristle<T>, load: T, what: &dyn Fn() -> String) {
    let contact = model.under_load(load).unwrap();
    for v in velocities().map(lit::<T>) {
        for z in [T::zero(), contact.stationary(v)] {
            let (now, held) = (contact.response(v, z), contact.hold(v, z, lit(1e-3)));
            let at = contact.linearised(v, z);
            let values = [now.rate, now.force, held.deflection, held.mean_force, held.end_force];
            let slopes = [
                at.rate_by_deflection,
                at.rate_by_velocity,
                at.force_by_deflection,
                at.force_by_velocity,
            ];
            let finite = values.iter().chain(&slopes).all(|x| x.is_finite());
            assert!(finite, "{} at v = {v}, z = {z}: {values:?} {slopes:?}", what());
        }
    }
}

/// Every curve, regularisation and model at one set of parameters.
fn assert_everything_finite<T: Scalar>(r: &Recipe, exponent: f64) {
    let scalar = std::any::type_name::<T>();
    let name = |part: &str| format!("{part} with δ = {exponent}, {r:?} in {scalar}");
    let (coulomb, stribeck, rational) = (coulomb::<T>(r), stribeck(r, exponent), rational(r));
    let (square_root, tangent) = (square_root(r), hyperbolic_tangent(r));
    assert_parts_finite(&coulomb, &square_root, &|| name("Coulomb, SquareRoot"));
    assert_parts_finite(&stribeck, &tangent, &|| name("Stribeck, HyperbolicTangent"));
    assert_parts_finite(&rational, &tangent, &|| name("RationalStribeck"));

    let (stiffness, damping) = (lit::<T>(r.stiffness), lit(r.damping));
    let (spring, damped) = (spring(stiffness), kelvin_voigt(stiffness, damping));
    let stick_limit = lit::<T>(0.5) * lit::<T>(r.dynamic) / stiffness;
    let models: [(&str, AnyBristle<T>); 8] = [
        ("FrBd on a spring", FrBd::new(stribeck, spring).into()),
        ("FrBd", FrBd::new(stribeck, damped).into()),
        ("FrBd, rational", FrBd::new(rational, damped).into()),
        ("FrBd, square root", FrBd::new(coulomb, damped).regularised(square_root).into()),
        ("FrBd, hyperbolic tangent", FrBd::new(stribeck, damped).regularised(tangent).into()),
        ("LuGre", LuGre::classical(stribeck, damped).into()),
        ("LuGre, viscous part inside", lugre_inside(stribeck, damped).into()),
        ("Dahl", dahl::<T>(r).into()),
    ];
    // The least μ over the largest σ0 is no admissible length.
    let plastic = ElastoPlastic::new(stribeck, damped, stick_limit).ok();
    let plastic = plastic.map(|model| ("ElastoPlastic", model.into()));
    for (part, model) in models.into_iter().chain(plastic) {
        assert_model_finite(model, lit(r.load), &|| name(part));
    }
}

#[test]
fn one_parameter_at_its_limit_leaves_every_answer_finite() {
    for (r, exponent) in single_extremes(1e-100, 1e100) {
        assert_everything_finite::<f64>(&r, exponent);
    }
    for (r, exponent) in single_extremes(1e-18, 1e15) {
        assert_everything_finite::<f32>(&r, exponent);
    }
}

#[test]
fn a_table_of_extreme_numbers_gives_finite_answers() {
    for knots in [
        [(0.0, 1e-100), (1e-100, 1e-50), (1e100, 1e-100)],
        [(0.0, 1e100), (1.5, 1e-100), (3.0, 1e100)],
        [(0.0, 1.0), (1e-100, 1.5), (2e-100, 1.0)],
    ] {
        let curve = bristle_specimens::specimens::table::<f64, 3>(knots);
        for v in velocities() {
            let (mu, slope) = curve.coefficient_and_slope(v.into());
            assert!(mu.is_finite() && slope.is_finite(), "{knots:?} at {v:e}: {mu} {slope}");
            assert!(mu >= 1e-100, "{knots:?} at {v:e}: {mu:e}");
        }
        assert!(curve.bounds(f64::INFINITY).min >= 1e-100);
    }
}

#[test]
fn no_answer_is_a_number_where_the_velocity_is_not_and_no_step_goes_backwards() {
    let nan = f64::NAN;
    for specimen in specimens::<f64>(&Recipe::TABLE_2) {
        let (contact, name) = (&specimen.subject, specimen.name());
        for branch in [Branch::Free, Branch::Forward, Branch::Backward] {
            let response = contact.response(branch.of(nan), 1e-5);
            assert!(response.rate.is_nan() && response.force.is_nan(), "{branch:?} {name}");
        }
        let response = contact.response(0.1, nan);
        assert!(response.rate.is_nan() && response.force.is_nan(), "{name}");
        for (v, z, h) in [(nan, 1e-5, 1e-3), (0.1, nan, 1e-3), (0.1, 1e-5, nan), (0.1, 1e-5, -1e-3)]
        {
            let held = contact.hold(v, z, h);
            let all = [held.deflection, held.end_force, held.mean_force];
            assert!(all.iter().all(|x| x.is_nan()), "{name}: {held:?}");
        }
        let limits = contact.limits(nan);
        assert_eq!((limits.deflection, limits.force, limits.relaxation_rate), (None, None, None));
        assert_eq!(contact.limits(-0.3), contact.limits(0.3));
    }
}

#[test]
fn at_rest_the_free_branch_holds_the_bristle() {
    let contact = table_2_frbd::<f64>().under_load(2.0).unwrap();
    for z in [-1.4e-4, 0.0, 3e-5] {
        for v in [0.0, -0.0] {
            let response = contact.response(v, z);
            // λ = 0 and r = 1: ż = 0, F = p σ0 z, up to μ (1/μ).
            assert_eq!(response.rate, 0.0);
            assert!((response.force - 2e4 * z).abs() <= 4.0 * f64::EPSILON * 2e4 * z.abs());
            assert_eq!(contact.hold(v, z, 1e6).deflection, z);
        }
    }
    assert_eq!(contact.stationary(0.0), 0.0, "the middle of both sides");
    assert_eq!(contact.stationary(Branch::Forward.of(0.0)), 1.5e-4);
    assert_eq!(contact.stationary(Branch::Backward.of(0.0)), -1.5e-4);
}

#[test]
fn a_lifted_contact_has_no_force_and_touches_unstretched() {
    let mut contact = table_2_frbd::<f64>().under_load(0.0).unwrap();
    assert_eq!(contact.force(0.3, 1e-4), 0.0);
    assert_eq!(contact.stored_energy(1e-4), 0.0);
    assert_eq!(contact.reload(5.0, 0.0, 1e-4).unwrap_err().name, "reference_load");
    let pressed = contact.renew(5.0, 1e-4).unwrap();
    assert_eq!((pressed.deflection, pressed.dissipated), (0.0, 0.0), "it touches unstretched");
    assert_eq!(contact.normal_force(), 5.0);
    assert_eq!(contact.force(0.3, 1e-4), 5.0 * contact.model().coefficient(0.3, 1e-4));
}

/// Rate and force on a locked branch are finite at one velocity and NaN at another.
fn assert_pole<M>(model: &M, branch: Branch, before: f64, beyond: f64, z: f64)
where
    M: Bristle<f64>,
    M::Deflection: Deflection<f64>,
{
    let z = M::Deflection::fill(z);
    let at = |v| model.coefficient(branch.of(v), z);
    assert!(at(before).is_finite(), "before {before}");
    assert!(at(beyond).is_nan(), "beyond {beyond}: {}", at(beyond));
    assert!(at(10.0 * beyond).is_nan());
    // The free branch has none.
    assert!(model.coefficient(beyond, z).is_finite());
}

#[test]
fn a_locked_branch_ends_a_third_of_the_way_to_its_pole_and_not_before() {
    let r = Recipe { viscous: 0.5, ..Recipe::TABLE_2 };
    for (branch, d) in [(Branch::Forward, -1.0), (Branch::Backward, 1.0)] {
        for damping in [0.0, 2.0, 64.5] {
            // σ1 s + μ_d + σ2 s is half of what it is at −s: a third of the way to its zero.
            let pole = d * r.dynamic / (damping + r.viscous) / 3.0;
            let (before, beyond) = (pole * (1.0 - 1e-9), pole * (1.0 + 1e-9));
            let bristle = || kelvin_voigt(r.stiffness, damping);
            let frbd = FrBd::new(coulomb::<f64>(&r), bristle());
            assert_pole(&frbd, branch, before, beyond, -d * 5e-5);
            // Beyond the full deflection, where α = 1.
            let plastic = ElastoPlastic::new(coulomb::<f64>(&r), bristle(), 5e-5);
            assert_pole(&plastic.unwrap(), branch, before, beyond, -d * 1.0);
            // LuGre's g knows no damping.
            let pole = d * r.dynamic / r.viscous / 3.0;
            let inside = LuGre::with_viscous_friction(coulomb::<f64>(&r), bristle(), 0.0).unwrap();
            assert_pole(&inside, branch, pole * (1.0 - 1e-9), pole * (1.0 + 1e-9), 5e-5);
            let classical = LuGre::classical(coulomb::<f64>(&r), bristle());
            assert!(classical.coefficient(branch.of(10.0 * pole), 5e-5).is_finite());
        }
        // Derivatives, too.
        let frbd = FrBd::new(coulomb::<f64>(&r), kelvin_voigt(r.stiffness, 2.0));
        let beyond = frbd.linearised(branch.of(d * 0.14), 5e-5);
        assert!(beyond.rate_by_velocity.is_nan() && beyond.coefficient_by_velocity.is_nan());
        let before = frbd.linearised(branch.of(d * 0.13), 5e-5);
        assert!(before.rate_by_velocity.is_finite() && before.coefficient_by_velocity.is_finite());
    }
}
