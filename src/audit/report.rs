//! The audit as a table.

use core::fmt::{self, Write};

use super::{Audit, LawStatus, slowest_on_spring};
use crate::Scalar;
use crate::linear::Threshold;
use crate::number::{Text, number};
use crate::stability::{Scheme, StepLimits};

/// Widths of the first two columns.
const NAME: usize = 19;
const FINDING: usize = 66;

/// Text of one cell; the longest finding has 80 bytes.
type Cell = Text<192>;

/// Writes one row: name, finding, reference.
fn row(f: &mut fmt::Formatter<'_>, name: &str, text: fmt::Arguments<'_>, by: &str) -> fmt::Result {
    let mut finding = Cell::new();
    finding.write_fmt(text)?;
    writeln!(f, "{name:<NAME$} {:<FINDING$} {by}", finding.as_str())
}

/// Writes one row from a format string.
macro_rules! row {
    ($f:expr, $name:expr, by $by:expr, $($text:tt)*) => {
        row($f, $name, format_args!($($text)*), $by)
    };
}

impl<T: Scalar> fmt::Display for Audit<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.characteristics.map_or("a friction model", |model| model.name);
        let (load, fastest) = (number(self.normal_force), number(self.parameters.fastest));
        writeln!(f, "audit of {name} under {load:.5} N, |v| ≤ {fastest:.5} m/s")?;
        self.write_passivity(f)?;
        self.write_bounds(f)?;
        self.write_curve(f)?;
        self.write_yielding(f)?;
        self.write_mechanism(f)?;
        self.write_steps(f)
    }
}

impl<T: Scalar> Audit<T> {
    fn write_passivity(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let passivity = &self.passivity;
        let ratio = number(passivity.excess);
        let (name, ortega) = ("passivity", "Barabanov, Ortega 2000");
        let search = "Romano et al., III-B; by search";
        match (passivity.verdict, passivity.needed_viscous_friction) {
            (LawStatus::Unrefuted, _) => row!(f, name, by search,
                "no case against it: (c₀ − K r)²/(4 K λ c₂) ≤ {ratio:.5}"),
            (verdict, Some(needed)) => {
                let verdict = if verdict == LawStatus::Holds { "holds" } else { "FAILS" };
                let has = self.characteristics.map_or(T::zero(), |model| model.viscous_friction);
                let (needed, has) = (number(needed), number(has));
                row!(f, name, by ortega, "{verdict}: needs σ2 ≥ {needed:.5} s/m, has {has:.5}")
            }
            (LawStatus::Fails, None) => row!(f, name, by search,
                "FAILS: (c₀ − K r)²/(4 K λ c₂) up to {ratio:.5}, not ≤ 1"),
            (LawStatus::Holds, None) if passivity.excess == T::zero() => {
                row!(f, name, by "Romano et al., Lemma III.2",
                    "holds: F v − Ẇ is a sum of squares in every state")
            }
            (LawStatus::Holds, None) => {
                row!(f, name, by ortega, "holds: (c₀ − K r)²/(4 K λ c₂) ≤ {ratio:.5}")
            }
        }?;
        let Some(witness) = passivity.witness else { return Ok(()) };
        let (v, z) = (number(witness.velocity), number(witness.deflection));
        let power = number(witness.dissipated_power);
        row!(f, "  worst case", by "by search",
            "F v − Ẇ = {power:.5} W at v = {v:.5} m/s, z = {z:.5} m")
    }

    fn write_bounds(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let limits = &self.limits;
        for (name, symbol, limit, unit, by) in [
            ("deflection", "|z|", limits.deflection, "m", "Romano et al., Lemma III.1"),
            ("force", "|F|", limits.force, "N", "z within its bound"),
            ("relaxation rate", "λ", limits.relaxation_rate, "1/s", "Romano et al., III-B"),
        ] {
            match limit.map(number) {
                Some(limit) => row!(f, name, by by, "{symbol} ≤ {limit:.5} {unit}"),
                None => row!(f, name, by by, "no bound"),
            }?;
        }
        Ok(())
    }

    fn write_curve(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(model) = self.characteristics else { return Ok(()) };
        if let Some(margin) = self.inversion_margin {
            let least = number(model.least_slope + model.viscous_friction);
            let damping = number(model.micro_damping.min);
            let verdict = if margin >= T::zero() { "one solution" } else { "FOLDS" };
            row!(f, "inversion", by "Romano et al., II-B; by search",
                "{verdict}: σ1 = {damping:.5}, least dμ/d|v| = {least:.5} s/m")?;
        }
        let (name, by, slope) = ("curve at rest", "Romano et al., II-B", model.slope_at_rest);
        if slope == T::zero() {
            row!(f, name, by by, "differentiable")
        } else if slope.is_finite() {
            let slope = number(slope);
            row!(f, name, by by, "kink, dμ/d|v| = {slope:.5} s/m: split steps at reversals")
        } else {
            row!(f, name, by by, "infinitely steep: no method keeps its order there")
        }?;
        let speed = number(model.speed_at_rest);
        if model.speed_at_rest == T::zero() {
            row!(f, "modulus |v|", by by, "exact, with its kink")
        } else {
            row!(f, "modulus |v|", by by, "smooth, |0|_ε = {speed:.5} m/s")
        }
    }

