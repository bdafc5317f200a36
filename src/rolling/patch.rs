//! A contact patch: bristles of one model along a length, under a pressure.

use super::Pressure;
use crate::bounds::larger;
use crate::curve::FrictionCurve;
use crate::parameter::{self, ParameterError, Rule};
use crate::regularisation::Regularisation;
use crate::rheology::{KelvinVoigt, Rheology, VelocityLaw};
use crate::scalar::{is_zero, to_f64};
use crate::{Affine, Bristle, Dahl, FrBd, LuGre, Scalar, Sliding};

/// A friction model with one deflection whose coefficients depend on the velocity alone, so that all
/// bristles of a patch share them. Every model of this crate but the elasto-plastic one, which
/// switches with its deflection.
pub trait RateDependent<T: Scalar>: Bristle<T, Deflection = T> {
    /// The four coefficients at a velocity.
    #[inline]
    fn at_velocity(&self, sliding: impl Into<Sliding<T>>) -> Affine<T> {
        self.affine(sliding.into(), T::zero())
    }

    /// What |c₀| and |c₂| do not exceed at velocities with |v| ≤ `fastest`; infinite if there is no such
    /// limit.
    fn output_limits(&self, fastest: T) -> OutputLimits<T> {
        let _ = fastest;
        let unlimited = T::one() / T::zero();
        OutputLimits { stiffness: unlimited, damping: unlimited }
    }
}

/// How strongly a model's deflection and velocity act on its friction coefficient, see
/// [`RateDependent::output_limits`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputLimits<T> {
    /// Largest |c₀| [1/m].
    pub stiffness: T,
    /// Largest |c₂| [s/m].
    pub damping: T,
}

impl<T, C, R, E> RateDependent<T> for FrBd<C, R, E>
where
    T: Scalar,
    C: FrictionCurve<T>,
    R: Rheology<T, Deflection = T>,
    E: Regularisation<T>,
{
    fn output_limits(&self, _fastest: T) -> OutputLimits<T> {
        // c₀ = σ0 r and c₂ = σ1 r with 0 < r ≤ 1.
        OutputLimits {
            stiffness: self.rheology().stiffness_bounds().max,
            damping: self.rheology().damping_bounds().max,
        }
    }
}

impl<T, C, D, E> RateDependent<T> for LuGre<C, KelvinVoigt<T, T, D>, E, T>
where
    T: Scalar,
    C: FrictionCurve<T>,
    D: VelocityLaw<T>,
    E: Regularisation<T>,
{
    fn output_limits(&self, fastest: T) -> OutputLimits<T> {
        let stiffness = self.storage_stiffness();
        let damping = self.rheology().damping_bounds().max;
        // c₀ = σ0 − σ1λ lies between σ0 − max σ1 max λ and σ0.
        let lowest = match self.limits(fastest).relaxation_rate {
            _ if is_zero(damping) => stiffness,
            Some(rate) => stiffness - damping * rate,
            None => -T::one() / T::zero(),
        };
        OutputLimits {
            stiffness: larger(stiffness, -lowest),
            damping: damping + self.viscous_friction(),
        }
    }
}

impl<T: Scalar> RateDependent<T> for Dahl<T> {
    fn output_limits(&self, _fastest: T) -> OutputLimits<T> {
        OutputLimits { stiffness: self.storage_stiffness(), damping: T::zero() }
    }
}

/// The coefficients of a model at a velocity, if they are numbers and its bristles relax: what is not one
/// would stay in a patch.
#[inline]
pub(crate) fn coefficients<T: Scalar, M: RateDependent<T>>(
    model: &M,
    velocity: T,
) -> Result<Affine<T>, ParameterError> {
    checked(model.at_velocity(velocity))
}

/// The same of coefficients that are there already.
#[inline]
pub(super) fn checked<T: Scalar>(affine: Affine<T>) -> Result<Affine<T>, ParameterError> {
    let Affine { relaxation, drive, stiffness, damping } = affine;
    if relaxation >= T::zero() && (relaxation + drive + stiffness + damping).is_finite() {
        return Ok(affine);
    }
    let named = [
        ("relaxation rate of the friction model", relaxation),
        ("drive of the friction model", drive),
        ("stiffness of the friction model", stiffness),
        ("damping of the friction model", damping),
    ];
    for (name, value) in named {
        if !value.is_finite() {
            let rule = Rule::Finite;
            return Err(ParameterError { name, component: None, value: to_f64(value), rule });
        }
    }
    if !(relaxation >= T::zero()) {
        parameter::non_negative("relaxation rate of the friction model", relaxation)?;
    }
    Ok(affine)
}

/// Parameters of [`Patch`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatchParameters<T, M, P> {
    /// Friction model of the bristles.
    pub model: M,
    /// Length L of the patch \[m\], positive.
    pub length: T,
    /// Pressure p(ξ) [N/m]: normal force per length.
    pub pressure: P,
}

