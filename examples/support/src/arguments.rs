//! Command-line options, declared with their defaults.

use std::ffi::OsString;
use std::fmt::{self, Display, Formatter};
use std::path::{Path, PathBuf};

use crate::file::{FileError, create_folder};
use crate::number::shortest;

/// Where figures and tables go unless `--out` says otherwise; `target` is never under version control.
const DEFAULT_OUT: &str = "target/figures";

/// The options of an example: declare them, then [`parse`](Arguments::parse).
///
/// `--out DIR` (where figures and tables go) and `--help` always exist. A value follows its name (`--end 5`) or an equals
/// sign (`--end=5`); of an option given twice the last one counts.
#[derive(Debug, Clone)]
#[must_use = "options are read by `parse`"]
pub struct Arguments {
    program: &'static str,
    about: &'static str,
    options: Vec<Opt>,
    takes_file: bool,
}

/// One declared option, with its default value or, after parsing, the value given.
#[derive(Debug, Clone)]
struct Opt {
    name: &'static str,
    unit: &'static str,
    help: &'static str,
    rule: Rule,
    value: Value,
}

#[derive(Debug, Clone)]
enum Value {
    Number(f64),
    Count(usize),
    Text(String),
}

/// What a value must obey. Numbers must be finite in any case.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Rule {
    /// Any finite number.
    Finite,
    /// Greater than zero.
    Positive,
    /// Not less than this.
    AtLeast(f64),
    /// From the first to the second number, both included.
    Between(f64, f64),
}

/// The values of all options after parsing.
#[derive(Debug, Clone)]
pub struct Values {
    options: Vec<Opt>,
    file: Option<PathBuf>,
    out_dir: PathBuf,
}

/// A misused command line, or the call for help. [`run`](crate::run()) turns it into a line and an exit code.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ArgumentError {
    /// `--help` was given; this is the answer.
    #[error("{0}")]
    Help(String),
    /// No option of that name was declared.
    #[error("unknown option {given:?}; there are {known}")]
    Unknown {
        /// What was given.
        given: String,
        /// All options, separated by commas.
        known: String,
    },
    /// The command line ended, or the next option began, where a value was due.
    #[error("--{name} needs a value ({rule})")]
    Missing {
        /// The option.
        name: &'static str,
        /// What it takes.
        rule: String,
    },
    /// The value is not a number or breaks the rule of the option.
    #[error("--{name} must be {rule}, but {given:?} was given")]
    Refused {
        /// The option.
        name: &'static str,
        /// What was given.
        given: String,
        /// What it takes.
        rule: String,
    },
    /// The folder of `--out` cannot be used.
    #[error("--out: {0}")]
    Out(#[from] FileError),
}

impl Display for Rule {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match *self {
            Rule::Finite => write!(f, "finite"),
            Rule::Positive => write!(f, "positive"),
            Rule::AtLeast(low) => write!(f, "at least {}", shortest(low)),
            Rule::Between(low, high) => write!(f, "from {} to {}", shortest(low), shortest(high)),
        }
    }
}

impl Rule {
    fn allows(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Rule::Finite => true,
                Rule::Positive => value > 0.0,
                Rule::AtLeast(low) => value >= low,
                Rule::Between(low, high) => (low..=high).contains(&value),
            }
    }
}

impl Opt {
    /// Reads `text` as a value of the same kind as the default.
    fn read(&self, text: &str) -> Result<Value, ArgumentError> {
        let value = match self.value {
            Value::Number(_) => text.parse().ok().map(Value::Number),
            Value::Count(_) => text.parse().ok().map(Value::Count),
            Value::Text(_) => Some(Value::Text(text.to_owned())),
        };
        let allowed = |value: &Value| value.as_f64().is_none_or(|value| self.rule.allows(value));
        value.filter(allowed).ok_or_else(|| ArgumentError::Refused {
            name: self.name,
            given: text.to_owned(),
            rule: self.rule(),
        })
    }

    /// `a number, positive`.
    fn rule(&self) -> String {
        let kind = match self.value {
            Value::Number(_) => "a number",
            Value::Count(_) => "a whole number",
            Value::Text(_) => "a text",
        };
        match (&self.value, self.rule) {
            (Value::Count(_) | Value::Text(_), Rule::Finite) => kind.to_owned(),
            (_, rule) => format!("{kind}, {rule}"),
        }
    }
}

impl Value {
    fn as_f64(&self) -> Option<f64> {
        match self {
            Value::Number(number) => Some(*number),
            Value::Count(count) => Some(*count as f64),
            Value::Text(_) => None,
        }
    }
}

impl Arguments {
    /// An example without options of its own; `about` is one sentence for `--help`.
    pub fn new(program: &'static str, about: &'static str) -> Arguments {
        Arguments { program, about, options: Vec::new(), takes_file: false }
    }

    /// Declares `--name NUMBER`; `unit` may be empty.
    pub fn number(
        self,
        name: &'static str,
        default: f64,
        unit: &'static str,
        help: &'static str,
    ) -> Arguments {
        self.with(Opt { name, unit, help, rule: Rule::Finite, value: Value::Number(default) })
    }

