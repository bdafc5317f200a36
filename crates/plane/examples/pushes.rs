//! A limit surface from pushes: how well ellipsoids, a polynomial and a support of points predict
//! the twist of a wrench, over the number of pushes that they were fitted to.
//!
//! Leaves `pushes.csv` and `pushes.svg` of a plate on three feet, with noise. With `--pushes` it
//! reads measured pairs, fits each half of a file and predicts the other.

use std::process::ExitCode;

use bristle::curve::{Coulomb, CoulombParameters};
use bristle::nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle_charts::{
    Arguments, Colour, Csv, Figure, Marker, Panel, Result, Rule, Values, noise, println,
    read_columns,
};
use bristle_plane::{
    EllipsoidFamily, Footprint, FootprintPoint, FrictionEllipsoid, PlaneBristle, PlaneFrBd, Push,
    Support,
};

type Points = Vec<FootprintPoint<f64>>;
type Twist = Vector3<f64>;

/// What predicts a twist from a wrench.
const PREDICTORS: [(&str, Colour); 4] = [
    ("isotropic ellipsoid", Colour::Grey),
    ("any ellipsoid", Colour::Orange),
    ("fourth degree", Colour::Green),
    ("support of points", Colour::Blue),
];

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("pushes", "Limit surfaces from pushes")
            .files("pushes", "measured pairs: v_x, v_y, omega, F_x, F_y, M in SI units")
            .number("size", 0.1, "m", "side of the square of 15 × 15 points")
            .must_be(Rule::Positive)
            .number("x", 0.0, "m", "its centre")
            .number("y", 0.0, "m", "its centre")
            .number("noise", 0.05, "", "of the simulated wrenches, over the friction force")
            .must_be(Rule::Positive)
            .number("regulariser", 1e-2, "", "of the weights of the points")
            .must_be(Rule::Positive)
            .parse()?;
        if arguments.files("pushes").is_empty() {
            simulated(&arguments)
        } else {
            measured(&arguments)
        }
    })
}

/// Friction of 1 N over points.
fn on(points: Points) -> Result<Footprint<f64, impl PlaneBristle<f64, 2>, Points>> {
    let curve = CoulombParameters { dynamic_coefficient: 1.0, viscous_friction: 0.0 };
    let bristle = KelvinVoigtParameters { micro_stiffness: 1e4, micro_damping: 10.0 };
    let contact = PlaneFrBd::isotropic(Coulomb::new(curve)?, KelvinVoigt::new(bristle)?);
    Ok(Footprint::new(contact.under_load(1.0)?, points)?)
}

fn grid(arguments: &Values) -> Points {
    let (size, centre) = (arguments.number("size"), [arguments.number("x"), arguments.number("y")]);
    let moved = |mut point: FootprintPoint<f64>| {
        (point.place[0], point.place[1]) = (point.place[0] + centre[0], point.place[1] + centre[1]);
        point
    };
    FootprintPoint::rectangle([size, size], [15, 15]).map(moved).collect()
}

/// The angles [rad] between measured and predicted twists of `test`, of each predictor.
fn angles(
    arguments: &Values,
    train: &[Push<f64>],
    test: &[Push<f64>],
) -> Result<[Vec<f64>; PREDICTORS.len()]> {
    // The rms distance of the points of the square from its centre, and noises of its size.
    let length = arguments.number("size") / 6.0_f64.sqrt();
    let force = train.iter().map(|push| push.wrench.xy().norm()).sum::<f64>() / train.len() as f64;
    let deviation = Vector3::new(force, force, force * length) * arguments.number("noise");
    let predict = |twist: &dyn Fn(&Twist) -> Result<Twist>| {
        let angle = |push: &Push<f64>| Ok(push.angle(&twist(&push.wrench)?, length));
        test.iter().map(angle).collect::<Result<Vec<f64>>>()
    };
    let ellipsoid = |family| {
        let fit = FrictionEllipsoid::fit(train, family, &deviation)?;
        predict(&|wrench| Ok(fit.ellipsoid.twist(wrench)?.twist))
    };
    let support =
        Support::fit(&grid(arguments), train, &deviation, arguments.number("regulariser"))?;
    let support = on(support.points)?;
    let surface = fourth_degree(train, force, length)?;
    Ok([
        ellipsoid(EllipsoidFamily::Isotropic)?,
        ellipsoid(EllipsoidFamily::Turned)?,
        predict(&|wrench| Ok(surface(wrench)))?,
        predict(&|wrench| Ok(support.sliding_twist(wrench, 1e-3)?.twist))?,
    ])
}

/// The gradient of the homogeneous polynomial of the fourth degree that is nearest to one at the
/// wrenches, with gradients along the twists: the family of Zhou and others (2016), without their
/// condition that it be convex.
fn fourth_degree(
    pushes: &[Push<f64>],
    force: f64,
    length: f64,
) -> Result<impl Fn(&Twist) -> Twist + use<>> {
    let unit = Vector3::new(1.0 / force, 1.0 / force, 1.0 / (force * length));
    let powers = || (0..=4).flat_map(|a| (0..=4 - a).map(move |b| [a, b, 4 - a - b]));
    let terms = move |w: &Twist| {
        let (mut values, mut slopes) =
            (SVector::<f64, 15>::zeros(), SMatrix::<f64, 3, 15>::zeros());
        for (k, powers) in powers().enumerate() {
            let term = |powers: [i32; 3]| (0..3).map(|i| w[i].powi(powers[i])).product::<f64>();
            values[k] = term(powers);
            for i in (0..3).filter(|&i| powers[i] > 0) {
                let mut less = powers;
                less[i] -= 1;
                slopes[(i, k)] = f64::from(powers[i]) * term(less);
            }
        }
        (values, slopes)
    };
    let mut matrix = SMatrix::<f64, 15, 15>::identity() * (1e-3 * pushes.len() as f64);
    let mut right = SVector::<f64, 15>::zeros();
    for push in pushes {
        let (values, slopes) = terms(&push.wrench.component_mul(&unit));
        let along = push.twist.component_mul(&Vector3::new(1.0, 1.0, length)).normalize();
        let across = (Matrix3::identity() - along * along.transpose()) * slopes;
        matrix += across.transpose() * across + values * values.transpose();
        right += values;
    }
    let solver = matrix.cholesky().ok_or("the polynomial is not determined")?;
    let solution = solver.solve(&right);
    Ok(move |w: &Twist| (terms(&w.component_mul(&unit)).1 * solution).component_mul(&unit))
}

