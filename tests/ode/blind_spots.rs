//! Where an error estimate sees nothing: growth from far below the tolerance, kinks that nobody
//! declares, derivatives that are wrong, contacts that reverse together. A success is one there,
//! too.
#![cfg(feature = "alloc")]

use bristle::ode::{
    self, AnyMethod, Failure, Output, Solver, StopReason, System, Tolerances, Trajectory,
};
use bristle::scene::PrescribedVelocity;
use bristle::signal::{Sine, SineParameters};
use bristle::{Branch, Bristle};
use bristle_specimens::draw::Draw;
use bristle_specimens::implicit::Set;
use nalgebra::{Matrix1, SVector, Vector1, Vector2, Vector3};

const METHODS: [AnyMethod; 5] = [
    AnyMethod::Automatic,
    AnyMethod::DormandPrince,
    AnyMethod::DormandPrince8,
    AnyMethod::Rodas4,
    AnyMethod::Rodas5P,
];

/// More steps than this and a run is refused, which is honest.
const MOST_STEPS: u64 = 400_000;

/// Errors over the tolerance, largest of any state at any sample, and refused runs.
struct Tally {
    /// What no error over the tolerance exceeds.
    most: f64,
    errors: Vec<f64>,
    refused: usize,
}

impl Tally {
    fn within(most: f64) -> Self {
        Self { most, errors: Vec::new(), refused: 0 }
    }

    /// Takes an answer whose largest error is found by a function.
    fn take<const N: usize>(
        &mut self,
        (name, method, tolerance): (&str, AnyMethod, f64),
        answer: Result<Trajectory<f64, N>, Box<Failure<f64, N>>>,
        error: impl Fn(&Trajectory<f64, N>) -> f64,
    ) {
        match answer {
            Ok(answer) => {
                let error = error(&answer) / tolerance;
                assert!(error < self.most, "{name}, {method:?} at {tolerance:e}: {error:e}");
                self.errors.push(error);
            }
            Err(_) => self.refused += 1,
        }
    }

    /// The law, beside the largest error: 99 % within a fifth of that, the median within a few
    /// tolerances, and few runs refused.
    fn obeys(mut self, median: f64, refused: f64) {
        self.errors.sort_by(f64::total_cmp);
        let count = self.errors.len();
        let at = |part: usize| self.errors.get(count * part / 100);
        let (half, most, last) = (at(50), at(99), self.errors.last());
        println!("{count} answers: {half:.1?}, {most:.0?}, {last:.0?}; {} refused", self.refused);
        assert!(count > 0 && self.errors[count / 2] < median, "median {}", self.errors[count / 2]);
        // One in a hundred of a small sample is its largest.
        let most =
            if count < 500 { self.errors[count * 9 / 10] } else { self.errors[count * 99 / 100] };
        assert!(most < 0.2 * self.most, "99 %, or 90 % of a small sample: {most}");
        let part = self.refused as f64 / (count + self.refused) as f64;
        assert!(part <= refused, "{part} refused");
    }
}

fn run<S: System<f64, N, K>, const N: usize, const K: usize>(
    solver: fn(AnyMethod, Tolerances<f64, N>) -> Solver<f64, AnyMethod, N>,
    (method, tolerance): (AnyMethod, f64),
    (system, start, end): (&S, SVector<f64, N>, f64),
    samples: usize,
) -> Result<Trajectory<f64, N>, Box<Failure<f64, N>>> {
    let tolerances = Tolerances::scaled(tolerance, system.scales()).unwrap();
    let solver = solver(method, tolerances).with_most_steps(MOST_STEPS);
    solver.solve(system, 0.0..end, start, Output::Uniform(samples))
}

fn distance<const N: usize>(
    (a, b): (&Trajectory<f64, N>, &Trajectory<f64, N>),
    scales: &SVector<f64, N>,
) -> f64 {
    let pairs = a.states().iter().zip(b.states());
    pairs.fold(0.0, |most, (a, b)| f64::max(most, (a - b).component_div(scales).amax()))
}

/// ẋ = λ x (1 − x): x grows as e^λt from x0, up to 1.
fn logistic(rate: f64, x0: f64, time: f64) -> f64 {
    1.0 / (1.0 + (1.0 / x0 - 1.0) * (-rate * time).exp())
}

