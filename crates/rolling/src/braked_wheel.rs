//! A wheel under brake and drive torque that carries its part of a vehicle: from rolling to
//! lock-up and to standstill.
//!
//! m v̇_x = f − F,  J ω̇ = R F − T + τ,  slip velocity v = v_x − ωR,  rolling speed U = ωR
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | m, J, R | mass carried, moment of inertia, effective rolling radius | kg, kg m², m |
//! | v_x, ω | speed of the vehicle, angular velocity of the wheel | m/s, rad/s |
//! | F | friction force of the tyre ([`Patch`](crate::Patch)), slows the car if > 0 | N |
//! | T | torque of the brake, a [`Contact`] in units of torque | N m |
//! | f, τ | other forward force (grade, wind), drive torque | N, N m |
//!
//! The brake is a friction contact like any other. Its bristles stand for the elasticity of pads,
//! caliper and suspension: a locked wheel rests on them, and locking needs no case distinction.
//!
//! # Steering
//!
//! On a tyre of two axes ([`CombinedPatch`](crate::CombinedPatch)) the wheel also slips
//! sideways, with a lateral velocity v_y that is given: v_x tan α at a slip angle α. The axes are
//! those of the wheel. F_y and the self-aligning moment M_z act on the suspension, and F = F_x has
//! to share the friction with F_y.
//!
//! # A step
//!
//! Over a step of length h tyre and brake are sources and dampers, F̄ = a + c v̄ and T̄ = b + d ω̄
//! with the mean velocities of the step: a [`LinearMechanism`] of mass and wheel with two
//! contacts.
//! Steps of every length keep the balance
//!
//! h (f v̄_x + τ ω̄ + F̄_y v_y)
//!   = Δ(½ m v_x² + ½ J ω²) + ΔW_tyre + D_volume + D_outlet + ΔW_brake + D_brake,
//!
//! where W is stored energy and D dissipated energy. D_brake includes what leaves with a change of
//! the brake's normal force ([`Contact::reload`]). With FrBD, a pressure that does not rise and
//! f = τ = v_y = 0 the total energy never grows.
//!
//! Source: the balances are those of the single-wheel (quarter-car) model of braking, e.g. C.
//! Canudas-de-Wit et al., "Dynamic friction models for road/tire longitudinal interaction",
//! Vehicle System Dynamics 39 (2003); the step is derived here.

use crate::{Motion, Tyre};
use bristle::companion::Companion;
use bristle::parameter::{Checked, Named};
use bristle::scalar::{is_zero, lit};
use bristle::{Bristle, Contact, Scalar};
use bristle_mechanism::{self as mechanism, LinearMechanism, Matrices, Sources, Structure};

/// How far a wheel may rock back, in lengths of its patch: its bristles stay where they are
/// meanwhile, an error of that part of the patch.
const ROCKING: f64 = 0.25;

/// Parameters of [`BrakedWheel`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct BrakedWheelParameters<T: Scalar, P, K> {
    /// The tyre, a patch in motion with its bristles as they are at the beginning: of one axis
    /// ([`Patch::exact`](crate::Patch::exact)), or of two for a wheel that steers
    /// ([`CombinedPatch`](crate::CombinedPatch)).
    pub tyre: P,
    /// The brake: friction over the angular velocity, with the units of the model to match. The
    /// capacity of the brake is μ(ω) times the normal force, so that with μ in metres the normal
    /// force is that of the pads, and with μ near 1 it is a torque \[N m\]. Every step changes the
    /// normal force to [`WheelLoads::brake_normal_force`]; what is given here is the one from which
    /// the first step changes it: zero for a brake that is not applied. Then tell the normal force
    /// at which its stiffness was measured ([`Contact::measured_at`]), or the first one that is not
    /// zero counts as such.
    pub brake: Contact<T, K>,
    /// Mass m \[kg\] that the wheel slows down, positive.
    pub mass: T,
    /// Moment of inertia J [kg m²] of the wheel and what turns with it, positive.
    pub inertia: T,
    /// Effective rolling radius R \[m\], positive.
    pub radius: T,
    /// Speed v_x [m/s] at the beginning.
    pub speed: T,
    /// Angular velocity ω [rad/s] at the beginning, zero or positive; a free wheel has v_x/R.
    pub angular_velocity: T,
}

