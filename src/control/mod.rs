//! Friction compensation in a control loop: the force that is added to an actuator's, sample by
//! sample, so that friction is felt less.
//!
//! A mechanism m v̇ = u − F is given u = u_c + η F̂, with the force F̂ of a friction model:
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | m | mass | kg |
//! | u, u_c, η F̂ | force of the actuator; the parts of controller and compensator | N |
//! | F, F̂ | friction force and its estimate, positive against v > 0 | N |
//! | η | share that is compensated | – |
//! | h | sample time | s |
//! | x, v | measured position and velocity | m, m/s |
//! | q | size of one encoder count | m |
//! | x_ref, e | reference, tracking error e = x − x_ref | m |
//! | K_p, K_d, K_i | gains of a PID controller on e | N/m, N s/m, N/(m s) |
//! | ε = η − 1, δ | over-compensation; relative error by which the model's P σ0 is too large | – |
//! | p, P | normal force; reference load of the [`Contact`](crate::Contact), p if constant | N |
//! | σ0, μ_s | bristle stiffness, static friction coefficient | 1/m, – |
//!
//! # Which one
//!
//! | | [`FeedForwardCompensator`] | [`FeedbackCompensator`] | [`FrictionObserver`] |
//! |---|---|---|---|
//! | its bristle follows | the reference | the encoder | the encoder, corrected by e |
//! | each sample needs | v_ref | x | x and x_ref |
//! | must be known | – | K_p, roughly | m, K_p, K_d, K_i |
//! | take it if | the axis follows closely | μ_s/σ0 ≥ 10 q | e shall correct the model |
//! | controller | any | any | a PID |
//! | not if | the axis sticks, or is pushed aside | (ε + δ) P σ0 > K_p | K_d ≤ α m or K_i ≥ α K_p |
//! | models, of one spring | all | not one that creeps at rest | not elasto-plastic, not implicit |
//!
//! *Feed-forward* measures nothing, so that nothing can hunt through it. It reverses its force with
//! the reference, even if the axis is stuck or still moves the other way.
//!
//! *Feedback* forgets a wrong deflection at the start once the axis has slid a few times |v|/λ:
//! that is g/σ0 for LuGre (at most μ_s/σ0), μ_d/σ0 for Dahl and (μ + σ1|v|)/σ0 for FrBD. In the
//! loop an error of the stiffness is a negative stiffness (ε + δ) P σ0: K_p must outweigh it, so
//! begin with η = 0.9, which leaves room for a model that is a tenth too stiff.
//!
//! *The observer* does the same, and lets e correct the deflection, at a standstill too: it pushes
//! an axis that is stuck behind its reference. It belongs to a PID controller with the feed-forward
//! m a_ref, for which its convergence is proved, with a corner rate α [1/s] that you choose
//! ([`Injection`]). At low sample rates it leaves a smaller error than feedback, at high ones
//! hardly: the page `docs/control-loop.md` compares them, and goes from a datasheet to a running
//! compensator.
//!
//! The modules have each law with its derivation. All three give η F̂ as [`OutputParameters`] say,
//! and answer with a [`Compensation`]; `reload` changes the normal force, `change` all else. The
//! encoder in the last two is a [`VelocityFromPosition`].
//!
//! Every compensator allocates nothing and has a fixed number of operations per sample, with two
//! exceptions: the implicit bristle solves an equation, a tabulated curve is searched. Its bristle
//! takes the exact step of a held velocity, so that it is stable by itself at any sample time. This
//! does not make the *loop* stable: a controller whose gains are too high for its sample time
//! remains unstable.
//!
//! # Refused samples
//!
//! A sample that is not finite, or faster than the mechanism can be, is refused: the last force is
//! given again, and [`Compensation::refused`] counts such samples in a row. The bristle stays where
//! it is, and the next good position or displacement covers the missed ones. Only the filters'
//! clocks run on.
//!
//! If only the reference is bad, the observer's bristle still follows the measured displacement.
//!
//! # Why not a sign
//!
//! Static compensation, η p μ(v) sgn v, is the baseline of the literature and takes one line:
//! `share * normal_force * curve.at(v) * v.signum()`. Around zero velocity friction is no function
//! of the velocity: a stuck contact carries any force up to breakaway. A sign switches the whole
//! friction with the noise or, with a dead band, gives nothing while the mechanism sticks.
//!

//! Sources: C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky, "A new model for control of
//! systems with friction", IEEE Transactions on Automatic Control 40 (1995), 419–425, for the
//! observer of LuGre; B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, "A survey of models,
//! analysis tools and compensation methods for the control of machines with friction", Automatica
//! 30 (1994), 1083–1138, for static compensation and its faults.

pub mod feed_forward;
pub mod feedback;
pub mod observer;
mod output;
pub mod velocity_from_position;

#[doc(inline)]
pub use feed_forward::{FeedForwardCompensator, FeedForwardParameters};
#[doc(inline)]
pub use feedback::{FeedbackCompensator, FeedbackParameters, MicroDamping};
#[doc(inline)]
pub use observer::{FrictionObserver, Injection, Measured, ObserverParameters};
#[doc(inline)]
pub use output::{Compensation, OutputParameters};
#[doc(inline)]
pub use velocity_from_position::{
    MotionSample, VelocityFromPosition, VelocityFromPositionParameters,
};
