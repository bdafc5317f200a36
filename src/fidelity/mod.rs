//! How much model a scene needs: the cheapest model, integrator and step that keep within a tolerance, and
//! the evidence.
mod history;
mod ladder;
mod reducible;
mod report;
mod weight;

pub use history::{History, HistoryParameters, Start};
pub use reducible::Reducible;
pub use report::{
    Choice, Evidence, FidelityError, Integrator, Norm, Plan, Rung, Tolerance, Trial, Verdict,
};
