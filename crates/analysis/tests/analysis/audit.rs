//! What an audit says, against closed forms, simulations and the tables of the literature; what it
//! refuses; and that it allocates nothing.

use std::fmt::Write;

use super::coulomb;
use bristle::curve::{Asymmetric, FrictionCurve, FunctionCurve, Stribeck, StribeckParameters};
use bristle::regularisation::SquareRoot;
use bristle::rheology::{KelvinVoigt, Maxwell, MaxwellParameters};
use bristle::{
    Bounds, Bristle, Contact, Dahl, DahlParameters, FrBd, LuGre, Mechanism, Sliding, Units, paper,
};
use bristle_analysis::audit::{Audit, AuditParameters, LawStatus, audit};
use bristle_analysis::linear::Threshold;
use bristle_analysis::step_limits::Scheme;
use bristle_specimens::own_rheology::{VelocityLaw, own_element};
use bristle_specimens::recipe::recipe;
use bristle_specimens::specimens::{
    self, Bare, kelvin_voigt, stribeck, table_2_bristle, table_2_curve, table_2_frbd, table_2_lugre,
};
use bristle_specimens::{assert_within, check};

const RIG: Mechanism<f64> = Mechanism { mass: 1.0, spring_stiffness: 2.0, viscous_damping: 0.0 };

/// Table 2's curve with something else.
fn curve(change: impl Fn(&mut StribeckParameters<f64>)) -> Stribeck<f64> {
    let mut parameters = paper::STICK_SLIP_CURVE;
    change(&mut parameters);
    Stribeck::new(parameters).unwrap()
}

/// Elastic up to 8e-5 m.
fn soft() -> impl Bristle<f64, Deflection = f64> + Copy {
    specimens::elasto_plastic(table_2_curve(), table_2_bristle(), 8e-5)
}

fn on_rig(sample_time: f64) -> AuditParameters<f64> {
    let (mechanism, sample_time) = (Some(RIG), Some(sample_time));
    AuditParameters { mechanism, sample_time, ..AuditParameters::up_to(1.0) }
}

/// A force that goes slowly up and down.
fn cycle(min: f64, max: f64) -> AuditParameters<f64> {
    AuditParameters { load_cycle: Some(Bounds { min, max }), ..AuditParameters::up_to(1.0) }
}

fn audit_of<M: Bristle<f64, Deflection = f64>>(model: M) -> Audit<f64> {
    audit(&model.under_load(1.0).unwrap(), AuditParameters::up_to(1.0)).unwrap()
}

#[test]
fn classical_lugre_of_table_2_is_not_passive_and_the_audit_says_what_it_lacks() {
    let audited = audit_of(table_2_lugre());
    let worst = audited.passivity;
    assert_eq!(worst.verdict, LawStatus::Fails);
    // σ1 (μ_s − μ_d)/μ_d = 64.5 · 0.5.
    assert_eq!(audited.characteristics.unwrap().needed_viscous_friction, Some(32.25));
    // At 1 m/s the curve is flat at μ_d: F v − Ẇ = σ0²z² − σ0σ1 z + σ1 + σ2 at z = 1.5e-4, the most
    // that the deflection may be.
    let (z, s0, s1) = (1.5e-4, 1e4, 64.5);
    let want = s0 * s0 * z * z - s0 * s1 * z + s1 + 0.04;
    assert_eq!((worst.velocity.abs(), worst.deflection.abs()), (1.0, z));
    assert_within(1e-12, s1, worst.least_power, want, || "worst case".to_owned());
    let contact = table_2_lugre().under_load(1.0).unwrap();
    let power = contact.dissipated_power(worst.velocity, worst.deflection);
    assert_within(1e-12, s1, power, want, || "the contact's own".to_owned());

    // With as much as it needs it is passive; with a little less it is not.
    let with = |viscous_friction| {
        let curve = curve(|curve| curve.viscous_friction = viscous_friction);
        audit_of(LuGre::classical(curve, table_2_bristle())).passivity.verdict
    };
    assert_eq!(with(32.25), LawStatus::Holds);
    assert_eq!(with(32.24), LawStatus::Fails);
}

#[test]
fn lugre_with_its_viscous_part_inside_fails_in_a_state_that_is_named() {
    let model = specimens::lugre_inside(table_2_curve(), table_2_bristle());
    let audited = audit_of(model);
    let passivity = audited.passivity;
    assert_eq!(passivity.verdict, LawStatus::Fails);
    assert_eq!(audited.characteristics.unwrap().needed_viscous_friction, None);
    let contact = model.under_load(1.0).unwrap();
    let power = contact.dissipated_power(passivity.velocity, passivity.deflection);
    assert!(power < -1.0);
    assert_within(1e-12, power.abs(), passivity.least_power, power, || "worst case".to_owned());
    // (c₀ − K r)²/(4 K λ c₂) = σ1 λ/(4 σ0) at the fastest.
    let lambda = model.affine(1.0.into(), 0.0).relaxation;
    let want = 64.5 * lambda / 4e4;
    assert_within(1e-13, want, passivity.excess, want, || "excess".to_owned());
}

