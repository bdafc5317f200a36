//! Parameters, models and scenes in files: exact round trips, refusals with their place, and
//! damaged files.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

use std::fmt::Debug;

use bristle::control::{
    FeedForwardParameters, FeedbackParameters, Injection, MicroDamping, ObserverParameters,
    OutputParameters, VelocityFromPositionParameters,
};
use bristle::curve::{AnyCurve, Stribeck};
use bristle::ode::{AnyMethod, System};
use bristle::regularisation::{AnyRegularisation, HyperbolicTangent, SquareRoot, Unregularised};
use bristle::rheology::{GeneralisedMaxwell, ZenerParameters};
use bristle::signal::AnySignal;
use bristle::{
    AnyBristle, Bounds, Branch, Bristle, Contact, Dahl, DahlParameters, FrBd, ImplicitBristle,
    LuGre, Mechanism, paper,
};
use bristle_analysis::audit::AuditParameters;
use bristle_convert::LossyGear;
use bristle_files::{Refusal, Setup};
use bristle_joint::{
    CurrentMotor, CurrentMotorParameters, GearFriction, GearFrictionParameters, GearedJoint,
    GearedJointParameters, Gravity, PositionControl, TorqueLoad, TorqueLoadParameters,
    VoltageMotor, VoltageMotorParameters,
};
use bristle_plane::{
    Axis, DiscPressure, FootprintPoint, PlaneBody, PlaneBodyParameters, PlaneBristle, PlaneFrBd,
    PlaneLuGre,
};
use bristle_rolling::AnyPressure;
use bristle_specimens::draw::Draw;
use bristle_specimens::specimens::{
    elasto_plastic, kelvin_voigt, lugre_inside, table_2_bristle, table_2_curve,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The files of the folder `examples`, with their names.
macro_rules! files {
    ($($name:ident)*) => {
        [$((
            stringify!($name),
            include_str!(concat!("../examples/", stringify!($name), ".toml")),
        )),*]
    };
}

const FILES: [(&str, &str); 16] = files!(
    stick_slip lugre valve frictional_lag gearbox dahl creep viscoelastic joint braking plane
    turning footprint patch steering voltage
);

/// The text of a file.
fn text(name: &str) -> &'static str {
    FILES.iter().find(|file| file.0 == name).unwrap().1
}

/// A value in a file of its own.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
struct File<V> {
    value: V,
}

fn written<V: Serialize>(value: &V) -> String {
    toml::to_string(&File { value }).unwrap()
}

fn read<V: DeserializeOwned>(text: &str) -> Result<V, String> {
    toml::from_str::<File<V>>(text).map(|file| file.value).map_err(|error| error.to_string())
}

/// Writes a value, reads it and writes it again.
fn round_trip<V: Serialize + DeserializeOwned + Debug>(value: &V) -> V {
    let text = written(value);
    let again: V = read(&text).unwrap();
    assert_eq!(text, written(&again));
    assert_eq!(format!("{value:?}"), format!("{again:?}"));
    again
}

#[test]
fn shipped_files_run_and_read_back_to_the_same_run() {
    for (name, text) in FILES {
        let mut setup = bristle_files::read(text).unwrap();
        let whole = setup.run().unwrap_or_else(|refusal| panic!("{name}{refusal}"));
        assert_eq!(whole.rows.len(), setup.solver.samples, "{name}");
        (setup.solver.end, setup.solver.samples) = (0.05, 11);
        let again: Setup = toml::from_str(&toml::to_string(&setup).unwrap()).unwrap();
        let (run, again) = (setup.run().unwrap(), again.run().unwrap());
        assert_eq!(run.rows.len(), 11, "{name}");
        assert!(run.rows.iter().flatten().all(|x| x.is_finite()), "{name}");
        let of_time = |row: &Vec<f64>| row.len() == 1 + run.columns.len();
        assert!(run.rows.iter().all(of_time), "{name}");
        // To the last bit.
        assert_eq!(run, again, "{name}");
    }
}

/// Awkward numbers, each with all its digits.
const CURVE: &str = "[value.stribeck]
static_coefficient = 0.30000000000000004
dynamic_coefficient = 0.1
stribeck_velocity = 0.0007000000000000001
stribeck_exponent = 1.2345678901234567
viscous_friction = 1e-17
";

#[test]
fn what_is_read_is_what_a_constructor_builds() {
    let curve: AnyCurve<f64> = read(CURVE).unwrap();
    let AnyCurve::Stribeck(stribeck) = curve else { panic!("{curve:?}") };
    let parameters = stribeck.parameters();
    assert_eq!(parameters.static_coefficient, 0.30000000000000004);
    assert_eq!(parameters.stribeck_velocity, 0.0007000000000000001);
    assert_eq!(stribeck, Stribeck::new(parameters).unwrap());
    assert_eq!(read::<Stribeck<f64>>(&CURVE.replace(".stribeck", "")), Ok(stribeck));
    round_trip(&stribeck);
    // In single precision the file's digits are those of a float.
    let single: Stribeck<f32> = read(&CURVE.replace(".stribeck", "")).unwrap();
    round_trip(&single);
}

