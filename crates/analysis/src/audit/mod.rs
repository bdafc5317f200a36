//! Checks a parameter set before a run: passivity, bounds, largest steps.
//!
//! | line | what is checked | by |
//! |---|---|---|
//! | passivity | F v ≥ Ẇ, W = ½ p K z² | a theorem, or a search for (c₀ − K r)² > 4 K λ c₂ |
//! | deflection, force, relaxation | bounds of \|z\|, \|F\|, λ | [`Bristle::limits`] |
//! | inversion | σ0 z + σ1 ż = μ(v − ż) has one root ż: σ1 + dμ/d\|v\| ≥ 0 | search for the slope |
//! | smoothness | dμ/d\|v\| = 0 at rest | `FrictionCurve::slope_at_rest` |
//! | creep | steady velocity under a force below breakaway, F_ss(v) = F | a search for it |
//! | relaxation at rest | λ(0): how fast the bristles of a resting contact let go | |
//! | drift | Δx = (μ_s/σ0) ln[(F_b² − F₁²)/(F_b² − F₂²)] a load cycle F₁ ↔ F₂ | closed form |
//! | stuck mass | ω² = (σ0 c p + k)/m, 2ζω = (σ1 c p + d)/m, c = 1 (2 reversed) | [`step_limits`] |
//! | | Maxwell bristle: (s + λ)(m s² + d s + k) + σ0 c p s = 0, λ(0), fast roots | |
//! | stick-slip | speeds of stable sliding on the spring | [`linear`] |
//! | steps | largest stable step of each method | [`step_limits`] |
//!
//! The line of the inversion prints "one solution", or "FOLDS" where σ1 + dμ/d|v| < 0 at some
//! speed: the equation has three roots there. This concerns the implicit bristle; FrBD has one
//! force for each state.
//!
//! For FrBD with a stiffness σ0(v) that depends on the velocity, the condition of the search is
//! μ (σ0(v) − K)² ≤ 4 σ1(v) K σ0(v)|v|_ε with K = σ0(0): without damping it is not passive.
//!
//! The drift follows from ż = v − |v| z σ0/μ_s far below the Stribeck velocity. Loading from F₁ to
//! F₂ takes the path (μ_s/σ0) ln[(F_b − F₁)/(F_b − F₂)], and unloading gives back
//! (μ_s/σ0) ln[(F_b + F₂)/(F_b + F₁)]. Dahl, LuGre and FrBD drift even with an exact modulus, where
//! they do not creep; an elasto-plastic bristle within its stick limit does neither.
//!
//! Sources: Romano et al. (arXiv 2602.09429), section III-B, for FrBD; N. Barabanov, R. Ortega,
//! "Necessary and sufficient conditions for passivity of the LuGre friction model", IEEE
//! Transactions on Automatic Control 45 (2000), 830–832; P. Dupont, V. Hayward, B. Armstrong,
//! F. Altpeter, "Single state elastoplastic friction models", IEEE Transactions on Automatic
//! Control 47 (2002), 787–792, for drift.

mod report;

use bristle::parameter::{Checked, Named};
use bristle::root::enclose;
use bristle::scalar::{is_zero, lit};
use bristle::{
    Bounds, Branch, Bristle, Characteristics, Contact, ContactLimits, Law, Mechanism, Scalar, Units,
};

use crate::linear::{self, Threshold};
use crate::step_limits::{self, Scheme, StepLimits, Swing};

/// Operating range and mechanism of an audit.
///
/// ```
/// use bristle_analysis::audit::AuditParameters;
///
/// let slow = AuditParameters { sample_time: Some(1e-3), ..AuditParameters::up_to(0.1) };
/// // A joint, of up to 5 rad/s, whose friction coefficient is a torque.
/// let joint = AuditParameters { units: bristle::Units::Rotation, ..AuditParameters::up_to(5.0) };
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct AuditParameters<T: Scalar> {
    /// Largest speed \|v\| [m/s] that occurs, positive and finite.
    pub fastest: T,
    /// The mechanism that the contact holds or brakes.
    pub mechanism: Option<Mechanism<T>>,
    /// Length \[s\] of a fixed step, positive.
    pub sample_time: Option<T>,
    /// A force \[N\] below breakaway that goes slowly up and down between two values; if none is
    /// given, between zero and half of breakaway.
    pub load_cycle: Option<Bounds<T>>,
    /// In which units the audit prints.
    #[cfg_attr(feature = "serde", serde(default))]
    pub units: Units,
}