#[test]
fn frbd_dahl_and_elasto_plastic_models_are_passive() {
    let valve = FrBd::new(
        Stribeck::new(paper::VALVE_CURVE).unwrap(),
        KelvinVoigt::new(paper::VALVE_BRISTLE).unwrap(),
    );
    let dahl = DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 };
    for passivity in [
        audit_of(valve).passivity,
        audit_of(table_2_frbd()).passivity,
        audit_of(Dahl::new(dahl).unwrap()).passivity,
        audit_of(soft()).passivity,
    ] {
        assert_eq!(passivity.verdict, LawStatus::Holds);
        assert_eq!((passivity.excess, passivity.least_power), (0.0, 0.0));
    }
}

/// σ0 = 1e4 (1 + 0.3 tanh v/v_d)
fn stiffening(scale: f64) -> VelocityLaw<f64> {
    VelocityLaw::new(
        move |sliding: Sliding<f64>| {
            let t = (sliding.velocity() / scale).tanh();
            (1e4 * (1.0 + 0.3 * t), 3e3 / scale * (1.0 - t * t))
        },
        Bounds { min: 7e3, max: 1.3e4 },
    )
}

#[test]
fn a_stiffness_that_varies_is_passive_with_enough_damping_only() {
    let with = |damping: f64| {
        audit_of(FrBd::new(table_2_curve(), own_element(stiffening(1.0), damping))).passivity
    };
    // The largest μ (σ0(v) − s)²/(4 σ1 s σ0(v)|v|) over |v| ≤ 1 m/s, s = σ0(0), is that at −1 m/s.
    let (t, s) = ((-1.0_f64).tanh(), 1e4);
    let (at, mu) = (s * (1.0 + 0.3 * t), 1.04);
    let ratio = |damping: f64| mu * (at - s) * (at - s) / (4.0 * damping * s * at);
    let damped = with(64.5);
    assert_eq!((damped.verdict, damped.least_power), (LawStatus::Unrefuted, 0.0));
    assert_within(1e-12, damped.excess, damped.excess, ratio(64.5), || "excess".to_owned());
    let undamped = with(0.0);
    assert_eq!(undamped.verdict, LawStatus::Fails);
    assert_eq!(undamped.excess, f64::INFINITY);
    assert!(undamped.least_power < 0.0);
    // Between them: not for every deflection, but perhaps for the admissible ones.
    let slight = with(64.5 * ratio(64.5) * 0.5);
    assert_within(1e-12, 2.0, slight.excess, 2.0, || "slight".to_owned());
}

#[test]
fn the_inversion_is_single_valued_where_the_closed_form_says() {
    check(256, recipe(), |r| {
        let curve = stribeck::<f64>(&r, 2.0);
        let model = FrBd::new(curve, kelvin_voigt(r.stiffness, r.damping));
        let contact = model.under_load(r.load).unwrap();
        let audit = audit(&contact, AuditParameters::up_to(10.0 * r.stribeck_velocity)).unwrap();
        // σ1 + σ2 − (μ_s − μ_d) √(2/e)/v_S for δ = 2.
        let fall = (r.static_ - r.dynamic) * (2.0 / 1f64.exp()).sqrt() / r.stribeck_velocity;
        let want = r.damping + r.viscous - fall;
        let terms = r.damping + r.viscous + fall;
        assert_within(1e-13, terms, audit.inversion_margin.unwrap(), want, || format!("{r:?}"));
    });
    // δ = 1 falls steepest at rest, δ < 1 infinitely so.
    let characteristics = |exponent| {
        let curve = curve(|curve| curve.stribeck_exponent = exponent);
        let known = FrBd::new(curve, table_2_bristle()).characteristics(1.0).unwrap();
        (known.least_slope, known.slope_at_rest)
    };
    let near = |got: f64, want: f64| assert_within(1e-12, 50.0, got, want, || "slope".to_owned());
    near(characteristics(1.0).0, -50.0 + 0.04);
    near(characteristics(1.0).1, -50.0 + 0.04);
    assert_eq!(characteristics(0.5), (f64::NEG_INFINITY, f64::NEG_INFINITY));
    assert_eq!(characteristics(2.0).1, 0.04);
    // A falling curve of either direction counts: δ = 1, or a smaller v_S.
    let pointed = curve(|curve| curve.stribeck_exponent = 1.0);
    let steep = curve(|curve| curve.stribeck_velocity = 0.004);
    let fall = 0.5 * (2.0 / 1f64.exp()).sqrt() / 0.004;
    for (other, want) in [(pointed, 0.04 - 50.0), (steep, 0.04 - fall)] {
        for (forward, backward) in [(other, table_2_curve()), (table_2_curve(), other)] {
            let both = Asymmetric { forward, backward };
            near(
                FrBd::new(both, table_2_bristle()).characteristics(1.0).unwrap().least_slope,
                want,
            );
            near(both.slope_at_rest(), other.slope_at_rest());
        }
    }
}

