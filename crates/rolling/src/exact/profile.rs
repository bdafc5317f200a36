//! Part of a deflection profile: the bristles that entered during one step.

use crate::moments::{decaying, phi1, rising};
use bristle::Scalar;
use bristle::scalar::{is_zero, lit};

/// What a step makes of every bristle that was there at its beginning: z ← decay·z + offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Map<T> {
    pub(crate) decay: T,
    pub(crate) offset: T,
}

impl<T: Scalar> Map<T> {
    pub(crate) fn identity() -> Self {
        Self { decay: T::one(), offset: T::zero() }
    }

    #[inline(always)]
    pub(crate) fn of(self, deflection: T) -> T {
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
    pub(crate) fn after(self, first: Self) -> Self {
        Self { decay: self.decay * first.decay, offset: self.of(first.offset) }
    }
}

/// z = base + rise t φ1(exponent t) + bulge t (1 − t) at the part t of the width, counted from the
/// newest bristle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Profile<T> {
    pub(super) width: T,
    pub(super) base: T,
    pub(super) rise: T,
    pub(super) exponent: T,
    /// What a change of the velocities during the step makes of the profile; zero for held ones.
    pub(super) bulge: T,
}

/// An exponent of a inflow profile beyond which nothing but its stationary end is left.
const STEEP: f64 = 1e20;

impl<T: Scalar> Profile<T> {
    /// The bristles that entered while λ and u = r v \[m/s\] were held for some time \[s\].
    #[inline(always)]
    pub(super) fn inflow(width: T, relaxation: T, drive: T, time: T) -> Self {
        let (exponent, zero) = (relaxation * time, T::zero());
        if exponent < lit(STEEP) {
            return Self { width, base: zero, rise: drive * time, exponent, bulge: zero };
        }
        // This profile to the last digit, in numbers that do not overflow.
        let rise = drive / relaxation * lit(STEEP);
        Self { width, base: zero, rise, exponent: lit(STEEP), bulge: zero }
    }

    /// A straight line from the deflection of the newest bristle to that of the oldest.
    pub(super) fn straight(width: T, newest: T, oldest: T) -> Self {
        let zero = T::zero();
        Self { width, base: newest, rise: oldest - newest, exponent: zero, bulge: zero }
    }

    /// The deflection at a part of the width.
    pub(super) fn at(&self, part: T) -> T {
        let bulge = self.bulge * (part * (T::one() - part));
        self.base + self.rise * part * phi1(self.exponent * part) + bulge
    }

    /// No deflection of the newest part of the width is outside of this.
    pub(super) fn range(&self, part: T) -> (T, T) {
        let (end, bulge) = (Self { bulge: T::zero(), ..*self }.at(part), self.bulge * lit(0.25));
        let low = self.base.smaller(end) + bulge.smaller(T::zero());
        (low, self.base.larger(end) + bulge.larger(T::zero()))
    }

    /// The segment after a step.
    #[inline(always)]
    pub(super) fn mapped(self, map: Map<T>) -> Self {
        let (rise, bulge) = (map.decay * self.rise, map.decay * self.bulge);
        Self { base: map.of(self.base), rise, bulge, ..self }
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
        if !is_zero(self.bulge) {
            let (near, mut power) = (self.bulge * part, length);
            let bulges: [T; N] = bulges(alpha, part);
            for (moment, bulge) in moments.iter_mut().zip(bulges) {
                *moment += power * near * bulge;
                power *= length;
            }
        }
        moments
    }