    /// Declares `--name COUNT`, a whole number.
    pub fn count(self, name: &'static str, default: usize, help: &'static str) -> Arguments {
        self.with(Opt { name, unit: "", help, rule: Rule::Finite, value: Value::Count(default) })
    }

    /// Declares `--name TEXT`.
    pub fn text(self, name: &'static str, default: &str, help: &'static str) -> Arguments {
        let value = Value::Text(default.to_owned());
        self.with(Opt { name, unit: "", help, rule: Rule::Finite, value })
    }

    /// Takes a file, the one word without dashes that follows no option; see [`Values::file`].
    pub fn file(mut self) -> Arguments {
        self.takes_file = true;
        self
    }

    /// Sets the rule of the option declared last.
    pub fn must_be(mut self, rule: Rule) -> Arguments {
        if let Some(last) = self.options.last_mut() {
            last.rule = rule;
        }
        self
    }

    /// Reads the command line of this process and creates the folder of `--out`.
    pub fn parse(self) -> Result<Values, ArgumentError> {
        self.parse_from(std::env::args_os().skip(1))
    }

    fn with(mut self, option: Opt) -> Arguments {
        self.options.push(option);
        self
    }

    fn parse_from(
        mut self,
        words: impl IntoIterator<Item = OsString>,
    ) -> Result<Values, ArgumentError> {
        let mut out_dir = PathBuf::from(DEFAULT_OUT);
        let mut file = None;
        let mut words = words.into_iter().peekable();
        while let Some(word) = words.next() {
            if self.takes_file && file.is_none() && !word.to_string_lossy().starts_with('-') {
                file = Some(PathBuf::from(word));
                continue;
            }
            let word = word.to_string_lossy().into_owned();
            let (name, attached) = match word.split_once('=') {
                Some((name, value)) => (name, Some(OsString::from(value))),
                None => (word.as_str(), None),
            };
            match name {
                "--help" | "-h" => return Err(ArgumentError::Help(self.usage())),
                "--bench" | "--test" => continue, // `cargo bench` and `cargo test` add these on their own
                _ => {}
            }
            let mut value = || {
                attached
                    .clone()
                    .or_else(|| words.next_if(|next| !next.to_string_lossy().starts_with("--")))
            };
            if name == "--out" {
                let given = value().filter(|given| !given.is_empty());
                out_dir = given
                    .ok_or(ArgumentError::Missing { name: "out", rule: "a folder".to_owned() })?
                    .into();
                continue;
            }
            let declared = name
                .strip_prefix("--")
                .and_then(|name| self.options.iter_mut().find(|o| o.name == name));
            let Some(option) = declared else {
                return Err(ArgumentError::Unknown { given: name.to_owned(), known: self.known() });
            };
            let missing = || ArgumentError::Missing { name: option.name, rule: option.rule() };
            let text = value().ok_or_else(missing)?.to_string_lossy().into_owned();
            option.value = option.read(&text)?;
        }
        create_folder(&out_dir)?;
        Ok(Values { options: self.options, file, out_dir })
    }

    fn known(&self) -> String {
        let names = self.options.iter().map(|option| option.name).chain(["out", "help"]);
        names.map(|name| format!("--{name}")).collect::<Vec<_>>().join(", ")
    }

    fn usage(&self) -> String {
        let mut rows: Vec<(String, String)> = self
            .options
            .iter()
            .map(|option| {
                let (kind, default) = match &option.value {
                    Value::Number(number) => ("NUMBER", shortest(*number)),
                    Value::Count(count) => ("COUNT", count.to_string()),
                    Value::Text(text) => ("TEXT", text.clone()),
                };
                let unit = if option.unit.is_empty() {
                    String::new()
                } else {
                    format!(" / {}", option.unit)
                };
                let rule = if option.rule == Rule::Finite {
                    String::new()
                } else {
                    format!(", {}", option.rule)
                };
                let text = format!("{}{unit}{rule} [default: {default}]", option.help);
                (format!("--{} {kind}", option.name), text)
            })
            .collect();
        rows.push((
            "--out DIR".to_owned(),
            format!("folder for figures and tables [default: {DEFAULT_OUT}]"),
        ));
        rows.push(("--help".to_owned(), "this text".to_owned()));
        let width = rows.iter().map(|(left, _)| left.len()).max().unwrap_or(0);
        let file = if self.takes_file { " [FILE]" } else { "" };
        let head = format!("{}{file}: {}\n\nOptions:\n", self.program, self.about);
        rows.iter().fold(head, |text, (left, right)| format!("{text}  {left:width$}  {right}\n"))
    }
}

impl Values {
    /// The value of a declared number.
    ///
    /// # Panics
    /// If no number of that name was declared: a slip of the example, not of its user.
    pub fn number(&self, name: &str) -> f64 {
        match self.declared(name) {
            Some(Value::Number(number)) => *number,
            _ => undeclared("number", name),
        }
    }