/// Drags a contact slowly until its force has a value; answers with the displacement.
fn drag(contact: &Contact<f64, impl Bristle<f64, Deflection = f64>>, z: &mut f64, to: f64) -> f64 {
    // Slow enough for the viscous forces, 65 s/m, to vanish.
    let sign = (to - contact.force(0.0, *z)).signum();
    let velocity = sign * 1e-12;
    let excess = |time: f64| sign * (contact.hold(velocity, *z, time).end_force - to);
    let time = bristle_specimens::root(0.0, 1e-3 / velocity.abs(), excess);
    *z = contact.hold(velocity, *z, time).deflection;
    velocity * time
}

#[test]
fn the_drift_of_a_load_cycle_is_that_of_a_slow_simulation() {
    fn assert_drift(model: impl Bristle<f64, Deflection = f64>, (min, max): (f64, f64)) {
        let contact = model.under_load(2.0).unwrap();
        let want = audit(&contact, cycle(min, max)).unwrap().drift.unwrap();
        let mut z = 0.0;
        drag(&contact, &mut z, min + 1e-3);
        drag(&contact, &mut z, min);
        let drift = drag(&contact, &mut z, max) + drag(&contact, &mut z, min);
        // The viscous force is 1e-10 N of the cycle's 1 N.
        assert_within(1e-8, 1e-4, drift, want, || format!("{min} {max} {contact:?}"));
    }
    for cycle in [(0.5, 2.5), (-1.0, 2.9), (-2.0, 2.0), (-2.5, -1.0)] {
        assert_drift(table_2_frbd(), cycle);
        assert_drift(table_2_lugre(), cycle);
    }
}

#[test]
fn a_regularised_contact_creeps_and_leaks_as_the_closed_forms_say() {
    let epsilon: f64 = 1e-14;
    let model = table_2_frbd().regularised(SquareRoot::new(epsilon).unwrap());
    // Of the two forces, over the breakaway of 3 N, the one of larger magnitude counts.
    for (least, most) in
        [(0.0, 0.1), (0.0, 0.5), (0.0, 0.9), (0.0, 0.99), (-0.5, 0.0), (-0.8, -0.2)]
    {
        let r: f64 = if -least > most { least } else { most };
        let contact = model.under_load(2.0).unwrap();
        let yielding = audit(&contact, cycle(3.0 * least, 3.0 * most)).unwrap();
        // √ε r/√(1 − r²) for a creep far below v_S: its square is 1e-10 of v_S², σ2 v 3e-8 of μ_s.
        let want = epsilon.sqrt() * r / (1.0 - r * r).sqrt();
        let creep = yielding.creep.unwrap();
        assert_within(1e-5, want.abs(), creep, want, || format!("r = {r}"));
        let backward = yielding.to_string().contains("m/s under -");
        assert_eq!(backward, r < 0.0, "{yielding}");
        // σ0√ε/(σ1√ε + μ_s)
        let leak = 1e4 * epsilon.sqrt() / (64.5 * epsilon.sqrt() + 1.5);
        assert_within(1e-14, leak, yielding.relaxation_at_rest, leak, || "leak".to_owned());
    }
    // An exact modulus sticks.
    let stuck = audit_of(table_2_frbd());
    let found = (stuck.creep, stuck.relaxation_at_rest, stuck.breakaway);
    assert_eq!(found, (Some(0.0), 0.0, Some(1.5)));
    // LuGre's bristles leak at σ0√ε/μ_s.
    let lugre = table_2_lugre().regularised(SquareRoot::new(1e-8).unwrap());
    let leak = audit_of(lugre).relaxation_at_rest;
    assert_within(1e-14, 1.0, leak, 1e4 * 1e-4 / 1.5, || "LuGre".to_owned());
}

