//! Every implementor, built from one recipe in any scalar type, beside its closed form.

use bristle::curve::{
    AnyCurve, Asymmetric, Coulomb, CoulombParameters, Cubic, FrictionCurve, FunctionCurve, Knot,
    RationalStribeck, RationalStribeckParameters, Stribeck, StribeckParameters, Tabulated,
};
use bristle::regularisation::{AnyRegularisation, HyperbolicTangent, SquareRoot, Unregularised};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{
    Affine, AnyBristle, Bounds, Bristle, Contact, Dahl, DahlParameters, ElastoPlastic, FrBd,
    ImplicitBristle, LuGre, Scalar, Surface,
};

use super::closed_form::{
    ClosedForm, Curve, DAMPING_VARIATION, Element, Family, Modulus, STIFFNESS_VARIATION,
};
use super::lit;
use super::own_rheology::{VelocityLaw, own_element};
use super::recipe::Recipe;

/// A model under its normal force, and what it should be.
pub struct Specimen<T: Scalar> {
    pub subject: Contact<T, AnyBristle<T>>,
    pub form: ClosedForm,
}

impl<T: Scalar> Specimen<T> {
    /// The model by itself.
    pub fn model(&self) -> AnyBristle<T> {
        self.subject.model().clone()
    }

    /// The same under s times its normal force, which scales its friction and leaves its stiffness.
    /// An implicit bristle that is just damped enough has several tips above one, and is at one.
    pub fn under(self, scale: f64) -> Self {
        let (load, scale) =
            (self.form.recipe.load, if self.is_implicit() { scale.min(1.0) } else { scale });
        let subject = self.model().under_load(lit(scale * load)).unwrap();
        let subject = subject.measured_at(lit(load)).unwrap();
        Self { subject, form: self.form.scaled(scale) }
    }

    /// μ/σ0 of the reference load \[m\].
    pub fn full_deflection(&self, v: f64) -> f64 {
        self.form.mu(v) / self.form.recipe.stiffness
    }

    /// What stands in a failure message.
    pub fn name(&self) -> String {
        let ClosedForm { family, curve, modulus, stiffness, damping, scale, .. } = self.form;
        format!(
            "{family:?}<{curve:?}, σ0 {stiffness:?}, σ1 {damping:?}, {modulus:?}>, s = {scale:e}"
        )
    }

    /// Whether a step freezes what depends on the deflection (α), or follows it (the tip velocity).
    pub fn freezes(&self) -> bool {
        self.form.family == Family::ElastoPlastic || self.is_implicit()
    }

    /// Whether the tip velocity is solved for.
    pub fn is_implicit(&self) -> bool {
        self.form.family == Family::Implicit
    }

    /// Whether the model is a case of FrBD.
    pub fn is_frbd(&self) -> bool {
        matches!(self.form.family, Family::FrBd | Family::Dahl)
    }
}

/// Every model.
pub fn specimens<T: Scalar>(recipe: &Recipe) -> Vec<Specimen<T>> {
    let mut list = Vec::new();
    // One line per curve …
    with_curve(&mut list, recipe, Curve::Coulomb, coulomb(recipe));
    with_curve(&mut list, recipe, Curve::Stribeck(1.0), stribeck(recipe, 1.0));
    with_curve(&mut list, recipe, Curve::Stribeck(2.0), stribeck(recipe, 2.0));
    with_curve(&mut list, recipe, Curve::Stribeck(0.7), stribeck(recipe, 0.7));
    with_curve(&mut list, recipe, Curve::Stribeck(3.3), stribeck(recipe, 3.3));
    with_curve(&mut list, recipe, Curve::Rational, rational(recipe));
    with_curve(&mut list, recipe, Curve::Tabulated, tabulated(recipe));
    with_curve(&mut list, recipe, Curve::Asymmetric, asymmetric(recipe));
    with_curve(&mut list, recipe, Curve::Function, function(recipe));
    // … and one per model that has no curve of its own.
    let dry = Recipe { viscous: 0.0, ..*recipe };
    let elements = (Element::Constant, Element::None);
    let form = ClosedForm::new(&dry, Family::Dahl, Curve::Coulomb, elements);
    push(&mut list, form, dahl(recipe));
    list
}

