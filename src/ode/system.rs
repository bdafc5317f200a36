//! The system of ordinary differential equations that an integrator solves.

use core::fmt::Debug;

use nalgebra::SVector;

use super::step::Few;
use super::storage::{Entries, States};
use crate::{Branch, Scalar};

/// A mechanism with N states and K sliding contacts: ẋ = f(t, x).
///
/// Between two reversals of a sliding velocity the field is smooth. An integrator locks each
/// contact's direction (see [`Branch`]), steps on the smooth field, finds the reversal and starts
/// afresh there. To write a system of your own, give the right-hand side on a branch and the
/// sliding velocities, and the [scales](System::scales) of its states; the rest is optional.
///
/// ```
/// use bristle::ode::{self, Output, System};
/// use bristle::{Bristle, Branch, Contact, Dahl, DahlParameters};
/// use bristle::nalgebra::Vector3;
///
/// /// A pendulum with friction in its joint: angle, angular velocity, bristle deflection.
/// struct Pendulum { joint: Contact<f64, Dahl<f64>> }
///
/// impl System<f64, 3> for Pendulum {
///     fn rate(&self, _time: f64, state: &Vector3<f64>, [joint]: [Branch; 1]) -> Vector3<f64> {
///         let (angle, velocity, deflection) = (state[0], state[1], state[2]);
///         let friction = self.joint.response(joint.of(velocity), deflection);
///         Vector3::new(velocity, -9.81 * angle.sin() - friction.force, friction.rate)
///     }
///
///     fn sliding_velocities(&self, _time: f64, state: &Vector3<f64>) -> [f64; 1] {
///         [state[1]]
///     }
///
///     fn scales(&self) -> Vector3<f64> {
///         // One radian, one radian per second, and the deflection at breakaway.
///         Vector3::new(1.0, 1.0, self.joint.limits(0.0).deflection.unwrap_or(1e-3))
///     }
/// }
///
/// let friction = Dahl::new(DahlParameters { dynamic_coefficient: 0.2, micro_stiffness: 1e3 })?;
/// let pendulum = Pendulum { joint: friction.under_load(1.0)? };
/// let start = Vector3::new(1.0, 0.0, 0.0);
/// let swing = ode::solve(&pendulum, 0.0..10.0, start, 1e-6, Output::Uniform(101))?;
/// assert!(swing.statistics().reversals > 5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait System<T: Scalar, const N: usize, const K: usize = 1> {
    /// The right-hand side f(t, x), each contact on its branch.
    fn rate(&self, time: T, state: &SVector<T, N>, branches: [Branch; K]) -> SVector<T, N>;

    /// The sliding velocity [m/s] of each contact, whose reversals are the kinks of f: in the same
    /// order and with the same sign as [`Branch::of`] gets it in [`System::rate`]. With another
    /// sign each contact is locked to the wrong side, and the answer is wrong without notice, or
    /// not finite.
    ///
    /// A velocity that passes zero twice within one step goes unnoticed. Friction prevents that: it
    /// acts on the velocity, so a long step across a reversal is rejected. Another kink of the
    /// state, such as a rope that goes slack or an end stop, has no such effect on its own sign.
    /// Leave it out here, and write it into the right-hand side, `max(stretch, 0)`: the error
    /// estimate then shortens the steps that cross it.
    fn sliding_velocities(&self, time: T, state: &SVector<T, N>) -> [T; K];

    /// The right-hand side with its partial derivatives, if they are known: exact ones, for methods
    /// lose their order by others. Wrong ones are refused
    /// ([`StopReason::WrongDerivative`](super::StopReason::WrongDerivative)).
    fn linearised(
        &self,
        time: T,
        state: &SVector<T, N>,
        branches: [Branch; K],
    ) -> Option<super::Linearisation<T, N>> {
        let _ = (time, state, branches);
        None
    }

    /// The first time strictly between `time` and `towards` at which an input is not smooth. There
    /// the right-hand side is that just after. A sliding velocity may jump there, also across zero.
    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        let _ = (time, towards);
        None
    }

    /// Tells each quantity that passes zero where f has a kink, or jumps, without a reversal: the
    /// gap to a floor, or that [of a bristle](crate::Bristle::switching_function) whose tip begins
    /// to slip. An adaptive step over a zero ends just beyond it, also where the signs at both ends
    /// are the same: a touch that lasts for a part of a step may fall between the stages. What
    /// rests at a zero within the tolerances is left alone. Tell them in one order always, and not
    /// more than there are states: a further one is multiplied into one told before.
    ///
    /// ```
    /// # use bristle::{Branch, Bristle, Contact, ElastoPlastic, ode};
    /// # use bristle::curve::Coulomb;
    /// # use bristle::rheology::KelvinVoigt;
    /// # use nalgebra::{SVector, Vector3};
    /// # struct Foot(Contact<f64, ElastoPlastic<Coulomb<f64>, KelvinVoigt<f64>>>);
    /// # impl ode::System<f64, 3, 1> for Foot {
    /// # fn rate(&self, _: f64, x: &Vector3<f64>, _: [Branch; 1]) -> Vector3<f64> { *x }
    /// # fn sliding_velocities(&self, _: f64, x: &Vector3<f64>) -> [f64; 1] { [x[1]] }
    /// // The states: the height above a floor, the sliding velocity, the deflection of a contact.
    /// fn switching_functions(
    ///     &self,
    ///     _time: f64,
    ///     state: &SVector<f64, 3>,
    ///     [branch]: [Branch; 1],
    ///     tell: &mut dyn FnMut(f64),
    /// ) {
    ///     tell(state[0]);
    ///     self.0.switching_function(branch.of(state[1]), state[2]).map(tell);
    /// }
    /// # }
    /// ```
    fn switching_functions(
        &self,
        time: T,
        state: &SVector<T, N>,
        branches: [Branch; K],
        tell: &mut dyn FnMut(T),
    ) {
        let _ = (time, state, branches, tell);
    }

    /// No adaptive step is longer than this \[s\]. `None` if there is no such limit.
    ///
    /// Give it for a sliding velocity that is prescribed, a time over which it turns at most once:
    /// in a longer step two reversals may cancel, and nothing tells of them. Give it for a force or
    /// a load that acts for less than two thousandths of the span while the body may stand still,
    /// for a step that nothing moves in can pass over it: a twentieth of its period, or a quarter
    /// of its shortest pulse.
    fn longest_step(&self) -> Option<T> {
        None
    }

    /// A typical magnitude of each state: what [`solve`](super::solve) and finite differences are
    /// relative to. The scale of a deflection is μ_s/σ0: `contact.limits(0.0).deflection`.
    ///
    /// If not given, one for each: far too coarse for a deflection in metres, and then an answer
    /// with a wrong friction force, without notice.
    fn scales(&self) -> SVector<T, N> {
        SVector::repeat(T::one())
    }
}

