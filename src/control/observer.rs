//! An observer of the bristle's deflection, corrected by the tracking error.
//!
//! The loop: m v̇ = u − F, with a reference x_ref, its acceleration a_ref, the tracking error
//! e = x − x_ref, and
//!
//! u = m a_ref − K_p e − K_d ė − K_i ∫e dt + F̂.
//!
//! The observer is the friction model with its coefficients at the measured velocity,
//! F = P (c₀ z + c₂ v), ż = −λ z + r v, and a correction, in one of two ways:
//!
//! | [`Injection`] | estimate | condition |
//! |---|---|---|
//! | `Velocity` | dẑ/dt = −λẑ + r w, F̂ = P (c₀ẑ + c₂w), w = v − k(ė + αe) | K_d > αm, K_i < αK_p |
//! | `Position` | dẑ/dt = −λ ẑ + r v − k e, F̂ = P (c₀ ẑ + c₂ v − σ1 k e) | both with α = σ0/σ1 |
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | z, ẑ, z̃ = z − ẑ | deflection, its estimate, the estimate's error | m |
//! | F̂, F̃ = F − F̂ | estimate of the friction force, its error | N |
//! | e, ė, E = ∫e dt | tracking error, its rate, its integral | m, m/s, m s |
//! | K_p, K_d, K_i | gains of the controller | N/m, N s/m, N/(m s) |
//! | k | gain of the injection: by velocity –, by position 1/s | |
//! | α | corner rate of the injection | 1/s |
//! | y = ė + α e | what is injected by velocity | m/s |
//! | m | mass | kg |
//! | p, P | normal force; reference load, p if that is constant | N |
//! | λ, r, c₀, c₂, K | coefficients of the model and stiffness of its storage, see [`Affine`] | |
//! | σ0, σ1, σ2 | micro-stiffness, micro-damping, viscous friction | 1/m, s/m, s/m |
//!
//! # Why it converges
//!
//! *By velocity.* Subtract: dz̃/dt = −λ z̃ + r (k y), F̃ = P (c₀ z̃ + c₂ (k y)). The error is a
//! friction element of its own, whose velocity is k y and whose coefficients vary in time as
//! λ(v(t)) does. Let W̃ = ½ P K z̃². Then
//!
//! k F̃ y − dW̃/dt = P (K λ z̃² + (c₀ − K r) z̃ (k y) + c₂ (k y)²) = Q.
//!
//! For FrBD c₀ = K r, and Q ≥ 0 whatever v(t) is: the error of an FrBD observer is passive because
//! the model is, for every curve, σ0, σ1 and k > 0. For LuGre at p = P c₀ − K r = −σ1 λ, and Q ≥ 0
//! for all z̃, y if and only if σ1² λ(v) ≤ 4 σ0 (σ1 + σ2), that is up to a certain speed.
//!
//! The loop answers with m ë + K_d ė + K_p e + K_i E = −F̃. With
//!
//! V = ½ m ė² + α m e ė + ½ (K_p + α K_d) e² + K_i e E + ½ α K_i E²,
//!
//! dV/dt = −(K_d − α m) ė² − (α K_p − K_i) e² − F̃ y, and V > 0 under the conditions of the table.
//! In other words (s + α)/(m s² + K_d s + K_p + K_i/s), with the Laplace variable s, is positive
//! real, strictly so without K_i.
//!
//! Add the two: W̃/k + V never rises, and falls as long as e or ė is not zero, so that e, ė → 0.
//! Where λ = 0, in a standing bristle, z̃ stays as it is once e is zero: then F̃ is balanced by K_i
//! E, and is zero without K_i.
//!
//! *By position*, as Canudas de Wit and others did for LuGre: dz̃/dt = −λ z̃ + k e, F̃ = P (σ0 z̃ +
//! σ1 dz̃/dt), so that e = −G z̃ with G = P (σ1 s + σ0)/(m s² + K_d s + K_p + K_i/s). It converges
//! if G is strictly positive real. Because c₀ = σ0 − σ1 λ in FrBD as well, and r and the velocity
//! drop out of the difference, the theorem holds for FrBD unchanged; for LuGre,
//! whose σ1 follows the load, at p = P.
//!
//! From Re G(jω) ∝ σ0 K_p − σ1 K_i + ω² (σ1 K_d − σ0 m) follow the conditions: the bristle's own
//! corner σ0/σ1 takes the place of α. With K_i > 0, G is zero at ω = 0 and only positive real: the
//! theorem then does not say that e vanishes, only that it stays bounded. The
//! corner is mostly high, and the condition K_d > m σ0/σ1 hard to meet.
//!
//! # In samples
//!
//! With v, y and e held over a sample the step of ẑ is exact. By velocity therefore
//!
//! h k F̃̄ y = ΔW̃ + h Q̄ with Q̄ ≥ 0
//!
//! (a bar is the mean over the sample) for every sample time: the observer never gives energy, and
//! without a tracking error z̃ never grows. By position z̃ never grows without a tracking error,
//! and is at most e^(−λh) z̃ + k h e.
//!
//! The estimate is cut to the deflection's limit, which the true deflection obeys: this only brings
//! the two together.
//!
//! The sampled *loop* is not proven stable by this: the controller's own hold and delay are not in
//! it. A mechanism whose tracking error is solved implicitly loses no passivity by them, and there
//! W̃/k + V never rises at any sample time. Otherwise keep the bandwidth at a tenth of the sample
//! rate or less.
//!
//! The theorems assume a share of one, an actuator within its limit, and a model that fits. A
//! friction force that differs from the model's is a disturbance. The estimate stays within its
//! limit, so that F̃ is bounded except for the part c₂ k y, which acts like more K_d and K_p. The
//! tracking error is then bounded, too.
//!
//! Source: Canudas de Wit et al., IEEE TAC 40 (1995), 419–425, section on observer-based
//! compensation, for the injection by position with LuGre. Injection by velocity, and both with
//! FrBD: from the affine form, as above.

