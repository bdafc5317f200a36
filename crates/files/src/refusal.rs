//! Why a file is refused, and where.

use std::fmt;

use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue, ValueDeserializer};

use crate::setup::Setup;

/// Why a file is refused, or its run. It prints as `:line:column: message`, for behind a file name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// Line and column from 1, if they are known.
    pub place: Option<(usize, usize)>,
    /// Parameter, value and rule, or why the run stopped.
    pub message: String,
}

impl std::error::Error for Refusal {}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            Some((line, column)) => write!(f, ":{line}:{column}: {}", self.message),
            None => write!(f, ": {}", self.message),
        }
    }
}

/// A value of a file, with its place.
type Node<'i> = Spanned<DeValue<'i>>;

/// Whether a key is that of a signal or an input, of which a plain number is a constant one.
fn is_signal(key: &str) -> bool {
    const SIGNALS: &str = "anchor brake_load current external force lateral_velocity opening \
                           reference rolling_speed slip_velocity torque twist velocity voltage";
    SIGNALS.split(' ').any(|signal| signal == key)
}

/// Reads a file.
///
/// # Errors
///
/// Text that is no TOML, keys and choices that do not exist, and parameters that a constructor
/// refuses, with the place in the file.
pub fn read(text: &str) -> Result<Setup, Refusal> {
    let plainly = |error: &toml::de::Error| {
        Refusal::at(text, error.span().map(|span| span.start), error.message().to_owned())
    };
    let document = document(text).map_err(|error| plainly(&error))?;
    let mut setup = Setup::deserialize(ValueDeserializer::from(document.clone()))
        .map_err(|error| found(text, &document, &error).unwrap_or_else(|| plainly(&error)))?;
    setup.text = text.to_owned();
    Ok(setup)
}

impl Refusal {
    fn at(text: &str, start: Option<usize>, message: String) -> Self {
        let place = start.and_then(|start| {
            let before = text.get(..start)?;
            let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
            Some((before.matches('\n').count() + 1, column))
        });
        Self { place, message }
    }

    /// Of a run: the place is that of the parameter which the message names with its value, else
    /// that of the scene.
    pub(crate) fn of_run(text: &str, message: String) -> Self {
        let found = document(text)
            .ok()
            .and_then(|document| parameter(text, entries(&[], 0, &document).iter(), &message));
        let scene = || text.find("[scene").or_else(|| text.find("scene")).unwrap_or(0);
        Self::at(text, Some(found.unwrap_or_else(scene)), message)
    }
}

/// A file in which every signal is a table.
fn document(text: &str) -> Result<Node<'_>, toml::de::Error> {
    let table = DeTable::parse(text)?;
    let mut document = Spanned::new(table.span(), DeValue::Table(table.into_inner()));
    constants(&mut document, false);
    Ok(document)
}

/// Turns plain numbers that stand for signals into constant signals.
fn constants(value: &mut Node, signal: bool) {
    let span = value.span();
    match value.get_mut() {
        DeValue::Table(table) => {
            for (key, value) in table.iter_mut() {
                constants(value, is_signal(key.get_ref()));
            }
        }
        DeValue::Array(list) => list.iter_mut().for_each(|value| constants(value, signal)),
        number @ (DeValue::Integer(_) | DeValue::Float(_)) if signal => {
            let key = Spanned::new(span.clone(), "constant".into());
            let constant = Spanned::new(span, number.clone());
            *number = DeValue::Table([(key, constant)].into_iter().collect());
        }
        _ => {}
    }
}

/// Where a file is wrong and why, better than the format knows.
///
/// It knows where a table or a list begins in which a parameter was refused. The parameter is the
/// first key behind it with the name, the index and the value of the error.
fn found(text: &str, document: &Node, error: &toml::de::Error) -> Option<Refusal> {
    let (span, message) = (error.span()?, error.message());
    let entries = entries(&[], 0, document);
    let behind = entries.iter().filter(|entry| entry.value.span().end > span.start);
    let (start, message) = choice(document, &entries, error)
        .or_else(|| wrong_type(text, document, &entries, error))
        .or_else(|| Some((parameter(text, behind, message)?, message.to_owned())))?;
    Some(Refusal::at(text, Some(start), message))
}

/// A value of a file: of a key, or an element of a list.
struct Entry<'t, 'i> {
    /// The keys and the indices that lead to it, its own last.
    path: Vec<String>,
    /// Where its key stands; where an element begins.
    start: usize,
    value: &'t Node<'i>,
}

/// Every value of a file.
fn entries<'t, 'i>(path: &[String], start: usize, value: &'t Node<'i>) -> Vec<Entry<'t, 'i>> {
    let mut found = vec![Entry { path: path.to_vec(), start, value }];
    let mut add = |key: String, start, value| {
        found.extend(entries(&[path, &[key]].concat(), start, value));
    };
    match value.get_ref() {
        DeValue::Table(table) => table
            .iter()
            .for_each(|(key, value)| add(key.get_ref().to_string(), key.span().start, value)),
        DeValue::Array(list) => list
            .iter()
            .enumerate()
            .for_each(|(index, value)| add(index.to_string(), value.span().start, value)),
        _ => {}
    }
    found
}

impl Entry<'_, '_> {
    /// Its key, or that of the list in which it is an element.
    fn key(&self) -> &str {
        let keys = self.path.iter().rev();
        keys.map(String::as_str).find(|key| key.parse::<usize>().is_err()).unwrap_or("")
    }

    /// The index in the innermost list around it, or its own.
    fn index(&self) -> Option<usize> {
        self.path.iter().rev().find_map(|key| key.parse().ok())
    }

