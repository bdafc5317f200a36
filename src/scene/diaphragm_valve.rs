//! A diaphragm valve: pressure from an I/P converter moves a stem against a spring, a preload and
//! friction.
//!
//! ẋ = v,  m v̇ = S_a P − k x − F₀ − c v − F,  τ Ṗ = K_P OP(t) + P_min − P
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x, v | position and velocity of the stem | m, m/s |
//! | m, k, c | mass, stiffness of the return spring, damping beside the friction | kg, N/m, N s/m |
//! | F₀, F | preload of the return spring, friction | N |
//! | P, P_min | pressure in the chamber, and its least value | Pa |
//! | OP | opening asked for | % |
//! | S_a | area of the diaphragm | m² |
//! | K_P | pressure gain | Pa/% |
//! | τ | time constant of the converter | s |
//!
//! Source: Romano et al. (arXiv 2602.09429), section V-B.

use nalgebra::Vector4;

use super::{Body, POSITION, VELOCITY};
use crate::ode::{Linearisation, System};
use crate::parameter::{Checked, Named};
use crate::scalar::lit;
use crate::signal::Signal;
use crate::{Branch, Bristle, Contact, Mechanism, Scalar};

/// Parameters of [`DiaphragmValve`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct DiaphragmValveParameters<T: Scalar, M, U> {
    /// Friction of the stem's packing under its normal force.
    pub contact: Contact<T, M>,
    /// Mass of the stem, its return spring (which must have a stiffness) and damping.
    pub mechanism: Mechanism<T>,
    /// Area S_a of the diaphragm \[m²\], positive.
    pub diaphragm_area: T,
    /// Preload F₀ of the return spring \[N\].
    pub preload: T,
    /// Least pressure P_min in the chamber \[Pa\], zero or positive.
    pub least_pressure: T,
    /// Pressure gain K_P [Pa/%], positive.
    pub pressure_gain: T,
    /// Time constant τ of the I/P converter \[s\], positive.
    pub time_constant: T,
    /// Opening asked for, OP(t) \[%\].
    pub opening: U,
}

/// A diaphragm valve. States: position \[m\] and velocity [m/s] of the stem, deflection \[m\],
/// pressure \[Pa\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiaphragmValve<T: Scalar, M, U> {
    parameters: DiaphragmValveParameters<T, M, U>,
    inverse_mass: T,
    /// 1/τ
    lag_rate: T,
}

const PRESSURE: usize = 3;

