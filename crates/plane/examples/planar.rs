//! A block in a plane: pulled along a circle over a surface that resists less across than along,
//! and a disc that spins while it slides to rest.
//!
//! The block has 1 kg under 1 N, Table 2 of the paper along x and 0.6 of its friction along y; two
//! springs of 2 N/m pull it to a point that moves around a circle. The disc has 1 kg, a radius of
//! 0.05 m and μ = 0.3: once as a footprint of 192 points, once as three axes whose limit surface is
//! an ellipsoid.
//!
//! Leaves `planar.csv` (the block) and `planar.svg`. Prints what solvers make of the cone of ‖v‖.

use std::error::Error;
use std::process::ExitCode;

use bristle::companion::{PointMass, VelocityHistory};
use bristle::curve::{Coulomb, CoulombParameters, Stribeck};
use bristle::ode::{self, DormandPrince, Method, Output, Rodas5P, RungeKutta4, Solver};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::signal::{Signal, Sine, SineParameters};
use bristle::{Mechanism, paper};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, Symbol, println};
use bristle_plane::{
    Axis, DiscPressure, Footprint, FootprintPoint, PlaneBristle, PlaneCompanion,
    PlaneCompanionStep, PlaneContact, PlaneFrBd,
};
use bristle_plane::{PlaneBody, PlaneBodyParameters};
use nalgebra::{Matrix3, SVector, Vector2, Vector3, Vector6};

/// Friction across over that along.
const ACROSS: f64 = 0.6;
/// Circle of the anchor: radius [m] and angular frequency [rad/s].
const CIRCLE: (f64, f64) = (1.5, 0.3);
const SPRING: f64 = 2.0; // N/m
/// The disc: radius [m], friction coefficient, normal force [N].
const DISC: (f64, f64, f64) = (0.05, 0.3, 9.81);

/// v/(a ω) at which every disc that slides and spins comes to rest: Z. Farkas, G. Bartels,
/// T. Unger, D. E. Wolf, "Frictional coupling between sliding and spinning motion", Phys. Rev.
/// Lett. 90 (2003).
const FARKAS: f64 = 0.653;

