//! How much dearer the best peer is than our best, at the same achieved error.
//!
//! Each side's *lower envelope* on a scene is what is left of all its runs that reached the end
//! when every run is dropped that another one beats in both error and CPU time. On it, log CPU
//! time is interpolated over log error. A run that is more accurate than asked for counts at its
//! own cost; nothing is extrapolated towards smaller errors: such a level is not reached.
//!
//! Between two points that belong to different methods, or lie far apart, the interpolation
//! flatters its side a little: peers and ours alike.

use crate::counts::LEVELS;
use crate::row::Row;

/// What a side pays for an error.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cost {
    /// The method of the nearest run that achieves it.
    pub(crate) who: String,
    /// CPU time [s].
    pub(crate) cpu_s: f64,
    /// Evaluations of the right-hand side.
    pub(crate) rhs_evals: f64,
}

/// Both sides at one error on one scene.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Comparison {
    pub(crate) scene: String,
    pub(crate) model: String,
    pub(crate) level: f64,
    /// The best peer, or none that reaches the level.
    pub(crate) peer: Option<Cost>,
    /// Our best, or none that reaches the level.
    pub(crate) ours: Option<Cost>,
}

impl Comparison {
    /// CPU time of the best peer over ours.
    pub(crate) fn ratio(&self) -> Option<f64> {
        Some(self.peer.as_ref()?.cpu_s / self.ours.as_ref()?.cpu_s)
    }
}

/// Compares everyone with the crate `ours`, on every scene in the order of the rows.
pub(crate) fn compare(rows: &[Row], ours: &str) -> Vec<Comparison> {
    let mut scenes: Vec<(&str, &str)> = Vec::new();
    for row in rows {
        if !scenes.contains(&(&row.scene, &row.model)) {
            scenes.push((&row.scene, &row.model));
        }
    }
    let mut comparisons = Vec::new();
    for (scene, model) in scenes {
        let here = || rows.iter().filter(move |row| row.scene == scene && row.model == model);
        let peers = envelope(here().filter(|row| row.crate_ != ours));
        let our_own = envelope(here().filter(|row| row.crate_ == ours));
        comparisons.extend(LEVELS.iter().map(|&level| Comparison {
            scene: scene.to_owned(),
            model: model.to_owned(),
            level,
            peer: cost(&peers, level),
            ours: cost(&our_own, level),
        }));
    }
    comparisons
}

/// The undominated runs, the most accurate first.
pub(crate) fn envelope<'a>(rows: impl Iterator<Item = &'a Row>) -> Vec<(f64, &'a Row)> {
    let mut points: Vec<(f64, &Row)> =
        rows.filter_map(|row| Some((row.achieved()?.max(f64::MIN_POSITIVE), row))).collect();
    points.sort_by(|(a, x), (b, y)| a.total_cmp(b).then(x.cpu_s.total_cmp(&y.cpu_s)));
    let mut cheapest = f64::INFINITY;
    points.retain(|(_, row)| {
        let better = row.cpu_s < cheapest;
        cheapest = cheapest.min(row.cpu_s);
        better
    });
    points
}

fn cost(envelope: &[(f64, &Row)], level: f64) -> Option<Cost> {
    let reaching = envelope.partition_point(|&(error, _)| error <= level);
    let &(error, row) = envelope[..reaching].last()?;
    let who = row.who();
    let (cpu_s, rhs_evals) = (row.cpu_s, row.rhs_evals as f64);
    let Some(&(looser, next)) = envelope.get(reaching) else {
        return Some(Cost { who, cpu_s, rhs_evals });
    };
    let weight = (level / error).ln() / (looser / error).ln();
    let between = |near: f64, far: f64| near * (far / near).powf(weight);
    let rhs_evals = between(rhs_evals.max(1.0), (next.rhs_evals as f64).max(1.0));
    Some(Cost { who, cpu_s: between(cpu_s, next.cpu_s), rhs_evals })
}

/// The table in Markdown.
pub(crate) fn markdown(comparisons: &[Comparison], ours: &str) -> String {
    let mut table = format!(
        "| scene | model | error | best peer | ms | evaluations | {ours} | ms | evaluations \
         | ratio |\n\
         |---|---|---|---|---|---|---|---|---|---|\n"
    );
    for comparison in comparisons {
        let Comparison { scene, model, level, peer, ours } = comparison;
        let cells = |cost: &Option<Cost>| match cost {
            Some(Cost { who, cpu_s, rhs_evals }) => {
                format!("{who} | {} | {rhs_evals:.0}", digits(cpu_s * 1e3))
            }
            None => "not reached | – | –".to_owned(),
        };
        let ratio = match comparison.ratio() {
            Some(ratio) => digits(ratio),
            None if ours.is_some() => "no peer".to_owned(),
            None => "–".to_owned(),
        };
        table += &format!(
            "| {scene} | {model} | {level:e} | {} | {} | {ratio} |\n",
            cells(peer),
            cells(ours)
        );
    }
    table
}