#[test]
fn the_stuck_mass_and_the_steps_are_those_of_the_literature() {
    let contact = table_2_frbd().under_load(1.0).unwrap();
    let parameters = AuditParameters {
        mechanism: Some(Mechanism { spring_stiffness: 0.0, ..RIG }),
        sample_time: Some(0.01),
        ..AuditParameters::up_to(1e3)
    };
    let audited = audit(&contact, parameters).unwrap();
    let stuck = audited.stuck.unwrap();
    // m s² + σ1 c p s + σ0 c p = 0 with c = 1 and c = 2.
    let same = |got: f64, want: f64| assert_within(1e-12, want, got, want, || "stuck".to_owned());
    same(stuck.frequency, 100.0);
    same(stuck.damping_ratio, 64.5 / 200.0);
    same(stuck.reversed_frequency, 2e4_f64.sqrt());
    same(stuck.reversed_damping_ratio, 129.0 / (2.0 * 2e4_f64.sqrt()));
    // Without a spring nothing stick-slips.
    assert_eq!(audited.steady_sliding, None);
    // Critical steps from the roots of the characteristic polynomials by computer algebra.
    for (scheme, bristle, virgin, reversed, within) in [
        (Scheme::Euler, 0.012_908, 0.006_45, 0.006_45, false),
        (Scheme::RungeKutta4, 0.017_976, 0.028_042_5, 0.018_711_9, true),
    ] {
        let limits = audited.steps.iter().flatten().find(|limits| limits.scheme == scheme).unwrap();
        assert!((limits.bristle.unwrap() - bristle).abs() < 1e-5);
        assert!((limits.stuck_from_rest.unwrap() - virgin).abs() < 1e-7);
        assert!((limits.stuck_reversed.unwrap() - reversed).abs() < 1e-7);
        assert_eq!(limits.check(0.01).is_ok(), within, "{scheme}");
    }
    let passive = audited.steps.iter().flatten().find(|limits| limits.scheme == Scheme::Passive);
    assert!(passive.unwrap().check(0.01).is_ok());
    // With the paper's spring the rig stick-slips up to 29.86 mm/s.
    let found = audit(&contact, on_rig(0.01)).unwrap().steady_sliding;
    let Some(Threshold::StableAbove(speed)) = found else { panic!("{found:?}") };
    assert_within(1e-10, 1.0, speed, 0.029_863_165_817_389_6, || "speed".to_owned());
}

#[test]
fn the_table_says_the_same_in_words() {
    let contact = table_2_lugre().under_load(1.0).unwrap();
    let table = audit(&contact, on_rig(0.02)).unwrap().to_string();
    for words in [
        "audit of classical LuGre under 1 N, |v| ≤ 1 m/s\n",
        "passivity           FAILS: needs σ2 ≥ 32.25 s/m, has 0.04 ",
        "|z| ≤ 1.5e-4 m ",
        "force               no bound",
        "one solution: σ1 = 64.5, least dμ/d|v| = -42.848 s/m",
        "ζ = 0.32267; after a reversal ζ = 0.4562 ",
        "small motions die out above 0.029863 m/s, GROW just below",
        "at 0.02 s",
        "  Euler             2e-4        0.0064527   0.0064514     TOO LONG\n",
        "  Passive           no promise: the contact is not passive",
        "  Rosenbrock        any         any         any           ok\n",
    ] {
        assert!(table.contains(words), "no “{words}” in\n{table}");
    }
    // Every line fits, and names its reference in one column.
    for line in table.lines().skip(1) {
        assert!(line.chars().count() <= 130, "{line}");
        if !line.starts_with("  ") {
            assert_eq!(line.chars().nth(86), Some(' '), "{line}");
            assert_ne!(line.chars().nth(87), Some(' '), "{line}");
        }
    }
}

#[test]
fn the_table_in_the_documentation_is_the_one_that_is_printed() {
    let contact = table_2_lugre().under_load(1.0).unwrap();
    let documentation = include_str!("../../src/audit/mod.rs");
    for line in audit(&contact, on_rig(1e-3)).unwrap().to_string().lines() {
        // Name and finding take 20 and 66 columns; the source after them is not shown.
        let shown: String = line.chars().take(87).collect();
        let shown = shown.trim_end();
        assert!(documentation.lines().any(|doc| doc == format!("/// {shown}")), "{shown}");
    }
}

#[test]
fn an_audit_in_single_precision_says_the_same() {
    let (curve, bristle) = specimens::table_2();
    let contact = LuGre::classical(curve, bristle).under_load(1.0).unwrap();
    let mechanism = Mechanism { mass: 1.0_f32, spring_stiffness: 2.0, viscous_damping: 0.0 };
    let parameters = AuditParameters { mechanism: Some(mechanism), ..AuditParameters::up_to(1.0) };
    let said = audit(&contact, parameters).unwrap();
    assert_eq!(said.passivity.verdict, LawStatus::Fails);
    assert_eq!(said.characteristics.unwrap().needed_viscous_friction, Some(32.25));
    // A few roundings of 6e-8.
    assert!((said.inversion_margin.unwrap() - (64.5 - 42.848_194)).abs() < 1e-4);
    assert!((said.stuck.unwrap().damping_ratio - 64.54 / 200.02).abs() < 1e-5);
    assert!((said.drift.unwrap() / (1.5e-4 * (1.0_f32 / 0.75).ln()) - 1.0).abs() < 1e-5);
    // Rounding makes no threshold.
    let rising = FrBd::new(coulomb::<f32>(1.0, 0.04), bristle).under_load(1.0).unwrap();
    let found = audit(&rising, parameters).unwrap().steady_sliding;
    assert_eq!(found, Some(Threshold::AlwaysStable));
}

