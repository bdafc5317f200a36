//! The predicted critical steps are those of the literature's table, and those at which a step
//! begins to make a disturbance grow.

use std::ops::ControlFlow;

use bristle::Mechanism;
use bristle::curve::Stribeck;
use bristle::ode::{DormandPrince, DormandPrince8, Method, RungeKutta4, Solver, Step, System};
use bristle::regularisation::SquareRoot;
use bristle::rheology::{KelvinVoigt, Maxwell, MaxwellParameters};
use bristle::scene::{DiaphragmValve, MassSpringDamper};
use bristle::{Branch, Bristle, Contact, Dahl, DahlParameters, FrBd, LuGre, paper};
use bristle_analysis::step_limits::{Scheme, StepLimits, largest_step, largest_step_of};
use bristle_specimens::{ode::Field, runge_kutta, specimens};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3, Vector4};

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
    // LuGre relaxes ever faster, at 0.7 m/s with σ0|v|/μ_d.
    let lugre = largest_step(&table_2_lugre(), Some(FREE), 0.7, Scheme::Euler).unwrap();
    assert!((lugre.bristle.unwrap() - 2.0 / 7000.0).abs() < 1e-15, "{lugre}");
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

/// A step that stays within |R| ≤ 1 on the way to its limit and leaves it there.
fn assert_leaves<M: Method<f64, 2> + Copy>(method: M, scheme: Scheme, real: f64, imaginary: f64) {
    let matrix = Matrix2::new(real, -imaginary, imaginary, real);
    let spiral = Field(|_: f64, x: &Vector2<f64>| matrix * x);
    let limit = largest_step_of(&matrix, scheme).unwrap();
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

/// A mass at rest on its bristles, spring and friction in balance.
struct Stuck<M> {
    contact: Contact<f64, M>,
    mechanism: Mechanism<f64>,
    /// Deflection at rest.
    deflection: f64,
    branch: Branch,
}

impl<M: Bristle<f64, Deflection = f64>> Stuck<M> {
    /// Unstretched, or stretched backwards to breakaway and about to slide forwards.
    fn new(contact: &Contact<f64, M>, mechanism: Mechanism<f64>, reversed: bool) -> Self {
        let breakaway = contact.stationary(Branch::Forward.of(0.0));
        let (deflection, branch) =
            if reversed { (-breakaway, Branch::Forward) } else { (0.0, Branch::Free) };
        Self { contact: contact.clone(), mechanism, deflection, branch }
    }

    fn acceleration(&self, x: f64, v: f64, friction: f64) -> f64 {
        let Mechanism { mass, spring_stiffness, viscous_damping } = self.mechanism;
        let beyond_rest = friction - self.contact.force(self.branch.of(0.0), self.deflection);
        -(spring_stiffness * x + viscous_damping * v + beyond_rest) / mass
    }

    fn rate(&self, [x, v, z]: [f64; 3]) -> [f64; 3] {
        let friction = self.contact.response(self.branch.of(v), z);
        [v, self.acceleration(x, v, friction.force), friction.rate]
    }

    fn step(&self, scheme: Scheme, state: [f64; 3], h: f64) -> [f64; 3] {
        let [x, v, z] = state;
        let sliding = self.branch.of(v);
        match scheme {
            Scheme::Euler => {
                let rate = self.rate(state);
                std::array::from_fn(|i| state[i] + h * rate[i])
            }
            Scheme::SemiImplicitEuler => {
                let v = v + h * self.acceleration(x, v, self.contact.force(sliding, z));
                [x + h * v, v, z + h * self.contact.rate(self.branch.of(v), z)]
            }
            Scheme::RungeKutta4 => runge_kutta(0.0..h, 1, state, |_, state| self.rate(state)),
            Scheme::ExactHold => {
                let hold = self.contact.affine(sliding, z).hold(v, z, h);
                let mean = self.contact.normal_force() * hold.mean_coefficient;
                let acceleration = self.acceleration(x + 0.5 * v * h, v, mean);
                [x + h * v, v + h * acceleration, hold.deflection]
            }
            other => unreachable!("{other} is compared with its method above"),
        }
    }

    /// The largest eigenvalue of a step, from central differences: smooth ones at breakaway, and
    /// such as the |v| z of the free branch does not see at rest.
    fn growth(&self, scheme: Scheme, h: f64) -> f64 {
        let size = if self.branch == Branch::Free { 1e-15 } else { 1e-9 };
        let columns = [size, 10.0 * size, size].into_iter().enumerate().map(|(i, kick)| {
            let [above, below] = [kick, -kick].map(|kick| {
                let mut state = [0.0, 0.0, self.deflection];
                state[i] += kick;
                Vector3::from(self.step(scheme, state, h))
            });
            (above - below) / (2.0 * kick)
        });
        let eigenvalues = Matrix3::from_columns(&columns.collect::<Vec<_>>()).complex_eigenvalues();
        eigenvalues.iter().map(|value| value.norm_sqr().sqrt()).fold(0.0, f64::max)
    }
}

/// Up to the predicted steps a disturbance does not grow, and a hundredth beyond it does.
fn assert_calms<M: Bristle<f64, Deflection = f64>>(
    contact: &Contact<f64, M>,
    mechanism: Mechanism<f64>,
) {
    for scheme in [Scheme::Euler, Scheme::SemiImplicitEuler, Scheme::RungeKutta4, Scheme::ExactHold]
    {
        let limits = largest_step(contact, Some(mechanism), 1.0, scheme).unwrap();
        for (reversed, limit) in [(false, limits.stuck_from_rest), (true, limits.stuck_reversed)] {
            let stuck = Stuck::new(contact, mechanism, reversed);
            let growth = |share: f64| stuck.growth(scheme, share * limit.unwrap());
            for share in [0.01, 0.1, 0.3, 0.6, 0.9, 0.99] {
                // A mode without a force stays at one; the differences have six digits.
                assert!(growth(share) <= 1.0 + 1e-6, "{scheme} {share}: {}", growth(share));
            }
            assert!(growth(1.01) > 1.0 + 1e-5, "{scheme}: {}", growth(1.01));
        }
    }
}

#[test]
fn a_stuck_mass_calms_down_up_to_the_predicted_step_and_no_further() {
    let sprung = Mechanism { spring_stiffness: 2.0, ..FREE };
    assert_calms(&table_2(), sprung);
    assert_calms(&table_3(), STEM);
    // LuGre is stuck as FrBD is.
    assert_calms(&table_2_lugre(), sprung);
}

#[test]
fn an_exactly_held_undamped_bristle_never_calms_a_mass() {
    let dahl = Dahl::new(DahlParameters { dynamic_coefficient: 1.5, micro_stiffness: 1e4 });
    let contact = dahl.unwrap().under_load(1.0).unwrap();
    let limits = largest_step(&contact, Some(FREE), 1.0, Scheme::ExactHold).unwrap();
    assert_eq!(limits.overall(), Some(0.0));
    assert!(limits.check(1e-9).is_err());
    // A hundredth of the 2/ω at which the semi-implicit method gives up: |eigenvalue|² = 1 +
    // (ωh)²/2, and the differences have six digits of the one.
    let growth = Stuck::new(&contact, FREE, false).growth(Scheme::ExactHold, 2e-4);
    assert!((growth.powi(2) - 1.0 - 2e-4).abs() < 1e-6, "{growth}");
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
