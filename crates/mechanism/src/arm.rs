//! A serial arm in a vertical plane: links in a row, of any number, on joints with friction.
//!
//! M(q) q̈ + c(q, q̇) + B q̇ + Wᵀ F = τ − ∂V/∂q
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | qᵢ, θᵢ = q₁ + … + qᵢ | angle of a joint, and of its link from hanging straight down | rad |
//! | mᵢ, lᵢ | mass of a link, its length | kg, m |
//! | cᵢ | distance of its centre of mass from its joint | m |
//! | Iᵢ | moment of inertia of a link about its centre of mass | kg m² |
//! | Jᵢ | moment of inertia of the rotor at its joint | kg m² |
//! | bᵢ | mᵢ cᵢ + lᵢ Σ mₖ of the links k > i | kg m |
//! | V | potential energy −g Σ bᵢ cos θᵢ | J |
//! | B | viscous damping of the joints | N m s/rad |
//! | τ, F | torques of the motors, friction torques | N m |
//!
//! In absolute angles the entries of M are lᵢ bⱼ cos(θᵢ − θⱼ) for i < j, and on the diagonal
//! Iᵢ + mᵢ cᵢ² + lᵢ² Σ mₖ; c has lᵢ bⱼ sin(θᵢ − θⱼ) θ̇ⱼ². Those of the joints are sums over the
//! links beyond each. Rotors count with the angle of their joint.
//!
//! A step takes M, c and V at the middle that the acceleration of the step before predicts. The
//! contacts are passive as in every mechanism; position, velocity and total energy are of second
//! order.
//!
//! Source: H. Asada, J.-J. Slotine, "Robot Analysis and Control" (1986), chapter 5, written out for
//! parallel axes.

use core::mem::take;

use crate::band::place;
use crate::contacts::{ContactState, Step};
use crate::mechanism::{Entries, LinearMechanism, Storage, Structure, Which};
use crate::rows::Rows;
use crate::step::{Motion, check_length, forwards};
use bristle::companion::Companion;
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::rheology::Deflection;
use bristle::scalar::lit;
use bristle::{Bristle, Scalar};

/// A link of an arm, with the joint before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link<T> {
    /// Mass m \[kg\], zero or positive.
    pub mass: T,
    /// Length l \[m\] to the next joint.
    pub length: T,
    /// Distance c \[m\] of the centre of mass from the joint, along the link.
    pub centre: T,
    /// Moment of inertia I [kg m²] about the centre of mass, zero or positive.
    pub inertia: T,
    /// Moment of inertia J [kg m²] of the rotor at the joint, seen at the joint; zero or positive.
    pub rotor: T,
    /// Viscous damping B [N m s/rad] of the joint, zero or positive: the drag of its gear, too.
    pub damping: T,
}

/// Parameters of an [`Arm`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmParameters<'a, T> {
    /// The links, from the base on.
    pub links: &'a [Link<T>],
    /// Gravity g [m/s²], of either sign; zero for an arm in a horizontal plane.
    pub gravity: T,
}

/// The row of a contact at a joint: s = q̇ᵢ.
pub fn on_joint<T: Scalar>(joint: usize) -> [(usize, T); 1] {
    [(joint, T::one())]
}

/// Where an arm is and how it moves: the caller's, changed by a step.
#[derive(Debug, PartialEq)]
pub struct ArmMotion<'a, T> {
    /// Angles q \[rad\] of the joints.
    pub position: &'a mut [T],
    /// Angular velocities q̇ [rad/s].
    pub velocity: &'a mut [T],
    /// Mean accelerations [rad/s²] over the last step, from which the next one is predicted: zero
    /// at rest and after a jump of a velocity.
    pub acceleration: &'a mut [T],
}

