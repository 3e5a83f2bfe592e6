//! `path=value` from the command line: the value takes its place in the tree before anything is read from it, so it is
//! checked like any other, and what is wrong with it is shown in the override's own text.
//!
//! A path names fields, keys of maps, and entities by their names wherever they are nested: `materials.glass.ior`,
//! `entities.ball.at`. Values in parentheses or brackets are counted from 0 (`entities.0`), and `x`, `y` and `z` are the
//! first three. Names with periods stand in double quotes.

use crate::diagnostics::{Code, Diagnostic, nearest};
use crate::session::Session;
use crate::source::{Source, SourceId, Sources, Span};

use super::node::{Node, Value};
use super::parse::parse;

/// Puts values in their places, one after the other. Those that fail are reported and change nothing.
pub(crate) fn apply(root: &mut Node, overrides: &[(String, String)], session: &mut Session) {
    for (path, value) in overrides {
        session.digest.update(path.as_bytes());
        session.digest.update(value.as_bytes());
        let text = format!("{path}={value}");
        let source =
            Source { name: "--set".into(), folder: session.sources.get(root.span.source).folder.clone(), text };
        let Some(source) = session.sources.add(source) else { continue };
        if let Err(error) = apply_one(root, path.len(), source, session) {
            session.found.push(*error);
        }
    }
}

fn apply_one(root: &mut Node, path: usize, source: SourceId, session: &Session) -> Result<(), Box<Diagnostic>> {
    let sources = &session.sources;
    let value = parse(sources, source, path + 1, &session.limits)?;
    let segments = segments(sources, source, path)?;
    let [way @ .., last] = &segments[..] else { return Ok(()) };
    let mut node = root;
    for (depth, segment) in way.iter().enumerate() {
        if depth == 0 && sources.text(*segment) == "settings" {
            let empty = Value::Tuple { name: 0, items: [].into() };
            node = field(node, *segment, || Node { value: empty, span: *segment }, sources)
                .ok_or_else(|| lost(&segments, depth, &[], sources))?;
            continue;
        }
        let candidates = names_in(node, sources);
        node = step(node, plain(sources.text(*segment)), sources)
            .ok_or_else(|| lost(&segments, depth, &candidates, sources))?;
    }
    let candidates = names_in(node, sources);
    let target = match step(node, plain(sources.text(*last)), sources).is_some() {
        true => step(node, plain(sources.text(*last)), sources),
        false => field(node, *last, || value.clone(), sources),
    };
    let target = target.ok_or_else(|| lost(&segments, segments.len() - 1, &candidates, sources))?;
    *target = value;
    Ok(())
}

/// The places of the path's parts.
fn segments(sources: &Sources, source: SourceId, path: usize) -> Result<Vec<Span>, Box<Diagnostic>> {
    let text = &sources.get(source).text[..path];
    let mut segments = Vec::new();
    let (mut start, mut quoted) = (0, false);
    for (at, c) in text.char_indices().chain([(path, '.')]) {
        quoted ^= c == '"';
        if c == '.' && (!quoted || at == path) {
            let span = Span { source, start: start as u32, end: at as u32 };
            if plain(sources.text(span)).is_empty() || (quoted && at == path) {
                let error = sources.error(Code::Override, span, format!("`{text}` is no path"));
                return Err(error.expected("names between periods, such as materials.glass.ior").into());
            }
            segments.push(span);
            start = at + 1;
        }
    }
    Ok(segments)
}

/// A part without its quotes.
fn plain(segment: &str) -> &str {
    segment.strip_prefix('"').and_then(|inner| inner.strip_suffix('"')).unwrap_or(segment)
}

/// What a part of the path leads to.
fn step<'n>(node: &'n mut Node, name: &str, sources: &Sources) -> Option<&'n mut Node> {
    let index = name.parse::<usize>().ok().or_else(|| ["x", "y", "z"].iter().position(|axis| *axis == name));
    match &mut node.value {
        Value::Record { fields, .. } => {
            fields.iter_mut().find(|(field, _)| sources.text(*field) == name).map(|(_, value)| value)
        }
        Value::Map(entries) => entries.iter_mut().find(|(key, _)| is_text(key, name)).map(|(_, value)| value),
        Value::Tuple { items, .. } => items.get_mut(index?),
        Value::List(items) => match name.parse::<usize>() {
            Ok(index) => items.get_mut(index),
            Err(_) => entity(items, name, sources),
        },
        _ => None,
    }
}

