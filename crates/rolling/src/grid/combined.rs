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
//! way on every axis: its path is followed once, and each axis relaxes along it as on a [`Grid`].
//! ω × z is left out beside ω × r: deflections are small beside the patch.
//!
//! Source: Romano et al. (arXiv 2602.09429), section IV-A, with the bristles of
//! [`plane`](bristle_plane).

use alloc::vec::Vec;

use nalgebra::SVector;

use super::path::Paths;
use super::{Bristles, Grid, between};
use crate::combined::finite;
use crate::{Motion, Patch, Pressure};
use bristle::parameter::{Named, ParameterError};
use bristle::scalar::lit;
use bristle::{Bristle, Scalar};
use bristle_plane::PlaneBristle;

/// A patch in combined slip on a [`Grid`], for velocities that vary along it: turn slip and camber.
/// Without spin [`CombinedPatch`](crate::CombinedPatch) is exact for held velocities and
/// couples to a mechanism. Along a smooth motion that is known the grid, of fourth order, is the
/// faster one for errors below some millionth of F_z.
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
/// .carrying(4000.0)?; // N
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
pub struct CombinedGrid<T: Scalar, M: PlaneBristle<T, A>, const A: usize> {
    model: M,
    /// With the models at rest.
    axes: [Grid<T, M::Axis>; A],
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
    /// Those of [`Grid::new`].
    pub fn new<P: Pressure<T>>(
        patch: &Patch<T, M, P>,
        cells: usize,
    ) -> Result<Self, ParameterError> {
        let grid = Grid::build(patch, cells, |_| Ok(Bristles::Varying(Vec::new())))?;
        let models = patch.model().axes(&SVector::zeros());
        let axes = models.map(|model| Grid { bristles: Bristles::Uniform(model), ..grid.clone() });
        Ok(Self { model: patch.model().clone(), axes })
    }

    /// The bristles of each axis: places, weights, deflections and stored energies. Their own
    /// forces are those of bristles that stick; for others see [`CombinedGrid::force`].
    pub fn axes(&self) -> &[Grid<T, M::Axis>; A] {
        &self.axes
    }

    /// Changes the normal force F_z \[N\], zero or positive, and returns the share of the stored
    /// energy that leaves: [`Grid::reload`].
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite; the patch is as it was.
    pub fn reload(&mut self, normal_force: T) -> Result<T, ParameterError> {
        let mut lost = T::zero();
        for axis in &mut self.axes {
            lost = axis.reload(normal_force)?;
        }
        Ok(lost)
    }

    /// The energy stored in the bristles \[J\].
    pub fn stored_energy(&self) -> T {
        self.axes.iter().fold(T::zero(), |sum, axis| sum + axis.stored_energy())
    }

    /// The friction force \[N\] of the deflections as they are, at slip velocities v(ξ) [m/s].
    pub fn force(&self, slip_velocity: impl Fn(T) -> SVector<T, A>) -> SVector<T, A> {
        self.weigh(Grid::deflections, slip_velocity, |_| T::one())
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
        self.weigh(Grid::deflections, slip_velocity, |place| place - half) * self.length()
    }

    /// A step of length h ≥ 0 \[s\] with a motion that varies in place and time, and the friction
    /// force F \[N\] at its end: [`Grid::step_field`] with vectors for the slip velocity and the
    /// force, of its order, also where one component of v reverses. Where v passes close to zero λ
    /// all but has a kink, and the error is of second order.
    ///
    /// # Errors
    ///
    /// Those of [`Grid::step_field`]; the patch is as it was.
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
        let cells = self.axes.first().map_or(0, Grid::cells);
        let model = &self.model;
        let paths = Paths {
            driven: |_, velocity: &SVector<T, A>| {
                let axes = model.axes(velocity);
                core::array::from_fn(|i| {
                    let affine = axes[i].affine(velocity[i].into(), T::zero());
                    (affine.relaxation, affine.drive * velocity[i])
                })
            },
            slip_velocity,
            rolling_speed,
            length: self.length(),
            duration,
            cells,
        };
        let mut ranges = self.axes.each_ref().map(|axis| axis.range);
        for node in 0..=cells {
            let Some(&place) = self.places().get(node) else { break };
            let arrival = paths.arrival(place, &mut ranges)?;
            for (axis, change) in self.axes.iter_mut().zip(arrival.changes) {
                let before = (arrival.origin)
                    .map_or_else(T::zero, |at| between(&axis.deflections, axis.range, at));
                if let Some(next) = axis.next.get_mut(node) {
                    *next = change.of(before);
                }
            }
        }
        let end = |place| slip_velocity(place, duration);
        let force = self.weigh(|axis| &axis.next, end, |_| T::one());
        finite("force", &force)?;
        for ((axis, &force), range) in self.axes.iter_mut().zip(&force).zip(ranges) {
            axis.commit(force, range)?;
        }
        Ok(force)
    }

    fn length(&self) -> T {
        self.axes.first().map_or_else(T::zero, |axis| axis.length)
    }

    fn places(&self) -> &[T] {
        self.axes.first().map_or(&[], Grid::places)
    }

    /// F_z Σ weight(ξ) w μ_b over the nodes, on each axis.
    fn weigh(
        &self,
        deflections: impl Fn(&Grid<T, M::Axis>) -> &[T],
        slip_velocity: impl Fn(T) -> SVector<T, A>,
        weight: impl Fn(T) -> T,
    ) -> SVector<T, A> {
        let mut sum = SVector::<T, A>::zeros();
        for (node, &place) in self.places().iter().enumerate() {
            let v = slip_velocity(place);
            let models = self.model.axes(&v).into_iter().zip(&v);
            for ((axis, (model, &v)), sum) in self.axes.iter().zip(models).zip(sum.iter_mut()) {
                if let (Some(&w), Some(&z)) = (axis.weights.get(node), deflections(axis).get(node))
                {
                    *sum += weight(place) * w * axis.normal_force * model.coefficient(v, z);
                }
            }
        }
        sum
    }
}