use super::output::{Compensation, Output, OutputParameters};
use super::velocity_from_position::{
    MotionSample, VelocityFromPosition, VelocityFromPositionParameters, along,
};
use crate::parameter::{Checked, Named, ParameterError};
use crate::rheology::{Deflection, HeldWeights};
use crate::scalar::{is_zero, lit};
use crate::{Affine, Bristle, Contact, Form, Law, Scalar};

/// How the tracking error e \[m\] corrects the estimate ẑ of a [`FrictionObserver`]: in one of two
/// ways, each with a gain k.
///
/// Take `Velocity`: its corner α is yours to choose, and so its condition K_d > α m can be met.
/// `Position` is the classical injection, to reproduce the literature. There the bristle's own
/// corner σ0/σ1 is α, which is mostly too high.
///
/// The theorems hold for every k > 0. For its size look at a bristle that stands (λ = 0): in FrBD,
/// with a share of one, the estimate then adds to the gains of the controller
///
/// | | K_p [N/m] | K_d [N s/m] | K_i [N/(m s)] |
/// |---|---|---|---|
/// | `Velocity` | P k (σ0 + α σ1) | P k σ1 | P k α σ0 |
/// | `Position` | P k σ1 | – | P k σ0 |
///
/// until ẑ is at its limit. Choose k so that the sums are gains that you would give the controller
/// at this sample time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub enum Injection<T> {
    /// The bristle is driven with the velocity w = v − k (ė + α e) instead of v.
    Velocity {
        /// Gain k \[–\], positive. Begin with 0.05; larger while the force stays smooth, because
        /// k multiplies the noise of ė.
        gain: T,
        /// Corner rate α [1/s], K_i/K_p < α < K_d/m. Begin with 0.7 K_d/m. Of errors faster than α
        /// it is ė that corrects, of slower ones e.
        corner: T,
    },
    /// k e is taken from the rate of the deflection (Canudas de Wit and others).
    Position {
        /// Gain k [1/s], positive. It corrects a standing bristle as fast as `Velocity` does with
        /// k α of the same size.
        gain: T,
    },
}

