//! The equations of motion of a mechanism, for [`bristle::ode::solve`].

use alloc::vec;
use alloc::vec::Vec;

use crate::arm::{Arm, KEPT, ROOM, Room};
use crate::band;
use crate::elastic_joint::{ElasticJoint, ElasticJointParameters};
use crate::mechanism::{LinearMechanism, Storage, Which};
use crate::rows::{Rows, along, spread};
use bristle::ode::dynamic;
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::scalar::lit;
use bristle::{Branch, Bristle, Contact, Scalar, Surface};

/// What acts on a mechanism at one time.
#[derive(Debug, PartialEq)]
pub struct Acting<'a, T> {
    /// Time t \[s\].
    pub time: T,
    /// Coordinates x \[m\].
    pub position: &'a [T],
    /// Velocities v [m/s].
    pub velocity: &'a [T],
    /// Forces f \[N\] on the coordinates, to be written; zero before.
    pub force: &'a mut [T],
    /// Prescribed part w [m/s] of each contact's sliding velocity, minus the velocity of a belt, to
    /// be written; zero before.
    pub prescribed: &'a mut [T],
    /// Normal force \[N\] of each contact, to be written where it varies; that of the contact
    /// before.
    pub load: &'a mut [T],
}

/// The equations of motion of a [`LinearMechanism`], an [`Arm`] or an [`ElasticJoint`]: a
/// [`dynamic::System`].
///
/// Friction is that of [`Contact::response_under`] under the loads that act, also where they are
/// those of the contacts: what a bristle holds beyond the friction of the moment is cut. With much
/// viscous friction a body that slows down quickly has a smaller force by that than
/// [`Contact::response`] gives.
///
/// It gives no derivatives: where a method asks for them, each state costs an evaluation, and one
/// of an arm of n joints costs as n³. With stiff bristles, arms of some ten joints are quick and
/// those of sixty are dear; a fixed step of theirs costs as n³ alone.
///
/// States are the coordinates, then their velocities, then the deflection of each contact. An arm
/// of joints that a file counts, let go:
///
/// ```
/// use bristle::ode::{self, Output};
/// use bristle::{Bristle, Dahl, DahlParameters};
/// use bristle_mechanism::{Arm, ArmParameters, EquationsOfMotion, Link, on_joint};
///
/// let n: usize = "3".parse()?; // from a file
/// let (mass, length, inertia) = (1.0, 0.2, 0.2 * 0.2 / 12.0); // kg, m, kg m²
/// let link = Link { mass, length, centre: 0.1, inertia, rotor: 0.02, damping: 0.05 };
/// let parameters = ArmParameters { links: &vec![link; n], gravity: 9.81 };
/// let arm = Arm::on_heap(&parameters, (0..n).map(on_joint).collect::<Vec<_>>())?;
/// let friction = Dahl::new(DahlParameters { dynamic_coefficient: 1.0, micro_stiffness: 1e3 })?;
/// let contacts = [friction.under_load(0.2)?]; // N m: one for all
///
/// let motor = |acting: bristle_mechanism::Acting<'_, f64>| {
///     acting.force[0] = -0.5 * acting.velocity[0]; // N m
/// };
/// let system = EquationsOfMotion::new(&arm, &contacts, [1.0, 1.0], motor)?; // rad, rad/s
/// let mut start = vec![0.0; 3 * n];
/// start[0] = 1.0; // rad
/// let motion = ode::solve(&system, 0.0..2.0, start, 1e-6, Output::Uniform(201))?;
/// let (q, v) = motion.states()[200].split_at(n);
/// assert!(arm.energy(q, &v[..n]) < arm.energy(&[1.0, 0.0, 0.0], &[0.0; 3]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct EquationsOfMotion<'a, T, B, M, F> {
    mechanism: &'a B,
    contacts: &'a [Contact<T, M>],
    /// L D Lᵀ of the mass matrix where it is constant.
    factors: Vec<T>,
    scales: Vec<T>,
    longest_step: Option<T>,
    kinks: Vec<T>,
    act: F,
}

