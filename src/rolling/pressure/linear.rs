//! Integrals over a pressure that is linear from knot to knot.
//!
//! On a piece from ξ = a of width w, with p = p₀(1 − t) + p₁ t at ξ = a + w t,
//!
//! ∫ p e^(−sξ) dξ = w e^(−sa) (p₀(ψ₀ − ψ₁) + p₁ψ₁)(sw),
//! ∫ p (1 − e^(−κξ)) dξ = w ((1 − e^(−κa))(p₀ + p₁)/2 + e^(−κa) κw (p₀(χ₀ − χ₁) + p₁χ₁)(0, κw)),
//!
//! sums of positive terms. Knots may coincide: the pressure jumps there.

use nalgebra::{Complex, ComplexField};

use super::PressureKnot;
use crate::Scalar;
use crate::rolling::moments::{complex_decaying, decaying, rising};
use crate::scalar::lit;

/// Start, width and the two pressures of each piece that has a width.
fn pieces<T: Scalar>(knots: &[PressureKnot<T>]) -> impl Iterator<Item = (T, T, T, T)> + '_ {
    knots.windows(2).filter_map(|pair| match pair {
        [a, b] if b.place > a.place => Some((a.place, b.place - a.place, a.pressure, b.pressure)),
        _ => None,
    })
}

pub(super) fn at_and_slope<T: Scalar>(knots: &[PressureKnot<T>], place: T) -> (T, T) {
    let mut answer = (T::zero(), T::zero());
    for (from, width, start, end) in pieces(knots) {
        if !(place < from) || is_first(from) {
            let slope = (end - start) / width;
            let t = (place - from) / width;
            answer = (start * (T::one() - t) + end * t, slope);
        }
    }
    answer
}

fn is_first<T: Scalar>(from: T) -> bool {
    !(from > T::zero())
}

pub(super) fn next_knot<T: Scalar>(knots: &[PressureKnot<T>], place: T) -> Option<T> {
    knots.iter().map(|knot| knot.place).find(|&knot| knot > place && knot < T::one())
}

pub(super) fn total<T: Scalar>(knots: &[PressureKnot<T>]) -> T {
    pieces(knots)
        .fold(T::zero(), |sum, (_, width, start, end)| sum + width * (start + end) * lit(0.5))
}

pub(super) fn rise<T: Scalar>(knots: &[PressureKnot<T>], decay: T) -> T {
    pieces(knots).fold(T::zero(), |sum, (from, width, start, end)| {
        let steepness = decay * width;
        // Of pieces that the profile has settled before, or at once.
        let settled = width * (start + end) * lit(0.5);
        if !steepness.is_finite() && steepness > T::zero() {
            return sum + settled;
        }
        let left = (-decay * from).exp();
        let [flat, tilted] = rising::<T, 2>(T::zero(), steepness);
        let within = start * (flat - tilted) + end * tilted;
        sum - (-decay * from).exp_m1() * settled + left * width * steepness * within
    })
}

pub(super) fn remaining<T: Scalar>(knots: &[PressureKnot<T>], decay: T) -> T {
    if !decay.is_finite() && decay > T::zero() {
        return T::zero();
    }
    pieces(knots).fold(T::zero(), |sum, (from, width, start, end)| {
        let [flat, tilted] = decaying::<T, 2>(decay * width);
        let within = start * (flat - tilted) + end * tilted;
        sum + (-decay * from).exp() * width * within
    })
}

pub(super) fn lever<T: Scalar>(knots: &[PressureKnot<T>], decay: T) -> T {
    if !decay.is_finite() && decay > T::zero() {
        return T::zero();
    }
    pieces(knots).fold(T::zero(), |sum, (from, width, start, end)| {
        let [flat, tilted, bent] = decaying::<T, 3>(decay * width);
        let within = start * (flat - tilted) + end * tilted;
        let moment = start * (tilted - bent) + end * bent;
        sum + (-decay * from).exp() * width * (from * within + width * moment)
    })
}

pub(super) fn transform<T: Scalar>(knots: &[PressureKnot<T>], rate: Complex<T>) -> Complex<T> {
    let zero = Complex::new(T::zero(), T::zero());
    pieces(knots).fold(zero, |sum, (from, width, start, end)| {
        let [flat, tilted] = complex_decaying::<T, 2>(rate.scale(width));
        let within = (flat - tilted).scale(start) + tilted.scale(end);
        sum + ((-rate.scale(from)).exp() * within).scale(width)
    })
}

/// The closed forms as a [`Pressure`](super::Pressure)'s methods, for a type with `knots()`.
macro_rules! linear_pressure {
    () => {
        fn at_and_slope(&self, place: T) -> (T, T) {
            super::linear::at_and_slope(&self.knots, place)
        }

        fn next_knot(&self, place: T) -> Option<T> {
            super::linear::next_knot(&self.knots, place)
        }

        fn total(&self) -> T {
            super::linear::total(&self.knots)
        }

        fn rise(&self, decay: T) -> T {
            super::linear::rise(&self.knots, decay)
        }

        fn remaining(&self, decay: T) -> T {
            super::linear::remaining(&self.knots, decay)
        }

        fn lever(&self, decay: T) -> T {
            super::linear::lever(&self.knots, decay)
        }

        fn transform(&self, rate: nalgebra::Complex<T>) -> nalgebra::Complex<T> {
            super::linear::transform(&self.knots, rate)
        }
    };
}
pub(super) use linear_pressure;
