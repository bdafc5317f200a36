//! The way of one bristle over a step: where it came from and what happened to it since, on every
//! axis.
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
//! reverses on the way the panel is split, since λ has a kink there. On several axes v reverses
//! where the start and the end of a panel are at an obtuse angle; it is split where ‖v‖ is least.
//!
//! Source: nodes, weights and A are those of Radau IIA of order 5 (E. Hairer, G. Wanner, "Solving
//! Ordinary Differential Equations II", table IV.5.6).

use nalgebra::SVector;

use super::interpolation::cut;
use crate::axes::OfAxes as _;
use crate::exact::profile::Map;
use bristle::Scalar;
use bristle::parameter::{Checked, Named};
use bristle::root::enclose;
use bristle::scalar::{lit, to_f64};

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

/// What a time with λ and u at the three nodes makes of a deflection.
#[inline]
fn passed<T: Scalar>(met: [(T, T); 3], duration: T, range: &mut (T, T)) -> Map<T> {
    for (relaxation, drive) in met {
        *range = widened(*range, drive / relaxation);
    }
    let sum = |row: &[f64; 3]| {
        let terms = row.iter().zip(met);
        terms.fold(T::zero(), |sum, (&a, (relaxation, _))| sum + lit::<T>(a) * relaxation)
            * duration
    };
    let whole = sum(&WEIGHTS);
    let [first, second] = INTEGRALS.map(|row| (sum(&row) - whole).exp());
    let weights = [first * lit(WEIGHTS[0]), second * lit(WEIGHTS[1]), lit(WEIGHTS[2])];
    let (mut relaxation, mut gained) = (T::zero(), T::zero());
    for (weight, met) in weights.into_iter().zip(met) {
        relaxation += weight * duration * met.0;
        gained += weight * duration * met.1;
    }
    // 1 − e^−Λ over its mean is 1 up to the fourth order; nodes too few for λ may not make
    // more of it.
    let faded = (-whole).exp_m1();
    let quotient = if relaxation > T::zero() { -faded / relaxation } else { T::one() };
    Map { decay: T::one() + faded, offset: quotient.smaller(lit(2.0)) * gained }
}

/// The bristle that arrives at a node.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arrival<T, const A: usize> {
    /// On each axis.
    pub(super) changes: [Map<T>; A],
    /// Where it was at the start of the step; `None` if it was not yet in the patch.
    pub(super) origin: Option<T>,
}

/// A range and a value in one range; NaN does not widen it.
#[inline]
pub(super) fn widened<T: Scalar>((low, high): (T, T), value: T) -> (T, T) {
    (low.smaller(value), high.larger(value))
}

