//! Contacts of one axis in a step of the mechanism: predictor, load, companion and ledger.

use crate::mechanism::{LinearMechanism, Storage};
use crate::rows::{Rows, along};
use crate::step::{Motion, Parts, check_length, forwards};
use bristle::companion::{Companion, CompanionStep, CompletedStep, Prediction};
use bristle::parameter::Checked;
use bristle::rheology::Deflection;
use bristle::scalar::{is_zero, lit};
use bristle::{Bristle, Form, LoadChange, Scalar, Surface};

/// What acts on a mechanism during a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs<'a, T> {
    /// Force f̄ \[N\] on each coordinate, averaged over the step: that at its middle is of second
    /// order.
    pub force: &'a [T],
    /// Prescribed part w of each contact's sliding velocity [m/s] at the middle of the step: minus
    /// the velocity of a belt. Empty for none.
    pub prescribed: &'a [T],
    /// Normal force p \[N\] of each contact at the middle of the step, zero or positive. Empty: it
    /// stays.
    pub load: &'a [T],
}

impl<'a, T> Inputs<'a, T> {
    /// Forces alone: no belt, and loads that stay.
    pub fn force(force: &'a [T]) -> Self {
        Self { force, prescribed: &[], load: &[] }
    }
}

/// What a contact keeps from step to step, and its last step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactState<T: Scalar, D: Deflection<T> = T> {
    load: T,
    /// W v at the beginning of the last step.
    pub(crate) before: Option<T>,
    deflection: D,
    /// Energy dissipated by slipping back when the load changed.
    slipped: T,
    pub(crate) frozen: Option<CompanionStep<T, D>>,
    /// Mean sliding velocity of the last step.
    pub(crate) mean: T,
}

impl<T: Scalar, D: Deflection<T>> ContactState<T, D> {
    /// A contact under the normal force of its companion, with a deflection \[m\], before its first
    /// step.
    pub fn new<M: Bristle<T, Deflection = D>>(companion: &Companion<T, M>, deflection: D) -> Self {
        let (load, [slipped, mean]) = (companion.contact().normal_force(), [T::zero(); 2]);
        Self { load, before: None, deflection, slipped, frozen: None, mean }
    }

    /// Deflection z \[m\].
    #[inline]
    pub fn deflection(&self) -> D {
        self.deflection
    }

    /// Normal force p \[N\] at the middle of the last step.
    #[inline]
    pub fn load(&self) -> T {
        self.load
    }

    /// What the friction has done in the last step: mean force, work, stored and dissipated energy.
    /// The energy that a falling load has set free is in the account, which is made when asked for.
    #[inline]
    pub fn last_step(&self) -> CompletedStep<T, D> {
        let [force, work, stored, dissipated] = [T::zero(); 4];
        let none = CompletedStep { deflection: self.deflection, force, work, stored, dissipated };
        let done = self.frozen.map_or(none, |step| step.commit(self.mean));
        let (stored, dissipated) = (done.stored - self.slipped, done.dissipated + self.slipped);
        CompletedStep { stored, dissipated, ..done }
    }

    /// Forgets the velocities before: after an impact, or any other jump of a velocity.
    pub fn forget_velocity(&mut self) {
        self.before = None;
    }

    /// The sliding velocity extrapolated to the middle of the next step, from that without belt and
    /// with it, and whether it counts on the last one: not before the first step, nor after a
    /// reversal. As of a history in which the belt has moved as it does now.
    #[inline(always)]
    pub(crate) fn predict(&self, [without, sliding]: [T; 2]) -> (T, bool) {
        let last = self.before.unwrap_or(without);
        let counts = self.before.is_some() && !(sliding * (last + (sliding - without)) < T::zero());
        let change = if counts { without - last } else { T::zero() };
        (sliding + lit::<T>(0.5) * change, counts)
    }

