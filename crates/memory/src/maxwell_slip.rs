//! Elasto-plastic elements side by side on one velocity.
//!
//! F/P = Σ (rᵢ σᵢ xᵢ + rᵢ τ σᵢ v),  ẋᵢ = −λᵢ xᵢ + rᵢ v,  W = ½ P Σ σᵢ xᵢ²
//!
//! λᵢ = αᵢ|v|/gᵢ,  rᵢ = ℓᵢ/gᵢ,  gᵢ = αᵢ τ |v| + ℓᵢ
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | v | sliding velocity, common to all elements | m/s |
//! | xᵢ | deflection of element i: the state is their vector | m |
//! | σᵢ | normalised stiffness of element i, zero or positive | 1/m |
//! | τ = σ1/Σσᵢ | damping over stiffness, the same for all elements | s |
//! | ℓᵢ(v, p) | yield length: σᵢ ℓᵢ is the element's share of the friction, Σ σᵢ ℓᵢ = s μ(v) | m |
//! | αᵢ ∈ \[0, 1\] | plasticity | – |
//! | P, s = p/P | reference load, friction scale | N, – |
//!
//! Each element is elasto-plastic FrBD: α is zero for |x| ≤ ρℓ and where x and v have opposite
//! signs, one for |x| ≥ ℓ, and in between sin²(½π(|x|/ℓ − ρ)/(1 − ρ)), with a stick ratio ρ below
//! one. With
//!
//! F v − Ẇ = P Σ (σᵢ/gᵢ)(αᵢ|v| xᵢ² + τ ℓᵢ v²) ≥ 0
//!
//! the model is passive for every α, hence for every ρ and curve, and for every p(t), which enters
//! ℓᵢ alone.

use bristle::curve::FrictionCurve;
use bristle::nalgebra::SVector;
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::scalar::{is_zero, lit};
use bristle::{Affine, Bristle, Law, Limits, Linearised, LoadChange, Scalar, Surface};

use crate::Parallel;

/// A spring that yields: a spring in series with a slider.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Element<T> {
    /// Normalised stiffness σᵢ [1/m], zero or positive.
    pub stiffness: T,
    /// Deflection \[m\] at which the element yields, where the friction coefficient is Σ σᵢ ℓᵢ.
    pub yield_length: T,
}

/// Parameters of [`MaxwellSlip`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaxwellSlipParameters<C, T, const N: usize, E = Element<T>> {
    /// The friction curve μ(v). The elements share it in proportion to σᵢ ℓᵢ.
    pub curve: C,
    /// The elements, for instance from [`virgin::bends`](crate::virgin::bends); for
    /// [`MaxwellSlip::following_load`] each by the stiffness of the contact where all up to it
    /// carry, a [`LoadedStiffness`], with loads that rise from above zero, both increasing.
    pub elements: [E; N],
    /// Micro-damping σ1 [s/m] of all elements together.
    #[doc(alias = "sigma1")]
    pub micro_damping: T,
    /// Share ρ of its yield length up to which an element is elastic, positive and below one.
    pub stick_ratio: T,
}

/// The stiffness of a contact under one load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedStiffness<T> {
    /// Load p over the reference load P \[–\].
    pub load: T,
    /// Tangential stiffness under this load over P [1/m].
    pub stiffness: T,
}

