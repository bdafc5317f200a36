//! Friction laws as an engine meets them: over one step a source and a damper, F̄ = bias +
//! damping·v̄.

use std::fmt::Debug;

use bristle::companion::{Companion, CompanionStep, PointMass, Prediction, VelocityHistory};
use bristle::curve::{FrictionCurve, Stribeck};
use bristle::{Bristle, ParameterError};
use bristle_analysis::ledger::{EnergyBalance, EnergyLedger};

/// Friction along one direction of one contact.
pub trait Law: Debug {
    /// Begins a step, from the sliding velocity at its beginning [m/s], the normal force [N] and
    /// its length [s].
    fn begin(&mut self, velocity: f64, normal_force: f64, h: f64) -> Result<(), ParameterError>;

    /// The step as a damper [N s/m] that pulls towards a velocity [m/s]; `None` where there is
    /// none.
    fn damper(&self) -> Option<(f64, f64)>;

    /// The mean friction force [N] on a free mass, solved in closed form.
    fn force(&self, body: PointMass<f64>) -> f64;

    /// Ends the step with the mean sliding velocity that the engine has found [m/s].
    fn commit(&mut self, mean_velocity: f64);

    /// Where the energy went.
    fn ledger(&self) -> &EnergyLedger<f64>;
}

/// A bristle model.
#[derive(Debug)]
pub struct Bristles<M> {
    companion: Companion<f64, M>,
    deflection: f64,
    history: VelocityHistory<f64>,
    step: Option<CompanionStep<f64>>,
    ledger: EnergyLedger<f64>,
}

impl<M: Bristle<f64, Deflection = f64>> Bristles<M> {
    /// Undeflected bristles, whose stiffness was measured under this load [N], and which slide no
    /// faster than this [m/s].
    pub fn new(model: M, reference_load: f64, fastest: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            companion: model.under_load(reference_load)?.companion(fastest)?,
            deflection: 0.0,
            history: VelocityHistory::new(0.0),
            step: None,
            ledger: EnergyLedger::new(),
        })
    }
}

impl<M: Bristle<f64, Deflection = f64>> Law for Bristles<M> {
    fn begin(&mut self, velocity: f64, normal_force: f64, h: f64) -> Result<(), ParameterError> {
        self.history.push(velocity);
        let velocity = self.history.predict();
        // The stiffness stays; a bristle that the surface no longer holds slips back.
        let reloaded = self.companion.reload(normal_force, velocity, self.deflection)?;
        self.deflection = reloaded.deflection;
        self.ledger.enter(reloaded);
        // Whether an elasto-plastic bristle yields within the step has to be known beforehand.
        let deflection = self.deflection + 0.5 * h * velocity;
        let middle = Prediction { velocity, deflection };
        self.step = Some(self.companion.step_about(middle, self.deflection, h));
        Ok(())
    }

    fn damper(&self) -> Option<(f64, f64)> {
        let step = self.step.as_ref()?;
        Some((step.damping(), step.target_velocity()?))
    }

    fn force(&self, body: PointMass<f64>) -> f64 {
        self.step.as_ref().map_or(0.0, |step| step.force(step.point_mass(body)))
    }

    fn commit(&mut self, mean_velocity: f64) {
        if let Some(step) = self.step.take() {
            let done = step.commit(mean_velocity);
            self.deflection = done.deflection;
            self.ledger.enter(done);
        }
    }

    fn ledger(&self) -> &EnergyLedger<f64> {
        &self.ledger
    }
}

/// Coulomb friction whose jump at rest is smeared over a velocity ε, F = p μ(v) v/√(v² + ε²).
#[derive(Debug)]
pub struct Regularised {
    curve: Stribeck<f64>,
    epsilon: f64,
    implicit: bool,
    history: VelocityHistory<f64>,
    /// Bias, damping and length of the step under way.
    step: (f64, f64, f64),
    ledger: EnergyLedger<f64>,
}

impl Regularised {
    /// Smeared over ε [m/s]. Explicit: all of it from the velocity at the beginning of the step.
    /// Implicit: the v in the numerator is the step's mean velocity, so that the friction is a
    /// damper.
    pub fn new(curve: Stribeck<f64>, epsilon: f64, implicit: bool) -> Self {
        Self {
            curve,
            epsilon,
            implicit,
            history: VelocityHistory::new(0.0),
            step: (0.0, 0.0, 0.0),
            ledger: EnergyLedger::new(),
        }
    }
}

impl Law for Regularised {
    fn begin(&mut self, velocity: f64, normal_force: f64, h: f64) -> Result<(), ParameterError> {
        self.history.push(velocity);
        let known = if self.implicit { self.history.predict() } else { velocity };
        let damping = normal_force * self.curve.at(known) / known.hypot(self.epsilon);
        self.step = if self.implicit { (0.0, damping, h) } else { (damping * velocity, 0.0, h) };
        Ok(())
    }

    fn damper(&self) -> Option<(f64, f64)> {
        let (_, damping, _) = self.step;
        (damping > 0.0).then_some((damping, 0.0))
    }

    fn force(&self, body: PointMass<f64>) -> f64 {
        let (bias, damping, h) = self.step;
        let pace = body.end_weight * h;
        let mean =
            (body.mass * body.velocity + pace * (body.force - bias)) / (body.mass + pace * damping);
        bias + damping * mean
    }

    fn commit(&mut self, mean_velocity: f64) {
        let (bias, damping, h) = self.step;
        let work = h * (bias + damping * mean_velocity) * mean_velocity;
        self.ledger.enter(EnergyBalance { supplied: work, stored: 0.0, dissipated: work });
    }

    fn ledger(&self) -> &EnergyLedger<f64> {
        &self.ledger
    }
}

/// Nothing, for the engine has its own.
#[derive(Debug, Default)]
pub struct Frictionless {
    ledger: EnergyLedger<f64>,
}

impl Law for Frictionless {
    fn begin(&mut self, _: f64, _: f64, _: f64) -> Result<(), ParameterError> {
        Ok(())
    }

    fn damper(&self) -> Option<(f64, f64)> {
        None
    }

    fn force(&self, _: PointMass<f64>) -> f64 {
        0.0
    }

    fn commit(&mut self, _: f64) {}

    fn ledger(&self) -> &EnergyLedger<f64> {
        &self.ledger
    }
}
