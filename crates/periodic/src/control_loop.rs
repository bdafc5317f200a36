//! A position loop around a mass with friction.
//!
//! ẋ = v,  m v̇ = u − k x − c v − F(v, z),  ż = h(v, z),  İ = x,  τ v̇_f = v − v_f
//!
//! u = −K_P x − K_I I − K_D v_f
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x, v | position error and velocity of the mass | m, m/s |
//! | z, F | deflection of the bristle, friction force | m, N |
//! | I | integral of the error | m s |
//! | v_f, τ | filtered velocity, and its time constant; v itself without a filter | m/s, s |
//! | u | control force | N |
//! | m, k, c | mass, spring stiffness, viscous damping | kg, N/m, N s/m |
//! | K_P, K_I, K_D | gains of the controller | N/m, N/(m s), N s/m |
//!
//! Static friction above the dynamic one lets a loop with integral action hunt: the mass sticks
//! beside its target until the integral breaks it loose, and it slips to the other side.
//!
//! Source: B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, "A survey of models, analysis tools
//! and compensation methods for the control of machines with friction", Automatica 30 (1994),
//! section 4.

use bristle::ode::{Linearisation, System};
use bristle::parameter::{Checked, Named};
use bristle::{Branch, Bristle, Contact, Mechanism};
use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{DMatrix, SMatrix, SVector};

use crate::multipliers::{multipliers, without_one};

/// Gains of a controller: P, PI, PD or PID, on the position error of a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pid {
    /// K_P [N/m], positive.
    #[doc(alias = "Kp")]
    pub proportional: f64,
    /// K_I [N/(m s)], zero for none.
    #[doc(alias = "Ki")]
    pub integral: f64,
    /// K_D [N s/m], zero for none.
    #[doc(alias = "Kd")]
    pub derivative: f64,
    /// Time constant τ \[s\] of the filter of the velocity; zero for none.
    pub filter_time: f64,
    /// Sample time h \[s\] of the controller, which holds its force in between; zero for a
    /// controller in continuous time. Its integral takes h x after the force is given (Euler
    /// forward); its filter is exact for a velocity that is held.
    pub sample_time: f64,
}

/// Parameters of a [`ControlLoop`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlLoopParameters<M> {
    /// Friction under its normal force.
    pub contact: Contact<f64, M>,
    /// The mass, and a spring and a damper beside the friction if there are any.
    pub mechanism: Mechanism<f64>,
    /// The controller.
    pub controller: Pid,
}

impl<M: Bristle<f64, Deflection = f64>> ControlLoopParameters<M> {
    /// The period of the mass on the controller's stiffness and the spring \[s\].
    pub(crate) fn swing(&self) -> f64 {
        let stiffness = self.controller.proportional + self.mechanism.spring_stiffness;
        core::f64::consts::TAU * (self.mechanism.mass / stiffness).sqrt()
    }

    /// The deflection of the bristle at breakaway \[m\], and the force on it \[N\].
    pub(crate) fn breakaway(&self) -> [f64; 2] {
        let deflection = self.contact.limits(0.0).deflection.unwrap_or(1e-6);
        let stiffness = self.contact.model().storage_stiffness() * self.contact.reference_load();
        [deflection, stiffness * deflection]
    }

    /// The parameters if each is in its range.
    pub(crate) fn checked(self) -> Checked<Self> {
        self.mechanism.checked()?;
        Named("normal_force", self.contact.normal_force()).positive()?;
        let Pid { proportional, integral, derivative, filter_time, sample_time } = self.controller;
        Named("proportional", proportional).positive()?;
        for (name, value) in [
            ("integral", integral),
            ("derivative", derivative),
            ("filter_time", filter_time),
            ("sample_time", sample_time),
        ] {
            // Zero, or large enough to be divided by.
            let in_range = value == 0.0 || Named(name, value).positive().is_ok();
            Named(name, value).stated(in_range, "be zero, or lie between 1e-100 and 1e100")?;
        }
        // The scales of the motion, with room for tolerances.
        let force = self.breakaway()[1];
        let stiffness = proportional + self.mechanism.spring_stiffness;
        let damping = derivative + self.mechanism.viscous_damping;
        for (name, divisor) in [
            ("breakaway force / (proportional + spring_stiffness)", stiffness),
            ("breakaway force / integral", integral),
            ("breakaway force / (derivative + viscous_damping)", damping),
        ] {
            if divisor > 0.0 {
                Named(name, force / divisor).between(1e-80, 1e80)?;
            }
        }
        Ok(self)
    }
}

/// What plays no part decays by this power of e over a sample.
const QUICK: f64 = 100.0;

