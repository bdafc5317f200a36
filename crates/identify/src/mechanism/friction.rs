//! Candidates for the friction of a gear: a bristle, a curve, a load law, in units of torque.
//!
//! T = p μ_b(v, z),  p = T_c + |k_m τ_m − k_e τ_e|,  μ_d = 1
//!
//! With μ_d = 1 the load of the idle gear is the Coulomb torque T_c itself, and the factors of the
//! load say how much friction each newton metre of motor and external torque adds. T_c is the
//! reference load, too: the stiffness of the bristle is T_c σ0 under every load.
//!
//! | parameter | symbol | unit |
//! |---|---|---|
//! | `coulomb_torque` | T_c | N m |
//! | `motor_load_factor`, `external_load_factor` | k_m, k_e: the products k_m μ_d and k_e μ_d | – |
//! | `breakaway_excess` | μ_s/μ_d − 1 | – |
//! | `stribeck_velocity` | v_S | rad/s |
//! | `stribeck_exponent` | δ: 2, unless something is said of it | – |
//! | `backward_ratio` | μ for v < 0 over μ for v > 0 | – |
//! | `micro_stiffness` | σ0: the inverse of the breakaway distance | 1/rad |
//! | `micro_damping` | σ1 | s/rad |

use core::fmt;

use super::start::Guess;
use crate::Parameter;
use bristle::curve::{
    AnyCurve, Asymmetric, Coulomb, CoulombParameters, Stribeck, StribeckParameters,
};
use bristle::parameter::Checked;
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::scalar::lit;
use bristle::{AnyBristle, FrBd, LuGre, Scalar};
use bristle_joint::{GearFriction, GearFrictionParameters, TorqueLoad, TorqueLoadParameters};

/// What carries the friction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Kind {
    /// With a bristle so stiff that its deflection does not count.
    Coulomb,
    /// Likewise.
    Stribeck,
    Dahl,
    LuGre,
    FrBd,
}

/// σ0 times the range of positions, of a bristle that does not count: it breaks away over a
/// ten-thousandth of the range. A stiffer one only rings.
const STIFF: f64 = 1e4;

/// A candidate for the friction of a gear.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Friction {
    kind: Kind,
    exponential: bool,
    pub(super) loaded: bool,
    pub(super) directional: bool,
}

/// The friction of a gear, chosen at run time.
pub(super) type Gear<T> = GearFriction<T, AnyBristle<T>, TorqueLoad<T>>;

/// Its parameters.
pub(super) type GearParameters<T> = GearFrictionParameters<T, AnyBristle<T>, TorqueLoad<T>>;

impl Friction {
    fn new(kind: Kind) -> Self {
        Self { kind, exponential: false, loaded: false, directional: false }
    }

    /// Whether it has a Stribeck curve.
    fn falls(&self) -> bool {
        !matches!(self.kind, Kind::Coulomb | Kind::Dahl)
    }

    /// A constant torque against the motion. Its bristle is fixed and stiff: it breaks away over a
    /// ten-thousandth of the range of positions, well damped.
    pub fn coulomb() -> Self {
        Self::new(Kind::Coulomb)
    }

    /// A Stribeck curve, with the bristle of [`Friction::coulomb`].
    pub fn stribeck() -> Self {
        Self::new(Kind::Stribeck)
    }

    /// [Dahl](bristle::Dahl)'s model.
    pub fn dahl() -> Self {
        Self::new(Kind::Dahl)
    }

    /// The classical [`LuGre`] model with a Stribeck curve.
    pub fn lugre() -> Self {
        Self::new(Kind::LuGre)
    }

    /// [`FrBd`] with a Stribeck curve.
    pub fn frbd() -> Self {
        Self::new(Kind::FrBd)
    }

    /// With a load that grows with the torques, p = T_c + |k_m τ_m − k_e τ_e|.
    #[must_use]
    pub fn loaded(self) -> Self {
        Self { loaded: true, ..self }
    }

    /// With a Stribeck exponent δ of one in place of two: friction falls at once from rest on.
    #[must_use]
    pub fn exponential(self) -> Self {
        Self { exponential: true, ..self }
    }

    /// With another curve backwards. Under a constant load that is a constant torque beside the
    /// mean of both curves: such a candidate is refused beside a
    /// [`Term::constant`](super::Term::constant) that is searched.
    #[must_use]
    pub fn directional(self) -> Self {
        Self { directional: true, ..self }
    }

    /// Coulomb, Dahl, Stribeck, FrBD and LuGre with a constant load, then with one that grows with
    /// the torques; of the latter also Coulomb by direction, and LuGre with δ = 1. From simple to
    /// rich, as [`compare`](super::compare()) takes them.
    pub fn candidates() -> Vec<Self> {
        let plain = [Self::coulomb(), Self::dahl(), Self::stribeck(), Self::frbd(), Self::lugre()];
        let [coulomb, .., lugre] = plain.map(Self::loaded);
        let more = [coulomb.directional(), lugre.exponential()];
        plain.into_iter().chain(plain.map(Self::loaded)).chain(more).collect()
    }