/// An arm as predicted for the middle of a step, and what acts on it there.
#[derive(Debug, PartialEq)]
pub struct ArmMiddle<'a, T> {
    /// Angles \[rad\] of the joints.
    pub position: &'a [T],
    /// Angular velocities [rad/s].
    pub velocity: &'a [T],
    /// Torques [N m] of gravity, −∂V/∂q.
    pub gravity: &'a [T],
    /// Torques [N m] of the motors, to be written; zero before.
    pub torque: &'a mut [T],
    /// Loads p of the contacts [N m], to be written where they vary (of a gear that of its torques,
    /// `GearFriction::load` of `bristle-joint`); those of the last step before.
    pub load: &'a mut [T],
}

/// A serial arm in a vertical plane, whose number of joints is known at run time.
///
/// Angles qᵢ of the joints add up: link i is turned by θᵢ = q₁ + … + qᵢ from hanging straight down,
/// all in one sense. The torque of gravity on a single link is −m g c sin q₁.
///
/// **A step has a largest length**, unlike that of a [`LinearMechanism`]. The friction is passive
/// at any, but inertia forces and the torques of a drive are explicit, at the predicted middle:
///
/// - Two, three and seven undamped links of 0.2 m, let go, keep their energy to 1 % while none
///   turns by more than 0.08 rad in a step, to a half by 0.4 rad, and grow to NaN with steps twice
///   as long. Damped arms take more.
/// - A drive τ = −K_P (q − q_d) − K_D q̇ on a link of moment of inertia J, held by nothing else, is
///   stable for K_D h/J + K_P h²/(2J) ≤ 1. Part of K_D as the [damping](Link::damping) of the link
///   has no such limit.
///
/// Seven links of 1 kg, each joint with friction, lifted from hanging by controllers:
///
/// ```
/// use bristle::{Bristle, FrBd, curve::Stribeck, paper, rheology::KelvinVoigt};
/// use bristle_mechanism::{Arm, ArmMotion, ArmParameters, ContactState, Link, on_joint};
///
/// let (mass, length, inertia) = (1.0, 0.2, 0.2 * 0.2 / 12.0);
/// let link = Link { mass, length, centre: 0.1, inertia, rotor: 0.05, damping: 0.1 };
/// let n: usize = "7".parse()?; // from a file
/// let rows: Vec<_> = (0..n).map(on_joint).collect();
/// let parameters = ArmParameters { links: &vec![link; n], gravity: 9.81 };
/// let mut arm = Arm::on_heap(&parameters, rows)?;
///
/// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
/// let friction = FrBd::new(Stribeck::new(paper::STICK_SLIP_CURVE)?, bristle);
/// let companion = friction.under_load(0.5)?.companion(10.0)?; // N m, rad/s: one for all
/// let mut contacts = vec![ContactState::new(&companion, 0.0); n];
/// let [mut q, mut v, mut a] = [(); 3].map(|()| vec![0.0; n]);
/// for _ in 0..2000 {
///     let motion = ArmMotion { position: &mut q, velocity: &mut v, acceleration: &mut a };
///     arm.step(1e-3, motion, &[companion], &mut contacts, |middle| {
///         for (i, torque) in middle.torque.iter_mut().enumerate() {
///             *torque = 300.0 * (0.3 - middle.position[i]) - 20.0 * middle.velocity[i];
///         }
///     })?;
/// }
/// assert!(q.iter().all(|q| *q > 0.0 && *q < 0.3) && arm.energy(&q, &v) > 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arm<T, R, S> {
    pub(crate) mechanism: LinearMechanism<T, R, S>,
    pub(crate) gravity: T,
}

/// What the arm keeps of each link: its length l, b, its moment of inertia in absolute angles, and
/// that of its rotor.
pub(crate) const KEPT: usize = 4;

/// Numbers of a [`Room`] for each link, beside those it keeps.
pub(crate) const ROOM: usize = 10;

