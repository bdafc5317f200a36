//! Parameters of other tools, where taking them over is more than a change of name.
//!
//! | from | to |
//! |---|---|
//! | Simscape *Rotational* and *Translational Friction* | [`SimscapeFriction`] → [`Stribeck`] |
//! | Drake `CoulombFriction` and stiction tolerance | [`DrakeFriction`] → [`Stribeck`] |
//! | MuJoCo `frictionloss`, `damping`, `solref` … | [`MujocoFriction`] → [`Coulomb`], [`Maxwell`] |
//! | MuJoCo `dcmotor lugre` | [`MujocoDcMotor`] ↔ [`Stribeck`], [`KelvinVoigt`] |
//! | Modelica `BearingFriction` (`tau_pos`, `peak`) | `bearing_friction` → [`Tabulated`] |
//! | Modelica `LossyGear` (`lossTable`) | [`LossyGear`] ↔ [`TorqueLoad`] |
//! | a datasheet without a bristle | [`Presliding`] → [`KelvinVoigt`] |
//!
//! Where a tool gives the friction as a force \[N\] or a torque \[N m\], the coefficients here are
//! that force or torque: put the model under a load of 1.
//!
//! But for LuGre blocks and MuJoCo's `dcmotor` these tools have no bristle. They let friction grow
//! from zero with the velocity, over a small velocity that is chosen for the solver: a stuck body
//! creeps. Here the bristle sticks, and a curve begins at the static friction. A bristle is needed
//! beside the curve: [`Presliding`].
//!
//! Changes of name are in `docs/coming-from.md`.
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(feature = "alloc")]
extern crate alloc;

#[cfg(feature = "alloc")]
use alloc::vec::Vec;

use bristle::curve::{Coulomb, CoulombParameters, Stribeck, StribeckParameters};
#[cfg(feature = "alloc")]
use bristle::curve::{Cubic, Knot, Tabulated};
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters, Maxwell, MaxwellParameters};
use bristle::scalar::lit;
use bristle::{Bristle, Scalar};
use bristle_joint::{GearFriction, TorqueLoad, TorqueLoadParameters};

/// Friction of Simscape's blocks *Rotational Friction* and *Translational Friction*.
///
/// T = √(2e) (T_brk − T_C) e^(−(ω/ω_St)²) ω/ω_St + T_C tanh(ω/ω_Coul) + f ω,
///
/// ω_St = √2 ω_brk,  ω_Coul = ω_brk/10
///
/// Its sum of Stribeck and Coulomb part has its peak T_brk at the breakaway velocity ω_brk, which
/// is not the Stribeck velocity: at 2.16 ω_brk most of the fall is over.
///
/// ```
/// use bristle_convert::SimscapeFriction;
/// use bristle::curve::FrictionCurve;
///
/// let block = SimscapeFriction { // its defaults
///     breakaway_friction: 25.0, // N m
///     coulomb_friction: 20.0,
///     breakaway_velocity: 0.1, // rad/s
///     viscous_coefficient: 0.001, // N m s/rad
/// };
/// let curve = block.curve()?; // under a load of 1
/// assert_eq!(curve.at(0.0), 25.0);
/// assert!((curve.at(1.0) - 20.001_f64).abs() < 1e-6);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// Source: MathWorks, Simscape reference, pages *Rotational Friction* and *Translational
/// Friction*.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct SimscapeFriction<T> {
    /// Breakaway friction T_brk [N m or N], at least the Coulomb friction.
    pub breakaway_friction: T,
    /// Coulomb friction T_C [N m or N], positive.
    pub coulomb_friction: T,
    /// Breakaway friction velocity ω_brk [rad/s or m/s], positive.
    pub breakaway_velocity: T,
    /// Viscous friction coefficient f [N m s/rad or N s/m], zero or positive.
    pub viscous_coefficient: T,
}

