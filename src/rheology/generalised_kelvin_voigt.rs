//! Springs in a row, each with a dashpot beside it; the first may be a spring alone.
//!
//! F/p = Kⱼ eⱼ + ηⱼ ėⱼ for every j,  z = Σ eⱼ
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | eⱼ | elongation of element j | m |
//! | z | deflection of the bristle | m |
//! | Kⱼ, ηⱼ | normalised stiffness and damping of element j | 1/m, s/m |
//!
//! Under a steady force element j yields with its retardation time ηⱼ/Kⱼ. The bristle is equivalent
//! to a [`GeneralisedMaxwell`] bristle with as many springs, which is computed when the bristle is
//! built; its state is the stretches x of those springs. From the creep compliance
//! J(s) = Σ 1/(Kⱼ + s ηⱼ) follow:
//!
//! - a static spring K = 1/Σ(1/Kⱼ);
//! - a spring behind a dashpot for each root of J(−aᵢ) = 0, one between each two retardation rates,
//!   and one above them if there is a spring alone; its stiffness is −1/(aᵢ J'(−aᵢ));
//! - without a spring alone, a dashpot beside them, d = 1/Σ(1/ηⱼ).
//!
//! State and elongations determine each other: eⱼ = Σ Kᵢ xᵢ/(Kⱼ − aᵢηⱼ).
//!
//! # Energy
//!
//! The stored energy W = ½ p Σ Kᵢ xᵢ² equals that of the springs of the row, ½ p Σ Kⱼ eⱼ², in every
//! state. Proof: written with √K x and √K e, both bristles are symmetric realisations of the same
//! relaxation, ẏ = A y + B ż, F/p = Bᵀy + d ż with A = Aᵀ. Both are minimal. Hence a linear map
//! takes one y to the other, and so does its inverse transpose: the map is orthogonal and preserves
//! |y|². The bristle is therefore passive with the identity of [`Rheology`].
//!
//! Source: as for [`GeneralisedMaxwell`]; the symmetric realisations of relaxation systems after
//! J. C. Willems, "Dissipative dynamical systems, part II", Archive for Rational Mechanics and
//! Analysis 45 (1972), 352–393.

use nalgebra::{SMatrix, SVector};

use super::modes::{Pole, root};
use super::{ElementBounds, Elements, GeneralisedMaxwell, KelvinVoigtParameters, MaxwellArm};
use crate::parameter::{Named, ParameterError};
use crate::rheology::Rheology;
use crate::scalar::is_zero;
use crate::{Scalar, Sliding};

/// Springs in a row, each with a dashpot beside it; the first may be a spring alone.
///
/// ```
/// use bristle::rheology::{GeneralisedKelvinVoigt, KelvinVoigtParameters, Rheology};
///
/// // Compliance 1/20 000 m per unit F/p at once, and the same again with a retardation time of
/// // 10 ms.
/// let bristle = GeneralisedKelvinVoigt::new([
///     KelvinVoigtParameters { micro_stiffness: 2e4, micro_damping: 0.0 },
///     KelvinVoigtParameters { micro_stiffness: 2e4, micro_damping: 200.0 },
/// ])?;
/// // That is a Zener bristle of 10 000/m and 10 000/m.
/// assert!((bristle.storage_stiffness() - nalgebra::Vector2::repeat(1e4)).amax() < 1e-9);
/// assert!((bristle.complex_modulus(0.0_f64).re - 1e4).abs() < 1e-9);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeneralisedKelvinVoigt<T: Scalar, const N: usize> {
    /// As they were given.
    given: [KelvinVoigtParameters<T, T>; N],
    maxwell: GeneralisedMaxwell<T, N>,
    /// 1/(Kⱼ − aᵢηⱼ) in row j, column i.
    compliance: SMatrix<T, N, N>,
}