impl<T: Scalar> AuditParameters<T> {
    /// An audit of the contact alone, for speeds up to `fastest` [m/s].
    pub fn up_to(fastest: T) -> Self {
        let units = Units::Translation;
        Self { fastest, mechanism: None, sample_time: None, load_cycle: None, units }
    }
}

/// Whether a law holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LawStatus {
    /// It holds, by a theorem.
    Holds,
    /// A search found no case in which it fails, but there is no theorem.
    Unrefuted,
    /// It fails: there is a case against it.
    Fails,
}

/// Whether the friction is passive: never returns more energy than it was given.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Passivity<T> {
    /// F v ≥ Ẇ at every velocity and admissible deflection.
    pub verdict: LawStatus,
    /// The largest (c₀ − K r)²/(4 K λ c₂) \[–\] over the velocities searched. Where it is at most
    /// one, the model is passive at every deflection. Zero for FrBD of constant stiffness.
    pub excess: T,
    /// The least F v − Ẇ \[W\] found: negative where friction returns more power than its bristles
    /// release; otherwise zero.
    pub least_power: T,
    /// Velocity [m/s] of the least power.
    pub velocity: T,
    /// Deflection \[m\] of the least power, within its limit.
    pub deflection: T,
}

/// The oscillation of a stuck mass on its bristles.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct StuckMass<T> {
    /// Undamped angular frequency [rad/s] with an undeflected bristle.
    pub frequency: T,
    /// Damping ratio ζ \[–\] there.
    #[doc(alias = "zeta")]
    pub damping_ratio: T,
    /// Undamped angular frequency [rad/s] just after a reversal of slow sliding.
    pub reversed_frequency: T,
    /// Damping ratio ζ \[–\] there.
    pub reversed_damping_ratio: T,
}

/// The laws, bounds and steps of a parameter set: fields for programs, and a table when printed.
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
/// use bristle::{Bristle, LuGre, Mechanism, paper};
/// use bristle_analysis::audit::{AuditParameters, LawStatus, audit};
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
/// let contact = LuGre::classical(curve, bristle).under_load(1.0)?;
/// let audit = audit(&contact, AuditParameters {
///     mechanism: Some(Mechanism { mass: 1.0, spring_stiffness: 2.0, viscous_damping: 0.0 }),
///     sample_time: Some(1e-3),
///     ..AuditParameters::up_to(1.0)
/// })?;
/// assert_eq!(audit.passivity.verdict, LawStatus::Fails);
/// assert_eq!(audit.characteristics.and_then(|it| it.needed_viscous_friction), Some(32.25));
/// let table = audit.to_string();
/// assert!(table.contains("FAILS: needs σ2 ≥ 32.25 s/m, has 0.04"));
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// The table, here without its last column, which names the source of each finding:
///
/// ```text
/// audit of classical LuGre under 1 N, |v| ≤ 1 m/s
/// passivity           FAILS: needs σ2 ≥ 32.25 s/m, has 0.04
///   worst case        F v − Ẇ = -29.96 W at v = 1 m/s, z = 1.5e-4 m
/// deflection          |z| ≤ 1.5e-4 m
/// force               no bound
/// relaxation rate     λ ≤ 10000 1/s
/// inversion           one solution: σ1 = 64.5, least dμ/d|v| = -42.848 s/m
/// curve at rest       differentiable
/// modulus |v|         exact, with its kink
/// breakaway           F_b = p μ_s = 1.5 N
/// drift               4.3152e-5 m per slow cycle 0 ↔ 0.75 N
/// creep               none under 0.75 N
/// stuck mass          ω = 100.01 rad/s, ζ = 0.32267; after a reversal ζ = 0.4562
/// sliding on spring   small motions die out above 0.029863 m/s, GROW just below
/// largest step [s]    bristle     stuck       reversed      at 0.001 s
///   Euler             2e-4        0.0064527   0.0064514     TOO LONG
///   SemiImplicitEuler 2e-4        0.014561    0.0090921     TOO LONG
///   RungeKutta4       2.7853e-4   0.028037    0.01871       TOO LONG
///   DormandPrince     3.3066e-4   0.032538    0.023966      TOO LONG
///   DormandPrince8    6.3937e-4   0.065643    0.048029      TOO LONG
///   ExactHold         any         0.012905    0.012903      ok
///   Passive           no promise: the contact is not passive at every deflection
///   Rosenbrock        any         any         any           ok
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Audit<T: Scalar> {
    /// What was asked.
    pub parameters: AuditParameters<T>,
    /// Normal force p \[N\].
    pub normal_force: T,
    /// Parameters of the model; `None` if it does not expose them.
    pub characteristics: Option<Characteristics<T>>,
    /// Passivity.
    pub passivity: Passivity<T>,
    /// Bounds of deflection \[m\], force \[N\] and relaxation rate [1/s].
    pub limits: ContactLimits<T>,
    /// σ1 + the least dμ/d|v| [s/m]. Where it is negative, the bristle's implicit equation has
    /// several solutions. `None` for a model that does not tell its characteristics.
    pub inversion_margin: Option<T>,
    /// The breakaway force p μ_s \[N\]; for an asymmetric curve that of forward sliding. `None` as
    /// above.
    pub breakaway: Option<T>,
    /// The load cycle; `None` as above.
    pub load_cycle: Option<Bounds<T>>,
    /// Displacement \[m\] left by each slow load cycle, at an exact modulus. `None` where no closed
    /// form is known, as for an asymmetric curve, and for a bristle that creeps without end.
    pub drift: Option<T>,
    /// Steady velocity [m/s] under the force of larger magnitude: zero if the contact sticks;
    /// `None` if it slides, or as above.
    pub creep: Option<T>,
    /// Relaxation rate λ(0) [1/s] of bristles at rest.
    pub relaxation_at_rest: T,
    /// The stuck mass, if there is a mechanism.
    pub stuck: Option<StuckMass<T>>,
    /// Speeds at which steady sliding on the spring is stable, from a millionth of the fastest up
    /// to it; if there is a spring.
    pub steady_sliding: Option<Threshold<T>>,
    /// The largest stable steps of every scheme, in the order of [`Scheme::ALL`]; without a
    /// mechanism those of the bristle alone. `None` if the relaxation rate has no bound, or for a
    /// passive step of a contact that is not passive at every deflection.
    pub steps: [Option<StepLimits<T>>; Scheme::ALL.len()],
}