/// Bristles of a model M along a length, under a pressure P.
///
/// ```
/// use bristle::rolling::{Motion, Patch, PatchParameters, PolynomialExponential};
/// use bristle::{FrBd, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
///
/// let friction = FrBd::new(Stribeck::new(paper::TYRE_CURVE)?, KelvinVoigt::new(paper::TYRE_BRISTLE)?);
/// let tyre = Patch::new(PatchParameters {
///     model: friction,
///     length: 0.1,                                  // m
///     pressure: PolynomialExponential::parabolic(),
/// })?
/// .carrying(4000.0)?; // N
/// assert!((tyre.normal_force() - 4000.0_f64).abs() < 1e-9);
///
/// // Rolling at 16 m/s with 0.8 m/s of slip.
/// let motion = Motion { slip_velocity: 0.8, transport_velocity: 16.0 / 0.1 };
/// assert!((tyre.slip(motion) - 0.05).abs() < 1e-15);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch<T, M, P> {
    model: M,
    length: T,
    pressure: P,
    /// Multiplies the pressure.
    load: T,
    /// L ∫p dξ without it \[N\].
    unloaded: T,
}

impl<T: Scalar, M, P: Pressure<T>> Patch<T, M, P> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses a length that is not positive.
    pub fn new(parameters: PatchParameters<T, M, P>) -> Result<Self, ParameterError> {
        let PatchParameters { model, length, pressure } = parameters;
        let length = parameter::positive("length", length)?;
        let unloaded = parameter::non_negative("total pressure", length * pressure.total())?;
        Ok(Self { model, length, pressure, load: T::one(), unloaded })
    }

    /// The same patch with its pressure scaled so that it carries a normal force F_z \[N\], zero or
    /// positive.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite, and a pressure that carries nothing.
    pub fn carrying(mut self, normal_force: T) -> Result<Self, ParameterError> {
        self.set_normal_force(normal_force)?;
        Ok(self)
    }

    /// The same in place, for a load that varies.
    ///
    /// # Errors
    ///
    /// Those of [`Patch::carrying`]; the patch is as it was.
    pub fn set_normal_force(&mut self, normal_force: T) -> Result<(), ParameterError> {
        let normal_force = parameter::non_negative("normal_force", normal_force)?;
        self.load = normal_force / parameter::positive("total pressure", self.unloaded)?;
        Ok(())
    }

    /// The friction model.
    pub fn model(&self) -> &M {
        &self.model
    }

    /// Length L \[m\].
    pub fn length(&self) -> T {
        self.length
    }

    /// The pressure as it was given; [`Patch::carrying`] multiplies it by [`Patch::load`].
    pub fn pressure(&self) -> &P {
        &self.pressure
    }

    /// What the pressure is multiplied by \[–\].
    pub fn load(&self) -> T {
        self.load
    }

    /// The normal force F_z = L ∫p dξ \[N\].
    pub fn normal_force(&self) -> T {
        self.load * self.unloaded
    }

    /// The slip v/(L V) \[–\] of a motion: infinite for a patch that slides without rolling.
    pub fn slip(&self, motion: Motion<T>) -> T {
        motion.slip_velocity / (self.length * motion.transport_velocity)
    }

    /// The motion at a slip v/(L V) \[–\] and a rolling speed L V [m/s].
    pub fn motion_at(&self, slip: Slip<T>) -> Motion<T> {
        Motion {
            slip_velocity: slip.slip * slip.rolling_speed,
            transport_velocity: slip.rolling_speed / self.length,
        }
    }

    /// The motion of a wheel's patch: v = v_x − ωR, V = ωR/L.
    pub fn motion_of(&self, wheel: WheelMotion<T>) -> Motion<T> {
        let rolling_speed = wheel.angular_velocity * wheel.radius;
        Motion {
            slip_velocity: wheel.speed - rolling_speed,
            transport_velocity: rolling_speed / self.length,
        }
    }
}

/// How the bodies move on each other: slip velocity and transport velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion<T> {
    /// Slip velocity v [m/s]: that of the body's surface over the ground, if nothing were elastic
    /// (the rigid sliding velocity). The force opposes it.
    pub slip_velocity: T,
    /// Transport velocity V [1/s]: rolling speed over the length of the patch, at which bristles cross it.
    pub transport_velocity: T,
}

/// A slip at a rolling speed, see [`Patch::motion_at`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slip<T> {
    /// v/(L V) \[–\].
    pub slip: T,
    /// L V [m/s].
    pub rolling_speed: T,
}

/// The motion of a wheel, see [`Patch::motion_of`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelMotion<T> {
    /// Speed v_x of the wheel's centre [m/s].
    pub speed: T,
    /// Angular velocity ω [rad/s], positive when the wheel rolls forward.
    pub angular_velocity: T,
    /// Effective rolling radius R \[m\].
    pub radius: T,
}

impl<T: Scalar> Motion<T> {
    /// Checks what a solver is given that only takes V ≥ 0.
    pub(crate) fn forward(self) -> Result<Self, ParameterError> {
        Ok(Self {
            slip_velocity: parameter::finite("slip_velocity", self.slip_velocity)?,
            transport_velocity: parameter::non_negative(
                "transport_velocity",
                self.transport_velocity,
            )?,
        })
    }

    /// Checks what only a rolling patch has an answer to.
    pub(super) fn rolling(self) -> Result<Self, ParameterError> {
        parameter::positive("transport_velocity", self.transport_velocity)?;
        self.forward()
    }
}
