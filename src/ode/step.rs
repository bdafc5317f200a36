//! One accepted step and its dense output.

use core::fmt::Debug;

use super::dense_output::DenseOutput;
use super::storage::States;
use crate::Scalar;

/// Some of the contacts of a system.
pub(crate) trait Contacts: Debug + Clone + PartialEq + Default {
    /// Takes a contact out, or in.
    fn toggle(&mut self, contact: usize);

    /// The contacts, in order: as long as some are left, not as many as there could be.
    fn iter(&self) -> impl Iterator<Item = usize> + use<Self>;
}

/// A bit for each contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Few(u128);

impl Few {
    pub(super) const MOST: usize = 128;
}

impl Contacts for Few {
    fn toggle(&mut self, contact: usize) {
        self.0 ^= 1 << contact;
    }

    fn iter(&self) -> impl Iterator<Item = usize> + use<> {
        let mut left = *self;
        core::iter::from_fn(move || {
            let contact = (left.0 != 0).then(|| left.0.trailing_zeros() as usize)?;
            left.toggle(contact);
            Some(contact)
        })
    }
}

/// Any number of contacts.
#[cfg(feature = "alloc")]
impl Contacts for alloc::collections::BTreeSet<usize> {
    fn toggle(&mut self, contact: usize) {
        if !self.remove(&contact) {
            self.insert(contact);
        }
    }

    fn iter(&self) -> impl Iterator<Item = usize> + use<> {
        self.clone().into_iter()
    }
}

/// One accepted step of an integration, with the state at every time within it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step<T: Scalar, V: States<T>> {
    pub(super) start_time: T,
    pub(super) end_time: T,
    /// Length of the step that the dense output spans: longer than this one if it was cut at an
    /// event.
    pub(super) whole: T,
    pub(super) end: V,
    pub(super) dense_output: DenseOutput<T, V>,
    pub(super) reversals_at_start: V::Contacts,
    pub(super) reversal: Option<usize>,
}

impl<T: Scalar, V: States<T>> Step<T, V> {
    /// Time at which the step starts \[s\].
    pub fn start_time(&self) -> T {
        self.start_time
    }

    /// Time at which the step ends \[s\].
    pub fn end_time(&self) -> T {
        self.end_time
    }

    /// State at the start.
    pub fn start(&self) -> &V {
        &self.dense_output.start
    }

    /// State at the end.
    pub fn end(&self) -> &V {
        &self.end
    }

    /// The contact whose sliding direction reverses at the end of the step, if one does: the step
    /// was cut there.
    pub fn reversal(&self) -> Option<usize> {
        self.reversal
    }

    /// The contacts whose sliding directions reverse where the step starts, without the step before
    /// being cut for them: those that reverse together with another one.
    pub fn reversals_at_start(&self) -> impl Iterator<Item = usize> + use<T, V> {
        self.reversals_at_start.iter()
    }

    /// The state at a time within the step.
    pub fn at(&self, time: T) -> V {
        if time == self.end_time || self.start_time == self.end_time {
            return self.end.clone();
        }
        self.dense_output.at((time - self.start_time) / self.whole)
    }

    /// The time at a fraction of the step.
    pub(super) fn time_at(&self, fraction: T) -> T {
        self.start_time + (self.end_time - self.start_time) * fraction
    }

    /// The state at a fraction of the step, 0 at its start and 1 at its end.
    #[inline]
    pub fn at_fraction(&self, fraction: T) -> V {
        let mut state = self.end.clone();
        self.at_fraction_to(fraction, &mut state);
        state
    }

    /// The same, written over a state.
    #[inline]
    pub(super) fn at_fraction_to(&self, fraction: T, state: &mut V) {
        let duration = self.end_time - self.start_time;
        // A step that was not cut has its length to the last bit.
        let part = if duration == self.whole { T::one() } else { duration / self.whole };
        self.dense_output.at_to(fraction * part, state);
    }

    /// The part of the step up to a time within it, with the same dense output.
    pub(super) fn until(&self, fraction: T) -> Self {
        let reversal = if fraction == T::one() { self.reversal } else { None };
        Self {
            end_time: self.time_at(fraction),
            end: self.at_fraction(fraction),
            reversal,
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Few, Step};
    use crate::ode::dense_output::DenseOutput;
    use nalgebra::Vector1;

    /// A quartic is its own curve.
    fn quartic() -> (Step<f64, Vector1<f64>>, impl Fn(f64) -> f64) {
        let value = |t: f64| 1.0 + t - 2.0 * t.powi(2) + 0.5 * t.powi(3) + 0.25 * t.powi(4);
        let slope = |t: f64| 1.0 - 4.0 * t + 1.5 * t.powi(2) + t.powi(3);
        let (a, b) = (0.5, 2.5);
        let chord = value(b) - value(a);
        let from_start = 2.0 * slope(a) - chord;
        let from_end = chord - 2.0 * slope(b) - from_start;
        let terms = [chord, from_start, from_end].map(Vector1::new);
        let mut dense_output = DenseOutput::new(Vector1::new(value(a)), terms);
        dense_output.push(Vector1::new(0.25 * 2f64.powi(4)));
        let step = Step {
            start_time: a,
            end_time: b,
            whole: b - a,
            end: Vector1::new(value(b)),
            dense_output,
            reversals_at_start: Few::default(),
            reversal: None,
        };
        (step, value)
    }

    #[test]
    fn a_quartic_is_reproduced_and_stays_itself_when_the_step_is_shortened() {
        let (step, value) = quartic();
        let short = step.until(0.3);
        assert!((short.end_time() - 1.1).abs() < 1e-15);
        for i in 0..=10 {
            let t = 0.5 + 0.2 * f64::from(i);
            assert!((step.at(t)[0] - value(t)).abs() < 1e-14 * 10.0, "{t}");
            let part = 0.1 * f64::from(i);
            let t = 0.5 + 0.6 * part;
            assert!((short.at(t)[0] - value(t)).abs() < 1e-14 * 10.0, "{t}");
            assert!((short.at_fraction(part)[0] - value(t)).abs() < 1e-14 * 10.0, "{t}");
        }
    }
}