/// The room of a step, for each link.
pub(crate) struct Room<'a, T> {
    pub(crate) kept: &'a mut [T],
    pub(crate) position: &'a mut [T],
    pub(crate) velocity: &'a mut [T],
    pub(crate) gravity: &'a mut [T],
    pub(crate) torque: &'a mut [T],
    /// cos θ, sin θ, θ̇
    pub(crate) turned: [&'a mut [T]; 3],
    /// Derivatives, and of each contact the load.
    pub(crate) adjoint: [&'a mut [T]; 3],
    pub(crate) load: &'a mut [T],
}

impl<'a, T: Scalar> Room<'a, T> {
    pub(crate) fn new(mut rest: &'a mut [T], n: usize, contacts: usize) -> Self {
        let mut next = |count| rest.split_off_mut(..count).unwrap_or_default();
        let kept = next(KEPT * n);
        let [position, velocity, gravity, torque] = [n; 4].map(&mut next);
        let (turned, adjoint) = ([n; 3].map(&mut next), [n; 3].map(&mut next));
        let load = next(contacts);
        Self { kept, position, velocity, gravity, torque, turned, adjoint, load }
    }

    /// The middle of a step, with the torques of gravity there.
    pub(crate) fn predict(&mut self, motion: [&[T]; 3], half: T, gravity: T) {
        let [position, velocity, acceleration] = motion;
        let [cosine, sine, rate] = &mut self.turned;
        let (mut angle, mut turning) = (T::zero(), T::zero());
        for (i, acceleration) in acceleration.iter().enumerate() {
            self.velocity[i] = velocity[i] + half * *acceleration;
            self.position[i] = position[i] + half * self.velocity[i];
            (angle, turning) = (angle + self.position[i], turning + self.velocity[i]);
            (sine[i], cosine[i]) = angle.sin_cos();
            rate[i] = turning;
        }
        for (i, link) in self.kept.chunks_exact(KEPT).enumerate().rev() {
            let beyond = self.gravity.get(i + 1).map_or_else(T::zero, |&beyond| beyond);
            self.gravity[i] = beyond - gravity * link[1] * sine[i];
        }
    }

    /// What a drive is given, with the loads of the step before and without torques.
    pub(crate) fn middle<D: Deflection<T>>(
        &mut self,
        contacts: &[ContactState<T, D>],
    ) -> ArmMiddle<'_, T> {
        self.torque.fill(T::zero());
        self.load.iter_mut().zip(contacts).for_each(|(load, state)| *load = state.load());
        let Self { position, velocity, gravity, torque, load, .. } = self;
        ArmMiddle { position, velocity, gravity, torque, load }
    }

    /// M(q), and the forces in the place of the accelerations.
    pub(crate) fn assemble(&mut self, mass: &mut [T], force: &mut [T]) {
        let [cosine, sine, rate] = &self.turned;
        inertia(self.kept, [cosine, sine, rate], mass, force);
        for (i, force) in force.iter_mut().enumerate() {
            *force = self.torque[i] + self.gravity[i] - *force;
        }
    }
}

impl<T: Scalar> ArmParameters<'_, T> {
    /// How many numbers an arm of so many links and contacts stores.
    pub const fn storage(links: usize, contacts: usize) -> usize {
        let beside = links.saturating_mul(KEPT + ROOM).saturating_add(contacts);
        structure(links).storage(links, contacts).saturating_add(beside)
    }
}

pub(crate) const fn structure(links: usize) -> Structure {
    Structure::Banded { half_bandwidth: links.saturating_sub(1) }
}

impl<T: Scalar> Link<T> {
    fn check(&self) -> Checked<T> {
        let mass = Named("mass", self.mass).non_negative()?;
        Named("length", self.length).finite()?;
        let centre = Named("centre", self.centre).finite()?;
        let inertia = Named("inertia", self.inertia).non_negative()?;
        let rotor = Named("rotor", self.rotor).non_negative()?;
        Named("damping", self.damping).non_negative()?;
        Named("inertia about the joint", inertia + mass * centre * centre + rotor).positive()
    }
}

/// B, and a mass in whose place every step puts M(q).
impl<T: Scalar> Entries<T> for ArmParameters<'_, T> {
    fn entry(&self, which: Which, i: usize, j: usize) -> T {
        match which {
            Which::Mass if i == j => T::one(),
            Which::Damping if i == j => self.links.get(i).map_or_else(T::zero, |link| link.damping),
            _ => T::zero(),
        }
    }
}

