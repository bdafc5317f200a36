//! Command-line arguments: `--name value` or `--name=value`, with defaults and rules.

use std::fmt::{self, Display, Formatter};
use std::path::{Path, PathBuf};

use super::{Result, create_folder, shortest};

/// Where figures and tables go unless `--out` says otherwise.
const DEFAULT_OUT: &str = "target/figures";

/// The options of an example, and `--out DIR` and `--help` besides.
#[derive(Debug, Clone)]
#[must_use = "arguments are read by `parse`"]
pub struct Arguments {
    program: &'static str,
    about: &'static str,
    options: Vec<Opt>,
    takes_file: bool,
}

/// The values of all options, after [`Arguments::parse`].
#[derive(Debug, Clone)]
pub struct Values {
    options: Vec<Opt>,
    file: Option<PathBuf>,
    out_dir: PathBuf,
}

/// What a number must obey besides being finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rule {
    /// Nothing else.
    Finite,
    /// Greater than zero.
    Positive,
    /// At least this.
    AtLeast(f64),
    /// In this range, both ends included.
    Between(f64, f64),
}

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

/// Why the command line gives no values.
#[derive(Debug)]
pub(super) enum Unusable {
    /// Help was asked for; here it is.
    Help(String),
    /// A mistake, with the option and the rule.
    Misuse(String),
}

impl std::error::Error for Unusable {}

