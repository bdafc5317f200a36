//! A contact surface: points of a footprint, each with its bristles and its share of the load.
//!
//! vⱼ = (v_x − ω yⱼ, v_y + ω xⱼ),  F = Σ wⱼ Fⱼ,  M = Σ wⱼ (xⱼ F_yⱼ − yⱼ F_xⱼ)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | (v_x, v_y, ω) | twist: sliding velocity at the origin, relative rate of spin | m/s, rad/s |
//! | (F_x, F_y, M) | wrench: friction against the motion, its torque about the origin | N, N m |
//! | (xⱼ, yⱼ) | place of point j on the body that carries the points | m |
//! | wⱼ, Σ wⱼ = 1 | share of point j in the normal force p | – |
//! | Fⱼ | friction force of a contact on two axes under the whole of p at vⱼ | N |
//!
//! Every point is a passive contact, so the footprint is one: its dissipation is the sum of theirs.
//! Under a companion step each point is a source and a damper. Together they are one wrench and a
//! symmetric, positive semidefinite 3 × 3 matrix.
//!
//! Three axes with a spin radius (see the [module](super)) are the cheap model, with an ellipsoid
//! for the limit surface; [`Footprint::limit_ellipsoid`] tells its error. The footprint does not
//! roll.
//!
//! Source: the limit surface as a sum over the points of a patch is that of S. Goyal, A. Ruina,
//! J. Papadopoulos, "Planar sliding with dry friction", Wear 143 (1991).

use nalgebra::{Matrix3, Vector2, Vector3};

use super::surface::norm;
use super::{PlaneBristle, PlaneCompanion, PlaneCompanionStep, PlaneContact, length};
use bristle::companion::CompletedStep;
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::scalar::{is_zero, lit};
use bristle::{Reloaded, Scalar};

/// A point of a [`Footprint`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct FootprintPoint<T> {
    /// Place (x, y) \[m\] in axes of the body that carries the points.
    pub place: [T; 2],
    /// Weight, zero or positive: pressure times area in any unit. Its share wⱼ of the normal force
    /// is its part of the sum of all weights.
    pub weight: T,
}

/// How the pressure falls towards the edge of a disc.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum DiscPressure {
    /// Constant.
    Uniform,
    /// √(1 − (r/a)²), of two elastic bodies.
    Hertz,
}

impl DiscPressure {
    /// The radius R \[m\] that turns the spin of a disc of a radius a \[m\] into an axis R ω: the
    /// full friction torque is R times the full friction force, with R = ⅔ a under a uniform
    /// pressure and 3π/16 a under that of Hertz. NaN for a negative radius.
    pub fn spin_radius<T: Scalar>(self, radius: T) -> T {
        length(radius)
            * lit(match self {
                Self::Uniform => 2.0 / 3.0,
                Self::Hertz => 3.0 * core::f64::consts::PI / 16.0,
            })
    }
}

impl<T: Scalar> FootprintPoint<T> {
    /// The 3 n² points of a disc of a radius a \[m\] about the origin, on n rings. A negative
    /// radius gives places that are NaN, which [`Footprint::new`] refuses.
    pub fn disc(radius: T, pressure: DiscPressure, rings: u16) -> impl Iterator<Item = Self> {
        let number = |count: u32| lit::<T>(f64::from(count));
        // Share of the load within a radius, and the radius of such a share.
        let within = move |r: T| match pressure {
            DiscPressure::Uniform => r * r,
            DiscPressure::Hertz => T::one() - (T::one() - r * r).powf(lit(1.5)),
        };
        let radius_of = move |share: T| match pressure {
            DiscPressure::Uniform => share.sqrt(),
            DiscPressure::Hertz => (T::one() - (T::one() - share).powf(lit(2.0 / 3.0))).sqrt(),
        };
        (0..u32::from(rings)).flat_map(move |ring| {
            let edge = |ring: u32| within(number(ring) / number(u32::from(rings)));
            let (inside, outside, count) = (edge(ring), edge(ring + 1), 6 * ring + 3);
            let r = length(radius) * radius_of((inside + outside) * lit(0.5));
            let weight = (outside - inside) / number(count);
            (0..count).map(move |k| {
                let (sin, cos) = (T::two_pi() * number(k) / number(count)).sin_cos();
                FootprintPoint { place: [r * cos, r * sin], weight }
            })
        })
    }

