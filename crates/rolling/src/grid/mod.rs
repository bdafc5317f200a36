//! A patch on a grid, for slip velocities or rolling speeds that vary along it.
//!
//! ∂z/∂t + V(ξ, t) ∂z/∂ξ = −λ(v) z + r(v) v,  F = L ∫₀¹ p(ξ) (c₀ z + c₂ v) dξ
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | ξ | place in the patch, from 0 to 1 | – |
//! | z(ξ, t) | deflection | m |
//! | V(ξ, t) | rolling speed over the length of the patch, of any sign | 1/s |
//! | v(ξ, t) | slip velocity | m/s |
//! | N | cells; nodes at ξᵢ = i/N | – |
//! | C | Courant number \|V\| h N: cells crossed in a step | – |
//!
//! Bristles enter undeflected wherever V points into the patch: at ξ = 0 where V(0, t) > 0 and at
//! ξ = 1 where V(1, t) < 0. Where V points away from a place inside, the bristles there spread.
//! Where V points towards one, they crowd and never leave.
//!
//! The scheme is semi-Lagrangian. The bristle that arrives at a node is followed back over the step
//! ([`path`]), its deflection at the start is interpolated ([`interpolation`]), and its own linear
//! equation is solved along the way. Every length of step is stable. With uniform V, λ and r the
//! nodes are exact for a whole Courant number.
//!
//! Source: Romano et al. (arXiv 2602.09429), section IV-A, the equation and its characteristics.
//! The scheme is classical (R. Courant, E. Isaacson, M. Rees, Communications on Pure and Applied
//! Mathematics 5 (1952), 243–255).

mod interpolation;
mod path;
mod weights;

use alloc::vec;
use alloc::vec::Vec;
use core::marker::PhantomData;

use nalgebra::SVector;

use super::{Motion, Patch, Pressure};
use crate::axes::{OfAxes, PatchModel};
use crate::exact::slipped;
use crate::patch::of_velocity;
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::rheology::HeldWeights as _;
use bristle::scalar::{is_zero, lit, to_f64};
use bristle::{Affine, Bristle, Contact, Reloaded, Scalar};
use interpolation::{Interpolation, cut};
use path::{Paths, located, widened};

/// Most cells of a grid.
const MOST_CELLS: usize = 10_000_000;
/// Samples of a given profile in each cell, for its range.
const SAMPLES: usize = 8;

/// The deflections of a patch at equidistant nodes.
///
/// * No deflection leaves the range of the initial ones and the stationary ones at the velocities
///   met: |z| ≤ max μ/σ0 holds for every length of step.
/// * The force is a quadrature of fifth order with positive weights that integrate the pressure
///   exactly. A kink or a jump of the profile (after a sudden change of v or a standstill) leaves
///   an error of second or first order in its cell.
/// * A step allocates nothing, and one that is refused changes nothing.
///
/// ```
/// use bristle_rolling::{Grid, Motion, Patch, PatchParameters, PolynomialExponential};
/// use bristle::{FrBd, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
///
/// let curve = Stribeck::new(paper::TYRE_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE)?;
/// let patch = Patch::new(PatchParameters {
///     model: FrBd::new(curve, bristle),
///     length: 0.1, // m
///     pressure: PolynomialExponential::constant(),
/// })?
/// .under_load(1.0)?; // N
/// let mut grid = Grid::new(&patch, 100)?;
///
/// // A slip ratio of 0.05 at 16 m/s, one cell a step, for one crossing of the patch.
/// let motion = Motion { slip_velocity: 0.8, rolling_speed: 16.0 };
/// let mut force = 0.0;
/// for _ in 0..100 {
///     force = grid.step(motion, 0.01 * 0.1 / 16.0)?;
/// }
/// assert!((force - 0.348954).abs() < 1e-6);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Grid<T, M, V = T, const A: usize = 1> {
    contact: Contact<T, M>,
    length: T,
    /// Places of the nodes.
    places: Vec<T>,
    /// Weights of the nodes in the force over the normal force.
    weights: Vec<T>,
    lines: [Line<T>; A],
    of: PhantomData<V>,
}

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
pub type CombinedGrid<T, M, const A: usize> = Grid<T, M, SVector<T, A>, A>;

/// The bristles of one axis.
#[derive(Debug, Clone, PartialEq)]
struct Line<T> {
    deflections: Vec<T>,
    /// The deflections after the step, while it is taken.
    next: Vec<T>,
    /// No deflection, at a node or between, is outside.
    range: (T, T),
}