#[test]
fn models_and_their_controllers_read_back_to_the_same_bits() {
    let curve: AnyCurve<f64> = read(CURVE).unwrap();
    let bristle = table_2_bristle();
    let smooth = SquareRoot::new(1e-9).unwrap();
    // Its curve must fall less steeply than its damping.
    let implicit = ImplicitBristle::new(curve.clone(), kelvin_voigt(1e4, 1e3)).unwrap();
    let elastic = elasto_plastic(curve.clone(), bristle, 1e-6);
    let models: [AnyBristle<f64>; 6] = [
        LuGre::classical(curve.clone(), bristle).regularised(smooth).into(),
        elastic.regularised(HyperbolicTangent::new(1e-4).unwrap()).into(),
        implicit.into(),
        FrBd::new(curve.clone(), bristle).into(),
        LuGre::classical(curve.clone(), bristle).into(),
        lugre_inside(curve.clone(), bristle).into(),
    ];
    let velocity = VelocityFromPositionParameters {
        sample_time: 1e-3,
        time_constant: 2e-3,
        fastest: 0.5,
        count: 0.0,
    };
    let output = OutputParameters { share: 1.0, largest_force: 3.0 };
    for model in models {
        let contact = model.under_load(12.5).unwrap().measured_at(10.0 / 3.0).unwrap();
        let again: Contact<f64, AnyBristle<f64>> = round_trip(&contact);
        for velocity in [0.0, 1e-6, -3e-3, 2.0] {
            assert_eq!(contact.force(velocity, 1e-5), again.force(velocity, 1e-5));
        }
        let (sample_time, fastest) = (1e-3, 1.0);
        let contact = || contact.clone();
        round_trip(&FeedForwardParameters { contact: contact(), sample_time, fastest, output });
        let damping = MicroDamping::Filtered;
        round_trip(&FeedbackParameters { contact: contact(), velocity, damping, output });
        round_trip(&ObserverParameters {
            contact: contact(),
            mass: 1.0,
            proportional_gain: 400.0,
            derivative_gain: 30.0,
            integral_gain: 1000.0,
            injection: Injection::Velocity { gain: 0.1, corner: 10.0 },
            velocity,
            output,
        });
    }
    let zener = ZenerParameters {
        static_stiffness: 1e4,
        relaxing_stiffness: 2e4 / 3.0,
        series_damping: 0.1 + 0.2,
    };
    round_trip(&zener);
    round_trip::<GeneralisedMaxwell<f64, 2>>(&GeneralisedMaxwell::zener(zener).unwrap());
    let load_cycle = Some(Bounds { min: 0.1, max: 0.2 });
    round_trip(&AuditParameters { load_cycle, ..AuditParameters::up_to(0.1) });
    for method in ["automatic", "dormand_prince", "dormand_prince8", "rodas4", "rodas5p"] {
        let read: AnyMethod = read(&format!("value = \"{method}\"")).unwrap();
        assert_eq!(round_trip(&read).to_string(), method);
    }
    // Models of fixed types; what is none, and what is chosen to be none, are written alike.
    round_trip(&FrBd::new(table_2_curve::<f64>(), bristle));
    round_trip(&LuGre::classical(table_2_curve::<f64>(), bristle));
    round_trip(&elasto_plastic(table_2_curve::<f64>(), bristle, 1e-6));
    let chosen: AnyRegularisation<f64> = AnyRegularisation::Unregularised;
    assert_eq!(written(&Unregularised), written(&chosen));
}

#[test]
fn models_of_several_axes_read_back_to_the_same_bits() {
    let curve: AnyCurve<f64> = read(CURVE).unwrap();
    let axis = |friction_ratio, stiffness| Axis {
        friction_ratio,
        bristle: kelvin_voigt(stiffness, 0.1 + 0.2),
    };
    let axes = [axis(1.0, 1e4), axis(0.1 + 0.5, 2e4 / 3.0), axis(0.9, 1e3)];
    let smooth = AnyRegularisation::from(SquareRoot::new(1e-9).unwrap());
    let model = PlaneFrBd::new(curve.clone(), axes).unwrap().regularised(smooth);
    let contact = model.under_load(1.0 / 3.0).unwrap();
    round_trip(&contact);
    let free = Mechanism { mass: 0.3, spring_stiffness: 0.0, viscous_damping: 0.1 };
    let body = PlaneBodyParameters {
        contact,
        mechanisms: [free; 3],
        anchor: [0.0, 0.1, 0.2],
        force: [1.0 / 3.0; 3],
    };
    round_trip(&PlaneBody::new(body).unwrap());
    for model in [
        PlaneLuGre::classical(curve.clone(), axes).unwrap(),
        PlaneLuGre::with_viscous_friction(curve.clone(), axes, 0.0).unwrap(),
        PlaneLuGre::with_viscous_friction(curve, axes, 0.1 + 0.2).unwrap(),
    ] {
        round_trip(&model.regularised(smooth));
    }
    // Of fixed types.
    round_trip(&PlaneFrBd::new(table_2_curve::<f64>(), axes).unwrap());
    round_trip(&PlaneLuGre::classical(table_2_curve::<f64>(), axes).unwrap());

    let bristle = "bristle = { micro_stiffness = 1e4, micro_damping = 1.0 }";
    let good = format!("{{ friction_ratio = 1.0, {bristle} }}");
    let curve = "curve.coulomb = { dynamic_coefficient = 0.3, viscous_friction = 0.0 }";
    for (axis, why) in [
        (good.replace("1.0, b", "0.0, b"), "friction_ratio[1] is 0, but must lie between"),
        (good.replace("1e4", "-1.0"), "micro_stiffness is -1, but must"),
        (format!("{good}, {good}"), "there must be 2 of them, not 3"),
    ] {
        let text = format!("[value]\n{curve}\naxes = [{good}, {axis}]");
        type Model = PlaneFrBd<AnyCurve<f64>, f64, 2, AnyRegularisation<f64>>;
        let refused = read::<Model>(&text).unwrap_err();
        assert!(refused.contains(why), "{refused}");
    }
}