/// A position loop around a mass with friction: a [`System`] with 4 states in continuous time, 5
/// with a filter of the velocity, 6 between the samples of a controller, where the last three do
/// not change.
///
/// States: position error \[m\], velocity [m/s], deflection \[m\], integral of the error \[m s\],
/// filtered velocity [m/s], held force \[N\]. Without integral action the integral is not used, and
/// decays with a time constant of 1 s, so that motions can repeat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlLoop<M, const N: usize> {
    parameters: ControlLoopParameters<M>,
    /// The Jacobian of all but friction, of which the loop is linear.
    frictionless: SMatrix<f64, N, N>,
}

const UNFILTERED: &str = "be zero: a loop with a filter is built by ControlLoop::filtered";
const CONTINUOUS: &str = "be zero: a loop that samples is built by ControlLoop::sampled";

impl<M: Bristle<f64, Deflection = f64>> ControlLoop<M, 4> {
    /// A loop without a filter.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range; refuses a filter and a sample time.
    pub fn new(parameters: ControlLoopParameters<M>) -> Checked<Self> {
        Self::of(parameters)
    }
}

impl<M: Bristle<f64, Deflection = f64>> ControlLoop<M, 5> {
    /// A loop with a filter of the velocity.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range; refuses a loop without a filter, and a sample
    /// time.
    pub fn filtered(parameters: ControlLoopParameters<M>) -> Checked<Self> {
        Self::of(parameters)
    }
}

impl<M: Bristle<f64, Deflection = f64>> ControlLoop<M, 6> {
    /// A sampled loop between its samples, with or without a filter.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range; refuses a loop without a sample time.
    pub fn sampled(parameters: ControlLoopParameters<M>) -> Checked<Self> {
        Self::of(parameters)
    }
}

impl<M: Bristle<f64, Deflection = f64>, const N: usize> ControlLoop<M, N> {
    /// The parameters, as they were given.
    pub fn parameters(&self) -> &ControlLoopParameters<M> {
        &self.parameters
    }

    /// At rest at a distance from the target, with an undeflected bristle.
    pub fn displaced(&self, position: f64) -> SVector<f64, N> {
        SVector::from_fn(|i, _| if i == 0 { position } else { 0.0 })
    }

    /// The sample time h \[s\], and what a sample does: the state x jumps to J x. None of a
    /// controller in continuous time.
    pub fn samples(&self) -> Option<(f64, SMatrix<f64, N, N>)> {
        let Pid { proportional, integral, derivative, filter_time, sample_time } =
            self.parameters.controller;
        if sample_time == 0.0 {
            return None;
        }
        let share = if filter_time > 0.0 { -(-sample_time / filter_time).exp_m1() } else { 1.0 };
        let mut jump = SMatrix::<f64, N, N>::identity();
        (jump[(4, 1)], jump[(4, 4)]) = (share, 1.0 - share);
        let force = jump.row(4) * -derivative;
        jump.set_row(5, &force);
        (jump[(5, 0)], jump[(5, 3)]) = (-proportional, -integral);
        // An integral that is not used is kept at zero.
        (jump[(3, 0)], jump[(3, 3)]) = if integral > 0.0 { (sample_time, 1.0) } else { (0.0, 0.0) };
        Some((sample_time, jump))
    }

    /// A loop of N states, if its controller takes as many.
    fn of(parameters: ControlLoopParameters<M>) -> Checked<Self> {
        let parameters = parameters.checked()?;
        let ControlLoopParameters { mechanism, controller, .. } = &parameters;
        let filter_time = Named("filter_time", controller.filter_time);
        let sample_time = Named("sample_time", controller.sample_time);
        let mut by_state = SMatrix::<f64, N, N>::zeros();
        by_state[(0, 1)] = 1.0;
        by_state[(1, 0)] = -mechanism.spring_stiffness;
        by_state[(1, 1)] = -mechanism.viscous_damping;
        if N == 6 {
            sample_time.positive()?;
            by_state[(1, 5)] = 1.0;
        } else {
            by_state[(3, 0)] = 1.0;
            by_state[(1, 0)] -= controller.proportional;
            by_state[(1, 3)] = -controller.integral;
            if controller.integral == 0.0 {
                by_state[(3, 3)] = -1.0;
            }
            // The velocity that the controller knows.
            if N == 5 {
                by_state[(4, 1)] = 1.0 / filter_time.positive()?;
                by_state[(4, 4)] = -by_state[(4, 1)];
                by_state[(1, 4)] -= controller.derivative;
            } else {
                filter_time.stated(filter_time.1 == 0.0, UNFILTERED)?;
                by_state[(1, 1)] -= controller.derivative;
            }
            sample_time.stated(sample_time.1 == 0.0, CONTINUOUS)?;
        }
        by_state.row_mut(1).unscale_mut(mechanism.mass);
        Ok(Self { frictionless: by_state, parameters })
    }

