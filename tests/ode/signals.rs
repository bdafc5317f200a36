//! Signals: values, rates of change, and the times at which they are not smooth.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test panics to fail")]

use bristle::scene::{MassSpringDamper, MassSpringDamperParameters};
use bristle::signal::{Function, Polyline, Signal, Sine, SineParameters, Vertex};
use bristle::{Bristle, Dahl, DahlParameters, ParameterError, Rule, paper};
use num_dual::Dual64;

/// Some times, on either side of every corner used below.
fn times() -> impl Iterator<Item = f64> {
    (-40..=80).map(|i| 0.0731 * f64::from(i))
}

/// Runs a check over a signal of every kind, in a scalar type.
macro_rules! every_signal {
    ($scalar:ty, |$name:ident, $signal:ident| $body:block) => {
        let lit = <$scalar>::from;
        let vertex = |time: f64, value: f64| Vertex { time: lit(time), value: lit(value) };
        {
            let $name = "constant";
            let $signal: $scalar = lit(-3.5);
            $body
        }
        {
            let $name = "sine";
            let $signal = Sine::new(SineParameters {
                mean: lit(0.7),
                amplitude: lit(-2.5),
                frequency: lit(0.31),
                phase: lit(0.4),
            })
            .unwrap();
            $body
        }
        {
            let $name = "polyline";
            let $signal = Polyline::new([
                vertex(-1.0, 2.0),
                vertex(0.5, -1.0),
                vertex(2.0, -1.0),
                vertex(2.5, 4.0),
            ])
            .unwrap();
            $body
        }
        {
            let $name = "polyline of one point";
            let $signal = Polyline::new([vertex(0.5, -1.0)]).unwrap();
            $body
        }
        {
            let $name = "function";
            let $signal = Function::new(
                |t: $scalar| if t < lit(1.0) { (t * t, t + t) } else { (t * lit(3.0), lit(3.0)) },
                [lit(1.0)],
            );
            $body
        }
    };
}

#[test]
fn the_rate_is_the_derivative_of_the_value() {
    every_signal!(Dual64, |name, signal| {
        for time in times() {
            let dual = signal.value(Dual64::new(time, 1.0));
            let (value, rate) = signal.value_and_rate(Dual64::from(time));
            // The same handful of operations, up to the order of a product.
            let close = |a: f64, b: f64| (a - b).abs() <= 4.0 * f64::EPSILON * (1.0 + b.abs());
            assert!(close(value.re, dual.re), "{name} at {time}: {value} {dual}");
            assert!(close(rate.re, dual.eps), "{name} at {time}: {rate} {dual}");
        }
    });
}

#[test]
fn between_kinks_a_signal_is_smooth_and_at_a_kink_it_is_not() {
    every_signal!(f64, |name, signal| {
        let width = 1e-6;
        // A second difference: curvature times width² where smooth (curvatures below 20), a bend
        // of at least 1 times the width, or a jump, where not.
        let bend = |t: f64| {
            (signal.value(t - width) + signal.value(t + width) - 2.0 * signal.value(t)).abs()
        };
        for time in times() {
            assert!(bend(time) < 100.0 * width * width, "{name} at {time}");
        }
        let mut time = -100.0;
        let mut kinks = 0;
        while let Some(kink) = signal.next_kink(time, 100.0) {
            assert!(kink > time && kink < 100.0, "{name}");
            // A level start and a level end may meet in one point: no bend there, no harm either.
            assert!(bend(kink) > 0.9 * width || name.contains("one point"), "{name} at {kink}");
            time = kink;
            kinks += 1;
        }
        let expected = match name {
            "polyline" => 4,
            "polyline of one point" | "function" => 1,
            _ => 0,
        };
        assert_eq!(kinks, expected, "{name}");
    });
}