    /// The sum of all weights.
    pub(crate) fn checked_sum(points: &[Self]) -> Checked<T> {
        let mut sum = T::zero();
        ParameterError::of_components(points, |&FootprintPoint { place: [x, y], weight }| {
            Named("place", x).finite()?;
            Named("place", y).finite()?;
            sum += Named("weight", weight).non_negative()?;
            Ok(())
        })?;
        Named("sum of weights", sum).positive()
    }

    /// The points of a rectangle of a length and a width \[m\] about the origin under a uniform
    /// pressure, in rows and columns at the middles of equal cells. A negative length or width
    /// gives places that are NaN, which [`Footprint::new`] refuses.
    pub fn rectangle(size: [T; 2], counts: [u16; 2]) -> impl Iterator<Item = Self> {
        let place = move |axis: usize, cell: u16| {
            let [size, count] = [size[axis % 2], lit(f64::from(counts[axis % 2]))];
            length(size) * ((lit::<T>(f64::from(cell)) + lit(0.5)) / count - lit(0.5))
        };
        (0..counts[1]).flat_map(move |row| {
            (0..counts[0]).map(move |column| FootprintPoint {
                place: [place(0, column), place(1, row)],
                weight: T::one(),
            })
        })
    }
}

/// A contact surface of points P, each with a bristle model M on two axes.
///
/// # Axes
///
/// Of the two bodies one carries the points and their bristles. Places, deflections, twists and
/// wrenches are in axes that *this* body carries, about an origin fixed in it. The twist is its
/// motion less that of the other body at the same place; −(F_x, F_y, M) acts on it, and
/// (F_x, F_y, M) on the other.
///
/// A velocity that is kept in fixed axes is turned by −θ before a step, and the wrench by θ after
/// it, where θ \[rad\] is the angle of the body that carries the points. In its axes the equation
/// of motion of a mass has the term m Ω × v with its rate of turning Ω [rad/s], which is ω only if
/// the other body does not turn.
///
/// ```
/// use bristle::curve::{Coulomb, CoulombParameters};
/// use bristle::nalgebra::Vector3;
/// use bristle_plane::{DiscPressure, Footprint, FootprintPoint, PlaneBristle, PlaneFrBd};
/// use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
///
/// let curve =
///     Coulomb::new(CoulombParameters { dynamic_coefficient: 0.5, viscous_friction: 0.0 })?;
/// let bristle =
///     KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness: 1e4, micro_damping: 10.0 })?;
/// let contact = PlaneFrBd::isotropic(curve, bristle).under_load(10.0)?; // N
/// let points: Vec<_> = FootprintPoint::disc(0.03, DiscPressure::Uniform, 10).collect();
/// let finger = Footprint::new(contact, points)?;
///
/// // On the spot it spins with ⅔ a μ p. While it spins fast, it slides nearly without force.
/// let spin = finger.stationary_wrench(&Vector3::new(0.0, 0.0, 10.0));
/// assert!((spin.z / (2.0 / 3.0 * 0.03 * 5.0) - 1.0_f64).abs() < 2e-3 && spin.xy().norm() < 1e-12);
/// let both = finger.stationary_wrench(&Vector3::new(0.01, 0.0, 10.0));
/// assert!(both.x < 0.3);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint<T, M, P> {
    contact: PlaneContact<T, M, 2>,
    points: P,
    /// 1/Σ weights
    inverse: T,
}

