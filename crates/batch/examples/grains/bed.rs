//! Spheres between two walls of spheres, periodic along x and y: linear springs along the normals,
//! bristles of two axes across them.
//!
//! Every pair that is near has a slot. A pair that does not touch has the normal force zero; touch
//! and loss of touch are changes of the load. Bristles are kept in two axes of the tangential plane
//! and projected where it tilts, which only takes energy away.

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle_batch::{Batch, BatchError, CommitInput, PassiveOutput, ReloadInput, StepInput};
use bristle_plane::PlaneFrBd;
use nalgebra::Vector3;

type Vector = Vector3<f64>;

/// Glass: mean radius [m], spread of the radii, density [kg/m³].
const RADIUS: f64 = 1e-3;
const SPREAD: f64 = 0.02;
const DENSITY: f64 = 2500.0;
/// Along the normal: stiffness [N/m] and damping [N s/m], a tenth of the critical one.
const STIFFNESS: f64 = 2e3;
const DAMPING: f64 = 0.03;
/// By what the lattice is compressed, over its spacing.
const COMPRESSION: f64 = 0.012;
/// The friction: μ from 0.5 to 0.4, and bristles about as stiff as the normal.
pub(crate) const CURVE: StribeckParameters<f64> = StribeckParameters {
    static_coefficient: 0.5,
    dynamic_coefficient: 0.4,
    stribeck_velocity: 0.1,
    stribeck_exponent: 2.0,
    viscous_friction: 0.0,
};
const BRISTLE: KelvinVoigtParameters<f64> =
    KelvinVoigtParameters { micro_stiffness: 3e4, micro_damping: 0.1 };
/// The load at which the bristles have this stiffness [N].
const REFERENCE_LOAD: f64 = 0.05;
/// Distance beyond touch within which a pair has a slot [m].
const SKIN: f64 = 0.06 * RADIUS;
/// How often the mean velocities are put into the friction again within a step.
const SWEEPS: usize = 3;

/// A sphere.
#[derive(Debug, Clone, Copy)]
struct Grain {
    radius: f64,
    /// 1/mass and 1/moment of inertia; zero in a wall.
    mobility: [f64; 2],
    place: Vector,
    /// Velocity, and angular velocity.
    motion: [Vector; 2],
    /// Its means over the step.
    mean: [Vector; 2],
    /// Where it was when slots were last looked for.
    listed: Vector,
}

/// Two grains that are near, and the axes of their contact.
#[derive(Debug, Clone, Copy)]
struct Pair {
    grains: [u32; 2],
    normal: Vector,
    across: [Vector; 2],
    distance: f64,
}

/// What a step reports.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Report {
    /// Pairs that touch, and those that began and ceased to.
    pub(crate) contacts: usize,
    pub(crate) born: usize,
    pub(crate) lost: usize,
    /// Work of the grains on the bristles over the step, and energy stored in them at its end [J].
    pub(crate) work: f64,
    pub(crate) stored: f64,
    /// Pressure on the walls and shear stress [Pa].
    pub(crate) pressure: f64,
    pub(crate) shear: f64,
}

/// All spheres and their contacts.
pub(crate) struct Bed {
    grains: Vec<Grain>,
    batch: Batch<'static, f64, 2>,
    pairs: Vec<Pair>,
    /// Normal forces of the last step and of this one.
    loads: [Vec<f64>; 2],
    deflections: Vec<f64>,
    velocities: Vec<f64>,
    /// Shares, biases and dampings.
    passive: [Vec<f64>; 3],
    dissipated: Vec<f64>,
    /// Sides along x and y, height of the top wall over the bottom one [m].
    size: Vector,
}