/// N elasto-plastic elements side by side on one velocity.
///
/// F/P = Σ (rᵢ σᵢ xᵢ + rᵢ τ σᵢ v),  ẋᵢ = −λᵢ xᵢ + rᵢ v,  W = ½ P Σ σᵢ xᵢ²
///
/// λᵢ = αᵢ|v|/gᵢ,  rᵢ = ℓᵢ/gᵢ,  gᵢ = αᵢ τ |v| + ℓᵢ
///
/// with the deflections xᵢ \[m\], the stiffnesses σᵢ [1/m], the yield lengths ℓᵢ(v, p) \[m\] with
/// Σ σᵢ ℓᵢ = s μ(v), the reference load P \[N\], s = p/P, and τ = σ1/Σ σᵢ \[s\]. The plasticity αᵢ
/// rises from zero at ρ ℓᵢ to one at ℓᵢ. Steady sliding is p μ(v). Passive for every parameter
/// set and every p(t).
///
/// The closer the stick ratio ρ is to one, the better is the memory and the shorter are the steps
/// that resolve the yield, (1 − ρ) ℓᵢ long. A step freezes α at its beginning, or where
/// [`Companion::step_about`](bristle::companion::Companion::step_about) predicts it.
///
/// ```
/// use bristle::Bristle;
/// use bristle::curve::{Coulomb, CoulombParameters};
/// use bristle_memory::{MaxwellSlip, MaxwellSlipParameters, Parallel, virgin::{self, VirginPoint}};
///
/// // The first loading of a contact, measured: it bends at 2, 6 and 15 µm.
/// let measured = [(2e-6, 0.10), (6e-6, 0.22), (15e-6, 0.30)]
///     .map(|(deflection, coefficient)| VirginPoint { deflection, coefficient });
/// let curve = CoulombParameters { dynamic_coefficient: 0.3, viscous_friction: 0.0 };
/// let friction = MaxwellSlip::new(MaxwellSlipParameters {
///     curve: Coulomb::new(curve)?,
///     elements: virgin::bends(&measured)?,
///     micro_damping: 10.0, // s/m
///     stick_ratio: 0.95,
/// })?;
/// let contact = friction.under_load(20.0)?; // N
///
/// // Out to 6 µm at 0.1 mm/s in steps of 0.1 ms, and back by 1 µm: there all three stick.
/// let (mut x, mut force) = (Parallel::default(), 0.0_f64);
/// for step in 0..700 {
///     let v = if step < 600 { 1e-4 } else { -1e-4 };
///     let held = contact.hold(v, x, 1e-4);
///     (x, force) = (held.deflection, held.end_force);
/// }
/// assert!((force - 20.0 * (0.22 - 0.05)).abs() < 0.1); // N; less where ρ is closer to one
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[doc(alias = "Iwan")]
#[doc(alias = "GMS")]
#[doc(alias = "Jenkins")]
pub struct MaxwellSlip<C, T, const N: usize> {
    curve: C,
    elements: [Slip<T>; N],
    /// τ
    damping_time: T,
    stick_ratio: T,
}

/// An element: its yield length is reach · μ(v) · clamp((s − onset) share, 0, most).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Slip<T> {
    stiffness: T,
    /// Yield length \[m\] for each unit of the friction coefficient, fully loaded.
    reach: T,
    onset: T,
    share: T,
    most: T,
}

impl<T: Scalar> Slip<T> {
    /// The load of the element under a friction scale s \[–\].
    #[inline]
    fn load(&self, scale: T) -> T {
        ((scale - self.onset) * self.share).larger(T::zero()).smaller(self.most)
    }

    /// The yield length \[m\] where the surface holds s μ, under the friction scale s.
    #[inline]
    fn yield_length(&self, friction: T, scale: T) -> T {
        if is_zero(scale) { T::zero() } else { self.reach * (self.load(scale) / scale) * friction }
    }
}

impl<T: Scalar, C: FrictionCurve<T>, const N: usize> MaxwellSlip<C, T, N> {
    /// Elements that all follow the load: their stiffness is that of the reference load, their
    /// friction in proportion to p.
    ///
    /// The curve decides over the friction: all yield lengths are scaled by μ(v)/Σ σᵢ ℓᵢ. They are
    /// those given at rest if Σ σᵢ ℓᵢ = μ(0); [`MaxwellSlip::yield_lengths`] returns those in use.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range, and the element. Refuses no elements, and
    /// elements of which none has a stiffness.
    pub fn new(parameters: MaxwellSlipParameters<C, T, N>) -> Checked<Self> {
        let MaxwellSlipParameters { curve, elements, micro_damping, stick_ratio } = parameters;
        Named("elements", N).count(1)?;
        ParameterError::of_components(&elements, |element| {
            Named("elements.stiffness", element.stiffness).non_negative()?;
            Named("elements.yield_length", element.yield_length).positive()
        })?;
        let total = elements.iter().fold(T::zero(), |sum, it| sum + it.stiffness * it.yield_length);
        let total = Named("sum of stiffness times yield_length", total).positive()?;
        let elements = elements.map(|Element { stiffness, yield_length }| Slip {
            stiffness,
            reach: yield_length / total,
            onset: T::zero(),
            share: T::one(),
            most: T::unlimited(),
        });
        Self::of(curve, elements, micro_damping, stick_ratio)
    }