impl<T: Scalar, M: PatchModel<T, V, A>, V: OfAxes<T, A>, const A: usize> Grid<T, M, V, A> {
    /// A patch on N cells, undeflected.
    ///
    /// # Errors
    ///
    /// Refuses a model whose coefficients depend on its deflection, zero cells or more than ten
    /// million, and a pressure that is negative or not finite somewhere.
    pub fn new<P: Pressure<T>>(patch: &Patch<T, M, P>, cells: usize) -> Checked<Self> {
        let (contact, rest) = (patch.contact().clone(), V::of_axes([T::zero(); A]));
        for checked in M::each(&contact, rest, |_, axis, _| of_velocity(axis.model())) {
            checked?;
        }
        Named("cells", cells).count_between(1, MOST_CELLS)?;
        let width = T::one() / lit(cells as f64);
        let mut places: Vec<T> = (0..cells).map(|i| lit::<T>(i as f64) * width).collect();
        places.push(T::one());
        let mut weights = weights::weights(patch.pressure(), cells)?;
        // A pressure that carries nothing has no weights.
        let total = weights.iter().fold(T::zero(), |sum, &weight| sum + weight);
        let share = if total > T::zero() { T::one() / total } else { T::zero() };
        weights.iter_mut().for_each(|weight| *weight *= share);
        let none = vec![T::zero(); cells + 1];
        let range = (T::zero(), T::zero());
        let lines = [(); A].map(|()| Line { deflections: none.clone(), next: none.clone(), range });
        Ok(Self { contact, length: patch.length(), places, weights, lines, of: PhantomData })
    }

    /// Number of cells N.
    pub fn cells(&self) -> usize {
        self.places.len() - 1
    }