#[test]
fn kinks_lie_strictly_between() {
    every_signal!(f64, |name, signal| {
        let walk = |from: f64, to: f64| {
            let mut found = Vec::new();
            let mut time = from;
            while let Some(kink) = signal.next_kink(time, to) {
                found.push(kink);
                time = kink;
            }
            found
        };
        let forward = walk(-100.0, 100.0);
        // Strictly between: neither end counts, and nothing beyond.
        for &kink in &forward {
            assert_eq!(signal.next_kink(kink, kink), None, "{name}");
            assert_ne!(signal.next_kink(kink, 100.0), Some(kink), "{name}");
            assert_eq!(signal.next_kink(kink - 0.01, kink), None, "{name}");
            assert_eq!(signal.next_kink(kink - 0.01, kink + 0.01), Some(kink), "{name}");
        }
    });
}

#[test]
fn a_constant_is_constant() {
    let constant = 2.5;
    for time in times() {
        assert_eq!(constant.value_and_rate(time), (2.5, 0.0));
        assert_eq!(constant.value(time), 2.5);
    }
}

#[test]
fn a_sine_has_its_mean_amplitude_frequency_and_phase() {
    let sine = Sine::new(SineParameters { mean: 1.0, amplitude: 2.0, frequency: 0.25, phase: 0.0 });
    let sine = sine.unwrap();
    // A period of 4 s: quarter by quarter, to the rounding of 2π.
    for (time, value) in [(0.0_f64, 1.0_f64), (1.0, 3.0), (2.0, 1.0), (3.0, -1.0), (4.0, 1.0)] {
        assert!((sine.value(time) - value).abs() < 1e-14, "{time}");
    }
    // Steepest at its mean: amplitude · 2π · frequency.
    assert!((sine.value_and_rate(0.0).1 - std::f64::consts::PI).abs() < 1e-15);
    // A phase of π/2 is a cosine.
    let phase = std::f64::consts::FRAC_PI_2;
    let cosine = Sine::new(SineParameters { mean: 0.0, amplitude: 1.0, frequency: 0.5, phase });
    let cosine = cosine.unwrap();
    for time in times() {
        let exact = (std::f64::consts::PI * time).cos();
        // Arguments of up to twenty.
        assert!((cosine.value(time) - exact).abs() < 1e-14, "{time}");
    }
}

#[test]
fn a_polyline_is_straight_between_its_points_and_level_outside() {
    let line = Polyline::new([
        Vertex { time: -1.0, value: 2.0 },
        Vertex { time: 0.5, value: -1.0 },
        Vertex { time: 2.0, value: -1.0 },
        Vertex { time: 2.5, value: 4.0 },
    ])
    .unwrap();
    let cases = [
        (-5.0, 2.0, 0.0),
        (-0.25, 0.5, -2.0),
        (1.0, -1.0, 0.0),
        (2.25, 1.5, 10.0),
        (9.0, 4.0, 0.0),
        // At a corner the rate is the one just after it.
        (-1.0, 2.0, -2.0),
        (0.5, -1.0, 0.0),
        (2.0, -1.0, 10.0),
        (2.5, 4.0, 0.0),
    ];
    for (time, value, rate) in cases {
        assert_eq!(line.value_and_rate(time), (value, rate), "{time}");
        assert_eq!(line.value(time), value, "{time}");
    }
}

#[test]
fn a_function_answers_at_a_kink_with_what_holds_just_after() {
    let step = Function::new(|t: f64| if t < 1.0 { (0.0, 0.0) } else { (5.0, 0.0) }, [3.0, 1.0]);
    assert_eq!(step.value(1.0), 5.0);
    // The kinks may be given in any order.
    assert_eq!(step.next_kink(0.0, 10.0), Some(1.0));
    assert_eq!(step.next_kink(1.0, 10.0), Some(3.0));
    let text = format!("{step:?}");
    assert!(text.contains("3.0, 1.0"), "{text}");
}

// ---------------------------------------------------------------------------------------------
// What is refused

const NOT_NUMBERS: [f64; 4] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300];

fn name(error: ParameterError) -> (&'static str, Option<usize>) {
    (error.name, error.component)
}

#[test]
fn a_force_that_is_not_a_number_is_refused() {
    let friction = Dahl::new(DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 5e3 });
    let parameters = paper::stick_slip_rig(friction.unwrap().under_load(1.0).unwrap());
    for force in NOT_NUMBERS {
        let parameters = MassSpringDamperParameters { force, ..parameters };
        assert_eq!(MassSpringDamper::new(parameters).unwrap_err().name, "force");
    }
}

