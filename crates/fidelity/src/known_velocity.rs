//! A bristle dragged at a known velocity.

use alloc::vec::Vec;

use super::scene::{Answers, Level, Run, Scene, check_run, each_step, resolving};
use super::{FidelityError, cost};
use bristle::curve::FrictionCurve;
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::regularisation::Regularisation;
use bristle::rheology::{Deflection, KelvinVoigt, KelvinVoigtParameters, Rheology};
use bristle::root::enclose;
use bristle::scalar::{is_zero, lit, to_f64};
use bristle::signal::Signal;
use bristle::{Branch, Bristle, Contact, Dahl, DahlParameters, Form, FrBd, Scalar};

impl Level {
    /// F = p μ(v) sgn v: no memory.
    pub const STATIC_CURVE: Self = Self { model: "static curve", method: None };
    /// A bristle under a constant friction coefficient, the mean of μ over the scene; each step
    /// exact at the velocity in its middle.
    pub const DAHL: Self = Self { model: "Dahl", method: Some("exact hold") };
    /// The model of one spring below the reference ([`KnownVelocity::with_lumped`]), in such steps.
    pub const LUMPED: Self = Self { model: "one spring", method: Some("exact hold") };
    /// The scene's own model; each step exact at the velocity in its middle ([`Bristle::hold`]).
    pub const REFERENCE: Self = Self { model: "reference", method: Some("exact hold") };
}

/// The friction force at equal intervals along a known sliding velocity.
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle_fidelity::{Answers, KnownVelocity, Level, Tolerance, choose};
/// use bristle::rheology::KelvinVoigt;
/// use bristle::signal::{Sine, SineParameters};
/// use bristle::{Bristle, FrBd, ParameterError, paper};
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let friction = FrBd::new(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?);
/// let scene = |mean, amplitude| -> Result<_, ParameterError> {
///     let velocity = Sine::new(SineParameters { mean, amplitude, frequency: 1.0, phase: 0.0 })?;
///     let answers = Answers { interval: 0.01_f64, count: 1000 };
///     let scene = KnownVelocity::new(friction.under_load(1.0)?, velocity, answers)?;
///     Ok(scene.starting_steadily())
/// };
/// let tolerance = Tolerance::at_every_answer(0.015); // N, 1 % of breakaway
/// // Where it slides on the bristle follows the curve. In pre-sliding it is a spring.
/// assert_eq!(choose(&scene(0.03, 0.02)?, tolerance)?.best.level, Level::STATIC_CURVE);
/// assert_eq!(choose(&scene(0.0, 1e-4)?, tolerance)?.best.level, Level::DAHL);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct KnownVelocity<T: Scalar, M, V, L = Dahl<T>> {
    contact: Contact<T, M>,
    lumped: Option<Contact<T, L>>,
    dahl: Contact<T, Dahl<T>>,
    velocity: V,
    answers: Answers<T>,
    angular_frequency: T,
    steady: bool,
}

/// Below FrBD with any bristle, FrBD with the same curve and one spring and one dashpot side by
/// side: those that answer a small oscillation of the angular frequency ω [rad/s] as the bristle
/// does, σ0 = G'(ω) and σ1 = G''(ω)/ω. For [`KnownVelocity::with_lumped`], with the ω of
/// [`KnownVelocity::angular_frequency`].
///
/// # Errors
///
/// Refuses a stiffness or a damping that is out of range.
pub fn lumped_frbd<T, C, R, E>(
    model: &FrBd<C, R, E>,
    angular_frequency: T,
) -> Checked<FrBd<C, KelvinVoigt<T>, E>>
where
    T: Scalar,
    C: FrictionCurve<T>,
    R: Rheology<T>,
    E: Regularisation<T>,
{
    let modulus = model.rheology().complex_modulus(angular_frequency);
    let bristle = KelvinVoigt::new(KelvinVoigtParameters {
        micro_stiffness: modulus.re,
        micro_damping: modulus.im / angular_frequency,
    })?;
    Ok(FrBd::new(model.curve().clone(), bristle).regularised(model.regularisation().clone()))
}

impl<T: Scalar, M: Bristle<T>, V: Signal<T>> KnownVelocity<T, M, V> {
    /// The force of a contact, which is the reference, along a velocity v(t) [m/s] from t = 0 on.
    /// The bristle starts undeflected. The model may be your own.
    ///
    /// # Errors
    ///
    /// Refuses an interval or a normal force that is not positive, no answers or more than a
    /// million, and a velocity that is not finite at an answer.
    pub fn new(contact: Contact<T, M>, velocity: V, answers: Answers<T>) -> Checked<Self> {
        let answers = answers.checked()?;
        Named("normal_force", contact.normal_force()).positive()?;
        // How fast the velocity changes: its root-mean-square rate over that of itself.
        let (mut rates, mut squares) = (T::zero(), T::zero());
        let mut last = Named("velocity", velocity.value(T::zero())).finite()?;
        for (index, time) in answers.times().enumerate() {
            let checked = Named("velocity", velocity.value(time)).finite();
            let now = ParameterError::of_component(index + 1, checked)?;
            rates += (now - last) * (now - last);
            squares += now * now;
            last = now;
        }
        let frequency =
            if is_zero(squares) { squares } else { (rates / squares).sqrt() / answers.interval };
        let angular_frequency = frequency.larger(T::one() / answers.time(answers.count));
        let dahl = dahl(&contact, &velocity, &answers)?;
        let lumped = None;
        Ok(Self { contact, lumped, dahl, velocity, answers, angular_frequency, steady: false })
    }
}