impl<T: Scalar> SimscapeFriction<T> {
    /// The curve, for a load of 1: T_brk at rest, T_C + f ω far beyond ω_brk, and between them
    /// within 4.5 % of T_brk − T_C of the block's at every speed from ω_brk on.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range.
    pub fn curve(&self) -> Checked<Stribeck<T>> {
        let coulomb = Named("coulomb_friction", self.coulomb_friction).positive()?;
        let most = Named("breakaway_friction", self.breakaway_friction);
        most.finite().and(most.at_least("coulomb_friction", coulomb))?;
        Named("breakaway_velocity", self.breakaway_velocity).positive()?;
        Named("viscous_coefficient", self.viscous_coefficient).non_negative()?;
        // With u = ω/ω_brk the fall is u e^((1 − u²)/2) from u = 1 on, and 1 below. Of all
        // e^(−(u/a)^δ) this one has the least largest error, 0.0448 (a search over a and δ).
        Stribeck::new(StribeckParameters {
            static_coefficient: self.breakaway_friction,
            dynamic_coefficient: coulomb,
            stribeck_velocity: self.breakaway_velocity * lit(2.157),
            stribeck_exponent: lit(4.285),
            viscous_friction: self.viscous_coefficient,
        })
    }
}

/// Friction of a pair of surfaces in Drake: `CoulombFriction`, and the plant's stiction tolerance.
///
/// Drake's continuous model has the coefficient μ_s S(x) for x < 1, μ_s − (μ_s − μ_d) S((x − 1)/2)
/// for 1 ≤ x < 3, and μ_d beyond, with x = v/v_s, the stiction tolerance v_s and
/// S(x) = x³ (10 − 15 x + 6 x²). Its discrete solvers do not use μ_s.
///
/// ```
/// use bristle_convert::DrakeFriction;
/// use bristle::curve::FrictionCurve;
///
/// let steel = DrakeFriction {
///     static_friction: 0.8,
///     dynamic_friction: 0.6,
///     stiction_tolerance: 1e-3, // m/s
/// };
/// let rubber = DrakeFriction { static_friction: 1.2, dynamic_friction: 1.0, ..steel };
/// let curve = steel.against(rubber).curve()?;
/// assert_eq!(curve.at(0.0), 2.0 * 0.8 * 1.2 / (0.8 + 1.2));
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// Source: Drake, `multibody/plant/multibody_plant.h`, section on Coulomb's law and its continuous
/// approximation, and `coulomb_friction.h`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct DrakeFriction<T> {
    /// Static friction coefficient μ_s \[–\], at least the dynamic one.
    pub static_friction: T,
    /// Dynamic friction coefficient μ_d \[–\], positive.
    pub dynamic_friction: T,
    /// Stiction tolerance v_s [m/s], positive.
    ///
    /// It is a number of the solver, not of the surface. If you know the Stribeck velocity of the
    /// surface, take [`Stribeck`] with it instead.
    pub stiction_tolerance: T,
}

impl<T: Scalar> DrakeFriction<T> {
    /// This surface against another: the coefficients are 2 μ₁ μ₂/(μ₁ + μ₂), the stiction tolerance
    /// is that of this one.
    #[must_use]
    pub fn against(self, other: Self) -> Self {
        let pair = |a: T, b: T| lit::<T>(2.0) * a * b / (a + b);
        Self {
            static_friction: pair(self.static_friction, other.static_friction),
            dynamic_friction: pair(self.dynamic_friction, other.dynamic_friction),
            ..self
        }
    }

    /// The curve: μ_s at rest, μ_d from three stiction tolerances on, and between them within 2.5 %
    /// of μ_s − μ_d of Drake's at every speed from v_s on.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range.
    pub fn curve(&self) -> Checked<Stribeck<T>> {
        let dynamic = Named("dynamic_friction", self.dynamic_friction).positive()?;
        let most = Named("static_friction", self.static_friction);
        most.finite().and(most.at_least("dynamic_friction", dynamic))?;
        Named("stiction_tolerance", self.stiction_tolerance).positive()?;
        // Of all e^(−(x/a)^δ) this one has the least largest error, 0.0241 (a search over a and δ).
        Stribeck::new(StribeckParameters {
            static_coefficient: self.static_friction,
            dynamic_coefficient: dynamic,
            stribeck_velocity: self.stiction_tolerance * lit(2.15),
            stribeck_exponent: lit(5.894),
            viscous_friction: T::zero(),
        })
    }
}

