//! An observer of the bristle's deflection, corrected by the tracking error.
//!
//! The loop: m v̇ = u − F, with x_ref, its acceleration a_ref, e = x − x_ref, and
//!
//! u = m a_ref − K_p e − K_d ė − K_i ∫e dt + F̂.
//!
//! The observer is the friction model with its coefficients at the measured velocity, F = p (c₀ z + c₂ v), ż = −λ z + r v, and a
//! correction, in one of two ways:
//!
//! | [`Injection`] | estimate | condition |
//! |---|---|---|
//! | `Velocity` | dẑ/dt = −λ ẑ + r (v − k y),  F̂ = p (c₀ ẑ + c₂ (v − k y)),  y = ė + α e | K_d > α m, K_i < α K_p |
//! | `Position` | dẑ/dt = −λ ẑ + r v − k e,  F̂ = p (c₀ ẑ + c₂ v − σ1 k e) | the same with α = σ0/σ1 |
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | z, ẑ, z̃ = z − ẑ | deflection, its estimate, the estimate's error | m |
//! | F̂, F̃ = F − F̂ | estimate of the friction force, its error | N |
//! | e, ė | tracking error and its rate | m, m/s |
//! | K_p, K_d, K_i | gains of the controller | N/m, N s/m, N/(m s) |
//! | k | gain of the injection: by velocity –, by position 1/s | |
//! | α | corner rate of the injection | 1/s |
//! | m | mass | kg |
//! | λ, r, c₀, c₂, K | coefficients of the model and stiffness of its storage, see [`Affine`] | |
//! | σ0, σ1, σ2 | micro-stiffness, micro-damping, viscous friction outside the bristle | 1/m, s/m, s/m |
//!
//! # Why it converges
//!
//! *By velocity.* Subtract: dz̃/dt = −λ z̃ + r (k y), F̃ = p (c₀ z̃ + c₂ (k y)). The error is a friction element of its own, whose
//! velocity is k y, with coefficients that vary in time as λ(v(t)) does. Let W̃ = ½ p K z̃². Then
//!
//! k F̃ y − dW̃/dt = p (K λ z̃² + (c₀ − K r) z̃ (k y) + c₂ (k y)²) = D.
//!
//! For FrBD c₀ = K r, and D ≥ 0 whatever v(t) is: *an FrBD observer's error is passive because the model is*, for every curve, σ0, σ1 and
//! k > 0. For LuGre c₀ − K r = −σ1 λ, and D ≥ 0 for all z̃, y iff σ1² λ(v) ≤ 4 σ0 (σ1 + σ2): up to a speed.
//!
//! The loop answers with m ë + K_d ė + K_p e + K_i q = −F̃, q̇ = e. With
//!
//! V = ½ m ė² + α m e ė + ½ (K_p + α K_d) e² + K_i e q + ½ α K_i q²,
//!
//! dV/dt = −(K_d − α m) ė² − (α K_p − K_i) e² − F̃ y, and V > 0 under the conditions of the table. In other words
//! (s + α)/(m s² + K_d s + K_p + K_i/s) is positive real, strictly so without K_i. Add: W̃/k + V never rises, and falls
//! as long as e, ė are not zero; so e, ė → 0. Where λ = 0, in a standing bristle, z̃
//! stays as it is once e is zero: then F̃ is what K_i q balances, and without K_i it is zero too.
//!
//! *By position*, as Canudas de Wit and others did for LuGre: dz̃/dt = −λ z̃ + k e, F̃ = p (σ0 z̃ + σ1 dz̃/dt), so that e = −G z̃ with
//! G = p (σ1 s + σ0)/(m s² + K_d s + K_p + K_i/s), and it converges if G is strictly positive real. Because c₀ = σ0 − σ1 λ in FrBD as
//! well, and r and the velocity drop out of the difference, the theorem holds for FrBD word by word. From
//! Re G(jω) ∝ σ0 K_p − σ1 K_i + ω² (σ1 K_d − σ0 m) follow the conditions: the bristle's own corner σ0/σ1 takes the place of α (with K_i, G is zero at ω = 0, and positive real no more than that). It is mostly
//! high, and the condition hard to meet: K_d > m σ0/σ1.
//!
//! # What is left of it in samples
//!
//! With v, y and e held over a sample the step of ẑ is exact. By velocity therefore h k F̃̄ y = ΔW̃ + D̄ with D̄ ≥ 0 (F̃̄ the mean over the
//! sample) *for every sample time*: the observer's part never gives energy, however long the sample, and without a tracking error z̃
//! never grows. By position z̃ never grows without a tracking error, and is at most e^(−λh) z̃ + k h e. The estimate is cut to the
//! deflection's limit, where the true one is: that only brings them together. What this does not prove is the
//! sampled *loop*: the controller's own hold and delay are not in it. Where they cost no passivity (a mechanism whose tracking error is solved
//! implicitly) the sum above carries over to every sample time; else keep its bandwidth a tenth of the sample rate or less.
//!
//! The theorems are about a share of one, an actuator within its limit, and a model that fits. A friction force that differs
//! from the model's is a disturbance: the estimate stays within its limit, so that F̃ is bounded but for the part c₂ k y, which acts like more
//! K_d and K_p; and with it the tracking error.
//!
//! Source: Canudas de Wit et al., IEEE TAC 40 (1995), 419–425, section on observer-based compensation, for the injection by
//! position with LuGre. Injection by velocity, and both with FrBD: from the affine form, as above.

