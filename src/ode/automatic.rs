//! The default: an explicit method while the solution is what limits the step, a Rosenbrock method
//! while stability would, switching in mid-run and both ways.
//!
//! Stick and slip differ: a stuck mass is stiff (its fast swing on the bristles has died out, yet
//! would limit an explicit step), breakaway and arrest are not.
//!
//! An explicit step is held by stability if h|λ| is near the limit of its stability region; |λ| is
//! read off its last two stages, |f(x₁) − f(x̃)|/|x₁ − x̃| (Hairer, Nørsett, Wanner, below). In a
//! Rosenbrock step the Jacobian J is at hand, and its spectral radius follows from traces of powers,
//!
//! ρ ≈ max(|tr J¹⁶|^(1/16), |tr J³²|^(1/32)),
//!
//! which no choice of units can mislead, and no complex pair: where one trace vanishes the other does
//! not.
//!
//! Source of the first: E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", 2nd
//! edition (Springer, 1996), section IV.2.

use nalgebra::{SMatrix, SVector};

use super::curve::Curve;
use super::method::{Attempt, Embedded, Field, Method, Point};
use super::{DormandPrince, DormandPrince8, Rodas4, Rodas5P};
use crate::Scalar;
use crate::bounds::smaller;
use crate::scalar::{lit, to_f64};
use crate::stability::Scheme;

/// The method behind [`solve`](super::solve): an explicit and a Rosenbrock method that take turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Automatic {
    pair: Pair,
}

/// Which two methods take turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Pair {
    /// Dormand–Prince 5 and Rodas4.
    Low,
    /// Dormand–Prince 8 and Rodas5P.
    High,
}

impl Automatic {
    /// [`DormandPrince`] and [`Rodas4`], for loose tolerances.
    pub const LOW_ORDER: Self = Self { pair: Pair::Low };

    /// [`DormandPrince8`] and [`Rodas5P`], for all others.
    pub const HIGH_ORDER: Self = Self { pair: Pair::High };
}

/// What [`Automatic`] keeps for a run.
#[derive(Debug, Clone)]
pub struct Memory<T: Scalar, const N: usize> {
    turn: Turn,
    /// Accepted steps since the last change of turns.
    since: u32,
    /// Steps in a row that spoke for a change.
    votes: u32,
    /// Votes that a change to the explicit method needs: more after it did not last.
    needed: u32,
    five: super::dormand_prince::Stages<T, N>,
    eight: super::dormand_prince8::Stages<T, N>,
    rodas4: super::rosenbrock::Stages<T, N, 6>,
    rodas5: super::rosenbrock::Stages<T, N, 8>,
}

/// Whose turn it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Turn {
    Explicit,
    Implicit,
}

/// Stability limits of h|λ| on the negative real axis, of orders 5 and 8 ([`stability`](crate::stability)).
const LIMITS: (f64, f64) = (3.3, 6.39);

/// An explicit step beyond this part of its limit is held by stability.
const HELD: f64 = 0.6;

/// Below this h ρ of a Rosenbrock step an explicit method is cheaper: it could take steps of
/// 0.8 of its limit, or two to three times as long if it is not held, at about the same cost.
const EASY: f64 = 2.5;

/// The estimate of a Rosenbrock step is taken so many times. The slow creep towards breakaway decides
/// when it comes, and a mass that sticks does little else. On the stick-slip scene of the
/// work-precision charts this cost up to a fifth more evaluations, and divided the error by a hundred at
/// a tolerance of 10⁻⁴, by ten at 10⁻⁶ and by nothing at 10⁻⁹.
const CARE: f64 = 5.0;

/// Votes for a change.
const VOTES: u32 = 2;

/// Most votes a change to the explicit method is made to need.
const MOST_VOTES: u32 = 32;

/// An explicit turn of fewer steps was not worth the change.
const SHORT: u32 = 12;

impl Embedded for Automatic {}

impl<T: Scalar, const N: usize> Method<T, N> for Automatic {
    type Memory = Memory<T, N>;

    fn scheme(&self) -> Option<Scheme> {
        // With fixed steps it stays with its Rosenbrock method.
        Some(Scheme::Rosenbrock)
    }

