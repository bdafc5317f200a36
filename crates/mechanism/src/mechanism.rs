//! The matrices of a mechanism, checked, and where its numbers are stored.

use crate::band;
use crate::rows::{self, Rows};
use crate::step::{Parts, check_length};
use bristle::Scalar;
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::scalar::{is_zero, lit};

/// The structure of M, C and K, which chooses how a step is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Structure {
    /// n² entries, row by row. A step solves a system of the size of the contacts.
    Dense,
    /// n entries, the diagonals: a body in its modes. A step solves a system of the size of the
    /// contacts.
    Diagonal,
    /// n (b + 1) entries, row by row, of row i those of columns i − b … i (those before column 0 do
    /// not count): bodies in a row. A step solves the whole, in a time that grows as n b². A
    /// contact must lie within b coordinates.
    Banded {
        /// Half-width b: entries farther than that from the diagonal are zero.
        half_bandwidth: usize,
    },
}

impl Structure {
    /// Entries in a row of the stored matrices.
    pub(crate) const fn width(self, coordinates: usize) -> usize {
        match self {
            Structure::Dense => coordinates,
            Structure::Diagonal => 1,
            Structure::Banded { half_bandwidth } => half_bandwidth.saturating_add(1),
        }
    }

    /// Whether the contacts are solved for alone.
    pub(crate) const fn is_reduced(self) -> bool {
        !matches!(self, Structure::Banded { .. })
    }

    /// How many numbers a mechanism of so many coordinates and contacts stores.
    pub const fn storage(self, coordinates: usize, contacts: usize) -> usize {
        let sums = contacts.saturating_mul(2).saturating_add(coordinates);
        let reduced = if self.is_reduced() { contacts.saturating_mul(sums) } else { 0 };
        // Four matrices, and two and three vectors.
        let rows = self.width(coordinates).saturating_mul(4).saturating_add(2);
        let all = rows.saturating_mul(coordinates).saturating_add(reduced);
        all.saturating_add(contacts.saturating_mul(3))
    }
}

/// The matrices of a mechanism.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Matrices<'a, T> {
    /// How the slices are laid out.
    pub structure: Structure,
    /// Mass matrix M \[kg\], symmetric and positive definite.
    pub mass: &'a [T],
    /// Damping matrix C [N s/m], symmetric and positive semidefinite; empty for none.
    pub damping: &'a [T],
    /// Stiffness matrix K [N/m], symmetric and positive semidefinite; empty for none.
    pub stiffness: &'a [T],
}

/// M, C and K by their entries: name, whether it must be definite, and the entry (i, j).
pub(crate) trait Entries<T> {
    fn entry(&self, which: Which, i: usize, j: usize) -> T;
}

/// One of the three matrices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Which {
    Mass,
    Damping,
    Stiffness,
}

impl Which {
    pub(crate) const ALL: [Self; 3] = [Self::Mass, Self::Damping, Self::Stiffness];

    fn names(self) -> [&'static str; 4] {
        NAMES[self as usize]
    }
}

/// The names of the entries all together, of one on the diagonal, of one before it in its row, and
/// of a pivot.
const NAMES: [[&str; 4]; 3] = [
    ["entries of mass", "mass", "entry of mass in row", "pivot of mass"],
    ["entries of damping", "damping", "entry of damping in row", "pivot of damping"],
    ["entries of stiffness", "stiffness", "entry of stiffness in row", "pivot of stiffness"],
];

impl<T: Scalar> Matrices<'_, T> {
    fn of(&self, which: Which) -> &[T] {
        [self.mass, self.damping, self.stiffness][which as usize]
    }

    /// The number of coordinates that the masses make, if they make any.
    fn coordinates(&self) -> Checked<usize> {
        let entries = self.mass.len();
        let coordinates = match self.structure {
            Structure::Dense => {
                let root = entries.isqrt();
                Named("number of entries of mass", lit::<T>(entries as f64))
                    .stated(root * root == entries, "be n²: a dense matrix must be square")?;
                root
            }
            structure => entries / structure.width(0),
        };
        Named("coordinates", coordinates).count(1)?;
        let wanted = coordinates * self.structure.width(coordinates);
        for which in Which::ALL {
            let given = self.of(which);
            if !given.is_empty() || which == Which::Mass {
                check_length(which.names()[0], given, wanted)?;
            }
        }
        Ok(coordinates)
    }
}

