//! Parameters from measurements: the parameters of a friction model from a log of motion and
//! friction, with standard errors, and what the log does not determine.
//!
//! C(q) = Σ rₖ² → min,  rₖ = μ_model(tₖ; q) − Fₖ/pₖ
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | q | search variables: logarithms of positive parameters, others over a typical magnitude | – |
//! | μ_model | friction coefficient of the model, run along the measured motion | – |
//! | Fₖ, pₖ | measured friction and normal force at the time tₖ | N |
//! | r, J | residuals, and their sensitivities ∂r/∂q | – |
//! | n, N | number of rows and of parameters | – |
//!
//! | step | what | where |
//! |---|---|---|
//! | 1 | columns, checked row by row | [`Log`] |
//! | 2 | starting values for stiffness and curve | [`InitialGuess`] |
//! | 3 | a model with free parameters | [`FrBdFit`], [`ElastoPlasticFit`], your own [`Candidate`] |
//! | 4 | the best parameters, with standard errors | [`fit`] gives a [`Fit`], which prints |
//! | 5 | a test on data that the fit has not seen | [`predict`] |
//!
//! Where no friction was measured, as in a robot that logs drive and position, see [`mechanism`].
//! Problems of another kind implement [`Residuals`] and call [`least_squares`]: the search and the
//! report know nothing of friction.
//!
//! Sensitivities are exact, by dual numbers through the whole run. The search is that of Levenberg
//! and Marquardt within bounds,
//!
//! min |J δ + r|² + λ |D δ|²,  D = the largest lengths of the columns of J so far.
//!
//! It works on a triangular factor of J (Givens). λ follows the ratio of the actual decrease of C
//! to the predicted one. A parameter at a bound that the descent points beyond does not move.
//!
//! Before a search has converged, each parameter is changed by 5 % both ways. If that lowers C by
//! more than a thousandth, the search goes on from there. It has
//! [stalled](SearchOutcome::Stalled) where it could not follow such a change, or where the gradient
//! of one parameter alone still promises a thousandth.
//!
//! # Standard errors
//!
//! Errors of the model last for many rows, so the residuals are not taken as independent:
//!
//! Cov = (JᵀJ)⁻¹ S (JᵀJ)⁻¹ n/(n − N),  S = Σₖ Σₗ (1 − |k − l|/L)₊ gₖ gₗᵀ,  gₖ = Jₖᵀ rₖ
//!
//! with a window L of ten correlation times τ = 1 + 2Σρ of the residuals, at most a tenth of the
//! rows. If τ σ² (JᵀJ)⁻¹ n/(n − N) with the mean square σ² of the residuals gives a larger
//! variance, that is taken: where few rows determine a parameter, the sum is too small on average.
//!
//! An error that repeats in every period of the motion is not noise, and no window sees it: use
//! [`predict`].
//!
//! # What the data do not determine
//!
//! Scale the columns of J to length one. A direction of parameters whose singular value is below √ε
//! of the largest has no effect, and every parameter with a share of at least 3 % in it is
//! [`Identifiability::Undetermined`]. A parameter whose standard error exceeds its value is
//! [`Identifiability::Uncertain`].
//!
//! Both refer to the minimum that was found: in a local minimum a parameter can be determined and
//! wrong. Motion to and fro at one speed, for instance, determines σ0 and one value of μ, but not
//! μ_s, v_S and σ2.
//!
//! # Limits
//!
//! The velocity is held between two rows: sample faster where it changes much within one, or where
//! the force jumps. Noise of the position acts on the model as motion. The residuals are
//! differences of the force alone.
//!
//! Sources: J. J. Moré, "The Levenberg-Marquardt algorithm: implementation and theory", Lecture
//! Notes in Mathematics 630 (1978); H. B. Nielsen, "Damping parameter in Marquardt's method",
//! report IMM-REP-1999-05, DTU (1999); W. K. Newey, K. D. West, "A simple, positive semi-definite,
//! heteroskedasticity and autocorrelation consistent covariance matrix", Econometrica 55 (1987),
//! 703–708.
#![cfg_attr(docsrs, feature(doc_cfg))]

mod candidates;
mod initial_guess;
mod least_squares;
mod log;
pub mod mechanism;
mod problem;
mod report;
mod residuals;
mod robust;
mod simulation;
mod static_curve;
mod triangle;
mod uncertainty;

pub use candidates::{Candidate, ElastoPlasticFit, FrBdFit};
pub use initial_guess::{InitialGuess, SlidingPoint};
pub use least_squares::{SearchProgress, SearchSettings, least_squares};
pub use log::{Log, LogParameters, MeasuredMotion};
pub use report::{Estimate, Fit, Identifiability, Remark, SearchOutcome};
pub use residuals::{Parameter, Residuals};
pub use simulation::{fit, predict};

/// The programs on these pages are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
#[doc = include_str!("../docs/identification.md")]
struct Pages;
