//! Ratios of costs, measured in turns within one run:
//! `cargo bench -p bristle-all --bench ratios`.
//!
//! Contacts of N axes beside the scalar contact, sliding along the diagonal at its speed; models
//! and curves chosen at run time beside their own types; bristles of several springs beside that of
//! one. Each evaluation waits for the one before. Both of a pair read parameters, deflection and
//! the share of the speed from memory. The best of many rounds counts.

use std::hint::black_box;
use std::time::Instant;

use bristle::curve::{
    AnyCurve, Coulomb, CoulombParameters, FrictionCurve, Knot, RationalStribeck,
    RationalStribeckParameters, Stribeck, Tabulated,
};
use bristle::rheology::{
    GeneralisedMaxwell, GeneralisedMaxwellParameters, KelvinVoigt, MaxwellArm, Rheology,
    ZenerParameters,
};
use bristle::{
    AnyBristle, Bristle, Dahl, DahlParameters, ElastoPlastic, FrBd, LuGre, ParameterError, paper,
};
use bristle_plane::{Axis, PlaneBristle, PlaneFrBd, PlaneLuGre};
use nalgebra::{SMatrix, SVector};

const SPEED: f64 = 0.008;
const DEFLECTION: f64 = 1.1e-4;

/// Rounds of which the best counts, and evaluations in each.
const ROUNDS: usize = 400;
const EVALUATIONS: usize = 1000;
/// Length of a step [s].
const STEP: f64 = 1e-3;

/// Prints all tables.
fn main() -> Result<(), ParameterError> {
    let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
    let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
    let (frbd, lugre) = (FrBd::new(curve, bristle), LuGre::classical(curve, bristle));
    println!("rate and force; all derivatives; exact step; passive step: ns and ratio\n");
    println!("N axes over the scalar contact");
    axes::<1>(curve, bristle)?;
    axes::<2>(curve, bristle)?;
    axes::<3>(curve, bristle)?;
    println!("AnyBristle over the type that it holds");
    at_run_time("FrBD", frbd)?;
    at_run_time("LuGre", lugre)?;
    at_run_time("elasto-plastic FrBD", ElastoPlastic::new(curve, bristle, 5e-5)?)?;
    let dahl = DahlParameters { dynamic_coefficient: 1.0, micro_stiffness: 1e4 };
    at_run_time("Dahl", Dahl::new(dahl)?)?;
    println!("n springs over one spring, then with AnyCurve over the curve's own type");
    springs("Zener", curve, GeneralisedMaxwell::zener(zener())?)?;
    springs("five arms", curve, GeneralisedMaxwell::new(five_arms())?)?;
    println!("AnyCurve over the type that it holds: coefficient; with slope");
    line("Stribeck", of_curve(curve), of_curve(AnyCurve::from(curve)));
    let coulomb = CoulombParameters { dynamic_coefficient: 1.0, viscous_friction: 0.04 };
    let coulomb = Coulomb::new(coulomb)?;
    line("Coulomb", of_curve(coulomb), of_curve(AnyCurve::from(coulomb)));
    let rational = RationalStribeck::new(RationalStribeckParameters {
        static_coefficient: 1.5,
        dynamic_coefficient: 1.0,
        stribeck_velocity: 0.01,
        viscous_friction: 0.04,
    })?;
    line("rational", of_curve(rational), of_curve(AnyCurve::from(rational)));
    let speeds = [0.0, 5e-3, 1e-2, 3e-2, 1.0];
    let knots = speeds.map(|speed| Knot { speed, coefficient: curve.at(speed) });
    let table = Tabulated::from_slice(&knots)?;
    line("table", of_curve(table.clone()), of_curve(AnyCurve::from(table)));
    Ok(())
}

fn zener() -> ZenerParameters<f64> {
    ZenerParameters { static_stiffness: (1e4), relaxing_stiffness: (2e4), series_damping: (100.0) }
}

/// A spring beside four behind dashpots, whose relaxation times span five decades.
fn five_arms() -> GeneralisedMaxwellParameters<f64, 5> {
    let arm = |stiffness, dashpot: Option<f64>| MaxwellArm {
        stiffness: (stiffness),
        series_damping: dashpot,
    };
    GeneralisedMaxwellParameters {
        arms: [
            arm(1e4, None),
            arm(2e4, Some(100.0)),
            arm(5e3, Some(5e3)),
            arm(1e4, Some(1.0)),
            arm(1e3, Some(1e4)),
        ],
        micro_damping: (1.0),
    }
}

fn axes<const N: usize>(
    curve: Stribeck<f64>,
    bristle: KelvinVoigt<f64>,
) -> Result<(), ParameterError> {
    let frbd = FrBd::new(curve, bristle);
    let plane = PlaneFrBd::<_, _, N>::isotropic(curve, bristle);
    line(&format!("FrBD, N = {N}"), scalar(frbd)?, planar(plane)?);
    let lugre = LuGre::classical(curve, bristle);
    let plane = PlaneLuGre::classical(curve, [Axis { friction_ratio: 1.0, bristle }; N])?;
    line(&format!("LuGre, N = {N}"), scalar(lugre)?, planar(plane)?);
    Ok(())
}

fn at_run_time<M>(name: &str, model: M) -> Result<(), ParameterError>
where
    M: Bristle<f64, Deflection = f64> + Into<AnyBristle<f64>>,
{
    line(name, scalar(model.clone())?, scalar(model.into())?);
    Ok(())
}