impl Bed {
    /// A face-centred lattice of so many cells along each side.
    pub(crate) fn new(cells: [usize; 3]) -> Result<Self, BatchError> {
        let spacing = RADIUS * 8.0_f64.sqrt() * (1.0 - COMPRESSION);
        let size = Vector::from_fn(|i, _| cells[i] as f64 * spacing);
        let mut draw = 9429_u64;
        let mut grains = Vec::new();
        for layer in 0..2 * cells[2] {
            for row in 0..2 * cells[1] {
                for column in (0..2 * cells[0]).filter(|column| (column + row + layer) % 2 == 0) {
                    draw = draw.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    let share = (draw >> 11) as f64 / (1_u64 << 53) as f64;
                    let radius = RADIUS * (1.0 + SPREAD * (2.0 * share - 1.0));
                    let mass = DENSITY * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
                    let walls = layer == 0 || layer == 2 * cells[2] - 1;
                    let mobility = if walls { 0.0 } else { 1.0 / mass };
                    let place =
                        Vector::new(column as f64, row as f64, layer as f64) * spacing / 2.0;
                    let still = [Vector::zeros(); 2];
                    grains.push(Grain {
                        radius,
                        mobility: [mobility, mobility / (0.4 * radius * radius)],
                        place,
                        motion: still,
                        mean: still,
                        listed: place,
                    });
                }
            }
        }
        let friction = PlaneFrBd::isotropic(Stribeck::new(CURVE)?, KelvinVoigt::new(BRISTLE)?);
        let batch = Batch::of(&friction)?.measured_at(REFERENCE_LOAD)?;
        let none = || Vec::new();
        let mut bed = Self {
            grains,
            batch,
            pairs: Vec::new(),
            loads: [none(), none()],
            deflections: none(),
            velocities: none(),
            passive: [none(), none(), none()],
            dissipated: none(),
            size,
        };
        bed.list();
        Ok(bed)
    }

    /// Spreads the batches over rayon's threads.
    #[cfg(feature = "rayon")]
    pub(crate) fn in_parallel(self) -> Self {
        Self { batch: self.batch.in_parallel(), ..self }
    }

    /// Adds a shear flow [1/s].
    pub(crate) fn shear(&mut self, rate: f64) {
        for grain in &mut self.grains {
            grain.motion[0].x += rate * (grain.place.z - 0.5 * self.size.z);
        }
    }

    /// The number of spheres.
    pub(crate) fn grains(&self) -> usize {
        self.grains.len()
    }

    /// From one grain to the nearest image of another.
    fn between(&self, [first, second]: [Vector; 2]) -> Vector {
        let mut apart = second - first;
        for axis in 0..2 {
            apart[axis] -= self.size[axis] * (apart[axis] / self.size[axis]).round();
        }
        apart
    }

    /// Looks for all near pairs, in the order of their grains; those that had a slot keep their
    /// loads and deflections.
    fn list(&mut self) {
        let reach = 2.0 * RADIUS * (1.0 + SPREAD) + SKIN;
        let counts = [0, 1].map(|axis| (self.size[axis] / reach) as usize);
        let floors = (self.size.z / reach) as usize + 2;
        let cell = |place: &Vector| {
            let [x, y] = [0, 1].map(|axis| {
                let share = (place[axis] / self.size[axis]).rem_euclid(1.0);
                ((share * counts[axis] as f64) as usize).min(counts[axis] - 1)
            });
            [x, y, ((place.z / reach + 1.0).max(0.0) as usize).min(floors - 1)]
        };
        let mut members = vec![Vec::new(); counts[0] * counts[1] * floors];
        let index = |[x, y, z]: [usize; 3]| (z * counts[1] + y) * counts[0] + x;
        for (number, grain) in self.grains.iter_mut().enumerate() {
            grain.listed = grain.place;
            members[index(cell(&grain.place))].push(number as u32);
        }
        let mut found = Vec::with_capacity(self.pairs.len());
        for (number, grain) in self.grains.iter().enumerate() {
            let [x, y, z] = cell(&grain.place);
            let from = found.len();
            for at in 0..27 {
                let shift =
                    |from: usize, step: usize, count: usize| (from + step + count - 1) % count;
                let floor = z + at / 9;
                if floor == 0 || floor > floors {
                    continue;
                }
                let (x, y) = (shift(x, at % 3, counts[0]), shift(y, at / 3 % 3, counts[1]));
                for &other in &members[index([x, y, floor - 1])] {
                    let second = &self.grains[other as usize];
                    let near = grain.radius + second.radius + SKIN;
                    let apart = self.between([grain.place, second.place]);
                    // A wall does not touch itself.
                    let moves = grain.mobility[0] + second.mobility[0] > 0.0;
                    if other as usize > number && moves && apart.norm_squared() < near * near {
                        found.push([number as u32, other]);
                    }
                }
            }
            found[from..].sort_unstable();
        }
        let (old, count) = (std::mem::take(&mut self.pairs), found.len());
        let (mut loads, mut deflections) = (vec![0.0; count], vec![0.0; 2 * count]);
        let mut known = old.iter().enumerate().peekable();
        for (slot, grains) in found.into_iter().enumerate() {
            let zero = Vector::zeros();
            let mut pair = Pair { grains, normal: zero, across: [zero; 2], distance: 0.0 };
            while known.next_if(|(_, old)| old.grains < grains).is_some() {}
            if let Some((from, old)) = known.next_if(|(_, old)| old.grains == grains) {
                pair = *old;
                loads[slot] = self.loads[0][from];
                deflections[slot] = self.deflections[from];
                deflections[count + slot] = self.deflections[self.deflections.len() / 2 + from];
            }
            self.pairs.push(pair);
        }
        self.loads = [loads, vec![0.0; count]];
        self.deflections = deflections;
        self.velocities = vec![0.0; 2 * count];
        self.passive = [(); 3].map(|()| vec![0.0; 2 * count]);
        self.dissipated = vec![0.0; count];
    }