impl<T: Scalar> Injection<T> {
    /// α, or what stands in its place, and σ1: of a model for which the theorem holds.
    fn corner<M>(&self, model: &M, fastest: T) -> Checked<(T, T)>
    where
        M: Bristle<T, Deflection = T>,
    {
        let stiffness = model.storage_stiffness();
        let known = model.characteristics(fastest);
        let (micro_damping, viscous) = known.map_or((T::zero(), T::zero()), |known| {
            (known.micro_damping.max, known.viscous_friction)
        });
        let corner = match *self {
            Self::Velocity { gain, corner } => {
                Named("gain", gain).positive()?;
                if !(model.obeys(Law::Secant) && model.obeys(Law::Passivity)) {
                    let as_in_lugre = fits(model, fastest, |a| {
                        let elastic = stiffness * a.drive - micro_damping * a.relaxation;
                        [(a.stiffness, elastic), (a.damping, micro_damping + viscous)]
                    });
                    if !as_in_lugre {
                        let takes = "an observer takes models that obey Law::Secant and \
                                     Law::Passivity, and those of LuGre's coefficients with the \
                                     σ1 and σ2 of Bristle::characteristics";
                        return Err(ParameterError::chosen(model.name(), takes));
                    }
                    if !is_zero(micro_damping) {
                        // D is a sum of squares up to this relaxation rate.
                        let limit = lit::<T>(4.0) * stiffness * (micro_damping + viscous)
                            / (micro_damping * micro_damping);
                        let limits = model.limits(fastest);
                        let fastest = limits.relaxation_rate.unwrap_or_else(T::unlimited);
                        Named("relaxation rate at the fastest speed", fastest)
                            .at_most("4 σ0 (σ1 + σ2)/σ1²", limit)?;
                    }
                }
                Named("corner", corner).positive()?
            }
            Self::Position { gain } => {
                Named("gain", gain).positive()?;
                if known.is_none() {
                    let takes = "Injection::Position takes models that give their σ1 by \
                                 Bristle::characteristics (Injection::Velocity does without)";
                    return Err(ParameterError::chosen(model.name(), takes));
                }
                let damping = Named("micro_damping", micro_damping);
                let rule = "be positive for Injection::Position, as its α is σ0/σ1; \
                            Injection::Velocity does without";
                damping.stated(micro_damping > T::zero(), rule)?;
                let corner = stiffness / damping.positive()?;
                let elastic = |a: Affine<T>| stiffness - micro_damping * a.relaxation;
                if !fits(model, fastest, |a| [(a.stiffness, elastic(a))]) {
                    let takes = "an observer by position takes models whose c₀ is σ0 − σ1 λ";
                    return Err(ParameterError::chosen(model.name(), takes));
                }
                corner
            }
        };
        Ok((corner, micro_damping))
    }
}

/// Parameters of a [`FrictionObserver`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct ObserverParameters<T: Scalar, M> {
    /// Friction under its normal force.
    pub contact: Contact<T, M>,
    /// Mass m \[kg\] of what the controller moves, positive.
    pub mass: T,
    /// Gain K_p [N/m] of the controller on the tracking error e, positive.
    pub proportional_gain: T,
    /// Gain K_d [N s/m] of the controller on ė, positive. A linear damping d [N s/m] of the
    /// mechanism that is not in the friction model may be added here, if the controller feeds
    /// d v_ref forward beside m a_ref.
    pub derivative_gain: T,
    /// Gain K_i [N/(m s)] of the controller on the integral of e, zero for none.
    pub integral_gain: T,
    /// How the tracking error corrects the estimate.
    pub injection: Injection<T>,
    /// The encoder: sample time, filter of the velocity, fastest speed, size of a count. LuGre's
    /// condition and the limit of the deflection depend on the fastest speed.
    pub velocity: VelocityFromPositionParameters<T>,
    /// Share η and largest force. The theorems assume a share of one.
    pub output: OutputParameters<T>,
}

