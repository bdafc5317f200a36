//! The law of the open door: a curve, a bristle and a model of one's own, each of fewer than forty
//! lines, go wherever those of the library go.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::ops::ControlFlow;

use bristle::companion::{PointMass, VelocityHistory};
use bristle::control::{
    FeedbackCompensator, FeedbackParameters, FrictionObserver, Injection, Measured, MicroDamping,
    ObserverParameters, OutputParameters, VelocityFromPositionParameters,
};
use bristle::curve::{AnyCurve, FrictionCurve};
use bristle::ode::{self, Output};
use bristle::rheology::{ElementBounds, Elements, KelvinVoigt, KelvinVoigtParameters, Rheology};
use bristle::scene::MassSpringDamper;
use bristle::signal::{Sine, SineParameters};
use bristle::{
    Affine, AnyBristle, Bounds, Bristle, Contact, Form, FrBd, Law, Limits, LoadChange,
    ParameterError, Scalar, Sliding, Surface, paper,
};
use bristle_batch::{Batch, CommitInput, PassiveOutput, ReloadInput, StepInput};
use bristle_fidelity::{
    Answers, KnownVelocity, MechanismScene, PatchScene, Quantity, Tolerance, choose,
};
use bristle_identify::{
    Candidate, InitialGuess, Log, LogParameters, MeasuredMotion, Parameter, SearchProgress,
    SearchSettings, fit,
};
use bristle_joint::{
    GearFriction, GearFrictionParameters, GearTorques, LoadedDeflection, TorqueLoad,
    TorqueLoadParameters,
};
use bristle_rolling::{Motion, Patch, PatchParameters, PolynomialExponential, Segment};
use bristle_specimens::lit;
use nalgebra::Vector3;

// ---------------------------------------------------------------------------------------------
// One's own
// ---------------------------------------------------------------------------------------------

/// A fall by the hyperbolic secant: μ = μ_d + (μ_s − μ_d) sech(v/v_S).
#[derive(Debug, Clone, Copy)]
struct Secant<T> {
    dynamic: T,
    drop: T,
    velocity: T,
}

impl<T: Scalar> FrictionCurve<T> for Secant<T> {
    fn coefficient_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        let u = sliding.velocity() / self.velocity;
        let fall = self.drop / u.cosh();
        (self.dynamic + fall, -fall * u.tanh() / self.velocity)
    }

    fn bounds(&self, fastest: T) -> Bounds<T> {
        Bounds { min: self.at(fastest), max: self.dynamic + self.drop }
    }

    fn is_even(&self) -> bool {
        true
    }

    /// (sech u)' = −sech u tanh u is least where sinh u = 1.
    fn least_slope(&self) -> Option<T> {
        Some(-self.drop / (self.velocity * lit(2.0)))
    }
}

/// A spring beside a dashpot that stiffens: d = η √(1 + (v/v₀)²).
#[derive(Debug, Clone, Copy)]
struct Stiffening {
    stiffness: f64,
    damping: f64,
    velocity: f64,
}

impl<T: Scalar> Rheology<T> for Stiffening {
    type Deflection = T;

    fn elements_and_slopes(&self, sliding: Sliding<T>) -> (Elements<T>, Elements<T>) {
        let (zero, d, v0): (T, T, T) = (T::zero(), lit(self.damping), lit(self.velocity));
        let u = sliding.velocity() / v0;
        let root = (T::one() + u * u).sqrt();
        (
            Elements { stiffness: lit(self.stiffness), decay: zero, damping: d * root },
            Elements { stiffness: zero, decay: zero, damping: d * u / (root * v0) },
        )
    }

    fn storage_stiffness(&self) -> T {
        lit(self.stiffness)
    }

    fn bounds(&self) -> ElementBounds<T> {
        ElementBounds {
            stiffness: Bounds::constant(lit(self.stiffness)),
            decay: Bounds::constant(T::zero()),
            damping: Bounds { min: lit(self.damping), max: lit(f64::INFINITY) },
            constant_decay: true,
            even: true,
        }
    }
}

