//! What holds of every scene: the report, refusals, references that do not settle.

use bristle::Bristle;
use bristle::fidelity::*;
use bristle::signal::{Sine, SineParameters};

use crate::known_velocity::sets;

#[test]
fn what_the_readme_shows_is_what_comes_out() {
    let velocity = SineParameters { mean: 0.0055, amplitude: 0.005, frequency: 25.0, phase: 0.0 };
    let scene = KnownVelocity::new(KnownVelocityParameters {
        contact: sets()[0].under_load(1.0).unwrap(),
        velocity: Sine::new(velocity).unwrap(),
        interval: 4e-4,
        answers: 1000,
        start: Start::Steady,
    });
    let choice = choose(&scene.unwrap(), Tolerance::at_every_answer(0.015)).unwrap();
    let text: Vec<String> = choice.to_string().lines().map(|l| l.trim_end().into()).collect();
    let text = text.join("\n");
    assert!(text.lines().all(|line| line.chars().count() <= 100), "it fits a page\n{text}");
    assert!(include_str!("../../README.md").contains(&text), "{text}");
}
