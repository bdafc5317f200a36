//! The Dahl model.

use super::{Affine, Characteristics, Form, Law, Limits, finite};
use crate::curve::Coulomb;
use crate::parameter::{Checked, Named};
use crate::rheology::ElementBounds;
use crate::{Bounds, Bristle, Scalar, Surface};

/// Parameters of [`Dahl`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct DahlParameters<T> {
    /// Friction coefficient μ_d \[–\], positive.
    #[doc(alias = "mu_d")]
    pub dynamic_coefficient: T,
    /// Normalised micro-stiffness σ0 [1/m], positive.
    #[doc(alias = "sigma0")]
    pub micro_stiffness: T,
}

/// The Dahl model: friction that depends on the displacement alone, whatever its speed.
///
/// ż = v − (σ0|v|/μ_d) z,  μ_b = F/P = σ0 z
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | z | bristle deflection, the state | m |
/// | v | sliding velocity of the body, the input | m/s |
/// | F, P | friction force, positive against v > 0; reference load, p if constant | N |
/// | μ_d | friction coefficient of sliding, at every speed | – |
/// | σ0 | normalised micro-stiffness | 1/m |
///
/// It is [`FrBd`](crate::FrBd) with a constant curve and σ1 = 0. Take it where two parameters are
/// all you have or want: friction that does not fall with the speed (many rolling guides), and
/// motions to and fro that go through the whole loop. It leaves out the damping force p σ1 v and
/// the cause of stick-slip, and its relaxation rate σ0|v|/μ_d [1/s] has no upper limit. For
/// loops within loops take the crate bristle-memory, for a body held under a force that varies
/// [`ElastoPlastic`](crate::ElastoPlastic).
///
/// Source: P. R. Dahl, "A solid friction model", The Aerospace Corporation, report
/// TOR-0158(3107-18)-1 (1968), with exponent 1.
///
/// ```
/// use bristle::{Bristle, Dahl, DahlParameters};
///
/// let friction = Dahl::new(DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 })?;
/// assert_eq!(friction.stationary(-1.0), -5e-5);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dahl<T> {
    dynamic: T,
    stiffness: T,
    /// σ0/μ_d
    relaxation_per_speed: T,
}

impl<T: Scalar> Dahl<T> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range.
    pub fn new(parameters: DahlParameters<T>) -> Checked<Self> {
        let dynamic = Named("dynamic_coefficient", parameters.dynamic_coefficient).positive()?;
        let stiffness = Named("micro_stiffness", parameters.micro_stiffness).positive()?;
        Ok(Self { dynamic, stiffness, relaxation_per_speed: stiffness / dynamic })
    }

    /// The parameters, as they were given.
    pub fn parameters(&self) -> DahlParameters<T> {
        DahlParameters { dynamic_coefficient: self.dynamic, micro_stiffness: self.stiffness }
    }

    /// σ0/(s μ_d)
    #[inline(always)]
    fn rate_per_speed(&self, surface: &Surface<T>) -> T {
        if surface.scale() == T::one() {
            self.relaxation_per_speed
        } else {
            self.stiffness / surface.apply(self.dynamic)
        }
    }
}

impl<T: Scalar> Bristle<T> for Dahl<T> {
    type Deflection = T;

    #[inline]
    fn affine(&self, surface: Surface<T>, _deflection: T) -> Affine<T> {
        Affine {
            relaxation: self.rate_per_speed(&surface) * surface.speed(),
            drive: T::one(),
            stiffness: self.stiffness,
            damping: T::zero(),
        }
    }

    #[inline]
    fn affine_and_slopes(&self, surface: Surface<T>, deflection: T) -> (Affine<T>, Affine<T>) {
        let slopes = Affine {
            relaxation: self.rate_per_speed(&surface) * surface.direction(),
            drive: T::zero(),
            stiffness: T::zero(),
            damping: T::zero(),
        };
        (self.affine(surface, deflection), slopes)
    }

    fn stationary(&self, surface: impl Into<Surface<T>>) -> T {
        let surface = surface.into();
        surface.apply(surface.direction() * self.dynamic) / self.stiffness
    }

    fn form(&self) -> Form {
        Form::OfVelocity
    }

    fn name(&self) -> &'static str {
        "Dahl"
    }

    fn storage_stiffness(&self) -> T {
        self.stiffness
    }

    fn obeys(&self, law: Law) -> bool {
        !matches!(law, Law::BoundedRelaxation | Law::NoDrift)
    }

    fn characteristics(&self, fastest: T) -> Option<Characteristics<T>> {
        let curve = Coulomb { dynamic: self.dynamic, viscous: T::zero() };
        let [stiffness, damping] = [self.stiffness, T::zero()].map(Bounds::constant);
        let elements = ElementBounds::elastic(stiffness, damping);
        Characteristics::new("Dahl", &curve, &elements, fastest)
    }

    fn limits(&self, fastest: T) -> Limits<T> {
        Limits::up_to(fastest, |fastest| Limits {
            deflection: finite(self.dynamic / self.stiffness),
            coefficient: finite(self.dynamic),
            relaxation_rate: finite(self.relaxation_per_speed * fastest),
        })
    }
}
