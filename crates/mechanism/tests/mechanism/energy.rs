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

#[test]
fn no_random_mechanism_makes_energy() {
    let mut draw = Draw::seeded(25);
    let mut negative = 0;
    // A million steps: PROPTEST_CASES=250000, in release.
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|cases| cases.parse().ok());
    let cases = cases.unwrap_or(10_000);
    for case in 0..cases {
        let random = Random::new(&mut draw);
        let (n, m, banded) = (random.coordinates, random.rows.len(), case % 2 == 0);
        let mut mechanism = random.mechanism(banded);
        let speed = draw.logarithmic(1e-3, 1e1);
        let mut position: Vec<_> = (0..n).map(|_| signed(&mut draw)).collect();
        let mut velocity: Vec<_> = (0..n).map(|_| speed * signed(&mut draw)).collect();
        let states = random.companions.iter().map(|companion| {
            let most = companion.contact().limits(0.0).deflection.unwrap();
            ContactState::new(companion, most * signed(&mut draw))
        });
        let mut contacts: Vec<_> = states.collect();
        let h = draw.logarithmic(1e-4, 1e2);
        for _ in 0..4 {
            let force: Vec<_> = (0..n).map(|_| 10.0 * signed(&mut draw)).collect();
            let belt: Vec<_> = (0..m).map(|_| signed(&mut draw)).collect();
            let load = |draw: &mut Draw| (draw.next() > 0.1).then(|| draw.logarithmic(1e-2, 1e2));
            let load: Vec<_> = (0..m).map(|_| load(&mut draw).unwrap_or(0.0)).collect();
            let inputs = Inputs { force: &force, prescribed: &belt, load: &load };
            let stored = |contacts: &[ContactState<f64>]| -> Vec<f64> {
                let pairs = contacts.iter().zip(&random.companions);
                pairs.map(|(state, c)| c.contact().stored_energy(state.deflection())).collect()
            };
            let (w0, e0) = (stored(&contacts), mechanism.energy(&position, &velocity));
            let (x0, v0) = (position.clone(), velocity.clone());
            let motion = Motion { position: &mut position, velocity: &mut velocity };
            mechanism.step(h, &inputs, motion, &random.companions, &mut contacts).unwrap();
            let w1 = stored(&contacts);
            let mean = mechanism.mean_velocities().to_vec();

            let (mut given, mut terms) = (0.0, 0.0);
            let mut pull: Vec<f64> = force.iter().map(|force| force.abs()).collect();
            for (k, state) in contacts.iter().enumerate() {
                let CompletedStep { force, work, stored, dissipated, .. } = *state.last_step();
                // The rounding of a step: 16 ε of these terms.
                let scale = work.abs() + w0[k] + w1[k];
                let rounding = 16.0 * f64::EPSILON * scale;
                assert!(dissipated >= 0.0 && work >= w1[k] - w0[k] - rounding, "{case}");
                assert!((work - stored - dissipated).abs() <= rounding, "{case}");
                assert!((stored - (w1[k] - w0[k])).abs() <= rounding, "{case}");
                negative += usize::from(work < 0.0);
                // What the belt gives is not the mechanism's.
                given += h * force * belt[k] - work;
                let moved = random.rows[k].iter().map(|&(i, w)| (w * mean[i]).abs()).sum::<f64>();
                terms += h * force.abs() * (belt[k].abs() + moved) + work.abs();
                random.rows[k].iter().for_each(|&(i, w)| pull[i] += (w * force).abs());
            }
            given += h * (0..n).map(|i| force[i] * mean[i]).sum::<f64>();
            given -= h * mechanism.damped_power(&mean);
            let most = |a: &[f64], b: &[f64]| -> Vec<f64> {
                a.iter().zip(b).map(|(a, b)| a.abs() + b.abs()).collect()
            };
            let (x, v) = (most(&x0, &position), most(&v0, &velocity));
            terms += size(&random.mass, &v) + size(&random.stiffness, &x);
            terms += h * size(&random.damping, &v) + h * h * size(&random.stiffness, &v);
            terms += h * (0..n).map(|i| (force[i] * v[i]).abs()).sum::<f64>();
            let off = (mechanism.energy(&position, &velocity) - e0 - given).abs();
            // In a band, s̄ is W v̄ to roundings of v̄, which a stuck contact of up to P (K h/2 +
            // K^½) multiplies.
            if banded {
                let stuck = |k: usize| {
                    let contact = random.companions[k].contact();
                    let stiffness = contact.model().storage_stiffness();
                    contact.reference_load() * (0.5 * h * stiffness + stiffness.sqrt() + 1.0)
                };
                let moved = |k: usize| random.rows[k].iter().map(|&(i, w)| (w * v[i]).abs());
                let square = |k: usize| moved(k).sum::<f64>().powi(2);
                terms += h * (0..m).map(|k| stuck(k) * square(k)).sum::<f64>();
            }
            // 20 coordinates and 12 contacts, with a few roundings each. Where A⁻¹ is applied to
            // forces and contacts apart, its condition number multiplies the roundings, and they
            // are those of the energies that force and friction would give without each other.
            if !banded {
                let free = pull.iter().enumerate().map(|(i, f)| f * f / random.mass[i * n + i]);
                terms += h * h * free.sum::<f64>();
            }
            let largest = |matrix: &[f64]| matrix.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
            let rigid = (0..n).fold(f64::MAX, |least, i| least.min(random.mass[i * n + i]));
            let softest = largest(&random.mass) + h * largest(&random.damping);
            let condition = (softest + h * h * largest(&random.stiffness)) / rigid;
            let amplified = if banded { 1.0 } else { condition };
            assert!(
                off <= 200.0 * f64::EPSILON * amplified * terms,
                "{case}: {off:e} of {terms:e}"
            );
        }
    }
    assert!(negative > 1000, "the contacts gave back what they had stored {negative} times only");
}
