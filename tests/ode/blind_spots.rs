//! Where an error estimate sees nothing: derivatives that are wrong, contacts that reverse
//! together. A success is one there, too. More of it is drawn in `drawn`.
#![cfg(feature = "alloc")]

use bristle::Branch;
use bristle::ode::{self, AnyMethod, Output, Solver, StopReason, System, Tolerances};
use bristle_specimens::draw::Draw;
use nalgebra::{Matrix1, Vector1, Vector3};

pub(crate) const METHODS: [AnyMethod; 5] = [
    AnyMethod::Automatic,
    AnyMethod::DormandPrince,
    AnyMethod::DormandPrince8,
    AnyMethod::Rodas4,
    AnyMethod::Rodas5P,
];

/// ẋ = 1 − x, with derivatives that are a factor off.
struct Relaxing(f64);

impl System<f64, 1, 0> for Relaxing {
    fn rate(&self, _: f64, x: &Vector1<f64>, _: [Branch; 0]) -> Vector1<f64> {
        Vector1::new(1.0 - x[0])
    }
    fn sliding_velocities(&self, _: f64, _: &Vector1<f64>) -> [f64; 0] {
        []
    }
    fn linearised(
        &self,
        time: f64,
        x: &Vector1<f64>,
        branches: [Branch; 0],
    ) -> Option<ode::Linearisation<f64, 1>> {
        let rate = self.rate(time, x, branches);
        let (by_state, by_time) = (Matrix1::new(-self.0), Vector1::zeros());
        Some(ode::Linearisation { rate, by_state, by_time })
    }
}

#[test]
fn wrong_derivatives_are_refused_by_name() {
    let solve = |factor: f64| {
        let relaxing = Relaxing(factor);
        ode::solve(&relaxing, 0.0..20.0, Vector1::new(0.0), 1e-6, Output::Uniform(2))
    };
    for factor in [1e5, 0.0, -1.0, 3.0] {
        let failure = solve(factor).unwrap_err();
        assert_eq!(failure.reason, StopReason::WrongDerivative { component: 0 });
        assert!(failure.to_string().contains("see linearised"), "{failure}");
    }
    assert!((solve(1.0).unwrap().states()[1][0] - 1.0).abs() < 1e-6);
}

/// Three masses without a coupling, braked by equal forces: their velocities pass zero together.
struct Together;

impl System<f64, 3, 3> for Together {
    fn rate(&self, time: f64, _: &Vector3<f64>, _: [Branch; 3]) -> Vector3<f64> {
        Vector3::repeat(time.cos())
    }
    fn sliding_velocities(&self, _: f64, x: &Vector3<f64>) -> [f64; 3] {
        [x[0], x[1], x[2]]
    }
}

#[test]
fn contacts_that_reverse_together_are_all_counted() {
    // v = sin t passes zero at π, 2π … 10π.
    for method in METHODS {
        let solver =
            Solver::checked(method, Tolerances::scaled(1e-6, Vector3::repeat(1.0)).unwrap());
        let run = solver.solve(&Together, 0.0..32.0, Vector3::zeros(), Output::Uniform(2)).unwrap();
        assert_eq!(run.reversals().len(), 30, "{method:?}");
        assert_eq!(run.statistics().reversals, 30, "{method:?}");
        for (number, reversal) in run.reversals().iter().enumerate() {
            let passes = std::f64::consts::PI * (number / 3 + 1) as f64;
            assert!((reversal.time - passes).abs() < 1e-4, "{method:?}: {}", reversal.time);
        }
    }
}

/// A body at rest that is pushed once: v̇ = J e^(−τ²)/(w √π), τ = (t − t₀)/w, gains J.
struct Pushed {
    impulse: f64,
    time: f64,
    width: f64,
}

impl System<f64, 1, 0> for Pushed {
    fn rate(&self, time: f64, _: &Vector1<f64>, _: [Branch; 0]) -> Vector1<f64> {
        let tau = (time - self.time) / self.width;
        let push = self.impulse * (-tau * tau).exp();
        Vector1::new(push / (self.width * std::f64::consts::PI.sqrt()))
    }
    fn sliding_velocities(&self, _: f64, _: &Vector1<f64>) -> [f64; 0] {
        []
    }
}

#[test]
fn a_push_on_a_body_at_rest_is_seen() {
    let mut draw = Draw::seeded(20_261_130);
    for number in 0..100 {
        let impulse = draw.logarithmic(0.1, 10.0);
        // It is felt for three widths and more, which are more than a thousandth of the span.
        let width = draw.logarithmic(0.0005, 0.05);
        let pushed = Pushed { impulse, time: 0.3 + 0.4 * draw.next(), width };
        for method in METHODS {
            for tolerance in [1e-3, 1e-6, 1e-9] {
                let scaled = Tolerances::scaled(tolerance, Vector1::new(1.0)).unwrap();
                let solver = Solver::checked(method, scaled);
                let run = solver.solve(&pushed, 0.0..1.0, Vector1::zeros(), Output::Uniform(2));
                let gained = run.unwrap().states()[1][0];
                let off = (gained - impulse).abs() / tolerance;
                assert!(off < 100.0, "{number}, {method:?} at {tolerance:e}: {off} tolerances");
            }
        }
    }
}
