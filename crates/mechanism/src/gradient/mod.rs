//! Gradients of a loss with respect to friction parameters, by the adjoint of companion steps.
//!
//! A step makes the state at its end from that at its beginning. Its adjoint makes, from the
//! derivatives of a loss by the state at the end, those by the state at the beginning, and adds
//! those by the parameters to a gradient. It looks at both states and solves once with the matrix
//! of the step, which is symmetric: with ā the derivative by the mean acceleration a, and
//! y = (A + (h/2) Wᵀ D W)⁻¹ ā,
//!
//! ∂/∂f = y,  ∂/∂βₖ = −(W y)ₖ,  ∂/∂Dₖ = −(W y)ₖ s̄ₖ,  ∂/∂x₀ = ∂/∂x₁ − K y, …
//!
//! Branches (reversals of a predicted velocity, a deflection at its limit, a bristle that slips
//! back where the load falls) are those that the step took: the gradient is that of the program.
//!
//! Source: the method of adjoints for recurrences, A. E. Bryson, Y.-C. Ho, "Applied Optimal
//! Control" (1969), section 2.2; checkpoints: A. Griewank, A. Walther, "Evaluating Derivatives"
//! (2008), chapter 12.

mod arm;
mod contact;
mod model;

pub use arm::{ArmAdjoint, ArmMiddleAdjoint, ArmState};
pub use contact::ContactAdjoint;
pub use model::Differentiable;

use crate::band;
use crate::contacts::{ContactState, Inputs, Step};
use crate::mechanism::{LinearMechanism, Storage};
use crate::rows::{Rows, along, spread};
use crate::step::{Parts, check_length, forwards};
use bristle::Scalar;
use bristle::companion::{Companion, CompanionStep};
use bristle::parameter::Checked;
use bristle::scalar::lit;

/// The derivatives of a loss by the state of a mechanism: at the end of a step when given, at its
/// beginning afterwards.
#[derive(Debug, PartialEq)]
pub struct Adjoint<'a, T> {
    /// By the coordinates x.
    pub position: &'a mut [T],
    /// By the velocities v.
    pub velocity: &'a mut [T],
    /// By the forces f̄ of the step: written.
    pub force: &'a mut [T],
    /// By what the contacts keep.
    pub contacts: &'a mut [ContactAdjoint<T>],
}

impl<T: Scalar, R: Rows<T>, S: Storage<T>> LinearMechanism<T, R, S> {
    /// Goes back over a [step](LinearMechanism::step), from the states of the contacts before and
    /// after it: changes the derivatives of a loss by the state at its end to those by the state at
    /// its beginning, and adds those by the parameters of each companion, one after the other, to
    /// `gradient`. One companion for all contacts has one set of parameters. Length and inputs are
    /// those of the step. The mean velocities of the mechanism are lost.
    ///
    /// # Errors
    ///
    /// Refuses slices of lengths that do not fit; nothing has changed.
    pub fn pull_back<M: Differentiable<T>>(
        &mut self,
        duration: T,
        inputs: &Inputs<'_, T>,
        companions: &[Companion<T, M>],
        contacts: [&[ContactState<T>]; 2],
        adjoint: Adjoint<'_, T>,
        gradient: &mut [T],
    ) -> Checked<()> {
        let Adjoint { position, velocity, force, contacts: by_contacts } = adjoint;
        self.check_step(inputs, [&*position, velocity], companions, contacts[0])?;
        check_length("derivatives by forces", force, self.coordinates)?;
        self.check_gradient(companions, contacts[1], by_contacts, gradient)?;
        let duration = forwards(duration);
        let (rows, mut parts) = self.prepared(duration);
        let step = Step { duration, companions, rows };
        force.fill(T::zero());
        let by = [position, velocity, force];
        parts.pull_back(&step, inputs.prescribed, contacts, by, by_contacts, gradient);
        force.copy_from_slice(parts.acceleration);
        if inputs.load.is_empty() {
            // The load was that of the step before.
            for by in by_contacts {
                (by.load, by.given_load) = (by.load + by.given_load, T::zero());
            }
        }
        Ok(())
    }

    pub(crate) fn check_gradient<M: Differentiable<T>>(
        &self,
        companions: &[Companion<T, M>],
        after: &[ContactState<T>],
        contacts: &[ContactAdjoint<T>],
        gradient: &[T],
    ) -> Checked<()> {
        self.check_contacts(companions, after)?;
        check_length("derivatives by contacts", contacts, self.rows.contacts())?;
        check_length("entries of the gradient", gradient, M::PARAMETERS * companions.len())
    }
}