    /// Places of the nodes, ξᵢ = i/N.
    pub fn places(&self) -> &[T] {
        &self.places
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
        slip_velocity: impl Fn(T) -> V,
    ) -> Checked<Reloaded<T, ()>> {
        let change = self.contact.change_load(normal_force)?;
        let mut kept = T::one();
        if change.after < change.before {
            for (node, &place) in self.places.iter().enumerate() {
                let at_node = |line: &Line<T>| line.deflections.get(node).copied();
                let here = self.lines.each_ref().map(|line| at_node(line).unwrap_or_else(T::zero));
                let ranges = here.map(|deflection| (deflection, deflection));
                kept = kept.smaller(M::kept(&self.contact, change, slip_velocity(place), ranges));
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
    pub fn renew(&mut self, normal_force: T) -> Checked<Reloaded<T, ()>> {
        let stored = self.stored_energy();
        let (kept, lost) = self.contact.renew_load(normal_force)?.renewed();
        self.lines.iter_mut().for_each(|line| line.scale(kept));
        Ok(Reloaded { deflection: (), dissipated: lost * stored })
    }

    /// Weights of the nodes in the force \[–\], F = P Σ wᵢ (c₀ z + c₂ v)ᵢ. None is negative, and
    /// their sum is 1 (0 for a pressure that carries nothing).
    pub fn weights(&self) -> &[T] {
        &self.weights
    }

    /// The energy stored in the bristles, W = (L/2) ∫ σ0 p z² dξ \[J\].
    pub fn stored_energy(&self) -> T {
        let half = lit::<T>(0.5) * self.contact.reference_load();
        let axes = self.lines.iter().zip(self.contact.model().stiffness_of_axes());
        axes.fold(T::zero(), |sum, (line, k)| {
            let nodes = self.weights.iter().zip(&line.deflections);
            sum + half * k * nodes.fold(T::zero(), |sum, (&weight, &z)| sum + weight * z * z)
        })
    }

    /// The force F \[N\] of the deflections as they are, at slip velocities v(ξ) [m/s].
    pub fn force(&self, slip_velocity: impl Fn(T) -> V) -> V {
        self.weigh(|line| &line.deflections, slip_velocity, |_| T::one())
    }

    /// The moment of each axis's force about the middle of the patch \[N m\], with the deflections
    /// as they are, at slip velocities v(ξ) [m/s]: that of the lateral axis is the self-aligning
    /// moment M_z.
    pub fn moment(&self, slip_velocity: impl Fn(T) -> V) -> V {
        let half: T = lit(0.5);
        self.weigh(|line| &line.deflections, slip_velocity, |place| (place - half) * self.length)
    }

    /// A step of length h ≥ 0 \[s\] with the motion held. The patch may also roll backwards (U <
    /// 0). Returns the force F \[N\] at the end.
    ///
    /// For a motion that varies in time take the one at the middle of the step (second order), or
    /// [`Grid::step_field`]. It costs one evaluation of the model.
    ///
    /// # Errors
    ///
    /// Refuses velocities that are not finite, a duration that is negative or not finite, and a
    /// force that is not finite.
    pub fn step(&mut self, motion: Motion<V, T>, duration: T) -> Checked<V> {
        let slip = motion.slip_velocity.finite("slip_velocity")?;
        let speed = Named("rolling_speed", motion.rolling_speed).finite()?;
        let duration = Named("duration", duration).non_negative()?;
        let courant = speed / self.length * duration * lit(self.cells() as f64);
        let Self { contact, weights, lines, .. } = self;
        let mut ranges = [(T::zero(), T::zero()); A];
        let force = M::each(contact, slip, |axis, contact, slip| {
            let (affine, line) = (contact.affine(slip, T::zero()), &mut lines[axis]);
            let drive = affine.drive * slip;
            line.shift(&affine, drive, courant, duration);
            ranges[axis] = widened(line.range, drive / affine.relaxation);
            let sums = (weights.iter().zip(&line.next))
                .fold((T::zero(), T::zero()), |sums, (&w, &z)| (sums.0 + w * z, sums.1 + w));
            let coefficient = affine.stiffness * sums.0 + affine.damping * slip * sums.1;
            contact.reference_load() * coefficient
        });
        let force = V::of_axes(force).finite("force")?;
        self.commit(ranges);
        Ok(force)
    }

    /// A step of length h ≥ 0 \[s\] with a motion that varies in place and time, for spin, camber
    /// and curved paths: functions of the place ξ \[–\] and of the time since the step's start
    /// \[s\], of which the rolling speed must be smooth. Returns the force F \[N\] at the end.
    ///
    /// In smooth motion the error is of fourth order in the width of a cell, and in the length of
    /// a step that crosses less than one. In a longer step each bristle is followed from cell to
    /// cell. Whole cells a step are best: nothing is interpolated, and the error is tens to
    /// thousands of times below that of a third of a cell a step.
    ///
    /// # Errors
    ///
    /// Refuses what [`Grid::step`] refuses, and a U(ξ, t) that turns so often within a step that a
    /// bristle crosses more than twenty times the cells of the grid (`panels of a path`).
    pub fn step_field<F, G>(&mut self, field: &Motion<F, G>, duration: T) -> Checked<V>
    where
        F: Fn(T, T) -> V,
        G: Fn(T, T) -> T,
    {
        let duration = Named("duration", duration).non_negative()?;
        let Motion { slip_velocity, rolling_speed } = field;
        let driven = |slip: &SVector<T, A>| {
            M::each(&self.contact, V::of_axes((*slip).into()), |_, contact, slip| {
                let affine = contact.affine(slip, T::zero());
                (affine.relaxation, affine.drive * slip)
            })
        };
        let slip = |place, time| SVector::from(slip_velocity(place, time).axes());
        let (length, cells) = (self.length, self.cells());
        let paths = Paths { driven, slip_velocity: slip, rolling_speed, length, duration, cells };
        let mut ranges = self.lines.each_ref().map(|line| line.range);
        for (node, &place) in self.places.iter().enumerate() {
            let arrival = paths.arrival(place, &mut ranges)?;
            for (line, change) in self.lines.iter_mut().zip(arrival.changes) {
                let before = arrival.origin.map_or_else(T::zero, |at| line.at(at));
                if let Some(next) = line.next.get_mut(node) {
                    *next = change.of(before);
                }
            }
        }
        let end = |place| slip_velocity(place, duration);
        let force = self.weigh(|line| &line.next, end, |_| T::one()).finite("force")?;
        self.commit(ranges);
        Ok(force)
    }

    fn commit(&mut self, ranges: [(T, T); A]) {
        for (line, range) in self.lines.iter_mut().zip(ranges) {
            line.range = range;
            core::mem::swap(&mut line.deflections, &mut line.next);
        }
    }

    /// Each axis's force \[N\], times a weight of the place.
    fn weigh(
        &self,
        deflections: impl Fn(&Line<T>) -> &Vec<T>,
        slip_velocity: impl Fn(T) -> V,
        weight: impl Fn(T) -> T,
    ) -> V {
        let mut sums = [T::zero(); A];
        for (node, (&place, &share)) in self.places.iter().zip(&self.weights).enumerate() {
            let weight = weight(place) * share;
            M::each(&self.contact, slip_velocity(place), |axis, contact, slip| {
                if let Some(&z) = deflections(&self.lines[axis]).get(node) {
                    sums[axis] += weight * contact.affine(slip, z).coefficient(slip, z);
                }
            });
        }
        V::of_axes(sums.map(|sum| self.contact.reference_load() * sum))
    }
}

impl<T: Scalar, M: Bristle<T, Deflection = T>> Grid<T, M> {
    /// This grid with the deflections z(ξ) \[m\].
    ///
    /// # Errors
    ///
    /// Refuses a deflection that is not finite, and names the node at or before it.
    pub fn with_profile(mut self, profile: impl Fn(T) -> T) -> Checked<Self> {
        let mut range = (T::zero(), T::zero());
        let cells = self.cells();
        let nodes = self.lines[0].deflections.iter_mut().zip(&self.places);
        for (node, (deflection, &place)) in nodes.enumerate() {
            let at = |place| {
                ParameterError::of_component(node, Named("profile", profile(place)).finite())
            };
            *deflection = at(place)?;
            // The extrema may lie between the nodes.
            for sample in 0..if node < cells { SAMPLES } else { 1 } {
                let value = at(place + lit::<T>(sample as f64 / (SAMPLES * cells) as f64))?;
                range = widened(range, value);
            }
        }
        self.lines[0].range = range;
        Ok(self)
    }

    /// The deflection \[m\] at a place ξ between 0 and 1, interpolated between the nodes; NaN
    /// elsewhere.
    pub fn deflection(&self, place: T) -> T {
        let inside = place >= T::zero() && place <= T::one();
        if inside { self.lines[0].at(place) } else { T::nan() }
    }
}

impl<T: Scalar> Line<T> {
    /// Multiplies every deflection.
    fn scale(&mut self, kept: T) {
        self.deflections.iter_mut().for_each(|deflection| *deflection *= kept);
        self.range = (kept * self.range.0, kept * self.range.1);
    }

    /// The deflection at a place, within the range.
    fn at(&self, place: T) -> T {
        let (low, high) = self.range;
        let (cell, part) = located(place, self.deflections.len().saturating_sub(1));
        cut(Interpolation::new(part).at(&self.deflections, cell), low, high)
    }

    /// The semi-Lagrangian step of equal bristles in a uniform motion.
    fn shift(&mut self, affine: &Affine<T>, drive: T, courant: T, duration: T) {
        let (zero, one) = (T::zero(), T::one());
        let cells = self.next.len() - 1;
        let most = lit::<T>(cells as f64 + 1.0);
        let forward = courant > zero;
        let shift = cut(courant, -most, most);
        // A whole number of cells but for rounding is one.
        let whole = shift.round();
        let exact = (shift - whole).abs() <= T::default_epsilon() * lit::<T>(8.0) * shift.abs();
        let shift = if exact { whole } else { shift };
        let floor = (-shift).floor();
        let part = -shift - floor;
        let offset = to_f64(floor) as isize;
        let weights = affine.weights(duration);
        let mut interpolation = Interpolation::new(part);
        let last = cells as isize;
        for (node, next) in self.next.iter_mut().enumerate() {
            let cell = node as isize + offset;
            let origin = lit::<T>(node as f64) - shift;
            if forward && origin <= zero || courant < zero && origin >= lit(cells as f64) {
                continue;
            }
            let before = if is_zero(part) {
                self.deflections.get(cell.clamp(0, last) as usize).copied().unwrap_or(zero)
            } else {
                let value =
                    interpolation.at(&self.deflections, cell.clamp(0, (last - 1).max(0)) as usize);
                cut(value, self.range.0, self.range.1)
            };
            *next = weights.end(before, drive);
        }
        // A bristle that entered during the step is the one behind it, a cell's passage older.
        let entered = if is_zero(courant) { 0 } else { to_f64(shift.abs().floor()) as usize + 1 };
        let passage = affine.weights(duration / if is_zero(courant) { one } else { courant.abs() });
        let mut deflection = zero;
        for i in 0..entered.min(cells + 1) {
            if let Some(next) = self.next.get_mut(if forward { i } else { cells - i }) {
                *next = deflection;
            }
            deflection = passage.end(deflection, drive);
        }
    }
}
