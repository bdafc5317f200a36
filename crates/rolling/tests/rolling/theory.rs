//! The theorems on a rolling patch, each against simulations that share nothing with them but the
//! model.

use std::f64::consts::TAU;

use crate::tyre::{
    LENGTH, LOAD, Model, STIFFNESS, by_rolling_speed, constant, coulomb, dahl, exponential, frbd,
    function, loaded as patch, lugre, lugre_inside, motion, parabolic, table, tyre,
};
use bristle::Bristle;
use bristle::regularisation::SquareRoot;
use bristle::signal::Function;
use bristle_rolling::{FunctionPressure, Motion, Patch, PatchPassivity, Pressure};
use bristle_specimens::{assert_within, check, integral, specimens};
use nalgebra::Complex;
use proptest::collection::vec;

fn trapezoidal(rising_part: f64) -> impl Pressure<f64> + Copy {
    let falling_part = 0.25;
    table([(0.0, 0.0), (rising_part, 1.0), (1.0 - falling_part, 1.0), (1.0, 0.0)])
}

/// Constant, then falling.
fn falling() -> impl Pressure<f64> + Copy {
    table([(0.0, 1.0), (0.5, 1.0), (0.75, 1.0), (1.0, 0.0)])
}

#[test]
fn falling_pressure_is_passive_and_rising_pressure_is_named_with_its_place() {
    let model = frbd(0.1);
    for passivity in [
        patch(model, constant()).passivity(),
        patch(model, exponential(0.1)).passivity(),
        patch(model, exponential(50.0)).passivity(),
        patch(model, falling()).passivity(),
    ] {
        assert_eq!(passivity, PatchPassivity::Passive);
    }
    let near = |answer: PatchPassivity<f64>, place: f64, slope: f64| {
        let PatchPassivity::Rises { place: at, slope: by } = answer else { panic!("{answer:?}") };
        assert!((at - place).abs() < 1e-12, "at {at}, not {place}");
        assert_within(1e-12, slope, by, slope, || "slope".into());
    };
    let stiffness = 252.0 * LOAD / LENGTH;
    near(patch(model, parabolic()).passivity(), 0.0, 6.0 * stiffness);
    // p' = p0 a e^(aξ) with p0 = a/(e^a − 1), at the outlet.
    let rising = stiffness * 16.0 * 4.0_f64.exp() / 4.0_f64.exp_m1();
    near(patch(model, exponential(-4.0)).passivity(), 1.0, rising);
    // The plateau's pressure follows from the area 1 − 0.2/2 − 0.25/2.
    near(patch(model, trapezoidal(0.2)).passivity(), 0.0, stiffness / 0.775 / 0.2);

    let (uniform, flat) = (|_: f64| (252.0, 0.0), |_: f64| (1.0, 0.0));
    let table = table([(0.0, 2.0), (0.3, 1.0), (0.6, 1.5), (1.0, 0.0)]);
    near(PatchPassivity::of(&table, uniform, flat), 0.3, 252.0 * 0.5 / 0.3);
    let steps = |up: f64| {
        let step = move |x: f64| if x < 0.4 { (1.0, 0.0) } else { (1.0 + up, 0.0) };
        PatchPassivity::of(&function(step, [0.4]), uniform, flat)
    };
    assert_eq!(steps(-0.5), PatchPassivity::Passive);
    assert!(matches!(steps(0.1), PatchPassivity::Rises { slope: f64::INFINITY, .. }));
}

