//! The names of a file's entities, and who is whose parent.

use std::collections::HashMap;

use crate::diagnostics::Code;
use crate::session::Session;
use crate::source::Span;

use super::schema::Entity;
use super::values::Spanned;

/// For every entity that names its parent, the parent's number. Entities are numbered each before its children.
///
/// Names that are given twice, parents that do not exist, and circles are reported.
pub(crate) fn parents(session: &mut Session, entities: &[Entity]) -> HashMap<u32, u32> {
    let mut rows = Vec::new();
    walk(entities, None, false, &mut rows);
    let known = known_names(session, &rows);
    let mut parents = HashMap::new();
    for (index, row) in rows.iter().enumerate() {
        if let Some(name) = &row.entity.parent
            && let Some(parent) = parent(session, &rows, &known, row, name)
        {
            parents.insert(index as u32, parent);
        }
    }
    report_circles(session, &rows, &parents);
    parents
}

/// An entity in its file.
struct Row<'e> {
    entity: &'e Entity,
    /// The entity whose child it is.
    above: Option<u32>,
    /// Whether an entity above it has instances.
    repeated: bool,
}

fn walk<'e>(entities: &'e [Entity], above: Option<u32>, repeated: bool, rows: &mut Vec<Row<'e>>) {
    for entity in entities {
        let index = rows.len() as u32;
        rows.push(Row { entity, above, repeated });
        walk(&entity.children, Some(index), repeated || entity.instances.is_some(), rows);
    }
}

fn known_names<'e>(session: &mut Session, rows: &[Row<'e>]) -> HashMap<&'e str, u32> {
    let mut known: HashMap<&str, u32> = HashMap::new();
    for (index, row) in rows.iter().enumerate() {
        let Some(name) = &row.entity.name else { continue };
        if let Some(first) = known.get(name.value.as_str()) {
            let first = rows[*first as usize].entity.name.as_ref().map_or(name.span, |first| first.span);
            let first = format!("first given at {}", session.sources.describe(first));
            let message = format!("two entities have the name {:?}", name.value);
            session.found.push(session.sources.error(Code::Duplicate, name.span, message).note(first));
        } else {
            known.insert(&name.value, index as u32);
        }
    }
    known
}

fn parent(
    session: &mut Session,
    rows: &[Row],
    known: &HashMap<&str, u32>,
    row: &Row,
    name: &Spanned<String>,
) -> Option<u32> {
    let (code, message) = match known.get(name.value.as_str()) {
        _ if row.above.is_some() => (Code::Conflict, "a child has a parent already".to_string()),
        Some(&parent) if rows[parent as usize].repeated => {
            (Code::Conflict, format!("{:?} is placed many times: which one is meant?", name.value))
        }
        Some(&parent) => return Some(parent),
        None => {
            let mut names: Vec<&str> = known.keys().copied().collect();
            names.sort_unstable();
            let message = format!("there is no entity {:?}", name.value);
            let error = session.sources.error(Code::UnknownName, name.span, message);
            session.found.push(error.expected("the name of an entity of this file").nearest_name(&name.value, names));
            return None;
        }
    };
    session.error(code, name.span, message);
    None
}

/// Reports entities that are their own ancestors, each circle once.
fn report_circles(session: &mut Session, rows: &[Row], parents: &HashMap<u32, u32>) {
    let up = |index: u32| parents.get(&index).copied().or(rows[index as usize].above);
    // The walk that first came to an entity. A walk that comes back to itself has found a circle.
    let mut seen_by: Vec<Option<u32>> = vec![None; rows.len()];
    for start in 0..rows.len() as u32 {
        let mut chain = Vec::new();
        let mut at = Some(start);
        while let Some(index) = at.filter(|&index| seen_by[index as usize].is_none()) {
            seen_by[index as usize] = Some(start);
            chain.push(index);
            at = up(index);
        }
        if let Some(from) = chain.iter().position(|&link| Some(link) == at) {
            report_circle(session, rows, parents, &chain[from..]);
        }
    }
}

fn report_circle(session: &mut Session, rows: &[Row], parents: &HashMap<u32, u32>, circle: &[u32]) {
    let Some(&named) = circle.iter().find(|index| parents.contains_key(index)) else { return };
    let name = |index: u32| match &rows[index as usize].entity.name {
        Some(name) => format!("{:?}", name.value),
        None => "an entity without a name".to_string(),
    };
    let chain: Vec<String> = circle
        .iter()
        .cycle()
        .skip_while(|&&index| index != named)
        .take(circle.len() + 1)
        .map(|&index| name(index))
        .collect();
    let error = session.sources.error(
        Code::Cycle,
        place(&rows[named as usize]),
        format!("{} is its own ancestor", name(named)),
    );
    session.found.push(error.note(format!("each is placed in the next one's space: {}", chain.join(" → "))));
}

/// Where an entity says who its parent is.
fn place(row: &Row) -> Span {
    row.entity.parent.as_ref().map_or(row.entity.span, |parent| parent.span)
}
