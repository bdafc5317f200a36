//! The peers: other crates, each set up as its documentation advises.
//!
//! Common to all: relative tolerance r, absolute tolerance r × scale of each state (or scaled
//! states, where a crate has a single absolute tolerance), the analytic Jacobian, samples from the
//! crate's own dense output, no limit on steps but the watchdog's, and a fresh start at a kink of
//! the input. Each file tells what it had to work around. Methods named `+ root` are told of
//! reversals: the crate's own root function finds them, and it starts again there.

mod differential_equations;
mod diffsol;
mod ivp;
mod ode_solvers;
mod run;

use bristle::ode::System;

pub(crate) use run::{Failure, Peer, Run};
use run::{Part, Piece, drive, told};

/// Every method of every peer.
pub(crate) fn all<S: System<f64, N>, const N: usize>() -> Vec<Peer<S, N>> {
    let mut peers = Vec::new();
    peers.extend(ode_solvers::methods());
    peers.extend(differential_equations::methods());
    peers.extend(ivp::methods());
    peers.extend(diffsol::methods());
    peers
}
