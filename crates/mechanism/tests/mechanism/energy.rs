//! Random mechanisms under loads that vary make no energy.

use bristle::companion::{Companion, CompletedStep};
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{AnyBristle, Bristle, Dahl, DahlParameters, ElastoPlastic, FrBd};
use bristle_mechanism::{ContactState, Inputs, LinearMechanism, Matrices, Motion, Structure};
use bristle_specimens::draw::Draw;

type RandomRows = Vec<Vec<(usize, f64)>>;

/// A mechanism as full matrices, rows of its contacts, and their companions.
pub(crate) struct Random {
    pub(crate) coordinates: usize,
    pub(crate) mass: Vec<f64>,
    pub(crate) damping: Vec<f64>,
    pub(crate) stiffness: Vec<f64>,
    pub(crate) rows: RandomRows,
    pub(crate) companions: Vec<Companion<f64, AnyBristle<f64>>>,
    half_bandwidth: usize,
}

fn below(draw: &mut Draw, count: usize) -> usize {
    ((draw.next() * count as f64) as usize).min(count - 1)
}

fn signed(draw: &mut Draw) -> f64 {
    2.0 * draw.next() - 1.0
}

impl Random {
    /// Up to 20 coordinates and 12 contacts. The matrices are sums of a few s gᵀ g, with g of at
    /// most b + 1 coordinates in a row: C and K have zero eigenvalues, mostly.
    pub(crate) fn new(draw: &mut Draw) -> Self {
        let n = 1 + below(draw, 20);
        let reach = below(draw, n);
        let semidefinite = |draw: &mut Draw, scale: f64| {
            let mut matrix = vec![0.0; n * n];
            for _ in 0..below(draw, n + 1) {
                let first = below(draw, n - reach);
                let g: Vec<_> = (0..=reach).map(|_| signed(draw)).collect();
                let strength = scale * draw.logarithmic(1e-3, 1.0);
                for (i, gi) in g.iter().enumerate() {
                    for (j, gj) in g.iter().enumerate() {
                        matrix[(first + i) * n + first + j] += strength * gi * gj;
                    }
                }
            }
            matrix
        };
        let mut mass = semidefinite(draw, 1.0);
        (0..n).for_each(|i| mass[i * n + i] += draw.logarithmic(1e-2, 1e2));
        let (damping, stiffness) = (semidefinite(draw, 10.0), semidefinite(draw, 1e3));
        let contacts = below(draw, 13);
        let rows = (0..contacts).map(|_| {
            let (first, second) = (below(draw, n - reach), 1 + below(draw, reach + 1));
            let rest = (0..second - 1).map(|_| (first + below(draw, reach + 1), signed(draw)));
            let rest: Vec<_> = rest.collect();
            core::iter::once((first, 1.0)).chain(rest).collect()
        });
        let rows = rows.collect();
        let companions = (0..contacts).map(|_| companion(draw)).collect();
        Self { coordinates: n, mass, damping, stiffness, rows, companions, half_bandwidth: reach }
    }

    /// In a structure it has.
    pub(crate) fn mechanism(&self, banded: bool) -> LinearMechanism<f64, RandomRows, Vec<f64>> {
        let (n, reach) = (self.coordinates, self.half_bandwidth);
        let [mass, damping, stiffness] =
            [&self.mass, &self.damping, &self.stiffness].map(|full| match banded {
                false => full.clone(),
                true => (0..n * (reach + 1))
                    .map(|k| (k / (reach + 1), k / (reach + 1) + k % (reach + 1)))
                    .map(|(i, j)| if j < reach { f64::NAN } else { full[i * n + j - reach] })
                    .collect(),
            });
        let structure = match banded {
            false => Structure::Dense,
            true => Structure::Banded { half_bandwidth: reach },
        };
        let [mass, damping, stiffness] = [&mass, &damping, &stiffness];
        let matrices = Matrices { structure, mass, damping, stiffness };
        LinearMechanism::on_heap(&matrices, self.rows.clone()).unwrap()
    }
}