/// A right-hand side and its partial derivatives at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linearisation<V, A> {
    /// f(t, x).
    pub rate: V,
    /// The Jacobian ∂f/∂x: entry (i, j) is ∂fᵢ/∂xⱼ.
    pub by_state: A,
    /// ∂f/∂t.
    pub by_time: V,
}

/// A system as the driver sees it: every [`System`] with K contacts, and
/// every [`dynamic::System`](super::dynamic::System).
pub trait Equations<T: Scalar, V: States<T>, K> {
    /// A value for each contact.
    type Contacts<X: Copy + Debug>: Entries<X>;

    /// The number of states.
    fn states(&self) -> usize;

    /// The number of contacts.
    fn contacts(&self) -> usize;

    /// [`System::rate`], written over a vector.
    fn rate_to(&self, time: T, state: &V, branches: &Self::Contacts<Branch>, rate: &mut V);

    /// [`System::sliding_velocities`], written over a value for each contact.
    fn velocities_to(&self, time: T, state: &V, velocities: &mut Self::Contacts<T>);

    /// [`System::sliding_velocities`].
    #[inline(always)]
    fn velocities(&self, time: T, state: &V) -> Self::Contacts<T> {
        let mut velocities = Self::Contacts::filled(self.contacts(), T::zero());
        self.velocities_to(time, state, &mut velocities);
        velocities
    }

    /// [`System::linearised`].
    fn tangent(
        &self,
        time: T,
        state: &V,
        branches: &Self::Contacts<Branch>,
    ) -> Option<Linearisation<V, V::Matrix>>;

    /// [`System::next_kink`].
    fn kink(&self, time: T, towards: T) -> Option<T>;

    /// [`System::switching_functions`], as many as there are states; `None` if there are none.
    fn switching(&self, time: T, state: &V, branches: &Self::Contacts<Branch>) -> Option<V>;

    /// [`System::longest_step`].
    fn limit(&self) -> Option<T>;

    /// [`System::scales`].
    fn magnitudes(&self) -> V;
}

/// Of K contacts, a number known when the program is compiled.
#[derive(Debug, Clone, Copy)]
pub struct Fixed<const K: usize>;

impl<T: Scalar, S: System<T, N, K> + ?Sized, const N: usize, const K: usize>
    Equations<T, SVector<T, N>, Fixed<K>> for S
{
    type Contacts<X: Copy + Debug> = [X; K];

    #[inline(always)]
    fn states(&self) -> usize {
        N
    }

    #[inline(always)]
    fn contacts(&self) -> usize {
        const { assert!(K <= Few::MOST, "a system may have 128 contacts at most") };
        K
    }

    #[inline(always)]
    fn rate_to(
        &self,
        time: T,
        x: &SVector<T, N>,
        branches: &[Branch; K],
        rate: &mut SVector<T, N>,
    ) {
        *rate = self.rate(time, x, *branches);
    }

    #[inline(always)]
    fn velocities_to(&self, time: T, state: &SVector<T, N>, velocities: &mut [T; K]) {
        *velocities = self.sliding_velocities(time, state);
    }

    #[inline(always)]
    fn tangent(
        &self,
        time: T,
        state: &SVector<T, N>,
        branches: &[Branch; K],
    ) -> Option<super::Linearisation<T, N>> {
        self.linearised(time, state, *branches)
    }

    #[inline(always)]
    fn kink(&self, time: T, towards: T) -> Option<T> {
        self.next_kink(time, towards)
    }

    #[inline(always)]
    fn switching(
        &self,
        time: T,
        state: &SVector<T, N>,
        branches: &[Branch; K],
    ) -> Option<SVector<T, N>> {
        told(N, |tell| self.switching_functions(time, state, *branches, tell))
    }

    fn limit(&self) -> Option<T> {
        self.longest_step()
    }

    fn magnitudes(&self) -> SVector<T, N> {
        self.scales()
    }
}

/// What is told, in an entry each; those that are left are one.
#[inline(always)]
pub(super) fn told<T: Scalar, V: States<T>>(
    states: usize,
    functions: impl FnOnce(&mut dyn FnMut(T)),
) -> Option<V> {
    let (mut values, mut count) = (None, 0);
    functions(&mut |value| {
        let values = values.get_or_insert_with(|| V::filled(states, T::one()));
        if states > 0 {
            values[count % states] *= value;
            count += 1;
        }
    });
    values
}