use super::output::{Compensation, Outlet, OutputParameters};
use super::path::along;
use super::velocity_from_position::{
    Reading, VelocityFromPosition, VelocityFromPositionParameters,
};
use crate::curve::FrictionCurve;
use crate::model::unlimited;
use crate::parameter::{self, ParameterError};
use crate::regularisation::Regularisation;
use crate::rheology::{Deflection, KelvinVoigt, Spring};
use crate::scalar::lit;
use crate::{Affine, Bristle, Contact, Dahl, FrBd, Law, LuGre, Scalar};

/// How the tracking error corrects the estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Injection<T> {
    /// By k (ė + α e), as a correction of the velocity that drives the whole model.
    Velocity {
        /// Gain k \[–\], positive: which part of the error's velocity the bristle is spared.
        gain: T,
        /// Corner rate α [1/s], positive and below K_d/m.
        corner: T,
    },
    /// By k e, as a correction of the deflection's rate: Canudas de Wit and others.
    Position {
        /// Gain k [1/s], positive.
        gain: T,
    },
}

/// Parameters of a [`FrictionObserver`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObserverParameters<T, M> {
    /// Friction under its normal force.
    pub contact: Contact<T, M>,
    /// Mass m \[kg\] of what the controller moves, positive.
    pub mass: T,
    /// Gain K_p [N/m] of the controller on the position, positive.
    pub proportional_gain: T,
    /// Gain K_d [N s/m] of the controller on the velocity, viscous damping of the mechanism included, positive.
    pub derivative_gain: T,
    /// Gain K_i [N/(m s)] of the controller on the integral of the position, zero for none.
    pub integral_gain: T,
    /// How the tracking error corrects the estimate.
    pub injection: Injection<T>,
    /// Sample time h and time constant τ \[s\] of the velocities' filter for [`FrictionObserver::step`], and the fastest speed
    /// \[m/s\]: LuGre's condition depends on it, and the limit of the deflection.
    pub velocity: VelocityFromPositionParameters<T>,
    /// Share and limit; the theorems are about a share of one.
    pub output: OutputParameters<T>,
}

/// What is known at a sample, for a loop that measures or estimates its velocity itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured<T> {
    /// Mean velocity v [m/s] over the sample that has ended.
    pub velocity: T,
    /// Tracking error e = x − x_ref \[m\].
    pub error: T,
    /// Its rate ė [m/s].
    pub error_rate: T,
}

/// A model whose difference from an estimate is linear, so that the theorems speak of it: [`FrBd`] and [`LuGre`] with
/// constant σ0 and σ1, and [`Dahl`].
///
/// Not elasto-plastic friction and the implicit bristle, whose coefficients depend on the deflection itself.
pub trait ObserverModel<T: Scalar>: Bristle<T, Deflection = T> + sealed::Sealed {}

mod sealed {
    pub trait Sealed {}
}

impl<T, C, E> sealed::Sealed for FrBd<C, KelvinVoigt<T>, E> {}
impl<T, C, E> sealed::Sealed for FrBd<C, Spring<T>, E> {}
impl<T, C, E> sealed::Sealed for LuGre<C, KelvinVoigt<T>, E, T> {}
impl<T> sealed::Sealed for Dahl<T> {}

impl<T: Scalar, C: FrictionCurve<T>, E: Regularisation<T>> ObserverModel<T>
    for FrBd<C, KelvinVoigt<T>, E>
{
}
impl<T: Scalar, C: FrictionCurve<T>, E: Regularisation<T>> ObserverModel<T>
    for FrBd<C, Spring<T>, E>
{
}
impl<T: Scalar, C: FrictionCurve<T>, E: Regularisation<T>> ObserverModel<T>
    for LuGre<C, KelvinVoigt<T>, E, T>
{
}
impl<T: Scalar> ObserverModel<T> for Dahl<T> {}

