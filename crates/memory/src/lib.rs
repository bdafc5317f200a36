//! Friction with memory: elements side by side on one velocity, each with a yield length of its
//! own.
//!
//! A bristle with one deflection forgets a loop within a loop. In slow motion FrBD and LuGre are
//! Dahl's model: a minor loop does not close, and small cycles let go of what the contact carries.
//! Elements that yield one after the other remember where each reversal was.
//!
//! | what | where |
//! |---|---|
//! | the model | [`MaxwellSlip`], a [`Bristle`](bristle::Bristle) with a vector deflection |
//! | its elements from a first loading | [`virgin::bends`], [`virgin::fit`] |
//! | its elements from a record of loops | [`record::fit`] |
//! | elements with a sharp yield, one step | [`MaxwellSlip::sharp_step`] |
//! | a stiffness that follows the load | [`MaxwellSlip::following_load`] |
//!
//! # Beside the elasto-plastic LuGre model as published
//!
//! Dupont and others have one deflection, ż = v (1 − α(z, v) z/z_ss(v)), F/p = σ0 z + σ1 ż + σ2 v.
//! Its stick limit z_ba is one constant length. Here the elements are elasto-plastic FrBD: there
//! are several of them, the damping enters by (μ/g)(σ0 z + σ1 v), so that each is passive for every
//! α, and the stick limit is a share ρ of the yield length at the present speed. A constant z_ba
//! would have to stay below the least μ/σ0 of the curve.
//!
//! Sources: W. D. Iwan, "A distributed-element model for hysteresis and its steady-state dynamic
//! response", Journal of Applied Mechanics 33 (1966), 893–900; F. Al-Bender, V. Lampaert,
//! J. Swevers, "The generalized Maxwell-slip model: a novel model for friction simulation and
//! compensation", IEEE Transactions on Automatic Control 50 (2005), 1883–1887; P. Dupont,
//! V. Hayward, B. Armstrong, F. Altpeter, "Single state elastoplastic friction models", IEEE
//! Transactions on Automatic Control 47 (2002), 787–792.
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]

mod maxwell_slip;
mod non_negative;
mod parallel;
pub mod record;
pub mod virgin;

pub use maxwell_slip::{Element, LoadedStiffness, MaxwellSlip, MaxwellSlipParameters, SharpStep};
pub use parallel::{Parallel, ParallelWeights};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