impl<T: Scalar> Audit<T> {
    /// The largest force of the load cycle over the breakaway force p μ_s \[–\]: the margin of a
    /// grip, if the contact is under the least normal force that it has. A part slips at 1, and
    /// an audit refuses a cycle that reaches it. `None` if no [`load_cycle`] was given (what the
    /// report prints then is a default), without a load, and for a model that does not tell its
    /// characteristics.
    ///
    /// [`load_cycle`]: AuditParameters::load_cycle
    pub fn load_share(&self) -> Option<T> {
        let (breakaway, cycle) = self.breakaway.zip(self.parameters.load_cycle)?;
        (!is_zero(breakaway)).then(|| peak(cycle).abs() / breakaway)
    }
}

/// Audits the parameters: which laws hold, what is bounded, how long a step may be.
///
/// Nothing is simulated; the cost is a few thousand evaluations of the model. For a bristle of
/// several springs, whose theorems are fewer, use [`Contact::limits`] and [`Bristle::obeys`].
///
/// # Errors
///
/// Names the parameter that is out of its range: the fastest speed, the mechanism, the sample time,
/// or a load cycle that is not below breakaway. Names a friction curve that is not finite or leaves
/// the bounds it states, with velocity and value, if that happens at rest or at one of the speeds
/// searched: 32 a decade over twelve decades.
pub fn audit<T: Scalar, M: Bristle<T, Deflection = T>>(
    contact: &Contact<T, M>,
    parameters: AuditParameters<T>,
) -> Checked<Audit<T>> {
    let AuditParameters { fastest, mechanism, sample_time, load_cycle, .. } = parameters;
    Named("fastest", fastest).positive()?;
    sample_time.map(|step| Named("sample_time", step).positive()).transpose()?;
    mechanism.map(Mechanism::checked).transpose()?;
    let characteristics = contact.model().characteristics(fastest);
    if let Some(fault) = characteristics.and_then(|model| model.curve_fault) {
        return Err(fault);
    }
    let breakaway = characteristics.map(|model| contact.normal_force() * model.static_coefficient);
    let load_cycle = breakaway.map(|force| checked(load_cycle, force)).transpose()?;
    let (drift, creep) = characteristics
        .zip(load_cycle)
        .map_or((None, None), |(model, cycle)| yielding(contact, &model, cycle, fastest));
    let passivity = passivity(contact, characteristics.as_ref(), fastest);
    let steps = Scheme::ALL.map(|scheme| {
        // A passive step needs a contact that is passive at every deflection.
        let promised = scheme != Scheme::Passive || passivity.excess <= T::one();
        let limits = step_limits::largest_step(contact, mechanism, fastest, scheme).ok();
        limits.filter(|_| promised)
    });
    Ok(Audit {
        parameters,
        normal_force: contact.normal_force(),
        characteristics,
        passivity,
        limits: contact.limits(fastest),
        inversion_margin: characteristics
            .map(|model| model.micro_damping.min + model.viscous_friction + model.least_slope),
        breakaway,
        load_cycle,
        drift,
        creep,
        relaxation_at_rest: contact.model().affine(T::zero().into(), T::zero()).relaxation,
        stuck: mechanism.map(|mechanism| stuck_mass(contact, mechanism, fastest)),
        steady_sliding: mechanism.and_then(|mechanism| {
            linear::critical_speed(contact, mechanism, slowest_on_spring(fastest)..fastest).ok()
        }),
        steps,
    })
}

