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
    curve: model.parts().curve().clone(),
    axes: *model.parts().bristles(),
    regularisation: model.parts().regularisation().clone(),
    viscous_friction: Some(model.viscous_friction()),
});
serialised_as!([M: PlaneBristle<T, N>, A: Signal<T>, F: Signal<T>; const N]
    PlaneBody<T, M, N, A, F> as PlaneBodyParameters<T, M, N, A, F>:
    Self::new, |body| body.parameters().clone());

/// What a model of a curve C, a regularisation E and a scalar T is in a file.
macro_rules! model_file {
    ($(#[$about:meta])* $name:literal $file:ident[$($generic:tt)*] { $($fields:tt)* }) => {
        $(#[$about])*
        #[derive(Serialize, Deserialize)]
        #[serde(
            deny_unknown_fields,
            rename = $name,
            bound(
                deserialize = "C: Deserialize<'de>, E: Default + Deserialize<'de>, \
                               T: Scalar + Deserialize<'de>",
                serialize = "C: Serialize, E: Serialize, T: Scalar + Serialize"
            )
        )]
        struct $file<$($generic)*> { $($fields)* }
    };
}

model_file! {
    /// A model on several axes in a file.
    "PlaneFrBd" PlaneFile[C, E, T, const N: usize] {
        curve: C,
        #[serde(with = "array")]
        axes: [Axis<T>; N],
        #[serde(default)]
        regularisation: E,
    }
}

model_file! {
    /// A LuGre model on several axes in a file: g and the viscous friction outside it, as a
    /// LuGre model on a line.
    "PlaneLuGre" PlaneLuGreFile[C, E, T, const N: usize] {
        curve: C,
        #[serde(with = "array")]
        axes: [Axis<T>; N],
        #[serde(default)]
        regularisation: E,
        #[serde(default = "Option::default")]
        viscous_friction: Option<T>,
    }
}
