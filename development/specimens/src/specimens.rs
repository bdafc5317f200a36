//! Every implementor, built from one recipe in any scalar type, beside its closed form.

use bristle::curve::{
    Asymmetric, Coulomb, CoulombParameters, Cubic, FrictionCurve, FunctionCurve, Knot,
    RationalStribeck, RationalStribeckParameters, Stribeck, StribeckParameters, Tabulated,
};
use bristle::regularisation::{HyperbolicTangent, Regularisation, SquareRoot, Unregularised};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{
    Affine, Bounds, Bristle, Contact, ContactLimits, Dahl, DahlParameters, ElastoPlastic, Form,
    FrBd, HeldContact, HeldStep, ImplicitBristle, Law, Limits, LinearisedContact, LuGre, Scalar,
    Sliding, Surface,
};

use super::closed_form::{
    ClosedForm, Curve, DAMPING_VARIATION, Element, Family, Modulus, STIFFNESS_VARIATION,
};
use super::lit;
use super::own_rheology::{VelocityLaw, own_element};
use super::recipe::Recipe;

/// A contact of any model with a single deflection, behind one pointer.
pub trait Subject<T: Scalar> {
    fn affine(&self, surface: Surface<T>, z: T) -> Affine<T>;
    fn affine_and_slopes(&self, surface: Surface<T>, z: T) -> (Affine<T>, Affine<T>);
    fn response(&self, surface: Surface<T>, z: T) -> (T, T);
    fn rate(&self, surface: Surface<T>, z: T) -> T;
    fn force(&self, surface: Surface<T>, z: T) -> T;
    fn linearised(&self, surface: Surface<T>, z: T) -> LinearisedContact<T>;
    fn stationary(&self, surface: Surface<T>) -> T;
    fn stationary_force(&self, surface: Surface<T>) -> T;
    fn stored_energy(&self, z: T) -> T;
    fn dissipated_power(&self, surface: Surface<T>, z: T) -> T;
    fn limits(&self, fastest: T) -> ContactLimits<T>;
    fn hold(&self, velocity: T, z: T, duration: T) -> HeldContact<T>;
    fn held(&self, surface: Surface<T>, z: T, duration: T) -> HeldStep<T>;
    fn holding_coefficient(&self, surface: Surface<T>, carried: T) -> T;
    fn form(&self) -> Form;
    fn obeys(&self, law: Law) -> bool;
    fn steady_linearised(&self, surface: Surface<T>) -> LinearisedContact<T>;
}

impl<T: Scalar, M: Bristle<T, Deflection = T>> Subject<T> for Contact<T, M> {
    fn affine(&self, surface: Surface<T>, z: T) -> Affine<T> {
        self.model().affine(surface, z)
    }
    fn affine_and_slopes(&self, surface: Surface<T>, z: T) -> (Affine<T>, Affine<T>) {
        self.model().affine_and_slopes(surface, z)
    }
    fn response(&self, surface: Surface<T>, z: T) -> (T, T) {
        let response = Contact::response(self, surface, z);
        (response.rate, response.force)
    }
    fn rate(&self, surface: Surface<T>, z: T) -> T {
        Contact::rate(self, surface, z)
    }
    fn force(&self, surface: Surface<T>, z: T) -> T {
        Contact::force(self, surface, z)
    }
    fn linearised(&self, surface: Surface<T>, z: T) -> LinearisedContact<T> {
        Contact::linearised(self, surface, z)
    }
    fn stationary(&self, surface: Surface<T>) -> T {
        Contact::stationary(self, surface)
    }
    fn stationary_force(&self, surface: Surface<T>) -> T {
        Contact::stationary_force(self, surface)
    }
    fn stored_energy(&self, z: T) -> T {
        Contact::stored_energy(self, z)
    }
    fn dissipated_power(&self, surface: Surface<T>, z: T) -> T {
        Contact::dissipated_power(self, surface, z)
    }
    fn limits(&self, fastest: T) -> ContactLimits<T> {
        Contact::limits(self, fastest)
    }
    fn hold(&self, velocity: T, z: T, duration: T) -> HeldContact<T> {
        Contact::hold(self, velocity, z, duration)
    }
    fn held(&self, surface: Surface<T>, z: T, duration: T) -> HeldStep<T> {
        self.model().hold(surface, z, duration)
    }
    fn steady_linearised(&self, surface: Surface<T>) -> LinearisedContact<T> {
        Contact::steady_linearised(self, surface)
    }
    fn holding_coefficient(&self, surface: Surface<T>, carried: T) -> T {
        self.model().holding_coefficient(surface, carried)
    }
    fn form(&self) -> Form {
        self.model().form()
    }
    fn obeys(&self, law: Law) -> bool {
        self.model().obeys(law)
    }
}

/// A model under its normal force, and what it should be.
pub struct Specimen<T: Scalar> {
    pub subject: Box<dyn Subject<T>>,
    pub form: ClosedForm,
}