/// Every model that has a curve. One line each.
fn with_curve<T: Scalar, C: FrictionCurve<T> + Send + Sync + 'static>(
    list: &mut Vec<Specimen<T>>,
    r: &Recipe,
    curve: Curve,
    c: C,
) {
    use Element::{Constant, Even, None, Varying};
    let form = |family, elements| ClosedForm::new(r, family, curve, elements);
    /// One model.
    macro_rules! one {
        ($family:ident, $elements:expr, $model:expr) => {
            push(list, form(Family::$family, $elements), $model)
        };
    }
    /// One model in each regularisation.
    macro_rules! each {
        ($family:ident, $elements:expr, $model:expr) => {
            let (form, model) = (form(Family::$family, $elements), $model);
            push(list, form, model.clone());
            let smooth = model.clone().regularised(square_root(r));
            push(list, ClosedForm { modulus: Modulus::SquareRoot, ..form }, smooth);
            let smooth = model.regularised(hyperbolic_tangent(r));
            push(list, ClosedForm { modulus: Modulus::HyperbolicTangent, ..form }, smooth);
        };
    }
    let (k, d): (T, T) = (lit(r.stiffness), lit(r.damping));
    let (own_k, own_d) = (varying_stiffness(r), varying_damping(r));
    let both = (Constant, Constant);
    let (c, damped, undamped) = (|| c.clone(), || kelvin_voigt(k, d), || spring(k));

    each!(FrBd, (Constant, None), FrBd::new(c(), undamped()));
    each!(FrBd, both, FrBd::new(c(), damped()));
    each!(FrBd, (Constant, Varying), FrBd::new(c(), own_element(k, own_d)));
    one!(FrBd, (Constant, Even), FrBd::new(c(), own_element(k, even_damping(r))));
    each!(FrBd, (Varying, Constant), FrBd::new(c(), own_element(own_k.clone(), d)));
    one!(FrBd, (Varying, None), FrBd::new(c(), own_element(own_k, T::zero())));
    each!(LuGreClassical, both, LuGre::classical(c(), damped()));
    one!(LuGreClassical, (Constant, None), LuGre::classical(c(), undamped()));
    each!(LuGreInside, both, lugre_inside(c(), damped()));
    let stick_limit = lit(form(Family::ElastoPlastic, both).stick_limit());
    each!(ElastoPlastic, both, elasto_plastic(c(), damped(), stick_limit));

    // Damped enough to have a single solution, where that can be: just so, and amply.
    let fall = curve.steepest_fall(r);
    if fall.is_finite() {
        for ample in [1.001, 1.5] {
            let r = Recipe { damping: ample * fall + r.damping + 1e-2, ..*r };
            let form = ClosedForm::new(&r, Family::Implicit, curve, both);
            push(list, form, implicit(c(), kelvin_voigt(k, lit(r.damping))));
        }
    }
}

fn push<T: Scalar, M: Bristle<T, Deflection = T> + Send + Sync + 'static>(
    list: &mut Vec<Specimen<T>>,
    form: ClosedForm,
    model: M,
) {
    let subject = AnyBristle::own(model).under_load(lit(form.recipe.load)).unwrap();
    list.push(Specimen { subject, form });
}

pub fn coulomb<T: Scalar>(r: &Recipe) -> Coulomb<T> {
    Coulomb::new(CoulombParameters {
        dynamic_coefficient: lit(r.dynamic),
        viscous_friction: lit(r.viscous),
    })
    .unwrap()
}

pub fn stribeck<T: Scalar>(r: &Recipe, exponent: f64) -> Stribeck<T> {
    Stribeck::new(StribeckParameters {
        static_coefficient: lit(r.static_),
        dynamic_coefficient: lit(r.dynamic),
        stribeck_velocity: lit(r.stribeck_velocity),
        stribeck_exponent: lit(exponent),
        viscous_friction: lit(r.viscous),
    })
    .unwrap()
}

