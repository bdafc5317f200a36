//! Combined slip: a patch that slips along and across, as that of a tyre that brakes in a bend.
//!
//! ∂zᵢ/∂t + V ∂zᵢ/∂ξ = −λᵢ zᵢ + rᵢ vᵢ,  zᵢ(0, t) = 0,  Fᵢ = L ∫₀¹ p (c₀ᵢ zᵢ + c₂ᵢ vᵢ) dξ,
//! M_z = L² ∫₀¹ (ξ − ½) p μ_y dξ
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | v | slip velocity: v_x along the way of the bristles, v_y across | m/s |
//! | λᵢ, rᵢ, c₀ᵢ, c₂ᵢ | coefficients of axis i at v | 1/s, –, 1/m, s/m |
//! | μ_y | virtual friction coefficient of the lateral axis | – |
//! | M_z | self-aligning moment | N m |
//!
//! The axes meet in the friction coefficient at ‖v‖ and in the weighted speed alone. Both are the
//! same for all bristles, because v is. So each axis is a patch of one axis, with closed forms,
//! exact steps and energies of its own. Isotropic bristles in a constant direction have the force
//! of one axis at ‖v‖, opposite to v.
//!
//! Two patches of one axis side by side do not share one friction limit: in full slip at 45° they
//! resist with √2 times the friction of one.
//!
//! Source: the patch of Romano et al. (arXiv 2602.09429), section IV, with the bristles of
//! [`plane`](bristle_plane), which has the coefficients.

use nalgebra::SVector;

use super::axes::{OfAxes as _, PatchModel as _};
use super::patch::{coefficients, slopes};
use super::{LinearisedPatch, Motion, Patch, Pressure, Steady};
use bristle::Scalar;
use bristle::parameter::Checked;
use bristle_plane::PlaneBristle;

impl<T: Scalar, M, P: Pressure<T>> Patch<T, M, P> {
    /// Each axis of a patch in combined slip at a slip velocity v [m/s]: a patch of one axis, to be
    /// evaluated at that component of v. Its steady motion, pneumatic trail and passivity are those
    /// of the axis; for slopes and limits it knows no other velocity. The pneumatic trail of a tyre
    /// is that of the lateral axis: `axes(&v)[1].pneumatic_trail` at the slip velocity `v.y`.
    pub fn axes<const A: usize>(&self, slip_velocity: &SVector<T, A>) -> [Patch<T, M::Axis, P>; A]
    where
        M: PlaneBristle<T, A>,
    {
        self.model().axes(slip_velocity).map(|axis| self.with_model(axis))
    }

    /// Steady rolling in combined slip, each axis in closed form: [`Patch::steady`] with a vector.
    /// The results are in the order of the axes: of a tyre braking first, then lateral. A locked
    /// wheel has the rolling speed 0.
    ///
    /// ```
    /// use bristle::curve::Stribeck;
    /// use bristle::nalgebra::Vector2;
    /// use bristle::paper;
    /// use bristle_plane::PlaneFrBd;
    /// use bristle::rheology::KelvinVoigt;
    /// use bristle_rolling::{Motion, Patch, PatchParameters, PolynomialExponential};
    ///
    /// let curve = Stribeck::new(paper::TYRE_CURVE)?;
    /// let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE)?;
    /// let tyre = Patch::new(PatchParameters {
    ///     model: PlaneFrBd::isotropic(curve, bristle),
    ///     length: bristle_rolling::TYRE_LENGTH,
    ///     pressure: PolynomialExponential::constant(),
    /// })?
    /// .under_load(4000.0)?; // N
    /// // 0.8 m/s of slip at 16 m/s: braking, with a slip angle. The force is opposite to v.
    /// let motion = Motion { slip_velocity: Vector2::new(0.64, 0.48), rolling_speed: 16.0 };
    /// let [along, across] = tyre.combined_steady(motion)?;
    /// assert!((along.force.hypot(across.force) - 4000.0 * 0.348954).abs() < 4000.0 * 5e-7);
    /// assert!((across.force / along.force - 0.75_f64).abs() < 1e-12);
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses a motion that is not finite, and a negative rolling speed.
    pub fn combined_steady<const A: usize>(
        &self,
        motion: Motion<SVector<T, A>, T>,
    ) -> Checked<[Steady<T>; A]>
    where
        M: PlaneBristle<T, A>,
    {
        let all = self.frozen(motion)?;
        Ok(M::each(self.contact(), motion.slip_velocity, |i, contact, _| {
            self.steady_of(contact, all[i])
        }))
    }

    /// The patch linearised about a steady motion in combined slip: in place `[j][i]` the force of
    /// axis i with respect to the slip velocity of axis j. About v = 0 it is the patch in adhesion,
    /// in which no axis feels another.
    ///
    /// # Errors
    ///
    /// Refuses a motion that is not finite, and a rolling speed that is not positive.
    pub fn combined_linearised<const A: usize>(
        &self,
        motion: Motion<SVector<T, A>, T>,
    ) -> Checked<[[LinearisedPatch<T, P>; A]; A]>
    where
        M: PlaneBristle<T, A>,
    {
        let Motion { slip_velocity: v, rolling_speed } = motion;
        let (axes, gradient) = self.model().axes_and_slopes(&v.finite("slip_velocity")?);
        let transport = self.rolling(Motion { slip_velocity: T::zero(), rolling_speed })?;
        for (axis, &slip_velocity) in axes.iter().zip(&v) {
            coefficients(&self.contact().with_model(axis.clone()), slip_velocity)?;
        }
        let about = |j: usize, i: usize| {
            let share = if i == j { T::one() } else { T::zero() };
            let axis = self.with_model(axes[i].clone());
            let (affine, slopes) = slopes(axis.contact(), v[i]);
            axis.linearised_about((v[i], transport), (affine, slopes.times(gradient[j])), share)
        };
        Ok(core::array::from_fn(|j| core::array::from_fn(|i| about(j, i))))
    }
}
