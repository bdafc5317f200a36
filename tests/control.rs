//! Friction compensation: the theorems of the observer, effects of the encoder, bad samples, and
//! the figures of the example `friction_compensation`.
#![allow(clippy::unwrap_used, reason = "a test panics to fail")]

use bristle::control::{
    Compensation, FeedForwardCompensator, FeedForwardParameters, FeedbackCompensator,
    FeedbackParameters, FrictionObserver, Injection, Measured, MicroDamping, ObserverParameters,
    OutputParameters, VelocityFromPosition, VelocityFromPositionParameters,
};
use bristle::curve::{Asymmetric, Stribeck};
use bristle::parameter::ParameterError;
use bristle::regularisation::{HyperbolicTangent, Regularisation, SquareRoot, Unregularised};
use bristle::rheology::{KelvinVoigt, Maxwell, MaxwellParameters};
use bristle::{
    Affine, Bristle, Characteristics, Contact, Dahl, DahlParameters, Form, FrBd, LuGre, Scalar,
    Surface,
};
use bristle_specimens::lit;
use bristle_specimens::recipe::Recipe;
use bristle_specimens::specimens::{coulomb, kelvin_voigt, stribeck};
use proptest::prelude::*;

#[allow(dead_code, reason = "its `main` and its chart are not needed here")]
#[path = "../examples/friction_compensation.rs"]
mod example;

type FrBdFriction = FrBd<Stribeck<f64>, KelvinVoigt<f64>>;
type Friction = Contact<f64, FrBdFriction>;
type LuGreFriction = Contact<f64, LuGre<Stribeck<f64>, KelvinVoigt<f64>>>;

const LOAD: f64 = 3.0;
const FRICTION: Recipe = Recipe { viscous: 0.4, load: LOAD, ..Recipe::TABLE_2 };
const MICRO_DAMPING: f64 = 60.0;

fn friction() -> Friction {
    friction_of(MICRO_DAMPING)
}

fn friction_of<T: Scalar>(micro_damping: f64) -> Contact<T, FrBd<Stribeck<T>, KelvinVoigt<T>>> {
    let bristle = kelvin_voigt(lit(1e4), lit(micro_damping));
    FrBd::new(stribeck(&FRICTION, 2.0), bristle).under_load(lit(LOAD)).unwrap()
}

/// Micro-damping [s/m]: a large one, and one so small that it cannot hide an error of the
/// deflection.
fn dampings() -> impl Strategy<Value = f64> {
    prop::sample::select(vec![60.0, 0.5])
}

fn lugre() -> LuGreFriction {
    let bristle = kelvin_voigt(1e4, MICRO_DAMPING);
    LuGre::classical(stribeck(&FRICTION, 2.0), bristle).under_load(LOAD).unwrap()
}

fn output(share: f64) -> OutputParameters<f64> {
    OutputParameters { share, largest_force: 1e6 }
}

fn filtered(sample_time: f64, time_constant: f64) -> VelocityFromPositionParameters<f64> {
    VelocityFromPositionParameters { sample_time, time_constant, fastest: 1.0, count: 0.0 }
}

fn sampled(sample_time: f64) -> VelocityFromPositionParameters<f64> {
    filtered(sample_time, 0.0)
}

fn observer_parameters<M>(
    contact: Contact<f64, M>,
    injection: Injection<f64>,
    sample_time: f64,
) -> ObserverParameters<f64, M> {
    ObserverParameters {
        contact,
        mass: 2.0,
        proportional_gain: 800.0,
        derivative_gain: 60.0,
        integral_gain: 0.0,
        injection,
        velocity: sampled(sample_time),
        output: output(1.0),
    }
}

fn feed_forward(
    sample_time: f64,
    output: OutputParameters<f64>,
) -> Result<FeedForwardCompensator<f64, FrBdFriction>, ParameterError> {
    let (contact, fastest) = (friction(), 1.0);
    FeedForwardCompensator::new(FeedForwardParameters { contact, sample_time, fastest, output })
}

fn fed_forward(sample_time: f64) -> FeedForwardCompensator<f64, FrBdFriction> {
    feed_forward(sample_time, output(1.0)).unwrap()
}

fn feedback_of<M: Bristle<f64, Deflection = f64>>(
    contact: Contact<f64, M>,
    velocity: VelocityFromPositionParameters<f64>,
    damping: MicroDamping,
    share: f64,
) -> FeedbackCompensator<f64, M> {
    let output = output(share);
    FeedbackCompensator::new(FeedbackParameters { contact, velocity, damping, output }).unwrap()
}

fn feedback(sample_time: f64, time_constant: f64) -> FeedbackCompensator<f64, FrBdFriction> {
    let velocity = filtered(sample_time, time_constant);
    feedback_of(friction(), velocity, MicroDamping::Uncompensated, 1.0)
}

fn refusal<T: core::fmt::Debug, E: core::fmt::Display>(result: Result<T, E>) -> String {
    result.unwrap_err().to_string()
}

#[test]
fn an_observer_whose_gains_break_the_condition_is_refused_with_number_and_limit() {
    let velocity = |corner| Injection::Velocity { gain: 0.2, corner };
    // α m < K_d: 2 kg · 30/s is just too much for 60 N s/m.
    assert!(FrictionObserver::new(observer_parameters(friction(), velocity(29.9), 1e-3)).is_ok());
    assert_eq!(
        refusal(FrictionObserver::new(observer_parameters(friction(), velocity(30.0), 1e-3))),
        "corner × mass is 60, but must be below derivative_gain = 60"
    );
    // K_i < α K_p
    let with_integral = |integral_gain| ObserverParameters {
        integral_gain,
        ..observer_parameters(friction(), velocity(20.0), 1e-3)
    };
    assert!(FrictionObserver::new(with_integral(15_999.0)).is_ok());
    assert_eq!(
        refusal(FrictionObserver::new(with_integral(16_000.0))),
        "integral_gain is 16000, but must be below corner × proportional_gain = 16000"
    );
    // By position σ0/σ1 takes the place of α: K_d > 2 · 1e4/60 = 333.3 N s/m.
    let position = |derivative_gain| ObserverParameters {
        derivative_gain,
        ..observer_parameters(friction(), Injection::Position { gain: 1.0 }, 1e-3)
    };
    assert!(FrictionObserver::new(position(334.0)).is_ok());
    assert!(refusal(FrictionObserver::new(position(333.0))).contains("derivative_gain = 333"));
    // Every number, NaN first.
    for bad in [f64::NAN, f64::INFINITY, -1.0, 0.0] {
        let at = |change: &dyn Fn(&mut ObserverParameters<f64, _>)| {
            let mut parameters = observer_parameters(friction(), velocity(20.0), 1e-3);
            change(&mut parameters);
            FrictionObserver::new(parameters).is_err()
        };
        assert!(at(&|p| p.mass = bad), "{bad}");
        assert!(at(&|p| p.proportional_gain = bad), "{bad}");
        assert!(at(&|p| p.derivative_gain = bad), "{bad}");
        assert!(bad == 0.0 || at(&|p| p.integral_gain = bad), "{bad}");
        assert!(at(&|p| p.velocity.fastest = bad), "{bad}");
        assert!(at(&|p| p.velocity.sample_time = bad), "{bad}");
        assert!(bad == 0.0 || at(&|p| p.velocity.time_constant = bad), "{bad}");
        assert!(bad == 0.0 || at(&|p| p.output.share = bad), "{bad}");
        assert!(at(&|p| p.output.share = 2.001) && !at(&|p| p.output.share = 2.0));
        assert!(at(&|p| p.output.largest_force = bad), "{bad}");
        assert!(at(&|p| p.injection = Injection::Velocity { gain: bad, corner: 1.0 }), "{bad}");
        assert!(at(&|p| p.injection = velocity(bad)), "{bad}");
        assert!(at(&|p| p.injection = Injection::Position { gain: bad }), "{bad}");
        assert!(feed_forward(bad, output(1.0)).is_err());
        assert!(bad == 0.0 || feed_forward(1e-3, output(bad)).is_err());
        assert!(VelocityFromPosition::new(filtered(bad, 0.0)).is_err());
        assert!(bad == 0.0 || VelocityFromPosition::new(filtered(1.0, bad)).is_err());
    }
}

