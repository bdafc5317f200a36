//! What the integrator tests share: the methods, small systems with closed forms, the paper's rig.
//!
//! A new method is added by one line in [`every_method`]; a new way to choose steps by one line in
//! [`every_solver`]. Every law in `tests/ode` then runs over it.

use std::cell::Cell;
use std::ops::{Deref, Range};

use bristle::curve::Stribeck;
use bristle::ode::{
    Event, Failure, Linearisation, Method, Observer, Output, Solver, Statistics, Summary, System,
    Tolerances, Trajectory,
};
use bristle::rheology::KelvinVoigt;
use bristle::scene::{MassSpringDamper, MassSpringDamperParameters};
use bristle::signal::Signal;
use bristle::{
    Branch, Bristle, Contact, Dahl, DahlParameters, FrBd, Mechanism, ParameterError, Scalar,
};
use nalgebra::{Matrix1, SVector, Vector1, Vector2};

pub use super::lit;
pub use super::specimens::{table_2, table_2_frbd, table_2_lugre};
pub use crate::{every_method, every_solver};

/// No run here needs as many steps: with this limit a test ends even if its run does not.
pub const MOST_STEPS: u64 = 100_000;

/// Runs a block with every method: its name, its value, the order of its steps and the order of
/// its dense output (of the error of the interpolant: a cubic is 4, a quartic 5).
#[macro_export]
macro_rules! every_method {
    (|$name:ident, $method:ident, $order:ident, $dense:ident| $body:block) => {
        $crate::every_method!(@one |$name, $method, $order, $dense| $body, RungeKutta4, 4.0, 4.0);
        $crate::every_method!(@one |$name, $method, $order, $dense| $body, DormandPrince, 5.0, 5.0);
        $crate::every_method!(
            @one |$name, $method, $order, $dense| $body, DormandPrince8, 8.0, 8.0);
        $crate::every_method!(@one |$name, $method, $order, $dense| $body, Rodas4, 4.0, 4.0);
        $crate::every_method!(@one |$name, $method, $order, $dense| $body, Rodas5P, 5.0, 5.0);
    };
    (@one |$name:ident, $method:ident, $order:ident, $dense:ident|
        $body:block, $type:ident, $o:expr, $d:expr) => {
        #[allow(unused_variables, reason = "not every law asks for every fact")]
        {
            let ($name, $method, $order, $dense): (&str, _, f64, f64) =
                (stringify!($type), bristle::ode::$type, $o, $d);
            $body
        }
    };
}

/// Runs a block with every method and every way to choose its steps. `$step` is the length of the
/// fixed steps and `$tolerances` what the adaptive ones use.
#[macro_export]
macro_rules! every_solver {
    ($step:expr, $tolerances:expr, |$name:ident, $solver:ident| $body:block) => {
        $crate::every_solver!(@fixed $step, |$name, $solver| $body, RungeKutta4);
        $crate::every_solver!(@fixed $step, |$name, $solver| $body, DormandPrince);
        $crate::every_solver!(@fixed $step, |$name, $solver| $body, DormandPrince8);
        $crate::every_solver!(@fixed $step, |$name, $solver| $body, Rodas4);
        $crate::every_solver!(@fixed $step, |$name, $solver| $body, Rodas5P);
        $crate::every_solver!(@fixed $step, |$name, $solver| $body, Automatic);
        $crate::every_solver!(@adaptive $tolerances, |$name, $solver| $body, DormandPrince);
        $crate::every_solver!(@adaptive $tolerances, |$name, $solver| $body, DormandPrince8);
        $crate::every_solver!(@adaptive $tolerances, |$name, $solver| $body, Rodas4);
        $crate::every_solver!(@adaptive $tolerances, |$name, $solver| $body, Rodas5P);
        $crate::every_solver!(@adaptive $tolerances, |$name, $solver| $body, Automatic);
    };
    (@fixed $step:expr, |$name:ident, $solver:ident| $body:block, $($method:ident)::+) => {{
        let $name = concat!(stringify!($($method)::+), ", fixed steps");
        let $solver = $crate::ode::OfAny::fixed(bristle::ode::$($method)::+, $step).unwrap();
        let $solver = $solver.with_most_steps($crate::ode::MOST_STEPS);
        $body
    }};
    (@adaptive $tolerances:expr, |$name:ident, $solver:ident|
        $body:block, $($method:ident)::+) => {{
        let $name = concat!(stringify!($($method)::+), ", adaptive steps");
        let $solver = $crate::ode::OfAny::checked(bristle::ode::$($method)::+, $tolerances);
        let $solver = $solver.with_most_steps($crate::ode::MOST_STEPS);
        $body
    }};
}