/// The model's own theorem, or a search for a case against it.
fn passivity<T: Scalar, M: Bristle<T, Deflection = T>>(
    contact: &Contact<T, M>,
    characteristics: Option<&Characteristics<T>>,
    fastest: T,
) -> Passivity<T> {
    let zero = T::zero();
    let theorem = contact.model().obeys(Law::Passivity);
    let stiffness = contact.model().storage_stiffness();
    let limit = contact.limits(fastest).deflection;
    let mut found = Passivity {
        verdict: LawStatus::Holds,
        excess: zero,
        least_power: zero,
        velocity: zero,
        deflection: zero,
    };
    for velocity in speeds(fastest).flat_map(|speed| [speed, -speed]) {
        // D/p = K λ z² + (c₀ − K r) v z + c₂ v², with the coefficients at z = 0: the models whose
        // coefficients depend on z have a theorem.
        let affine = contact.model().affine(velocity.into(), zero);
        let square = stiffness * affine.relaxation;
        let cross = affine.stiffness - stiffness * affine.drive;
        // For FrBD the difference of two equal numbers, of which a few roundings are left.
        let rounding = lit::<T>(4.0) * T::default_epsilon() * affine.stiffness.abs();
        let cross = if cross.abs() > rounding { cross } else { zero };
        if cross != zero {
            let ratio = cross * cross / (lit::<T>(4.0) * square * affine.damping);
            found.excess = found.excess.larger(ratio);
        }
        // The deflection of least D, within its bound.
        let lowest = -cross * velocity / (lit::<T>(2.0) * square);
        let deflection = limit.map_or(lowest, |limit| lowest.smaller(limit).larger(-limit));
        let power = square * deflection * deflection
            + cross * velocity * deflection
            + affine.damping * velocity * velocity;
        let least_power = contact.normal_force() * power;
        // Under a theorem what is negative is rounding.
        if least_power < found.least_power && !theorem {
            found = Passivity { least_power, velocity, deflection, ..found };
        }
    }
    let short = characteristics.is_some_and(|model| {
        model.needed_viscous_friction.is_some_and(|needed| !(model.viscous_friction >= needed))
    });
    if !theorem {
        let fails = short || found.least_power < zero;
        found.verdict = if fails { LawStatus::Fails } else { LawStatus::Unrefuted };
    }
    found
}

/// Drift and creep in a load cycle.
fn yielding<T: Scalar, M: Bristle<T, Deflection = T>>(
    contact: &Contact<T, M>,
    characteristics: &Characteristics<T>,
    cycle: Bounds<T>,
    fastest: T,
) -> (Option<T>, Option<T>) {
    let zero = T::zero();
    let breakaway = contact.normal_force() * characteristics.static_coefficient;
    let stiffness = contact.model().storage_stiffness();
    let peak = peak(cycle);
    // The formula is for friction that is equal in both directions.
    let known = !characteristics.creeps && is_even(contact, fastest);
    // An elasto-plastic bristle neither drifts nor creeps within its stick limit; beyond it no
    // closed form is known.
    let elastic = characteristics
        .stick_limit
        .map(|limit| peak.abs() <= contact.normal_force() * stiffness * limit);
    if let Some(elastic) = elastic {
        let none = elastic.then_some(zero);
        return (none.filter(|_| known), none);
    }
    let known = known && characteristics.micro_stiffness.is_constant() && breakaway > zero;
    // (F_b² − F₁²)/(F_b² − F₂²), as one plus what the cycle makes of it.
    let gain = (cycle.max - cycle.min) * (cycle.max + cycle.min)
        / ((breakaway - cycle.max) * (breakaway + cycle.max));
    let drift = characteristics.static_coefficient / stiffness * gain.ln_1p();
    (known.then_some(drift), creep(contact, characteristics, peak, fastest))
}

