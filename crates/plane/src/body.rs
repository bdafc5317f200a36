//! A body that slides in a plane, held by springs whose far ends move.
//!
//! ẋᵢ = vᵢ,  mᵢ v̇ᵢ = fᵢ(t) + kᵢ (aᵢ(t) − xᵢ) − cᵢ vᵢ − Fᵢ(v, z),  ż = h(v, z)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | xᵢ, vᵢ | position and velocity along axis i | m, m/s |
//! | z | deflections of the bristles | m |
//! | mᵢ, kᵢ, cᵢ | mass, spring stiffness, viscous damping of axis i | kg, N/m, N s/m |
//! | aᵢ | position of the spring's far end | m |
//! | fᵢ | applied force | N |
//! | Fᵢ | friction force | N |
//!
//! With three axes the third is R times the angle of rotation, R ω its velocity, J/R² its mass and
//! torque over R its force, with the radius R of [`plane`](crate#rotation-as-an-axis).
//!
//! In a plane ‖v‖ has the tip of a cone at rest, and there is no direction to lock. A path that
//! passes beside the tip is smooth, and the solver takes short steps where the velocity turns fast.
//! A body that rests stays at the tip, where the direction of its velocity is that of its
//! roundings: an adaptive solver may take hundreds of steps for each second of rest. Where the body
//! stands for long or stops often, take the passive step of
//! [`PlaneCompanion`](crate::PlaneCompanion).

use nalgebra::{SMatrix, SVector};

use crate::{PlaneBristle, PlaneContact};
use bristle::ode::{Linearisation, System};
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::scalar::{is_zero, lit};
use bristle::signal::Signal;
use bristle::{Branch, Mechanism, Scalar};

/// Parameters of [`PlaneBody`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(deserialize = "T: Scalar + serde::Deserialize<'de>, \
                       M: PlaneBristle<T, N> + serde::Deserialize<'de>, \
                       A: serde::Deserialize<'de>, F: serde::Deserialize<'de>"))
)]
#[cfg_attr(
    feature = "serde",
    serde(bound(serialize = "T: Scalar + serde::Serialize, \
                     M: PlaneBristle<T, N> + serde::Serialize, \
                     A: serde::Serialize, F: serde::Serialize"))
)]
pub struct PlaneBodyParameters<T, M, const N: usize, A = T, F = T> {
    /// Friction under its normal force.
    pub contact: PlaneContact<T, M, N>,
    /// Mass, spring and damper of each axis; springs and dampers may be absent (zero).
    #[cfg_attr(feature = "serde", serde(with = "bristle::serialisation::array"))]
    pub mechanisms: [Mechanism<T>; N],
    /// Position aᵢ(t) \[m\] of each spring's far end.
    #[cfg_attr(feature = "serde", serde(with = "bristle::serialisation::array"))]
    pub anchor: [A; N],
    /// Force fᵢ(t) \[N\] along each axis; 0 for none.
    #[cfg_attr(feature = "serde", serde(with = "bristle::serialisation::array"))]
    pub force: [F; N],
}

/// A body on two axes, or on three with its rotation, held by springs whose far ends move.
///
/// States: the positions \[m\], then the velocities [m/s], then the deflections \[m\].
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle::nalgebra::Vector6;
/// use bristle::ode::{self, Output};
/// use bristle_plane::{PlaneBristle, PlaneFrBd};
/// use bristle::rheology::KelvinVoigt;
/// use bristle_plane::{PlaneBody, PlaneBodyParameters};
/// use bristle::{Mechanism, paper};
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let friction = PlaneFrBd::isotropic(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?);
/// let free = Mechanism { mass: 1.0, spring_stiffness: 0.0, viscous_damping: 0.0 };
/// let block = PlaneBody::new(PlaneBodyParameters {
///     contact: friction.under_load(1.0)?, // N
///     mechanisms: [free; 2],
///     anchor: [0.0; 2],
///     force: [0.0; 2],
/// })?;
/// // Pushed off at 0.5 m/s, it stops after about v²/(2 μ_d p/m), in the direction of the push.
/// let start = Vector6::new(0.0, 0.0, 0.3, 0.4, 0.0, 0.0);
/// let run = ode::solve(&block, 0.0..1.0, start, 1e-6, Output::Uniform(2))?;
/// let end = run.states()[1];
/// assert!((end[0].hypot(end[1]) - 0.12).abs() < 0.01);
/// assert!((end[1] / end[0] - 4.0 / 3.0).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneBody<T, M, const N: usize, A = T, F = T> {
    parameters: PlaneBodyParameters<T, M, N, A, F>,
}