    /// Bias and damping of the next step, with the companion at the sliding velocity extrapolated
    /// to its middle.
    #[inline(always)]
    pub(crate) fn freeze<M: Bristle<T, Deflection = D>>(
        &mut self,
        companion: &Companion<T, M>,
        [without, sliding, load, duration]: [T; 4],
    ) -> (T, T) {
        let (contact, (predicted, _)) = (companion.contact(), self.predict([without, sliding]));
        let mut deflection = self.deflection;
        self.slipped = T::zero();
        if load != self.load {
            let change = LoadChange { before: self.load, after: load };
            let reloaded = contact.reloaded(change, predicted, deflection);
            (deflection, self.slipped) = (reloaded.deflection, reloaded.dissipated);
        }
        let mut scale = T::one();
        if load != contact.normal_force() {
            scale = load / contact.normal_force();
            scale = if scale >= T::zero() && scale.is_finite() { scale } else { T::nan() };
        }
        let surface = Surface::scaled(predicted, scale);
        let step = if contact.model().form() == Form::OfVelocity {
            companion.step(surface, deflection, duration)
        } else {
            let (half, on) = (duration * lit(0.5), contact.surface(surface));
            let middle = if is_zero(load) {
                deflection
            } else {
                contact.model().hold(on, deflection, half).deflection
            };
            let prediction = Prediction { velocity: surface, deflection: middle };
            companion.step_about(prediction, deflection, duration)
        };
        (self.before, self.load) = (Some(without), load);
        let sources = (step.bias(), step.damping());
        self.frozen = Some(step);
        sources
    }

    /// Ends the step at the mean sliding velocity that was found.
    #[inline(always)]
    pub(crate) fn commit(&mut self, mean_sliding: T) {
        self.mean = mean_sliding;
        if let Some(step) = &self.frozen {
            self.deflection = step.commit(mean_sliding).deflection;
        }
    }
}

impl<T: Scalar, R: Rows<T>, S: Storage<T>> LinearMechanism<T, R, S> {
    /// A step of length h ≥ 0 \[s\], with a state for each contact and a companion for each, or one
    /// for all.
    ///
    /// Each sliding velocity is extrapolated from the last two, as by a
    /// [`VelocityHistory`](bristle::companion::VelocityHistory): take steps of equal length, or
    /// call [`ContactState::forget_velocity`] where it changes. Another length than that of the
    /// step before also factors A anew.
    ///
    /// A load is taken as by [`Companion::reload`]. Build companions under a load that is positive.
    ///
    /// A step takes numbers and gives numbers: what is NaN makes NaN of what depends on it, and so
    /// does h < 0, a load that is negative or infinite, and a positive load on a contact that was
    /// built without one.
    ///
    /// # Errors
    ///
    /// Refuses slices of lengths that do not fit; nothing has moved.
    pub fn step<M: Bristle<T>>(
        &mut self,
        duration: T,
        inputs: &Inputs<'_, T>,
        motion: Motion<'_, T>,
        companions: &[Companion<T, M>],
        contacts: &mut [ContactState<T, M::Deflection>],
    ) -> Checked<()> {
        self.check_step(inputs, [&*motion.position, motion.velocity], companions, contacts)?;
        let duration = forwards(duration);
        if let ([x], [v], [state]) = (&mut *motion.position, &mut *motion.velocity, &mut *contacts)
            && self.structure.is_reduced()
        {
            self.step_of_one(duration, inputs, [x, v], companions, state);
            return Ok(());
        }
        let (rows, mut parts) = self.prepared(duration);
        parts.acceleration.copy_from_slice(inputs.force);
        let step = Step { duration, companions, rows };
        parts.step(&step, [inputs.prescribed, inputs.load], motion, contacts);
        Ok(())
    }

