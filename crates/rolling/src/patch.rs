//! A contact patch: bristles of one model along a length, under a pressure.

use super::Pressure;
use super::axes::{OfAxes, PatchModel};
use bristle::parameter::{Checked, Named, ParameterError, Rule};
use bristle::scalar::is_zero;
use bristle::{Affine, Bristle, Contact, Form, LoadChange, Scalar};

/// The coefficients of a model at a velocity, if they are finite and λ is not negative: a bad one
/// would stay in the patch.
#[inline]
pub(super) fn coefficients<T: Scalar, M: Bristle<T, Deflection = T>>(
    contact: &Contact<T, M>,
    velocity: T,
) -> Checked<Affine<T>> {
    of_velocity(contact.model())?;
    checked(contact.affine(velocity, T::zero()))
}

/// The coefficients of a contact at a velocity and their slopes; none without a load.
#[inline]
pub(super) fn slopes<T: Scalar, M: Bristle<T, Deflection = T>>(
    contact: &Contact<T, M>,
    velocity: T,
) -> (Affine<T>, Affine<T>) {
    let surface = contact.surface(velocity);
    if is_zero(surface.scale()) {
        return (Affine::none(), Affine::none());
    }
    contact.model().affine_and_slopes(surface, T::zero())
}

/// Refuses a model whose coefficients depend on its deflection.
#[inline]
pub(super) fn of_velocity<T: Scalar, M: Bristle<T>>(model: &M) -> Checked<()> {
    if model.form() == Form::OfVelocity {
        return Ok(());
    }
    let takes = "a patch takes models whose Bristle::form is Form::OfVelocity";
    Err(ParameterError::chosen(model.name(), takes))
}

/// Coefficients, if they are finite and λ is not negative.
#[inline]
pub(super) fn checked<T: Scalar>(affine: Affine<T>) -> Checked<Affine<T>> {
    let Affine { relaxation, drive, stiffness, damping } = affine;
    let name = "relaxation rate of the friction model";
    finite(name, relaxation)?;
    finite("drive of the friction model", drive)?;
    finite("stiffness of the friction model", stiffness)?;
    finite("damping of the friction model", damping)?;
    Named(name, relaxation).at_least("zero", T::zero())?;
    Ok(affine)
}

/// A computed number of any magnitude, if it is finite.
#[inline]
pub(super) fn finite<T: Scalar>(name: &'static str, value: T) -> Checked<T> {
    Named(name, value).check(value.is_finite(), Rule::Finite)
}

/// Parameters of [`Patch`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct PatchParameters<T, M, P> {
    /// Friction model of the bristles.
    pub model: M,
    /// Length L of the patch \[m\], positive.
    pub length: T,
    /// Pressure p(ξ) [N/m]: normal force per length, at which the stiffness was measured.
    /// [`Patch::under_load`] gives another one of this form.
    pub pressure: P,
}

/// Bristles of a model M along a length, under a pressure P.
///
/// ```
/// use bristle_rolling::{Motion, Patch, PatchParameters, PolynomialExponential};
/// use bristle::{FrBd, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
///
/// let curve = Stribeck::new(paper::TYRE_CURVE)?;
/// let friction = FrBd::new(curve, KelvinVoigt::new(paper::TYRE_BRISTLE)?);
/// let tyre = Patch::new(PatchParameters {
///     model: friction,
///     length: 0.1,                                  // m
///     pressure: PolynomialExponential::parabolic(),
/// })?
/// .under_load(4000.0)?; // N
///
/// // Rolling at 16 m/s with 0.8 m/s of slip.
/// let motion = Motion { slip_velocity: 0.8, rolling_speed: 16.0 };
/// assert!((motion.slip_ratio() - 0.05_f64).abs() < 1e-15);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch<T, M, P> {
    pub(super) contact: Contact<T, M>,
    length: T,
    pressure: P,
    /// L ∫p dξ of the pressure as it was given \[N\].
    given: T,
    /// The reference load over it.
    pub(super) factor: T,
}

