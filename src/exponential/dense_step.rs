//! One step on one branch: the bristle between two reversals of its velocity.

#![allow(
    clippy::needless_range_loop,
    reason = "the same index runs through rows, columns and nodes"
)]

use super::nodes::Nodes;
use crate::rheology::{HeldWeights, Weights};
use crate::scalar::{is_zero, lit};
use crate::{Branch, Bristle, Contact, Scalar};

/// The affine bristle at one velocity, per unit normal force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample<T> {
    pub(super) velocity: T,
    /// λ [1/s]
    relaxation: T,
    /// r v [m/s]
    drive: T,
    /// c₀ [1/m]
    stiffness: T,
    /// c₂ v \[–\]
    viscous: T,
}

impl<T: Scalar> Sample<T> {
    /// Evaluates a model at a velocity on a branch. What rounding leaves on the wrong side of a
    /// reversal counts as zero, so that no λ is negative.
    #[inline(always)]
    pub(super) fn new<M: Bristle<T, Deflection = T>>(
        contact: &Contact<T, M>,
        branch: Branch,
        velocity: T,
        deflection: T,
    ) -> Self {
        let mut sliding = branch.of(velocity);
        if sliding.speed() < T::zero() {
            sliding = branch.of(T::zero());
        }
        let velocity = sliding.velocity();
        let affine = contact.affine(sliding, deflection);
        Self {
            velocity,
            relaxation: affine.relaxation,
            drive: affine.drive * velocity,
            stiffness: affine.stiffness,
            viscous: affine.damping * velocity,
        }
    }
}

/// One step of a run: the deflection between two times, without a reversal inside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DenseStep<T, const S: usize> {
    start_time: T,
    end_time: T,
    normal_force: T,
    start: T,
    end: T,
    /// The bristle at the nodes.
    pub(super) samples: [Sample<T>; S],
    /// Between these lie the start and every z_ss at the nodes.
    least: T,
    greatest: T,
    /// What of the start lies outside every z_ss at the nodes, and decays by e^−Λ.
    excess: T,
    /// Λ over the step.
    relaxation: T,
    /// How far the collocated part has come at each node: z = start − excess (1 − e^−Λ) + this.
    way: [T; S],
    /// That way between the nodes.
    way_curve: Curve<T, S>,
    /// Λ between the nodes; zero without an excess.
    relaxation_curve: Curve<T, S>,
    /// An estimate of the error of the curve \[m\].
    pub(super) error: T,
}

/// The mean relaxation rate of the nodes, and the range of their stationary deflections.
#[inline(always)]
fn range<T: Scalar, const S: usize>(samples: &[Sample<T>; S]) -> (T, T, T) {
    let mut relaxation = T::zero();
    let (mut least, mut greatest) = (T::one() / T::zero(), -T::one() / T::zero());
    for (sample, &weight) in samples.iter().zip(&Nodes::<S>::OF.weights) {
        relaxation += sample.relaxation * lit(weight);
        // Without relaxation nothing holds the deflection on the side to which it is driven;
        // 0/0 is neither side.
        let stationary = sample.drive / sample.relaxation;
        (least, greatest) = (least.smaller(stationary), greatest.larger(stationary));
    }
    (relaxation, least, greatest)
}

/// A polynomial of the part θ of the step that is over, zero at the start:
/// first θ + Σ higher_k θ^(k+2).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Curve<T, const S: usize> {
    first: T,
    higher: [T; S],
}

impl<T: Scalar, const S: usize> Curve<T, S> {
    /// The integral of the polynomial through a value at the start and those at the nodes.
    #[inline(always)]
    fn integral(at_start: T, at_nodes: &[T; S]) -> Self {
        let table = &Nodes::<S>::OF;
        let higher = core::array::from_fn(|k| {
            let mut sum = at_start * lit(table.powers_of_start[k]);
            for j in 0..S {
                sum += at_nodes[j] * lit(table.powers[k][j]);
            }
            sum * lit(1.0 / (k + 2) as f64)
        });
        Self { first: at_start, higher }
    }

