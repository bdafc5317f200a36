//! Elements from a hysteresis loop: shares by non-negative least squares on the branches of the
//! outer loop alone, their number by cross-validation, then loops that were not used.
//!
//! Without a file the data are made: eighty elements, their strengths in a smooth distribution, and
//! noise of 1 % of the friction. With `--log` the first half of a measured record is fitted and the
//! second predicted. Leaves `outer_loop.csv` and `outer_loop.svg`.

use std::path::Path;
use std::process::ExitCode;

use bristle::curve::{Coulomb, CoulombParameters};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Result, noise, println, read_columns};
use bristle_memory::virgin::{self, VirginPoint};
use bristle_memory::{Element, MaxwellSlip, MaxwellSlipParameters, Parallel};

/// Numbers of elements that are tried.
const COUNTS: [usize; 10] = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32];
const FOLDS: usize = 4;

type Points = Vec<(f64, f64)>;

/// Displacement \[m\] and friction over normal force \[–\], row by row; the first `fitted` rows are
/// outer loops.
struct Record {
    rows: Points,
    fitted: usize,
}

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("outer_loop", "Elements from the outer loop alone")
            .text("log", "", "record of a tangential test; none: made data")
            .text(
                "columns",
                "t=1,x=2,f=3,p=4",
                "time, displacement, friction, load of --log, in SI",
            )
            .number("from", 0.0, "s", "time from which --log is used")
            .number("to", 1e9, "s", "time to which --log is used")
            .parse()?;
        let log = arguments.text("log");
        let record = if log.is_empty() {
            made()?
        } else {
            let span = arguments.number("from")..=arguments.number("to");
            read(Path::new(log), arguments.text("columns"), span)?
        };
        report(&record, arguments.out_dir())
    })
}

/// Six outer cycles of ±100 µm, then loops within loops.
fn made() -> Result<Record> {
    // Yield lengths up to 150 µm, most of them short.
    let elements = core::array::from_fn::<_, 80, _>(|i| {
        let yield_length = 150e-6 * ((i as f64 + 0.5) / 80.0).powi(2);
        Element { stiffness: 0.5 / 80.0 / yield_length.max(5e-6), yield_length }
    });
    let outer = [100.0, -100.0].repeat(6);
    let inner = [100.0, -60.0, 40.0, -20.0, 20.0, -40.0, 60.0, 10.0, 50.0, 0.0, 100.0, -100.0];
    let mut path = Points::new();
    let (mut place, mut fitted) = (0.0, 0);
    for (leg, end) in outer.iter().chain(&inner).enumerate() {
        fitted = if leg == outer.len() { path.len() } else { fitted };
        let count = f64::round(end - place).abs() as usize;
        path.extend(
            (1..=count).map(|n| (1e-6 * (place + (end - place) * n as f64 / count as f64), 0.0)),
        );
        place = *end;
    }
    let most = virgin::coefficient(&elements, 1.0);
    let mut noise = noise();
    let mut rows = predict(&elements, &path)?;
    rows.iter_mut().for_each(|row| row.1 += 0.01 * most * noise());
    Ok(Record { rows, fitted })
}

fn read(path: &Path, columns: &str, span: std::ops::RangeInclusive<f64>) -> Result<Record> {
    let columns = read_columns(path, columns)?;
    let named = |name: &str| -> Result<&[f64]> {
        let column = columns.iter().find(|column| column.0 == name);
        Ok(&column.ok_or_else(|| format!("--columns has no {name}"))?.1)
    };
    let (time, place, force, load) = (named("t")?, named("x")?, named("f")?, named("p")?);
    let used = (0..time.len()).filter(|&row| span.contains(&time[row]));
    let rows: Points = used.map(|row| (place[row], force[row] / load[row])).collect();
    Ok(Record { fitted: rows.len() / 2, rows })
}

/// Sharp elements along a path, from an unstretched contact.
fn predict<const N: usize>(elements: &[Element<f64>; N], path: &[(f64, f64)]) -> Result<Points> {
    let curve = CoulombParameters {
        dynamic_coefficient: virgin::coefficient(elements, f64::INFINITY),
        viscous_friction: 0.0,
    };
    let model = MaxwellSlip::new(MaxwellSlipParameters {
        curve: Coulomb::new(curve)?,
        elements: *elements,
        micro_damping: 0.0,
        stick_ratio: 0.95,
    })?;
    let (mut z, mut before) = (Parallel::default(), 0.0);
    let step = |&(place, _): &(f64, f64)| {
        let step = model.sharp_step(0.0, place - before, z);
        (z, before) = (step.deflection, place);
        (place, step.coefficient)
    };
    Ok(path.iter().map(step).collect())
}

/// The branches between turns, as virgin curves: half of the way and half of the force since the
/// turn (Masing).
fn branches(rows: &[(f64, f64)]) -> Vec<Vec<VirginPoint<f64>>> {
    let places = rows.iter().map(|row| row.0);
    let range =
        places.clone().fold(f64::NEG_INFINITY, f64::max) - places.fold(f64::INFINITY, f64::min);
    let (mut turns, mut extreme, mut rising) = (Vec::new(), 0, true);
    for (row, &(place, _)) in rows.iter().enumerate() {
        let beyond = if rising { place - rows[extreme].0 } else { rows[extreme].0 - place };
        if beyond >= 0.0 {
            extreme = row;
        } else if beyond < -0.05 * range {
            turns.push(extreme);
            (extreme, rising) = (row, !rising);
        }
    }
    let branch = |ends: &[usize]| {
        let (turn, branch) = (rows[ends[0]], &rows[ends[0] + 1..=ends[1]]);
        let halves = branch.iter().map(|row| VirginPoint {
            deflection: 0.5 * (row.0 - turn.0).abs(),
            coefficient: (0.5 * (row.1 - turn.1) * (row.0 - turn.0).signum()).max(0.0),
        });
        halves.filter(|point| point.deflection > 1e-3 * range).collect()
    };
    turns.windows(2).map(branch).collect()
}

