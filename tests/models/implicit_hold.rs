//! The step of the implicit bristle at a held velocity, beside an integration of its own with tiny
//! steps: which finds the tip by bisection, ends a step where the tip begins or ceases to stick,
//! and is of fourth order in between.

use std::cell::Cell;

use bristle::curve::Stribeck;
use bristle::rheology::KelvinVoigt;
use bristle::{Bristle, HeldStep, ImplicitBristle, paper};

use super::implicit::watched;
use bristle_specimens::draw::Draw;
use bristle_specimens::implicit::{Set, TABLE_2};
use bristle_specimens::specimens::table_2;

#[derive(Debug, Clone, Copy)]
struct Scene {
    velocity: f64,
    deflection: f64,
    duration: f64,
}

fn draw(dice: &mut Draw, set: &Set) -> Scene {
    let unit = set.curve.stribeck_velocity;
    let sign = if dice.next() < 0.5 { -1.0 } else { 1.0 };
    Scene {
        velocity: sign * dice.logarithmic(1e-4 * unit, 1e3 * unit),
        deflection: (2.6 * dice.next() - 1.3) * set.mu(0.0) / set.bristle.micro_stiffness,
        duration: dice.logarithmic(1e-7, 1e3),
    }
}

/// What a model gives in a scene of a set.
fn hold(set: &Set, scene: Scene) -> HeldStep<f64> {
    let Scene { velocity, deflection, duration } = scene;
    set.model().hold(velocity, deflection, duration)
}

/// Compares with tiny steps.
fn assert_true(set: &Set, scene: Scene) {
    let Scene { velocity, deflection, duration } = scene;
    let held = hold(set, scene);
    let (end, mean) = set.truth(velocity, deflection, duration);
    let full = set.mu(0.0) / set.bristle.micro_stiffness;
    let off = (held.deflection - end).abs() / full;
    assert!(off < 1e-6, "{set:?} {scene:?}: {:e} for {end:e}, {off:e}", held.deflection);
    let off = (held.mean_coefficient - mean).abs() / (set.mu(0.0) + set.mu(velocity.abs()));
    assert!(off < 1e-6, "{set:?} {scene:?}: mean {} for {mean}, {off:e}", held.mean_coefficient);
}

#[test]
fn a_step_of_any_length_is_what_tiny_steps_come_to() {
    let mut dice = Draw(1);
    for set in Set::all() {
        for _ in 0..15 {
            assert_true(&set, draw(&mut dice, &set));
        }
    }
}

#[test]
fn two_half_steps_make_a_whole_one_and_no_step_gives_energy() {
    let mut dice = Draw(2);
    for set in Set::all() {
        let stiffness = set.bristle.micro_stiffness;
        for _ in 0..150 {
            let scene = draw(&mut dice, &set);
            let Scene { velocity, deflection, duration } = scene;
            let whole = hold(&set, scene);
            let work = duration * whole.mean_coefficient * velocity;
            let (from, to) = (deflection, whole.deflection);
            let stored = 0.5 * stiffness * (to - from) * (to + from);
            let (mean, most) = (whole.mean_coefficient, set.mu(velocity.abs()));
            let sum =
                duration * velocity.abs() * (mean.abs() + most) + 1e-7 * stiffness * from * from;
            assert!(work - stored >= -1e-8 * sum, "{set:?} {scene:?}: {:e}", work - stored);
            let half = Scene { duration: 0.5 * duration, ..scene };
            let first = hold(&set, half);
            let second = hold(&set, Scene { deflection: first.deflection, ..half });
            // A few tens of pieces of an accuracy of 1e-9.
            let off = (second.deflection - to).abs() * stiffness / set.mu(0.0);
            assert!(off < 1e-7, "{set:?} {scene:?}: {off:e}");
            let halves = 0.5 * (first.mean_coefficient + second.mean_coefficient);
            let off = (halves - mean).abs() / (set.mu(0.0) + most);
            assert!(off < 1e-7, "{set:?} {scene:?}: mean {off:e}");
        }
    }
}

#[test]
fn it_sticks_for_exactly_as_long_as_the_surface_holds() {
    let model = TABLE_2.model();
    // 1.5 = 1e4 v t + 64.5 v: until then z = v t and a mean of σ0 v t/2 + σ1 v.
    let v = 1.0 / 64.0;
    let breaks = (1.5 / v - 64.5) / 1e4;
    for share in [1e-6, 0.5, 0.999_999] {
        let h = share * breaks;
        let held = model.hold(v, 0.0, h);
        assert_eq!(held.deflection, v * h);
        assert!((held.mean_coefficient - (5e3 * v * h + 64.5 * v)).abs() < 1e-14);
        assert!((held.end_coefficient - (1e4 * v * h + 64.5 * v)).abs() < 1e-14);
    }
    // Just beyond it slides: u ≈ σ0 v (t − t_b)/Φ'(0) within a thousandth of v.
    let late = 1e-3 * 64.54 / 1e4;
    let held = model.hold(v, 0.0, breaks + late);
    let want = v * (breaks + late) - v * 0.5 * 1e-3 * late;
    assert!((held.deflection - want).abs() < 1e-3 * 1e-3 * v * late, "{:e}", held.deflection);
    // At rest nothing happens in any time.
    let still = model.hold(0.0, 1e-4, 1e300);
    assert_eq!((still.deflection, still.end_coefficient, still.mean_coefficient), (1e-4, 1.0, 1.0));
}

