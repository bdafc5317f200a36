//! Bristles of several axes in a batch: the steps of a [`PlaneContact`], the energy balance under
//! loads that vary, and the same bits in every order.

use std::array::from_fn;

use bristle::Bristle;
use bristle::curve::{FrictionCurve, Stribeck, StribeckParameters};
use bristle_batch::{
    Batch, BatchError, CommitInput, Outcome, PassiveOutput, Real, ReloadInput, StepInput,
};
use bristle_plane::{Axis, PlaneBristle, PlaneContact, PlaneFrBd};
use nalgebra::SVector;
use proptest::array::uniform;
use proptest::prelude::*;

use crate::f;
use bristle_specimens::draw::Draw;
use bristle_specimens::recipe::{decades, velocity};
use bristle_specimens::specimens::kelvin_voigt;
use bristle_specimens::{assert_within, check, lit};

type Model<T, const N: usize> = PlaneFrBd<Stribeck<T>, T, N>;

/// Curve, axes and a few bristles.
#[derive(Debug, Clone)]
struct Case<const N: usize> {
    /// μ_d, μ_s, v_S, δ, σ2
    curve: [f64; 5],
    /// a, σ0, σ1
    axes: [[f64; 3]; N],
    bristles: Vec<Grain<N>>,
    duration: f64,
}

/// Velocities predicted and found, deflection over μ_d/σ0, normal forces in turn.
#[derive(Debug, Clone)]
struct Grain<const N: usize> {
    predicted: [f64; N],
    mean: [f64; N],
    deflection: [f64; N],
    loads: [f64; 4],
}

fn case<const N: usize>() -> impl Strategy<Value = Case<N>> {
    let zero_or = |most: f64| prop_oneof![1 => Just(0.0), 4 => decades(1e-3 * most, most)];
    let axis = (decades(0.1, 10.0), decades(1e2, 1e5), zero_or(1e3));
    let grain =
        (uniform(velocity()), uniform(velocity()), uniform(-3.0..3.0), uniform(zero_or(1e3)))
            .prop_map(|(predicted, mean, deflection, loads)| Grain {
                predicted,
                mean,
                deflection,
                loads,
            });
    (
        (decades(0.1, 2.0), 1.0..2.0, decades(1e-3, 1.0), prop_oneof![Just(1.0), Just(2.0)]),
        zero_or(1.0),
        uniform::<_, N>(axis),
        prop::collection::vec(grain, 1..40),
        zero_or(10.0),
        any::<bool>(),
    )
        .prop_map(
            |((dynamic, rise, stribeck, exponent), viscous, axes, bristles, duration, alike)| {
                Case {
                    curve: [dynamic, dynamic * rise, stribeck, exponent, viscous],
                    axes: axes.map(|(ratio, stiffness, damping)| match (alike, axes[0]) {
                        (true, (_, stiffness, damping)) => [1.0, stiffness, damping],
                        _ => [ratio, stiffness, damping],
                    }),
                    bristles,
                    duration,
                }
            },
        )
}

impl<const N: usize> Case<N> {
    fn curve<T: Real>(&self) -> Stribeck<T> {
        let [dynamic, static_, stribeck, exponent, viscous] = self.curve.map(lit);
        Stribeck::new(StribeckParameters {
            dynamic_coefficient: dynamic,
            static_coefficient: static_,
            stribeck_velocity: stribeck,
            stribeck_exponent: exponent,
            viscous_friction: viscous,
        })
        .unwrap()
    }

    fn model<T: Real>(&self) -> Model<T, N> {
        let axes = self.axes.map(|[ratio, micro_stiffness, micro_damping]| {
            let bristle = kelvin_voigt(lit(micro_stiffness), lit(micro_damping));
            Axis { friction_ratio: lit(ratio), bristle }
        });
        PlaneFrBd::new(self.curve(), axes).unwrap()
    }

    /// One axis after the other.
    fn column<T: Real>(&self, of: impl Fn(&Grain<N>, usize) -> f64) -> Vec<T> {
        (0..N)
            .flat_map(|i| self.bristles.iter().map(move |one| (one, i)))
            .map(|(grain, i)| lit(of(grain, i)))
            .collect()
    }

