//! Rheologies written outside the library: springs and dashpots that depend on the velocity.

use std::fmt;
use std::sync::Arc;

use bristle::rheology::{ElementBounds, Elements, Rheology};
use bristle::{Bounds, Scalar, Sliding};
use nalgebra::SVector;

/// A stiffness or damping over the velocity, with its slope.
#[derive(Clone)]
pub struct VelocityLaw<T> {
    #[allow(clippy::type_complexity, reason = "a function behind a pointer")]
    function: Arc<dyn Fn(Sliding<T>) -> (T, T) + Send + Sync>,
    bounds: Bounds<T>,
    even: bool,
}

impl<T> fmt::Debug for VelocityLaw<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("VelocityLaw")
    }
}

impl<T: Scalar> VelocityLaw<T> {
    pub fn new(
        function: impl Fn(Sliding<T>) -> (T, T) + Send + Sync + 'static,
        bounds: Bounds<T>,
    ) -> Self {
        Self { function: Arc::new(function), bounds, even: false }
    }

    /// By the speed: the same in both directions.
    pub fn of_speed(
        function: impl Fn(T) -> (T, T) + Send + Sync + 'static,
        bounds: Bounds<T>,
    ) -> Self {
        let signed = move |sliding: Sliding<T>| {
            let (value, slope) = function(sliding.speed());
            (value, slope * sliding.direction())
        };
        Self { function: Arc::new(signed), bounds, even: true }
    }

    /// c (1 + a u/√(1 + u²)) with u = v/v_d: larger forward than backward.
    pub fn varying(constant: f64, variation: f64, velocity: f64) -> Self {
        let [c, a, v_d] = [constant, variation, velocity].map(super::lit::<T>);
        let function = move |sliding: Sliding<T>| {
            let u = sliding.velocity() / v_d;
            let root = (T::one() + u * u).sqrt();
            (c * (T::one() + a * u / root), c * a / (root * root * root * v_d))
        };
        Self::new(function, Bounds { min: c * (T::one() - a), max: c * (T::one() + a) })
    }
}

impl<T: Scalar> From<T> for VelocityLaw<T> {
    fn from(value: T) -> Self {
        Self::of_speed(move |_| (value, T::zero()), Bounds::constant(value))
    }
}

/// A spring beside a dashpot.
#[derive(Debug, Clone)]
pub struct OwnElement<T> {
    pub stiffness: VelocityLaw<T>,
    pub damping: VelocityLaw<T>,
}

pub fn own_element<T: Scalar>(
    stiffness: impl Into<VelocityLaw<T>>,
    damping: impl Into<VelocityLaw<T>>,
) -> OwnElement<T> {
    OwnElement { stiffness: stiffness.into(), damping: damping.into() }
}

impl<T: Scalar> Rheology<T> for OwnElement<T> {
    type Deflection = T;

    fn elements_and_slopes(&self, sliding: Sliding<T>) -> (Elements<T>, Elements<T>) {
        let [stiffness, damping] =
            [&self.stiffness, &self.damping].map(|law| (law.function)(sliding));
        let decay = T::zero();
        (
            Elements { stiffness: stiffness.0, decay, damping: damping.0 },
            Elements { stiffness: stiffness.1, decay, damping: damping.1 },
        )
    }

    fn storage_stiffness(&self) -> T {
        (self.stiffness.function)(T::zero().into()).0
    }

    fn bounds(&self) -> ElementBounds<T> {
        ElementBounds {
            stiffness: self.stiffness.bounds,
            decay: Bounds::constant(T::zero()),
            damping: self.damping.bounds,
            constant_decay: true,
            even: self.stiffness.even && self.damping.even,
        }
    }
}

/// Springs side by side, some behind a dashpot, and a dashpot beside them all.
#[derive(Debug, Clone)]
pub struct OwnArms<T, const N: usize> {
    pub arms: [(T, Option<VelocityLaw<T>>); N],
    pub damping: VelocityLaw<T>,
}

impl<T: Scalar, const N: usize> Rheology<T> for OwnArms<T, N> {
    type Deflection = SVector<T, N>;

    fn elements_and_slopes(
        &self,
        sliding: Sliding<T>,
    ) -> (Elements<T, SVector<T, N>>, Elements<T, SVector<T, N>>) {
        let decays = self.arms.each_ref().map(|(stiffness, law)| {
            law.as_ref().map_or((T::zero(), T::zero()), |law| {
                let (damping, slope) = (law.function)(sliding);
                let decay = *stiffness / damping;
                (decay, -decay * slope / damping)
            })
        });
        let (damping, slope) = (self.damping.function)(sliding);
        let [decay, by_velocity] = [0, 1]
            .map(|part| SVector::from_fn(|i, _| if part == 0 { decays[i].0 } else { decays[i].1 }));
        (
            Elements { stiffness: self.storage_stiffness(), decay, damping },
            Elements { stiffness: SVector::zeros(), decay: by_velocity, damping: slope },
        )
    }

    fn storage_stiffness(&self) -> SVector<T, N> {
        SVector::from_fn(|i, _| self.arms[i].0)
    }

    fn bounds(&self) -> ElementBounds<T> {
        let decay = self.arms.iter().map(|(stiffness, law)| {
            law.as_ref().map_or(Bounds::constant(T::zero()), |law| Bounds {
                min: *stiffness / law.bounds.max,
                max: *stiffness / law.bounds.min,
            })
        });
        let laws = || self.arms.iter().filter_map(|arm| arm.1.as_ref());
        ElementBounds {
            stiffness: Bounds::constant(self.storage_stiffness().sum()),
            decay: decay.reduce(Bounds::union).unwrap(),
            damping: self.damping.bounds,
            constant_decay: laws().all(|law| law.bounds.is_constant()),
            even: laws().all(|law| law.even) && self.damping.even,
        }
    }
}
