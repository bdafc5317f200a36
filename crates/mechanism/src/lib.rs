//! Many friction contacts in one linear mechanism, stepped without creating energy by one linear
//! solve a step.
//!
//! M v̇ + C v + K x + Wᵀ F = f,  s = W v + w
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x, v | coordinates and their velocities | m, m/s |
//! | M | mass matrix, M = Mᵀ > 0 | kg |
//! | C, K | damping and stiffness matrices, C = Cᵀ ≥ 0, K = Kᵀ ≥ 0 | N s/m, N/m |
//! | f | applied force of each coordinate | N |
//! | s, w | sliding velocity of each contact, and its prescribed part: a belt | m/s |
//! | W | by which factor each coordinate moves each contact | – |
//! | F | friction force of each contact, positive against s > 0 | N |
//! | A, B, G | M + (h/2)C + (h²/4)K, A⁻¹Wᵀ, (h/2)W B | kg, 1/kg, s/kg |
//!
//! Angles and torques serve as well. [`LinearMechanism`] holds the matrices, [`Chain`] makes them
//! for blocks in a row, and [`ContactState`] is what a contact keeps from step to step. [`Arm`] has
//! masses that depend on where it is, [`ElasticJoint`] a shaft with backlash; each can be stepped,
//! or solved for by its [`EquationsOfMotion`]. [`gradient`] has the derivatives of a loss by
//! friction parameters.
//!
//! # A step
//!
//! Every contact hands out its [companion](bristle::companion): with the coefficients frozen at the
//! predicted s\*, its mean force is F̄ = β + δ s̄, δ ≥ 0. The step of length h is the trapezoidal
//! rule, v̄ = (v₀ + v₁)/2. With the mean acceleration a = (v₁ − v₀)/h and D = diag δ,
//!
//! (A + (h/2) Wᵀ D W) a = f̄ − K (x₀ + (h/2) v₀) − C v₀ − Wᵀ (β + D s₀),
//!
//! one linear system, no iteration. The structure chooses how it is solved:
//!
//! - dense, or diagonal in modes: A is factored when h changes. The contacts are coupled through G
//!   alone: (I + G D) s̄ = s₀ + (h/2) W A⁻¹ r − G β, a system of the size of the contacts, with
//!   r = f̄ − K (x₀ + (h/2) v₀) − C v₀, then a = A⁻¹ r − B F̄;
//! - banded: the system itself is factored in each step, at a cost that grows with the number of
//!   coordinates only.
//!
//! # Energy
//!
//! With E = ½ vᵀ M v + ½ xᵀ K x,
//!
//! E₁ − E₀ = h f̄·v̄ − h v̄ᵀ C v̄ − Σ h F̄ₖ (s̄ₖ − w̄ₖ),  h F̄ₖ s̄ₖ ≥ W₁ₖ − W₀ₖ,
//!
//! for every h, every prediction and every number of contacts; the second for models whose
//! [companion step is passive](bristle::companion::CompanionStep::is_passive). With matrices that
//! [change](LinearMechanism::change) from step to step, as M(q) of an [`Arm`], the second stays,
//! and the total closes to O(h²). Passive is not accurate; the order is two.
//!
//! Source: the companion form of Romano et al. (arXiv 2602.09429), see [`bristle::companion`]; the
//! reduction to the contacts is the Woodbury identity.
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![allow(private_bounds, reason = "equations of motion are those of this crate's mechanisms")]

#[cfg(feature = "alloc")]
extern crate alloc;

mod arm;
mod band;
mod chain;
mod contacts;
mod elastic_joint;
#[cfg(feature = "alloc")]
mod equations;
pub mod gradient;
mod mechanism;
mod rows;
mod step;

pub use arm::{Arm, ArmMiddle, ArmMotion, ArmParameters, Link, on_joint};
pub use chain::{Block, Chain, Coupling, on_ground, to_next};
pub use contacts::{ContactState, Inputs};
pub use elastic_joint::{ElasticJoint, ElasticJointMotion, ElasticJointParameters, ShaftStep};
#[cfg(feature = "alloc")]
pub use equations::{Acting, EquationsOfMotion};
pub use mechanism::{LinearMechanism, Matrices, Storage, Structure};
pub use rows::Rows;
pub use step::{Motion, Sources};

/// The programs on this page are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
#[doc = include_str!("../docs/gradients.md")]
struct Pages;