/// Curve and bristle of the paper's Table 2.
pub fn table_2<T: Scalar>() -> (Stribeck<T>, KelvinVoigt<T>) {
    let r = Recipe::TABLE_2;
    (stribeck(&r, 2.0), kelvin_voigt(lit(r.stiffness), lit(r.damping)))
}

pub fn table_2_curve<T: Scalar>() -> Stribeck<T> {
    table_2().0
}

pub fn table_2_bristle<T: Scalar>() -> KelvinVoigt<T> {
    table_2().1
}

pub fn table_2_frbd<T: Scalar>() -> FrBd<Stribeck<T>, KelvinVoigt<T>> {
    let (curve, bristle) = table_2();
    FrBd::new(curve, bristle)
}

pub fn table_2_lugre<T: Scalar>() -> LuGre<Stribeck<T>, KelvinVoigt<T>, Unregularised, T> {
    let (curve, bristle) = table_2();
    LuGre::classical(curve, bristle)
}

/// A model that says no more of itself than it has to.
#[derive(Debug, Clone)]
pub struct Bare<M>(pub M);

impl<T: Scalar, M: Bristle<T, Deflection = T>> Bristle<T> for Bare<M> {
    type Deflection = T;

    fn affine(&self, surface: Surface<T>, z: T) -> Affine<T> {
        self.0.affine(surface, z)
    }

    fn affine_and_slopes(&self, surface: Surface<T>, z: T) -> (Affine<T>, Affine<T>) {
        self.0.affine_and_slopes(surface, z)
    }

    fn stationary(&self, surface: impl Into<Surface<T>>) -> T {
        self.0.stationary(surface)
    }

    fn storage_stiffness(&self) -> T {
        self.0.storage_stiffness()
    }
}

pub fn rational<T: Scalar>(r: &Recipe) -> RationalStribeck<T> {
    RationalStribeck::new(RationalStribeckParameters {
        static_coefficient: lit(r.static_),
        dynamic_coefficient: lit(r.dynamic),
        stribeck_velocity: lit(r.stribeck_velocity),
        viscous_friction: lit(r.viscous),
    })
    .unwrap()
}

pub fn tabulated<T: Scalar>(r: &Recipe) -> Tabulated<[Cubic<T>; 5]> {
    table(r.knots())
}

/// A table from pairs of speed and coefficient.
pub fn table<T: Scalar, const N: usize>(knots: [(f64, f64); N]) -> Tabulated<[Cubic<T>; N]> {
    Tabulated::new(knots.map(|(speed, mu)| Knot { speed: lit(speed), coefficient: lit(mu) }))
        .unwrap()
}

pub fn asymmetric<T: Scalar>(r: &Recipe) -> Asymmetric<Stribeck<T>, Coulomb<T>> {
    Asymmetric { forward: stribeck(r, 2.0), backward: coulomb(&Recipe { viscous: 0.0, ..*r }) }
}

pub fn function<T: Scalar>(r: &Recipe) -> FunctionCurve<T, impl Fn(T) -> (T, T) + Clone + use<T>> {
    let (dynamic, v_s): (T, T) = (lit(r.dynamic), lit(r.stribeck_velocity));
    FunctionCurve::new(
        move |speed: T| {
            let u = speed / v_s;
            let square = T::one() + u * u;
            let fall = lit::<T>(0.5) / square.sqrt();
            (dynamic * (T::one() + fall), -dynamic * fall * u / square / v_s)
        },
        Bounds { min: dynamic, max: dynamic * lit(1.5) },
    )
    .unwrap()
    // −½ μ_d u/(1 + u²)^(3/2)/v_S is least at u² = ½.
    .with_least_slope(-lit::<T>(3.0).sqrt() / lit(9.0) * dynamic / v_s)
    .unwrap()
}

pub fn varying_stiffness<T: Scalar>(r: &Recipe) -> VelocityLaw<T> {
    VelocityLaw::varying(r.stiffness, STIFFNESS_VARIATION, r.varying_velocity)
}