/// LuGre's numbers and characteristics, but backwards for a factor of c₀ and one of c₂; with a
/// factor of zero it gives no characteristics.
#[derive(Debug, Clone, Copy)]
struct Factors<M>(M, f64, f64);

impl<M: Bristle<f64, Deflection = f64>> Bristle<f64> for Factors<M> {
    type Deflection = f64;

    fn affine(&self, surface: Surface<f64>, z: f64) -> Affine<f64> {
        self.affine_and_slopes(surface, z).0
    }

    fn affine_and_slopes(&self, surface: Surface<f64>, z: f64) -> (Affine<f64>, Affine<f64>) {
        let (of, slopes) = self.0.affine_and_slopes(surface, z);
        if surface.velocity() > 0.0 {
            return (of, slopes);
        }
        (Affine { stiffness: self.1 * of.stiffness, damping: self.2 * of.damping, ..of }, slopes)
    }

    fn stationary(&self, surface: impl Into<Surface<f64>>) -> f64 {
        self.0.stationary(surface)
    }

    fn storage_stiffness(&self) -> f64 {
        self.0.storage_stiffness()
    }

    fn form(&self) -> Form {
        self.0.form()
    }

    fn characteristics(&self, fastest: f64) -> Option<Characteristics<f64>> {
        self.0.characteristics(fastest).filter(|_| self.2 != 0.0)
    }
}

#[test]
fn an_observer_of_numbers_that_no_theorem_knows_is_refused() {
    let contact = lugre();
    let (model, load) = (*contact.model(), contact.normal_force());
    let built = |c0, c2, injection, error| {
        let model = Factors(model, c0, c2);
        let of = observer_parameters(model.under_load(load).unwrap(), injection, 1e-3);
        let velocity = VelocityFromPositionParameters { fastest: 0.05, ..of.velocity };
        let parameters = ObserverParameters { derivative_gain: 1e5, velocity, ..of };
        match FrictionObserver::new(parameters) {
            Ok(_) => assert_eq!(error, ""),
            Err(refusal) => assert!(refusal.to_string().contains(error), "{refusal}"),
        }
    };
    let velocity = Injection::Velocity { gain: 1.0, corner: 10.0 };
    built(1.0, 1.0, velocity, "");
    built(1.0, -1.0, velocity, "LuGre's coefficients");
    built(1.1, 1.0, velocity, "LuGre's coefficients");
    built(1.0, 1.0, Injection::Position { gain: 1.0 }, "");
    built(1.1, 1.0, Injection::Position { gain: 1.0 }, "c₀ is σ0 − σ1 λ");
    // Neither σ1 nor a name; and σ1 = 0.
    let unknown = "(Injection::Velocity does without), not an unnamed model (see Bristle::name)";
    built(1.0, 0.0, Injection::Position { gain: 1.0 }, unknown);
    let dahl = DahlParameters { dynamic_coefficient: 1.0, micro_stiffness: 1e4 };
    let contact = Dahl::new(dahl).unwrap().under_load(1.0).unwrap();
    let parameters = observer_parameters(contact, Injection::Position { gain: 1.0 }, 1e-3);
    let refused = refusal(FrictionObserver::new(parameters));
    assert!(refused.starts_with("micro_damping is 0, but must be positive for Inj"), "{refused}");
}

#[test]
fn an_observer_of_lugre_is_refused_beyond_the_speed_at_which_its_error_gives_energy() {
    // σ1² λ ≤ 4 σ0 (σ1 + σ2) with λ ≤ σ0 v/μ_d: v ≤ 4 (60 + 0.4) · 1/3600 = 67.1 mm/s for the least
    // g.
    let injection = Injection::Velocity { gain: 0.2, corner: 20.0 };
    let upto = |fastest| ObserverParameters {
        velocity: VelocityFromPositionParameters { fastest, ..sampled(1e-3) },
        ..observer_parameters(lugre(), injection, 1e-3)
    };
    assert!(FrictionObserver::new(upto(0.067)).is_ok());
    let refused = refusal(FrictionObserver::new(upto(0.068)));
    assert!(refused.starts_with("relaxation rate at the fastest speed is 68"), "{refused}");
    assert!(refused.contains("at most 4 σ0 (σ1 + σ2)/σ1² = 671.1"), "{refused}");
    // FrBD has no such limit.
    let fast = observer_parameters(friction(), injection, 1e-3);
    let velocity = VelocityFromPositionParameters { fastest: 1e3, ..sampled(1e-3) };
    assert!(FrictionObserver::new(ObserverParameters { velocity, ..fast }).is_ok());
}

