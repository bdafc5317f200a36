//! The audit as a table.

use core::fmt::{self, Write};

use super::{Audit, LawStatus, MethodLimit, Passivity, slowest_on_spring};
use crate::Scalar;
use crate::linear::Threshold;
use crate::scalar::to_f64;
use crate::stability::Scheme;

/// Width of the columns.
const NAME: usize = 19;
const FINDING: usize = 66;

/// Text on the stack: what does not fit is cut.
struct Cell {
    bytes: [u8; 192],
    length: usize,
}

impl Cell {
    fn new() -> Self {
        Self { bytes: [0; 192], length: 0 }
    }

    fn as_str(&self) -> &str {
        let written = self.bytes.get(..self.length).unwrap_or(&[]);
        core::str::from_utf8(written).unwrap_or("")
    }
}

impl Write for Cell {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for character in text.chars() {
            let end = self.length + character.len_utf8();
            match self.bytes.get_mut(self.length..end) {
                Some(place) => character.encode_utf8(place),
                None => return Ok(()),
            };
            self.length = end;
        }
        Ok(())
    }
}

/// A number to five digits, with an exponent where it is long without.
pub(crate) struct Number(pub(crate) f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = Cell::new();
        write!(text, "{:.4e}", self.0)?;
        let Some((digits, exponent)) = text.as_str().split_once('e') else {
            let infinite = self.0 == f64::INFINITY;
            return f.write_str(if infinite { "∞" } else { text.as_str() });
        };
        let power: i32 = exponent.parse().unwrap_or(0);
        if self.0 == 0.0 {
            return f.write_str("0");
        }
        if (-3..6).contains(&power) {
            let places = usize::try_from(4 - power).unwrap_or(0);
            let mut plain = Cell::new();
            write!(plain, "{:.places$}", self.0)?;
            let plain = plain.as_str();
            let short = if plain.contains('.') {
                plain.trim_end_matches('0').trim_end_matches('.')
            } else {
                plain
            };
            return f.write_str(short);
        }
        let digits = digits.trim_end_matches('0').trim_end_matches('.');
        write!(f, "{digits}e{exponent}")
    }
}

fn number<T: Scalar>(value: T) -> Number {
    Number(to_f64(value))
}

/// One line: what, finding, reference.
fn line(
    f: &mut fmt::Formatter<'_>,
    name: &str,
    finding: fmt::Arguments<'_>,
    reference: &str,
) -> fmt::Result {
    let mut cell = Cell::new();
    cell.write_fmt(finding)?;
    writeln!(f, "{name:<NAME$} {:<FINDING$} {reference}", cell.as_str())
}