/// Everything the paths of a step share.
#[derive(Debug)]
pub(super) struct Paths<T, D, F, G, const A: usize> {
    /// λᵢ and uᵢ = rᵢ vᵢ of every axis at a slip velocity.
    pub(super) driven: D,
    /// v(ξ, t)
    pub(super) slip_velocity: F,
    /// U(ξ, t) = L V
    pub(super) rolling_speed: G,
    /// L [m]
    pub(super) length: T,
    pub(super) duration: T,
    pub(super) cells: usize,
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

impl<T, D, F, G, const A: usize> Paths<T, D, F, G, A>
where
    T: Scalar,
    D: Fn(&SVector<T, A>) -> [(T, T); A],
    F: Fn(T, T) -> SVector<T, A>,
    G: Fn(T, T) -> T,
{
    fn transport(&self, place: T, time: T) -> T {
        (self.rolling_speed)(inside(place), time) / self.length
    }

    fn slip(&self, place: T, time: T) -> SVector<T, A> {
        (self.slip_velocity)(inside(place), time)
    }

    /// Follows the bristle that is at a place at the end of the step, and adds the stationary
    /// deflections that it has met to the range of each axis. Velocities that are not
    /// finite on the way make its deflection NaN.
    pub(super) fn arrival(&self, node: T, ranges: &mut [(T, T); A]) -> Checked<Arrival<T, A>> {
        let (zero, one) = (T::zero(), T::one());
        let width = one / lit(self.cells as f64);
        let mut arrival = Arrival { changes: [Map::identity(); A], origin: None };
        let rolling_speed = (self.rolling_speed)(inside(node), self.duration);
        let transport = Named("rolling_speed", rolling_speed).finite()? / self.length;
        // A hundredth of a cell is crossed within the rounding of the time.
        let longest = width / (transport.abs() * T::default_epsilon() * lit(1e2));
        Named("duration", self.duration).at_most("what resolves a cell", longest)?;
        let mut slip = self.slip(node, self.duration);
        slip.finite("slip_velocity")?;
        let mut here = (self.duration, node, transport);
        if node <= zero && here.2 > zero || node >= one && here.2 < zero {
            return Ok(arrival);
        }
        let most = PANELS_A_CELL * self.cells + MORE_PANELS;
        let mut panels = 0;
        while here.0 > zero {
            let (time, place, velocity) = here;
            let speed = velocity.abs();
            let mut step = if speed * time <= width * lit(WHOLE) { time } else { width / speed };
            let mut origin = self.back(here, step);
            while (origin - place).abs() > width * lit(FARTHEST) {
                step *= lit(0.5);
                origin = self.back(here, step);
                panels += 1;
            }
            let from = if step < time { time - step } else { zero };
            let mut start = (from, origin, self.transport(origin, from));
            let entered = origin <= zero && start.2 > zero
                || origin >= one && start.2 < zero
                || origin < zero
                || origin > one;
            if entered {
                start = self.entry(here, start);
            }
            let before = self.slip(start.1, start.0);
            self.pass(&Panel { start, end: here }, (before, slip), &mut arrival, ranges);
            if entered {
                return Ok(arrival);
            }
            (here, slip) = (start, before);
            panels += 1;
            Named("panels of a path", panels as f64).at_most("limit", most as f64)?;
        }
        arrival.origin = Some(inside(here.1));
        Ok(arrival)
    }

    /// The place a while before, by the classical Runge–Kutta method.
    fn back(&self, (time, place, velocity): (T, T, T), step: T) -> T {
        let half = step * lit(0.5);
        let second = self.transport(place - half * velocity, time - half);
        let third = self.transport(place - half * second, time - half);
        let fourth = self.transport(place - step * third, time - step);
        place - step * lit(1.0 / 6.0) * (velocity + lit::<T>(2.0) * (second + third) + fourth)
    }

    /// Time, end of the patch and V at which a path entered that is outside at `outside`.
    fn entry(&self, here: (T, T, T), outside: (T, T, T)) -> (T, T, T) {
        let gate = if outside.1 < lit(0.5) { T::zero() } else { T::one() };
        let ends = ((T::zero(), here.1 - gate), (here.0 - outside.0, outside.1 - gate));
        let beyond = |step: T| self.back(here, step) - gate;
        let (step, _) = enclose(beyond, ends.0, ends.1, T::default_epsilon() * here.0);
        let time = here.0 - step;
        (time, gate, self.transport(gate, time))
    }

    /// Adds what happens along a panel, with v at its start and end.
    fn pass(
        &self,
        panel: &Panel<T>,
        (before, after): (SVector<T, A>, SVector<T, A>),
        arrival: &mut Arrival<T, A>,
        ranges: &mut [(T, T); A],
    ) {
        let (zero, one) = (T::zero(), T::one());
        let mut turn = zero;
        if before.dot(&after) < zero {
            // To a millionth of the panel: what λ's kink costs there is beyond notice.
            let change = after - before;
            let slip = |part: T| change.dot(&self.slip(panel.place(part), panel.time(part)));
            let ends = ((zero, change.dot(&before)), (one, change.dot(&after)));
            (turn, _) = enclose(slip, ends.0, ends.1, lit(1e-6));
        }
        self.collect(panel, (turn, one), arrival, ranges);
        if turn > zero {
            self.collect(panel, (zero, turn), arrival, ranges);
        }
    }

    /// Adds what happens along a part of a panel.
    fn collect(
        &self,
        panel: &Panel<T>,
        (from, to): (T, T),
        arrival: &mut Arrival<T, A>,
        ranges: &mut [(T, T); A],
    ) {
        let duration = (panel.end.0 - panel.start.0) * (to - from);
        let met = PLACES.map(|place| {
            let part = if place < 1.0 { from + (to - from) * lit(place) } else { to };
            let (place, time) = (panel.place(part), panel.time(part));
            (self.driven)(&self.slip(place, time))
        });
        for (axis, (change, range)) in arrival.changes.iter_mut().zip(ranges).enumerate() {
            let met = met.each_ref().map(|met| met[axis]);
            *change = change.after(passed(met, duration, range));
        }
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