impl<T: Scalar> Entries<T> for (&Matrices<'_, T>, usize) {
    fn entry(&self, which: Which, i: usize, j: usize) -> T {
        let (matrices, coordinates) = *self;
        let width = matrices.structure.width(coordinates);
        let place = match matrices.structure {
            Structure::Dense => i * width + j,
            _ => band::place(width, i.max(j), i.min(j)),
        };
        matrices.of(which).get(place).copied().unwrap_or_else(T::zero)
    }
}

/// A linear mechanism with contacts, and the room in which its steps are computed. It has no state:
/// positions, velocities and contacts are the caller's.
///
/// The numbers are in a storage of the caller's choice, an array of
/// [`Structure::storage`] numbers, or on the heap by [`LinearMechanism::on_heap`]. Both give the
/// same bits. Three masses between walls, with friction to the ground and between the first two:
///
/// ```
/// use bristle::{Bristle, FrBd, curve::Stribeck, paper, rheology::KelvinVoigt};
/// use bristle_mechanism::{
///     ContactState, Inputs, LinearMechanism, Matrices, Motion, Structure,
/// };
///
/// let stiffness = [[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]]; // N/m
/// let matrices = Matrices {
///     structure: Structure::Dense,
///     mass: &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], // kg
///     damping: &[],
///     stiffness: stiffness.as_flattened(),
/// };
/// let rows: [&[(usize, f64)]; 2] = [&[(0, 1.0)], &[(1, 1.0), (0, -1.0)]];
/// let storage = [0.0; Structure::Dense.storage(3, 2)];
/// let mut mechanism = LinearMechanism::new(&matrices, rows, storage)?;
///
/// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
/// let friction = FrBd::new(Stribeck::new(paper::STICK_SLIP_CURVE)?, bristle);
/// let companions = [friction.under_load(0.1)?.companion(1.0)?; 2]; // N, m/s
/// let mut contacts = companions.map(|companion| ContactState::new(&companion, 0.0));
/// let (mut position, mut velocity) = ([0.0; 3], [0.0; 3]);
/// for n in 0..1000 {
///     let force = [0.0, (0.012 * f64::from(n)).cos(), 0.0]; // N
///     let motion = Motion { position: &mut position, velocity: &mut velocity };
///     mechanism.step(0.01, &Inputs::force(&force), motion, &companions, &mut contacts)?;
/// }
/// assert!(mechanism.energy(&position, &velocity) > 0.0); // J
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearMechanism<T, R, S> {
    pub(crate) structure: Structure,
    pub(crate) coordinates: usize,
    /// The length of the step for which A is factored; NaN for none.
    pub(crate) duration: T,
    pub(crate) rows: R,
    pub(crate) storage: S,
}

/// Room for the numbers of a mechanism: an array, a mutable slice or a vector of them.
pub trait Storage<T>: AsRef<[T]> + AsMut<[T]> {}

impl<T, S: AsRef<[T]> + AsMut<[T]>> Storage<T> for S {}

impl<T: Scalar, R: Rows<T>, S: Storage<T>> LinearMechanism<T, R, S> {
    /// A mechanism with contacts, in a storage of at least [`Structure::storage`] numbers.
    ///
    /// # Errors
    ///
    /// Refuses matrices without coordinates, of lengths that do not fit, not finite or not
    /// symmetric (up to rounding); M that is not positive definite; C and K that have a negative
    /// eigenvalue; a contact on nothing, or in a band on coordinates too far apart; a storage that
    /// is too small.
    pub fn new(matrices: &Matrices<'_, T>, rows: R, storage: S) -> Checked<Self> {
        let coordinates = matrices.coordinates()?;
        Self::of_entries(matrices.structure, coordinates, &(matrices, coordinates), rows, storage)
    }