#[test]
fn a_refused_parameter_is_found_at_its_own_line() {
    let text = text("stick_slip");
    for (good, bad) in [
        ("mass = 1.0", "mass = -1.0"),
        ("spring_stiffness = 2.0", "spring_stiffness = inf"),
        ("normal_force = 1.0", "normal_force = nan"),
        ("dynamic_coefficient = 1.0", "dynamic_coefficient = 0.0"),
        ("static_coefficient = 1.5", "static_coefficient = 0.5"),
        ("micro_damping = 64.5", "micro_damping = -64.5"),
        // No parameter: the format's own place.
        ("viscous_friction = 0.04", "viscosity = 0.04"),
        ("samples = 6001", "samples = 1.5"),
    ] {
        let text = text.replace(good, bad);
        assert!(text.contains(bad));
        let (line, column) = bristle_files::read(&text).unwrap_err().place.unwrap();
        let there: String = text.lines().nth(line - 1).unwrap().chars().skip(column - 1).collect();
        let key = bad.split(' ').next().unwrap();
        let value = bad.rsplit(' ').next().unwrap();
        assert!(there.starts_with(key) || there.starts_with(value), "{bad}: {line}: {there}");
    }
    // The mechanism of the second axis: its own braces.
    let plane = self::text("plane");
    let bad = plane.replacen(
        "mass = 1.0, spring_stiffness = 2.0",
        "mass = 1.0, spring_stiffness = 3.0",
        1,
    );
    let bad = bad.replace("spring_stiffness = 2.0", "spring_stiffness = -2.0");
    let refusal = bristle_files::read(&bad).unwrap_err();
    let line = bad.lines().position(|line| line.contains("= -2.0")).unwrap() + 1;
    assert_eq!(refusal.place.unwrap().0, line, "{refusal}");
}

/// What the example says of a text that it refuses at once or as it runs.
fn refused(text: &str) -> String {
    let run = bristle_files::read(text).and_then(|setup| setup.run());
    run.map(|table| table.rows.len()).unwrap_err().to_string()
}

/// A file, what takes the place of what, and what is said: from its place on, or at the line of the
/// change.
const REFUSED: &str = r#"
stick_slip | end = 60.0 | end = -1.0 | :5:1: end is -1, but must be positive and finite
stick_slip | end = 60.0 | end = 0 | :5:1: end is 0, but must be positive and finite
stick_slip | end = 60.0 | end = inf | :5:1: end is inf, but must be positive and finite
stick_slip | samples = 6001 | samples = 1 | :6:1: samples is 1, but must lie between 2 and
stick_slip | tolerance = 1e-6 | tolerance = 0 | :8:1: tolerance is 0, but must lie between
stick_slip | tolerance = 1e-6 | tolerance = 1 | :8:1: tolerance is 1, but must lie between
stick_slip | tolerance = 1e-6 | step = 1e-5 |
    :8:1: step is 0.00001, but must be absent: the method automatic chooses the steps
stick_slip | tolerance = 1e-6 | tolerance = 1e-6¶step = 1e-3 |
    :9:1: step is 0.001, but must be absent: tolerance chooses the steps
stick_slip | "automatic" | "runge_kutta4" |
    :8:1: tolerance is 0.000001, but must be absent: runge_kutta4 takes steps of
gearbox | step = 1e-4 | # | :6:1: method is runge_kutta4, but must come with a step
braking | step | tolerance | :6:1: tolerance is 0.005, but must be absent: a braked
braking | step | method = "rodas4"¶step |
    :6:1: method is rodas4, but must be absent: a braked wheel takes steps
braking | step = 5e-3 | step = 0.0 | :6:1: step is 0, but must be finite and at least
sticking | samples = 301 | samples = 1e6 | samples is 1e6, but must be a whole number
sticking | samples = 301 | samples = -5 | samples is -5, but must be a whole number
sticking | mass = 2.0 | mass = "2" | mass is "2", but must be a number
sticking | force.constant = 0.0 | force = "constant" |
    force is "constant", but must be a number or one of `constant`, `sine`, `polyline`
