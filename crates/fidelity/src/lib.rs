//! How much model a scene needs: the cheapest model and the longest step that keep its answers
//! within a tolerance of the reference, measured over the whole scene.
//!
//! You give a representative scene, one of these or [your own](Scene), and an error that you allow:
//!
//! | scene | wanted | models, from the cheapest on |
//! |---|---|---|
//! | [`KnownVelocity`] | F along v(t) | static curve, Dahl, one spring¹, the model itself |
//! | [`PatchScene`] | F of a patch along v(t), U(t) | slip curve, relaxation length, the patch |
//! | [`MechanismScene`] | x, v or F of a mass on a spring | static curve, Dahl, the model itself |
//!
//! [`choose`] answers with a [`Choice`], which prints as a table. Every model can be the reference,
//! your own too.
//!
//! ¹ Where you give one: [`KnownVelocity::with_lumped`].
//!
//! # How the search goes
//!
//! 1. The *reference*, the most expensive level, runs over the scene with 1, 2, 4 … steps from one
//!    answer to the next until two runs agree within a tenth of the tolerance, and a third one
//!    with them. The third has an odd number of steps: it meets a force that repeats itself from
//!    step to step of the others.
//! 2. Every other level runs with 1, 2, 4 … steps until it is within the tolerance, settles on
//!    something else, or would cost more than the best run so far.
//! 3. The cheapest run that is within the tolerance is chosen.
//!
//! Every error is measured at every answer; nothing is estimated. A run is accepted if its error
//! and the difference of the last two runs of the reference together are within the tolerance.
//!
//! # When there is no answer
//!
//! A reference that does not settle within the budget is [`FidelityError::Undetermined`], with the
//! difference that is left. Either the scene needs more steps ([`Tolerance::budget`]), or rounding
//! errors grow to the size of the motion: steady sliding on the falling part of a curve is
//! unstable, and roundings decide when a mass that waits there slips.
//!
//! # Cost
//!
//! The unit of cost is one evaluation of FrBD with one spring, about 10 ns: a static curve costs 1,
//! an exact step of Dahl 0.7, of FrBD 1.7 and the force at an answer 0.8 (together 2.5), an exact
//! step of a bristle of several springs 43, a passive step of a mass 3.5.
//!
//! # Physics
//!
//! The last column of the table is [`Trial::physics`], a number for what the level leaves out, from
//! the motion of the reference. Where it is large the level fails. Small, it does not promise that
//! the level is enough: the errors were measured, the numbers explain them.
//!
//! | number | of | formula | small if |
//! |---|---|---|---|
//! | lag | static curve | max \|ż_ss\|/(λ z_b), 2 at a reversal | the bristle has no delay |
//! | lag | slip curve | change of the steady force per transit over its maximum | likewise |
//! | presliding | Dahl | z_b over the longest way in one direction | it slides far |
//! | variation | Dahl of a mass | max \|F_ss(v) / F_ss(0) − 1\| | friction hardly varies with v |
//! | ς/L | relaxation length | relaxation length over length | the patch forgets within a transit |
//! | stuck | reference | share of answers within z_b of a reversal (mass: at rest) | it slides |
//! | adhering | reference of a patch | share of answers with λ L < V | it slides |
//!
//! z_b \[m\]: deflection at breakaway, λ [1/s]: relaxation rate, F_ss \[N\]: steady force,
//! L \[m\]: length of the patch, V [m/s]: its rolling speed.
//!
//! # Limits
//!
//! A choice holds for its scene, at its answers. All runs can miss an event, or agree about an
//! alias of a swing, that no signal declares
//! ([`Signal::next_kink`](bristle::signal::Signal::next_kink),
//! [`Signal::longest_step`](bristle::signal::Signal::longest_step)) and that is shorter than the
//! steps of the reference: at least 8 from one answer to the next and 4096 over the scene, and as
//! many as the declared ones ask for ([`Scene::fewest_steps`]).
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]

extern crate alloc;

mod choose;
mod cost;
mod known_velocity;
mod mechanism;
mod patch;
mod report;
mod scene;

pub use choose::{Tolerance, choose};
pub use known_velocity::{KnownVelocity, lumped_frbd};
pub use mechanism::MechanismScene;
pub use patch::PatchScene;
pub use report::{Choice, FidelityError, Trial, Verdict};
pub use scene::{Answers, Level, Quantity, Run, Scene};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
