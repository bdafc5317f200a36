//! What a patch of one axis and one in combined slip have in common.

use nalgebra::SVector;

use bristle::parameter::{Checked, Named, ParameterError};
use bristle::{Bristle, Contact, LoadChange, Scalar};
use bristle_plane::PlaneBristle;

/// A slip velocity [m/s] or a force \[N\] of a patch: a number, or a vector of A axes.
pub trait OfAxes<T: Scalar, const A: usize>: Copy {
    /// From the number of each axis.
    fn of_axes(axes: [T; A]) -> Self;

    /// The number of each axis.
    fn axes(self) -> [T; A];

    /// Itself, if all its numbers are finite.
    ///
    /// # Errors
    ///
    /// Refuses one that is not, and names its axis where there are several.
    #[inline]
    fn finite(self, name: &'static str) -> Checked<Self> {
        for (axis, component) in self.axes().into_iter().enumerate() {
            let checked = Named(name, component).finite();
            if A > 1 { ParameterError::of_component(axis, checked) } else { checked }?;
        }
        Ok(self)
    }
}

impl<T: Scalar> OfAxes<T, 1> for T {
    #[inline(always)]
    fn of_axes([number]: [T; 1]) -> Self {
        number
    }

    #[inline(always)]
    fn axes(self) -> [T; 1] {
        [self]
    }
}

impl<T: Scalar, const A: usize> OfAxes<T, A> for SVector<T, A> {
    #[inline(always)]
    fn of_axes(axes: [T; A]) -> Self {
        axes.into()
    }

    #[inline(always)]
    fn axes(self) -> [T; A] {
        self.into()
    }
}

/// A model of the bristles of a patch in motion, at slip velocities V of A axes: every [`Bristle`]
/// of one spring, at a number, and every [`PlaneBristle`], at a vector.
pub trait PatchModel<T: Scalar, V, const A: usize>: Clone {
    /// The model of one axis at a slip velocity.
    type Axis: Bristle<T, Deflection = T>;

    /// A function of each axis's number, contact and slip velocity [m/s].
    fn each<R>(
        contact: &Contact<T, Self>,
        slip_velocity: V,
        of: impl FnMut(usize, &Contact<T, Self::Axis>, T) -> R,
    ) -> [R; A];

    /// Stiffness of the stored energy on each axis [1/m].
    fn stiffness_of_axes(&self) -> [T; A];

    /// The share of the deflections \[–\] that a load that falls leaves of bristles whose
    /// deflections \[m\] lie in these ranges.
    fn kept(
        contact: &Contact<T, Self>,
        change: LoadChange<T>,
        slip_velocity: V,
        ranges: [(T, T); A],
    ) -> T;
}

impl<T: Scalar, M: Bristle<T, Deflection = T>> PatchModel<T, T, 1> for M {
    type Axis = M;

    #[inline(always)]
    fn each<R>(
        contact: &Contact<T, M>,
        slip_velocity: T,
        mut of: impl FnMut(usize, &Contact<T, M>, T) -> R,
    ) -> [R; 1] {
        [of(0, contact, slip_velocity)]
    }

    fn stiffness_of_axes(&self) -> [T; 1] {
        [self.storage_stiffness()]
    }

    fn kept(
        contact: &Contact<T, M>,
        change: LoadChange<T>,
        slip_velocity: T,
        [(low, high)]: [(T, T); 1],
    ) -> T {
        let (model, surface) = (contact.model(), contact.surface(slip_velocity));
        let kept = |z: T| change.kept_by(model, surface, model.storage_stiffness() * z);
        kept(low).smaller(kept(high))
    }
}

impl<T: Scalar, M: PlaneBristle<T, A>, const A: usize> PatchModel<T, SVector<T, A>, A> for M {
    type Axis = M::Axis;

    #[inline(always)]
    fn each<R>(
        contact: &Contact<T, M>,
        slip_velocity: SVector<T, A>,
        mut of: impl FnMut(usize, &Contact<T, M::Axis>, T) -> R,
    ) -> [R; A] {
        let axes = contact.model().axes(&slip_velocity).map(|axis| contact.with_model(axis));
        core::array::from_fn(|i| of(i, &axes[i], slip_velocity[i]))
    }

    fn stiffness_of_axes(&self) -> [T; A] {
        self.storage_stiffness().into()
    }

    fn kept(
        contact: &Contact<T, M>,
        change: LoadChange<T>,
        slip_velocity: SVector<T, A>,
        ranges: [(T, T); A],
    ) -> T {
        // No bristle is deflected by more on any axis.
        let most = ranges.map(|(low, high)| (-low).larger(high)).into();
        let limits = contact.model().limits(slip_velocity.norm());
        change.kept(limits.utilisation(&most, contact.friction_scale()))
    }
}
