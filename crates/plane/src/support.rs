//! Which points of a body carry its load, from pushes: the linear half of [`crate::pushes`].

use alloc::vec;
use alloc::vec::Vec;

use bristle::Scalar;
use bristle::parameter::Named;
use bristle::scalar::{is_zero, lit};
use nalgebra::Vector3;

use crate::footprint::Lever;
use crate::surface::norm;
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
        let (mut matrix, mut right) = (vec![T::zero(); count * count], vec![T::zero(); count]);
        for push in pushes {
            let wanted = push.wrench.component_div(deviation);
            let columns = points.iter().map(|point| unit_wrench(point, &push.twist, deviation));
            let columns: Vec<_> = columns.collect();
            for ((row, right), column) in matrix.chunks_mut(count).zip(&mut right).zip(&columns) {
                *right += column.dot(&wanted);
                row.iter_mut().zip(&columns).for_each(|(entry, other)| *entry += column.dot(other));
            }
        }
        // The friction with the shares given, and its square as the unit of the regulariser.
        let shares: Vec<T> = points.iter().map(|point| point.weight / sum).collect();
        let together = matrix.chunks(count).map(|row| dot(row, &shares));
        let stiff = dot(&shares, &together.collect::<Vec<_>>());
        let prior = (dot(&right, &shares) / stiff).larger(T::zero());
        let weight = regulariser * stiff / lit(pushes.len() as f64) * lit(count as f64);
        for ((i, right), &share) in right.iter_mut().enumerate().zip(&shares) {
            *right += weight * prior * share;
            if let Some(entry) = matrix.get_mut(i * (count + 1)) {
                *entry += weight;
            }
        }
        let carried = minimised(&matrix, &right, shares.iter().map(|&s| prior * s).collect())?;
        let friction = carried.iter().fold(T::zero(), |sum, &c| sum + c);
        let friction = Named("friction", friction).positive()?;
        let squares = pushes.iter().fold(T::zero(), |sum, push| {
            let wanted = push.wrench.component_div(deviation);
            let left = points.iter().zip(&carried).fold(wanted, |left, (point, &c)| {
                left - unit_wrench(point, &push.twist, deviation) * c
            });
            sum + left.norm_squared()
        });
        let scatter = (squares / lit(3.0 * pushes.len() as f64)).sqrt();
        let weighted = points.iter().zip(carried);
        let points =
            weighted.map(|(point, c)| FootprintPoint { weight: c / friction, ..*point }).collect();
        Ok(Self { points, friction, scatter })
    }
}

/// Wrench of a friction of 1 N at a point, over the deviations; zero where it rests.
fn unit_wrench<T: Scalar>(
    point: &FootprintPoint<T>,
    twist: &Vector3<T>,
    deviation: &Vector3<T>,
) -> Vector3<T> {
    let lever = Lever(point.place);
    let velocity = lever.velocity(twist);
    let speed = norm(&velocity);
    if is_zero(speed) {
        return Vector3::zeros();
    }
    lever.wrench(&(velocity / speed)).component_div(deviation)
}

/// x·y
fn dot<T: Scalar>(x: &[T], y: &[T]) -> T {
    x.iter().zip(y).fold(T::zero(), |sum, (&x, &y)| sum + x * y)
}

/// The minimum of ½ cᵀG c − bᵀc with c ≥ 0, one unknown after the other, until the residual of no
/// unknown that is free is above √ε max|b|.
fn minimised<T: Scalar>(
    matrix: &[T],
    right: &[T],
    mut carried: Vec<T>,
) -> Result<Vec<T>, LimitSurfaceError> {
    const SWEEPS: u32 = 100_000;
    let fine = T::default_epsilon().sqrt() * right.iter().fold(T::zero(), |m, b| m.larger(b.abs()));
    for _ in 0..SWEEPS {
        let mut worst = T::zero();
        for (i, (row, &right)) in matrix.chunks(right.len()).zip(right).enumerate() {
            let (Some(&diagonal), residual) = (row.get(i), right - dot(row, &carried)) else {
                continue;
            };
            if let Some(c) = carried.get_mut(i) {
                let held = *c <= T::zero() && residual <= T::zero();
                worst = if held { worst } else { worst.larger(residual.abs()) };
                *c = (*c + residual / diagonal).larger(T::zero());
            }
        }
        if worst <= fine {
            return Ok(carried);
        }
    }
    Err(LimitSurfaceError::NotConverged(SWEEPS))
}