/// Dahl's model under the mean friction of a contact over the scene, with the stiffness of all its
/// springs.
fn dahl<T: Scalar, M: Bristle<T>>(
    contact: &Contact<T, M>,
    velocity: &impl Signal<T>,
    answers: &Answers<T>,
) -> Checked<Contact<T, Dahl<T>>> {
    let model = contact.model();
    let dynamic_coefficient = answers.times().fold(T::zero(), |sum, time| {
        // The curve beside v = 0, where it has no sign and is 0.
        let now = velocity.value(time);
        let now = if is_zero(now) { T::default_epsilon() } else { now };
        sum + model.stationary_coefficient(now).abs() / lit(answers.count as f64)
    });
    let micro_stiffness = model.storage_stiffness().inner_product(M::Deflection::fill(T::one()));
    let dahl = Dahl::new(DahlParameters { dynamic_coefficient, micro_stiffness })?;
    Ok(contact.with_model(dahl))
}

/// The cost of an exact step and of the force after it, in evaluations of FrBD with one spring.
fn costs<T: Scalar, M: Bristle<T>>(model: &M) -> (f64, f64) {
    match (model.form(), M::Deflection::SPRINGS) {
        (Form::Solved, _) => (cost::IMPLICIT_HOLD, cost::IMPLICIT_FORCE),
        (_, 1) => (cost::HOLD, cost::FORCE),
        _ => (cost::MATRIX_HOLD, cost::FORCE),
    }
}

impl<T: Scalar, M: Bristle<T>, V: Signal<T>, L> KnownVelocity<T, M, V, L> {
    /// A model of one spring below the reference, as another level: for a bristle of several
    /// springs ([`lumped_frbd`]), or for one whose steps are dear. Dahl's model takes its
    /// stiffness.
    ///
    /// ```
    /// use bristle::curve::Stribeck;
    /// use bristle::rheology::{GeneralisedMaxwell, ZenerParameters};
    /// use bristle::signal::{Sine, SineParameters};
    /// use bristle::{Bristle, FrBd, paper};
    /// use bristle_fidelity::{Answers, KnownVelocity, Level, Tolerance, choose, lumped_frbd};
    ///
    /// let rubber = GeneralisedMaxwell::zener(ZenerParameters {
    ///     static_stiffness: 1e4,    // 1/m
    ///     relaxing_stiffness: 2e4,  // 1/m
    ///     series_damping: 1e4,      // s/m
    /// })?;
    /// let friction = FrBd::new(Stribeck::new(paper::STICK_SLIP_CURVE)?, rubber);
    /// let wave = SineParameters { mean: 0.0, amplitude: 1e-5, frequency: 1.0, phase: 0.0 };
    /// let answers = Answers { interval: 0.01, count: 200 }; // s
    /// let scene =
    ///     KnownVelocity::new(friction.under_load(1.0)?, Sine::new(wave)?, answers)?; // N
    /// let lumped = lumped_frbd(&friction, scene.angular_frequency())?;
    /// let choice = choose(&scene.with_lumped(lumped)?, Tolerance::at_every_answer(0.005))?; // N
    /// assert!(choice.trials.iter().any(|trial| trial.level == Level::LUMPED));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses a model that gives Dahl's a parameter that is out of range.
    pub fn with_lumped<N>(self, lumped: N) -> Checked<KnownVelocity<T, M, V, N>>
    where
        N: Bristle<T, Deflection = T>,
    {
        let Self { contact, velocity, answers, angular_frequency, steady, .. } = self;
        let lumped = contact.with_model(lumped);
        let dahl = dahl(&lumped, &velocity, &answers)?;
        let lumped = Some(lumped);
        Ok(KnownVelocity { contact, lumped, dahl, velocity, answers, angular_frequency, steady })
    }

    /// How fast the velocity changes [rad/s]: its root-mean-square rate over that of itself, or one
    /// over the length of the scene where that is more.
    #[doc(alias = "omega")]
    pub fn angular_frequency(&self) -> T {
        self.angular_frequency
    }

    /// Starts as in steady sliding at the first velocity.
    #[must_use]
    pub fn starting_steadily(self) -> Self {
        Self { steady: true, ..self }
    }

    fn static_curve(&self) -> Run {
        let mut run = Run::default();
        for time in self.answers.times() {
            run.answers.push(to_f64(self.contact.stationary_force(self.velocity.value(time))));
            run.count(1, cost::CURVE);
        }
        run
    }