impl Display for Unusable {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (Unusable::Help(text) | Unusable::Misuse(text)) = self;
        f.write_str(text)
    }
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
    fn read(&self, text: &str) -> Option<Value> {
        match self.value {
            Value::Number(_) => {
                text.parse().ok().filter(|&x| self.rule.allows(x)).map(Value::Number)
            }
            Value::Count(_) => {
                let count = text.parse().ok();
                count.filter(|&n: &usize| self.rule.allows(n as f64)).map(Value::Count)
            }
            Value::Text(_) => Some(Value::Text(text.to_owned())),
        }
    }

    /// `a number, positive`.
    fn rule(&self) -> String {
        match (&self.value, self.rule) {
            (Value::Text(_), _) => "a text".to_owned(),
            (Value::Count(_), Rule::Finite) => "a whole number".to_owned(),
            (Value::Count(_), rule) => format!("a whole number, {rule}"),
            (Value::Number(_), rule) => format!("a number, {rule}"),
        }
    }

    /// The line of `--help`.
    fn usage(&self) -> (String, String) {
        let (kind, default) = match &self.value {
            Value::Number(number) => ("NUMBER", shortest(*number)),
            Value::Count(count) => ("COUNT", count.to_string()),
            Value::Text(text) => ("TEXT", text.clone()),
        };
        let mut text = self.help.to_owned();
        if !self.unit.is_empty() {
            text += &format!(" / {}", self.unit);
        }
        if self.rule != Rule::Finite {
            text += &format!(", {}", self.rule);
        }
        (format!("--{} {kind}", self.name), format!("{text} [default: {default}]"))
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
        self.with(name, unit, help, Value::Number(default))
    }

    /// Declares `--name COUNT`, a whole number.
    pub fn count(self, name: &'static str, default: usize, help: &'static str) -> Arguments {
        self.with(name, "", help, Value::Count(default))
    }

    /// Declares `--name TEXT`.
    pub fn text(self, name: &'static str, default: &str, help: &'static str) -> Arguments {
        self.with(name, "", help, Value::Text(default.to_owned()))
    }

    fn with(
        mut self,
        name: &'static str,
        unit: &'static str,
        help: &'static str,
        value: Value,
    ) -> Arguments {
        self.options.push(Opt { name, unit, help, rule: Rule::Finite, value });
        self
    }

    /// Takes a file: the one word that follows no option; see [`Values::file`].
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
    pub fn parse(self) -> Result<Values> {
        let words = std::env::args_os().skip(1);
        self.parse_from(words.map(|word| word.to_string_lossy().into_owned()))
    }

    pub(super) fn parse_from(mut self, words: impl IntoIterator<Item = String>) -> Result<Values> {
        let misuse = |text: String| Unusable::Misuse(text);
        let mut out_dir = PathBuf::from(DEFAULT_OUT);
        let mut file = None;
        let mut words = words.into_iter().peekable();
        while let Some(word) = words.next() {
            if self.takes_file && file.is_none() && !word.starts_with('-') {
                file = Some(PathBuf::from(word));
                continue;
            }
            let (name, attached) = match word.split_once('=') {
                Some((name, value)) => (name, Some(value.to_owned())),
                None => (word.as_str(), None),
            };
            match name {
                "--help" | "-h" => return Err(Unusable::Help(self.usage()).into()),
                "--bench" | "--test" => continue, // `cargo bench` and `cargo test` add these
                _ => {}
            }
            let known = name.strip_prefix("--").unwrap_or("");
            let option = self.options.iter_mut().find(|option| option.name == known);
            if option.is_none() && known != "out" {
                let known = self.known();
                return Err(misuse(format!("unknown option {name:?}; there are {known}")).into());
            }
            let value = attached.or_else(|| words.next_if(|next| !next.starts_with("--")));
            let rule = option.as_ref().map_or("a folder".to_owned(), |option| option.rule());
            let missing = || misuse(format!("{name} needs a value ({rule})"));
            match option {
                None => {
                    out_dir = value.filter(|folder| !folder.is_empty()).ok_or_else(missing)?.into();
                }
                Some(option) => {
                    let text = value.ok_or_else(missing)?;
                    option.value = option.read(&text).ok_or_else(|| {
                        misuse(format!("{name} must be {rule}, but {text:?} was given"))
                    })?;
                }
            }
        }
        create_folder(&out_dir).map_err(|error| misuse(format!("--out: {error}")))?;
        Ok(Values { options: self.options, file, out_dir })
    }

    fn known(&self) -> String {
        let names = self.options.iter().map(|option| option.name).chain(["out", "help"]);
        names.map(|name| format!("--{name}")).collect::<Vec<_>>().join(", ")
    }

    fn usage(&self) -> String {
        let mut rows: Vec<(String, String)> = self.options.iter().map(Opt::usage).collect();
        let out = format!("folder for figures and tables [default: {DEFAULT_OUT}]");
        rows.push(("--out DIR".to_owned(), out));
        rows.push(("--help".to_owned(), "this text".to_owned()));
        let width = rows.iter().map(|(left, _)| left.len()).max().unwrap_or(0);
        let file = if self.takes_file { " [FILE]" } else { "" };
        let head = format!("{}{file}: {}\n\nOptions:\n", self.program, self.about);
        rows.iter().fold(head, |text, (left, right)| format!("{text}  {left:width$}  {right}\n"))
    }
}

impl Values {
    /// The value of a declared number. Panics for a name that the example itself has misspelt, as
    /// do [`Values::count`] and [`Values::text`].
    pub fn number(&self, name: &str) -> f64 {
        match self.declared(name) {
            Value::Number(number) => *number,
            _ => undeclared(name),
        }
    }

    /// The value of a declared count.
    pub fn count(&self, name: &str) -> usize {
        match self.declared(name) {
            Value::Count(count) => *count,
            _ => undeclared(name),
        }
    }

    /// The value of a declared text.
    pub fn text(&self, name: &str) -> &str {
        match self.declared(name) {
            Value::Text(text) => text,
            _ => undeclared(name),
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

    fn declared(&self, name: &str) -> &Value {
        let option = self.options.iter().find(|option| option.name == name);
        option.map_or_else(|| undeclared(name), |option| &option.value)
    }
}

#[expect(clippy::panic, reason = "a misspelt name in the example; no command line leads here")]
fn undeclared(name: &str) -> ! {
    panic!("the example declares no option of this kind named {name:?}")
}
