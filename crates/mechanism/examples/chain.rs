//! A Burridge–Knopoff chain: blocks in a row, dragged by springs over a rough floor, that stick and
//! slip in avalanches of every size.
//!
//! Each block has 1 kg under 0.9 to 1.1 N, a spring of 1 N/m to a driver that moves at V, and
//! springs of κ to its neighbours. Coordinates count from the driver, so that the floor is a belt
//! of velocity −V under the blocks: no force is applied, and all energy comes in through the
//! friction.
//!
//! An avalanche begins where the first block slides faster than 20 V and ends where the last one
//! stops; its size is the sum of the ways that all blocks have slid. The first quarter of the time
//! is not counted. The motion is chaotic: other roundings give other avalanches, with like counts.
//!
//! Leaves `chain.csv` (the avalanches) and `chain.svg`. Prints their statistics and the energies.

use std::process::ExitCode;

use bristle::companion::Companion;
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, FrBd, Mechanism, ParameterError};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Progress, Rule, Symbol, println};
use bristle_mechanism::{Block, Chain, ContactState, Coupling, Inputs, Motion, on_ground};

type Friction = FrBd<Stribeck<f64>, KelvinVoigt<f64>>;

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("chain", "Avalanches in a Burridge–Knopoff chain")
            .count("blocks", 200, "blocks in the chain")
            .must_be(Rule::Between(2.0, 1e4))
            .number("coupling", 1.0, "N/m", "stiffness of the springs between blocks")
            .must_be(Rule::Positive)
            .number("drive", 1e-3, "m/s", "velocity of the driver")
            .must_be(Rule::Between(1e-5, 0.1))
            .number("end", 10_000.0, "s", "end of the simulated time")
            .must_be(Rule::Between(10.0, 1e6))
            .number("step", 0.02, "s", "length of a step")
            .must_be(Rule::Between(1e-4, 1.0))
            .parse()?;
        let scene = Scene {
            blocks: arguments.count("blocks"),
            coupling: arguments.number("coupling"),
            drive: arguments.number("drive"),
            end: arguments.number("end"),
            step: arguments.number("step"),
        };
        let run = scene.run()?;
        let columns = ["beginning", "end", "size", "blocks"];
        let mut table = Csv::create(arguments.out_dir(), "chain", &columns)?;
        for a in &run.avalanches {
            table.row(&[], &[a.beginning, a.end, a.size, a.blocks as f64])?;
        }
        table.finish()?;
        run.print();
        println!("{}", run.figure(&scene).save(arguments.out_dir(), "chain")?.display());
        Ok(())
    })
}

struct Scene {
    blocks: usize,
    coupling: f64,
    drive: f64,
    end: f64,
    step: f64,
}

#[derive(Clone, Copy)]
struct Avalanche {
    beginning: f64,
    end: f64,
    /// Sum of the ways of all blocks [m], and how many have slid.
    size: f64,
    blocks: usize,
}

struct Run {
    avalanches: Vec<Avalanche>,
    /// Where and when a block slid: time [s] and number of the block.
    sliding: Vec<(f64, f64)>,
    /// Mean friction over time [s, N].
    mean_force: Vec<(f64, f64)>,
    steps: u32,
    /// From the driver, dissipated, in springs and masses, in bristles, and what is missing [J].
    energies: [f64; 5],
}

/// A share in [0, 1) that differs from block to block without order.
fn scattered(ratio: f64, block: usize) -> f64 {
    (ratio * block as f64).fract()
}

fn friction(load: f64) -> Result<Companion<f64, Friction>, ParameterError> {
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: 1.0,
        dynamic_coefficient: 0.8,
        stribeck_velocity: 0.03,
        stribeck_exponent: 1.0,
        viscous_friction: 0.0,
    })?;
    let bristle =
        KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness: 1e3, micro_damping: 10.0 })?;
    FrBd::new(curve, bristle).under_load(load)?.companion(1.0)
}

impl Scene {
    fn run(&self) -> Result<Run, ParameterError> {
        let (n, h) = (self.blocks, self.step);
        let block = Block {
            to_ground: Mechanism { mass: 1.0, spring_stiffness: 1.0, viscous_damping: 0.0 },
            to_next: Coupling { stiffness: self.coupling, damping: 0.0 },
        };
        let rows: Vec<_> = (0..n).map(on_ground).collect();
        let mut chain = Chain { blocks: &vec![block; n] }.on_heap(rows)?;
        let loads = (0..n).map(|i| 0.9 + 0.2 * scattered(0.754_877_666_246_693, i)); // N
        let companions = loads.map(friction).collect::<Result<Vec<_>, _>>()?;
        let new = |companion| ContactState::new(companion, 0.0);
        let mut contacts: Vec<_> = companions.iter().map(new).collect();
        // At rest on the floor.
        let place = |i| 0.05 * scattered(0.618_033_988_749_895, i); // m
        let mut position: Vec<_> = (0..n).map(place).collect();
        let mut velocity = vec![-self.drive; n];
        let (force, floor) = (vec![0.0; n], vec![self.drive; n]);
        let inputs = Inputs { force: &force, prescribed: &floor, load: &[] };

        let beginning = chain.energy(&position, &velocity);
        let (mut driven, mut dissipated, mut stored) = (0.0, 0.0, 0.0);
        let mut avalanches = Avalanches::new(n, self);
        let mut mean_force = Vec::new();
        let steps = (self.end / h).round() as u32;
        let (every, part) = ((steps / 20_000).max(1), (steps / 100).max(1));
        let mut progress = Progress::new("chain", 100);
        for step in 0..steps {
            let motion = Motion { position: &mut position, velocity: &mut velocity };
            chain.step(h, &inputs, motion, &companions, &mut contacts)?;
            let mut total = 0.0;
            for state in &contacts {
                let done = state.last_step();
                total += done.force;
                dissipated += done.dissipated;
                stored += done.stored;
            }
            driven += total * self.drive * h;
            let time = h * f64::from(step + 1);
            avalanches.see(time, h, self.drive, &velocity);
            if step % every == 0 && time > 0.9 * self.end {
                mean_force.push((time, total / n as f64));
            }
            if step % part == 0 {
                progress.reach((step / part) as usize);
            }
        }
        progress.reach(100);
        let mechanical = chain.energy(&position, &velocity) - beginning;
        let missing = driven - dissipated - mechanical - stored;
        let counted = avalanches.all.into_iter().filter(|a| a.beginning > 0.25 * self.end);
        Ok(Run {
            avalanches: counted.collect(),
            sliding: avalanches.sliding,
            mean_force,
            steps,
            energies: [driven, dissipated, mechanical, stored, missing],
        })
    }
}