/// The ellipsoid that stands for the limit surface of a footprint, from
/// [`Footprint::limit_ellipsoid`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitEllipsoid<T> {
    /// Radius R \[m\] of the spin as a third axis R ω: full friction torque over full friction
    /// force.
    pub spin_radius: T,
    /// How far the limit surface is from the ellipsoid at most \[–\]: the error of the size of the
    /// wrench (F_x, F_y, M/R), over the size.
    pub surface_error: T,
    /// How far the wrench (F_x, F_y, M/R) is from that of the ellipsoid at the same twist at most
    /// \[–\], over the full friction force. It is larger, because the directions differ too.
    pub wrench_error: T,
}

impl<T: Scalar, M: PlaneBristle<T, 2>, P: AsRef<[FootprintPoint<T>]>> Footprint<T, M, P> {
    /// A contact under the whole normal force, spread over points.
    ///
    /// # Errors
    ///
    /// Refuses a place that is not finite, a weight that is negative or not finite, and weights
    /// without a positive sum. Names the point.
    pub fn new(contact: PlaneContact<T, M, 2>, points: P) -> Checked<Self> {
        let sum = FootprintPoint::checked_sum(points.as_ref())?;
        Ok(Self { contact, points, inverse: T::one() / sum })
    }

    /// The contact under the whole normal force.
    pub fn contact(&self) -> &PlaneContact<T, M, 2> {
        &self.contact
    }

    /// The points.
    pub fn points(&self) -> &[FootprintPoint<T>] {
        self.points.as_ref()
    }

    /// Changes the normal force to p' \[N\], zero or positive, before a step; each point keeps its
    /// share of it. Cuts the deflections that are no longer held at the `twist`, and returns the
    /// energy \[J\] that is dissipated, see [`PlaneContact::reload`].
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite, and another number of deflections
    /// than points; the footprint is as it was.
    pub fn reload(
        &mut self,
        normal_force: T,
        twist: &Vector3<T>,
        deflections: &mut [Vector2<T>],
    ) -> Checked<Reloaded<T, ()>> {
        self.as_many("deflections", deflections.len())?;
        let change = self.contact.change_load(normal_force)?;
        let mut dissipated = T::zero();
        for ((share, lever), deflection) in self.shares().zip(deflections) {
            let left = self.contact.held(change, &lever.velocity(twist), deflection);
            *deflection = left.deflection;
            dissipated += share * left.dissipated;
        }
        Ok(Reloaded { deflection: (), dissipated })
    }

    /// Each point's share of the normal force and its place.
    pub(crate) fn shares(&self) -> impl Iterator<Item = (T, Lever<T>)> + Clone {
        self.points().iter().map(|point| (point.weight * self.inverse, Lever(point.place)))
    }

    /// The wrench \[N, N m\] of steady sliding with a twist: a point of the limit surface.
    pub fn stationary_wrench(&self, twist: &Vector3<T>) -> Vector3<T> {
        self.shares().fold(Vector3::zeros(), |sum, (share, lever)| {
            sum + lever.wrench(&self.contact.stationary_force(&lever.velocity(twist))) * share
        })
    }