    /// The step of one coordinate with one contact: the sums of many without their loops, which
    /// would cost half as much as the contact.
    #[inline(always)]
    fn step_of_one<M: Bristle<T>>(
        &mut self,
        duration: T,
        inputs: &Inputs<'_, T>,
        [x, v]: [&mut T; 2],
        companions: &[Companion<T, M>],
        state: &mut ContactState<T, M::Deflection>,
    ) {
        self.prepare(duration);
        let (rows, half) = (&self.rows, lit::<T>(0.5) * duration);
        let (Some(numbers), &[force]) = (self.storage.as_mut().first_chunk_mut(), inputs.force)
        else {
            return;
        };
        let [_, damping, stiffness, reciprocal, response, coupling, _, _, mean_velocity] = numbers;
        let step = Step { duration, companions, rows };
        let acting = [inputs.prescribed, inputs.load];
        let [sliding, bias, damper] = step.freeze(0, &[*v], acting, state);
        let free = (force - (*stiffness * (*x + half * *v) + *damping * *v)) * *reciprocal;
        let sum = sliding + half * along(rows.row(0), &[free]) - *coupling * bias;
        let mean = sum / (*coupling * damper + T::one());
        let a = free - *response * (bias + damper * mean);
        *mean_velocity = *v + half * a;
        *x += duration * *mean_velocity;
        *v += duration * a;
        state.commit(mean);
    }

    /// Refuses what does not fit a step.
    pub(crate) fn check_step<M: Bristle<T>>(
        &self,
        inputs: &Inputs<'_, T>,
        motion: [&[T]; 2],
        companions: &[Companion<T, M>],
        contacts: &[ContactState<T, M::Deflection>],
    ) -> Checked<()> {
        let count = self.rows.contacts();
        self.check_motion(inputs.force, motion)?;
        self.check_contacts(companions, contacts)?;
        let given = [("prescribed velocities", inputs.prescribed), ("loads", inputs.load)];
        let mut given = given.into_iter().filter(|(_, values)| !values.is_empty());
        given.try_for_each(|(name, values)| check_length(name, values, count))
    }

    /// Refuses other counts of companions and states.
    pub(crate) fn check_contacts<M: Bristle<T>>(
        &self,
        companions: &[Companion<T, M>],
        contacts: &[ContactState<T, M::Deflection>],
    ) -> Checked<()> {
        let count = self.rows.contacts();
        if companions.len() != 1 {
            check_length("companions", companions, count)?;
        }
        check_length("contact states", contacts, count)
    }
}

/// A step of contacts with companions of a model.
pub(crate) struct Step<'a, T, R, M> {
    pub(crate) duration: T,
    pub(crate) companions: &'a [Companion<T, M>],
    pub(crate) rows: &'a R,
}

impl<T: Scalar, R: Rows<T>, M: Bristle<T>> Step<'_, T, R, M> {
    /// Freezes a contact at the beginning of the step: its sliding velocity, bias and damping.
    #[inline(always)]
    fn freeze(
        &self,
        contact: usize,
        velocity: &[T],
        [prescribed, load]: [&[T]; 2],
        state: &mut ContactState<T, M::Deflection>,
    ) -> [T; 3] {
        let each = usize::from(self.companions.len() > 1);
        let companion = &self.companions[contact * each];
        let without = along(self.rows.row(contact), velocity);
        let sliding = prescribed.get(contact).map_or(without, |&belt| without + belt);
        let load = load.get(contact).copied().unwrap_or(state.load);
        let (bias, damper) = state.freeze(companion, [without, sliding, load, self.duration]);
        [sliding, bias, damper]
    }
}

impl<T: Scalar> Parts<'_, T> {
    /// The step under forces in the place of the accelerations, with belts and loads.
    #[inline(always)]
    pub(crate) fn step<R: Rows<T>, M: Bristle<T>>(
        &mut self,
        step: &Step<'_, T, R, M>,
        acting: [&[T]; 2],
        motion: Motion<'_, T>,
        contacts: &mut [ContactState<T, M::Deflection>],
    ) {
        let &Step { duration, rows, .. } = step;
        let room = self.bias.iter_mut().zip(&mut *self.dampers).zip(&mut *self.sliding);
        for (k, (((bias, damper), sliding), state)) in room.zip(&mut *contacts).enumerate() {
            [*sliding, *bias, *damper] = step.freeze(k, motion.velocity, acting, state);
        }
        self.solve(duration, motion, rows);
        for (state, &mean) in contacts.iter_mut().zip(&*self.sliding) {
            state.commit(mean);
        }
    }
}