/// The true bristle and its estimate over one sample, with velocity and injection y held: the
/// energy h k y F̃̄ that the error takes up, and the change of its stored energy. F̃̄ comes from
/// the two exact means.
fn error_energy<M: Bristle<f64, Deflection = f64>>(
    contact: &Contact<f64, M>,
    (v, z, estimate): (f64, f64, f64),
    injected: f64,
    after: f64,
    h: f64,
) -> (f64, f64) {
    let truth = contact.hold(v, z, h);
    let affine = contact.model().affine(v.into(), z);
    let model = affine.hold(v - injected, estimate, h);
    let error = truth.mean_force - contact.normal_force() * model.mean_coefficient;
    let stored =
        contact.stored_energy(truth.deflection - after) - contact.stored_energy(z - estimate);
    (h * error * injected, stored)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// h k y F̃̄ ≥ ΔW̃ for every state, velocity, injection and sample time, with the estimate that
    /// the observer computes.
    #[test]
    fn the_error_of_an_frbd_observer_never_gives_energy(
        v in -1.0..1.0f64, z in -1.5e-4..1.5e-4f64, error in -0.1..0.1f64,
        rate in -1.0..1.0f64, gain in 1e-3..2.0f64, exponent in -5.0..0.0f64, steps in 1usize..6,
        size in -4.0..0.0f64, damping in dampings(),
    ) {
        let h = 10f64.powf(exponent);
        let contact = friction_of(damping);
        let corner = 20.0;
        let injection = Injection::Velocity { gain, corner };
        let parameters = observer_parameters(contact, injection, h);
        let mut observer = FrictionObserver::new(parameters).unwrap();

        // Over four decades, so that some are as small as the deflection's share of the rate.
        let (rate, error) = (rate * 10f64.powf(size), error * 10f64.powf(size));
        let injected = gain * (rate + corner * error);
        let mut z = z;
        for _ in 0..steps {
            let before = observer.deflection();
            let answer = observer.step_measured(Measured { velocity: v, error, error_rate: rate });
            let affine = contact.model().affine(v.into(), z);
            let wanted = LOAD * affine.coefficient(v - injected, observer.deflection());
            prop_assert!((answer.force - wanted).abs() <= 1e-12 * (1.0 + wanted.abs()));
            let (taken, stored) =
                error_energy(&contact, (v, z, before), injected, observer.deflection(), h);
            z = contact.hold(v, z, h).deflection;
            // Rounding of the products, all of them below this scale.
            let scale = h * injected.abs() * LOAD * (1.5 + 70.0 * (1.0 + injected.abs())) + 1e-3;
            prop_assert!(taken - stored >= -1e-12 * scale, "{taken} {stored}");
        }
    }

}

proptest! {
    // Each case is a run of thousands of samples.
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// The tracking error is solved by the implicit midpoint rule, which is passive. Then W̃/k + V
    /// never rises, and the errors of tracking and force decay, for every admissible gain and
    /// sample time.
    #[test]
    fn an_observed_loop_converges_for_every_admissible_gain_at_any_sample_time(
        gain in 0.05..1.0f64, part in 0.1..0.95f64,
        // None, or enough for its pole K_i/K_p to be settled in the time given.
        integral in prop_oneof![1 => Just(0.0), 3 => 0.1..0.9f64],
        exponent in -2.3..-0.5f64, start in -1.4e-4..1.4e-4f64, speed in 0.005..0.2f64,
        light in dampings(),
    ) {
        let h = 10f64.powf(exponent);
        let (mass, stiffness, damping) = (2.0, 800.0, 60.0);
        let contact = friction_of(light);
        let corner = part * damping / mass;
        let integral_gain = integral * corner * stiffness;
        let mut observer = FrictionObserver::new(ObserverParameters {
            integral_gain,
            ..observer_parameters(contact, Injection::Velocity { gain, corner }, h)
        }).unwrap();
        let (mut e, mut rate, mut sum, mut z) = (0.0, 0.0, 0.0, start);
        let level = |e: f64, rate: f64, sum: f64, error: f64| {
            contact.stored_energy(error) / gain
                + 0.5 * mass * rate * rate + corner * mass * e * rate
                + 0.5 * (stiffness + corner * damping) * e * e
                + integral_gain * e * sum + 0.5 * corner * integral_gain * sum * sum
        };
        let first = level(e, rate, sum, z - observer.deflection());
        let mut last = first;
        let mut time = 0.0;
        let mut n = 0u32;
        // Long enough for the slowest pole of the tracking error.
        while time < 60.0 || n < 400 {
            // The velocity, known: to and fro.
            let v = if (n / 7).is_multiple_of(2) { speed } else { -speed };
            let truth = contact.hold(v, z, h);
            let affine = contact.model().affine(v.into(), z);
            let before = observer.deflection();
            // Mean error of the force is a + b y; midpoint of the tracking error for y held.
            let estimated = |y: f64| affine.hold(v - gain * y, before, h).mean_coefficient;
            let of = |y: f64| truth.mean_force - LOAD * estimated(y);
            let (a, b) = (of(0.0), of(1.0) - of(0.0));
            // Unknown: mean rate w of e. e' = e + h w/2, q' = q + h e'/2, acceleration 2(w −
            // rate)/h.
            let midpoint = |w: f64| {
                let mean = e + 0.5 * h * w;
                let q = sum + 0.5 * h * mean;
                let y = w + corner * mean;
                let controller = damping * w + stiffness * mean + integral_gain * q;
                2.0 * mass * (w - rate) / h + controller + a + b * y
            };
            let w = -midpoint(0.0) / (midpoint(1.0) - midpoint(0.0));
            let mean = e + 0.5 * h * w;
            let _ = observer.step_measured(Measured { velocity: v, error: mean, error_rate: w });
            (e, rate, sum) = (e + h * w, 2.0 * w - rate, sum + h * mean);
            z = truth.deflection;
            let now = level(e, rate, sum, z - observer.deflection());
            // Rounding of numbers as large as the first level.
            prop_assert!(now <= last + 1e-12 * first, "sample {n}: {last} to {now}");
            last = now;
            time += h;
            n += 1;
        }
        prop_assert!(last <= 1e-6 * first, "{last} of {first} is left");
    }

    /// By position G is strictly positive real in continuous time: here the samples are far shorter
    /// than all time constants.
    #[test]
    fn the_classical_injection_converges_for_frbd_as_for_lugre(
        gain in 1.0..50.0f64, start in -1.4e-4..1.4e-4f64, speed in 0.005..0.06f64,
        excess in 1.1..3.0f64,
    ) {
        let h = 1e-4;
        let damping = excess * 2.0 * 1e4 / 60.0;
        let parameters = |contact| ObserverParameters {
            derivative_gain: damping, proportional_gain: 2e4,
            ..observer_parameters(contact, Injection::Position { gain }, h)
        };
        let mut frbd = FrictionObserver::new(parameters(friction())).unwrap();
        let contact = friction();
        let (mut e, mut rate, mut z) = (0.0f64, 0.0, start);
        let mut greatest: f64 = 0.0;
        for n in 0..10_000 {
            let v = if (n / 500) % 2 == 0 { speed } else { -speed };
            let truth = contact.hold(v, z, h);
            z = truth.deflection;
            let answer = frbd.step_measured(Measured { velocity: v, error: e, error_rate: rate });
            let force = truth.end_force - answer.force;
            // Semi-implicit Euler of the tracking error.
            rate = (rate - h / 2.0 * (2e4 * e + force)) / (1.0 + h * damping / 2.0);
            e += h * rate;
            greatest = greatest.max(e.abs());
        }
        prop_assert!(e.abs() < 1e-3 * greatest, "{e} of {greatest}");
        prop_assert!((z - frbd.deflection()).abs() < 1e-3 * start.abs() + 1e-12);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// Two compensators of one model under one encoder forget what they started from.
    #[test]
    fn estimates_along_the_same_displacements_never_diverge(
        counts in prop::collection::vec(-40i32..40, 1..60), first in -150i32..150,
        exponent in -5.0..0.0f64, tau in 0.0..0.1f64,
    ) {
        let h = 10f64.powf(exponent);
        let (mut one, mut other) = (feedback(h, tau), feedback(h, tau));
        // The other is moved first.
        let _ = one.advance(0.0);
        let _ = other.advance(1e-6 * f64::from(first));
        let _ = other.advance(-1e-6 * f64::from(first));
        let mut apart = f64::INFINITY;
        for count in counts {
            let move_by = 1e-6 * f64::from(count);
            let a = one.advance(move_by).deflection;
            let b = other.advance(move_by).deflection;
            // Both read the curve at the same speed once their filters agree: without a filter at
            // once.
            if tau == 0.0 {
                prop_assert!((a - b).abs() <= apart + 1e-18);
                apart = (a - b).abs();
            }
            prop_assert!(a.abs() <= 1.5e-4 * (1.0 + 1e-12) && b.abs() <= 1.5e-4 * (1.0 + 1e-12));
        }
    }

    /// s p K q (1 + max μ/min μ), for every deflection and sample time.
    #[test]
    fn one_count_moves_the_force_by_no_more_than_the_bound(
        counts in prop::collection::vec(-30i32..30, 1..40), flicker in prop::bool::ANY,
        exponent in -5.0..0.0f64, tau in 0.0..0.1f64,
    ) {
        let count = 1e-6;
        let mut compensator = feedback(10f64.powf(exponent), tau);
        let bound = compensator.step_per_count(count).unwrap();
        // p K q (1 + max μ/min μ), where the first is estimated from above.
        let elastic = LOAD * 1e4 * count;
        prop_assert!(bound >= elastic * 2.5 * (1.0 - 1e-12) && bound <= elastic * 2.95);
        let mut at = 0i32;
        for move_by in counts {
            at += move_by;
            let _ = compensator.step(count * f64::from(at));
        }
        let before = compensator.step(count * f64::from(at)).force;
        at += if flicker { 1 } else { -1 };
        let after = compensator.step(count * f64::from(at)).force;
        prop_assert!((after - before).abs() <= bound * (1.0 + 1e-9));
    }

    /// The state after bad samples is tested below, against a twin that saw none.
    #[test]
    fn any_input_gives_finite_output_and_two_good_samples_end_an_outage(
        inputs in prop::collection::vec(prop_oneof![
            4 => -1.0..1.0f64,
            1 => prop::sample::select(
                vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN, 1e300]
            ),
        ], 1..40),
    ) {
        for f in laws().iter_mut() {
            for &input in &inputs {
                let answer = f(input);
                prop_assert!(answer.force.is_finite() && answer.deflection.is_finite());
                prop_assert!(input.is_finite() || answer.refused > 0);
            }
            // Twice: the first may be far from what was taken for a position.
            let _ = f(0.1);
            prop_assert_eq!(f(0.1).refused, 0);
        }
    }
}