fn springs<R, const N: usize>(
    name: &str,
    curve: Stribeck<f64>,
    rheology: R,
) -> Result<(), ParameterError>
where
    R: Rheology<f64, Deflection = SVector<f64, N>>,
{
    let one = FrBd::new(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?);
    let several = FrBd::new(curve, rheology.clone());
    line(name, scalar(one)?, viscoelastic(several.clone())?);
    let any = FrBd::new(AnyCurve::from(curve), rheology);
    line(&format!("{name}, AnyCurve"), viscoelastic(several)?, viscoelastic(any)?);
    Ok(())
}

/// Prints costs, and their ratios to others, measured in turns.
fn line<const K: usize>(name: &str, others: impl Fn() -> [f64; K], these: impl Fn() -> [f64; K]) {
    let mut best = [[f64::INFINITY; K]; 2];
    for _ in 0..ROUNDS {
        for (best, new) in best.iter_mut().zip([others(), these()]) {
            best.iter_mut().zip(new).for_each(|(best, new)| *best = best.min(new));
        }
    }
    print!("  {name:22}");
    for (other, this) in best[0].iter().zip(best[1]) {
        print!("{this:9.1} {:5.2}", this / other);
    }
    println!();
}

/// Nanoseconds of an evaluation, each of which waits for the last.
#[inline(always)]
fn round(work: impl Fn(f64) -> f64) -> f64 {
    let (start, mut velocity) = (Instant::now(), SPEED);
    for _ in 0..EVALUATIONS {
        velocity = SPEED + 1e-30 * work(black_box(velocity));
    }
    black_box(velocity);
    start.elapsed().as_secs_f64() * 1e9 / EVALUATIONS as f64
}

fn scalar(
    model: impl Bristle<f64, Deflection = f64>,
) -> Result<impl Fn() -> [f64; 4], ParameterError> {
    let contact = black_box(model.under_load(1.0)?);
    let companion = black_box(contact.clone().companion(1.0)?);
    let (share, z) = black_box((1.0, DEFLECTION));
    Ok(move || {
        [
            round(|v| {
                let response = contact.response(v * share, z);
                response.rate + response.force
            }),
            round(|v| {
                let linear = contact.linearised(v * share, z);
                linear.rate + linear.rate_by_velocity + linear.force + linear.force_by_velocity
            }),
            round(|v| contact.hold(v * share, z, STEP).mean_force),
            // A unit mass under the force that keeps it sliding at about this speed.
            round(|v| {
                let step = companion.step(v * share, z, STEP);
                let mean = (1.28 - step.bias() + v * share * 2e3) / (2e3 + step.damping());
                step.commit(mean).deflection
            }),
        ]
    })
}

fn planar<const N: usize>(
    model: impl PlaneBristle<f64, N>,
) -> Result<impl Fn() -> [f64; 4], ParameterError> {
    let contact = black_box(model.under_load(1.0)?);
    let companion = black_box(contact.clone().companion(1.0)?);
    let share = black_box(1.0 / (N as f64).sqrt());
    let z = black_box(SVector::repeat(DEFLECTION * share));
    let each = move |v: f64| SVector::<f64, N>::repeat(v * share);
    Ok(move || {
        [
            round(|v| {
                let response = contact.response(&each(v), &z);
                total(&response.rate) + total(&response.force)
            }),
            round(|v| {
                let linear = contact.linearised(&each(v), &z);
                total(&linear.rate)
                    + total(&linear.rate_by_velocity)
                    + total(&linear.force)
                    + total(&linear.force_by_velocity)
            }),
            round(|v| total(&contact.hold(&each(v), &z, STEP).mean_force)),
            round(|v| {
                let step = companion.step(&each(v), &z, STEP);
                let pull = each(1.28) - step.bias() + each(v) * 2e3;
                let mean = pull.component_div(&step.damping().add_scalar(2e3));
                total(&step.commit(&mean).deflection)
            }),
        ]
    })
}

fn viscoelastic<const N: usize>(
    model: impl Bristle<f64, Deflection = SVector<f64, N>>,
) -> Result<impl Fn() -> [f64; 4], ParameterError> {
    let contact = black_box(model.under_load(1.0)?);
    let companion = black_box(contact.clone().companion(1.0)?);
    let x = black_box(SVector::repeat(1e-5));
    Ok(move || {
        [
            round(|v| {
                let response = contact.response(v, x);
                total(&response.rate) + response.force
            }),
            round(|v| {
                let linear = contact.linearised(v, x);
                total(&linear.rate)
                    + total(&linear.rate_by_velocity)
                    + linear.force
                    + linear.force_by_velocity
            }),
            round(|v| contact.hold(v, x, STEP).mean_force),
            round(|v| {
                let step = companion.step(v, x, STEP);
                let mean = (1.28 - step.bias() + v * 2e3) / (2e3 + step.damping());
                total(&step.commit(mean).deflection)
            }),
        ]
    })
}

fn of_curve(curve: impl FrictionCurve<f64>) -> impl Fn() -> [f64; 2] {
    let curve = black_box(curve);
    move || {
        [
            round(|v| curve.at(v)),
            round(|v| {
                let (coefficient, slope) = curve.coefficient_and_slope(v.into());
                coefficient + slope
            }),
        ]
    }
}

/// The sum of all entries, without a zero to begin with.
#[inline(always)]
fn total<const R: usize, const C: usize>(entries: &SMatrix<f64, R, C>) -> f64 {
    (1..R * C).fold(entries[0], |sum, i| sum + entries[i])
}