impl<'a, T, B, M, F> EquationsOfMotion<'a, T, B, M, F>
where
    T: Scalar,
    B: Mechanics<T>,
    M: Bristle<T, Deflection = T>,
    F: Fn(Acting<'_, T>),
{
    /// The equations with a contact for each row of the mechanism, or one for all, and with typical
    /// magnitudes \[m\] and [m/s] of coordinates and velocities, to which tolerances are relative.
    /// That of a deflection is the largest at rest, or 10⁻⁶ m if that is zero (without load) or has
    /// no bound. `act` is asked for what acts, at any time and state, and has to give the same for
    /// the same. Evaluations allocate: for a loop take steps.
    ///
    /// # Errors
    ///
    /// Refuses another number of contacts, and magnitudes that are not positive and finite.
    pub fn new(
        mechanism: &'a B,
        contacts: &'a [Contact<T, M>],
        magnitudes: [T; 2],
        act: F,
    ) -> Checked<Self> {
        let (n, m) = mechanism.sizes();
        if contacts.len() != 1 {
            Named("contacts", contacts.len()).count_between(m, m)?;
        }
        let positive = |value| Named("magnitudes", value).positive();
        ParameterError::of_components(magnitudes, positive)?;
        let mut scales = vec![magnitudes[0]; 2 * n + m];
        scales[n..2 * n].fill(magnitudes[1]);
        let factors = mechanism.factors();
        let (longest_step, kinks) = (None, Vec::new());
        let mut all = Self { mechanism, contacts, factors, scales, longest_step, kinks, act };
        for k in 0..m {
            let limit = all.contact(k).limits(T::zero()).deflection.filter(|z| *z > T::zero());
            all.scales[2 * n + k] = limit.unwrap_or_else(|| lit(1e-6));
        }
        Ok(all)
    }

    /// With the times \[s\] at which what acts jumps or has a kink. Steps end there, and `act` has
    /// to give what holds just after.
    ///
    /// ```
    /// use bristle::ode::{self, Output};
    /// use bristle::{Bristle, Dahl, DahlParameters};
    /// use bristle_mechanism::{Acting, ElasticJoint, ElasticJointParameters, EquationsOfMotion};
    ///
    /// let joint = ElasticJoint::new(ElasticJointParameters {
    ///     inertias: [1e-3, 0.02], // kg m²
    ///     stiffness: 500.0,       // N m/rad
    ///     damping: 0.1,           // N m s/rad
    ///     backlash: 0.0,          // rad
    /// })?;
    /// let dahl = DahlParameters { dynamic_coefficient: 1.0, micro_stiffness: 1e3 };
    /// let contacts = [Dahl::new(dahl)?.under_load(0.2)?]; // N m
    /// let (begin, end) = (0.5, 0.503); // s
    /// let push = |acting: Acting<'_, f64>| {
    ///     acting.force[0] = if (begin..end).contains(&acting.time) { 10.0 } else { 0.0 }; // N m
    /// };
    /// let system = EquationsOfMotion::new(&joint, &contacts, [1.0, 1.0], push)?;
    /// let system = system.with_kinks(vec![begin, end])?;
    /// let start = vec![0.0; 6]; // angles, velocities, and friction on either side
    /// let motion = ode::solve(&system, 0.0..1.0, start, 1e-6, Output::Uniform(101))?;
    /// assert!(motion.states()[100][0] > 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses times that are not finite or do not increase.
    pub fn with_kinks(mut self, kinks: Vec<T>) -> Checked<Self> {
        let mut before = None;
        ParameterError::of_components(&kinks, |&time| {
            let time = Named("kinks", time);
            before.replace(time.1).map_or_else(|| time.finite(), |before| time.increasing(before))
        })?;
        self.kinks = kinks;
        Ok(self)
    }

    /// With a bound of adaptive steps \[s\]: a quarter of the shortest pause or pulse of what acts,
    /// if its times are not known as [kinks](EquationsOfMotion::with_kinks).
    ///
    /// # Errors
    ///
    /// Refuses a bound that is not positive and finite.
    pub fn with_longest_step(mut self, step: T) -> Checked<Self> {
        self.longest_step = Some(Named("longest step", step).positive()?);
        Ok(self)
    }

    fn contact(&self, k: usize) -> &Contact<T, M> {
        &self.contacts[k.min(self.contacts.len() - 1)]
    }

    /// Forces in the place of a vector of zeros; belts and loads.
    fn acting(&self, time: T, state: &[T], force: &mut [T]) -> [Vec<T>; 2] {
        let (n, m) = self.mechanism.sizes();
        let mut load: Vec<T> = (0..m).map(|k| self.contact(k).normal_force()).collect();
        let mut belt = vec![T::zero(); m];
        let (position, velocity) = (&state[..n], &state[n..2 * n]);
        let (prescribed, to_load) = (&mut belt[..], &mut load[..]);
        (self.act)(Acting { time, position, velocity, force, prescribed, load: to_load });
        [belt, load]
    }
}

impl<T, B, M, F> dynamic::System<T> for EquationsOfMotion<'_, T, B, M, F>
where
    T: Scalar,
    B: Mechanics<T>,
    M: Bristle<T, Deflection = T>,
    F: Fn(Acting<'_, T>),
{
    fn states(&self) -> usize {
        self.scales.len()
    }

    fn contacts(&self) -> usize {
        self.mechanism.sizes().1
    }

    fn rate(&self, time: T, state: &[T], branches: &[Branch], rate: &mut [T]) {
        let (n, _) = self.mechanism.sizes();
        let (position, velocity) = (&state[..n], &state[n..2 * n]);
        let (moving, deflecting) = rate.split_at_mut(2 * n);
        let (to_position, force) = moving.split_at_mut(n);
        force.fill(T::zero());
        let [prescribed, load] = self.acting(time, state, force);
        for (k, (branch, rate)) in branches.iter().zip(deflecting).enumerate() {
            let row = self.mechanism.row(k);
            let surface = branch.of(along(row, velocity) + prescribed[k]);
            let friction = self.contact(k).response_under(load[k], surface, state[2 * n + k]);
            *rate = friction.rate;
            spread(row, -friction.force, force);
        }
        to_position.copy_from_slice(velocity);
        self.mechanism.accelerate(&self.factors, [position, velocity], force);
    }

    fn sliding_velocities(&self, time: T, state: &[T], velocities: &mut [T]) {
        let (n, _) = self.mechanism.sizes();
        let [prescribed, _] = self.acting(time, state, &mut vec![T::zero(); n]);
        for (k, (sliding, belt)) in velocities.iter_mut().zip(prescribed).enumerate() {
            *sliding = along(self.mechanism.row(k), &state[n..2 * n]) + belt;
        }
    }

    fn switching_functions(
        &self,
        time: T,
        state: &[T],
        branches: &[Branch],
        tell: &mut dyn FnMut(T),
    ) {
        let (n, m) = self.mechanism.sizes();
        let zero = T::zero();
        // Most models have none, and need no forces.
        if (0..m).all(|k| self.contact(k).switching_function(zero, zero).is_none()) {
            return;
        }
        let [prescribed, load] = self.acting(time, state, &mut vec![zero; n]);
        for k in 0..m {
            let sliding = along(self.mechanism.row(k), &state[n..2 * n]) + prescribed[k];
            let contact = self.contact(k);
            let scale = load[k] / contact.reference_load();
            let surface = Surface::scaled(branches[k].of(sliding), scale);
            contact.model().switching_function(surface, state[2 * n + k]).map(&mut *tell);
        }
    }

    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        let next = self.kinks.partition_point(|&kink| kink <= time);
        self.kinks.get(next).copied().filter(|&kink| kink < towards)
    }

    fn longest_step(&self) -> Option<T> {
        self.longest_step
    }

    fn scales(&self, scales: &mut [T]) {
        scales.copy_from_slice(&self.scales);
    }
}

/// M v̇ = f − … of a mechanism.
pub(crate) trait Mechanics<T> {
    /// The numbers of coordinates and of contacts.
    fn sizes(&self) -> (usize, usize);

    /// The row of a contact.
    fn row(&self, contact: usize) -> &[(usize, T)];

    /// What [`Mechanics::accelerate`] needs and does not change.
    fn factors(&self) -> Vec<T> {
        Vec::new()
    }

    /// The accelerations at x and v, in the place of applied forces less friction.
    fn accelerate(&self, factors: &[T], motion: [&[T]; 2], force: &mut [T]);
}

impl<T: Scalar, R: Rows<T>, S: Storage<T>> Mechanics<T> for LinearMechanism<T, R, S> {
    fn sizes(&self) -> (usize, usize) {
        (self.coordinates, self.rows.contacts())
    }

    fn row(&self, contact: usize) -> &[(usize, T)] {
        self.rows.row(contact)
    }

    fn factors(&self) -> Vec<T> {
        let mut mass = self.matrix(Which::Mass).to_vec();
        band::factor(self.width(), &mut mass, |_, _| ());
        mass
    }

    fn accelerate(&self, factors: &[T], motion: [&[T]; 2], force: &mut [T]) {
        let matrices = [Which::Stiffness, Which::Damping].map(|which| self.matrix(which));
        band::subtract_products(self.width(), matrices, motion, force);
        band::solve(self.width(), factors, force);
    }
}

impl<T: Scalar, R: Rows<T>, S: Storage<T>> Mechanics<T> for Arm<T, R, S> {
    fn sizes(&self) -> (usize, usize) {
        self.mechanism.sizes()
    }

    fn row(&self, contact: usize) -> &[(usize, T)] {
        self.mechanism.row(contact)
    }

    fn accelerate(&self, _: &[T], [position, velocity]: [&[T]; 2], force: &mut [T]) {
        let n = position.len();
        let mut numbers = vec![T::zero(); (n + KEPT + ROOM) * n];
        let (mass, rest) = numbers.split_at_mut(n * n);
        let mut room = Room::new(rest, n, 0);
        room.kept.copy_from_slice(self.kept());
        room.predict([position, velocity, velocity], T::zero(), self.gravity);
        room.torque.copy_from_slice(force);
        room.assemble(mass, force);
        let damping = self.mechanism.matrix(Which::Damping).iter().skip(n - 1).step_by(n);
        for ((force, &damping), &v) in force.iter_mut().zip(damping).zip(velocity) {
            *force -= damping * v;
        }
        band::factor_and_solve(n, mass, force);
    }
}

impl<T: Scalar> Mechanics<T> for ElasticJoint<T> {
    fn sizes(&self) -> (usize, usize) {
        (2, 2)
    }

    fn row(&self, contact: usize) -> &[(usize, T)] {
        self.rows.row(contact)
    }

    fn accelerate(&self, _: &[T], motion: [&[T]; 2], force: &mut [T]) {
        let [stretch, rate] = motion.map(|x| x[0] - x[1]);
        let ElasticJointParameters { inertias: [motor, link], damping, .. } = self.parameters();
        let torque = self.mean_torque(stretch, stretch) + damping * rate;
        force.copy_from_slice(&[(force[0] - torque) / motor, (force[1] + torque) / link]);
    }
}
