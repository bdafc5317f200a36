//! What a step costs, counted, and what a model takes of the memory: the tables of
//! docs/embedded.md, line by line.

mod counted;

use std::mem::{size_of, size_of_val};

use bristle::companion::CompanionStep;
use bristle::control::{
    FeedForwardCompensator, FeedForwardParameters, FeedbackCompensator, FeedbackParameters,
    FrictionObserver, Injection, MicroDamping, ObserverParameters, OutputParameters,
    VelocityFromPosition, VelocityFromPositionParameters,
};
use bristle::curve::{
    Coulomb, CoulombParameters, Cubic, FrictionCurve, Knot, RationalStribeck,
    RationalStribeckParameters, Stribeck, StribeckParameters, Tabulated,
};
use bristle::exponential::Exponential;
use bristle::regularisation::Unregularised;
use bristle::rheology::{GeneralisedMaxwell, KelvinVoigt, KelvinVoigtParameters};
use bristle::{
    Bristle, Contact, Dahl, DahlParameters, ElastoPlastic, FrBd, ImplicitBristle, LuGre, Scalar,
    paper,
};
use bristle_adaptation::{AdaptiveFriction, AdaptiveFrictionParameters, FrictionEstimate, Sample};
use counted::{Counted, Counts, counts};
use nalgebra::{Vector2, convert};

const DOCUMENT: &str = include_str!("../../../docs/embedded.md");

fn lit<T: Scalar>(value: f64) -> T {
    convert(value)
}

/// The curve of Table 2 with another exponent.
fn stribeck<T: Scalar>(exponent: f64) -> Stribeck<T> {
    Stribeck::new(StribeckParameters {
        static_coefficient: lit(paper::STICK_SLIP_CURVE.static_coefficient),
        dynamic_coefficient: lit(paper::STICK_SLIP_CURVE.dynamic_coefficient),
        stribeck_velocity: lit(paper::STICK_SLIP_CURVE.stribeck_velocity),
        stribeck_exponent: lit(exponent),
        viscous_friction: lit(paper::STICK_SLIP_CURVE.viscous_friction),
    })
    .unwrap()
}

fn bristle<T: Scalar>() -> KelvinVoigt<T> {
    KelvinVoigt::new(KelvinVoigtParameters {
        micro_stiffness: lit(paper::STICK_SLIP_BRISTLE.micro_stiffness),
        micro_damping: lit(paper::STICK_SLIP_BRISTLE.micro_damping),
    })
    .unwrap()
}

fn rational<T: Scalar>() -> RationalStribeck<T> {
    RationalStribeck::new(RationalStribeckParameters {
        static_coefficient: lit(1.5),
        dynamic_coefficient: lit(1.0),
        stribeck_velocity: lit(0.01),
        viscous_friction: lit(0.04),
    })
    .unwrap()
}

fn tabulated<T: Scalar>() -> Tabulated<[Cubic<T>; 8]> {
    let speeds = [0.0, 0.004, 0.007, 0.011, 0.016, 0.023, 0.05, 1.0];
    let curve = stribeck::<f64>(2.0);
    Tabulated::new(
        speeds.map(|speed| Knot { speed: lit(speed), coefficient: lit(curve.at(speed)) }),
    )
    .unwrap()
}

fn coulomb<T: Scalar>() -> Coulomb<T> {
    Coulomb::new(CoulombParameters { dynamic_coefficient: lit(1.0), viscous_friction: lit(0.04) })
        .unwrap()
}

fn dahl<T: Scalar>() -> Dahl<T> {
    Dahl::new(DahlParameters { dynamic_coefficient: lit(1.0), micro_stiffness: lit(1e4) }).unwrap()
}

fn elasto_plastic<T: Scalar>() -> ElastoPlastic<Stribeck<T>, KelvinVoigt<T>, Unregularised, T> {
    ElastoPlastic::new(stribeck(2.0), bristle(), lit(5e-5)).unwrap()
}