    /// Elements that come into contact one after the other as the load rises, so that the stiffness
    /// of the contact follows its load: K ∝ p^⅓ between Hertz's spheres, K ∝ p between rough
    /// surfaces. Element i carries clamp(p − pᵢ₋₁, 0, pᵢ − pᵢ₋₁), the last one all above its pᵢ₋₁;
    /// it has the stiffness Kᵢ − Kᵢ₋₁, comes unstretched, and slips back when its load falls below
    /// what it holds.
    ///
    /// A part that is held stands still while such a grip varies, with
    /// [`reload`](bristle::Contact::reload); with [`renew`](bristle::Contact::renew), which changes
    /// the reference load, the loads pᵢ would change with it.
    ///
    /// The stiffness at rest follows the load, the bends of the virgin curve follow from it: the
    /// elements that came first yield first. (In the contact of two spheres, by Cattaneo and
    /// Mindlin, the ring that came last does.)
    ///
    /// ```
    /// use bristle::Bristle;
    /// use bristle::curve::{Coulomb, CoulombParameters};
    /// use bristle_memory::{LoadedStiffness, MaxwellSlip, MaxwellSlipParameters};
    ///
    /// let curve = CoulombParameters { dynamic_coefficient: 0.5, viscous_friction: 0.0 };
    /// let friction = MaxwellSlip::following_load(MaxwellSlipParameters {
    ///     curve: Coulomb::new(curve)?,
    ///     elements: core::array::from_fn::<_, 8, _>(|i| {
    ///         let load = (i + 1) as f64 / 4.0; // up to twice the reference load
    ///         LoadedStiffness { load, stiffness: 1e4 * load.cbrt() }
    ///     }),
    ///     micro_damping: 1.0,
    ///     stick_ratio: 0.9,
    /// })?;
    /// let mut contact = friction.under_load(10.0)?; // N
    /// let _ = contact.reload(2.5, 0.0, Default::default())?;
    /// assert!((contact.stationary_force(0.1) - 0.5 * 2.5).abs() < 1e-15);
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range, and the component.
    pub fn following_load(
        parameters: MaxwellSlipParameters<C, T, N, LoadedStiffness<T>>,
    ) -> Checked<Self> {
        let MaxwellSlipParameters { curve, elements, micro_damping, stick_ratio } = parameters;
        Named("elements", N).count(1)?;
        let mut below = LoadedStiffness { load: T::zero(), stiffness: T::zero() };
        ParameterError::of_components(&elements, |point| {
            let load = Named("elements.load", point.load);
            let stiffness = Named("elements.stiffness", point.stiffness);
            load.positive().and(stiffness.positive())?;
            let below = core::mem::replace(&mut below, *point);
            load.increasing(below.load).and(stiffness.increasing(below.stiffness))
        })?;
        let last = below.load;
        below = LoadedStiffness { load: T::zero(), stiffness: T::zero() };
        let elements = elements.map(|point| {
            let LoadedStiffness { load: onset, stiffness } = core::mem::replace(&mut below, point);
            let (width, stiffness) = (point.load - onset, point.stiffness - stiffness);
            let most = if point.load == last { T::unlimited() } else { T::one() };
            Slip { stiffness, reach: width / stiffness, onset, share: T::one() / width, most }
        });
        Self::of(curve, elements, micro_damping, stick_ratio)
    }

    fn of(curve: C, elements: [Slip<T>; N], micro_damping: T, stick_ratio: T) -> Checked<Self> {
        let micro_damping = Named("micro_damping", micro_damping).non_negative()?;
        Named("stick_ratio", stick_ratio).positive()?;
        Named("stick_ratio", stick_ratio).stated(stick_ratio < T::one(), "be below one")?;
        let total = elements.iter().fold(T::zero(), |sum, element| sum + element.stiffness);
        Ok(Self { curve, elements, damping_time: micro_damping / total, stick_ratio })
    }

    /// The friction curve.
    pub fn curve(&self) -> &C {
        &self.curve
    }

    /// The yield lengths ℓᵢ \[m\] at a velocity.
    #[inline]
    pub fn yield_lengths(&self, surface: impl Into<Surface<T>>) -> SVector<T, N> {
        let surface = surface.into();
        let friction = surface.friction(&self.curve);
        SVector::from_fn(|i, _| self.elements[i].yield_length(friction, surface.scale()))
    }

