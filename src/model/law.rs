//! The laws that set friction models apart.

use core::fmt;

/// A property that holds for every state and velocity, with a reference where it has a name. Ask
/// [`Bristle::obeys`](crate::Bristle::obeys).
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | P | load at which σ0 was measured; the normal force p, if that is constant | N |
/// | Kᵢ, xᵢ | stiffness and stretch of spring i; beside a dashpot alone σ0 and z | 1/m, m |
/// | W = ½ P Σ Kᵢ xᵢ² | stored energy | J |
///
/// ```
/// use bristle::Law;
///
/// for law in Law::ALL {
///     println!("{law}");
/// }
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Law {
    /// Steady sliding reproduces the friction curve: F_ss = p μ(v) sgn_ε(v), where μ includes the
    /// viscous part; for LuGre F_ss = p (g(v) sgn_ε(v) + σ2 v) (Romano et al., section III-A).
    SteadySliding,
    /// F/p = (μ(v)/|v|_ε)(v − ż): the bristle is in series with a dashpot whose coefficient is
    /// taken at the velocity of the body. It makes any passive bristle a passive friction model.
    Secant,
    /// F v ≥ Ẇ: friction never gives more energy than it stored. With several springs W is the sum
    /// over all of them (Romano et al., Lemma III.2; for LuGre within its deflection limit, cf. N.
    /// Barabanov and R. Ortega, "Necessary and sufficient conditions for passivity of the LuGre
    /// friction model", IEEE Transactions on Automatic Control 45 (2000), 830–832).
    Passivity,
    /// |z(0)| ≤ max μ/σ0 implies |z(t)| ≤ max μ/σ0 (Romano et al., Lemma III.1). A law of one
    /// spring: several springs can be stretched against each other, and no such box of stretches
    /// is kept.
    BoundedDeflection,
    /// Within the deflection limit |F| ≤ p max μ over the velocities met. Several springs keep this
    /// bound in runs from rest only, so they do not obey the law; see
    /// [`Limits::coefficient`](crate::Limits::coefficient).
    BoundedForce,
    /// The relaxation rate λ has a limit at all velocities (for FrBD σ0/(σ1 + σ2)), see
    /// [`Limits::relaxation_rate`](crate::Limits::relaxation_rate). With several springs it is a
    /// limit of the largest eigenvalue.
    BoundedRelaxation,
    /// (z, v) → (−z, −v) flips the rate and the force. A curve that differs by direction breaks it,
    /// such as [`Asymmetric`](crate::curve::Asymmetric).
    OddSymmetry,
    /// Cycles of the force below a stick limit p σ0 z_b > 0 cause no drift (P. Dupont, V. Hayward,
    /// B. Armstrong, F. Altpeter, "Single state elastoplastic friction models", IEEE Transactions
    /// on Automatic Control 47 (2002), 787–792).
    NoDrift,
}

impl Law {
    /// All laws.
    pub const ALL: [Self; 8] = [
        Self::SteadySliding,
        Self::Secant,
        Self::Passivity,
        Self::BoundedDeflection,
        Self::BoundedForce,
        Self::BoundedRelaxation,
        Self::OddSymmetry,
        Self::NoDrift,
    ];
}

impl fmt::Display for Law {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::SteadySliding => "steady sliding on the curve",
            Self::Secant => "secant law",
            Self::Passivity => "passivity",
            Self::BoundedDeflection => "bounded deflection",
            Self::BoundedForce => "bounded force",
            Self::BoundedRelaxation => "bounded relaxation rate",
            Self::OddSymmetry => "odd symmetry",
            Self::NoDrift => "no drift below a stick limit",
        })
    }
}
