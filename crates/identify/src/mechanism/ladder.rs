//! Starts: what the inverse criterion hardly sees is tried, and a candidate begins where those that
//! it contains have ended.
//!
//! Coulomb's friction is a Dahl bristle that is stiff, Dahl's model a FrBD or LuGre one without
//! micro-damping on a flat curve, each of them a loaded one without a share of the torques. From
//! the result of the smaller candidate the larger one can only fall: its squares are never above.

use super::friction::Friction;
use super::joint::Model;
use super::report::JointFit;
use crate::{Estimate, Parameter};

/// Factors by which the start of a parameter is tried.
const FACTORS: [f64; 6] = [0.01, 0.03, 0.1, 0.3, 3.0, 10.0];
/// Parameters that are tried.
const TRIED: [&str; 2] = ["micro_stiffness", "stribeck_velocity"];
/// Values of parameters with which a model is the one without them, and nearly is.
const NEUTRAL: [(&str, [f64; 2]); 5] = [
    ("micro_damping", [0.0, 0.0]),
    ("motor_load_factor", [0.0, 0.02]),
    ("external_load_factor", [0.0, 0.02]),
    ("breakaway_excess", [0.0, 0.05]),
    ("backward_ratio", [1.0, 1.0]),
];

impl Friction {
    /// The candidates from which a search begins one after the other: Coulomb, load, bristle.
    pub(super) fn rungs(&self) -> Vec<Self> {
        let with = |of: Self| if self.loaded { of.loaded() } else { of };
        let rungs = [Self::coulomb(), with(Self::coulomb()), with(Self::dahl())];
        let mut rungs: Vec<_> = rungs.into_iter().filter(|rung| self.contains(rung)).collect();
        rungs.dedup();
        rungs
    }
}

/// Where parameters start.
pub(super) fn starts(parameters: &[Parameter]) -> Vec<f64> {
    parameters.iter().map(|parameter| parameter.start).collect()
}

/// Starts parameters that have no effect with little: without a breakaway excess no search finds a
/// Stribeck velocity.
pub(super) fn off_neutral(parameters: &mut [Parameter]) {
    for (name, [without, little]) in NEUTRAL {
        let ours = parameters.iter_mut().filter(|p| p.name == name && p.start == without);
        ours.for_each(|p| p.start = little.max(p.least).min(p.most));
    }
}

/// Starts that differ in one parameter which the inverse criterion hardly sees.
pub(super) fn tried(parameters: &[Parameter]) -> Vec<Vec<f64>> {
    let free = |p: &Parameter| TRIED.contains(&p.name) && p.least < p.most;
    let places = parameters.iter().enumerate().filter(|(_, parameter)| free(parameter));
    let moved = |(i, parameter): (usize, &Parameter)| {
        FACTORS.map(|factor| {
            let mut values = starts(parameters);
            let value = (parameter.start * factor).max(parameter.least).min(parameter.most);
            values.iter_mut().skip(i).take(1).for_each(|place| *place = value);
            values
        })
    };
    places.flat_map(moved).collect()
}

impl Model {
    /// The parameters with which a candidate begins at the result of a smaller one: the same, or
    /// nearly so. Then a search moves all of them, and one that was fixed there starts as it does
    /// by itself. Undamped, the bristle lacks its damping: in LuGre's model a stiff one damps more
    /// than in that of Coulomb's friction.
    pub(super) fn begun(&self, smaller: &JointFit, [nearly, undamped]: [bool; 2]) -> Vec<f64> {
        let value = |(parameter, log): (&Parameter, &Option<usize>)| {
            let undamped = undamped && parameter.name == "micro_damping";
            let same = |e: &&Estimate| e.parameter.name == parameter.name && e.log == *log;
            let found = smaller.fit.estimates.iter().find(same);
            let found =
                found.filter(|e| !undamped && (!nearly || e.parameter.least < e.parameter.most));
            let neutral = NEUTRAL.iter().find(|(name, _)| *name == parameter.name);
            let neutral = neutral.map(|(_, values)| values[usize::from(nearly)]);
            let value = found.map(|e| e.value).or(neutral).unwrap_or(parameter.start);
            value.max(parameter.least).min(parameter.most)
        };
        self.parameters.iter().zip(&self.of_logs).map(value).collect()
    }
}
