//! Friction of one axis, estimated while it moves.
//!
//! m v̇ = u − F,  F = (p0 + k q) μ_b(v, z) + B v + F0
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | m, v | mass, velocity | kg, m/s |
//! | u | force of the actuator and known external forces | N |
//! | μ_b, z | friction coefficient of the bristle model, its deflection | –, m |
//! | p0, k | load of the idle axis, share of the load q in the normal force | N, – |
//! | q | a load that is known: a weight, the modulus of a gear's torque | N |
//! | B, F0 | drag, offset (forward and backward friction differ by twice this) | N s/m, N |
//! | ω | corner of the filters | rad/s |
//! | h | sample time | s |
//!
//! (p0, k, B, F0) is linear in this balance. Both sides are averaged over two samples, in which the
//! second difference of the positions is exactly m v̇, and pass two equal low-pass filters of the
//! corner ω. So no velocity is differentiated, and the balance holds as it did before. The filters
//! start empty where sliding begins: both sides lack the same past, and the first samples, in which
//! the bristle has hardly yielded, count little (kept full they tripled the time to find a level).
//!
//! The estimate is frozen while the axis does not slide. A stuck contact carries any force up to
//! breakaway, which says nothing of its level. What counts as sliding is a speed of the user, at
//! which the bristle has long yielded.
//!
//! Filtered samples are correlated: 1 + 4/(ω h) of them count as one.
//!
//! Source: J.-J. E. Slotine, W. Li, "Applied Nonlinear Control", Prentice-Hall 1991, section 8.7,
//! for the filtered balance.

use bristle::nalgebra::{SVector, Vector4};
use bristle::parameter::{Checked, Named};
use bristle::rheology::Deflection;
use bristle::scalar::lit;
use bristle::{Bristle, Scalar};

use crate::{RecursiveLeastSquares, RecursiveLeastSquaresParameters};

/// What is estimated. Torques in N m and radians for an axis that turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionEstimate<T> {
    /// Normal force p0 \[N\] of the idle axis; with the model, its Coulomb level.
    #[doc(alias = "level")]
    pub idle_load: T,
    /// Share k \[–\] of the load in the normal force.
    pub load_share: T,
    /// Drag B [N s/m] beside the bristle.
    pub drag: T,
    /// Force F0 \[N\] against a motion forward, with a motion backward.
    pub offset: T,
}

impl<T: Scalar> FrictionEstimate<T> {
    /// The normal force p0 + k q \[N\] of the bristle under a load q \[N\], for a compensator.
    pub fn normal_force(&self, load: T) -> T {
        self.idle_load + self.load_share * load
    }

    /// The force B v + F0 \[N\] beside the bristle at a velocity [m/s], to be added to that of a
    /// compensator.
    pub fn beside(&self, velocity: T) -> T {
        self.drag * velocity + self.offset
    }

    fn vector(&self) -> Vector4<T> {
        Vector4::new(self.idle_load, self.load_share, self.drag, self.offset)
    }
}

/// Parameters of [`AdaptiveFriction`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdaptiveFrictionParameters<T, M> {
    /// Friction per unit normal force: the shape, which is not adapted.
    pub model: M,
    /// Mass m \[kg\], zero or positive.
    pub mass: T,
    /// Sample time h \[s\], positive.
    pub sample_time: T,
    /// Corner ω [rad/s] of the filters, positive: as high as the noise of the second difference of
    /// positions allows.
    pub corner: T,
    /// Speed [m/s] from which the axis slides, positive: some times what it passes while the
    /// bristle yields.
    pub slowest: T,
    /// Speed [m/s] that the axis cannot exceed, above the slowest: faster samples are refused.
    pub fastest: T,
    /// Standard deviation \[N\] of the filtered force balance about the model, positive.
    pub noise: T,
    /// Time of sliding \[s\] after which a motion of one kind has faded to 1/e; at least 8 h.
    pub memory: T,
    /// The estimate at the beginning, within the bounds.
    pub start: FrictionEstimate<T>,
    /// The least that each may become; of normal force and share, zero or positive.
    pub least: FrictionEstimate<T>,
    /// The most that each may become. What equals its least is known and not adapted.
    pub most: FrictionEstimate<T>,
}

/// What happened in one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<T> {
    /// Displacement over the sample \[m\]: the difference of two positions, or v h.
    pub displacement: T,
    /// Force u \[N\] over the sample: that of the actuator, and known external forces.
    pub force: T,
    /// Load q \[N\] over the sample, zero or positive.
    pub load: T,
}

/// What a sample was good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SampleUse {
    /// The axis slid: the estimate has moved.
    Adapted,
    /// The axis was slower than the slowest speed, or the sample before is missing: frozen.
    Frozen,
    /// The sample is not finite or larger than a parameter may be (1e100, in `f32` 1e15), its load
    /// negative or its speed above the fastest: it is counted, and nothing else changes. The
    /// balance goes on with the second sample after it.
    Refused,
}