/// Every compensator behind one function of its input.
fn laws() -> [Box<dyn FnMut(f64) -> Compensation<f64>>; 5] {
    let mut forward = fed_forward(1e-3);
    let mut back = feedback(1e-3, 2e-3);
    let mut damped = feedback_of(lugre(), filtered(1e-3, 2e-3), MicroDamping::Filtered, 1.0);
    let mut by_velocity = observed(INJECTION, 0.0);
    let mut by_position = observed(Injection::Position { gain: 1.0 }, 0.0);
    [
        Box::new(move |x| forward.step(x)),
        Box::new(move |x| back.step(x)),
        Box::new(move |x| damped.step(x)),
        Box::new(move |x| by_velocity.step(x, 0.0)),
        Box::new(move |x| by_position.step(x, 0.0)),
    ]
}

#[test]
fn at_rest_the_classical_injection_alone_moves_the_estimate() {
    // v = 0: λ = 0, r = 1 and c₂ = σ1, so that ẑ = −k e h and F̂ = p (σ0 ẑ − σ1 k e).
    let mut observer = observed(Injection::Position { gain: 2.0 }, 0.0);
    let at = Measured { velocity: 0.0, error: 1e-3, error_rate: 5.0 };
    let answer = observer.step_measured(at);
    assert!((answer.deflection + 2e-6).abs() < 1e-18);
    assert!((answer.force + LOAD * (1e4 * 2e-6 + 60.0 * 2e-3)).abs() < 1e-12);
}

#[test]
fn what_is_faster_than_the_mechanism_can_be_is_refused() {
    let mut forward = fed_forward(1e-3);
    assert_eq!(forward.step(1.0).refused, 0);
    assert_eq!(forward.step(-1.1).refused, 1);
    let mut encoder = VelocityFromPosition::new(sampled(1e-3)).unwrap();
    assert_eq!(encoder.step(0.0).unwrap().displacement, 0.0);
    assert_eq!(encoder.step(1.5e-3), None);
    assert_eq!(encoder.step(f64::NAN), None);
    // Three samples on, three times as far is possible, at the mean velocity of them.
    assert_eq!(encoder.step(2.7e-3).unwrap().displacement, 2.7e-3);
    assert!((encoder.velocity() - 0.9).abs() < 1e-12);
    // Where it was put by hand, it is believed the second time.
    assert_eq!(encoder.step(7.0), None);
    assert_eq!(encoder.step(7.0).unwrap().displacement, 0.0);
    assert_eq!(encoder.step(7.0005).unwrap().displacement, 7.0005 - 7.0);
}

#[test]
fn under_a_load_that_varies_a_compensator_has_the_bristle_of_the_contact() {
    let mut forward = fed_forward(1e-3);
    let mut feedback = feedback(1e-3, 0.0);
    let mut observer = FrictionObserver::new(observer_parameters(
        friction_of(10.0),
        Injection::Velocity { gain: 0.2, corner: 10.0 },
        1e-3,
    ))
    .unwrap();
    let (mut contact, mut softer) = (friction(), friction_of(10.0));
    let (mut z, mut x, mut y, mut before) = (0.0, 0.0, 0.0, 0.0);
    let _ = feedback.step(x);
    for n in 0..2000 {
        let t = 1e-3 * f64::from(n);
        let load = if n % 500 == 499 { 0.0 } else { 2.0 + 1.5 * (9.0 * t).sin() };
        let velocity = 2e-3 * (5.0 * t).cos();
        x += 1e-3 * velocity;
        forward.reload(load).unwrap();
        feedback.reload(load).unwrap();
        observer.reload(load).unwrap();
        // At the velocity of the sample before.
        z = contact.reload(load, before, z).unwrap().deflection;
        y = softer.reload(load, before, y).unwrap().deflection;
        let held = contact.hold(velocity, z, 1e-3);
        (z, y) = (held.deflection, softer.hold(velocity, y, 1e-3).deflection);
        let ahead = forward.step(velocity);
        assert_eq!((ahead.force, ahead.deflection), (held.mean_force, z));
        // The velocity is a difference of positions.
        assert!((feedback.step(x).deflection - z).abs() < 1e-12);
        // Without a tracking error the estimate is the deflection.
        let measured = Measured { velocity, error: 0.0, error_rate: 0.0 };
        assert_eq!(observer.step_measured(measured).deflection, y);
        before = velocity;
    }
    for refused in [f64::NAN, -1.0] {
        assert_eq!(forward.reload(refused).unwrap_err().name, "normal_force");
        assert_eq!(feedback.reload(refused).unwrap_err().name, "normal_force");
        assert_eq!(observer.reload(refused).unwrap_err().name, "normal_force");
    }
    assert_eq!(forward.contact().normal_force(), contact.normal_force());
}