/// A page of fixed size.
struct Page([u8; 8192], usize);

impl Write for Page {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        let place = self.0.get_mut(self.1..self.1 + text.len()).ok_or(std::fmt::Error)?;
        place.copy_from_slice(text.as_bytes());
        self.1 += text.len();
        Ok(())
    }
}

#[test]
fn an_audit_and_its_table_allocate_nothing() {
    let contact = table_2_lugre().under_load(1.0).unwrap();
    let mut page = Page([0; 8192], 0);
    let counted = allocation_counter::measure(|| {
        write!(page, "{}", audit(&contact, on_rig(0.02)).unwrap()).unwrap();
    });
    assert!(page.1 > 1000);
    assert_eq!(counted.count_total, 0);
}

#[test]
fn what_is_out_of_range_is_refused_by_name() {
    let contact = table_2_frbd().under_load(1.0).unwrap();
    let good = AuditParameters::up_to(1.0);
    let rig = |rig| AuditParameters { mechanism: Some(rig), ..good };
    for (parameters, name) in [
        (AuditParameters::up_to(f64::NAN), "fastest"),
        (AuditParameters::up_to(f64::INFINITY), "fastest"),
        (AuditParameters::up_to(0.0), "fastest"),
        (AuditParameters { sample_time: Some(f64::NAN), ..good }, "sample_time"),
        (AuditParameters { sample_time: Some(0.0), ..good }, "sample_time"),
        (cycle(0.0, 1.5), "load_cycle.max"),
        (cycle(-1.6, 1.0), "-load_cycle.min"),
        (cycle(1.0, 0.5), "load_cycle.max"),
        (cycle(f64::NAN, 0.5), "-load_cycle.min"),
        (rig(Mechanism { mass: 0.0, ..RIG }), "mass"),
        (rig(Mechanism { spring_stiffness: -1.0, ..RIG }), "spring_stiffness"),
        (rig(Mechanism { viscous_damping: f64::NAN, ..RIG }), "viscous_damping"),
    ] {
        assert_eq!(audit(&contact, parameters).unwrap_err().name, name);
    }
    // No load: nothing to break away, and still an answer.
    let free = audit(&table_2_frbd().under_load(0.0).unwrap(), good).unwrap();
    assert_eq!(free.breakaway.unwrap(), 0.0);
}

#[test]
fn a_bristle_that_creeps_is_audited_as_one() {
    let bristle = MaxwellParameters { micro_stiffness: 1e4, series_damping: 200.0 };
    let model = FrBd::new(table_2_curve(), Maxwell::new(bristle).unwrap());
    let contact = model.under_load(1.0).unwrap();
    let mechanism = Some(Mechanism { spring_stiffness: 0.0, ..RIG });
    let parameters = AuditParameters { mechanism, ..AuditParameters::up_to(1.0) };
    let audit = audit(&contact, parameters).unwrap();
    // F_ss = v/(v/μ + 1/200) = 0.75 N.
    let creep = audit.creep.unwrap();
    let mu = table_2_curve().coefficient(creep.into());
    assert_within(1e-12, 0.75, creep / (creep / mu + 5e-3), 0.75, || "creep".to_owned());
    assert!((creep - 0.010_508).abs() < 1e-6);
    assert_eq!((audit.drift, audit.relaxation_at_rest), (None, 50.0));
    // m s² + λ s + σ0 p with λ = 1e4/200.
    let stuck = audit.stuck.unwrap();
    assert_within(1e-13, 100.0, stuck.frequency, 100.0, || "ω".to_owned());
    assert_within(1e-13, 0.25, stuck.damping_ratio, 0.25, || "ζ".to_owned());
    for limits in &audit.steps {
        let stuck = limits.and_then(|limits| limits.stuck_from_rest);
        assert!(stuck.is_none_or(|step| step > 1e-3), "{limits:?}");
    }
    let table = audit.to_string();
    assert!(table.contains("no end: the bristle creeps under any force"), "{table}");
    assert!(table.contains("m/s under 0.75 N; bristles relax at 50 1/s"), "{table}");
    assert!(table.contains("ω = 100 rad/s, ζ = 0.25;"), "{table}");
}

