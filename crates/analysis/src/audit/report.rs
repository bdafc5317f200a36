//! The audit as a table.

use core::fmt::{self, Write};

use bristle::number::{Number, Text};
use bristle::scalar::is_zero;
use bristle::{Characteristics, Scalar};

use super::{Audit, LawStatus, Passivity, peak, slowest_on_spring};
use crate::linear::Threshold;
use crate::step_limits::Scheme;

/// Widths of the first two columns.
const NAME: usize = 19;
const FINDING: usize = 66;

/// Titles and widths of the largest steps; without a mechanism the first one only.
const STEPS: [(&str, usize); 3] = [("bristle", 12), ("stuck", 12), ("reversed", 14)];

/// Text of one cell; the longest finding has 80 bytes.
type Cell = Text<192>;

/// Writes one row: name, finding, reference.
fn row(f: &mut fmt::Formatter<'_>, name: &str, text: fmt::Arguments<'_>, by: &str) -> fmt::Result {
    let mut finding = Cell::default();
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
        let (load, fastest) = (Number::of(self.normal_force), Number::of(self.parameters.fastest));
        let [newton, speed] = self.units(["N", "m/s"]);
        writeln!(f, "audit of {name} under {load:.5} {newton}, |v| ≤ {fastest:.5} {speed}")?;
        self.write_passivity(f)?;
        self.write_bounds(f)?;
        if let Some(model) = self.characteristics {
            self.write_curve(f, &model)?;
            self.write_yielding(f, &model)?;
        }
        self.write_mechanism(f)?;
        self.write_steps(f)
    }
}

