//! Every viscoelastic bristle, built from one recipe, beside its formula.

use bristle::rheology::{
    Deflection, GeneralisedMaxwell, GeneralisedMaxwellParameters, Maxwell, MaxwellArm,
    MaxwellParameters, Rheology, ZenerParameters,
};
use bristle::{Bristle, Contact, ContactLimits, FrBd, Law, Scalar};
use nalgebra::SVector;
use proptest::prelude::*;

use super::closed_form::Curve;
use super::own_rheology::{OwnArms, VelocityLaw};
use super::recipe::{Recipe, decades, recipe, scale, velocity};
use super::specimens::{square_root, stribeck};
use super::{check, lit};

/// Springs and dashpots of up to five arms.
#[derive(Debug, Clone, Copy)]
pub struct Parts {
    pub stiffness: [f64; 5],
    pub series: [f64; 5],
    pub beside: f64,
}

pub fn parts() -> impl Strategy<Value = Parts> {
    (
        prop::array::uniform5(decades(1e1, 1e8)),
        prop::array::uniform5(decades(1e-2, 1e6)),
        decades(1e-2, 1e4),
    )
        .prop_map(|(stiffness, series, beside)| Parts { stiffness, series, beside })
}

/// Damping c (1 + ½ u/√(1 + u²)), u = v/v_d: larger forward than backward.
pub fn varying<T: Scalar>(r: &Recipe, c: f64) -> VelocityLaw<T> {
    VelocityLaw::varying(c, 0.5, r.varying_velocity)
}

/// How a damping depends on the velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    Constant,
    Varying,
}

/// What a bristle is made of, in plain numbers: arms (Kᵢ, ηᵢ) and the dashpot beside them.
#[derive(Debug, Clone)]
pub struct Form {
    pub arms: Vec<(f64, Option<f64>)>,
    pub series: Change,
    pub beside: f64,
    pub beside_law: Change,
    pub name: &'static str,
    pub regularised: bool,
    pub recipe: Recipe,
    /// Friction scale s.
    pub scale: f64,
}

impl Form {
    pub fn factor(&self, law: Change, v: f64) -> f64 {
        let u = v / self.recipe.varying_velocity;
        if law == Change::Constant { 1.0 } else { 1.0 + 0.5 * u / 1.0_f64.hypot(u) }
    }
    pub fn decay(&self, v: f64) -> Vec<f64> {
        let series = |eta: f64| eta * self.factor(self.series, v);
        self.arms.iter().map(|(k, eta)| eta.map_or(0.0, |eta| k / series(eta))).collect()
    }
    pub fn damping(&self, v: f64) -> f64 {
        self.beside * self.factor(self.beside_law, v)
    }
    pub fn speed(&self, v: f64) -> f64 {
        if self.regularised { v.hypot(self.recipe.epsilon.sqrt()) } else { v.abs() }
    }
    pub fn mu(&self, v: f64) -> f64 {
        self.scale * Curve::Stribeck(2.0).mu(&self.recipe, v)
    }
    pub fn creeps(&self) -> bool {
        self.arms.iter().all(|arm| arm.1.is_some())
    }
    pub fn is_linear(&self) -> bool {
        self.series == Change::Constant
    }
    /// Σ Kᵢ|xᵢ| and Σ Kᵢxᵢ.
    pub fn carried(&self, x: &[f64]) -> (f64, f64) {
        let terms = self.arms.iter().zip(x).map(|(arm, x)| arm.0 * x);
        terms.fold((0.0, 0.0), |(size, sum), term| (size + term.abs(), sum + term))
    }
    /// ż by the formula, and the sum of its absolute terms.
    pub fn common_rate(&self, v: f64, x: &[f64]) -> (f64, f64) {
        let (size, sum) = self.carried(x);
        let (mu, speed) = (self.mu(v), self.speed(v));
        let g = mu + self.damping(v) * speed;
        ((mu * v - speed * sum) / g, (mu * v.abs() + speed * size) / g)
    }
}

/// A contact of any bristle behind one pointer, with its state as a slice.
pub trait Subject<T: Scalar> {
    fn rate(&self, v: T, x: &[T]) -> Vec<T>;
    fn force(&self, v: T, x: &[T]) -> T;
    fn dissipated_power(&self, v: T, x: &[T]) -> T;
    fn stored_energy(&self, x: &[T]) -> T;
    fn stationary(&self, v: T) -> Vec<T>;
    fn stationary_force(&self, v: T) -> T;
    /// End state, end force, mean force.
    fn hold(&self, v: T, x: &[T], h: T) -> (Vec<T>, T, T);
    fn limits(&self, fastest: T) -> ContactLimits<T>;
    fn obeys(&self, law: Law) -> bool;
    /// ∂ẋ/∂v, ∂F/∂v, and ∂ẋ/∂x applied to a direction, ∂F/∂x along it.
    fn derivatives(&self, v: T, x: &[T], along: &[T]) -> (Vec<T>, T, Vec<T>, T);
}