fn observed(injection: Injection<f64>, time_constant: f64) -> FrictionObserver<f64, FrBdFriction> {
    FrictionObserver::new(ObserverParameters {
        derivative_gain: 400.0,
        velocity: filtered(1e-3, time_constant),
        ..observer_parameters(friction(), injection, 1e-3)
    })
    .unwrap()
}

const INJECTION: Injection<f64> = Injection::Velocity { gain: 0.1, corner: 20.0 };

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// At constant velocity the filter makes up for all that it missed, and so does each
    /// displacement: the compensator agrees with a twin that saw everything. Faults are in the
    /// position and in the reference, alone and together.
    #[test]
    fn after_any_outage_the_bristle_is_where_its_clean_twin_is(
        faults in prop::collection::vec(0u8..8, 1..40), speed in 1e-3..0.9f64, tau in 0.0..0.02f64,
        by_position in prop::bool::ANY,
    ) {
        let injection = if by_position { Injection::Position { gain: 1.0 } } else { INJECTION };
        let (mut clean, mut faulty) = (observed(injection, tau), observed(injection, tau));
        let (mut fed, mut fed_faulty) = (feedback(1e-3, tau), feedback(1e-3, tau));
        let settled = (40.0 * (tau / 1e-3 + 1.0)) as usize;
        let at = |n: usize| speed * 1e-3 * n as f64;
        for x in (0..settled).map(at) {
            let _ = (clean.step(x, x), faulty.step(x, x), fed.step(x), fed_faulty.step(x));
        }
        for (n, fault) in faults.iter().chain(&[7, 7]).enumerate() {
            let x = at(settled + n);
            let (position, reference) = (fault & 1 == 0, fault & 2 == 0);
            // A fault of its own each time, so that no two are beside one another.
            let off = if n % 2 == 0 { f64::NAN } else { 10.0 * (n + 1) as f64 };
            // 4..8: no fault.
            let (bad_x, bad_r) = if *fault >= 4 { (x, x) } else {
                (if position { x } else { off }, if reference { x } else { f64::NAN })
            };
            let (a, b) = (clean.step(x, x), faulty.step(bad_x, bad_r));
            let (c, d) = (fed.step(x), fed_faulty.step(bad_x));
            let seen = *fault >= 4;
            prop_assert_eq!(b.refused == 0, seen || (position && reference));
            prop_assert_eq!(d.refused == 0, seen || position);
            prop_assert_eq!(b.deflection, faulty.deflection());
            if seen || position {
                // Rounding of the way's parts, and e⁻⁴⁰ of the filter.
                prop_assert!((a.deflection - b.deflection).abs() < 1e-12 * 1.5e-4, "{a:?} {b:?}");
                prop_assert!((c.deflection - d.deflection).abs() < 1e-12 * 1.5e-4, "{c:?} {d:?}");
            }
            if b.refused == 0 {
                prop_assert!((a.force - b.force).abs() < 1e-9, "{a:?} {b:?}");
            }
        }
    }
}

#[test]
fn after_an_outage_the_rate_of_the_error_is_the_mean_rate_over_it() {
    // Stuck, with an error that grows at 10 mm/s, of which the corner takes next to nothing. The
    // clean observer answers with p c₂ k ė = 3 · 60 · 0.1 · 0.01 = 0.18 N; n missed samples taken
    // for one would give n times as much on top.
    let injection = Injection::Velocity { gain: 0.1, corner: 1e-6 };
    for missed in [2u32, 10, 300] {
        for tau in [0.0, 5e-3] {
            let (mut clean, mut faulty) = (observed(injection, tau), observed(injection, tau));
            let mut force = (0.0, 0.0);
            for n in 0..=300 + missed {
                let reference = 1e-5 * f64::from(n);
                let seen = n < 300 || n == 300 + missed;
                let position = if seen { 0.0 } else { f64::NAN };
                force = (clean.step(0.0, reference).force, faulty.step(position, reference).force);
            }
            // What is left is the injection that was missed: n h k ė of the deflection, times p σ0.
            let left = LOAD * 1e4 * f64::from(missed) * 1e-3 * 0.1 * 0.01;
            let apart = (force.0 - force.1).abs();
            assert!(apart <= left * (1.0 + 1e-6), "{missed} {tau}: {apart} {left}");
            assert!(left < 0.18 * f64::from(missed) / 5.0);
        }
    }
}

#[test]
fn after_a_reset_of_the_encoder_the_error_starts_again() {
    let mut observer = observed(INJECTION, 5e-3);
    let mut fresh = observer;
    for n in 0..50 {
        let _ = observer.step(0.0, 1e-5 * f64::from(n));
    }
    let _ = observer.step(2.0, 2.0 - 1e-6);
    let before = observer.deflection();
    let answer = observer.step(2.0, 2.0 - 1e-6);
    assert_eq!(answer.refused, 0);
    // At rest only the error itself injects: h k α e of deflection, and p σ1 k α e of force.
    let _ = fresh.step(0.0, -1e-6);
    let moved = 1e-3 * 0.1 * 20.0 * 1e-6;
    assert!((fresh.deflection() + moved).abs() < 1e-18);
    assert!((answer.deflection - before + moved).abs() < 1e-15, "{answer:?}");
    let wanted = LOAD * (1e4 * answer.deflection - 60.0 * 0.1 * 20.0 * 1e-6);
    assert!((answer.force - wanted).abs() < 1e-9, "{answer:?} {wanted}");
}

#[test]
fn a_reference_that_nothing_could_follow_is_refused_once() {
    let mut observer = observed(INJECTION, 0.0);
    let mut twin = observer;
    for n in 0..50 {
        let x = 1e-6 * f64::from(n);
        let fault = if n == 30 { 1e300 } else { x };
        let (a, b) = (twin.step(x, x), observer.step(x, fault));
        assert_eq!(b.refused, u32::from(n == 30));
        assert_eq!(a.deflection, b.deflection);
    }
    // A step of 0.9 m is followed at once; 1.1 m, more than a thousand times 1 m/s · 1 ms, the
    // second time.
    assert_eq!(observer.step(49e-6, 0.9).refused, 0);
    assert_eq!(observer.step(49e-6, -1.1).refused, 1);
    assert_eq!(observer.step(49e-6, -1.1).refused, 0);
}