    /// Geometry, normal forces and projected deflections, at the middle of the step.
    fn touch(&mut self, duration: f64) {
        let count = self.pairs.len();
        for slot in 0..count {
            let Pair { grains: [i, j], across: before, .. } = self.pairs[slot];
            let [first, second] = [i, j].map(|number| &self.grains[number as usize]);
            let middle =
                [first, second].map(|grain| grain.place + 0.5 * duration * grain.motion[0]);
            let apart = self.between(middle);
            let distance = apart.norm();
            let overlap = first.radius + second.radius - distance;
            let normal = apart / distance;
            let approach = (first.motion[0] - second.motion[0]).dot(&normal);
            let load = if overlap > 0.0 { STIFFNESS * overlap + DAMPING * approach } else { 0.0 };
            self.loads[1][slot] = load.max(0.0);
            // Two axes at right angles to the normal, by Duff et al. (JCGT 6, 2017).
            let sign = 1.0_f64.copysign(normal.z);
            let (a, b) = (-1.0 / (sign + normal.z), normal.x * normal.y);
            let across = [
                Vector::new(1.0 + sign * normal.x * normal.x * a, sign * b * a, -sign * normal.x),
                Vector::new(b * a, sign + normal.y * normal.y * a, -normal.y),
            ];
            let [x, y] = [slot, count + slot].map(|at| self.deflections[at]);
            let bent = before[0] * x + before[1] * y;
            [self.deflections[slot], self.deflections[count + slot]] = across.map(|t| t.dot(&bent));
            self.pairs[slot] = Pair { grains: [i, j], normal, across, distance };
        }
    }

    /// Sliding velocities of the contacts, from those of the grains.
    fn slide(&mut self, motion: impl Fn(&Grain) -> [Vector; 2]) {
        let count = self.pairs.len();
        for (slot, pair) in self.pairs.iter().enumerate() {
            let [first, second] = pair.grains.map(|number| &self.grains[number as usize]);
            let ([v, spin], [w, other]) = (motion(first), motion(second));
            let turning = spin * first.radius + other * second.radius;
            let velocity = v - w + turning.cross(&pair.normal);
            self.velocities[slot] = velocity.dot(&pair.across[0]);
            self.velocities[count + slot] = velocity.dot(&pair.across[1]);
        }
    }

    /// The friction on the first grain of a contact, against its sliding.
    fn friction(&self, slot: usize) -> [f64; 2] {
        let [_, biases, dampings] = &self.passive;
        [slot, self.pairs.len() + slot].map(|at| biases[at] + dampings[at] * self.velocities[at])
    }

    /// Mean motions under all forces, which are added in the order of the slots.
    fn push(&mut self, duration: f64, forces: &mut Vec<[f64; 2]>) {
        forces.clear();
        forces.extend((0..self.pairs.len()).map(|slot| self.friction(slot)));
        self.grains.iter_mut().for_each(|grain| grain.mean = grain.motion);
        let slots = self.pairs.iter().zip(&self.loads[1]).zip(&*forces);
        for ((pair, &load), &[x, y]) in slots {
            let friction = pair.across[0] * x + pair.across[1] * y;
            let force = pair.normal * load + friction;
            let torque = pair.normal.cross(&friction);
            for (number, sign) in pair.grains.into_iter().zip([-0.5, 0.5]) {
                let grain = &mut self.grains[number as usize];
                grain.mean[0] += force * (sign * duration * grain.mobility[0]);
                grain.mean[1] -= torque * (0.5 * duration * grain.radius * grain.mobility[1]);
            }
        }
    }

