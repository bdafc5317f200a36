//! Parameters from measurements: what a log of motion and friction tells about a model, how well, and what it does not tell.
//!
//! C(q) = Σ rₖ² → min,  rₖ = μ_model(tₖ; q) − Fₖ/pₖ
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | q | parameters: logarithms of positive ones, others over a typical magnitude | – |
//! | μ_model | friction coefficient of a model that sees the measured motion only, and runs along it by exact steps | – |
//! | Fₖ, pₖ | measured friction and normal force at the time tₖ | N |
//!
//! | step | what | where |
//! |---|---|---|
//! | 1 | columns, checked row by row | [`Log`] |
//! | 2 | stiffness and curve at a glance | [`InitialGuess`], [`static_curve`] |
//! | 3 | a model with free parameters | [`FrBdFit`], [`MaxwellFit`], [`ElastoPlasticFit`], or a [`Candidate`] of your own |
//! | 4 | the best parameters, with standard errors | [`fit`] gives a [`Fit`], which prints as a table |
//! | 5 | data it has not seen | [`predict`] |
//!
//! Sensitivities are exact, by dual numbers through the whole run. The search is that of Levenberg and Marquardt within bounds,
//! on a triangle that takes the rows one by one (Givens), so that nothing large is stored:
//!
//! min |J δ + r|² + λ |D δ|²,  D = the largest lengths of the columns of J so far.
//!
//! λ follows the ratio of the decrease of C to the promised one. A parameter at a bound that it pushes against rests.
//!
//! # Standard errors
//!
//! What a model cannot do lasts for many rows. So the residuals are not taken as independent:
//!
//! Cov = (JᵀJ)⁻¹ S (JᵀJ)⁻¹ n/(n − N),  S = Σₖ Σₗ (1 − |k − l|/L)₊ gₖ gₗᵀ,  gₖ = Jₖᵀ rₖ
//!
//! with a window L of ten correlation times τ = 1 + 2Σρ of the residuals, at most a tenth of the n rows; or, if that is larger for a
//! parameter, τ σ² (JᵀJ)⁻¹ n/(n − N) with the mean square σ² of the residuals: where few rows tell a parameter, the sum is too small on the average. An error that is the
//! same in every period of the motion is not noise, and no window sees it: look at [`predict`].
//!
//! # What the data do not tell
//!
//! A direction of parameters whose singular value, with the columns of J scaled to length one, is below √ε of the largest has no
//! effect, and every parameter in it is [`Identifiability::Undetermined`]. A standard error above the value is
//! [`Identifiability::Uncertain`]. Both speak of the minimum that was found: in a local one a parameter can be called determined and be wrong.
//! To and fro at one speed, for instance, tells σ0 and one value of μ, but not μ_s, v_S and σ2.
//!
//! # Limits
//!
//! The velocity is held between two rows: where it changes much within one, or the force jumps, sample faster. Noise of the position
//! acts on the model as motion. The residuals are the differences of the force alone; a mechanism around the contact is not
//! simulated.
//!
//! Sources: J. J. Moré, "The Levenberg-Marquardt algorithm: implementation and theory", Lecture Notes in Mathematics 630 (1978);
//! H. B. Nielsen, "Damping parameter in Marquardt's method", report IMM-REP-1999-05, DTU (1999); W. K. Newey, K. D. West, "A simple,
//! positive semi-definite, heteroskedasticity and autocorrelation consistent covariance matrix", Econometrica 55 (1987), 703–708.

mod candidates;
mod error;
mod initial_guess;
mod least_squares;
mod log;
mod report;
mod residuals;
mod simulation;
mod static_curve;
mod triangle;
mod uncertainty;

pub use candidates::{ElastoPlasticFit, FrBdFit, MaxwellFit};
pub use error::IdentifyError;
pub use initial_guess::InitialGuess;
pub use least_squares::{Progress, Settings, least_squares};
pub use log::{Log, LogParameters, Motion};
pub use report::{Estimate, Fit, Identifiability, Outcome, ResidualStatistics, WeakDirection};
pub use residuals::{Candidate, Parameter, Residuals, Scaling};
pub use simulation::{Prediction, Simulation, fit, fit_from, predict};
pub use static_curve::{CurveCandidate, RationalCurve, SlidingPoint, StribeckCurve, static_curve};
