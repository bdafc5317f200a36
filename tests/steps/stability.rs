//! The predicted critical steps are those of the literature's table, and those at which the methods
//! themselves stop to calm a disturbance.

#![allow(clippy::unwrap_used, reason = "a test may fail")]

use std::ops::ControlFlow;

use bristle::Mechanism;
use bristle::curve::Stribeck;
use bristle::ode::{DormandPrince, DormandPrince8, Method, RungeKutta4, Solver, Step, System};
use bristle::regularisation::SquareRoot;
use bristle::rheology::{KelvinVoigt, Maxwell, MaxwellParameters};
use bristle::scene::{DiaphragmValve, MassSpringDamper};
use bristle::{Branch, Bristle, Contact, Dahl, DahlParameters, FrBd, LuGre, paper};
use bristle_analysis::step_limits::{Scheme, StepLimits, largest_step, largest_step_of};
use bristle_specimens::specimens;
use nalgebra::{Matrix2, Matrix3, Vector1, Vector2, Vector3, Vector4};

/// Schemes whose stuck limit can be met.
const LIMITED: [Scheme; 6] = [
    Scheme::Euler,
    Scheme::SemiImplicitEuler,
    Scheme::RungeKutta4,
    Scheme::DormandPrince,
    Scheme::DormandPrince8,
    Scheme::ExactHold,
];

type FrBdContact = Contact<f64, FrBd<Stribeck<f64>, KelvinVoigt<f64>>>;

fn table_2() -> FrBdContact {
    specimens::table_2_frbd().under_load(1.0).unwrap()
}

fn table_2_lugre() -> Contact<f64, LuGre<Stribeck<f64>, KelvinVoigt<f64>>> {
    specimens::table_2_lugre().under_load(1.0).unwrap()
}

fn table_3() -> FrBdContact {
    let (curve, bristle) =
        (Stribeck::new(paper::VALVE_CURVE), KelvinVoigt::new(paper::VALVE_BRISTLE));
    FrBd::new(curve.unwrap(), bristle.unwrap()).under_load(1.0).unwrap()
}

const FREE: Mechanism<f64> = Mechanism { mass: 1.0, spring_stiffness: 0.0, viscous_damping: 0.0 };
/// Table 3: the stem of the valve and its return spring.
const STEM: Mechanism<f64> =
    Mechanism { mass: 1.6, spring_stiffness: 203_495.8, viscous_damping: 0.0 };

/// Bristle at any velocity, stuck, stuck after a reversal.
fn limits(contact: &FrBdContact, mechanism: Mechanism<f64>, scheme: Scheme) -> [f64; 3] {
    let limits = largest_step(contact, Some(mechanism), f64::INFINITY, scheme).unwrap();
    [limits.bristle.unwrap(), limits.stuck_from_rest.unwrap(), limits.stuck_reversed.unwrap()]
}

// Against values from elsewhere

#[test]
fn the_critical_steps_of_the_papers_contacts_are_the_tabulated_ones() {
    // From the roots of the characteristic polynomials by a computer algebra system, to the digits
    // it was asked for.
    let rig = |scheme| limits(&table_2(), FREE, scheme);
    let valve = |scheme| limits(&table_3(), STEM, scheme);
    for (got, want) in [
        (rig(Scheme::Euler), ["1.2908e-2", "6.45e-3", "6.45e-3"]),
        (rig(Scheme::RungeKutta4), ["1.7976e-2", "2.80425e-2", "1.87119e-2"]),
        (rig(Scheme::SemiImplicitEuler), ["1.2908e-2", "1.456434e-2", "9.09357e-3"]),
        (valve(Scheme::Euler), ["1.07682e-4", "1.0262e-5", "1.0277e-5"]),
        (valve(Scheme::RungeKutta4), ["1.49964e-4", "4.4170e-4", "3.1459e-4"]),
        (valve(Scheme::SemiImplicitEuler), ["1.07682e-4", "2.9579e-4", "2.0642e-4"]),
    ] {
        for (got, want) in got.into_iter().zip(want) {
            let digits = want.find('e').unwrap() - 2;
            assert_eq!(format!("{got:.digits$e}"), want, "{got:e}");
        }
    }
}