    /// Largest real parts ln |μ|/h about rest, and without friction [1/s], from the multipliers μ
    /// over a sample, or over a period of the swing, and less if they are too large for a number;
    /// zero within roundings.
    pub(crate) fn abscissas(&self) -> Checked<(f64, f64)> {
        let samples = self.samples();
        let (longest, jump) =
            samples.unwrap_or_else(|| (self.parameters.swing(), SMatrix::identity()));
        let over = |mut dynamics: SMatrix<f64, N, N>, unused: &[usize], is_rest: bool| {
            let largest = |h: f64| {
                for &state in unused {
                    dynamics[(state, state)] = -QUICK / h;
                }
                let mut flow = DMatrix::from_column_slice(N, N, (dynamics * h).as_slice());
                if samples.is_none() {
                    balance_parlett_reinsch(&mut flow);
                }
                flow = flow.exp();
                let all = multipliers(&[SMatrix::from_column_slice(flow.as_slice()) * jump])?;
                // A mass rests at any deflection that the controller balances: one multiplier is 1.
                let all = if is_rest { without_one(&all) } else { all.to_vec() };
                let first = all.first().filter(|it| it.log_modulus < f64::INFINITY)?;
                Some(if first.is_neutral() { 0.0 } else { first.log_modulus / h })
            };
            let lengths = if samples.is_some() { 1 } else { 100 };
            (0..lengths).map(|tenths| longest * 0.1_f64.powi(tenths)).find_map(largest)
        };
        let integrates = self.parameters.controller.integral > 0.0;
        let stuck = self.linearised(0.0, &SVector::zeros(), [Branch::Free]);
        let stuck = stuck.map_or_else(SMatrix::zeros, |linearised| linearised.by_state);
        let rest = over(stuck, if integrates { &[] } else { &[3] }, true);
        let large = over(self.frictionless, if integrates { &[2] } else { &[2, 3] }, false);
        let finite = |name, found: Option<f64>| Named(name, found.unwrap_or(f64::NAN)).number();
        Ok((finite("rest_abscissa", rest)?, finite("large_abscissa", large)?))
    }
}

impl<M: Bristle<f64, Deflection = f64>, const N: usize> System<f64, N> for ControlLoop<M, N> {
    #[inline]
    fn rate(&self, _: f64, state: &SVector<f64, N>, [branch]: [Branch; 1]) -> SVector<f64, N> {
        let ControlLoopParameters { contact, mechanism, .. } = &self.parameters;
        let friction = contact.response(branch.of(state[1]), state[2]);
        let mut rate = self.frictionless * state;
        rate[1] -= friction.force / mechanism.mass;
        rate[2] = friction.rate;
        rate
    }

    fn sliding_velocities(&self, _: f64, state: &SVector<f64, N>) -> [f64; 1] {
        [state[1]]
    }

    fn linearised(
        &self,
        time: f64,
        state: &SVector<f64, N>,
        [branch]: [Branch; 1],
    ) -> Option<Linearisation<f64, N>> {
        let ControlLoopParameters { contact, mechanism, .. } = &self.parameters;
        let friction = contact.linearised(branch.of(state[1]), state[2]);
        let mut by_state = self.frictionless;
        by_state[(1, 1)] -= friction.force_by_velocity / mechanism.mass;
        by_state[(1, 2)] -= friction.force_by_deflection / mechanism.mass;
        (by_state[(2, 1)], by_state[(2, 2)]) =
            (friction.rate_by_velocity, friction.rate_by_deflection);
        let rate = self.rate(time, state, [branch]);
        Some(Linearisation { rate, by_state, by_time: SVector::zeros() })
    }

    #[inline]
    fn switching_functions(
        &self,
        _: f64,
        state: &SVector<f64, N>,
        [branch]: [Branch; 1],
        tell: &mut dyn FnMut(f64),
    ) {
        self.parameters.contact.switching_function(branch.of(state[1]), state[2]).map(tell);
    }

    /// The position error that the controller does not feel at breakaway, and what the mass does
    /// from there: it swings, no faster than the damping allows.
    fn scales(&self) -> SVector<f64, N> {
        let ControlLoopParameters { mechanism, controller, .. } = &self.parameters;
        let stiffness = controller.proportional + mechanism.spring_stiffness;
        let [deflection, force] = self.parameters.breakaway();
        let (position, rate) = (force / stiffness, (stiffness / mechanism.mass).sqrt());
        // The integral that breaks the mass loose.
        let wait = if controller.integral > 0.0 { stiffness / controller.integral } else { 1.0 };
        let damping = controller.derivative + mechanism.viscous_damping;
        let velocity = (position * rate).min(force / damping);
        let all = [position, velocity, deflection, position * wait, velocity, position * stiffness];
        SVector::from_fn(|i, _| all[i].max(f64::MIN_POSITIVE))
    }
}