    /// The ellipsoid of three axes that is nearest to the limit surface of these points, and how
    /// far it is from it: whether the cheap model will do.
    ///
    /// It is of constant friction, equal along both axes, and tells nothing of the friction curve.
    /// Evaluates the points 1041 times.
    ///
    /// ```
    /// # use bristle::curve::{Coulomb, CoulombParameters};
    /// # use bristle_plane::{Footprint, FootprintPoint, PlaneBristle, PlaneFrBd};
    /// # use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
    /// # let curve =
    /// #     Coulomb::new(CoulombParameters { dynamic_coefficient: 0.5, viscous_friction: 0.0 })?;
    /// # let bristle = KelvinVoigtParameters { micro_stiffness: 1e4, micro_damping: 10.0 };
    /// # let bristle = KelvinVoigt::new(bristle)?;
    /// # let contact = PlaneFrBd::isotropic(curve, bristle).under_load(10.0)?;
    /// let points: Vec<_> = FootprintPoint::rectangle([0.1, 0.1], [20, 20]).collect();
    /// let square = Footprint::new(contact, points)?.limit_ellipsoid();
    /// assert!((square.spin_radius - 0.03826_f64).abs() < 1e-4); // (√2 + asinh 1)/6 of the side
    /// assert!(square.surface_error > 0.05 && square.surface_error < 0.1);
    /// assert!(square.wrench_error > 0.15 && square.wrench_error < 0.2);
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    pub fn limit_ellipsoid(&self) -> LimitEllipsoid<T> {
        // Over the friction force of pure sliding.
        let wrench = |twist: &Vector3<T>| {
            self.shares().fold(Vector3::zeros(), |sum, (share, lever)| {
                sum + lever.unit_wrench(twist) * share
            })
        };
        let (spin_radius, zero) = (wrench(&Vector3::z()).z, T::zero());
        let mut nearest = LimitEllipsoid { spin_radius, surface_error: zero, wrench_error: zero };
        if is_zero(spin_radius) {
            return nearest;
        }
        let angle = |part: i8, parts: i8| T::pi() * lit(f64::from(part) / f64::from(parts));
        for (part, direction) in (-32..=32).flat_map(|part| (0..16).map(move |j| (part, j))) {
            let ((turn, slide), (sin, cos)) =
                (angle(part, 64).sin_cos(), angle(direction, 16).sin_cos());
            // Of the twist (v_x, v_y, R ω), and of the wrench with which the ellipsoid answers it.
            let direction = Vector3::new(slide * cos, slide * sin, turn);
            let mut got = wrench(&Vector3::new(direction.x, direction.y, turn / spin_radius));
            got.z /= spin_radius;
            nearest.surface_error = nearest.surface_error.larger((T::one() - norm(&got)).abs());
            nearest.wrench_error = nearest.wrench_error.larger(norm(&(got - direction)));
        }
        nearest
    }

    /// The wrench \[N, N m\] at a twist and the deflections \[m\] of all points; NaN for another
    /// number of deflections.
    pub fn wrench(&self, twist: &Vector3<T>, deflections: &[Vector2<T>]) -> Vector3<T> {
        if deflections.len() != self.points().len() {
            return Vector3::repeat(T::nan());
        }
        self.shares().zip(deflections).fold(Vector3::zeros(), |sum, ((share, lever), z)| {
            sum + lever.wrench(&self.contact.force(&lever.velocity(twist), z)) * share
        })
    }

    /// The energy \[J\] stored in the bristles of all points.
    pub fn stored_energy(&self, deflections: &[Vector2<T>]) -> T {
        self.shares()
            .zip(deflections)
            .fold(T::zero(), |sum, ((share, _), z)| sum + share * self.contact.stored_energy(z))
    }

    /// The exact step of length h ≥ 0 \[s\] at a held twist: moves the deflections of all points
    /// and returns the mean wrench \[N, N m\].
    ///
    /// # Errors
    ///
    /// Refuses another number of deflections than points.
    pub fn hold(
        &self,
        twist: &Vector3<T>,
        deflections: &mut [Vector2<T>],
        duration: T,
    ) -> Checked<Vector3<T>> {
        self.as_many("deflections", deflections.len())?;
        let mut mean = Vector3::zeros();
        for ((share, lever), z) in self.shares().zip(deflections) {
            let held = self.contact.hold(&lever.velocity(twist), z, duration);
            *z = held.deflection;
            mean += lever.wrench(&held.mean_force) * share;
        }
        Ok(mean)
    }

    /// Prepares the footprint for passive steps inside a mechanism, with the limits of its
    /// deflections for speeds up to `fastest` [m/s] of any point, see [`PlaneContact::companion`].
    ///
    /// # Errors
    ///
    /// Refuses a speed that is negative or not finite.
    pub fn companion(self, fastest: T) -> Checked<FootprintCompanion<T, M, P>> {
        let companion = self.contact.clone().companion(fastest)?;
        Ok(FootprintCompanion { footprint: self, companion })
    }