#[test]
fn a_curve_that_is_none_is_refused_with_the_speed_and_the_value() {
    let refused = |curve: fn(f64) -> (f64, f64)| {
        let curve = FunctionCurve::new(curve, Bounds { min: 0.5, max: 1.5 }).unwrap();
        let contact = FrBd::new(curve, table_2_bristle()).under_load(1.0).unwrap();
        audit(&contact, AuditParameters::up_to(1.0)).map_err(|error| error.to_string())
    };
    let outside = |value: &str| {
        format!("friction curve is {value}, but must lie between 0.5 and 1.5 at v = 1")
    };
    assert_eq!(refused(|v| (if v > 0.05 { -1.0 } else { 1.0 }, 0.0)), Err(outside("-1")));
    assert_eq!(refused(|v| (if v > 0.05 { f64::NAN } else { 1.0 }, 0.0)), Err(outside("NaN")));
    assert_eq!(refused(|_| (0.0, 0.0)), Err(outside("0")));
    assert_eq!(refused(|_| (5.0, 0.0)), Err(outside("5")));
    let slope = "slope of the friction curve is NaN, but must be finite at v = 1";
    assert_eq!(refused(|_| (1.0, f64::NAN)), Err(slope.to_owned()));
    // At rest alone.
    let at_rest = "friction curve is 2, but must lie between 0.5 and 1.5 at v = 0";
    assert_eq!(refused(|v| (if v > 0.0 { 1.0 } else { 2.0 }, 0.0)), Err(at_rest.to_owned()));
    assert!(refused(|v| (0.5 + 1.0 / (1.0 + v), -1.0 / ((1.0 + v) * (1.0 + v)))).is_ok());
    // What the crate has of its own stays within its bounds.
    check(256, recipe(), |r| {
        let model = FrBd::new(stribeck::<f64>(&r, 2.0), kelvin_voigt(r.stiffness, r.damping));
        assert_eq!(model.characteristics(1e3 * r.stribeck_velocity).unwrap().curve_fault, None);
    });
}

#[test]
fn bounds_of_a_curve_in_the_wrong_order_are_refused_as_such() {
    /// Constant friction with bounds of its own.
    #[derive(Debug, Clone)]
    struct Bounded(Bounds<f64>);
    impl FrictionCurve<f64> for Bounded {
        fn coefficient_and_slope(&self, _: Sliding<f64>) -> (f64, f64) {
            (1.0, 0.0)
        }
        fn bounds(&self, _: f64) -> Bounds<f64> {
            self.0
        }
    }
    let refused = |min, max| {
        let curve = Bounded(Bounds { min, max });
        let contact = FrBd::new(curve, table_2_bristle()).under_load(1.0).unwrap();
        audit(&contact, AuditParameters::up_to(1.0)).map(drop).map_err(|error| error.to_string())
    };
    let want = "upper bound of a curve is 0.5, but must be at least its lower bound = 1.5";
    assert_eq!(refused(1.5, 0.5), Err(want.to_owned()));
    assert!(refused(f64::NAN, 1.5).unwrap_err().starts_with("upper bound of a curve is 1.5"));
    assert_eq!(refused(1.0, 1.0), Ok(()));
}

#[test]
fn constant_friction_and_none_are_told_as_what_they_are() {
    let constant = FrBd::new(coulomb(0.7, 0.0), table_2_bristle());
    let table =
        |load| audit(&constant.under_load(load).unwrap(), on_rig(1e-3)).unwrap().to_string();
    let loaded = table(1.0);
    assert!(loaded.contains("small motions neither grow nor die out at any speed"), "{loaded}");
    assert!(loaded.contains("Routh–Hurwitz, 1e-6 … 1 m/s"), "{loaded}");
    assert!(table(0.0).contains("sliding on spring   no friction"), "{}", table(0.0));
}

#[test]
fn a_cycle_is_as_large_as_the_larger_of_its_two_forces() {
    // Elastic up to 8e-5 m · 1e4 N/m = 0.8 N: a pull of 1.2 N is beyond it, whatever the push. An
    // elasto-plastic bristle has no drift below, and above it no closed form.
    let contact = soft().under_load(1.0).unwrap();
    let yielding = |from, to| {
        let yielding = audit(&contact, cycle(from, to)).unwrap();
        (yielding.drift, yielding.creep)
    };
    for within in [yielding(-0.7, 0.1), yielding(-0.1, 0.7), yielding(0.0, 0.8)] {
        assert_eq!(within, (Some(0.0), Some(0.0)));
    }
    for beyond in [yielding(-1.2, 0.1), yielding(-0.1, 1.2), yielding(0.0, 0.81)] {
        assert!(beyond.0.is_none() && beyond.1 != Some(0.0), "{beyond:?}");
    }
}

#[test]
fn the_table_says_that_the_undamped_bristle_of_the_tyre_folds() {
    let curve = Stribeck::new(paper::TYRE_CURVE).unwrap();
    let tyre = FrBd::new(curve, KelvinVoigt::new(paper::TYRE_BRISTLE).unwrap());
    let audit = audit(&tyre.under_load(1.0).unwrap(), AuditParameters::up_to(20.0)).unwrap();
    // σ2 − (μ_s − μ_d) √(2/e)/v_S.
    assert!(audit.to_string().contains("FOLDS: σ1 = 0, least dμ/d|v| = -0.032511 s/m"), "{audit}");
    let firm = audit_of(table_2_frbd());
    assert!(firm.to_string().contains("one solution"), "{firm}");
}

