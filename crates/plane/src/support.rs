//! Which points of a body carry its load, from pushes: the linear half of [`crate::pushes`].

use alloc::vec::Vec;

use bristle::Scalar;
use bristle::parameter::Named;
use bristle::scalar::lit;
use nalgebra::{DMatrix, DVector, Matrix3xX, Vector3};

use crate::footprint::Lever;
use crate::{FootprintPoint, LimitSurfaceError, Push};

/// The points of a support and the friction of each, from [`Support::fit`].
#[derive(Debug, Clone, PartialEq)]
pub struct Support<T> {
    /// The points, for a [`Footprint`](crate::Footprint). The weight of each is its share of the
    /// normal force; those at which nothing was found are zero.
    pub points: Vec<FootprintPoint<T>>,
    /// Full friction force p μ \[N\].
    pub friction: T,
    /// Scatter of the wrenches over the standard deviations that were given \[–\], all rows.
    pub scatter: T,
}

impl<T: Scalar> Support<T> {
    /// The weights of points that give the wrenches of pushes, with the standard deviation of a
    /// measured wrench \[N, N, N m\] and friction that is equal in all directions.
    ///
    /// The regulariser ρ \[–\], positive, draws the weights to those of the given points: it counts
    /// as much as ρ pushes that say so. 1 for many points; far below one where there are few.
    ///
    /// ```
    /// use bristle::nalgebra::Vector3;
    /// use bristle_plane::{FootprintPoint, Push, Support};
    ///
    /// // Three feet under 3, 2 and 1 N of friction, of four that could be there.
    /// let feet = [[0.0, 0.0], [0.1, 0.0], [0.0, 0.1], [0.1, 0.1]]
    ///     .map(|place| FootprintPoint { place, weight: 1.0 });
    /// let wrench = |t: &Vector3<f64>| {
    ///     feet.iter().zip([3.0, 2.0, 1.0, 0.0]).fold(Vector3::zeros(), |sum, (foot, friction)| {
    ///         let [x, y] = foot.place;
    ///         let (v_x, v_y) = (t.x - t.z * y, t.y + t.z * x);
    ///         let (f_x, f_y) = (friction * v_x / v_x.hypot(v_y), friction * v_y / v_x.hypot(v_y));
    ///         sum + Vector3::new(f_x, f_y, x * f_y - y * f_x)
    ///     })
    /// };
    /// let pushes: Vec<_> = (0..20)
    ///     .map(|k| 0.01 * Vector3::new(f64::from(k % 3), 0.4, f64::from(k)))
    ///     .map(|twist| Push { twist, wrench: wrench(&twist) })
    ///     .collect();
    /// let found = Support::fit(&feet, &pushes, &Vector3::new(0.1, 0.1, 5e-3), 1e-9)?;
    /// assert!((found.friction - 6.0).abs() < 1e-4 && (found.points[0].weight - 0.5).abs() < 1e-4);
    /// # Ok::<(), bristle_plane::LimitSurfaceError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses pushes without a twist or that are not finite, none of them, points that
    /// [`Footprint::new`](crate::Footprint::new) would refuse, and a deviation or regulariser that
    /// is not positive; fails by name if the search has not ended.
    pub fn fit(
        points: &[FootprintPoint<T>],
        pushes: &[Push<T>],
        deviation: &Vector3<T>,
        regulariser: T,
    ) -> Result<Self, LimitSurfaceError> {
        Push::checked(pushes, 1, deviation)?;
        let regulariser = Named("regulariser", regulariser).positive()?;
        let sum = FootprintPoint::checked_sum(points)?;
        // Normal equations G c = b of what each point carries.
        let count = points.len();
        let (mut matrix, mut right) = (DMatrix::zeros(count, count), DVector::zeros(count));
        for push in pushes {
            let wrenches = unit_wrenches(points, &push.twist, deviation);
            right += wrenches.tr_mul(&push.wrench.component_div(deviation));
            matrix += wrenches.tr_mul(&wrenches);
        }
        // The friction with the shares given, and its square as the unit of the regulariser.
        let shares = DVector::from_iterator(count, points.iter().map(|point| point.weight / sum));
        let stiff = shares.dot(&(&matrix * &shares));
        let prior = &shares * (right.dot(&shares) / stiff).larger(T::zero());
        let weight = regulariser * stiff / lit(pushes.len() as f64) * lit(count as f64);
        right += &prior * weight;
        matrix += DMatrix::from_diagonal_element(count, count, weight);
        let carried = minimised(&matrix, &right, prior)?;
        let friction = Named("friction", carried.sum()).positive()?;
        let squares = pushes.iter().fold(T::zero(), |sum, push| {
            let found = unit_wrenches(points, &push.twist, deviation) * &carried;
            sum + (push.wrench.component_div(deviation) - found).norm_squared()
        });
        let scatter = (squares / lit(3.0 * pushes.len() as f64)).sqrt();
        let weighted = points.iter().zip(&carried);
        let points =
            weighted.map(|(point, &c)| FootprintPoint { weight: c / friction, ..*point }).collect();
        Ok(Self { points, friction, scatter })
    }
}

/// Wrenches of a friction of 1 N at each point, over the deviations.
fn unit_wrenches<T: Scalar>(
    points: &[FootprintPoint<T>],
    twist: &Vector3<T>,
    deviation: &Vector3<T>,
) -> Matrix3xX<T> {
    let wrench = |point: &FootprintPoint<T>| Lever(point.place).unit_wrench(twist);
    let columns = points.iter().map(|point| wrench(point).component_div(deviation));
    Matrix3xX::from_columns(&columns.collect::<Vec<_>>())
}

/// The minimum of ½ cᵀG c − bᵀc with c ≥ 0, one unknown after the other, until the residual of no
/// unknown that is free is above √ε max|b|.
fn minimised<T: Scalar>(
    matrix: &DMatrix<T>,
    right: &DVector<T>,
    mut carried: DVector<T>,
) -> Result<DVector<T>, LimitSurfaceError> {
    const SWEEPS: u32 = 100_000;
    let fine = T::default_epsilon().sqrt() * right.amax();
    for _ in 0..SWEEPS {
        let mut worst = T::zero();
        for (i, column) in matrix.column_iter().enumerate() {
            let residual = right[i] - column.dot(&carried);
            let held = carried[i] <= T::zero() && residual <= T::zero();
            worst = if held { worst } else { worst.larger(residual.abs()) };
            carried[i] = (carried[i] + residual / column[i]).larger(T::zero());
        }
        if worst <= fine {
            return Ok(carried);
        }
    }
    Err(LimitSurfaceError::NotConverged(SWEEPS))
}