    #[inline(always)]
    fn at(&self, fraction: T) -> T {
        let sum = self.higher.iter().rev().fold(T::zero(), |sum, &power| sum * fraction + power);
        (sum * fraction + self.first) * fraction
    }

    /// The derivative.
    #[inline(always)]
    fn slope(&self, fraction: T) -> T {
        let mut sum = T::zero();
        for (k, &power) in self.higher.iter().enumerate().rev() {
            sum = (sum + power * lit((k + 2) as f64)) * fraction;
        }
        sum + self.first
    }
}

impl<T: Scalar, const S: usize> DenseStep<T, S> {
    /// Solves one step from what the model says at its nodes, and at its start for the curve
    /// between.
    #[inline]
    pub(super) fn new(
        (start_time, end_time): (T, T),
        normal_force: T,
        start: T,
        at_start: &Sample<T>,
        samples: &[Sample<T>; S],
    ) -> Self {
        let duration = end_time - start_time;
        let (relaxation, mut least, mut greatest) = range(samples);
        let relaxation = relaxation * duration;
        // A deflection that follows z_ss lags by its change over Λ: what is within that of the
        // range belongs to the slow part, what is outside decays exactly.
        let lag = (greatest - least) * (lit::<T>(0.5) + lit::<T>(2.0) / relaxation);
        let held = start.smaller(greatest + lag).larger(least - lag);
        let base = if held.is_finite() { held } else { start };
        let excess = start - base;
        // NaN is no bound.
        least = if least < start { least } else { start };
        greatest = if greatest > start { greatest } else { start };

        let driven: [T; S] =
            core::array::from_fn(|i| (samples[i].drive - samples[i].relaxation * base) * duration);
        let way = collocated(samples, duration, driven);
        // What each node's slope is, θ as the time; their mean is the way, and keeps the digits
        // of a short one that the elimination may lose.
        let slopes: [T; S] =
            core::array::from_fn(|i| driven[i] - samples[i].relaxation * duration * way[i]);
        let end = if relaxation < T::one() {
            let weights = Nodes::<S>::OF.weights.iter().zip(&slopes);
            let sum = weights.fold(T::zero(), |sum, (&weight, &slope)| sum + slope * lit(weight));
            start - excess * fallen(relaxation) + sum
        } else {
            base + excess * (-relaxation).exp() + way[S - 1]
        };

        let first = (at_start.drive - at_start.relaxation * base) * duration;
        let way_curve = Curve::integral(first, &slopes);
        let mut error = unresolved(first, &slopes);
        let mut relaxation_curve = Curve { first: T::zero(), higher: [T::zero(); S] };
        if !is_zero(excess) {
            let first = at_start.relaxation * duration;
            let rates = core::array::from_fn(|i| samples[i].relaxation * duration);
            relaxation_curve = Curve::integral(first, &rates);
            // Where this counts Λ is about one.
            error += excess.abs() * unresolved(first, &rates) / (T::one() + relaxation);
        }
        let mut step = Self {
            start_time,
            end_time,
            normal_force,
            start,
            end,
            samples: *samples,
            least,
            greatest,
            excess,
            relaxation,
            way,
            way_curve,
            relaxation_curve,
            error,
        };
        step.end = step.within(end, T::zero());
        step
    }

    /// Cut to the range that the exact solution keeps, and a margin on both sides.
    #[inline(always)]
    fn within(&self, deflection: T, margin: T) -> T {
        deflection.smaller(self.greatest + margin).larger(self.least - margin)
    }

    /// Time at which the step starts \[s\].
    pub fn start_time(&self) -> T {
        self.start_time
    }

    /// Time at which the step ends \[s\].
    pub fn end_time(&self) -> T {
        self.end_time
    }

    /// Deflection at the start \[m\].
    pub fn start(&self) -> T {
        self.start
    }

    /// Deflection at the end \[m\].
    pub fn end(&self) -> T {
        self.end
    }