fn implicit<T: Scalar>() -> ImplicitBristle<Stribeck<T>, T> {
    ImplicitBristle::new(stribeck(2.0), bristle()).unwrap()
}

fn zener<T: Scalar>() -> FrBd<Stribeck<T>, GeneralisedMaxwell<T, 2>> {
    let parameters = bristle::rheology::ZenerParameters {
        static_stiffness: lit(1e4),
        relaxing_stiffness: lit(2e4),
        series_damping: lit(100.0),
    };
    FrBd::new(stribeck(2.0), GeneralisedMaxwell::zener(parameters).unwrap())
}

fn frbd<T: Scalar, C: FrictionCurve<T>>(curve: C) -> FrBd<C, KelvinVoigt<T>> {
    FrBd::new(curve, bristle())
}

/// Sliding in the Stribeck range: the curve needs its exponential.
const VELOCITY: Counted = Counted(0.008);
/// Between the stick limit and the curve: an elasto-plastic bristle needs its sine.
const DEFLECTION: Counted = Counted(1.1e-4);
/// λh = 0.05: the step of the bristle needs none. Beyond ½ it does.
const SHORT: Counted = Counted(1e-3);
const LONG: Counted = Counted(2e-2);

fn cell(counts: Counts) -> String {
    let Counts { add, mul, div, sqrt, exp, pow, other } = counts;
    let mut cell = format!("{add} + {mul} + {div}");
    for (count, name) in [(sqrt, "√"), (exp, "exp"), (pow, "pow"), (other, "sin, cos")] {
        if count > 0 {
            cell += &if count == 1 { format!(", {name}") } else { format!(", {count} {name}") };
        }
    }
    cell
}

fn line<M: Bristle<Counted>>(
    name: &str,
    model: M,
    deflection: M::Deflection,
    drag: &dyn Fn(&Contact<Counted, M>) -> String,
) -> String {
    let contact = model.under_load(Counted(1.0)).unwrap();
    let response = counts(|| contact.response(VELOCITY, deflection));
    let hold = |duration| cell(counts(|| contact.hold(VELOCITY, deflection, duration)));
    let companion = contact.clone().companion(Counted(1.0)).unwrap();
    let passive = counts(|| companion.step(VELOCITY, deflection, SHORT).commit(VELOCITY));
    format!(
        "| {name} | {} | {} | {} | {} | {} |",
        cell(response),
        hold(SHORT),
        hold(LONG),
        cell(passive),
        drag(&contact)
    )
}

fn one_spring<M: Bristle<Counted, Deflection = Counted>>(name: &str, model: M) -> String {
    line(name, model, DEFLECTION, &|contact| {
        let ramp = VELOCITY..Counted(0.009);
        cell(counts(|| Exponential::<3>.ramp(contact, ramp, DEFLECTION, SHORT)))
    })
}

/// Says which lines the document lacks, and how they should be.
fn check(lines: &[String]) {
    let missing: Vec<_> = lines.iter().filter(|line| !DOCUMENT.contains(line.as_str())).collect();
    assert!(
        missing.is_empty(),
        "docs/embedded.md lacks of {}:\n{}",
        missing.len(),
        lines.join("\n")
    );
}

#[test]
fn the_document_tells_the_operations_of_every_step() {
    check(&[
        one_spring("FrBD, Coulomb", frbd(coulomb())),
        one_spring("FrBD, rational", frbd(rational())),
        one_spring("FrBD, tabulated (8)", frbd(tabulated())),
        one_spring("FrBD, Stribeck δ = 2", frbd(stribeck(2.0))),
        one_spring("FrBD, Stribeck δ = 0.7", frbd(stribeck(0.7))),
        one_spring("LuGre, Stribeck δ = 2", LuGre::classical(stribeck(2.0), bristle())),
        one_spring("Dahl", dahl()),
        one_spring("elasto-plastic, Stribeck δ = 2", elasto_plastic()),
        one_spring("implicit, Stribeck δ = 2", implicit()),
        line(
            "FrBD, Zener, Stribeck δ = 2",
            zener(),
            Vector2::new(DEFLECTION, Counted(1e-5)),
            &|_| "–".into(),
        ),
    ]);
}