#[test]
fn an_undamped_swing_is_held_by_its_frequency() {
    // Dahl: ω² = σ0 p c/m. Explicit Euler and the exact hold are unstable at every step, as their
    // step maps have a determinant above one.
    let (stiffness, mass) = (4e4, 0.25);
    let dahl = Dahl::new(DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: stiffness });
    let contact = dahl.unwrap().under_load(9.0).unwrap();
    let mechanism = Mechanism { mass, ..FREE };
    let omega = (stiffness * 9.0 / mass).sqrt();
    for (scheme, reach) in [
        (Scheme::Euler, 0.0),
        (Scheme::ExactHold, 0.0),
        (Scheme::SemiImplicitEuler, 2.0),
        (Scheme::RungeKutta4, 8.0f64.sqrt()),
    ] {
        let limits = largest_step(&contact, Some(mechanism), 1.0, scheme).unwrap();
        // The roots pass through a square root, bisection stops at the last digits.
        for (got, c) in [(limits.stuck_from_rest, 1.0f64), (limits.stuck_reversed, 2.0)] {
            let want = reach / (omega * c.sqrt());
            assert!((got.unwrap() - want).abs() <= 1e-12 * want, "{scheme}: {got:?}, not {want}");
        }
    }
    // DP5 has |R(iy)|² = 1 − y⁶/1800 + y⁸/1600 − y¹⁰/14400 + y¹²/360000: its terms of order 6 to
    // 12, from R = Σ zᵏ/k! + z⁶/600. With w = y², −1/1800 + w/1600 − w²/14400 + w³/360000 vanishes
    // at w:
    let excess = |w: f64| -1.0 / 1800.0 + w / 1600.0 - w * w / 14400.0 + w * w * w / 360_000.0;
    let limits = largest_step(&contact, Some(mechanism), 1.0, Scheme::DormandPrince).unwrap();
    let w = (limits.stuck_from_rest.unwrap() * omega).powi(2);
    assert!(excess(w).abs() < 1e-15 && excess(0.9 * w) < 0.0, "{w}");
}

#[test]
fn schemes_without_a_limit_have_none() {
    for scheme in [Scheme::Passive, Scheme::Rosenbrock] {
        let limits = largest_step(&table_2(), Some(FREE), 1.0, scheme).unwrap();
        assert_eq!(limits.overall(), None);
        assert!(limits.check(1e3).is_ok());
    }
    let held = largest_step(&table_2(), Some(FREE), 1.0, Scheme::ExactHold).unwrap();
    assert_eq!(held.bristle, None);
}

#[test]
fn without_forces_nothing_swings() {
    for scheme in Scheme::ALL {
        let contact = table_2().model().under_load(0.0).unwrap();
        let limits = largest_step(&contact, Some(FREE), 1.0, scheme).unwrap();
        assert_eq!((limits.stuck_from_rest, limits.stuck_reversed), (None, None), "{scheme}");
    }
}

#[test]
fn an_overdamped_swing_is_held_by_its_faster_root() {
    // m s² + d s + k with the roots −1 and −1000, contact without load: a = 1001/s, b = 1000/s².
    let mechanism = Mechanism { mass: 1.0, spring_stiffness: 1000.0, viscous_damping: 1001.0 };
    let contact = table_2().model().under_load(0.0).unwrap();
    for (scheme, reach) in [(Scheme::Euler, 2.0), (Scheme::RungeKutta4, 2.785_293_563_405_282)] {
        let stuck =
            largest_step(&contact, Some(mechanism), 1.0, scheme).unwrap().stuck_from_rest.unwrap();
        assert!((stuck - reach / 1000.0).abs() < 1e-12, "{scheme}: {stuck}");
    }
    // 2/a, where the determinant 1 − ha + h²b/2 and the trace 2 − ha − h²b/2 leave the triangle,
    // and 4/(a + √(a² + 4b)).
    let root = (1001.0f64 * 1001.0 + 4000.0).sqrt();
    for (scheme, want) in
        [(Scheme::ExactHold, 2.0 / 1001.0), (Scheme::SemiImplicitEuler, 4.0 / (1001.0 + root))]
    {
        let limits = largest_step(&contact, Some(mechanism), 1.0, scheme).unwrap();
        assert!((limits.stuck_from_rest.unwrap() - want).abs() < 1e-12, "{limits}");
    }
}