    fn is_element(&self) -> bool {
        self.path.last().is_some_and(|key| key.parse::<usize>().is_ok())
    }
}

/// Where the key stands which a message "name[index] is value, but must …" speaks of: with this
/// index and value, else with the value alone, else with a table or a list as its value. Else the
/// row of this index in a list of lists.
fn parameter<'e, 't: 'e, 'i: 't>(
    text: &str,
    entries: impl Iterator<Item = &'e Entry<'t, 'i>>,
    message: &str,
) -> Option<usize> {
    let (name, rest) = message.split_once(" is ")?;
    let value = rest.split_once(", but must").map(|parts| parts.0);
    let index = name.split_once('[').and_then(|(_, index)| index.strip_suffix(']')?.parse().ok());
    let name = name.split('[').next()?.rsplit('.').next()?;
    let number = |text: &str| text.replace('_', "").parse::<f64>().map(|number| number.to_string());
    let given = |at: &Node| {
        let given = text.get(at.span()).unwrap_or("").trim_matches(['"', '\'']);
        value.is_some_and(|value| {
            given == value || number(given).is_ok_and(|given| Ok(given) == number(value))
        })
    };
    let rank = |entry: &Entry| {
        let (is_list, has_parts, given) = match entry.value.get_ref() {
            DeValue::Array(list) => (true, true, list.iter().any(given)),
            other => (false, other.is_table(), given(entry.value)),
        };
        let (named, here) = (entry.key() == name, index.is_some() && entry.index() == index);
        match entry.is_element() {
            false if named && given && here => Some(0),
            true if named && given && here => Some(1),
            false if named && given => Some(2),
            false if named && has_parts => Some(3),
            true if here && is_list => Some(4),
            _ => None,
        }
    };
    entries.filter_map(|entry| Some((rank(entry)?, entry.start))).min().map(|found| found.1)
}

/// Where a value is of another type than it must be, and what it must be.
fn wrong_type(
    text: &str,
    document: &Node,
    entries: &[Entry],
    error: &toml::de::Error,
) -> Option<(usize, String)> {
    let (span, message) = (error.span()?, error.message());
    let within = |entry: &&Entry| {
        let around = entry.value.span();
        around.start <= span.start && span.end <= around.end
    };
    let entry = entries.iter().filter(within).min_by_key(|entry| entry.value.span().len())?;
    let is_signal = is_signal(entry.key());
    let wanted = match message.rsplit_once(", expected ").map_or(message, |parts| parts.1) {
        "newtype variant" if !is_signal => "a table of this name with its keys".into(),
        "newtype variant" | "wanted string or table" => {
            let number = if is_signal { "a number or " } else { "" };
            format!("{number}{}", choices(document, &entry.path)?)
        }
        "usize" | "u64" => "a whole number, zero or positive".into(),
        "u16" => "a whole number from 0 to 65535".into(),
        "f64" => "a number".into(),
        "a sequence" => "a list".into(),
        wanted if wanted.starts_with("struct ") => "a table with its keys".into(),
        wanted if wanted.starts_with("an array of length ") => {
            wanted.replace("an array of length", "a list of")
        }
        wanted if message.starts_with("invalid type") => wanted.into(),
        _ => return None,
    };
    let given = text.get(span.clone())?.lines().next().unwrap_or("");
    Some((span.start, format!("{} is {given}, but must be {wanted}", entry.key())))
}

/// What is said of a file with a table of one entry at a place.
fn with(document: &Node, path: &[String], entry: (Spanned<DeString>, Node)) -> Option<String> {
    let mut whole = document.clone();
    let place = path.iter().try_fold(&mut whole, |value, key| match value.get_mut() {
        DeValue::Table(table) => table.get_mut(key.as_str()),
        DeValue::Array(list) => list.get_mut(key.parse::<usize>().ok()?),
        _ => None,
    })?;
    *place.get_mut() = DeValue::Table([entry].into_iter().collect());
    Some(Setup::deserialize(ValueDeserializer::from(whole)).err()?.message().to_owned())
}

/// What may be chosen at a place.
fn choices(document: &Node, path: &[String]) -> Option<String> {
    let value = Spanned::new(0..0, DeValue::Boolean(true));
    let why = with(document, path, (Spanned::new(0..0, "?".into()), value))?;
    Some(why.strip_prefix("unknown variant `?`, expected ")?.to_owned())
}

/// Where a choice has several entries or none, such as two models, and what to write.
fn choice(document: &Node, entries: &[Entry], error: &toml::de::Error) -> Option<(usize, String)> {
    let span = error.span().filter(|_| error.message().starts_with("wanted exactly 1 element"))?;
    let (path, table) = entries.iter().find_map(|entry| match entry.value.get_ref() {
        DeValue::Table(table) if entry.value.span() == span && table.len() != 1 => {
            Some((&entry.path, table))
        }
        _ => None,
    })?;
    // With one entry alone the error names all choices if that is none.
    for (key, value) in table {
        let why = with(document, path, (key.clone(), value.clone()));
        if let Some(why) = why.filter(|why| why.starts_with("unknown variant")) {
            return Some((key.span().start, why));
        }
    }
    let name = path.join(".");
    let Some(last) = table.keys().map(|key| key.span().start).max() else {
        let wanted = choices(document, path)?;
        return Some((span.start, format!("{name} is empty, expected {wanted}")));
    };
    let keys: Vec<&str> = table.keys().map(|key| key.get_ref().as_ref()).collect();
    let (count, keys) = (keys.len(), keys.join(" and "));
    Some((last, format!("{name} has {count} entries, {keys}, but must have one")))
}
