//! A success is one: drawn scenes, every adaptive method, tolerances of 1e-3 … 1e-10, against
//! closed forms and against two methods that agree.
//!
//! The program is the ignored test, see there; `cargo test` runs a sample.
#![cfg(feature = "alloc")]

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::ode::{AnyMethod, Failure, Output, Solver, System, Tolerances, Trajectory};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::scene::{
    DiaphragmValve, MassSpringDamper, MassSpringDamperParameters, PrescribedVelocity,
};
use bristle::signal::{Polyline, Sine, SineParameters, Vertex};
use bristle::{Branch, Bristle, Contact, FrBd, LuGre, Mechanism, paper};
use bristle_specimens::draw::Draw;
use bristle_specimens::implicit::Set;
use bristle_specimens::joints::{Arm, Axes, Joints};
use bristle_specimens::ode::Field;
use bristle_specimens::specimens::table_2;
use nalgebra::{SVector, Vector1, Vector2};

use crate::blind_spots::METHODS;

/// Samples of a run.
const SAMPLES: usize = 201;

/// More steps than this and a run is refused, which is honest.
const MOST_STEPS: u64 = 400_000;

type Answer<const N: usize> = Result<Trajectory<f64, N>, Box<Failure<f64, N>>>;

fn run<S: System<f64, N, K>, const N: usize, const K: usize>(
    solver: fn(AnyMethod, Tolerances<f64, N>) -> Solver<f64, AnyMethod, N>,
    (method, tolerance): (AnyMethod, f64),
    (system, start, end): (&S, SVector<f64, N>, f64),
) -> Answer<N> {
    let tolerances = Tolerances::scaled(tolerance, system.scales()).unwrap();
    let solver = solver(method, tolerances).with_most_steps(MOST_STEPS);
    solver.solve(system, 0.0..end, start, Output::Uniform(SAMPLES))
}

/// The largest distance of two solutions in any state, over its scale or, if that is larger, the
/// largest value it has had so far: a relative tolerance is one of a part of the value.
pub(crate) fn distance<const N: usize>(
    a: &Trajectory<f64, N>,
    b: &Trajectory<f64, N>,
    scales: &SVector<f64, N>,
) -> f64 {
    let mut sizes = *scales;
    let pairs = a.states().iter().zip(b.states());
    pairs.fold(0.0, |most, (a, b)| {
        sizes = sizes.sup(&b.abs());
        f64::max(most, (a - b).component_div(&sizes).amax())
    })
}

/// Errors over the tolerance, the largest of any state at any sample, and refused runs.
#[derive(Default)]
struct Tally {
    errors: Vec<f64>,
    refused: usize,
    /// The number of the scene.
    number: usize,
    /// Answers beyond 1 000 tolerances.
    wrong: Vec<String>,
}

impl Tally {
    /// Every method at every tolerance on a scene, with a function for the error of an answer that
    /// is known but for a doubt.
    fn judge<S: System<f64, N, K>, const N: usize, const K: usize>(
        &mut self,
        (name, methods, tolerances): (&str, &[AnyMethod], &[f64]),
        scene: (&S, SVector<f64, N>, f64),
        (error, doubt): (impl Fn(&Trajectory<f64, N>) -> f64, f64),
    ) {
        for &tolerance in tolerances.iter().filter(|&&tolerance| tolerance >= 10.0 * doubt) {
            for &method in methods {
                match run(Solver::checked, (method, tolerance), scene) {
                    Ok(answer) => {
                        let error = error(&answer) / tolerance;
                        if !(error < 1e3) {
                            let answer = format!("{method:?} at {tolerance:e}: {error:.0}");
                            self.wrong.push(format!("{name} {}, {answer}", self.number));
                        }
                        self.errors.push(error);
                    }
                    Err(failure) => {
                        println!("{name}, {method:?} at {tolerance:e}: {failure}");
                        self.refused += 1;
                    }
                }
            }
        }
    }

    /// Against two methods that agree, if they do.
    fn compare<S: System<f64, N, K>, const N: usize, const K: usize>(
        &mut self,
        setting: (&str, &[AnyMethod], &[f64]),
        scene: (&S, SVector<f64, N>, f64),
        fine: impl FnOnce() -> [Answer<N>; 2],
    ) {
        if setting.2.is_empty() {
            return;
        }
        let [Ok(fine), Ok(other)] = fine() else { return };
        let scales = scene.0.scales();
        let doubt = distance(&fine, &other, &scales);
        self.judge(setting, scene, (|answer: &_| distance(answer, &fine, &scales), doubt));
    }

