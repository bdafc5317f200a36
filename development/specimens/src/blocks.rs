//! A system of any number of states, of a fixed size and of one known at run time.

use bristle::ode::{System, dynamic};
use bristle::{Branch, Scalar};
use nalgebra::SVector;

use crate::lit;

/// Blocks on a belt under Dahl's friction, each on a spring to the one before, the first driven.
#[derive(Debug)]
pub struct Blocks(pub usize);

impl Blocks {
    fn rate<T: Scalar>(&self, time: T, state: &[T], branches: &[Branch], rate: &mut [T]) {
        let at = |i: usize| state.get(3 * i).copied();
        for (i, branch) in branches.iter().enumerate() {
            let (place, velocity, z) = (state[3 * i], state[3 * i + 1], state[3 * i + 2]);
            let before = if i == 0 { time.sin() * lit(0.5) } else { at(i - 1).unwrap_or(place) };
            let pull = before + at(i + 1).unwrap_or(place) - place * lit(2.0);
            let slip = branch.of(velocity - lit(0.1));
            rate[3 * i] = velocity;
            rate[3 * i + 1] = pull * lit(9.0) - z * lit(500.0);
            rate[3 * i + 2] = slip.velocity() - slip.speed() * z * lit(1000.0);
        }
    }

    fn velocities<T: Scalar>(&self, state: &[T], velocities: &mut [T]) {
        for (velocity, block) in velocities.iter_mut().zip(state.chunks(3)) {
            *velocity = block[1] - lit(0.1);
        }
    }

    /// A typical magnitude of a state.
    pub fn scale<T: Scalar>(i: usize) -> T {
        lit([0.1, 0.1, 1e-3][i % 3])
    }
}

/// K of them.
#[derive(Debug)]
pub struct Few<const K: usize>;

impl<T: Scalar, const N: usize, const K: usize> System<T, N, K> for Few<K> {
    fn rate(&self, time: T, state: &SVector<T, N>, branches: [Branch; K]) -> SVector<T, N> {
        let mut rate = SVector::<T, N>::zeros();
        Blocks(K).rate(time, state.as_slice(), &branches, rate.as_mut_slice());
        rate
    }

    fn sliding_velocities(&self, _: T, state: &SVector<T, N>) -> [T; K] {
        let mut velocities = [T::zero(); K];
        Blocks(K).velocities(state.as_slice(), &mut velocities);
        velocities
    }

    fn scales(&self) -> SVector<T, N> {
        SVector::from_fn(|i, _| Blocks::scale(i))
    }
}

impl<T: Scalar> dynamic::System<T> for Blocks {
    fn states(&self) -> usize {
        3 * self.0
    }

    fn contacts(&self) -> usize {
        self.0
    }

    fn rate(&self, time: T, state: &[T], branches: &[Branch], rate: &mut [T]) {
        self.rate(time, state, branches, rate);
    }

    fn sliding_velocities(&self, _: T, state: &[T], velocities: &mut [T]) {
        self.velocities(state, velocities);
    }

    fn scales(&self, scales: &mut [T]) {
        scales.iter_mut().enumerate().for_each(|(i, scale)| *scale = Self::scale(i));
    }
}