    pub(crate) fn of_entries(
        structure: Structure,
        coordinates: usize,
        entries: &impl Entries<T>,
        rows: R,
        storage: S,
    ) -> Checked<Self> {
        let needed = structure.storage(coordinates, rows.contacts());
        Named("numbers of storage", storage.as_ref().len()).count(needed)?;
        let mut mechanism = Self { structure, coordinates, duration: T::nan(), rows, storage };
        rows::check(&mechanism.rows, structure, coordinates)?;
        mechanism.load(entries)?;
        Ok(mechanism)
    }

    /// Takes other matrices of the same structure and size, and other rows of as many contacts:
    /// M(q) and W(q) of a mechanism whose geometry changes, before each step. A is factored anew.
    ///
    /// # Errors
    ///
    /// As [`LinearMechanism::new`]; the mechanism is as it was.
    pub fn change(&mut self, matrices: &Matrices<'_, T>, rows: R) -> Checked<()> {
        if matrices.structure != self.structure {
            return Err(ParameterError::chosen("another", "a mechanism keeps its structure"));
        }
        let (coordinates, contacts) = (self.coordinates, self.rows.contacts());
        Named("coordinates", matrices.coordinates()?).count_between(coordinates, coordinates)?;
        Named("contacts", rows.contacts()).count_between(contacts, contacts)?;
        rows::check(&rows, self.structure, self.coordinates)?;
        self.load(&(matrices, self.coordinates))?;
        self.rows = rows;
        Ok(())
    }

    /// Checks all matrices in the room of the factors, then stores them.
    fn load(&mut self, entries: &impl Entries<T>) -> Checked<()> {
        let width = self.width();
        self.duration = T::nan();
        let (_, parts) = self.split();
        for which in Which::ALL {
            check(which, width, entries, parts.factors)?;
        }
        for (which, matrix) in
            Which::ALL.into_iter().zip([parts.mass, parts.damping, parts.stiffness])
        {
            for (i, row) in matrix.chunks_exact_mut(width).enumerate() {
                for j in i.saturating_sub(width - 1)..=i {
                    row[j + width - 1 - i] = entries.entry(which, i, j);
                }
            }
        }
        Ok(())
    }

    pub(crate) fn width(&self) -> usize {
        self.structure.width(self.coordinates)
    }

    /// The contacts, and the storage in its parts.
    #[inline(always)]
    pub(crate) fn split(&mut self) -> (&R, Parts<'_, T>) {
        let (n, m) = (self.coordinates, self.rows.contacts());
        let matrix = n * self.structure.width(n);
        let reduced = if self.structure.is_reduced() { m } else { 0 };
        let mut rest = self.storage.as_mut();
        let mut next = |count| rest.split_off_mut(..count).unwrap_or_default();
        let parts = Parts {
            structure: self.structure,
            mass: next(matrix),
            damping: next(matrix),
            stiffness: next(matrix),
            factors: next(matrix),
            responses: next(reduced * n),
            coupling: next(reduced * m),
            system: next(reduced * m),
            acceleration: next(n),
            mean_velocity: next(n),
            bias: next(m),
            dampers: next(m),
            sliding: next(m),
            room: rest,
        };
        (&self.rows, parts)
    }

    /// The number of coordinates n.
    pub fn coordinates(&self) -> usize {
        self.coordinates
    }

    /// The contacts.
    pub fn rows(&self) -> &R {
        &self.rows
    }

    /// E = ½ vᵀ M v + ½ xᵀ K x \[J\], without that of the bristles. NaN for slices of other
    /// lengths.
    pub fn energy(&self, position: &[T], velocity: &[T]) -> T {
        lit::<T>(0.5) * (self.form(Which::Mass, velocity) + self.form(Which::Stiffness, position))
    }