/// Forces and torques on a [`BrakedWheel`] over a step, and its steering: means over the step, or
/// values at its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct WheelLoads<T> {
    /// Normal force of the brake's contact, zero or positive: the capacity of the brake over μ.
    pub brake_normal_force: T,
    /// Drive torque τ [N m]; a negative one turns the wheel backwards, which the brake never does.
    pub drive_torque: T,
    /// Force f \[N\] on the vehicle other than the tyre's, positive forward: grade, wind.
    pub force: T,
    /// Lateral velocity v_y [m/s] of the wheel over the ground, in the wheel's axes: v_x tan α at
    /// a slip angle α. Zero on a tyre of one axis.
    #[doc(alias = "slip_angle")]
    pub lateral_velocity: T,
}

impl<T: Scalar> WheelLoads<T> {
    /// The brake alone.
    pub fn braking(brake_normal_force: T) -> Self {
        let zero = T::zero();
        Self { brake_normal_force, drive_torque: zero, force: zero, lateral_velocity: zero }
    }
}

/// The motion of a [`BrakedWheel`], and what acted on it over the last step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelState<T> {
    /// Time \[s\] since the beginning.
    pub time: T,
    /// Way of the vehicle \[m\].
    pub position: T,
    /// Angle of the wheel \[rad\].
    pub angle: T,
    /// Speed v_x [m/s].
    pub speed: T,
    /// Angular velocity ω [rad/s].
    pub angular_velocity: T,
    /// Deflection of the brake's bristle \[rad\].
    pub brake_deflection: T,
    /// How far the wheel has rocked back from where it had rolled to, in lengths of the patch
    /// \[–\].
    pub rolled_back: T,
    /// Friction force of the tyre F̄ \[N\], averaged over the last step.
    pub force: T,
    /// Lateral friction force F̄_y \[N\], averaged over the last step, positive against v_y > 0.
    pub lateral_force: T,
    /// Torque of the brake T̄ [N m], averaged over the last step.
    pub brake_torque: T,
}

/// A wheel with a tyre of bristles and a brake of one bristle, and the mass that it carries. It is
/// not a [`System`](bristle::ode::System) but takes steps of its own, passive ones.
///
/// A full brake application at 72 km/h, with steps of 5 ms:
///
/// ```
/// use bristle_rolling::{Patch, PatchParameters, PolynomialExponential, Segment};
/// use bristle_rolling::{BrakedWheel, BrakedWheelParameters, WheelLoads};
/// use bristle::{Bristle, FrBd, paper};
/// use bristle::curve::{Coulomb, CoulombParameters, Stribeck};
/// use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
///
/// let curve = Stribeck::new(paper::TYRE_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE)?;
/// let tyre = Patch::new(PatchParameters {
///     model: FrBd::new(curve, bristle),
///     length: bristle_rolling::TYRE_LENGTH,
///     pressure: PolynomialExponential::constant(),
/// })?
/// .under_load(4000.0)?; // N
/// // Near 1 N m of torque per newton: the normal force is the capacity in N m.
/// let pads = Coulomb::new(CoulombParameters { dynamic_coefficient: 1.0, viscous_friction: 0.0 })?;
/// // 1/rad, s/rad
/// let flexible = KelvinVoigtParameters { micro_stiffness: 20.0, micro_damping: 0.1 };
/// let mut wheel = BrakedWheel::new(BrakedWheelParameters {
///     tyre: tyre.exact([[Segment::default(); 100]])?,
///     brake: FrBd::new(pads, KelvinVoigt::new(flexible)?).under_load(0.0)?.measured_at(1500.0)?,
///     mass: 400.0,
///     inertia: 1.0,
///     radius: 0.3,
///     speed: 20.0,
///     angular_velocity: 20.0 / 0.3,
/// })?;
/// while wheel.state().speed > 1e-3 {
///     let ramp = 5000.0 * wheel.state().time; // N m/s
///     let pressed = WheelLoads::braking(if ramp < 1500.0 { ramp } else { 1500.0 });
///     wheel.step(pressed, 5e-3)?;
/// }
/// // Locked on a road that is worse the faster one slides.
/// assert!(wheel.state().position > 40.0 && wheel.state().position < 80.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Accuracy
///
/// Speeds and angles are of second order in h in smooth motion. Each step is solved twice: with the
/// coefficients at the extrapolated velocities, then with those at the mean velocities found, which
/// takes the error to a tenth.
///
/// A wheel that locks oscillates on the bristles of its brake. Steps longer than that oscillation
/// replace it by one of their own length, which dies away in about ten steps.
///
/// # Rolling backwards
///
/// The patch rolls forward only, U ≥ 0. A wheel that rocks back, as it does when it comes to rest,
/// keeps its tyre's bristles where they are until it has rolled forward again by as much. Rolling
/// back by more than a quarter of the patch is refused (`rolled_back`), and the wheel stays as it
/// was before that step. A vehicle that slides backwards, v_x < 0, on a locked wheel is fine.
#[derive(Debug, Clone)]
pub struct BrakedWheel<T: Scalar, P, K> {
    tyre: P,
    brake: Companion<T, K>,
    body: Body<T>,
    radius: T,
    state: WheelState<T>,
    /// Accelerations over the last step [m/s², rad/s²].
    acceleration: (T, T),
}

