//! The values of docs/experiments.md, by closed forms and by other integrators.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use super::*;

/// By scipy's Radau to 1e-9, on the equations as published.
#[test]
fn break_away_falls_with_the_rate_of_the_force() {
    let (curve, bristle) = (curve().unwrap(), bristle().unwrap());
    let implicit = ImplicitBristle::new(curve, bristle).unwrap();
    for (name, peak, want) in [
        ("FrBD, slow", break_away(&FrBd::new(curve, bristle), 0.1, 0.0), 1.48829),
        ("FrBD", break_away(&FrBd::new(curve, bristle), 20.0, 0.0), 1.11915),
        ("LuGre", break_away(&LuGre::classical(curve, bristle), 20.0, 0.0), 1.19446),
        ("elasto-plastic", break_away(&elasto_plastic().unwrap(), 20.0, 0.0), 1.32366),
        ("ten elements", break_away(&ten(0.95).unwrap(), 20.0, 0.0), 1.40962),
        // It sticks up to μ_s at any rate.
        ("implicit", break_away(&implicit, 20.0, 0.0), STATIC),
    ] {
        // Steps of 0.1 ms, of second order; the peak lies between two of them.
        assert!((peak.unwrap() - want).abs() < 4e-5, "{name}");
    }
}

/// No model ages: what a dwell of 1 s and of 10 s leaves is the same.
#[test]
fn break_away_does_not_grow_with_the_dwell_time() {
    let (curve, bristle) = (curve().unwrap(), bristle().unwrap());
    let model = FrBd::new(curve, bristle);
    let [short, long] = [2.0, 12.0].map(|dwell| break_away(&model, 20.0, dwell).unwrap());
    // The oscillation from the first loading has faded.
    assert!((short - long).abs() < 1e-6, "{short} {long}");
}

#[test]
fn in_slow_motion_frbd_and_lugre_forget_like_dahl() {
    let (curve, bristle) = (curve().unwrap(), bristle().unwrap());
    let ends = |model: &dyn Fn(&mut Points) -> Vec<f64>| {
        let ends = model(&mut Points::new());
        (ends[2] - ends[0]) / STATIC
    };
    let path = [0.0, 180.0, 90.0, 180.0];
    let frbd = FrBd::new(curve, bristle);
    let lugre = LuGre::classical(curve, bristle);
    for miss in
        [ends(&|points| along(&frbd, &path, points)), ends(&|points| along(&lugre, &path, points))]
    {
        // Dahl's branches over μ/σ0: 1.2 up, 0.6 down, 0.6 up.
        let up = |force: f64, x: f64| 1.0 - (1.0 - force) * (-x).exp();
        let down = |force: f64, x: f64| -1.0 + (1.0 + force) * (-x).exp();
        let outer = up(0.0, 1.2);
        let dahl = up(down(outer, 0.6), 0.6) - outer;
        assert!((miss - dahl).abs() < 1e-4, "{miss} is not {dahl}"); // 0.1 µm/s
    }
}

/// Δx = (μ_s/σ0) ln((F_b² − F1²)/(F_b² − F2²)) per cycle; nothing below a stick limit.
#[test]
fn drift_under_load_cycles() {
    let (curve, bristle) = (curve().unwrap(), bristle().unwrap());
    let [least, greatest] = CYCLE.map(|share| 1.0 - share * share);
    let law = 1e6 * STATIC / STIFFNESS * (least / greatest).ln();
    let drift = |points: Points| points[2].1 - points[1].1;
    let frbd = drift(cycles(&FrBd::new(curve, bristle)).unwrap());
    // Slow, but not infinitely: σ1 |v| is up to 2e-3 of μ.
    assert!((frbd / law - 1.0).abs() < 2e-3, "{frbd} is not {law}");
    let elastic = drift(cycles(&elasto_plastic().unwrap()).unwrap());
    assert!(elastic.abs() < 1e-9, "{elastic}");
}

/// By scipy's LSODA to 1e-9, in mN.
#[test]
fn frictional_lag_has_the_width_of_an_independent_integration() {
    let (curve, bristle) = (curve().unwrap(), bristle().unwrap());
    let implicit = ImplicitBristle::new(curve, bristle).unwrap();
    for (name, width, want) in [
        ("FrBD", lag_of(&FrBd::new(curve, bristle), 100.0), 9.1726),
        ("LuGre", lag_of(&LuGre::classical(curve, bristle), 100.0), 10.4121),
        ("implicit", lag_of(&implicit, 100.0), -83.2634),
    ] {
        // Velocities held over a four-thousandth of a period.
        assert!((1e3 * width - want).abs() < 0.01, "{name}: {width}");
    }
}

#[test]
fn stick_slip_has_its_period() {
    let (curve, bristle) = (curve().unwrap(), bristle().unwrap());
    let implicit = ImplicitBristle::new(curve, bristle).unwrap();
    for (name, cycle, want) in [
        ("FrBD", stick_slip(&FrBd::new(curve, bristle)), [7.639267, 0.494266, 1.536889]),
        ("implicit", stick_slip(&implicit), [7.755823, 0.481472, 1.550270]),
        ("elasto-plastic", stick_slip(&elasto_plastic().unwrap()), [7.656117, 0.492248, 1.539]),
    ] {
        let cycle = cycle.unwrap().1.unwrap();
        // Steps of 0.1 ms: the period of companion steps is off by 1e-6 of itself and more.
        let off = [0, 1, 2].map(|i| (cycle[i] / want[i] - 1.0).abs());
        assert!(off.iter().all(|&off| off < 3e-5), "{name}: {cycle:?}");
    }
}
