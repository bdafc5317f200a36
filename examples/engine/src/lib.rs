//! Friction of `bristle` inside a rigid-body engine, rapier. See the README beside.

pub mod bond;
pub mod capsule;
pub mod law;
pub mod measure;
pub mod scene;
