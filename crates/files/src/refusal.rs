//! Why a file of the example `from_file` is refused, and where.

use std::fmt;

use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use crate::setup::Setup;

/// What is wrong with a file: line and column from 1 if they are known, and the reason.
#[derive(Debug)]
pub struct Refusal {
    pub place: Option<(usize, usize)>,
    pub message: String,
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
    pub fn of_run(text: &str, message: String) -> Self {
        let scene = || text.find("[scene").or_else(|| text.find("scene")).unwrap_or(0);
        let document = DeTable::parse(text).ok();
        let found = document
            .as_ref()
            .and_then(|document| parameter(text, &entries(document.get_ref()), &message));
        Self { place: line_and_column(text, found.unwrap_or_else(scene)), message }
    }

    /// Of a text.
    ///
    /// A format knows where a table or a list begins in which a parameter was refused. The
    /// parameter is the first key behind it with the name, the index and the value of the error.
    fn of_text(text: &str, error: &toml::de::Error) -> Self {
        let message = error.message().to_owned();
        let Some(span) = error.span() else { return Self { place: None, message } };
        let told = DeTable::parse(text).ok().and_then(|document| {
            let entries = entries(document.get_ref());
            let behind: Vec<Entry> = entries
                .iter()
                .filter(|entry| entry.value.span().end > span.start)
                .cloned()
                .collect();
            choice(text, &entries, error)
                .or_else(|| wrong_type(text, &entries, error))
                .or_else(|| Some((parameter(text, &behind, &message)?, message.clone())))
                .or_else(|| Some((row(&behind, &message)?, message.clone())))
        });
        let (start, message) = told.unwrap_or((span.start, message));
        Self { place: line_and_column(text, start), message }
    }
}

/// Reads a file.
pub fn read(text: &str) -> Result<Setup, Refusal> {
    toml::from_str(text).map_err(|error| Refusal::of_text(text, &error))
}

fn line_and_column(text: &str, start: usize) -> Option<(usize, usize)> {
    let before = text.get(..start)?;
    let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
    Some((before.matches('\n').count() + 1, column))
}

/// A value of a file: of a key, or an element of a list.
#[derive(Debug, Clone)]
struct Entry<'t, 'i> {
    /// The keys and the indices that lead to it, its own last.
    path: Vec<String>,
    /// Where its key stands; where an element begins.
    start: usize,
    value: &'t Spanned<DeValue<'i>>,
}

/// Every value of a file, in the order of the text.
fn entries<'t, 'i>(document: &'t DeTable<'i>) -> Vec<Entry<'t, 'i>> {
    fn of_table<'t, 'i>(table: &'t DeTable<'i>, path: &[String], found: &mut Vec<Entry<'t, 'i>>) {
        for (key, value) in table {
            of_value(value, [path, &[key.get_ref().to_string()]].concat(), key.span().start, found);
        }
    }
    fn of_value<'t, 'i>(
        value: &'t Spanned<DeValue<'i>>,
        path: Vec<String>,
        start: usize,
        found: &mut Vec<Entry<'t, 'i>>,
    ) {
        found.push(Entry { path: path.clone(), start, value });
        match value.get_ref() {
            DeValue::Table(table) => of_table(table, &path, found),
            DeValue::Array(list) => list.iter().enumerate().for_each(|(index, value)| {
                let path = [path.as_slice(), &[index.to_string()]].concat();
                of_value(value, path, value.span().start, found);
            }),
            _ => {}
        }
    }
    let mut found = Vec::new();
    of_table(document, &[], &mut found);
    found.sort_by_key(|entry| entry.start);
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

    fn list(&self) -> Option<&DeArray<'_>> {
        match self.value.get_ref() {
            DeValue::Array(list) => Some(list),
            _ => None,
        }
    }
}

/// Name and index of "name[index] is …".
fn name(message: &str) -> Option<(&str, Option<usize>)> {
    let name = message.split_once(" is ")?.0;
    let index = name.split_once('[').and_then(|(_, index)| index.strip_suffix(']')?.parse().ok());
    let name = name.split('[').next()?.rsplit('.').next()?;
    (!name.contains(' ')).then_some((name, index))
}

