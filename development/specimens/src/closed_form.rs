//! The models in closed form, as the publications write them, in plain `f64`.
//!
//! Written apart from the library, by the formulas and not by the code: no fast paths, no series
//! where the formula itself is good, other formulations where there is a choice.

use bristle::Affine;

use super::recipe::Recipe;

/// A friction curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Curve {
    Coulomb,
    /// With the Stribeck exponent δ.
    Stribeck(f64),
    Rational,
    Tabulated,
    /// Stribeck with δ = 2 forward, Coulomb without viscous friction backward.
    Asymmetric,
    /// μ_d (1 + ½/√(1 + (s/v_S)²)).
    Function,
}

/// |v|_ε.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Modulus {
    Exact,
    SquareRoot,
    HyperbolicTangent,
}

/// A stiffness or damping: absent, constant, c (1 + a u/√(1 + u²)) with u = v/v_d, which is not
/// even in v on purpose, or c (1 + a/(1 + u²)), which is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Element {
    None,
    Constant,
    Varying,
    Even,
}

/// Amplitude a of a varying stiffness.
pub const STIFFNESS_VARIATION: f64 = 0.3;
/// Amplitude a of a varying damping.
pub const DAMPING_VARIATION: f64 = 0.5;

/// Which family of coefficients λ, r, c₀, c₂.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Family {
    FrBd,
    LuGreClassical,
    LuGreInside,
    Dahl,
    ElastoPlastic,
    Implicit,
}

/// A model in closed form.
#[derive(Debug, Clone, Copy)]
pub struct ClosedForm {
    pub recipe: Recipe,
    pub family: Family,
    pub curve: Curve,
    pub modulus: Modulus,
    pub stiffness: Element,
    pub damping: Element,
    /// Friction scale s.
    pub scale: f64,
}

/// ż and μ_b differentiated by z and by v, or what goes with each of them.
#[derive(Debug, Clone, Copy)]
pub struct Partials {
    pub rate_by_deflection: f64,
    pub rate_by_velocity: f64,
    pub coefficient_by_deflection: f64,
    pub coefficient_by_velocity: f64,
}

/// What the implicit bristle's derivatives are made of.
struct AtTip {
    drive: f64,
    compliance_terms: f64,
    slope: f64,
    slope_terms: f64,
    error: f64,
    rough: f64,
}

fn sign(v: f64) -> f64 {
    if v == 0.0 { 0.0 } else { v.signum() }
}

impl Curve {
    /// μ without the part σ2|v| that can be taken off as a whole.
    pub fn dry(self, r: &Recipe, v: f64) -> f64 {
        let drop = r.static_ - r.dynamic;
        let u = v.abs() / r.stribeck_velocity;
        match self {
            Self::Coulomb => r.dynamic,
            Self::Stribeck(exponent) => r.dynamic + drop * (-u.powf(exponent)).exp(),
            Self::Rational => r.dynamic + drop / (1.0 + u * u),
            Self::Tabulated => Table(r.knots()).value(v.abs()),
            Self::Asymmetric if v >= 0.0 => Self::Stribeck(2.0).dry(r, v) + r.viscous * v.abs(),
            Self::Asymmetric => r.dynamic,
            Self::Function => r.dynamic * (1.0 + 0.5 / 1.0_f64.hypot(u)),
        }
    }

    /// σ2 of the part that can be taken off as a whole.
    pub fn viscous(self, r: &Recipe) -> f64 {
        match self {
            Self::Coulomb | Self::Stribeck(_) | Self::Rational => r.viscous,
            Self::Tabulated | Self::Asymmetric | Self::Function => 0.0,
        }
    }

    /// μ(v).
    pub fn mu(self, r: &Recipe, v: f64) -> f64 {
        self.dry(r, v) + self.viscous(r) * v.abs()
    }