    /// As many of something as points.
    fn as_many(&self, name: &'static str, count: usize) -> Checked<()> {
        let points = self.points().len();
        Named(name, count).count_between(points, points)
    }
}

/// The place of a point, from which twists and wrenches are seen.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lever<T>(pub(crate) [T; 2]);

impl<T: Scalar> Lever<T> {
    #[inline(always)]
    pub(crate) fn velocity(self, twist: &Vector3<T>) -> Vector2<T> {
        let [x, y] = self.0;
        Vector2::new(twist.x - twist.z * y, twist.y + twist.z * x)
    }

    #[inline(always)]
    pub(crate) fn wrench(self, force: &Vector2<T>) -> Vector3<T> {
        let [x, y] = self.0;
        Vector3::new(force.x, force.y, x * force.y - y * force.x)
    }

    /// The wrench of a friction of 1 N against a twist; zero where the point rests.
    pub(crate) fn unit_wrench(self, twist: &Vector3<T>) -> Vector3<T> {
        let velocity = self.velocity(twist);
        let speed = norm(&velocity);
        if is_zero(speed) { Vector3::zeros() } else { self.wrench(&(velocity / speed)) }
    }

    /// Jᵀ diag(d) J with the velocity J·twist.
    #[inline(always)]
    pub(crate) fn damping(self, damping: &Vector2<T>) -> Matrix3<T> {
        let ([x, y], zero) = (self.0, T::zero());
        let (first, second) = (-damping.x * y, damping.y * x);
        let spin = [first, second, second * x - first * y];
        Matrix3::from([[damping.x, zero, first], [zero, damping.y, second], spin])
    }
}

/// A [`Footprint`] prepared for passive steps inside a mechanism.
///
/// A disc of 2 kg that is pushed off spinning, with steps of 1 ms:
///
/// ```
/// use bristle::companion::VelocityHistory;
/// use bristle::curve::{Coulomb, CoulombParameters};
/// use bristle::nalgebra::{Matrix3, Vector2, Vector3};
/// use bristle_plane::{
///     DiscPressure, Footprint, FootprintPoint, PlaneBristle, PlaneCompanionStep, PlaneFrBd,
/// };
/// use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
///
/// let curve =
///     Coulomb::new(CoulombParameters { dynamic_coefficient: 0.3, viscous_friction: 0.0 })?;
/// let bristle =
///     KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness: 1e4, micro_damping: 50.0 })?;
/// let contact = PlaneFrBd::isotropic(curve, bristle).under_load(2.0 * 9.81)?;
/// let points: Vec<_> = FootprintPoint::disc(0.05, DiscPressure::Uniform, 4).collect();
/// let mut deflections = vec![Vector2::zeros(); points.len()];
/// let mut steps = vec![PlaneCompanionStep::default(); points.len()];
/// let disc = Footprint::new(contact, points)?.companion(5.0)?;
/// let (inertia, h) = (Matrix3::from_diagonal(&Vector3::new(2.0, 2.0, 2.5e-3)), 1e-3);
/// let mut twist = Vector3::new(0.5, 0.2, 30.0);
/// let mut history: [_; 3] = core::array::from_fn(|i| VelocityHistory::new(twist[i]));
/// while twist.norm() > 1e-6 {
///     let predicted = Vector3::from_fn(|i, _| history[i].predict());
///     let step = disc.step(&predicted, &deflections, h, &mut steps)?;
///     // (2/h) inertia (v̄ − v₀) = −bias − damping v̄
///     let matrix = inertia * (2.0 / h) + step.damping;
///     let right = inertia * (2.0 / h) * twist - step.bias;
///     let Some(mean) = matrix.lu().solve(&right) else { break };
///     let done = disc.commit(&steps, &mean, &mut deflections)?;
///     assert!(done.dissipated >= 0.0);
///     twist = 2.0 * mean - twist;
///     // The axes turn with the disc, and its velocity does not.
///     let (sin, cos) = f64::sin_cos(h * mean.z);
///     let (x, y) = (twist.x, twist.y);
///     (twist.x, twist.y) = (cos * x + sin * y, cos * y - sin * x);
///     (0..3).for_each(|i| history[i].push(twist[i]));
/// }
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FootprintCompanion<T: Scalar, M, P> {
    footprint: Footprint<T, M, P>,
    companion: PlaneCompanion<T, M, 2>,
}

