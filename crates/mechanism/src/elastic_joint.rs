//! An elastic joint: motor and link on either side of a shaft with backlash, friction on both.
//!
//! J_m ω̇_m = τ_m − F_m − T − c ė,  J_l ω̇_l = τ_l − F_l + T + c ė,  e = θ_m − θ_l
//!
//! U(e) = ½ k max(|e| − b/2, 0)²,  T = U'(e)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | θ, ω | angles and angular velocities of motor and link, at the link | rad, rad/s |
//! | J | moments of inertia | kg m² |
//! | k, c | stiffness and damping of the shaft | N m/rad, N m s/rad |
//! | b | backlash: the play between the two ends | rad |
//! | τ, F | applied torques, friction torques | N m |
//!
//! Over a step the torque of the shaft is the discrete gradient T̄ = (U(e₁) − U(e₀))/(e₁ − e₀), so
//! that its work is the change of U, whatever the teeth do in the step, to roundings. These grow
//! with the length of the step over √(J/k) of the lighter side (the tests allow 100 ε times that,
//! of energies and works). All else is linear: e₁ = E − R T̄ with what the joint would do without a
//! shaft, E, and its compliance R > 0.
//! U is convex, so that there is one solution, and U piecewise quadratic, so that it is the root of
//! a quadratic equation of the stretch, without iteration.
//!
//! Source: the discrete gradient of T. Itoh, K. Abe, "Hamiltonian-conserving discrete canonical
//! equations based on variational difference quotients", J. Comput. Phys. 76 (1988), in one
//! variable; the companion steps of [`bristle::companion`].

use crate::contacts::ContactState;
use crate::step::forwards;
use bristle::companion::Companion;
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::scalar::{is_zero, lit};
use bristle::{Bristle, Scalar};

/// Parameters of an [`ElasticJoint`], all at the link's side of the gear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElasticJointParameters<T> {
    /// Moments of inertia J_m and J_l [kg m²] of motor and link.
    pub inertias: [T; 2],
    /// Stiffness k [N m/rad] of the shaft, positive.
    pub stiffness: T,
    /// Damping c [N m s/rad] of the shaft, in the play too; zero or positive.
    pub damping: T,
    /// Backlash b \[rad\], the whole play; zero or positive.
    pub backlash: T,
}

/// Where motor and link are and how they move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElasticJointMotion<T> {
    /// Angles θ_m and θ_l \[rad\].
    pub position: [T; 2],
    /// Angular velocities ω_m and ω_l [rad/s].
    pub velocity: [T; 2],
}

/// What a shaft has done over a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShaftStep<T> {
    /// Mean torque T̄ [N m] of its spring.
    pub torque: T,
    /// Energy \[J\] that its damper has dissipated.
    pub dissipated: T,
    /// Mean angular velocities [rad/s] of motor and link.
    pub mean_velocities: [T; 2],
}

/// A motor that drives a link by an elastic shaft with backlash, with friction on either side, in
/// steps whose energy is exact.
///
/// A motor swings to and fro through a play of 20 mrad; the link rubs.
///
/// ```
/// use bristle::{Bristle, Dahl, DahlParameters};
/// use bristle_mechanism::{ContactState, ElasticJoint, ElasticJointMotion, ElasticJointParameters};
///
/// let joint = ElasticJoint::new(ElasticJointParameters {
///     inertias: [0.01, 0.1],
///     stiffness: 50.0,
///     damping: 0.02,
///     backlash: 0.02,
/// })?;
/// let friction = Dahl::new(DahlParameters { dynamic_coefficient: 1.0, micro_stiffness: 1e3 })?;
/// let companions = [friction.under_load(0.02)?, friction.under_load(0.05)?]; // N m
/// let companions = [companions[0].companion(1.0)?, companions[1].companion(1.0)?];
/// let mut contacts = companions.map(|companion| ContactState::new(&companion, 0.0));
/// let mut motion = ElasticJointMotion { position: [0.0; 2], velocity: [0.0; 2] };
/// let (h, mut missing) = (1e-3, joint.energy(&motion));
/// for n in 0..5000 {
///     let torques = [0.2 * (2e-3 * f64::from(n)).sin(), 0.0]; // N m
///     let shaft = joint.step(h, torques, &mut motion, &companions, &mut contacts, None);
///     let friction: f64 = contacts.iter().map(|contact| contact.last_step().work).sum();
///     missing += h * torques[0] * shaft.mean_velocities[0] - friction - shaft.dissipated;
/// }
/// assert!((missing - joint.energy(&motion)).abs() < 1e-13); // J
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElasticJoint<T> {
    parameters: ElasticJointParameters<T>,
    /// b/2
    play: T,
    pub(crate) rows: [[(usize, T); 1]; 2],
}