    /// The steepest fall of the curve, −min dμ/d|v|, without σ2: a number that is not exceeded.
    pub fn steepest_fall(self, r: &Recipe) -> f64 {
        let per_velocity = (r.static_ - r.dynamic) / r.stribeck_velocity;
        match self {
            Self::Coulomb => 0.0,
            Self::Stribeck(d) if d < 1.0 => f64::INFINITY,
            Self::Stribeck(d) => {
                let w = (d - 1.0) / d;
                d * w.powf(w) * (-w).exp() * per_velocity
            }
            // (3/8)√3, and (2/9)√3 for 1/√(1 + u²).
            Self::Rational => 0.375 * 3_f64.sqrt() * per_velocity,
            Self::Function => 3_f64.sqrt() / 9.0 * r.dynamic / r.stribeck_velocity,
            Self::Asymmetric => Self::Stribeck(2.0).steepest_fall(r),
            // A cubic of this kind is at most three times as steep as its secants.
            Self::Tabulated => r.knots().windows(2).fold(0.0, |most: f64, knots| {
                most.max(3.0 * (knots[0].1 - knots[1].1) / (knots[1].0 - knots[0].0))
            }),
        }
    }

    /// Sum of the absolute values of the terms of dμ/dv, without σ2.
    pub fn dry_slope_terms(self, r: &Recipe, v: f64) -> f64 {
        let drop = r.static_ - r.dynamic;
        let u = v.abs() / r.stribeck_velocity;
        match self {
            Self::Coulomb => 0.0,
            Self::Stribeck(exponent) => {
                let steepness = if u == 0.0 && exponent != 1.0 {
                    0.0
                } else {
                    exponent * u.powf(exponent - 1.0) * (-u.powf(exponent)).exp()
                };
                drop * steepness / r.stribeck_velocity
            }
            Self::Rational => drop * 2.0 * u / (1.0 + u * u).powi(2) / r.stribeck_velocity,
            Self::Tabulated => Table(r.knots()).slope_terms(v.abs()),
            Self::Asymmetric if v >= 0.0 => Self::Stribeck(2.0).dry_slope_terms(r, v) + r.viscous,
            Self::Asymmetric => 0.0,
            Self::Function => 0.5 * r.dynamic * u / (1.0 + u * u).powf(1.5) / r.stribeck_velocity,
        }
    }

    /// A number below which μ never falls.
    pub fn floor(self, r: &Recipe) -> f64 {
        match self {
            Self::Tabulated => r.table.iter().fold(f64::INFINITY, |a, b| a.min(*b)) * r.dynamic,
            _ => r.dynamic,
        }
    }
}

impl Modulus {
    /// |v|_ε.
    pub fn speed(self, r: &Recipe, v: f64) -> f64 {
        match self {
            Self::Exact => v.abs(),
            Self::SquareRoot => v.hypot(r.epsilon.sqrt()),
            Self::HyperbolicTangent => {
                let u = v / r.threshold;
                // v coth u is 0/0 at rest: there the first terms of its series.
                if u.abs() < 1e-5 { r.threshold * (1.0 + u * u / 3.0) } else { v / u.tanh() }
            }
        }
    }

    /// sgn_ε(v).
    pub fn sign(self, r: &Recipe, v: f64) -> f64 {
        match self {
            Self::Exact => sign(v),
            Self::SquareRoot => v / self.speed(r, v),
            Self::HyperbolicTangent => (v / r.threshold).tanh(),
        }
    }

    /// Sum of the absolute values of the terms of d|v|_ε/dv.
    pub fn slope_terms(self, r: &Recipe, v: f64) -> f64 {
        match self {
            Self::Exact | Self::SquareRoot => 1.0,
            // coth u − u/sinh² u; below 1e-4 the library differentiates a series of no terms
            // larger than the result.
            Self::HyperbolicTangent => {
                let u = (v / r.threshold).abs();
                if u < 0.9e-4 { u } else { 1.0 / u.tanh() + u / u.sinh().powi(2) }
            }
        }
    }

    /// |0|_ε.
    pub fn at_rest(self, r: &Recipe) -> f64 {
        self.speed(r, 0.0)
    }
}

impl Element {
    fn value(self, constant: f64, variation: f64, r: &Recipe, v: f64) -> f64 {
        let u = v / r.varying_velocity;
        match self {
            Self::None => 0.0,
            Self::Constant => constant,
            Self::Varying => constant * (1.0 + variation * u / 1.0_f64.hypot(u)),
            Self::Even => constant * (1.0 + variation / (1.0 + u * u)),
        }
    }