/// The loop of `docs/control-loop.md`: 1 mm/s, counts of 0.5 µm, at most 200 a sample.
#[test]
fn a_glitch_of_the_counter_and_the_way_back_cancel() {
    let velocity = VelocityFromPositionParameters { fastest: 0.1, ..filtered(1e-3, 2e-3) };
    let make = || feedback_of(friction(), velocity, MicroDamping::Uncompensated, 1.0);
    let count = 0.5e-6;
    for glitch in [250i64, -250, 390, 1000, 1 << 20] {
        let (mut clean, mut faulty) = (make(), make());
        let (mut last, mut last_faulty) = (0, 0);
        for n in 0..60i64 {
            let now = 2 * n;
            let read = if n == 40 { now + glitch } else { now };
            let a = clean.advance(count * (now - last) as f64);
            let b = faulty.advance(count * (read - last_faulty) as f64);
            (last, last_faulty) = (now, read);
            assert_eq!(b.refused, u32::from(n == 40), "{glitch} {n}");
            if n != 40 {
                // The filter had settled to e⁻¹⁶, and the speed only says where the curve is read.
                assert!((a.force - b.force).abs() < 1e-6 * LOAD, "{glitch} {n}: {a:?} {b:?}");
            }
        }
    }
    // Where no count came, NaN, and the next difference covers it.
    let (mut clean, mut faulty) = (make(), make());
    for n in 0..60 {
        let a = clean.advance(count * 2.0).force;
        let way = match n {
            40 => f64::NAN,
            41 => 4.0,
            _ => 2.0,
        };
        let b = faulty.advance(count * way).force;
        assert!(n == 40 || (a - b).abs() < 1e-6 * LOAD, "{n}: {a} {b}");
    }
    // No count while the glitch lasts: the way out is still remembered.
    let before = clean.velocity();
    assert_eq!(faulty.advance(count * 250.0).refused, 1);
    assert_eq!(faulty.advance(f64::NAN).refused, 2);
    let answer = faulty.advance(count * (6.0 - 250.0));
    let _ = clean.advance(count * 2.0);
    let _ = clean.advance(count * 2.0);
    let a = clean.advance(count * 2.0);
    assert_eq!(answer.refused, 0);
    assert!((a.force - answer.force).abs() < 1e-6 * LOAD, "{a:?} {answer:?}");
    assert!((faulty.velocity() - before).abs() < 1e-6 * before);
    // A counter that was set anew stays where it is: believed the second time.
    assert_eq!(faulty.advance(1.0).refused, 1);
    assert_eq!(faulty.advance(count).refused, 0);
    assert_eq!(faulty.advance(count).refused, 0);
}

#[test]
fn after_an_outage_the_filter_takes_all_missed_samples_at_once() {
    // τ = 4 h: 0.8 is left each sample.
    let mut encoder = VelocityFromPosition::new(filtered(1e-3, 4e-3)).unwrap();
    for n in 0..100 {
        let _ = encoder.step(5e-5 * f64::from(n));
    }
    // Stopped at once: three samples at rest, two of them not seen; and the next counts once again.
    let stop = 5e-5 * 99.0;
    for (positions, left) in [(&[f64::NAN, 77.0, stop][..], 3), (&[stop], 4)] {
        for position in positions {
            let _ = encoder.step(*position);
        }
        assert!((encoder.velocity() - 0.05 * 0.8f64.powi(left)).abs() < 1e-10);
    }
    for _ in 0..1000 {
        let _ = encoder.step(f64::NAN);
    }
    let _ = encoder.step(stop);
    // But for the rounding of 1 − 0.8¹⁰⁰⁰.
    assert!(encoder.velocity().abs() < 1e-16);
}

#[test]
fn the_bound_per_count_includes_the_viscous_part_and_excludes_regularised_and_creeping_models() {
    let of = |h, time_constant| {
        feedback_of(lugre(), filtered(h, time_constant), MicroDamping::Uncompensated, 0.5)
    };
    let count = 1e-6;
    let filters = [(1e-3, 0.0), (1e-4, 0.0), (1e-5, 0.0), (1e-4, 1e-4), (1e-5, 3e-4)];
    for ((h, tau), load) in filters.into_iter().flat_map(|it| [(it, 1.0), (it, 5.0), (it, 0.2)]) {
        let mut compensator = of(h, tau);
        compensator.reload(load * LOAD).unwrap();
        let bound = compensator.step_per_count(count).unwrap();
        // η q (P σ0 (1 + μ_s/μ_d) + 2 p σ2/(τ + h))
        let wanted = 0.5 * LOAD * count * (1e4 * 2.5 + load * 2.0 * 0.4 / (tau + h));
        assert!((bound - wanted).abs() < 1e-12 * wanted, "{bound} {wanted}");
        let mut last = compensator.step(0.0).force;
        let mut most: f64 = 0.0;
        for n in 0..200 {
            let now = compensator.step(if n % 2 == 0 { count } else { 0.0 }).force;
            (most, last) = (most.max((now - last).abs()), now);
        }
        assert!(most <= bound, "{most} {bound}");
        // One count up and one down, twice σ2 q w/h/(2 − w).
        let viscous = 0.5 * load * LOAD * count * 2.0 * 0.4 / (2.0 * tau + h);
        assert!(most >= viscous, "{most} {viscous}");
    }
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX] {
        assert_eq!(of(1e-3, 0.0).step_per_count(bad), None);
    }
    assert_eq!(of(1e-3, 0.0).step_per_count(-count), of(1e-3, 0.0).step_per_count(count));

    fn regularised<E: Regularisation<f64>>(modulus: E) -> Option<f64> {
        let contact = friction().model().regularised(modulus).under_load(LOAD).unwrap();
        let law = feedback_of(contact, sampled(1e-3), MicroDamping::Uncompensated, 1.0);
        law.step_per_count(1e-6)
    }
    assert_eq!(regularised(SquareRoot::new(1e-8).unwrap()), None);
    assert_eq!(regularised(HyperbolicTangent::new(1e-4).unwrap()), None);
    assert!(regularised(Unregularised).is_some());

    // At a standstill it relaxes by time, so by any share for one count.
    let creeping = Maxwell::new(MaxwellParameters { micro_stiffness: 1e4, series_damping: 50.0 });
    let creeping = FrBd::new(*friction().model().curve(), creeping.unwrap());
    let contact = creeping.under_load(LOAD).unwrap();
    let law = feedback_of(contact, sampled(1e-3), MicroDamping::Uncompensated, 1.0);
    assert_eq!(law.step_per_count(1e-6), None);
}

