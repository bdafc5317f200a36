//! Geared joints: friction that grows with the torques through the gear ([`GearFriction`]), motors
//! and controllers that drive it, and the joint to simulate ([`GearedJoint`]).
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(feature = "alloc")]
extern crate alloc;

mod audit;
#[cfg(feature = "serde")]
mod file;
mod gear;
mod geared_joint;
mod input;

pub use audit::GearAudit;
pub use gear::{
    GearFriction, GearFrictionParameters, GearStep, GearTorques, LoadLaw, LoadedDeflection,
    TorqueLoad, TorqueLoadParameters,
};
pub use geared_joint::{GearedJoint, GearedJointParameters, JointState, JointTorques};
pub use input::{
    CurrentMotor, CurrentMotorParameters, Gravity, JointInput, JointInputValue, JointMotion,
    PositionControl, VoltageMotor, VoltageMotorParameters,
};

/// The programs on these pages are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
#[doc = include_str!("../docs/joint.md")]
struct Pages;