    fn slope_terms(self, constant: f64, variation: f64, r: &Recipe, v: f64) -> f64 {
        let u = v / r.varying_velocity;
        match self {
            Self::None | Self::Constant => 0.0,
            // 1/√(1+u²) − u²/(1+u²)^{3/2}, which is how dual numbers differentiate it.
            Self::Varying => 2.0 * constant * variation / r.varying_velocity / 1.0_f64.hypot(u),
            Self::Even => {
                2.0 * constant * variation / r.varying_velocity * u.abs() / (1.0 + u * u).powi(2)
            }
        }
    }
}

impl ClosedForm {
    /// Without regularisation, under the reference load.
    pub fn new(r: &Recipe, family: Family, curve: Curve, elements: (Element, Element)) -> Self {
        let ((stiffness, damping), recipe) = (elements, *r);
        Self { recipe, family, curve, modulus: Modulus::Exact, stiffness, damping, scale: 1.0 }
    }

    /// σ0(v).
    pub fn sigma0(&self, v: f64) -> f64 {
        self.stiffness.value(self.recipe.stiffness, STIFFNESS_VARIATION, &self.recipe, v)
    }

    /// The model under a friction scale: μ → s μ; z_b → s z_b; σ1, σ2 → s σ1, s σ2 of LuGre.
    pub fn scaled(self, scale: f64) -> Self {
        Self { scale, ..self }
    }

    /// The scale of σ1.
    fn damping_scale(&self) -> f64 {
        match self.family {
            Family::LuGreClassical | Family::LuGreInside => self.scale,
            _ => 1.0,
        }
    }

    /// σ1(v).
    pub fn sigma1(&self, v: f64) -> f64 {
        self.damping_scale()
            * self.damping.value(self.recipe.damping, DAMPING_VARIATION, &self.recipe, v)
    }

    /// σ2 of the term outside the bristle: classical LuGre only.
    pub fn outside(&self) -> f64 {
        match self.family {
            Family::LuGreClassical => self.scale * self.curve.viscous(&self.recipe),
            _ => 0.0,
        }
    }

    /// s μ(v), the curve of the secant law; for LuGre g(v).
    pub fn mu(&self, v: f64) -> f64 {
        self.scale
            * match self.family {
                Family::LuGreClassical => self.curve.dry(&self.recipe, v),
                _ => self.curve.mu(&self.recipe, v),
            }
    }

    fn mu_slope_terms(&self, v: f64) -> f64 {
        let inside = match self.family {
            Family::LuGreClassical => 0.0,
            _ => self.curve.viscous(&self.recipe),
        };
        self.scale * (self.curve.dry_slope_terms(&self.recipe, v) + inside)
    }

    /// |v|_ε.
    pub fn speed(&self, v: f64) -> f64 {
        self.modulus.speed(&self.recipe, v)
    }

    /// sgn_ε(v).
    pub fn sign(&self, v: f64) -> f64 {
        self.modulus.sign(&self.recipe, v)
    }

    /// z_b.
    pub fn stick_limit(&self) -> f64 {
        if self.family == Family::Implicit {
            // What the surface can hold at rest; to be slow, and within roundings.
            return 0.999 * self.mu(1e-300).min(self.mu(-1e-300)) / self.recipe.stiffness;
        }
        self.scale * self.recipe.stick_fraction * self.curve.floor(&self.recipe)
            / self.recipe.stiffness
    }

    /// α(z, v).
    pub fn alpha(&self, v: f64, z: f64) -> f64 {
        let (stick, full) = (self.stick_limit(), self.mu(v) / self.sigma0(v));
        if self.family != Family::ElastoPlastic {
            1.0
        } else if z * sign(v) <= stick {
            0.0
        } else if z.abs() >= full {
            1.0
        } else {
            // ½ + ½ sin(π (|z| − (z_m + z_b)/2)/(z_m − z_b)) = sin²(π/2 (|z| − z_b)/(z_m − z_b))
            let phase = (z.abs() - stick) / (full - stick);
            (std::f64::consts::FRAC_PI_2 * phase).sin().powi(2)
        }
    }

    /// Whether α is between zero and one.
    pub fn in_transition(&self, v: f64, z: f64) -> bool {
        let alpha = self.alpha(v, z);
        alpha > 0.0 && alpha < 1.0
    }