#[test]
fn the_condition_weighs_pressure_stiffness_and_rolling_speed() {
    // Σ0 V = e^((b + c − a)ξ): passive iff b + c ≤ a.
    check(100, (0.1..3.0_f64, -3.0..3.0_f64, -3.0..3.0_f64), |(a, b, c)| {
        let growing = |rate: f64| move |x: f64| ((rate * x).exp(), rate * (rate * x).exp());
        let answer = PatchPassivity::of(&exponential(a), growing(b), growing(c));
        let rate = b + c - a;
        match answer {
            PatchPassivity::Passive => assert!(rate <= 1e-12, "{rate}"),
            PatchPassivity::Rises { place, slope } => {
                assert!(rate >= -1e-12 && place > 0.999, "{rate} {place}");
                let want = a / -(-a).exp_m1() * rate * rate.exp();
                assert_within(1e-12, want.max(1.0), slope, want, || format!("{a} {b} {c}"));
            }
            PatchPassivity::Model => unreachable!(),
        }
    });
    // Exactly balanced, but for rounding of large terms.
    let growing = |rate: f64| move |x: f64| (1e6 * (rate * x).exp(), 1e6 * rate * (rate * x).exp());
    let balanced = PatchPassivity::of(&exponential(2.1), growing(0.8), growing(1.3));
    assert_eq!(balanced, PatchPassivity::Passive);
    // What is not a number is no proof: a value, a slope, and that at the last place looked at.
    let flat = constant::<f64>();
    let uniform = |_: f64| (252.0, 0.0);
    let nan = |_: f64| (252.0, f64::NAN);
    let at_the_end = |place: f64| (252.0, if place > 0.999 { f64::NAN } else { 0.0 });
    for found in [
        PatchPassivity::of(&flat, |_| (f64::NAN, 0.0), uniform),
        PatchPassivity::of(&flat, nan, uniform),
        PatchPassivity::of(&flat, uniform, nan),
        PatchPassivity::of(&flat, at_the_end, uniform),
    ] {
        assert!(matches!(found, PatchPassivity::Rises { .. }), "{found:?}");
    }
}

#[test]
fn a_model_that_is_not_passive_makes_no_passive_patch() {
    let passivity = patch(specimens::table_2_lugre(), constant()).passivity();
    assert_eq!(passivity, PatchPassivity::Model);
}

/// θ of the largest activity of a parabola, its damping number, and the ends of the first bands,
/// tan(θ/2) = θ/2: by mpmath.
const WORST: f64 = 7.314_42;
const LEAST: f64 = 0.011_115_722_3;
const BAND_ENDS: [f64; 2] = [8.986_818_915_82, 15.450_503_673_9];

#[test]
fn a_pressure_that_rises_needs_damping_and_the_parabola_that_of_its_closed_form() {
    fn least<P: Pressure<f64>>(pressure: P) -> f64 {
        patch(tyre(), pressure).least_passive_damping(160.0).unwrap()
    }
    let parabola = patch(tyre(), parabolic());
    for transport in [1.0, 160.0] {
        let needed = parabola.least_passive_damping(LENGTH * transport).unwrap();
        // Half of the last printed digit.
        let number = needed * transport / STIFFNESS;
        assert!((number - LEAST).abs() <= 0.5e-10, "{number}");
    }
    assert_eq!(parabola.least_passive_damping(0.0).unwrap_err().name, "rolling_speed");
    assert_eq!(least(constant()), 0.0);
    assert_eq!(least(exponential(3.0)), 0.0);
    assert_eq!(least(falling()), 0.0);
    assert!(least(trapezoidal(0.05)) > 0.0);
    // S of a constant pressure, (1 − cos θ)/θ², touches zero in every period: to f32's roundings.
    fn in_f32<P: Pressure<f32>>(pressure: P) -> f32 {
        crate::tyre::patch(coulomb(0.5, 0.0), pressure).least_passive_damping(160.0).unwrap()
    }
    let one = |_: f32| (1.0, 0.0);
    assert_eq!(in_f32(constant()), 0.0);
    assert_eq!(in_f32(FunctionPressure::new(Function::new(one, [0.5])).unwrap()), 0.0);
    assert_eq!(in_f32(FunctionPressure::new(Function::new(one, [])).unwrap()), 0.0);
}

