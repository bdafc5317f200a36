//! The way of one bristle over a step: where it came from and what happened to it since.
//!
//! Ẋ = V(X, t) is followed back from a node by the classical Runge–Kutta method, in panels that
//! cross a cell at most. A bristle that crosses an end of the patch on the way entered there,
//! undeflected. Along a panel ż = −λz + u with u = r v is linear, and with three Radau nodes c_k
//! and their weights b_k
//!
//! z ← e^−Λ z + (1 − e^−Λ) Σ w_k u_k / Σ w_k λ_k,  w_k = b_k e^−(Λ − Λ_k),  Λ_k = Σ A_kj λ_j δ,
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | δ | duration of the panel | s |
//! | Λ, Λ_k | relaxation over the panel, and up to a node | – |
//!
//! a mean with positive weights of z and of the stationary deflections u_k/λ_k met: no deflection
//! beyond them. Exact where λ and u are constant, of fourth order where they vary. Where v
//! reverses on the way the panel is split, since λ has a kink there.
//!
//! Source: nodes, weights and A are those of Radau IIA of order 5 (E. Hairer, G. Wanner, "Solving
//! Ordinary Differential Equations II", table IV.5.6).

use super::Bristles;
use super::interpolation::{Interpolation, cut};
use crate::bounds::{larger, smaller};
use crate::parameter::{self, ParameterError};
use crate::rheology::{Deflection as _, HeldWeights as _};
use crate::root::enclose;
use crate::scalar::{lit, to_f64};
use crate::{Bristle, Scalar, Sliding};

/// √6
const ROOT: f64 = 2.449_489_742_783_178;
const PLACES: [f64; 3] = [0.4 - 0.1 * ROOT, 0.4 + 0.1 * ROOT, 1.0];
const WEIGHTS: [f64; 3] = [(16.0 - ROOT) / 36.0, (16.0 + ROOT) / 36.0, 1.0 / 9.0];
/// A for the first two nodes; for the third it is b.
const INTEGRALS: [[f64; 3]; 2] = [
    [(88.0 - 7.0 * ROOT) / 360.0, (296.0 - 169.0 * ROOT) / 1800.0, (3.0 * ROOT - 2.0) / 225.0],
    [(296.0 + 169.0 * ROOT) / 1800.0, (88.0 + 7.0 * ROOT) / 360.0, (-3.0 * ROOT - 2.0) / 225.0],
];

/// A panel crosses about a cell; a little more than one rather than one and a sliver …
const WHOLE: f64 = 1.1;
/// … and no more than this, where V changes on the way.
const FARTHEST: f64 = 1.6;
/// Panels of a path, for each cell of the grid and besides. A path that never turns needs one for
/// each cell, and a few where V changes fast.
const PANELS_A_CELL: usize = 20;
const MORE_PANELS: usize = 1000;

/// What a step makes of the bristle that arrives at a node: z ← decay · z(origin) + gained.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arrival<T> {
    pub(super) decay: T,
    pub(super) gained: T,
    /// Where it was at the start of the step; `None` if it was not yet in the patch.
    pub(super) origin: Option<T>,
}

/// Range of what drove the bristles over a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach<T> {
    /// The stationary deflections.
    pub(super) stationary: (T, T),
    /// The drives u = r v.
    pub(super) drive: (T, T),
}

impl<T: Scalar> Reach<T> {
    pub(super) fn none() -> Self {
        let none = (T::zero(), T::zero());
        Self { stationary: none, drive: none }
    }

    #[inline]
    pub(super) fn include(&mut self, relaxation: T, drive: T) {
        self.drive = widened(self.drive, drive);
        // Infinite for a bristle that does not relax: then the drive is the limit.
        if relaxation > T::zero() || drive < T::zero() || drive > T::zero() {
            self.stationary = widened(self.stationary, drive / relaxation);
        }
    }

    /// What deflections in a range can have become after a duration.
    #[inline]
    pub(super) fn widened(&self, (low, high): (T, T), duration: T) -> (T, T) {
        let least = larger(low + duration * self.drive.0, self.stationary.0);
        let most = smaller(high + duration * self.drive.1, self.stationary.1);
        (smaller(low, least), larger(high, most))
    }
}