    /// The error that this part of the answers does not exceed.
    fn at(&self, part: f64) -> f64 {
        let last = self.errors.len().saturating_sub(1);
        let place = (self.errors.len() as f64 * part) as usize;
        self.errors.get(place.min(last)).copied().unwrap_or(0.0)
    }

    fn part_refused(&self) -> f64 {
        self.refused as f64 / (self.errors.len() + self.refused) as f64
    }

    /// A line of the table.
    fn print(&mut self, name: &str) {
        self.errors.sort_by(f64::total_cmp);
        println!(
            "| {name} | {} | {:.2} | {:.0} | {:.0} | {} | {:.1} % |",
            self.errors.len(),
            self.at(0.5),
            self.at(0.99),
            self.at(1.0),
            self.wrong.len(),
            100.0 * self.part_refused()
        );
    }

    /// The law: the median within a tolerance, 99 % within a hundred (of a small sample, 95 %),
    /// none beyond a thousand, and at most 2 % refused (of a small sample, 5 %).
    fn obeys(&self) {
        let count = self.errors.len();
        let (most, refused) =
            if count < 3000 { (self.at(0.95), 0.05) } else { (self.at(0.99), 0.02) };
        assert!(self.wrong.is_empty(), "{:#?}", self.wrong);
        assert!(self.at(0.5) < 1.0 && most < 100.0, "{} {most}", self.at(0.5));
        assert!(self.part_refused() <= refused, "{} refused", self.part_refused());
    }
}

/// Two fine runs of different methods.
fn fine<S: System<f64, N, K>, const N: usize, const K: usize>(
    scene: (&S, SVector<f64, N>, f64),
    explicit: AnyMethod,
) -> [Answer<N>; 2] {
    [
        run(Solver::adaptive, (explicit, 1e-13), scene),
        run(Solver::adaptive, (AnyMethod::Rodas5P, 1e-12), scene),
    ]
}

/// ẋ = λ(t) x (1 − x) with λ = a (t − t₀), or λ = a without t₀: x follows a logistic curve in ∫λ.
struct Logistic<const N: usize>([(f64, f64); N]);

impl<const N: usize> Logistic<N> {
    fn exact(&self, start: &SVector<f64, N>, time: f64) -> SVector<f64, N> {
        SVector::from_fn(|i, _| {
            let (rate, ramp) = self.0[i];
            let sum = if ramp > 0.0 { time * (0.5 * time - ramp) } else { time };
            1.0 / (1.0 + (1.0 / start[i] - 1.0) * (-rate * sum).exp())
        })
    }
}

impl<const N: usize> System<f64, N, 0> for Logistic<N> {
    fn rate(&self, time: f64, x: &SVector<f64, N>, _: [Branch; 0]) -> SVector<f64, N> {
        SVector::from_fn(|i, _| {
            let (rate, ramp) = self.0[i];
            let rate = if ramp > 0.0 { rate * (time - ramp) } else { rate };
            rate * x[i] * (1.0 - x[i])
        })
    }
    fn sliding_velocities(&self, _: f64, _: &SVector<f64, N>) -> [f64; 0] {
        []
    }
}