/// As many of these as there are states, each with a rate of its own.
struct Logistic<const N: usize>([f64; N]);

impl<const N: usize> System<f64, N, 0> for Logistic<N> {
    fn rate(&self, _: f64, x: &SVector<f64, N>, _: [Branch; 0]) -> SVector<f64, N> {
        SVector::from_fn(|i, _| self.0[i] * x[i] * (1.0 - x[i]))
    }
    fn sliding_velocities(&self, _: f64, _: &SVector<f64, N>) -> [f64; 0] {
        []
    }
}

/// ṙ = λ r (1 − r²), θ̇ = ω in the plane: r² grows as a logistic curve of rate 2λ.
struct Hopf {
    rate: f64,
    frequency: f64,
}

impl System<f64, 2, 0> for Hopf {
    fn rate(&self, _: f64, x: &Vector2<f64>, _: [Branch; 0]) -> Vector2<f64> {
        let outward = self.rate * (1.0 - x.norm_squared());
        x * outward + Vector2::new(-x[1], x[0]) * self.frequency
    }
    fn sliding_velocities(&self, _: f64, _: &Vector2<f64>) -> [f64; 0] {
        []
    }
}

/// Starts between 1e-19 and 1e-3 of what they grow to, against closed forms.
fn seeds(draw: &mut Draw, tolerances: &[f64], tally: &mut Tally) {
    let rate = draw.logarithmic(0.1, 100.0);
    let starts = [(); 2].map(|()| draw.logarithmic(1e-19, 1e-3));
    let rates = [rate, rate * draw.logarithmic(0.1, 10.0)];
    let frequency = rate * draw.logarithmic(0.1, 10.0);
    let end = -starts[0].ln() / rate * (1.0 + 0.4 * draw.next());
    for (&tolerance, method) in tolerances.iter().flat_map(|t| METHODS.map(|method| (t, method))) {
        // 1e10 starts, each to be followed over 40 powers of e, are more than order 4 can do.
        if method == AnyMethod::Rodas4 && tolerance < 1e-8 {
            continue;
        }
        let setting = (method, tolerance);
        let one = (&Logistic([rate]), Vector1::new(starts[0]), end);
        let answer = run(Solver::checked, setting, one, 2);
        tally.take(("one", method, tolerance), answer, |answer| {
            (answer.states()[1][0] - logistic(rate, starts[0], end)).abs()
        });
        let two = (&Logistic(rates), Vector2::from(starts), end);
        let answer = run(Solver::checked, setting, two, 2);
        tally.take(("two", method, tolerance), answer, |answer| {
            let error = |i: usize| answer.states()[1][i] - logistic(rates[i], starts[i], end);
            f64::max(error(0).abs(), error(1).abs())
        });
        let turning = (&Hopf { rate, frequency }, Vector2::new(starts[0], 0.0), end);
        let answer = run(Solver::checked, setting, turning, 2);
        tally.take(("turning", method, tolerance), answer, |answer| {
            let radius = logistic(2.0 * rate, starts[0].powi(2), end).sqrt();
            let (sin, cos) = (frequency * end).sin_cos();
            (answer.states()[1] - Vector2::new(cos, sin) * radius).amax()
        });
    }
}

/// A mass over a spring that pushes only: the kink is in the right-hand side, as the documentation
/// of `sliding_velocities` advises.
#[derive(Clone, Copy)]
struct Floor {
    stiffness: f64,
    damping: f64,
    force: f64,
    frequency: f64,
}

impl Floor {
    fn acceleration(&self, time: f64, x: &Vector2<f64>, depth: f64) -> f64 {
        let Self { stiffness, damping, force, frequency } = self;
        stiffness * depth - damping * x[1] - 1.0 + force * (frequency * time).sin()
    }
}

impl System<f64, 2, 0> for Floor {
    fn rate(&self, time: f64, x: &Vector2<f64>, _: [Branch; 0]) -> Vector2<f64> {
        Vector2::new(x[1], self.acceleration(time, x, (-x[0]).max(0.0)))
    }
    fn sliding_velocities(&self, _: f64, _: &Vector2<f64>) -> [f64; 0] {
        []
    }
}