#[test]
fn a_creeping_bristle_leaves_the_oscillation_two_roots_of_the_cubic() {
    // (s + λ)(m s² + d s + k) + p K s = 0 with λ = K/η, of which the slow root is the creep.
    let (stiffness, relaxation, mass, damping, spring) = (1e4, 30.0, 1.0, 5.0, 1e3);
    let bristle = Maxwell::new(MaxwellParameters {
        micro_stiffness: stiffness,
        series_damping: stiffness / relaxation,
    });
    let contact = FrBd::new(specimens::table_2_curve(), bristle.unwrap());
    let contact = contact.under_load(1.0).unwrap();
    let mechanism = Mechanism { mass, spring_stiffness: spring, viscous_damping: damping };
    // The slow root by Newton's method from zero.
    let (mut slow, squares) = (0.0_f64, [damping + relaxation, stiffness + spring]);
    for _ in 0..50 {
        let linear = squares[1] + relaxation * damping;
        let value = ((slow + squares[0]) * slow + linear) * slow + relaxation * spring;
        slow -= value / ((3.0 * slow + 2.0 * squares[0]) * slow + linear);
    }
    let (a, b) = (damping + relaxation + slow, -relaxation * spring / slow);
    for (scheme, want) in [
        (Scheme::ExactHold, 2.0 * a / b),
        (Scheme::SemiImplicitEuler, 4.0 / (a + (a * a + 4.0 * b).sqrt())),
    ] {
        let limits = largest_step(&contact, Some(mechanism), 1.0, scheme).unwrap();
        let got = limits.stuck_from_rest.unwrap();
        // The slow root, λk/(b m) = 2.7/s to first order, is off by 2.7 (λ + d/m)/b, 0.84 % of it,
        // and b with it. Without it a would be off by 8 %.
        assert!((got / want - 1.0).abs() < 0.01, "{scheme}: {got}, not {want}");
    }
}

#[test]
fn an_elasto_plastic_bristle_holds_on_after_a_reversal() {
    let (curve, bristle) = specimens::table_2();
    let contact = specimens::elasto_plastic(curve, bristle, 5e-5).under_load(1.0).unwrap();
    for scheme in Scheme::ALL {
        let limits = largest_step(&contact, Some(FREE), 1.0, scheme).unwrap();
        assert_eq!(limits.stuck_from_rest, limits.stuck_reversed, "{scheme}");
    }
}

/// Two contacts have the same limits, up to a share of them.
fn assert_alike(one: StepLimits<f64>, other: StepLimits<f64>, share: f64) {
    for (a, b) in [
        (one.bristle, other.bristle),
        (one.stuck_from_rest, other.stuck_from_rest),
        (one.stuck_reversed, other.stuck_reversed),
    ] {
        assert_eq!(a.is_some(), b.is_some());
        let (a, b) = (a.unwrap_or(1.0), b.unwrap_or(1.0));
        assert!((a - b).abs() < share * b, "{one}: {a}, not {b}");
    }
}

#[test]
fn regularisation_hardly_changes_the_limits() {
    // √ε a ten-thousandth of the Stribeck velocity. The square root is within 2 % of the sign where
    // the contact breaks away.
    let model = table_2().model().regularised(SquareRoot::new(1e-12).unwrap());
    let smooth = model.under_load(1.0).unwrap();
    for scheme in LIMITED {
        let exact = largest_step(&table_2(), Some(FREE), 1.0, scheme).unwrap();
        assert_alike(largest_step(&smooth, Some(FREE), 1.0, scheme).unwrap(), exact, 0.02);
    }
}

// Any mechanism

