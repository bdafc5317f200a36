//! One degree of freedom: ẋ = v, m v̇ = f(t) + k (y(t) − x) − d v − F, and how its rungs are run.

use alloc::vec::Vec;

use nalgebra::{Matrix3, Vector3};

use super::super::report::FidelityError;
use super::super::{Rung, weight};
use crate::Mechanism;
use crate::bounds::{larger, smaller};
use crate::companion::VelocityHistory;
use crate::ode::{Failure, Linearisation, Solver, System};
use crate::scalar::{is_zero, lit, to_f64};
use crate::signal::Signal;
use crate::{Branch, Bristle, Contact, LinearisedContact, Scalar};

/// What moves the mass, and where it begins. Positions count from there.
#[derive(Debug, Clone)]
pub(super) struct Machine<T, D, F> {
    pub(super) mechanism: Mechanism<T>,
    pub(super) drive: D,
    pub(super) force: F,
    pub(super) position: T,
    pub(super) velocity: T,
}

impl<T: Scalar, D: Signal<T>, F: Signal<T>> Machine<T, D, F> {
    /// f + k (y − x(0)) \[N\].
    #[inline]
    pub(super) fn applied(&self, time: T) -> T {
        let force = self.force.value(time);
        if is_zero(self.mechanism.spring_stiffness) {
            return force;
        }
        force + self.mechanism.spring_stiffness * (self.drive.value(time) - self.position)
    }

    /// How fast the fastest small motion about a state grows \[1/s\]; negative if all decay.
    pub(super) fn growth_rate<M: Bristle<T, Deflection = T>>(
        &self,
        contact: &Contact<T, M>,
        at: &Sample,
    ) -> f64 {
        let Mechanism { mass, spring_stiffness, viscous_damping } = self.mechanism;
        let jacobian = jacobian(
            &contact.linearised(lit::<T>(at.velocity), lit(at.deflection)),
            (mass, spring_stiffness, viscous_damping),
        );
        let poles = crate::eigenvalues::eigenvalues(&jacobian.map(to_f64), 3);
        // Not a number: nothing decays for certain.
        poles.map_or(0.0, |all| {
            all.iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, |a, b| if b > a { b } else { a })
        })
    }

    fn applied_and_rate(&self, time: T) -> (T, T) {
        let (force, force_rate) = self.force.value_and_rate(time);
        let (drive, drive_rate) = self.drive.value_and_rate(time);
        let stiffness = self.mechanism.spring_stiffness;
        (force + stiffness * (drive - self.position), force_rate + stiffness * drive_rate)
    }
}

/// A mass after a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    /// Position \[m\], from the start.
    pub(super) position: f64,
    /// Velocity [m/s].
    pub(super) velocity: f64,
    /// Friction force \[N\]; NaN if nobody asked.
    pub(super) force: f64,
    /// Deflection \[m\].
    pub(super) deflection: f64,
}

/// A run, or as much of it as its means allowed.
#[derive(Debug, Clone)]
pub(super) struct Run {
    pub(super) samples: Vec<Sample>,
    /// Evaluations of the friction model, Jacobians included.
    pub(super) evaluations: f64,
    /// Weighted right-hand sides.
    pub(super) cost: f64,
}

/// Evaluations that a run may take where they do not count.
pub(super) const NO_LIMIT: (f64, f64) = (f64::INFINITY, f64::INFINITY);

/// When answers are wanted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid<T> {
    pub(super) interval: T,
    pub(super) answers: usize,
    pub(super) substeps: usize,
    pub(super) with_force: bool,
}

impl<T: Scalar> Grid<T> {
    pub(super) fn time(&self, index: usize) -> T {
        self.interval * lit(index as f64)
    }
}

/// Dry friction without memory: true rest, and the curve beside it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dry<T> {
    /// p μ_s \[N\].
    pub(super) breakaway: T,
    /// p σ∞ [N s/m]: what the curve rises by at last. It is taken implicitly, for a step may be long beside m/(p σ∞).
    pub(super) viscous: T,
}