#[test]
fn positions_counts_and_a_known_velocity_give_the_observer_the_same_estimate() {
    let injection = Injection::Velocity { gain: 0.3, corner: 20.0 };
    let (mut placed, mut counted) = (observed(injection, 2e-3), observed(injection, 2e-3));
    // Without a filter the secants are the velocities.
    let (mut encoded, mut known) = (observed(injection, 0.0), observed(injection, 0.0));
    let (count, start) = (1e-6, 1_000_000);
    let wave = |amplitude: f64, n: i32| (amplitude * (0.1 * f64::from(n)).sin()).round() as i32;
    let (mut last, mut position, mut error) = (start, 0.0, 0.0);
    // Counts from a metre on, with a glitch of the counter, a count that did not come and a
    // reference that is none.
    for n in 0..200 {
        let glitch = if n == 40 { 1 << 20 } else { 0 };
        let (now, goal) = (start + wave(100.0, n) + glitch, start + wave(120.0, n));
        let (now, goal) = (f64::from(now), f64::from(goal));
        let goal = if n == 90 { f64::NAN } else { goal };
        let a = placed.step(if n == 70 { f64::NAN } else { count * now }, count * goal);
        let b = if n == 70 {
            counted.advance(f64::NAN, 0.0)
        } else {
            let moved = now - f64::from(last);
            last = now as i32;
            counted.advance(count * moved, count * (now - goal))
        };
        assert_eq!((a.refused, b.refused), (u32::from([40, 70, 90].contains(&n)), a.refused));
        // Roundings of 1 m, 1e-16 each: σ0 p of them, and in a velocity over 1 ms.
        assert!((a.deflection - b.deflection).abs() < 1e-13, "{n}: {a:?} {b:?}");
        assert!((a.force - b.force).abs() < 1e-8, "{n}: {a:?} {b:?}");

        let phase = 0.1 * f64::from(n);
        let (x, reference) = (1e-4 * phase.sin(), 1.2e-4 * (phase + 0.1).sin());
        let first = n == 0;
        let rate = |now: f64, before: f64| if first { 0.0 } else { (now - before) / 1e-3 };
        let measured = Measured {
            velocity: rate(x, position),
            error: x - reference,
            error_rate: rate(x - reference, error),
        };
        let (a, b) = (encoded.step(x, reference), known.step_measured(measured));
        (position, error) = (x, x - reference);
        // Rounding of differences of 1e-4 m, over 1e-3 s.
        assert!((a.deflection - b.deflection).abs() < 1e-15, "{n}: {a:?} {b:?}");
        assert!(first || (a.force - b.force).abs() < 1e-9, "{n}: {a:?} {b:?}");
    }
    assert!(counted.deflection().abs() > 1e-6);
}

#[test]
fn an_estimate_is_cut_to_the_limit_of_the_deflection() {
    let mut observer = observed(INJECTION, 0.0);
    let limit = friction().model().limits(1.0).deflection.unwrap();
    let mut deflection = 0.0;
    for _ in 0..10 {
        let at = Measured { velocity: 0.0, error: -1.0, error_rate: 0.0 };
        deflection = observer.step_measured(at).deflection;
        assert!(deflection <= limit);
    }
    assert_eq!(deflection, limit);
    assert_eq!(
        observer.step_measured(Measured { velocity: 0.0, error: 1e3, error_rate: 0.0 }).deflection,
        -limit
    );
}

#[test]
fn a_reset_compensator_equals_a_new_one() {
    let new = (fed_forward(1e-3), feedback(1e-3, 5e-3), observed(INJECTION, 5e-3));
    let (mut forward, mut back, mut observer) = new;
    assert!(forward.step(0.02).force > 0.1);
    let inputs = [0.0, 1e-5, f64::NAN, 2e-5, 0.5];
    assert_eq!(inputs.map(|x| back.step(x).refused), [0, 0, 1, 0, 1]);
    assert_eq!(inputs.map(|x| observer.step(x, 2.0 * x).refused), [0, 0, 1, 0, 1]);
    forward.reset();
    back.reset();
    observer.reset();
    assert_eq!((forward, back, observer), new);
}

#[test]
fn steady_motion_gives_the_curve_at_any_sample_time() {
    for h in [1e-4, 1e-3, 0.1] {
        for v in [0.004, -0.02, 0.3] {
            let mu = 1.0 + 0.5 * (-(v / 0.01f64).powi(2)).exp() + 0.4 * f64::abs(v);
            let want = LOAD * mu * f64::signum(v);
            let mut forward = fed_forward(h);
            let mut back = feedback(h, 0.0);
            let mut classical = feedback_of(lugre(), sampled(h), MicroDamping::Uncompensated, 1.0);
            let mut last = [0.0; 3];
            // Some thirty relaxation lengths (σ1|v| + μ)/σ0: e^−30 is nothing beside the tolerance.
            let length = (60.0 * f64::abs(v) + 1.5) / 1e4;
            for _ in 0..(30.0 * length / (f64::abs(v) * h)).ceil() as usize + 2 {
                last = [
                    forward.step(v).force,
                    back.advance(v * h).force,
                    classical.advance(v * h).force,
                ];
            }
            for got in last {
                assert!((got - want).abs() < 1e-9, "{got} {want}, {h} s, {v} m/s");
            }
        }
    }
}

#[test]
fn the_direction_of_the_displacement_chooses_the_side_of_an_asymmetric_curve() {
    let of = |dynamic| coulomb(&Recipe { dynamic, viscous: 0.0, ..FRICTION });
    let curve = Asymmetric { forward: of(1.0), backward: of(2.0) };
    let model = FrBd::new(curve, kelvin_voigt(1e4, MICRO_DAMPING));
    // A filter so slow that its velocity still has the first direction after the reversal.
    let velocity = filtered(1e-3, 10.0);
    for (direction, first, then) in [(1.0, 1.0, -2.0), (-1.0, -2.0, 1.0)] {
        let contact = model.under_load(LOAD).unwrap();
        let mut compensator = feedback_of(contact, velocity, MicroDamping::Uncompensated, 1.0);
        let _ = compensator.step(0.0);
        // 20 mm at 0.2 m/s, then 20 mm back: a hundred relaxation lengths μ/σ0 = 0.2 mm.
        let forward = (0..100).fold(0.0, |_, _| compensator.advance(direction * 2e-4).force);
        assert!((forward - LOAD * first).abs() < 1e-9, "{forward}");
        let back = (0..90).fold(0.0, |_, _| compensator.advance(-direction * 2e-4).force);
        assert!(compensator.velocity() * direction > 0.0, "the filter has turned already");
        assert!((back - LOAD * then).abs() < 1e-9, "{back}");
    }
}

#[test]
fn at_rest_the_elastic_force_stays_to_the_last_bit() {
    let mut compensator = feedback(1e-3, 5e-3);
    let _ = compensator.advance(3e-5);
    let force = compensator.advance(-1e-6).force;
    for _ in 0..1000 {
        assert_eq!(compensator.advance(0.0).force, force);
    }
    assert!(force > 0.5 * LOAD * 1e4 * 2.9e-5);
}

#[test]
fn the_output_is_the_share_within_the_limit() {
    let friction = Dahl::new(DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 });
    let law = |share, largest_force| {
        let mut law = FeedForwardCompensator::new(FeedForwardParameters {
            contact: friction.unwrap().under_load(10.0).unwrap(),
            sample_time: 1.0,
            fastest: 1.0,
            output: OutputParameters { share, largest_force },
        })
        .unwrap();
        // After a second each way the bristle slides steadily: 5 N.
        let [backward, forward] = [-1.0, 1.0].map(|velocity| {
            let _ = law.step(velocity);
            law.step(velocity)
        });
        assert_eq!((forward.force, forward.saturated), (-backward.force, backward.saturated));
        (backward.force, backward.saturated)
    };
    assert_eq!(law(0.8, 10.0), (-4.0, false));
    assert_eq!(law(1.2, 10.0), (-6.0, false));
    assert_eq!(law(1.2, 5.5), (-5.5, true));
}