impl<T: Scalar> ElasticJoint<T> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses moments of inertia and a stiffness that are not positive, a damping or a backlash
    /// that is negative, and what is not finite.
    pub fn new(parameters: ElasticJointParameters<T>) -> Checked<Self> {
        let positive = |inertia| Named("inertias", inertia).positive();
        ParameterError::of_components(parameters.inertias, positive)?;
        Named("stiffness", parameters.stiffness).positive()?;
        Named("damping", parameters.damping).non_negative()?;
        let backlash = Named("backlash", parameters.backlash).non_negative()?;
        let rows = [0, 1].map(|side| [(side, T::one())]);
        Ok(Self { parameters, play: backlash * lit(0.5), rows })
    }

    /// The parameters.
    pub fn parameters(&self) -> ElasticJointParameters<T> {
        self.parameters
    }

    /// Kinetic energy and that of the shaft \[J\], without that of the bristles.
    pub fn energy(&self, motion: &ElasticJointMotion<T>) -> T {
        let [motor, link] = motion.velocity;
        let [j, l] = self.parameters.inertias;
        let half = lit::<T>(0.5);
        half * (j * motor * motor + l * link * link) + self.stored(stretch(motion.position))
    }

    /// A step of length h ≥ 0 \[s\] under applied torques [N m], averaged over it, on motor and
    /// link, with a companion and a state for the friction of each, and their loads where these
    /// vary. It takes numbers and gives numbers: NaN for NaN, for h < 0, and for a load that is
    /// negative.
    pub fn step<M: Bristle<T>>(
        &self,
        duration: T,
        torques: [T; 2],
        motion: &mut ElasticJointMotion<T>,
        companions: &[Companion<T, M>; 2],
        contacts: &mut [ContactState<T, M::Deflection>; 2],
        loads: Option<[T; 2]>,
    ) -> ShaftStep<T> {
        let ElasticJointParameters { inertias, damping, .. } = self.parameters;
        let (duration, half) = (forwards(duration), lit::<T>(0.5) * duration);
        let (start, rates) = (stretch(motion.position), motion.velocity);
        // The matrix [[a, −s], [−s, b]] of the mean accelerations, and what acts but for the
        // spring.
        let side = half * damping;
        let (mut diagonal, mut right) = (inertias.map(|inertia| inertia + side), torques);
        let resisted = damping * stretch(rates);
        (right[0], right[1]) = (right[0] - resisted, right[1] + resisted);
        for (k, (state, companion)) in contacts.iter_mut().zip(companions).enumerate() {
            let load = loads.map_or(state.load(), |loads| loads[k]);
            let (bias, damper) = state.freeze(companion, [rates[k], rates[k], load, duration]);
            diagonal[k] += half * damper;
            right[k] -= bias + damper * rates[k];
        }
        // Of a b − s² nothing cancels: s ≤ a, b.
        let inverse = T::one() / (diagonal[0] * diagonal[1] - side * side);
        let solve = |[motor, link]: [T; 2]| {
            let [a, b] = diagonal;
            [(b * motor + side * link) * inverse, (side * motor + a * link) * inverse]
        };
        let free = start + duration * (stretch(rates) + half * stretch(solve(right)));
        let compliance = duration * half * stretch(solve([T::one(), -T::one()]));
        let torque = self.mean_torque(start, self.end(start, free, compliance));
        let accelerations = solve([right[0] - torque, right[1] + torque]);
        let mean_velocities = [0, 1].map(|k| rates[k] + half * accelerations[k]);
        for k in 0..2 {
            motion.position[k] += duration * mean_velocities[k];
            motion.velocity[k] += duration * accelerations[k];
            contacts[k].commit(mean_velocities[k]);
        }
        let rate = stretch(mean_velocities);
        ShaftStep { torque, dissipated: duration * damping * rate * rate, mean_velocities }
    }

    /// U(e).
    fn stored(&self, stretch: T) -> T {
        let beyond = (stretch.abs() - self.play).larger(T::zero());
        lit::<T>(0.5) * self.parameters.stiffness * beyond * beyond
    }

    /// −1, 0 or 1: which flank of the teeth is in contact.
    fn flank(&self, stretch: T) -> T {
        if stretch > self.play {
            T::one()
        } else if stretch < -self.play {
            -T::one()
        } else {
            T::zero()
        }
    }

    /// (U(e₁) − U(e₀))/(e₁ − e₀).
    pub(crate) fn mean_torque(&self, start: T, end: T) -> T {
        let (flank, change) = (self.flank(start), end - start);
        if flank == self.flank(end) || is_zero(change) {
            let middle = lit::<T>(0.5) * (start + end) - flank * self.play;
            return self.parameters.stiffness * flank.abs() * middle;
        }
        (self.stored(end) - self.stored(start)) / change
    }

    /// The stretch e₁ = E − R T̄ at the end. What is left of that equation rises with e₁, so that
    /// its signs at the edges of the play tell the flank.
    fn end(&self, start: T, free: T, compliance: T) -> T {
        let left = |end: T| end - free + compliance * self.mean_torque(start, end);
        let one = T::one();
        let flank = if left(self.play) < T::zero() {
            one
        } else if left(-self.play) > T::zero() {
            -one
        } else {
            T::zero()
        };
        let (half, stored) = (lit::<T>(0.5), self.stored(start));
        let stiffness = self.parameters.stiffness * flank.abs();
        let (soft, offset) = (compliance * stiffness, start - flank * self.play);
        // (d − D) d + R (½ k (e₀ + d ∓ b/2)² − U(e₀)) = 0 of the change d, with D = E − e₀.
        let square = one + half * soft;
        let linear = free - start - soft * offset;
        let before = self.flank(start);
        if before == flank {
            return start + linear / square;
        }
        let constant = compliance * (half * stiffness * offset * offset - stored);
        let root = (linear * linear - lit::<T>(4.0) * square * constant).larger(T::zero()).sqrt();
        // To a flank the larger change, from a flank the one back.
        let sign = if is_zero(flank) { -before } else { flank };
        start + half * (linear + sign * root) / square
    }
}

/// The angle of the motor less that of the link.
fn stretch<T: Scalar>([motor, link]: [T; 2]) -> T {
    motor - link
}
