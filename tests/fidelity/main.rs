//! The choice of a model for a scene.

mod history;
mod mechanism;
mod rolling;