/// Velocity and tracking error at a sample, for [`FrictionObserver::step_measured`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured<T> {
    /// Mean velocity v [m/s] over the past sample.
    pub velocity: T,
    /// Tracking error e = x − x_ref \[m\].
    pub error: T,
    /// Its rate ė [m/s].
    pub error_rate: T,
}

/// Whether the coefficients of a model are what a theorem takes them to be, but for roundings: at
/// forty speeds from the fastest down to some 1e-4 of it, in both directions.
fn fits<T: Scalar, M: Bristle<T, Deflection = T>, const N: usize>(
    model: &M,
    fastest: T,
    pairs: impl Fn(Affine<T>) -> [(T, T); N],
) -> bool {
    let mut velocity = fastest;
    (0..80).all(|_| {
        let affine = model.affine(velocity.into(), T::zero());
        velocity *= lit(-0.9);
        // Of what cancels to c₀, too.
        let terms = model.storage_stiffness() * (T::one() + affine.drive.abs());
        let rounding = T::default_epsilon() * lit(64.0);
        pairs(affine).iter().all(|(got, want)| {
            let largest = terms.larger(got.abs()).larger(want.abs());
            (*got - *want).abs() <= rounding * largest
        })
    })
}

/// Largest jump of the reference in one sample, over the displacement at the fastest speed: a
/// planner a thousand times slower than the loop asks for that much. A larger jump is refused as a
/// fault the first time.
const JUMP: f64 = 1e3;

/// Compensation by an observer of the deflection: η F̂. Its bristle follows the measured
/// displacement and is corrected by the tracking error, as [`Injection`] says; the
/// [module](self) has the formula of F̂. It is for a PID controller with the feed-forward m a_ref:
/// given its gains, [`new`](Self::new) checks the conditions under which the tracking error
/// vanishes (by position with K_i > 0: stays bounded).
///
/// | call each sample | with |
/// |---|---|
/// | [`step`](Self::step) | position and reference |
/// | [`advance`](Self::advance) | differences of counts, for `f32` |
/// | [`step_measured`](Self::step_measured) | a velocity, e and ė of your own |
///
/// ```
/// use bristle::control::{
///     FrictionObserver, Injection, ObserverParameters, OutputParameters,
///     VelocityFromPositionParameters,
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
///     velocity: VelocityFromPositionParameters {
///         sample_time: 1e-3,
///         time_constant: 2e-3,
///         fastest: 0.5,
///         count: 0.0,
///     },
///     output: OutputParameters { share: 1.0, largest_force: 3.0 },
/// };
/// let mut observer = FrictionObserver::new(parameters)?;
/// let _ = observer.step(0.0, 0.0); // position and reference at the start
/// let mut force = 0.0;
/// for sample in 1..=50 {
///     let reference = 1e-5 * f64::from(sample); // m: 10 mm/s
///     force = observer.step(0.98 * reference, reference).force; // a little behind it
/// }
/// assert!(force > 1.0 && observer.deflection() > 0.0); // N, of the 1.5 N that break away
///
/// // The classical injection needs K_d > m σ0/σ1.
/// let classical = Injection::Position { gain: 0.1 };
/// let refused = FrictionObserver::new(ObserverParameters { injection: classical, ..parameters });
/// let refused = refused.unwrap_err().to_string();
/// assert!(refused.starts_with("corner × mass is 155.03"));
/// assert!(refused.ends_with("below derivative_gain = 30"));
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionObserver<T, M> {
    injection: Injection<T>,
    /// σ1
    micro_damping: T,
    limit: T,
    position: VelocityFromPosition<T>,
    error: VelocityFromPosition<T>,
    output: Output<T, M>,
}