    fn deflections<T: Real>(&self) -> Vec<T> {
        self.column(|grain, i| grain.deflection[i] * self.curve[0] / self.axes[i][1])
    }

    fn loads<T: Real>(&self, time: usize) -> Vec<T> {
        self.bristles.iter().map(|grain| lit(grain.loads[time])).collect()
    }
}

/// The components of bristle k.
fn of<T: Real, const N: usize>(column: &[T], k: usize) -> SVector<T, N> {
    SVector::from_fn(|i, _| column[i * (column.len() / N) + k])
}

/// What a passive step leaves.
#[derive(Debug, Clone)]
struct Passive<T> {
    share: Vec<T>,
    bias: Vec<T>,
    damping: Vec<T>,
    after: Vec<T>,
}

/// Deflections in place of `before`, under loads, at predicted and mean velocities.
fn passive<T: Real, const N: usize>(
    batch: &Batch<'_, T, N>,
    [predicted, mean, before, loads]: [&[T]; 4],
    duration: T,
) -> (Passive<T>, [Outcome; 2]) {
    let column = || vec![T::zero(); before.len()];
    let mut step =
        Passive { share: column(), bias: column(), damping: column(), after: before.to_vec() };
    let input =
        StepInput { velocities: predicted, normal_forces: loads, deflections: &mut step.after };
    let output = PassiveOutput {
        shares: &mut step.share,
        biases: &mut step.bias,
        dampings: &mut step.damping,
    };
    let begun = batch.companions(input, duration, output).unwrap();
    let found = CommitInput { shares: &step.share, velocities: mean, normal_forces: loads };
    let ended = batch.commit(found, duration, &mut step.after).unwrap();
    (step, [begun, ended])
}