/// Friction of a degree of freedom in MuJoCo: `frictionloss` and `damping` of a joint or a tendon.
///
/// MuJoCo's friction is a constraint without stiffness, a₁ + d b v = (1 − d) a₀: under a force
/// below f the body creeps as if a damper c = d b M/(1 − d) held it, with d = dmin and
/// b = 2/(dmax timeconst) from `solimp` and `solref`. A [`Maxwell`] bristle creeps, too. Real
/// friction hardly does: if the creep is not wanted, take [`Presliding`].
///
/// ```
/// use bristle_convert::MujocoFriction;
/// use bristle::{Bristle, FrBd};
///
/// let joint = MujocoFriction {
///     friction_loss: 0.5, // N m
///     damping: 0.02,      // N m s/rad
///     inertia: 0.01,      // kg m², with armature
///     solref: [0.02, 1.0], // the defaults
///     solimp: [0.9, 0.95],
/// };
/// let friction = FrBd::new(joint.curve()?, joint.bristle()?).under_load(1.0)?;
/// // Under a hundredth of the friction loss it creeps as in MuJoCo, within one per cent.
/// let creep = 0.005 * (1.0 - 0.9) / 0.9 * (0.95 * 0.02 / 2.0) / 0.01; // rad/s
/// assert!((friction.stationary_force(creep) / 0.005_f64 - 1.0).abs() < 0.011);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// For a contact, `friction_loss` is the sliding coefficient times the normal force, and `inertia`
/// the mass of the body.
///
/// Source: MuJoCo documentation, *Computation*, "Constraint model", and *Modeling*, "Solver
/// parameters"; `engine_core_constraint.c` for b and for the stiffness of friction, which is zero.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct MujocoFriction<T> {
    /// Friction loss f [N m or N], positive.
    pub friction_loss: T,
    /// Viscous damping of the joint [N m s/rad or N s/m], zero or positive.
    pub damping: T,
    /// Inertia M [kg m² or kg] that the friction brakes, with the armature; positive.
    pub inertia: T,
    /// `solreffriction`: (timeconst, dampratio) \[s, –\], or both negative, (−stiffness, −damping).
    pub solref: [T; 2],
    /// The first two numbers of `solimpfriction`, (dmin, dmax), clamped to 0.0001 … 0.9999.
    pub solimp: [T; 2],
}

impl<T: Scalar> MujocoFriction<T> {
    /// f and the damping, for a load of 1.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range.
    pub fn curve(&self) -> Checked<Coulomb<T>> {
        Coulomb::new(CoulombParameters {
            dynamic_coefficient: Named("friction_loss", self.friction_loss).positive()?,
            viscous_friction: Named("damping", self.damping).non_negative()?,
        })
    }

    /// The damper c = d b M/(1 − d) [N m s/rad or N s/m] as which a stuck body creeps in MuJoCo.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range.
    pub fn creep_damping(&self) -> Checked<T> {
        let inertia = Named("inertia", self.inertia).positive()?;
        ParameterError::of_components(self.solimp, |d| Named("solimp", d).between(0.0, 1.0))?;
        let [least, most] = self.solimp.map(|d| d.clamp(lit(1e-4), lit(0.9999)));
        let [time, damping] = self.solref;
        let rate = if damping > T::zero() {
            let time = ParameterError::of_component(0, Named("solref", time).positive())?;
            lit::<T>(2.0) / (most * time)
        } else {
            -ParameterError::of_component(1, Named("solref", damping).finite())? / most
        };
        Named("creep_damping", least * rate * inertia / (T::one() - least)).positive()
    }

    /// A bristle that creeps like MuJoCo's friction under forces far below f, for a load of 1. At
    /// half of f it creeps twice as fast.
    ///
    /// MuJoCo has no spring. This one, 4 c²/M, is the softest on which the stuck body does not
    /// oscillate.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range.
    pub fn bristle(&self) -> Checked<Maxwell<T>> {
        let series_damping = self.creep_damping()?;
        let micro_stiffness = lit::<T>(4.0) * series_damping * series_damping / self.inertia;
        Maxwell::new(MaxwellParameters { micro_stiffness, series_damping })
    }
}

