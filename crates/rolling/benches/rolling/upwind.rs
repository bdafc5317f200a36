//! First-order upwind differences with implicit relaxation, the common baseline:
//!
//! zᵢ ← (zᵢ − C (zᵢ − zᵢ₋₁) + h r v)/(1 + λ h),  z₀ = 0,  Courant number C = V h N ≤ 1.

use bristle::Bristle;
use bristle_rolling::Grid;

/// A patch on the nodes, and with the weights, of a [`Grid`].
pub(crate) struct Upwind<M> {
    model: M,
    weights: Vec<f64>,
    deflections: Vec<f64>,
    next: Vec<f64>,
}

impl<M: Bristle<f64, Deflection = f64>> Upwind<M> {
    pub(crate) fn new(model: &M, grid: &Grid<f64, M>) -> Self {
        let still = vec![0.0; grid.cells() + 1];
        Self {
            model: model.clone(),
            weights: grid.weights().iter().map(|w| w * grid.normal_force()).collect(),
            deflections: still.clone(),
            next: still,
        }
    }

    /// A step of a duration [s] at a held slip velocity [m/s].
    pub(crate) fn step(&mut self, slip_velocity: f64, courant: f64, duration: f64) {
        let affine = self.model.affine(slip_velocity.into(), 0.0);
        let gained = duration * affine.drive * slip_velocity;
        let left = 1.0 / (1.0 + duration * affine.relaxation);
        let pairs = self.deflections.iter().zip(self.deflections.iter().skip(1));
        for (next, (before, here)) in self.next.iter_mut().skip(1).zip(pairs) {
            *next = (here - courant * (here - before) + gained) * left;
        }
        std::mem::swap(&mut self.deflections, &mut self.next);
    }

    /// The friction force [N] at a slip velocity [m/s].
    pub(crate) fn force(&self, slip_velocity: f64) -> f64 {
        let affine = self.model.affine(slip_velocity.into(), 0.0);
        let nodes = self.weights.iter().zip(&self.deflections);
        nodes.map(|(w, z)| w * (affine.stiffness * z + affine.damping * slip_velocity)).sum()
    }
}
