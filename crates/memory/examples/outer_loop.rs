//! Elements from a hysteresis loop: stiffnesses by non-negative least squares on the outer loop
//! alone, their number by cross-validation, then loops that were not used.
//!
//! Two records: a measured one, by default of a steel plate that yields (`outer_loop/u_plate.csv`
//! says whose), and made data of eighty elements with noise of 1 % of the friction. Strokes of at
//! least nine tenths of the longest are the outer loop; where there are no others, the first half
//! of the record is fitted and the second predicted. Leaves `outer_loop.csv` and `outer_loop.svg`.

use std::path::Path;
use std::process::ExitCode;

use bristle::curve::{Coulomb, CoulombParameters};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Result, noise, println, read_columns};
use bristle_memory::record::{self, RecordFit, RecordPoint};
use bristle_memory::virgin;
use bristle_memory::{Element, MaxwellSlip, MaxwellSlipParameters, Parallel};

/// Numbers of elements that are tried.
const COUNTS: [usize; 9] = [2, 3, 4, 6, 8, 12, 16, 24, 32];
const FOLDS: usize = 4;
const PLATE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/outer_loop/u_plate.csv");

type Points = Vec<(f64, f64)>;

/// What a row is used for.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Use {
    /// It is fitted, with the other rows of a stroke.
    Outer(usize),
    Unseen,
    /// Its elements are not known: a record that does not begin unstretched.
    Unknown,
}

struct Record {
    name: &'static str,
    /// Displacement \[m\] and force over its range \[–\].
    rows: Points,
    uses: Vec<Use>,
}

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("outer_loop", "Elements from the outer loop alone")
            .text("log", PLATE, "record of a slow tangential test")
            .text("columns", "x=1*1e-3,f=2*1e3", "displacement, force; if wanted, load p, time t")
            .number("from", -1e9, "s", "time (row, without t) from which --log is used")
            .number("to", 1e9, "s", "time (row, without t) to which --log is used")
            .parse()?;
        let span = arguments.number("from")..=arguments.number("to");
        let log = Path::new(arguments.text("log"));
        let measured = sorted("measured", read(log, arguments.text("columns"), span)?);
        report([measured, sorted("made", made()?)], arguments.out_dir())
    })
}

/// Six outer cycles of ±100 µm, then loops within loops.
fn made() -> Result<Points> {
    // Yield lengths up to 150 µm, most of them short.
    let elements = core::array::from_fn::<_, 80, _>(|i| {
        let yield_length = 150e-6 * ((i as f64 + 0.5) / 80.0).powi(2);
        Element { stiffness: 0.5 / 80.0 / yield_length.max(5e-6), yield_length }
    });
    let outer = [100.0, -100.0].repeat(6);
    let inner = [95.0, -60.0, 40.0, -20.0, 20.0, -40.0, 60.0, 10.0, 50.0, 0.0, 75.0];
    let (mut path, mut place) = (vec![(0.0, 0.0)], 0.0);
    for end in outer.iter().chain(&inner) {
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
    Ok(rows)
}

fn read(path: &Path, columns: &str, span: std::ops::RangeInclusive<f64>) -> Result<Points> {
    let columns = read_columns(path, columns)?;
    let named = |name: &str| columns.iter().find(|column| column.0 == name).map(|column| &column.1);
    let (Some(place), Some(force)) = (named("x"), named("f")) else {
        return Err("--columns has no x or no f".into());
    };
    let at = |name: &str, row: usize, other: f64| named(name).map_or(other, |values| values[row]);
    let used = (0..place.len()).filter(|&row| span.contains(&at("t", row, row as f64)));
    let rows = used.map(|row| (place[row] - place[0], force[row] / at("p", row, 1.0)));
    Ok(filled(&rows.collect::<Points>()))
}

/// With points on the line between those that are far apart, as digitised ones are.
fn filled(rows: &[(f64, f64)]) -> Points {
    let step = 0.003 * range(rows.iter().map(|row| row.0));
    let mut all = vec![rows[0]];
    for pair in rows.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        let count = ((to.0 - from.0).abs() / step).ceil().max(1.0);
        all.extend((1..=count as usize).map(|i| {
            let share = i as f64 / count;
            (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1))
        }));
    }
    all
}