/// Where the key stands which a message "name[index] is value, but must …" speaks of: with this
/// index and value, else with the value alone, else with a table or a list as its value.
fn parameter(text: &str, entries: &[Entry], message: &str) -> Option<usize> {
    let (name, index) = name(message)?;
    let value = message.split_once(" is ")?.1.split_once(", but must")?.0;
    let number = |text: &str| text.replace('_', "").parse::<f64>().map(|number| number.to_string());
    let given = |at: &Spanned<DeValue>| {
        let given = text.get(at.span()).unwrap_or("").trim_matches(['"', '\'']);
        given == value || number(given).is_ok_and(|given| Ok(given) == number(value))
    };
    let any = |entry: &Entry| {
        given(entry.value) || entry.list().is_some_and(|list| list.iter().any(given))
    };
    let of_name = |elements: bool| {
        entries.iter().filter(move |entry| entry.key() == name && entry.is_element() == elements)
    };
    let at_index = |entry: &&Entry| index.is_some() && entry.index() == index && any(entry);
    let deep =
        |entry: &&Entry| matches!(entry.value.get_ref(), DeValue::Array(_) | DeValue::Table(_));
    let found = of_name(false).find(at_index).or_else(|| of_name(true).find(at_index));
    let found = found.or_else(|| of_name(false).find(|entry| any(entry)));
    found.or_else(|| of_name(false).find(deep)).map(|entry| entry.start)
}

/// Where the row of a list of lists begins that a message "name[index] is …" speaks of.
fn row(entries: &[Entry], message: &str) -> Option<usize> {
    let index = name(message)?.1?;
    let list = entries.iter().find_map(|entry| entry.list().filter(|list| !list.is_empty()))?;
    list.get(index)
        .filter(|row| matches!(row.get_ref(), DeValue::Array(_)))
        .map(|row| row.span().start)
}

/// Where a value is of another type than it must be, and what it must be.
fn wrong_type(text: &str, entries: &[Entry], error: &toml::de::Error) -> Option<(usize, String)> {
    let (span, message) = (error.span()?, error.message());
    let within = |entry: &&Entry| {
        let around = entry.value.span();
        around.start <= span.start && span.end <= around.end
    };
    let entry = entries.iter().filter(within).min_by_key(|entry| entry.value.span().len())?;
    let wanted = match message.rsplit_once(", expected ") {
        _ if message == "wanted string or table" => choices(text, &entry.path)?,
        Some((_, "newtype variant")) => "a table of this name with its keys".into(),
        Some((_, "usize" | "u64")) => "a whole number, zero or positive".into(),
        Some((_, "u16")) => "a whole number from 0 to 65535".into(),
        Some((_, "f64")) => "a number".into(),
        Some((_, "a sequence")) => "a list".into(),
        Some((_, wanted)) if wanted.starts_with("struct ") => "a table with its keys".into(),
        Some((_, wanted)) if wanted.starts_with("an array of length ") => {
            wanted.replace("an array of length", "a list of")
        }
        Some((_, wanted)) if message.starts_with("invalid type") => wanted.into(),
        _ => return None,
    };
    let given = text.get(span.clone())?.lines().next().unwrap_or("");
    Some((span.start, format!("{} is {given}, but must be {wanted}", entry.key())))
}

/// What may be chosen at a place.
fn choices(text: &str, path: &[String]) -> Option<String> {
    let why = with(text, path, "?", toml::Value::Boolean(true))?;
    Some(why.strip_prefix("unknown variant `?`, expected ")?.to_owned())
}

/// What is said of a file with a table of one entry at a place.
fn with(text: &str, path: &[String], entry: &str, kept: toml::Value) -> Option<String> {
    let mut whole = toml::Value::Table(text.parse().ok()?);
    let place = path.iter().try_fold(&mut whole, |value, key| match value {
        toml::Value::Table(table) => table.get_mut(key),
        toml::Value::Array(list) => list.get_mut(key.parse::<usize>().ok()?),
        _ => None,
    })?;
    *place = toml::Value::Table([(entry.to_owned(), kept)].into_iter().collect());
    Some(Setup::deserialize(whole).err()?.message().to_owned())
}

/// Where a choice has several entries or none, such as two models, and what to write.
fn choice(text: &str, entries: &[Entry], error: &toml::de::Error) -> Option<(usize, String)> {
    let refused = ["wanted exactly 1 element", "invalid type: map, expected enum"];
    if !refused.iter().any(|refused| error.message().starts_with(refused)) {
        return None;
    }
    let span = error.span()?;
    let (path, table) = entries.iter().find_map(|entry| match entry.value.get_ref() {
        DeValue::Table(table) if entry.value.span() == span && table.len() != 1 => {
            Some((&entry.path, table))
        }
        _ => None,
    })?;
    let entries: Vec<&str> = table.keys().map(|key| key.get_ref().as_ref()).collect();
    // With one entry alone the error says whether it is a choice, and names all choices.
    let alone = |entry: &str| {
        let whole = toml::Value::Table(text.parse().ok()?);
        let place = path.iter().try_fold(&whole, |value, key| match value {
            toml::Value::Array(list) => list.get(key.parse::<usize>().ok()?),
            value => value.get(key),
        })?;
        let kept = place.get(entry).cloned().unwrap_or(toml::Value::Boolean(true));
        with(text, path, entry, kept).filter(|why| why.starts_with("unknown variant"))
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