#[test]
fn a_loop_without_exponentials_has_none() {
    let none = |counts: Counts| {
        assert_eq!((counts.exp, counts.pow, counts.sqrt, counts.other), (0, 0, 0, 0));
    };
    let quick = frbd(rational()).under_load(Counted(1.0)).unwrap();
    let table = frbd(tabulated()).under_load(Counted(1.0)).unwrap();
    for index in -200_i32..=200 {
        let velocity = Counted(1e-7 * 1.12_f64.powi(index.abs()) * f64::from(index.signum()));
        // λ never exceeds σ0/(σ1 + σ2), nor does σ0/σ1: h of less than σ1/(2 σ0) keeps λh below ½.
        let step = Counted(0.49 * 64.5 / 1e4);
        none(counts(|| quick.hold(velocity, DEFLECTION, step)));
        none(counts(|| table.hold(velocity, DEFLECTION, step)));
        let companion = quick.companion(Counted(1.0)).unwrap();
        none(counts(|| companion.step(velocity, DEFLECTION, step).commit(velocity)));
    }
    // Beyond, it takes one.
    assert_eq!(counts(|| quick.hold(Counted(10.0), DEFLECTION, Counted(0.01))).exp, 1);
}

fn bytes<T: Scalar, M: Bristle<T>>(_: M) -> [usize; 3] {
    let contact = size_of::<Contact<T, M>>();
    [contact, size_of::<CompanionStep<T, M::Deflection>>(), size_of::<M::Deflection>()]
}

fn size_line(name: &str, single: [usize; 3], double: [usize; 3]) -> String {
    let both = |part: usize| format!("{}, {}", single[part], double[part]);
    format!("| {name} | {} | {} | {} |", both(0), both(1), both(2))
}

#[test]
fn the_document_tells_the_memory_of_every_model() {
    macro_rules! line {
        ($name:expr, $model:expr) => {
            size_line($name, bytes::<f32, _>($model), bytes::<f64, _>($model))
        };
    }
    check(&[
        line!("FrBD, Coulomb", frbd(coulomb())),
        line!("FrBD, rational", frbd(rational())),
        line!("FrBD, tabulated (8)", frbd(tabulated())),
        line!("FrBD, Stribeck", frbd(stribeck(2.0))),
        line!("LuGre, Stribeck", LuGre::classical(stribeck(2.0), bristle())),
        line!("Dahl", dahl()),
        line!("elasto-plastic, Stribeck", elasto_plastic()),
        line!("implicit, Stribeck", implicit()),
        line!("FrBD, Zener, Stribeck", zener()),
    ]);
}

fn filter<T: Scalar>() -> VelocityFromPositionParameters<T> {
    VelocityFromPositionParameters {
        sample_time: lit(1e-3),
        time_constant: lit(4e-3),
        fastest: lit(1.0),
        count: lit(1e-6),
    }
}

fn output<T: Scalar>() -> OutputParameters<T> {
    OutputParameters { share: lit(1.0), largest_force: lit(3.0) }
}

fn feed_forward<T: Scalar, M: Bristle<T, Deflection = T>>(
    model: M,
) -> FeedForwardCompensator<T, M> {
    FeedForwardCompensator::new(FeedForwardParameters {
        contact: model.under_load(lit(1.0)).unwrap(),
        sample_time: lit(1e-3),
        fastest: lit(1.0),
        output: output(),
    })
    .unwrap()
}

fn feedback<T: Scalar, M: Bristle<T, Deflection = T>>(
    model: M,
    damping: MicroDamping,
) -> FeedbackCompensator<T, M> {
    FeedbackCompensator::new(FeedbackParameters {
        contact: model.under_load(lit(1.0)).unwrap(),
        velocity: filter(),
        damping,
        output: output(),
    })
    .unwrap()
}