/// A solver of systems behind `&dyn System`: the driver is compiled once for each method and
/// number of states, not for each test.
#[derive(Debug, Clone, Copy)]
pub struct OfAny<T: Scalar, M, const N: usize>(pub Solver<T, M, N>);

impl<T: Scalar, M, const N: usize> Deref for OfAny<T, M, N> {
    type Target = Solver<T, M, N>;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl<T: Scalar, M: Method<T, N>, const N: usize> OfAny<T, M, N> {
    pub fn checked(method: M, tolerances: Tolerances<T, N>) -> Self {
        Self(Solver::checked(method, tolerances))
    }

    pub fn adaptive(method: M, tolerances: Tolerances<T, N>) -> Self {
        Self(Solver::adaptive(method, tolerances))
    }

    pub fn fixed(method: M, step: T) -> Result<Self, ParameterError> {
        Solver::fixed(method, step).map(Self)
    }

    pub fn plain(self) -> Self {
        Self(self.0.plain())
    }

    pub fn with_largest_step(self, largest: T) -> Result<Self, ParameterError> {
        self.0.with_largest_step(largest).map(Self)
    }

    pub fn with_first_step(self, first: T) -> Result<Self, ParameterError> {
        self.0.with_first_step(first).map(Self)
    }

    pub fn with_most_steps(self, most: u64) -> Self {
        Self(self.0.with_most_steps(most))
    }

    pub fn solve<const K: usize>(
        &self,
        system: &dyn System<T, N, K>,
        span: Range<T>,
        initial_state: SVector<T, N>,
        output: Output<'_, T>,
    ) -> Result<Trajectory<T, N>, Box<Failure<T, N>>> {
        self.0.solve(system, span, initial_state, output)
    }

    pub fn solve_with_events<const K: usize>(
        &self,
        system: &dyn System<T, N, K>,
        span: Range<T>,
        initial_state: SVector<T, N>,
        events: &[Event<'_, T, N>],
        output: Output<'_, T>,
    ) -> Result<Trajectory<T, N>, Box<Failure<T, N>>> {
        self.0.solve_with_events(system, span, initial_state, events, output)
    }

    pub fn stream<O: Observer<T, SVector<T, N>>, const K: usize>(
        &self,
        system: &dyn System<T, N, K>,
        span: Range<T>,
        initial_state: SVector<T, N>,
        events: &[Event<'_, T, N>],
        observer: &mut O,
    ) -> Result<Summary<T, N>, Failure<T, N>> {
        self.0.stream(system, span, initial_state, events, observer)
    }
}

/// The same relative tolerance for every state, and as absolute one: for states of order one.
pub fn tolerance<const N: usize>(relative: f64) -> Tolerances<f64, N> {
    Tolerances::scaled(relative, SVector::repeat(1.0)).unwrap()
}

/// The cost of a run but for its evaluations, of which a dense output may need some more.
pub fn but_evaluations(statistics: Statistics) -> Statistics {
    Statistics { evaluations: 0, ..statistics }
}

/// Slope of ln y over ln x by least squares: the observed order of a method over a range of steps.
pub fn observed_order(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let logs = points.iter().map(|(x, y)| (x.ln(), y.ln()));
    let (mx, my) = logs.clone().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (num, den) = logs.fold((0.0, 0.0), |(num, den), (x, y)| {
        (num + (x - mx) * (y - my), den + (x - mx) * (x - mx))
    });
    num / den
}

// ---------------------------------------------------------------------------------------------
// Friction

/// The stick-slip rig of the paper: p = 1 N, m = 1 kg, k = 2 N/m, pulled at a given velocity.
pub fn rig<T: Scalar, M: Bristle<T, Deflection = T>>(
    friction: M,
    drive_velocity: T,
) -> MassSpringDamper<T, M> {
    MassSpringDamper::new(MassSpringDamperParameters {
        contact: friction.under_load(T::one()).unwrap(),
        mechanism: Mechanism {
            mass: T::one(),
            spring_stiffness: lit(2.0),
            viscous_damping: T::zero(),
        },
        drive_velocity,
        force: T::zero(),
    })
    .unwrap()
}

pub fn stick_slip<T: Scalar>() -> MassSpringDamper<T, FrBd<Stribeck<T>, KelvinVoigt<T>>> {
    rig(table_2_frbd(), lit(0.1))
}

// ---------------------------------------------------------------------------------------------
// Systems with closed forms

/// Friction coefficient and micro-stiffness of [`dahl`]: a breakaway deflection of 0.1 m.
pub const DAHL: (f64, f64) = (0.5, 5.0);

pub fn dahl() -> Contact<f64, Dahl<f64>> {
    let (dynamic_coefficient, micro_stiffness) = DAHL;
    let dahl = Dahl::new(DahlParameters { dynamic_coefficient, micro_stiffness }).unwrap();
    dahl.under_load(1.0).unwrap()
}

/// The deflection of [`dahl`] after a path whose turning points and last point are given, from
/// z = 0 at the first: dz/dx = 1 − sgn(ẋ) z σ0/μ, so that over every stretch
/// z = s μ/σ0 + (z₀ − s μ/σ0) exp(−(σ0/μ)|x − x₀|).
pub fn dahl_deflection(path: &[f64]) -> f64 {
    let limit = DAHL.0 / DAHL.1;
    path.windows(2).fold(0.0, |z, ends| {
        let way = ends[1] - ends[0];
        let steady = limit * way.signum();
        steady + (z - steady) * (-way.abs() / limit).exp()
    })
}

/// The velocity V sin(ωt + φ) and the path along it.
#[derive(Debug, Clone, Copy)]
pub struct Swing {
    pub amplitude: f64,
    pub angular: f64,
    pub phase: f64,
}

impl Swing {
    pub fn position(&self, time: f64) -> f64 {
        -self.amplitude / self.angular * (self.angular * time + self.phase).cos()
    }

    /// The times in (0, end) at which the velocity is zero.
    pub fn reversals(&self, end: f64) -> Vec<f64> {
        let first = (self.phase / std::f64::consts::PI).floor() as i64 + 1;
        (first..)
            .map(|k| (k as f64 * std::f64::consts::PI - self.phase) / self.angular)
            .take_while(|&time| time < end)
            .collect()
    }

    /// The deflection of [`dahl`] along the swing, from z = 0 at t = 0.
    pub fn deflection(&self, time: f64) -> f64 {
        let mut path = vec![self.position(0.0)];
        path.extend(self.reversals(time).into_iter().map(|t| self.position(t)));
        path.push(self.position(time));
        dahl_deflection(&path)
    }
}

impl Signal<f64> for Swing {
    fn value(&self, time: f64) -> f64 {
        self.value_and_rate(time).0
    }

    fn value_and_rate(&self, time: f64) -> (f64, f64) {
        let (sin, cos) = (self.angular * time + self.phase).sin_cos();
        (self.amplitude * sin, self.amplitude * self.angular * cos)
    }
}

/// A mass on a spring without friction, ẍ = −x: position and velocity are cosine and −sine.
#[derive(Debug, Clone, Copy)]
pub struct Oscillator;

impl Oscillator {
    /// From x = 1, v = 0 at t = 0.
    pub fn exact(time: f64) -> Vector2<f64> {
        Vector2::new(time.cos(), -time.sin())
    }
}

impl System<f64, 2, 0> for Oscillator {
    fn rate(&self, _: f64, x: &Vector2<f64>, _: [Branch; 0]) -> Vector2<f64> {
        Vector2::new(x[1], -x[0])
    }

    fn sliding_velocities(&self, _: f64, _: &Vector2<f64>) -> [f64; 0] {
        []
    }
}

/// ẋ = f(t, x), without contacts.
#[derive(Clone, Copy)]
pub struct Field<F>(pub F);

impl<F> std::fmt::Debug for Field<F> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Field")
    }
}

impl<T: Scalar, F, const N: usize> System<T, N, 0> for Field<F>
where
    F: Fn(T, &SVector<T, N>) -> SVector<T, N>,
{
    fn rate(&self, time: T, x: &SVector<T, N>, _: [Branch; 0]) -> SVector<T, N> {
        (self.0)(time, x)
    }

    fn sliding_velocities(&self, _: T, _: &SVector<T, N>) -> [T; 0] {
        []
    }
}

/// ẋ = u(t): the integral of a signal.
#[derive(Debug, Clone)]
pub struct Integral<U>(pub U);

impl<U: Signal<f64>> System<f64, 1, 0> for Integral<U> {
    fn rate(&self, time: f64, _: &Vector1<f64>, _: [Branch; 0]) -> Vector1<f64> {
        Vector1::new(self.0.value(time))
    }

