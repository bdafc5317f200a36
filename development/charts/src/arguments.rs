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
    kind: Kind,
    /// What was given, or the default; of the right kind and obeying the rule.
    value: String,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Number,
    Count,
    Text,
    /// Any number of them, in lines of the value.
    Files,
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
    fn accepts(&self, text: &str) -> bool {
        let number = match self.kind {
            Kind::Number => text.parse().ok(),
            Kind::Count => text.parse::<usize>().ok().map(|count| count as f64),
            Kind::Text | Kind::Files => return true,
        };
        number.is_some_and(|number| self.rule.allows(number))
    }

    /// `a number, positive`.
    fn rule(&self) -> String {
        match (self.kind, self.rule) {
            (Kind::Text, _) => "a text".to_owned(),
            (Kind::Files, _) => "one file or several".to_owned(),
            (Kind::Count, Rule::Finite) => "a whole number".to_owned(),
            (Kind::Count, rule) => format!("a whole number, {rule}"),
            (Kind::Number, rule) => format!("a number, {rule}"),
        }
    }

    /// The line of `--help`.
    fn usage(&self) -> (String, String) {
        let Opt { name, unit, help, rule, kind, value } = self;
        let kind = format!("{kind:?}").to_uppercase();
        let unit = if unit.is_empty() { String::new() } else { format!(" / {unit}") };
        let rule = if *rule == Rule::Finite { String::new() } else { format!(", {rule}") };
        (format!("--{name} {kind}"), format!("{help}{unit}{rule} [default: {value}]"))
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
        self.with(Kind::Number, name, unit, help, shortest(default))
    }

    /// Declares `--name COUNT`, a whole number.
    pub fn count(self, name: &'static str, default: usize, help: &'static str) -> Arguments {
        self.with(Kind::Count, name, "", help, default.to_string())
    }

    /// Declares `--name TEXT`.
    pub fn text(self, name: &'static str, default: &str, help: &'static str) -> Arguments {
        self.with(Kind::Text, name, "", help, default.to_owned())
    }

    /// Declares `--name FILE FILE …`; see [`Values::files`].
    pub fn files(self, name: &'static str, help: &'static str) -> Arguments {
        self.with(Kind::Files, name, "", help, String::new())
    }

    fn with(
        mut self,
        kind: Kind,
        name: &'static str,
        unit: &'static str,
        help: &'static str,
        value: String,
    ) -> Arguments {
        self.options.push(Opt { name, unit, help, rule: Rule::Finite, kind, value });
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
        let (mut file, mut given) = (None, Vec::new());
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
                Some(option) if option.kind == Kind::Files => {
                    let mut files = vec![value.ok_or_else(missing)?];
                    while let Some(next) = words.next_if(|next| !next.starts_with("--")) {
                        files.push(next);
                    }
                    option.value.extend(files.iter().map(|file| format!("{file}\n")));
                }
                Some(option) if given.contains(&option.name) => {
                    return Err(misuse(format!("{name} is given twice")).into());
                }
                Some(option) => {
                    given.push(option.name);
                    option.value = value.ok_or_else(missing)?;
                    if !option.accepts(&option.value) {
                        let given = &option.value;
                        let text = format!("{name} must be {rule}, but {given:?} was given");
                        return Err(misuse(text).into());
                    }
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
        self.text(name).parse().unwrap_or_else(|_| undeclared(name))
    }

    /// The value of a declared count.
    pub fn count(&self, name: &str) -> usize {
        self.text(name).parse().unwrap_or_else(|_| undeclared(name))
    }

    /// The value of a declared text.
    pub fn text(&self, name: &str) -> &str {
        let option = self.options.iter().find(|option| option.name == name);
        option.map_or_else(|| undeclared(name), |option| &option.value)
    }

    /// The files of an option, in their order.
    pub fn files(&self, name: &str) -> Vec<&Path> {
        self.text(name).lines().map(Path::new).collect()
    }

    /// The file given, if the example takes one.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// The folder for figures and tables; it exists.
    pub fn out_dir(&self) -> &Path {
        &self.out_dir
    }
}

#[expect(clippy::panic, reason = "a misspelt name in the example; no command line leads here")]
fn undeclared<T>(name: &str) -> T {
    panic!("the example declares no option of this kind named {name:?}")
}
