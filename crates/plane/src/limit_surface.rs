//! The limit surface of quasi-static sliding, both ways: the wrench of a twist, the twist of a
//! wrench.
//!
//! A body that slides slowly under a wrench w is on its limit surface, the set of all friction
//! wrenches of sliding, and its twist t is normal to it (maximum dissipation).
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | t = (v_x, v_y, ω) | twist at the origin | m/s, m/s, rad/s |
//! | w = (F_x, F_y, M) | friction wrench against it, torque about the origin | N, N, N m |
//! | D(t) = max w·t | dissipated power, over all friction wrenches | W |
//! | B | matrix of an ellipsoid: wᵀB⁻¹w = 1 on it | N², N² m, N² m² |
//!
//! The limit surface of a footprint itself, twist to wrench, and the ellipsoid nearest to it are in
//! `footprint.rs` ([`Footprint::stationary_wrench`], [`Footprint::limit_ellipsoid`]).
//!
//! Of an ellipsoid D = √(tᵀB t), w = B t/D and t ∝ B⁻¹w, in closed form. Of a
//! [`Footprint`](crate::Footprint) D is a sum over its points, and t is where D is least among all
//! twists with w·t = 1 W: one minimum, for D is convex.
//!
//! Sources: S. Goyal, A. Ruina, J. Papadopoulos, "Planar sliding with dry friction", Wear 143
//! (1991), 307–330; S. H. Lee, M. R. Cutkosky, "Fixture planning with friction", Journal of
//! Engineering for Industry 113 (1991), 320–327, for the ellipsoid.

use bristle::Scalar;
use bristle::parameter::{Checked, Named, ParameterError, Rule};
use bristle::scalar::lit;
use nalgebra::{Matrix3, Vector2, Vector3};

use crate::footprint::Lever;
use crate::{Footprint, FootprintPoint, PlaneBristle};

/// How a body slides under a wrench.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlidingTwist<T> {
    /// The twist (v_x, v_y, ω) at which the wrench does 1 W: w·t = 1. Quasi-static sliding tells
    /// its direction alone.
    pub twist: Vector3<T>,
    /// The wrench over the one on the limit surface along the same ray \[–\]: below one the body
    /// stands.
    pub utilisation: T,
}

/// Why there is no twist of a wrench, or no limit surface of pushes.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LimitSurfaceError {
    /// What was given is none that slides in one way.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The pushes leave a parameter open, to the last digit: they have one twist, for instance.
    /// Where they nearly do, its standard error tells.
    #[error("the pushes do not determine the {0} parameters of the family")]
    Undetermined(usize),
    /// The search has not ended.
    #[error("the search has not converged after {0} iterations")]
    NotConverged(u32),
}

/// A limit surface that is an ellipsoid wᵀB⁻¹w = 1: of any ratios, turned, and off centre (about an
/// origin beside the centre of friction).
///
/// ```
/// use bristle::nalgebra::Vector3;
/// use bristle_plane::FrictionEllipsoid;
///
/// let pad = FrictionEllipsoid::isotropic(5.0, 0.02)?; // N, m
/// let sliding = pad.twist(&Vector3::new(3.0, 0.0, 0.08))?; // N, N, N m
/// // As much spin R ω as sliding has M/R over F.
/// assert!((0.02 * sliding.twist.z / sliding.twist.x - 0.08 / 0.02 / 3.0_f64).abs() < 1e-12);
/// assert!((sliding.utilisation - 1.0).abs() < 1e-12);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionEllipsoid<T> {
    /// L of B = L Lᵀ
    factor: Matrix3<T>,
    inverse: Matrix3<T>,
}

impl<T: Scalar> FrictionEllipsoid<T> {
    /// The ellipsoid of a matrix B, of which the lower triangle is read. Its diagonal is the
    /// squares of the largest F_x, F_y and M.
    ///
    /// # Errors
    ///
    /// Refuses a matrix that is not finite or not positive definite.
    pub fn new(matrix: Matrix3<T>) -> Checked<Self> {
        Self::of_factor(matrix.cholesky().map(|cholesky| cholesky.l()), matrix)
    }

    /// From L, if there is one, of a matrix that an error tells of.
    pub(crate) fn of_factor(factor: Option<Matrix3<T>>, matrix: Matrix3<T>) -> Checked<Self> {
        let factor = factor.and_then(|factor| Some((factor, factor.try_inverse()?)));
        let found = factor.filter(|(_, inverse)| inverse.iter().all(|x| x.is_finite()));
        let rule = Rule::Stated("be that of a finite, positive definite matrix");
        let refused = || Named("determinant", matrix.determinant()).refused(rule);
        found.map(|(factor, inverse)| Self { factor, inverse }).ok_or_else(refused)
    }