impl<T: Scalar, M: Bristle<T, Deflection = T>, U: Signal<T>> DiaphragmValve<T, M, U> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range; the opening is checked at time zero.
    pub fn new(parameters: DiaphragmValveParameters<T, M, U>) -> Checked<Self> {
        let mut p = parameters;
        Named("spring_stiffness", p.mechanism.spring_stiffness).positive()?;
        Named("opening", p.opening.value(T::zero())).finite()?;
        p.mechanism = p.mechanism.checked()?;
        Named("diaphragm_area", p.diaphragm_area).positive()?;
        Named("preload", p.preload).finite()?;
        p.least_pressure = Named("least_pressure", p.least_pressure).non_negative()?;
        Named("pressure_gain", p.pressure_gain).positive()?;
        Named("time_constant", p.time_constant).positive()?;
        let [inverse_mass, lag_rate] = [p.mechanism.mass, p.time_constant].map(|x| T::one() / x);
        Ok(Self { parameters: p, inverse_mass, lag_rate })
    }

    #[inline(always)]
    fn body(&self) -> Body<'_, T, M> {
        let DiaphragmValveParameters { contact, mechanism, .. } = &self.parameters;
        Body { contact, mechanism: *mechanism, inverse_mass: self.inverse_mass }
    }

    /// The parameters, as they were given.
    pub fn parameters(&self) -> &DiaphragmValveParameters<T, M, U> {
        &self.parameters
    }

    /// The state in which pressure and spring have settled at the opening asked for at a time,
    /// with no friction: x = (S_a P − F₀)/k, v = z = 0, P = P_min + K_P OP.
    pub fn balanced(&self, time: T) -> Vector4<T> {
        let pressure = self.pressure_asked_for(time);
        let force = self.parameters.diaphragm_area * pressure - self.parameters.preload;
        let position = force / self.parameters.mechanism.spring_stiffness;
        Vector4::new(position, T::zero(), T::zero(), pressure)
    }

    /// The friction force \[N\] at a state.
    pub fn friction_force(&self, state: &Vector4<T>) -> T {
        self.body().friction_force(state)
    }

    /// A typical magnitude of each state, for tolerances: travel and pressure at full opening, the
    /// velocity at which the stem oscillates on its bristles, the deflection at breakaway.
    ///
    /// The velocity is that of a fast stroke: the paper's valve reaches 0.77 of it under a sine of
    /// 40 % at 0.05 Hz, and 0.06 under a ramp of 1 % per second.
    pub fn scales(&self) -> Vector4<T> {
        let pressure = self.parameters.pressure_gain * lit(100.0);
        let travel =
            self.parameters.diaphragm_area * pressure / self.parameters.mechanism.spring_stiffness;
        let (velocity, deflection) =
            (self.body().bristle_velocity(), self.body().breakaway_deflection());
        Vector4::new(travel, velocity, deflection, pressure)
    }

    fn pressure_asked_for(&self, time: T) -> T {
        self.parameters.least_pressure
            + self.parameters.pressure_gain * self.parameters.opening.value(time)
    }

    /// Ṗ [Pa/s].
    fn pressure_rate(&self, time: T, state: &Vector4<T>) -> T {
        (self.pressure_asked_for(time) - state[PRESSURE]) * self.lag_rate
    }

    /// Force \[N\] of diaphragm and return spring on the stem.
    fn force(&self, state: &Vector4<T>) -> T {
        self.parameters.diaphragm_area * state[PRESSURE]
            - self.parameters.mechanism.spring_stiffness * state[POSITION]
            - self.parameters.preload
    }
}

impl<T, M, U> System<T, 4> for DiaphragmValve<T, M, U>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    U: Signal<T>,
{
    #[inline]
    fn rate(&self, time: T, state: &Vector4<T>, [branch]: [Branch; 1]) -> Vector4<T> {
        let mut rate = self.body().rate(self.force(state), state, branch);
        rate[PRESSURE] = self.pressure_rate(time, state);
        rate
    }

    #[inline]
    fn sliding_velocities(&self, _time: T, state: &Vector4<T>) -> [T; 1] {
        [state[VELOCITY]]
    }

    #[inline]
    fn linearised(
        &self,
        time: T,
        state: &Vector4<T>,
        [branch]: [Branch; 1],
    ) -> Option<Linearisation<T, 4>> {
        let mut linearised = self.body().linearised(self.force(state), state, branch);
        linearised.rate[PRESSURE] = self.pressure_rate(time, state);
        linearised.by_state[(VELOCITY, PRESSURE)] =
            self.parameters.diaphragm_area * self.inverse_mass;
        linearised.by_state[(PRESSURE, PRESSURE)] = -self.lag_rate;
        let (_, opening_rate) = self.parameters.opening.value_and_rate(time);
        linearised.by_time[PRESSURE] = self.parameters.pressure_gain * opening_rate * self.lag_rate;
        Some(linearised)
    }

    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        self.parameters.opening.next_kink(time, towards)
    }

    #[inline]
    fn switching_functions(
        &self,
        _time: T,
        state: &Vector4<T>,
        [branch]: [Branch; 1],
        tell: &mut dyn FnMut(T),
    ) {
        self.body().switching_function(state, branch).map(tell);
    }

    fn longest_step(&self) -> Option<T> {
        self.parameters.opening.longest_step()
    }

    fn scales(&self) -> Vector4<T> {
        DiaphragmValve::scales(self)
    }
}
