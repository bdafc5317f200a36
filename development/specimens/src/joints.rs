//! Mechanisms of many driven joints with friction.

use bristle::curve::Stribeck;
use bristle::ode::System;
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Branch, Bristle, Contact, ElastoPlastic, FrBd, paper};
use nalgebra::{SMatrix, SVector};

use crate::draw::Draw;

/// Of the whole arm [m], [kg].
const LENGTH: f64 = 2.0;
const MASS: f64 = 3.0;
/// [m/s²].
const GRAVITY: f64 = 9.81;

/// The model of friction.
pub type Friction = FrBd<Stribeck<f64>, KelvinVoigt<f64>>;

/// The elasto-plastic one.
pub type Yielding = ElastoPlastic<Stribeck<f64>, KelvinVoigt<f64>>;

/// Joints with position control and friction, each with a sine of its own to follow.
pub struct Joints<const K: usize, M = Friction> {
    friction: Contact<f64, M>,
    /// Of the position [N m/rad] and of the velocity [N m s/rad].
    gains: [f64; 2],
    /// Amplitude [rad], angular frequency [rad/s] and phase [rad] of each.
    sines: [[f64; 3]; K],
}

fn parts() -> (Stribeck<f64>, KelvinVoigt<f64>) {
    let bristle = KelvinVoigtParameters { micro_stiffness: 1e3, micro_damping: 2.0 };
    (Stribeck::new(paper::STICK_SLIP_CURVE).unwrap(), KelvinVoigt::new(bristle).unwrap())
}

impl<const K: usize> Joints<K> {
    pub fn new(gains: [f64; 2], sines: [[f64; 3]; K]) -> Self {
        let (curve, bristle) = parts();
        Self { friction: FrBd::new(curve, bristle).under_load(3.0).unwrap(), gains, sines }
    }

    /// With the elasto-plastic model of the same curve and bristle, and a stick limit \[m\]
    /// below 1e-3.
    pub fn elasto_plastic(self, stick_limit: f64) -> Joints<K, Yielding> {
        let (curve, bristle) = parts();
        let friction = ElastoPlastic::new(curve, bristle, stick_limit).unwrap();
        let Self { gains, sines, .. } = self;
        Joints { friction: friction.under_load(3.0).unwrap(), gains, sines }
    }

    pub fn drawn(draw: &mut Draw) -> Self {
        let gain = draw.logarithmic(20.0, 600.0);
        let sine = |_| {
            [0.1 + 0.5 * draw.next(), 0.5 + 4.0 * draw.next(), std::f64::consts::TAU * draw.next()]
        };
        let sines = std::array::from_fn(sine);
        Self::new([gain, 0.05 * gain], sines)
    }
}

impl<const K: usize, M: Bristle<f64, Deflection = f64>> Joints<K, M> {
    /// Writes the rates of position and deflection. Answers with the torque of joint i.
    fn torque(&self, i: usize, time: f64, state: &[f64], branch: Branch, rate: &mut [f64]) -> f64 {
        let [angle, velocity, deflection] = [0, 1, 2].map(|k| state[3 * i + k]);
        let friction = self.friction.response(branch.of(velocity), deflection);
        (rate[3 * i], rate[3 * i + 2]) = (velocity, friction.rate);
        let [amplitude, angular, phase] = self.sines[i];
        let (sine, cosine) = (angular * time + phase).sin_cos();
        let off = [amplitude * sine - angle, amplitude * angular * cosine - velocity];
        self.gains[0] * off[0] + self.gains[1] * off[1] - friction.force
    }

    fn switching_functions(&self, state: &[f64], branches: [Branch; K], tell: &mut dyn FnMut(f64)) {
        for (i, branch) in branches.into_iter().enumerate() {
            let sliding = branch.of(state[3 * i + 1]);
            self.friction.switching_function(sliding, state[3 * i + 2]).map(&mut *tell);
        }
    }

    fn scales<const N: usize>() -> SVector<f64, N> {
        SVector::from_fn(|i, _| [0.5, 0.5, 1e-3][i % 3])
    }
}

/// Side by side, with springs of 40 N m/rad between them.
pub struct Axes<const K: usize, M = Friction>(pub Joints<K, M>);

