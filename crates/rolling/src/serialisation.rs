//! Pressures in files.

use alloc::vec::Vec;

use bristle::serialised_as;
use bristle::signal::{Polyline, Vertex};

use crate::{FunctionPressure, PolynomialExponential, PolynomialExponentialParameters};

serialised_as!([; const N] PolynomialExponential<T, N> as PolynomialExponentialParameters<T, N>:
    Self::new, Self::parameters);
serialised_as!([] FunctionPressure<T, Polyline<Vec<Vertex<T>>>> as Polyline<Vec<Vertex<T>>>:
    Self::new, |pressure| pressure.function().clone());
