//! What a scene says before it is run, and what a run says of the scene: bounds of energy, conditioning, evidence.

use alloc::vec::Vec;

use super::super::report::{Evidence, FidelityError, Norm};
use super::climb::{AbsoluteValue, Climb, larger, root};
use super::machine::{Run, Sample};
use crate::scalar::to_f64;
use crate::signal::Signal;
use crate::{Bristle, Law, Scalar};

/// Error of a run in times its tolerance that is not held against a friction model's energy balance.
const LOOSE: f64 = 30.0;
/// Instants at which the evidence looks at the curve.
const LOOKS: usize = 32;
/// Instants at which it is asked how fast errors grow.
const GROWTH_LOOKS: usize = 64;
/// e-foldings that are no waiting.
const FEW_FOLDS: f64 = 2.0;
/// A velocity that changes by less than this part of itself while an error grows by a factor e (or in an interval) is even.
const EVEN: f64 = 0.3;

/// What the applied force says before anything is run.
pub(super) struct Survey {
    /// The largest of it \[N\].
    pub(super) largest: f64,
    /// √(2E) that it can have given the mass by each answer \[√J\]: of a passive contact no more.
    gained: Vec<f64>,
}

impl<T, M, D, F> Climb<'_, T, M, D, F>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    D: Signal<T>,
    F: Signal<T>,
{
    /// What the applied force can have done by each answer. d√(2E)/dt ≤ |f + k (y − x₀)|/√m for a passive contact,
    /// E = ½ m v² + ½ k (x − x₀)² + W.
    pub(super) fn survey(&self) -> Survey {
        let scene = self.scene;
        let machine = &scene.machine;
        let mass = to_f64(machine.mechanism.mass);
        let interval = to_f64(scene.interval);
        let z = match scene.start {
            super::Start::Undeflected => 0.0,
            super::Start::Steady => to_f64(scene.contact.stationary(machine.velocity)),
        };
        let springs = to_f64(scene.contact.model().storage_stiffness())
            * to_f64(scene.contact.normal_force());
        let start = to_f64(machine.velocity);
        let mut gained = root(mass * start * start + springs * z * z);
        let mut all = Vec::with_capacity(scene.answers);
        let at = |place: f64| {
            to_f64(machine.applied(scene.interval * crate::scalar::lit(place))).abs_value()
        };
        let mut before = at(0.0);
        let mut largest = before;
        for index in 0..scene.answers {
            let (middle, end) = (at(index as f64 + 0.5), at(index as f64 + 1.0));
            // The larger end of each half.
            let (first, second) = (larger(before, middle), larger(middle, end));
            gained += 0.5 * interval * (first + second) / root(mass);
            largest = larger(largest, larger(first, second));
            all.push(gained);
            before = end;
        }
        Survey { largest, gained: all }
    }

    /// A bound on the error of true rest, where the static curve cannot but rest.
    pub(super) fn stuck_bound(&self, survey: &Survey) -> Option<f64> {
        let scene = self.scene;
        let machine = &scene.machine;
        let at_rest = crate::scalar::is_zero(machine.velocity)
            && survey.largest <= to_f64(scene.dry.breakaway)
            && scene.contact.model().obeys(Law::Passivity);
        if !at_rest || scene.quantity == super::Quantity::Force {
            return None;
        }
        let mass = to_f64(machine.mechanism.mass);
        let stiffness = to_f64(machine.mechanism.spring_stiffness);
        let interval = to_f64(scene.interval);
        let (mut way, mut error, mut squares) = (0.0, 0.0_f64, 0.0);
        for gained in &survey.gained {
            let speed = gained / root(mass);
            way += interval * speed;
            let spring = gained / root(stiffness);
            let off = match scene.quantity {
                super::Quantity::Velocity => speed,
                _ if spring < way => spring,
                _ => way,
            };
            error = larger(error, off);
            squares += off * off;
        }
        Some(match self.tolerance.norm {
            Norm::Greatest => error,
            Norm::RootMeanSquare => root(squares / survey.gained.len() as f64),
        })
    }

    /// Whether the mass holds more energy than it can have got.
    pub(super) fn check_energy(
        &self,
        run: &Run,
        digits: u8,
        survey: &Survey,
    ) -> Result<(), FidelityError> {
        let scene = self.scene;
        let mechanism = &scene.machine.mechanism;
        let springs = to_f64(scene.contact.model().storage_stiffness())
            * to_f64(scene.contact.normal_force());
        let (mass, stiffness) = (to_f64(mechanism.mass), to_f64(mechanism.spring_stiffness));
        let tolerance = nalgebra::ComplexField::powi(10.0_f64, -i32::from(digits));
        let slack = LOOSE * tolerance * root(mass) * to_f64(scene.scales[1]) + 1e-150;
        for (index, (sample, gained)) in run.samples.iter().zip(&survey.gained).enumerate() {
            let Sample { position: x, velocity: v, deflection: z, .. } = *sample;
            let energy = 0.5 * (mass * v * v + stiffness * x * x + springs * z * z);
            // A hundredth for what lies between answers, and what errors of the run may seem to add.
            let most = 1.01 * gained + slack;
            let limit = 0.5 * most * most;
            if !(energy <= limit) {
                let time = to_f64(scene.interval) * (index + 1) as f64;
                return Err(FidelityError::GainsEnergy { time, energy, limit });
            }
        }
        Ok(())
    }

    /// By how much a relative error of the forces has grown, beside the velocity, where a run slides evenly although that is unstable:
    ///
    /// e^S p μ_s/(m σ |v|),  S = ∫ σ dt over the intervals in which σ > 0 and |Δv| < 0.3 |v| min(1, σ Δt),
    ///
    /// σ \[1/s\] the largest real part of the eigenvalues of the Jacobian at an answer. Where the velocity grows as fast as an error does, the
    /// motion is only early or late; here it waits, and what it waits for is the error.
    pub(super) fn growth(&self, run: &Run) -> f64 {
        let scene = self.scene;
        let interval = to_f64(scene.interval);
        let shake = to_f64(scene.dry.breakaway) / to_f64(scene.machine.mechanism.mass);
        let stride = run.samples.len().div_ceil(GROWTH_LOOKS).max(1);
        let (mut all, mut worst) = (0.0, 1.0);
        for (before, now) in run.samples.iter().zip(run.samples.iter().skip(1)).step_by(stride) {
            let change = (now.velocity - before.velocity).abs_value();
            let speed = now.velocity.abs_value();
            if !(change < EVEN * speed) {
                continue;
            }
            let rate = scene.machine.growth_rate(&scene.contact, now);
            let folds = rate * interval;
            if change < EVEN * speed * folds {
                all += folds * stride as f64;
                worst = larger(worst, shake / (rate * speed));
            }
        }
        if all > FEW_FOLDS { worst * nalgebra::ComplexField::exp(all) } else { 1.0 }
    }

    /// What kind of a scene the reference found.
    pub(super) fn evidence(&self, run: &Run) -> Evidence {
        let scene = self.scene;
        let model = scene.contact.model();
        let breakaway = to_f64(scene.scales[2]);
        let (mut slowest, mut fastest) = (f64::INFINITY, 0.0);
        let (mut reversals, mut stuck) = (0, 0_usize);
        let (mut way, mut longest, mut from) = (0.0, 0.0, 0.0);
        let (mut lag, mut relaxation) = (0.0, 0.0);
        let mut direction = 0.0;
        let interval = to_f64(scene.interval);
        let stride = run.samples.len().div_ceil(LOOKS).max(1);
        for (index, sample) in run.samples.iter().enumerate() {
            let speed = sample.velocity.abs_value();
            slowest = if speed < slowest { speed } else { slowest };
            fastest = larger(fastest, speed);
            if sample.velocity * direction < 0.0 {
                reversals += 1;
                way = 0.0;
            }
            if sample.velocity != 0.0 {
                direction = sample.velocity;
            }
            way += (sample.position - from).abs_value();
            from = sample.position;
            longest = larger(longest, way);
            if way < breakaway {
                stuck += 1;
            }
            if index % stride == 0 {
                let v: T = crate::scalar::lit(sample.velocity);
                let z = to_f64(model.stationary(v));
                lag = larger(lag, (sample.deflection - z).abs_value() / breakaway);
                relaxation += stride as f64
                    * interval
                    * to_f64(
                        model.affine(v.into(), crate::scalar::lit(sample.deflection)).relaxation,
                    );
            }
        }
        Evidence {
            slowest,
            fastest,
            reversals,
            lag,
            presliding: breakaway / longest,
            stuck_share: stuck as f64 / run.samples.len().max(1) as f64,
            relaxation,
            transits: None,
        }
    }
}