impl<T: Scalar> Specimen<T> {
    /// What stands in a failure message.
    pub fn name(&self) -> String {
        let ClosedForm { family, curve, modulus, stiffness, damping, .. } = self.form;
        format!("{family:?}<{curve:?}, σ0 {stiffness:?}, σ1 {damping:?}, {modulus:?}>")
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

/// A specimen as a model again, for what takes any model.
#[derive(Clone, Copy)]
pub struct AsModel<'a, T: Scalar>(pub &'a Specimen<T>);

impl<T: Scalar> core::fmt::Debug for AsModel<'_, T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.0.name())
    }
}

impl<T: Scalar> Bristle<T> for AsModel<'_, T> {
    type Deflection = T;

    fn affine(&self, surface: Surface<T>, z: T) -> Affine<T> {
        self.0.subject.affine(surface, z)
    }
    fn affine_and_slopes(&self, surface: Surface<T>, z: T) -> (Affine<T>, Affine<T>) {
        self.0.subject.affine_and_slopes(surface, z)
    }
    fn stationary(&self, surface: impl Into<Surface<T>>) -> T {
        self.0.subject.stationary(surface.into())
    }
    fn storage_stiffness(&self) -> T {
        lit(self.0.form.storage())
    }
    fn holding_coefficient(&self, surface: Surface<T>, carried: T) -> T {
        self.0.subject.holding_coefficient(surface, carried)
    }
    fn form(&self) -> Form {
        self.0.subject.form()
    }
    fn obeys(&self, law: Law) -> bool {
        self.0.subject.obeys(law)
    }
    fn limits(&self, fastest: T) -> Limits<T> {
        let ContactLimits { deflection, force, relaxation_rate } = self.0.subject.limits(fastest);
        let coefficient = force.map(|force| force / lit(self.0.form.recipe.load));
        Limits { deflection, coefficient, relaxation_rate }
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
    let form = ClosedForm {
        recipe: Recipe { viscous: 0.0, ..*recipe },
        family: Family::Dahl,
        curve: Curve::Coulomb,
        modulus: Modulus::Exact,
        stiffness: Element::Constant,
        damping: Element::None,
        scale: 1.0,
    };
    push(&mut list, form, dahl(recipe));
    list
}

/// One model in each regularisation.
macro_rules! in_each_regularisation {
    ($list:expr, $form:expr, $model:expr) => {{
        let (form, model) = ($form, $model);
        let recipe = &form.recipe;
        push($list, ClosedForm { modulus: Modulus::Exact, ..form }, model.clone());
        push(
            $list,
            ClosedForm { modulus: Modulus::SquareRoot, ..form },
            model.clone().regularised(square_root(recipe)),
        );
        push(
            $list,
            ClosedForm { modulus: Modulus::HyperbolicTangent, ..form },
            model.regularised(hyperbolic_tangent(recipe)),
        );
    }};
}

/// Every model that has a curve. One line each.
fn with_curve<T: Scalar, C: FrictionCurve<T> + 'static>(
    list: &mut Vec<Specimen<T>>,
    r: &Recipe,
    curve: Curve,
    c: C,
) {
    use Element::{Constant, Even, None, Varying};
    let form = |family, stiffness, damping| ClosedForm {
        recipe: *r,
        family,
        curve,
        modulus: Modulus::Exact,
        stiffness,
        damping,
        scale: 1.0,
    };
    let frbd = |stiffness, damping| form(Family::FrBd, stiffness, damping);
    let (k, d): (T, T) = (lit(r.stiffness), lit(r.damping));
    let (k_varying, d_varying) = (varying_stiffness(r), varying_damping(r));

    in_each_regularisation!(list, frbd(Constant, None), FrBd::new(c.clone(), spring(k)));
    in_each_regularisation!(
        list,
        frbd(Constant, Constant),
        FrBd::new(c.clone(), kelvin_voigt(k, d))
    );
    in_each_regularisation!(
        list,
        frbd(Constant, Varying),
        FrBd::new(c.clone(), own_element(k, d_varying))
    );
    push(list, frbd(Constant, Even), FrBd::new(c.clone(), own_element(k, even_damping(r))));
    in_each_regularisation!(
        list,
        frbd(Varying, Constant),
        FrBd::new(c.clone(), own_element(k_varying.clone(), d))
    );
    push(list, frbd(Varying, None), FrBd::new(c.clone(), own_element(k_varying, T::zero())));

    in_each_regularisation!(
        list,
        form(Family::LuGreClassical, Constant, Constant),
        LuGre::classical(c.clone(), kelvin_voigt(k, d))
    );
    push(
        list,
        form(Family::LuGreClassical, Constant, None),
        LuGre::classical(c.clone(), kelvin_voigt(k, T::zero())),
    );
    in_each_regularisation!(
        list,
        form(Family::LuGreInside, Constant, Constant),
        lugre_inside(c.clone(), kelvin_voigt(k, d))
    );
    let stick_limit = lit(form(Family::ElastoPlastic, Constant, Constant).stick_limit());
    in_each_regularisation!(
        list,
        form(Family::ElastoPlastic, Constant, Constant),
        elasto_plastic(c.clone(), kelvin_voigt(k, d), stick_limit)
    );

    // Damped enough to have a single solution, where that can be: just so, and amply.
    let fall = curve.steepest_fall(r);
    if fall.is_finite() {
        for ample in [1.001, 1.5] {
            let r = Recipe { damping: ample * fall + r.damping + 1e-2, ..*r };
            let form = ClosedForm { recipe: r, ..form(Family::Implicit, Constant, Constant) };
            push(list, form, implicit(c.clone(), kelvin_voigt(k, lit(r.damping))));
        }
    }
}