#[test]
fn a_small_sinusoid_gets_energy_from_a_parabola_in_its_bands_only() {
    let transport = 160.0;
    let still = motion(0.0, transport);
    let response = |damping: f64, theta: f64| {
        let parabola = patch(frbd(damping), parabolic());
        parabola.linearised(still).unwrap().by_slip_velocity(theta * transport).re
    };
    let least = LEAST * 252.0 / transport;
    let mut theta = 0.01;
    let size = response(0.0, 1e-3);
    for (n, end) in BAND_ENDS.into_iter().enumerate() {
        let start = TAU * (n + 1) as f64;
        assert!(response(0.0, start + 1e-3) < 0.0 && response(0.0, start - 1e-3) > 0.0);
        assert!(response(0.0, end - 1e-8) < 0.0 && response(0.0, end + 1e-8) > 0.0);
    }
    while theta < 60.0 {
        assert!(response(least * (1.0 + 1e-9), theta) > -1e-12 * size, "{theta}");
        theta += 0.01;
    }
    assert!(response(least * (1.0 - 1e-6), WORST) < 0.0);
}

/// v = v* + a cos ωt, V = V* + b cos ωt.
#[derive(Clone, Copy)]
struct Wobble {
    motion: Motion<f64>,
    slip_amplitude: f64,
    transport_amplitude: f64,
    angular_frequency: f64,
}

impl Wobble {
    fn slip_velocity(&self, t: f64) -> f64 {
        self.motion.slip_velocity + self.slip_amplitude * (self.angular_frequency * t).cos()
    }

    /// Mean of V.
    fn transport(&self) -> f64 {
        self.motion.rolling_speed / LENGTH
    }

    /// ∫ V dt
    fn travelled(&self, t: f64) -> f64 {
        let phase = self.angular_frequency * t;
        self.transport() * t + self.transport_amplitude / self.angular_frequency * phase.sin()
    }

    /// When the bristle that is at a place now entered.
    fn entry(&self, place: f64, now: f64) -> f64 {
        let mut t = now - place / self.transport();
        for _ in 0..20 {
            let speed =
                self.transport() + self.transport_amplitude * (self.angular_frequency * t).cos();
            t -= (self.travelled(t) + place - self.travelled(now)) / speed;
        }
        t
    }

    /// F(t): the bristles of a quadrature, each followed from its entry by Runge and Kutta's
    /// method.
    fn force<M: Model, P: Pressure<f64>>(&self, patch: &Patch<f64, M, P>, now: f64) -> f64 {
        // κ/STEPS of a ninth at most: 1e-7 by its fourth power.
        const STEPS: usize = 100;
        let v = |t| self.slip_velocity(t);
        let weight = patch.normal_force() / patch.pressure().total();
        weight
            * integral(0.0, 1.0, 8, |place| {
                let start = self.entry(place, now);
                let h = (now - start) / STEPS as f64;
                let rate = |t: f64, z: f64| patch.model().rate(v(t), z);
                let mut z = 0.0;
                for step in 0..STEPS {
                    let t = start + h * step as f64;
                    let k1 = rate(t, z);
                    let k2 = rate(t + 0.5 * h, z + 0.5 * h * k1);
                    let k3 = rate(t + 0.5 * h, z + 0.5 * h * k2);
                    let k4 = rate(t + h, z + h * k3);
                    z += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
                }
                patch.pressure().at(place) * patch.model().coefficient(v(now), z)
            })
    }

    /// The first harmonic of the force over the amplitude.
    fn response<M: Model, P: Pressure<f64>>(&self, patch: &Patch<f64, M, P>) -> Complex<f64> {
        const SAMPLES: usize = 8;
        let sum: Complex<f64> = (0..SAMPLES)
            .map(|sample| {
                let phase = TAU * sample as f64 / SAMPLES as f64;
                let force = self.force(patch, phase / self.angular_frequency);
                Complex::new(force * phase.cos(), -force * phase.sin())
            })
            .sum();
        sum * 2.0 / (SAMPLES as f64 * (self.slip_amplitude + self.transport_amplitude))
    }
}

