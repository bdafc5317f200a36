//! Tests of this module, run wherever a test binary includes it or an example that does.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::{Path, PathBuf};

use super::chart::{Colour, Figure, HeatMap, Panel};
use super::draw::svg;
use super::table::{Csv, read_columns, read_names};
use super::{Arguments, Rule, Values, shortest};

fn folder(test: &str) -> PathBuf {
    std::env::temp_dir().join(format!("bristle-support-{}-{test}", std::process::id()))
}

fn arguments() -> Arguments {
    Arguments::new("test", "A test")
        .number("end", 60.0, "s", "end of the simulated time")
        .must_be(Rule::Positive)
        .number("offset", 0.0, "m", "where it starts")
        .count("samples", 11, "points of the curve")
        .must_be(Rule::AtLeast(2.0))
}

fn parse(arguments: Arguments, words: &[&str]) -> Result<Values, String> {
    let words = words.iter().chain(&["--out", "/tmp"]).map(|word| (*word).to_owned());
    arguments.parse_from(words).map_err(|error| error.to_string())
}

#[test]
fn values_are_defaults_or_follow_a_space_or_an_equals_sign() {
    let values = parse(arguments(), &[]).unwrap();
    assert_eq!((values.number("end"), values.count("samples")), (60.0, 11));
    assert_eq!(values.out_dir(), Path::new("/tmp"));
    let words = ["--end", "1e-3", "--samples=5", "--offset", "-2", "--bench"];
    let values = parse(arguments(), &words).unwrap();
    assert_eq!((values.number("end"), values.number("offset")), (1e-3, -2.0));
    assert_eq!(values.count("samples"), 5);
}

#[test]
fn refusals_name_the_option_the_value_and_the_rule() {
    let refusal = |words: &[&str]| parse(arguments(), words).unwrap_err();
    let number = "--end must be a number, positive, but";
    for given in ["NaN", "inf", "0", "-1", "ten", ""] {
        assert_eq!(refusal(&["--end", given]), format!("{number} {given:?} was given"));
    }
    let count = "--samples must be a whole number, at least 2, but";
    assert_eq!(refusal(&["--samples=1"]), format!("{count} \"1\" was given"));
    assert_eq!(refusal(&["--samples=2.5"]), format!("{count} \"2.5\" was given"));
    assert_eq!(refusal(&["--end"]), "--end needs a value (a number, positive)");
    assert_eq!(refusal(&["--out="]), "--out needs a value (a folder)");
    assert_eq!(refusal(&["--end", "3", "--end=4"]), "--end is given twice");
    let known = "there are --end, --offset, --samples, --out, --help";
    assert_eq!(refusal(&["--edn", "3"]), format!("unknown option \"--edn\"; {known}"));
    assert_eq!(refusal(&["end"]), format!("unknown option \"end\"; {known}"));
}

#[test]
fn help_lists_every_option_with_unit_rule_and_default() {
    let usage = parse(arguments(), &["--help"]).unwrap_err();
    let end = "--end NUMBER     end of the simulated time / s, positive [default: 60]";
    let samples = "--samples COUNT  points of the curve, at least 2 [default: 11]";
    assert!(usage.contains(end) && usage.contains(samples), "{usage}");
    assert!(usage.contains("--out DIR"), "{usage}");
}

#[test]
fn a_file_and_a_text_are_taken_where_they_are_declared() {
    let arguments = || Arguments::new("test", "A test").text("columns", "t=1", "which").file();
    let values = parse(arguments(), &["data.csv", "--columns", "t=2"]).unwrap();
    assert_eq!((values.file(), values.text("columns")), (Some(Path::new("data.csv")), "t=2"));
    let values = parse(arguments(), &[]).unwrap();
    assert_eq!((values.file(), values.text("columns")), (None, "t=1"));
    let twice = parse(arguments(), &["a", "b"]).unwrap_err();
    assert!(twice.starts_with("unknown option \"b\""), "{twice}");
}

