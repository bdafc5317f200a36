//! One step: the linear system, solved as its structure has it.

use crate::band;
use crate::mechanism::{LinearMechanism, Storage, Structure};
use crate::rows::{Rows, along, spread};
use bristle::Scalar;
use bristle::parameter::{Checked, Named};
use bristle::scalar::{is_zero, lit};

/// Where a mechanism is and how it moves: the caller's, changed by a step.
#[derive(Debug, PartialEq)]
pub struct Motion<'a, T> {
    /// Coordinates x \[m\].
    pub position: &'a mut [T],
    /// Velocities v [m/s].
    pub velocity: &'a mut [T],
}

/// What stands for friction over a step, F̄ = bias + damping · s̄, of contacts of your own: one of
/// a plane has a row for each axis, for instance.
#[derive(Debug, PartialEq)]
pub struct Sources<'a, T> {
    /// Mean friction force \[N\] of each row if its mean sliding velocity is zero.
    pub bias: &'a [T],
    /// Damping [N s/m] of each row, zero or positive.
    pub damping: &'a [T],
    /// Sliding velocity [m/s] of each row: at the beginning of the step when given, s₀ = W v₀ + w,
    /// averaged over the step afterwards, s̄.
    pub sliding: &'a mut [T],
}

/// The storage of a mechanism.
pub(crate) struct Parts<'a, T> {
    pub(crate) structure: Structure,
    pub(crate) mass: &'a mut [T],
    pub(crate) damping: &'a mut [T],
    pub(crate) stiffness: &'a mut [T],
    /// Of A, in a band of A + (h/2) Wᵀ D W.
    pub(crate) factors: &'a mut [T],
    /// B = A⁻¹ Wᵀ, column by column.
    pub(crate) responses: &'a mut [T],
    /// G = (h/2) W B
    pub(crate) coupling: &'a mut [T],
    /// I + G D
    pub(crate) system: &'a mut [T],
    pub(crate) acceleration: &'a mut [T],
    pub(crate) mean_velocity: &'a mut [T],
    pub(crate) bias: &'a mut [T],
    pub(crate) dampers: &'a mut [T],
    pub(crate) sliding: &'a mut [T],
    /// What the storage has beyond.
    pub(crate) room: &'a mut [T],
}

impl<T: Scalar, R: Rows<T>, S: Storage<T>> LinearMechanism<T, R, S> {
    /// A step of length h ≥ 0 \[s\] under applied forces \[N\], averaged over it, and friction of
    /// your own, whose companions you ask before and commit afterwards.
    /// [`LinearMechanism::step`] does both for contacts of one axis. NaN for NaN, and for h < 0.
    ///
    /// # Errors
    ///
    /// Refuses slices of lengths that do not fit; nothing has moved.
    pub fn advance(
        &mut self,
        duration: T,
        force: &[T],
        motion: Motion<'_, T>,
        sources: Sources<'_, T>,
    ) -> Checked<()> {
        let contacts = self.rows.contacts();
        self.check_motion(force, [&*motion.position, motion.velocity])?;
        check_length("biases", sources.bias, contacts)?;
        check_length("dampings", sources.damping, contacts)?;
        check_length("sliding velocities", sources.sliding, contacts)?;
        let duration = forwards(duration);
        let (rows, mut parts) = self.prepared(duration);
        parts.bias.copy_from_slice(sources.bias);
        parts.dampers.copy_from_slice(sources.damping);
        parts.sliding.copy_from_slice(sources.sliding);
        parts.acceleration.copy_from_slice(force);
        parts.solve(duration, motion, rows);
        sources.sliding.copy_from_slice(parts.sliding);
        Ok(())
    }

    /// W v of a contact [m/s], its sliding velocity without a prescribed part.
    #[inline]
    pub fn sliding_velocity(&self, contact: usize, velocity: &[T]) -> T {
        along(self.rows.row(contact), velocity)
    }

    /// The velocities v̄ [m/s] averaged over the last step.
    pub fn mean_velocities(&self) -> &[T] {
        let (n, m) = (self.coordinates, self.rows.contacts());
        let end = self.structure.storage(n, m) - 3 * m; // behind them: bias, dampers, sliding
        self.storage.as_ref().get(end - n..end).unwrap_or(&[])
    }

    pub(crate) fn check_motion(&self, force: &[T], [position, velocity]: [&[T]; 2]) -> Checked<()> {
        check_length("forces", force, self.coordinates)?;
        check_length("positions", position, self.coordinates)?;
        check_length("velocities", velocity, self.coordinates)
    }

    /// The contacts and the storage, for a step of a length, with A factored for it.
    #[inline(always)]
    pub(crate) fn prepared(&mut self, duration: T) -> (&R, Parts<'_, T>) {
        self.prepare(duration);
        self.split()
    }

    /// Factors A for a step of a length, if it is not.
    #[inline(always)]
    pub(crate) fn prepare(&mut self, duration: T) {
        if self.structure.is_reduced() && self.duration != duration {
            self.factor(lit::<T>(0.5) * duration);
        }
        self.duration = duration;
    }