impl<T: Scalar, D: Signal<T>, F: Signal<T>> Machine<T, D, F> {
    /// The static curve with a set-valued friction at rest. With the mean velocity v̄ of a step of length h,
    ///
    /// (2m/h + kh/2 + d) v̄ = 2m v₀/h + f + k (y − x₀) − F̄,
    ///
    /// f and y in the middle of the step. It comes to rest (v₁ = 0, v̄ = v₀/2) if the F̄ that this takes is no more than
    /// p μ_s; else it slides in the direction of that force, with F̄ = p (μ(v\*) − σ∞|v\*|) sgn + p σ∞ v̄ of the extrapolated velocity v\*.
    pub(super) fn slide<M: Bristle<T>>(
        &self,
        contact: &Contact<T, M>,
        dry: Dry<T>,
        grid: Grid<T>,
    ) -> Run {
        let Mechanism { mass, spring_stiffness, viscous_damping } = self.mechanism;
        let half: T = lit(0.5);
        let step = grid.interval / lit(grid.substeps as f64);
        let inertia = mass * lit(2.0) / step;
        let resistance = inertia + spring_stiffness * step * half + viscous_damping;
        let (mut x, mut v) = (T::zero(), self.velocity);
        let mut history = VelocityHistory::new(v);
        let mut samples = Vec::with_capacity(grid.answers);
        let mut evaluations = 0.0;
        for index in 0..grid.answers {
            let start = grid.time(index);
            for substep in 0..grid.substeps {
                let middle = start + step * lit(substep as f64 + 0.5);
                let push = inertia * v + self.applied(middle) - spring_stiffness * x;
                let to_stop = push - resistance * v * half;
                let mut mean = v * half;
                if to_stop.abs() > dry.breakaway {
                    let direction = if to_stop > T::zero() { T::one() } else { -T::one() };
                    let predicted = history.predict() * direction;
                    let curve = if predicted > T::zero() {
                        evaluations += 1.0;
                        contact.stationary_force(predicted * direction).abs()
                            - dry.viscous * predicted
                    } else {
                        dry.breakaway
                    };
                    let sliding = (push - direction * curve) / (resistance + dry.viscous);
                    if (lit::<T>(2.0) * sliding - v) * direction > T::zero() {
                        mean = sliding;
                    }
                }
                x += step * mean;
                v = lit::<T>(2.0) * mean - v;
                history.push(v);
            }
            let force = if !grid.with_force {
                f64::NAN
            } else if is_zero(v) {
                let balance = self.applied(grid.time(index + 1)) - spring_stiffness * x;
                to_f64(larger(smaller(balance, dry.breakaway), -dry.breakaway))
            } else {
                evaluations += 1.0;
                to_f64(contact.stationary_force(v))
            };
            samples.push(Sample {
                position: to_f64(x),
                velocity: to_f64(v),
                force,
                deflection: 0.0,
            });
        }
        let steps = (grid.answers * grid.substeps) as f64;
        let cost = steps * weight::SLIDE + evaluations * weight::STEADY;
        Run { samples, evaluations, cost }
    }

    /// Passive steps of a bristle, solved once each.
    pub(super) fn companion<M: Bristle<T, Deflection = T>>(
        &self,
        contact: &Contact<T, M>,
        deflection: T,
        step_weight: f64,
        grid: Grid<T>,
    ) -> Result<Run, FidelityError> {
        let Mechanism { mass, spring_stiffness, viscous_damping } = self.mechanism;
        let half: T = lit(0.5);
        let step = grid.interval / lit(grid.substeps as f64);
        let inertia = mass * lit(2.0) / step;
        let resistance = inertia + spring_stiffness * step * half + viscous_damping;
        let (mut x, mut v, mut z) = (T::zero(), self.velocity, deflection);
        let companion = contact.clone().companion(T::zero())?;
        let mut history = VelocityHistory::new(v);
        let mut samples = Vec::with_capacity(grid.answers);
        let mut evaluations = 0.0;
        for index in 0..grid.answers {
            let start = grid.time(index);
            for substep in 0..grid.substeps {
                let middle = start + step * lit(substep as f64 + 0.5);
                let push = inertia * v + self.applied(middle) - spring_stiffness * x;
                let friction = companion.step(history.predict(), z, step);
                let mean = (push - friction.bias()) / (resistance + friction.damping());
                x += step * mean;
                v = lit::<T>(2.0) * mean - v;
                z = friction.commit(mean).deflection;
                history.push(v);
            }
            evaluations += grid.substeps as f64;
            let mut force = f64::NAN;
            if grid.with_force {
                evaluations += 1.0;
                force = to_f64(contact.force(v, z));
            }
            let (position, velocity) = (to_f64(x), to_f64(v));
            samples.push(Sample { position, velocity, force, deflection: to_f64(z) });
        }
        let steps = (grid.answers * grid.substeps) as f64;
        let forces = if grid.with_force { grid.answers as f64 } else { 0.0 };
        Ok(Run { samples, evaluations, cost: steps * step_weight + forces * weight::FORCE })
    }