/// A step that stays within |R| ≤ 1 on the way to its limit and leaves it there.
fn assert_leaves<M: Method<f64, 2> + Copy>(method: M, scheme: Scheme, real: f64, imaginary: f64) {
    struct Spiral(Matrix2<f64>);
    impl System<f64, 2, 0> for Spiral {
        fn rate(&self, _: f64, x: &Vector2<f64>, _: [Branch; 0]) -> Vector2<f64> {
            self.0 * x
        }
        fn sliding_velocities(&self, _: f64, _: &Vector2<f64>) -> [f64; 0] {
            []
        }
    }
    let spiral = Spiral(Matrix2::new(real, -imaginary, imaginary, real));
    let limit = largest_step_of(&spiral.0, scheme).unwrap();
    let after = |step: f64| {
        let solver = Solver::fixed(method, step).unwrap().plain();
        let start = Vector2::new(1.0, 0.0);
        let run = solver.stream(&spiral, 0.0..step, start, &[], &mut |_: &Step<f64, 2>| {
            ControlFlow::Continue(())
        });
        run.unwrap().state.norm()
    };
    // Bisected to the last digits; R has at most 13 terms, of which none exceeds e^6.4 ≈ 600.
    assert!((after(limit) - 1.0).abs() < 1e-10, "{scheme}: |R| = {}", after(limit));
    for part in 1..50 {
        assert!(after(limit * f64::from(part) / 50.0) <= 1.0 + 1e-14, "{scheme}");
    }
    assert!(after(limit * 1.001) > 1.0, "{scheme}");
}

#[test]
fn the_stability_functions_are_those_of_the_methods() {
    for angle in [0.0f64, 0.3, 0.8, 1.2, 1.5] {
        let (real, imaginary) = (-angle.cos(), angle.sin());
        assert_leaves(RungeKutta4, Scheme::RungeKutta4, real, imaginary);
        assert_leaves(DormandPrince, Scheme::DormandPrince, real, imaginary);
        assert_leaves(DormandPrince8, Scheme::DormandPrince8, real, imaginary);
    }
}

#[test]
fn a_scenes_jacobian_at_rest_gives_the_stuck_limits() {
    let rig = MassSpringDamper::new(paper::stick_slip_rig(table_2())).unwrap();
    let valve = DiaphragmValve::new(paper::valve(table_3(), 0.425, 50.0)).unwrap();
    let mechanism = Mechanism { spring_stiffness: 2.0, ..FREE };
    for scheme in
        [Scheme::Euler, Scheme::RungeKutta4, Scheme::DormandPrince, Scheme::DormandPrince8]
    {
        for reversed in [false, true] {
            let part = if reversed { -1.0 } else { 0.0 };
            // Eigenvalues of a balanced matrix keep all but a few digits.
            let assert_near = |got: Option<f64>, limits: StepLimits<f64>| {
                let want = if reversed { limits.stuck_reversed } else { limits.stuck_from_rest };
                let (got, want) = (got.unwrap(), want.unwrap());
                assert!((got - want).abs() < 1e-9 * want, "{scheme}: {got}, not {want}");
            };
            let at_rest = Vector3::new(0.0, 0.0, part * 1.5e-4);
            let tangent = rig.linearised(0.0, &at_rest, [Branch::Forward]).unwrap();
            let got = largest_step_of(&tangent.by_state, scheme);
            assert_near(got, largest_step(&table_2(), Some(mechanism), 1.0, scheme).unwrap());

            let at_rest = Vector4::new(0.0, 0.0, part * 59.86 / 6.82e7, 1e5);
            let tangent = valve.linearised(0.0, &at_rest, [Branch::Forward]).unwrap();
            let got = largest_step_of(&tangent.by_state, scheme);
            assert_near(got, largest_step(&table_3(), Some(STEM), 1.0, scheme).unwrap());
        }
    }
}

#[test]
fn modes_that_grow_by_themselves_set_no_limit() {
    let jacobian = Matrix2::new(3.0, 0.0, 0.0, -4.0);
    assert_eq!(largest_step_of(&jacobian, Scheme::Euler), Some(0.5));
    let growing = Matrix2::new(3.0, 0.0, 0.0, 4.0);
    assert_eq!(largest_step_of(&growing, Scheme::Euler), None);
    assert_eq!(largest_step_of(&jacobian, Scheme::Rosenbrock), None);
}