/// A range and a value in one range; NaN does not widen it.
#[inline]
pub(super) fn widened<T: Scalar>((low, high): (T, T), value: T) -> (T, T) {
    (smaller(low, value), larger(high, value))
}

/// Where a function passes zero between two places at which its signs differ.
fn crossing<T: Scalar>(
    function: impl Fn(T) -> Result<T, ParameterError>,
    (a, b): ((T, T), (T, T)),
    tolerance: T,
) -> Result<T, ParameterError> {
    let mut refused = None;
    let look = |at: T| {
        function(at).unwrap_or_else(|error| {
            refused = Some(error);
            T::zero()
        })
    };
    let (from, to) = enclose(look, a, b, tolerance);
    refused.map_or(Ok((from + to) * lit(0.5)), Err)
}

/// Everything the paths of a step share.
#[derive(Debug)]
pub(super) struct Paths<'a, T, M, F, G> {
    pub(super) bristles: &'a Bristles<M>,
    /// At the start of the step.
    pub(super) deflections: &'a [T],
    /// v(ξ, t) and U(ξ, t) = L V.
    pub(super) slip_velocity: &'a F,
    pub(super) rolling_speed: &'a G,
    /// L [m]
    pub(super) length: T,
    pub(super) duration: T,
}

/// One panel, from its end back to its start.
struct Panel<T> {
    /// Time, place, V.
    start: (T, T, T),
    end: (T, T, T),
}

impl<T: Scalar> Panel<T> {
    /// The place at a part of the panel: the cubic with the right places and velocities at both
    /// ends.
    #[inline]
    fn place(&self, part: T) -> T {
        let ((from, x0, v0), (to, x1, v1)) = (self.start, self.end);
        let (rest, duration) = (T::one() - part, to - from);
        let two = lit::<T>(2.0);
        let place = x0 * rest * rest * (T::one() + two * part)
            + x1 * part * part * (T::one() + two * rest)
            + duration * part * rest * (v0 * rest - v1 * part);
        inside(place)
    }

    fn time(&self, part: T) -> T {
        self.start.0 + (self.end.0 - self.start.0) * part
    }
}

/// A place cut to the patch.
#[inline]
fn inside<T: Scalar>(place: T) -> T {
    cut(place, T::zero(), T::one())
}

