//! The program: a curve from a table, and what the chart says.
#![allow(clippy::unwrap_used, reason = "a test panics to fail")]

use std::fs;
use std::path::Path;
use std::process::Command;

const SCENE: &str = r#"
solver = { end = 0.1, samples = 5 }
[scene.prescribed_velocity]
velocity.constant = 0.01
[scene.prescribed_velocity.contact]
normal_force = 10.0
[scene.prescribed_velocity.contact.model.frbd]
rheology = { micro_stiffness = 1e4, micro_damping = 10.0 }
"#;

/// Table and chart that the program leaves of a file `name`.toml with a curve.
fn left(folder: &Path, name: &str, curve: &str) -> (String, String) {
    let path = folder.join(name).with_extension("toml");
    fs::write(&path, format!("{SCENE}curve.tabulated = {curve}\n")).unwrap();
    let mut program = Command::new(env!("CARGO_BIN_EXE_bristle"));
    assert!(program.arg(&path).arg("--out").arg(folder).status().unwrap().success());
    let read = |end| fs::read_to_string(path.with_extension(end)).unwrap();
    (read("csv"), read("svg"))
}

#[test]
fn a_curve_comes_from_a_table_and_the_chart_names_file_and_model() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("curve");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("measured.csv"), "v,mu\n0.0,0.5\n0.02,0.4\n1.0,0.6\n").unwrap();
    let (table, chart) = left(&folder, "by_name", r#""measured.csv""#);
    let rows = "[{ speed = 0.0, coefficient = 0.5 }, { speed = 0.02, coefficient = 0.4 }, \
                { speed = 1.0, coefficient = 0.6 }]";
    assert_eq!(table, left(&folder, "in_line", rows).0);
    assert!(chart.contains("by_name.toml: frbd"));
}