/// Starts between 1e-19 and 1e-3 of what they grow to, and modes that die out before they grow,
/// against closed forms.
fn seeds(draw: &mut Draw, tolerances: &[f64], tally: &mut Tally) {
    let rate = draw.logarithmic(0.1, 100.0);
    let starts = Vector2::from_fn(|_, _| draw.logarithmic(1e-19, 1e-3));
    let other = rate * draw.logarithmic(0.1, 10.0);
    let frequency = rate * draw.logarithmic(0.1, 10.0);
    let end = -starts[0].ln() / rate * (1.0 + 0.4 * draw.next());
    // ṙ = λ r (1 − r²), θ̇ = ω in the plane: r² grows as a logistic curve of rate 2λ.
    let hopf = Field(|_: f64, x: &Vector2<f64>| {
        x * (rate * (1.0 - x.norm_squared())) + Vector2::new(-x[1], x[0]) * frequency
    });
    // 1e10 starts, each to be followed over 40 powers of e, are more than order 4 can do.
    let least = |method| if method == AnyMethod::Rodas4 { 1e-8 } else { 1e-9 };
    for method in METHODS {
        let tolerances = tolerances.iter().copied().filter(|&t| t >= least(method));
        let (tolerances, methods) = (tolerances.collect::<Vec<_>>(), [method]);
        let two = Logistic([(rate, 0.0), (other, 0.0)]);
        let error = |answer: &Trajectory<f64, 2>| {
            answer
                .iter()
                .fold(0.0, |most, (time, x)| f64::max(most, (x - two.exact(&starts, time)).amax()))
        };
        tally.judge(("seeds", &methods, &tolerances), (&two, starts, end), (error, 0.0));
        let error = |answer: &Trajectory<f64, 2>| {
            let radius = Logistic([(2.0 * rate, 0.0)]);
            let from = Vector1::new(starts[0].powi(2));
            let (sin, cos) = (frequency * end).sin_cos();
            let exact = Vector2::new(cos, sin) * radius.exact(&from, end)[0].sqrt();
            (answer.last().unwrap().1 - exact).amax()
        };
        let scene = (&hopf, Vector2::new(starts[0], 0.0), end);
        tally.judge(("turning seed", &methods, &tolerances), scene, (error, 0.0));
        // Dies out by at most e⁻¹⁰, and grows again.
        let ramp = (20.0 / rate * draw.next()).sqrt();
        let (system, start) = (Logistic([(rate, ramp)]), Vector1::new(1e-3));
        let error = |answer: &Trajectory<f64, 1>| {
            answer.iter().fold(0.0, |most, (time, x)| {
                f64::max(most, (x - system.exact(&start, time)).amax())
            })
        };
        let scene = (&system, start, ramp * 2.0 + 12.0 / (rate * ramp));
        tally.judge(("ramp", &methods, &tolerances), scene, (error, 0.0));
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
    let whole = Field(|time: f64, x: &Vector2<f64>| {
        Vector2::new(x[1], floor.acceleration(time, x, (-x[0]).max(0.0)))
    });
    let (start, end) = (Vector2::new(0.5 + draw.next(), 0.0), 8.0);
    let fine = || fine((&Split(floor), start, end), AnyMethod::DormandPrince8);
    tally.compare(("floor", &METHODS, tolerances), (&whole, start, end), fine);
}

/// An implicit bristle under a sine, whose tip begins and ceases to slip without notice.
fn implicit_bristles(draw: &mut Draw, tolerances: &[f64], tally: &mut Tally) {
    let set = draw.one_of(&Set::all());
    let (mean, frequency) = (0.0055 * draw.next(), draw.logarithmic(1.0, 200.0));
    let velocity = SineParameters { mean, amplitude: 0.01, frequency, phase: 0.0 };
    let contact = set.model().under_load(1.0).unwrap();
    let scene = PrescribedVelocity::new(contact, Sine::new(velocity).unwrap());
    let (start, end) = (Vector1::new(0.0), 4.0 / frequency);
    let fine = [(AnyMethod::DormandPrince8, 1e-13), (AnyMethod::Rodas5P, 1e-12)];
    let one = |(method, tolerance)| {
        let tolerances = Tolerances::scaled(tolerance, scene.scales()).unwrap();
        let solver = Solver::adaptive(method, tolerances).with_largest_step(end / 1e4).unwrap();
        solver.solve(&scene, 0.0..end, start, Output::Uniform(SAMPLES))
    };
    let fine = || fine.map(one);
    tally.compare(("implicit", &METHODS, tolerances), (&scene, start, end), fine);
}

/// A curve and a bristle, under a load \[N\] and for a mass \[kg\].
fn friction(
    draw: &mut Draw,
    load: f64,
    mass: f64,
) -> (StribeckParameters<f64>, KelvinVoigtParameters<f64>) {
    let dynamic_coefficient = draw.logarithmic(0.05, 1.5);
    let curve = StribeckParameters {
        static_coefficient: dynamic_coefficient * (1.05 + draw.next()),
        dynamic_coefficient,
        stribeck_velocity: draw.logarithmic(1e-3, 0.1),
        stribeck_exponent: draw.one_of(&[1.0, 2.0]),
        viscous_friction: dynamic_coefficient * draw.logarithmic(0.01, 1.0),
    };
    let micro_stiffness = draw.logarithmic(1e3, 1e6);
    let damping = 2.0 * draw.logarithmic(0.05, 1.0);
    let micro_damping = damping * (mass * micro_stiffness / load).sqrt();
    (curve, KelvinVoigtParameters { micro_stiffness, micro_damping })
}

/// Stick-slip of a mass on a spring, pre-sliding under a force, and lag at a given velocity.
fn rigs(draw: &mut Draw, tolerances: &[f64], tally: &mut Tally) {
    let (load, mass) = (draw.logarithmic(1.0, 30.0), draw.logarithmic(0.1, 10.0));
    let (curve, bristle) = friction(draw, load, mass);
    let is_frbd = draw.next() < 0.5;
    let spring_stiffness = draw.logarithmic(1e-4, 0.02) * load * bristle.micro_stiffness;
    let (drive_velocity, swing) = (draw.logarithmic(1e-3, 0.2), (mass / spring_stiffness).sqrt());
    let mechanism = Mechanism { mass, spring_stiffness, viscous_damping: 0.0 };
    // Until the first slip, and a few cycles more.
    let breakaway = load * curve.static_coefficient;
    let end = 2.0 * breakaway / spring_stiffness / drive_velocity + 25.0 * swing;
    let drawn = (mechanism, drive_velocity, end, load * bristle.micro_stiffness, breakaway);
    let (curve, bristle) = (Stribeck::new(curve).unwrap(), KelvinVoigt::new(bristle).unwrap());
    if is_frbd {
        rig(draw, FrBd::new(curve, bristle).under_load(load).unwrap(), drawn, tolerances, tally);
    } else {
        let friction = LuGre::classical(curve, bristle);
        rig(draw, friction.under_load(load).unwrap(), drawn, tolerances, tally);
    }
}

fn rig<M: Bristle<f64, Deflection = f64> + Copy>(
    draw: &mut Draw,
    contact: Contact<f64, M>,
    (mechanism, drive_velocity, end, stiffness, breakaway): (Mechanism<f64>, f64, f64, f64, f64),
    tolerances: &[f64],
    tally: &mut Tally,
) {
    let setting = |name| (name, &METHODS[..], tolerances);
    let pulled = MassSpringDamperParameters { contact, mechanism, drive_velocity, force: 0.0 };
    let pulled = MassSpringDamper::new(pulled).unwrap();
    let scene = (&pulled, pulled.at_rest(), end);
    tally.compare(setting("stick-slip"), scene, || fine(scene, AnyMethod::DormandPrince8));

    let frequency = draw.logarithmic(1e-3, 0.3) * (stiffness / mechanism.mass).sqrt() / 6.0;
    let amplitude = (0.3 + 0.65 * draw.next()) * breakaway;
    let force = SineParameters { mean: 0.0, amplitude, frequency, phase: 0.0 };
    let held = MassSpringDamperParameters {
        contact,
        mechanism: Mechanism { spring_stiffness: 0.0, ..mechanism },
        drive_velocity: 0.0,
        force: Sine::new(force).unwrap(),
    };
    let held = MassSpringDamper::new(held).unwrap();
    let scene = (&held, held.at_rest(), 3.0 / frequency);
    tally.compare(setting("pre-sliding"), scene, || fine(scene, AnyMethod::DormandPrince8));

    let frequency = draw.logarithmic(1.0, 100.0);
    let velocity = SineParameters { mean: 0.0055, amplitude: 0.01, frequency, phase: 0.0 };
    let dragged = PrescribedVelocity::new(contact, Sine::new(velocity).unwrap());
    let scene = (&dragged, Vector1::new(0.0), 4.0 / frequency);
    tally.compare(setting("lag"), scene, || fine(scene, AnyMethod::DormandPrince8));
}

fn valves(draw: &mut Draw, tolerances: &[f64], tally: &mut Tally) {
    valve(|| draw.logarithmic(0.4, 2.5), 15.0, tolerances, tally);
}

/// The paper's valve under a ramp, its friction multiplied by some factors. Explicit methods need
/// millions of steps.
fn valve(mut factor: impl FnMut() -> f64, end: f64, tolerances: &[f64], tally: &mut Tally) {
    let (mut curve, mut bristle) = (paper::VALVE_CURVE, paper::VALVE_BRISTLE);
    let friction = factor();
    curve.static_coefficient *= friction;
    curve.dynamic_coefficient *= friction;
    curve.stribeck_velocity *= factor();
    bristle.micro_stiffness *= factor();
    bristle.micro_damping *= factor();
    let friction = FrBd::new(Stribeck::new(curve).unwrap(), KelvinVoigt::new(bristle).unwrap());
    let contact = friction.under_load(1.0).unwrap();
    let ramp = [Vertex { time: 0.0, value: 0.0 }, Vertex { time: 20.0, value: 40.0 * factor() }];
    let valve = paper::valve(contact, 0.4 * factor(), Polyline::new(ramp).unwrap());
    let valve = DiaphragmValve::new(valve).unwrap();
    let methods = [AnyMethod::Automatic, AnyMethod::Rodas4, AnyMethod::Rodas5P];
    let scene = (&valve, valve.balanced(0.0), end);
    tally.compare(("valve", &methods, tolerances), scene, || fine(scene, AnyMethod::Automatic));
}

/// Joints in a row, coupled by springs, each with a position control whose torque has a limit that
/// nobody declares: K contacts, N = 3 K states (position, velocity, deflection).
struct Limited<const N: usize, const K: usize> {
    contact: Contact<f64, FrBd<Stribeck<f64>, KelvinVoigt<f64>>>,
    inertia: f64,
    gains: [f64; 2],
    limit: f64,
    coupling: f64,
    /// Of the reference 0.5 sin ωt of each \[rad/s\].
    angular: [f64; K],
}

impl<const N: usize, const K: usize> System<f64, N, K> for Limited<N, K> {
    fn rate(&self, time: f64, x: &SVector<f64, N>, branches: [Branch; K]) -> SVector<f64, N> {
        let mut rate = SVector::zeros();
        for i in 0..K {
            let [q, v, z] = [0, 1, 2].map(|k| x[3 * i + k]);
            let friction = self.contact.response(branches[i].of(v), z);
            let [gain, damping] = self.gains;
            let reference = 0.5 * (self.angular[i] * time).sin();
            let motor = (gain * (reference - q) - damping * v).clamp(-self.limit, self.limit);
            let mut torque = motor - friction.force;
            if i > 0 {
                torque += self.coupling * (x[3 * i - 3] - q);
            }
            if i + 1 < K {
                torque += self.coupling * (x[3 * i + 3] - q);
            }
            rate[3 * i] = v;
            rate[3 * i + 1] = torque / self.inertia;
            rate[3 * i + 2] = friction.rate;
        }
        rate
    }
    fn sliding_velocities(&self, _: f64, x: &SVector<f64, N>) -> [f64; K] {
        std::array::from_fn(|i| x[3 * i + 1])
    }
    fn longest_step(&self) -> Option<f64> {
        let fastest = self.angular.into_iter().fold(0.0, f64::max);
        Some(std::f64::consts::PI / fastest)
    }
    fn scales(&self) -> SVector<f64, N> {
        let deflection = self.contact.limits(0.0).deflection.unwrap();
        SVector::from_fn(|i, _| [1.0, 1.0, deflection][i % 3])
    }
}

fn joints<const N: usize, const K: usize>(draw: &mut Draw, tolerances: &[f64], tally: &mut Tally) {
    let (load, inertia) = (draw.logarithmic(0.3, 3.0), draw.logarithmic(0.05, 1.0));
    let (curve, bristle) = friction(draw, load, inertia);
    let breakaway = load * curve.static_coefficient;
    let friction = FrBd::new(Stribeck::new(curve).unwrap(), KelvinVoigt::new(bristle).unwrap());
    let contact = friction.under_load(load).unwrap();
    let gain = draw.logarithmic(20.0, 500.0);
    let damping = 2.0 * draw.logarithmic(0.2, 1.5) * (gain * inertia).sqrt();
    let joints = Limited::<N, K> {
        limit: breakaway * draw.logarithmic(0.8, 5.0),
        contact,
        inertia,
        gains: [gain, damping],
        coupling: draw.logarithmic(0.1, 10.0),
        angular: [(); K].map(|()| draw.logarithmic(1.0, 10.0)),
    };
    let scene = (&joints, SVector::zeros(), 2.0);
    let fine = || fine(scene, AnyMethod::DormandPrince8);
    tally.compare((&format!("{K} joints"), &METHODS, tolerances), scene, fine);
}

/// Joints that follow sines, with springs between them.
fn axes<const N: usize, const K: usize>(draw: &mut Draw, tolerances: &[f64], tally: &mut Tally) {
    let axes = Axes::<K>(Joints::drawn(draw));
    let scene = (&axes, SVector::<f64, N>::zeros(), 3.0);
    let fine = || fine::<_, N, K>(scene, AnyMethod::DormandPrince8);
    tally.compare::<_, N, K>((&format!("axes, {K} joints"), &METHODS, tolerances), scene, fine);
}

/// Such joints in a row, under gravity.
fn arm<const N: usize, const K: usize>(draw: &mut Draw, tolerances: &[f64], tally: &mut Tally) {
    let arm = Arm::<K>(Joints::drawn(draw));
    let scene = (&arm, SVector::<f64, N>::zeros(), 3.0);
    let fine = || fine::<_, N, K>(scene, AnyMethod::DormandPrince8);
    tally.compare::<_, N, K>((&format!("arm, {K} joints"), &METHODS, tolerances), scene, fine);
}

/// Axes with elasto-plastic friction.
fn yielding<const N: usize, const K: usize>(draw: &mut Draw, tols: &[f64], tally: &mut Tally) {
    let stick_limit = 1e-3 * (0.2 + 0.7 * draw.next());
    let axes = Axes(Joints::<K>::drawn(draw).elasto_plastic(stick_limit));
    let scene = (&axes, SVector::<f64, N>::zeros(), 3.0);
    let fine = || fine::<_, N, K>(scene, AnyMethod::DormandPrince8);
    tally.compare::<_, N, K>((&format!("yielding, {K} joints"), &METHODS, tols), scene, fine);
}

/// Draws a scene of a kind.
type Kind = fn(&mut Draw, &[f64], &mut Tally);

/// Every kind, with the number of scenes that one call draws.
const KINDS: [(&str, Kind, usize); 8] = [
    ("seeds and ramps", seeds, 3),
    ("floors", floors, 1),
    ("implicit bristles", implicit_bristles, 1),
    ("rigs", rigs, 3),
    ("valves", valves, 1),
    ("1 joint", joints::<3, 1>, 1),
    ("2 joints", joints::<6, 2>, 1),
    ("4 joints", joints::<12, 4>, 1),
];

/// Kinds of many joints, drawn by themselves.
const OF_MANY_JOINTS: [(&str, Kind, usize); 3] = [
    ("axes, 7 joints", axes::<21, 7>, 1),
    ("arm, 4 joints", arm::<12, 4>, 1),
    ("axes, elasto-plastic", yielding::<12, 4>, 1),
];

/// The law on so many scenes, or on the one of each kind with the number `BRISTLE_SCENE`.
fn law(kinds: &[(&str, Kind, usize)], seed: u64, scenes: usize, tolerances: &[f64]) {
    let only = std::env::var("BRISTLE_SCENE").ok().and_then(|number| number.parse().ok());
    println!("| | answers | median | 99 % | largest | beyond 1 000 | refused |");
    println!("|---|---|---|---|---|---|---|");
    let mut all = Tally::default();
    for &(name, draws, of_one) in kinds {
        let (mut draw, mut tally) = (Draw::seeded(seed), Tally::default());
        for number in 0..scenes.div_ceil(of_one * kinds.len()) {
            let is_left_out = only.is_some_and(|only: usize| only != number);
            tally.number = number;
            draws(&mut draw, if is_left_out { &[] } else { tolerances }, &mut tally);
        }
        tally.print(name);
        all.refused += tally.refused;
        all.errors.append(&mut tally.errors);
        all.wrong.append(&mut tally.wrong);
    }
    all.print("all");
    all.obeys();
}

#[test]
fn a_success_is_one_on_a_few_drawn_scenes() {
    law(&KINDS, 3, KINDS.len(), &[1e-4, 1e-7, 1e-10]);
}

#[test]
fn an_answer_of_any_method_is_near_on_the_scenes_of_the_paper() {
    // Dormand–Prince at 1e-6 was 28 876 tolerances off here, and a Rosenbrock method at 1e-3 lost
    // the solution.
    let (mut draw, mut tally, tolerances) = (Draw(1), Tally::default(), [1e-3, 1e-6]);
    let (curve, bristle) = table_2();
    let mechanism = Mechanism { mass: 1.0, spring_stiffness: 2.0, viscous_damping: 0.0 };
    let paper = (mechanism, 0.1, 15.0, 1e4, 1.5);
    let contact = FrBd::new(curve, bristle).under_load(1.0).unwrap();
    rig(&mut draw, contact, paper, &tolerances, &mut tally);
    let contact = LuGre::classical(curve, bristle).under_load(1.0).unwrap();
    rig(&mut draw, contact, paper, &tolerances, &mut tally);
    valve(|| 1.0, 1.5, &tolerances, &mut tally);
    tally.print("paper");
    // Five methods on three scenes of two models, three on the valve, at two tolerances each.
    assert!(tally.errors.len() >= 60 && tally.at(1.0) < 100.0, "{:?}", tally.errors);
}

#[test]
fn what_drawn_scenes_have_shown_is_seen() {
    let scenes: [(Kind, u64, usize, f64); 12] = [
        // Dormand–Prince was 2 101, 1 518 and 1 519 tolerances off: a torque goes from one limit to
        // the other within a step.
        (joints::<3, 1>, 1, 61, 1e-5),
        (joints::<3, 1>, 1, 72, 1e-5),
        (joints::<3, 1>, 3, 24, 1e-5),
        // It and the default were 9 142 off: the mass touches the floor between two stages.
        (floors, 1, 50, 1e-4),
        // The default was 1 885 off: a tip that begins to slip.
        (implicit_bristles, 1, 18, 1e-10),
        // The default and order 8 were 62 709 off: a tip that slips between two stages.
        (implicit_bristles, 7, 323, 1e-9),
        // The default was 2 655 off: a tip ceases to slip where the estimate is zero by chance.
        (implicit_bristles, 8, 154, 1e-10),
        // Rodas4 was 3 857 off: a step with hλ = 3, beside whose estimate the error was large.
        (seeds, 7, 99, 1e-5),
        // It was 1 129 off: a step from decay to growth, where its estimate was zero by chance.
        (seeds, 20, 61, 1e-5),
        // Order 8 was 63 854 off: a step cut at a reversal passed over the peak of the curve there.
        (rigs, 2, 32, 1e-7),
        // The default was 6 140 off: the mass leaves the floor for less than a step, between two
        // stages, and is back.
        (floors, 14, 322, 5e-8),
        // Rodas5P was 16 923 off: a step from just above the floor to beyond the bounce.
        (floors, 20, 169, 1e-4),
    ];
    for (kind, seed, number, tolerance) in scenes {
        let (mut draw, mut tally) = (Draw(seed), Tally::default());
        for earlier in 0..=number {
            let judged = usize::from(earlier == number);
            kind(&mut draw, &[tolerance][..judged], &mut tally);
        }
        tally.errors.sort_by(f64::total_cmp);
        let is_known = tally.refused == 0 && tally.errors.len() % METHODS.len() == 0;
        let most = tally.errors.last().copied().unwrap_or(f64::NAN);
        assert!(is_known && most < 100.0, "{seed} {number}: {:?}", tally.errors);
    }
}

const TOLERANCES: [f64; 8] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10];

/// How many scenes the environment asks for.
fn scenes(default: usize) -> usize {
    std::env::var("BRISTLE_SCENES").ok().and_then(|scenes| scenes.parse().ok()).unwrap_or(default)
}

#[test]
#[ignore = "hours in release; BRISTLE_SEED, BRISTLE_SCENES (of 3000), one of them: BRISTLE_SCENE"]
fn a_success_is_one_on_drawn_scenes() {
    law(&KINDS, 1, scenes(3000), &TOLERANCES);
}

#[test]
#[ignore = "minutes in release; BRISTLE_SEED, BRISTLE_SCENES (of 200), one of them: BRISTLE_SCENE"]
fn a_success_is_one_on_drawn_mechanisms() {
    law(&OF_MANY_JOINTS, 1, scenes(200), &TOLERANCES);
}