    /// Whether a simpler candidate is this one with some of its parameters without effect.
    pub(super) fn contains(&self, simpler: &Self) -> bool {
        let kind = match (simpler.kind, self.kind) {
            (Kind::Coulomb, _) | (Kind::Stribeck | Kind::Dahl, Kind::LuGre | Kind::FrBd) => true,
            (one, other) => one == other,
        };
        let least = (!simpler.falls() || simpler.exponential == self.exponential)
            && simpler.loaded <= self.loaded
            && simpler.directional <= self.directional;
        kind && least && simpler != self
    }

    /// Its parameters with units of translation.
    pub(super) fn parameters(&self, guess: &Guess) -> Vec<Parameter> {
        let (coulomb, range) = (guess.coulomb, guess.range);
        let bounds = 1e-3 * coulomb..=100.0 * coulomb;
        let mut all = vec![Parameter::scaled("coulomb_torque", "N", coulomb, bounds, coulomb)];
        if self.loaded {
            all.push(Parameter::scaled("motor_load_factor", "", 0.1, 0.0..=0.95, 0.1));
            all.push(Parameter::scaled("external_load_factor", "", 0.1, 0.0..=5.0, 0.1));
        }
        let logarithmic = Parameter::logarithmic;
        if self.falls() {
            let (speed, least, most) = (guess.speed, 1e-4 * guess.fastest, 10.0 * guess.fastest);
            all.push(Parameter::scaled("breakaway_excess", "", 0.3, 0.0..=10.0, 0.3));
            all.push(logarithmic("stribeck_velocity", "m/s", 0.1 * speed, least..=most));
            // Fixed, unless something is said of it.
            let exponent = if self.exponential { 1.0 } else { 2.0 };
            let bounds = exponent..=exponent;
            all.push(Parameter::scaled("stribeck_exponent", "", exponent, bounds, 1.0));
        }
        if self.directional {
            all.push(logarithmic("backward_ratio", "", 1.0, 0.1..=10.0));
        }
        let fixed = matches!(self.kind, Kind::Coulomb | Kind::Stribeck);
        let (start, least) = if fixed { (STIFF, STIFF) } else { (200.0, 1.0) };
        let (stiffness, bounds) = (start / range, least / range..=STIFF / range);
        all.push(logarithmic("micro_stiffness", "1/m", stiffness, bounds));
        if self.kind != Kind::Dahl {
            // Of critical damping of the stuck joint, 2 √(σ0 J/T_c).
            let share = if fixed { 0.5 } else { 0.1 };
            let damping = share * (2.0 * (stiffness * guess.inertia / coulomb).sqrt());
            let bounds = if fixed { damping..=damping } else { 0.0..=1e3 * damping };
            let typical = (!fixed).then_some(damping);
            all.push(Parameter { typical, ..logarithmic("micro_damping", "s/m", damping, bounds) });
        }
        all
    }

    /// The friction with the values of these names, for speeds up to the fastest.
    pub(super) fn gear<T: Scalar>(
        &self,
        value: impl Fn(&str) -> Option<T>,
        fastest: f64,
    ) -> Checked<GearParameters<T>> {
        let (zero, one) = (T::zero(), T::one());
        let or = |name, other| value(name).unwrap_or(other);
        let [idle_load, drag, micro_stiffness] =
            ["coulomb_torque", "drag", "micro_stiffness"].map(|name| or(name, T::nan()));
        let motor_share = or("motor_load_factor", zero);
        let external_share = or("external_load_factor", zero);
        let (excess, stribeck_velocity) =
            (or("breakaway_excess", zero), or("stribeck_velocity", one));
        let (backward, micro_damping) = (or("backward_ratio", one), or("micro_damping", zero));
        let curve = |size: T| -> Checked<AnyCurve<T>> {
            let viscous_friction = zero;
            if !self.falls() {
                let parameters = CoulombParameters { dynamic_coefficient: size, viscous_friction };
                return Ok(Coulomb::new(parameters)?.into());
            }
            let curve = Stribeck::new(StribeckParameters {
                static_coefficient: size * (one + excess),
                dynamic_coefficient: size,
                stribeck_velocity,
                stribeck_exponent: or("stribeck_exponent", lit(2.0)),
                viscous_friction,
            });
            Ok(curve?.into())
        };
        let forward = curve(one)?;
        let curve = if self.directional {
            Asymmetric { forward, backward: curve(backward)? }.into()
        } else {
            forward
        };
        let bristle = KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness, micro_damping })?;
        let friction: AnyBristle<T> = match self.kind {
            Kind::LuGre => LuGre::classical(curve, bristle).into(),
            // Dahl's model is one of a flat curve without damping.
            _ => FrBd::new(curve, bristle).into(),
        };
        let load =
            TorqueLoad::new(TorqueLoadParameters { idle_load, motor_share, external_share })?;
        let fastest = lit(fastest);
        Ok(GearFrictionParameters { friction, load, reference_load: idle_load, drag, fastest })
    }
}

impl fmt::Display for Friction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self.kind {
            Kind::Coulomb => "Coulomb",
            Kind::Stribeck => "Stribeck",
            Kind::Dahl => "Dahl",
            Kind::LuGre => "LuGre",
            Kind::FrBd => "FrBD",
        };
        let flag = |is: bool, text| if is { text } else { "" };
        let load = flag(self.loaded, ", loaded");
        let directional = flag(self.directional, ", directional");
        let exponent = flag(self.exponential, ", δ = 1");
        f.pad(&format!("{name}{load}{directional}{exponent}"))
    }
}