impl<T: Scalar, M: Bristle<T, Deflection = T>> FrictionObserver<T, M> {
    /// Checks the parameters and the conditions under which the closed loop converges. The bristle
    /// starts undeflected.
    ///
    /// # Errors
    ///
    /// Refuses parameters out of their ranges, α m ≥ K_d, and K_i ≥ α K_p. [`Injection::Position`]
    /// needs σ1 > 0, and has α = σ0/σ1. With [`Injection::Velocity`], LuGre is refused if the
    /// fastest speed breaks σ1² λ ≤ 4 σ0 (σ1 + σ2). Refuses a model whose difference from an
    /// estimate is not linear (its [`Form`] is not [`Form::OfVelocity`]). Of the others
    ///
    /// - by velocity it takes those that obey [`Law::Secant`] and [`Law::Passivity`] (Dahl, FrBD of
    ///   constant stiffness), and those with LuGre's c₀ = K r − σ1 λ and c₂ = σ1 + σ2;
    /// - by position those with c₀ = σ0 − σ1 λ (FrBD with a Kelvin–Voigt bristle, LuGre), σ1 > 0.
    ///
    /// The σ1 and σ2 are those of [`Bristle::characteristics`].
    pub fn new(parameters: ObserverParameters<T, M>) -> Checked<Self> {
        let ObserverParameters { contact, injection, velocity, output, .. } = parameters;
        let fastest = Named("fastest", velocity.fastest).positive()?;
        let mass = Named("mass", parameters.mass).positive()?;
        let proportional = Named("proportional_gain", parameters.proportional_gain).positive()?;
        let derivative = Named("derivative_gain", parameters.derivative_gain).positive()?;
        let integral = Named("integral_gain", parameters.integral_gain).non_negative()?;
        let model = contact.model();
        if model.form() != Form::OfVelocity {
            let takes = "an observer takes models whose Bristle::form is Form::OfVelocity";
            return Err(ParameterError::chosen(model.name(), takes));
        }
        let (corner, micro_damping) = injection.corner(model, fastest)?;
        Named("corner × mass", corner * mass).below("derivative_gain", derivative)?;
        let most = corner * proportional;
        Named("integral_gain", integral).below("corner × proportional_gain", most)?;
        Ok(Self {
            limit: model.limits(fastest).deflection.unwrap_or_else(T::unlimited),
            position: VelocityFromPosition::new(velocity)?,
            // The reference may jump: a slow planner gives a staircase.
            error: VelocityFromPosition::new(VelocityFromPositionParameters {
                fastest: fastest * lit(JUMP),
                ..velocity
            })?,
            output: Output::new(contact, output)?,
            injection,
            micro_damping,
        })
    }

    /// The force for the coming sample, from a measured position and its reference \[m\].
    ///
    /// The bristle follows the measured displacement, the curve is read at the filtered velocity,
    /// and ė is the filtered rate of e.
    ///
    /// After refused positions ė is the mean rate since the last good one. After a restart (see
    /// [`VelocityFromPosition::step`]) ė starts again at zero.
    ///
    /// A reference is refused if it is not finite, or if e jumps in one sample by more than a
    /// thousand times what the fastest speed allows. The bristle then follows the measured
    /// displacement without a correction. A next e that is as near to the refused one confirms the
    /// jump and is taken; ė stays as it was before the jump. A jump by d that is not refused moves
    /// the estimate by up to k d, within its limit: give the observer smooth references.
    #[inline]
    pub fn step(&mut self, position: T, reference: T) -> Compensation<T> {
        let moved = self.position.step(position);
        self.track(moved, position - reference)
    }

    /// The force for the coming sample, from a displacement since the last call and the tracking
    /// error e = x − x_ref now \[m\]: in `f32`, both are differences of counts times the size of a
    /// count.
    ///
    /// The observer remembers the displacements that it refused, see
    /// [`VelocityFromPosition::advance`]: after a glitch and the way back from it the estimate has
    /// followed the mechanism. A tracking error is refused as the reference of
    /// [`FrictionObserver::step`] is.
    #[inline]
    pub fn advance(&mut self, displacement: T, error: T) -> Compensation<T> {
        let moved = self.position.advance(displacement);
        self.track(moved, error)
    }

    /// Moves the estimate, or refuses the sample.
    #[inline]
    fn track(&mut self, moved: Option<MotionSample<T>>, error: T) -> Compensation<T> {
        let Some(moved) = moved else {
            self.error.miss();
            return self.output.refuse();
        };
        if moved.restarted {
            self.error.reset();
        }
        let (velocity, secant) = (moved.velocity, moved.secant);
        let Some(tracked) = self.error.step(error) else {
            let error = T::zero();
            let (deflection, _) =
                self.estimate(secant, Measured { velocity, error, error_rate: error });
            return self.output.refuse_and_move(deflection);
        };
        self.follow(secant, Measured { velocity, error, error_rate: tracked.velocity })
    }