/// Dahl's model with a friction that grows as a power of the speed, f = μ (1 + |v|/v₀)ⁿ:
/// ż = v − (σ0|v|/f) z, μ_b = σ0 z. Passive, because F v − Ẇ = p σ0 λ z².
#[derive(Debug, Clone, Copy)]
struct PowerDahl<T> {
    dynamic: T,
    stiffness: T,
    velocity: T,
    exponent: T,
}

impl<T: Scalar> Bristle<T> for PowerDahl<T> {
    type Deflection = T;

    fn affine(&self, surface: Surface<T>, z: T) -> Affine<T> {
        self.affine_and_slopes(surface, z).0
    }

    fn affine_and_slopes(&self, surface: Surface<T>, _: T) -> (Affine<T>, Affine<T>) {
        let (zero, speed) = (T::zero(), surface.speed());
        let (f, k) = (self.dry(surface), self.stiffness);
        let share = T::one() - self.exponent * speed / (self.velocity + speed);
        let slope = k * surface.direction() * share / f;
        let still = Affine { relaxation: slope, drive: zero, stiffness: zero, damping: zero };
        (Affine { relaxation: k * speed / f, drive: T::one(), stiffness: k, ..still }, still)
    }

    fn stationary(&self, surface: impl Into<Surface<T>>) -> T {
        let surface = surface.into();
        surface.direction() * self.dry(surface) / self.stiffness
    }

    fn storage_stiffness(&self) -> T {
        self.stiffness
    }

    fn form(&self) -> Form {
        Form::OfVelocity
    }

    fn obeys(&self, law: Law) -> bool {
        matches!(law, Law::Passivity | Law::Secant | Law::SteadySliding | Law::OddSymmetry)
    }

    fn limits(&self, fastest: T) -> Limits<T> {
        let most = self.dry(fastest.into());
        let [deflection, coefficient] = [Some(most / self.stiffness), Some(most)];
        Limits { deflection, coefficient, relaxation_rate: None }
    }
}

impl<T: Scalar> PowerDahl<T> {
    fn dry(&self, surface: Surface<T>) -> T {
        let power = (T::one() + surface.speed() / self.velocity).powf(self.exponent);
        surface.apply(self.dynamic * power)
    }
}

// ---------------------------------------------------------------------------------------------
// The doors
// ---------------------------------------------------------------------------------------------

const SECANT: Secant<f64> = Secant { dynamic: 1.0, drop: 0.5, velocity: 0.01 };
const STIFFENING: Stiffening = Stiffening { stiffness: 1e4, damping: 64.5, velocity: 0.1 };
const POWER: PowerDahl<f64> =
    PowerDahl { dynamic: 1.0, stiffness: 1e4, velocity: 0.05, exponent: 0.2 };

fn frbd() -> FrBd<Secant<f64>, Stiffening> {
    FrBd::new(SECANT, STIFFENING)
}

/// Runs a check with both models, and with each behind a pointer.
macro_rules! through_the_door {
    ($check:ident $(, $more:expr)*) => {{
        let (frbd, power) = (frbd(), POWER);
        let chosen = [AnyBristle::own(frbd), AnyBristle::own(power)];
        assert_eq!($check(frbd $(, $more)*), $check(chosen[0].clone() $(, $more)*));
        assert_eq!($check(power $(, $more)*), $check(chosen[1].clone() $(, $more)*));
        [$check(frbd $(, $more)*), $check(power $(, $more)*)]
    }};
}

