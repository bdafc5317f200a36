//! A bristle dragged at a given velocity: ż = h(z, v(t)).

use nalgebra::SVector;

use crate::ode::{Linearisation, System};
use crate::rheology::{Deflection, States};
use crate::scalar::lit;
use crate::signal::Signal;
use crate::{Branch, Bristle, Contact, Scalar};

/// A bristle dragged at a given velocity. State: its deflection \[m\], or the stretches of its
/// springs.
///
/// ```
/// use bristle::ode::{self, Output};
/// use bristle::scene::PrescribedVelocity;
/// use bristle::signal::{Sine, SineParameters};
/// use bristle::{Bristle, FrBd, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::{GeneralisedMaxwell, ZenerParameters};
/// use bristle::nalgebra::Vector2;
///
/// let bristle = GeneralisedMaxwell::zener(ZenerParameters {
///     static_stiffness: 1e4,
///     relaxing_stiffness: 2e4,
///     series_damping: 100.0,
/// })?;
/// let velocity = SineParameters { mean: 0.0, amplitude: 0.01, frequency: 1.0, phase: 0.0 };
/// let friction = FrBd::new(Stribeck::new(paper::STICK_SLIP_CURVE)?, bristle);
/// let scene = PrescribedVelocity::new(friction.under_load(1.0)?, Sine::new(velocity)?);
/// let run = ode::solve(&scene, 0.0..1.0, Vector2::zeros(), 1e-6, Output::Uniform(101))?;
/// assert!(run.iter().all(|(time, state)| scene.friction_force(time, state).abs() <= 1.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct PrescribedVelocity<T: Scalar, M, V> {
    contact: Contact<T, M>,
    velocity: V,
}

impl<T: Scalar, M: Bristle<T>, V: Signal<T>> PrescribedVelocity<T, M, V> {
    /// A contact that is dragged at a sliding velocity v(t) [m/s].
    pub fn new(contact: Contact<T, M>, velocity: V) -> Self {
        Self { contact, velocity }
    }

    /// The sliding velocity [m/s] at a time.
    pub fn velocity(&self, time: T) -> T {
        self.velocity.value(time)
    }

    /// The friction force \[N\] at a time and state.
    pub fn friction_force<const N: usize>(&self, time: T, state: &SVector<T, N>) -> T
    where
        M::Deflection: States<T, N>,
    {
        self.contact.force(self.velocity.value(time), M::Deflection::from_states(state))
    }

    /// The state in which the bristle has adapted to the velocity at a time.
    pub fn stationary<const N: usize>(&self, time: T) -> SVector<T, N>
    where
        M::Deflection: States<T, N>,
    {
        self.contact.stationary(self.velocity.value(time)).states()
    }

    /// A typical magnitude of each state, for tolerances.
    pub fn scales<const N: usize>(&self) -> SVector<T, N>
    where
        M::Deflection: States<T, N>,
    {
        // At rest; of several springs that of a pull that none had time to relax from.
        let model = self.contact.model();
        let limits = model.limits(T::zero());
        let together = M::Deflection::fill(T::one()).inner_product(model.storage_stiffness());
        let pulled = || limits.coefficient.map(|coefficient| coefficient / together);
        let typical = limits.deflection.or_else(pulled).unwrap_or_else(|| lit(1e-6));
        SVector::repeat(typical)
    }
}

impl<T, M, V, const N: usize> System<T, N> for PrescribedVelocity<T, M, V>
where
    T: Scalar,
    M: Bristle<T>,
    M::Deflection: States<T, N>,
    V: Signal<T>,
{
    #[inline]
    fn rate(&self, time: T, state: &SVector<T, N>, [branch]: [Branch; 1]) -> SVector<T, N> {
        let deflection = M::Deflection::from_states(state);
        self.contact.rate(branch.of(self.velocity.value(time)), deflection).states()
    }

    #[inline]
    fn sliding_velocities(&self, time: T, _state: &SVector<T, N>) -> [T; 1] {
        [self.velocity.value(time)]
    }

    fn linearised(
        &self,
        time: T,
        state: &SVector<T, N>,
        [branch]: [Branch; 1],
    ) -> Option<Linearisation<T, N>> {
        let (velocity, acceleration) = self.velocity.value_and_rate(time);
        let deflection = M::Deflection::from_states(state);
        let friction = self.contact.linearised(branch.of(velocity), deflection);
        Some(Linearisation {
            rate: friction.rate.states(),
            by_state: M::Deflection::matrix(friction.rate_by_deflection),
            by_time: (friction.rate_by_velocity * acceleration).states(),
        })
    }

    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        self.velocity.next_kink(time, towards)
    }

    #[inline]
    fn switching_functions(
        &self,
        time: T,
        state: &SVector<T, N>,
        [branch]: [Branch; 1],
        tell: &mut dyn FnMut(T),
    ) {
        let sliding = branch.of(self.velocity.value(time));
        self.contact.switching_function(sliding, M::Deflection::from_states(state)).map(tell);
    }

    fn longest_step(&self) -> Option<T> {
        self.velocity.longest_step()
    }

    fn scales(&self) -> SVector<T, N> {
        PrescribedVelocity::scales(self)
    }
}