impl<T: Scalar, const N: usize> GeneralisedKelvinVoigt<T, N> {
    /// Checks the elements, at least one, with increasing retardation times ηⱼ/Kⱼ, and finds the
    /// equivalent springs side by side. (Two with equal times are one element: their compliances
    /// add up.)
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range, and the element; refuses a bristle without
    /// elements, retardation times that do not increase, and elements so unlike each other that an
    /// equivalent spring or dashpot would be out of its range.
    pub fn new(elements: [KelvinVoigtParameters<T, T>; N]) -> Result<Self, ParameterError> {
        let given = elements;
        let elements = elements.map(|element| (element.micro_stiffness, element.micro_damping));
        let (zero, one) = (T::zero(), T::one());
        Named("elements", N).count(1)?;
        check(&elements)?;
        let springs = elements.iter().take_while(|element| is_zero(element.1)).count();
        // Retardation rates pⱼ, increasing, of the elements with a dashpot, from the last to the
        // first.
        let damped = N - springs;
        // 1/K = Σ (1/η)/(a − p) with the spring alone, 0 = Σ … without: scaled to rates up to one.
        let mut poles = [Pole { rate: zero, weight: zero }; N];
        let from_last = elements.iter().rev().take(damped);
        for (pole, &(stiffness, damping)) in poles.iter_mut().zip(from_last) {
            *pole = Pole { rate: stiffness / damping, weight: one / damping };
        }
        let instant = elements.first().filter(|_| springs > 0).map(|element| element.0);
        let most = |of: fn(&Pole<T>) -> T| poles.iter().fold(zero, |most, p| most.larger(of(p)));
        let unit = most(|pole| pole.rate);
        let (scale, constant) = match instant {
            Some(stiffness) => (stiffness / unit, one),
            None => (one / most(|pole| pole.weight), zero),
        };
        let scaled = poles.map(|pole| Pole { rate: pole.rate / unit, weight: pole.weight * scale });

        let compliances = elements.iter().fold(zero, |sum, element| sum + one / element.0);
        let mut arms = [MaxwellArm { stiffness: one / compliances, series_damping: None }; N];
        let mut compliance = SMatrix::<T, N, N>::zeros();
        // Element by element, in one column for each arm.
        let mut columns = compliance.column_iter_mut();
        if let Some(mut column) = columns.next() {
            for (compliance, element) in column.iter_mut().zip(&elements) {
                *compliance = one / element.0;
            }
        }
        // One root for each arm but the static one.
        let relaxing = arms.iter_mut().skip(1).zip(columns);
        for (index, (arm, mut column)) in relaxing.enumerate() {
            let root = root(scaled.get(..damped).unwrap_or_default(), constant, index);
            let decay = root.value() * unit;
            let mut slope = zero;
            if let (Some(stiffness), Some(first)) = (instant, column.iter_mut().next()) {
                *first = one / stiffness;
            }
            let of_poles = scaled.iter().zip(&poles).zip(column.iter_mut().rev());
            for ((scaled, pole), compliance) in of_poles.take(damped) {
                let gap = root.above(scaled.rate) * unit;
                // Kⱼ − aᵢηⱼ = ηⱼ (pⱼ − aᵢ).
                let softness = pole.weight / gap;
                slope += softness / gap;
                *compliance = -softness;
            }
            let checked = |name, value| {
                ParameterError::of_component(index + 1, Named(name, value).positive())
            };
            arm.stiffness = checked("equivalent stiffness", one / (decay * slope))?;
            arm.series_damping = Some(checked("equivalent damping", arm.stiffness / decay)?);
            ParameterError::of_component(index + 1, arm.check_decay())?;
        }
        let damping = if instant.is_some() {
            zero
        } else {
            one / elements.iter().fold(zero, |sum, element| sum + one / element.1)
        };
        let maxwell = GeneralisedMaxwell::from_parts(arms, damping);
        Ok(Self { given, maxwell, compliance })
    }

    /// The elements, as they were given.
    pub fn elements(&self) -> &[KelvinVoigtParameters<T, T>; N] {
        &self.given
    }

    /// The equivalent bristle of springs side by side, the static one first.
    pub fn equivalent(&self) -> &GeneralisedMaxwell<T, N> {
        &self.maxwell
    }

    /// The elongations eⱼ \[m\] of the elements, from the state.
    pub fn elongations(&self, state: SVector<T, N>) -> SVector<T, N> {
        self.compliance * self.maxwell.storage_stiffness().component_mul(&state)
    }
}

impl<T: Scalar, const N: usize> Rheology<T> for GeneralisedKelvinVoigt<T, N> {
    type Deflection = SVector<T, N>;

    #[inline(always)]
    fn elements_and_slopes(
        &self,
        sliding: Sliding<T>,
    ) -> (Elements<T, SVector<T, N>>, Elements<T, SVector<T, N>>) {
        self.maxwell.elements_and_slopes(sliding)
    }

    #[inline]
    fn storage_stiffness(&self) -> SVector<T, N> {
        self.maxwell.storage_stiffness()
    }

    fn bounds(&self) -> ElementBounds<T> {
        self.maxwell.bounds()
    }
}

/// Checks the elements: their retardation times increase.
fn check<T: Scalar>(elements: &[(T, T)]) -> Result<(), ParameterError> {
    let mut last = None;
    for (j, &(stiffness, damping)) in elements.iter().enumerate() {
        ParameterError::of_component(j, Named("micro_stiffness", stiffness).positive())?;
        ParameterError::of_component(j, Named("micro_damping", damping).non_negative())?;
        // Behind the first element it must be positive, too: the times increase.
        let time = damping / stiffness;
        if let Some(last) = last {
            let name = "retardation time";
            ParameterError::of_component(j, Named(name, time).increasing(last))?;
        }
        last = Some(time);
    }
    Ok(())
}
