//! A contact patch along a known motion.

use alloc::vec::Vec;

use super::scene::{Answers, Level, Run, Scene, check_run, each_step, resolving};
use super::{FidelityError, cost};
use bristle::parameter::{Checked, Named};
use bristle::scalar::{lit, to_f64};
use bristle::signal::Signal;
use bristle::{Bristle, Scalar};
use bristle_rolling::{Motion, Patch, PolynomialExponential};

impl Level {
    /// The steady force at the motion of the instant: no memory.
    pub const SLIP_CURVE: Self = Self { model: "slip curve", method: None };
    /// A force that follows the slip curve over a relaxation length ς, Ḟ = −(U/ς)(F − F_ss): each
    /// step exact for U held and F_ss straight.
    pub const RELAXATION_LENGTH: Self =
        Self { model: "relaxation length", method: Some("exact ramp") };
    /// The patch itself; each step exact for the motion in its middle
    /// ([`ExactPatch::step`](bristle_rolling::ExactPatch::step)). Steps lead to an answer from the
    /// last transit before it on, or from the answer before if that is later.
    pub const PATCH: Self = Self { model: "patch", method: Some("exact hold") };
}

/// The friction force of a contact patch at equal intervals along a known motion.
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle_fidelity::{Answers, Level, PatchScene, Tolerance, choose};
/// use bristle::rheology::KelvinVoigt;
/// use bristle_rolling::{Motion, Patch, PatchParameters, PolynomialExponential};
/// use bristle::signal::{Sine, SineParameters};
/// use bristle::{FrBd, ParameterError, paper};
///
/// let tyre = Patch::new(PatchParameters {
///     model: FrBd::new(Stribeck::new(paper::TYRE_CURVE)?, KelvinVoigt::new(paper::TYRE_BRISTLE)?),
///     length: bristle_rolling::TYRE_LENGTH,
///     pressure: PolynomialExponential::parabolic(),
/// })?
/// .under_load(4000.0)?; // N
/// let scene = |frequency: f64| -> Result<_, ParameterError> {
///     let slip = SineParameters { mean: 0.2, amplitude: 0.2, frequency, phase: 0.0 };
///     let motion = Motion { slip_velocity: Sine::new(slip)?, rolling_speed: 16.0 };
///     let answers = Answers { interval: 0.01 / frequency, count: 1000 };
///     Ok(PatchScene::new(tyre, motion, answers)?.starting_steadily())
/// };
/// let tolerance = Tolerance::at_every_answer(20.0); // N, some 1 % of the largest force
/// // Slow steering follows the slip curve. With half a transit in a period it takes the patch.
/// assert_eq!(choose(&scene(0.2)?, tolerance)?.best.level, Level::SLIP_CURVE);
/// assert_eq!(choose(&scene(320.0)?, tolerance)?.best.level, Level::PATCH);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct PatchScene<T, M, const N: usize, S, W> {
    patch: Patch<T, M, PolynomialExponential<T, N>>,
    motion: Motion<S, W>,
    answers: Answers<T>,
    steady: bool,
    /// Relaxation length \[m\].
    relaxation_length: T,
}

/// Segments that a patch gets memory for, some megabytes; narrower ones are merged.
const SEGMENTS: usize = 20_000;

