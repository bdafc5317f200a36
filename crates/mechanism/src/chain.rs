//! Blocks in a row: masses, springs and dampers to the neighbours and to ground or a driver.
//!
//! mᵢ v̇ᵢ = fᵢ − kᵢ xᵢ − cᵢ vᵢ + κᵢ (xᵢ₊₁ − xᵢ) + γᵢ (vᵢ₊₁ − vᵢ) − (the same of i − 1) − friction
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | mᵢ | mass of a block | kg |
//! | kᵢ, cᵢ | spring and damper to the ground, or to a driver | N/m, N s/m |
//! | κᵢ, γᵢ | spring and damper to the next block | N/m, N s/m |
//!
//! A driver at y(t) is the force k y + c ẏ on the block. Inertias, angles and torques serve as
//! well: motor and link of an elastic joint are two blocks, with friction on either side; with
//! backlash they are an [`ElasticJoint`](crate::ElasticJoint).
//!
//! Source: R. Burridge, L. Knopoff, "Model and theoretical seismicity", Bull. Seismol. Soc. Am. 57
//! (1967), for the chain of blocks on a driver.

use crate::mechanism::{Entries, LinearMechanism, Storage, Structure, Which};
use crate::rows::Rows;
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::{Mechanism, Scalar};

/// A spring beside a damper, between two blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling<T> {
    /// Stiffness κ [N/m], zero or positive.
    pub stiffness: T,
    /// Damping γ [N s/m], zero or positive.
    pub damping: T,
}

/// A block of a chain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block<T> {
    /// Its mass, and its spring and damper to the ground or to a driver.
    pub to_ground: Mechanism<T>,
    /// Its spring and damper to the next block; none for the last one.
    pub to_next: Coupling<T>,
}

/// The row of a contact between a block and the ground, or a belt: s = vᵢ.
pub fn on_ground<T: Scalar>(block: usize) -> [(usize, T); 2] {
    [(block, T::one()), (block, T::zero())]
}

/// The row of a contact between a block and the next one: s = vᵢ₊₁ − vᵢ.
pub fn to_next<T: Scalar>(block: usize) -> [(usize, T); 2] {
    [(block, -T::one()), (block.saturating_add(1), T::one())]
}

/// Blocks in a row, as parameters of a [`LinearMechanism`] whose steps take a time that grows as
/// their number.
///
/// An elastic joint: a motor of 0.01 kg m² with friction drives a link of 0.1 kg m² by a gear of
/// 50 N m/rad.
///
/// ```
/// use bristle::{Bristle, Dahl, DahlParameters, Mechanism};
/// use bristle_mechanism::{Block, Chain, ContactState, Coupling, Inputs, Motion, on_ground};
///
/// let [motor, link] = [0.01, 0.1].map(|inertia| Block {
///     to_ground: Mechanism { mass: inertia, spring_stiffness: 0.0, viscous_damping: 0.0 },
///     to_next: Coupling { stiffness: 50.0, damping: 0.02 },
/// });
/// let (blocks, rows) = ([motor, link], [on_ground(0), on_ground(1)]);
/// let storage = [0.0; Chain::<f64>::STRUCTURE.storage(2, 2)];
/// let mut joint = Chain { blocks: &blocks }.mechanism(rows, storage)?;
/// let friction = Dahl::new(DahlParameters { dynamic_coefficient: 1.0, micro_stiffness: 1e3 })?;
/// let companions = [friction.under_load(0.1)?, friction.under_load(0.05)?]; // N m
/// let companions = [companions[0].companion(1.0)?, companions[1].companion(1.0)?];
/// let mut contacts = companions.map(|companion| ContactState::new(&companion, 0.0));
/// let (mut position, mut velocity) = ([0.0; 2], [0.0; 2]);
/// for _ in 0..1000 {
///     let motion = Motion { position: &mut position, velocity: &mut velocity };
///     joint.step(1e-3, &Inputs::force(&[0.2, 0.0]), motion, &companions, &mut contacts)?;
/// }
/// // 0.2 N m less 0.15 N m of friction, for 1 s.
/// let momentum = 0.01 * velocity[0] + 0.1 * velocity[1];
/// assert!((momentum - 0.05_f64).abs() < 0.01);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chain<'a, T> {
    /// The blocks, in their order.
    pub blocks: &'a [Block<T>],
}

impl<T: Scalar> Chain<'_, T> {
    /// The structure of every chain, which tells the storage it needs.
    pub const STRUCTURE: Structure = Structure::Banded { half_bandwidth: 1 };

    /// The mechanism, in a storage of at least [`Structure::storage`] numbers. Contacts are rows
    /// by [`on_ground`] and [`to_next`].
    ///
    /// # Errors
    ///
    /// Refuses a chain without blocks, masses that are not positive, springs and dampers that are
    /// negative, what is not finite, contacts on blocks that are not there or not neighbours, and a
    /// storage that is too small.
    pub fn mechanism<R: Rows<T>, S: Storage<T>>(
        &self,
        rows: R,
        storage: S,
    ) -> Checked<LinearMechanism<T, R, S>> {
        Named("blocks", self.blocks.len()).count(1)?;
        ParameterError::of_components(self.blocks, |block| {
            block.to_ground.checked()?;
            let Coupling { stiffness, damping } = block.to_next;
            Named("coupling stiffness of block", stiffness).non_negative()?;
            Named("coupling damping of block", damping).non_negative()
        })?;
        LinearMechanism::of_entries(Self::STRUCTURE, self.blocks.len(), self, rows, storage)
    }

    /// As [`Chain::mechanism`], with a storage on the heap.
    ///
    /// # Errors
    ///
    /// As [`Chain::mechanism`].
    #[cfg(feature = "alloc")]
    pub fn on_heap<R: Rows<T>>(
        &self,
        rows: R,
    ) -> Checked<LinearMechanism<T, R, alloc::vec::Vec<T>>> {
        let size = Self::STRUCTURE.storage(self.blocks.len(), rows.contacts());
        self.mechanism(rows, alloc::vec![T::zero(); size])
    }
}

impl<T: Scalar> Entries<T> for Chain<'_, T> {
    fn entry(&self, which: Which, i: usize, j: usize) -> T {
        let of_block = |Block { to_ground, to_next }: &Block<T>| match which {
            Which::Mass => [to_ground.mass, T::zero()],
            Which::Damping => [to_ground.viscous_damping, to_next.damping],
            Which::Stiffness => [to_ground.spring_stiffness, to_next.stiffness],
        };
        let block = |i: usize| self.blocks.get(i).map_or([T::zero(); 2], of_block);
        // Behind the last block there is no coupling.
        let next = |i: usize| if i + 1 < self.blocks.len() { block(i)[1] } else { T::zero() };
        if i != j {
            return -next(i.min(j));
        }
        block(i)[0] + i.checked_sub(1).map_or_else(T::zero, next) + next(i)
    }
}