/// What the reference may jump by in one sample, over the way of the fastest speed: what a planner a thousand times slower than
/// the loop asks for. More is a fault, until it is seen twice.
const JUMP: f64 = 1e3;

/// An observer of the deflection, and the compensation by its force.
///
/// ```
/// use bristle::control::{
///     FrictionObserver, Injection, ObserverParameters, OutputParameters, VelocityFromPositionParameters,
/// };
/// use bristle::{Bristle, FrBd, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
/// let parameters = ObserverParameters {
///     contact: FrBd::new(curve, bristle).under_load(1.0)?,
///     mass: 1.0,
///     proportional_gain: 400.0,
///     derivative_gain: 30.0,
///     integral_gain: 1000.0,
///     injection: Injection::Velocity { gain: 0.1, corner: 10.0 },
///     velocity: VelocityFromPositionParameters { sample_time: 1e-3, time_constant: 2e-3, fastest: 0.5, count: 0.0 },
///     output: OutputParameters { share: 1.0, largest_force: 3.0 },
/// };
/// let mut observer = FrictionObserver::new(parameters)?;
/// let force = observer.step(0.0, 1e-4).force; // the position is behind its reference
///
/// // The classical injection needs K_d > m σ0/σ1.
/// let classical = Injection::Position { gain: 0.1 };
/// let refused = FrictionObserver::new(ObserverParameters { injection: classical, ..parameters });
/// let refused = refused.unwrap_err().to_string();
/// assert!(refused.starts_with("corner × mass is 155.03") && refused.ends_with("below derivative_gain = 30"));
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionObserver<T, M> {
    contact: Contact<T, M>,
    injection: Injection<T>,
    /// σ1
    micro_damping: T,
    limit: T,
    position: VelocityFromPosition<T>,
    error: VelocityFromPosition<T>,
    deflection: T,
    outlet: Outlet<T>,
}

impl<T: Scalar, M: ObserverModel<T>> FrictionObserver<T, M> {
    /// Checks the parameters, and the conditions under which the closed loop converges; the bristle is undeflected.
    ///
    /// # Errors
    ///
    /// Refuses parameters out of their ranges; α m ≥ K_d and K_i ≥ α K_p (with α = σ0/σ1 for [`Injection::Position`], which
    /// needs σ1 > 0); and with [`Injection::Velocity`] a LuGre model that is faster than σ1² λ ≤ 4 σ0 (σ1 + σ2) allows.
    pub fn new(parameters: ObserverParameters<T, M>) -> Result<Self, ParameterError> {
        let ObserverParameters { contact, injection, velocity, output, .. } = parameters;
        let fastest = parameter::positive("fastest", velocity.fastest)?;
        let mass = parameter::positive("mass", parameters.mass)?;
        let proportional = parameter::positive("proportional_gain", parameters.proportional_gain)?;
        let derivative = parameter::positive("derivative_gain", parameters.derivative_gain)?;
        let integral = parameter::non_negative("integral_gain", parameters.integral_gain)?;
        let model = contact.model();
        let stiffness = model.storage_stiffness();
        let (micro_damping, viscous) = model
            .characteristics(fastest)
            .map_or((T::zero(), T::zero()), |a| (a.micro_damping.max, a.viscous_friction));
        let corner = match injection {
            Injection::Velocity { gain, corner } => {
                parameter::positive("gain", gain)?;
                if !model.obeys(Law::Secant) {
                    // D is a sum of squares up to this relaxation rate.
                    let four: T = lit(4.0);
                    let limit = four * stiffness * (micro_damping + viscous)
                        / (micro_damping * micro_damping);
                    let fastest = model.limits(fastest).relaxation_rate.unwrap_or_else(unlimited);
                    parameter::at_most(
                        "relaxation rate at the fastest speed",
                        fastest,
                        "4 σ0 (σ1 + σ2)/σ1²",
                        limit,
                    )?;
                }
                parameter::positive("corner", corner)?
            }
            Injection::Position { gain } => {
                parameter::positive("gain", gain)?;
                stiffness / parameter::positive("micro_damping", micro_damping)?
            }
        };
        parameter::below("corner × mass", corner * mass, "derivative_gain", derivative)?;
        let most = corner * proportional;
        parameter::below("integral_gain", integral, "corner × proportional_gain", most)?;
        Ok(Self {
            limit: model.limits(fastest).deflection.unwrap_or_else(unlimited),
            position: VelocityFromPosition::new(velocity)?,
            // The reference may jump, and a slow planner gives stairs.
            error: VelocityFromPosition::new(VelocityFromPositionParameters {
                fastest: fastest * lit(JUMP),
                ..velocity
            })?,
            outlet: Outlet::new(output)?,
            contact,
            injection,
            micro_damping,
            deflection: T::zero(),
        })
    }

