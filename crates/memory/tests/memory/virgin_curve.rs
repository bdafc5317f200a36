//! Elements from a virgin curve: exactly, and by least squares.

use bristle::nalgebra::{DMatrix, DVector};
use bristle_memory::virgin::{self, VirginPoint};
use bristle_memory::{Element, MaxwellSlip, MaxwellSlipParameters};
use bristle_specimens::draw::Draw;

use super::{coulomb, zeros};

fn points<const N: usize>(points: [(f64, f64); N]) -> [VirginPoint<f64>; N] {
    points.map(|(deflection, coefficient)| VirginPoint { deflection, coefficient })
}

#[test]
fn a_piecewise_linear_curve_is_met_at_its_points_and_between_them() {
    // Slopes 5e4, 3e4, 1e4 1/m.
    let measured = points([(2e-6, 0.10), (6e-6, 0.22), (14e-6, 0.30)]);
    let elements = virgin::bends(&measured).unwrap();
    for (element, (stiffness, length)) in
        elements.iter().zip([(2e4, 2e-6), (2e4, 6e-6), (1e4, 14e-6)])
    {
        assert!((element.stiffness - stiffness).abs() < 1e-9);
        assert_eq!(element.yield_length, length);
    }
    for (x, want) in [(1e-6, 0.05), (4e-6, 0.16), (6e-6, 0.22), (10e-6, 0.26), (1.0, 0.30)] {
        assert!((virgin::coefficient(&elements, x) - want).abs() < 1e-15, "{x}");
    }
    // The model runs along it, on a curve of its own height.
    let model = MaxwellSlip::new(MaxwellSlipParameters {
        curve: coulomb(),
        elements,
        micro_damping: 0.0,
        stick_ratio: 0.9,
    });
    let first = model.unwrap().sharp_step(0.0, 4e-6 / 0.3, zeros());
    assert!((first.coefficient - 0.16 / 0.3).abs() < 1e-14);
}

#[test]
fn points_on_a_line_make_an_element_without_stiffness() {
    // The second slope is larger, by a rounding.
    let measured = points([(1.1e-6, 0.051), (2.9e-6, 0.051 / 1.1e-6 * 2.9e-6), (5e-6, 0.15)]);
    let elements = virgin::bends(&measured).unwrap();
    assert_eq!(elements[0].stiffness, 0.0);
    assert!((virgin::coefficient(&elements, 2.9e-6) - measured[1].coefficient).abs() < 1e-15);
}

#[test]
fn the_fit_meets_a_piecewise_linear_curve_with_bends_at_its_yield_lengths() {
    let lengths: [f64; 12] = core::array::from_fn(|i| 1e-6 * (i + 1) as f64);
    // Every second element has no stiffness.
    let made = lengths.map(|yield_length| {
        let even = ((yield_length * 1e6).round() as usize).is_multiple_of(2);
        Element { stiffness: if even { 1e4 } else { 0.0 }, yield_length }
    });
    let measured: Vec<_> = (1..=60)
        .map(|i| 0.22e-6 * f64::from(i))
        .map(|x| VirginPoint { deflection: x, coefficient: virgin::coefficient(&made, x) })
        .collect();
    let fitted = virgin::fit(&measured, lengths).unwrap();
    for (got, want) in fitted.iter().zip(made) {
        // Normal equations of twelve yield lengths: half of the digits of their square.
        assert!((got.stiffness - want.stiffness).abs() < 1e-6 * 1e4, "{got:?}");
        assert!(got.stiffness >= 0.0);
    }
}

/// The least sum of squares over all choices of elements that are left out, by QR decomposition.
fn enumerated<const N: usize>(points: &[VirginPoint<f64>], lengths: [f64; N]) -> f64 {
    let force = DVector::from_iterator(points.len(), points.iter().map(|it| it.coefficient));
    let mut least = force.norm_squared();
    for choice in 1_usize..1 << N {
        let chosen: Vec<usize> = (0..N).filter(|i| choice >> i & 1 == 1).collect();
        let matrix = DMatrix::from_fn(points.len(), chosen.len(), |k, i| {
            points[k].deflection.min(lengths[chosen[i]])
        });
        let decomposed = matrix.clone().qr();
        let Some(x) = decomposed.r().solve_upper_triangular(&(decomposed.q().transpose() * &force))
        else {
            continue;
        };
        if x.iter().all(|&x| x >= 0.0) {
            least = least.min((&matrix * x - &force).norm_squared());
        }
    }
    least
}