    /// The first time between two at which the velocity is not smooth or reverses: a step of a held
    /// velocity knows one direction only.
    fn next_kink(&self, from: T, to: T) -> Option<T> {
        let kink = self.velocity.next_kink(from, to);
        let end = kink.unwrap_or(to);
        // Beside the ends, where the velocity may jump or be zero.
        let beside = (end - from) * lit(1e-8);
        let ends = [from + beside, end - beside].map(|time| (time, self.velocity.value(time)));
        let [(_, first), (_, last)] = ends;
        let reverses =
            first < T::zero() && last > T::zero() || first > T::zero() && last < T::zero();
        if !reverses {
            return kink;
        }
        Some(enclose(|time| self.velocity.value(time), ends[0], ends[1], beside).1)
    }

    fn hold<N: Bristle<T>>(
        &self,
        contact: &Contact<T, N>,
        steps: u32,
        costs: (f64, f64),
    ) -> Checked<Run> {
        let steady = self.steady.then(|| contact.stationary(self.velocity.value(T::zero())));
        let mut z = steady.unwrap_or_else(|| N::Deflection::fill(T::zero()));
        let mut run = Run::default();
        for span in self.answers.spans() {
            for (step, look, _) in each_step(span, steps, |from, to| self.next_kink(from, to)) {
                let velocity = Named("velocity", self.velocity.value(look)).finite()?;
                z = contact.hold(velocity, z, step).deflection;
                run.count(1, costs.0);
            }
            run.answers.push(to_f64(contact.force(self.velocity.value(span.1), z)));
            run.count(1, costs.1);
        }
        Ok(run)
    }

    /// See [`Scene::physics`], of the bristle that the levels share; nothing if its deflection has
    /// no limit.
    fn physics_of<N: Bristle<T>>(
        &self,
        contact: &Contact<T, N>,
        level: Level,
    ) -> Option<(&'static str, f64)> {
        let rest = contact.model().limits(T::zero()).deflection?;
        let breakaway = to_f64(contact.friction_scale() * rest);
        let dt = to_f64(self.answers.interval);
        let mut last = self.velocity.value(T::zero());
        let (mut lag, mut way, mut longest, mut stuck) = (0.0_f64, 0.0_f64, 0.0_f64, 0_u32);
        for now in self.answers.times().map(|time| self.velocity.value(time)) {
            let change = contact.stationary(now) - contact.stationary(last);
            let rate = to_f64(change.largest()) / dt;
            let relaxation = contact
                .affine(Branch::locked(now).of(now), N::Deflection::fill(T::zero()))
                .relaxation;
            let one = N::Deflection::fill(T::one());
            let relaxation = to_f64(N::Deflection::relax(relaxation, one).largest());
            let reversed = Branch::locked(now) != Branch::locked(last);
            let here = if reversed { 2.0 } else { rate / (relaxation * breakaway) };
            lag = if here <= lag { lag } else { here.min(2.0) };
            way = if reversed { 0.0 } else { way } + dt * to_f64(now).abs();
            longest = longest.max(way);
            stuck += u32::from(way < breakaway);
            last = now;
        }
        Some(match level {
            Level::STATIC_CURVE => ("lag", lag),
            Level::DAHL => ("presliding", (breakaway / longest).min(1.0)),
            _ => ("stuck", f64::from(stuck) / self.answers.count as f64),
        })
    }
}

impl<T, M, V, L> Scene for KnownVelocity<T, M, V, L>
where
    T: Scalar,
    M: Bristle<T>,
    V: Signal<T>,
    L: Bristle<T, Deflection = T>,
{
    fn levels(&self) -> Vec<Level> {
        let mut levels = alloc::vec![Level::STATIC_CURVE, Level::DAHL];
        levels.extend(self.lumped.as_ref().map(|_| Level::LUMPED));
        levels.push(Level::REFERENCE);
        levels
    }

    fn interval(&self) -> f64 {
        to_f64(self.answers.interval)
    }

    fn fewest_steps(&self) -> u32 {
        resolving(self.answers.interval, self.velocity.longest_step())
    }

    fn run(&self, level: Level, steps: u32) -> Result<Run, FidelityError> {
        check_run(&self.levels(), level, steps)?;
        let run = match (level, &self.lumped) {
            (Level::STATIC_CURVE, _) => return Ok(self.static_curve()),
            (Level::DAHL, _) => self.hold(&self.dahl, steps, (cost::DAHL_HOLD, 0.0)),
            (Level::LUMPED, Some(lumped)) => self.hold(lumped, steps, (cost::HOLD, cost::FORCE)),
            _ => self.hold(&self.contact, steps, costs(self.contact.model())),
        };
        Ok(run?)
    }

    /// Of the static curve the lag: the change of the steady deflection in one relaxation time, in
    /// breakaway distances, 2 where the velocity reverses. Of Dahl the pre-sliding share: the
    /// breakaway distance over the longest way in one direction, at most 1. Of the others the share
    /// of the time that the bristle is stuck: since it last reversed it has slid less than that.
    ///
    /// All are those of the model of one spring, if there is one. A bristle of several springs has
    /// no limit of its deflection, and no such numbers of its own.
    fn physics(&self, level: Level, _: u32) -> Option<(&'static str, f64)> {
        match &self.lumped {
            Some(lumped) => self.physics_of(lumped, level),
            None => self.physics_of(&self.contact, level),
        }
    }
}
