//! An arm on a gear in a loop of 1 kHz: simulated, compensated in one of several ways.

use bristle::companion::{PointMass, VelocityHistory};
use bristle::control::{FeedForwardCompensator, FeedForwardParameters, OutputParameters};
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, ElastoPlastic, FrBd, ParameterError};
use bristle_adaptation::{AdaptiveFriction, AdaptiveFrictionParameters, FrictionEstimate, Sample};

/// Sample time [s].
const SAMPLE: f64 = 1e-3;
/// Samples until a torque acts.
const DELAY: usize = 4;
/// Standard deviation of the torque that acts [N m], about the one that was asked for.
const RIPPLE: f64 = 0.05;
/// Inertia [kg m²].
const INERTIA: f64 = 0.05;
/// Fastest speed [rad/s].
const FASTEST: f64 = 20.0;
/// 14 bits of a turn [rad].
const COUNT: f64 = core::f64::consts::TAU / 16384.0;

/// Friction that the controller is given at the beginning: of the gear's load, μ = 0.1.
pub(crate) const NOMINAL: FrictionEstimate<f64> =
    FrictionEstimate { idle_load: 3.0, load_share: 1.0, drag: 0.05, offset: 0.1 };

pub(crate) type Friction = FrBd<Stribeck<f64>, KelvinVoigt<f64>>;

/// The real friction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Truth {
    pub(crate) friction: FrictionEstimate<f64>,
    /// Amplitude [N m] of a torque that comes back every seventh of a turn.
    pub(crate) cogging: f64,
}

/// What the loop does against friction. All are given the nominal friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Method {
    Nominal,
    /// With its corner [rad/s].
    DisturbanceObserver(f64),
    Adaptation,
    /// The observer finds what the adaptation leaves.
    Both(f64),
}

/// One sample of a run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Record {
    pub(crate) time: f64,
    /// Reference less position [rad].
    pub(crate) error: f64,
    pub(crate) estimate: FrictionEstimate<f64>,
}

fn curve() -> Result<Stribeck<f64>, ParameterError> {
    Stribeck::new(StribeckParameters {
        static_coefficient: 0.13,
        dynamic_coefficient: 0.1,
        stribeck_velocity: 0.1,
        stribeck_exponent: 1.0,
        viscous_friction: 0.0,
    })
}

fn bristle() -> Result<KelvinVoigt<f64>, ParameterError> {
    KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness: 100.0, micro_damping: 0.3 })
}

/// The friction that the controller knows, per unit normal force.
pub(crate) fn known() -> Result<Friction, ParameterError> {
    Ok(FrBd::new(curve()?, bristle()?))
}

/// Friction of another family: it sticks without a creep.
pub(crate) fn elasto_plastic()
-> Result<ElastoPlastic<Stribeck<f64>, KelvinVoigt<f64>>, ParameterError> {
    ElastoPlastic::new(curve()?, bristle()?, 6e-4)
}

/// Adaptation within a factor of two; the offset within 0.3 N m.
pub(crate) fn parameters() -> Result<AdaptiveFrictionParameters<f64, Friction>, ParameterError> {
    let times = |factor: f64, offset: f64| FrictionEstimate {
        idle_load: factor * NOMINAL.idle_load,
        load_share: factor * NOMINAL.load_share,
        drag: factor * NOMINAL.drag,
        offset,
    };
    Ok(AdaptiveFrictionParameters {
        model: known()?,
        mass: INERTIA,
        sample_time: SAMPLE,
        corner: 100.0,
        slowest: 0.3,
        fastest: FASTEST,
        noise: 0.02,
        memory: 2.0,
        start: NOMINAL,
        least: times(0.5, -0.3),
        most: times(2.0, 0.3),
    })
}

/// Torque of gravity [N m], which the controller knows; its modulus is the load of the gear.
fn gravity(angle: f64) -> f64 {
    4.0 * angle.cos()
}

fn feed_forward(
    estimate: &FrictionEstimate<f64>,
    angle: f64,
) -> Result<FeedForwardParameters<f64, Friction>, ParameterError> {
    Ok(FeedForwardParameters {
        contact: known()?.under_load(estimate.normal_force(gravity(angle).abs()))?,
        sample_time: SAMPLE,
        fastest: FASTEST,
        output: OutputParameters { share: 1.0, largest_force: 5.0 },
    })
}

/// Reference position, velocity and acceleration: two sines.
fn reference(time: f64) -> [f64; 3] {
    [(0.8, 3.0), (0.3, 8.0)].iter().fold([0.0; 3], |sum, &(amplitude, rate)| {
        let (sin, cos) = (rate * time).sin_cos();
        let [x, v, a] = sum;
        [x + amplitude * sin, v + amplitude * rate * cos, a - amplitude * rate * rate * sin]
    })
}