fn median(mut angles: Vec<f64>) -> f64 {
    angles.sort_by(f64::total_cmp);
    angles[angles.len() / 2].to_degrees()
}

fn measured(arguments: &Values) -> Result<()> {
    println!("{:40} median angle (degrees)", "");
    println!("{:40} {}", "", PREDICTORS.map(|(name, _)| format!("{name:>20}")).join(""));
    let mut all: [Vec<f64>; PREDICTORS.len()] = Default::default();
    let row = |name: &str, of: &[Vec<f64>]| {
        let cells = of.iter().map(|angles| format!("{:20.1}", median(angles.clone())));
        println!("{name:40} {}", cells.collect::<String>());
    };
    for path in arguments.files("pushes") {
        let columns = read_columns(path, "vx=1,vy=2,omega=3,fx=4,fy=5,m=6")?;
        let [v_x, v_y, omega, f_x, f_y, m] = [0, 1, 2, 3, 4, 5].map(|i| &columns[i].1);
        let push = |i: usize| Push {
            twist: Vector3::new(v_x[i], v_y[i], omega[i]),
            wrench: Vector3::new(f_x[i], f_y[i], m[i]),
        };
        let half = |odd| (odd..m.len()).step_by(2).map(push).collect::<Vec<_>>();
        let mut here: [Vec<f64>; PREDICTORS.len()] = Default::default();
        for (train, test) in [(half(0), half(1)), (half(1), half(0))] {
            let angles = angles(arguments, &train, &test)?;
            here.iter_mut().zip(angles).for_each(|(all, some)| all.extend(some));
        }
        row(&path.file_stem().unwrap_or_default().to_string_lossy(), &here);
        all.iter_mut().zip(here).for_each(|(all, some)| all.extend(some));
    }
    row("all", &all);
    Ok(())
}

fn simulated(arguments: &Values) -> Result<()> {
    // Three feet, none of them a point of the grid.
    let feet = [([-0.04, -0.035], 0.5), ([0.042, -0.028], 0.3), ([0.005, 0.043], 0.2)];
    let plate = on(feet.map(|(place, weight)| FootprintPoint { place, weight }).to_vec())?;
    let mut noise = noise();
    let mut push = |scatter: f64| {
        let twist = Vector3::new(noise(), noise(), noise() / 0.04);
        let error = Vector3::new(noise(), noise(), 0.04 * noise()) * scatter;
        Push { twist, wrench: plate.stationary_wrench(&twist) + error }
    };
    let test: Vec<_> = (0..500).map(|_| push(0.0)).collect();
    let train: Vec<_> = (0..200).map(|_| push(arguments.number("noise"))).collect();
    let mut lines = PREDICTORS.map(|_| Vec::new());
    let mut table = Csv::create(arguments.out_dir(), "pushes", &["predictor", "pushes", "angle"])?;
    for count in [6, 10, 20, 50, 100, 200] {
        let angles = angles(arguments, &train[..count], &test)?;
        for ((line, angles), (name, _)) in lines.iter_mut().zip(angles).zip(PREDICTORS) {
            line.push((count as f64, median(angles)));
            table.row(&[name], &[count as f64, line[line.len() - 1].1])?;
            println!("{count:4} pushes, {name:20} {:5.2}°", line[line.len() - 1].1);
        }
    }
    table.finish()?;
    let mut panel = Panel::new("pushes", "median angle (degrees)").log_x().log_y();
    for ((name, colour), line) in PREDICTORS.iter().zip(&lines) {
        panel = panel.marked_line(name, *colour, *colour, line);
    }
    let deviation = Vector3::new(1.0, 1.0, 0.04) * arguments.number("noise");
    let found =
        Support::fit(&grid(arguments), &train, &deviation, arguments.number("regulariser"))?;
    let mut places = Panel::new("x (mm)", "y (mm)").equal_scales();
    let at = |points: &[FootprintPoint<f64>], range: std::ops::Range<f64>| -> Vec<(f64, f64)> {
        let inside = points.iter().filter(|point| range.contains(&point.weight));
        inside.map(|point| (1e3 * point.place[0], 1e3 * point.place[1])).collect()
    };
    places = places
        .points("found: 0.2 to 2 % of the load", Colour::Sky, at(&found.points, 0.002..0.02))
        .points("more", Colour::Blue, at(&found.points, 0.02..1.1))
        .points(
            "feet",
            Colour::Vermilion.marked(Marker::Square).size(4.0),
            at(plate.points(), 0.0..1.1),
        );
    let figure = Figure::new(980, 420).title("Limit surfaces from pushes").columns(2);
    let saved = figure.panel(panel).panel(places).save(arguments.out_dir(), "pushes")?;
    println!("\n{}", saved.display());
    Ok(())
}