/// The implicit midpoint rule with the coefficients of the contact's axes, in f64 of the model's
/// own numbers; the exact step and the change of load of the contact itself.
fn steps_are_those_of_a_contact<T: Real, const N: usize>() {
    check(150, case::<N>(), |case| {
        let (model, h) = (case.model::<T>(), lit::<T>(case.duration));
        let batch = Batch::of(&model).unwrap();
        let predicted = case.column::<T>(|grain, i| grain.predicted[i]);
        let mean = case.column::<T>(|grain, i| grain.mean[i]);
        let (before, loads) = (case.deflections::<T>(), case.loads::<T>(0));
        let (step, outcomes) = passive(&batch, [&predicted, &mean, &before, &loads], h);
        assert!(outcomes.iter().all(Outcome::is_finite), "{case:?}");
        let (mut held, mut force) = (before.clone(), before.clone());
        let input =
            StepInput { velocities: &predicted, normal_forces: &loads, deflections: &mut held };
        assert!(batch.hold(input, h, &mut force).unwrap().is_finite());
        // A change of the load where the stiffness stays.
        let (mut reloaded, mut slipped) = (before.clone(), loads.clone());
        let after = case.loads::<T>(1);
        let change = ReloadInput { before: &loads, after: &after, velocities: &predicted };
        let measured = batch.measured_at(lit(2.0)).unwrap();
        assert!(measured.reload(change, &mut reloaded, &mut slipped).unwrap().is_finite());

        let epsilon = f(T::default_epsilon());
        for (k, grain) in case.bristles.iter().enumerate() {
            let contact: PlaneContact<T, _, N> = model.under_load(loads[k]).unwrap();
            let (v, z) = (of::<T, N>(&predicted, k), of::<T, N>(&before, k));
            let axes = contact.model().axes(&v);
            let exact = contact.hold(&v, &z, h);
            let steady = contact.stationary(&v);
            for i in 0..N {
                let a = axes[i].affine(v[i].into(), z[i]);
                let states = [z[i], of::<T, N>(&mean, k)[i]];
                let [bias, damping, after, size] = crate::midpoint(a, loads[k], states, f(h));
                let (h, load, z) = (f(h), f(loads[k]), f(z[i]));
                // The limit of the curve's maximum, with the sum of the speeds for their norm.
                let speed: f64 = grain.mean.iter().map(|v| v.abs()).sum();
                let most = case.curve[1] + case.curve[4] * speed;
                let most = (most * case.axes[i][0] / case.axes[i][1]).max(z.abs());
                let what = |name: &str| format!("{name} of bristle {k}, axis {i}, {case:?}");
                let near = |ulps: f64, scale: f64, got: T, want: f64, name: &str| {
                    assert_within(ulps * epsilon, scale, f(got), want, || what(name));
                };
                let at = i * case.bristles.len() + k;
                near(20.0, bias.abs(), step.bias[at], bias, "bias");
                near(20.0, damping, step.damping[at], damping, "damping");
                near(20.0, size + 0.1 * most, step.after[at], after.clamp(-most, most), "passive");
                // 1 − φ1 = x φ2 loses two digits above x = ½ in the scalar step.
                let x = (f(a.relaxation) * h).min(1.0);
                let size = z.abs() + x * f(steady[i]).abs();
                near(24.0, size, held[at], f(exact.deflection[i]), "exact deflection");
                let v = f(predicted[at]);
                let size = load * (f(a.stiffness) * size + f(a.damping) * v.abs());
                near(28.0, size, force[at], f(exact.mean_force[i]), "exact force");
            }
            // What had no load has no deflection, which a contact does not know.
            let z = if loads[k] == T::zero() { z * T::zero() } else { z };
            let contact = model.under_load(loads[k]).unwrap();
            let mut contact: PlaneContact<T, _, N> = contact.measured_at(lit(2.0)).unwrap();
            let (stored, v) = (f(contact.stored_energy(&z)), of::<T, N>(&predicted, k));
            let want = contact.reload(lit(grain.loads[1]), &v, &z).unwrap();
            // A viscous curve may be highest between rest and v, and hold a little more there.
            let (curve, v) = (case.curve::<f64>(), f(v.norm()));
            let ends = curve.coefficient(v.into()).max(case.curve[1]);
            let between = curve.bounds(v).max > ends * (1.0 + 8.0 * epsilon);
            for i in 0..N {
                let (got, want) = (f(reloaded[i * case.bristles.len() + k]), f(want.deflection[i]));
                if between {
                    assert!(got.abs() <= want.abs() * (1.0 + 24.0 * epsilon), "{k}, {case:?}");
                } else {
                    let size = f(z[i]).abs();
                    assert_within(24.0 * epsilon, size, got, want, || format!("{k}, {case:?}"));
                }
            }
            if !between {
                let want = f(want.dissipated);
                assert_within(24.0 * epsilon, stored, f(slipped[k]), want, || format!("{case:?}"));
            }
        }
    });
}

#[test]
fn steps_of_several_axes_are_those_of_a_contact_in_a_plane() {
    steps_are_those_of_a_contact::<f64, 1>();
    steps_are_those_of_a_contact::<f64, 2>();
    steps_are_those_of_a_contact::<f64, 3>();
    steps_are_those_of_a_contact::<f32, 2>();
}