fn check_response<M: Model, P: Pressure<f64>>(
    model: M,
    pressure: P,
    velocities: &[f64],
    name: &str,
) {
    let patch = patch(model, pressure);
    let transport = 160.0;
    for &slip_velocity in velocities {
        let motion = motion(slip_velocity, transport);
        let linearised = patch.linearised(motion).unwrap();
        let faster = |omega: f64| by_rolling_speed(&patch, motion, omega);
        for theta in [0.1, 1.0, 4.0, 7.3] {
            let angular_frequency = theta * transport;
            // Small against v* and v_S, large against rounding of the force.
            let amplitude = 1e-4 * slip_velocity.abs().clamp(1e-2, 1.0);
            let still =
                Wobble { motion, slip_amplitude: 0.0, transport_amplitude: 0.0, angular_frequency };
            let name = |what| move || format!("{name}, {what} at v = {slip_velocity}, θ = {theta}");
            let slip = Wobble { slip_amplitude: amplitude, ..still };
            let (got, want) =
                (linearised.by_slip_velocity(angular_frequency), slip.response(&patch));
            // Second order in 1e-4; about v = 0, where |v| is not smooth, first order in 1e-6
            // σ0/(μ V).
            assert_within(3e-6, want.norm(), (got - want).norm(), 0.0, name("F̃/ṽ"));
            let rolling = Wobble { transport_amplitude: 1e-4 * transport, ..still };
            let (got, want) = (faster(angular_frequency), rolling.response(&patch) / LENGTH);
            // Against the size of the static response, from which that of a high frequency falls.
            let size = faster(0.0).norm().max(want.norm());
            assert_within(1e-6, size, (got - want).norm(), 0.0, name("F̃/Ṽ"));
        }
    }
}

#[test]
fn the_frequency_response_is_that_of_followed_bristles() {
    let both = [0.0, 0.6, -4.0];
    check_response(tyre(), constant(), &both, "FrBD, constant");
    check_response(frbd(0.05), parabolic(), &both, "FrBD, parabolic");
    check_response(lugre_inside(0.05), parabolic(), &[0.6], "LuGre inside, parabolic");
    check_response(lugre(0.05), exponential(2.0), &[0.0, 0.6], "LuGre, exponential");
    check_response(dahl(), exponential(0.1), &[2.0], "Dahl, exponential");
    let regularised = frbd(0.05).regularised(SquareRoot::new(0.04).unwrap());
    check_response(regularised, parabolic(), &both, "regularised");
}

#[test]
fn a_slow_response_is_the_static_one() {
    fn same<M: Model, P: Pressure<f64>>(model: M, pressure: P, v: f64, speed: f64) {
        let patch = patch(model, pressure);
        let motion = Motion { slip_velocity: v, rolling_speed: speed };
        let linearised = patch.linearised(motion).unwrap();
        let at =
            |omega| [linearised.by_slip_velocity(omega), by_rolling_speed(&patch, motion, omega)];
        let [by_v, by_u] = at(0.0);
        let size = patch.slip_stiffness(speed).unwrap() / speed;
        for [slip, transport] in [at(1e-9), at(-1e-9)] {
            let scale = size.max(by_v.re.abs());
            assert_within(1e-13, scale, slip.re, by_v.re, || format!("{v} {speed}"));
            let off = (transport.re - by_u.re).abs();
            assert!(off <= 1e-13 * by_u.re.abs(), "{v} {speed} by V: {off:e}");
            // What ω = 1e-9 turns them by.
            assert!(slip.im.abs() <= 1e-7 * scale);
        }
    }
    check(40, (-9.0..3.0_f64, -2.0..2.0_f64, 0.0..0.1_f64), |(v, speed, damping)| {
        let (v, speed) = (10.0_f64.powf(v), 10.0_f64.powf(speed));
        same(frbd(damping), parabolic(), v, speed);
        same(frbd(damping), exponential(0.1), -v, speed);
        same(tyre(), trapezoidal(0.2), v, speed);
        same(dahl(), constant(), v, speed);
    });
}

