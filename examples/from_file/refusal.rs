//! Why a file of the example `from_file` is refused, and where.

use std::fmt;

use serde::Deserialize;
use toml::de::{DeTable, DeValue};

use crate::setup::Setup;

/// What is wrong with a file: line and column from 1 if they are known, and the reason.
#[derive(Debug)]
pub(crate) struct Refusal {
    pub(crate) place: Option<(usize, usize)>,
    pub(crate) message: String,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            Some((line, column)) => write!(f, ":{line}:{column}: {}", self.message),
            None => write!(f, ": {}", self.message),
        }
    }
}

impl Refusal {
    /// Of a run: the place is that of the parameter which the message names with its value, else
    /// that of the scene.
    pub(crate) fn of_run(text: &str, message: String) -> Self {
        let scene = || text.find("[scene").or_else(|| text.find("scene")).unwrap_or(0);
        let start = parameter(text, &message).unwrap_or_else(scene);
        Self { place: line_and_column(text, start), message }
    }

    /// Of a text.
    ///
    /// A format knows where a table or a list begins in which a parameter was refused. The
    /// parameter is the first key behind it with the name and the value of the error.
    fn of_text(text: &str, error: &toml::de::Error) -> Self {
        let Some(span) = error.span() else {
            return Self { place: None, message: error.message().to_owned() };
        };
        let (start, message) = choice(text, error).unwrap_or_else(|| {
            let behind = text.get(span.start..).unwrap_or("");
            let further = parameter(behind, error.message()).unwrap_or(0);
            (span.start + further, error.message().to_owned())
        });
        Self { place: line_and_column(text, start), message }
    }
}

/// Reads a file.
pub(crate) fn read(text: &str) -> Result<Setup, Refusal> {
    toml::from_str(text).map_err(|error| Refusal::of_text(text, &error))
}

fn line_and_column(text: &str, start: usize) -> Option<(usize, usize)> {
    let before = text.get(..start)?;
    let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
    Some((before.matches('\n').count() + 1, column))
}

/// Where the key stands which a message "name is value, but must …" speaks of.
fn parameter(text: &str, message: &str) -> Option<usize> {
    let (name, rest) = message.split_once(" is ")?;
    let name = name.split('[').next()?.rsplit('.').next().filter(|name| !name.contains(' '))?;
    let value = rest.split_once(", but must")?.0;
    let number = |text: &str| text.parse::<f64>().map(|number| number.to_string());
    text.match_indices(name).map(|found| found.0).find(|&at| {
        let whole = text
            .get(..at)
            .is_some_and(|before| !before.ends_with(|c: char| c.is_alphanumeric() || c == '_'));
        let given = text.get(at + name.len()..).unwrap_or("").trim_start();
        let given = given.strip_prefix('=').unwrap_or("").trim_start();
        let given = given.split([',', '}', ' ', '\n']).next().unwrap_or("").trim_matches('"');
        whole && (given == value || number(given).is_ok_and(|given| Ok(given) == number(value)))
    })
}

/// Where a choice has several entries or none, such as two models, and what to write.
fn choice(text: &str, error: &toml::de::Error) -> Option<(usize, String)> {
    if !error.message().starts_with("wanted exactly 1 element") {
        return None;
    }
    let span = error.span()?;
    let document = DeTable::parse(text).ok()?;
    let mut path = Vec::new();
    let table = find(document.get_ref(), &span, &mut path)?;
    let entries: Vec<&str> = table.keys().map(|key| key.get_ref().as_ref()).collect();
    // With one entry alone the error says whether it is a choice, and names all choices.
    let alone = |entry: &str| {
        let mut whole = toml::Value::Table(text.parse().ok()?);
        let place = path.iter().try_fold(&mut whole, |value, key| match value {
            toml::Value::Table(table) => table.get_mut(key),
            toml::Value::Array(list) => list.get_mut(key.parse::<usize>().ok()?),
            _ => None,
        })?;
        let kept = place.get(entry).cloned().unwrap_or(toml::Value::Boolean(true));
        *place = toml::Value::Table([(entry.to_owned(), kept)].into_iter().collect());
        let why = Setup::deserialize(whole).err()?.message().to_owned();
        why.starts_with("unknown variant").then_some(why)
    };
    let path_name = path.join(".");
    if entries.is_empty() {
        let choices = alone("?").and_then(|why| Some(why.split_once(", ")?.1.to_owned()));
        let choices = choices.unwrap_or_else(|| "expected one entry".into());
        return Some((span.start, format!("{path_name} is empty, {choices}")));
    }
    for key in table.keys() {
        if let Some(why) = alone(key.get_ref()) {
            return Some((key.span().start, why));
        }
    }
    let last = table.keys().map(|key| key.span().start).max()?;
    let (count, entries) = (entries.len(), entries.join(" and "));
    Some((last, format!("{path_name} has {count} entries, {entries}, but must have one")))
}

/// The table that is no choice of one, and the keys that lead there.
fn find<'t, 'i>(
    table: &'t DeTable<'i>,
    span: &std::ops::Range<usize>,
    path: &mut Vec<String>,
) -> Option<&'t DeTable<'i>> {
    table.iter().find_map(|(key, value)| {
        path.push(key.get_ref().to_string());
        let found = inside(value, span, path);
        if found.is_none() {
            path.pop();
        }
        found
    })
}

fn inside<'t, 'i>(
    value: &'t toml::Spanned<DeValue<'i>>,
    span: &std::ops::Range<usize>,
    path: &mut Vec<String>,
) -> Option<&'t DeTable<'i>> {
    match value.get_ref() {
        DeValue::Table(table) if value.span() == *span && table.len() != 1 => Some(table),
        DeValue::Table(table) => find(table, span, path),
        DeValue::Array(list) => list.iter().enumerate().find_map(|(index, value)| {
            path.push(index.to_string());
            let found = inside(value, span, path);
            if found.is_none() {
                path.pop();
            }
            found
        }),
        _ => None,
    }
}