/// Friction of a footprint over one step: mean wrench = bias + damping·mean twist.
#[must_use]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FootprintStep<T: Scalar> {
    /// Mean wrench \[N, N m\] if the mean twist is zero.
    pub bias: Vector3<T>,
    /// The damping [N s/m, N s, N m s]: symmetric, positive semidefinite.
    pub damping: Matrix3<T>,
}

impl<T: Scalar, M: PlaneBristle<T, 2>, P: AsRef<[FootprintPoint<T>]>> FootprintCompanion<T, M, P> {
    /// The footprint.
    pub fn footprint(&self) -> &Footprint<T, M, P> {
        &self.footprint
    }

    /// Changes the normal force before a step: take the load at the middle of the step, and the
    /// twist predicted for it. See [`Footprint::reload`].
    ///
    /// # Errors
    ///
    /// Refuses what [`Footprint::reload`] refuses; the companion is as it was.
    pub fn reload(
        &mut self,
        normal_force: T,
        predicted_twist: &Vector3<T>,
        deflections: &mut [Vector2<T>],
    ) -> Checked<Reloaded<T, ()>> {
        let reloaded = self.footprint.reload(normal_force, predicted_twist, deflections)?;
        let _ = self.companion.contact.change_load(normal_force)?;
        Ok(reloaded)
    }

    /// The source and the damper that stand for the friction over a step of length h ≥ 0 \[s\],
    /// from the deflections \[m\] of all points and a twist predicted for the middle of the step.
    /// The step of each point is kept in `steps` for [`FootprintCompanion::commit`].
    ///
    /// # Errors
    ///
    /// Refuses another number of deflections or steps than points.
    pub fn step(
        &self,
        predicted_twist: &Vector3<T>,
        deflections: &[Vector2<T>],
        duration: T,
        steps: &mut [PlaneCompanionStep<T, 2>],
    ) -> Checked<FootprintStep<T>> {
        self.footprint.as_many("deflections", deflections.len())?;
        self.footprint.as_many("steps", steps.len())?;
        let (mut bias, mut damping) = (Vector3::zeros(), Matrix3::zeros());
        let points = self.footprint.shares().zip(deflections).zip(steps);
        for (((share, lever), z), step) in points {
            *step = self.companion.step(&lever.velocity(predicted_twist), z, duration);
            bias += lever.wrench(&step.bias()) * share;
            damping += lever.damping(&step.damping()) * share;
        }
        Ok(FootprintStep { bias, damping })
    }

    /// Ends the steps of all points with the mean twist that the mechanism has found, and moves
    /// their deflections. The force of the result is the mean wrench (F_x, F_y, M) [N, N m].
    ///
    /// # Errors
    ///
    /// Refuses another number of deflections or steps than points.
    pub fn commit(
        &self,
        steps: &[PlaneCompanionStep<T, 2>],
        mean_twist: &Vector3<T>,
        deflections: &mut [Vector2<T>],
    ) -> Checked<CompletedStep<T, (), Vector3<T>>> {
        self.footprint.as_many("deflections", deflections.len())?;
        self.footprint.as_many("steps", steps.len())?;
        let ([work, stored, dissipated], force) = ([T::zero(); 3], Vector3::zeros());
        let mut sum = CompletedStep { deflection: (), force, work, stored, dissipated };
        let points = self.footprint.shares().zip(deflections).zip(steps);
        for (((share, lever), z), step) in points {
            let done = step.commit(&lever.velocity(mean_twist));
            *z = done.deflection;
            sum.force += lever.wrench(&done.force) * share;
            sum.work += share * done.work;
            sum.stored += share * done.stored;
            sum.dissipated += share * done.dissipated;
        }
        Ok(sum)
    }
}