#[test]
fn single_precision_follows_double_over_half_a_million_counts() {
    let mut single = FeedbackCompensator::new(FeedbackParameters {
        contact: friction_of::<f32>(MICRO_DAMPING),
        velocity: VelocityFromPositionParameters {
            sample_time: 1e-3f32,
            time_constant: 5e-3,
            fastest: 1.0,
            count: 0.0,
        },
        damping: MicroDamping::Uncompensated,
        output: OutputParameters { share: 1.0, largest_force: 10.0 },
    })
    .unwrap();
    let mut double = feedback(1e-3, 5e-3);
    let mut worst: f64 = 0.0;
    for n in 0..20_000 {
        let counts = (50.0 * (f64::from(n) * 1e-2).sin()).round();
        let a = single.advance(counts as f32 * 1e-6).force;
        let b = double.advance(counts * 1e-6).force;
        worst = worst.max((f64::from(a) - b).abs());
    }
    // Each step forgets what the one before rounded: a few units of the last place of 4.5 N, no
    // drift.
    assert!(worst < 2e-5, "{worst}");
}

mod servo {
    use super::example::{Outcome, Plant, Setting, Sign, Way, best_coulomb, run};

    /// The best of the example's list.
    const BEST: Sign = Sign::DeadBand(5e-5);

    fn outcome(setting: Setting) -> Outcome {
        run(setting).unwrap()
    }

    #[test]
    fn frbd_compensation_leaves_less_than_a_third_of_the_error_of_tuned_coulomb() {
        let [(_, coulomb), (_, calm)] = best_coulomb(Setting::of(Way::None)).unwrap();
        let none = outcome(Setting::of(Way::None));
        assert!(coulomb.rms < 0.7 * none.rms, "the baseline is worth something: {}", coulomb.rms);
        assert!(coulomb.rms < calm.rms && calm.sign_changes <= 2);
        for way in [Way::FrBd, Way::FeedForward, Way::Observer, Way::LuGre] {
            let bristle = outcome(Setting::of(way));
            assert!(3.0 * bristle.rms <= coulomb.rms, "{way:?}: {} {}", bristle.rms, coulomb.rms);
        }
    }

    #[test]
    fn coulomb_over_compensated_by_a_fifth_hunts_at_rest_and_a_bristle_does_not() {
        let over = |way| Setting { share: 1.2, ..Setting::of(way) };
        let coulomb = outcome(over(Way::Coulomb(BEST)));
        // Tens of swings in 2.5 s, each of tens of counts.
        assert!(coulomb.sign_changes > 50, "{}", coulomb.sign_changes);
        assert!(coulomb.range > 40e-6, "{}", coulomb.range);
        for way in [Way::FrBd, Way::FeedForward, Way::Observer, Way::LuGre] {
            let bristle = outcome(over(way));
            // Within two counts of 0.5 µm: it creeps onto its target.
            assert_eq!(bristle.sign_changes, 0, "{way:?}");
            assert!(bristle.range < 1.1e-6, "{way:?}: {}", bristle.range);
        }
    }

    #[test]
    fn the_fed_back_bristle_stays_calm_from_a_hundred_samples_a_second_to_ten_thousand() {
        for (rate, bandwidth) in [(1e2, 4.0), (1e4, 20.0)] {
            for way in [Way::FrBd, Way::Observer] {
                let slow = Setting { rate, bandwidth, ..Setting::of(way) };
                let bristle = outcome(slow);
                let none = outcome(Setting { way: Way::None, ..slow });
                assert!(
                    bristle.rms < 0.3 * none.rms,
                    "{rate} {way:?}: {} {}",
                    bristle.rms,
                    none.rms
                );
                assert!(bristle.sign_changes <= 2, "{rate} {way:?}: {}", bristle.sign_changes);
            }
        }
    }

    #[test]
    fn the_axis_is_simulated_accurately_enough_for_all_this() {
        for way in [Way::None, Way::FrBd] {
            let coarse = outcome(Setting::of(way));
            let fine = outcome(Setting { refinement: 2, ..Setting::of(way) });
            // A fiftieth of the differences asserted above.
            assert!((coarse.rms - fine.rms).abs() < 0.02 * fine.rms, "{} {}", coarse.rms, fine.rms);
        }
    }

    /// An FrBD compensator of an implicit bristle, below the Stribeck velocity, where the two
    /// models differ most: knowing the true parameters does not help.
    #[test]
    fn against_the_implicit_bristle_the_model_is_what_limits_it() {
        let at = |way| Setting { plant: Plant::Implicit, ..Setting::of(way) };
        let coulomb = outcome(at(Way::Coulomb(BEST)));
        let guessed = outcome(at(Way::FrBd));
        let informed = outcome(Setting { informed: true, ..at(Way::FrBd) });
        assert!(guessed.rms < 0.75 * coulomb.rms, "{} {}", guessed.rms, coulomb.rms);
        assert!(informed.rms > 0.9 * guessed.rms, "{} {}", informed.rms, guessed.rms);
        assert_eq!(guessed.sign_changes, 0);
        assert!(coulomb.sign_changes > 50);
    }
}

#[test]
fn a_count_that_is_coarse_for_the_sample_time_is_no_speed() {
    // 4096 counts a turn at 4 kHz: one count is 6.1 rad/s, three times what the joint can do.
    let (h, count) = (0.25e-3, std::f64::consts::TAU / 4096.0);
    let coarse =
        VelocityFromPositionParameters { sample_time: h, time_constant: 2e-3, fastest: 2.0, count };
    let mut encoder = VelocityFromPosition::new(coarse).unwrap();
    // 0.77 rad/s, as counts.
    let (mut gone, mut last) = (0.0, 0.0);
    for sample in 0..4000 {
        let position = (0.77 * h * f64::from(sample) / count).floor() * count;
        let motion = encoder.step(position);
        assert!(motion.is_some(), "refused at sample {sample}");
        gone += motion.unwrap().displacement;
        last = position;
    }
    assert!((gone - last).abs() < 1e-12 && (encoder.velocity() - 0.77).abs() < 0.77);
    // A jump is one still.
    assert_eq!(encoder.step(last + 4.0 * count), None);
    // Found elsewhere again, a count further on, the measurement starts anew from there.
    assert_eq!(encoder.step(last + 100.0 * count), None);
    let found = encoder.step(last + 101.0 * count).unwrap();
    assert!(found.restarted && found.displacement == 0.0, "{found:?}");
    let bad = VelocityFromPositionParameters { count: -1.0, ..coarse };
    assert!(VelocityFromPosition::new(bad).unwrap_err().to_string().contains("count"));
}