    fn memory(&self) -> Self::Memory {
        Memory {
            turn: Turn::Implicit,
            since: 0,
            votes: 0,
            needed: VOTES,
            five: Method::<T, N>::memory(&DormandPrince),
            eight: Method::<T, N>::memory(&DormandPrince8),
            rodas4: Method::<T, N>::memory(&Rodas4),
            rodas5: Method::<T, N>::memory(&Rodas5P),
        }
    }

    fn begin<F: Field<T, N>>(
        &self,
        memory: &mut Self::Memory,
        field: &mut F,
        point: &mut Point<T, N>,
    ) {
        match (memory.turn, self.pair) {
            (Turn::Explicit, Pair::Low) => DormandPrince.begin(&mut memory.five, field, point),
            (Turn::Explicit, Pair::High) => DormandPrince8.begin(&mut memory.eight, field, point),
            (Turn::Implicit, Pair::Low) => memory.rodas4.begin(field, point),
            (Turn::Implicit, Pair::High) => memory.rodas5.begin(field, point),
        }
    }

    #[inline]
    fn attempt<F: Field<T, N>>(
        &self,
        memory: &mut Self::Memory,
        field: &mut F,
        from: &Point<T, N>,
        step: T,
    ) -> Attempt<T, N> {
        let mut attempt = match (memory.turn, self.pair) {
            (Turn::Explicit, Pair::Low) => {
                return DormandPrince.attempt(&mut memory.five, field, from, step);
            }
            (Turn::Explicit, Pair::High) => {
                return DormandPrince8.attempt(&mut memory.eight, field, from, step);
            }
            (Turn::Implicit, Pair::Low) => Rodas4.attempt(&mut memory.rodas4, field, from, step),
            (Turn::Implicit, Pair::High) => Rodas5P.attempt(&mut memory.rodas5, field, from, step),
        };
        attempt.error *= lit::<T>(CARE);
        attempt
    }

    #[inline]
    fn arrive<F: Field<T, N>>(
        &self,
        memory: &mut Self::Memory,
        field: &mut F,
        end: &mut Point<T, N>,
    ) {
        match (memory.turn, self.pair) {
            (Turn::Explicit, Pair::Low) => DormandPrince.arrive(&mut memory.five, field, end),
            (Turn::Explicit, Pair::High) => DormandPrince8.arrive(&mut memory.eight, field, end),
            (Turn::Implicit, Pair::Low) => memory.rodas4.arrive(field, end),
            (Turn::Implicit, Pair::High) => memory.rodas5.arrive(field, end),
        }
    }

    fn curve<F: Field<T, N>>(
        &self,
        memory: &Self::Memory,
        field: &mut F,
        from: &Point<T, N>,
        end: &Point<T, N>,
    ) -> Curve<T, N> {
        match (memory.turn, self.pair) {
            (Turn::Explicit, Pair::Low) => DormandPrince.curve(&memory.five, field, from, end),
            (Turn::Explicit, Pair::High) => DormandPrince8.curve(&memory.eight, field, from, end),
            (Turn::Implicit, Pair::Low) => Rodas4.curve(&memory.rodas4, field, from, end),
            (Turn::Implicit, Pair::High) => Rodas5P.curve(&memory.rodas5, field, from, end),
        }
    }

