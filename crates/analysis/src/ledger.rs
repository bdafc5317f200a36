//! Where the energy of friction goes: supplied, stored, dissipated.
//!
//! ∫F v dt = ΔW + ∫D dt,  W = ½ p K z²,  D = F v − Ẇ
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | ∫F v dt | work of the mechanism on the contact: supplied | J |
//! | ΔW | change of the energy of the bristles: stored | J |
//! | ∫D dt | dissipated | J |
//!
//! The three sums are independent: the work from force and velocity, the stored energy from the
//! deflections at the ends, the dissipated energy from D of the model. The residual of their
//! balance ([`EnergyBalance::residual`]) is the error of the run: about the tolerance for an
//! integrator. For exact and passive steps ([`Contact::hold`],
//! [`Companion`](bristle::companion::Companion)) it is the rounding of the terms of each step. With
//! LuGre these can be much larger than their sum.
//!
//! A passive contact never returns more than it had stored: supplied − stored never falls. How far
//! it has fallen below its highest value is [`EnergyLedger::gain`]. Over a closed cycle nothing is
//! stored ([`EnergyLedger::close_cycle`]); a contact that supplies work there is an engine, which
//! classical LuGre can be.
//!
//! Sources: Romano et al. (arXiv 2602.09429), section III-B, for the balance; Gauss–Legendre
//! quadrature as in M. Abramowitz, I. A. Stegun, "Handbook of Mathematical Functions" (1964), table
//! 25.4.

use bristle::companion::CompletedStep;
use bristle::ode::Step;
use bristle::rheology::{Deflection, HeldWeights};
use bristle::scalar::lit;
use bristle::{Bristle, Contact, HeldContact, Reloaded, Scalar};
use nalgebra::SVector;

/// Energy over a stretch of time \[J\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyBalance<T> {
    /// Work of the mechanism on the contact, ∫F v dt.
    pub supplied: T,
    /// Change of the energy stored in the bristles, ΔW.
    pub stored: T,
    /// Dissipated energy, ∫(F v − Ẇ) dt.
    pub dissipated: T,
}

impl<T: Scalar> EnergyBalance<T> {
    /// supplied − stored − dissipated \[J\]: the error of the run.
    pub fn residual(&self) -> T {
        self.supplied - self.stored - self.dissipated
    }
}

impl<T: Scalar, D, F> From<CompletedStep<T, D, F>> for EnergyBalance<T> {
    fn from(step: CompletedStep<T, D, F>) -> Self {
        Self { supplied: step.work, stored: step.stored, dissipated: step.dissipated }
    }
}

/// The energy that left with a change of the load was stored before.
impl<T: Scalar, D> From<Reloaded<T, D>> for EnergyBalance<T> {
    fn from(reloaded: Reloaded<T, D>) -> Self {
        let Reloaded { dissipated, .. } = reloaded;
        Self { supplied: T::zero(), stored: -dissipated, dissipated }
    }
}

/// A compensated sum (Neumaier).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sum<T> {
    value: T,
    rest: T,
}

impl<T: Scalar> Sum<T> {
    fn add(&mut self, term: T) {
        let sum = self.value + term;
        self.rest += if self.value.abs() >= term.abs() {
            (self.value - sum) + term
        } else {
            (term - sum) + self.value
        };
        self.value = sum;
    }
}

/// The three sums of a balance: supplied, stored, dissipated.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Account<T>([Sum<T>; 3]);

impl<T: Scalar> Account<T> {
    fn empty() -> Self {
        Self([Sum { value: T::zero(), rest: T::zero() }; 3])
    }

    fn add(&mut self, balance: EnergyBalance<T>) {
        let terms = [balance.supplied, balance.stored, balance.dissipated];
        self.0.iter_mut().zip(terms).for_each(|(sum, term)| sum.add(term));
    }