    /// The value of a declared count.
    ///
    /// # Panics
    /// If no count of that name was declared: a slip of the example, not of its user.
    pub fn count(&self, name: &str) -> usize {
        match self.declared(name) {
            Some(Value::Count(count)) => *count,
            _ => undeclared("count", name),
        }
    }

    /// The value of a declared text.
    ///
    /// # Panics
    /// If no text of that name was declared: a slip of the example, not of its user.
    pub fn text(&self, name: &str) -> &str {
        match self.declared(name) {
            Some(Value::Text(text)) => text,
            _ => undeclared("text", name),
        }
    }

    /// The file given, if the example takes one.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// The folder for figures and tables; it exists.
    pub fn out_dir(&self) -> &Path {
        &self.out_dir
    }

    fn declared(&self, name: &str) -> Option<&Value> {
        self.options.iter().find(|option| option.name == name).map(|option| &option.value)
    }
}

#[expect(
    clippy::panic,
    reason = "a misspelt name in the example itself; no command line leads here"
)]
fn undeclared(kind: &str, name: &str) -> ! {
    panic!("the example declares no {kind} named {name:?}")
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    fn parse(words: &[&str]) -> Result<Values, String> {
        Arguments::new("test", "A test")
            .number("end", 60.0, "s", "end of the simulated time")
            .must_be(Rule::Positive)
            .number("offset", 0.0, "m", "where it starts")
            .count("samples", 11, "points of the curve")
            .must_be(Rule::AtLeast(2.0))
            .parse_from(words.iter().chain(&["--out", "/tmp"]).map(OsString::from))
            .map_err(|error| error.to_string())
    }

    #[test]
    fn defaults_hold_without_arguments() {
        let values = parse(&[]).unwrap();
        assert_eq!((values.number("end"), values.count("samples")), (60.0, 11));
        assert_eq!(values.out_dir(), Path::new("/tmp"));
    }

    #[test]
    fn values_follow_a_space_or_an_equals_sign_and_may_be_negative() {
        let values = parse(&["--end", "1e-3", "--samples=5", "--offset", "-2", "--bench"]).unwrap();
        assert_eq!(
            (values.number("end"), values.number("offset"), values.count("samples")),
            (1e-3, -2.0, 5)
        );
    }

    #[test]
    fn refusals_name_the_option_the_value_and_the_rule() {
        let refusal = |words: &[&str]| parse(words).unwrap_err();
        let number = "--end must be a number, positive, but";
        for given in ["NaN", "inf", "0", "-1", "ten", ""] {
            assert_eq!(refusal(&["--end", given]), format!("{number} {given:?} was given"));
        }
        assert_eq!(
            refusal(&["--samples=1"]),
            "--samples must be a whole number, at least 2, but \"1\" was given"
        );
        assert_eq!(
            refusal(&["--samples=2.5"]),
            "--samples must be a whole number, at least 2, but \"2.5\" was given"
        );
        assert_eq!(refusal(&["--end"]), "--end needs a value (a number, positive)");
        assert_eq!(refusal(&["--out="]), "--out needs a value (a folder)");
        let known = "there are --end, --offset, --samples, --out, --help";
        assert_eq!(refusal(&["--edn", "3"]), format!("unknown option \"--edn\"; {known}"));
        assert_eq!(refusal(&["end"]), format!("unknown option \"end\"; {known}"));
    }

    #[test]
    fn help_lists_every_option_with_unit_rule_and_default() {
        let usage = parse(&["--help"]).unwrap_err();
        assert!(
            usage
                .contains("--end NUMBER     end of the simulated time / s, positive [default: 60]"),
            "{usage}"
        );
        assert!(
            usage.contains("--samples COUNT  points of the curve, at least 2 [default: 11]"),
            "{usage}"
        );
        assert!(usage.contains("--out DIR"), "{usage}");
    }

    #[test]
    fn a_file_and_a_text_are_taken_where_they_are_declared() {
        let arguments = Arguments::new("test", "A test").text("columns", "t=1", "which").file();
        let words = ["--out", "/tmp", "data.csv", "--columns", "t=2"].map(OsString::from);
        let values = arguments.clone().parse_from(words).unwrap();
        assert_eq!((values.file(), values.text("columns")), (Some(Path::new("data.csv")), "t=2"));
        let values = arguments.clone().parse_from(["--out", "/tmp"].map(OsString::from)).unwrap();
        assert_eq!((values.file(), values.text("columns")), (None, "t=1"));
        let twice = arguments.parse_from(["a", "b"].map(OsString::from)).unwrap_err().to_string();
        assert!(twice.starts_with("unknown option \"b\""), "{twice}");
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_named() {
        let arguments = Arguments::new("test", "A test");
        let error =
            arguments.parse_from(["--out=/proc/nowhere/figures".into()]).unwrap_err().to_string();
        assert!(
            error.starts_with("--out: cannot create the folder /proc/nowhere/figures: "),
            "{error}"
        );
    }
}
