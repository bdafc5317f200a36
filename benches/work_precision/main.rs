//! Work over precision of every method on every scene: `cargo bench --bench work_precision`.
//!
//! Leaves `work_precision.csv` and a chart for every scene. Each point is one run over the whole
//! scene: its error against a [reference](reference) over all samples, and the shortest time of
//! several such runs. A run that fails is a row and a mark, too.
//!
//! `--scene WORD` and `--method WORD` keep what has the word in its name, `--out DIR` says where
//! the files go. `--phases` prints where the evaluations on stick-slip go, and nothing else.
//!
//! Read times as ratios within one run of this bench. What is unfair: the scenes are small (one to
//! four states), so that the linear algebra of an implicit method is nearly free; the relative
//! tolerance goes with absolute ones from each state's scale, which a user would have to know; and
//! every method here is told where the sliding velocity reverses, save the plain ones.
#![allow(unreachable_pub, reason = "another package includes these modules")]

mod chart;
mod measure;
mod methods;
mod phases;
mod reference;
mod row;
mod scenes;

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use bristle::ode::System;
use row::Row;

/// A reference that differs by more from another one of its kind is none.
const CONSISTENT: f64 = 1e-13;

const USAGE: &str = "usage: work_precision [--out DIR] [--scene WORD] [--method WORD] [--phases]";

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let options = Options::read(std::env::args().skip(1))?;
        if options.phases {
            return phases::report();
        }
        let mut bench = Bench { options, visited: 0, rows: Vec::new(), problem: None };
        let begin = Instant::now();
        scenes::each(&mut bench)?;
        let Bench { options, rows, problem, .. } = bench;
        println!("{}", row::write(&options.out, "work_precision", &rows)?.display());
        for path in chart::draw(&options.out, "work_precision", &rows)? {
            println!("{}", path.display());
        }
        println!("{:.0} s", begin.elapsed().as_secs_f64());
        problem.map_or(Ok(()), |problem| Err(problem.into()))
    })
}

/// What the command line asks for.
#[derive(Debug)]
struct Options {
    out: PathBuf,
    scene: String,
    method: String,
    phases: bool,
}

impl Options {
    fn read(mut words: impl Iterator<Item = String>) -> Result<Self, Box<dyn Error>> {
        let mut options = Self {
            out: "target/figures".into(),
            scene: String::new(),
            method: String::new(),
            phases: false,
        };
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or(USAGE);
            match word.as_str() {
                "--bench" => {} // `cargo bench` adds this on its own
                "--out" => options.out = value()?.into(),
                "--scene" => options.scene = value()?,
                "--method" => options.method = value()?,
                "--phases" => options.phases = true,
                _ => return Err(USAGE.into()),
            }
        }
        Ok(options)
    }
}

struct Bench {
    options: Options,
    visited: usize,
    rows: Vec<Row>,
    problem: Option<String>,
}

impl scenes::Visitor for Bench {
    fn visit<S: System<f64, N> + Clone, const N: usize>(&mut self, scene: &scenes::Scene<S, N>) {
        self.visited += 1;
        if !scene.name.contains(&self.options.scene) {
            return;
        }
        println!("{} {}, {} of {}", scene.name, scene.model, self.visited, scenes::COUNT);
        let begin = Instant::now();
        let solved = reference::reference(scene)
            .and_then(|samples| reference::check(scene, &samples).map(|check| (samples, check)));
        let (reference, check) = match solved {
            Ok(solved) => solved,
            Err(error) => {
                self.problem = Some(format!("{} {}: {error}", scene.name, scene.model));
                return;
            }
        };
        println!(
            "  reference: another one, of {} steps and {} reversals, differs by {:.1e}; \
             both took {:.1} s",
            check.steps,
            check.reversals,
            check.difference,
            begin.elapsed().as_secs_f64()
        );
        if !(check.difference < CONSISTENT) {
            let difference = check.difference;
            let text = format!("{} {}: two references differ by", scene.name, scene.model);
            self.problem = Some(format!("{text} {difference:e}"));
        }
        let mut methods = methods::all(scene);
        methods.retain(|method| method.name.contains(&self.options.method));
        let mut progress = bristle_charts::Progress::new("methods", methods.len());
        for method in methods {
            let rows = measure::sweep(scene, &reference, &method);
            progress.step();
            println!("  {}: setting, error, time / ms, evaluations", method.name);
            for row in &rows {
                print!("    {:8.1e} {:8.1e} {:9.3}", row.setting, row.error, 1e3 * row.seconds);
                println!(" {:9} {}", row.cost.rates, row.status());
            }
            self.rows.extend(rows);
        }
    }
}