/// What an audit prints of a joint: every unit of translation has its rotary counterpart, every
/// number stays.
#[test]
fn the_audit_of_a_joint_prints_radians_and_newton_metres() {
    let print = |contact: &dyn Fn(AuditParameters<f64>) -> Audit<f64>, mechanism| {
        let load_cycle = Some(Bounds { min: -0.1, max: 0.4 });
        let sample_time = Some(1e-3);
        let of =
            |units| AuditParameters { fastest: 1.0, mechanism, sample_time, load_cycle, units };
        [Units::Translation, Units::Rotation].map(|units| contact(of(units)).to_string())
    };
    let (curve, bristle) = (table_2_curve(), table_2_bristle());
    let creeping = Maxwell::new(MaxwellParameters { micro_stiffness: 1e4, series_damping: 200.0 });
    let steep = Stribeck::new(StribeckParameters { stribeck_exponent: 1.0, ..paper::TYRE_CURVE });
    let smooth = FrBd::new(steep.unwrap(), bristle).regularised(SquareRoot::new(1e-6).unwrap());
    let smooth = smooth.under_load(1.0).unwrap();
    let creeping = FrBd::new(curve, creeping.unwrap()).under_load(1.0).unwrap();
    let classical = LuGre::classical(curve, bristle).under_load(1.0).unwrap();
    let tables = [
        print(
            &|parameters| audit(&table_2_frbd().under_load(1.0).unwrap(), parameters).unwrap(),
            Some(RIG),
        ),
        print(&|parameters| audit(&smooth, parameters).unwrap(), Some(RIG)),
        print(&|parameters| audit(&creeping, parameters).unwrap(), None),
        print(&|parameters| audit(&classical, parameters).unwrap(), Some(RIG)),
    ];
    for [line, joint] in &tables {
        let words = |table: &str| -> Vec<String> {
            let table = table.replace("Theorem", "");
            table.split([' ', '\n', ',', ';', ':']).map(str::to_owned).collect()
        };
        for word in ["m/s", "s/m", "1/m", "m", "N", "force", "mass"] {
            assert!(!words(&joint.replace("N m", "")).contains(&word.into()), "{word}: {joint}");
        }
        assert!(line.contains(" m/s") && line.contains(" N") && !line.contains("rad\n"), "{line}");
        let numbers = |table: &str| -> Vec<f64> {
            words(table).iter().filter_map(|word| word.parse().ok()).collect()
        };
        assert_eq!(numbers(line), numbers(joint), "{line}{joint}");
    }
    let [_, joint] = &tables[0];
    for row in [
        "audit of FrBD under 1 N m, |v| ≤ 1 rad/s\n",
        "deflection          |z| ≤ 1.5e-4 rad ",
        "torque              |F| ≤ 1.5",
        "breakaway           F_b = p μ_s = 1.5 N m, of which 0.267 is used ",
        " rad per slow cycle -0.1 ↔ 0.4 N m ",
        "stuck inertia       ω = ",
        "small motions die out above 0.029863 rad/s, GROW just below ",
        "1e-6 … 1 rad/s\n",
    ] {
        assert!(joint.contains(row), "{row}: {joint}");
    }
    assert!(tables[1][1].contains("kink, dμ/d|v| = ") && tables[1][1].contains(" s/rad: split"));
    assert!(tables[1][1].contains("|0|_ε = 0.001 rad/s"), "{}", tables[1][1]);
    assert!(tables[2][1].contains(" rad/s under 0.4 N m; bristles relax at 50 1/s"));
    assert!(tables[3][1].contains("needs σ2 ≥ 32.25 s/rad, has 0.04"));
    assert!(tables[3][1].contains("W at v = 1 rad/s, z = 1.5e-4 rad"));
}

#[test]
fn the_table_says_that_no_step_is_known_where_the_relaxation_rate_has_no_bound() {
    let table = audit_of(Bare(table_2_frbd())).to_string();
    let euler = table.lines().find(|line| line.starts_with("  Euler ")).unwrap();
    assert!(euler.ends_with("none is known: the relaxation rate has no bound"), "{table}");
}

#[test]
fn of_a_dashpot_that_varies_the_least_damping_counts() {
    let micro_damping = VelocityLaw::new(
        |sliding: Sliding<f64>| {
            let t = sliding.velocity().tanh();
            (60.0 - 20.0 * t * t, -40.0 * t * (1.0 - t * t))
        },
        Bounds { min: 40.0, max: 60.0 },
    );
    let audit = audit_of(FrBd::new(table_2_curve(), own_element(1e4, micro_damping)));
    // 40 + σ2 − (μ_s − μ_d) √(2/e)/v_S < 0 < 60 + …
    let want = 40.04 - 50.0 * (2.0 / 1f64.exp()).sqrt();
    assert_within(1e-13, 40.0, audit.inversion_margin.unwrap(), want, || "margin".to_owned());
}