#[test]
fn files_go_on_to_the_next_option_and_add_up() {
    let arguments = || Arguments::new("test", "A test").files("log", "logs").count("n", 1, "n");
    let values = parse(arguments(), &["--log", "a", "b", "--n", "2", "--log=c"]).unwrap();
    assert_eq!(values.files("log"), ["a", "b", "c"].map(Path::new));
    assert_eq!(values.count("n"), 2);
    assert!(parse(arguments(), &[]).unwrap().files("log").is_empty());
    let none = parse(arguments(), &["--log", "--n", "2"]).unwrap_err();
    assert_eq!(none, "--log needs a value (one file or several)");
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let words = ["--out=/proc/nowhere/figures".to_owned()];
    let error = arguments().parse_from(words).unwrap_err().to_string();
    let expected = "--out: cannot create the folder /proc/nowhere/figures: ";
    assert!(error.starts_with(expected), "{error}");
}

#[test]
fn numbers_read_back_to_the_same_bits() {
    let special = [0.1 + 0.2, f64::MIN_POSITIVE, 5e-324, f64::MAX, -0.0, f64::NEG_INFINITY];
    for value in special {
        assert_eq!(shortest(value).parse::<f64>().map(f64::to_bits), Ok(value.to_bits()));
    }
    assert_eq!([1e-9, 0.1].map(shortest), ["1e-9", "0.1"]);
}