/// Loads that come and go, velocities that nobody predicted.
fn contacts_that_come_and_go_give_no_energy<T: Real, const N: usize>(stays: bool) {
    check(200, case::<N>(), |case| {
        let count = case.bristles.len();
        let reference = lit::<T>(3.0);
        let batch = Batch::of(&case.model::<T>()).unwrap();
        let batch = if stays { batch.measured_at(reference).unwrap() } else { batch };
        let predicted = case.column::<T>(|grain, i| grain.predicted[i]);
        let mean = case.column::<T>(|grain, i| grain.mean[i]);
        let stored = |z: &[T], loads: &[T], k: usize| -> f64 {
            let half = |i: usize| 0.5 * case.axes[i][1] * f(z[i * count + k]).powi(2);
            f(if stays { reference } else { loads[k] }) * (0..N).map(half).sum::<f64>()
        };
        let mut z = case.deflections::<T>();
        for time in 0..3 {
            let [loads, next] = [time, time + 1].map(|time| case.loads::<T>(time));
            if stays {
                // What has no load is born unstretched.
                let none = |at: usize| loads[at % count] == T::zero();
                (0..z.len()).filter(|&at| none(at)).for_each(|at| z[at] = T::zero());
            }
            let (step, _) = passive(&batch, [&predicted, &mean, &z, &loads], lit(case.duration));
            let mut left = loads.clone();
            let mut after = step.after.clone();
            if stays {
                let change = ReloadInput { before: &loads, after: &next, velocities: &mean };
                assert!(batch.reload(change, &mut after, &mut left).unwrap().is_finite());
            } else {
                // min(1, p/p')
                let rising = |at: usize| next[at % count] > loads[at % count];
                let share = |at: usize| loads[at % count] / next[at % count];
                (0..z.len()).filter(|&at| rising(at)).for_each(|at| after[at] *= share(at));
            }
            for k in 0..count {
                let (mut work, mut terms) = (0.0, 0.0);
                for at in (0..N).map(|i| i * count + k) {
                    let (v, b, c) = (f(mean[at]), f(step.bias[at]), f(step.damping[at]));
                    work += case.duration * v * (b + c * v);
                    terms += case.duration * v.abs() * (b.abs() + c * v.abs());
                }
                let [first, second] = [&z, &step.after].map(|z| stored(z, &loads, k));
                let last = stored(&after, &next, k);
                let rounding = 32.0 * f(T::default_epsilon()) * (terms + first + second);
                let dissipated = work - (second - first);
                assert!(dissipated >= -rounding, "{dissipated:e} of {k}, {case:?}");
                // What leaves is what is missing, and some of it leaves unless the load stays.
                let left = if stays { f(left[k]) } else { (second - last).max(0.0) };
                assert!(left >= 0.0);
                assert_within(1.0, rounding, second - last, left, || format!("{case:?}"));
                if stays && (loads[k] == T::zero() || next[k] == T::zero()) {
                    assert!(of::<T, N>(&after, k).iter().all(|&z| z == T::zero()), "it remembers");
                }
            }
            z = after;
        }
    });
}

#[test]
fn contacts_of_several_axes_that_come_and_go_give_no_energy_that_was_not_stored() {
    for stays in [false, true] {
        contacts_that_come_and_go_give_no_energy::<f64, 2>(stays);
        contacts_that_come_and_go_give_no_energy::<f64, 3>(stays);
        contacts_that_come_and_go_give_no_energy::<f32, 2>(stays);
    }
}

fn friction<const N: usize>(ratios: [f64; N]) -> Model<f64, N> {
    let bristle = crate::kelvin_voigt();
    let axes = ratios.map(|friction_ratio| Axis { friction_ratio, bristle });
    PlaneFrBd::new(crate::stribeck(2.0), axes).unwrap()
}

#[test]
fn one_axis_of_a_plane_and_a_motion_along_one_axis_give_the_bits_of_the_line() {
    let line = crate::friction::<f64>();
    let line = Batch::of(&line).unwrap();
    let mut draw = Draw(11);
    let mut column =
        |size: f64| [(); 67].map(|()| draw.sign() * draw.logarithmic(1e-6 * size, size));
    let (predicted, mean, before) = (column(10.0), column(10.0), column(3e-4));
    let loads = column(1e3).map(f64::abs);
    let bits = |step: &Passive<f64>| -> Vec<u64> {
        let columns = [&step.share, &step.bias, &step.damping, &step.after];
        columns.iter().flat_map(|column| column[..67].iter().map(|x| x.to_bits())).collect()
    };
    let (want, _) = passive(&line, [&predicted, &mean, &before, &loads], 1e-3);
    let plane = Batch::of(&friction([1.0])).unwrap();
    let (got, _) = passive(&plane, [&predicted, &mean, &before, &loads], 1e-3);
    assert_eq!(bits(&got), bits(&want));
    // The root of a square is exact.
    let with_none = |column: [f64; 67]| [column.to_vec(), vec![0.0; 67]].concat();
    let [predicted, mean, before] = [predicted, mean, before].map(with_none);
    let (got, _) =
        passive(&line.isotropic::<2>().unwrap(), [&predicted, &mean, &before, &loads], 1e-3);
    assert_eq!(bits(&got), bits(&want));
}