/// Mass and wheel, with contacts of the slip velocity and of the angular velocity.
type Body<T> = LinearMechanism<T, [[(usize, T); 2]; 2], [T; NUMBERS]>;

const NUMBERS: usize = Structure::Diagonal.storage(2, 2);

impl<T: Scalar, P: Tyre<T>, K: Bristle<T, Deflection = T>> BrakedWheel<T, P, K> {
    /// Checks the parameters. The bristle of a brake that is under load begins with the deflection
    /// of a disc that has been turning.
    ///
    /// # Errors
    ///
    /// Refuses a mass, a moment of inertia or a radius that is not positive, a speed that is not
    /// finite, and an angular velocity that is negative.
    pub fn new(parameters: BrakedWheelParameters<T, P, K>) -> Checked<Self> {
        let BrakedWheelParameters { tyre, brake, mass, inertia, radius, speed, angular_velocity } =
            parameters;
        let angular_velocity = Named("angular_velocity", angular_velocity).non_negative()?;
        let (zero, one) = (T::zero(), T::one());
        let state = WheelState {
            time: zero,
            position: zero,
            angle: zero,
            speed: Named("speed", speed).finite()?,
            angular_velocity,
            brake_deflection: brake.stationary(angular_velocity),
            rolled_back: zero,
            force: zero,
            lateral_force: zero,
            brake_torque: zero,
        };
        let mass = [Named("mass", mass).positive()?, Named("inertia", inertia).positive()?];
        let radius = Named("radius", radius).positive()?;
        let rows = [[(0, one), (1, -radius)], [(1, one), (1, zero)]];
        let (structure, mass) = (Structure::Diagonal, &mass[..]);
        let matrices = Matrices { structure, mass, damping: &[], stiffness: &[] };
        Ok(Self {
            tyre,
            brake: brake.companion(angular_velocity)?,
            body: LinearMechanism::new(&matrices, rows, [zero; NUMBERS])?,
            radius,
            state,
            acceleration: (zero, zero),
        })
    }

    /// The motion.
    pub fn state(&self) -> WheelState<T> {
        self.state
    }

    /// The tyre.
    pub fn tyre(&self) -> &P {
        &self.tyre
    }

    /// The tyre, for a normal force that varies
    /// ([`ExactPatch::reload`](crate::ExactPatch::reload)).
    pub fn tyre_mut(&mut self) -> &mut P {
        &mut self.tyre
    }

    /// The brake.
    pub fn brake(&self) -> &Contact<T, K> {
        self.brake.contact()
    }

    /// Slip velocity v = v_x − ωR [m/s], to a rounding of the speed.
    pub fn slip_velocity(&self) -> T {
        self.state.speed - self.state.angular_velocity * self.radius
    }

    /// Slip of braking (v_x − ωR)/v_x = s/(1 + s) \[–\] with s = v/U of [`Motion::slip_ratio`]: 0
    /// for a wheel that rolls freely, 1 for a locked one. 0 if the vehicle stands; of little use
    /// near that.
    pub fn braking_slip(&self) -> T {
        if is_zero(self.state.speed) { T::zero() } else { self.slip_velocity() / self.state.speed }
    }

    /// The self-aligning moment M_z [N m] of the tyre as it is, at a lateral velocity [m/s]: it
    /// turns a wheel with v_y > 0 into the direction in which it moves if it is positive. Zero on a
    /// tyre of one axis. For the time it takes see
    /// [`ExactPatch::moment`](crate::ExactPatch::moment).
    pub fn aligning_moment(&self, lateral_velocity: T) -> T {
        self.tyre.aligning_moment([self.slip_velocity(), lateral_velocity])
    }

    /// ½ m v_x² + ½ J ω² \[J\].
    pub fn kinetic_energy(&self) -> T {
        let WheelState { position, angle, speed, angular_velocity, .. } = self.state;
        self.body.energy(&[position, angle], &[speed, angular_velocity])
    }

    /// Energy stored in the bristles of tyre and brake \[J\]. It takes time in proportion to the
    /// number of segments.
    pub fn stored_energy(&self) -> T {
        self.tyre.stored_energy() + self.brake.contact().stored_energy(self.state.brake_deflection)
    }