#[test]
fn a_table_has_a_header_and_rows_of_text_and_numbers() {
    let folder = folder("rows");
    let mut table = Csv::create(&folder, "table", &["model", "t", "x"]).unwrap();
    table.row(&["a, \"b\""], &[0.1, 1e-9]).unwrap();
    let refused = table.row(&["a"], &[0.1]).unwrap_err().to_string();
    assert!(refused.ends_with("a row has 2 cells, the header 3"), "{refused}");
    let path = table.finish().unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(text, "model,t,x\n\"a, \"\"b\"\"\",0.1,1e-9\n");
    // The table stands where another one wants a folder.
    let blocked = Csv::create(&path, "table", &["t"]).unwrap_err().to_string();
    assert!(blocked.ends_with("it is a file"), "{blocked}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn columns_are_chosen_scaled_and_refused_by_place() {
    let path = folder("columns");
    std::fs::write(&path, "Time [s]\tForce [uN]\n# by hand\n0\t5\n0.5\t-6\n").unwrap();
    let read = read_columns(&path, "t=1,f=2*-0.25").unwrap();
    assert_eq!(read, [("t".to_owned(), vec![0.0, 0.5]), ("f".to_owned(), vec![-1.25, 1.5])]);
    assert_eq!(read_columns(&path, "t=Time [s],f=Force [uN]*-0.25").unwrap(), read);
    assert_eq!(read_names(&path).unwrap(), ["Time [s]", "Force [uN]"]);
    std::fs::write(&path, "0,1\n1,one\n").unwrap();
    let refused = read_columns(&path, "t=1,f=2").unwrap_err().to_string();
    assert!(refused.ends_with("line 2: column 2 must be a number, but is \"one\""), "{refused}");
    for choice in ["t", "t=0", "t=1*", "t=1*NaN", "=x", "t=Time"] {
        let refused = read_columns(&path, choice).unwrap_err().to_string();
        assert!(refused.starts_with("columns: "), "{choice}: {refused}");
    }
    std::fs::remove_file(path).unwrap();
}

fn panel() -> Panel {
    let points = [(0.0, 1.0), (1.0, 2.0)];
    Panel::new("time t (s)", "force F_z (N)").line("a < b", Colour::Blue.dashed(), points)
}

#[test]
fn a_figure_has_a_title_subscripts_dashes_and_a_name_for_every_series() {
    let nothing: [(f64, f64); 0] = [];
    let empty = panel().line("not there", Colour::Green, nothing);
    let empty = empty.line(r"ode\_solvers", Colour::Green, [(0.0, 1.5), (1.0, 1.5)]);
    let figure = Figure::new(400, 600).title("Loads").panel(panel()).panel(empty);
    let svg = svg(&figure).unwrap();
    let subscript = ">z</tspan><tspan dx=\"0.3em\" dy=\"-0.225em\">(N)</tspan>";
    // Two panels, one legend; dashes in both panels and in the legend; white paper.
    let counts = [
        ("a &lt; b", 1),
        ("not there", 0),
        ("ode_solvers", 1),
        (subscript, 2),
        ("stroke-dasharray", 3),
        ("<title>Loads</title>", 1),
        ("width=\"400\" height=\"600\"", 1),
        ("height=\"6000\" fill=\"#FFFFFF\"", 1),
    ];
    for (text, count) in counts {
        assert_eq!(svg.matches(text).count(), count, "{text}\n{svg}");
    }
}

#[test]
fn lines_stay_in_the_frame_and_points_outside_are_left_out() {
    let wild = [(0.0, 0.0), (0.5, 1e300), (0.6, f64::NAN), (1.0, -1e300), (1.0, 0.5)];
    let line = Panel::new("x", "y").line("", Colour::Blue, wild).points("", Colour::Blue, wild);
    let svg = svg(&Figure::new(300, 300).panel(line.y_range(0.0..=1.0))).unwrap();
    assert_eq!(svg.matches("<circle").count(), 2);
    for points in svg.split("points=\"").skip(1).filter_map(|rest| rest.split('"').next()) {
        for number in points.split([' ', ',']).filter(|number| !number.is_empty()) {
            assert!((0..=3000).contains(&number.parse::<i32>().unwrap()), "{points}");
        }
    }
}

#[test]
fn what_cannot_be_drawn_is_told() {
    let refusal = |figure: Figure| svg(&figure).unwrap_err().to_string();
    let range =
        refusal(Figure::new(400, 300).panel(panel()).panel(panel().log_y().y_range(0.0..=1.0)));
    assert_eq!(range, "panel 2: y axis from 0 to 1: a logarithmic axis starts above zero");
    let small = refusal(Figure::new(100, 100).panel(panel()));
    assert!(small.ends_with("px are left for the plot; enlarge it"), "{small}");
    let nothing =
        Panel::new("x (m)", "y (m)").log_x().line("", Colour::Blue, [(f64::NAN, 1.0), (-1.0, 1.0)]);
    assert!(svg(&Figure::new(400, 300).panel(nothing)).unwrap().contains("no data"));
    svg(&Figure::new(400, 300)).unwrap();
}

#[test]
fn a_heat_map_has_a_bar_and_leaves_nan_white() {
    let map =
        |value: f64| HeatMap::new("z (mm)", [0.0, 1.0], [0.0, 1.0], move |i, _| value * i as f64);
    let ground = |value| Panel::new("t (s)", "place ξ (–)").heat_map(map(value));
    let tiles = |value| {
        let svg = svg(&Figure::new(500, 300).panel(ground(value))).unwrap();
        assert_eq!(svg.matches("z (mm)").count(), 1);
        svg.matches("<rect").count()
    };
    assert_eq!(tiles(2.0) - tiles(f64::NAN), 4);
}

#[test]
fn ticks_are_round_and_their_labels_short() {
    use super::axis::Axis;
    let labels = |from: f64, to: f64, logarithmic| {
        Axis::fixed(&(from..=to), logarithmic).unwrap().with_ticks(5).labels().join(" ")
    };
    assert_eq!(labels(0.0, 1.0, false), "0.0 0.5 1.0");
    assert_eq!(labels(0.0, 0.9, false), "0.0 0.2 0.4 0.6 0.8");
    assert_eq!(labels(-1.0, 1.0, false), "−1.0 −0.5 0.0 0.5 1.0");
    assert_eq!(labels(0.1, 100.0, true), "10⁻¹ 10⁰ 10¹ 10²");
    assert_eq!(labels(10.0, 50.0, true), "10 20 50");
    assert_eq!(labels(1e-12, 1.0, true), "10⁻¹² 10⁻⁹ 10⁻⁶ 10⁻³ 10⁰");
    assert_eq!(labels(0.0, 2e-7, false), "0 0.5·10⁻⁷ 1·10⁻⁷ 1.5·10⁻⁷ 2·10⁻⁷");
}