/// Finds avalanches while the chain moves.
struct Avalanches {
    threshold: f64,
    slid: Vec<f64>,
    now: Option<f64>,
    next_picture: f64,
    all: Vec<Avalanche>,
    sliding: Vec<(f64, f64)>,
}

impl Avalanches {
    fn new(blocks: usize, scene: &Scene) -> Self {
        let (threshold, pictured, slid) = (20.0 * scene.drive, 0.9 * scene.end, vec![0.0; blocks]);
        let (all, sliding) = (Vec::new(), Vec::new());
        Self { threshold, slid, now: None, next_picture: pictured, all, sliding }
    }

    fn see(&mut self, time: f64, h: f64, drive: f64, velocity: &[f64]) {
        let mut moves = false;
        let picture = time >= self.next_picture;
        for (i, (slid, v)) in self.slid.iter_mut().zip(velocity).enumerate() {
            let speed = v + drive;
            if speed.abs() > self.threshold {
                *slid += speed.abs() * h;
                moves = true;
                if picture {
                    self.sliding.push((time, i as f64 + 1.0));
                }
            }
        }
        if picture {
            self.next_picture = time + 0.5;
        }
        match (self.now, moves) {
            (None, true) => self.now = Some(time),
            (Some(beginning), false) => {
                let size = self.slid.iter().sum();
                let blocks = self.slid.iter().filter(|slid| **slid != 0.0).count();
                self.all.push(Avalanche { beginning, end: time, size, blocks });
                self.slid.fill(0.0);
                self.now = None;
            }
            _ => {}
        }
    }
}

impl Run {
    fn print(&self) {
        let count = self.avalanches.len();
        println!("{} steps, {count} avalanches", self.steps);
        println!("blocks that slid    avalanches   share of the way");
        let way: f64 = self.avalanches.iter().map(|a| a.size).sum();
        for (least, most) in [(1, 1), (2, 3), (4, 9), (10, 29), (30, 99), (100, usize::MAX)] {
            let inside = |a: &&Avalanche| (least..=most).contains(&a.blocks);
            let (mut number, mut share) = (0, 0.0);
            for avalanche in self.avalanches.iter().filter(inside) {
                number += 1;
                share += avalanche.size / way;
            }
            let range = match most {
                usize::MAX => format!("{least} or more"),
                _ if least == most => format!("{least}"),
                _ => format!("{least} to {most}"),
            };
            println!("{range:>16} {number:13} {:16.1} %", 100.0 * share);
        }
        let [driven, dissipated, mechanical, stored, missing] = self.energies;
        println!();
        println!("from the driver              {driven:16.9} J");
        println!("dissipated                   {dissipated:16.9} J");
        println!("more in springs and masses   {mechanical:16.9} J");
        println!("more in bristles             {stored:16.9} J");
        println!("missing                      {missing:16.1e} J");
        println!();
    }

    fn figure(&self, scene: &Scene) -> Figure {
        let mut sizes: Vec<f64> = self.avalanches.iter().map(|a| a.size).collect();
        sizes.sort_by(|a, b| b.total_cmp(a));
        let counts = sizes.iter().enumerate().map(|(i, &size)| (size, i as f64 + 1.0));
        let counts: Vec<_> = counts.collect();
        let title = format!("Avalanches in a chain of {} blocks", scene.blocks);
        let last = 0.9 * scene.end..=scene.end;
        Figure::new(900, 760)
            .title(title)
            .panel(
                Panel::new("time t (s)", "block")
                    .title("where and when blocks slide")
                    .x_range(last.clone())
                    .points("", Symbol::from(Colour::Blue).size(2.0), &self.sliding),
            )
            .panel(
                Panel::new("time t (s)", "mean friction (N)")
                    .title("the force on the driver")
                    .x_range(last)
                    .line("", Colour::Orange, &self.mean_force),
            )
            .panel(
                Panel::new("size: sum of the ways of all blocks (m)", "avalanches ≥ size")
                    .title("sizes over counts")
                    .log_x()
                    .log_y()
                    .points("", Symbol::from(Colour::Green).size(4.0), counts),
            )
    }
}