impl<T, M, A, F, const N: usize> PlaneBody<T, M, N, A, F>
where
    T: Scalar,
    M: PlaneBristle<T, N>,
    A: Signal<T>,
    F: Signal<T>,
{
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range, and its axis; anchors and forces are checked
    /// at time zero.
    pub fn new(parameters: PlaneBodyParameters<T, M, N, A, F>) -> Checked<Self> {
        let PlaneBodyParameters { mechanisms, anchor, force, .. } = &parameters;
        ParameterError::of_components(0..N, |axis| {
            mechanisms[axis].checked()?;
            Named("anchor", anchor[axis].value(T::zero())).finite()?;
            Named("force", force[axis].value(T::zero())).finite()
        })?;
        Ok(Self { parameters })
    }

    /// The parameters, as they were given.
    pub fn parameters(&self) -> &PlaneBodyParameters<T, M, N, A, F> {
        &self.parameters
    }

    /// The contact.
    pub fn contact(&self) -> &PlaneContact<T, M, N> {
        &self.parameters.contact
    }

    /// Velocity and deflection in a state of three parts.
    #[inline(always)]
    fn parts<const S: usize>(state: &SVector<T, S>) -> [SVector<T, N>; 2] {
        const { assert!(S == 3 * N, "a body has three states on each axis") };
        [1, 2].map(|part| SVector::from_fn(|i, _| state[part * N + i]))
    }
}

/// S = 3N: another number of states does not compile.
impl<T, M, A, F, const N: usize, const S: usize> System<T, S, 0> for PlaneBody<T, M, N, A, F>
where
    T: Scalar,
    M: PlaneBristle<T, N>,
    A: Signal<T>,
    F: Signal<T>,
{
    #[inline]
    fn rate(&self, time: T, state: &SVector<T, S>, _: [Branch; 0]) -> SVector<T, S> {
        let PlaneBodyParameters { contact, mechanisms, anchor, force } = &self.parameters;
        let [velocity, deflection] = Self::parts(state);
        let friction = contact.response(&velocity, &deflection);
        let mut rate = SVector::zeros();
        for i in 0..N {
            let Mechanism { mass, spring_stiffness, viscous_damping } = mechanisms[i];
            let spring = spring_stiffness * (anchor[i].value(time) - state[i]);
            let other = force[i].value(time) + spring - viscous_damping * velocity[i];
            rate[i] = velocity[i];
            rate[N + i] = (other - friction.force[i]) / mass;
            rate[2 * N + i] = friction.rate[i];
        }
        rate
    }

    fn sliding_velocities(&self, _: T, _: &SVector<T, S>) -> [T; 0] {
        []
    }

    fn linearised(
        &self,
        time: T,
        state: &SVector<T, S>,
        _: [Branch; 0],
    ) -> Option<Linearisation<T, S>> {
        let PlaneBodyParameters { contact, mechanisms, anchor, force } = &self.parameters;
        let [velocity, deflection] = Self::parts(state);
        let friction = contact.linearised(&velocity, &deflection);
        let (mut by_state, mut by_time) = (SMatrix::zeros(), SVector::zeros());
        for i in 0..N {
            let Mechanism { mass, spring_stiffness, viscous_damping } = mechanisms[i];
            by_state[(i, N + i)] = T::one();
            by_state[(N + i, i)] = -spring_stiffness / mass;
            by_state[(N + i, 2 * N + i)] = -friction.force_by_deflection[i] / mass;
            by_state[(2 * N + i, 2 * N + i)] = friction.rate_by_deflection[i];
            for j in 0..N {
                by_state[(N + i, N + j)] = -friction.force_by_velocity[(i, j)] / mass;
                by_state[(2 * N + i, N + j)] = friction.rate_by_velocity[(i, j)];
            }
            by_state[(N + i, N + i)] -= viscous_damping / mass;
            let drive = force[i].value_and_rate(time).1;
            by_time[N + i] = (drive + spring_stiffness * anchor[i].value_and_rate(time).1) / mass;
        }
        Some(Linearisation { rate: self.rate(time, state, []), by_state, by_time })
    }

    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        let PlaneBodyParameters { anchor, force, .. } = &self.parameters;
        anchor.iter().zip(force).fold(None, |first, (anchor, force)| {
            let first = anchor.next_kink(time, first.unwrap_or(towards)).or(first);
            force.next_kink(time, first.unwrap_or(towards)).or(first)
        })
    }

    fn longest_step(&self) -> Option<T> {
        let PlaneBodyParameters { anchor, force, .. } = &self.parameters;
        let anchors = anchor.iter().filter_map(|anchor| anchor.longest_step());
        anchors.chain(force.iter().filter_map(|force| force.longest_step())).reduce(T::smaller)
    }

    /// Deflection: at breakaway. Position: the stretch of the spring at breakaway, without a spring
    /// the deflection. Velocity: what the mass reaches when that stretch is released.
    fn scales(&self) -> SVector<T, S> {
        let PlaneBodyParameters { contact, mechanisms, .. } = &self.parameters;
        let limits = contact.model().limits(T::zero()).deflection;
        let mut scales = SVector::zeros();
        for (i, &stiffness) in contact.model().storage_stiffness().iter().enumerate() {
            let Mechanism { mass, spring_stiffness, .. } = mechanisms[i];
            let deflection = limits.map_or_else(|| lit(1e-6), |limits| limits[i]);
            let bristle = stiffness * contact.normal_force();
            let breakaway = (bristle * deflection).larger(T::default_epsilon());
            let free = is_zero(spring_stiffness);
            let stretch = if free { deflection } else { breakaway / spring_stiffness };
            scales[i] = stretch;
            scales[N + i] = (breakaway * stretch / mass).sqrt();
            scales[2 * N + i] = deflection;
        }
        scales
    }
}
