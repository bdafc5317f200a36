//! Part of a deflection profile: the bristles that entered during one step.

use crate::Scalar;
use crate::rolling::integrals::{decaying, phi1, rising};
use crate::scalar::{is_zero, lit};

/// What a step makes of every bristle that was there at its beginning: z ← decay·z + offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Map<T> {
    pub(super) decay: T,
    pub(super) offset: T,
}

impl<T: Scalar> Map<T> {
    pub(super) fn identity() -> Self {
        Self { decay: T::one(), offset: T::zero() }
    }

    #[inline(always)]
    pub(super) fn of(self, deflection: T) -> T {
        self.decay * deflection + self.offset
    }

    /// The moments ∫₀^c sᵏ e^(−as) z ds of bristles over a length c after the step.
    #[inline(always)]
    pub(super) fn of_moments<const N: usize>(
        self,
        mut moments: [T; N],
        length: T,
        decay: T,
    ) -> [T; N] {
        let level: [T; N] = level(decay * length);
        let mut offset = self.offset * length;
        for (moment, level) in moments.iter_mut().zip(level) {
            *moment = self.decay * *moment + offset * level;
            offset *= length;
        }
        moments
    }

    /// First the other one, then this one.
    #[inline(always)]
    pub(super) fn after(self, first: Self) -> Self {
        Self { decay: self.decay * first.decay, offset: self.of(first.offset) }
    }
}

/// z = base + rise t φ1(exponent t) at the part t of the width, counted from the newest bristle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Segment<T> {
    pub(super) width: T,
    pub(super) base: T,
    pub(super) rise: T,
    pub(super) exponent: T,
}

impl<T: Scalar> Segment<T> {
    /// A straight line from the deflection of the newest bristle to that of the oldest.
    pub(super) fn straight(width: T, newest: T, oldest: T) -> Self {
        Self { width, base: newest, rise: oldest - newest, exponent: T::zero() }
    }

    /// The deflection at a part of the width.
    pub(super) fn at(&self, part: T) -> T {
        self.base + self.rise * part * phi1(self.exponent * part)
    }

    /// The segment after a step.
    #[inline(always)]
    pub(super) fn mapped(self, map: Map<T>) -> Self {
        Self { base: map.of(self.base), rise: map.decay * self.rise, ..self }
    }

    /// ∫ sᵏ e^(−as) z ds over the newest part of the width, s counted from the newest bristle.
    #[inline]
    pub(super) fn moments<const N: usize>(&self, part: T, decay: T) -> [T; N] {
        let length = self.width * part;
        let alpha = decay * length;
        let mut moments: [T; N] = rising(alpha, self.exponent * part);
        let level: [T; N] = level(alpha);
        let (rise, mut power) = (self.rise * part, length);
        for (moment, level) in moments.iter_mut().zip(level) {
            *moment = power * (self.base * level + rise * *moment);
            power *= length;
        }
        moments
    }

    /// This segment and a newer one before it as one straight line, which has the same integral and the
    /// same first moment unless that would take it beyond the deflections of both.
    pub(super) fn merged_with(&self, newer: &Self) -> Self {
        let width = newer.width + self.width;
        if !(width > T::zero()) {
            return *self;
        }
        let [new0, new1] = newer.moments(T::one(), T::zero());
        let [old0, old1] = self.moments(T::one(), T::zero());
        let mean = (new0 + old0) / width;
        // First moment about the middle, over width²/12.
        let first = new1 + old1 + newer.width * old0;
        let tilt = (first / (width * width) - mean * lit(0.5)) * lit(12.0);
        let ends = [newer.base, newer.at(T::one()), self.base, self.at(T::one())];
        let (mut least, mut most) = (ends[0], ends[0]);
        for end in ends {
            least = if end < least { end } else { least };
            most = if end > most { end } else { most };
        }
        let room = if most - mean < mean - least { most - mean } else { mean - least };
        let room = if room > T::zero() { room } else { T::zero() };
        let half = lit::<T>(0.5) * tilt;
        let half = if half > room {
            room
        } else if half < -room {
            -room
        } else {
            half
        };
        Self::straight(width, mean - half, mean + half)
    }
}

/// ψ_k(α), which without decay is 1/(k + 1).
#[inline(always)]
pub(super) fn level<T: Scalar, const N: usize>(alpha: T) -> [T; N] {
    if is_zero(alpha) {
        core::array::from_fn(|k| lit(1.0 / (k + 1) as f64))
    } else {
        decaying(alpha)
    }
}

/// ∫₀^c sᵏ e^(−as) ds.
#[inline(always)]
pub(super) fn level_moments<T: Scalar, const N: usize>(length: T, decay: T) -> [T; N] {
    let everywhere = Map { decay: T::zero(), offset: T::one() };
    everywhere.of_moments([T::zero(); N], length, decay)
}

/// Moments ∫ ξᵏ e^(−aξ) … dξ of what has moved on by a distance.
#[inline(always)]
pub(super) fn shifted<T: Scalar, const N: usize>(
    mut moments: [T; N],
    distance: T,
    decay: T,
) -> [T; N] {
    for first in 1..N {
        for k in (first..N).rev() {
            moments[k] += distance * moments[k - 1];
        }
    }
    if !is_zero(decay) {
        let weight = (-decay * distance).exp();
        for moment in &mut moments {
            *moment *= weight;
        }
    }
    moments
}