joint | external.gravity | external = true # |
    external is true, but must be a number or one of `constant`, `sine`, `polyline`, `gravity`
footprint | rings = 10 | rings = 65536 | rings is 65536, but must be a whole number
gearbox | frequency = 1.0 | frequency = 9e18 |
    frequency is 9000000000000000000, but must be at most 500000: a run has up to a million periods
dahl | frequency = 1.0 | frequency = 9e18 | frequency is 9000000000000000000, but must be at most
joint | frequency = 0.5 | frequency = 1e9 | frequency is 1000000000, but must be at most
plane | frequency = 0.0477 | frequency = 1e9 | frequency is 1000000000, but must be at most
patch | frequency = 20.0 | frequency = 1e12 | frequency is 1000000000000, but must be at most
stick_slip | samples = 6001 | samples = 1000000000000 |
    samples is 1000000000000, but must lie between 2 and 1e6
gearbox | step = 1e-4 | step = 1e-12 | step is 0.000000000001, but must be finite and at least
footprint | rings = 10 | rings = 60000 |
    rings is 60000, but must give up to 100000 points, not 10800000000
footprint | disc = { radius = 0.03, pressure = "hertz", rings = 10 } |
    rectangle = { size = [0.03, 0.02], counts = [401, 250] } |
    counts is [401, 250], but must give up to 100000 points, not 100250
footprint | end = 1.0 | end = 5e3 | end is 5000, but must be at most
patch | cells = 200 | cells = 1000000000 | cells is 1000000000, but must lie between 1 and 1e4
"#;

/// Solver keys out of range or in contradiction, values of another type, and runs that cannot end.
#[test]
fn what_is_refused_is_told_at_its_line_with_value_and_rule() {
    for row in REFUSED.trim().replace("|\n    ", "| ").lines() {
        let row = row.replace('¶', "\n");
        let [name, good, bad, expected] = row.split(" | ").collect::<Vec<_>>()[..] else {
            panic!("{row}")
        };
        let text = if name == "sticking" { STICKING } else { text(name) };
        let changed = text.replacen(good, bad, 1);
        assert!(changed != text, "{row}");
        let line = changed.lines().position(|line| line.contains(bad)).unwrap_or(0) + 1;
        let refused = refused(&changed);
        let place = if expected.starts_with(':') { expected } else { &format!(":{line}:") };
        assert!(refused.starts_with(place) && refused.contains(expected), "{row}\n{refused}");
    }
}

#[test]
fn fixed_steps_beyond_the_stable_ones_are_refused() {
    // A light mass on stiff bristles, driven harmonically: ω = √(σ0 p/m) = 4000 rad/s.
    let valve = |solver: &str| {
        format!(
            "[solver]\nend = 0.01\nsamples = 11\n{solver}
[scene.mass_spring_damper]
drive_velocity = 0.0
force.sine = {{ mean = 0.0, amplitude = 20.0, frequency = 100.0, phase = 0.0 }}
mechanism = {{ mass = 0.1, spring_stiffness = 12e3, viscous_damping = 10.0 }}
contact.normal_force = 1.0
[scene.mass_spring_damper.contact.model.frbd]
rheology = {{ micro_stiffness = 1.6e6, micro_damping = 400.0 }}
[scene.mass_spring_damper.contact.model.frbd.curve.stribeck]
static_coefficient = 8.0
dynamic_coefficient = 5.0
stribeck_velocity = 2e-3
stribeck_exponent = 2.0
viscous_friction = 20.0
"
        )
    };
    // m s² + (σ1 p + d) s + (σ0 p + k) = 0 at rest, c = 1: Runge–Kutta 4 is stable up to 0.66 ms.
    let fixed = |method: &str, step: f64| valve(&format!("method = \"{method}\"\nstep = {step}"));
    let too_long = ":5:1: step is 0.002, but must be shorter";
    for method in ["runge_kutta4", "dormand_prince", "dormand_prince8"] {
        let refused = refused(&fixed(method, 2e-3));
        assert!(refused.starts_with(too_long), "{method}{refused}");
        assert!(refused.ends_with("a tolerance in its place chooses the steps"), "{refused}");
        let runs = bristle_files::read(&fixed(method, 1e-4)).unwrap().run().unwrap();
        assert_eq!(runs.rows.len(), 11, "{method}");
        assert!(runs.error.unwrap() < 0.01, "{method}: {:?}", runs.error);
    }
}

/// A body on a spring whose end moves, with a curve that falls: L-stable methods are no safer.
const STICKING: &str = "[solver]
end = 15.0
samples = 301
method = \"rodas4\"
step = 0.05
[scene.mass_spring_damper]
drive_velocity = 0.02
force.constant = 0.0
mechanism = { mass = 2.0, spring_stiffness = 50.0, viscous_damping = 0.0 }
contact.normal_force = 10.0
[scene.mass_spring_damper.contact.model.frbd]
rheology = { micro_stiffness = 5e3, micro_damping = 20.0 }
[scene.mass_spring_damper.contact.model.frbd.curve]
stribeck = { static_coefficient = 0.6, dynamic_coefficient = 0.35, stribeck_velocity = 0.01, \
stribeck_exponent = 1.0, viscous_friction = 0.0 }
";