/// The same, with the height as a quantity that changes its sign: steps are split at the kink.
struct Split(Floor);

impl System<f64, 2> for Split {
    fn rate(&self, time: f64, x: &Vector2<f64>, [branch]: [Branch; 1]) -> Vector2<f64> {
        let depth = match branch {
            Branch::Forward => 0.0,
            Branch::Backward => -x[0],
            Branch::Free => (-x[0]).max(0.0),
        };
        Vector2::new(x[1], self.0.acceleration(time, x, depth))
    }
    fn sliding_velocities(&self, _: f64, x: &Vector2<f64>) -> [f64; 1] {
        [x[0]]
    }
    fn longest_step(&self) -> Option<f64> {
        Some(0.05 / self.0.stiffness.sqrt())
    }
}

/// Against two methods on the split system that agree.
fn floors(draw: &mut Draw, tolerances: &[f64], tally: &mut Tally) {
    let floor = Floor {
        stiffness: draw.logarithmic(10.0, 1e4),
        damping: draw.logarithmic(0.01, 0.3),
        force: 3.0 * draw.next(),
        frequency: draw.logarithmic(0.5, 20.0),
    };
    let (start, end) = (Vector2::new(0.5 + draw.next(), 0.0), 8.0);
    let split = (&Split(floor), start, end);
    let fine = run(Solver::adaptive, (AnyMethod::DormandPrince8, 1e-13), split, 201);
    let other = run(Solver::adaptive, (AnyMethod::Rodas5P, 1e-12), split, 201);
    let (fine, other) = (fine.unwrap(), other.unwrap());
    let scales = Vector2::repeat(1.0);
    // A floor that is left and met many times may be chaotic.
    if distance((&fine, &other), &scales) > 1e-10 {
        return;
    }
    for (&tolerance, method) in tolerances.iter().flat_map(|t| METHODS.map(|method| (t, method))) {
        let answer = run(Solver::checked, (method, tolerance), (&floor, start, end), 201);
        tally.take(("floor", method, tolerance), answer, |answer| {
            distance((answer, &fine), &scales)
        });
    }
}

/// An implicit bristle under a sine, whose tip begins and ceases to slip without notice.
fn implicit_bristles(draw: &mut Draw, tolerances: &[f64], tally: &mut Tally) {
    let set = draw.one_of(&Set::all());
    let (mean, frequency) = (0.0055 * draw.next(), draw.logarithmic(1.0, 200.0));
    let velocity = SineParameters { mean, amplitude: 0.01, frequency, phase: 0.0 };
    let contact = set.model().under_load(1.0).unwrap();
    let scene = PrescribedVelocity::new(contact, Sine::new(velocity).unwrap());
    let (start, end, scales) = (Vector1::new(0.0), 4.0 / frequency, scene.scales());
    let fine = |method, tolerance| {
        let tolerances = Tolerances::scaled(tolerance, scales).unwrap();
        let solver = Solver::adaptive(method, tolerances);
        let solver = solver.with_largest_step(end / 2e4).unwrap();
        solver.solve(&scene, 0.0..end, start, Output::Uniform(201)).unwrap()
    };
    let (fine, other) = (fine(AnyMethod::DormandPrince8, 1e-13), fine(AnyMethod::Rodas5P, 1e-12));
    assert!(distance((&fine, &other), &scales) < 1e-9);
    for (&tolerance, method) in tolerances.iter().flat_map(|t| METHODS.map(|method| (t, method))) {
        let answer = run(Solver::checked, (method, tolerance), (&scene, start, end), 201);
        tally.take(("implicit", method, tolerance), answer, |answer| {
            distance((answer, &fine), &scales)
        });
    }
}

#[test]
fn growth_from_far_below_the_tolerance_is_followed() {
    let (mut draw, mut tally) = (Draw::seeded(7), Tally::within(1e3));
    for _ in 0..6 {
        seeds(&mut draw, &[1e-3, 1e-5, 1e-7], &mut tally);
    }
    tally.obeys(1.0, 0.1);
}