impl<T: Scalar, M, P: Pressure<T>> Patch<T, M, P> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses a length that is not positive.
    pub fn new(parameters: PatchParameters<T, M, P>) -> Checked<Self> {
        let PatchParameters { model, length, pressure } = parameters;
        let length = Named("length", length).positive()?;
        let given = Named("total pressure", length * pressure.total()).non_negative()?;
        let contact = Contact::new(model, given)?;
        Ok(Self { contact, length, pressure, given, factor: T::one() })
    }

    /// This patch under a normal force F_z \[N\], zero or positive, at which its stiffness was
    /// measured: it is the reference load, too.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite, and a pressure that carries nothing.
    pub fn under_load(mut self, normal_force: T) -> Checked<Self> {
        self.renew_load(normal_force)?;
        Ok(self)
    }

    /// The patch whose stiffness and damping belong to another load P \[N\] than its normal force,
    /// see [`Contact::measured_at`].
    ///
    /// # Errors
    ///
    /// Refuses a reference load that is not positive, and a pressure that carries nothing.
    pub fn measured_at(self, reference_load: T) -> Checked<Self> {
        let factor = reference_load / Named("total pressure", self.given).positive()?;
        Ok(Self { contact: self.contact.measured_at(reference_load)?, factor, ..self })
    }

    /// Makes the normal force the reference load, too.
    pub(super) fn renew_load(&mut self, normal_force: T) -> Checked<LoadChange<T>> {
        Named("normal_force", normal_force).non_negative()?;
        let given = Named("total pressure", self.given).positive()?;
        self.factor = normal_force / given;
        self.contact.renew_load(normal_force)
    }

    /// The friction model under the normal force F_z and the reference load.
    pub fn contact(&self) -> &Contact<T, M> {
        &self.contact
    }

    /// The friction model.
    pub fn model(&self) -> &M {
        self.contact.model()
    }

    /// This patch with another friction model.
    #[inline]
    pub(super) fn with_model<K>(&self, model: K) -> Patch<T, K, P> {
        let Self { length, given, factor, .. } = *self;
        let (contact, pressure) = (self.contact.with_model(model), self.pressure.clone());
        Patch { contact, length, pressure, given, factor }
    }

    /// Length L \[m\].
    pub fn length(&self) -> T {
        self.length
    }

    /// The pressure as it was given. Its form is that under every load.
    pub fn pressure(&self) -> &P {
        &self.pressure
    }

    /// The normal force F_z \[N\].
    pub fn normal_force(&self) -> T {
        self.contact.normal_force()
    }

    /// The transport velocity V = U/L \[1/s\], crossings of the patch per second, if the patch
    /// rolls forward or stands. Below the smallest parameter a speed is none, and its arithmetic
    /// with subnormal numbers is slow.
    #[inline]
    fn transport(&self, rolling_speed: T) -> Checked<T> {
        let rolling_speed = Named("rolling_speed", rolling_speed).non_negative()?;
        let stands = rolling_speed < Named::smallest();
        let rolling_speed = if stands { T::zero() } else { rolling_speed };
        Named("rolling_speed", rolling_speed / self.length).finite()
    }

    /// The motion of each axis and the coefficients at it, if they are those of a patch.
    #[inline]
    pub(super) fn frozen<V: OfAxes<T, A>, const A: usize>(
        &self,
        motion: Motion<V, T>,
    ) -> Checked<[Frozen<T>; A]>
    where
        M: PatchModel<T, V, A>,
    {
        let slip_velocity = motion.slip_velocity.finite("slip_velocity")?;
        let transport = self.transport(motion.rolling_speed)?;
        let axes = M::each(&self.contact, slip_velocity, |_, contact, slip_velocity| {
            let affine = coefficients(contact, slip_velocity);
            affine.map(|affine| Frozen { affine, slip_velocity, transport })
        });
        let mut all = [Frozen { affine: Affine::none(), slip_velocity: T::zero(), transport }; A];
        for (frozen, axis) in all.iter_mut().zip(axes) {
            *frozen = axis?;
        }
        Ok(all)
    }

    /// The transport velocity of a motion that is finite, if the patch rolls forward.
    pub(super) fn rolling(&self, motion: Motion<T>) -> Checked<T> {
        Named("rolling_speed", motion.rolling_speed).positive()?;
        Named("slip_velocity", motion.slip_velocity).finite()?;
        self.transport(motion.rolling_speed)
    }
}

/// How two bodies move on each other at a contact patch (what a log measured is an
/// `identify::Motion`): two numbers, held over a step, two signals
/// of the time for [`ExactPatch::follow`](super::ExactPatch::follow), or two functions of the place
/// ξ \[–\] and of the time since the step's start \[s\] for `Grid::step_field`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion<S, W = S> {
    /// Slip velocity v [m/s]: velocity of the body's surface over the ground if neither were
    /// elastic (the rigid sliding velocity). The friction force opposes it.
    pub slip_velocity: S,
    /// Rolling speed U [m/s] at which bristles cross the patch. For a wheel it is ωR. Only a grid
    /// also takes negative ones.
    pub rolling_speed: W,
}

impl<T: Scalar> Motion<T> {
    /// The slip ratio v/U \[–\]; infinite for a patch that slides without rolling.
    pub fn slip_ratio(self) -> T {
        self.slip_velocity / self.rolling_speed
    }
}

/// The coefficients of all bristles over a step, and what moves them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frozen<T: Scalar> {
    pub(super) affine: Affine<T>,
    /// v [m/s]
    pub(super) slip_velocity: T,
    /// V \[1/s\]
    pub(super) transport: T,
}

impl<T: Scalar> Frozen<T> {
    /// u = r v [m/s]
    #[inline]
    pub(super) fn drive(&self) -> T {
        self.affine.drive * self.slip_velocity
    }
}