/// LuGre friction of MuJoCo's actuator `dcmotor`, since 3.7:
/// `lugre="stiffness damping coulomb static stribeck"`.
///
/// ż = ω − σ0 |ω| z/g(ω),  τ = σ0 z + σ1 ż + d ω,  g = τ_c + (τ_s − τ_c) e^(−(ω/ω_s)²)
///
/// That is `LuGre::classical(curve, bristle)` under a load of 1. With the same curve and bristle
/// [`FrBd`](bristle::FrBd) is passive, and moves alike where σ1 |ω| is small beside g.
///
/// ```
/// use bristle_convert::MujocoDcMotor;
/// use bristle::{Bristle, LuGre};
///
/// let motor = MujocoDcMotor {
///     stiffness: 1e4,        // N m/rad
///     damping: 10.0,         // N m s/rad
///     coulomb_friction: 1.0, // N m
///     static_friction: 1.5,  // N m
///     stribeck_velocity: 0.1, // rad/s
///     viscous_damping: 0.3,  // N m s/rad, the actuator's `damping`
/// };
/// let friction = LuGre::classical(motor.curve()?, motor.bristle()?).under_load(1.0)?;
/// // What MuJoCo 4.0.0 gives at 0.05 rad/s.
/// assert!((friction.stationary_force(0.05) - (1.389400391536 + 0.015_f64)).abs() < 1e-11);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// Source: MuJoCo documentation, *XML reference*, `actuator/dcmotor/lugre`. The exponent two, and
/// that the damping is outside g, by runs of MuJoCo 4.0.0 at held velocities.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct MujocoDcMotor<T> {
    /// Bristle stiffness σ0 [N m/rad or N/m], positive. (With zero MuJoCo has no LuGre friction.)
    pub stiffness: T,
    /// Bristle damping σ1 [N m s/rad or N s/m], zero or positive.
    pub damping: T,
    /// Coulomb friction τ_c [N m or N], positive.
    pub coulomb_friction: T,
    /// Static friction τ_s [N m or N], at least the Coulomb friction.
    pub static_friction: T,
    /// Stribeck velocity ω_s [rad/s or m/s], positive.
    pub stribeck_velocity: T,
    /// Damping d of the actuator [N m s/rad or N s/m], its own attribute; zero or positive.
    pub viscous_damping: T,
}

impl<T: Scalar> MujocoDcMotor<T> {
    /// The curve, viscous damping included, for a load of 1.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range.
    pub fn curve(&self) -> Checked<Stribeck<T>> {
        let coulomb = Named("coulomb_friction", self.coulomb_friction).positive()?;
        let most = Named("static_friction", self.static_friction);
        Stribeck::new(StribeckParameters {
            static_coefficient: most.finite().and(most.at_least("coulomb_friction", coulomb))?,
            dynamic_coefficient: coulomb,
            stribeck_velocity: Named("stribeck_velocity", self.stribeck_velocity).positive()?,
            stribeck_exponent: lit(2.0),
            viscous_friction: Named("viscous_damping", self.viscous_damping).non_negative()?,
        })
    }

    /// The bristle, for a load of 1.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range.
    pub fn bristle(&self) -> Checked<KelvinVoigt<T>> {
        KelvinVoigt::new(KelvinVoigtParameters {
            micro_stiffness: Named("stiffness", self.stiffness).positive()?,
            micro_damping: Named("damping", self.damping).non_negative()?,
        })
    }

    /// The motor of a curve and a bristle under a load \[N m or N\].
    ///
    /// # Errors
    ///
    /// Refuses a Stribeck exponent other than two, and a load that is not positive.
    pub fn of(curve: &Stribeck<T>, bristle: &KelvinVoigt<T>, load: T) -> Checked<Self> {
        let (curve, bristle) = (curve.parameters(), bristle.parameters());
        Named("stribeck_exponent", curve.stribeck_exponent).exactly(lit(2.0))?;
        let load = Named("load", load).positive()?;
        Ok(Self {
            stiffness: load * bristle.micro_stiffness,
            damping: load * bristle.micro_damping,
            coulomb_friction: load * curve.dynamic_coefficient,
            static_friction: load * curve.static_coefficient,
            stribeck_velocity: curve.stribeck_velocity,
            viscous_damping: load * curve.viscous_friction,
        })
    }