    /// A step of length h ≥ 0 \[s\]; returns the motion at its end.
    ///
    /// # Errors
    ///
    /// Refuses loads and a duration that are not finite or negative, a lateral velocity on a tyre
    /// of one axis, and a wheel that rolls backwards; the wheel is as it was.
    pub fn step(&mut self, loads: WheelLoads<T>, duration: T) -> Checked<WheelState<T>> {
        Named("brake_normal_force", loads.brake_normal_force).non_negative()?;
        Named("drive_torque", loads.drive_torque).finite()?;
        Named("force", loads.force).finite()?;
        Named("lateral_velocity", loads.lateral_velocity).finite()?;
        let duration = Named("duration", duration).non_negative()?;
        let (load, velocity) = (self.brake.contact().normal_force(), self.state.angular_velocity);
        let pressed = loads.brake_normal_force;
        let held = self.brake.reload(pressed, velocity, self.state.brake_deflection)?.deflection;
        let stepped = self.stepped(loads, held, duration);
        if stepped.is_err() {
            // The brake is as it was, too.
            let _ = self.brake.reload(load, velocity, held)?;
        }
        stepped
    }

    /// A step from a deflection of the brake that its normal force holds.
    fn stepped(
        &mut self,
        loads: WheelLoads<T>,
        brake_deflection: T,
        duration: T,
    ) -> Checked<WheelState<T>> {
        let half = lit::<T>(0.5) * duration;
        let (before, radius, moves) = (self.state, self.radius, duration > T::zero());
        let (body, length) = (&mut self.body, self.tyre.length());
        // Forward beyond where it has been.
        let owed = if moves { before.rolled_back * length / duration } else { T::zero() };
        let motion = |slip_velocity: T, spin: T| Motion {
            slip_velocity: [slip_velocity, loads.lateral_velocity],
            rolling_speed: T::zero().larger(spin * radius - owed),
        };
        let (speed_rate, angular_rate) = self.acceleration;
        let mut spin = before.angular_velocity + half * angular_rate;
        let mut slip = before.speed + half * speed_rate - spin * radius;
        // First with the coefficients at the extrapolated velocities.
        let pads = self.brake.step(spin, brake_deflection, duration);
        let pads = [pads.bias(), pads.damping()];
        self.tyre.roll(motion(slip, spin), duration, |tyre| {
            ([slip, spin], _) = before.moved(body, &loads, [tyre, pads], duration)?;
            Ok(None)
        })?;
        // Then with those at the mean velocities found.
        let step = self.brake.step(spin, brake_deflection, duration);
        let pads = [step.bias(), step.damping()];
        let mut after = before;
        let rolled = self.tyre.roll(motion(slip, spin), duration, |tyre| {
            ([slip, spin], after) = before.moved(body, &loads, [tyre, pads], duration)?;
            Named("speed", after.speed).finite()?;
            Named("angular_velocity", after.angular_velocity).finite()?;
            let rolled_back = before.rolled_back - spin * radius * duration / length;
            after.rolled_back = T::zero().larger(rolled_back);
            Named("rolled_back", after.rolled_back).at_most("what a patch takes", lit(ROCKING))?;
            Ok(Some(slip))
        })?;

        let pads = step.commit(spin);
        self.state.brake_deflection = pads.deflection;
        if let (true, Some([force, lateral_force])) = (moves, rolled) {
            let turned = after.angular_velocity - before.angular_velocity;
            self.acceleration = ((after.speed - before.speed) / duration, turned / duration);
            let (brake_deflection, brake_torque) = (pads.deflection, pads.force);
            self.state =
                WheelState { brake_deflection, force, lateral_force, brake_torque, ..after };
        }
        Ok(self.state)
    }
}

impl<T: Scalar> WheelState<T> {
    /// The mean slip velocity and angular velocity of a step, and the motion after it, with bias
    /// and damping of the tyre and of the brake.
    fn moved(
        self,
        body: &mut Body<T>,
        loads: &WheelLoads<T>,
        [tyre, brake]: [[T; 2]; 2],
        duration: T,
    ) -> Checked<([T; 2], Self)> {
        let mut position = [self.position, self.angle];
        let mut velocity = [self.speed, self.angular_velocity];
        let mut means = [0, 1].map(|contact| body.sliding_velocity(contact, &velocity));
        let motion = mechanism::Motion { position: &mut position, velocity: &mut velocity };
        let ([bias, damping], sliding) =
            ([[tyre[0], brake[0]], [tyre[1], brake[1]]], &mut means[..]);
        let sources = Sources { bias: &bias, damping: &damping, sliding };
        body.advance(duration, &[loads.force, loads.drive_torque], motion, sources)?;
        let ([position, angle], [speed, angular_velocity]) = (position, velocity);
        let time = self.time + duration;
        Ok((means, Self { time, position, angle, speed, angular_velocity, ..self }))
    }
}