    /// The reference under error control, until it has cost so many evaluations; up to the second number if it looks like ending there.
    pub(super) fn adaptive<M: Bristle<T, Deflection = T>>(
        &self,
        contact: &Contact<T, M>,
        deflection: T,
        (tolerance, scales, longest): (T, Vector3<T>, T),
        grid: Grid<T>,
        (most, at_most): (f64, f64),
    ) -> Result<Run, FidelityError> {
        let rig = Rig { machine: self, contact };
        let stopped = |failure: &Failure<T, 3>| FidelityError::Stopped {
            rung: Rung::Reference,
            time: to_f64(failure.time),
            reason: failure.reason,
        };
        let start = Vector3::new(T::zero(), self.velocity, deflection);
        // What happens within a step goes unseen, and so must not be long beside the scene.
        let solver = Solver::automatic(tolerance, scales)?.with_largest_step(longest)?;
        let span = T::zero()..grid.time(grid.answers);
        let mut run = solver.begin(&rig, span, start).map_err(|f| stopped(&f))?;
        let mut samples: Vec<Sample> = Vec::with_capacity(grid.answers.min(1 << 16));
        let mut forces = 0.0;
        let mut spent = 0.0;
        loop {
            let foreseen = spent * grid.answers as f64 / samples.len() as f64;
            let given_up = spent > at_most || (spent > most && !(foreseen <= at_most));
            if samples.len() >= grid.answers || given_up {
                break;
            }
            let next = grid.time(samples.len() + 1);
            let Some(step) =
                run.advance_observed(|_, end| next < end).map_err(|failure| stopped(&failure))?
            else {
                break;
            };
            while samples.len() < grid.answers {
                let time = grid.time(samples.len() + 1);
                if time > step.end_time() {
                    break;
                }
                let state = step.at(time);
                let mut force = f64::NAN;
                if grid.with_force {
                    forces += 1.0;
                    force = to_f64(contact.force(state[1], state[2]));
                }
                samples.push(Sample {
                    position: to_f64(state[0]),
                    velocity: to_f64(state[1]),
                    force,
                    deflection: to_f64(state[2]),
                });
            }
            let statistics = run.statistics();
            spent = (statistics.evaluations + statistics.jacobians) as f64 + forces;
        }
        let statistics = run.statistics();
        let evaluations = statistics.evaluations as f64 + statistics.jacobians as f64 + forces;
        let cost = statistics.evaluations as f64 * weight::STAGE
            + statistics.jacobians as f64 * weight::JACOBIAN
            + forces * weight::FORCE
            + samples.len() as f64 * weight::DENSE;
        Ok(Run { samples, evaluations, cost })
    }
}

/// Slopes of the rates of position, velocity and deflection by these.
fn jacobian<T: Scalar>(friction: &LinearisedContact<T, T>, (m, k, d): (T, T, T)) -> Matrix3<T> {
    let zero = T::zero();
    Matrix3::new(
        zero,
        T::one(),
        zero,
        -k / m,
        -(d + friction.force_by_velocity) / m,
        -friction.force_by_deflection / m,
        zero,
        friction.rate_by_velocity,
        friction.rate_by_deflection,
    )
}

/// The machine with its friction, for the integrators. States: position from the start, velocity, deflection.
struct Rig<'a, T, M, D, F> {
    machine: &'a Machine<T, D, F>,
    contact: &'a Contact<T, M>,
}

impl<T, M, D, F> System<T, 3> for Rig<'_, T, M, D, F>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    D: Signal<T>,
    F: Signal<T>,
{
    #[inline]
    fn rate(&self, time: T, state: &Vector3<T>, [branch]: [Branch; 1]) -> Vector3<T> {
        let Mechanism { mass, spring_stiffness, viscous_damping } = self.machine.mechanism;
        let friction = self.contact.response(branch.of(state[1]), state[2]);
        let own = spring_stiffness * state[0] + viscous_damping * state[1];
        let force = self.machine.applied(time) - own - friction.force;
        Vector3::new(state[1], force / mass, friction.rate)
    }

    #[inline]
    fn sliding_velocities(&self, _time: T, state: &Vector3<T>) -> [T; 1] {
        [state[1]]
    }

    fn linearised(
        &self,
        time: T,
        state: &Vector3<T>,
        [branch]: [Branch; 1],
    ) -> Option<Linearisation<T, 3>> {
        let Mechanism { mass, spring_stiffness, viscous_damping } = self.machine.mechanism;
        let friction = self.contact.linearised(branch.of(state[1]), state[2]);
        let own = spring_stiffness * state[0] + viscous_damping * state[1];
        let (applied, applied_rate) = self.machine.applied_and_rate(time);
        let zero = T::zero();
        Some(Linearisation {
            rate: Vector3::new(state[1], (applied - own - friction.force) / mass, friction.rate),
            by_state: jacobian(&friction, (mass, spring_stiffness, viscous_damping)),
            by_time: Vector3::new(zero, applied_rate / mass, zero),
        })
    }

    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        let machine = self.machine;
        let (a, b) =
            (machine.drive.next_kink(time, towards), machine.force.next_kink(time, towards));
        crate::signal::first_between(a.into_iter().chain(b), time, towards)
    }
}
