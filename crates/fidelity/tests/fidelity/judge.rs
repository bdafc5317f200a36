//! Judges choices against a truth that is found in another way, and against all other runs.

use bristle_fidelity::{FidelityError, Scene, Tolerance, choose};

/// Scenes of each kind behind the promises of the documentation. They take minutes in release:
/// `cargo test --release -p bristle-fidelity -- --ignored --nocapture`.
pub(crate) const ALL: usize = 300;

/// The distance between answers and the truth in the sense of a tolerance.
pub(crate) fn distance(tolerance: Tolerance, a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let off = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    if tolerance.root_mean_square {
        return (off.map(|e| e * e).sum::<f64>() / a.len() as f64).sqrt();
    }
    // Not `f64::max`, which passes over NaN.
    off.fold(0.0, |most: f64, e| if e > most || e.is_nan() { e } else { most })
}

/// What became of drawn scenes.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    scenes: usize,
    wrong: Vec<String>,
    dear: Vec<String>,
    /// Within the default budget of a search, a second's work.
    undetermined: Vec<String>,
    /// Within ten times that budget.
    open: Vec<String>,
    /// Largest time of a search [s], and what for.
    slowest: (f64, String),
}

impl Tally {
    /// Judges one scene by the truth.
    pub(crate) fn judge(
        &mut self,
        scene: &dyn Scene,
        tolerance: Tolerance,
        truth: &[f64],
        what: &str,
    ) {
        self.judge_within(scene, tolerance, (truth, 0.0), what);
    }

    /// Judges one scene by a truth that is known to an error. If that is more than half of the
    /// tolerance nobody knows whether a choice is right, and none must be made.
    pub(crate) fn judge_within(
        &mut self,
        scene: &dyn Scene,
        tolerance: Tolerance,
        (truth, uncertainty): (&[f64], f64),
        what: &str,
    ) {
        self.scenes += 1;
        let clock = std::time::Instant::now();
        let chosen = choose(scene, tolerance);
        let time = clock.elapsed().as_secs_f64();
        if time > self.slowest.0 {
            self.slowest = (time, format!("{what}: {chosen:?}"));
        }
        let choice = match chosen {
            Ok(choice) => choice,
            Err(error @ FidelityError::Undetermined { .. }) => {
                self.undetermined.push(format!("{what}\n    {error}"));
                if cfg!(debug_assertions) {
                    return; // the next would take a minute
                }
                match choose(scene, Tolerance { budget: 10.0 * tolerance.budget, ..tolerance }) {
                    Ok(choice) => choice,
                    Err(error) => return self.open.push(format!("{what}\n    {error}")),
                }
            }
            Err(error) => panic!("{what}: {error}"),
        };
        let best = choice.best;
        let run = scene.run(best.level, best.steps).unwrap();
        // What is reported is what a run gives and costs, to the last evaluation.
        assert_eq!((run.evaluations, run.cost), (best.evaluations, best.cost), "{what}");
        let error = distance(tolerance, &run.answers, truth);
        let found = format!(
            "{what}\n    {error:e} of {:e}, known to {uncertainty:e}\n{choice}",
            tolerance.error
        );
        if !(error <= tolerance.error + uncertainty && uncertainty <= 0.5 * tolerance.error) {
            return self.wrong.push(found);
        }
        for level in scene.levels() {
            let mut steps = 1;
            while steps <= 1 << 16 {
                let other = scene.run(level, steps).unwrap();
                if other.cost >= 0.999 * best.cost {
                    break;
                }
                let error = distance(tolerance, &other.answers, truth);
                if error <= tolerance.error - uncertainty {
                    self.dear
                        .push(format!("{found}\nbut {level}, {steps}: {error:e}, {}", other.cost));
                    return;
                }
                if level.method.is_none() {
                    break;
                }
                steps *= 2;
            }
        }
    }

    /// No choice is wrong, one in twenty at most is dearer than need be, and one in twenty needs a
    /// larger budget than a second's work. With ten times the budget `most_open` are still open:
    /// masses that wait on the falling part of their curve, and undeclared jumps under a tolerance
    /// of a thousandth, which steps of fixed length meet to first order only.
    pub(crate) fn verdict(&self, most_open: usize) {
        let Self { scenes, wrong, dear, undetermined, open, slowest } = self;
        for line in undetermined.iter().chain(open).chain(dear) {
            println!("{line}\n");
        }
        println!("slowest: {slowest:?}");
        println!(
            "{scenes} scenes: {} wrong, {} dearer than need be, {} undetermined, {} of them with \
             ten times the budget",
            wrong.len(),
            dear.len(),
            undetermined.len(),
            open.len()
        );
        assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
        let few = (*scenes).max(20) / 20;
        assert!(dear.len() <= few, "{} of {scenes}", dear.len());
        assert!(undetermined.len() <= few, "{undetermined:#?}");
        assert!(open.len() <= most_open, "{open:#?}");
    }
}