#[test]
fn the_response_has_the_symmetry_of_a_real_system_and_fades() {
    let motion = Motion { slip_velocity: 0.6, rolling_speed: 16.0 };
    let parabola = patch(frbd(0.05), parabolic());
    let linearised = parabola.linearised(motion).unwrap();
    for frequency in [1e-3, 10.0, 3e3, 1e6] {
        let (one, other) =
            (linearised.by_slip_velocity(frequency), linearised.by_slip_velocity(-frequency));
        assert_within(1e-12, one.norm(), (one - other.conj()).norm(), 0.0, || "slip".into());
    }
    // What is left at high frequency is the dashpots: L ∫ p H2 dξ.
    let direct =
        LOAD * integral(0.0, 1.0, 20, |place| linearised.direct(place) * parabolic().at(place));
    // c₀ H1/ω is a ten-thousandth of it.
    assert_within(1e-3, direct, linearised.by_slip_velocity(1e8).re, direct, || "dashpots".into());
    // As 1/θ.
    assert!(
        by_rolling_speed(&parabola, motion, 1e8).norm()
            < 1e-5 * by_rolling_speed(&parabola, motion, 0.0).norm()
    );
}

const BRISTLES: usize = 100;

/// Moves a patch of bristles on by one place of their row at a held velocity.
fn advance<M: Model>(model: &M, row: &mut [f64], v: f64, transport: f64) {
    let h = 1.0 / (BRISTLES as f64 * transport);
    for i in (1..row.len()).rev() {
        row[i] = model.hold(v, row[i - 1], h).deflection;
    }
    row[0] = model.hold(v, 0.0, 0.5 * h).deflection;
}

fn place(i: usize) -> f64 {
    (i as f64 + 0.5) / BRISTLES as f64
}

fn norm(row: &[f64]) -> f64 {
    (row.iter().map(|z| z * z).sum::<f64>() / BRISTLES as f64).sqrt()
}

fn check_limits<M: Model, P: Pressure<f64>>(
    model: M,
    pressure: P,
    initial: f64,
    velocities: &[f64],
) {
    let transport = 50.0;
    let patch = patch(model, pressure);
    let fastest = velocities.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    // A rough initial deflection.
    let mut row: Vec<f64> = (0..BRISTLES).map(|i| initial * (7.0 * i as f64).sin()).collect();
    let initial_norm = norm(&row);
    // The row's sums miss the integrals by the square of a place's width.
    let slack = 1.0 + 1e-3;
    for (step, &v) in velocities.iter().flat_map(|v| std::iter::repeat_n(v, 20)).enumerate() {
        advance(patch.model(), &mut row, v, transport);
        // A row of a hundred is hardly another after one of its places.
        if step % 4 != 3 {
            continue;
        }
        let elapsed = (step + 1) as f64 / (BRISTLES as f64 * transport);
        let limits = patch.limits(motion(fastest, transport), elapsed).unwrap();
        let got = norm(&row);
        let most = limits.gain + limits.remaining_deflection * initial_norm;
        assert!(got <= most * slack, "‖z‖ = {got} > {most} at step {step}");
        if step >= BRISTLES {
            for (i, z) in row.iter().enumerate() {
                let most = limits.deflection(place(i));
                assert!(z.abs() <= most * (1.0 + 1e-12), "z = {z} > {most} at {i}, step {step}");
            }
        }
        let force = row
            .iter()
            .enumerate()
            .map(|(i, &z)| patch.pressure().at(place(i)) * patch.model().coefficient(v, z))
            .sum::<f64>()
            * (patch.normal_force() / patch.pressure().total())
            / BRISTLES as f64;
        let most = limits.force + limits.remaining_force * initial_norm;
        assert!(force.abs() <= most * slack, "|F| = {force} > {most} at step {step}");
    }
}

#[test]
fn deflection_and_force_stay_within_their_limits() {
    let runs = (vec(-1.0..1.0_f64, 1..14), -4.0..2.0_f64, -6.0..-1.0_f64, 0.0..0.1_f64);
    check(24, runs, |(velocities, size, initial, damping)| {
        let velocities: Vec<_> = velocities.iter().map(|v| v * 10.0_f64.powf(size)).collect();
        let initial = 10.0_f64.powf(initial);
        check_limits(frbd(damping), parabolic(), initial, &velocities);
        check_limits(frbd(damping), exponential(1.0), initial, &velocities);
        check_limits(lugre(damping), constant(), initial, &velocities);
        check_limits(lugre_inside(damping), trapezoidal(0.2), initial, &velocities);
        check_limits(dahl(), exponential(0.1), initial, &velocities);
    });
}