    /// Factors A; B and G. It splits the storage by itself: parts that a rare branch passes by
    /// address would live in memory in every step.
    #[cold]
    fn factor(&mut self, half: T) {
        let (width, n, m) = (self.width(), self.coordinates, self.rows.contacts().max(1));
        let (rows, mut parts) = self.split();
        parts.assemble(half);
        band::factor(width, parts.factors, |_, _| ());
        for (contact, response) in parts.responses.chunks_exact_mut(n).enumerate() {
            response.fill(T::zero());
            spread(rows.row(contact), T::one(), response);
            band::solve(width, parts.factors, response);
        }
        for (contact, coupled) in parts.coupling.chunks_exact_mut(m).enumerate() {
            let responses = parts.responses.chunks_exact(n);
            for (entry, response) in coupled.iter_mut().zip(responses) {
                *entry = half * along(rows.row(contact), response);
            }
        }
    }
}

impl<T: Scalar> Parts<'_, T> {
    /// The step, from biases, dampers and sliding velocities in the storage, and forces in the
    /// place of the accelerations.
    #[inline(always)]
    pub(crate) fn solve(&mut self, duration: T, motion: Motion<'_, T>, rows: &impl Rows<T>) {
        let Motion { position, velocity } = motion;
        let (width, half) = (self.structure.width(position.len()), lit::<T>(0.5) * duration);
        // First x₀ + (h/2) v₀; the mean velocity at the end.
        let middle = &mut *self.mean_velocity;
        for (middle, (&x, &v)) in middle.iter_mut().zip(position.iter().zip(velocity.iter())) {
            *middle = x + half * v;
        }
        let matrices = [&*self.stiffness, &*self.damping];
        band::subtract_products(width, matrices, [middle, velocity], self.acceleration);
        self.accelerate(half, rows);
        let moved = position.iter_mut().zip(velocity).zip(&mut *self.mean_velocity);
        for (((x, v), mean), &a) in moved.zip(&*self.acceleration) {
            *mean = *v + half * a;
            *x += duration * *mean;
            *v += duration * a;
        }
    }

    /// The acceleration from r, and s̄ from s₀.
    #[inline(always)]
    pub(crate) fn accelerate(&mut self, half: T, rows: &impl Rows<T>) {
        let width = self.structure.width(self.acceleration.len());
        if self.structure.is_reduced() {
            self.solve_contacts(width, half, rows);
        } else {
            self.solve_whole(width, half, rows);
        }
    }

    /// factors = A.
    #[inline(always)]
    fn assemble(&mut self, half: T) {
        let matrices = self.mass.iter().zip(&*self.damping).zip(&*self.stiffness);
        for (sum, ((&m, &c), &k)) in self.factors.iter_mut().zip(matrices) {
            *sum = m + half * (c + half * k);
        }
    }

    /// By a system of the size of the contacts.
    #[inline(always)]
    fn solve_contacts(&mut self, width: usize, half: T, rows: &impl Rows<T>) {
        band::solve(width, self.factors, self.acceleration);
        let contacts = self.bias.len();
        for (contact, sliding) in self.sliding.iter_mut().enumerate() {
            let row = contact * contacts..(contact + 1) * contacts;
            let (coupled, system) = (&self.coupling[row.clone()], &mut self.system[row]);
            let mut sum = *sliding + half * along(rows.row(contact), self.acceleration);
            let sources = self.bias.iter().zip(&*self.dampers);
            for ((entry, &g), (&bias, &damper)) in system.iter_mut().zip(coupled).zip(sources) {
                sum -= g * bias;
                *entry = g * damper;
            }
            system[contact] += T::one();
            *sliding = sum;
        }
        band::eliminate(self.system, self.sliding);
        let forces = self.bias.iter().zip(&*self.dampers).zip(&*self.sliding);
        for (contact, ((&bias, &damper), &sliding)) in forces.enumerate() {
            let force = bias + damper * sliding;
            let response = &self.responses[contact * self.acceleration.len()..];
            for (a, &b) in self.acceleration.iter_mut().zip(response) {
                *a -= b * force;
            }
        }
    }

    /// By the system in a band.
    #[inline(always)]
    fn solve_whole(&mut self, width: usize, half: T, rows: &impl Rows<T>) {
        self.assemble(half);
        for (contact, &sliding) in self.sliding.iter().enumerate() {
            let (row, damper) = (rows.row(contact), self.dampers[contact]);
            let (force, damper) = (self.bias[contact] + damper * sliding, half * damper);
            for (k, &(i, factor)) in row.iter().enumerate().filter(|(_, pair)| !is_zero(pair.1)) {
                if let Some(a) = self.acceleration.get_mut(i) {
                    *a -= factor * force;
                }
                let scaled = damper * factor;
                if let Some(entry) = self.factors.get_mut(band::place(width, i, i)) {
                    *entry += scaled * factor;
                }
                for &(j, other) in row[..k].iter().filter(|(_, other)| !is_zero(*other)) {
                    // Both entries of a coordinate that is named twice.
                    let both = if i == j { other + other } else { other };
                    let place = band::place(width, i.max(j), i.min(j));
                    if let Some(entry) = self.factors.get_mut(place) {
                        *entry += scaled * both;
                    }
                }
            }
        }
        band::factor_and_solve(width, self.factors, self.acceleration);
        for (contact, sliding) in self.sliding.iter_mut().enumerate() {
            *sliding += half * along(rows.row(contact), self.acceleration);
        }
    }
}

/// NaN for a step backwards.
#[inline]
pub(crate) fn forwards<T: Scalar>(duration: T) -> T {
    if duration >= T::zero() { duration } else { T::nan() }
}

/// Refuses a slice of another length.
#[inline]
pub(crate) fn check_length<V>(name: &'static str, slice: &[V], wanted: usize) -> Checked<()> {
    Named(name, slice.len()).count_between(wanted, wanted)
}
