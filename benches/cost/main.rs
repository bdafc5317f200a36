//! What one evaluation and one step cost, beside one exponential:
//! `cargo bench -p bristle --bench cost`.
//! Contacts of several axes, models chosen at run time and bristles of several springs are compared
//! with their plain counterparts by `cargo bench -p bristle-all --bench ratios`.
//!
//! Every measured piece of work waits for the result of the one before, as it does in a simulation
//! or a control loop, and so does the exponential it is compared with. Read the ratios to `exp`
//! of the same scalar within one run; absolute times belong to the machine.
//!
//! The parameters are those of the paper's Table 2, in the middle of the Stribeck range, where the
//! friction curve needs its exponential. An integrator's line is the cost of a whole step of the
//! driver (fixed, sliding steadily, without output): its right-hand sides, its algebra, and the
//! watch for reversals.

use std::hint::black_box;

use bristle::curve::{RationalStribeck, RationalStribeckParameters, Stribeck, StribeckParameters};
use bristle::exponential::Exponential;
use bristle::ode::{
    self, DormandPrince, DormandPrince8, Method, Output, Rodas4, Rodas5P, RungeKutta4, Solver,
    System,
};
use bristle::rheology::{
    GeneralisedMaxwell, GeneralisedMaxwellParameters, KelvinVoigt, KelvinVoigtParameters,
    MaxwellArm, ZenerParameters,
};
use bristle::scene::{MassSpringDamper, MassSpringDamperParameters};
use bristle::{
    Affine, Branch, Bristle, Dahl, DahlParameters, ElastoPlastic, FrBd, LuGre, Mechanism,
    ParameterError, Scalar, paper,
};
use bristle_specimens::blocks::{Blocks, Few};
use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{SVector, Vector2, Vector3, convert};

const SPEED: f64 = 0.008;
const DEFLECTION: f64 = 1.1e-4;

/// A result that the next input depends on, without changing its value.
fn chain<T: Scalar>(value: T, result: T) -> T {
    value + result * convert(1e-30)
}

/// Measures a function of a velocity, each call waiting for the last.
fn measure<T: Scalar>(c: &mut Criterion, name: &str, start: f64, mut work: impl FnMut(T) -> T) {
    let start: T = convert(start);
    let mut value = start;
    c.bench_function(name, |b| {
        b.iter(|| {
            value = chain(start, work(black_box(value)));
            value
        });
    });
}