    /// The five numbers of the attribute `lugre`.
    pub fn lugre(&self) -> [T; 5] {
        let Self { stiffness, damping, coulomb_friction, static_friction, .. } = *self;
        [stiffness, damping, coulomb_friction, static_friction, self.stribeck_velocity]
    }
}

/// The curve of the table `tau_pos` of Modelica's `BearingFriction`, rows of speed and torque, for
/// a load of 1. `f_pos` of `SupportFriction` and `mue_pos` of `Clutch` and `Brake` are read alike.
///
/// There the friction at rest is `peak` times that of the first row, and drops to it at the first
/// motion. Here it drops within `fall_speed` [rad/s or m/s], which lies below the second row. From
/// there on the curve is the table's, linear between rows and beyond the last; only a falling one
/// goes on level. Its corners are rounded, because the curve has a slope everywhere: within a 256th
/// of the way to the next row, and by at most 0.12 % of the difference of the two torques.
///
/// ```
/// use bristle_convert::bearing_friction;
/// use bristle::curve::FrictionCurve;
///
/// let curve = bearing_friction(&[[0.0, 2.0], [10.0, 2.0], [100.0, 5.0]], 1.1, 0.01)?;
/// assert_eq!((curve.at(0.0), curve.at(0.01), curve.at(100.0)), (2.2, 2.0, 5.0));
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// Source: Modelica Standard Library, `Mechanics.Rotational.Components.BearingFriction`.
///
/// # Errors
///
/// Names the row whose speed does not increase or whose torque is not positive, an empty table, a
/// `peak` below 1, or a `fall_speed` that is not below the second row.
#[cfg(feature = "alloc")]
pub fn bearing_friction<T: Scalar>(
    tau_pos: &[[T; 2]],
    peak: T,
    fall_speed: T,
) -> Checked<Tabulated<Vec<Cubic<T>>>> {
    Named("rows of tau_pos", tau_pos.len()).count(1)?;
    let mut previous = None;
    ParameterError::of_components(tau_pos, |&[speed, torque]| {
        let (speed, before) = (Named("speed", speed), previous.replace(speed));
        before.map_or_else(|| speed.exactly(T::zero()), |before| speed.increasing(before))?;
        Named("torque", torque).positive()
    })?;
    Named("peak", Named("peak", peak).finite()?).stated(peak >= T::one(), "be at least one")?;
    Named("fall_speed", fall_speed).positive()?;
    let mut rows = tau_pos.iter().copied();
    let [_, start] = rows.next().unwrap_or([T::zero(); 2]);
    let mut landing = start;
    if let Some([speed, torque]) = rows.clone().next() {
        Named("fall_speed", fall_speed).below("speed of the second row", speed)?;
        landing += (torque - start) * (fall_speed / speed);
    }
    let mut last = [fall_speed, landing];
    let mut table = alloc::vec![[T::zero(), peak * start], last];
    for row in rows {
        // On the straight line, beside both ends: between these the curve has its slope.
        let beside = [CORNER, 1.0 - CORNER, 1.0].map(|share| {
            let [near, far]: [T; 2] = [lit(1.0 - share), lit(share)];
            [last[0] * near + row[0] * far, last[1] * near + row[1] * far]
        });
        table.extend(beside);
        last = row;
    }
    // Rows so close that nothing is between them keep their corner.
    table.dedup_by(|next, before| next[0] <= before[0]);
    let knot = |[speed, coefficient]: [T; 2]| Knot { speed, coefficient };
    Tabulated::from_slice(&table.into_iter().map(knot).collect::<Vec<_>>())
}

/// Where a corner of a table ends, as a share of the way to the next row.
#[cfg(feature = "alloc")]
const CORNER: f64 = 1.0 / 256.0;