    /// One step, with the walls sheared at a rate [1/s].
    pub(crate) fn step(&mut self, rate: f64, duration: f64) -> Result<Report, BatchError> {
        let moved = |grain: &Grain| (grain.place - grain.listed).norm();
        if self.grains.iter().map(moved).fold(0.0, f64::max) > 0.4 * SKIN {
            self.list();
        }
        for grain in self.grains.iter_mut().filter(|grain| grain.mobility[0] == 0.0) {
            grain.motion[0].x = rate * (grain.place.z - 0.5 * self.size.z);
        }
        self.touch(duration);
        self.slide(|grain| grain.motion);
        let [before, after] = &self.loads;
        let change = ReloadInput { before, after, velocities: &self.velocities };
        let reloaded = self.batch.reload(change, &mut self.deflections, &mut self.dissipated)?;
        let input = StepInput {
            velocities: &self.velocities,
            normal_forces: after,
            deflections: &mut self.deflections,
        };
        let [shares, biases, dampings] = &mut self.passive;
        let begun =
            self.batch.companions(input, duration, PassiveOutput { shares, biases, dampings })?;
        let mut forces = Vec::with_capacity(self.pairs.len());
        for _ in 0..SWEEPS {
            self.push(duration, &mut forces);
            self.slide(|grain| grain.mean);
        }
        let found = CommitInput {
            shares: &self.passive[0],
            velocities: &self.velocities,
            normal_forces: &self.loads[1],
        };
        let ended = self.batch.commit(found, duration, &mut self.deflections)?;
        assert!(reloaded.is_finite() && begun.is_finite() && ended.is_finite());
        for grain in &mut self.grains {
            grain.place += grain.mean[0] * duration;
            let ends = [0, 1].map(|k| grain.mean[k] * 2.0 - grain.motion[k]);
            grain.motion = ends;
        }
        let report = self.report(duration, &forces);
        self.loads.swap(0, 1);
        Ok(report)
    }

    fn report(&self, duration: f64, forces: &[[f64; 2]]) -> Report {
        let (count, mut report) = (self.pairs.len(), Report::default());
        let volume = self.size.x * self.size.y * self.size.z;
        for (slot, (pair, &[x, y])) in self.pairs.iter().zip(forces).enumerate() {
            let (before, load) = (self.loads[0][slot], self.loads[1][slot]);
            report.contacts += usize::from(load > 0.0);
            report.born += usize::from(load > 0.0 && before == 0.0);
            report.lost += usize::from(load == 0.0 && before > 0.0);
            let [v, w] = [slot, count + slot].map(|at| self.velocities[at]);
            report.work += duration * (x * v + y * w);
            let [z, u] = [slot, count + slot].map(|at| self.deflections[at]);
            report.stored += 0.5 * REFERENCE_LOAD * BRISTLE.micro_stiffness * (z * z + u * u);
            let force = pair.normal * load + pair.across[0] * x + pair.across[1] * y;
            let branch = pair.normal.z * pair.distance / volume;
            report.pressure += force.z * branch;
            report.shear -= force.x * branch;
        }
        report
    }

    /// Friction over static friction of all contacts that touch, at the last load.
    pub(crate) fn mobilised(&self) -> impl Iterator<Item = f64> {
        let loads = self.loads[0].iter().enumerate().filter(|(_, load)| **load > 0.0);
        loads.map(|(slot, &load)| {
            let [x, y] = self.friction(slot);
            x.hypot(y) / (load * CURVE.static_coefficient)
        })
    }

    /// A number that differs unless every bit of the state agrees (FNV-1a).
    pub(crate) fn hash(&self) -> u64 {
        let grains = self.grains.iter().flat_map(|grain| {
            [grain.place, grain.motion[0], grain.motion[1]]
                .into_iter()
                .flat_map(|v| [v.x, v.y, v.z])
        });
        let numbers = grains.chain(self.deflections.iter().copied());
        numbers.fold(0xcbf2_9ce4_8422_2325, |hash, number| {
            (hash ^ number.to_bits()).wrapping_mul(0x0100_0000_01b3)
        })
    }
}