    /// The deflection \[m\] at a time within the step.
    #[inline]
    pub fn at(&self, time: T) -> T {
        if time == self.end_time {
            return self.end;
        }
        let fraction = (time - self.start_time) / (self.end_time - self.start_time);
        let mut deflection = self.start + self.way_curve.at(fraction);
        if !is_zero(self.excess) {
            deflection -= self.excess * fallen(self.relaxation_curve.at(fraction));
        }
        // The nodes may miss the extreme of z_ss between them; of a parabola, no more than this.
        self.within(deflection, (self.greatest - self.least) * lit(0.25))
    }

    /// How far from the equation the curve is at a time \[m/s\]: its rate less that of the bristle
    /// there.
    pub(super) fn defect(&self, time: T, sample: &Sample<T>) -> T {
        let duration = self.end_time - self.start_time;
        let fraction = (time - self.start_time) / duration;
        let mut rate = self.way_curve.slope(fraction);
        if !is_zero(self.excess) {
            let relaxation = &self.relaxation_curve;
            rate -= self.excess * (-relaxation.at(fraction)).exp() * relaxation.slope(fraction);
        }
        rate / duration - (sample.drive - sample.relaxation * self.at(time))
    }

    /// No more than this can happen within a time in which the bristle is as in a sample \[m\]. The
    /// deflection cannot leave its range.
    pub(super) fn reach(&self, sample: &Sample<T>, time: T) -> T {
        let range = self.greatest - self.least;
        let turnover = sample.relaxation * time;
        range * if turnover < T::one() { turnover } else { T::one() }
    }

    /// Force, work and deflection of the step.
    pub fn summary(&self) -> StepSummary<T> {
        let table = &Nodes::<S>::OF;
        let duration = self.end_time - self.start_time;
        let mut deflections: [T; S] = core::array::from_fn(|i| self.start + self.way[i]);
        if !is_zero(self.excess) {
            for (deflection, fall) in deflections.iter_mut().zip(self.falls()) {
                *deflection += self.excess * fall;
            }
        }
        let (mut stiffness, mut weighted, mut viscous) = (T::zero(), T::zero(), T::zero());
        let mut positive = true;
        for i in 0..S {
            let sample = &self.samples[i];
            let share = sample.stiffness * lit(table.weights[i]);
            positive = positive && share > T::zero();
            stiffness += share;
            weighted += share * deflections[i];
            viscous += sample.viscous * lit(table.weights[i]);
        }
        // With positive stiffness the mean deflection keeps the range of the exact one.
        let shift = if positive {
            let mean = weighted / stiffness;
            self.within(mean, T::zero()) - mean
        } else {
            T::zero()
        };
        let mut work = T::zero();
        for i in 0..S {
            let sample = &self.samples[i];
            let coefficient = sample.stiffness * (deflections[i] + shift) + sample.viscous;
            work += coefficient * sample.velocity * lit(table.weights[i]);
        }
        let last = &self.samples[S - 1];
        StepSummary {
            deflection: self.end,
            end: self.normal_force * (last.stiffness * self.end + last.viscous),
            mean: self.normal_force * (weighted + stiffness * shift + viscous),
            work: self.normal_force * work * duration,
        }
    }

    /// e^−Λ − 1 at the nodes: collocated, and scaled so that ∫λ(e^−Λ − 1), which is known, is met.
    fn falls(&self) -> [T; S] {
        let table = &Nodes::<S>::OF;
        let duration = self.end_time - self.start_time;
        let fading = core::array::from_fn(|i| -self.samples[i].relaxation * duration);
        let mut falls = collocated(&self.samples, duration, fading);
        let mut integral = T::zero();
        for i in 0..S {
            integral += falls[i] * self.samples[i].relaxation * duration * lit(table.weights[i]);
        }
        // 1 − e^−Λ − Λ = −Λ² φ2(Λ), by way of the exact step of a bristle with λ = 1.
        let weights = Weights::new(T::one(), self.relaxation);
        let wanted = -weights.mean(T::zero(), T::one()) * self.relaxation;
        // Both vanish as Λ²/2.
        let slight = self.relaxation < T::default_epsilon();
        let scale = if slight { T::one() } else { wanted / integral };
        for fall in &mut falls {
            *fall *= scale;
        }
        falls
    }
}