impl<T: Scalar, M: Bristle<T, Deflection = T>, const N: usize, S: Signal<T>, W: Signal<T>>
    PatchScene<T, M, N, S, W>
{
    /// The force of a patch along a slip velocity v(t) and a rolling speed U(t) ≥ 0 [m/s] from
    /// t = 0 on. The bristles start undeflected.
    ///
    /// # Errors
    ///
    /// Refuses an interval or a normal force that is not positive, no answers or more than a
    /// million, and at an answer a velocity that is not finite and a rolling speed below zero.
    pub fn new(
        patch: Patch<T, M, PolynomialExponential<T, N>>,
        motion: Motion<S, W>,
        answers: Answers<T>,
    ) -> Checked<Self> {
        let answers = answers.checked()?;
        Named("normal_force", patch.normal_force()).positive()?;
        // What a constant pressure in adhesion has, until it is known.
        let relaxation_length = patch.length() / lit(3.0);
        let mut scene = Self { patch, motion, answers, steady: false, relaxation_length };
        let (mut slip, mut rolling) = (T::zero(), T::zero());
        for answer in 0..=answers.count {
            let Motion { slip_velocity, rolling_speed } = scene.at(answers.time(answer));
            slip += Named("slip_velocity", slip_velocity).finite()?.abs();
            rolling += Named("rolling_speed", rolling_speed).non_negative()?;
        }
        let count = lit(1.0 + answers.count as f64);
        let found = [slip / count, T::zero()].map(|slip| scene.lag_about(slip, rolling / count));
        scene.relaxation_length = found.into_iter().flatten().next().unwrap_or(relaxation_length);
        Ok(scene)
    }

    /// Starts as in steady rolling at the first velocities.
    #[must_use]
    pub fn starting_steadily(self) -> Self {
        Self { steady: true, ..self }
    }

    /// The relaxation length ς \[m\] of [`Level::RELAXATION_LENGTH`]: −U Im G/(ω Re G) for ω → 0 of
    /// the frequency response G from v to F ([`Patch::linearised`]) at the mean |v| and U of the
    /// scene, which to first order in ω is the lag of the patch. Where that is not between nothing
    /// and the length of the patch, about v = 0.
    #[doc(alias = "sigma")]
    pub fn relaxation_length(&self) -> T {
        self.relaxation_length
    }

    /// The lag \[m\] of the patch behind slow changes of a motion.
    fn lag_about(&self, slip_velocity: T, rolling_speed: T) -> Option<T> {
        // A phase of a thousandth in a transit: slow, and far above roundings even in f32.
        let slow = lit::<T>(1e-3) * rolling_speed / self.patch.length();
        let response = self.patch.linearised(Motion { slip_velocity, rolling_speed }).ok()?;
        let response = response.by_slip_velocity(slow);
        let lag = -response.im * rolling_speed / (slow * response.re);
        (lag > T::zero() && lag < self.patch.length()).then_some(lag)
    }

    fn at(&self, time: T) -> Motion<T> {
        let Motion { slip_velocity, rolling_speed } = &self.motion;
        let (slip_velocity, rolling_speed) = (slip_velocity.value(time), rolling_speed.value(time));
        Motion { slip_velocity, rolling_speed }
    }

    fn next_kink(&self, from: T, to: T) -> Option<T> {
        let Motion { slip_velocity, rolling_speed } = &self.motion;
        let first = slip_velocity.next_kink(from, to);
        rolling_speed.next_kink(from, first.unwrap_or(to)).or(first)
    }

    fn slip_curve(&self, run: &mut Run) -> Result<(), FidelityError> {
        for time in self.answers.times() {
            run.answers.push(to_f64(self.patch.steady(self.at(time))?.force));
            run.count(1, cost::SLIP_CURVE);
        }
        Ok(())
    }

    fn lag(&self, steps: u32, run: &mut Run) -> Result<(), FidelityError> {
        let mut target = self.patch.steady(self.at(T::zero()))?.force;
        let mut force = if self.steady { target } else { T::zero() };
        for span in self.answers.spans() {
            for (h, look, end) in each_step(span, steps, |from, to| self.next_kink(from, to)) {
                let steady = self.patch.steady(self.at(end))?.force;
                // φ1 = (1 − e⁻ˣ)/x: the mean of e⁻ˢ over the step.
                let x = self.motion.rolling_speed.value(look) * h / self.relaxation_length;
                let phi1 = if x > T::zero() { -(-x).exp_m1() / x } else { T::one() };
                force = steady - (steady - target) * phi1 + (force - target) * (-x).exp();
                target = steady;
                run.count(1, cost::SLIP_CURVE + cost::LAG);
            }
            run.answers.push(to_f64(force));
        }
        Ok(())
    }

    fn patch(&self, steps: u32, run: &mut Run) -> Result<(), FidelityError> {
        let mut patch = self.patch.clone().exact_in(SEGMENTS)?;
        if self.steady {
            patch.settle(self.at(T::zero()))?;
        }
        for (last, time) in self.answers.spans() {
            let span = (self.last_transit(last, time, steps), time);
            for (step, look, _) in each_step(span, steps, |from, to| self.next_kink(from, to)) {
                patch.step(self.at(look), step)?;
                run.count(1, cost::PATCH);
            }
            run.answers.push(to_f64(patch.force(self.motion.slip_velocity.value(time))));
            run.count(1, cost::PATCH_FORCE);
        }
        Ok(())
    }

    /// Where the steps that lead to an answer begin. The patch forgets all that is more than a
    /// transit old: if the answer before is much longer ago than that, at half as much again before
    /// this one, provided that the way since, as far as so many steps tell, is a transit.
    fn last_transit(&self, before: T, end: T, steps: u32) -> T {
        let (length, speed) = (self.patch.length(), &self.motion.rolling_speed);
        let from = end - length * lit(1.5) / speed.value(end);
        if !(from > before) {
            return before;
        }
        let looks = each_step((from, end), steps + 3, |_, _| None);
        let way = looks.fold(T::zero(), |way, (step, look, _)| way + speed.value(look) * step);
        // A tenth to spare for what the speed does between the looks.
        if way > length * lit(1.1) { from } else { before }
    }
}

