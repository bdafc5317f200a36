//! Small motions: a contact, or a mechanism with friction, as a linear system.
//!
//! **A contact** that slides at v\* with the deflection z\* responds to a small change ṽ of its
//! velocity by
//!
//! dz̃/dt = A z̃ + B ṽ,  F̃ = C z̃ + D ṽ
//!
//! | symbol | for one deflection | meaning | unit |
//! |---|---|---|---|
//! | A | −λ(v\*) | relaxation | 1/s |
//! | B = H1 | ∂ż/∂v | rate of the deflection by the velocity | – |
//! | C | p c₀(v\*) | stiffness | N/m |
//! | D = p H2 | p ∂μ_b/∂v | force that follows at once | N s/m |
//! | G(s) = C (sI − A)⁻¹ B + D | | transfer function from ṽ to F̃ | N s/m |
//!
//! [`state_space()`] and [`steady_state_space`] return it.
//!
//! H1 and H2 are the derivatives of Romano et al., section III-C; the last term of H1 as printed
//! there lacks the factor z\*, it is −σ0'(v) (|v|_ε/g) z. For FrBD with constant σ0, σ1 in steady
//! sliding (z\* = z_ss) they reduce to the slope of the friction curve,
//!
//! H1 = (|v|_ε/g) (μ sgn_ε)',  H2 = σ1 H1,  G(s) = p (|v|_ε/g) (μ sgn_ε)' (σ0 + σ1 s)/(s +
//! σ0|v|_ε/g):
//!
//! slow changes follow the friction curve, fast ones a fraction of its slope; the corner lies at λ.
//!
//! **A mass on a spring** whose far end moves steadily ([`steady_sliding()`]) slides steadily or
//! stick-slips. Both can occur at one speed, depending on the start; the linear analysis is about
//! small disturbances of steady sliding. They obey
//!
//! m s³ + (mλ + D) s² + (k + λ D + C B) s + λ k = 0,  D = d + ∂F/∂v.
//!
//! With λ D + C B = λ S, where S = d + dF_ss/dv is the slope of all steady forces, they die out if
//! and only if (Routh–Hurwitz)
//!
//! mλ + D > 0  and  (mλ + D) λ S + D k > 0.
//!
//! For FrBD with constant σ0, σ1 and d = 0, both D and S have the sign of (μ sgn_ε)', so that this
//! slope alone decides, whatever k and m. Damping beside the friction, or a LuGre model with
//! viscous friction, separates them: where S < 0 < D the spring must be stiffer than k_c = −(mλ +
//! D) λ S/D ([`critical_stiffness`]).
//!
//! Where friction does not depend on the speed both vanish, and small motions neither grow nor die
//! out ([`Threshold::Marginal`]). Because ∂ż/∂v loses its digits there as a difference, the slope
//! of steady sliding is taken from the curve itself
//! ([`Bristle::steady_linearised`](bristle::Bristle::steady_linearised)).
//!
//! **Any mechanism** that gives its derivatives: its Jacobian is the matrix A of a [`StateSpace`].
//!
//! Sources: Romano et al. (arXiv 2602.09429), section III-C; the Routh–Hurwitz conditions as in
//! F. R. Gantmacher, "The Theory of Matrices", volume 2 (Chelsea, 1959), chapter XV.

mod contact;
mod state_space;
mod steady_sliding;

pub use contact::{state_space, steady_state_space};
pub use state_space::StateSpace;
pub use steady_sliding::{
    SteadySliding, Threshold, critical_speed, critical_stiffness, steady_sliding,
};