impl<T, M, F, G> Paths<'_, T, M, F, G>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    F: Fn(T, T) -> T,
    G: Fn(T, T) -> T,
{
    fn cells(&self) -> usize {
        self.deflections.len().saturating_sub(1)
    }

    fn transport(&self, place: T, time: T) -> Result<T, ParameterError> {
        let speed = (self.rolling_speed)(inside(place), time);
        parameter::finite("rolling_speed", speed / self.length)
    }

    fn slip(&self, place: T, time: T) -> Result<T, ParameterError> {
        parameter::finite("slip_velocity", (self.slip_velocity)(inside(place), time))
    }

    /// Follows the bristle that is at a place at the end of the step.
    pub(super) fn arrival(
        &self,
        node: T,
        reach: &mut Reach<T>,
    ) -> Result<Arrival<T>, ParameterError> {
        let (zero, one) = (T::zero(), T::one());
        let width = one / lit(self.cells() as f64);
        let mut arrival = Arrival { decay: one, gained: zero, origin: None };
        let mut here = (self.duration, node, self.transport(node, self.duration)?);
        let mut slip = self.slip(node, self.duration)?;
        if node <= zero && here.2 > zero || node >= one && here.2 < zero {
            return Ok(arrival);
        }
        let most = (PANELS_A_CELL * self.cells() + MORE_PANELS) as f64;
        let mut panels = 0.0;
        while here.0 > zero {
            let (time, place, velocity) = here;
            let speed = velocity.abs();
            let mut step = if speed * time <= width * lit(WHOLE) { time } else { width / speed };
            let mut origin = self.back(here, step)?;
            while (origin - place).abs() > width * lit(FARTHEST) {
                step *= lit(0.5);
                origin = self.back(here, step)?;
                panels += 1.0;
                parameter::at_most("panels of a path", panels, "limit", most)?;
            }
            let from = if step < time { time - step } else { zero };
            let mut start = (from, origin, self.transport(origin, from)?);
            let entered = origin <= zero && start.2 > zero
                || origin >= one && start.2 < zero
                || origin < zero
                || origin > one;
            if entered {
                start = self.entry(here, start)?;
            }
            let panel = Panel { start, end: here };
            let before = self.slip(start.1, start.0)?;
            self.pass(&panel, (before, slip), &mut arrival, reach)?;
            if entered {
                return Ok(arrival);
            }
            (here, slip) = (start, before);
            panels += 1.0;
            parameter::at_most("panels of a path", panels, "limit", most)?;
        }
        arrival.origin = Some(inside(here.1));
        Ok(arrival)
    }

    /// The place a while before, by the classical Runge–Kutta method.
    fn back(&self, (time, place, velocity): (T, T, T), step: T) -> Result<T, ParameterError> {
        let half = step * lit(0.5);
        let second = self.transport(place - half * velocity, time - half)?;
        let third = self.transport(place - half * second, time - half)?;
        let fourth = self.transport(place - step * third, time - step)?;
        let two = lit::<T>(2.0);
        Ok(place - step * lit(1.0 / 6.0) * (velocity + two * (second + third) + fourth))
    }

    /// Time, end of the patch and V at which a path entered that is outside at `outside`.
    fn entry(&self, here: (T, T, T), outside: (T, T, T)) -> Result<(T, T, T), ParameterError> {
        let gate = if outside.1 < lit(0.5) { T::zero() } else { T::one() };
        let beyond = |step: T| Ok(self.back(here, step)? - gate);
        let ends = ((T::zero(), here.1 - gate), (here.0 - outside.0, outside.1 - gate));
        let time = here.0 - crossing(beyond, ends, T::default_epsilon() * here.0)?;
        Ok((time, gate, self.transport(gate, time)?))
    }

    /// Adds what happens along a panel, with v at its start and end.
    fn pass(
        &self,
        panel: &Panel<T>,
        (before, after): (T, T),
        arrival: &mut Arrival<T>,
        reach: &mut Reach<T>,
    ) -> Result<(), ParameterError> {
        let (zero, one) = (T::zero(), T::one());
        if before < zero && after > zero || before > zero && after < zero {
            // To a millionth of the panel: what λ's kink costs there is beyond notice.
            let slip = |part: T| self.slip(panel.place(part), panel.time(part));
            let turn = crossing(slip, ((zero, before), (one, after)), lit(1e-6))?;
            self.collect(panel, (turn, one), arrival, reach)?;
            self.collect(panel, (zero, turn), arrival, reach)
        } else {
            self.collect(panel, (zero, one), arrival, reach)
        }
    }

    /// Adds what happens along a part of a panel.
    fn collect(
        &self,
        panel: &Panel<T>,
        (from, to): (T, T),
        arrival: &mut Arrival<T>,
        reach: &mut Reach<T>,
    ) -> Result<(), ParameterError> {
        let duration = (panel.end.0 - panel.start.0) * (to - from);
        let (mut relaxations, mut drives) = ([T::zero(); 3], [T::zero(); 3]);
        for (k, place) in PLACES.iter().enumerate() {
            let part = if *place < 1.0 { from + (to - from) * lit(*place) } else { to };
            let (place, time) = (panel.place(part), panel.time(part));
            let slip = self.slip(place, time)?;
            let (relaxation, drive) = self.bristles.driven(place, slip, self.deflections);
            reach.include(relaxation, drive);
            (relaxations[k], drives[k]) = (relaxation, drive);
        }
        let sum = |row: &[f64; 3]| {
            let terms = row.iter().zip(relaxations);
            terms.fold(T::zero(), |sum, (&a, relaxation)| sum + lit::<T>(a) * relaxation) * duration
        };
        let whole = sum(&WEIGHTS);
        let [first, second] = INTEGRALS.map(|row| (sum(&row) - whole).exp());
        let weights = [first * lit(WEIGHTS[0]), second * lit(WEIGHTS[1]), lit(WEIGHTS[2])];
        let mean = |values: [T; 3]| {
            weights.iter().zip(values).fold(T::zero(), |sum, (&w, value)| sum + w * value)
        };
        // A hold at the mean relaxation knows e^−Λ and (1 − e^−Λ)/Λ to the last digits.
        let (decay, gained) = if duration > T::zero() {
            let held = whole / duration;
            let hold = T::weights(held, duration);
            let (relaxed, met) = (hold.end(T::zero(), held), mean(relaxations) * duration);
            // The quotient is 1 up to the fourth order; nodes too few for λ may not make more of
            // it.
            let quotient = if met > T::zero() { relaxed / met } else { T::one() };
            let quotient = if quotient < lit(2.0) { quotient } else { lit(2.0) };
            (hold.end(T::one(), T::zero()), quotient * duration * mean(drives))
        } else {
            (T::one(), T::zero())
        };
        arrival.gained += arrival.decay * gained;
        arrival.decay *= decay;
        Ok(())
    }
}