/// The entity of that name in a list, or among the children of its entities.
fn entity<'n>(items: &'n mut [Node], name: &str, sources: &Sources) -> Option<&'n mut Node> {
    for item in items {
        let Value::Record { fields, .. } = &item.value else { continue };
        if fields.iter().any(|(field, value)| sources.text(*field) == "name" && is_text(value, name)) {
            return Some(item);
        }
        let Value::Record { fields, .. } = &mut item.value else { continue };
        for (field, value) in fields {
            if let ("children", Value::List(children)) = (sources.text(*field), &mut value.value)
                && let Some(found) = entity(children, name, sources)
            {
                return Some(found);
            }
        }
    }
    None
}

/// The field of a record, which is added if it is absent. Whether there may be such a field is found out on reading.
fn field<'n>(node: &'n mut Node, name: Span, absent: impl FnOnce() -> Node, sources: &Sources) -> Option<&'n mut Node> {
    let text = plain(sources.text(name));
    let (bytes, mut fields) = match &mut node.value {
        Value::Record { name, fields } => (*name, std::mem::take(fields).into_vec()),
        Value::Tuple { name, items } if items.is_empty() => (*name, Vec::new()),
        Value::Name => (node.span.end - node.span.start, Vec::new()),
        _ => return None,
    };
    if !fields.iter().any(|(field, _)| sources.text(*field) == text) {
        fields.push((name, absent()));
    }
    node.value = Value::Record { name: bytes, fields: fields.into() };
    let Value::Record { fields, .. } = &mut node.value else { return None };
    fields.iter_mut().find(|(field, _)| sources.text(*field) == text).map(|(_, value)| value)
}

fn is_text(node: &Node, text: &str) -> bool {
    matches!(&node.value, Value::Text(found) if **found == *text)
}

/// Everything that a next part could name, for messages.
fn names_in(node: &Node, sources: &Sources) -> Vec<String> {
    let mut names = Vec::new();
    match &node.value {
        Value::Record { fields, .. } => names.extend(fields.iter().map(|(field, _)| sources.text(*field).to_string())),
        Value::Map(entries) => {
            names.extend(entries.iter().filter_map(|(key, _)| match &key.value {
                Value::Text(text) => Some(text.to_string()),
                _ => None,
            }));
        }
        Value::List(items) => items.iter().for_each(|item| entity_names(item, sources, &mut names)),
        _ => {}
    }
    names
}

fn entity_names(node: &Node, sources: &Sources, names: &mut Vec<String>) {
    let Value::Record { fields, .. } = &node.value else { return };
    for (field, value) in fields {
        match (sources.text(*field), &value.value) {
            ("name", Value::Text(name)) => names.push(name.to_string()),
            ("children", Value::List(children)) => {
                children.iter().for_each(|child| entity_names(child, sources, names));
            }
            _ => {}
        }
    }
}

/// The error for a path that leads nowhere from its part `depth` on.
fn lost(segments: &[Span], depth: usize, candidates: &[String], sources: &Sources) -> Diagnostic {
    let text = |span: &Span| sources.text(*span).to_string();
    let before: Vec<String> = segments[..depth].iter().map(text).collect();
    let here = text(&segments[depth]);
    let place = if depth == 0 { "the scene".into() } else { format!("`{}`", before.join(".")) };
    let error = sources.error(Code::Override, segments[depth], format!("there is no `{here}` in {place}"));
    let names: Vec<&str> = candidates.iter().map(String::as_str).collect();
    let Some(near) = nearest(plain(&here), &names) else { return error.nearest_name(&here, names) };
    let quoted = if near.contains('.') { format!("\"{near}\"") } else { near.to_string() };
    let after = segments[depth + 1..].iter().map(text);
    let path: Vec<String> = before.into_iter().chain([quoted]).chain(after).collect();
    error.help(format!("did you mean `{}`?", path.join(".")))
}
