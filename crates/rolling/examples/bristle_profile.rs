//! What the bristles of a tyre do in its contact patch: deflection over place and time, under a
//! slip velocity that reverses (Table 1, V = 20 1/s, v(t) = 1 − exp(−t/5 ms) + 0.5 sin(2π 10 t) −
//! 0.6).
//!
//! Bristles enter undeflected at ξ = 0 and travel up the picture, one patch in 50 ms. What the slip
//! does to them at an instant it does to all of them at once.
//!
//! Leaves `bristle_profile.csv` and `bristle_profile.svg`.

use std::process::ExitCode;

use bristle::curve::Stribeck;
use bristle::rheology::KelvinVoigt;
use bristle::{FrBd, paper};
use bristle_charts::{Arguments, Colour, Csv, Figure, HeatMap, Panel, Rule, println};
use bristle_rolling::{Grid, Motion, Patch, PatchParameters, PolynomialExponential};

/// Rolling speed [m/s].
const SPEED: f64 = 2.0;
/// Speed over the length of the patch [1/s].
const TRANSPORT: f64 = SPEED / bristle_rolling::TYRE_LENGTH;

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments =
            Arguments::new("bristle_profile", "Bristles in the contact patch of a tyre")
                .number("end", 0.3, "s", "end of the simulated time")
                .must_be(Rule::Between(1e-3, 10.0))
                .count("cells", 100, "cells of the grid; a step crosses one")
                .must_be(Rule::Between(4.0, 1000.0))
                .number("offset", -0.6, "m/s", "constant part of the slip velocity beyond 1 m/s")
                .must_be(Rule::Between(-100.0, 100.0))
                .parse()?;
        let (end, cells) = (arguments.number("end"), arguments.count("cells"));
        let offset = arguments.number("offset");
        let slip = |t: f64| {
            1.0 - (-t / 0.005).exp() + 0.5 * (20.0 * std::f64::consts::PI * t).sin() + offset
        };

        let patch = Patch::new(PatchParameters {
            model: FrBd::new(
                Stribeck::new(paper::TYRE_CURVE)?,
                KelvinVoigt::new(paper::TYRE_BRISTLE)?,
            ),
            length: bristle_rolling::TYRE_LENGTH,
            pressure: PolynomialExponential::parabolic(),
        })?
        .under_load(1.0)?;
        let mut grid = Grid::new(&patch, cells)?;

        // A cell a step: the nodes are exact for the velocity at the middle of each step.
        let step = 1.0 / (TRANSPORT * cells as f64);
        let steps = (end / step).round().max(1.0) as usize;
        let mut times = vec![0.0];
        let mut profiles = vec![grid.deflections()[0].to_vec()];
        let mut forces = vec![(0.0, grid.force(|_| slip(0.0)))];
        for n in 0..steps {
            let slip_velocity = slip((n as f64 + 0.5) * step);
            grid.step(Motion { slip_velocity, rolling_speed: SPEED }, step)?;
            let time = (n + 1) as f64 * step;
            times.push(time);
            profiles.push(grid.deflections()[0].to_vec());
            forces.push((time, grid.force(|_| slip(time))));
        }

        let columns = ["t", "place", "deflection"];
        let mut table = Csv::create(arguments.out_dir(), "bristle_profile", &columns)?;
        for (&time, profile) in times.iter().zip(&profiles) {
            for (&place, &deflection) in grid.places().iter().zip(profile) {
                table.row(&[], &[time, place, deflection])?;
            }
        }
        table.finish()?;

        println!(
            "Table 1, rolling at {SPEED} m/s, parabolic pressure, {cells} cells, {steps} steps"
        );
        println!();
        println!("    t / ms   v / (m/s)   z at outlet / mm   largest |z| / mm   F/F_z");
        for n in (0..=steps).step_by((steps / 12).max(1)) {
            let largest = profiles[n].iter().fold(0.0, |most: f64, z| most.max(z.abs()));
            let outlet = profiles[n].last().copied().unwrap_or(0.0);
            println!(
                "{:10.1} {:11.4} {:18.4} {:18.4} {:7.4}",
                1e3 * times[n],
                slip(times[n]),
                1e3 * outlet,
                1e3 * largest,
                forces[n].1
            );
        }

        let ground = HeatMap::new("deflection z (mm)", times.clone(), grid.places(), |i, j| {
            1e3 * profiles[i][j]
        });
        // The way of a bristle in every transit.
        let ways = (0..).map(|k| f64::from(k) / TRANSPORT).take_while(|&start| start < end);
        let map = ways.fold(
            Panel::new("time t (s)", "place ξ (–)")
                .title("deflection; dashed: ways of single bristles"),
            |panel, start| {
                let out = end.min(start + 1.0 / TRANSPORT);
                let way = [(start, 0.0), (out, (out - start) * TRANSPORT)];
                panel.line("", Colour::Black.dashed().width(0.8), way)
            },
        );
        let velocity: Vec<(f64, f64)> = times.iter().map(|&time| (time, slip(time))).collect();
        let figure = Figure::new(760, 760)
            .title("Deflection of the bristles of a tyre over place and time")
            .panel(map.heat_map(ground))
            .panel(Panel::new("time t (s)", "slip velocity v (m/s)").horizontal(0.0, "").line(
                "",
                Colour::Blue,
                velocity,
            ))
            .panel(Panel::new("time t (s)", "force ratio F/F_z (–)").horizontal(0.0, "").line(
                "",
                Colour::Blue,
                forces,
            ));
        println!();
        println!("{}", figure.save(arguments.out_dir(), "bristle_profile")?.display());
        Ok(())
    })
}
