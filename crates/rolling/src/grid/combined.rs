//! Combined slip on a grid, for a slip velocity that varies along the patch: spin.
//!
//! ∂zᵢ/∂t + V ∂zᵢ/∂ξ = −λᵢ(v) zᵢ + rᵢ(v) vᵢ,  v(ξ, t) = (v_x − ω y, v_y + ω L (½ − ξ))
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | v_x, v_y | slip velocity at the middle of the patch, along and across | m/s |
//! | ω | spin: how fast the rolling body turns about the normal of the contact | rad/s |
//! | y | place of this line of bristles across the patch, 0 in its middle | m |
//!
//! The axes meet in the coefficients alone, taken at the v of each place. A bristle runs the same
//! way on every axis: its path is followed once, and each axis relaxes along it as on a
//! [`Grid`](super::Grid). ω × z is left out beside ω × r: deflections are small beside the patch.
//!
//! Source: Romano et al. (arXiv 2602.09429), section IV-A, with the bristles of
//! [`plane`](bristle_plane).

use alloc::vec::Vec;

use nalgebra::SVector;

use super::{Line, Mesh};
use crate::combined::{axes_of, finite};
use crate::exact::slipped;
use crate::{Motion, Patch, Pressure};
use bristle::parameter::{Named, ParameterError};
use bristle::scalar::{is_zero, lit};
use bristle::{Contact, Reloaded, Scalar};
use bristle_plane::PlaneBristle;

/// A patch in combined slip on a [`Grid`](crate::Grid), for velocities that vary along it: turn
/// slip and camber. Without spin [`CombinedPatch`](crate::CombinedPatch) is exact for held
/// velocities and couples to a mechanism. Along a smooth motion that is known the grid, of fourth
/// order, is the faster one for errors below some millionth of F_z.
///
/// A wheel that turns about the vertical at ψ̇ and leans by the camber angle γ, while it turns
/// about its axle at Ω, has the spin ω = ψ̇ + (1 − ε) Ω sin γ. With x forward, y to the left and z
/// up, a wheel of γ > 0 leans to the right. ε is how much of the camber the carcass takes up: 0 for
/// the tyre of a motorcycle, about 0.7 for that of a car (H. B. Pacejka, "Tire and Vehicle
/// Dynamics", chapter 4).
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle::nalgebra::Vector2;
/// use bristle::paper;
/// use bristle_plane::PlaneFrBd;
/// use bristle::rheology::KelvinVoigt;
/// use bristle_rolling::{CombinedGrid, Motion, Patch, PatchParameters, PolynomialExponential};
///
/// let curve = Stribeck::new(paper::TYRE_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE)?;
/// let (length, speed) = (bristle_rolling::TYRE_LENGTH, 16.0); // m, m/s
/// let tyre = Patch::new(PatchParameters {
///     model: PlaneFrBd::isotropic(curve, bristle),
///     length,
///     pressure: PolynomialExponential::parabolic(),
/// })?
/// .under_load(4000.0)?; // N
/// let mut rolling = CombinedGrid::new(&tyre, 100)?;
///
/// // Leaning to the right by 3° on a wheel of 0.3 m radius, as a motorcycle does.
/// let spin = speed / 0.3 * 3_f64.to_radians().sin(); // rad/s
/// let slip = |place: f64| Vector2::new(0.0, spin * length * (0.5 - place)); // m/s
/// let field = Motion { slip_velocity: |place, _| slip(place), rolling_speed: |_, _| speed };
/// // In a step longer than a crossing of the patch it settles.
/// let force = rolling.step_field(&field, 2.0 * length / speed)?;
/// // Friction resists to the left: the body is pushed to the right, the side that it leans to.
/// assert!(force.x == 0.0 && force.y > 0.0);
/// let turning = rolling.moment(slip).y; // N m, against the spin
/// assert!(turning < 0.0);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone)]
pub struct CombinedGrid<T, M, const A: usize> {
    contact: Contact<T, M>,
    mesh: Mesh<T>,
    lines: [Line<T>; A],
}