#[test]
fn where_a_matrix_cannot_tell_the_answer_is_nan() {
    let nan = Matrix3::new(1.0, 0.0, 0.0, 0.0, f64::NAN, 0.0, 0.0, 0.0, 1.0);
    assert!(largest_step_of(&nan, Scheme::RungeKutta4).unwrap().is_nan());
    for scheme in [Scheme::SemiImplicitEuler, Scheme::ExactHold, Scheme::Passive] {
        assert!(largest_step_of(&Matrix2::<f64>::identity(), scheme).unwrap().is_nan());
    }
}

// Refusals

#[test]
fn a_step_beyond_the_limit_is_refused_with_its_cause() {
    let limits = largest_step(&table_2(), Some(FREE), f64::INFINITY, Scheme::RungeKutta4).unwrap();
    assert!(limits.check(0.017_976_2).is_ok());
    let refused = limits.check(0.02).unwrap_err();
    assert_eq!((refused.name, refused.value), ("step", 0.02));
    let message = refused.to_string();
    let start = "step is 0.02, but must be at most the bristle's critical step = 0.017976";
    assert!(message.starts_with(start), "{message}");
    // The stuck mass is what holds the semi-implicit method.
    let limits =
        largest_step(&table_2(), Some(FREE), f64::INFINITY, Scheme::SemiImplicitEuler).unwrap();
    let message = limits.check(0.0125).unwrap_err().to_string();
    assert!(message.contains("after a reversal = 0.0090935"), "{message}");
    for step in [f64::NAN, 0.0, -1e-3, f64::INFINITY] {
        assert!(limits.check(step).is_err(), "{step}");
    }
}

#[test]
fn what_is_no_mechanism_is_refused_by_name() {
    let refused = |mechanism, fastest| {
        largest_step(&table_2(), Some(mechanism), fastest, Scheme::Euler).unwrap_err().name
    };
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(refused(Mechanism { mass: bad, ..FREE }, 1.0), "mass");
        assert_eq!(refused(Mechanism { spring_stiffness: bad, ..FREE }, 1.0), "spring_stiffness");
        assert_eq!(refused(Mechanism { viscous_damping: bad, ..FREE }, 1.0), "viscous_damping");
    }
    assert_eq!(refused(Mechanism { mass: 0.0, ..FREE }, 1.0), "mass");
    assert_eq!(refused(FREE, f64::NAN), "fastest");
    // LuGre relaxes without bound as it slides faster.
    let endless = largest_step(&table_2_lugre(), Some(FREE), f64::INFINITY, Scheme::RungeKutta4);
    let message = endless.unwrap_err().to_string();
    assert_eq!(message, "relaxation_rate is inf, but must be finite");
    // An exact step of the bristle does not mind.
    assert!(largest_step(&table_2_lugre(), Some(FREE), f64::INFINITY, Scheme::ExactHold).is_ok());
}

#[test]
fn single_precision_gives_the_same_limits() {
    let contact = specimens::table_2_frbd::<f32>().under_load(1.0).unwrap();
    let mechanism = Mechanism { mass: 1.0_f32, spring_stiffness: 0.0, viscous_damping: 0.0 };
    for scheme in LIMITED {
        let single = largest_step(&contact, Some(mechanism), 1.0, scheme).unwrap();
        let double = largest_step(&table_2(), Some(FREE), 1.0, scheme).unwrap();
        let mut wide = double;
        wide.bristle = single.bristle.map(f64::from);
        wide.stuck_from_rest = single.stuck_from_rest.map(f64::from);
        wide.stuck_reversed = single.stuck_reversed.map(f64::from);
        // Some roundings of the coefficients in single precision.
        assert_alike(wide, double, 3e-6);
    }
}

// Measured

/// A mass at rest on its bristles, spring and friction in balance. States: how far position,
/// velocity and deflection are off.
struct Stuck<M> {
    contact: Contact<f64, M>,
    mechanism: Mechanism<f64>,
    /// Deflection at rest.
    deflection: f64,
    /// The direction of sliding, where it is locked.
    lock: Option<Branch>,
}

