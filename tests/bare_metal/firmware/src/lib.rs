//! All that a real-time loop calls of bristle, as functions for C: `no_panic.rs` builds this
//! archive and follows every call from them.
//!
//! Everything is known at run time only, so that the compiler cannot work anything out beforehand.
//! A panic would end in a function that exists nowhere; the probes at the end do panic and
//! allocate, to show that it is seen.
#![no_std]
// Names that C can call.
#![allow(unsafe_code, reason = "exporting a name is `unsafe`; nothing else here is")]

extern crate alloc;

mod control;
mod many;
mod plane;
mod probes;
mod rolling;
mod steps;

use bristle::{ParameterError, Scalar};
use bristle_batch::BatchError;
use nalgebra::RealField;

unsafe extern "C" {
    /// Defined nowhere.
    fn bristle_firmware_panicked() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    // SAFETY: never linked.
    unsafe { bristle_firmware_panicked() }
}

/// Every number of an entry: parameters, state and input.
#[repr(C)]
pub struct Input<T> {
    pub static_coefficient: T,
    pub dynamic_coefficient: T,
    pub stribeck_velocity: T,
    pub stribeck_exponent: T,
    pub viscous_friction: T,
    /// Speed and coefficient of each.
    pub knots: [[T; 2]; 8],
    pub micro_stiffness: T,
    pub micro_damping: T,
    pub stick_limit: T,
    /// Stiffness and damping of each.
    pub elements: [[T; 2]; 5],
    pub threshold_velocity: T,
    pub normal_force: T,
    pub fastest: T,
    pub velocity: T,
    pub next_velocity: T,
    pub deflections: [T; 5],
    pub duration: T,
    pub rolling: [T; 4],
    /// Mass of a free body, and of the one under control.
    pub mass: T,
    pub end_weight: T,
    /// Share and largest force of a compensator.
    pub output: [T; 2],
    /// Of a velocity's filter.
    pub time_constant: T,
    /// K_p, K_d, K_i; gain and corner of an observer.
    pub gains: [T; 5],
    /// Samples, or inputs of many bristles.
    pub many: [[T; MANY]; 4],
    /// Parameters of many bristles.
    pub columns: [[T; MANY]; 6],
    /// How many bristles there are.
    pub count: usize,
}

/// More than a batch's block, and not a multiple of one.
const MANY: usize = 40;

/// A number out of what was refused.
trait Refusal {
    fn value(&self) -> f64;
}

impl Refusal for ParameterError {
    fn value(&self) -> f64 {
        self.value
    }
}

impl Refusal for BatchError {
    fn value(&self) -> f64 {
        match self {
            Self::Parameter(error) => error.value,
            Self::Length { length, .. } => *length as f64,
            _ => 0.0,
        }
    }
}

/// An answer that hangs on all results, or on the value that was refused.
fn answer<T: Scalar, E: Refusal>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| nalgebra::convert(error.value()))
}

macro_rules! entries {
    ($($function:path => $single:ident, $double:ident;)*) => {$(
        #[unsafe(no_mangle)]
        pub extern "C" fn $single(input: &Input<f32>) -> f32 {
            answer($function(input))
        }

        #[unsafe(no_mangle)]
        pub extern "C" fn $double(input: &Input<f64>) -> f64 {
            answer($function(input))
        }
    )*};
}

entries! {
    steps::frbd_stribeck => entry_frbd_stribeck_f32, entry_frbd_stribeck_f64;
    steps::frbd_rational => entry_frbd_rational_f32, entry_frbd_rational_f64;
    steps::frbd_tabulated => entry_frbd_tabulated_f32, entry_frbd_tabulated_f64;
    steps::frbd_coulomb => entry_frbd_coulomb_f32, entry_frbd_coulomb_f64;
    steps::frbd_asymmetric => entry_frbd_asymmetric_f32, entry_frbd_asymmetric_f64;
    steps::frbd_function => entry_frbd_function_f32, entry_frbd_function_f64;
    steps::frbd_spring => entry_frbd_spring_f32, entry_frbd_spring_f64;
    steps::frbd_square_root => entry_frbd_square_root_f32, entry_frbd_square_root_f64;
    steps::frbd_tanh => entry_frbd_tanh_f32, entry_frbd_tanh_f64;
    steps::frbd_maxwell => entry_frbd_maxwell_f32, entry_frbd_maxwell_f64;
    steps::frbd_zener => entry_frbd_zener_f32, entry_frbd_zener_f64;
    steps::frbd_maxwell_arms => entry_frbd_maxwell_arms_f32, entry_frbd_maxwell_arms_f64;
    steps::lugre => entry_lugre_f32, entry_lugre_f64;
    steps::lugre_inside => entry_lugre_inside_f32, entry_lugre_inside_f64;
    steps::dahl => entry_dahl_f32, entry_dahl_f64;
    steps::elasto_plastic => entry_elasto_plastic_f32, entry_elasto_plastic_f64;
    steps::implicit => entry_implicit_f32, entry_implicit_f64;
    control::secant => entry_control_secant_f32, entry_control_secant_f64;
    control::feed_forward => entry_control_feed_forward_f32, entry_control_feed_forward_f64;
    control::feedback => entry_control_feedback_f32, entry_control_feedback_f64;
    control::observer => entry_control_observer_f32, entry_control_observer_f64;
    control::lugre => entry_control_lugre_f32, entry_control_lugre_f64;
    control::dahl => entry_control_dahl_f32, entry_control_dahl_f64;
    control::elasto_plastic => entry_control_elasto_plastic_f32, entry_control_elasto_plastic_f64;
    control::implicit => entry_control_implicit_f32, entry_control_implicit_f64;
    control::adaptation => entry_control_adaptation_f32, entry_control_adaptation_f64;
    many::stribeck_curve => entry_many_stribeck_f32, entry_many_stribeck_f64;
    many::rational => entry_many_rational_f32, entry_many_rational_f64;
    many::spring => entry_many_spring_f32, entry_many_spring_f64;
    many::dahl => entry_many_dahl_f32, entry_many_dahl_f64;
    many::each => entry_many_each_f32, entry_many_each_f64;
    plane::frbd => entry_plane_frbd_f32, entry_plane_frbd_f64;
    plane::spin => entry_plane_spin_f32, entry_plane_spin_f64;
    plane::lugre => entry_plane_lugre_f32, entry_plane_lugre_f64;
    plane::footprint => entry_plane_footprint_f32, entry_plane_footprint_f64;
    rolling::step => entry_rolling_step_f32, entry_rolling_step_f64;
    rolling::passive => entry_rolling_passive_f32, entry_rolling_passive_f64;
}

/// A literal.
fn lit<T: RealField>(value: f64) -> T {
    nalgebra::convert(value)
}