#[test]
fn the_fit_is_the_least_of_all_choices() {
    let mut draw = Draw::seeded(6);
    let mut held = 0;
    for _ in 0..300 {
        let mut length = 0.0;
        let lengths: [f64; 6] = core::array::from_fn(|_| {
            length += 1e-6 * (0.3 + draw.next());
            length
        });
        // From smooth to mostly noise.
        let noise = draw.one_of(&[0.0, 0.01, 0.1, 0.5]);
        let measured: Vec<_> = (0..14)
            .map(|_| {
                let deflection = 1.2 * length * (0.02 + draw.next());
                let coefficient =
                    (1.0 - (-deflection / 2e-6).exp() + noise * draw.gauss()).max(0.0);
                VirginPoint { deflection, coefficient }
            })
            .collect();
        let fitted = virgin::fit(&measured, lengths).unwrap();
        held += fitted.iter().filter(|element| element.stiffness == 0.0).count();
        let got: f64 = measured
            .iter()
            .map(|it| (virgin::coefficient(&fitted, it.deflection) - it.coefficient).powi(2))
            .sum();
        let want = enumerated(&measured, lengths);
        // The minimum is flat: half of the digits of the unknowns are all of its own.
        assert!((got - want).abs() <= 1e-12 + 1e-9 * want, "{got} is not {want}");
    }
    assert!(held > 300, "the bound is met in {held} cases only");
}

#[test]
fn of_yield_lengths_that_no_point_tells_apart_one_has_the_stiffness() {
    let mut draw = Draw::seeded(2);
    for _ in 0..100 {
        let deflections = (0..20).map(|_| 7e-6 * (0.01 + draw.next()));
        let measured: Vec<_> = deflections
            .map(|x| VirginPoint { deflection: x, coefficient: 1e4 * (x.min(2e-6) + 0.7 * x) })
            .collect();
        // The last four are beyond all points.
        let fitted = virgin::fit(&measured, [1e-6, 2e-6, 8e-6, 9e-6, 1e-5, 2e-5]).unwrap();
        let beyond = fitted[2..].iter().map(|it| it.stiffness).filter(|&it| it != 0.0);
        let beyond: Vec<_> = beyond.collect();
        // Normal equations: half of the digits.
        assert!(beyond.len() == 1 && (beyond[0] - 7e3).abs() < 1e-2, "{beyond:?}");
    }
}

#[test]
fn unusable_points_are_refused_by_name() {
    let sound = points([(1e-6, 0.1), (2e-6, 0.15), (3e-6, 0.18)]);
    for (i, (deflection, coefficient), name) in [
        (0, (0.0, 0.1), "points.deflection"),
        (1, (1e-6, 0.15), "points.deflection"),
        (2, (f64::NAN, 0.2), "points.deflection"),
        (1, (2e-6, -0.1), "points.coefficient"),
        (2, (3e-6, f64::INFINITY), "points.coefficient"),
    ] {
        let mut bad = sound;
        bad[i] = VirginPoint { deflection, coefficient };
        let error = virgin::bends(&bad).unwrap_err();
        assert_eq!((error.name, error.component), (name, Some(i)));
    }
    // It stiffens at the first point; it falls after the second.
    for (bad, i) in [([(1e-6, 0.1), (2e-6, 0.3)], 0), ([(1e-6, 0.1), (2e-6, 0.05)], 1)] {
        let error = virgin::bends(&points(bad)).unwrap_err();
        assert_eq!((error.name, error.component), ("slope of the points up to it", Some(i)));
    }
    let refused = |points: &[_], lengths: [f64; 2]| virgin::fit(points, lengths).unwrap_err().name;
    assert_eq!(refused(&[], [1e-6, 2e-6]), "points");
    assert_eq!(refused(&sound, [2e-6, 2e-6]), "yield_lengths");
    assert_eq!(refused(&sound, [f64::NAN, 2e-6]), "yield_lengths");
    assert_eq!(refused(&points([(-1e-6, 0.1)]), [1e-6, 2e-6]), "points.deflection");
    assert_eq!(virgin::fit(&sound, []).unwrap_err().name, "yield_lengths");
}