    /// f(u) = μ(u) sgn_ε(u).
    fn carried(&self, u: f64) -> f64 {
        self.mu(u) * self.sign(u)
    }

    /// v_s of the implicit bristle, from σ1 v_s + f(v_s) = σ0 z + σ1 v by bisection over the
    /// numbers themselves.
    pub fn tip(&self, v: f64, z: f64) -> f64 {
        if self.family != Family::Implicit {
            return v;
        }
        let (s0, s1) = (self.sigma0(v), self.sigma1(v));
        let trial = s0 * z + s1 * v;
        let (size, direction) = (trial.abs(), if trial < 0.0 { -1.0 } else { 1.0 });
        if size == 0.0 || self.mu(direction * f64::MIN_POSITIVE) >= size {
            return 0.0;
        }
        let balance = |u: f64| s1 * u + self.carried(direction * u) * direction - size;
        let (mut low, mut high) = (0, 1e300_f64.to_bits());
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if balance(f64::from_bits(middle)) < 0.0 { low = middle } else { high = middle }
        }
        direction * f64::from_bits(high)
    }

    /// For the implicit bristle, at its tip: r, ds/d|v_s| with the sum of its terms, Φ' with the
    /// sum of its terms, f', and the error of |v_s| per rounding.
    fn at_tip(&self, v: f64, z: f64) -> AtTip {
        let r = &self.recipe;
        let u = self.tip(v, z);
        let (s0, s1, mu, n) = (self.sigma0(v), self.sigma1(v), self.mu(u), self.speed(u));
        let mu_terms = self.mu_slope_terms(u);
        let slope_terms = s1 + mu_terms;
        // Φ' itself by differences, on one side of rest.
        let h = (1e-6 * r.stribeck_velocity).max(1e-9 * u.abs());
        let side = if u < 0.0 { -1.0 } else { 1.0 };
        let from = (u.abs() - h).max(f64::MIN_POSITIVE);
        let to = u.abs() + h;
        let rise = side * (self.carried(side * to) - self.carried(side * from));
        let loads = s0 * z.abs() + s1 * v.abs();
        let sticks = u == 0.0 && (s0 * z + s1 * v).abs() < mu * (1.0 - 1e-9);
        let (slope, error) = if sticks {
            (slope_terms, 0.0)
        } else {
            let slope = (s1 + rise / (to - from)).max(1e-9 * slope_terms);
            (slope, loads * 2.0 / slope)
        };
        AtTip {
            drive: mu / (mu + s1 * n),
            compliance_terms: (mu + n * mu_terms) / (mu * mu),
            slope,
            slope_terms,
            error,
            // How much the derivatives change with that error: over v_S, and over |v_s| itself.
            rough: if sticks {
                1.0
            } else {
                slope_terms / slope * (1.0 + error * (10.0 / r.stribeck_velocity + 1.0 / n))
            },
        }
    }

    /// The denominator g.
    pub fn resistance(&self, v: f64, z: f64) -> f64 {
        match self.family {
            Family::Implicit => {
                let u = self.tip(v, z);
                self.sigma1(v) * self.speed(u) + self.mu(u)
            }
            Family::LuGreClassical | Family::LuGreInside | Family::Dahl => self.mu(v),
            Family::FrBd | Family::ElastoPlastic => {
                self.alpha(v, z) * self.sigma1(v) * self.speed(v) + self.mu(v)
            }
        }
    }

    /// The four coefficients.
    pub fn coefficients(&self, v: f64, z: f64) -> Affine<f64> {
        let (sigma0, sigma1, mu) = (self.sigma0(v), self.sigma1(v), self.mu(v));
        let g = self.resistance(v, z);
        match self.family {
            // Those of FrBD at the velocity of the tip.
            Family::Implicit => {
                Self { family: Family::FrBd, ..*self }.coefficients(self.tip(v, z), z)
            }
            Family::FrBd | Family::ElastoPlastic => Affine {
                relaxation: self.alpha(v, z) * sigma0 * self.speed(v) / g,
                drive: mu / g,
                stiffness: sigma0 * mu / g,
                damping: sigma1 * mu / g,
            },
            Family::LuGreClassical | Family::LuGreInside => Affine {
                relaxation: sigma0 * self.speed(v) / g,
                drive: 1.0,
                stiffness: sigma0 * (1.0 - sigma1 * self.speed(v) / g),
                damping: sigma1 + self.outside(),
            },
            Family::Dahl => Affine {
                relaxation: sigma0 * self.speed(v) / g,
                drive: 1.0,
                stiffness: sigma0,
                damping: 0.0,
            },
        }
    }

    /// Sums of the absolute values of the terms of the four coefficients: only LuGre's c₀ is a
    /// difference, and α where it is neither zero nor one.
    pub fn terms(&self, v: f64, z: f64) -> Affine<f64> {
        let coefficients = self.coefficients(v, z);
        match self.family {
            Family::Implicit => {
                let at = self.at_tip(v, z);
                let share = at.drive * at.drive * at.compliance_terms * at.error;
                let (s0, s1) = (self.sigma0(v), self.sigma1(v));
                Affine {
                    relaxation: coefficients.relaxation + s0 * share,
                    drive: coefficients.drive + s1 * share,
                    stiffness: coefficients.stiffness + s0 * s1 * share,
                    damping: coefficients.damping + s1 * s1 * share,
                }
            }
            Family::ElastoPlastic if self.in_transition(v, z) => {
                let by_alpha = self.alpha_terms(v, z);
                Affine {
                    relaxation: coefficients.relaxation + by_alpha.relaxation,
                    drive: coefficients.drive + by_alpha.drive,
                    stiffness: coefficients.stiffness + by_alpha.stiffness,
                    damping: coefficients.damping + by_alpha.damping,
                }
            }
            Family::LuGreClassical | Family::LuGreInside => Affine {
                stiffness: self.sigma0(v)
                    * (1.0 + self.sigma1(v) * self.speed(v) / self.resistance(v, z)),
                ..coefficients
            },
            _ => coefficients,
        }
    }

    /// The stiffness in W = ½ p σ0 z².
    pub fn storage(&self) -> f64 {
        self.recipe.stiffness
    }

    /// F v − Ẇ by the dissipation identity, (p/g)(ασ0²|v|_ε z² + σ1 μ v²), for the models it holds
    /// for (constant σ0), and the general p(sλz² + (c₀ − s r) z v + c₂ v²) for the others.
    pub fn dissipation(&self, v: f64, z: f64) -> f64 {
        let g = self.resistance(v, z);
        if self.stiffness == Element::Constant
            && matches!(self.family, Family::FrBd | Family::ElastoPlastic | Family::Dahl)
        {
            let spring = self.alpha(v, z) * self.sigma0(v).powi(2) * self.speed(v) * z * z;
            self.recipe.load / g * (spring + self.sigma1(v) * self.mu(v) * v * v)
        } else {
            let c = self.coefficients(v, z);
            self.recipe.load
                * (self.storage() * c.relaxation * z * z
                    + (c.stiffness - self.storage() * c.drive) * z * v
                    + c.damping * v * v)
        }
    }

    /// Sum of the absolute values of the terms of F v − Ẇ, from force and rate.
    pub fn power_terms(&self, v: f64, z: f64) -> f64 {
        let (c, terms) = (self.coefficients(v, z), self.terms(v, z));
        let force = terms.stiffness * z.abs() + terms.damping * v.abs();
        // The error of an implicit bristle's tip is in its rate, too.
        let rate = if self.family == Family::Implicit { terms } else { c };
        let rate = rate.relaxation * z.abs() + rate.drive * v.abs();
        self.recipe.load * (force * v.abs() + self.storage() * z.abs() * rate)
    }

    /// Sums of the absolute values of the terms of the derivatives of the four coefficients with
    /// respect to v, by the quotient rule as dual numbers apply it, e.g. for λ = σ0|v|_ε/g:
    /// λ' = σ0'|v|_ε/g + σ0|v|_ε'/g − σ0|v|_ε g'/g² with g' = σ1'|v|_ε + σ1|v|_ε' + μ'.
    pub fn slope_terms(&self, v: f64, z: f64) -> Affine<f64> {
        let r = &self.recipe;
        let (s0, s1, mu, n) = (self.sigma0(v), self.sigma1(v), self.mu(v), self.speed(v));
        let ds0 = self.stiffness.slope_terms(r.stiffness, STIFFNESS_VARIATION, r, v);
        let ds1 =
            self.damping_scale() * self.damping.slope_terms(r.damping, DAMPING_VARIATION, r, v);
        let (dmu, dn) = (self.mu_slope_terms(v), self.modulus.slope_terms(r, v));
        // An error of α is relative to one, not to itself.
        let transition = self.in_transition(v, z);
        let (g, alpha) = (self.resistance(v, z), if transition { 1.0 } else { self.alpha(v, z) });
        match self.family {
            Family::Implicit => {
                let at = self.at_tip(v, z);
                let share = at.drive * at.drive * at.compliance_terms * s1 / at.slope * at.rough;
                Affine {
                    // (s r)' = s' r − s σ1 r² s', of which s' r² is left.
                    relaxation: 2.0 * s0 * share / at.drive,
                    drive: s1 * share,
                    stiffness: s0 * s1 * share,
                    damping: s1 * s1 * share,
                }
            }
            Family::FrBd | Family::ElastoPlastic => {
                let by_alpha = self.alpha_terms(v, z);
                let alpha_slope = self.alpha_slopes_terms(v, z).1;
                let dg = alpha * (ds1 * n + s1 * dn) + dmu;
                let drive = dmu / g + mu * dg / (g * g) + by_alpha.drive * alpha_slope;
                let relaxation = alpha * (ds0 * n / g + s0 * dn / g + s0 * n * dg / (g * g))
                    + by_alpha.relaxation * alpha_slope;
                Affine {
                    relaxation,
                    drive,
                    stiffness: ds0 * mu / g + s0 * drive,
                    damping: ds1 * mu / g + s1 * drive,
                }
            }
            Family::LuGreClassical | Family::LuGreInside | Family::Dahl => {
                let relaxation = s0 * (dn / g + n * dmu / (g * g));
                Affine {
                    relaxation,
                    drive: 0.0,
                    stiffness: ds1 * s0 * n / g + s1 * relaxation,
                    damping: ds1,
                }
            }
        }
    }

    /// Sums of the absolute values of the terms of the derivatives with respect to α, e.g.
    /// σ0|v|_ε/g − ασ0|v|_ε σ1|v|_ε/g² for λ.
    pub fn alpha_terms(&self, v: f64, z: f64) -> Affine<f64> {
        let (s0, s1, mu, n) = (self.sigma0(v), self.sigma1(v), self.mu(v), self.speed(v));
        let g = self.resistance(v, z);
        let drive = mu * s1 * n / (g * g);
        Affine {
            relaxation: s0 * n / g * (1.0 + s1 * n / g),
            drive,
            stiffness: s0 * drive,
            damping: s1 * drive,
        }
    }

    /// Sums of the absolute values of the terms of the partial derivatives of ż = −λz + rv and
    /// μ_b = c₀z + c₂v, by the product rule and through α.
    pub fn partials_terms(&self, v: f64, z: f64) -> Partials {
        if self.family == Family::Implicit {
            let at = self.at_tip(v, z);
            let (s0, s1, share) =
                (self.sigma0(v), self.sigma1(v), at.slope_terms / at.slope * at.rough);
            return Partials {
                rate_by_deflection: s0 / at.slope * at.rough,
                rate_by_velocity: share,
                coefficient_by_deflection: s0 * share,
                coefficient_by_velocity: s1 * share,
            };
        }
        let (terms, slopes) = (self.terms(v, z), self.slope_terms(v, z));
        let (by_alpha, alpha) = (self.alpha_terms(v, z), self.alpha_slopes_terms(v, z).0);
        let (v, z) = (v.abs(), z.abs());
        Partials {
            rate_by_deflection: terms.relaxation
                + alpha * (by_alpha.relaxation * z + by_alpha.drive * v),
            rate_by_velocity: slopes.relaxation * z + slopes.drive * v + terms.drive,
            coefficient_by_deflection: terms.stiffness
                + alpha * (by_alpha.stiffness * z + by_alpha.damping * v),
            coefficient_by_velocity: slopes.stiffness * z + slopes.damping * v + terms.damping,
        }
    }

    /// What a unit error of α makes of the dissipated power: α is a difference, ½ + ½ sin(…), so
    /// its error is relative to one and not to itself.
    pub fn power_by_alpha(&self, v: f64, z: f64) -> f64 {
        if !self.in_transition(v, z) {
            return 0.0;
        }
        let by_alpha = self.alpha_terms(v, z);
        self.recipe.load * (self.storage() * by_alpha.relaxation * z * z + by_alpha.damping * v * v)
    }

    /// Sums of the absolute values of the terms of ∂α/∂z and ∂α/∂v. The phase of the sine runs
    /// over π between z_b and z_m, so |∂α/∂z| ≤ π/2/(z_m − z_b); z_m = μ(v)/σ0 moves it as fast.
    pub fn alpha_slopes_terms(&self, v: f64, z: f64) -> (f64, f64) {
        if !self.in_transition(v, z) {
            return (0.0, 0.0);
        }
        let width = self.mu(v) / self.sigma0(v) - self.stick_limit();
        let by_deflection = std::f64::consts::FRAC_PI_2 / width;
        (by_deflection, by_deflection * self.mu_slope_terms(v) / self.sigma0(v))
    }
}