/// Finds the strokes of the outer loop, and brings the force to its range.
fn sorted(name: &'static str, mut rows: Points) -> Record {
    let range = range(rows.iter().map(|row| row.1));
    rows.iter_mut().for_each(|row| row.1 /= range);
    let turns = turns(&rows);
    let strokes: Vec<_> = turns.windows(2).collect();
    let length = |stroke: &[usize]| (rows[stroke[1]].0 - rows[stroke[0]].0).abs();
    let longest = strokes.iter().map(|stroke| length(stroke)).fold(0.0, f64::max);
    let is_outer = |stroke: &&&[usize]| length(stroke) >= 0.9 * longest;
    let all_outer = strokes.iter().filter(|stroke| !is_outer(stroke)).count() < 2;
    let first = if all_outer { turns[2] } else { 0 };
    let mut uses: Vec<_> =
        (0..rows.len()).map(|row| if row <= first { Use::Unknown } else { Use::Unseen }).collect();
    for (i, stroke) in strokes.iter().filter(is_outer).enumerate() {
        if stroke[0] >= first && (!all_outer || 2 * stroke[1] < rows.len()) {
            uses[stroke[0] + 1..=stroke[1]].fill(Use::Outer(i));
        }
    }
    Record { name, rows, uses }
}

fn range(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().fold(f64::NEG_INFINITY, f64::max) - values.fold(f64::INFINITY, f64::min)
}

/// The rows at which the motion turns, the first and the last among them.
fn turns(rows: &[(f64, f64)]) -> Vec<usize> {
    let back = 0.01 * range(rows.iter().map(|row| row.0));
    let (mut turns, mut extreme, mut rising) = (vec![0], 0, true);
    for (row, &(place, _)) in rows.iter().enumerate() {
        let beyond = if rising { place - rows[extreme].0 } else { rows[extreme].0 - place };
        if beyond >= 0.0 {
            extreme = row;
        } else if beyond < -back {
            turns.push(extreme);
            (extreme, rising) = (row, !rising);
        }
    }
    turns.push(rows.len() - 1);
    turns.dedup();
    turns
}

/// Elements with yield lengths up to half of the outer stroke, most of them short.
fn fit<const N: usize>(record: &Record, kept: impl Fn(usize) -> bool) -> Result<RecordFit<f64, N>> {
    let outer = || record.rows.iter().zip(&record.uses);
    let fitted = outer().filter(|(_, role)| matches!(role, Use::Outer(_)));
    let reach = 0.5 * range(fitted.map(|(row, _)| row.0).collect::<Vec<_>>().into_iter());
    let lengths = core::array::from_fn(|i| reach * ((i as f64 + 1.0) / N as f64).powi(2));
    let point = |(&(displacement, coefficient), role): (&(f64, f64), &Use)| {
        let weight = f64::from(matches!(role, Use::Outer(stroke) if kept(*stroke)));
        RecordPoint { displacement, coefficient, weight }
    };
    Ok(record::fit(&outer().map(point).collect::<Vec<_>>(), lengths)?)
}

/// Sharp elements along a path, unstretched at its beginning.
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
    let (mut z, mut before) = (Parallel::default(), path[0].0);
    let step = |&(place, _): &(f64, f64)| {
        let step = model.sharp_step(0.0, place - before, z);
        (z, before) = (step.deflection, place);
        (place, step.coefficient)
    };
    Ok(path.iter().map(step).collect())
}

/// What a number of elements gives; errors over the range of the force.
struct Found {
    /// RMS error of strokes that a fold leaves out.
    left_out: f64,
    /// RMS and largest error of the loops that were not used.
    unseen: f64,
    largest: f64,
    predicted: Points,
}

fn assess<const N: usize>(record: &Record) -> Result<Found> {
    let errors = |fitted: &RecordFit<f64, N>, counts: &dyn Fn(Use) -> bool| -> Result<Vec<f64>> {
        let predicted = predict(&fitted.elements, &record.rows)?;
        let pairs = predicted.iter().zip(&record.rows).zip(&record.uses);
        let counted = pairs.filter(|(_, role)| counts(**role));
        Ok(counted.map(|((one, other), _)| one.1 + fitted.offset - other.1).collect())
    };
    let mut left_out = Vec::new();
    for fold in 0..FOLDS {
        let fitted = fit::<N>(record, |stroke| stroke % FOLDS != fold)?;
        let out = |role| matches!(role, Use::Outer(stroke) if stroke % FOLDS == fold);
        left_out.extend(errors(&fitted, &out)?);
    }
    let fitted = fit::<N>(record, |_| true)?;
    let unseen = errors(&fitted, &|role| role == Use::Unseen)?;
    let mut predicted = predict(&fitted.elements, &record.rows)?;
    predicted.iter_mut().for_each(|row| row.1 += fitted.offset);
    let rms = |errors: &[f64]| {
        f64::sqrt(errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64)
    };
    let largest = unseen.iter().fold(0.0, |most: f64, error| most.max(error.abs()));
    Ok(Found { left_out: rms(&left_out), unseen: rms(&unseen), largest, predicted })
}

