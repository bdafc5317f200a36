//! How much model a scene needs: the cheapest rung of a ladder of models, with integrator and step, that keeps
//! the friction force within a tolerance, and the evidence for it.
//!
//! | rung | what | weight of a step | of an answer |
//! |---|---|---|---|
//! | static curve | F = p μ(v) sgn v, no memory | – | 1 |
//! | Dahl | one deflection under a constant coefficient, the mean of μ over the scene | 0.7 | – |
//! | FrBD | one spring, one dashpot, the friction curve; held velocity | 1.7 | 0.8 |
//! | | the same by collocation with three nodes | 9 | 0.8 |
//! | reference | a bristle of several springs; held velocity | 43 | 0.8 |
//! | | the implicit bristle; held velocity | 24 | 5 |
//!
//! Weights are times over that of one right-hand side of FrBD, as measured. A plan answers at equal intervals Δ,
//! with n = 1, 2, 4 … steps from one answer to the next. If the model of a scene has one spring and one dashpot,
//! FrBD is the reference; below the [implicit bristle](crate::ImplicitBristle) it has the same spring and dashpot. Else
//! FrBD is the bristle of one spring and one dashpot with the same complex modulus at the frequency ω of the scene (its root-mean-square acceleration over its root-mean-square velocity):
//! σ0 = G'(ω), σ1 = G''(ω)/ω.
//!
//! # Evidence
//!
//! *A bound* for the static curve, where FrBD is the reference. With e = z − z_ss, ė = −λ e − ż_ss, so
//!
//! |e(t)| ≤ |e₀| e^−Λ(t) + ∫₀ᵗ e^−(Λ(t) − Λ(s)) |ż_ss(s)| ds,  |F − F_ss| = p c₀ |e|,
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | z, z_ss | deflection, and the stationary one at the velocity of the instant | m |
//! | λ, Λ = ∫λ dt | relaxation rate, relaxation | 1/s, – |
//! | F, F_ss | friction force, and that of the static curve | N |
//! | p, c₀ | normal force, stiffness of [`Affine`](crate::Affine) | N, 1/m |
//!
//! evaluated along the scene with the smaller λ of both ends of an interval (none, where v reverses) and all of
//! the change of z_ss at its end. It costs the curve at each instant, and holds as far as v is monotone from one
//! instant to the next.
//!
//! *A pilot* where the bound does not decide: all rungs beside the reference, over two periods of a scene that repeats itself
//! (one, and the beginning of the next, if Λ of a period says that it forgets), else over all of it. For FrBD each look
//! at the friction curve is kept. The equation is linear in z, so from one answer to the next any method is a map
//! z ↦ a z + b: the reference by parabolas in s = ∫λ dt through three looks, of fourth order, with intervals split at
//! reversals and at kinks of the velocity and halved where their part of the error is largest; held steps
//! by the same looks; and a Dahl bristle, which feels only the way slid, without any. New looks are
//! made for a plan in those intervals alone where it is not clear from longer steps that they hardly matter. A difference that grows from period to
//! period is followed to the end of the scene. A measured error, with that of the reference added, must stay below 85 % of the
//! tolerance, or 97 % where every answer of the scene was looked at.
//!
//! The pilot costs at most 2000 evaluations of the friction model, or a twentieth of a full run of the reference
//! if that is more. What cannot be decided within that is refused
//! ([`FidelityError::PilotTooShort`]), not guessed: a stiff scene of more than some 760 different answers, or a bristle of
//! several springs along many.
//!
//! # Limits
//!
//! Forces along given velocities only. In a mechanism the error of the force acts back on the velocity.
//! A velocity that does much between two answers, unseen at all of them, is not noticed.
//!
//! Source: the bound follows from the linear equation of Romano et al. (arXiv 2602.09429), section III-A, by
//! variation of constants; the ladder is of this crate.

mod history;
mod ladder;
mod panel;
mod pilot;
mod reducible;
mod report;
mod weight;

pub use history::{History, HistoryParameters, Start};
pub use reducible::Reducible;
pub use report::{
    Choice, Evidence, FidelityError, Integrator, Norm, Plan, Rung, Tolerance, Trial, Verdict,
};

/// The largest of some numbers, or their root mean square; what is no number stays.
fn norm_of(norm: Norm, numbers: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = numbers.len().max(1) as f64;
    match norm {
        Norm::Greatest => {
            numbers.map(size).fold(0.0, |most: f64, e| if e <= most { most } else { e })
        }
        Norm::RootMeanSquare => {
            let sum: f64 = numbers.map(|e| e * e).sum();
            nalgebra::ComplexField::sqrt(sum / count)
        }
    }
}

/// |x|.
fn size(x: f64) -> f64 {
    nalgebra::ComplexField::abs(x)
}

fn exp(x: f64) -> f64 {
    nalgebra::ComplexField::exp(x)
}

fn exp_m1(x: f64) -> f64 {
    nalgebra::ComplexField::exp_m1(x)
}
