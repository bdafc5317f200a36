//! A limit surface from pushes: pairs of twist and wrench of a body that slides slowly.
//!
//! min Σ ‖(w_k − w(t_k))/s‖²
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | t_k, w_k | measured twist, measured friction wrench against it | m/s, rad/s; N, N m |
//! | w(t) | wrench of the limit surface at a twist | N, N m |
//! | s | standard deviation of the measured wrench | N, N, N m |
//!
//! The error is in the wrench, which sensors give with more noise than a camera gives directions.
//! Least squares in the matrix of wᵀB⁻¹w = 1 and in the direction B⁻¹w would be linear, but biased
//! by that noise, which enters squared. Of an ellipsoid w(t) = L n with n = Lᵀt/‖Lᵀt‖ and B = L Lᵀ,
//! and L is sought by Levenberg's and Marquardt's method: B is positive definite whatever L is.
//!
//! The wrench of a support of points is linear in what they carry, w(t) = Σ c_j g_j(t) with the
//! friction c_j = μ p w_j ≥ 0 of point j \[N\] and the wrench g_j(t) of a unit friction: linear
//! least squares with one minimum. Points that lie close to each other are told apart by a
//! regulariser alone.
//!
//! Source of such pairs, and of surfaces of the fourth degree: J. Zhou, R. Paolini, J. A. Bagnell,
//! M. T. Mason, "A convex polynomial force-motion model for planar sliding", IEEE ICRA 2016.

use bristle::Scalar;
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::scalar::lit;
use nalgebra::{Cholesky, Const, Matrix3, SMatrix, SVector, Vector3};

use crate::{FrictionEllipsoid, LimitSurfaceError};

/// A measured pair of quasi-static sliding, in axes of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Push<T> {
    /// Twist (v_x, v_y, ω) \[m/s, m/s, rad/s\] or any multiple: the direction counts.
    pub twist: Vector3<T>,
    /// Friction wrench (F_x, F_y, M) \[N, N, N m\] against it: that of the pusher.
    pub wrench: Vector3<T>,
}

impl<T: Scalar> Push<T> {
    /// The angle \[rad\] between the measured twist and a predicted one, with spins times a
    /// `length` \[m\]: the size of the body, such as the rms distance of its points.
    pub fn angle(&self, predicted: &Vector3<T>, length: T) -> T {
        let metric = Vector3::new(T::one(), T::one(), length);
        self.twist.component_mul(&metric).angle(&predicted.component_mul(&metric))
    }

    pub(crate) fn checked(pushes: &[Self], least: usize, deviation: &Vector3<T>) -> Checked<()> {
        Named("pushes", pushes.len()).count(least)?;
        ParameterError::of_components(deviation, |&it| Named("deviation", it).positive())?;
        ParameterError::of_components(pushes, |push| {
            Named("twist", push.twist.norm()).positive()?;
            Named("wrench", push.wrench.norm()).finite()
        })
    }
}

/// Which ellipsoids are sought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum EllipsoidFamily {
    /// Equal in all directions: the full friction force and the spin radius. Two parameters.
    Isotropic,
    /// Along the axes: largest F_x, F_y and M. Three parameters.
    Ratios,
    /// Any: turned, and off centre. Six parameters.
    Turned,
}

impl EllipsoidFamily {
    /// Which parameter each entry of L is: L_xx, L_yy, L_ωω, L_yx, L_ωx, L_ωy.
    fn entries(self) -> &'static [usize] {
        match self {
            Self::Isotropic => &[0, 0, 1],
            Self::Ratios => &[0, 1, 2],
            Self::Turned => &[0, 1, 2, 3, 4, 5],
        }
    }
}

/// Rows and columns of the entries of L.
const PLACES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 0), (2, 0), (2, 1)];

/// An ellipsoid from pushes, by [`FrictionEllipsoid::fit`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EllipsoidFit<T> {
    /// The ellipsoid.
    pub ellipsoid: FrictionEllipsoid<T>,
    /// The factor L of its matrix, B = L Lᵀ, lower triangular. Its first row is the largest F_x.
    pub factor: Matrix3<T>,
    /// Standard errors of the entries of L; zero where the family has no parameter. From the
    /// scatter of the wrenches, so that those given need to be right up to a factor only.
    pub standard_errors: Matrix3<T>,
    /// Scatter of the wrenches over the standard deviations that were given \[–\].
    pub scatter: T,
}

type Normal<T> = (SMatrix<T, 6, 6>, SVector<T, 6>, T);