    /// The force for the coming sample, where only the position \[m\] is measured, beside its reference \[m\].
    ///
    /// The bristle follows the measured displacement, the curve is read at the filtered velocity, and ė is the filtered
    /// secant of e.
    ///
    /// After positions that were refused ė is the mean rate since the last good one. Where a position is believed to be elsewhere (see
    /// [`VelocityFromPosition::push`]) ė begins anew at zero. A reference that is no finite number, or for the first time farther off than a thousand
    /// times what the fastest speed allows, is refused, too; then the bristle follows the measured displacement without a correction.
    /// A jump of the reference by d that is not refused moves the estimate by up to k d, within its limit: give it smooth ones.
    #[inline]
    pub fn step(&mut self, position: T, reference: T) -> Compensation<T> {
        let reading = self.position.read(position);
        if reading == Reading::Refused {
            self.error.miss();
            return self.outlet.refuse();
        }
        if reading == Reading::Restarted {
            self.error.reset();
        }
        let error = position - reference;
        let tracked = self.error.push(error).is_some();
        let (secant, velocity) = (self.position.secant(), self.position.filtered());
        if !tracked {
            // The displacement is known, and would be lost.
            let still = Measured { velocity, error: T::zero(), error_rate: T::zero() };
            if let Some((deflection, _)) = self.estimate(secant, still) {
                self.deflection = deflection;
                self.outlet.moved(deflection);
            }
            return self.outlet.refuse();
        }
        let error_rate = self.error.filtered();
        self.advance(secant, Measured { velocity, error, error_rate })
    }

    /// The force for the coming sample, where the velocity is known too: the exact step over the sample that has
    /// ended with all three numbers held. A velocity beyond the fastest is refused.
    #[inline]
    pub fn step_measured(&mut self, measured: Measured<T>) -> Compensation<T> {
        if !(measured.velocity.abs() <= self.position.fastest()) {
            return self.outlet.refuse();
        }
        self.advance(measured.velocity, measured)
    }

    /// The deflection's estimate ẑ \[m\].
    pub fn deflection(&self) -> T {
        self.deflection
    }

    /// The answer to the last sample.
    pub fn last(&self) -> Compensation<T> {
        self.outlet.last()
    }

    /// The contact.
    pub fn contact(&self) -> &Contact<T, M> {
        &self.contact
    }

    /// Begins anew with an undeflected bristle; the next sample says where the mechanism is.
    pub fn reset(&mut self) {
        self.position.reset();
        self.error.reset();
        self.deflection = T::zero();
        self.outlet.reset(T::zero());
    }

    #[inline]
    fn advance(&mut self, secant: T, measured: Measured<T>) -> Compensation<T> {
        let Some((deflection, force)) = self.estimate(secant, measured) else {
            return self.outlet.refuse();
        };
        self.deflection = deflection;
        self.outlet.give(force, deflection)
    }

    /// Deflection \[m\] and force \[N\] after the sample, where they are finite.
    #[inline]
    fn estimate(&self, secant: T, measured: Measured<T>) -> Option<(T, T)> {
        let Measured { velocity, error, error_rate } = measured;
        let affine: Affine<T> = along(self.contact.model(), secant, velocity, self.deflection);
        let weights = affine.weights(self.position.sample_time());
        // What the injection takes from the bristle's rate and from the friction coefficient.
        let (rate, coefficient) = match self.injection {
            Injection::Velocity { gain, corner } => {
                let injected = gain * (error_rate + corner * error);
                (affine.drive * injected, affine.damping * injected)
            }
            Injection::Position { gain } => (gain * error, self.micro_damping * gain * error),
        };
        let drive = affine.drive * secant - rate;
        let deflection = T::end(&weights, self.deflection, drive).within(self.limit);
        let force =
            self.contact.normal_force() * (affine.coefficient(velocity, deflection) - coefficient);
        (deflection.is_finite() && force.is_finite()).then_some((deflection, force))
    }
}