#[test]
fn the_error_of_fixed_steps_is_told_and_a_large_one_refused() {
    let run = |solver: &str| {
        let text = STICKING.replace("method = \"rodas4\"\nstep = 0.05", solver);
        bristle_files::read(&text).unwrap().run().unwrap()
    };
    let exact = run("tolerance = 1e-10");
    assert_eq!(exact.error, None);
    for (method, steps) in [
        ("rodas4", [0.05, 0.2, 1.0]),
        ("rodas5p", [0.1, 0.2, 1.0]),
        ("runge_kutta4", [0.02, 0.2, 1.0]),
    ] {
        for step in steps {
            let text = STICKING.replace("rodas4", method).replace("0.05", &step.to_string());
            let refused = refused(&text);
            let expected = format!(":5:1: step is {step}, but must be shorter");
            assert!(refused.starts_with(&expected), "{method}: {refused}");
        }
        // Against an adaptive run: the worst row of each state, over its largest size.
        let fixed = run(&format!("method = \"{method}\"\nstep = 4e-3"));
        let told = fixed.error.unwrap();
        let mut error = 0.0;
        for column in 1..4 {
            let size = exact.rows.iter().fold(0.0, |most, row| f64::max(most, row[column].abs()));
            for (row, exact) in fixed.rows.iter().zip(&exact.rows) {
                error = f64::max(error, (row[column] - exact[column]).abs() / size);
            }
        }
        assert!(told < 1e-2 && error > 1e-8, "{method}: {error:e}");
        // Half the step of order four leaves a sixteenth of the error; order one would leave half.
        assert!((0.5..2.0).contains(&(told / error)), "{method}: {told:e}, {error:e}");
    }
    // The load of a gear has kinks, at which every method is of order one.
    let joint = text("joint");
    let joint = |step: f64| {
        let solver = format!("method = \"runge_kutta4\"\nstep = {step}");
        joint.replacen("tolerance = 1e-6", &solver, 1).replacen("end = 6.0", "end = 0.1", 1)
    };
    let long = refused(&joint(0.1));
    assert!(long.starts_with(":8:1: step is 0.1, but must be shorter"), "{long}");
    assert!(bristle_files::read(&joint(1e-4)).unwrap().run().unwrap().error.unwrap() < 1e-2);
}

#[test]
fn a_value_that_occurs_twice_is_found_by_its_index() {
    let table = |rows: &str| {
        let curve = STICKING.split("stribeck = {").next().unwrap();
        format!("{curve}tabulated = [\n{rows}]\n")
    };
    let row = |speed: f64| format!("{{ speed = {speed:?}, coefficient = 0.5 }},\n");
    let speeds = [0.0, 0.1, 0.3, 0.1];
    let text = table(&speeds.map(row).concat());
    let first = text.lines().position(|line| line.starts_with("{ speed")).unwrap() + 1;
    let refused = |text: &str| bristle_files::read(text).unwrap_err();
    let named = refused(&text);
    assert_eq!(named.place, Some((first + 3, 3)), "{named}");
    assert!(named.message.starts_with("speed[3] is 0.1, but must be larger"), "{named}");
    let short = table(&speeds.map(|speed| format!("[{speed:?}, 0.5],\n")).concat());
    assert_eq!(refused(&short).place, Some((first + 3, 1)), "{short}");
}

#[test]
fn a_plain_number_is_a_constant_signal() {
    for bad in ["nan", "inf", "{}", "\"constant\"", "{ constant = 1.0, sine = 2.0 }", "true"] {
        let text = STICKING.replace("force.constant = 0.0", &format!("force = {bad}"));
        assert!(text != STICKING && bristle_files::read(&text).is_err(), "{bad}");
    }
    let read = |force: &str| {
        let text = STICKING.replace("force.constant = 0.0", force);
        toml::to_string(&bristle_files::read(&text).unwrap()).unwrap()
    };
    assert_eq!(read("force = 0.1"), read("force.constant = 0.1"));
    assert_eq!(read("force = -3"), read("force.constant = -3.0"));
    let joint = text("joint");
    let plain = joint.replace("external.gravity = {", "external = 0.5 # {");
    let table = joint.replace("external.gravity = {", "external.constant = 0.5 # {");
    let rows = |text: &str| {
        let mut setup = bristle_files::read(text).unwrap();
        setup.solver.end = 0.05;
        setup.run().unwrap().rows
    };
    assert_eq!(rows(&plain), rows(&table));
    // Wherever the files have a signal.
    for (name, text) in FILES {
        let mut file = toml::Value::Table(text.parse().unwrap());
        assert!(numbers_for_signals(&mut file, false) > 0, "{name}");
        let plain = toml::to_string(&file).unwrap();
        assert!(bristle_files::read(&plain).is_ok(), "{name}: {plain}");
    }
}