fn models<T: Scalar>(c: &mut Criterion, scalar: &str) {
    let curve_parameters = paper::STICK_SLIP_CURVE;
    let t = |value: f64| convert::<f64, T>(value);
    let (Ok(curve), Ok(rational), Ok(bristle), Ok(dahl)) = (
        Stribeck::new(StribeckParameters {
            static_coefficient: t(curve_parameters.static_coefficient),
            dynamic_coefficient: t(curve_parameters.dynamic_coefficient),
            stribeck_velocity: t(curve_parameters.stribeck_velocity),
            stribeck_exponent: t(curve_parameters.stribeck_exponent),
            viscous_friction: t(curve_parameters.viscous_friction),
        }),
        RationalStribeck::new(RationalStribeckParameters {
            static_coefficient: t(curve_parameters.static_coefficient),
            dynamic_coefficient: t(curve_parameters.dynamic_coefficient),
            stribeck_velocity: t(curve_parameters.stribeck_velocity),
            viscous_friction: t(curve_parameters.viscous_friction),
        }),
        KelvinVoigt::new(KelvinVoigtParameters {
            micro_stiffness: t(paper::STICK_SLIP_BRISTLE.micro_stiffness),
            micro_damping: t(paper::STICK_SLIP_BRISTLE.micro_damping),
        }),
        Dahl::new(DahlParameters { dynamic_coefficient: t(1.0), micro_stiffness: t(1e4) }),
    ) else {
        return;
    };
    measure(c, &format!("{scalar}/exp"), -0.64, |x: T| x.exp());
    let one = |c: &mut Criterion, name: &str, model: &dyn Fn(T) -> T| {
        measure(c, &format!("{scalar}/{name}"), SPEED, model);
    };
    let z = t(DEFLECTION);
    let h = t(1e-3);
    let both = |affine: Affine<T>, v| affine.rate(v, z) + affine.coefficient(v, z);
    let frbd = FrBd::new(curve, bristle);
    let quick = FrBd::new(rational, bristle);
    let lugre = LuGre::classical(curve, bristle);
    one(c, "rate and force, FrBD", &|v| both(frbd.affine(v.into(), z), v));
    one(c, "rate and force, FrBD with rational curve", &|v| both(quick.affine(v.into(), z), v));
    one(c, "rate and force, LuGre", &|v| both(lugre.affine(v.into(), z), v));
    one(c, "rate and force, Dahl", &|v| both(dahl.affine(v.into(), z), v));
    if let Ok(model) = ElastoPlastic::new(curve, bristle, t(5e-5)) {
        one(c, "rate and force, elasto-plastic FrBD", &|v| both(model.affine(v.into(), z), v));
    }
    one(c, "all derivatives, FrBD", &|v| {
        let linear = frbd.linearised(v, z);
        linear.rate_by_velocity + linear.coefficient_by_velocity
    });
    one(c, "exact step, FrBD", &|v| frbd.affine(v.into(), z).hold(v, z, h).mean_coefficient);
    if let Ok(bristle) = GeneralisedMaxwell::zener(zener()) {
        let zener = FrBd::new(curve, bristle);
        let x = Vector2::new(z, t(1e-5));
        one(c, "rate and force, FrBD with Zener bristle", &|v| {
            let affine = zener.affine(v.into(), x);
            affine.rate(v, x).sum() + affine.coefficient(v, x)
        });
        one(c, "exact step, FrBD with Zener bristle", &|v| zener.hold(v, x, h).mean_coefficient);
    }
    if let Ok(bristle) = GeneralisedMaxwell::new(five_arms()) {
        let five = FrBd::new(curve, bristle);
        let x = SVector::<T, 5>::repeat(t(1e-5));
        one(c, "rate and force, FrBD with five arms", &|v| {
            let affine = five.affine(v.into(), x);
            affine.rate(v, x).sum() + affine.coefficient(v, x)
        });
        one(c, "exact step, FrBD with five arms", &|v| five.hold(v, x, h).mean_coefficient);
    }
    if let Ok(companion) = frbd.under_load(t(1.0)).and_then(|contact| contact.companion(t(1.0))) {
        // A unit mass under the force that keeps it sliding at about this speed.
        one(c, "passive step, FrBD, deflection alone", &|v| {
            let step = companion.step(v, z, h);
            let mean = (t(1.28) - step.bias() + v * t(2e3)) / (t(2e3) + step.damping());
            step.commit(mean).deflection
        });
        one(c, "passive step, FrBD, with its ledger", &|v| {
            let step = companion.step(v, z, h);
            let mean = (t(1.28) - step.bias() + v * t(2e3)) / (t(2e3) + step.damping());
            let done = step.commit(mean);
            done.deflection + done.work + done.stored + done.dissipated
        });
    }
    if let Ok(companion) = frbd.under_load(t(1.0)).and_then(|contact| contact.companion(t(1.0))) {
        // Between 1 and 2 N, each step under a load of its own.
        let mut companion = companion;
        let mut load = t(1.0);
        measure(c, &format!("{scalar}/passive step, FrBD, under a load that varies"), SPEED, |v| {
            load = t(3.0) - load;
            let Ok(reloaded) = companion.reload(load, v, z) else { return v };
            let step = companion.step(v, reloaded.deflection, h);
            let mean = (t(1.28) - step.bias() + v * t(2e3)) / (t(2e3) + step.damping());
            step.commit(mean).deflection + reloaded.dissipated
        });
    }
    if let Ok(contact) = frbd.under_load(t(1.0)) {
        one(c, "exponential step of three nodes, FrBD", &|v| {
            let ramp = v..v + t(1e-4);
            Exponential::<3>.ramp(&contact, ramp, z, h).deflection
        });
    }
    one(c, "exact step, FrBD with rational curve", &|v| {
        quick.affine(v.into(), z).hold(v, z, h).mean_coefficient
    });
}

/// A spring beside one behind a dashpot.
fn zener<T: Scalar>() -> ZenerParameters<T> {
    ZenerParameters {
        static_stiffness: convert(1e4),
        relaxing_stiffness: convert(2e4),
        series_damping: convert(100.0),
    }
}

/// A spring beside four behind dashpots, whose relaxation times span five decades.
fn five_arms<T: Scalar>() -> GeneralisedMaxwellParameters<T, 5> {
    let arm = |stiffness, dashpot: Option<f64>| MaxwellArm {
        stiffness: convert(stiffness),
        series_damping: dashpot.map(convert),
    };
    GeneralisedMaxwellParameters {
        arms: [
            arm(1e4, None),
            arm(2e4, Some(100.0)),
            arm(5e3, Some(5e3)),
            arm(1e4, Some(1.0)),
            arm(1e3, Some(1e4)),
        ],
        micro_damping: convert(1.0),
    }
}