    /// Of the full friction force p μ \[N\], equal in all directions, and the radius R \[m\] of the
    /// full friction torque p μ R, see [`DiscPressure::spin_radius`](crate::DiscPressure).
    ///
    /// # Errors
    ///
    /// Refuses a force or a radius that is not positive.
    pub fn isotropic(force: T, spin_radius: T) -> Checked<Self> {
        let force = Named("force", force).positive()?;
        let torque = force * Named("spin_radius", spin_radius).positive()?;
        let factor = Matrix3::from_diagonal(&Vector3::new(force, force, torque));
        Self::of_factor(Some(factor), factor * factor)
    }

    /// The matrix B.
    pub fn matrix(&self) -> Matrix3<T> {
        self.factor * self.factor.transpose()
    }

    /// The radius R \[m\] of the spin: the largest torque over the mean of the largest forces along
    /// x and y.
    pub fn spin_radius(&self) -> T {
        let largest = self.matrix().diagonal().map(T::sqrt);
        largest.z * lit(2.0) / (largest.x + largest.y)
    }

    /// The wrench B t/√(tᵀB t) of sliding with a twist; zero at rest.
    pub fn wrench(&self, twist: &Vector3<T>) -> Vector3<T> {
        let direction = self.factor.tr_mul(twist);
        self.factor * direction.try_normalize(T::zero()).unwrap_or(direction)
    }

    /// The twist of a wrench, along B⁻¹w.
    ///
    /// # Errors
    ///
    /// Refuses a wrench that is zero or not finite.
    pub fn twist(&self, wrench: &Vector3<T>) -> Checked<SlidingTwist<T>> {
        let inside = self.inverse * wrench;
        let utilisation = Named("wrench", inside.norm()).positive()?;
        let twist = self.inverse.tr_mul(&inside) / (utilisation * utilisation);
        Ok(SlidingTwist { twist, utilisation })
    }
}

/// Dissipated power at a twist, its gradient and its Hessian.
type Power<T> = (T, Vector3<T>, Matrix3<T>);

impl<T: Scalar, M: PlaneBristle<T, 2>, P: AsRef<[FootprintPoint<T>]>> Footprint<T, M, P> {
    /// The twist of a wrench \[N, N m\] in quasi-static sliding: the one whose
    /// [wrench](Self::stationary_wrench) has the direction of the given one. The friction
    /// coefficients are those at a `speed` [m/s], at all points.
    ///
    /// A wrench on a flat part of the limit surface turns the body about a point that carries
    /// load, which keeps the rest of it by sticking. Newton's method on the dissipated power,
    /// which is smoothed less and less: some thirty sums over the points.
    ///
    /// ```
    /// # use bristle::curve::{Coulomb, CoulombParameters};
    /// # use bristle::nalgebra::Vector3;
    /// # use bristle_plane::{Footprint, FootprintPoint, PlaneBristle, PlaneFrBd};
    /// # use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
    /// # let curve =
    /// #     Coulomb::new(CoulombParameters { dynamic_coefficient: 0.5, viscous_friction: 0.0 })?;
    /// # let bristle = KelvinVoigtParameters { micro_stiffness: 1e4, micro_damping: 10.0 };
    /// # let bristle = KelvinVoigt::new(bristle)?;
    /// # let contact = PlaneFrBd::isotropic(curve, bristle).under_load(10.0)?;
    /// let points: Vec<_> = FootprintPoint::rectangle([0.1, 0.05], [12, 6]).collect();
    /// let plate = Footprint::new(contact, points)?;
    /// // Pushed by 1 N along x, 30 mm beside the centre.
    /// let sliding = plate.sliding_twist(&Vector3::new(1.0, 0.0, -0.03), 1e-3)?;
    /// let wrench = plate.stationary_wrench(&sliding.twist);
    /// assert!((wrench.z / wrench.x + 0.03_f64).abs() < 1e-6);
    /// assert!((wrench.x * sliding.utilisation - 1.0).abs() < 1e-6);
    /// # Ok::<(), bristle_plane::LimitSurfaceError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses a wrench that is zero or not finite, a contact without friction at that speed, and
    /// points that lie at one place, which resist no torque about it; and fails by name if the
    /// search does not end.
    pub fn sliding_twist(
        &self,
        wrench: &Vector3<T>,
        speed: T,
    ) -> Result<SlidingTwist<T>, LimitSurfaceError> {
        let speed = Named("speed", speed).positive()?;
        let zero = T::zero();
        // The largest force along each axis.
        let friction = |x, y| self.contact().stationary_force(&Vector2::new(x, y));
        let largest = Vector2::new(friction(speed, zero).x, friction(zero, speed).y);
        Named("friction", largest.x).positive()?;
        Named("friction", largest.y).positive()?;
        let (centre, radius) = self.spread();
        let radius = Named("distance of the points", radius).positive()?;
        // About the centre, in units of force, radius and 1 W of the wrench.
        let unit = lit::<T>(0.5) * (largest.x + largest.y);
        let local = Lever([-centre.x, -centre.y]).wrench(&wrench.xy()) + Vector3::z() * wrench.z;
        let local = Vector3::new(local.x, local.y, local.z / radius) / unit;
        let size = Named("wrench", local.norm()).positive()?;
        let points = self.shares().map(|(share, Lever([x, y]))| {
            (share, Lever([(x - centre.x) / radius, (y - centre.y) / radius]))
        });
        let (twist, power) = least_power(points, &(local / size), &(largest / unit))?;
        let spin = twist.z / radius;
        let turned = Vector3::new(twist.x + spin * centre.y, twist.y - spin * centre.x, spin);
        Ok(SlidingTwist { twist: turned / (unit * size), utilisation: size / power })
    }