    fn balance(&self) -> EnergyBalance<T> {
        let [supplied, stored, dissipated] = self.0.map(|sum| sum.value + sum.rest);
        EnergyBalance { supplied, stored, dissipated }
    }
}

/// The energy of one contact over a run, by any kind of step.
///
/// Classical LuGre with the parameters of Table 2 supplies work in each of these cycles: 1.5 mm at
/// 1 mm/s, then 0.1 mm at 10 m/s.
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
/// use bristle::{Bristle, LuGre, paper};
/// use bristle_analysis::ledger::EnergyLedger;
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
/// let contact = LuGre::classical(curve, bristle).under_load(1.0)?;
/// let (mut z, mut ledger) = (0.0, EnergyLedger::new());
/// for _ in 0..100 {
///     ledger.close_cycle();
///     z = ledger.hold(&contact, 1e-3, z, 1.5).deflection;
///     z = ledger.hold(&contact, 10.0, z, 1e-5).deflection;
/// }
/// let cycle = ledger.cycle();
/// assert!((cycle.supplied + 0.0178134).abs() < 1e-7); // J: the contact pushes
/// assert!(cycle.stored.abs() < 1e-12);
/// assert!(!ledger.is_passive(1e-9));
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyLedger<T> {
    total: Account<T>,
    cycle: Account<T>,
    /// The highest value of supplied − stored so far.
    highest: T,
    gain: T,
}

impl<T: Scalar> Default for EnergyLedger<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Scalar> EnergyLedger<T> {
    /// An empty ledger.
    pub fn new() -> Self {
        let (empty, zero) = (Account::empty(), T::zero());
        Self { total: empty, cycle: empty, highest: zero, gain: zero }
    }

    /// Enters the energies of one step, such as a [`CompletedStep`].
    ///
    /// The work that turns the bristles of a plane contact, which is all stored, is entered as
    /// `EnergyBalance { supplied, stored: supplied, dissipated: 0 }`.
    pub fn enter(&mut self, step: impl Into<EnergyBalance<T>>) {
        let step = step.into();
        self.total.add(step);
        self.cycle.add(step);
        let total = self.total.balance();
        let net = total.supplied - total.stored;
        // NaN stays in the gain.
        let fall = self.highest - net;
        self.gain = if fall <= self.gain { self.gain } else { fall };
        self.highest = self.highest.larger(net);
    }

    /// Takes an exact step of a contact at a held velocity ([`Contact::hold`]) and enters it.
    pub fn hold<M: Bristle<T>>(
        &mut self,
        contact: &Contact<T, M>,
        velocity: T,
        deflection: M::Deflection,
        duration: T,
    ) -> HeldContact<T, M::Deflection> {
        let hold = contact.hold(velocity, deflection, duration);
        let affine = contact.affine(velocity, deflection);
        let (weights, drive) = (affine.weights(duration), affine.drive * velocity);
        let mean = weights.mean(deflection, drive);
        let change = weights.end(deflection, drive) - deflection;
        let stiffness = contact.model().storage_stiffness();
        let path = duration * velocity;
        // Σ K x·(Λx) integrated over the step, + (c₀ − K r) h z̄ v + c₂ h v²
        let dissipated = weights.relaxed_energy(stiffness, deflection, drive)
            + (affine.stiffness - stiffness.scaled_by(affine.drive)).inner_product(mean) * path
            + affine.damping * path * velocity;
        let half = stiffness * (lit::<T>(0.5) * contact.reference_load());
        self.enter(EnergyBalance {
            supplied: duration * hold.mean_force * velocity,
            stored: half.scaled_by(change).inner_product(hold.deflection + deflection),
            dissipated: contact.reference_load() * dissipated,
        });
        hold
    }

