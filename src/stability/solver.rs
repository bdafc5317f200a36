//! The limit on the fixed steps of a [`Solver`].

use super::{Scheme, largest_step};
use crate::ode::{
    Automatic, DormandPrince, DormandPrince8, Method, Rodas4, Rodas5P, RungeKutta4, Solver,
};
use crate::parameter::ParameterError;
use crate::{Bristle, Contact, Mechanism, Scalar};

/// The scheme of an integrator.
macro_rules! scheme {
    ($($method:ident => $scheme:ident),*) => {
        $(impl From<&$method> for Scheme {
            fn from(_: &$method) -> Self {
                Self::$scheme
            }
        })*
    };
}

scheme!(
    RungeKutta4 => RungeKutta4,
    DormandPrince => DormandPrince,
    DormandPrince8 => DormandPrince8,
    Rodas4 => Rosenbrock,
    Rodas5P => Rosenbrock,
    // With fixed steps it stays with its Rosenbrock method.
    Automatic => Rosenbrock
);

impl<T: Scalar, M: Method<T, N>, const N: usize> Solver<T, M, N>
where
    for<'a> Scheme: From<&'a M>,
{
    /// Refuses a fixed step beyond what is stable for a contact that slides no faster than
    /// `fastest` [m/s] in a mechanism ([`largest_step`]). Adaptive steps are kept short enough by
    /// their error.
    ///
    /// ```
    /// use bristle::ode::{RungeKutta4, Solver};
    /// use bristle::{Bristle, FrBd, Mechanism, paper};
    /// use bristle::curve::Stribeck;
    /// use bristle::rheology::KelvinVoigt;
    ///
    /// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
    /// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
    /// let contact = FrBd::new(curve, bristle).under_load(1.0)?;
    /// let mechanism = Mechanism { mass: 1.0, spring_stiffness: 2.0, viscous_damping: 0.0 };
    /// let solver = |step| {
    ///     let solver = Solver::<f64, _, 3>::fixed(RungeKutta4, step)?;
    ///     solver.within_stability(&contact, mechanism, 1.0)
    /// };
    /// assert!(solver(5e-3).is_ok());
    /// let refused = solver(20e-3).unwrap_err().to_string();
    /// assert!(refused.starts_with(
    ///     "step is 0.02, but must be at most the bristle's critical step = 0.01824"
    /// ));
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Names the step and the limit it exceeds; passes on what is wrong with the mechanism, or with
    /// a model whose relaxation rate has no bound up to that velocity.
    pub fn within_stability<B: Bristle<T, Deflection = T>>(
        self,
        contact: &Contact<T, B>,
        mechanism: Mechanism<T>,
        fastest: T,
    ) -> Result<Self, ParameterError> {
        let limits = largest_step(contact, Some(mechanism), fastest, Scheme::from(self.method()))?;
        if let Some(step) = self.fixed_step() {
            limits.check(step)?;
        }
        Ok(self)
    }
}