fn observer<T: Scalar, M: Bristle<T, Deflection = T>>(
    model: M,
    injection: Injection<T>,
) -> FrictionObserver<T, M> {
    FrictionObserver::new(ObserverParameters {
        contact: model.under_load(lit(1.0)).unwrap(),
        mass: lit(1.0),
        proportional_gain: lit(400.0),
        // More than m σ0/σ1.
        derivative_gain: lit(200.0),
        integral_gain: lit(1000.0),
        injection,
        velocity: filter(),
        output: output(),
    })
    .unwrap()
}

fn adaptive<T: Scalar, M: Bristle<T>>(model: M) -> AdaptiveFriction<T, M> {
    let all = |value| {
        let [idle_load, load_share, drag, offset] = [lit(value); 4];
        FrictionEstimate { idle_load, load_share, drag, offset }
    };
    AdaptiveFriction::new(AdaptiveFrictionParameters {
        model,
        mass: lit(1.0),
        sample_time: lit(1e-3),
        corner: lit(100.0),
        slowest: lit(1e-3),
        fastest: lit(1.0),
        noise: lit(0.01),
        memory: lit(1.0),
        start: all(1.0),
        least: all(0.0),
        most: all(2.0),
    })
    .unwrap()
}

fn by_velocity<T: Scalar>() -> Injection<T> {
    Injection::Velocity { gain: lit(0.1), corner: lit(10.0) }
}

fn by_position<T: Scalar>() -> Injection<T> {
    Injection::Position { gain: lit(0.1) }
}

/// One sample in the Stribeck range, after many that have brought the bristle there.
fn sample(mut step: impl FnMut(Counted)) -> String {
    let mut position = 0.0;
    let mut next = || {
        position += 1e-3 * VELOCITY.0;
        step(Counted(position));
    };
    (0..50).for_each(|_| next());
    cell(counts(next))
}

#[test]
fn the_document_tells_operations_and_memory_of_every_compensator() {
    macro_rules! line {
        ($name:expr, $build:expr, |$it:ident, $position:ident| $step:expr) => {{
            let mut a = $build(stribeck::<Counted>(2.0));
            let mut b = $build(rational::<Counted>());
            let first = sample(|$position| {
                let $it = &mut a;
                let _ = std::hint::black_box($step);
            });
            let quick = sample(|$position| {
                let $it = &mut b;
                let _ = std::hint::black_box($step);
            });
            let single = size_of_val(&$build(stribeck::<f32>(2.0)));
            let double = size_of_val(&$build(stribeck::<f64>(2.0)));
            format!("| {} | {first} | {quick} | {single}, {double} |", $name)
        }};
    }
    check(&[
        line!("`FeedForwardCompensator`", |curve| feed_forward(frbd(curve)), |it, _position| {
            it.step(VELOCITY)
        }),
        line!(
            "`FeedbackCompensator`",
            |curve| feedback(frbd(curve), MicroDamping::Uncompensated),
            |it, position| it.step(position)
        ),
        line!(
            "the same with its damping",
            |curve| feedback(frbd(curve), MicroDamping::Filtered),
            |it, position| it.step(position)
        ),
        line!(
            "`FrictionObserver`, by velocity",
            |curve| observer(frbd(curve), by_velocity()),
            |it, position| it.step(position, position)
        ),
        line!(
            "`FrictionObserver`, by position",
            |curve| observer(frbd(curve), by_position()),
            |it, position| it.step(position, position)
        ),
        line!("`AdaptiveFriction`", |curve| adaptive(frbd(curve)), |it, _position| {
            let [force, load] = [2.8, 0.5].map(Counted);
            it.step(Sample { displacement: VELOCITY * SHORT, force, load })
        }),
    ]);
    let mut encoder = VelocityFromPosition::new(filter()).unwrap();
    let operations = sample(|position| {
        let _ = encoder.step(position);
    });
    let [single, double] =
        [size_of::<VelocityFromPosition<f32>>(), size_of::<VelocityFromPosition<f64>>()];
    check(&[format!("| `VelocityFromPosition` | {operations} | the same | {single}, {double} |")]);
}
