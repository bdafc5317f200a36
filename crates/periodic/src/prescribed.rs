//! A bristle under a prescribed velocity that repeats: no iteration.
//!
//! ż = −λ(v(t)) z + r(v(t)) v(t),  z(T) = E z(0) + D,  z(0) = (1 − E)⁻¹ D
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | z | deflection, or the stretches of several springs | m |
//! | λ, r | coefficients of the bristle, see `bristle::Affine` | 1/s, – |
//! | E, D | what a period keeps of a deflection, and what it makes of none | –, m |
//!
//! It holds where the coefficients depend on the velocity alone: not for an elasto-plastic or
//! implicit bristle.

use bristle::ode::System;
use bristle::parameter::ParameterError;
use bristle::rheology::States;
use bristle::scene::PrescribedVelocity;
use bristle::signal::Signal;
use bristle::{Bristle, Contact, Form};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use crate::segments::solve;
use crate::{Answer, Guess, Orbit, Shooting};

impl Shooting {
    /// The deflections of a contact under a velocity of period T \[s\] that repeat with it, from
    /// one run: of a model whose coefficients depend on the velocity alone.
    ///
    /// ```
    /// use bristle::signal::{Sine, SineParameters};
    /// use bristle::{Bristle, Dahl, DahlParameters};
    /// use bristle_periodic::Shooting;
    ///
    /// let dahl = DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 };
    /// let contact = Dahl::new(dahl)?.under_load(10.0)?;
    /// let wave = SineParameters { mean: 0.0, amplitude: 1e-3, frequency: 1.0, phase: 0.0 };
    /// let loop_ = Shooting::default().prescribed(&contact, Sine::new(wave)?, (0.0, 1.0))?;
    /// // At the turn of a loop of amplitude X = 1 mm/s/(2π s⁻¹): −(μ/σ0) tanh(σ0 X/μ).
    /// let turn = -5e-5 * (1e-3 / std::f64::consts::TAU / 5e-5_f64).tanh();
    /// assert!((loop_.start[0] / turn - 1.0).abs() < 1e-9);
    /// # Ok::<(), bristle_periodic::PeriodicError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses another model, a velocity that is zero throughout (every deflection repeats), and a
    /// period that is not positive; says why the run stopped.
    pub fn prescribed<M, V, const N: usize>(
        &self,
        contact: &Contact<f64, M>,
        velocity: V,
        (start_time, period): (f64, f64),
    ) -> Answer<Orbit<N>>
    where
        M: Bristle<f64, Deflection: States<f64, N>>,
        V: Signal<f64>,
    {
        if contact.model().form() != Form::OfVelocity {
            let takes = "a known velocity takes a model whose coefficients depend on it alone";
            return Err(ParameterError::chosen(contact.model().name(), takes).into());
        }
        let system = PrescribedVelocity::new(contact.clone(), velocity);
        let cyclic = self.cyclic(Some(start_time), System::<f64, N>::scales(&system))?;
        let run = cyclic.of(&system).flow((start_time, SVector::zeros()), period)?;
        let kept = SMatrix::identity() - run.product();
        let made = run.end.component_div(&cyclic.scales);
        let kept = DMatrix::from_column_slice(N, N, kept.as_slice());
        let made = solve(kept, &DVector::from_column_slice(made.as_slice()))?;
        let state = SVector::from_fn(|i, _| made[i] * cyclic.scales[i]);
        cyclic.orbit(&[Guess { state, period }], &[run])
    }
}