#[test]
fn a_floor_that_nobody_declares_is_met_within_the_tolerance() {
    let (mut draw, mut tally) = (Draw::seeded(11), Tally::within(1e3));
    for _ in 0..3 {
        floors(&mut draw, &[1e-4, 1e-8], &mut tally);
    }
    tally.obeys(10.0, 0.02);
}

#[test]
fn the_tip_of_an_implicit_bristle_slips_within_the_tolerance() {
    let (mut draw, mut tally) = (Draw::seeded(5), Tally::within(1e3));
    implicit_bristles(&mut draw, &[1e-4, 1e-8], &mut tally);
    tally.obeys(10.0, 0.02);
}

#[test]
#[ignore = "minutes in release; other scenes with each BRISTLE_SEED"]
fn a_success_is_one_on_drawn_blind_spots() {
    let mut draw = Draw::seeded(1);
    let tolerances = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10];
    // Every estimate may vanish by chance in the very step that crosses a kink: about one answer in
    // three thousand is beyond 1 000 tolerances.
    let [mut grown, mut met, mut slipped] = [1e3, 1e4, 1e4].map(Tally::within);
    for _ in 0..40 {
        seeds(&mut draw, &tolerances[..6], &mut grown);
        floors(&mut draw, &tolerances, &mut met);
        implicit_bristles(&mut draw, &tolerances, &mut slipped);
    }
    grown.obeys(1.0, 0.1);
    met.obeys(10.0, 0.1);
    slipped.obeys(10.0, 0.02);
}

/// ẋ = 1 − x, with derivatives that are a factor off.
struct Relaxing(f64);

impl System<f64, 1, 0> for Relaxing {
    fn rate(&self, _: f64, x: &Vector1<f64>, _: [Branch; 0]) -> Vector1<f64> {
        Vector1::new(1.0 - x[0])
    }
    fn sliding_velocities(&self, _: f64, _: &Vector1<f64>) -> [f64; 0] {
        []
    }
    fn linearised(
        &self,
        time: f64,
        x: &Vector1<f64>,
        branches: [Branch; 0],
    ) -> Option<ode::Linearisation<f64, 1>> {
        let rate = self.rate(time, x, branches);
        let (by_state, by_time) = (Matrix1::new(-self.0), Vector1::zeros());
        Some(ode::Linearisation { rate, by_state, by_time })
    }
}

#[test]
fn wrong_derivatives_are_refused_by_name() {
    let solve = |factor: f64| {
        let relaxing = Relaxing(factor);
        ode::solve(&relaxing, 0.0..20.0, Vector1::new(0.0), 1e-6, Output::Uniform(2))
    };
    for factor in [1e5, 0.0, -1.0, 3.0] {
        let failure = solve(factor).unwrap_err();
        assert_eq!(failure.reason, StopReason::WrongDerivative { component: 0 });
        assert!(failure.to_string().contains("see linearised"), "{failure}");
    }
    assert!((solve(1.0).unwrap().states()[1][0] - 1.0).abs() < 1e-6);
}

/// Three masses without a coupling, braked by equal forces: their velocities pass zero together.
struct Together;

impl System<f64, 3, 3> for Together {
    fn rate(&self, time: f64, _: &Vector3<f64>, _: [Branch; 3]) -> Vector3<f64> {
        Vector3::repeat(time.cos())
    }
    fn sliding_velocities(&self, _: f64, x: &Vector3<f64>) -> [f64; 3] {
        [x[0], x[1], x[2]]
    }
}

#[test]
fn contacts_that_reverse_together_are_all_counted() {
    // v = sin t passes zero at π, 2π … 10π.
    for method in METHODS {
        let solver =
            Solver::checked(method, Tolerances::scaled(1e-6, Vector3::repeat(1.0)).unwrap());
        let run = solver.solve(&Together, 0.0..32.0, Vector3::zeros(), Output::Uniform(2)).unwrap();
        assert_eq!(run.reversals().len(), 30, "{method:?}");
        assert_eq!(run.statistics().reversals, 30, "{method:?}");
        for (number, reversal) in run.reversals().iter().enumerate() {
            let passes = std::f64::consts::PI * (number / 3 + 1) as f64;
            assert!((reversal.time - passes).abs() < 1e-4, "{method:?}: {}", reversal.time);
        }
    }
}
