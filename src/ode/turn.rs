//! What the driver does with the sliding directions of the contacts: it locks them, turns them at
//! reversals, and anew where an input jumps.

use super::failure::StopReason;
use super::growth::LARGE;
use super::integration::Integration;
use super::progress::StopTime;
use super::reversal::ContactBranch;
use super::step::Contacts;
use super::stepper::{OneStep, Point};
use super::storage::{Entries, States};
use super::system::Equations;
use crate::scalar::lit;
use crate::{Branch, Scalar};

/// The right-hand side jumps at zero velocity, and holds a contact there, if contacts slide in
/// neither direction so many times within so small a part of the time span.
const ENDLESS: (u32, f64) = (100, 1e-2);

impl<T: Scalar, V: States<T>, S: Equations<T, V, K> + ?Sized, M: OneStep<T, V>, K>
    Integration<'_, T, V, S, M, K>
{
    /// Brings what is known of the contacts to the current point.
    pub(super) fn refresh_locks(&mut self) {
        let Point { time, state, .. } = &self.point;
        let velocities = self.system.velocities(*time, state);
        let mut errors = S::Contacts::filled(self.system.contacts(), T::zero());
        // With many states all velocities are asked for each of them at the start alone.
        let is_known = self.point.state.count() > LARGE && self.progress.statistics.steps > 0;
        if let Some(tolerances) = self.settings.tolerances.as_ref().filter(|_| !is_known) {
            let (mut beside, mut moved) = (state.clone(), velocities.clone());
            for i in 0..state.count() {
                beside[i] += tolerances.absolute()[i];
                self.system.velocities_to(*time, &beside, &mut moved);
                let velocities = moved.entries().iter().zip(velocities.entries());
                for (error, (&moved, &still)) in errors.entries_mut().iter_mut().zip(velocities) {
                    *error += (moved - still).abs();
                }
                beside[i] = state[i];
            }
        }
        let known = velocities.entries().iter().zip(errors.entries());
        for (lock, (&velocity, &error)) in self.locks.entries_mut().iter_mut().zip(known) {
            lock.begin(velocity, Some(error).filter(|_| !is_known));
        }
    }

    /// Passes a time that no step may pass, where an input may have a kink, or a sliding velocity
    /// may jump across zero.
    pub(super) fn pass(&mut self, stop: StopTime<T>) {
        self.progress.pass(stop);
        if stop.is_kink {
            let velocities = self.system.velocities(self.point.time, &self.point.state);
            let locks = self.locks.entries_mut().iter_mut().zip(velocities.entries());
            for (contact, (lock, &velocity)) in locks.enumerate() {
                if lock.jump(velocity) {
                    self.turned.toggle(contact);
                }
            }
            self.refresh_rate();
        }
    }

    /// Turns a contact at the end of a step that was cut at its reversal. Where the dense output
    /// was too coarse, the rest of the way is another step.
    pub(super) fn reverse(
        &mut self,
        before: Option<ContactBranch<T>>,
        contact: usize,
        fraction: T,
    ) -> Result<(), StopReason> {
        let has_arrived = match (before, self.locks.entries().get(contact)) {
            (Some(before), Some(after)) => after.reaches_zero(&before),
            _ => true,
        };
        if has_arrived {
            self.step.reversal = Some(contact);
            self.progress.statistics.reversals += 1;
            self.turn(contact, fraction)?;
        }
        Ok(())
    }

    /// Brings the velocities to the current point, and locks the contacts that slide clearly.
    #[inline]
    pub(super) fn update_locks(&mut self) {
        let velocities = self.system.velocities(self.point.time, &self.point.state);
        let mut has_locked = false;
        let locks = self.locks.entries_mut().iter_mut();
        for (lock, &velocity) in locks.zip(velocities.entries()) {
            if lock.branch == Branch::Free && velocity.abs() > lock.noise {
                lock.branch = Branch::towards(velocity);
                has_locked = true;
            }
            lock.update(velocity);
        }
        if has_locked {
            self.refresh_rate();
        }
    }

    /// Turns a contact that was on the wrong branch from the start of the trial.
    pub(super) fn turn_at_start(&mut self, contact: usize) -> Result<(), StopReason> {
        self.progress.statistics.rejected += 1;
        self.turn(contact, T::zero())?;
        // Turned back again, it has not reversed; nor has it where the first direction was a wrong
        // guess.
        let is_first = self.point.time == self.progress.start_time;
        if !is_first {
            self.turned.toggle(contact);
        }
        if !self.progress.is_adaptive()
            && self.branches.entries().get(contact) == Some(&Branch::Free)
        {
            // Neither branch leads anywhere, and without an error estimate nothing tells whether
            // the free one does.
            return Err(StopReason::EndlessReversals { contact });
        }
        Ok(())
    }

    /// Turns a contact to the other branch at the current point, after a step cut to a fraction.
    fn turn(&mut self, index: usize, fraction: T) -> Result<(), StopReason> {
        if let Some(lock) = self.locks.entries_mut().get_mut(index) {
            lock.turn(fraction);
            if self.progress.is_adaptive() {
                self.progress.limit_length(lock.likely(self.progress.length));
            }
            if lock.branch == Branch::Free {
                let (since, times) = self.undecided;
                let (many, part) = ENDLESS;
                self.undecided = (since, times + 1);
                if times >= many {
                    if (self.point.time - since).abs() < self.progress.span() * lit(part) {
                        return Err(StopReason::EndlessReversals { contact: index });
                    }
                    self.undecided = (self.point.time, 0);
                }
            }
        }
        self.refresh_locks();
        self.refresh_rate();
        Ok(())
    }
}