pub fn varying_damping<T: Scalar>(r: &Recipe) -> VelocityLaw<T> {
    VelocityLaw::varying(r.damping, DAMPING_VARIATION, r.varying_velocity)
}

/// c (1 + a/(1 + u²)) with u = |v|/v_d.
pub fn even_damping<T: Scalar>(r: &Recipe) -> VelocityLaw<T> {
    let (c, a, v_d): (T, T, T) = (lit(r.damping), lit(DAMPING_VARIATION), lit(r.varying_velocity));
    VelocityLaw::of_speed(
        move |speed: T| {
            let u = speed / v_d;
            let share = a / (T::one() + u * u);
            (c * (T::one() + share), -c * share * (u + u) / (T::one() + u * u) / v_d)
        },
        Bounds { min: c, max: c * (T::one() + a) },
    )
}

pub fn spring<T: Scalar>(micro_stiffness: T) -> KelvinVoigt<T> {
    kelvin_voigt(micro_stiffness, T::zero())
}

pub fn kelvin_voigt<T: Scalar>(micro_stiffness: T, micro_damping: T) -> KelvinVoigt<T> {
    KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness, micro_damping }).unwrap()
}

/// The LuGre model whose g is the whole curve.
pub fn lugre_inside<T: Scalar, C: FrictionCurve<T>>(
    curve: C,
    rheology: KelvinVoigt<T>,
) -> LuGre<C, KelvinVoigt<T>, Unregularised, T> {
    LuGre::with_viscous_friction(curve, rheology, T::zero()).unwrap()
}

pub fn elasto_plastic<T: Scalar, C: FrictionCurve<T>>(
    curve: C,
    rheology: KelvinVoigt<T>,
    stick_limit: T,
) -> ElastoPlastic<C, KelvinVoigt<T>, Unregularised, T> {
    ElastoPlastic::new(curve, rheology, stick_limit).unwrap()
}

pub fn implicit<T: Scalar, C: FrictionCurve<T>>(
    curve: C,
    rheology: KelvinVoigt<T>,
) -> ImplicitBristle<C, T> {
    ImplicitBristle::new(curve, rheology).unwrap()
}

pub fn dahl<T: Scalar>(r: &Recipe) -> Dahl<T> {
    Dahl::new(DahlParameters {
        dynamic_coefficient: lit(r.dynamic),
        micro_stiffness: lit(r.stiffness),
    })
    .unwrap()
}

pub fn square_root<T: Scalar>(r: &Recipe) -> SquareRoot<T> {
    SquareRoot::new(lit(r.epsilon)).unwrap()
}

pub fn hyperbolic_tangent<T: Scalar>(r: &Recipe) -> HyperbolicTangent<T> {
    HyperbolicTangent::new(lit(r.threshold)).unwrap()
}

/// Every curve.
pub fn curves<T: Scalar>(r: &Recipe) -> Vec<(Curve, AnyCurve<T>)> {
    vec![
        (Curve::Coulomb, AnyCurve::own(coulomb(r))),
        (Curve::Stribeck(1.0), AnyCurve::own(stribeck(r, 1.0))),
        (Curve::Stribeck(2.0), AnyCurve::own(stribeck(r, 2.0))),
        (Curve::Stribeck(0.7), AnyCurve::own(stribeck(r, 0.7))),
        (Curve::Stribeck(3.3), AnyCurve::own(stribeck(r, 3.3))),
        (Curve::Rational, AnyCurve::own(rational(r))),
        (Curve::Tabulated, AnyCurve::own(tabulated(r))),
        (Curve::Asymmetric, AnyCurve::own(asymmetric(r))),
        (Curve::Function, AnyCurve::own(function(r))),
    ]
}

/// Every regularisation.
pub fn regularisations<T: Scalar>(r: &Recipe) -> Vec<(Modulus, AnyRegularisation<T>)> {
    vec![
        (Modulus::Exact, Unregularised.into()),
        (Modulus::SquareRoot, square_root(r).into()),
        (Modulus::HyperbolicTangent, hyperbolic_tangent(r).into()),
    ]
}
