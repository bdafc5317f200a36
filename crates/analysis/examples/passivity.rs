//! An engine made of friction: a velocity that is slow over 1.5 mm and fast over 0.1 mm, again and
//! again. Classical LuGre with the paper's parameters (Table 2) gives work in every cycle; FrBD
//! takes it.
//!
//! Leaves `passivity.csv` and `passivity.svg`: the force over a settled cycle, the work over the
//! cycles, and the work per cycle over the fast velocity.

use std::error::Error;
use std::process::ExitCode;

use bristle::curve::Stribeck;
use bristle::rheology::KelvinVoigt;
use bristle::{Bristle, Contact, FrBd, LuGre, paper};
use bristle_analysis::audit::{AuditParameters, audit};
use bristle_analysis::ledger::{EnergyBalance, EnergyLedger};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, Stroke, println};

const SLOW: f64 = 1e-3;
const SLOW_PATH: f64 = 1.5e-3;
const FAST_PATH: f64 = 1e-4;

/// One model's machine, ready for the table and the chart.
struct Machine {
    label: &'static str,
    stroke: Stroke,
    /// A settled cycle.
    cycle: EnergyBalance<f64>,
    residual: f64,
    /// Displacement [m] and force [N], slow and fast phase of the settled cycle.
    phases: [Vec<(f64, f64)>; 2],
    /// Work supplied [J] after each cycle from the start.
    work: Vec<(f64, f64)>,
    /// Work per settled cycle [J] over the fast velocity [m/s].
    over_velocity: Vec<(f64, f64)>,
}

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("passivity", "An engine made of friction")
            .number("fast", 10.0, "m/s", "velocity of the fast phase")
            .must_be(Rule::Positive)
            .count("cycles", 20, "cycles from rest")
            .must_be(Rule::Between(2.0, 1e6))
            .count("samples", 401, "rows per phase of the last cycle")
            .must_be(Rule::Between(2.0, 1e6))
            .parse()?;
        let (fast, cycles) = (arguments.number("fast"), arguments.count("cycles"));
        let samples = arguments.count("samples");

        let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
        let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
        let columns = ["model", "t", "x", "v", "z", "force", "supplied", "stored", "dissipated"];
        let mut table = Csv::create(arguments.out_dir(), "passivity", &columns)?;

        let classical = LuGre::classical(curve, bristle);
        let inside = LuGre::with_viscous_friction(curve, bristle, 0.0)?;
        let frbd = FrBd::new(curve, bristle);
        let mut run = Run { fast, cycles, samples, table: &mut table };
        let machines = [
            run.machine("lugre", "LuGre", Colour::Orange.into(), classical)?,
            run.machine("lugre_inside", "LuGre, σ_2 inside g", Colour::Green.dashed(), inside)?,
            run.machine("frbd", "FrBD", Colour::Blue.dotted(), frbd)?,
        ];
        table.finish()?;

        println!(
            "1 mm/s over 1.5 mm, {fast} m/s over 0.1 mm, Table 2, p = 1 N, after {cycles} cycles"
        );
        println!();
        println!(
            "                      supplied / J     stored / J  dissipated / J  residual of the run"
        );
        for Machine { label, cycle, residual, .. } in &machines {
            let EnergyBalance { supplied, stored, dissipated } = cycle;
            println!(
                "{label:18} {supplied:15.7e} {stored:14.1e} {dissipated:15.7e} {residual:20.1e}"
            );
        }
        println!();
        let audit = audit(&classical.under_load(1.0)?, AuditParameters::up_to(fast))?;
        for line in audit.to_string().lines().take(2) {
            println!("{line}");
        }
        println!();
        println!("{}", chart(&machines, fast).save(arguments.out_dir(), "passivity")?.display());
        Ok(())
    })
}

struct Run<'a> {
    fast: f64,
    cycles: usize,
    samples: usize,
    table: &'a mut Csv,
}