impl<T: Scalar, R: Rows<T>, S: Storage<T>> Arm<T, R, S> {
    /// An arm with contacts, in a storage of at least [`ArmParameters::storage`] numbers. Contacts
    /// are rows by [`on_joint`], or any other.
    ///
    /// # Errors
    ///
    /// Refuses an arm without links; masses, moments of inertia and dampings that are negative; a
    /// link that turns without inertia, I + m c² + J = 0; what is not finite; contacts on joints
    /// that are not there; a storage that is too small.
    pub fn new(parameters: &ArmParameters<'_, T>, rows: R, storage: S) -> Checked<Self> {
        let ArmParameters { links, gravity } = *parameters;
        let n = links.len();
        Named("links", n).count(1)?;
        let gravity = Named("gravity", gravity).finite()?;
        ParameterError::of_components(links, Link::check)?;
        let needed = ArmParameters::<T>::storage(n, rows.contacts());
        Named("numbers of storage", storage.as_ref().len()).count(needed)?;
        let mut mechanism =
            LinearMechanism::of_entries(structure(n), n, parameters, rows, storage)?;
        let (mut beyond, (_, parts)) = (T::zero(), mechanism.split());
        let kept = parts.room.chunks_exact_mut(KEPT).zip(links);
        for (kept, link) in kept.rev() {
            let Link { mass, length, centre, inertia, rotor, .. } = *link;
            let own = inertia + mass * centre * centre + length * length * beyond;
            kept.copy_from_slice(&[length, mass * centre + length * beyond, own, rotor]);
            beyond += mass;
        }
        Ok(Self { mechanism, gravity })
    }