    /// A step of elements with a sharp yield, the limit ρ → 1 without damping: they are carried by
    /// a `displacement` u − x \[m\] and slip back to their yield lengths,
    ///
    /// xᵢ' = clamp(xᵢ + displacement, ±ℓᵢ),  F'/P = Σ σᵢ xᵢ'.
    ///
    /// It remembers exactly: a loop closes to rounding. With the force at its end a step is
    /// passive, for every history of the ℓᵢ:
    /// F'·displacement − ΔW = P Σ σᵢ [xᵢ'(uᵢ − xᵢ') + ½(xᵢ' − xᵢ)²] ≥ 0. It is of first order. In
    /// an implicit step of a mechanism F' never falls with the displacement, and
    /// [`SharpStep::stiffness`] is its slope.
    pub fn sharp_step(
        &self,
        surface: impl Into<Surface<T>>,
        displacement: T,
        deflection: Parallel<T, N>,
    ) -> SharpStep<T, N> {
        let limits = self.yield_lengths(surface);
        let mut elastic = T::zero();
        let deflection = Parallel(SVector::from_fn(|i, _| {
            let (carried, limit) = (deflection[i] + displacement, limits[i]);
            if carried.abs() > limit {
                return if carried > T::zero() { limit } else { -limit };
            }
            elastic += self.elements[i].stiffness;
            carried
        }));
        let coefficient = self.storage_stiffness().dot(&deflection);
        SharpStep { deflection, coefficient, stiffness: elastic }
    }

    /// λᵢ, rᵢ and the slope of their only variable, α|v|/ℓ, by deflection and by velocity.
    #[inline]
    fn element(&self, i: usize, surface: &Surface<T>, x: T, friction: [T; 2]) -> Rates<T> {
        let [full, slope] = friction.map(|it| self.elements[i].yield_length(it, surface.scale()));
        let (zero, one) = (T::zero(), T::one());
        if is_zero(full) {
            // Without a load it does nothing.
            return Rates { relaxation: zero, drive: zero, by_deflection: zero, by_velocity: zero };
        }
        let (speed, direction) = (surface.speed(), surface.direction());
        let utilisation = direction * x / full;
        let [alpha, alpha_slope] = plasticity(utilisation, self.stick_ratio);
        let flow = alpha * speed;
        let resistance = self.damping_time * flow + full;
        // On a branch locked to the other direction it falls with the speed, down to a pole.
        let usable = resistance > lit::<T>(0.5) * full;
        let inverse = if usable { one / resistance } else { T::nan() };
        let square = inverse * inverse;
        let by_velocity = alpha * direction - alpha_slope * utilisation * (slope / full) * speed;
        Rates {
            relaxation: flow * inverse,
            drive: full * inverse,
            by_deflection: alpha_slope * direction * speed * square,
            by_velocity: (by_velocity * full - flow * slope) * square,
        }
    }

    fn rates(&self, surface: Surface<T>, deflection: &SVector<T, N>) -> SVector<Rates<T>, N> {
        let (friction, slope) = surface.friction_and_slope(&self.curve);
        SVector::from_fn(|i, _| self.element(i, &surface, deflection[i], [friction, slope]))
    }

    /// The coefficients, or their derivatives, from λᵢ and rᵢ.
    #[inline]
    fn coefficients(
        &self,
        relaxation: SVector<T, N>,
        drive: SVector<T, N>,
    ) -> Affine<T, Parallel<T, N>> {
        let stiffness = self.storage_stiffness().component_mul(&drive);
        Affine {
            relaxation,
            drive: Parallel(drive),
            stiffness: Parallel(stiffness),
            damping: self.damping_time * stiffness.sum(),
        }
    }
}

/// What an element does at one velocity and deflection.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Rates<T> {
    /// λ
    relaxation: T,
    /// r
    drive: T,
    /// ∂λ/∂x; ∂r/∂x is −τ times it.
    by_deflection: T,
    /// ∂λ/∂v; ∂r/∂v is −τ times it.
    by_velocity: T,
}

/// α of x sgn v/ℓ, and its slope.
fn plasticity<T: Scalar>(utilisation: T, stick_ratio: T) -> [T; 2] {
    if !(utilisation > stick_ratio) {
        return [T::zero(), T::zero()];
    }
    if utilisation >= T::one() {
        return [T::one(), T::zero()];
    }
    let width = T::one() - stick_ratio;
    let (sin, cos) = (T::frac_pi_2() * (utilisation - stick_ratio) / width).sin_cos();
    [sin * sin, T::pi() * sin * cos / width]
}

/// The result of [`MaxwellSlip::sharp_step`], per reference load.
#[must_use]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SharpStep<T: Scalar, const N: usize> {
    /// Deflections at the end of the step \[m\].
    pub deflection: Parallel<T, N>,
    /// Friction coefficient F'/P at the end of the step \[–\].
    pub coefficient: T,
    /// Stiffness [1/m] of the elements that have not yielded: dF'/P by the displacement.
    pub stiffness: T,
}

impl<T: Scalar, C: FrictionCurve<T>, const N: usize> Bristle<T> for MaxwellSlip<C, T, N> {
    type Deflection = Parallel<T, N>;