/// A state as a slice and back.
pub trait Slice<T: Scalar>: Deflection<T> {
    fn of(slice: &[T]) -> Self;
    fn vec(self) -> Vec<T>;
}
impl<T: Scalar> Slice<T> for T {
    fn of(slice: &[T]) -> Self {
        slice[0]
    }
    fn vec(self) -> Vec<T> {
        vec![self]
    }
}
impl<T: Scalar, const N: usize> Slice<T> for SVector<T, N> {
    fn of(slice: &[T]) -> Self {
        Self::from_column_slice(slice)
    }
    fn vec(self) -> Vec<T> {
        self.as_slice().to_vec()
    }
}

impl<T: Scalar, M: Bristle<T>> Subject<T> for Contact<T, M>
where
    M::Deflection: Slice<T>,
{
    fn rate(&self, v: T, x: &[T]) -> Vec<T> {
        Contact::rate(self, v, M::Deflection::of(x)).vec()
    }
    fn force(&self, v: T, x: &[T]) -> T {
        Contact::force(self, v, M::Deflection::of(x))
    }
    fn dissipated_power(&self, v: T, x: &[T]) -> T {
        Contact::dissipated_power(self, v, M::Deflection::of(x))
    }
    fn stored_energy(&self, x: &[T]) -> T {
        Contact::stored_energy(self, M::Deflection::of(x))
    }
    fn stationary(&self, v: T) -> Vec<T> {
        Contact::stationary(self, v).vec()
    }
    fn stationary_force(&self, v: T) -> T {
        Contact::stationary_force(self, v)
    }
    fn hold(&self, v: T, x: &[T], h: T) -> (Vec<T>, T, T) {
        let held = Contact::hold(self, v, M::Deflection::of(x), h);
        (held.deflection.vec(), held.end_force, held.mean_force)
    }
    fn limits(&self, fastest: T) -> ContactLimits<T> {
        Contact::limits(self, fastest)
    }
    fn obeys(&self, law: Law) -> bool {
        self.model().obeys(law)
    }
    fn derivatives(&self, v: T, x: &[T], along: &[T]) -> (Vec<T>, T, Vec<T>, T) {
        let linear = self.linearised(v, M::Deflection::of(x));
        let along = M::Deflection::of(along);
        (
            linear.rate_by_velocity.vec(),
            linear.force_by_velocity,
            M::Deflection::relax(linear.rate_by_deflection, along).vec(),
            linear.force_by_deflection.inner_product(along),
        )
    }
}

pub struct Specimen<T: Scalar> {
    pub subject: Box<dyn Subject<T>>,
    pub form: Form,
}

impl<T: Scalar> Specimen<T> {
    pub fn name(&self) -> String {
        let Form { name, series, beside_law, regularised, scale, .. } = &self.form;
        format!("{name} {series:?} {beside_law:?} {regularised} {scale}")
    }
}

pub fn maxwell<T: Scalar>(k: f64, eta: T) -> Maxwell<T> {
    Maxwell::new(MaxwellParameters { micro_stiffness: lit(k), series_damping: eta }).unwrap()
}

pub fn zener<T: Scalar>(k0: f64, k1: f64, eta: T) -> GeneralisedMaxwell<T, 2> {
    let parameters = ZenerParameters {
        static_stiffness: lit(k0),
        relaxing_stiffness: lit(k1),
        series_damping: eta,
    };
    GeneralisedMaxwell::zener(parameters).unwrap()
}

pub fn arms<T: Scalar, const N: usize>(
    arms: [(f64, Option<T>); N],
    micro_damping: T,
) -> GeneralisedMaxwell<T, N> {
    let arms = arms.map(|(k, series_damping)| MaxwellArm { stiffness: lit(k), series_damping });
    GeneralisedMaxwell::new(GeneralisedMaxwellParameters { arms, micro_damping }).unwrap()
}

/// The same with laws of the velocity, written outside the library.
pub fn own_arms<T: Scalar, const N: usize>(
    arms: [(f64, Option<VelocityLaw<T>>); N],
    damping: impl Into<VelocityLaw<T>>,
) -> OwnArms<T, N> {
    OwnArms { arms: arms.map(|(k, law)| (lit(k), law)), damping: damping.into() }
}

/// Every bristle.
pub fn specimens<T: Scalar + Slice<T>>(r: &Recipe, p: &Parts) -> Vec<Specimen<T>> {
    specimens_under(r, p, 1.0)
}