impl Run<'_> {
    fn machine<M: Bristle<f64, Deflection = f64> + Copy>(
        &mut self,
        name: &str,
        label: &'static str,
        stroke: Stroke,
        model: M,
    ) -> Result<Machine, Box<dyn Error>> {
        let contact = model.under_load(1.0)?;
        let (mut z, mut ledger) = (0.0, EnergyLedger::new());
        let mut work = vec![(0.0, 0.0)];
        for cycle in 1..self.cycles {
            z = one_cycle(&mut ledger, &contact, z, self.fast);
            work.push((cycle as f64, ledger.total().supplied));
        }
        // The last one in small steps, each exact.
        ledger.close_cycle();
        let mut phases = [Vec::new(), Vec::new()];
        let (mut t, mut x) = (0.0, 0.0);
        let runs = [(SLOW, SLOW_PATH), (self.fast, FAST_PATH)];
        for ((velocity, path), points) in runs.into_iter().zip(&mut phases) {
            let step = path / velocity / (self.samples - 1) as f64;
            for i in 0..self.samples {
                if i > 0 {
                    z = ledger.hold(&contact, velocity, z, step).deflection;
                    (t, x) = (t + step, x + velocity * step);
                }
                let force = contact.force(velocity, z);
                let EnergyBalance { supplied, stored, dissipated } = ledger.cycle();
                self.table
                    .row(&[name], &[t, x, velocity, z, force, supplied, stored, dissipated])?;
                points.push((x * 1e3, force));
            }
        }
        work.push((self.cycles as f64, ledger.total().supplied));
        Ok(Machine {
            label,
            stroke,
            cycle: ledger.cycle(),
            residual: ledger.total().residual(),
            phases,
            work: work.into_iter().map(|(cycle, energy)| (cycle, energy * 1e3)).collect(),
            over_velocity: (0..=100)
                .map(|i| 10f64.powf(f64::from(i) / 40.0 - 1.0))
                .map(|fast| (fast, settled(&contact, fast).supplied * 1e3))
                .collect(),
        })
    }
}

/// Both phases in one exact step each.
fn one_cycle<M: Bristle<f64, Deflection = f64>>(
    ledger: &mut EnergyLedger<f64>,
    contact: &Contact<f64, M>,
    z: f64,
    fast: f64,
) -> f64 {
    let z = ledger.hold(contact, SLOW, z, SLOW_PATH / SLOW).deflection;
    ledger.hold(contact, fast, z, FAST_PATH / fast).deflection
}

/// The energies of a cycle that repeats itself.
fn settled<M: Bristle<f64, Deflection = f64>>(
    contact: &Contact<f64, M>,
    fast: f64,
) -> EnergyBalance<f64> {
    let (mut z, mut ledger) = (0.0, EnergyLedger::new());
    for _ in 0..40 {
        ledger.close_cycle();
        z = one_cycle(&mut ledger, contact, z, fast);
    }
    ledger.cycle()
}

fn chart(machines: &[Machine], fast: f64) -> Figure {
    let with = |panel: Panel, points: fn(&Machine) -> &[(f64, f64)]| {
        machines.iter().fold(panel, |panel, machine| {
            panel.line(machine.label, machine.stroke, points(machine))
        })
    };
    let panel = |title: &str, x: &str, y: &str| Panel::new(x, y).title(title);
    let path = "displacement x (mm)";
    Figure::new(960, 760)
        .title("An engine made of friction: work of FrBD and LuGre, cycle by cycle")
        .columns(2)
        .panel(with(panel("slow phase: 1 mm/s", path, "friction force F (N)"), |m| &m.phases[0]))
        .panel(with(panel(&format!("fast phase: {fast} m/s"), path, "friction force F (N)"), |m| {
            &m.phases[1]
        }))
        .panel(with(
            panel("from rest", "number of cycles (–)", "work done on the contact (mJ)"),
            |m| &m.work,
        ))
        .panel(
            with(
                panel("settled cycle", "velocity of the fast phase (m/s)", "work per cycle (mJ)"),
                |m| &m.over_velocity,
            )
            .log_x()
            .y_range(-30.0..=10.0)
            .horizontal(0.0, ""),
        )
}
