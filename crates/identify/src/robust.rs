//! Losses: squares, and robust ones by iteratively reweighted least squares (IRLS).
//!
//! Σ w(r/s) r² → min,  s = 1.4826 median|r|
//!
//! | loss | w(u) |
//! |---|---|
//! | squares | 1 |
//! | Huber | min(1, 1.345/\|u\|) |
//! | Tukey's bisquare | (1 − (u/4.685)²)² within \|u\| < 4.685, else 0 |
//!
//! Both lose 5 % of the efficiency under Gaussian noise. Huber's has no other minima than squares;
//! Tukey's ignores outliers.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | r | residual | – |
//! | s | robust estimate of its standard deviation | – |
//! | u, w | r/s, weight | – |
//!
//! Source: P. J. Huber, E. M. Ronchetti, "Robust Statistics" (2009), chapter 7; the constants are
//! the usual ones.

use super::log::median;

/// What is minimised: Σ w(r/s) r².
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Loss {
    /// Squares, w = 1.
    #[default]
    Squares,
    /// Huber's loss: outliers count by their size.
    Huber,
    /// Tukey's bisquare: outliers do not count.
    Tukey,
}

impl Loss {
    /// The square roots of the weights of residuals without their signs; none where half of them
    /// vanish.
    pub(super) fn weights(self, sizes: &[f64]) -> Vec<f64> {
        let spread = 1.4826 * median(&mut sizes.to_vec());
        let weight = |size: &f64| match (self, size / spread) {
            (Self::Squares, _) => 1.0,
            (Self::Huber, u) => (1.345 / u).min(1.0).sqrt(),
            (Self::Tukey, u) => (1.0 - (u / 4.685).powi(2)).max(0.0),
        };
        if spread > 0.0 { sizes.iter().map(weight).collect() } else { Vec::new() }
    }
}