#[test]
fn slopes_and_claims_of_ones_own_are_true() {
    for v in [-0.3, -0.004, 1e-5, 0.02, 0.7] {
        let z = 0.4e-4;
        for s in [1.0, 0.3] {
            let h = 1e-6 * f64::abs(v);
            let at = |v| Surface::scaled(v, s);
            let difference = |f: &dyn Fn(f64) -> f64| (f(v + h) - f(v - h)) / (2.0 * h);
            let by_velocity = difference(&|v| POWER.rate(at(v), z));
            let got = POWER.linearised(at(v), z).rate_by_velocity;
            assert!((got - by_velocity).abs() < 1e-8 * (1.0 + got.abs()), "{got} {by_velocity}");
            let by_velocity = difference(&|v| frbd().rate(at(v), z));
            let got = frbd().linearised(at(v), z).rate_by_velocity;
            assert!((got - by_velocity).abs() < 1e-7 * (1.0 + got.abs()), "{got} {by_velocity}");
        }
        for model in [AnyBristle::own(frbd()), AnyBristle::own(POWER)] {
            let long = model.hold(v, z, 1e4).end_coefficient;
            let steady = model.stationary_coefficient(v);
            assert!((long - steady).abs() < 1e-12 * steady.abs(), "{long} {steady}");
            let scaled = model.stationary_coefficient(Surface::scaled(v, 0.3));
            assert!((scaled - 0.3 * steady).abs() < 1e-15);
            assert!(model.under_load(2.0).unwrap().dissipated_power(v, z) >= 0.0);
        }
    }
    assert!(
        SECANT.coefficient_and_slope(Sliding::from(0.00881)).1 >= SECANT.least_slope().unwrap()
    );
}

#[test]
fn the_solver_takes_it() {
    fn stick_slip<M: Bristle<f64, Deflection = f64>>(model: M) -> [f64; 3] {
        let rig = paper::stick_slip_rig(model.under_load(1.0).unwrap());
        let rig = MassSpringDamper::new(rig).unwrap();
        let run = ode::solve(&rig, 0.0..10.0, rig.at_rest(), 1e-8, Output::Uniform(2)).unwrap();
        let end: Vector3<f64> = *run.states().last().unwrap();
        end.into()
    }
    let [frbd, power] = through_the_door!(stick_slip);
    // Pulled at 0.1 m/s by 2 N/m: slips for its drop, or slides on steadily.
    assert!(frbd[0] > 1e-3 && (power[1] - 0.1).abs() < 0.1, "{frbd:?} {power:?}");
}

#[test]
fn the_companion_takes_it_and_keeps_its_balance() {
    fn worst<M: Bristle<f64, Deflection = f64>>(model: M) -> f64 {
        let mut companion = model.under_load(3.0).unwrap().companion(0.5).unwrap();
        let (mut z, mut velocity, mut worst) = (0.0, 0.0, 0.0);
        let mut history = VelocityHistory::new(velocity);
        for step in 0..400 {
            let phase = 0.05 * f64::from(step);
            let predicted = history.predict();
            let load = 3.0 + 2.0 * (1.7 * phase).sin();
            z = companion.reload(load, predicted, z).unwrap().deflection;
            let friction = companion.step(predicted, z, 0.02);
            assert!(friction.is_passive());
            let force = 6.0 * phase.sin();
            let body = PointMass { mass: 0.5, velocity, force, end_weight: 0.5 };
            let mean = friction.point_mass(body);
            let done = friction.commit(mean);
            worst = f64::min(worst, done.dissipated);
            (z, velocity) = (done.deflection, 2.0 * mean - velocity);
            history.push(velocity);
        }
        assert!(velocity.is_finite());
        worst
    }
    assert_eq!(through_the_door!(worst), [0.0; 2]);
}

fn encoder() -> VelocityFromPositionParameters<f64> {
    VelocityFromPositionParameters {
        sample_time: 1e-3,
        time_constant: 2e-3,
        fastest: 0.05,
        count: 0.0,
    }
}

const OUTPUT: OutputParameters<f64> = OutputParameters { share: 1.0, largest_force: 5.0 };