/// Puts a number in place of every signal, and counts them.
fn numbers_for_signals(value: &mut toml::Value, is_pressure: bool) -> usize {
    let kinds = ["constant", "sine", "polyline"];
    match value {
        toml::Value::Table(table)
            if !is_pressure && table.keys().any(|k| kinds.contains(&&**k)) =>
        {
            *value = toml::Value::Float(0.1);
            1
        }
        toml::Value::Table(table) => {
            table.iter_mut().map(|(key, value)| numbers_for_signals(value, key == "pressure")).sum()
        }
        toml::Value::Array(list) => {
            list.iter_mut().map(|value| numbers_for_signals(value, false)).sum()
        }
        _ => 0,
    }
}

const PAGE: &str = include_str!("../docs/files.md");

#[test]
fn the_files_on_the_pages_run() {
    // They slide: 8 N against 4 N, and 6 N to break away; a spring that is drawn on at 0.1 m/s.
    for (page, rows) in [(PAGE, 2001), (include_str!("../README.md"), 6001)] {
        let text = page.split("```toml\n").nth(1).and_then(|text| text.split("```").next());
        let table = bristle_files::read(text.unwrap()).unwrap().run().unwrap();
        assert_eq!(table.rows.len(), rows);
        assert!(table.rows.iter().any(|row| row[2].abs() > 0.09));
    }
}

#[test]
fn every_key_of_the_files_is_on_the_page() {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    let known = |key: &str| PAGE.split(|c| !part(c)).any(|word| word == key);
    for (name, text) in FILES {
        let lines = text.lines().filter_map(|line| line.split('#').next());
        let words = lines.flat_map(|line| line.split([' ', '{', '[', ']', ',', '.', '=', '}']));
        for key in words.filter(|word| word.starts_with(|c: char| c.is_ascii_lowercase())) {
            assert!(known(key.trim_matches('"')), "{name}: {key} is not on the page");
        }
    }
}

#[test]
fn a_choice_of_two_or_of_none_is_refused_with_what_it_lacks() {
    let text = text("stick_slip");
    let two = text.replacen("model.frbd.curve", "model.lugre.curve", 1);
    // At the one that comes last.
    let [one, other] = ["model.frbd", "model.lugre"].map(|key| two.find(key).unwrap());
    let line = two[..one.max(other)].matches('\n').count() + 1;
    let two = refused(&two);
    let why = "scene.mass_spring_damper.contact.model has 2 entries, frbd and lugre, but must";
    assert!(two.contains(why) && two.starts_with(&format!(":{line}:")), "{two}");
    // One header of several is misspelt.
    let spool = text.replacen("[scene.mass_spring_damper]", "[scene.spool]", 1);
    let line = spool.lines().position(|line| line == "[scene.spool]").unwrap() + 1;
    let spool = refused(&spool);
    let why = "unknown variant `spool`, expected one of `prescribed_velocity`";
    assert!(spool.contains(why) && spool.starts_with(&format!(":{line}:8: ")), "{spool}");
    let empty = refused("[solver]\nend = 1.0\nsamples = 2\n[scene]\n");
    let why = ":4:1: scene is empty, expected one of `prescribed_velocity`";
    assert!(empty.starts_with(why), "{empty}");
}

#[test]
fn joints_and_parameters_of_other_tools_read_back_to_the_same_bits() {
    let bristle = DahlParameters { dynamic_coefficient: 0.1 + 0.2, micro_stiffness: 1e3 / 7.0 };
    let load = TorqueLoadParameters { idle_load: 0.5, motor_share: 1.0, external_share: 0.6 };
    let mut gear = GearFriction::new(GearFrictionParameters {
        friction: AnyBristle::from(Dahl::new(bristle).unwrap()),
        load: TorqueLoad::new(load).unwrap(),
        reference_load: 0.1 + 0.7,
        drag: 0.05,
        fastest: 1.0 / 3.0,
    })
    .unwrap();
    gear.set_friction_scale(1.1).unwrap();
    gear.set_drag_scale(0.7).unwrap();
    let motor = VoltageMotor::new(VoltageMotorParameters {
        voltage: PositionControl {
            reference: AnySignal::Constant(0.1),
            proportional_gain: 0.3,
            derivative_gain: 0.7,
        },
        torque_constant: 1.2,
        resistance: 0.1 + 0.2,
        largest_voltage: Some(24.0),
        largest_current: None,
    })
    .unwrap();
    let external = Gravity { horizontal_torque: 1.2, hanging_angle: 0.1 };
    let parameters = GearedJointParameters { gear, inertia: 0.02, motor, external };
    let joint = GearedJoint::new(parameters).unwrap();
    let again = round_trip(&joint);
    let (state, free) = ([0.3, 0.1, 1e-5].into(), [Branch::Free]);
    assert_eq!(joint.rate(0.1, &state, free), again.rate(0.1, &state, free));
    round_trip(&joint.parameters());
    let current = CurrentMotor::new(CurrentMotorParameters {
        current: 1.0 / 3.0,
        torque_constant: 1.2,
        largest_current: Some(5.0),
    })
    .unwrap();
    round_trip(&current);

    let row = LossyGear {
        driving_efficiency: 0.9,
        back_driving_efficiency: 0.8,
        driving_friction: 0.1 + 0.2,
        back_driving_friction: 0.4,
        ratio: 100.0,
    };
    round_trip(&row);
    round_trip::<Vec<_>>(&FootprintPoint::disc(0.3, DiscPressure::Hertz, 2).collect());
    round_trip(&DiscPressure::Uniform);
}