impl<T: Scalar> FrictionEllipsoid<T> {
    /// The ellipsoid nearest to the wrenches of pushes, with the standard deviation of a measured
    /// wrench \[N, N, N m\].
    ///
    /// ```
    /// use bristle::nalgebra::Vector3;
    /// use bristle_plane::{EllipsoidFamily, FrictionEllipsoid, Push};
    ///
    /// let real = FrictionEllipsoid::isotropic(5.0, 0.02)?; // N, m
    /// let pushes: Vec<_> = (0..12)
    ///     .map(|k| Vector3::new(0.01, 0.002 * f64::from(k), 0.3 * f64::from(k % 5) - 0.6))
    ///     .map(|twist| Push { twist, wrench: real.wrench(&twist) })
    ///     .collect();
    /// let noise = Vector3::new(0.1, 0.1, 2e-3); // N, N, N m
    /// let fit = FrictionEllipsoid::fit(&pushes, EllipsoidFamily::Isotropic, &noise)?;
    /// assert!((fit.ellipsoid.spin_radius() - 0.02).abs() < 1e-9);
    /// let predicted = fit.ellipsoid.twist(&pushes[3].wrench)?.twist;
    /// assert!(pushes[3].angle(&predicted, 0.02) < 1e-6); // rad
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses pushes without a twist or that are not finite, fewer pushes than parameters, and a
    /// deviation that is not positive; fails by name where they leave a parameter open.
    pub fn fit(
        pushes: &[Push<T>],
        family: EllipsoidFamily,
        deviation: &Vector3<T>,
    ) -> Result<EllipsoidFit<T>, LimitSurfaceError> {
        let entries = family.entries();
        let count = entries.iter().max().map_or(0, |last| last + 1);
        let undetermined = LimitSurfaceError::Undetermined(count);
        Push::checked(pushes, count, deviation)?;
        let mean = |of: fn(&Vector3<T>) -> T| {
            pushes.iter().fold(T::zero(), |sum, push| sum + of(&push.wrench))
                / lit(pushes.len() as f64)
        };
        let force = Named("force", mean(|w| w.xy().norm())).positive()?;
        let torque = Named("torque", mean(|w| w.z.abs())).positive()?;
        let sizes = Vector3::new(force, force, torque);
        let mut factor = Matrix3::from_diagonal(&sizes);
        let (mut damping, mut normal) =
            (lit::<T>(1e-3), squares(pushes, entries, deviation, &factor));
        for _ in 0..200 {
            let solver = factored(&normal.0, count, damping).ok_or(undetermined)?;
            let step = solver.solve(&normal.1);
            let (mut next, mut largest) = (factor, T::zero());
            for (&parameter, &place) in entries.iter().zip(&PLACES) {
                next[place] += step[parameter];
                largest = largest.larger((step[parameter] / sizes[place.0]).abs());
            }
            let after = squares(pushes, entries, deviation, &next);
            let change = step.dot(&normal.1);
            // Of exact pushes nothing but roundings is left, which no step makes smaller.
            let rounded = largest <= T::default_epsilon().sqrt() && !(after.2 < normal.2);
            let settled = rounded || change.abs() <= T::default_epsilon() * lit(64.0) * normal.2;
            if after.2 <= normal.2 {
                (factor, normal, damping) = (next, after, damping * lit(0.1));
            } else {
                damping *= lit(10.0);
            }
            if settled {
                let inverse = factored(&normal.0, count, T::zero()).ok_or(undetermined)?.inverse();
                let scatter = (normal.2 / lit((3 * pushes.len() - count) as f64)).sqrt();
                let mut standard_errors = Matrix3::zeros();
                for (&parameter, &place) in entries.iter().zip(&PLACES) {
                    standard_errors[place] = scatter * inverse[(parameter, parameter)].sqrt();
                }
                let ellipsoid = Self::of_factor(Some(factor), factor)?;
                return Ok(EllipsoidFit { ellipsoid, factor, standard_errors, scatter });
            }
        }
        Err(LimitSurfaceError::NotConverged(200))
    }
}

/// JᵀJ, Jᵀr and rᵀr of the residuals over their deviations.
fn squares<T: Scalar>(
    pushes: &[Push<T>],
    entries: &[usize],
    deviation: &Vector3<T>,
    factor: &Matrix3<T>,
) -> Normal<T> {
    let (mut matrix, mut right, mut sum) = (SMatrix::zeros(), SVector::zeros(), T::zero());
    for push in pushes {
        let inside = factor.tr_mul(&push.twist);
        let size = inside.norm();
        let n = inside / size;
        let residual = (push.wrench - factor * n).component_div(deviation);
        // ∂w/∂L_ab = e_a n_b + L (e_b − n n_b) t_a/‖Lᵀt‖
        let mut slopes = SMatrix::<T, 3, 6>::zeros();
        for (&parameter, &(a, b)) in entries.iter().zip(&PLACES) {
            let mut turned = n * -n[b];
            turned[b] += T::one();
            let mut slope = factor * turned * (push.twist[a] / size);
            slope[a] += n[b];
            let mut column = slopes.column_mut(parameter);
            column += slope.component_div(deviation);
        }
        matrix += slopes.tr_mul(&slopes);
        right += slopes.tr_mul(&residual);
        sum += residual.norm_squared();
    }
    (matrix, right, sum)
}

/// JᵀJ with its diagonal times 1 + damping, factored; none where it leaves a parameter open.
fn factored<T: Scalar>(
    matrix: &SMatrix<T, 6, 6>,
    count: usize,
    damping: T,
) -> Option<Cholesky<T, Const<6>>> {
    let mut matrix = *matrix;
    for i in 0..6 {
        let used = matrix[(i, i)] * (T::one() + damping);
        matrix[(i, i)] = if i < count { used } else { T::one() };
    }
    matrix.cholesky()
}
