//! Adaptive friction compensation: what is linear in a friction model, estimated while it runs.
//!
//! Wear, temperature and load change the level of friction, hardly its shape. The level of the
//! bristle, its share of the load, drag and an offset enter the balance of forces linearly, so that
//! recursive least squares follow them in a control loop.
//!
//! | what | where |
//! |---|---|
//! | friction of an axis from displacements and forces | [`AdaptiveFriction`] |
//! | the estimator by itself, for any linear model | [`RecursiveLeastSquares`] |
//!
//! The steps allocate nothing, do not panic, and have a fixed number of operations, except where
//! the model's own step has not.
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]

mod friction;
mod least_squares;

pub use friction::{
    Adapted, AdaptiveFriction, AdaptiveFrictionParameters, FrictionEstimate, Sample, SampleUse,
};
pub use least_squares::{RecursiveLeastSquares, RecursiveLeastSquaresParameters};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