/// Elements with yield lengths spread evenly up to the reach of the branches.
fn fit<const N: usize>(points: &[VirginPoint<f64>]) -> Result<[Element<f64>; N]> {
    let reach = points.iter().map(|point| point.deflection).fold(0.0, f64::max);
    let lengths = core::array::from_fn(|i| reach * (i as f64 + 1.0) / N as f64);
    Ok(virgin::fit(points, lengths)?)
}

fn root_mean_square(errors: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = errors.fold((0.0, 0.0), |(n, sum), error| (n + 1.0, sum + error * error));
    f64::sqrt(sum / count)
}

/// Errors over the range of the force: of branches that a fold leaves out, and of the record after
/// the fitted rows; and the predicted record.
fn assess<const N: usize>(record: &Record) -> Result<(f64, f64, Points)> {
    let (used, unseen) = record.rows.split_at(record.fitted);
    let forces = || record.rows.iter().map(|row| row.1);
    let range = forces().fold(f64::NEG_INFINITY, f64::max) - forces().fold(f64::INFINITY, f64::min);
    let branches = branches(used);
    let mut left_out = Vec::new();
    for fold in 0..FOLDS {
        let (out, kept): (Vec<_>, Vec<_>) =
            branches.iter().enumerate().partition(|(i, _)| i % FOLDS == fold);
        let kept: Vec<_> = kept.into_iter().flat_map(|branch| branch.1).copied().collect();
        let elements = fit::<N>(&kept)?;
        let off = |point: &VirginPoint<f64>| {
            // A branch is twice the virgin curve.
            2.0 * (virgin::coefficient(&elements, point.deflection) - point.coefficient)
        };
        left_out.extend(out.into_iter().flat_map(|branch| branch.1).map(off));
    }
    let elements = fit::<N>(&branches.concat())?;
    let predicted = predict(&elements, &record.rows)?.split_off(record.fitted);
    let errors = predicted.iter().zip(unseen).map(|(one, other)| one.1 - other.1);
    let found = (root_mean_square(left_out.into_iter()), root_mean_square(errors));
    Ok((found.0 / range, found.1 / range, predicted))
}

fn report(record: &Record, out: &Path) -> Result<()> {
    let found = [
        assess::<1>(record)?,
        assess::<2>(record)?,
        assess::<3>(record)?,
        assess::<4>(record)?,
        assess::<6>(record)?,
        assess::<8>(record)?,
        assess::<12>(record)?,
        assess::<16>(record)?,
        assess::<24>(record)?,
        assess::<32>(record)?,
    ];
    println!("elements  branches left out  loops that were not fitted (RMS over the range of F)");
    for (count, (left_out, unseen, _)) in COUNTS.iter().zip(&found) {
        println!("{count:8}  {:15.2} %  {:6.2} %", 1e2 * left_out, 1e2 * unseen);
    }
    // The fewest that are within 2 % of the least error of branches left out.
    let least = found.iter().map(|it| it.0).fold(f64::INFINITY, f64::min);
    let chosen = found.iter().position(|it| it.0 <= 1.02 * least).unwrap_or(0);
    println!("chosen by cross-validation: {}", COUNTS[chosen]);

    let unseen = &record.rows[record.fitted..];
    let mut table = Csv::create(out, "outer_loop", &["x", "measured", "predicted"])?;
    for (data, model) in unseen.iter().zip(&found[chosen].2) {
        table.row(&[], &[data.0, data.1, model.1])?;
    }
    table.finish()?;
    let micro = |points: &[(f64, f64)]| -> Points {
        points.iter().map(|point| (1e6 * point.0, point.1)).collect()
    };
    let axes = || Panel::new("displacement x (µm)", "friction over load F/p (–)").own_legend();
    let over = |of: &dyn Fn(&(f64, f64, Points)) -> f64| -> Points {
        COUNTS.iter().zip(&found).map(|(&count, it)| (count as f64, 1e2 * of(it))).collect()
    };
    let figure = Figure::new(1200, 400)
        .title("Elements from the outer loop alone, and loops that were not fitted")
        .columns(3)
        .panel(axes().title("fitted").line(
            "",
            Colour::Orange,
            micro(&record.rows[..record.fitted]),
        ))
        .panel(
            axes()
                .title(format!("not fitted, {} elements", COUNTS[chosen]))
                .line("data", Colour::Orange.width(4.0), micro(unseen))
                .line("predicted", Colour::Blue.width(1.2), micro(&found[chosen].2)),
        )
        .panel(
            Panel::new("number of elements n", "RMS error (% of the range of F)")
                .title("how many")
                .y_range(0.0..=10.0)
                .marked_line(
                    "branches left out",
                    Colour::Black.dashed(),
                    Colour::Black,
                    over(&|it| it.0),
                )
                .marked_line("not fitted", Colour::Blue, Colour::Blue, over(&|it| it.1))
                .own_legend(),
        );
    println!("\n{}", figure.save(out, "outer_loop")?.display());
    Ok(())
}

#[cfg(test)]
mod tests {
    /// From outer loops of ±100 µm with noise of 1 %: loops within loops that were not fitted.
    #[test]
    fn minor_loops_are_within_three_percent_of_the_range_of_force() -> super::Result<()> {
        let record = super::made()?;
        let [few, many] = [super::assess::<4>(&record)?.1, super::assess::<16>(&record)?.1];
        // The noise alone is 0.5 % of the range.
        assert!(many > 0.005 && many < 0.03 && few > 0.03, "{few} {many}");
        Ok(())
    }
}