#[test]
fn of_a_spring_that_varies_the_least_stiffness_bounds_the_deflection() {
    let limits = audit_of(FrBd::new(table_2_curve(), own_element(stiffening(1.0), 64.5))).limits;
    // The most that the curve takes up to 1 m/s is μ_s; and stretched at 7e3, it pulls at 1.3e4.
    let most = table_2_curve().bounds(1.0).max;
    assert_within(1e-15, 1e-4, limits.deflection.unwrap(), most / 7e3, || "deflection".into());
    assert_within(1e-15, 1.0, limits.force.unwrap(), most * 13.0 / 7.0, || "force".into());
}

/// With σ0 = s (1 + 0.3 tanh u), u = v/v_d, FrBD has (K r − c₀)²/4 K λ c₂ =
/// 0.09 μ tanh² u/(4 σ1 v_d |u| (1 + 0.3 tanh u)), largest four decades below the fastest speed.
#[test]
fn a_lack_of_damping_at_slow_sliding_is_found_below_any_speed() {
    let (slow, mu, damping) = (1e-4, 0.5, 64.5);
    let model = FrBd::new(coulomb(mu, 0.0), own_element(stiffening(slow), damping));
    let ratio = |u: f64| u.tanh().powi(2) / (u * (1.0 - 0.3 * u.tanh()));
    let most = (1..4000).map(|n| ratio(1e-3 * f64::from(n))).fold(0.0, f64::max);
    let want = 0.09 * mu / (4.0 * damping * slow) * most;
    // Up to (ln 10/32/2)² away from the top, for speeds are 32 a decade.
    let excess = audit_of(model).passivity.excess;
    assert_within(1.4e-3, want, excess, want, || "excess".to_owned());
}

#[test]
fn no_passive_step_is_promised_to_a_contact_that_is_not_passive_at_every_deflection() {
    let with = |micro_damping: f64| {
        let bristle = own_element(stiffening(1.0), micro_damping);
        let audit = audit_of(FrBd::new(table_2_curve(), bristle));
        let passive = Scheme::ALL.iter().position(|&scheme| scheme == Scheme::Passive).unwrap();
        (audit.passivity.excess, audit.steps[passive].is_some())
    };
    // The excess goes with 1/σ1.
    let needed = 64.5 * with(64.5).0;
    for (excess, promised) in [(0.5, true), (0.9, true), (1.1, false), (2.0, false), (3.9, false)] {
        let got = with(needed / excess);
        assert_within(1e-12, excess, got.0, excess, || "excess".to_owned());
        assert_eq!(got.1, promised, "excess {excess}");
    }
}

#[test]
fn no_drift_is_told_of_friction_that_is_not_the_same_both_ways() {
    let drift = |backward, stribeck_velocity| {
        let from = |highest| {
            curve(|curve| {
                (curve.static_coefficient, curve.dynamic_coefficient) = (highest, 0.7);
                curve.stribeck_velocity = stribeck_velocity;
            })
        };
        let curve = Asymmetric { forward: from(1.5), backward: from(backward) };
        let contact = FrBd::new(curve, table_2_bristle()).under_load(1.0).unwrap();
        audit(&contact, cycle(0.0, 0.5)).unwrap().drift
    };
    assert_eq!(drift(0.8, 0.01), None);
    // The curves are different below a hundred thousandth of the fastest speed alone.
    assert_eq!(drift(0.8, 1e-5), None);
    // The closed form, (μ_s/σ0) ln[F_b²/(F_b² − F²)].
    let want = 1.5e-4 * (2.25_f64 / 2.0).ln();
    assert_within(1e-12, want, drift(1.5, 0.01).unwrap(), want, || "drift".to_owned());
}

/// A part of 2.943 N that shakes by a half in a grip of 16 N that varies by a half, μ_s = 0.8: at
/// worst 4.4145 N of 6.4 N.
#[test]
fn the_margin_of_a_grip_is_the_weight_over_the_least_that_it_holds() {
    let curve = curve(|curve| (curve.static_coefficient, curve.dynamic_coefficient) = (0.8, 0.6));
    let least = FrBd::new(curve, table_2_bristle()).under_load(8.0).unwrap();
    let shaken = cycle(0.5 * 2.943, 1.5 * 2.943);
    let grip = audit(&least, shaken).unwrap();
    assert_within(1e-15, 1.0, grip.load_share().unwrap(), 4.4145 / 6.4, || "share".to_owned());
    assert!(grip.to_string().contains("F_b = p μ_s = 6.4 N, of which 0.69 is used"), "{grip}");
    // The cycle that is looked at without one says nothing of a grip.
    let free = audit(&least, AuditParameters::up_to(1.0)).unwrap();
    assert!(free.load_share().is_none() && !free.to_string().contains("used"));
    let idle = FrBd::new(curve, table_2_bristle()).under_load(0.0).unwrap();
    assert_eq!(audit(&idle, shaken).unwrap().load_share(), None);
}