    /// The centre of the load and the rms distance from it \[m\].
    fn spread(&self) -> (Vector2<T>, T) {
        let centre = self
            .shares()
            .fold(Vector2::zeros(), |sum, (share, Lever([x, y]))| sum + Vector2::new(x, y) * share);
        let square = self.shares().fold(T::zero(), |sum, (share, Lever([x, y]))| {
            sum + (Vector2::new(x, y) - centre).norm_squared() * share
        });
        (centre, square.sqrt())
    }
}

/// The twist t with w·t = 1 of the least power, and this power; w is of length one.
fn least_power<T: Scalar>(
    points: impl Iterator<Item = (T, Lever<T>)> + Clone,
    wrench: &Vector3<T>,
    largest: &Vector2<T>,
) -> Result<(Vector3<T>, T), LimitSurfaceError> {
    let power = |twist: &Vector3<T>, smooth| power(points.clone(), twist, largest, smooth);
    // Where one point carries much of the load, the flat part of a turn about it is large, and
    // at its edge the search is long.
    for (share, Lever([x, y])) in points.clone().filter(|(share, _)| *share > lit(0.2)) {
        let turn = Vector3::new(y, T::zero() - x, T::one());
        let (others, forces, _) = power(&turn, T::zero());
        let torque = wrench.dot(&turn);
        let held = wrench * (others / torque) - forces;
        if held.xy().component_div(largest).norm() <= share {
            return Ok((turn / torque, others / torque.abs()));
        }
    }
    let mut twist = *wrench;
    let (finest, mut smooth): (T, T) = (T::default_epsilon().sqrt(), lit(0.3));
    const ITERATIONS: u32 = 200;
    for _ in 0..ITERATIONS {
        let (before, forces, curvature) = power(&twist, smooth);
        // Newton's step among the twists with w·t = 1. What wwᵀ adds changes no such step.
        let hessian = curvature + wrench * wrench.transpose() * before;
        let Some(solver) = hessian.cholesky() else { break };
        let [along, across] = [solver.solve(&forces), solver.solve(wrench)];
        let multiplier = wrench.dot(&along) / wrench.dot(&across);
        let step = across * multiplier - along;
        let residual = (forces - wrench * multiplier).norm() / forces.norm();
        // Below its roundings the twist can neither be smoothed nor mended.
        let of_twist = twist.norm() * T::default_epsilon() * lit(64.0);
        let last = smooth <= (finest * before).larger(of_twist);
        if last && (residual <= finest * lit(16.0) || step.norm() <= of_twist) {
            return Ok((twist, power(&twist, T::zero()).0));
        }
        // Each stage but the last need only come as near as its smoothing.
        if !last && -forces.dot(&step) <= smooth * lit(0.1) {
            smooth *= lit(0.1);
            continue;
        }
        let (promised, rounding) = (forces.dot(&step), before * T::default_epsilon());
        let mut length = T::one();
        let enough = |length: T| {
            let after = power(&(twist + step * length), smooth).0;
            after <= before + promised * length * lit(0.1) + rounding * lit(8.0)
        };
        while length > finest && !enough(length) {
            length *= lit(0.5);
        }
        twist += step * length;
    }
    Err(LimitSurfaceError::NotConverged(ITERATIONS))
}

/// Σ wⱼ √(‖M vⱼ‖² + ε²) with the largest forces M over their mean.
fn power<T: Scalar>(
    points: impl Iterator<Item = (T, Lever<T>)>,
    twist: &Vector3<T>,
    largest: &Vector2<T>,
    smooth: T,
) -> Power<T> {
    let zero = T::zero();
    let none = (zero, Vector3::zeros(), Matrix3::zeros());
    points.fold(none, |sum, (share, lever)| {
        let weighted = lever.velocity(twist).component_mul(largest);
        let power = (weighted.norm_squared() + smooth * smooth).sqrt();
        if !(power > zero) {
            return sum;
        }
        let wrench = lever.wrench(&(weighted.component_mul(largest) / power));
        let stiff = lever.damping(&largest.component_mul(largest));
        let curvature = (stiff - wrench * wrench.transpose()) * (share / power);
        (sum.0 + share * power, sum.1 + wrench * share, sum.2 + curvature)
    })
}