#[test]
fn observer_and_compensator_take_it() {
    fn observed<M: Bristle<f64, Deflection = f64>>(model: M) -> f64 {
        let mut observer = FrictionObserver::new(ObserverParameters {
            contact: model.clone().under_load(1.0).unwrap(),
            mass: 1.0,
            proportional_gain: 400.0,
            derivative_gain: 30.0,
            integral_gain: 1000.0,
            injection: Injection::Velocity { gain: 0.1, corner: 10.0 },
            velocity: encoder(),
            output: OUTPUT,
        })
        .unwrap();
        let measured = Measured { velocity: 0.02, error: 0.0, error_rate: 0.0 };
        let force = (0..500).fold(0.0, |_, _| observer.step_measured(measured).force);
        let steady = model.stationary_coefficient(0.02);
        assert!((force - steady).abs() < 1e-9 * steady, "{force} {steady}");
        force
    }
    fn fed_back<M: Bristle<f64, Deflection = f64>>(model: M) -> f64 {
        let contact = model.clone().under_load(1.0).unwrap();
        let damping = MicroDamping::Uncompensated;
        let parameters =
            FeedbackParameters { contact, velocity: encoder(), damping, output: OUTPUT };
        let mut compensator = FeedbackCompensator::new(parameters).unwrap();
        let force = (0..800).fold(0.0, |_, n| compensator.step(2e-5 * f64::from(n)).force);
        let steady = model.stationary_coefficient(0.02);
        assert!((force - steady).abs() < 1e-3 * steady, "{force} {steady}");
        force
    }
    let _ = (through_the_door!(observed), through_the_door!(fed_back));
}

#[test]
fn a_rolling_patch_takes_it_exactly() {
    fn rolled<M: Bristle<f64, Deflection = f64>>(model: M) -> f64 {
        let pressure = PolynomialExponential::parabolic();
        let patch = Patch::new(PatchParameters { model, length: 0.1, pressure }).unwrap();
        let patch = patch.under_load(100.0).unwrap();
        let motion = Motion { slip_velocity: 0.02, rolling_speed: 2.0 };
        let steady = patch.steady(motion).unwrap().force;
        let mut exact = patch.exact([[Segment::default(); 200]]).unwrap();
        let force = (0..60).fold(0.0, |_, _| exact.step(motion, 2e-3).unwrap());
        assert!((force - steady).abs() < 1e-10 * steady, "{force} {steady}");
        steady
    }
    assert!(through_the_door!(rolled).iter().all(|&force| force > 10.0));
}

#[test]
fn fidelity_measures_what_is_enough_for_it() {
    let answers = Answers { interval: 1e-2, count: 50 };
    let sine = SineParameters { mean: 0.01, amplitude: 0.02, frequency: 3.0, phase: 0.0 };
    let velocity = Sine::new(sine).unwrap();
    let tolerance = Tolerance::root_mean_square(1e-2);
    let scene = KnownVelocity::new(POWER.under_load(1.0).unwrap(), velocity, answers).unwrap();
    assert!(choose(&scene, tolerance).is_ok());
    let rig = paper::stick_slip_rig(POWER.under_load(1.0).unwrap());
    let rig = MassSpringDamper::new(rig).unwrap();
    let start = [0.0; 3].into();
    let scene = MechanismScene::new(rig, start, answers, Quantity::Position).unwrap();
    assert!(choose(&scene, tolerance).is_ok());
    let pressure = PolynomialExponential::constant();
    let patch = Patch::new(PatchParameters { model: POWER, length: 0.1, pressure }).unwrap();
    let motion = Motion { slip_velocity: velocity, rolling_speed: 5.0 };
    let scene = PatchScene::new(patch.under_load(1.0).unwrap(), motion, answers).unwrap();
    assert!(choose(&scene, tolerance).is_ok());
    // A curve of one's own; a dashpot that varies is a level of its own.
    let contact = frbd().under_load(1.0).unwrap();
    let scene = KnownVelocity::new(contact, velocity, answers).unwrap();
    assert!(choose(&scene, tolerance).is_ok());
}

#[test]
fn fidelity_measures_the_same_behind_a_pointer() {
    fn chosen<M: Bristle<f64, Deflection = f64>>(model: M) -> String {
        let answers = Answers { interval: 1e-2, count: 50 };
        let sine = SineParameters { mean: 0.0, amplitude: 1e-4, frequency: 3.0, phase: 0.0 };
        let contact = model.under_load(1.0).unwrap();
        let scene = KnownVelocity::new(contact, Sine::new(sine).unwrap(), answers).unwrap();
        choose(&scene, Tolerance::root_mean_square(1e-2)).unwrap().to_string()
    }
    let _ = through_the_door!(chosen);
}