#[test]
fn a_bad_file_is_refused_with_parameter_value_rule_and_place() {
    for (good, bad, place, why) in [
        (
            "dynamic_coefficient = 0.1",
            "dynamic_coefficient = -1.0",
            "line 1, column 2",
            "dynamic_coefficient is -1, but must lie between 1e-100 and 1e100",
        ),
        ("viscous_friction", "viscosity", "line 6, column 1", "unknown field `viscosity`"),
        ("viscous_friction = 1e-17", "", "", "missing field `viscous_friction`"),
        ("stribeck]", "parabola]", "", "unknown variant `parabola`"),
        ("1e-17", "nan", "", "viscous_friction is NaN, but must lie between 0 and 1e100"),
    ] {
        let refused = read::<AnyCurve<f64>>(&CURVE.replace(good, bad)).unwrap_err();
        assert!(refused.contains(place) && refused.contains(why), "{refused}");
    }
    let table = "value = { tabulated = [{ speed = 0.0, coefficient = 0.4 }, \
                 { speed = 0.0, coefficient = 0.3 }] }";
    let pressure = "value.quadratic = { coefficients = [1.0, 2.0], decay = 0.0 }";
    let sine = "value.sine = { mean = 0.0, amplitude = 1.0, frequency = 0.0, phase = 0.0 }";
    let hanging = "value = { horizontal_torque = 1.0, hanging_angle = nan }";
    for (refused, why) in [
        (read::<AnyCurve<f64>>(table).map(drop), "speed[1] is 0, but must be larger than its"),
        (read::<AnyPressure<f64>>(pressure).map(drop), "there must be 3 of them, not 2"),
        (read::<AnySignal<f64>>(sine).map(drop), "frequency is 0, but must lie between"),
        (
            read::<AnySignal<f64>>("value = { constant = inf }").map(drop),
            "constant is inf, but must lie between",
        ),
        (read::<Gravity<f64>>(hanging).map(drop), "hanging_angle is NaN"),
        (read::<Gravity<f64>>(hanging).map(drop), "line 1, column 52"),
    ] {
        let refused = refused.unwrap_err();
        assert!(refused.contains(why), "{refused}");
    }
    // A curve of your own is no text.
    let own = AnyCurve::own(Stribeck::new(paper::STICK_SLIP_CURVE).unwrap());
    assert!(toml::to_string(&File { value: own }).is_err());
}

fn below(draw: &mut Draw, most: usize) -> usize {
    (draw.next() * most as f64) as usize
}

fn one_of<'t, V>(draw: &mut Draw, list: &'t [V]) -> Option<&'t V> {
    list.get(below(draw, list.len()))
}

/// Where a text has words of numbers and of letters.
fn words(text: &str) -> Vec<std::ops::Range<usize>> {
    let ends = |c: char| c.is_whitespace() || "=,[]{}\"#".contains(c);
    let starts = text.match_indices(ends).map(|(at, end)| at + end.len());
    std::iter::once(0)
        .chain(starts)
        .map(|start| start..text[start..].find(ends).map_or(text.len(), |length| start + length))
        .filter(|word| !word.is_empty())
        .collect()
}

/// Where a text has numbers outside its comments.
fn numbers(text: &str) -> Vec<std::ops::Range<usize>> {
    let said = |at: usize| !text[..at].rsplit('\n').next().unwrap().contains('#');
    let mut words = words(text);
    words.retain(|word| text[word.clone()].parse::<f64>().is_ok() && said(word.start));
    words
}