impl<M: Bristle<f64, Deflection = f64>> Stuck<M> {
    fn branch(&self, free: Branch) -> Branch {
        self.lock.unwrap_or(free)
    }

    /// The force of everything but friction.
    fn others(&self, state: &Vector3<f64>) -> f64 {
        let Mechanism { spring_stiffness, viscous_damping, .. } = self.mechanism;
        -spring_stiffness * state[0] - viscous_damping * state[1]
    }

    /// The friction force beyond that at rest.
    fn friction(&self, force: f64) -> f64 {
        let branch = self.branch(Branch::Free);
        force - self.contact.force(branch.of(0.0), self.deflection)
    }

    /// One step of a scheme that is none of the library's methods.
    fn step(&self, scheme: Scheme, state: &Vector3<f64>, h: f64) -> Vector3<f64> {
        let [x, v, z] = [state[0], state[1], state[2] + self.deflection];
        let (branch, mass) = (self.branch(Branch::Free), self.mechanism.mass);
        match scheme {
            Scheme::Euler => state + self.rate(0.0, state, [Branch::Free]) * h,
            Scheme::SemiImplicitEuler => {
                let force = self.others(state) - self.friction(self.contact.force(branch.of(v), z));
                let v = v + force * h / mass;
                let rate = self.contact.rate(branch.of(v), z);
                Vector3::new(x + v * h, v, state[2] + rate * h)
            }
            Scheme::ExactHold => {
                let model = self.contact.model();
                let hold = model.affine(branch.of(v).into(), z).hold(v, z, h);
                let middle = Vector3::new(x + 0.5 * v * h, v, z);
                let mean = self.contact.normal_force() * hold.mean_coefficient;
                let force = self.others(&middle) - self.friction(mean);
                Vector3::new(x + v * h, v + force * h / mass, hold.deflection - self.deflection)
            }
            other => unreachable!("{other} is a method"),
        }
    }
}

impl<M: Bristle<f64, Deflection = f64>> System<f64, 3> for Stuck<M> {
    fn rate(&self, _: f64, state: &Vector3<f64>, [branch]: [Branch; 1]) -> Vector3<f64> {
        let sliding = self.branch(branch).of(state[1]);
        let friction = self.contact.response(sliding, self.deflection + state[2]);
        let force = self.others(state) - self.friction(friction.force);
        Vector3::new(state[1], force / self.mechanism.mass, friction.rate)
    }

    fn sliding_velocities(&self, _: f64, state: &Vector3<f64>) -> [f64; 1] {
        [state[1]]
    }
}

/// A bristle under a held velocity. State: how far its deflection is off the stationary one.
struct Held<M> {
    contact: Contact<f64, M>,
    velocity: f64,
}

impl<M: Bristle<f64, Deflection = f64>> System<f64, 1> for Held<M> {
    fn rate(&self, _: f64, state: &Vector1<f64>, _: [Branch; 1]) -> Vector1<f64> {
        let stationary = self.contact.stationary(self.velocity);
        Vector1::new(self.contact.rate(self.velocity, stationary + state[0]))
    }

    fn sliding_velocities(&self, _: f64, _: &Vector1<f64>) -> [f64; 1] {
        [self.velocity]
    }
}

/// Steps of a run. Near its critical step a disturbance changes by the part of the step that is too
/// much or too little, or more: 2 % off by e⁴ from the first half of a run to the second.
const STEPS: u32 = 400;

/// The plain method with fixed steps, as the library runs it; each state is shown.
fn run<M: Method<f64, N>, S: System<f64, N>, const N: usize>(
    method: M,
    system: &S,
    start: [f64; N],
    h: f64,
    mut show: impl FnMut(f64) -> ControlFlow<()>,
) {
    let mut observer = |step: &Step<f64, N>| show(step.end()[N.min(2) - 1]);
    let solver = Solver::fixed(method, h).unwrap().plain();
    let span = 0.0..h * f64::from(STEPS);
    solver.stream(system, span, start.into(), &[], &mut observer).unwrap();
}

