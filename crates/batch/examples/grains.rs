//! A hundred thousand contacts of glass spheres between two rough walls that shear them: contacts
//! are born and lost, and their bristles step as a batch.
//!
//! A face-centred lattice of spheres of 2 mm, their radii spread by 2 %, is compressed to about
//! 0.05 N for each contact, settles and is then sheared. Normal forces are linear springs with
//! dampers. Friction is FrBD on two axes in the tangential plane of each contact, under a normal
//! force that varies: a contact that is born begins at z = 0, whatever its slot held.
//!
//! Leaves `grains.csv` and `grains.svg`. Prints contacts per second, the ledger of the friction and
//! a hash of the final state; with `--features rayon` that of one thread and of two.

#[path = "grains/bed.rs"]
mod bed;

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use bed::{Bed, Report};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, println};

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Part of the run in which the bed settles before it is sheared.
const SETTLING: f64 = 0.2;

/// Runs the first of some steps, each of a duration [s], with a shear rate [1/s] after settling.
fn run(
    bed: &mut Bed,
    first: usize,
    (steps, duration, rate): (usize, f64, f64),
    mut look: impl FnMut(f64, Report) -> Outcome<()>,
) -> Outcome<()> {
    let settled = (SETTLING * steps as f64) as usize;
    for step in 0..first {
        if step == settled {
            bed.shear(rate);
        }
        let rate = if step < settled { 0.0 } else { rate };
        look((step + 1) as f64 * duration, bed.step(rate, duration)?)?;
    }
    Ok(())
}

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("grains", "A granular bed that is sheared")
            .count("cells", 24, "cells of the lattice along x and y, four spheres each")
            .must_be(Rule::Between(4.0, 200.0))
            .count("floors", 9, "cells of the lattice along z")
            .must_be(Rule::Between(3.0, 200.0))
            .count("steps", 300, "steps, the first fifth of them to settle")
            .must_be(Rule::Between(10.0, 1e6))
            .number("duration", 8e-6, "s", "duration of a step")
            .must_be(Rule::Between(1e-8, 1e-5))
            .number("rate", 30.0, "1/s", "shear rate")
            .must_be(Rule::Between(0.0, 1e3))
            .parse()?;
        let cells = [arguments.count("cells"), arguments.count("cells"), arguments.count("floors")];
        let timing =
            (arguments.count("steps"), arguments.number("duration"), arguments.number("rate"));
        let (steps, duration, rate) = timing;
        let settled = SETTLING * steps as f64 * duration;

        let columns =
            ["t", "strain", "shear", "pressure", "contacts", "born", "lost", "work", "stored"];
        let mut table = Csv::create(arguments.out_dir(), "grains", &columns)?;
        let mut bed = Bed::new(cells)?;
        let (mut stress, mut births, mut losses) = (Vec::new(), Vec::new(), Vec::new());
        let (mut works, mut stores) = (Vec::new(), Vec::new());
        let (mut work, mut least, mut contacts, mut changes) = (0.0, f64::INFINITY, 0, 0);
        let (mut before, mut smallest) = (0.0, f64::INFINITY);
        let start = Instant::now();
        run(&mut bed, steps, timing, |t, report| {
            let strain = rate * (t - settled).max(0.0);
            work += report.work;
            // What the friction has taken and neither holds nor gave back: step by step and in all.
            let lost = report.work - (report.stored - before);
            (before, least) = (report.stored, least.min(lost));
            smallest = smallest.min(work - report.stored);
            contacts += report.contacts;
            changes += report.born + report.lost;
            let Report { born, lost, .. } = report;
            let Report { shear, pressure, stored, .. } = report;
            let count = [report.contacts, born, lost].map(|count| count as f64);
            let row = [t, strain, shear, pressure, count[0], count[1], count[2], work, stored];
            table.row(&[], &row)?;
            if strain > 0.0 {
                stress.push((100.0 * strain, shear / pressure));
            }
            // The first step bears all contacts.
            if t > duration {
                births.push((1e3 * t, count[1]));
                losses.push((1e3 * t, count[2]));
            }
            works.push((1e3 * t, 1e3 * work));
            stores.push((1e3 * t, 1e3 * stored));
            Ok(())
        })?;
        let seconds = start.elapsed().as_secs_f64();
        table.finish()?;

        let each = contacts as f64 / steps as f64;
        println!(
            "{} spheres, {each:.0} contacts in a step, {changes} births and losses",
            bed.grains()
        );
        println!(
            "{:.2e} contacts a second, {seconds:.1} s for {steps} steps",
            contacts as f64 / seconds
        );
        println!("friction took {:.3e} J and holds {:.3e} J", work, before);
        println!("taken and not held: never below {smallest:.2e} J, in one step {least:.2e} J");
        assert!(smallest >= 0.0 && least >= 0.0, "the friction gave energy that was not stored");
        println!("state {:016x}", bed.hash());
        #[cfg(feature = "rayon")]
        threads(cells, timing)?;

        let mut density = [0.0; 25];
        let (mut all, width) = (0.0, 1.0 / 25.0);
        for share in bed.mobilised() {
            all += 1.0;
            if let Some(bin) = density.get_mut((share / width) as usize) {
                *bin += 1.0;
            }
        }
        let density: Vec<_> = density
            .iter()
            .enumerate()
            .flat_map(|(bin, count)| {
                let height = count / (all * width);
                [(bin as f64 * width, height), ((bin + 1) as f64 * width, height)]
            })
            .collect();
        let figure = Figure::new(900, 720)
            .title("A granular bed that is sheared")
            .columns(2)
            .panel(
                Panel::new("shear strain (%)", "shear stress over pressure τ/σ (–)")
                    .title("stress")
                    .line("", Colour::Blue, &stress),
            )
            .panel(
                Panel::new("time t (ms)", "contacts in a step (–)")
                    .title(format!("births and losses of {each:.0} contacts"))
                    .own_legend()
                    .vertical(1e3 * settled, "shear")
                    .line("born", Colour::Green, &births)
                    .line("lost", Colour::Orange.dashed(), &losses),
            )
            .panel(
                Panel::new("time t (ms)", "energy (mJ)")
                    .title("ledger of the friction")
                    .own_legend()
                    .vertical(1e3 * settled, "shear")
                    .line("taken from the grains", Colour::Blue, &works)
                    .line("stored in bristles", Colour::Vermilion.dashed(), &stores),
            )
            .panel(
                Panel::new("friction over static friction (–)", "probability density (–)")
                    .title("mobilised friction at the end")
                    .line("", Colour::Blue, &density),
            );
        println!("{}", figure.save(arguments.out_dir(), "grains")?.display());
        Ok(())
    })
}

/// The first steps again, on one thread and on two.
#[cfg(feature = "rayon")]
fn threads(cells: [usize; 3], timing: (usize, f64, f64)) -> Outcome<()> {
    let few = timing.0.min(20);
    let mut one = Bed::new(cells)?;
    run(&mut one, few, timing, |_, _| Ok(()))?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build()?;
    let two = pool.install(|| -> Result<_, String> {
        let mut two = Bed::new(cells).map_err(|error| error.to_string())?.in_parallel();
        run(&mut two, few, timing, |_, _| Ok(())).map_err(|error| error.to_string())?;
        Ok(two.hash())
    })?;
    println!("after {few} steps: one thread {:016x}, two {two:016x}", one.hash());
    assert_eq!(one.hash(), two, "threads changed the result");
    Ok(())
}