/// Three significant digits.
fn digits(value: f64) -> String {
    let places = (2.0 - value.abs().log10().floor()).clamp(0.0, 9.0);
    format!("{value:.*}", places as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::OK;

    fn row(who: (&str, &str), error: f64, cpu_s: f64) -> Row {
        Row {
            scene: "S".to_owned(),
            model: "frbd".to_owned(),
            crate_: who.0.to_owned(),
            method: who.1.to_owned(),
            setting: String::new(),
            error: Some(error),
            cpu_s,
            rhs_evals: (cpu_s * 1e6) as u64,
            jac_evals: 0,
            steps: 0,
            rejected: 0,
            status: OK.to_owned(),
        }
    }

    const OURS: (&str, &str) = ("ours", "method");
    const PEER: (&str, &str) = ("peer", "method");

    /// The comparison at a level.
    fn at(rows: &[Row], level: f64) -> Comparison {
        let mut found = compare(rows, "ours").into_iter().filter(|c| c.level == level);
        match (found.next(), found.next()) {
            (Some(comparison), None) => comparison,
            several => panic!("one comparison at {level}, not {several:?}"),
        }
    }

    fn close(a: Option<f64>, b: f64) -> bool {
        a.is_some_and(|a| (a / b - 1.0).abs() < 1e-12) // a few roundings of exp and ln
    }

    #[test]
    fn costs_are_interpolated_between_the_logarithms() {
        // Half way from 1e-8 to 1e-4 on a logarithmic axis: √(8·2) = 4; ours is exactly there.
        let rows = [row(PEER, 1e-4, 2.0), row(PEER, 1e-8, 8.0), row(OURS, 1e-6, 0.5)];
        assert!(close(at(&rows, 1e-6).ratio(), 8.0));
        assert!(close(at(&rows, 1e-6).peer.map(|cost| cost.rhs_evals), 4e6));
    }

    #[test]
    fn a_level_that_nobody_reaches_is_not_extrapolated() {
        let rows = [row(PEER, 1e-5, 2.0), row(PEER, 2e-9, 8.0), row(OURS, 1e-10, 1.0)];
        let tight = at(&rows, 1e-9);
        assert_eq!(
            (tight.peer.is_some(), tight.ours.is_some(), tight.ratio()),
            (false, true, None)
        );
        let table = markdown(&compare(&rows, "ours"), "ours");
        assert!(
            table.contains(
                "| 1e-9 | not reached | – | – | ours/method | 1000 | 1000000 | no peer |"
            ),
            "{table}"
        );
    }

    #[test]
    fn a_run_better_than_asked_for_counts_at_its_own_cost() {
        let rows = [row(PEER, 1e-7, 3.0), row(OURS, 1e-12, 1.5)];
        assert!(close(at(&rows, 1e-3).ratio(), 2.0));
    }

    #[test]
    fn the_envelope_takes_the_cheapest_of_all_methods() {
        let rows = [
            row(("peer", "slow"), 1e-3, 5.0),
            row(("other", "fast"), 1e-3, 1.0),
            row(("peer", "slow"), 1e-6, 6.0),
            row(("other", "fast"), 1e-6, 9.0),
            // Dearer than the one at 1e-6 and less accurate: a detour no envelope takes.
            row(("peer", "erratic"), 1e-4, 7.0),
            row(OURS, 1e-9, 1.0),
        ];
        let loose = at(&rows, 1e-3).peer;
        assert_eq!(loose.as_ref().map(|cost| cost.who.as_str()), Some("other/fast"));
        assert!(close(loose.map(|cost| cost.cpu_s), 1.0));
        let tight = at(&rows, 1e-6).peer;
        assert_eq!(tight.as_ref().map(|cost| cost.who.as_str()), Some("peer/slow"));
        assert!(close(tight.map(|cost| cost.cpu_s), 6.0));
    }

    #[test]
    fn failed_runs_do_not_count() {
        let failed = Row { status: "stiff".to_owned(), ..row(PEER, 1e-9, 0.1) };
        let endless = Row { error: None, ..row(PEER, 0.0, 0.1) };
        let rows = [failed, endless, row(PEER, 1e-9, 4.0), row(OURS, 1e-9, 2.0)];
        assert!(close(at(&rows, 1e-9).ratio(), 2.0));
    }

    #[test]
    fn scenes_and_models_are_kept_apart() {
        let other = Row { model: "lugre".to_owned(), ..row(PEER, 1e-9, 0.1) };
        let rows = [row(PEER, 1e-9, 4.0), other, row(OURS, 1e-9, 2.0)];
        let ratios: Vec<_> = compare(&rows, "ours").iter().map(Comparison::ratio).collect();
        assert_eq!(ratios, [Some(2.0), Some(2.0), Some(2.0), None, None, None]);
    }
}
