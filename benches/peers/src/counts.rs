//! The least evaluations of each method on each scene, at given errors: what does not depend on the
//! machine.

use crate::row::{OK, Row};

/// The errors at which methods are compared.
pub(crate) const LEVELS: [f64; 3] = [1e-3, 1e-6, 1e-9];

/// A table: least evaluations of a run within each error, a Jacobian counted as 1.5.
pub(crate) fn markdown(rows: &[Row]) -> String {
    let mut table =
        String::from("| scene | method | 1e-3 | 1e-6 | 1e-9 |\n|---|---|---|---|---|\n");
    let mut methods: Vec<(&str, &str, String)> = Vec::new();
    for row in rows {
        let method = (&*row.scene, &*row.model, row.who());
        if !methods.contains(&method) {
            methods.push(method);
        }
    }
    for (scene, model, who) in methods {
        let runs = || {
            let all = rows.iter().filter(|row| row.scene == scene && row.model == model);
            all.filter(|row| row.who() == who)
        };
        let cells = LEVELS.map(|level| {
            let within = runs().filter(|row| row.achieved().is_some_and(|error| error <= level));
            let spent = within.map(|row| row.rhs_evals as f64 + 1.5 * row.jac_evals as f64);
            match spent.reduce(f64::min) {
                Some(least) => format!("{least:.0}"),
                None if runs().any(|row| row.status == OK) => "–".to_owned(),
                None => "failed".to_owned(),
            }
        });
        table += &format!("| {scene} {model} | {who} | {} |\n", cells.join(" | "));
    }
    table
}
