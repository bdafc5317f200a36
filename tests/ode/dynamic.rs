//! Systems of a size known at run time.

use bristle::ode::{
    self, AnyMethod, Output, Solver, StopReason, System, Tolerances, Trajectory, dynamic,
};
use bristle::{Branch, Scalar};
use bristle_specimens::blocks::{Blocks, Few};
use bristle_specimens::draw::Draw;
use bristle_specimens::joints::{Arm, Axes, Joints, Yielding};
use bristle_specimens::lit;
use bristle_specimens::ode::MOST_STEPS;
use nalgebra::SVector;

use crate::drawn::distance;

/// The same runs of both, by every method with an error estimate.
fn same_bits<T: Scalar, const N: usize, const K: usize>(tolerance: f64, end: f64) {
    let (blocks, span) = (Blocks(K), T::zero()..lit(end));
    let scales = SVector::<T, N>::from_fn(|i, _| Blocks::scale(i));
    let fixed = Tolerances::scaled(lit(tolerance), scales).unwrap();
    let grown = dynamic::Tolerances::scaled(lit(tolerance), scales.as_slice().to_vec()).unwrap();
    for method in ["automatic", "dormand_prince", "dormand_prince8", "rodas4", "rodas5p"] {
        let method: AnyMethod = method.parse().unwrap();
        let pairs = [
            (Solver::adaptive(method, fixed), dynamic::Solver::adaptive(method, grown.clone())),
            (Solver::checked(method, fixed), dynamic::Solver::checked(method, grown.clone())),
        ];
        for (of_fixed, of_grown) in pairs {
            let of_fixed = of_fixed.with_most_steps(MOST_STEPS);
            let of_grown = of_grown.with_most_steps(MOST_STEPS);
            let (start, output) = (SVector::<T, N>::zeros(), Output::Uniform(50));
            let one: Trajectory<T, N> =
                of_fixed.solve(&Few::<K>, span.clone(), start, output).unwrap();
            let start = vec![T::zero(); N];
            let other = of_grown.solve(&blocks, span.clone(), start, output).unwrap();
            assert_eq!(one.statistics(), other.statistics(), "{method}");
            assert!(one.statistics().reversals > 0, "{method}");
            for (one, other) in one.states().iter().zip(other.states()) {
                assert_eq!(one.as_slice(), &other[..], "{method}");
            }
            assert_eq!(one.reversals().len(), other.reversals().len());
            for (one, other) in one.reversals().iter().zip(other.reversals()) {
                assert!(one.index == other.index && one.time == other.time, "{method}");
                assert_eq!(one.state.as_slice(), &other.state[..], "{method}");
            }
        }
    }
}

#[test]
fn a_system_of_either_kind_has_the_same_bits() {
    // 1, 3 and 4 blocks: below and from twelve states on the error is estimated in two ways.
    same_bits::<f64, 3, 1>(1e-5, 10.0);
    same_bits::<f64, 9, 3>(1e-5, 5.0);
    same_bits::<f64, 12, 4>(1e-5, 5.0);
    same_bits::<f32, 9, 3>(1e-3, 5.0);
}

/// Where the curves of steps that were cut at a reversal were not looked at, samples were off by 74
/// tolerances at 1e-5 and by 140 at 1e-7.
#[test]
fn of_many_contacts_the_curve_up_to_a_reversal_is_near_as_well() {
    let (scales, span) = (SVector::<f64, 21>::from_fn(|i, _| Blocks::scale(i)), 0.0..5.0);
    let (start, output) = (SVector::zeros(), Output::Uniform(201));
    let fine = Tolerances::scaled(1e-10, scales).unwrap();
    let fine = Solver::adaptive(AnyMethod::Rodas5P, fine);
    let fine = fine.solve(&Few::<7>, span.clone(), start, output).unwrap();
    for tolerance in [1e-4, 1e-5, 1e-6, 1e-7] {
        let run = ode::solve(&Few::<7>, span.clone(), start, tolerance, output).unwrap();
        let samples = run.states().iter().zip(fine.states());
        let off = samples.map(|(run, fine)| (run - fine).component_div(&scales).amax());
        let worst = off.fold(0.0, f64::max) / tolerance;
        assert!(worst < 20.0, "{tolerance}: {worst}");
    }
}

/// At 301 times an answer is within 50 tolerances of one with steps as tight as rounding allows.
fn assert_near<S: System<f64, N, K>, const N: usize, const K: usize>(joints: &S, tolerance: f64) {
    let (start, span, output) = (SVector::zeros(), 0.0..3.0, Output::Uniform(301));
    let fine = Tolerances::scaled(1e-12, joints.scales()).unwrap();
    let fine = Solver::adaptive(AnyMethod::DormandPrince, fine);
    let fine = fine.solve(joints, span.clone(), start, output).unwrap();
    let run = ode::solve(joints, span, start, tolerance, output).unwrap();
    let worst = distance(&run, &fine, &joints.scales()) / tolerance;
    assert!(worst < 50.0, "{worst}");
}

/// Where a step passed over a kink of one joint, the others hid it from its estimates: samples were
/// off by 3 771, 2 100 and 1 580 tolerances. In the last scene by 100: it lies before a reversal,
/// up to which the step is cut, and the estimate of the shorter step was larger.
#[test]
fn a_kink_of_one_of_many_joints_is_seen() {
    assert_near::<_, 21, 7>(&Axes::<7>(Joints::drawn(&mut Draw(121))), 1e-9);
    assert_near::<_, 21, 7>(&Axes::<7>(Joints::drawn(&mut Draw(359))), 1e-9);
    assert_near::<_, 12, 4>(&Arm::<4>(Joints::drawn(&mut Draw(47))), 1e-9);
    assert_near::<_, 12, 4>(&Arm::<4>(Joints::drawn(&mut Draw(1158))), 1e-6);
}