    fn write_yielding(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(yielding) = self.yielding else { return Ok(()) };
        let force = number(yielding.breakaway);
        row!(f, "breakaway", by "Romano et al., II-B", "F_b = p μ_s = {force:.5} N")?;
        let (from, to) = (number(yielding.cycle.from), number(yielding.cycle.to));
        let creeps = self.characteristics.is_some_and(|model| model.creeps);
        let (name, by) = ("drift", "Dupont et al. 2002");
        match yielding.drift {
            Some(drift) if drift == T::zero() => {
                row!(f, name, by by, "none in slow cycles {from:.5} ↔ {to:.5} N")
            }
            Some(drift) => {
                let drift = number(drift);
                row!(f, name, by by, "{drift:.5} m per slow cycle {from:.5} ↔ {to:.5} N")
            }
            None if creeps => {
                row!(f, name, by "its dashpot", "no end: the bristle creeps under any force")
            }
            None => row!(f, name, by by, "not known for {from:.5} ↔ {to:.5} N"),
        }?;
        let force = number(yielding.cycle.peak());
        let rate = number(yielding.relaxation_at_rest);
        let (name, by) = ("creep", "F_ss(v) = F");
        match yielding.creep {
            Some(creep) if creep == T::zero() => row!(f, name, by by, "none under {force:.5} N"),
            Some(creep) => {
                let creep = number(creep);
                row!(f, name, by by,
                    "{creep:.5} m/s under {force:.5} N; bristles relax at {rate:.5} 1/s")
            }
            None => row!(f, name, by by, "not known under {force:.5} N"),
        }
    }

    fn write_mechanism(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(stuck) = self.stuck {
            let (rate, ratio) = (number(stuck.frequency), number(stuck.damping_ratio));
            let later = number(stuck.reversed_damping_ratio);
            row!(f, "stuck mass", by "module stability",
                "ω = {rate:.5} rad/s, ζ = {ratio:.5}; after a reversal ζ = {later:.5}")?;
        }
        let Some(threshold) = self.steady_sliding else { return Ok(()) };
        let fastest = self.parameters.fastest;
        let (slowest, fastest) = (number(slowest_on_spring(fastest)), number(fastest));
        let mut by = Cell::new();
        write!(by, "Routh–Hurwitz, {slowest:.5} … {fastest:.5} m/s")?;
        let (name, by) = ("sliding on spring", by.as_str());
        match threshold {
            _ if self.normal_force == T::zero() => row!(f, name, by by, "no friction, no load"),
            Threshold::AlwaysStable => {
                row!(f, name, by by, "small motions die out at every speed")
            }
            Threshold::NeverStable => {
                row!(f, name, by by, "small motions die out at no speed: stick-slip")
            }
            Threshold::Marginal => {
                row!(f, name, by by, "small motions neither grow nor die out at any speed")
            }
            Threshold::StableAbove(speed) => {
                let speed = number(speed);
                row!(f, name, by by, "small motions die out above {speed:.5} m/s, GROW just below")
            }
            Threshold::StableBelow(speed) => {
                let speed = number(speed);
                row!(f, name, by by, "small motions GROW above {speed:.5} m/s, die out just below")
            }
        }
    }

    fn write_steps(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut head = Cell::new();
        write!(head, "{:<12}", "bristle")?;
        if self.stuck.is_some() {
            write!(head, "{:<12}{:<14}", "stuck", "reversed")?;
        }
        if let Some(time) = self.parameters.sample_time.map(number) {
            write!(head, "at {time:.5} s")?;
        }
        row!(f, "largest step [s]", by "module stability", "{}", head.as_str())?;
        for (scheme, limits) in Scheme::ALL.into_iter().zip(self.steps) {
            let mut cells = Cell::new();
            self.write_limits(&mut cells, scheme, limits)?;
            let mut name = Cell::new();
            write!(name, "  {scheme}")?;
            writeln!(f, "{:<NAME$} {}", name.as_str(), cells.as_str().trim_end())?;
        }
        Ok(())
    }

    /// The limits of one scheme, and whether the sample time is within them.
    fn write_limits(
        &self,
        cells: &mut Cell,
        scheme: Scheme,
        limits: Option<StepLimits<T>>,
    ) -> fmt::Result {
        let Some(limits) = limits else {
            return cells.write_str(if scheme == Scheme::Passive {
                "no promise: the contact is not passive at every deflection"
            } else {
                "none is known: the relaxation rate has no bound"
            });
        };
        let columns =
            [(limits.bristle, 12), (limits.stuck_from_rest, 12), (limits.stuck_reversed, 14)];
        for (limit, width) in columns.into_iter().take(if self.stuck.is_some() { 3 } else { 1 }) {
            match limit {
                None => write!(cells, "{:<width$}", "any")?,
                Some(limit) if limit == T::zero() => write!(cells, "{:<width$}", "none")?,
                Some(limit) => write!(cells, "{:<width$.5}", number(limit))?,
            }
        }
        let within = self.parameters.sample_time.map(|step| limits.check(step).is_ok());
        cells.write_str(within.map_or("", |within| if within { "ok" } else { "TOO LONG" }))
    }
}