#[test]
fn the_gain_is_attained_by_a_step_in_adhesion_and_in_sliding() {
    let patch = patch(tyre(), constant());
    let transport = 50.0;
    let gain = |fastest| patch.limits(motion(fastest, transport), 1.0).unwrap().gain;
    // Adhesion: z = v ξ/V up to κ of 1e-6.
    let v = 1e-7;
    let mut row = [0.0; BRISTLES];
    for _ in 0..BRISTLES {
        advance(patch.model(), &mut row, v, transport);
    }
    let steady = patch.steady(motion(v, transport)).unwrap();
    assert_within(1e-4, gain(v), norm(&row), gain(v), || "adhesion, simulated".into());
    let got = integral(0.0, 1.0, 20, |place| steady.deflection(place).powi(2)).sqrt();
    assert_within(1e-5, gain(v), got, gain(v), || "adhesion".into());
    assert_within(1e-15, gain(v), gain(v), v / transport / 3.0_f64.sqrt(), || "γ".into());
    // The integral of a², where the limit is reached in the middle of the patch.
    for fastest in [1e-3, 0.1, 0.5, 3.0, 1e3] {
        let limits = patch.limits(motion(fastest, transport), 1.0).unwrap();
        let want = integral(0.0, 1.0, 2000, |place| limits.deflection(place).powi(2)).sqrt();
        // The kink of a² in one of 2000 panels, which may be the first.
        assert_within(1e-5, want, gain(fastest), want, || format!("γ({fastest})"));
    }
    assert_eq!(gain(0.0), 0.0);
}

#[test]
fn the_limit_of_the_force_is_attained_by_an_initial_deflection_like_the_pressure() {
    // Schwarz' inequality is an equality for z₀ = c p, with v = 0.
    let patch = patch(tyre(), parabolic());
    let limits = patch.limits(motion(0.0, 50.0), 0.0).unwrap();
    let load = patch.normal_force() / (LENGTH * patch.pressure().total());
    let (c, p) = (1e-6, |place| load * patch.pressure().at(place));
    let square = integral(0.0, 1.0, 10, |place| p(place) * p(place));
    let force = LENGTH * 252.0 * c * square;
    let most = limits.force + limits.remaining_force * c * square.sqrt();
    assert_within(1e-13, force, most, force, || "|F|".into());
}

#[test]
fn the_initial_deflection_is_forgotten_after_one_transit() {
    let patch = patch(frbd(0.05), parabolic());
    let at = |elapsed| patch.limits(motion(0.0, 50.0), elapsed).unwrap();
    let (before, after) = (at(0.0199), at(0.0201));
    assert_eq!((before.remaining_deflection, before.gain), (1.0, 0.0));
    assert_eq!((after.remaining_deflection, after.remaining_force, after.force), (0.0, 0.0, 0.0));
    assert!(at(0.01).remaining_force > at(0.019).remaining_force);
    for (fastest, transport, elapsed, name) in [
        (-1.0, 1.0, 0.0, "slip_velocity"),
        (f64::INFINITY, 1.0, 0.0, "slip_velocity"),
        (1.0, 0.0, 0.0, "rolling_speed"),
        (1.0, -1.0, 0.0, "rolling_speed"),
        (1.0, 1.0, -1.0, "elapsed"),
        (1.0, 1.0, f64::NAN, "elapsed"),
    ] {
        let refused = patch.limits(motion(fastest, transport), elapsed).unwrap_err();
        assert_eq!(refused.name, name);
    }
}

#[test]
fn the_limit_of_the_force_is_that_of_the_curve_where_the_bristles_slide() {
    // Dashpots, whose c₂ v exceeds any other limit at such velocities.
    let model = coulomb(0.4, 0.3);
    for fastest in [1e2, 1e6, 1e12] {
        for transport in [1.0, 160.0] {
            let patch = patch(model, trapezoidal(0.125));
            let got = patch.limits(motion(fastest, transport), 2.0).unwrap().force;
            // F_z max μ, up to the rounding of the load.
            assert_within(1e-14, 1.0, got / (LOAD * 0.4), 1.0, || format!("{fastest}"));
        }
    }
}

