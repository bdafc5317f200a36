//! The friction curves and regularisations of the crate, on one set of parameters.
//!
//! Leaves `friction_curves.csv` and `friction_curves.svg`.

use std::process::ExitCode;

use bristle::curve::{
    Asymmetric, Coulomb, CoulombParameters, FrictionCurve, Knot, RationalStribeck,
    RationalStribeckParameters, Stribeck, StribeckParameters, Tabulated,
};
use bristle::regularisation::{HyperbolicTangent, Regularisation, SquareRoot, Unregularised};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, Stroke, println};

const STATIC: f64 = 0.6;
const DYNAMIC: f64 = 0.4;
const STRIBECK_VELOCITY: f64 = 0.05;
const VISCOUS: f64 = 0.25;
const FASTEST: f64 = 0.4;

/// One curve over the velocity: name in the table, label in the legend, stroke, (v, μ, dμ/dv).
struct Curve {
    name: &'static str,
    label: &'static str,
    stroke: Stroke,
    samples: Vec<[f64; 3]>,
}

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("friction_curves", "Friction curves and regularisations")
            .count("samples", 801, "points per curve")
            .must_be(Rule::Between(2.0, 1e7))
            .parse()?;
        let samples = arguments.count("samples");

        let stribeck = |stribeck_exponent, viscous_friction| {
            Stribeck::new(StribeckParameters {
                static_coefficient: STATIC,
                dynamic_coefficient: DYNAMIC,
                stribeck_velocity: STRIBECK_VELOCITY,
                stribeck_exponent,
                viscous_friction,
            })
        };
        let coulomb = Coulomb::new(CoulombParameters {
            dynamic_coefficient: DYNAMIC,
            viscous_friction: VISCOUS,
        })?;
        let rational = RationalStribeck::new(RationalStribeckParameters {
            static_coefficient: STATIC,
            dynamic_coefficient: DYNAMIC,
            stribeck_velocity: STRIBECK_VELOCITY,
            viscous_friction: VISCOUS,
        })?;
        let measured = [(0.0, 0.58), (0.03, 0.55), (0.07, 0.46), (0.15, 0.44), (0.3, 0.47)];
        let tabulated =
            Tabulated::new(measured.map(|(speed, coefficient)| Knot { speed, coefficient }))?;
        let asymmetric = Asymmetric { forward: stribeck(2.0, VISCOUS)?, backward: coulomb };

        let curves = [
            sample("coulomb", "Coulomb, viscous", Colour::Black.dotted(), &coulomb, samples),
            sample(
                "stribeck_1",
                "Stribeck, δ = 1",
                Colour::Green.dashed(),
                &stribeck(1.0, VISCOUS)?,
                samples,
            ),
            sample(
                "stribeck_2",
                "Stribeck, δ = 2",
                Colour::Blue.into(),
                &stribeck(2.0, VISCOUS)?,
                samples,
            ),
            sample("rational", "rational Stribeck", Colour::Orange.dashed(), &rational, samples),
            sample("tabulated", "tabulated", Colour::Purple.into(), &tabulated, samples),
            sample("asymmetric", "asymmetric", Colour::Sky.width(5.0), &asymmetric, samples),
        ];
        let dry = sample(
            "stribeck_dry",
            "Stribeck, δ = 2, σ_2 = 0",
            Colour::Sky.dashed(),
            &stribeck(2.0, 0.0)?,
            samples,
        );

        let columns = ["curve", "v", "coefficient", "slope"];
        let mut table = Csv::create(arguments.out_dir(), "friction_curves", &columns)?;
        println!(
            "μ_s = {STATIC}, μ_d = {DYNAMIC}, v_S = {STRIBECK_VELOCITY} m/s, σ2 = {VISCOUS} s/m"
        );
        println!();
        println!("friction coefficient      at rest  at v_S  at {FASTEST} m/s");
        for curve in curves.iter().chain([&dry]) {
            for row in &curve.samples {
                table.row(&[curve.name], row)?;
            }
            let at = |v: f64| {
                let index = ((v / FASTEST + 1.0) * 0.5 * (samples - 1) as f64).round();
                curve.samples[index as usize][1]
            };
            let (rest, stribeck, fast) = (at(0.0), at(STRIBECK_VELOCITY), at(FASTEST));
            let label = curve.label.replace("_2", "2");
            println!("{label:24}  {rest:7.4}  {stribeck:6.4}  {fast:10.4}");
        }
        table.finish()?;
        println!();
        println!(
            "{}",
            chart(&curves, &dry)?.save(arguments.out_dir(), "friction_curves")?.display()
        );
        Ok(())
    })
}

/// Samples a curve over both directions of sliding.
fn sample<C: FrictionCurve<f64>>(
    name: &'static str,
    label: &'static str,
    stroke: Stroke,
    curve: &C,
    samples: usize,
) -> Curve {
    let point = |i: usize| {
        let v = FASTEST * (2.0 * i as f64 / (samples - 1) as f64 - 1.0);
        let (coefficient, slope) = curve.coefficient_and_slope(v.into());
        [v, coefficient, slope]
    };
    Curve { name, label, stroke, samples: (0..samples).map(point).collect() }
}

fn chart(curves: &[Curve], dry: &Curve) -> Result<Figure, bristle::ParameterError> {
    // The friction force of steady sliding, as the paper draws it: with the sign of the velocity.
    let mut signed = Panel::new("sliding velocity v (m/s)", "friction μ(v) sgn v (–)")
        .title("with the sign of the velocity")
        .own_legend();
    for curve in curves.iter().filter(|curve| curve.name == "stribeck_2").chain([dry]) {
        let mut points: Vec<_> =
            curve.samples.iter().map(|row| (row[0], row[1] * row[0].signum())).collect();
        // The jump at rest is drawn as such.
        let half = points.partition_point(|point| point.0 < 0.0);
        points.insert(half, (0.0, -STATIC));
        points.insert(half + 1, (0.0, STATIC));
        signed = signed.line(curve.label, curve.stroke, &points);
    }
    let mut shapes = Panel::new("sliding velocity v (m/s)", "friction coefficient μ (–)")
        .title("all curves")
        .own_legend();
    // The asymmetric curve is two others, and lies below them.
    for curve in curves.iter().rev() {
        let points: Vec<_> = curve.samples.iter().map(|row| (row[0], row[1])).collect();
        shapes = shapes.line(curve.label, curve.stroke, &points);
    }
    let (root, tangent) = (SquareRoot::new(1e-6)?, HyperbolicTangent::new(1e-3)?);
    let grid = || (-500..=500).map(|i| f64::from(i) * 1e-5);
    let signs = Panel::new("sliding velocity v (mm/s)", "regularised sign (–)")
        .title("regularisations, |0|_ε = 1 mm/s")
        .own_legend()
        .line("exact", Colour::Black.width(1.0), sign(grid(), &Unregularised))
        .line("square root", Colour::Vermilion, sign(grid(), &root))
        .line("hyperbolic tangent", Colour::Black.dashed(), sign(grid(), &tangent));
    Ok(Figure::new(900, 820)
        .title("Friction curves and regularised signs over the sliding velocity")
        .columns(2)
        .panel(signed)
        .panel(shapes)
        .panel(signs))
}

fn sign<E: Regularisation<f64>>(
    velocities: impl Iterator<Item = f64>,
    regularisation: &E,
) -> Vec<(f64, f64)> {
    velocities.map(|v| (v * 1e3, regularisation.sign(v.into()))).collect()
}