/// Whether a small disturbance grows: its largest value in the second half of a run against that in
/// the first.
fn grows<S: System<f64, N>, const N: usize>(
    scheme: Scheme,
    system: &S,
    start: [f64; N],
    h: f64,
    step: impl Fn(&[f64; N]) -> [f64; N],
) -> bool {
    let mut largest = [0.0f64; 2];
    let mut taken = 0;
    let mut show = |value: f64| {
        let half = usize::from(taken >= STEPS / 2);
        largest[half] = largest[half].max(value.abs());
        taken += 1;
        // A thousandfold is enough, before the motion is no longer small.
        let start = start.iter().fold(0.0f64, |a, b| a.max(b.abs()));
        if value.abs() > 1e3 * start { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    match scheme {
        Scheme::DormandPrince => run(DormandPrince, system, start, h, &mut show),
        Scheme::DormandPrince8 => run(DormandPrince8, system, start, h, &mut show),
        _ => {
            let mut state = start;
            for _ in 0..STEPS {
                state = if scheme == Scheme::RungeKutta4 {
                    RungeKutta4::step(system, 0.0, &state.into(), h).into()
                } else {
                    step(&state)
                };
                if show(state[N.min(2) - 1]).is_break() {
                    return true;
                }
            }
        }
    }
    taken < STEPS || largest[1] > largest[0]
}

/// The first step, from small ones up, at which something starts; to a two-hundredth.
fn onset(smallest: f64, starts: impl Fn(f64) -> bool) -> f64 {
    assert!(!starts(smallest), "already at {smallest:e}");
    let mut below = smallest;
    // Narrower than any return to stability.
    while !starts(below * 1.2) {
        below *= 1.1;
        assert!(below < 1e3 * smallest, "never up to {below:e}");
    }
    let mut above = below * 1.2;
    while above > below * 1.005 {
        let middle = 0.5 * (below + above);
        if starts(middle) {
            above = middle;
        } else {
            below = middle;
        }
    }
    below
}

/// The step at which a small disturbance of a stuck mass starts to grow.
fn measured_stuck<M: Bristle<f64, Deflection = f64>>(
    contact: &Contact<f64, M>,
    mechanism: Mechanism<f64>,
    scheme: Scheme,
    reversed: bool,
    smallest: f64,
) -> f64 {
    let forward = Branch::Forward;
    let (deflection, lock) =
        if reversed { (-contact.stationary(forward.of(0.0)), Some(forward)) } else { (0.0, None) };
    let stuck = Stuck { contact: contact.clone(), mechanism, deflection, lock };
    // So little that even a thousandfold is small against the deflection at breakaway and the
    // Stribeck velocity.
    let kick = 1e-9 * contact.stationary(forward.of(0.0)) / 1e-4;
    onset(smallest, |h| {
        grows(scheme, &stuck, [0.0, kick, 0.0], h, |state| {
            stuck.step(scheme, &Vector3::from(*state), h).into()
        })
    })
}

fn assert_near(scheme: Scheme, measured: f64, predicted: Option<f64>) {
    let predicted = predicted.unwrap();
    let off = (measured / predicted - 1.0).abs();
    assert!(off < 0.01, "{scheme}: measured {measured:e}, predicted {predicted:e}");
}

/// Of a contact on a mechanism, searched for from a smallest step on.
fn assert_calms<M: Bristle<f64, Deflection = f64>>(
    contact: &Contact<f64, M>,
    mechanism: Mechanism<f64>,
    schemes: &[Scheme],
    smallest: f64,
) {
    for &scheme in schemes {
        let limits = largest_step(contact, Some(mechanism), 1.0, scheme).unwrap();
        for (reversed, limit) in [(false, limits.stuck_from_rest), (true, limits.stuck_reversed)] {
            let measured = measured_stuck(contact, mechanism, scheme, reversed, smallest);
            assert_near(scheme, measured, limit);
        }
    }
}

#[test]
fn a_stuck_mass_calms_down_up_to_the_predicted_step_and_no_further() {
    let sprung = Mechanism { spring_stiffness: 2.0, ..FREE };
    assert_calms(&table_2(), sprung, &LIMITED, 1e-3);
    assert_calms(&table_3(), STEM, &LIMITED, 2e-6);
    // LuGre is stuck as FrBD is.
    let schemes = [Scheme::Euler, Scheme::RungeKutta4, Scheme::ExactHold];
    assert_calms(&table_2_lugre(), sprung, &schemes, 1e-3);
}

/// The step at which a disturbed bristle under a held velocity runs away.
fn measured_bristle<M: Bristle<f64, Deflection = f64>>(
    contact: &Contact<f64, M>,
    velocity: f64,
    scheme: Scheme,
    smallest: f64,
) -> f64 {
    let held = Held { contact: contact.clone(), velocity };
    let kick = 1e-6 * contact.stationary(velocity);
    onset(smallest, |h| {
        grows(scheme, &held, [kick], h, |&[off]| {
            // Euler, and with a held velocity the semi-implicit method too.
            [off + h * held.rate(0.0, &Vector1::new(off), [Branch::Free])[0]]
        })
    })
}

#[test]
fn a_bristle_relaxes_up_to_the_predicted_step_and_no_further() {
    let schemes = [
        Scheme::Euler,
        Scheme::SemiImplicitEuler,
        Scheme::RungeKutta4,
        Scheme::DormandPrince,
        Scheme::DormandPrince8,
    ];
    for scheme in schemes {
        // FrBD relaxes fastest at infinite velocity, σ1|v| ≫ μ; LuGre ever faster.
        for (contact, smallest) in [(table_2(), 1e-3), (table_3(), 1e-5)] {
            let limits = largest_step(&contact, Some(FREE), f64::INFINITY, scheme).unwrap();
            let measured = measured_bristle(&contact, 1e3, scheme, smallest);
            assert_near(scheme, measured, limits.bristle);
        }
        let limits = largest_step(&table_2_lugre(), Some(FREE), 0.7, scheme).unwrap();
        let measured = measured_bristle(&table_2_lugre(), 0.7, scheme, 1e-5);
        assert_near(scheme, measured, limits.bristle);
    }
}

#[test]
fn an_exactly_held_undamped_bristle_never_calms_a_mass() {
    let dahl = Dahl::new(DahlParameters { dynamic_coefficient: 1.5, micro_stiffness: 1e4 });
    let contact = dahl.unwrap().under_load(1.0).unwrap();
    let limits = largest_step(&contact, Some(FREE), 1.0, Scheme::ExactHold).unwrap();
    assert_eq!(limits.overall(), Some(0.0));
    assert!(limits.check(1e-9).is_err());
    // A hundredth of the 2/ω at which the semi-implicit method gives up: |eigenvalue|² = 1 +
    // (ωh)²/2.
    let h = 2e-4;
    let stuck = Stuck { contact, mechanism: FREE, deflection: 0.0, lock: None };
    let mut state = Vector3::new(0.0, 1e-9, 0.0);
    let energy = |s: &Vector3<f64>| s[1] * s[1] + 1e4 * s[2] * s[2];
    let before = energy(&state);
    for _ in 0..STEPS {
        state = stuck.step(Scheme::ExactHold, &state, h);
    }
    let growth = energy(&state) / before;
    let predicted = (1.0f64 + (100.0 * h).powi(2) / 2.0).powi(STEPS as i32);
    // The energy of a rotating vector differs from its radius by ωh/2 or so.
    assert!((growth / predicted - 1.0).abs() < 0.05, "{growth}, not {predicted}");
}

#[test]
fn a_mode_of_rounding_size_does_not_limit_a_step() {
    // A decay of 1000/s beside a swing of 1e-9 rad/s, which is what rounding may leave of rest.
    // Euler's method enlarges every swing.
    let jacobian = Matrix3::new(-1e3, 0.0, 0.0, 0.0, 0.0, -1e-9, 0.0, 1e-9, 0.0);
    let step: f64 = largest_step_of(&jacobian, Scheme::Euler).unwrap();
    // |1 − 1000 h| = 1, found to a few roundings.
    assert!((step - 2e-3).abs() < 1e-12, "{step}");
}
