//! The paper's parameter sets, from its tables and the text beside them.
//!
//! Source: Romano et al. (arXiv 2602.09429). Units follow this crate (the paper prints the
//! spring's stiffness in N, the pressure gain in Pa and no unit for the valve's damping).
//!
//! ```
//! use bristle::{Bristle, FrBd, Law, LuGre, paper};
//! use bristle::curve::Stribeck;
//! use bristle::rheology::KelvinVoigt;
//!
//! let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
//! let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
//! assert!(FrBd::new(curve, bristle).obeys(Law::Passivity));
//! assert!(!LuGre::classical(curve, bristle).obeys(Law::Passivity));
//! # Ok::<(), bristle::ParameterError>(())
//! ```

use crate::curve::StribeckParameters;
use crate::rheology::KelvinVoigtParameters;
use crate::scene::{DiaphragmValveParameters, MassSpringDamperParameters};
use crate::{Contact, Mechanism};

/// Table 2: the friction curve of the pre-sliding, lag and stick-slip experiments (section V-A):
/// μ_s = 1.5, μ_d = 1, v_S = 0.01 m/s, δ = 2, σ2 = 0.04 s/m.
pub const STICK_SLIP_CURVE: StribeckParameters<f64> = StribeckParameters {
    static_coefficient: 1.5,
    dynamic_coefficient: 1.0,
    stribeck_velocity: 0.01,
    stribeck_exponent: 2.0,
    viscous_friction: 0.04,
};

/// Table 2: the bristle of the same experiments: σ0 = 1e4 1/m, σ1 = 64.5 s/m.
pub const STICK_SLIP_BRISTLE: KelvinVoigtParameters<f64> =
    KelvinVoigtParameters { micro_stiffness: 1e4, micro_damping: 64.5 };

/// The stick-slip rig of section V-A: m = 1 kg on a spring of k = 2 N/m, pulled at v_ref = 0.1 m/s.
pub fn stick_slip_rig<M>(contact: Contact<f64, M>) -> MassSpringDamperParameters<f64, M> {
    MassSpringDamperParameters {
        contact,
        mechanism: Mechanism { mass: 1.0, spring_stiffness: 2.0, viscous_damping: 0.0 },
        drive_velocity: 0.1,
        force: 0.0,
    }
}

/// Table 3: the friction curve of the diaphragm valve's packing (section V-B), for a normal force
/// of 1 N: the coefficients are forces in newtons. μ_s = 59.86, μ_d = 39.73, v_S = 6.42 mm/s,
/// δ = 2, σ2 = 2970 s/m.
pub const VALVE_CURVE: StribeckParameters<f64> = StribeckParameters {
    static_coefficient: 59.86,
    dynamic_coefficient: 39.73,
    stribeck_velocity: 6.42e-3,
    stribeck_exponent: 2.0,
    viscous_friction: 2.97e3,
};

/// Table 3: the bristle of the diaphragm valve's packing: σ0 = 6.82e7 1/m, σ1 = 701.97 s/m.
pub const VALVE_BRISTLE: KelvinVoigtParameters<f64> =
    KelvinVoigtParameters { micro_stiffness: 6.82e7, micro_damping: 701.97 };

/// Table 3: the diaphragm valve, with an I/P converter of time constant τ \[s\] (0.933 s in Test 1,
/// 0.425 s in Test 2) and the opening OP(t) \[%\] asked for: m = 1.6 kg, k = 203 495.8 N/m, area
/// 445 cm², preload 2578.3 N, least pressure 41 276.4 Pa, gain 1666.49 Pa/%.
pub fn valve<M, U>(
    contact: Contact<f64, M>,
    time_constant: f64,
    opening: U,
) -> DiaphragmValveParameters<f64, M, U> {
    DiaphragmValveParameters {
        contact,
        mechanism: Mechanism { mass: 1.6, spring_stiffness: 203_495.8, viscous_damping: 0.0 },
        diaphragm_area: 445e-4,
        preload: 2578.3,
        least_pressure: 41_276.40,
        pressure_gain: 1666.49,
        time_constant,
        opening,
    }
}

/// Table 1: the friction curve of the tyre (section IV-A): μ_s = 0.6, μ_d = 0.2, v_S = 10 m/s,
/// δ = 2, σ2 = 0.0018 s/m.
pub const TYRE_CURVE: StribeckParameters<f64> = StribeckParameters {
    static_coefficient: 0.6,
    dynamic_coefficient: 0.2,
    stribeck_velocity: 10.0,
    stribeck_exponent: 2.0,
    viscous_friction: 0.0018,
};

/// Table 1: the bristle of the tyre: σ0 = 252 1/m, σ1 = 0.
pub const TYRE_BRISTLE: KelvinVoigtParameters<f64> =
    KelvinVoigtParameters { micro_stiffness: 252.0, micro_damping: 0.0 };
