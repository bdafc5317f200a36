//! Curves, bristles, regularisations and models: their laws, closed forms, derivatives and
//! refusals.

#[path = "../common/mod.rs"]
mod common;

mod curves;
mod derivatives;
mod implicit;
mod implicit_hold;
mod laws;
mod parameters;
mod viscoelastic;