type Outcome<T> = Result<T, Box<dyn Error>>;
type Friction<C, const N: usize> = PlaneFrBd<C, f64, N>;
type Contact<C, const N: usize> = PlaneContact<f64, Friction<C, N>, N>;
type Disc = Footprint<f64, Friction<Coulomb<f64>, 2>, Vec<FootprintPoint<f64>>>;
type Block = PlaneBody<f64, Friction<Stribeck<f64>, 2>, 2, Sine<f64>>;

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("planar", "A block and a disc in a plane")
            .number("end", 40.0, "s", "end of the block's simulated time")
            .must_be(Rule::Between(1.0, 1000.0))
            .count("samples", 4001, "rows of the table, evenly spaced, both ends included")
            .must_be(Rule::Between(2.0, 1e6))
            .parse()?;
        let (end, samples) = (arguments.number("end"), arguments.count("samples"));
        let (block, anchor) = block()?;
        let output = Output::Uniform(samples);
        let run = ode::solve(&block, 0.0..end, Vector6::zeros(), 1e-8, output)?;

        let columns = ["t", "anchor_x", "anchor_y", "x", "y", "v_x", "v_y", "f_x", "f_y"];
        let mut table = Csv::create(arguments.out_dir(), "planar", &columns)?;
        let (mut path, mut pull, mut forces) = (Vec::new(), Vec::new(), Vec::new());
        for (t, state) in run.iter() {
            let (v, z) = (Vector2::new(state[2], state[3]), Vector2::new(state[4], state[5]));
            let force = block.contact().force(&v, &z);
            let [x, y] = [&anchor[0], &anchor[1]].map(|signal| signal.value(t));
            table.row(&[], &[t, x, y, state[0], state[1], v.x, v.y, force.x, force.y])?;
            path.push((state[0], state[1]));
            pull.push((x, y));
            forces.push((force.x, force.y));
        }
        table.finish()?;

        orders(&block, &anchor)?;
        let points: Vec<_> = FootprintPoint::disc(DISC.0, DiscPressure::Uniform, 8).collect();
        let disc = Footprint::new(disc_contact::<2>()?, points)?;
        let surface = limit_surface(&disc);
        let depth = surface.iter().map(|(torque, force)| 1.0 - torque.hypot(*force));
        println!();
        println!(
            "limit surface of the disc: at most {:.1} % inside the ellipsoid",
            100.0 * depth.fold(0.0, f64::max)
        );
        let last = |run: &[(f64, f64)]| run.last().map_or(f64::NAN, |point| point.1);
        let (mut slides, mut ellipsoids) = (Vec::new(), Vec::new());
        println!("v/(a ω) at the beginning and close to rest");
        for ratio in [0.25, 1.0] {
            let (slide, ellipsoid) = (slide(&disc, ratio)?, slide_as_ellipsoid(ratio)?);
            println!(
                "    {ratio:4.2}: disc {:.3}, ellipsoid {:.3}",
                last(&slide),
                last(&ellipsoid)
            );
            // A gap between the runs.
            slides.extend(slide.into_iter().chain([(f64::NAN, f64::NAN)]));
            ellipsoids.extend(ellipsoid.into_iter().chain([(f64::NAN, f64::NAN)]));
        }
        println!();

        let curve = paper::STICK_SLIP_CURVE;
        let (lower, upper) = (curve.dynamic_coefficient, curve.static_coefficient);
        let figure = Figure::new(900, 820)
            .title(
                "A block pulled along a circle, and a disc that spins: paths and friction forces",
            )
            .columns(2)
            .panel(
                Panel::new("x (m)", "y (m)")
                    .title("block on a moving anchor")
                    .equal_scales()
                    .line("anchor", Colour::Grey.dashed(), &pull)
                    .line("block", Colour::Blue, &path),
            )
            .panel(
                Panel::new("friction force F_x (N)", "friction force F_y (N)")
                    .title("friction force on the block")
                    .equal_scales()
                    .points("friction force", Symbol::from(Colour::Sky).size(4.0), &forces)
                    .line("static ellipse", Colour::Vermilion, ellipse(upper, ACROSS * upper))
                    .line(
                        "dynamic ellipse",
                        Colour::Black.dashed().width(1.0),
                        ellipse(lower, ACROSS * lower),
                    ),
            )
            .panel(
                Panel::new("torque M/(μ p R), R = ⅔ a (–)", "force F/(μ p) (–)")
                    .title("limit surface of the disc")
                    .equal_scales()
                    .line("ellipsoid", Colour::Orange.dashed(), ellipse(1.0, 1.0).take(91))
                    .line("disc", Colour::Purple, &surface),
            )
            .panel(
                Panel::new("time t (s)", "speed ratio v/(a ω) (–)")
                    .title("a disc slides to rest, from two ratios")
                    .line("ellipsoid", Colour::Orange.dashed(), &ellipsoids)
                    .line("disc", Colour::Purple, &slides)
                    .horizontal(FARKAS, "last ratio of a disc, 0.653"),
            );
        println!("{}", figure.save(arguments.out_dir(), "planar")?.display());
        Ok(())
    })
}

/// An ellipse, in steps of one degree.
fn ellipse(x: f64, y: f64) -> impl Iterator<Item = (f64, f64)> {
    (0..=360).map(move |k| {
        let (sin, cos) = f64::from(k).to_radians().sin_cos();
        (x * cos, y * sin)
    })
}

/// The block and its anchor.
fn block() -> Outcome<(Block, [Sine<f64>; 2])> {
    let (radius, frequency) = (CIRCLE.0, CIRCLE.1 / std::f64::consts::TAU);
    let sine =
        |mean, amplitude, phase| Sine::new(SineParameters { mean, amplitude, frequency, phase });
    let quarter = std::f64::consts::FRAC_PI_2;
    let anchor = [sine(0.0, radius, 0.0)?, sine(radius, -radius, quarter)?];
    let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
    let axes = [1.0, ACROSS].map(|friction_ratio| Axis { friction_ratio, bristle });
    let friction = PlaneFrBd::new(Stribeck::new(paper::STICK_SLIP_CURVE)?, axes)?;
    let mechanism = Mechanism { mass: 1.0, spring_stiffness: SPRING, viscous_damping: 0.0 };
    let block = PlaneBody::new(PlaneBodyParameters {
        contact: friction.under_load(1.0)?,
        mechanisms: [mechanism; 2],
        anchor,
        force: [0.0; 2],
    })?;
    Ok((block, anchor))
}

