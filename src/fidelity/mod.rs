//! How much model a scene needs: the cheapest rung of a ladder of models, with integrator and step, that keeps the friction force (of a
//! mechanism also position or velocity) within a tolerance, and the evidence for it.
//!
//! [`History`] is for a velocity that is known, as in this table; [`RollingHistory`] for the known motion of a contact patch, and
//! [`MechanismHistory`] for a mass whose motion follows from the friction, both below.
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
//! # Contact patches
//!
//! [`RollingHistory`]: a patch along a known slip velocity v(t) and transport velocity V(t).
//!
//! | rung | what | weight of a step | of an answer |
//! |---|---|---|---|
//! | slip curve | F = F_ss(v, V), the steady force at the motion of the instant | – | 25 |
//! | relaxation length | Ḟ = −(V/ς)(F − F_ss), ς in lengths of the patch; exact for V held and F_ss straight over a step | 26 | – |
//! | patch | the exact reduction with the motion of the middle held | 45 | 15 |
//! | | the same of fourth order | 80 | 15 |
//! | | on a grid of N cells, under a pressure that the exact reduction does not take; held motion | 10 + 3.5 N | 15 |
//!
//! ς is the relaxation length of [`Patch::linearised`](crate::rolling::Patch::linearised), −V Im G/(ω Re G) for ω → 0, about the
//! mean of |v| and of V over the scene, which to first order in the frequency is the lag of the patch; where it is not between 0 and 1 (a falling
//! slip curve), about v = 0. Source of the form: H. B. Pacejka, "Tire and Vehicle Dynamics", the relaxation length of a
//! single-contact-point model; its length here is that of the patch alone, derived and not measured.
//!
//! A patch forgets everything after one transit. Where two answers are more than a transit apart a plan rolls through
//! the last transit before each answer only, and n is the number of steps in it (times some, by which the fourth order divides
//! a transit at least). The pilot looks at the first transit and one period of a motion that repeats itself, at all of another.
//!
//! The bound for the slip curve is that above along each bristle's way through the patch: with e = z − z\*,
//! z\* = z_ss (1 − e^(−κξ)), κ = λ/V,
//!
//! |e| ≤ ∫ e^−(Λ(t) − Λ(s)) |∂z\*/∂s| ds since it entered,  |F − F_ss| ≤ L c₀ ∫₀¹ p |e| dξ,
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | ξ, L, p | place in the patch, its length, pressure | –, m, N/m |
//! | V, v | transport velocity, slip velocity | 1/s, m/s |
//! | G, ω | frequency response from v to F, angular frequency | N s/m, rad/s |
//!
//! and holds as far as z_ss and κ are monotone from one instant to the next. The pilot's reference is the exact
//! reduction under any pressure (by quadrature over its profile where there are no moments), to second and fourth order; where
//! each answer stands alone only those are refined whose two values differ. What is counted are evaluations of the
//! friction model: the tables of weights do not enter the pilot's account, and a grid's step counts as one.
//!
//! # Mechanisms
//!
//! In a [`MechanismHistory`] the force acts back on the velocity, and what is wanted may be a position or a velocity:
//!
//! | rung | what | weight of a step |
//! |---|---|---|
//! | static curve | true rest: the mass stops where a force up to p μ_s can stop it; implicit, in closed form | 2.4, and 1.5 while it slides |
//! | Dahl | a bristle under the coefficient at rest; passive steps ([`Contact::companion`](crate::Contact::companion)) | 3.1 |
//! | reference | any model of one deflection; passive steps | 3.5 |
//! | | the same under error control ([`Solver::automatic`](crate::ode::Solver::automatic)) | 4.7 an evaluation, 9.6 a Jacobian |
//!
//! A lumped FrBD below another model of one deflection would cost as much as that.
//!
//! *A bound*, where a passive contact starts at rest and the applied force g = f + k (y − x₀) never exceeds p μ_s, so that the
//! static curve does not move: with E = ½ m v² + ½ k (x − x₀)² + W, d√(2E)/dt ≤ |g|/√m, so that
//!
//! |v| ≤ G/√m,  |x − x₀| ≤ min(∫G dt/√m, G/√k),  G(t) = ∫₀ᵗ |g| ds/√m,
//!
//! as far as g is monotone between an answer and the middle to the next. A reference that holds more energy than ½ (√(2E₀) + G)²
//! is refused: its friction drives it ([`FidelityError::GainsEnergy`]).
//!
//! *A pilot* else, over all of the scene or three of its periods: the reference under error control, and a second opinion. That is the
//! static curve, or passive steps, within 25 % of the tolerance of it; or error control at five digits or more, within 30 % of looser one.
//! Then the rungs with fixed steps are compared with it. What a difference grows by from period to period is followed to the end with half as much again;
//! where velocity and deflection do not yet repeat themselves all of the scene is looked at, or a quarter of the tolerance has to do.
//! If error control sees a part only, passive steps of three lengths (or two, and the static curve) may stand for it, if they converge over
//! all of the window and agree with it on its part ([`Verdict::Extrapolated`]). If not even that is within its means, the reference under
//! tightened error control is the answer ([`Verdict::Estimated`]): often far dearer than need be, and refused
//! ([`FidelityError::PilotTooShort`]) where a spring can lead the mass along unstable sliding.
//!
//! *Conditioning.* Steady sliding on the falling part of the curve is an unstable equilibrium: errors grow there by e^σt, σ the abscissa of
//! [`Contact::critical_speed`](crate::Contact::critical_speed). A mass that comes there quietly waits until its errors are as large as its
//! motion. Along the run of the reference the factor
//!
//! e^S p μ_s/(m σ |v|),  S = ∫ σ dt while the velocity stays nearly as it is,
//!
//! tells how many digits error control needs; if roundings grow to a tenth of the tolerance, no run in this arithmetic knows
//! when the mass slips, and the scene is refused ([`FidelityError::Undetermined`]). An example: 16 g on 99 N/m, pulled at 0.75 mm/s over the curve
//! of the paper's stick-slip rig, σ = 8.7/s. With 30 or 40 digits it slips after 24.37 s; two good integrators put the slip up to half a second away
//! at a tolerance of 10⁻¹⁰, each tolerance elsewhere.
//!
//! # Limits
//!
//! Error control takes no step longer than an eighth of a period, a sixteenth of a scene without.
//! Limit cycles that nobody announced by a period are not looked for.
//!
//! A pilot may look at each n-th answer of a window only. The velocity (of a patch: both) it looks at at all of them, and it looks
//! closer if a period has less than 24 of its instants, or if from one of them to the next a velocity
//!
//! - leaves the range of both ends by more than 5 % of the largest speed,
//! - is more than twice as fast as the faster end or, in one direction, less than half as fast as the slower one, by more than 0.5 %
//!   of the largest speed,
//! - or reverses and the ends do not tell.
//!
//! Where it has no means for that, the scene is refused ([`FidelityError::PilotTooShort`]): 2000 evaluations do for a period of
//! some 380 answers that cannot be divided, as a prime. What a velocity does between two answers and at none of them is not noticed.
//!
//! A velocity that jumps exactly at an answer or in the middle of a step, which roundings leave to either side, and two models that
//! drift apart more slowly than two periods tell: both can hide more than a tolerance. Of 26 317 scenes with corners, jumps and curves
//! of any steepness, drawn by chance in order to find such, 73 were answered with an error beyond the tolerance, half of them by less
//! than two thirds of it; all seven that erred by ten times as much or more had jumps.
//!
//! Of 120 scenes drawn by chance (a base that moves, periodic forces of 10 mHz to 1 kHz, with and without a spring) after the last threshold was
//! set, none was answered wrongly, 16 were refused (one of them because nobody can know it), and 39 plans cost more than twice the cheapest that would
//! have done: of mechanisms little more than half are answered cheaply, where of known velocities and motions of patches it is nine in ten.
//! What decides is what the pilot sees: the reference over three periods may take more than its 2000 evaluations, whatever
//! the cheapest plan takes.
//!
//! Source: the bound follows from the linear equation of Romano et al. (arXiv 2602.09429), section III-A, by
//! variation of constants; the ladder is of this crate.

mod between;
mod history;
mod ladder;
mod look;
mod mechanism;
mod panel;
mod pilot;
mod reducible;
mod report;
mod rolling;
mod walk;
mod weight;

pub use history::{History, HistoryParameters, Start};
pub use mechanism::{Carried, MechanismHistory, MechanismHistoryParameters};
pub use reducible::Reducible;
pub use report::{
    Choice, Evidence, FidelityError, Integrator, Norm, Plan, Quantity, Rung, Tolerance, Trial,
    Verdict,
};
pub use rolling::{RollingHistory, RollingHistoryParameters};

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