impl<const N: usize, const K: usize, M> System<f64, N, K> for Axes<K, M>
where
    M: Bristle<f64, Deflection = f64>,
{
    fn rate(&self, time: f64, state: &SVector<f64, N>, branches: [Branch; K]) -> SVector<f64, N> {
        let mut rate = SVector::<f64, N>::zeros();
        for (i, branch) in branches.into_iter().enumerate() {
            let own = self.0.torque(i, time, state.as_slice(), branch, rate.as_mut_slice());
            let angle = |i: usize| state.get(3 * i).copied().unwrap_or(0.0);
            let before = if i == 0 { 0.0 } else { angle(i - 1) };
            let springs = 40.0 * (before + angle(i + 1) - 2.0 * angle(i));
            rate[3 * i + 1] = (own + springs) / (0.3 + 0.1 * i as f64);
        }
        rate
    }

    fn sliding_velocities(&self, _: f64, state: &SVector<f64, N>) -> [f64; K] {
        core::array::from_fn(|i| state[3 * i + 1])
    }

    fn switching_functions(
        &self,
        _: f64,
        state: &SVector<f64, N>,
        branches: [Branch; K],
        tell: &mut dyn FnMut(f64),
    ) {
        self.0.switching_functions(state.as_slice(), branches, tell);
    }

    fn scales(&self) -> SVector<f64, N> {
        Joints::<K>::scales()
    }
}

/// In a row, links with a mass at each end: with the angles φ from the horizontal, M φ̈ = Q,
/// Mᵢⱼ = m l² (K − max(i, j)) cos(φᵢ − φⱼ), and 0.02 kg m² more on the diagonal.
pub struct Arm<const K: usize, M = Friction>(pub Joints<K, M>);

impl<const N: usize, const K: usize, M> System<f64, N, K> for Arm<K, M>
where
    M: Bristle<f64, Deflection = f64>,
{
    fn rate(&self, time: f64, state: &SVector<f64, N>, branches: [Branch; K]) -> SVector<f64, N> {
        let mut rate = SVector::<f64, N>::zeros();
        let (mut angles, mut speeds, mut torques) = ([0.0; K], [0.0; K], [0.0; K]);
        let (mut angle, mut speed) = (0.0, 0.0);
        for (i, branch) in branches.into_iter().enumerate() {
            torques[i] = self.0.torque(i, time, state.as_slice(), branch, rate.as_mut_slice());
            (angle, speed) = (angle + state[3 * i], speed + state[3 * i + 1]);
            (angles[i], speeds[i]) = (angle, speed);
        }
        let (mass, length) = (MASS / K as f64, LENGTH / K as f64);
        let mut inertia = SMatrix::<f64, K, K>::from_diagonal_element(0.02);
        let mut force = SVector::<f64, K>::zeros();
        for i in 0..K {
            let weight = mass * GRAVITY * length * (K - i) as f64 * angles[i].cos();
            force[i] = torques[i] - torques.get(i + 1).unwrap_or(&0.0) - weight;
            for j in 0..K {
                let (sine, cosine) = (angles[i] - angles[j]).sin_cos();
                let beyond = mass * length * length * (K - i.max(j)) as f64;
                inertia[(i, j)] += beyond * cosine;
                force[i] -= beyond * sine * speeds[j] * speeds[j];
            }
        }
        let accelerations = inertia.cholesky().map(|factors| factors.solve(&force));
        let accelerations = accelerations.unwrap_or(SVector::repeat(f64::NAN));
        for i in 0..K {
            let before = if i == 0 { 0.0 } else { accelerations[i - 1] };
            rate[3 * i + 1] = accelerations[i] - before;
        }
        rate
    }

    fn sliding_velocities(&self, _: f64, state: &SVector<f64, N>) -> [f64; K] {
        core::array::from_fn(|i| state[3 * i + 1])
    }

    fn switching_functions(
        &self,
        _: f64,
        state: &SVector<f64, N>,
        branches: [Branch; K],
        tell: &mut dyn FnMut(f64),
    ) {
        self.0.switching_functions(state.as_slice(), branches, tell);
    }

    fn scales(&self) -> SVector<f64, N> {
        Joints::<K>::scales()
    }
}
