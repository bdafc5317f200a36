//! A spring beside a spring with a dashpot: the standard linear solid.

use super::{GeneralisedMaxwell, GeneralisedMaxwellParameters, MaxwellArm};
use crate::Scalar;
use crate::parameter::Checked;

/// Parameters of a Zener bristle, see [`GeneralisedMaxwell::zener`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct ZenerParameters<T> {
    /// Normalised stiffness K₀ [1/m] of the static spring, positive.
    pub static_stiffness: T,
    /// Normalised stiffness K₁ [1/m] of the spring behind the dashpot, positive.
    pub relaxing_stiffness: T,
    /// Normalised damping η [s/m] of the dashpot, positive.
    #[doc(alias = "eta")]
    pub series_damping: T,
}

impl<T: Scalar> GeneralisedMaxwell<T, 2> {
    /// A spring beside a spring with a dashpot: the standard linear solid, stiff (K₀ + K₁) when it
    /// is pulled fast, soft (K₀) when it has had time to relax, and lossy in between.
    ///
    /// ż = ẋ₀ = ẋ₁ + (K₁/η) x₁,  F/p = K₀ x₀ + K₁ x₁
    ///
    /// | symbol | meaning | unit |
    /// |---|---|---|
    /// | x₀ = z | stretch of the static spring: the deflection of the bristle | m |
    /// | x₁ | stretch of the spring behind the dashpot | m |
    /// | K₀, K₁ | normalised stiffness of either | 1/m |
    /// | η | normalised damping of the dashpot | s/m |
    ///
    /// The state is the vector (x₀, x₁). In steady sliding the second spring has relaxed, and the
    /// first carries the whole curve.
    ///
    /// ```
    /// use bristle::{Bristle, FrBd, paper};
    /// use bristle::curve::Stribeck;
    /// use bristle::rheology::{GeneralisedMaxwell, ZenerParameters};
    /// use bristle::nalgebra::Vector2;
    ///
    /// let bristle = GeneralisedMaxwell::zener(ZenerParameters {
    ///     static_stiffness: 1e4,
    ///     relaxing_stiffness: 2e4,
    ///     series_damping: 100.0,
    /// })?;
    /// let contact = FrBd::new(Stribeck::new(paper::STICK_SLIP_CURVE)?, bristle).under_load(10.0)?;
    ///
    /// // Pulled by 20 µm within 1 ms, then held: the force falls by the second spring's share.
    /// let pulled = contact.hold(0.02, Vector2::zeros(), 1e-3);
    /// let held = contact.hold(0.0, pulled.deflection, 1.0);
    /// assert!(held.end_force < 0.45 * pulled.end_force);
    /// let stored = |state| contact.stored_energy(state);
    /// assert!(stored(held.deflection) < stored(pulled.deflection));
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// In a mechanism of one's own the stretches are two of its states:
    ///
    /// ```
    /// use bristle::ode::{self, Output, System};
    /// use bristle::{Branch, Bristle, Contact, FrBd, paper};
    /// use bristle::curve::Stribeck;
    /// use bristle::rheology::{GeneralisedMaxwell, ZenerParameters};
    /// use bristle::nalgebra::Vector4;
    ///
    /// /// 1 kg pulled at 0.1 m/s by a spring of 2 N/m: position, velocity, two stretches.
    /// struct Pulled { contact: Contact<f64, FrBd<Stribeck<f64>, Zener>> }
    /// type Zener = GeneralisedMaxwell<f64, 2>;
    ///
    /// impl System<f64, 4> for Pulled {
    ///     fn rate(&self, time: f64, state: &Vector4<f64>, [branch]: [Branch; 1]) -> Vector4<f64> {
    ///         let stretches = state.fixed_rows::<2>(2).into_owned();
    ///         let friction = self.contact.response(branch.of(state[1]), stretches);
    ///         let pull = 2.0 * (0.1 * time - state[0]);
    ///         Vector4::new(state[1], pull - friction.force, friction.rate[0], friction.rate[1])
    ///     }
    ///     fn sliding_velocities(&self, _: f64, state: &Vector4<f64>) -> [f64; 1] {
    ///         [state[1]]
    ///     }
    ///     fn scales(&self) -> Vector4<f64> {
    ///         Vector4::new(0.1, 0.1, 1e-4, 1e-4)
    ///     }
    /// }
    ///
    /// let bristle = GeneralisedMaxwell::zener(ZenerParameters {
    ///     static_stiffness: 1e4,
    ///     relaxing_stiffness: 2e4,
    ///     series_damping: 100.0,
    /// })?;
    /// let contact = FrBd::new(Stribeck::new(paper::STICK_SLIP_CURVE)?, bristle).under_load(1.0)?;
    /// let (system, start) = (Pulled { contact }, Vector4::zeros());
    /// let run = ode::solve(&system, 0.0..7.0, start, 1e-6, Output::Uniform(8))?;
    /// // Stuck until the pull has grown to μ_s p = 1.5 N, at 7.5 s.
    /// let (_, state) = run.last().unwrap();
    /// assert!(state[0] < 1e-3 && (1e4 * state[2] - 1.4).abs() < 1e-2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range. Also refuses a decay rate K₁/η above
    /// 10⁵⁰ 1/s (for `f32` 10¹⁰ 1/s), which no step can tell from an instant.
    #[doc(alias = "standard linear solid")]
    pub fn zener(parameters: ZenerParameters<T>) -> Checked<Self> {
        let ZenerParameters { static_stiffness, relaxing_stiffness, series_damping } = parameters;
        let arms = [
            MaxwellArm { stiffness: static_stiffness, series_damping: None },
            MaxwellArm { stiffness: relaxing_stiffness, series_damping: Some(series_damping) },
        ];
        for (arm, stiffness) in arms.iter().zip(["static_stiffness", "relaxing_stiffness"]) {
            arm.check(stiffness, "series_damping")?;
        }
        Ok(Self(GeneralisedMaxwellParameters { arms, micro_damping: T::zero() }))
    }
}
