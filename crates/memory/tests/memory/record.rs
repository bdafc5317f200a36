//! Elements from a record: exactly, by weights, with the zero of the force.

use bristle_memory::record::{self, RecordPoint};
use bristle_memory::{Element, MaxwellSlip, MaxwellSlipParameters};

use super::{coulomb, zeros};

const LENGTHS: [f64; 4] = [1e-6, 3e-6, 8e-6, 2e-5];
/// Σ σᵢ ℓᵢ = 1, as the curve.
const STIFFNESS: [f64; 4] = [2e5, 0.0, 6e4, 1.6e4];
const OFFSET: f64 = 0.07;

/// Rows along a motion through given places [µm], the force by `sharp_step`.
fn made(places: &[i32]) -> Vec<RecordPoint<f64>> {
    let elements: [_; 4] =
        core::array::from_fn(|i| Element { stiffness: STIFFNESS[i], yield_length: LENGTHS[i] });
    let (curve, micro_damping) = (coulomb(), 0.0);
    let parameters = MaxwellSlipParameters { curve, elements, micro_damping, stick_ratio: 0.9 };
    let model = MaxwellSlip::new(parameters).unwrap();
    let (mut x, mut record) = (zeros(), Vec::new());
    for leg in places.windows(2) {
        let step = 1e-7 * f64::from((leg[1] - leg[0]).signum());
        for n in 1..=10 * (leg[1] - leg[0]).abs() {
            // The first row is where it begins.
            let moved = model.sharp_step(0.0, if record.is_empty() { 0.0 } else { step }, x);
            x = moved.deflection;
            let displacement = 5e-6 + 1e-6 * f64::from(leg[0]) + step * f64::from(n);
            let coefficient = moved.coefficient + OFFSET;
            record.push(RecordPoint { displacement, coefficient, weight: 1.0 });
        }
    }
    record
}

#[test]
fn the_fit_returns_elements_and_zero_of_the_force_of_a_record() {
    let record = made(&[0, 30, -30, 25, -10, 30]);
    // Of the rows without weight only the motion counts, whatever their force.
    let weigh = |(i, mut point): (usize, RecordPoint<f64>)| {
        (point.weight, point.coefficient) =
            if i < 300 { (0.0, 9.0) } else { (2.0, point.coefficient) };
        point
    };
    let weighed: Vec<_> = record.iter().copied().enumerate().map(weigh).collect();
    for record in [record, weighed] {
        let fitted = record::fit(&record, LENGTHS).unwrap();
        assert!((fitted.offset - OFFSET).abs() < 1e-9, "{}", fitted.offset);
        for (element, want) in fitted.elements.iter().zip(STIFFNESS) {
            // Normal equations: half of the digits.
            assert!((element.stiffness - want).abs() < 1e-6 * 2e5, "{element:?} is not {want}");
        }
    }
}

#[test]
fn unusable_records_are_refused_by_name() {
    let sound = made(&[0, 4]);
    let refused = |change: &dyn Fn(&mut RecordPoint<f64>)| {
        let mut record = sound.clone();
        change(&mut record[7]);
        let error = record::fit(&record, LENGTHS).unwrap_err();
        (error.name, error.component)
    };
    assert_eq!(refused(&|it| it.displacement = f64::NAN), ("record.displacement", Some(7)));
    assert_eq!(refused(&|it| it.coefficient = f64::INFINITY), ("record.coefficient", Some(7)));
    assert_eq!(refused(&|it| it.weight = -1.0), ("record.weight", Some(7)));
    let refused = |record: &[_], lengths: [f64; 2]| record::fit(record, lengths).unwrap_err().name;
    assert_eq!(refused(&[], [1e-6, 2e-6]), "sum of record.weight");
    assert_eq!(refused(&sound, [2e-6, 2e-6]), "yield_lengths");
    // Without motion there is nothing to choose: the force is all offset.
    let still = record::fit(&[sound[9]; 5], LENGTHS).unwrap();
    assert_eq!((still.elements[0].stiffness, still.offset), (0.0, sound[9].coefficient));
}