#[test]
fn a_long_step_ends_in_steady_sliding() {
    for velocity in [1e-4, -5.5e-3, 0.3, -40.0, 1e4] {
        for deflection in [-2e-4, 0.0, 1e-4] {
            let model = TABLE_2.model();
            let held = model.hold(velocity, deflection, 1e12);
            let want = velocity.signum() * TABLE_2.mu(velocity.abs());
            assert!((held.deflection * 1e4 - want).abs() < 1e-14 * want.abs());
            assert!((held.end_coefficient - want).abs() < 1e-14 * want.abs());
            assert!((held.mean_coefficient - want).abs() < 1e-6);
        }
    }
}

#[test]
fn a_curve_that_is_not_a_number_gives_none() {
    let whole = Stribeck::new(paper::STICK_SLIP_CURVE).unwrap();
    let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE).unwrap();
    let whole_model = ImplicitBristle::new(whole, bristle).unwrap();
    for (speed, torn_below) in [(f64::INFINITY, true), (1e-9, true), (1e-4, false)] {
        // A number only beyond a speed, or up to it.
        let torn = watched(whole, move |at| (at < speed) != torn_below);
        let model = ImplicitBristle::new(torn, bristle).unwrap();
        // From sticking, from sliding, over a reversal, at rest.
        for (velocity, deflection) in
            [(0.0, 0.0), (1e-3, 0.0), (0.01, 1e-4), (-0.01, 1.2e-4), (0.0, 1e-4)]
        {
            for duration in [1e-6, 1e-2, 10.0] {
                let step = model.hold(velocity, deflection, duration);
                let HeldStep { deflection: z, end_coefficient, mean_coefficient, .. } = step;
                let all = [z, end_coefficient, mean_coefficient];
                let what = format!("{speed} {torn_below} {velocity} {deflection} {duration}");
                // A step that meets none of what is torn is a step: it sticks, or slides on.
                let stuck = (z - deflection - velocity * duration).abs() < 1e-12;
                let slides = whole_model.tip_velocity(velocity, deflection).abs() > speed;
                let is_whole = if torn_below { slides } else { stuck };
                let wanted = if is_whole { 0 } else { 3 };
                assert_eq!(all.iter().filter(|x| x.is_nan()).count(), wanted, "{what}: {step:?}");
            }
        }
    }
}

#[test]
fn what_is_not_a_number_stays_so_and_no_time_changes_nothing() {
    const NAN: f64 = f64::NAN;
    const INFINITY: f64 = f64::INFINITY;
    for set in Set::all() {
        let model = set.model();
        for (v, z) in [(NAN, 0.0), (0.0, NAN), (INFINITY, 0.0), (1.0, INFINITY)] {
            assert!(model.rate(v, z).is_nan() && model.coefficient(v, z).is_nan(), "{v}, {z}");
            assert!(model.linearised(v, z).rate.is_nan() && !model.sticks(v, z), "{v}, {z}");
        }
        for (velocity, deflection, duration) in [(NAN, 0.0, 1.0), (1.0, NAN, 1.0), (1.0, 0.0, NAN)]
        {
            let held = hold(&set, Scene { velocity, deflection, duration });
            assert!(held.deflection.is_nan() && held.mean_coefficient.is_nan(), "{set:?} {held:?}");
        }
        let held = hold(&set, Scene { velocity: 0.1, deflection: 1e-5, duration: 0.0 });
        assert_eq!(held.deflection, 1e-5);
        assert_eq!(held.mean_coefficient, held.end_coefficient);
    }
}

#[test]
fn looks_at_the_curve_are_few_and_never_more_than_1500() {
    let count = |set: &Set, many: u32, seed: u64, duration: Option<f64>| {
        let mut dice = Draw(seed);
        let (mut most, mut sum) = (0, 0);
        let looks = Cell::new(0);
        let curve = watched(Stribeck::new(set.curve).unwrap(), |_| {
            looks.set(looks.get() + 1);
            true
        });
        let model = ImplicitBristle::new(curve, KelvinVoigt::new(set.bristle).unwrap()).unwrap();
        for _ in 0..many {
            let scene = draw(&mut dice, set);
            let h = duration.unwrap_or(scene.duration);
            looks.set(0);
            let held = model.hold(scene.velocity, scene.deflection, h);
            assert!(held.mean_coefficient.is_finite());
            most = looks.get().max(most);
            sum += looks.get();
        }
        (most, sum / many)
    };
    for set in Set::all() {
        let (most, mean) = count(&set, 200, 3, None);
        let short = count(&set, 200, 3, Some(1e-5));
        // Three to six for the first tip, one piece or two for what follows.
        assert!(
            short.1 <= if set.bristle.micro_damping > 0.0 { 12 } else { 80 },
            "{short:?}: {set:?}"
        );
        assert!(most <= 1500, "{most}: {set:?}");
        assert!(mean <= 150, "{mean}: {set:?}");
    }
}

#[test]
fn in_single_precision_it_is_the_same_step() {
    let (curve, bristle) = table_2::<f32>();
    let single = ImplicitBristle::new(curve, bristle).unwrap();
    let mut dice = Draw(4);
    for _ in 0..300 {
        let Scene { velocity, deflection, duration } = draw(&mut dice, &TABLE_2);
        let (v, z, h) = (velocity as f32, deflection as f32, duration as f32);
        let got = single.hold(v, z, h);
        let want = TABLE_2.model().hold(f64::from(v), z.into(), h.into());
        // Sixteen roundings of the accuracy, times 64.5 v of the load, which a light tip amplifies
        // by 64.5/21.6.
        let off = f64::from(got.deflection) - want.deflection;
        let allowed = 2e-5 * 1.5e-4 * (1.0 + 64.5 * velocity.abs());
        assert!(off.abs() < allowed, "{velocity:e} {deflection:e} {duration:e}: {off:e}");
    }
}