fn companion(draw: &mut Draw) -> Companion<f64, AnyBristle<f64>> {
    let dynamic_coefficient = draw.logarithmic(1e-2, 1.0);
    let micro_stiffness = draw.logarithmic(1e1, 1e6);
    let dahl = DahlParameters { dynamic_coefficient, micro_stiffness };
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: dynamic_coefficient * (1.0 + draw.next()),
        dynamic_coefficient,
        stribeck_velocity: draw.logarithmic(1e-3, 1e-1),
        stribeck_exponent: 2.0,
        viscous_friction: draw.next(),
    })
    .unwrap();
    let micro_damping = draw.next() * micro_stiffness.sqrt();
    let bristle = KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness, micro_damping });
    let bristle = bristle.unwrap();
    let limit = 0.5 * dynamic_coefficient / micro_stiffness;
    let model: AnyBristle<f64> = match below(draw, 3) {
        0 => Dahl::new(dahl).unwrap().into(),
        1 => FrBd::new(curve, bristle).into(),
        _ => ElastoPlastic::new(curve, bristle, limit).unwrap().into(),
    };
    model.under_load(draw.logarithmic(1e-2, 1e2)).unwrap().companion(1.0).unwrap()
}

/// Σ |aᵢⱼ| |xᵢ| |xⱼ|.
fn size(matrix: &[f64], x: &[f64]) -> f64 {
    let n = x.len();
    let entries = matrix.iter().enumerate();
    entries.map(|(k, a)| (a * x[k / n] * x[k % n]).abs()).sum()
}

impl Random {
    /// Energies [J] whose roundings the solve makes, and by how much it multiplies them, given a
    /// bound v of the velocities and the sum of all forces on each coordinate without their signs.
    fn solved(&self, banded: bool, h: f64, v: &[f64], pull: &[f64]) -> (f64, f64) {
        if banded {
            // s̄ is W v̄ to roundings of v̄, which a stuck contact multiplies by up to
            // P (K h/2 + K^½).
            let terms = self.rows.iter().zip(&self.companions).map(|(row, companion)| {
                let contact = companion.contact();
                let stiffness = contact.model().storage_stiffness();
                let damper = 0.5 * h * stiffness + stiffness.sqrt() + 1.0;
                let moved: f64 = row.iter().map(|&(i, w)| (w * v[i]).abs()).sum();
                h * contact.reference_load() * damper * moved * moved
            });
            return (terms.sum(), 1.0);
        }
        // A⁻¹ is applied to forces and contacts apart: its condition number multiplies the
        // roundings, and they are those of the energies that each would give without the others.
        let masses: Vec<_> = self.mass.iter().step_by(self.coordinates + 1).collect();
        let free: f64 = pull.iter().zip(&masses).map(|(f, m)| h * h * f * f / *m).sum();
        let largest = |matrix: &[f64]| matrix.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
        let stiffest = h * (largest(&self.damping) + h * largest(&self.stiffness));
        let lightest = masses.into_iter().fold(f64::MAX, |least, m| least.min(*m));
        (free, (largest(&self.mass) + stiffest) / lightest)
    }
}

/// A random mechanism in motion.
struct Trial {
    random: Random,
    banded: bool,
    mechanism: LinearMechanism<f64, RandomRows, Vec<f64>>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    contacts: Vec<ContactState<f64>>,
    /// How often a contact has given back what it had stored.
    returned: usize,
}

impl Trial {
    fn new(draw: &mut Draw, banded: bool) -> Self {
        let random = Random::new(draw);
        let (n, speed) = (random.coordinates, draw.logarithmic(1e-3, 1e1));
        let position = (0..n).map(|_| signed(draw)).collect();
        let velocity = (0..n).map(|_| speed * signed(draw)).collect();
        let states = random.companions.iter().map(|companion| {
            let most = companion.contact().limits(0.0).deflection.unwrap();
            ContactState::new(companion, most * signed(draw))
        });
        let contacts = states.collect();
        let mechanism = random.mechanism(banded);
        Self { random, banded, mechanism, position, velocity, contacts, returned: 0 }
    }

    /// Energy of each contact.
    fn stored(&self) -> Vec<f64> {
        let pairs = self.contacts.iter().zip(&self.random.companions);
        pairs.map(|(state, c)| c.contact().stored_energy(state.deflection())).collect()
    }