impl<T, M, const A: usize> CombinedGrid<T, M, A>
where
    T: Scalar,
    M: PlaneBristle<T, A>,
{
    /// A patch of equal bristles on N cells, undeflected.
    ///
    /// # Errors
    ///
    /// Those of [`Grid::new`](crate::Grid::new).
    pub fn new<P: Pressure<T>>(
        patch: &Patch<T, M, P>,
        cells: usize,
    ) -> Result<Self, ParameterError> {
        let mesh = Mesh::new(patch, cells)?;
        let lines = core::array::from_fn(|_| Line::undeflected(cells));
        Ok(Self { contact: patch.contact().clone(), mesh, lines })
    }

    /// Places of the nodes, ξᵢ = i/N.
    pub fn places(&self) -> &[T] {
        &self.mesh.places
    }

    /// Deflections of each axis at the nodes \[m\].
    pub fn deflections(&self) -> [&[T]; A] {
        self.lines.each_ref().map(|line| line.deflections.as_slice())
    }

    /// The normal force F_z \[N\].
    pub fn normal_force(&self) -> T {
        self.contact.normal_force()
    }

    /// Changes the normal force F_z \[N\], zero or positive, before a step with slip velocities
    /// v(ξ) [m/s], see [`ExactPatch::reload`](crate::ExactPatch::reload).
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite, and a positive one on a patch without
    /// a reference load; the patch is as it was.
    pub fn reload(
        &mut self,
        normal_force: T,
        slip_velocity: impl Fn(T) -> SVector<T, A>,
    ) -> Result<Reloaded<T, ()>, ParameterError> {
        let change = self.contact.change_load(normal_force)?;
        let (model, scale) = (self.contact.model(), self.contact.friction_scale());
        let mut kept = if is_zero(normal_force) { T::zero() } else { T::one() };
        if change.after < change.before && kept > T::zero() {
            for (node, &place) in self.mesh.places.iter().enumerate() {
                let limits = model.limits(slip_velocity(place).norm());
                let at_node = |line: &Line<T>| line.deflections.get(node).copied();
                let z = self.lines.each_ref().map(|line| at_node(line).unwrap_or_else(T::zero));
                kept = kept.smaller(change.kept(limits.utilisation(&z.into(), scale)));
            }
        }
        let dissipated = slipped(self.stored_energy(), kept);
        self.lines.iter_mut().for_each(|line| line.scale(kept));
        Ok(Reloaded { deflection: (), dissipated })
    }

    /// Changes the normal force by renewal, see [`ExactPatch::renew`](crate::ExactPatch::renew).
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite; the patch is as it was.
    pub fn renew(&mut self, normal_force: T) -> Result<Reloaded<T, ()>, ParameterError> {
        let stored = self.stored_energy();
        let (kept, lost) = self.contact.renew_load(normal_force)?.renewed();
        self.lines.iter_mut().for_each(|line| line.scale(kept));
        Ok(Reloaded { deflection: (), dissipated: lost * stored })
    }

    /// The energy stored in the bristles \[J\].
    pub fn stored_energy(&self) -> T {
        let half = lit::<T>(0.5) * self.contact.reference_load();
        let stiffness = self.contact.model().storage_stiffness();
        let axes = self.lines.iter().zip(&stiffness);
        axes.fold(T::zero(), |sum, (line, &k)| sum + half * k * self.mesh.mean_square(line))
    }

    /// The friction force \[N\] of the deflections as they are, at slip velocities v(ξ) [m/s].
    pub fn force(&self, slip_velocity: impl Fn(T) -> SVector<T, A>) -> SVector<T, A> {
        self.weigh(|line| &line.deflections, slip_velocity, |_| T::one())
    }

    /// The moment \[N m\] of each axis's force about the middle of the patch,
    /// L² ∫ (ξ − ½) p μ_b dξ, of the deflections as they are: that of the lateral axis is the
    /// self-aligning moment M_z.
    ///
    /// It is the moment *on* the rolling body, while F is against v: with slip velocities that are
    /// those of a rigid body, as above, the power \[W\] that friction takes is F·v − M_z ω. That of
    /// a row at y adds y F_x to M_z.
    pub fn moment(&self, slip_velocity: impl Fn(T) -> SVector<T, A>) -> SVector<T, A> {
        let half: T = lit(0.5);
        self.weigh(|line| &line.deflections, slip_velocity, |place| place - half) * self.mesh.length
    }

    /// A step of length h ≥ 0 \[s\] with a motion that varies in place and time, and the friction
    /// force F \[N\] at its end: [`Grid::step_field`][step] with vectors for the slip velocity and
    /// the force, of its order, also where one component of v reverses. Where v passes close to
    /// zero λ all but has a kink, and the error is of second order.
    ///
    /// # Errors
    ///
    /// Those of [`Grid::step_field`][step]; the patch is as it was.
    ///
    /// [step]: crate::Grid::step_field
    pub fn step_field<F, G>(
        &mut self,
        field: &Motion<F, G>,
        duration: T,
    ) -> Result<SVector<T, A>, ParameterError>
    where
        F: Fn(T, T) -> SVector<T, A>,
        G: Fn(T, T) -> T,
    {
        let duration = Named("duration", duration).non_negative()?;
        let Motion { slip_velocity, rolling_speed } = field;
        let driven = |velocity: &SVector<T, A>| {
            let axes = axes_of(&self.contact, velocity);
            core::array::from_fn(|i| {
                let affine = axes[i].affine(velocity[i], T::zero());
                (affine.relaxation, affine.drive * velocity[i])
            })
        };
        let along = Motion { slip_velocity, rolling_speed };
        let ranges = self.mesh.follow(&mut self.lines, driven, along, duration)?;
        let end = |place| slip_velocity(place, duration);
        let force = self.weigh(|line| &line.next, end, |_| T::one());
        finite("force", &force)?;
        self.lines.iter_mut().zip(ranges).for_each(|(line, range)| line.commit(range));
        Ok(force)
    }

    /// P Σ weight(ξ) w μ_b over the nodes, on each axis.
    fn weigh(
        &self,
        deflections: impl Fn(&Line<T>) -> &Vec<T>,
        slip_velocity: impl Fn(T) -> SVector<T, A>,
        weight: impl Fn(T) -> T,
    ) -> SVector<T, A> {
        let load = self.contact.reference_load();
        let mut sum = SVector::<T, A>::zeros();
        for (node, (&place, &w)) in self.mesh.places.iter().zip(&self.mesh.weights).enumerate() {
            let v = slip_velocity(place);
            let axes = axes_of(&self.contact, &v).into_iter().zip(&v);
            for ((line, (axis, &v)), sum) in self.lines.iter().zip(axes).zip(sum.iter_mut()) {
                if let Some(&z) = deflections(line).get(node) {
                    *sum += weight(place) * w * load * axis.affine(v, z).coefficient(v, z);
                }
            }
        }
        sum
    }
}