/// A text with one damage.
fn damaged_once(text: &str, draw: &mut Draw) -> String {
    const NUMBERS: &str = "nan -nan inf -inf 0.0 -0.0 0 -1.0 1e308 -1e308 1e-320 1e400 1e100 \
                           1e-100 1 \"1\" true [] 9223372036854775807 \
                           123456789012345678901234567890";
    let mut text = text.to_owned();
    match below(draw, 8) {
        // A number.
        0 | 1 => {
            if let Some(at) = one_of(draw, &numbers(&text)) {
                let numbers: Vec<&str> = NUMBERS.split(' ').collect();
                text.replace_range(at.clone(), one_of(draw, &numbers).unwrap());
            }
            text
        }
        // A bit of a byte.
        2 => {
            let mut bytes = text.into_bytes();
            let at = below(draw, bytes.len());
            bytes[at] ^= 1 << below(draw, 8);
            String::from_utf8_lossy(&bytes).into_owned()
        }
        // Two words change places.
        3 => {
            let mut words = words(&text);
            let [one, other] = [(); 2].map(|()| below(draw, words.len()));
            words = vec![words[one.min(other)].clone(), words[one.max(other)].clone()];
            if one != other {
                let [early, late] = [0, 1].map(|i| text[words[i].clone()].to_owned());
                text.replace_range(words[1].clone(), &early);
                text.replace_range(words[0].clone(), &late);
            }
            text
        }
        // One of several entries within braces or brackets is lost or doubled.
        4 => {
            let commas: Vec<usize> = text.match_indices(',').map(|found| found.0).collect();
            if let Some(&at) = one_of(draw, &commas) {
                let rest = &text[at + 1..];
                let end = at + 1 + rest.find([',', '}', ']', '\n']).unwrap_or(rest.len());
                let entry = text[at..end].repeat(2 * below(draw, 2));
                text.replace_range(at..end, &entry);
            }
            text
        }
        // Two headers change places, or two tables do.
        5 => {
            let mut tables: Vec<String> =
                text.split("\n[").map(|table| format!("\n[{table}")).collect();
            let [one, other] = [(); 2].map(|()| 1 + below(draw, tables.len() - 1));
            if tables.len() == 1 {
                return text;
            }
            tables.swap(one, other);
            if one != other && below(draw, 2) == 0 {
                let header = |table: &str| table[1..].find('\n').map_or(table.len(), |n| n + 1);
                let [at, to] = [header(&tables[one]), header(&tables[other])];
                let rest = tables[one].split_off(at);
                let body = std::mem::replace(&mut tables[other], rest);
                tables[one].push_str(&body[to..]);
                tables[other].insert_str(0, &body[..to]);
            }
            tables.concat()[2..].to_owned()
        }
        // A line is lost, doubled or exchanged.
        6 => {
            let mut lines: Vec<&str> = text.lines().collect();
            let [place, other] = [(); 2].map(|()| below(draw, lines.len()));
            match below(draw, 3) {
                0 => drop(lines.remove(place)),
                1 => lines.insert(place, lines[place]),
                _ => lines.swap(place, other),
            }
            lines.join("\n")
        }
        // A character is lost, doubled or replaced.
        _ => {
            let mut characters: Vec<char> = text.chars().collect();
            let at = below(draw, characters.len());
            let lost = at..at + below(draw, 2);
            characters
                .splice(lost, ['μ', '=', 'e', '-', '{', '"', '9'].get(below(draw, 8)).copied());
            String::from_iter(characters)
        }
    }
}

/// A text with one to three damages.
fn damaged(text: &str, draw: &mut Draw) -> String {
    (0..=below(draw, 3)).fold(text.to_owned(), |text, _| damaged_once(&text, draw))
}

/// Takes ten steps of what a text holds: the number of rows, or the refusal.
fn ten_steps(text: &str) -> Result<usize, Refusal> {
    let mut setup = bristle_files::read(text)?;
    // Of which some may be tried again.
    setup.solver.most_steps = Some(20);
    let table = setup.run()?;
    assert!(table.rows.iter().flatten().all(|number| number.is_finite()), "{text}");
    Ok(table.rows.len())
}

#[test]
fn damaged_files_are_refused_at_a_place_or_run() {
    let rounds = 100;
    let mut draw = Draw(0x9e37_79b9_7f4a_7c15);
    let [mut refused, mut run] = [[0; FILES.len()]; 2];
    for round in 0..rounds * FILES.len() {
        let file = round % FILES.len();
        let (name, text) = FILES[file];
        let text = damaged(text, &mut draw);
        match std::panic::catch_unwind(|| ten_steps(&text)) {
            Err(_) => panic!("{name} panics:\n{text}"),
            Ok(Err(refusal)) => {
                refused[file] += 1;
                assert!(!refusal.message.is_empty(), "{name}: {text}");
                let (line, column) = refusal.place.unwrap_or_else(|| panic!("{refusal}\n{text}"));
                // At the latest just behind the last character.
                let there =
                    text.split('\n').nth(line - 1).is_some_and(|l| column <= l.chars().count() + 1);
                assert!(there, "{name}{refusal}\n{text}");
            }
            Ok(Ok(rows)) => {
                run[file] += 1;
                assert!(rows > 0, "{name}: {text}");
            }
        }
    }
    assert!(refused.iter().all(|&count| 10 * count > 3 * rounds), "{refused:?}");
    assert!(run.iter().all(|&count| 20 * count > rounds), "{run:?}");
}

#[test]
fn a_bad_number_is_refused_at_its_own_line() {
    for (name, text) in FILES {
        for at in numbers(text) {
            let mut bad = text.to_owned();
            bad.replace_range(at.clone(), "nan");
            let line = text[..at.start].matches('\n').count() + 1;
            let refusal = ten_steps(&bad).expect_err(&bad);
            let column = at.start - text[..at.start].rfind('\n').map_or(0, |end| end + 1) + 1;
            let place = refusal.place.unwrap();
            assert!(place.0 == line && place.1 <= column, "{name}:{line}:{column}: {refusal}");
        }
    }
}
