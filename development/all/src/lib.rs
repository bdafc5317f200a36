//! Nothing: the tests, benches and pages that use several crates need a package of their own.

/// The programs of the pages compile and run.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
#[doc = include_str!("../../../docs/choosing.md")]
#[doc = include_str!("../../../docs/control-loop.md")]
#[doc = include_str!("../../../docs/embedded.md")]
#[doc = include_str!("../../../docs/experiments.md")]
#[doc = include_str!("../../../docs/gallery.md")]
#[doc = include_str!("../../../docs/paper.md")]
#[doc = include_str!("../../../docs/work-precision.md")]
struct Pages;