/// All numbers of elements, and the place of the chosen one: the fewest that are within 2 % of the
/// least error of strokes left out.
fn study(record: &Record) -> Result<([Found; 9], usize)> {
    let found = [
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
    let least = found.iter().map(|it| it.left_out).fold(f64::INFINITY, f64::min);
    let chosen = found.iter().position(|it| it.left_out <= 1.02 * least).unwrap_or(0);
    Ok((found, chosen))
}

fn report(records: [Record; 2], out: &Path) -> Result<()> {
    let mut table = Csv::create(out, "outer_loop", &["record", "x", "measured", "predicted"])?;
    let mut figure = Figure::new(1200, 760).columns(3);
    figure = figure.title("Elements from the outer loop alone, and loops that were not used");
    for record in &records {
        let (found, chosen) = study(record)?;
        println!("{}: RMS errors over the range of the force", record.name);
        println!("elements  strokes left out  loops not used  (largest)");
        for (count, it) in COUNTS.iter().zip(&found) {
            let [left_out, unseen, largest] =
                [it.left_out, it.unseen, it.largest].map(|error| 1e2 * error);
            println!("{count:8}  {left_out:14.2} %  {unseen:12.2} %  {largest:7.1} %");
        }
        println!("chosen by cross-validation: {}\n", COUNTS[chosen]);
        for (data, model) in record.rows.iter().zip(&found[chosen].predicted) {
            table.row(&[record.name], &[data.0, data.1, model.1])?;
        }
        for panel in panels(record, &found, chosen) {
            figure = figure.panel(panel);
        }
    }
    table.finish()?;
    println!("{}", figure.save(out, "outer_loop")?.display());
    Ok(())
}

fn panels(record: &Record, found: &[Found; 9], chosen: usize) -> [Panel; 3] {
    let part = |points: &[(f64, f64)], wanted: &dyn Fn(Use) -> bool| -> Points {
        let chosen = points.iter().zip(&record.uses).filter(|(_, role)| wanted(**role));
        chosen.map(|(&(place, force), _)| (1e3 * place, force)).collect()
    };
    let unseen = |role: Use| role == Use::Unseen;
    let axes = || Panel::new("displacement x (mm)", "force F over its range (–)").own_legend();
    let over = |of: &dyn Fn(&Found) -> f64| -> Points {
        COUNTS.iter().zip(found).map(|(&count, it)| (count as f64, 1e2 * of(it))).collect()
    };
    let outer = part(&record.rows, &|role| matches!(role, Use::Outer(_)));
    let predicted = part(&found[chosen].predicted, &unseen);
    [
        axes().title(format!("{}: fitted", record.name)).line("", Colour::Orange, outer),
        axes()
            .title(format!("{}: not used, {} elements", record.name, COUNTS[chosen]))
            .line("data", Colour::Orange.width(4.0), part(&record.rows, &unseen))
            .line("predicted", Colour::Blue.width(1.2), predicted),
        Panel::new("number of elements n", "RMS error (% of the range of F)")
            .title("how many")
            .y_range(0.0..=10.0)
            .marked_line(
                "strokes left out",
                Colour::Black.dashed(),
                Colour::Black,
                over(&|it| it.left_out),
            )
            .marked_line("not used", Colour::Blue, Colour::Blue, over(&|it| it.unseen))
            .own_legend(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From outer loops of ±100 µm with noise of 1 %: loops within loops that were not used.
    #[test]
    fn minor_loops_of_made_data_are_predicted_to_the_noise() -> Result<()> {
        let record = sorted("made", made()?);
        let [few, many] = [assess::<2>(&record)?.unseen, assess::<16>(&record)?.unseen];
        // The noise alone is 0.5 % of the range.
        assert!(many > 0.0045 && many < 0.01 && few > 0.03, "{few} {many}");
        Ok(())
    }

    /// Smaller loops of a measured damper, from its outer loop.
    #[test]
    fn measured_minor_loops_are_within_three_percent_of_the_range_of_force() -> Result<()> {
        let rows = read(Path::new(PLATE), "x=1*1e-3,f=2*1e3", -1.0..=1e9)?;
        let (found, chosen) = study(&sorted("measured", rows))?;
        let unseen = found[chosen].unseen;
        assert!(unseen < 0.03 && found[0].unseen > 0.1, "{unseen}");
        Ok(())
    }
}