impl<T: Scalar> Audit<T> {
    /// Units and words of translation, or what takes their place.
    fn units<const N: usize>(&self, translation: [&'static str; N]) -> [&'static str; N] {
        translation.map(|unit| self.parameters.units.of(unit))
    }

    fn write_passivity(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Passivity { verdict, excess, least_power, velocity, deflection } = self.passivity;
        let ratio = Number::of(excess);
        let [damping, speed, metre] = self.units(["s/m", "m/s", "m"]);
        let (name, ortega) = ("passivity", "Barabanov, Ortega 2000");
        let search = "Romano et al., III-B; by search";
        let model = self.characteristics;
        let needed = model.and_then(|it| Some((it.needed_viscous_friction?, it.viscous_friction)));
        match (verdict, needed) {
            (LawStatus::Unrefuted, _) => row!(f, name, by search,
                "no case against it: (c₀ − K r)²/(4 K λ c₂) ≤ {ratio:.5}"),
            (_, Some((needed, has))) => row!(f, name, by ortega,
                "{}: needs σ2 ≥ {:.5} {damping}, has {:.5}",
                if verdict == LawStatus::Holds { "holds" } else { "FAILS" },
                Number::of(needed), Number::of(has)),
            (LawStatus::Fails, None) => row!(f, name, by search,
                "FAILS: (c₀ − K r)²/(4 K λ c₂) up to {ratio:.5}, not ≤ 1"),
            (LawStatus::Holds, None) if is_zero(excess) => row!(f, name,
                by "Romano et al., Lemma III.2",
                "holds: F v − Ẇ is a sum of squares in every state"),
            (LawStatus::Holds, None) => row!(f, name, by ortega,
                "holds: (c₀ − K r)²/(4 K λ c₂) ≤ {ratio:.5}"),
        }?;
        if is_zero(least_power) {
            return Ok(());
        }
        let (power, v, z) = (Number::of(least_power), Number::of(velocity), Number::of(deflection));
        row!(f, "  worst case", by "by search",
            "F v − Ẇ = {power:.5} W at v = {v:.5} {speed}, z = {z:.5} {metre}")
    }

    fn write_bounds(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let limits = &self.limits;
        let [force, newton, metre] = self.units(["force", "N", "m"]);
        for (name, symbol, limit, unit, by) in [
            ("deflection", "|z|", limits.deflection, metre, "Romano et al., Lemma III.1"),
            (force, "|F|", limits.force, newton, "z within its bound"),
            ("relaxation rate", "λ", limits.relaxation_rate, "1/s", "Romano et al., III-B"),
        ] {
            match limit.map(Number::of) {
                Some(limit) => row!(f, name, by by, "{symbol} ≤ {limit:.5} {unit}"),
                None => row!(f, name, by by, "no bound"),
            }?;
        }
        Ok(())
    }

    fn write_curve(&self, f: &mut fmt::Formatter<'_>, model: &Characteristics<T>) -> fmt::Result {
        let [unit, damping] = self.units(["m/s", "s/m"]);
        let folds = !self.inversion_margin.is_some_and(|margin| margin >= T::zero());
        row!(f, "inversion", by "Romano et al., II-B; by search",
            "{}: σ1 = {:.5}, least dμ/d|v| = {:.5} {damping}",
            if folds { "FOLDS" } else { "one solution" },
            Number::of(model.micro_damping.min),
            Number::of(model.least_slope + model.viscous_friction))?;
        let (name, by, slope) = ("curve at rest", "Romano et al., II-B", model.slope_at_rest);
        match Number::of(slope) {
            _ if is_zero(slope) => row!(f, name, by by, "differentiable"),
            finite if slope.is_finite() => row!(f, name, by by,
                "kink, dμ/d|v| = {finite:.5} {damping}: split steps at reversals"),
            _ => row!(f, name, by by, "infinitely steep: no method keeps its order there"),
        }?;
        match model.speed_at_rest {
            zero if is_zero(zero) => row!(f, "modulus |v|", by by, "exact, with its kink"),
            speed => {
                row!(f, "modulus |v|", by by, "smooth, |0|_ε = {:.5} {unit}", Number::of(speed))
            }
        }
    }

    fn write_yielding(
        &self,
        f: &mut fmt::Formatter<'_>,
        model: &Characteristics<T>,
    ) -> fmt::Result {
        let Some((breakaway, cycle)) = self.breakaway.zip(self.load_cycle) else { return Ok(()) };
        let [newton, metre, speed, force] = self.units(["N", "m", "m/s", "force"]);
        let (name, by, held) = ("breakaway", "Romano et al., II-B", Number::of(breakaway));
        match self.load_share() {
            Some(share) => row!(f, name, by by,
                "F_b = p μ_s = {held:.5} {newton}, of which {:.3} is used", Number::of(share)),
            None => row!(f, name, by by, "F_b = p μ_s = {held:.5} {newton}"),
        }?;
        let (from, to) = (Number::of(cycle.min), Number::of(cycle.max));
        let (name, by) = ("drift", "Dupont et al. 2002");
        match self.drift {
            Some(drift) if is_zero(drift) => row!(f, name, by by,
                "none in slow cycles {from:.5} ↔ {to:.5} {newton}"),
            Some(drift) => row!(f, name, by by,
                "{:.5} {metre} per slow cycle {from:.5} ↔ {to:.5} {newton}", Number::of(drift)),
            None if model.creeps => row!(f, name, by "its dashpot",
                "no end: the bristle creeps under any {force}"),
            None => row!(f, name, by by, "not known for {from:.5} ↔ {to:.5} {newton}"),
        }?;
        let (force, rate) = (Number::of(peak(cycle)), Number::of(self.relaxation_at_rest));
        let (name, by) = ("creep", "F_ss(v) = F");
        match self.creep {
            Some(creep) if is_zero(creep) => row!(f, name, by by, "none under {force:.5} {newton}"),
            Some(creep) => row!(f, name, by by,
                "{:.5} {speed} under {force:.5} {newton}; bristles relax at {rate:.5} 1/s",
                Number::of(creep)),
            None => row!(f, name, by by, "not known under {force:.5} {newton}"),
        }
    }

    fn write_mechanism(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [mass, unit] = self.units(["mass", "m/s"]);
        if let Some(stuck) = self.stuck {
            let mut name = Cell::default();
            write!(name, "stuck {mass}")?;
            row!(f, name.as_str(), by "module step_limits",
                "ω = {:.5} rad/s, ζ = {:.5}; after a reversal ζ = {:.5}",
                Number::of(stuck.frequency), Number::of(stuck.damping_ratio),
                Number::of(stuck.reversed_damping_ratio))?;
        }
        let Some(threshold) = self.steady_sliding else { return Ok(()) };
        let fastest = self.parameters.fastest;
        let (slowest, fastest) = (Number::of(slowest_on_spring(fastest)), Number::of(fastest));
        let mut by = Cell::default();
        write!(by, "Routh–Hurwitz, {slowest:.5} … {fastest:.5} {unit}")?;
        let (name, by) = ("sliding on spring", by.as_str());
        match threshold {
            _ if is_zero(self.normal_force) => row!(f, name, by by, "no friction, no load"),
            Threshold::AlwaysStable => row!(f, name, by by, "small motions die out at every speed"),
            Threshold::NeverStable => row!(f, name, by by,
                "small motions die out at no speed: stick-slip"),
            Threshold::Marginal => row!(f, name, by by,
                "small motions neither grow nor die out at any speed"),
            Threshold::StableAbove(speed) => row!(f, name, by by,
                "small motions die out above {:.5} {unit}, GROW just below", Number::of(speed)),
            Threshold::StableBelow(speed) => row!(f, name, by by,
                "small motions GROW above {:.5} {unit}, die out just below", Number::of(speed)),
        }
    }

    fn write_steps(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let columns = STEPS.into_iter().take(if self.stuck.is_some() { 3 } else { 1 });
        let mut cells = Cell::default();
        for (title, width) in columns.clone() {
            write!(cells, "{title:<width$}")?;
        }
        if let Some(time) = self.parameters.sample_time.map(Number::of) {
            write!(cells, "at {time:.5} s")?;
        }
        row!(f, "largest step [s]", by "module step_limits", "{}", cells.as_str())?;
        for (scheme, limits) in Scheme::ALL.into_iter().zip(self.steps) {
            let mut cells = Cell::default();
            match limits {
                None if scheme == Scheme::Passive => {
                    write!(cells, "no promise: the contact is not passive at every deflection")?;
                }
                None => write!(cells, "none is known: the relaxation rate has no bound")?,
                Some(limits) => {
                    let steps = [limits.bristle, limits.stuck_from_rest, limits.stuck_reversed];
                    for (step, (_, width)) in steps.into_iter().zip(columns.clone()) {
                        match step {
                            None => write!(cells, "{:<width$}", "any")?,
                            Some(step) if is_zero(step) => write!(cells, "{:<width$}", "none")?,
                            Some(step) => write!(cells, "{:<width$.5}", Number::of(step))?,
                        }
                    }
                    let within = self.parameters.sample_time.map(|step| limits.check(step).is_ok());
                    cells.write_str(within.map_or("", |ok| if ok { "ok" } else { "TOO LONG" }))?;
                }
            }
            let mut name = Cell::default();
            write!(name, "  {scheme}")?;
            writeln!(f, "{:<NAME$} {}", name.as_str(), cells.as_str().trim_end())?;
        }
        Ok(())
    }
}