    /// The force for the coming sample, from a velocity v, an error e and a rate ė of your own: for
    /// a loop with a tachometer or a state estimator, or a simulation. Nothing is filtered.
    ///
    /// The bristle takes the exact step over the past sample, with the three numbers held: it moves
    /// with v h. The error of v adds up in it, so take [`FrictionObserver::step`] where there is a
    /// position. Refused are numbers that are not finite, and a velocity beyond the fastest; the
    /// motion of such a sample is lost. Do not mix it with `step` or `advance`.
    #[inline]
    pub fn step_measured(&mut self, measured: Measured<T>) -> Compensation<T> {
        if !(measured.velocity.abs() <= self.position.fastest) {
            return self.output.refuse();
        }
        self.follow(measured.velocity, measured)
    }

    /// The estimate ẑ of the deflection \[m\].
    pub fn deflection(&self) -> T {
        self.output.last.deflection
    }

    /// Changes the normal force \[N\], zero or positive, before a sample: that at its middle, as
    /// measured or computed. A deflection that it no longer holds is cut, see
    /// [`Contact::reload`].
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite; nothing has changed.
    #[inline]
    pub fn reload(&mut self, normal_force: T) -> Checked<()> {
        self.output.reload(normal_force)
    }

    /// Takes other parameters between two samples: another model, load, share or limit. The
    /// estimate, position, velocity and error are kept, and the conditions are checked again.
    ///
    /// The deflection stays as it is: with another stiffness the elastic force jumps by the ratio
    /// of the two, and the stored energy with it. For a load that varies see
    /// [`FrictionObserver::reload`], which is passive.
    ///
    /// # Errors
    ///
    /// Those of [`FrictionObserver::new`]; nothing has changed.
    pub fn change(&mut self, parameters: ObserverParameters<T, M>) -> Checked<()> {
        let new = Self::new(parameters)?;
        *self = Self {
            position: new.position.after(&self.position),
            error: new.error.after(&self.error),
            output: new.output.after(&self.output),
            ..new
        };
        Ok(())
    }

    /// The contact, with its model and its present load.
    pub fn contact(&self) -> &Contact<T, M> {
        &self.output.contact
    }

    /// Back to the beginning: an undeflected bristle; the next sample is the initial position. Call
    /// it while a brake holds the axis.
    pub fn reset(&mut self) {
        self.position.reset();
        self.error.reset();
        self.output.reset();
    }

    #[inline]
    fn follow(&mut self, secant: T, measured: Measured<T>) -> Compensation<T> {
        let (deflection, force) = self.estimate(secant, measured);
        self.output.answer(force, measured.velocity, deflection)
    }

    /// Deflection \[m\] and force \[N\] after the sample.
    #[inline]
    fn estimate(&self, secant: T, measured: Measured<T>) -> (T, T) {
        let Measured { velocity, error, error_rate } = measured;
        let before = self.output.last.deflection;
        let affine: Affine<T> = along(&self.output.contact, secant, velocity, before);
        let weights = affine.weights(self.position.sample_time);
        // What the injection takes from the bristle's rate and from the friction coefficient.
        let (rate, coefficient) = match self.injection {
            Injection::Velocity { gain, corner } => {
                let injected = gain * (error_rate + corner * error);
                (affine.drive * injected, affine.damping * injected)
            }
            Injection::Position { gain } => (gain * error, self.micro_damping * gain * error),
        };
        let drive = affine.drive * secant - rate;
        let limit = self.output.contact.surface(velocity).apply(self.limit);
        let deflection = weights.end(before, drive).within(limit);
        let friction = affine.coefficient(velocity, deflection) - coefficient;
        let force = self.output.contact.reference_load() * friction;
        (deflection, force)
    }
}