/// Every bristle under s times its reference load. One line each.
pub fn specimens_under<T: Scalar + Slice<T>>(r: &Recipe, p: &Parts, s: f64) -> Vec<Specimen<T>> {
    use Change::{Constant, Varying};
    let (k, e, d) = (p.stiffness, p.series, p.beside);
    let mut list = Vec::new();
    // With series damping (1) and without (0).
    let arm = |i: usize, relaxes| (k[i], (relaxes == 1).then_some(e[i]));
    let form = |name, arms: &[(f64, Option<f64>)], series, beside, beside_law| Form {
        arms: arms.to_vec(),
        series,
        beside,
        beside_law,
        name,
        regularised: false,
        recipe: *r,
        scale: s,
    };
    /// The library's.
    macro_rules! add {
        ($name:literal, [$($i:literal: $relaxes:literal),*], $beside:expr) => {
            let parts = [$(arm($i, $relaxes)),*];
            let bristle = arms(parts.map(|(k, eta)| (k, eta.map(lit::<T>))), lit($beside));
            push(&mut list, form($name, &parts, Constant, $beside, Constant), bristle);
        };
    }
    /// With dampings of their own laws.
    macro_rules! own {
        ($name:literal, [$($i:literal: $relaxes:literal),*], $series:ident, $beside:expr) => {
            let parts = [$(arm($i, $relaxes)),*];
            let law = |eta| match $series {
                Varying => varying::<T>(r, eta),
                Constant => lit::<T>(eta).into(),
            };
            let series = parts.map(|(k, eta)| (k, eta.map(law)));
            let (beside, of) = ($beside, if $beside == 0.0 { Constant } else { Varying });
            let bristle = own_arms(series, varying(r, beside));
            push(&mut list, form($name, &parts, $series, beside, of), bristle);
        };
    }
    let one = form("Maxwell", &[arm(0, 1)], Constant, 0.0, Constant);
    push(&mut list, one, maxwell(k[0], lit::<T>(e[0])));
    let two = form("Zener", &[arm(0, 0), arm(1, 1)], Constant, 0.0, Constant);
    push(&mut list, two, zener(k[0], k[1], lit::<T>(e[1])));
    add!("static arm", [0: 0], d);
    add!("two arms", [0: 1, 1: 0], d);
    add!("two static arms", [0: 0, 1: 1, 2: 0], 0.0);
    add!("five arms", [0: 1, 1: 1, 2: 0, 3: 1, 4: 1], 0.0);
    own!("own Maxwell", [0: 1], Varying, 0.0);
    own!("own Zener", [0: 0, 1: 1], Varying, 0.0);
    own!("own arms", [0: 0, 1: 1, 2: 1], Varying, d);
    own!("three arms that creep", [0: 1, 1: 1, 2: 1], Constant, d);
    own!("own", [0: 0, 1: 1], Constant, d);
    list
}

pub fn push<T: Scalar, R: Rheology<T> + 'static>(
    list: &mut Vec<Specimen<T>>,
    form: Form,
    bristle: R,
) where
    R::Deflection: Slice<T>,
{
    fn under<T: Scalar, M: Bristle<T>>(model: M, form: &Form) -> Box<Contact<T, M>> {
        let contact = model.under_load(lit(form.scale * form.recipe.load)).unwrap();
        Box::new(contact.measured_at(lit(form.recipe.load)).unwrap())
    }
    let model = FrBd::new(stribeck(&form.recipe, 2.0), bristle);
    let regularised = Form { regularised: true, ..form.clone() };
    let smooth = model.clone().regularised(square_root(&form.recipe));
    list.push(Specimen { subject: under(model, &form), form });
    list.push(Specimen { subject: under(smooth, &regularised), form: regularised });
}

/// A recipe, springs and dashpots, a velocity, and a state: Kᵢxᵢ/μ_s of each spring.
pub fn case() -> impl Strategy<Value = (Recipe, Parts, f64, [f64; 5])> {
    (recipe(), parts(), velocity(), prop::array::uniform5(-3.0..3.0))
}

pub fn every(cases: u32, test: impl Fn(&Specimen<f64>, f64, &[f64])) {
    check(cases, (case(), scale()), |((r, p, v, forces), scale)| {
        for specimen in specimens_under::<f64>(&r, &p, scale) {
            let x = stretches(&specimen.form, &forces);
            test(&specimen, v, &x);
        }
    });
}

pub fn stretches(form: &Form, forces: &[f64; 5]) -> Vec<f64> {
    form.arms.iter().zip(forces).map(|(arm, f)| f * form.recipe.static_ / arm.0).collect()
}