    /// A step under random forces, belts and loads, and its balances.
    fn step(&mut self, draw: &mut Draw, h: f64) {
        let (n, m) = (self.random.coordinates, self.contacts.len());
        let force: Vec<_> = (0..n).map(|_| 10.0 * signed(draw)).collect();
        let belt: Vec<_> = (0..m).map(|_| signed(draw)).collect();
        let load = |draw: &mut Draw| (draw.next() > 0.1).then(|| draw.logarithmic(1e-2, 1e2));
        let load: Vec<_> = (0..m).map(|_| load(draw).unwrap_or(0.0)).collect();
        let inputs = Inputs { force: &force, prescribed: &belt, load: &load };
        let (x0, v0, w0) = (self.position.clone(), self.velocity.clone(), self.stored());
        let motion = Motion { position: &mut self.position, velocity: &mut self.velocity };
        let companions = &self.random.companions;
        self.mechanism.step(h, &inputs, motion, companions, &mut self.contacts).unwrap();
        let mean = self.mechanism.mean_velocities().to_vec();

        let (mut given, mut terms) = (0.0, 0.0);
        let mut pull: Vec<f64> = force.iter().map(|force| force.abs()).collect();
        for (k, (state, w1)) in self.contacts.iter().zip(self.stored()).enumerate() {
            let CompletedStep { force, work, stored, dissipated, .. } = state.last_step();
            // The rounding of a step: 16 ε of these terms.
            let rounding = 16.0 * f64::EPSILON * (work.abs() + w0[k] + w1);
            assert!(dissipated >= 0.0 && work >= w1 - w0[k] - rounding);
            assert!((work - stored - dissipated).abs() <= rounding);
            assert!((stored - (w1 - w0[k])).abs() <= rounding);
            self.returned += usize::from(work < 0.0);
            // What the belt gives is not the mechanism's.
            given += h * force * belt[k] - work;
            let row = &self.random.rows[k];
            let moved: f64 = row.iter().map(|&(i, w)| (w * mean[i]).abs()).sum();
            terms += h * force.abs() * (belt[k].abs() + moved) + work.abs();
            row.iter().for_each(|&(i, w)| pull[i] += (w * force).abs());
        }
        let damped = h * self.mechanism.damped_power(&mean);
        given += h * (0..n).map(|i| force[i] * mean[i]).sum::<f64>() - damped;
        let most = |a: &[f64], b: &[f64]| -> Vec<f64> {
            a.iter().zip(b).map(|(a, b)| a.abs() + b.abs()).collect()
        };
        let (x, v) = (most(&x0, &self.position), most(&v0, &self.velocity));
        let Random { mass, damping, stiffness, .. } = &self.random;
        terms += size(mass, &v) + size(stiffness, &x);
        terms += h * size(damping, &v) + h * h * size(stiffness, &v);
        terms += h * (0..n).map(|i| (force[i] * v[i]).abs()).sum::<f64>();
        let (solved, amplified) = self.random.solved(self.banded, h, &v, &pull);
        let change =
            self.mechanism.energy(&self.position, &self.velocity) - self.mechanism.energy(&x0, &v0);
        // 20 coordinates and 12 contacts, with a few roundings each.
        let rounding = 200.0 * f64::EPSILON * amplified * (terms + solved);
        assert!((change - given).abs() <= rounding, "{change:e}, not {given:e} ± {rounding:e}");
    }
}

#[test]
fn no_random_mechanism_makes_energy() {
    let (mut draw, mut returned) = (Draw::seeded(25), 0);
    // A million steps: PROPTEST_CASES=250000, in release.
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|cases| cases.parse().ok());
    for case in 0..cases.unwrap_or(10_000) {
        let mut trial = Trial::new(&mut draw, case % 2 == 0);
        let h = draw.logarithmic(1e-4, 1e2);
        (0..4).for_each(|_| trial.step(&mut draw, h));
        returned += trial.returned;
    }
    assert!(returned > 1000, "the contacts gave back what they had stored {returned} times only");
}
