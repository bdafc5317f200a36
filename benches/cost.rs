//! What one evaluation costs, beside one exponential: `cargo bench --bench cost`.
//!
//! Every measured piece of work waits for the result of the one before, as it does in a simulation
//! or a control loop, and so does the exponential it is compared with. Read the ratios to `exp`
//! of the same scalar within one run; absolute times belong to the machine.
//!
//! The parameters are those of the paper's Table 2, in the middle of the Stribeck range, where the
//! friction curve needs its exponential. The integrator's line is the cost of a whole step, four
//! right-hand sides.

use std::hint::black_box;

use bristle::ode::{RungeKutta4, System};
use bristle::scene::SpringDrivenMass;
use bristle::{
    Branch, Bristle, Dahl, DahlParameters, ElastoPlastic, ElastoPlasticParameters, FrBd,
    KelvinVoigt, KelvinVoigtParameters, LuGre, RationalStribeck, RationalStribeckParameters,
    Scalar, Stribeck, StribeckParameters, paper,
};
use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Vector3, convert};

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
    let frbd = FrBd::new(curve, bristle);
    let quick = FrBd::new(rational, bristle);
    let lugre = LuGre::classical(curve, bristle);
    one(c, "rate and force, FrBD", &|v| {
        let response = frbd.response(v, z);
        response.rate + response.coefficient
    });
    one(c, "rate and force, FrBD with rational curve", &|v| {
        let response = quick.response(v, z);
        response.rate + response.coefficient
    });
    one(c, "rate and force, LuGre", &|v| {
        let response = lugre.response(v, z);
        response.rate + response.coefficient
    });
    one(c, "rate and force, Dahl", &|v| {
        let response = dahl.response(v, z);
        response.rate + response.coefficient
    });
    let elastic = ElastoPlasticParameters { curve, rheology: bristle, stick_limit: t(5e-5) };
    if let Ok(model) = ElastoPlastic::new(elastic) {
        one(c, "rate and force, elasto-plastic FrBD", &|v| {
            let response = model.response(v, z);
            response.rate + response.coefficient
        });
    }
    one(c, "all derivatives, FrBD", &|v| {
        let linear = frbd.linearised(v, z);
        linear.rate_by_velocity + linear.coefficient_by_velocity
    });
    one(c, "exact step, FrBD", &|v| frbd.affine(v.into(), z).hold(v, z, h).mean);
    one(c, "exact step, FrBD with rational curve", &|v| {
        quick.affine(v.into(), z).hold(v, z, h).mean
    });
}

fn integrators(c: &mut Criterion) {
    let rig = Stribeck::new(paper::STICK_SLIP_CURVE).and_then(|curve| {
        let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
        let contact = FrBd::new(curve, bristle).under_load(1.0)?;
        SpringDrivenMass::new(paper::stick_slip_rig(contact))
    });
    let Ok(rig) = rig else { return };
    let state = |velocity: f64| Vector3::new(0.7, velocity, DEFLECTION);
    measure(c, "f64/right-hand side, spring-driven mass", SPEED, |v: f64| {
        rig.rate(14.0, &state(v), [Branch::Forward]).sum()
    });
    measure(c, "f64/right-hand side with Jacobian, spring-driven mass", SPEED, |v: f64| {
        let tangent = rig.tangent(14.0, &state(v), [Branch::Forward]);
        tangent.map_or(0.0, |tangent| tangent.rate.sum() + tangent.by_state.sum())
    });
    measure(c, "f64/RK4 step, spring-driven mass", SPEED, |v: f64| {
        RungeKutta4::step(&rig, 14.0, &state(v), 1e-4).sum()
    });
}

fn all(c: &mut Criterion) {
    models::<f64>(c, "f64");
    models::<f32>(c, "f32");
    integrators(c);
}

criterion_group!(benches, all);
criterion_main!(benches);