impl<T: Scalar> fmt::Display for Audit<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name =
            self.characteristics.map_or("a friction model", |characteristics| characteristics.name);
        let (load, fastest) = (number(self.normal_force), number(self.parameters.fastest));
        writeln!(f, "audit of {name} under {load} N, |v| ≤ {fastest} m/s")?;
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
        let Passivity { verdict, needed_viscous_friction, excess, witness } = self.passivity;
        let outside = self
            .characteristics
            .map_or(T::zero(), |characteristics| characteristics.viscous_friction);
        let (has, ratio) = (number(outside), number(excess));
        let ortega = "Barabanov, Ortega 2000";
        match (verdict, needed_viscous_friction, witness) {
            (LawStatus::Holds, Some(needed), _) => {
                let needed = number(needed);
                let finding = format_args!("holds: needs σ2 ≥ {needed} s/m, has {has}");
                line(f, "passivity", finding, ortega)?;
            }
            (LawStatus::Holds, None, _) if excess == T::zero() => {
                let finding = format_args!("holds: F v − Ẇ is a sum of squares in every state");
                line(f, "passivity", finding, "Romano et al., Lemma III.2")?;
            }
            (LawStatus::Holds, None, _) => {
                let finding = format_args!("holds: (c₀ − K r)²/(4 K λ c₂) ≤ {ratio}");
                line(f, "passivity", finding, ortega)?;
            }
            (LawStatus::Fails, Some(needed), _) => {
                let needed = number(needed);
                let finding = format_args!("FAILS: needs σ2 ≥ {needed} s/m, has {has}");
                line(f, "passivity", finding, ortega)?;
            }
            (LawStatus::Fails, None, _) => {
                let finding = format_args!("FAILS: (c₀ − K r)²/(4 K λ c₂) up to {ratio}, not ≤ 1");
                line(f, "passivity", finding, "Romano et al., III-B; by search")?;
            }
            (LawStatus::Unrefuted, ..) => {
                let finding = format_args!("no case against it: (c₀ − K r)²/(4 K λ c₂) ≤ {ratio}");
                line(f, "passivity", finding, "Romano et al., III-B; by search")?;
            }
        }
        if let Some(witness) = witness {
            let (v, z) = (number(witness.velocity), number(witness.deflection));
            let power = number(witness.dissipated_power);
            let finding = format_args!("F v − Ẇ = {power} W at v = {v} m/s, z = {z} m");
            line(f, "  worst case", finding, "by search")?;
        }
        Ok(())
    }

    fn write_bounds(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut bound = |name, symbol, limit: Option<T>, unit, reference| match limit.map(number) {
            Some(limit) => line(f, name, format_args!("{symbol} ≤ {limit} {unit}"), reference),
            None => line(f, name, format_args!("no bound"), reference),
        };
        let limits = &self.limits;
        bound("deflection", "|z|", limits.deflection, "m", "Romano et al., Lemma III.1")?;
        bound("force", "|F|", limits.force, "N", "z within its bound")?;
        bound("relaxation rate", "λ", limits.relaxation_rate, "1/s", "Romano et al., III-B")
    }

    fn write_curve(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(characteristics) = self.characteristics else { return Ok(()) };
        if let Some(margin) = self.inversion_margin {
            let least = number(characteristics.least_slope + characteristics.viscous_friction);
            let damping = number(characteristics.micro_damping.min);
            let verdict = if margin >= T::zero() { "one solution" } else { "FOLDS" };
            let finding = format_args!("{verdict}: σ1 = {damping}, least dμ/d|v| = {least} s/m");
            line(f, "inversion", finding, "Romano et al., II-B; by search")?;
        }
        let slope = number(characteristics.slope_at_rest);
        let reference = "Romano et al., II-B";
        if characteristics.slope_at_rest == T::zero() {
            line(f, "curve at rest", format_args!("differentiable"), reference)?;
        } else if characteristics.slope_at_rest.is_finite() {
            let finding = format_args!("kink, dμ/d|v| = {slope} s/m: split steps at reversals");
            line(f, "curve at rest", finding, reference)?;
        } else {
            let finding = format_args!("infinitely steep: no method keeps its order there");
            line(f, "curve at rest", finding, reference)?;
        }
        if characteristics.speed_at_rest == T::zero() {
            line(f, "modulus |v|", format_args!("exact, with its kink"), reference)
        } else {
            let speed = number(characteristics.speed_at_rest);
            line(f, "modulus |v|", format_args!("smooth, |0|_ε = {speed} m/s"), reference)
        }
    }

    fn write_yielding(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(yielding) = self.yielding else { return Ok(()) };
        let force = number(yielding.breakaway);
        line(f, "breakaway", format_args!("F_b = p μ_s = {force} N"), "Romano et al., II-B")?;
        let (from, to) = (number(yielding.cycle.from), number(yielding.cycle.to));
        let creeps = self.characteristics.is_some_and(|characteristics| characteristics.creeps);
        match yielding.drift.map(number) {
            Some(Number(0.0)) => {
                let finding = format_args!("none in slow cycles {from} ↔ {to} N");
                line(f, "drift", finding, "Dupont et al. 2002")?;
            }
            Some(drift) => {
                let finding = format_args!("{drift} m per slow cycle {from} ↔ {to} N");
                line(f, "drift", finding, "Dupont et al. 2002")?;
            }
            None if creeps => {
                let finding = format_args!("no end: the bristle creeps under any force");
                line(f, "drift", finding, "its dashpot")?;
            }
            None => {
                let finding = format_args!("not known for {from} ↔ {to} N");
                line(f, "drift", finding, "Dupont et al. 2002")?;
            }
        }
        let leak = number(yielding.leak);
        let backward = -yielding.cycle.from > yielding.cycle.to;
        let to = if backward { from } else { to };
        match yielding.creep {
            Some(creep) if creep == T::zero() => {
                line(f, "creep", format_args!("none under {to} N"), "F_ss(v) = F")?;
            }
            Some(creep) => {
                let creep = number(creep);
                let finding = format_args!("{creep} m/s under {to} N; bristles leak at {leak} 1/s");
                line(f, "creep", finding, "F_ss(v) = F")?;
            }
            None => line(f, "creep", format_args!("not known under {to} N"), "F_ss(v) = F")?,
        }
        Ok(())
    }

    fn write_mechanism(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(stuck) = self.stuck {
            let rate = number(stuck.frequency);
            let ratio = number(stuck.damping_ratio);
            let later = number(stuck.reversed_damping_ratio);
            let finding =
                format_args!("ω = {rate} rad/s, ζ = {ratio}; after a reversal ζ = {later}");
            line(f, "stuck mass", finding, "module stability")?;
        }
        let Some(threshold) = self.steady_sliding else { return Ok(()) };
        let fastest = self.parameters.fastest;
        let (slowest, fastest) = (number(slowest_on_spring(fastest)), number(fastest));
        let mut reference = Cell::new();
        write!(reference, "Routh–Hurwitz, {slowest} … {fastest} m/s")?;
        let mut finding =
            |text: fmt::Arguments<'_>| line(f, "sliding on spring", text, reference.as_str());
        match threshold {
            _ if self.normal_force == T::zero() => finding(format_args!("no friction, no load")),
            Threshold::AlwaysStable => {
                finding(format_args!("small motions die out at every speed"))
            }
            Threshold::NeverStable => {
                finding(format_args!("small motions die out at no speed: stick-slip"))
            }
            Threshold::Marginal => {
                finding(format_args!("small motions neither grow nor die out at any speed"))
            }
            Threshold::StableAbove(speed) => {
                let speed = number(speed);
                finding(format_args!("small motions die out above {speed} m/s, GROW just below"))
            }
            Threshold::StableBelow(speed) => {
                let speed = number(speed);
                finding(format_args!("small motions GROW above {speed} m/s, die out just below"))
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
            write!(head, "at {time} s")?;
        }
        line(f, "largest step [s]", format_args!("{}", head.as_str()), "module stability")?;
        for step in &self.steps {
            write_step(f, step, self.stuck.is_some())?;
        }
        Ok(())
    }
}