    /// A step of length h ≥ 0 \[s\], with a state for each contact and a companion for each, or one
    /// for all. `drive` is asked once, for torques and loads at the predicted middle of the step:
    /// controllers, and gears whose load follows their torques. NaN for NaN, and for h < 0.
    ///
    /// # Errors
    ///
    /// Refuses slices of lengths that do not fit; nothing has moved.
    pub fn step<M: Bristle<T>>(
        &mut self,
        duration: T,
        motion: ArmMotion<'_, T>,
        companions: &[Companion<T, M>],
        contacts: &mut [ContactState<T, M::Deflection>],
        drive: impl FnOnce(ArmMiddle<'_, T>),
    ) -> Checked<()> {
        let ArmMotion { position, velocity, acceleration } = motion;
        self.check([position, velocity, acceleration], companions, contacts)?;
        let (n, gravity) = (self.mechanism.coordinates(), self.gravity);
        let duration = forwards(duration);
        let (rows, mut parts) = self.mechanism.prepared(duration);
        let mut room = Room::new(take(&mut parts.room), n, contacts.len());
        let predicted = [&*position, velocity, acceleration];
        room.predict(predicted, lit::<T>(0.5) * duration, gravity);
        drive(room.middle(contacts));
        room.assemble(parts.mass, parts.acceleration);
        let motion = Motion { position, velocity };
        let step = Step { duration, companions, rows };
        parts.step(&step, [&[], room.load], motion, contacts);
        acceleration.copy_from_slice(parts.acceleration);
        Ok(())
    }

    /// Refuses what does not fit a step.
    pub(crate) fn check<M: Bristle<T>>(
        &self,
        [position, velocity, acceleration]: [&[T]; 3],
        companions: &[Companion<T, M>],
        contacts: &[ContactState<T, M::Deflection>],
    ) -> Checked<()> {
        let n = self.mechanism.coordinates();
        check_length("positions", position, n)?;
        check_length("velocities", velocity, n)?;
        check_length("accelerations", acceleration, n)?;
        self.mechanism.check_contacts(companions, contacts)
    }

    /// Kinetic and potential energy \[J\], without that of the bristles; zero at rest, hanging.
    /// NaN for slices of other lengths.
    pub fn energy(&self, position: &[T], velocity: &[T]) -> T {
        let n = self.mechanism.coordinates();
        if position.len() != n || velocity.len() != n {
            return T::nan();
        }
        let [mut angle, mut rate, mut x, mut y, mut energy] = [T::zero(); 5];
        let links = self.kept().chunks_exact(KEPT);
        for (link, (&q, &v)) in links.zip(position.iter().zip(velocity)) {
            let [length, moment, own, rotor] = [link[0], link[1], link[2], link[3]];
            (angle, rate) = (angle + q, rate + v);
            let (sine, cosine) = angle.sin_cos();
            let half = lit::<T>(0.5);
            energy += half * (own * rate * rate + rotor * v * v);
            // (x, y) is the velocity of the joint; that of the link's points beside it is rate · r.
            energy += moment * rate * (x * cosine + y * sine);
            let raised = (half * angle).sin();
            energy += self.gravity * moment * (raised * raised + raised * raised);
            (x, y) = (x + length * rate * cosine, y + length * rate * sine);
        }
        energy
    }

    /// What it keeps of its links.
    pub(crate) fn kept(&self) -> &[T] {
        let n = self.mechanism.coordinates();
        let end = structure(n).storage(n, self.mechanism.rows().contacts());
        self.mechanism.storage.as_ref().get(end..end + KEPT * n).unwrap_or(&[])
    }

    /// vᵀ B v \[W\]. NaN for a slice of another length.
    pub fn damped_power(&self, velocity: &[T]) -> T {
        self.mechanism.damped_power(velocity)
    }

    /// The velocities [rad/s] averaged over the last step.
    pub fn mean_velocities(&self) -> &[T] {
        self.mechanism.mean_velocities()
    }
}

#[cfg(feature = "alloc")]
impl<T: Scalar, R: Rows<T>> Arm<T, R, alloc::vec::Vec<T>> {
    /// As [`Arm::new`], with a storage on the heap, for a number of joints known at run time. Steps
    /// do not allocate.
    ///
    /// # Errors
    ///
    /// As [`Arm::new`].
    pub fn on_heap(parameters: &ArmParameters<'_, T>, rows: R) -> Checked<Self> {
        let size = ArmParameters::<T>::storage(parameters.links.len(), rows.contacts());
        Self::new(parameters, rows, alloc::vec![T::zero(); size])
    }
}

/// M(q) and c(q, q̇) of the joints.
fn inertia<T: Scalar>(
    kept: &[T],
    [cosine, sine, rate]: [&[T]; 3],
    mass: &mut [T],
    coriolis: &mut [T],
) {
    let n = coriolis.len();
    for i in 0..n {
        let moment = kept[KEPT * i + 1];
        coriolis[i] = T::zero();
        for j in 0..i {
            let factor = kept[KEPT * j] * moment;
            let across = factor * (sine[i] * cosine[j] - cosine[i] * sine[j]);
            mass[place(n, i, j)] = factor * (cosine[i] * cosine[j] + sine[i] * sine[j]);
            coriolis[i] += across * rate[j] * rate[j];
            coriolis[j] -= across * rate[i] * rate[i];
        }
        mass[place(n, i, i)] = kept[KEPT * i + 2];
    }
    // From absolute angles to those of the joints: sums over all links k ≥ i, l ≥ j.
    for i in (0..n).rev() {
        for j in (0..=i).rev() {
            let mut sum = mass[place(n, i, j)];
            if j < i {
                sum += mass[place(n, i, j + 1)];
            } else if i + 1 < n {
                sum += mass[place(n, i + 1, i)];
            }
            if i + 1 < n {
                sum += mass[place(n, i + 1, j)] - mass[place(n, i + 1, j + 1)];
            }
            mass[place(n, i, j)] = sum;
        }
        if i + 1 < n {
            coriolis[i] += coriolis[i + 1];
        }
    }
    for (i, link) in kept.chunks_exact(KEPT).enumerate() {
        mass[place(n, i, i)] += link[3];
    }
}