fn push<T: Scalar, M: Bristle<T, Deflection = T> + 'static>(
    list: &mut Vec<Specimen<T>>,
    form: ClosedForm,
    model: M,
) {
    let contact = model.under_load(lit(form.recipe.load)).unwrap();
    list.push(Specimen { subject: Box::new(contact), form });
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

/// A friction curve behind one pointer.
pub trait CurveSubject<T: Scalar> {
    fn at(&self, velocity: T) -> T;
    fn coefficient(&self, sliding: Sliding<T>) -> T;
    fn coefficient_and_slope(&self, sliding: Sliding<T>) -> (T, T);
    fn bounds(&self, fastest: T) -> Bounds<T>;
    fn viscous_friction(&self) -> T;
    fn without_viscous_friction(&self) -> Box<dyn CurveSubject<T>>;
    fn is_even(&self) -> bool;
    fn least_slope(&self) -> Option<T>;
}

impl<T: Scalar, C: FrictionCurve<T> + 'static> CurveSubject<T> for C {
    fn at(&self, velocity: T) -> T {
        FrictionCurve::at(self, velocity)
    }
    fn coefficient(&self, sliding: Sliding<T>) -> T {
        FrictionCurve::coefficient(self, sliding)
    }
    fn coefficient_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        FrictionCurve::coefficient_and_slope(self, sliding)
    }
    fn bounds(&self, fastest: T) -> Bounds<T> {
        FrictionCurve::bounds(self, fastest)
    }
    fn viscous_friction(&self) -> T {
        FrictionCurve::viscous_friction(self)
    }
    fn without_viscous_friction(&self) -> Box<dyn CurveSubject<T>> {
        Box::new(FrictionCurve::without_viscous_friction(self))
    }
    fn is_even(&self) -> bool {
        FrictionCurve::is_even(self)
    }
    fn least_slope(&self) -> Option<T> {
        FrictionCurve::least_slope(self)
    }
}

/// Every curve.
pub fn curves<T: Scalar>(r: &Recipe) -> Vec<(Curve, Box<dyn CurveSubject<T>>)> {
    vec![
        (Curve::Coulomb, Box::new(coulomb(r))),
        (Curve::Stribeck(1.0), Box::new(stribeck(r, 1.0))),
        (Curve::Stribeck(2.0), Box::new(stribeck(r, 2.0))),
        (Curve::Stribeck(0.7), Box::new(stribeck(r, 0.7))),
        (Curve::Stribeck(3.3), Box::new(stribeck(r, 3.3))),
        (Curve::Rational, Box::new(rational(r))),
        (Curve::Tabulated, Box::new(tabulated(r))),
        (Curve::Asymmetric, Box::new(asymmetric(r))),
        (Curve::Function, Box::new(function(r))),
    ]
}

/// A regularisation behind one pointer.
pub trait ModulusSubject<T: Scalar> {
    fn speed(&self, sliding: Sliding<T>) -> T;
    fn speed_and_slope(&self, sliding: Sliding<T>) -> (T, T);
    fn sign(&self, sliding: Sliding<T>) -> T;
    fn sign_and_slope(&self, sliding: Sliding<T>) -> (T, T);
    fn speed_at_rest(&self) -> T;
}

impl<T: Scalar, E: Regularisation<T>> ModulusSubject<T> for E {
    fn speed(&self, sliding: Sliding<T>) -> T {
        Regularisation::speed(self, sliding)
    }
    fn speed_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        Regularisation::speed_and_slope(self, sliding)
    }
    fn sign(&self, sliding: Sliding<T>) -> T {
        Regularisation::sign(self, sliding)
    }
    fn sign_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        Regularisation::sign_and_slope(self, sliding)
    }
    fn speed_at_rest(&self) -> T {
        Regularisation::speed_at_rest(self)
    }
}

/// Every regularisation.
pub fn regularisations<T: Scalar>(r: &Recipe) -> Vec<(Modulus, Box<dyn ModulusSubject<T>>)> {
    vec![
        (Modulus::Exact, Box::new(Unregularised)),
        (Modulus::SquareRoot, Box::new(square_root(r))),
        (Modulus::HyperbolicTangent, Box::new(hyperbolic_tangent(r))),
    ]
}