/// The answer to one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use = "the estimate is for a compensator"]
pub struct Adapted<T> {
    /// The estimate, within its bounds.
    pub estimate: FrictionEstimate<T>,
    /// What the sample was good for.
    pub sample: SampleUse,
    /// How many samples have been refused since the beginning.
    pub refused: u32,
}

/// One row of the balance: u, and the factors of p0, k, B and F0.
type Row<T> = SVector<T, 5>;

/// The estimate and its filters; one [`AdaptiveFriction::step`] a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdaptiveFriction<T: Scalar, M: Bristle<T>> {
    model: M,
    mass: T,
    sample_time: T,
    slowest: T,
    fastest: T,
    /// 1 − e^(−ω h)
    share: T,
    least_squares: RecursiveLeastSquares<T, 4>,
    deflection: M::Deflection,
    /// The row of the sample before; none at the beginning and after a refused one.
    before: Option<Row<T>>,
    filters: [Row<T>; 2],
    refused: u32,
}

impl<T: Scalar, M: Bristle<T>> AdaptiveFriction<T, M> {
    /// Checks the parameters. The bristle starts undeflected.
    ///
    /// # Errors
    ///
    /// Refuses parameters out of the ranges that their docs say.
    pub fn new(parameters: AdaptiveFrictionParameters<T, M>) -> Checked<Self> {
        let AdaptiveFrictionParameters { model, start, least, most, .. } = parameters;
        let sample_time = Named("sample_time", parameters.sample_time).positive()?;
        let corner = Named("corner", parameters.corner).positive()? * sample_time;
        let fastest = Named("fastest", parameters.fastest).positive()?;
        let slowest = Named("slowest", parameters.slowest).positive()?;
        Named("least.idle_load", least.idle_load).non_negative()?;
        Named("least.load_share", least.load_share).non_negative()?;
        let correlated = T::one() + lit::<T>(4.0) / corner;
        Ok(Self {
            model,
            mass: Named("mass", parameters.mass).non_negative()?,
            sample_time,
            slowest: Named("slowest", slowest).below("fastest", fastest)?,
            fastest,
            share: T::one() - (-corner).exp(),
            least_squares: RecursiveLeastSquares::new(RecursiveLeastSquaresParameters {
                start: start.vector(),
                least: least.vector(),
                most: most.vector(),
                noise: Named("noise", parameters.noise).positive()? * correlated.sqrt(),
                memory: Named("memory", parameters.memory).positive()? / sample_time,
            })?,
            deflection: M::Deflection::fill(T::zero()),
            before: None,
            filters: [Row::zeros(); 2],
            refused: 0,
        })
    }

    /// Takes the sample that has just ended.
    #[inline]
    pub fn step(&mut self, sample: Sample<T>) -> Adapted<T> {
        let sample = self.take(sample).unwrap_or_else(|| {
            (self.before, self.refused) = (None, self.refused.saturating_add(1));
            SampleUse::Refused
        });
        Adapted { estimate: self.estimate(), sample, refused: self.refused }
    }

    /// The estimate now.
    pub fn estimate(&self) -> FrictionEstimate<T> {
        let [idle_load, load_share, drag, offset] = (*self.least_squares.estimate()).into();
        FrictionEstimate { idle_load, load_share, drag, offset }
    }

    /// Standard deviation of the estimate, as far as the model and its noise are right.
    pub fn deviation(&self) -> FrictionEstimate<T> {
        let variance = self.least_squares.covariance().diagonal();
        let [idle_load, load_share, drag, offset] = variance.map(T::sqrt).into();
        FrictionEstimate { idle_load, load_share, drag, offset }
    }

    fn take(&mut self, sample: Sample<T>) -> Option<SampleUse> {
        let Sample { displacement, force, load } = sample;
        let velocity = displacement / self.sample_time;
        let force = Named("force", force).finite().ok()?;
        let load = Named("load", load).non_negative().ok()?;
        if !(velocity.abs() <= self.fastest) {
            return None;
        }
        let held = self.model.hold(velocity, self.deflection, self.sample_time);
        let coefficient = held.mean_coefficient;
        let row = Row::from([force, coefficient, coefficient * load, velocity, T::one()]);
        if !row.iter().fold(true, |finite, x| finite & x.is_finite()) {
            return None;
        }
        self.deflection = held.deflection;
        let Some(before) = self.before.replace(row) else { return Some(SampleUse::Frozen) };
        let slower = velocity.abs().smaller(before[3].abs());
        if !(slower >= self.slowest && velocity * before[3] > T::zero()) {
            self.filters = [Row::zeros(); 2];
            return Some(SampleUse::Frozen);
        }
        let mut balance = (row + before) * lit::<T>(0.5);
        balance[0] -= self.mass * ((velocity - before[3]) / self.sample_time);
        for filter in &mut self.filters {
            *filter += (balance - *filter) * self.share;
            balance = *filter;
        }
        let [[force, regressor @ ..]] = balance.data.0;
        let moved = self.least_squares.update(&regressor.into(), force);
        Some(if moved { SampleUse::Adapted } else { SampleUse::Frozen })
    }
}
