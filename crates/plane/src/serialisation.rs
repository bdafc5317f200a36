//! Models, contacts and bodies of several axes in files.

use bristle::curve::FrictionCurve;
use bristle::regularisation::Regularisation;
use bristle::serialisation::array;
use bristle::signal::Signal;
use bristle::{Scalar, serialised_as};
use serde::{Deserialize, Serialize};

use crate::{Axis, PlaneBody, PlaneBodyParameters, PlaneBristle, PlaneFrBd, PlaneLuGre};

serialised_as!([C: FrictionCurve<T>, E: Regularisation<T> | Default; const N]
PlaneFrBd<C, T, N, E> as PlaneFile<C, E, T, N>:
|file: PlaneFile<C, E, T, N>| {
    Ok(PlaneFrBd::new(file.curve, file.axes)?.regularised(file.regularisation))
},
|model| PlaneFile {
    curve: model.curve().clone(),
    axes: *model.bristles(),
    regularisation: model.regularisation().clone(),
});
serialised_as!([C: FrictionCurve<T>, E: Regularisation<T> | Default; const N]
PlaneLuGre<C, T, N, E> as PlaneLuGreFile<C, E, T, N>:
|file: PlaneLuGreFile<C, E, T, N>| {
    let PlaneLuGreFile { curve, axes, regularisation, viscous_friction } = file;
    let model = match viscous_friction {
        Some(outside) => PlaneLuGre::with_viscous_friction(curve, axes, outside)?,
        None => PlaneLuGre::classical(curve, axes)?,
    };
    Ok(model.regularised(regularisation))
},
|model| PlaneLuGreFile {
    curve: model.frbd.curve().clone(),
    axes: *model.frbd.bristles(),
    regularisation: model.frbd.regularisation().clone(),
    viscous_friction: Some(model.viscous_friction()),
});
serialised_as!([M: PlaneBristle<T, N>, A: Signal<T>, F: Signal<T>; const N]
    PlaneBody<T, M, N, A, F> as PlaneBodyParameters<T, M, N, A, F>:
    Self::new, |body| body.parameters().clone());

/// A model on several axes in a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "PlaneFrBd")]
struct PlaneFile<C, E, T: Scalar, const N: usize> {
    curve: C,
    #[serde(
        with = "array",
        bound(deserialize = "T: Deserialize<'de>", serialize = "T: Serialize")
    )]
    axes: [Axis<T>; N],
    #[serde(default)]
    regularisation: E,
}

/// A LuGre model on several axes in a file: g and the viscous friction outside it, as a
/// LuGre model on a line.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "PlaneLuGre")]
struct PlaneLuGreFile<C, E, T: Scalar, const N: usize> {
    curve: C,
    #[serde(with = "array")]
    axes: [Axis<T>; N],
    #[serde(default)]
    regularisation: E,
    #[serde(default = "Option::default")]
    viscous_friction: Option<T>,
}