/// All bits of a step of bristles in a given order, back in their own order.
fn in_order(batch: &Batch<'_, f64, 2>, order: &[usize]) -> Vec<[u64; 8]> {
    let count = order.len();
    let mut draw = Draw(3);
    let mut column = |axes: usize, size: f64| -> Vec<f64> {
        let own: Vec<_> =
            (0..axes * count).map(|_| draw.sign() * draw.logarithmic(1e-6 * size, size)).collect();
        (0..axes).flat_map(|i| order.iter().map(move |k| i * count + k)).map(|at| own[at]).collect()
    };
    let (predicted, mean, before) = (column(2, 10.0), column(2, 10.0), column(2, 3e-4));
    let loads: Vec<_> = column(1, 1e3).iter().map(|load| load.abs()).collect();
    let (step, _) = passive(batch, [&predicted, &mean, &before, &loads], 1e-3);
    let mut bits = vec![[0; 8]; count];
    for (place, &k) in order.iter().enumerate() {
        let columns = [&step.share, &step.bias, &step.damping, &step.after];
        bits[k] = from_fn(|at| columns[at / 2][at % 2 * count + place].to_bits());
    }
    bits
}

#[test]
fn contacts_in_every_order_get_the_same_bits() {
    let batch = Batch::of(&friction([1.0, 0.6])).unwrap();
    let mut order: Vec<usize> = (0..20_003).collect();
    let want = in_order(&batch, &order);
    order.reverse();
    assert_eq!(in_order(&batch, &order), want);
    let mut draw = Draw(1);
    for last in (1..order.len()).rev() {
        order.swap(last, (draw.next() * (last + 1) as f64) as usize);
    }
    assert_eq!(in_order(&batch, &order), want);
    #[cfg(feature = "rayon")]
    assert_eq!(in_order(&batch.in_parallel(), &order), want);
}

#[test]
fn slices_that_do_not_go_with_the_number_of_axes_are_refused() {
    let batch = Batch::of(&friction([1.0, 0.6])).unwrap();
    let mut z = [0.0; 4];
    let mut hold = |velocities: &[f64], normal_forces: &[f64]| {
        let input = StepInput { velocities, normal_forces, deflections: &mut z };
        batch.hold(input, 1e-3, &mut [0.0; 4]).unwrap_err().to_string()
    };
    let text = "normal_forces has length 4, but velocities asks for 2";
    assert_eq!(hold(&[0.1; 4], &[1.0; 4]), text);
    let text = "velocities has length 5, which is no multiple of 2, the number of axes";
    assert_eq!(hold(&[0.1; 5], &[1.0; 2]), text);
    let loads = ReloadInput { before: &[1.0; 4], after: &[1.0; 4], velocities: &[0.1; 8] };
    let measured = batch.measured_at(1.0).unwrap();
    let refused = measured.reload(loads, &mut z, &mut [0.0; 4]).unwrap_err();
    assert!(matches!(refused, BatchError::Length { name: "deflections", expected: 8, .. }));
    // No axes are no bristles.
    let none = Batch::of(&friction([])).unwrap();
    let input = StepInput { velocities: &[], normal_forces: &[], deflections: &mut [] };
    assert!(none.hold(input, 1e-3, &mut []).unwrap().is_finite());
}

#[test]
fn what_is_not_finite_on_one_axis_is_counted_for_its_bristle() {
    let batch = Batch::of(&friction([1.0, 0.6])).unwrap();
    let count = |velocities: [f64; 4], loads: [f64; 2]| {
        let before = [1e-5, 1e-5, f64::MIN_POSITIVE, 0.0];
        passive(&batch, [&velocities, &velocities, &before, &loads], 1e-3).1
    };
    let (first, none) = (Outcome { not_finite: 1, first: Some(1) }, Outcome::default());
    for nothing in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(count([0.1, 0.1, 0.1, nothing], [1.0; 2]), [first; 2]);
        assert_eq!(count([0.1; 4], [1.0, nothing]), [first, none]);
    }
    // Neither rest nor what is next to it divides by zero; nor does no load.
    assert_eq!(count([0.0, -0.0, 5e-324, 1e-200], [0.0, 1.0]), [none; 2]);
}