    fn accepted<F: Field<T, N>>(
        &self,
        memory: &mut Self::Memory,
        field: &mut F,
        from: &Point<T, N>,
        end: &Point<T, N>,
        proposed: Option<T>,
    ) -> Option<T> {
        memory.since += 1;
        let step = (end.time - from.time).abs();
        let limit: T = lit(match self.pair {
            Pair::Low => LIMITS.0,
            Pair::High => LIMITS.1,
        });
        match memory.turn {
            Turn::Explicit => {
                if self.pair == Pair::High {
                    DormandPrince8.accepted(&mut memory.eight, field, from, end, proposed);
                }
                let (ahead, beside) = match self.pair {
                    Pair::Low => {
                        (memory.five.k[6] - memory.five.k[5], end.state - memory.five.sixth)
                    }
                    Pair::High => {
                        (memory.eight.k[12] - memory.eight.k[11], end.state - memory.eight.twelfth)
                    }
                };
                let held = held(&ahead, &beside, &end.scale, step, limit * lit(HELD));
                memory.votes = if held { memory.votes + 1 } else { 0 };
                if memory.votes < VOTES {
                    return proposed;
                }
                let lasted = memory.since > SHORT;
                memory.needed = if lasted { VOTES } else { (memory.needed * 2).min(MOST_VOTES) };
                memory.change(Turn::Implicit);
                let mut end = *end;
                self.begin(memory, field, &mut end);
                proposed
            }
            Turn::Implicit => {
                let jacobian = match self.pair {
                    Pair::Low => {
                        memory.rodas4.tangent = memory.rodas4.at_end;
                        memory.rodas4.tangent.by_state
                    }
                    Pair::High => {
                        memory.rodas5.tangent = memory.rodas5.at_end;
                        memory.rodas5.tangent.by_state
                    }
                };
                // Fixed steps stay with the method that bears any length.
                let proposed = proposed?;
                let reach = spectral_radius(&(jacobian * step));
                memory.votes = if reach < EASY { memory.votes + 1 } else { 0 };
                if memory.votes < memory.needed {
                    return Some(proposed);
                }
                memory.change(Turn::Explicit);
                let most = step * limit * lit(0.8 / if reach > 0.01 { reach } else { 0.01 });
                Some(smaller(proposed, most))
            }
        }
    }
}

impl<T: Scalar, const N: usize> Memory<T, N> {
    fn change(&mut self, turn: Turn) {
        self.eight.forget();
        self.turn = turn;
        self.since = 0;
        self.votes = 0;
    }
}

/// Whether h|λ| exceeds a limit, from a difference of rates and that of the states they belong to.
fn held<T: Scalar, const N: usize>(
    rates: &SVector<T, N>,
    states: &SVector<T, N>,
    scale: &SVector<T, N>,
    step: T,
    limit: T,
) -> bool {
    let (mut over, mut under) = (T::zero(), T::zero());
    for i in 0..N {
        let inverse = T::one() / scale[i];
        let (rate, state) = (rates[i] * inverse, states[i] * inverse);
        over += rate * rate;
        under += state * state;
    }
    // States that hardly differ tell nothing but their rounding.
    under > lit(1e-6) && over * step * step > under * limit * limit
}

/// The greatest magnitude of an eigenvalue, within some ten percent; infinite beyond 10²⁰ or so.
fn spectral_radius<T: Scalar, const N: usize>(matrix: &SMatrix<T, N, N>) -> f64 {
    let mut power = *matrix;
    for _ in 0..4 {
        power = power * power;
    }
    let (mut sixteenth, mut thirty_second) = (T::zero(), T::zero());
    for i in 0..N {
        sixteenth += power[(i, i)];
        for j in 0..N {
            thirty_second += power[(i, j)] * power[(j, i)];
        }
    }
    let root = |value: T, exponent: f64| {
        let size = to_f64(value).abs();
        if size.is_finite() {
            super::controller::rough_power(size, exponent)
        } else {
            f64::INFINITY
        }
    };
    let (a, b) = (root(sixteenth, 1.0 / 16.0), root(thirty_second, 1.0 / 32.0));
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::spectral_radius;
    use nalgebra::{Matrix2, Matrix3};

    #[test]
    fn the_spectral_radius_is_found_in_any_units() {
        let close =
            |found: f64, want: f64| assert!((found / want - 1.0).abs() < 0.12, "{found} {want}");
        close(spectral_radius(&Matrix3::from_diagonal(&[-0.3, 2.0, -5.0].into())), 5.0);
        // Complex pairs of every direction.
        for i in 0..40 {
            let angle = 0.04 * f64::from(i);
            let (sin, cos) = angle.sin_cos();
            close(spectral_radius(&(Matrix2::new(cos, -sin, sin, cos) * 3.0)), 3.0);
        }
        // The same oscillator, in metres and in nanometres.
        let oscillator = |unit: f64| Matrix2::new(0.0, 1.0 / unit, -1e4 * unit, -64.5);
        close(spectral_radius(&oscillator(1.0)), 100.0);
        close(spectral_radius(&oscillator(1e-9)), 100.0);
        assert!(spectral_radius(&Matrix2::<f32>::new(1e30, 0.0, 0.0, 1.0)).is_infinite());
    }
}