/// One row of the loss table of Modelica's `LossyGear`.
///
/// −τ_B = i (η_mf1 τ_A − τ_bf1) while flange A drives, the motor,
///
/// −τ_B = i (τ_A/η_mf2 − τ_bf2) while flange B drives, the load.
///
/// With x = μ k_m, y = μ k_e and c = μ p0 + B |v| of a [gear](bristle_joint::GearFriction) this is
///
/// η_mf1 = (1 − x)/(1 + y),  η_mf2 = (1 − y)/(1 + x),  i τ_bf1 = c/(1 + y),  i τ_bf2 = c/(1 − y)
///
/// x = (1 − 2 η_mf1 + η_mf1 η_mf2)/(1 − η_mf1 η_mf2),  y likewise with the two exchanged.
///
/// ```
/// use bristle_convert::LossyGear;
///
/// // The row of Modelica's example LossyGearDemo3.
/// let row = LossyGear {
///     driving_efficiency: 0.25,
///     back_driving_efficiency: 0.25,
///     driving_friction: 0.625, // N m
///     back_driving_friction: 2.5,
///     ratio: 1.0,
/// };
/// let gear = row.losses()?;
/// assert!((gear.coefficient - 0.6_f64).abs() < 1e-12); // 0.75/1.25
/// let load = gear.load.parameters();
/// assert!((load.motor_share - 1.0).abs() < 1e-12 && (load.idle_load - 1.0 / 0.6).abs() < 1e-12);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// A table of several rows: `docs/coming-from.md` has the program.
///
/// Source: Modelica Standard Library, `Mechanics.Rotational.Components.LossyGear`; C. Pelchen, C.
/// Schweiger, M. Otter, "Modeling and simulating the efficiency of gearboxes and of planetary
/// gearboxes", 2nd International Modelica Conference (2002).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct LossyGear<T> {
    /// Mesh efficiency η_mf1 \[–\] while the motor drives, above 0 and at most 1.
    #[doc(alias = "eta_mf1")]
    pub driving_efficiency: T,
    /// Mesh efficiency η_mf2 \[–\] while the load drives, above 0 and at most 1.
    #[doc(alias = "eta_mf2")]
    pub back_driving_efficiency: T,
    /// Bearing friction τ_bf1 [N m] on the motor side while the motor drives, zero or positive.
    #[doc(alias = "tau_bf1")]
    pub driving_friction: T,
    /// Bearing friction τ_bf2 [N m] on the motor side while the load drives, zero or positive.
    #[doc(alias = "tau_bf2")]
    pub back_driving_friction: T,
    /// Ratio i \[–\]: angle of the motor over angle of the joint, without its sign; positive.
    pub ratio: T,
}

/// The losses of a [`LossyGear`] in the terms of a [gear](bristle_joint::GearFriction), on the side
/// of the joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearLosses<T> {
    /// Friction coefficient μ \[–\], with the larger of k_m and k_e as 1.
    pub coefficient: T,
    /// The load law: p0, k_m, k_e. The drag at the row's speed is within p0.
    pub load: TorqueLoad<T>,
}

impl<T: Scalar> LossyGear<T> {
    /// Coefficient and load law with this row's efficiencies.
    ///
    /// The row's two bearing frictions are one number here, c = μ p0: the mean of i τ_bf1 (1 + y)
    /// and i τ_bf2 (1 − y). The row is met exactly if they agree.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range. The load law asks for
    /// η_mf1 ≤ 1/(2 − η_mf2) and η_mf2 ≤ 1/(2 − η_mf1).
    pub fn losses(&self) -> Checked<GearLosses<T>> {
        let Self { driving_efficiency: drive, back_driving_efficiency: back, .. } = *self;
        let (one, two) = (T::one(), lit::<T>(2.0));
        for (name, value) in [("driving_efficiency", drive), ("back_driving_efficiency", back)] {
            Named(name, value).positive()?;
            Named(name, value).stated(value <= one, "be at most one")?;
        }
        let ratio = Named("ratio", self.ratio).positive()?;
        let first = Named("driving_friction", self.driving_friction).non_negative()?;
        let second = Named("back_driving_friction", self.back_driving_friction).non_negative()?;
        // 1 − 2 η + η₁η₂, where roundings stand for zero.
        let share = |name, eta: T, bound, other: T| {
            let numerator = one - two * eta + drive * back;
            let rounding = lit::<T>(8.0) * T::default_epsilon();
            if numerator.abs() <= rounding {
                return Ok(T::zero());
            }
            Named(name, eta).at_most(bound, one / (two - other))?;
            Ok(numerator / (one - drive * back))
        };
        let motor = share("driving_efficiency", drive, "1/(2 - back_driving_efficiency)", back)?;
        let external = share("back_driving_efficiency", back, "1/(2 - driving_efficiency)", drive)?;
        let beside = ratio * (first * (one + external) + second * (one - external)) / two;
        let larger = if motor > external { motor } else { external };
        // Ideal teeth: the bearings alone.
        let coefficient = if larger > T::zero() { larger } else { one };
        let load = TorqueLoad::new(TorqueLoadParameters {
            idle_load: beside / coefficient,
            motor_share: motor / coefficient,
            external_share: external / coefficient,
        })?;
        Ok(GearLosses { coefficient, load })
    }