#[test]
fn what_rises_between_two_places_is_seen_though_its_slope_is_not() {
    let flat = constant::<f64>();
    let uniform = |_: f64| (100.0, 0.0);
    // A step up from 200 to 300, at a third, which is none of the 257 places.
    let step = |place: f64| (if place < 1.0 / 3.0 { 200.0 } else { 300.0 }, 0.0);
    for found in
        [PatchPassivity::of(&flat, step, uniform), PatchPassivity::of(&flat, uniform, step)]
    {
        let PatchPassivity::Rises { place, slope } = found else { panic!("{found:?}") };
        // Over one of 256 parts; the place is that at its end.
        assert_eq!((place, slope), (86.0 / 256.0, 1e4 * 256.0));
    }
    let down = |place: f64| (if place < 1.0 / 3.0 { 300.0 } else { 200.0 }, 0.0);
    assert_eq!(PatchPassivity::of(&flat, down, uniform), PatchPassivity::Passive);
}

#[test]
fn of_two_active_bands_the_worse_counts_though_its_phase_is_larger() {
    // Two narrow ridges. The transform of a triangle of half-width w about c with the area A has
    // the imaginary part −A sin(θc) (sin(θw/2)/(θw/2))².
    let (w, first, second) = (0.02, (1.0 / 3.0, 0.4), (0.98, 0.6));
    let ridge = move |x: f64, (middle, area): (f64, f64)| match (x - middle) / w {
        t if (-1.0..0.0).contains(&t) => (area / w * (1.0 + t), area / (w * w)),
        t if (0.0..1.0).contains(&t) => (area / w * (1.0 - t), -area / (w * w)),
        _ => (0.0, 0.0),
    };
    let both = move |x| if x < 0.5 { ridge(x, first) } else { ridge(x, second) };
    let knots = [first.0 - w, first.0, first.0 + w, second.0 - w, second.0];
    let ridges = function(both, knots);
    let activity = |theta: f64| {
        let fading = ((0.5 * theta * w).sin() / (0.5 * theta * w)).powi(2);
        -fading * (first.1 * (theta * first.0).sin() + second.1 * (theta * second.0).sin()) / theta
    };
    let best = |from: f64, to: f64| {
        (0..=100_000)
            .map(|number| from + (to - from) * f64::from(number) / 1e5)
            .map(|theta| (activity(theta), theta))
            .fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a })
    };
    let (lower, upper) = (best(1.0, 8.0), best(8.0, 400.0));
    assert!(lower.0 > 0.03 && upper.0 > 1.5 * lower.0, "{lower:?} {upper:?}");
    let patch = patch(tyre(), ridges);
    let least = patch.least_passive_damping(160.0).unwrap();
    // The scan's step is 4e-3 rad, of a maximum with a curvature of less than 0.1.
    assert!((least * 160.0 / (252.0 * LENGTH) - upper.0).abs() < 1e-6, "{least:?} {upper:?}");
}

#[test]
fn the_weights_of_the_slip_velocity_are_derivatives_along_the_steady_profile() {
    let model = lugre(0.05);
    let patch = patch(model, exponential(2.0));
    for v in [0.6, -4.0] {
        let linearised = patch.linearised(motion(v, 160.0)).unwrap();
        let steady = patch.steady(motion(v, 160.0)).unwrap();
        for place in [0.0, 0.3, 1.0] {
            let z = steady.deflection(place);
            let slope = |f: &dyn Fn(f64) -> f64| (f(v + 1e-5) - f(v - 1e-5)) / 2e-5;
            // H₁ and H₂; the differences miss third derivatives times 1e-10.
            let (drive, direct) = (linearised.drive(place), linearised.direct(place));
            let want = slope(&|v| model.rate(v, z));
            assert_within(1e-7, 1.0, drive, want, || format!("H₁({place}) at {v}"));
            let want = slope(&|v| model.coefficient(v, z));
            assert_within(1e-7, want.abs(), direct, want, || format!("H₂({place}) at {v}"));
        }
    }
}
