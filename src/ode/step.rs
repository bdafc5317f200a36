//! One accepted step and the curve through it.
//!
//! Dense output: with θ the fraction of the step,
//!
//! x(θ) = cubic Hermite interpolant of both ends and their rates + θ²(1 − θ)² q.
//!
//! The quartic term q is zero for a method without one (order 3 then, else 4).

use nalgebra::SVector;

use crate::Scalar;
use crate::scalar::lit;

/// One accepted step of an integration, with the state at every time within it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step<T, const N: usize> {
    pub(crate) start_time: T,
    pub(crate) end_time: T,
    pub(crate) start: SVector<T, N>,
    pub(crate) end: SVector<T, N>,
    pub(crate) start_rate: SVector<T, N>,
    pub(crate) end_rate: SVector<T, N>,
    pub(crate) quartic: SVector<T, N>,
    pub(crate) reversal_at_start: Option<usize>,
    pub(crate) reversal: Option<usize>,
}

impl<T: Scalar, const N: usize> Step<T, N> {
    /// Time at which the step starts \[s\].
    pub fn start_time(&self) -> T {
        self.start_time
    }

    /// Time at which the step ends \[s\]; before the start for an integration backward in time.
    pub fn end_time(&self) -> T {
        self.end_time
    }

    /// State at the start.
    pub fn start(&self) -> &SVector<T, N> {
        &self.start
    }

    /// State at the end.
    pub fn end(&self) -> &SVector<T, N> {
        &self.end
    }

    /// The contact whose sliding direction reverses at the end of the step, if one does: the step
    /// was cut there.
    pub fn reversal(&self) -> Option<usize> {
        self.reversal
    }

    /// The contact whose sliding direction reverses where the step starts, if one does there
    /// without the step before being cut for it.
    pub fn reversal_at_start(&self) -> Option<usize> {
        self.reversal_at_start
    }

    /// The state at a time within the step.
    pub fn at(&self, time: T) -> SVector<T, N> {
        if time == self.end_time || self.start_time == self.end_time {
            return self.end;
        }
        self.at_fraction((time - self.start_time) / (self.end_time - self.start_time))
    }

    /// The state at a fraction of the step, 0 at its start and 1 at its end.
    #[inline]
    pub fn at_fraction(&self, fraction: T) -> SVector<T, N> {
        let rest = T::one() - fraction;
        let (chord, from_start, from_end) = self.hermite();
        self.start
            + (chord + (from_start + (from_end + self.quartic * rest) * fraction) * rest) * fraction
    }

    /// The slope of the interpolant over the fraction.
    fn slope_at_fraction(&self, fraction: T) -> SVector<T, N> {
        let (chord, from_start, from_end) = self.hermite();
        let two: T = lit(2.0);
        let turn = T::one() - two * fraction;
        chord
            + from_start * turn
            + from_end * (fraction * (two - lit::<T>(3.0) * fraction))
            + self.quartic * (two * fraction * (T::one() - fraction) * turn)
    }

    /// Chord of the step and the departures of the end rates from it.
    #[inline(always)]
    fn hermite(&self) -> (SVector<T, N>, SVector<T, N>, SVector<T, N>) {
        let duration = self.end_time - self.start_time;
        let chord = self.end - self.start;
        let from_start = self.start_rate * duration - chord;
        let from_end = chord - self.end_rate * duration - from_start;
        (chord, from_start, from_end)
    }

    /// The part of the step up to a time within it, with the same interpolant.
    pub(crate) fn until(&self, fraction: T, end_time: T) -> Self {
        let square = fraction * fraction;
        let duration = self.end_time - self.start_time;
        Self {
            end_time,
            end: self.at_fraction(fraction),
            end_rate: self.slope_at_fraction(fraction) / duration,
            quartic: self.quartic * (square * square),
            reversal: if fraction == T::one() { self.reversal } else { None },
            ..*self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Step;
    use nalgebra::Vector1;

    /// A quartic is its own interpolant.
    fn quartic() -> (Step<f64, 1>, impl Fn(f64) -> f64) {
        let value = |t: f64| 1.0 + t - 2.0 * t.powi(2) + 0.5 * t.powi(3) + 0.25 * t.powi(4);
        let slope = |t: f64| 1.0 - 4.0 * t + 1.5 * t.powi(2) + t.powi(3);
        let (a, b) = (0.5, 2.5);
        let step = Step {
            start_time: a,
            end_time: b,
            start: Vector1::new(value(a)),
            end: Vector1::new(value(b)),
            start_rate: Vector1::new(slope(a)),
            end_rate: Vector1::new(slope(b)),
            quartic: Vector1::new(0.25 * 2f64.powi(4)),
            reversal_at_start: None,
            reversal: None,
        };
        (step, value)
    }

    #[test]
    fn a_quartic_is_reproduced_and_stays_itself_when_the_step_is_shortened() {
        let (step, value) = quartic();
        let short = step.until(0.3, 1.1);
        for i in 0..=10 {
            let t = 0.5 + 0.2 * f64::from(i);
            assert!((step.at(t)[0] - value(t)).abs() < 1e-14 * 10.0, "{t}");
            let t = 0.5 + 0.06 * f64::from(i);
            assert!((short.at(t)[0] - value(t)).abs() < 1e-14 * 10.0, "{t}");
        }
    }
}