/// The limits of one method, in the columns of the head.
fn write_step<T: Scalar>(
    f: &mut fmt::Formatter<'_>,
    step: &MethodLimit<T>,
    mechanism: bool,
) -> fmt::Result {
    let mut cells = Cell::new();
    match step.limits {
        None if step.scheme == Scheme::Passive => {
            cells.write_str("no promise: the contact is not passive at every deflection")?;
        }
        None => cells.write_str("none is known: the relaxation rate has no bound")?,
        Some(limits) => {
            let columns =
                [(limits.bristle, 12), (limits.stuck_from_rest, 12), (limits.stuck_reversed, 14)];
            let columns = columns.into_iter().take(if mechanism { 3 } else { 1 });
            for (limit, width) in columns {
                let mut cell = Cell::new();
                match limit.map(to_f64) {
                    None => cell.write_str("any")?,
                    Some(0.0) => cell.write_str("none")?,
                    Some(limit) => write!(cell, "{}", Number(limit))?,
                }
                write!(cells, "{:<width$}", cell.as_str())?;
            }
        }
    }
    match step.within {
        Some(true) => cells.write_str("ok")?,
        Some(false) => cells.write_str("TOO LONG")?,
        None => {}
    }
    let mut name = Cell::new();
    write!(name, "  {}", step.scheme)?;
    writeln!(f, "{:<NAME$} {}", name.as_str(), cells.as_str().trim_end())
}