/// Bristles of a model of one's own on masses, under loads that vary.
#[test]
fn a_batch_takes_it_one_by_one() {
    fn stepped<M: Bristle<f64, Deflection = f64> + Sync>(model: M) -> [f64; 9] {
        let batch = Batch::of_model(&model).unwrap().measured_at(2.0).unwrap();
        let contact = model.clone().under_load(2.0).unwrap().measured_at(2.0).unwrap();
        let (mut z, mut force, mut left) = ([0.0; 9], [0.0; 9], [0.0; 9]);
        let [mut shares, mut biases, mut dampings] = [[0.0; 9]; 3];
        let (mut stored, mut alone) = (0.0, 0.0);
        for step in 0..300 {
            let phase = 0.1 * f64::from(step);
            let load = |phase: f64| [2.0 + 1.5 * phase.sin(); 9];
            let (before, after) = (load(phase - 0.1), load(phase));
            let velocities: [f64; 9] =
                std::array::from_fn(|i| 0.01 * i as f64 * (0.7 * phase).cos());
            let change = ReloadInput { before: &before, after: &after, velocities: &velocities };
            assert!(batch.reload(change, &mut z, &mut left).unwrap().is_finite());
            // A passive step gives no energy that was not stored.
            let mut end = z;
            let input =
                StepInput { velocities: &velocities, normal_forces: &after, deflections: &mut end };
            let (shares, biases, dampings) = (&mut shares, &mut biases, &mut dampings);
            let output = PassiveOutput {
                shares: &mut *shares,
                biases: &mut *biases,
                dampings: &mut *dampings,
            };
            assert!(batch.companions(input, 1e-3, output).unwrap().is_finite());
            let mean = velocities.map(|v| 0.9 * v);
            let found = CommitInput { shares: &*shares, velocities: &mean, normal_forces: &after };
            assert!(batch.commit(found, 1e-3, &mut end).unwrap().is_finite());
            for i in 0..9 {
                let work = 1e-3 * mean[i] * (biases[i] + dampings[i] * mean[i]);
                let gain = contact.stored_energy(end[i]) - contact.stored_energy(z[i]);
                assert!(work - gain >= -1e-15 && left[i] >= 0.0, "{work:e} {gain:e}");
                stored += work - gain;
            }
            // The exact step is that of one contact.
            let mut one = model.clone().under_load(after[4]).unwrap().measured_at(2.0).unwrap();
            let want = one.hold(velocities[4], z[4], 1e-3);
            let input =
                StepInput { velocities: &velocities, normal_forces: &after, deflections: &mut z };
            assert!(batch.hold(input, 1e-3, &mut force).unwrap().is_finite());
            assert_eq!((z[4], force[4]), (want.deflection, want.mean_force));
            alone += one.reload(after[4], velocities[4], z[4]).unwrap().dissipated;
        }
        assert!(stored > 0.0 && alone == 0.0);
        force
    }
    let _ = through_the_door!(stepped);
}

/// [`PowerDahl`] to be found from a log.
#[derive(Debug)]
struct PowerFit;

impl Candidate<3> for PowerFit {
    type Model<T: Scalar> = PowerDahl<T>;

    fn parameters(&self, _: &InitialGuess) -> [Parameter; 3] {
        [
            Parameter::positive("dynamic", "", 0.5, 10.0),
            Parameter::positive("stiffness", "1/m", 3e3, 100.0),
            Parameter::scaled("exponent", "", 0.1, 0.0..=1.0, 0.1),
        ]
    }

    fn model<T: Scalar>(
        &self,
        &[dynamic, stiffness, exponent]: &[T; 3],
    ) -> Result<PowerDahl<T>, ParameterError> {
        Ok(PowerDahl { dynamic, stiffness, velocity: lit(0.05), exponent })
    }
}