    /// vᵀ C v \[W\]. NaN for a slice of another length.
    pub fn damped_power(&self, velocity: &[T]) -> T {
        self.form(Which::Damping, velocity)
    }

    /// xᵀ A x of one of the stored matrices.
    fn form(&self, which: Which, x: &[T]) -> T {
        if x.len() == self.coordinates {
            band::quadratic(self.width(), self.matrix(which), x)
        } else {
            T::nan()
        }
    }

    /// M, C or K as it is stored.
    pub(crate) fn matrix(&self, which: Which) -> &[T] {
        let (which, size) = (which as usize, self.coordinates * self.width());
        self.storage.as_ref().get(which * size..(which + 1) * size).unwrap_or(&[])
    }
}

#[cfg(feature = "alloc")]
impl<T: Scalar, R: Rows<T>> LinearMechanism<T, R, alloc::vec::Vec<T>> {
    /// As [`LinearMechanism::new`], with a storage on the heap, for sizes known at run time. Steps
    /// do not allocate.
    ///
    /// # Errors
    ///
    /// As [`LinearMechanism::new`].
    pub fn on_heap(matrices: &Matrices<'_, T>, rows: R) -> Checked<Self> {
        let size = matrices.structure.storage(matrices.coordinates()?, rows.contacts());
        Self::new(matrices, rows, alloc::vec![T::zero(); size])
    }
}

const SYMMETRIC: &str = "equal the entry across the diagonal: the matrix must be symmetric";
const BOUNDED: &str = "be at most √(aᵢᵢ aⱼⱼ): the matrix must not have a negative eigenvalue";

/// Refuses what is not finite, not symmetric or not (semi)definite, in the room for a matrix.
fn check<T: Scalar>(
    which: Which,
    width: usize,
    entries: &impl Entries<T>,
    room: &mut [T],
) -> Checked<()> {
    let [_, name, beside, pivots] = which.names();
    // The roundings of L D Lᵀ, relative to the diagonal: N. J. Higham, "Accuracy and Stability of
    // Numerical Algorithms" (2002), theorems 10.5 and 10.7.
    let rounding = T::default_epsilon() * lit(8.0 * (width + 1) as f64);
    let definite = which == Which::Mass;
    let fill = |i: usize, row: &mut [T]| {
        let diagonal = Named(name, entries.entry(which, i, i));
        let diagonal = if definite { diagonal.positive() } else { diagonal.non_negative() }?;
        for j in i.saturating_sub(width - 1)..i {
            let value = Named(beside, entries.entry(which, i, j));
            row[j + width - 1 - i] = value.finite()?;
            let mirrored = Named(beside, entries.entry(which, j, i)).finite()?;
            // Not as a product, which could overflow.
            let of_both = diagonal.sqrt() * entries.entry(which, j, j).sqrt();
            value.stated((value.1 - mirrored).abs() <= rounding * of_both, SYMMETRIC)?;
            value.stated(value.1.abs() <= of_both * (T::one() + rounding), BOUNDED)?;
        }
        let shift = if definite { T::one() } else { T::one() + rounding };
        // A row of zeros stands alone.
        let alone = is_zero(diagonal);
        row[width - 1] = if alone { T::one() } else { diagonal * shift };
        Ok(())
    };
    for (i, row) in room.chunks_exact_mut(width).enumerate() {
        ParameterError::of_component(i, fill(i, row))?;
    }
    let rule = if definite {
        "be positive: the matrix must be positive definite"
    } else {
        "not be negative: the matrix must not have a negative eigenvalue"
    };
    let mut last = Ok(T::one());
    band::factor(width, room, |i, pivot| {
        let least = if definite { entries.entry(which, i, i) * rounding } else { T::zero() };
        let pivot = Named(pivots, pivot);
        if last.is_ok() {
            last = ParameterError::of_component(i, pivot.stated(pivot.1 > least, rule));
        }
    });
    last.map(drop)
}