    fn linearised(
        &self,
        time: f64,
        _: &Vector1<f64>,
        _: [Branch; 0],
    ) -> Option<Linearisation<f64, 1>> {
        let (value, rate) = self.0.value_and_rate(time);
        let by_state = Matrix1::zeros();
        Some(Linearisation { rate: Vector1::new(value), by_state, by_time: Vector1::new(rate) })
    }

    fn sliding_velocities(&self, _: f64, _: &Vector1<f64>) -> [f64; 0] {
        []
    }

    fn next_kink(&self, time: f64, towards: f64) -> Option<f64> {
        self.0.next_kink(time, towards)
    }
}

/// ẋ = sgn v(t): the bare kink. x is the time spent sliding forward less that spent sliding
/// backward, and every method is exact on a locked branch, however long its steps.
#[derive(Debug, Clone)]
pub struct Sided<V>(pub V);

impl<V: Signal<f64>> System<f64, 1> for Sided<V> {
    fn rate(&self, time: f64, _: &Vector1<f64>, [branch]: [Branch; 1]) -> Vector1<f64> {
        Vector1::new(branch.of(self.0.value(time)).direction())
    }

    fn sliding_velocities(&self, time: f64, _: &Vector1<f64>) -> [f64; 1] {
        [self.0.value(time)]
    }

    fn next_kink(&self, time: f64, towards: f64) -> Option<f64> {
        self.0.next_kink(time, towards)
    }
}

/// A system that counts the calls of its right-hand side.
#[derive(Debug)]
pub struct Counted<S> {
    pub system: S,
    pub calls: Cell<u64>,
}

impl<S> Counted<S> {
    pub fn new(system: S) -> Self {
        Self { system, calls: Cell::new(0) }
    }
}

impl<T: Scalar, S: System<T, N, K>, const N: usize, const K: usize> System<T, N, K> for Counted<S> {
    fn rate(&self, time: T, state: &SVector<T, N>, branches: [Branch; K]) -> SVector<T, N> {
        self.calls.set(self.calls.get() + 1);
        self.system.rate(time, state, branches)
    }

    fn sliding_velocities(&self, time: T, state: &SVector<T, N>) -> [T; K] {
        self.system.sliding_velocities(time, state)
    }

    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        self.system.next_kink(time, towards)
    }

    fn scales(&self) -> SVector<T, N> {
        self.system.scales()
    }
}
