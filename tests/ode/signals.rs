//! Signals: values, rates of change, and the times at which they are not smooth.

use bristle::scene::MassSpringDamper;
use bristle::signal::{Function, Polyline, Signal, Sine, SineParameters, Vertex};
use bristle::{Bristle, Dahl, DahlParameters, ParameterError, Rule, paper};
use bristle_specimens::assert_fields_refuse;

/// Some times, on either side of every corner used below.
fn times() -> impl Iterator<Item = f64> {
    (-40..=80).map(|i| 0.0731 * f64::from(i))
}

/// A signal is smooth but at its kinks, which lie strictly between the times asked about.
fn has_kinks(name: &str, signal: impl Signal<f64>, kinks: &[f64]) {
    let width = 1e-6;
    // A second difference: curvature times width² where smooth (curvatures below 20), a bend of at
    // least 1 times the width, or a jump, where not.
    let bend =
        |t: f64| (signal.value(t - width) + signal.value(t + width) - 2.0 * signal.value(t)).abs();
    for time in times() {
        assert!(bend(time) < 100.0 * width * width, "{name} at {time}");
    }
    let mut before = -100.0;
    for &kink in kinks {
        assert_eq!(signal.next_kink(before, 100.0), Some(kink), "{name}");
        assert_eq!(signal.next_kink(kink - 0.01, kink), None, "{name}");
        assert_eq!(signal.next_kink(kink, kink), None, "{name}");
        // A level start and a level end may meet in one point: no bend there, no harm either.
        assert!(bend(kink) > 0.9 * width || name == "polyline of one point", "{name} at {kink}");
        before = kink;
    }
    assert_eq!(signal.next_kink(before, 100.0), None, "{name}");
}

#[test]
fn between_kinks_a_signal_is_smooth_and_at_a_kink_it_is_not() {
    let vertex = |time, value| Vertex { time, value };
    let sine = SineParameters { mean: 0.7, amplitude: -2.5, frequency: 0.31, phase: 0.4 };
    let line = [vertex(-1.0, 2.0), vertex(0.5, -1.0), vertex(2.0, -1.0), vertex(2.5, 4.0)];
    let own = |t: f64| if t < 1.0 { (t * t, t + t) } else { (t * 3.0, 3.0) };
    has_kinks("constant", -3.5, &[]);
    has_kinks("sine", Sine::new(sine).unwrap(), &[]);
    has_kinks("polyline", Polyline::new(line).unwrap(), &[-1.0, 0.5, 2.0, 2.5]);
    has_kinks("polyline of one point", Polyline::new([vertex(0.5, -1.0)]).unwrap(), &[0.5]);
    has_kinks("function", Function::new(own, [1.0]), &[1.0]);
    assert_eq!((2.5.value_and_rate(0.7), 2.5.value(0.7)), ((2.5, 0.0), 2.5));
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
        let (sin, cos) = (std::f64::consts::PI * time).sin_cos();
        let (value, rate) = cosine.value_and_rate(time);
        assert_eq!(value, cosine.value(time));
        // Arguments of up to twenty.
        assert!((value - cos).abs() < 1e-14, "{time}");
        assert!((rate + std::f64::consts::PI * sin).abs() < 4e-14, "{time}");
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

const NOT_NUMBERS: [f64; 4] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300];

fn name(error: ParameterError) -> (&'static str, Option<usize>) {
    (error.name, error.component)
}

#[test]
fn a_force_that_is_not_a_number_is_refused() {
    let friction = Dahl::new(DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 5e3 });
    let parameters = paper::stick_slip_rig(friction.unwrap().under_load(1.0).unwrap());
    assert_fields_refuse!(NOT_NUMBERS, MassSpringDamper::new, parameters; force);
}

#[test]
fn a_sine_refuses_its_parameters_by_name() {
    let good = SineParameters { mean: 1.0, amplitude: 2.0, frequency: 0.25, phase: 0.1 };
    assert_fields_refuse!(NOT_NUMBERS, Sine::new, good; mean amplitude frequency phase);
    assert_fields_refuse!([0.0, -1.0], Sine::new, good; frequency);
    for bad in [0.0, -1.0] {
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