/// Whether steady friction is equal in both directions, by samples.
fn is_even<T: Scalar, M: Bristle<T, Deflection = T>>(contact: &Contact<T, M>, fastest: T) -> bool {
    [lit(1e-6), lit(1e-3), T::one()].into_iter().all(|part: T| {
        let speed = fastest * part;
        let (one, other) = (contact.stationary_force(speed), contact.stationary_force(-speed));
        (one + other).abs() <= lit::<T>(1e3) * T::default_epsilon() * one.abs()
    })
}

/// The velocity at which steady friction first reaches a force.
fn creep<T: Scalar, M: Bristle<T, Deflection = T>>(
    contact: &Contact<T, M>,
    characteristics: &Characteristics<T>,
    force: T,
    fastest: T,
) -> Option<T> {
    let zero = T::zero();
    let smooth = !is_zero(characteristics.speed_at_rest);
    if !(smooth || characteristics.creeps) || is_zero(force) {
        return Some(zero);
    }
    let signed = |speed: T| if force < zero { -speed } else { speed };
    let excess = |speed: T| contact.stationary_force(signed(speed)).abs() - force.abs();
    let (mut below, mut above) =
        (zero, if smooth { characteristics.speed_at_rest } else { fastest } * lit(1e-6));
    while above < fastest {
        let at = excess(above);
        if at >= zero {
            let (speed, _) = enclose(excess, (below, excess(below)), (above, at), zero);
            return Some(signed(speed));
        }
        below = above;
        above *= lit(1.5);
    }
    None
}

fn stuck_mass<T: Scalar, M: Bristle<T, Deflection = T>>(
    contact: &Contact<T, M>,
    mechanism: Mechanism<T>,
    fastest: T,
) -> StuckMass<T> {
    let swing = |reversed: bool| {
        let swing = Swing::new(contact, mechanism, Branch::Forward, reversed, fastest);
        let (damping, stiffness) = (lit::<T>(swing.damping), lit::<T>(swing.stiffness));
        let frequency = stiffness.sqrt();
        (frequency, damping / (lit::<T>(2.0) * frequency))
    };
    let (frequency, damping_ratio) = swing(false);
    let (reversed_frequency, reversed_damping_ratio) = swing(true);
    StuckMass { frequency, damping_ratio, reversed_frequency, reversed_damping_ratio }
}

/// The load cycle, of which both forces must be below breakaway.
fn checked<T: Scalar>(cycle: Option<Bounds<T>>, breakaway: T) -> Checked<Bounds<T>> {
    let cycle = cycle.unwrap_or(Bounds { min: T::zero(), max: lit::<T>(0.5) * breakaway });
    for (name, force) in [("load_cycle.max", cycle.max), ("-load_cycle.min", -cycle.min)] {
        Named(name, force).finite()?;
        if !is_zero(breakaway) {
            Named(name, force).below("breakaway force", breakaway)?;
        }
    }
    Named("load_cycle.max", cycle.max).at_least("load_cycle.min", cycle.min)?;
    Ok(cycle)
}

/// The force of larger magnitude in a load cycle.
fn peak<T: Scalar>(cycle: Bounds<T>) -> T {
    if -cycle.min > cycle.max { cycle.min } else { cycle.max }
}

/// The slowest steady sliding on the spring that is looked at [m/s].
fn slowest_on_spring<T: Scalar>(fastest: T) -> T {
    fastest * lit(1e-6)
}

/// Speeds from the fastest down over twelve decades, 32 each.
fn speeds<T: Scalar>(fastest: T) -> impl Iterator<Item = T> {
    // 10^(−1/32)
    let next: T = lit(0.930_572_040_929_699_2);
    core::iter::successors(Some(fastest), move |&speed| Some(speed * next)).take(12 * 32)
}
