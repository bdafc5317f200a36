//! A diaphragm valve: pressure from an I/P converter moves a stem against a spring, a preload and
//! friction.
//!
//! ẋ = v,  m v̇ = S_a P − k x − F₀ − F,  τ Ṗ = K_P OP(t) + P_min − P
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x, v | position and velocity of the stem | m, m/s |
//! | P, P_min | pressure in the chamber, and its least value | Pa |
//! | OP | opening asked for | % |
//! | S_a | area of the diaphragm | m² |
//! | K_P | pressure gain | Pa/% |
//! | τ | time constant of the converter | s |
//!
//! Source: Romano et al. (arXiv 2602.09429), section V-B.

use nalgebra::Vector4;

use super::{DEFLECTION, Moving, POSITION, VELOCITY, typical_deflection, typical_force};
use crate::ode::{Linearisation, System};
use crate::parameter::{self, ParameterError};
use crate::scalar::lit;
use crate::signal::Signal;
use crate::{Branch, Bristle, Contact, Scalar};

/// Parameters of [`DiaphragmValve`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiaphragmValveParameters<T, M, U> {
    /// Friction of the stem's packing under its normal force.
    pub contact: Contact<T, M>,
    /// Mass m of the stem \[kg\], positive.
    pub mass: T,
    /// Area S_a of the diaphragm \[m²\], positive.
    pub diaphragm_area: T,
    /// Stiffness k of the return spring [N/m], positive.
    pub spring_stiffness: T,
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
pub struct DiaphragmValve<T, M, U> {
    contact: Contact<T, M>,
    inverse_mass: T,
    diaphragm_area: T,
    spring_stiffness: T,
    preload: T,
    least_pressure: T,
    pressure_gain: T,
    /// 1/τ
    lag_rate: T,
    opening: U,
}

const PRESSURE: usize = 3;

impl<T, M, U> DiaphragmValve<T, M, U>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    U: Signal<T>,
{
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range.
    pub fn new(parameters: DiaphragmValveParameters<T, M, U>) -> Result<Self, ParameterError> {
        let p = parameters;
        Ok(Self {
            contact: p.contact,
            inverse_mass: T::one() / parameter::positive("mass", p.mass)?,
            diaphragm_area: parameter::positive("diaphragm_area", p.diaphragm_area)?,
            spring_stiffness: parameter::positive("spring_stiffness", p.spring_stiffness)?,
            preload: parameter::finite("preload", p.preload)?,
            least_pressure: parameter::non_negative("least_pressure", p.least_pressure)?,
            pressure_gain: parameter::positive("pressure_gain", p.pressure_gain)?,
            lag_rate: T::one() / parameter::positive("time_constant", p.time_constant)?,
            opening: p.opening,
        })
    }

    /// The state in which pressure and spring have settled at the opening asked for at a time,
    /// with no friction: x = (S_a P − F₀)/k, v = z = 0, P = P_min + K_P OP.
    pub fn balanced(&self, time: T) -> Vector4<T> {
        let pressure = self.pressure_asked_for(time);
        let position = (self.diaphragm_area * pressure - self.preload) / self.spring_stiffness;
        Vector4::new(position, T::zero(), T::zero(), pressure)
    }

    /// The friction force \[N\] at a state.
    pub fn friction_force(&self, state: &Vector4<T>) -> T {
        self.contact.force(state[VELOCITY], state[DEFLECTION])
    }

    /// A typical magnitude of each state, for tolerances: travel and pressure at full opening, the
    /// velocity at which the stem oscillates on its bristles, the deflection at breakaway.
    pub fn scales(&self) -> Vector4<T> {
        let pressure = self.pressure_gain * lit(100.0);
        let travel = self.diaphragm_area * pressure / self.spring_stiffness;
        let deflection = typical_deflection(&self.contact);
        let force = typical_force(&self.contact);
        let velocity = (force * self.inverse_mass * deflection).sqrt();
        Vector4::new(travel, velocity, deflection, pressure)
    }

    fn pressure_asked_for(&self, time: T) -> T {
        self.least_pressure + self.pressure_gain * self.opening.value(time)
    }

    /// Every force \[N\] on the stem but friction.
    fn other_forces(&self, state: &Vector4<T>) -> T {
        self.diaphragm_area * state[PRESSURE]
            - self.spring_stiffness * state[POSITION]
            - self.preload
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
        let velocity = state[VELOCITY];
        let friction = self.contact.response(branch.of(velocity), state[DEFLECTION]);
        Vector4::new(
            velocity,
            (self.other_forces(state) - friction.force) * self.inverse_mass,
            friction.rate,
            (self.pressure_asked_for(time) - state[PRESSURE]) * self.lag_rate,
        )
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
        let sliding = branch.of(state[VELOCITY]);
        let Moving { mut rate, mut by_state } =
            Moving::new(&self.contact, sliding, state[DEFLECTION], self.inverse_mass);
        rate[VELOCITY] += self.other_forces(state) * self.inverse_mass;
        rate[PRESSURE] = (self.pressure_asked_for(time) - state[PRESSURE]) * self.lag_rate;
        by_state[(VELOCITY, POSITION)] = -self.spring_stiffness * self.inverse_mass;
        by_state[(VELOCITY, PRESSURE)] = self.diaphragm_area * self.inverse_mass;
        by_state[(PRESSURE, PRESSURE)] = -self.lag_rate;
        let (_, opening_rate) = self.opening.value_and_rate(time);
        let pressure_rate = self.pressure_gain * opening_rate * self.lag_rate;
        let by_time = Vector4::new(T::zero(), T::zero(), T::zero(), pressure_rate);
        Some(Linearisation { rate, by_state, by_time })
    }

    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        self.opening.next_kink(time, towards)
    }

    fn scales(&self) -> Vector4<T> {
        DiaphragmValve::scales(self)
    }
}