/// α has kinks at the stick limit and at the stationary deflection. Before the model told of them,
/// samples were off by more than 300 tolerances. The product of the functions of all joints does
/// not tell of one: that of a joint which slides steadily has any sign.
#[test]
fn kinks_of_elasto_plastic_joints_are_met() {
    fn joints<const K: usize>(draw: &mut Draw) -> Joints<K, Yielding> {
        let stick_limit = 1e-3 * (0.2 + 0.7 * draw.next());
        Joints::drawn(draw).elasto_plastic(stick_limit)
    }
    assert_near::<_, 12, 4>(&Axes(joints(&mut Draw(238))), 1e-9);
    assert_near::<_, 21, 7>(&Axes(joints(&mut Draw(49))), 1e-9);
}

#[test]
fn hundreds_of_blocks_are_solved_to_the_tolerance_without_a_jacobian() {
    // Beyond 400 states. Steps a hundred times as tight as those of a solution have its digits.
    let (blocks, span, tolerance) = (Blocks(150), 0.0..1.0, 1e-4);
    let scales: Vec<f64> = (0..450).map(Blocks::scale).collect();
    let tight = dynamic::Tolerances::scaled(1e-9, scales.clone()).unwrap();
    let tight = dynamic::Solver::adaptive(AnyMethod::DormandPrince8, tight);
    let (start, output) = (vec![0.0; 450], Output::Uniform(5));
    let wanted = tight.solve(&blocks, span.clone(), start.clone(), output).unwrap();
    let found = ode::solve(&blocks, span, start, tolerance, output).unwrap();
    assert!(found.statistics().jacobians == 0 && found.statistics().reversals > 0);
    for (found, wanted) in found.states().iter().zip(wanted.states()) {
        for i in 0..450 {
            let error = (found[i] - wanted[i]).abs() / (scales[i] + wanted[i].abs());
            assert!(error < tolerance, "{i}: {error}");
        }
        // The drive has not come far: from the 100th block on all move as one on the belt alone.
        assert!(found[300..303] == found[447..450], "{found:?}");
    }
}

/// ẋ = 20 (x − sin t) + cos t of so many states: beside sin t errors grow as e^(20 t).
struct Unstable(usize);

impl dynamic::System<f64> for Unstable {
    fn states(&self) -> usize {
        self.0
    }

    fn contacts(&self) -> usize {
        0
    }

    fn rate(&self, time: f64, state: &[f64], _: &[Branch], rate: &mut [f64]) {
        for (rate, x) in rate.iter_mut().zip(state) {
            *rate = 20.0 * (x - time.sin()) + time.cos();
        }
    }

    fn sliding_velocities(&self, _: f64, _: &[f64], _: &mut [f64]) {}
}

#[test]
fn growth_of_errors_is_seen_with_a_jacobian_and_without() {
    for states in [3, 20, 401] {
        let run = |end| {
            let output = Output::Uniform(2);
            ode::solve(&Unstable(states), 0.0..end, vec![0.0; states], 1e-6, output)
        };
        // e²⁰ and e⁶⁰.
        let end = run(1.0).unwrap();
        assert!((end.states()[1][states - 1] - 1f64.sin()).abs() < 1e-6, "{states}");
        assert!(matches!(run(3.0).unwrap_err().reason, StopReason::ErrorsGrow { .. }), "{states}");
    }
}

#[test]
fn sizes_other_than_the_system_s_are_refused() {
    let solver = |states| {
        let tolerances = dynamic::Tolerances::scaled(1e-6, vec![1.0; states]).unwrap();
        dynamic::Solver::checked(AnyMethod::Automatic, tolerances)
    };
    let solve = |states, start| {
        let run = solver(states).solve(&Blocks(2), 0.0..1.0, vec![0.0; start], Output::Steps);
        run.map(|_| ()).map_err(|failure| failure.reason)
    };
    let refused = |states, start| solve(states, start).unwrap_err().to_string();
    assert_eq!(refused(6, 5), "there must be 6 values of initial_state, not 5");
    assert_eq!(refused(5, 6), "there must be 6 values of tolerances, not 5");
    assert_eq!(solve(6, 6), Ok(()));
}

/// Before anything of such a size is asked for: no capacity overflows.
#[test]
fn sizes_of_no_system_are_refused() {
    struct Sizes(usize, usize);
    impl dynamic::System<f64> for Sizes {
        fn states(&self) -> usize {
            self.0
        }
        fn contacts(&self) -> usize {
            self.1
        }
        fn rate(&self, _: f64, _: &[f64], _: &[Branch], rate: &mut [f64]) {
            rate.fill(0.0);
        }
        fn sliding_velocities(&self, _: f64, _: &[f64], _: &mut [f64]) {}
    }
    let refused = |states, contacts, start| {
        let (system, output) = (Sizes(states, contacts), Output::Uniform(2));
        let run = ode::solve(&system, 0.0..1.0, vec![0.0; start], 1e-6, output);
        run.unwrap_err().reason.to_string()
    };
    let text = refused(0, 0, 0);
    assert!(text.contains("of states there must be at least 1, not 0"), "{text}");
    let text = refused(usize::MAX, 0, 2);
    assert!(text.ends_with("values of initial_state, not 2"), "{text}");
    let text = refused(2, usize::MAX, 2);
    assert!(text.contains("contacts"), "{text}");
}