impl<M> Bristles<M> {
    /// λ and u = r v at a place: that of the node there, or interpolated between nodes.
    #[inline]
    fn driven<T: Scalar>(&self, place: T, slip: T, deflections: &[T]) -> (T, T)
    where
        M: Bristle<T, Deflection = T>,
    {
        let of = |model: &M, deflection: T| {
            let affine = model.affine(Sliding::from(slip), deflection);
            (affine.relaxation, affine.drive * slip)
        };
        let models = match self {
            Bristles::Uniform(model) => return of(model, T::zero()),
            Bristles::Varying(models) => models,
        };
        let cells = models.len().saturating_sub(1);
        let (cell, part) = located(place, cells);
        let at = |i: usize| match (models.get(i), deflections.get(i)) {
            (Some(model), Some(&deflection)) => of(model, deflection),
            _ => (T::zero(), T::zero()),
        };
        // At a node but for rounding.
        let close = T::default_epsilon() * lit(8.0 * cells as f64);
        if part <= close {
            return at(cell);
        }
        if T::one() - part <= close {
            return at(cell + 1);
        }
        let count = (cells + 1).min(4);
        let first = cell.saturating_sub(1).min(cells + 1 - count);
        let (mut relaxations, mut drives) = ([T::zero(); 4], [T::zero(); 4]);
        let none = T::one() / T::zero();
        let (mut range, mut all_relax) = ((none, -none), true);
        for k in 0..count {
            let (relaxation, drive) = at(first + k);
            (relaxations[k], drives[k]) = (relaxation, drive);
            all_relax &= relaxation > T::zero();
            range = widened(range, drive / relaxation);
        }
        let mut interpolation = Interpolation::new(part);
        let mut between =
            |values: &[T; 4]| interpolation.at(values.get(..count).unwrap_or(values), cell - first);
        let (relaxation, drive) = (between(&relaxations), between(&drives));
        let relaxation = if relaxation < T::zero() { T::zero() } else { relaxation };
        // No stationary deflection beyond those of the nodes around; between two nodes a smooth
        // extremum lies beyond them by an eighth of their range.
        let margin = (range.1 - range.0) * lit(0.25);
        let (low, high) = (range.0 - margin, range.1 + margin);
        let drive = if all_relax { cut(drive, relaxation * low, relaxation * high) } else { drive };
        (relaxation, drive)
    }
}

/// The cell of a place 0 … 1 and the part of it before the place.
#[inline]
pub(super) fn located<T: Scalar>(place: T, cells: usize) -> (usize, T) {
    let count = place * lit(cells as f64);
    let floor = count.floor();
    // `as` saturates; NaN becomes 0 and stays in the part.
    let cell = (to_f64(floor) as usize).min(cells.saturating_sub(1));
    (cell, count - lit(cell as f64))
}