impl<T: Scalar, M: Bristle<T, Deflection = T>, const N: usize, S: Signal<T>, W: Signal<T>> Scene
    for PatchScene<T, M, N, S, W>
{
    fn levels(&self) -> Vec<Level> {
        alloc::vec![Level::SLIP_CURVE, Level::RELAXATION_LENGTH, Level::PATCH]
    }

    fn interval(&self) -> f64 {
        to_f64(self.answers.interval)
    }

    fn fewest_steps(&self) -> u32 {
        let Motion { slip_velocity, rolling_speed } = &self.motion;
        let longest = [slip_velocity.longest_step(), rolling_speed.longest_step()];
        let longest = longest.into_iter().flatten().reduce(T::smaller);
        let spans = self.answers.spans();
        let stepped = spans.map(|(last, time)| time - self.last_transit(last, time, 1));
        resolving(stepped.fold(T::zero(), T::larger), longest)
    }

    fn run(&self, level: Level, steps: u32) -> Result<Run, FidelityError> {
        check_run(&self.levels(), level, steps)?;
        let mut run = Run::default();
        match level {
            Level::SLIP_CURVE => self.slip_curve(&mut run),
            Level::RELAXATION_LENGTH => self.lag(steps, &mut run),
            _ => self.patch(steps, &mut run),
        }?;
        Ok(run)
    }

    /// Of the slip curve the lag: the change of the steady force in one transit over the largest
    /// steady force. Of the relaxation length that length over the length of the patch. Of the
    /// patch the share of the time in which no bristle relaxes on its way through it: it adheres.
    fn physics(&self, level: Level, _: u32) -> Option<(&'static str, f64)> {
        let (length, count) = (self.patch.length(), self.answers.count as f64);
        let steady = |time| self.patch.steady(self.at(time)).map_or(0.0, |s| to_f64(s.force));
        let mut last = steady(T::zero());
        let (mut change, mut largest, mut adhering) = (0.0_f64, last.abs(), 0_u32);
        for time in self.answers.times() {
            let Motion { slip_velocity, rolling_speed } = self.at(time);
            let now = steady(time);
            let transits = self.interval() * to_f64(rolling_speed / length);
            change = change.max((now - last).abs() / transits);
            largest = largest.max(now.abs());
            let relaxation = self.patch.model().affine(slip_velocity.into(), T::zero()).relaxation;
            adhering += u32::from(relaxation * length < rolling_speed);
            last = now;
        }
        Some(match level {
            Level::SLIP_CURVE => ("lag", (change / largest).min(2.0)),
            Level::RELAXATION_LENGTH => ("ς/L", to_f64(self.relaxation_length / length)),
            _ => ("adhering", f64::from(adhering) / count),
        })
    }
}