type Friction<T> = FrBd<Stribeck<T>, KelvinVoigt<T>>;

/// The stick-slip rig in a scalar type.
fn rig<T: Scalar>() -> Result<MassSpringDamper<T, Friction<T>>, ParameterError> {
    let t = |value: f64| convert::<f64, T>(value);
    let (curve, bristle) = (paper::STICK_SLIP_CURVE, paper::STICK_SLIP_BRISTLE);
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: t(curve.static_coefficient),
        dynamic_coefficient: t(curve.dynamic_coefficient),
        stribeck_velocity: t(curve.stribeck_velocity),
        stribeck_exponent: t(curve.stribeck_exponent),
        viscous_friction: t(curve.viscous_friction),
    })?;
    let bristle = KelvinVoigt::new(KelvinVoigtParameters {
        micro_stiffness: t(bristle.micro_stiffness),
        micro_damping: t(bristle.micro_damping),
    })?;
    MassSpringDamper::new(MassSpringDamperParameters {
        contact: FrBd::new(curve, bristle).under_load(t(1.0))?,
        mechanism: Mechanism { mass: t(1.0), spring_stiffness: t(2.0), viscous_damping: t(0.0) },
        drive_velocity: t(SPEED),
        force: t(0.0),
    })
}

fn integrators<T: Scalar>(c: &mut Criterion, scalar: &str) {
    let t = |value: f64| convert::<f64, T>(value);
    let Ok(rig) = rig::<T>() else { return };
    let state = |velocity: T| Vector3::new(t(0.0), velocity, t(DEFLECTION));
    let name = |what: &str| format!("{scalar}/{what}, spring-driven mass");
    measure(c, &name("right-hand side"), SPEED, |v: T| {
        rig.rate(t(14.0), &state(v), [Branch::Forward]).sum()
    });
    measure(c, &name("right-hand side with Jacobian"), SPEED, |v: T| {
        let tangent = rig.linearised(t(14.0), &state(v), [Branch::Forward]);
        tangent.map_or(T::zero(), |tangent| tangent.rate.sum() + tangent.by_state.sum())
    });
    measure(c, &name("bare RK4 step"), SPEED, |v: T| {
        RungeKutta4::step(&rig, t(14.0), &state(v), t(1e-4)).sum()
    });
    step(c, &name("step of RungeKutta4"), &rig, RungeKutta4);
    step(c, &name("step of DormandPrince"), &rig, DormandPrince);
    step(c, &name("step of DormandPrince8"), &rig, DormandPrince8);
    step(c, &name("step of Rodas4"), &rig, Rodas4);
    step(c, &name("step of Rodas5P"), &rig, Rodas5P);
}

/// Measures steps of a method in the Stribeck range, each from where the last one ended.
fn step<T, S, M>(c: &mut Criterion, name: &str, rig: &S, method: M)
where
    T: Scalar,
    S: System<T, 3>,
    M: Method<T, 3>,
{
    let t = |value: f64| convert::<f64, T>(value);
    let Ok(solver) = Solver::fixed(method, t(2f64.powi(-14))) else { return };
    // Pulled along at about the speed of the Stribeck range, for as long as it lasts.
    let start = Vector3::new(t(-0.5), t(SPEED), t(DEFLECTION));
    let begin = || solver.begin(rig, t(0.0)..t(0.125), start);
    let mut run = begin();
    c.bench_function(name, |b| {
        b.iter(|| {
            let over = match &mut run {
                Ok(run) => !matches!(run.advance(), Ok(Some(_))),
                Err(_) => true,
            };
            if over {
                run = begin();
            }
        });
    });
}

/// The same run of `solve` with a fixed size and with one known at run time.
fn sizes(c: &mut Criterion) {
    let (span, output) = (0.0..5.0, Output::Uniform(201));
    c.bench_function("f64/solve, 21 states, of a fixed size", |b| {
        let start = SVector::<f64, 21>::zeros();
        b.iter(|| ode::solve(&Few::<7>, span.clone(), start, 1e-6, output).is_ok());
    });
    c.bench_function("f64/solve, 21 states, of a size known at run time", |b| {
        b.iter(|| ode::solve(&Blocks(7), span.clone(), vec![0.0; 21], 1e-6, output).is_ok());
    });
}

fn all(c: &mut Criterion) {
    sizes(c);
    models::<f64>(c, "f64");
    models::<f32>(c, "f32");
    integrators::<f64>(c, "f64");
    integrators::<f32>(c, "f32");
}

criterion_group!(benches, all);

criterion_main!(benches);