    /// This segment and a newer one before it as one straight line: the closest to both in the
    /// mean square under the weight e^(−as), unless that would take it beyond the deflections of
    /// both; then a less inclined one. It has the same ∫ e^(−as) z ds, unless cut back the same
    /// first moment, and never more energy ∫ e^(−as) z² ds.
    pub(super) fn merged_with(&self, newer: &Self, decay: T) -> Self {
        let width = newer.width + self.width;
        if !(width > T::zero()) {
            return *self;
        }
        // In parts of the new width: its powers would underflow.
        let of_unit = |segment: &Self| {
            let unit = Self { width: T::one(), ..*segment };
            unit.moments::<2>(T::one(), decay * segment.width)
        };
        let ([new0, new1], [old0, old1]) = (of_unit(newer), of_unit(self));
        let (new, old) = (newer.width / width, self.width / width);
        let left = old * (-decay * newer.width).exp();
        let integral = new * new0 + left * old0;
        let first = new * new * new1 + left * (old * old1 + new * old0);
        let [weight0, weight1, weight2]: [T; 3] = level(decay * width);
        let (mean, middle) = (integral / weight0, weight1 / weight0);
        let tilt = (first - middle * integral) / (weight2 - middle * weight1);

        let ends = [newer.base, newer.at(T::one()), self.base, self.at(T::one())];
        let (least, most) = ends
            .into_iter()
            .fold((mean, mean), |(least, most), end| (least.smaller(end), most.larger(end)));
        let (below, above) = (mean - least, most - mean);
        let rest = T::one() - middle;
        let rising = (below / middle).smaller(above / rest);
        let falling = (above / middle).smaller(below / rest);
        let tilt = tilt.smaller(rising).larger(-falling);
        Self::straight(width, mean - middle * tilt, mean + rest * tilt)
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

/// ∫₀¹ tᵏ (t − part t²) e^(−αt) dt, for up to the 12 coefficients that a pressure has.
#[inline]
fn bulges<T: Scalar, const N: usize>(alpha: T, part: T) -> [T; N] {
    fn of<T: Scalar, const M: usize, const N: usize>(psi: [T; M], part: T) -> [T; N] {
        core::array::from_fn(|k| match psi.get(k + 1..k + 3) {
            Some(&[near, far]) => near - part * far,
            _ => T::zero(),
        })
    }
    if N <= 2 { of(level::<T, 4>(alpha), part) } else { of(level::<T, 14>(alpha), part) }
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

#[cfg(test)]
mod tests {
    extern crate std;
    use super::Profile;

    #[test]
    fn merged_segments_keep_their_integral_and_stay_within_their_ends() {
        let mut seed = 3_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut tilted = [0; 2];
        for number in 0..20_000 {
            let decay = [0.0, 0.7, -0.4, 5.0][number % 4];
            let mut draw = || Profile {
                base: random() - 0.5,
                rise: 10.0 * (random() - 0.5),
                exponent: 10.0 * random(),
                ..Profile::straight(random(), 0.0, 0.0)
            };
            let (old, new) = (draw(), draw());
            let merged = old.merged_with(&new, decay);
            let ends = [new.base, new.at(1.0), old.base, old.at(1.0)];
            let low = ends.iter().copied().fold(f64::INFINITY, f64::min);
            let high = ends.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            for end in [merged.base, merged.at(1.0)] {
                // A few roundings of deflections up to 5.
                assert!(end >= low - 1e-14 && end <= high + 1e-14, "{merged:?} {ends:?}");
            }
            let integral = |segment: &Profile<f64>| segment.moments::<2>(1.0, decay);
            // Of all places in the patch the weight differs by a factor only.
            let shift = (-decay * new.width).exp();
            let (new0, old0) = (integral(&new), integral(&old).map(|moment| shift * moment));
            let [zeroth, first] = integral(&merged);
            assert!((zeroth - new0[0] - old0[0]).abs() < 1e-14);
            // The midpoint rule over 256 panels misses less than 1e-4 of these profiles.
            let energy = |segment: &Profile<f64>| -> f64 {
                let panels = 256;
                let part = |number: i32| (f64::from(number) + 0.5) / f64::from(panels);
                let square = |at: f64| {
                    segment.at(at).powi(2) * (-decay * segment.width * at).exp() * segment.width
                };
                (0..panels).map(|number| square(part(number))).sum::<f64>() / f64::from(panels)
            };
            if number % 40 < 4 {
                let (before, after) = (energy(&new) + shift * energy(&old), energy(&merged));
                assert!(after <= before + 1e-4 * before.max(0.1), "{after} of {before}");
            }
            // The first moment too, unless an end would have gone beyond.
            let free = (merged.base - low).min(high - merged.base) > 1e-9
                && (merged.at(1.0) - low).min(high - merged.at(1.0)) > 1e-9;
            tilted[usize::from(free)] += 1;
            let kept = (first - new0[1] - old0[1] - new.width * old0[0]).abs();
            assert!(!free || kept < 1e-13, "{kept:e}");
        }
        // Both happen.
        assert!(tilted.iter().all(|&count| count > 1000), "{tilted:?}");
    }

    #[test]
    fn a_newborn_profile_of_any_steepness_is_that_of_full_sliding_without_overflow() {
        // λh from what the formula takes to what overflows; z_ss = u/λ = 2 in all of them.
        for (relaxation, time) in [
            (1e10, 9e9),
            (1e10, 1.1e10),
            (1e151, 1e150),
            (1e160, 1e150),
            (1e300, 1e300),
            (5e307, 1e100),
        ] {
            let width = 0.25;
            let segment = Profile::inflow(width, relaxation, 2.0 * relaxation, time);
            let name = std::format!("λ = {relaxation:e}, h = {time:e}: {segment:?}");
            assert_eq!((segment.at(0.0), segment.width), (0.0, width), "{name}");
            for part in [1e-3_f64, 0.5, 1.0] {
                // Beyond a layer of 1e-18 nothing but a few roundings is missing.
                assert!((segment.at(part) - 2.0).abs() < 2e-15, "{name}");
                for decay in [0.0_f64, 0.7] {
                    // ∫ sᵏ 2 e^(−as) ds over the part: the layer takes 1.1e-20/part of it, 1e-17.
                    let moments = segment.moments::<3>(part, decay);
                    let length = width * part;
                    let level = super::level_moments::<f64, 3>(length, decay);
                    for (got, level) in moments.into_iter().zip(level) {
                        assert!((got / (2.0 * level) - 1.0).abs() < 3e-15, "{name}: {got:e}");
                    }
                }
            }
        }
        // Nothing drives it.
        let still = Profile::inflow(0.25, 1e200, 0.0, 1e200);
        assert_eq!((still.at(0.5), still.moments::<2>(1.0, 0.7)), (0.0, [0.0; 2]));
    }
}