/// Deflection, force and work of one step, from [`Exponential::ramp`](super::Exponential::ramp) and
/// [`Exponential::step`](super::Exponential::step).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepSummary<T> {
    /// Deflection at the end of the step \[m\].
    pub deflection: T,
    /// Friction force \[N\] at the end of the step.
    pub end: T,
    /// Friction force \[N\] averaged over the step.
    pub mean: T,
    /// Work ∫F v dt done against friction \[J\].
    pub work: T,
}

impl<T: Scalar> StepSummary<T> {
    /// Adds what happens in the part of the step that follows, given the length of that part.
    pub(super) fn then(self, next: Self, part: T) -> Self {
        let (mean, work) = (self.mean + next.mean * part, self.work + next.work);
        Self { mean, work, ..next }
    }

    /// The answer to input that is not a number.
    pub(super) fn unknown() -> Self {
        Self { deflection: T::nan(), end: T::nan(), mean: T::nan(), work: T::nan() }
    }
}

/// 1 − e^−x.
#[inline(always)]
fn fallen<T: Scalar>(x: T) -> T {
    -(-x).exp_m1()
}

/// The size over the step of the integral of what the polynomial through a value at the start and
/// those at the nodes leaves out: its Legendre coefficients go on falling, two by two, as the last
/// four do.
#[inline(always)]
fn unresolved<T: Scalar, const S: usize>(at_start: T, at_nodes: &[T; S]) -> T {
    let table = &Nodes::<S>::OF;
    let size = |row: usize| {
        let mut sum = at_start * lit(table.tail_of_start[row]);
        for j in 0..S {
            sum += at_nodes[j] * lit(table.tail[row][j]);
        }
        sum.abs()
    };
    let (before, last) = (size(0) + size(1), size(2) + size(3));
    let left = if last < before { last * (last / before) } else { last };
    left * lit(1.0 / (2 * S + 1) as f64)
}

/// Solves (D + λh) y = right by elimination. Without pivots: the matrix D with λ ≥ 0 on its
/// diagonal is, its rows weighted by b, positive definite.
#[inline(always)]
fn collocated<T: Scalar, const S: usize>(
    samples: &[Sample<T>; S],
    duration: T,
    mut right: [T; S],
) -> [T; S] {
    let mut matrix = [[T::zero(); S]; S];
    for i in 0..S {
        for j in 0..S {
            matrix[i][j] = lit(Nodes::<S>::OF.slopes[i][j]);
        }
        matrix[i][i] += samples[i].relaxation * duration;
    }
    for k in 0..S {
        let inverse = T::one() / matrix[k][k];
        for j in k + 1..S {
            matrix[k][j] *= inverse;
        }
        right[k] *= inverse;
        for i in k + 1..S {
            let factor = matrix[i][k];
            for j in k + 1..S {
                let change = factor * matrix[k][j];
                matrix[i][j] -= change;
            }
            let change = factor * right[k];
            right[i] -= change;
        }
    }
    for k in (0..S).rev() {
        for j in k + 1..S {
            let change = matrix[k][j] * right[j];
            right[k] -= change;
        }
    }
    right
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::{DenseStep, Sample};
    use crate::{Branch, Bristle, Dahl, DahlParameters};

    #[test]
    fn at_a_held_velocity_the_curve_of_a_step_solves_the_equation() {
        let parameters = DahlParameters { dynamic_coefficient: 0.3, micro_stiffness: 1e4 };
        let dahl = Dahl::new(parameters).unwrap().under_load(1.0).unwrap();
        let velocity = 0.01;
        let sample = Sample::new(&dahl, Branch::Forward, velocity, 0.0);
        for start in [-3e-5, 0.0, 2e-5] {
            // Over 1.7 relaxation times.
            let step = DenseStep::<f64, 3>::new((1.0, 1.005), 1.0, start, &sample, &[sample; 3]);
            for part in 0..=10 {
                let time = 1.0 + 5e-4 * f64::from(part);
                // Differences of times near one have eleven digits.
                let defect = step.defect(time, &sample);
                assert!(defect.abs() < 1e-11 * velocity, "{start} {time}: {defect}");
            }
        }
    }
}