impl<T: Scalar> Parts<'_, T> {
    /// From the derivatives by x, v and a at the end of the step, those by x and v at its
    /// beginning; y in the place of the accelerations.
    pub(crate) fn pull_back<R: Rows<T>, M: Differentiable<T>>(
        &mut self,
        step: &Step<'_, T, R, M>,
        prescribed: &[T],
        [before, after]: [&[ContactState<T>]; 2],
        [position, velocity, acceleration]: [&mut [T]; 3],
        adjoints: &mut [ContactAdjoint<T>],
        gradient: &mut [T],
    ) {
        let &Step { duration, companions, rows } = step;
        let (half, width) = (lit::<T>(0.5) * duration, self.structure.width(position.len()));
        for (i, x) in position.iter().enumerate() {
            velocity[i] += duration * *x;
            self.acceleration[i] = acceleration[i] + duration * velocity[i] - half * duration * *x;
        }
        for (k, (adjoint, after)) in adjoints.iter().zip(after).enumerate() {
            spread(rows.row(k), half * adjoint.by_mean(after), self.acceleration);
            self.dampers[k] = after.frozen.as_ref().map_or(T::zero(), CompanionStep::damping);
        }
        self.bias.fill(T::zero());
        self.sliding.fill(T::zero());
        self.accelerate(half, rows);
        let (y, middle) = (&*self.acceleration, &mut *self.mean_velocity);
        middle.fill(T::zero());
        let matrices = [&*self.stiffness, &*self.damping];
        band::subtract_products(width, matrices, [y, middle], position);
        middle.iter_mut().zip(y).for_each(|(middle, y)| *middle = half * *y);
        band::subtract_products(width, matrices, [middle, y], velocity);
        for (k, adjoint) in adjoints.iter_mut().enumerate() {
            let (states, moved) = ([&before[k], &after[k]], along(rows.row(k), y));
            let without = after[k].before.unwrap_or_else(T::zero);
            let sliding = prescribed.get(k).map_or(without, |&belt| without + belt);
            let by = [-moved, -moved * after[k].mean];
            let mut by_sliding =
                adjoint.before + adjoint.by_mean(&after[k]) - self.dampers[k] * moved;
            let one = k.min(companions.len() - 1);
            let gradient = &mut gradient[M::PARAMETERS * one..][..M::PARAMETERS];
            let sliding = [without, sliding];
            let companion = &companions[one];
            by_sliding += adjoint.pull_back(companion, duration, states, sliding, by, gradient);
            spread(rows.row(k), by_sliding, velocity);
        }
    }
}

/// Goes over a run backwards: hands out the number of each step, from the last down to 0, and the
/// states before and after it. Every `between`-th state is kept, and the others are made again by
/// `step`: with 1 all are kept and nothing is made again; with √steps the memory is twice that many
/// states, for one more simulation.
///
/// # Errors
///
/// What `step` and `back` refuse.
#[cfg(feature = "alloc")]
pub fn backwards<S: Clone, E>(
    start: S,
    steps: usize,
    between: usize,
    mut step: impl FnMut(usize, &mut S) -> Result<(), E>,
    mut back: impl FnMut(usize, [&S; 2]) -> Result<(), E>,
) -> Result<(), E> {
    let between = between.max(1);
    let mut kept = alloc::vec![start];
    for first in (0..steps).step_by(between).skip(1) {
        kept.extend_from_within(kept.len() - 1..);
        let Some(state) = kept.last_mut() else { break };
        (first - between..first).try_for_each(|n| step(n, state))?;
    }
    let (mut end, mut states) = (steps, alloc::vec::Vec::new());
    while let Some(state) = kept.pop() {
        let first = kept.len() * between;
        // The state at the end of all but the last stretch begins the one after.
        let after = states.drain(..).next();
        states.push(state);
        for n in first..end - usize::from(after.is_some()) {
            states.extend_from_within(states.len() - 1..);
            states.last_mut().map_or(Ok(()), |state| step(n, state))?;
        }
        states.extend(after);
        for (n, pair) in (first..end).zip(states.windows(2)).rev() {
            back(n, [&pair[0], &pair[1]])?;
        }
        end = first;
    }
    Ok(())
}