#[test]
fn a_sine_refuses_its_parameters_by_name() {
    let good = SineParameters { mean: 1.0, amplitude: 2.0, frequency: 0.25, phase: 0.1 };
    for bad in NOT_NUMBERS {
        let refused = [
            ("mean", SineParameters { mean: bad, ..good }),
            ("amplitude", SineParameters { amplitude: bad, ..good }),
            ("frequency", SineParameters { frequency: bad, ..good }),
            ("phase", SineParameters { phase: bad, ..good }),
        ];
        for (parameter, parameters) in refused {
            assert_eq!(name(Sine::new(parameters).unwrap_err()), (parameter, None));
        }
    }
    for bad in [0.0, -1.0] {
        let refused = Sine::new(SineParameters { frequency: bad, ..good }).unwrap_err();
        assert_eq!((refused.name, refused.value), ("frequency", bad));
        // Everything else may be zero or negative.
        let parameters = SineParameters { mean: bad, amplitude: bad, phase: bad, ..good };
        assert!(Sine::new(parameters).is_ok());
    }
}

#[test]
fn a_polyline_refuses_points_by_their_place() {
    let good = [
        Vertex { time: 0.0, value: 1.0 },
        Vertex { time: 1.0, value: 2.0 },
        Vertex { time: 2.0, value: 0.0 },
    ];
    for component in 0..3 {
        for bad in NOT_NUMBERS {
            let mut vertices = good;
            vertices[component].time = bad;
            assert_eq!(name(Polyline::new(vertices).unwrap_err()), ("time", Some(component)));
            let mut vertices = good;
            vertices[component].value = bad;
            assert_eq!(name(Polyline::new(vertices).unwrap_err()), ("value", Some(component)));
        }
    }
    // Times that stand still or go back.
    for bad in [1.0, 0.5] {
        let mut vertices = good;
        vertices[2].time = bad;
        let refused = Polyline::new(vertices).unwrap_err();
        assert_eq!(name(refused), ("time", Some(2)));
        assert_eq!(refused.rule, Rule::Increasing { previous: 1.0 });
    }
    // Points that are fine each by itself, on a line that is not.
    let steep = [Vertex { time: 0.0, value: 0.0 }, Vertex { time: 1e-60, value: 1e60 }];
    assert_eq!(name(Polyline::new(steep).unwrap_err()), ("slope", Some(1)));
    let refused = Polyline::new([] as [Vertex<f64>; 0]).unwrap_err();
    assert_eq!((refused.name, refused.rule), ("vertices", Rule::Count { least: 1 }));
}

#[test]
fn a_polyline_takes_its_points_in_any_storage() {
    let points = [Vertex { time: 0.0, value: 1.0 }, Vertex { time: 2.0, value: 5.0 }];
    let (array, slice) = (Polyline::new(points).unwrap(), Polyline::new(&points[..]).unwrap());
    let list = Polyline::new(points.to_vec()).unwrap();
    for time in [-1.0, 0.0, 0.3, 2.0, 7.0] {
        let want = array.value_and_rate(time);
        assert_eq!((slice.value_and_rate(time), list.value_and_rate(time)), (want, want));
        assert_eq!(list.next_kink(time, 9.0), array.next_kink(time, 9.0));
    }
}

/// Against the plain reading: the first of all times on the way.
#[test]
fn the_next_corner_of_a_polyline_is_the_first_on_the_way() {
    let times = [-1.0, 0.0, 0.5, 2.0, 7.0];
    let line = Polyline::new(times.map(|time| Vertex { time, value: 1.0 })).unwrap();
    let probes = [-2.0, -1.0, -0.5, 0.0, 0.2, 0.5, 1.0, 2.0, 6.9, 7.0, 9.0, f64::NAN];
    for from in probes {
        for to in probes {
            let inside = |time: &f64| from < *time && *time < to;
            let expected = times.into_iter().find(inside);
            assert_eq!(line.next_kink(from, to), expected, "{from} {to}");
        }
    }
}