#[test]
fn identification_finds_its_parameters() {
    let (mut time, mut speeds, mut friction, mut z) = (vec![], vec![], vec![], 0.0);
    for row in 0..800 {
        let t = 5e-3 * f64::from(row);
        let v = 0.05 * (1.3 * t).sin() + 0.004 * (17.0 * t).sin();
        if let Some(before) = speeds.last() {
            z = POWER.hold(0.5 * (v + before), z, 5e-3).deflection;
        }
        time.push(t);
        speeds.push(v);
        friction.push(POWER.coefficient(v, z));
    }
    let motion = MeasuredMotion::Velocity(&speeds);
    let log = LogParameters { time: &time, motion, friction: &friction, normal_force: None };
    let log = Log::new(log).unwrap();
    let starts = PowerFit.parameters(&InitialGuess::of(&log).unwrap());
    let go_on = &mut |_: &SearchProgress<'_>| ControlFlow::Continue(());
    let found = fit(&PowerFit, starts, &log, &SearchSettings::default(), go_on).unwrap();
    for (found, want) in found.estimates.iter().zip([1.0, 1e4, 0.2]) {
        assert!((found.value / want - 1.0).abs() < 1e-6, "{found:?} for {want}");
    }
}

#[test]
fn a_gear_takes_it() {
    fn lifted<M: Bristle<f64, Deflection = f64>>(friction: M) -> f64 {
        let load = TorqueLoadParameters { idle_load: 2.0, motor_share: 1.0, external_share: 0.6 };
        let load = TorqueLoad::new(load).unwrap();
        // The load below, 2 + 3 + 0.6 · 2.
        let (reference_load, drag, fastest) = (6.2, 0.05, 10.0);
        let gear = GearFrictionParameters { friction, load, reference_load, drag, fastest };
        let gear = GearFriction::new(gear).unwrap();
        let (mut v, mut z, h) = (0.0, LoadedDeflection::none(), 1e-3);
        let torques = GearTorques { motor: 3.0, external: -2.0 };
        for _ in 0..200 {
            let step = gear.step(torques, v, z, h).unwrap();
            let mean = (2.0 * 0.02 / h * v + 1.0 - step.bias()) / (2.0 * 0.02 / h + step.damping());
            (v, z) = (2.0 * mean - v, step.commit(mean).deflection);
        }
        v
    }
    assert!(through_the_door!(lifted).iter().all(|v| v.abs() < 1e-3));
}

#[test]
fn curves_of_ones_own_stand_in_every_model_and_table() {
    let bristle = KelvinVoigtParameters { micro_stiffness: 1e4, micro_damping: 64.5 };
    let bristle = KelvinVoigt::new(bristle).unwrap();
    let own = AnyCurve::own(SECANT);
    let stuck = bristle::ImplicitBristle::new(own.clone(), bristle).unwrap();
    assert!(stuck.sticks(0.0, 1.4e-4) && !stuck.sticks(0.0, 1.6e-4));
    let (fixed, any) = (FrBd::new(SECANT, bristle), FrBd::new(own, bristle));
    assert_eq!(fixed.hold(0.01, 1e-5, 1e-3), any.hold(0.01, 1e-5, 1e-3));
}

/// `PowerDahl`, whose tip lets go of all its stretch when the load changes.
#[derive(Debug, Clone, Copy)]
struct LetsGo(PowerDahl<f64>);

impl Bristle<f64> for LetsGo {
    type Deflection = f64;

    fn affine(&self, surface: Surface<f64>, z: f64) -> Affine<f64> {
        self.0.affine(surface, z)
    }

    fn affine_and_slopes(&self, surface: Surface<f64>, z: f64) -> (Affine<f64>, Affine<f64>) {
        self.0.affine_and_slopes(surface, z)
    }

    fn stationary(&self, surface: impl Into<Surface<f64>>) -> f64 {
        self.0.stationary(surface)
    }

    fn storage_stiffness(&self) -> f64 {
        self.0.storage_stiffness()
    }

    fn held(&self, _: LoadChange<f64>, _: Surface<f64>, _: f64) -> f64 {
        0.0
    }
}

#[test]
fn what_a_model_of_ones_own_says_of_a_load_is_heard_behind_the_door() {
    let model = LetsGo(POWER);
    let of = |mut contact: Contact<f64, AnyBristle<f64>>| contact.reload(1.5, 0.0, 1e-5).unwrap();
    let (own, ours) = (AnyBristle::own(model), AnyBristle::own(POWER));
    assert_eq!(of(own.under_load(2.0).unwrap()).deflection, 0.0);
    assert_eq!(of(ours.under_load(2.0).unwrap()).deflection, 1e-5);
}