/// What solvers make of the cone: the largest error of the block's place over 40 s.
fn orders(block: &Block, anchor: &[Sine<f64>; 2]) -> Outcome<()> {
    let (start, seconds) = (Vector6::zeros(), Output::Uniform(81));
    let reference = ode::solve(block, 0.0..40.0, start, 1e-13, seconds)?;
    let off = |states: &[Vector6<f64>]| {
        let pairs = states.iter().zip(reference.states());
        pairs.fold(0.0_f64, |most, (a, b)| most.max((a.xy() - b.xy()).norm()))
    };
    println!("block over 40 s, its place off by at most");
    println!("ode::solve        tolerance    steps  rejected  evaluations      error");
    for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
        let run = ode::solve(block, 0.0..40.0, start, tolerance, seconds)?;
        let statistics = run.statistics();
        println!(
            "                  {tolerance:9.0e} {:8} {:9} {:12}  {:7.0e} m",
            statistics.steps,
            statistics.rejected,
            statistics.evaluations,
            off(run.states())
        );
    }
    println!("fixed steps       10 ms      5 ms    2.5 ms   1.25 ms   order");
    let steps = [1e-2, 5e-3, 2.5e-3, 1.25e-3];
    let row = |name: &str, errors: [f64; 4]| {
        let order = (errors[1] / errors[2]).log2();
        let errors = errors.map(|error| format!("{error:9.0e}")).join(" ");
        println!("{name:14}{errors} {order:7.1}");
    };
    let companion = block.contact().companion(1.0)?;
    row("companion", steps.map(|h| off(&companion_run(&companion, anchor, h))));
    let fixed = |run: Option<Vec<Vector6<f64>>>| run.map_or(f64::NAN, |states| off(&states));
    row("RungeKutta4", steps.map(|h| fixed(fixed_run(block, RungeKutta4, h))));
    row("DormandPrince", steps.map(|h| fixed(fixed_run(block, DormandPrince, h))));
    row("Rodas5P", steps.map(|h| fixed(fixed_run(block, Rodas5P, h))));
    Ok(())
}

/// The block by fixed steps, each half second.
fn fixed_run<M: Method<f64, 6>>(block: &Block, method: M, h: f64) -> Option<Vec<Vector6<f64>>> {
    let solver = Solver::fixed(method, h).ok()?;
    let run = solver.solve(block, 0.0..40.0, SVector::zeros(), Output::Uniform(81)).ok()?;
    Some(run.states().to_vec())
}

/// The block by companion steps, each half second.
fn companion_run(
    companion: &PlaneCompanion<f64, Friction<Stribeck<f64>, 2>, 2>,
    anchor: &[Sine<f64>; 2],
    h: f64,
) -> Vec<Vector6<f64>> {
    let (mut x, mut v, mut z) = (Vector2::zeros(), Vector2::zeros(), Vector2::zeros());
    let mut history = [VelocityHistory::new(0.0); 2];
    let mut states = vec![Vector6::zeros()];
    let each = (0.5 / h).round() as u32;
    for n in 0..80 * each {
        let step = companion.step(&Vector2::from_fn(|i, _| history[i].predict()), &z, h);
        let middle = h * (f64::from(n) + 0.5);
        let pull = Vector2::from_fn(|i, _| SPRING * (anchor[i].value(middle) - x[i]));
        let resistance = step.damping().add_scalar(2.0 / h + 0.5 * h * SPRING);
        let mean = (v * (2.0 / h) + pull - step.bias()).component_div(&resistance);
        z = step.commit(&mean).deflection;
        (x, v) = (x + h * mean, 2.0 * mean - v);
        (0..2).for_each(|i| history[i].push(v[i]));
        if (n + 1) % each == 0 {
            states.push(Vector6::new(x.x, x.y, v.x, v.y, z.x, z.y));
        }
    }
    states
}