/// The controller's side: what it was given, has measured and has asked for.
struct Controller {
    method: Method,
    adaptive: AdaptiveFriction<f64, Friction>,
    compensator: FeedForwardCompensator<f64, Friction>,
    /// Position [rad] and velocity [rad/s], by counts.
    measured: f64,
    speed: f64,
    /// What the disturbance observer has found [N m].
    observed: f64,
    /// Torques on their way to the motor, and what of each is compensation [N m].
    asked: [[f64; 2]; DELAY],
}

impl Controller {
    fn new(method: Method) -> Result<Self, ParameterError> {
        Ok(Self {
            method,
            adaptive: AdaptiveFriction::new(parameters()?)?,
            compensator: FeedForwardCompensator::new(feed_forward(&NOMINAL, 0.0)?)?,
            measured: 0.0,
            speed: reference(0.0)[1],
            observed: 0.0,
            asked: [[gravity(0.0), 0.0]; DELAY],
        })
    }

    fn adapts(&self) -> bool {
        matches!(self.method, Method::Adaptation | Method::Both(_))
    }

    /// The torque that acts in sample n, and its part for friction; asks for a later one.
    fn control(&mut self, n: usize) -> Result<[f64; 2], ParameterError> {
        let time = SAMPLE * n as f64;
        let [position, ..] = reference(time);
        let [_, before, _] = reference(time - 0.5 * SAMPLE);
        let [_, velocity, acceleration] = reference(time + 0.5 * SAMPLE);
        let estimate = if self.adapts() { self.adaptive.estimate() } else { NOMINAL };
        self.compensator.change(feed_forward(&estimate, position)?)?;
        let friction = self.compensator.step(velocity).force + estimate.beside(velocity);
        let feedback = 80.0 * (position - self.measured) + 2.8 * (before - self.speed);
        let other = INERTIA * acceleration + gravity(self.measured) + self.observed;
        let asked = [feedback + friction + other, friction];
        Ok(core::mem::replace(&mut self.asked[n % DELAY], asked))
    }

    /// Reads the position after a sample in which a torque acted.
    fn measure(&mut self, position: f64, [torque, friction]: [f64; 2]) {
        let counted = (position / COUNT).round() * COUNT;
        let (displacement, weight) = (counted - self.measured, gravity(self.measured));
        let (force, load) = (torque - weight, weight.abs());
        let _ = self.adaptive.step(Sample { displacement, force, load });
        let speed = displacement / SAMPLE;
        if let Method::DisturbanceObserver(corner) | Method::Both(corner) = self.method {
            let rest = force - friction - INERTIA * (speed - self.speed) / SAMPLE;
            self.observed += (1.0 - (-corner * SAMPLE).exp()) * (rest - self.observed);
        }
        (self.measured, self.speed) = (counted, speed);
    }
}

/// A run against a plant whose friction over time is given.
pub(crate) fn run<M: Bristle<f64, Deflection = f64>>(
    plant: M,
    truth: impl Fn(f64) -> Truth,
    method: Method,
    samples: usize,
) -> Result<Vec<Record>, ParameterError> {
    let mut controller = Controller::new(method)?;
    let mut friction = plant.under_load(NOMINAL.idle_load)?.companion(FASTEST)?;
    let [mut x, mut v, _] = reference(0.0);
    let (mut z, mut history, mut noise) = (0.0, VelocityHistory::new(v), bristle_charts::noise());
    let mut records = Vec::with_capacity(samples);
    for n in 0..samples {
        let time = SAMPLE * n as f64;
        let estimate = controller.adaptive.estimate();
        records.push(Record { time, error: reference(time)[0] - x, estimate });
        let acting = controller.control(n)?;
        let Truth { friction: real, cogging } = truth(time);
        let drive = acting[0] + RIPPLE * noise();
        // The plant, in steps of 50 µs.
        let h = SAMPLE / 20.0;
        for _ in 0..20 {
            z = friction.reload(real.normal_force(gravity(x).abs()), v, z)?.deflection;
            let step = friction.step(history.predict(), z, h);
            let other = gravity(x) + real.beside(v) + cogging * (7.0 * x).sin();
            let (mass, force) = (INERTIA, drive - other);
            let body = PointMass { mass, velocity: v, force, end_weight: 0.5 };
            let mean = step.point_mass(body);
            (x, v, z) = (x + h * mean, 2.0 * mean - v, step.commit(mean).deflection);
            history.push(v);
        }
        controller.measure(x, acting);
    }
    Ok(records)
}

/// Root mean square of the error [rad] from a time [s] on.
pub(crate) fn rms(records: &[Record], from: f64) -> f64 {
    let errors = || records.iter().filter(|record| record.time >= from).map(|r| r.error);
    (errors().map(|e| e * e).sum::<f64>() / errors().count() as f64).sqrt()
}