    #[inline]
    fn affine(&self, surface: Surface<T>, deflection: Parallel<T, N>) -> Affine<T, Parallel<T, N>> {
        let friction = surface.friction(&self.curve);
        let rates = SVector::<_, N>::from_fn(|i, _| {
            self.element(i, &surface, deflection[i], [friction, T::zero()])
        });
        self.coefficients(rates.map(|it| it.relaxation), rates.map(|it| it.drive))
    }

    fn affine_and_slopes(
        &self,
        surface: Surface<T>,
        deflection: Parallel<T, N>,
    ) -> (Affine<T, Parallel<T, N>>, Affine<T, Parallel<T, N>>) {
        let rates = self.rates(surface, &deflection);
        let slope = rates.map(|it| it.by_velocity);
        (
            self.coefficients(rates.map(|it| it.relaxation), rates.map(|it| it.drive)),
            self.coefficients(slope, slope * -self.damping_time),
        )
    }

    fn linearised(
        &self,
        surface: impl Into<Surface<T>>,
        deflection: Parallel<T, N>,
    ) -> Linearised<T, Parallel<T, N>> {
        let surface = surface.into();
        let (velocity, tau) = (surface.velocity(), self.damping_time);
        let (affine, slopes) = self.affine_and_slopes(surface, deflection);
        let mut linearised = Linearised::new(&affine, &slopes, velocity, deflection);
        // ∂ẋ/∂x and ∂μ_b/∂x have −∂λ/∂x (x + τ v) each, the latter times τ σ.
        let by_deflection = self.rates(surface, &deflection).map(|it| it.by_deflection);
        let along = by_deflection.component_mul(&deflection.add_scalar(tau * velocity));
        linearised.rate_by_deflection -= along;
        linearised.coefficient_by_deflection.0 -=
            self.storage_stiffness().component_mul(&along) * tau;
        linearised
    }

    fn stationary(&self, surface: impl Into<Surface<T>>) -> Parallel<T, N> {
        let surface = surface.into();
        Parallel(self.yield_lengths(surface) * surface.direction())
    }

    fn storage_stiffness(&self) -> Parallel<T, N> {
        Parallel(SVector::from_fn(|i, _| self.elements[i].stiffness))
    }

    fn holding_coefficient(&self, surface: Surface<T>, carried: T) -> T {
        surface.largest_up_to(carried, |surface| surface.friction(&self.curve))
    }

    /// Each element slips back to what its own load holds.
    fn held(
        &self,
        change: LoadChange<T>,
        surface: Surface<T>,
        deflection: Parallel<T, N>,
    ) -> Parallel<T, N> {
        if change.after >= change.before {
            return deflection;
        }
        if is_zero(change.after) {
            return Parallel::default();
        }
        let scale = surface.scale();
        let scale_before = scale * (change.before / change.after);
        let holding = [T::one(), -T::one()].map(|sign| self.holding_coefficient(surface, sign));
        Parallel(SVector::from_fn(|i, _| {
            let (element, x) = (&self.elements[i], deflection[i]);
            if is_zero(x) {
                return x;
            }
            let limit = element.yield_length(holding[usize::from(x < T::zero())], scale);
            let before =
                if scale_before.is_finite() { element.load(scale_before) } else { scale_before };
            x * LoadChange { before, after: element.load(scale) }.kept(x.abs() / limit)
        }))
    }

    fn name(&self) -> &'static str {
        "Maxwell slip"
    }

    fn obeys(&self, law: Law) -> bool {
        match law {
            Law::SteadySliding | Law::Passivity | Law::NoDrift => true,
            Law::BoundedDeflection => self.limits(T::one()).deflection.is_some(),
            Law::BoundedRelaxation => self.damping_time > T::zero(),
            Law::OddSymmetry => self.curve.is_even(),
            _ => false,
        }
    }

    fn limits(&self, fastest: T) -> Limits<T> {
        let fastest = fastest.abs();
        if !(fastest >= T::zero()) {
            return Limits { deflection: None, coefficient: None, relaxation_rate: None };
        }
        let finite = |limit: T| limit.is_finite().then_some(limit);
        // Elements of which each has its share of every load.
        let shared = self.elements.iter().all(|element| !element.most.is_finite());
        let reach = self.elements.iter().fold(T::zero(), |most, it| most.larger(it.reach));
        Limits {
            deflection: finite(reach * self.curve.bounds(fastest).max).filter(|_| shared),
            coefficient: None,
            relaxation_rate: finite(T::one() / self.damping_time),
        }
    }
}