    /// The row of a gear at a velocity of its joint [rad/s]. A gear that jams or locks itself has
    /// no row: an efficiency would not be positive.
    ///
    /// # Errors
    ///
    /// Refuses a ratio that is not positive, a velocity of zero, and a gear with μ k_m ≥ 1 or
    /// μ k_e ≥ 1.
    pub fn of<M: Bristle<T>>(
        gear: &GearFriction<T, M, TorqueLoad<T>>,
        velocity: T,
        ratio: T,
    ) -> Checked<Self> {
        Named("ratio", ratio).positive()?;
        let speed = Named("velocity", velocity.abs()).positive()?;
        let one = T::one();
        let coefficient = gear.model().stationary_coefficient(velocity).abs();
        let mu = gear.friction_scale() * coefficient;
        let TorqueLoadParameters { idle_load, motor_share, external_share } =
            gear.law().parameters();
        let below_one =
            |name, share| Named(name, mu * share).stated(mu * share < one, "be below one");
        let motor = below_one("mu k_m", motor_share)?;
        let external = below_one("mu k_e", external_share)?;
        let beside = (mu * idle_load + gear.drag() * speed) / ratio;
        Ok(Self {
            driving_efficiency: (one - motor) / (one + external),
            back_driving_efficiency: (one - external) / (one + motor),
            driving_friction: beside / (one + external),
            back_driving_friction: beside / (one - external),
            ratio,
        })
    }
}

/// What sticks before it slips, from what is measured or guessed: a bristle for a curve that has
/// none.
///
/// σ0 = μ_s/travel,  σ1 = 2 ζ √(σ0 m/p)
///
/// ```
/// use bristle_convert::Presliding;
///
/// let dry = Presliding {
///     static_coefficient: 0.2,
///     travel: 10e-6, // m
///     normal_force: 50.0, // N
///     mass: 2.0, // kg
///     damping_ratio: 0.5,
/// };
/// let bristle = dry.bristle()?;
/// assert_eq!(bristle.parameters().micro_stiffness, 2e4); // 1/m
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Presliding<T> {
    /// Static friction coefficient μ_s \[–\] of the curve, positive; under a load of 1 the
    /// breakaway force.
    pub static_coefficient: T,
    /// Elastic travel \[m or rad\] until breakaway, positive: of metal on metal 1 to 100 µm.
    pub travel: T,
    /// Normal force p \[N\], positive; 1 if the coefficient is a force or a torque.
    pub normal_force: T,
    /// Mass m \[kg\] that hangs on the bristle when stuck, or moment of inertia [kg m²]; positive.
    pub mass: T,
    /// Damping ratio ζ \[–\] of the stuck mass, zero or positive: 0.3 to 0.7 if nothing is known.
    pub damping_ratio: T,
}

impl<T: Scalar> Presliding<T> {
    /// The bristle.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range.
    pub fn bristle(&self) -> Checked<KelvinVoigt<T>> {
        let micro_stiffness = Named("static_coefficient", self.static_coefficient).positive()?
            / Named("travel", self.travel).positive()?;
        let mass = Named("mass", self.mass).positive()?;
        let force = Named("normal_force", self.normal_force).positive()?;
        let ratio = Named("damping_ratio", self.damping_ratio).non_negative()?;
        let micro_damping = lit::<T>(2.0) * ratio * (micro_stiffness * mass / force).sqrt();
        KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness, micro_damping })
    }
}

/// The programs on these pages are tests.
#[cfg(all(doctest, feature = "alloc"))]
#[doc = include_str!("../README.md")]
#[doc = include_str!("../docs/coming-from.md")]
struct Pages;