/// The monotone cubic through knots, in the Hermite basis, with Brodlie's form of the
/// Fritsch–Butland slopes: 1/d = α/Δ₁ + (1 − α)/Δ₂ … with α = (h₁ + 2h₂)/(3(h₁ + h₂)).
#[derive(Debug, Clone, Copy)]
pub struct Table<const N: usize>(pub [(f64, f64); N]);

impl<const N: usize> Table<N> {
    fn secant(&self, i: usize) -> (f64, f64) {
        let ((s0, m0), (s1, m1)) = (self.0[i], self.0[i + 1]);
        ((m1 - m0) / (s1 - s0), s1 - s0)
    }

    /// The slope at knot i.
    pub fn slope(&self, i: usize) -> f64 {
        let end = |(near, h0): (f64, f64), (next, h1): (f64, f64)| {
            // Derivative of the parabola through three points, at the first.
            let slope = near + (near - next) * h0 / (h0 + h1);
            if slope * near <= 0.0 {
                0.0
            } else if near * next <= 0.0 && slope.abs() > 3.0 * near.abs() {
                3.0 * near
            } else {
                slope
            }
        };
        let slope = if N == 2 {
            self.secant(0).0
        } else if i == 0 {
            end(self.secant(0), self.secant(1))
        } else if i == N - 1 {
            self.secant(N - 2).0
        } else {
            let ((d1, h1), (d2, h2)) = (self.secant(i - 1), self.secant(i));
            let a = (h1 + 2.0 * h2) / (3.0 * (h1 + h2));
            if d1 * d2 > 0.0 { d1 * d2 / (a * d2 + (1.0 - a) * d1) } else { 0.0 }
        };
        // Beyond the last knot the curve is level if it falls there.
        if i == N - 1 { slope.max(0.0) } else { slope }
    }

    fn interval(&self, s: f64) -> usize {
        self.0.iter().rposition(|knot| knot.0 <= s).unwrap_or(0)
    }

    /// The curve at a speed.
    pub fn value(&self, s: f64) -> f64 {
        let i = self.interval(s);
        let (start, m0) = self.0[i];
        if i == N - 1 {
            return m0 + self.slope(i) * (s - start);
        }
        let (_, h) = self.secant(i);
        let t = (s - start) / h;
        let m1 = self.0[i + 1].1;
        (1.0 + 2.0 * t) * (1.0 - t).powi(2) * m0
            + t * (1.0 - t).powi(2) * h * self.slope(i)
            + t * t * (3.0 - 2.0 * t) * m1
            + t * t * (t - 1.0) * h * self.slope(i + 1)
    }

    /// Sum of the absolute values of the terms of its slope.
    pub fn slope_terms(&self, s: f64) -> f64 {
        let i = self.interval(s);
        if i == N - 1 {
            self.slope(i)
        } else {
            6.0 * self.secant(i).0.abs() + 4.0 * (self.slope(i).abs() + self.slope(i + 1).abs())
        }
    }
}