fn disc_contact<const N: usize>() -> Outcome<Contact<Coulomb<f64>, N>> {
    let parameters = CoulombParameters { dynamic_coefficient: DISC.1, viscous_friction: 0.0 };
    let bristle =
        KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness: 1e6, micro_damping: 100.0 })?;
    Ok(PlaneFrBd::isotropic(Coulomb::new(parameters)?, bristle).under_load(DISC.2)?)
}

/// Force over torque of steady sliding, each over its largest on the ellipsoid.
fn limit_surface(disc: &Disc) -> Vec<(f64, f64)> {
    let (radius, mu, p) = DISC;
    let torque = mu * p * DiscPressure::Uniform.spin_radius(radius);
    let point = |k: i32| {
        let (sin, cos) = (f64::from(k) * std::f64::consts::FRAC_PI_2 / 180.0).sin_cos();
        let wrench = disc.stationary_wrench(&Vector3::new(sin, 0.0, cos / radius));
        (wrench.z / torque, wrench.x / (mu * p))
    };
    (0..=180).map(point).collect()
}

/// v/(a ω) over time of the disc as a footprint.
fn slide(disc: &Disc, ratio: f64) -> Outcome<Vec<(f64, f64)>> {
    let companion = disc.clone().companion(5.0)?;
    let mut z = vec![Vector2::zeros(); disc.points().len()];
    let mut steps = vec![PlaneCompanionStep::default(); z.len()];
    let inertia = Matrix3::from_diagonal(&inertia());
    coast(ratio, |predicted, twist, h| {
        let step = companion.step(predicted, &z, h, &mut steps)?;
        let matrix = inertia * (2.0 / h) + step.damping;
        let mean = matrix.lu().solve(&(inertia * (2.0 / h) * twist - step.bias));
        let mean = mean.ok_or("a singular matrix")?;
        let _ = companion.commit(&steps, &mean, &mut z)?;
        Ok(mean)
    })
}

/// v/(a ω) over time of the disc as three axes.
fn slide_as_ellipsoid(ratio: f64) -> Outcome<Vec<(f64, f64)>> {
    let companion = disc_contact::<3>()?.companion(5.0)?;
    let radius = DiscPressure::Uniform.spin_radius(DISC.0);
    let axes = Vector3::new(1.0, 1.0, radius);
    let mut z = Vector3::zeros();
    coast(ratio, |predicted, twist, h| {
        let step = companion.step(&axes.component_mul(predicted), &z, h);
        let mean = step.point_mass(PointMass {
            mass: inertia().component_div(&axes).component_div(&axes),
            velocity: axes.component_mul(twist),
            force: Vector3::zeros(),
            end_weight: Vector3::repeat(0.5),
        });
        z = step.commit(&mean).deflection;
        Ok(mean.component_div(&axes))
    })
}

/// Mass and moment of inertia of the disc.
fn inertia() -> Vector3<f64> {
    Vector3::new(1.0, 1.0, 0.5 * DISC.0 * DISC.0)
}

/// v/(a ω) over time from a ratio on, pushed off at 0.3 m/s, until the disc hardly moves. A step
/// turns a predicted twist, the twist at its beginning and its length into its mean twist.
fn coast(
    ratio: f64,
    mut step: impl FnMut(&Vector3<f64>, &Vector3<f64>, f64) -> Outcome<Vector3<f64>>,
) -> Outcome<Vec<(f64, f64)>> {
    let (h, mut twist) = (1e-4, Vector3::new(0.3, 0.0, 0.3 / (ratio * DISC.0)));
    let mut history: [_; 3] = core::array::from_fn(|i| VelocityHistory::new(twist[i]));
    let mut rows = Vec::new();
    while twist.xy().norm() > 2e-3 {
        rows.push((h * rows.len() as f64, twist.xy().norm() / (DISC.0 * twist.z)));
        let mean = step(&Vector3::from_fn(|i, _| history[i].predict()), &twist, h)?;
        twist = 2.0 * mean - twist;
        (0..3).for_each(|i| history[i].push(twist[i]));
    }
    Ok(rows)
}
