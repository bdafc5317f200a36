//! The parameters of a mechanism and of its friction from logs of drive and position, where no
//! friction was measured.
//!
//! J v̇ = τ_m + τ_e − B v − p μ_b(v, z),  p = T_c + |k_m τ_m − k_e τ_e|,
//!
//! τ_e = τ(t) + Σ θᵢ φᵢ(x, v)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x, v, z | position, velocity, deflection of the bristle | rad, rad/s, rad |
//! | J, B | moment of inertia, drag: [`Joint`] | kg m², N m s/rad |
//! | τ_m | torque of the motor, from torque, current, voltage or a controller: [`Drive`] | N m |
//! | τ_e | torques on the load side, each a [`Term`] with a factor θ, and a measured one | N m |
//! | p, μ_b | load of the gear, friction model: [`Friction`]; see [`bristle_joint`] | N m, – |
//! | T_c, k_m, k_e | Coulomb torque, factors of the load, with μ_d = 1 | N m, –, – |
//!
//! For a linear axis read m for rad, N for N m and kg for kg m²: [`Joint::in_units`] prints them.
//!
//! | step | what | where |
//! |---|---|---|
//! | 1 | columns, checked row by row | [`DriveLog`] |
//! | 2 | the mechanism, and what is known of it | [`Joint`] |
//! | 3 | one candidate, or several compared by logs left out | [`fit_joint`], [`compare`] |
//! | 4 | parameters with standard errors, errors by two criteria | [`JointFit`], which prints |
//! | 5 | friction and joint for simulations and control | [`JointModel`] |
//!
//! ```
//! use bristle_identify::mechanism::{
//!     self, Drive, DriveLog, DriveLogParameters, Friction, Joint, Progress, Settings, Term,
//! };
//! use core::ops::ControlFlow;
//!
//! # fn columns(phase: f64) -> Result<[Vec<f64>; 3], bristle::ParameterError> {
//! #     use bristle_joint::{
//! #         GearFriction, GearFrictionParameters, GearedJoint, GearedJointParameters, Gravity,
//! #         JointState, TorqueLoad, TorqueLoadParameters,
//! #     };
//! #     use bristle::{Dahl, DahlParameters};
//! #     let law = TorqueLoadParameters { idle_load: 0.05, motor_share: 0.2, external_share: 0.1 };
//! #     let dahl = DahlParameters { dynamic_coefficient: 1.0, micro_stiffness: 200.0 };
//! #     let (friction, load) = (Dahl::new(dahl)?, TorqueLoad::new(law)?);
//! #     let (reference_load, drag, fastest) = (law.idle_load, 0.01, 10.0);
//! #     let gear = GearFrictionParameters { friction, load, reference_load, drag, fastest };
//! #     let torque = |t: f64| 0.7 * (3.0 * t + phase).sin() + 0.3 * (7.3 * t).sin();
//! #     let joint = GearedJoint::new(GearedJointParameters {
//! #         gear: GearFriction::new(gear)?,
//! #         inertia: 0.008,
//! #         motor: bristle::signal::Function::new(move |t: f64| (torque(t), 0.0), []),
//! #         external: Gravity { horizontal_torque: 0.5, hanging_angle: 0.0 },
//! #     })?;
//! #     let (mut state, mut columns) = (JointState::at_rest(0.0), [vec![], vec![], vec![]]);
//! #     for step in 0..4000 {
//! #         if step % 5 == 0 {
//! #             let row = [state.time, state.angle, torque(state.time)];
//! #             columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
//! #         }
//! #         state = joint.step(&state, 1e-3)?.0;
//! #     }
//! #     Ok(columns)
//! # }
//! // Columns of two logs of a pendulum on a gear: time, position and motor torque.
//! let (one, other) = (columns(0.0)?, columns(1.0)?);
//! let log = |[time, position, torque]: &[Vec<f64>; 3]| {
//!     DriveLog::new(DriveLogParameters::new(time, position, Drive::Torque(torque)))
//! };
//! let joint = Joint::new().with(Term::Gravity);
//! let mut go_on = |_: &Progress<'_>| ControlFlow::Continue(());
//! let candidates = [Friction::coulomb().loaded(), Friction::dahl().loaded()];
//! let found = mechanism::compare(
//!     &joint,
//!     &candidates,
//!     &[log(&one)?],
//!     &[log(&other)?],
//!     &Settings::default(),
//!     &mut go_on,
//! )?;
//! println!("{found}");
//! let fit = found.named().unwrap();
//! let near = |name: &str, truth: f64| (fit.value(name).unwrap() / truth - 1.0).abs() < 0.05;
//! assert!(near("inertia", 0.008) && near("coulomb_torque", 0.05));
//! assert!(near("motor_load_factor", 0.2) && near("external_load_factor", 0.1));
//! let model = fit.model()?;
//! let (gear, external) = (model.gear()?, model.external(&joint)?); // for a `GearedJoint`
//! # let _ = (gear, external);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Names of the parameters
//!
//! With μ_d = 1 the friction model is a curve without a unit, and torques and factors of the load
//! are what the teeth take. A [gear](bristle_joint::GearFriction) with a μ_d of its own, as that of
//! its datasheet, has the products:
//!
//! | name | in [`bristle_joint`] | found with |
//! |---|---|---|
//! | `inertia` | `GearedJointParameters::inertia` | always |
//! | `drag` | `GearFrictionParameters::drag` | always |
//! | `delay` \[s\] | not there: [`DriveLogParameters::delay`] | [`Joint::start`] |
//! | `torque_constant`, `resistance` | those of `VoltageMotorParameters` | [`Drive`] |
//! | `inductance` L \[H\] | not there: L di/dt = u − R i − k_t v | [`Joint::start`], of a voltage |
//! | `duty_exponent` | γ of V sgn(d) \|d\|^γ, not there | [`Drive::Duty`] |
//! | `offset_torque`, `spring_rate` | [`ExternalTorque`] | [`Term::constant`], [`Term::spring`] |
//! | `backward_drag` | [`ExternalTorque`] | [`Term::backward_drag`] |
//! | `ripple_cos_1`, `ripple_sin_1`, … | [`ExternalTorque`] | [`Term::ripple`] |
//! | `gravity_torque` | `Gravity::horizontal_torque` | [`Term::Gravity`] |
//! | `hanging_angle` | `Gravity::hanging_angle`, within ±π | [`Term::Gravity`] |
//! | `coulomb_torque` | `TorqueLoadParameters::idle_load` · μ_d | every [`Friction`] |
//! | `motor_load_factor` | `TorqueLoadParameters::motor_share` · μ_d | [`Friction::loaded`] |
//! | `external_load_factor` | `TorqueLoadParameters::external_share` · μ_d | [`Friction::loaded`] |
//! | `breakaway_excess` | μ_s/μ_d − 1 | Stribeck, FrBD, LuGre |
//! | `stribeck_velocity` | `StribeckParameters::stribeck_velocity` | Stribeck, FrBD, LuGre |
//! | `stribeck_exponent` | `StribeckParameters::stribeck_exponent` | Stribeck, FrBD, LuGre |
//! | `backward_ratio` | μ for v < 0 over μ for v > 0 | [`Friction::directional`] |
//! | `micro_stiffness` | σ0/μ_d at `reference_load` = `idle_load` | Dahl, FrBD, LuGre |
//! | `micro_damping` | σ1/μ_d, likewise | FrBD, LuGre |
//! | `initial_velocity`, `initial_deflection` | not there, of each log | [`DriveLog::in_motion`] |
//!
//! Stiffness and damping of the bristle do not follow the load. A search goes up to a
//! `micro_stiffness` of 10⁴ over the range of the motion, or farther if it starts beyond. The
//! exponent of the curve is 2, in [`Friction::exponential`] 1; it may start elsewhere, or be
//! known.
//!
//! # Criteria
//!
//! | criterion | residual | what it is for |
//! |---|---|---|
//! | inverse | torque of the equation of motion, from smoothed derivatives | the start |
//! | segments | position, simulated over segments from the measured motion | the way |
//! | simulated | position over whole logs | the end, and what a simulator needs |
//!
//! The first and the last are reported, also on logs held out. A search goes through the inverse
//! criterion and segments of growing length ([`Settings::horizons`]). Where the position over a
//! segment depends on the parameters too much, as in stick-slip, segments end earlier, and a
//! [remark](crate::Remark) says so.
//!
//! Where the errors of the position exceed a third of the standard deviation of the motion, the
//! model does not explain the log: a wrong sign, a missing torque, degrees. A remark names the log,
//! the worst first, and no parameter is determined then. Where the segments that were fitted are
//! explained and the whole log is not, a remark says that alone: where nothing holds the position,
//! small errors add up. So do remarks of logs held out, also of one in which hardly anything moves.
//!
//! Simulations take passive steps of at most 1 ms, see
//! [`GearFriction::joint_step`](bristle_joint::GearFriction::joint_step). Dual numbers through them
//! give exact sensitivities. Standard errors, and what the data do not determine, are those of
//! [`identify`](crate).
//!
//! # What which log tells
//!
//! The unit of all torques comes from the drive or from what is [known](Joint::known): with a
//! voltage alone and neither torque constant nor gravity known, only ratios are determined. One
//! load does not tell factors of the load, one speed no Stribeck curve, and a position with a
//! coarse encoder no bristle shorter than a count. Of an inductance only the time L/R shows: it is
//! as wrong as the resistance, and to motions much slower than R/L a delay of this time.
//!
//! A log that stands still most of its time tells less than its standard errors say: held friction
//! is anything up to its limit. A pendulum that is moved a little and held in between may be found
//! with several times its gravity. Fit its moves alone, each a log that begins under load:
//! [`DriveLog::between`], [`DriveLog::in_motion`].
//!
//! Noise of a measured drive would load and unload the gear in every step, and a sliding bristle
//! slips back with each fall of its load. The gear is therefore loaded by the smoothed drive,
//! unless the drive is a command ([`DriveLogParameters::noisy`]).
//!
//! # Limits
//!
//! A simulation starts with the smoothed position and velocity of its first row. Begin and end logs
//! at rest, or leave out rows by [`DriveLog::between`]; of each log that begins in motion, or at
//! rest under load, the state there can be searched: [`DriveLog::in_motion`]. Voltage and current
//! are taken without limits of their own.

mod compare;
mod criteria;
mod expected;
mod fit;
mod friction;
mod joint;
mod judge;
mod ladder;
mod log;
mod plant;
mod report;
mod smooth;
mod start;

pub use super::robust::Loss;
pub use compare::{Comparison, compare};
pub use fit::{Progress, Settings, fit_joint};
pub use friction::Friction;
pub use joint::{Joint, OwnTerm, Term};
pub use log::{Drive, DriveLog, DriveLogParameters, KnownLoad};
pub use report::{ExpectedError, ExternalTorque, GroupScores, JointFit, JointModel, Score, Scores};