    /// Enters a step of an integration, by quadrature at five points of its dense output.
    ///
    /// `motion` returns the sliding velocity [m/s] and the deflection \[m\] of the contact, of one
    /// spring or several, at a time and state. An observer of a run enters all of its steps, see
    /// [`Solver::stream`](bristle::ode::Solver::stream):
    ///
    /// ```
    /// use bristle::curve::Stribeck;
    /// use bristle::ode::{DormandPrince, Solver, Step, Tolerances};
    /// use bristle::rheology::KelvinVoigt;
    /// use bristle::scene::MassSpringDamper;
    /// use bristle::{Bristle, FrBd, paper};
    /// use bristle_analysis::ledger::EnergyLedger;
    /// use core::ops::ControlFlow;
    ///
    /// let friction = FrBd::new(
    ///     Stribeck::new(paper::STICK_SLIP_CURVE)?,
    ///     KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?,
    /// );
    /// let contact = friction.under_load(1.0)?;
    /// let rig = MassSpringDamper::new(paper::stick_slip_rig(contact))?;
    /// let solver = Solver::checked(DormandPrince, Tolerances::scaled(1e-8, rig.scales())?);
    /// let mut ledger = EnergyLedger::new();
    /// let mut meter = |step: &Step<f64, 3>| {
    ///     ledger.integrate(&contact, step, |_, state| (state[1], state[2]));
    ///     ControlFlow::Continue(())
    /// };
    /// solver.stream(&rig, 0.0..60.0, rig.at_rest(), &[], &mut meter)?;
    /// let energy = ledger.total();
    /// assert!(energy.supplied > 5.0 && energy.residual().abs() < 1e-6);
    /// assert!(ledger.is_passive(1e-6));
    /// # Ok::<(), bristle::Error>(())
    /// ```
    pub fn integrate<M: Bristle<T>, const N: usize>(
        &mut self,
        contact: &Contact<T, M>,
        step: &Step<T, N>,
        motion: impl Fn(T, &SVector<T, N>) -> (T, M::Deflection),
    ) {
        let duration = step.end_time() - step.start_time();
        let (mut supplied, mut dissipated) = (T::zero(), T::zero());
        for (node, weight) in NODES {
            let fraction = lit::<T>(node);
            let time = step.start_time() + duration * fraction;
            let (velocity, deflection) = motion(time, &step.at_fraction(fraction));
            let weight = duration * lit(weight);
            supplied += weight * contact.force(velocity, deflection) * velocity;
            dissipated += weight * contact.dissipated_power(velocity, deflection);
        }
        let (_, before) = motion(step.start_time(), step.start());
        let (_, after) = motion(step.end_time(), step.end());
        // Σ ½ K (z₁ − z₀)(z₁ + z₀)
        let half = lit::<T>(0.5) * contact.reference_load();
        let (rise, sum) = (after - before, after + before);
        let stored = half * contact.model().storage_stiffness().scaled_by(rise).inner_product(sum);
        self.enter(EnergyBalance { supplied, stored, dissipated });
    }

    /// The energies since the beginning.
    pub fn total(&self) -> EnergyBalance<T> {
        self.total.balance()
    }

    /// The energies since the last cycle was closed.
    pub fn cycle(&self) -> EnergyBalance<T> {
        self.cycle.balance()
    }

    /// Ends a cycle, begins the next one, and returns the energies of the cycle that ends.
    pub fn close_cycle(&mut self) -> EnergyBalance<T> {
        let balance = self.cycle.balance();
        self.cycle = Account::empty();
        balance
    }

    /// How far supplied − stored \[J\] has fallen below its highest value so far: the energy that
    /// the contact has returned beyond what it had. Zero for a passive contact, up to the error of
    /// the run.
    pub fn gain(&self) -> T {
        self.gain
    }

    /// Whether the contact was passive in this run: its gain is within a tolerance \[J\].
    pub fn is_passive(&self, tolerance: T) -> bool {
        self.gain <= tolerance
    }
}

/// Nodes and weights of the Gauss–Legendre rule of five points on [0, 1].
const NODES: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_24),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_55, 0.239_314_335_249_683_24),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];
