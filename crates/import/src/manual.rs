//! The reference part of the scene format's manual, written by the schema itself.

use std::fmt::Write;

use crate::diagnostics::Code;
use crate::ron::info::{FieldInfo, Form, Kind, TypeInfo};
use crate::ron::schema::Scene;
use crate::ron::schema::study::Study;

/// Every type of the format with all its fields, and every kind of diagnostic, as Markdown. The crate's `README.md` holds
/// this text; a test compares the two.
pub fn reference() -> String {
    let mut text = String::new();
    for info in types() {
        type_page(&mut text, info);
    }
    text += "## Diagnostics\n\n| code | meaning |\n| --- | --- |\n";
    for code in Code::ALL {
        line(&mut text, &[format!("`{}`", code.name()), code.meaning().to_string()]);
    }
    text
}

/// Every type of the study format with all its fields, as Markdown. The crate's `study.md` holds this text.
pub fn study_reference() -> String {
    let mut found = Vec::new();
    visit(Study::INFO, &mut found);
    let mut text = String::new();
    for info in found {
        type_page(&mut text, info);
    }
    text
}

/// All types of the format: each before those that its fields take.
fn types() -> Vec<&'static TypeInfo> {
    let mut found = Vec::new();
    visit(Scene::INFO, &mut found);
    found
}

fn visit(info: &'static TypeInfo, found: &mut Vec<&'static TypeInfo>) {
    if found.iter().any(|known: &&TypeInfo| known.name == info.name) {
        return;
    }
    found.push(info);
    for field in info.fields() {
        visit_kind(&(field.kind)(), found);
    }
}

fn visit_kind(kind: &Kind, found: &mut Vec<&'static TypeInfo>) {
    match kind {
        Kind::Plain(_) => {}
        Kind::Type(info) => visit(info, found),
        Kind::Optional(kind) | Kind::List(kind) | Kind::Tuple(kind, _) | Kind::Map(kind) => visit_kind(kind, found),
        Kind::Either(one, other) => {
            visit_kind(one, found);
            visit_kind(other, found);
        }
    }
}

impl TypeInfo {
    /// Its fields, those of all variants in turn.
    fn fields(&self) -> impl Iterator<Item = &'static FieldInfo> {
        let (fields, variants) = match self.form {
            Form::Record(fields) => (fields, [].as_slice()),
            Form::Choice(variants) => ([].as_slice(), variants),
        };
        fields.iter().chain(variants.iter().flat_map(|variant| variant.fields))
    }
}

fn type_page(text: &mut String, info: &TypeInfo) {
    *text += &format!("## {}\n\n{}\n\n", info.name, paragraph(info.doc));
    match info.form {
        Form::Record(fields) => field_table(text, fields),
        Form::Choice(variants) if variants.iter().all(|variant| variant.fields.is_empty()) => {
            *text += "| name | meaning |\n| --- | --- |\n";
            for variant in variants {
                line(text, &[format!("`{}`", variant.name), paragraph(variant.doc)]);
            }
            *text += "\n";
        }
        Form::Choice(variants) => {
            for variant in variants {
                *text += &format!("### {} {}\n\n{}\n\n", info.name, variant.name, paragraph(variant.doc));
                field_table(text, variant.fields);
            }
        }
    }
}

fn field_table(text: &mut String, fields: &[FieldInfo]) {
    *text += "| field | takes | unit | range | default | example | meaning |\n";
    *text += "| --- | --- | --- | --- | --- | --- | --- |\n";
    for field in fields {
        let kind = (field.kind)();
        let default = match (field.default, &kind) {
            (Some(default), _) => format!("`{default}`"),
            (None, Kind::Optional(_)) => "absent".into(),
            (None, _) => "must be given".into(),
        };
        line(
            text,
            &[
                format!("`{}`", field.name),
                linked(&kind),
                field.unit.to_string(),
                field.range.map_or("", |range| range.text).to_string(),
                default,
                format!("`{}`", field.example),
                paragraph(field.doc),
            ],
        );
    }
    *text += "\n";
}

fn line(text: &mut String, cells: &[String]) {
    let cells = cells.iter().map(|cell| if cell.is_empty() { "–" } else { cell });
    let _ = writeln!(text, "| {} |", cells.collect::<Vec<_>>().join(" | "));
}

fn paragraph(lines: &[&str]) -> String {
    lines.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ")
}

/// The kind with links to the pages of the types in it.
fn linked(kind: &Kind) -> String {
    match kind {
        Kind::Plain(name) => name.to_string(),
        Kind::Type(info) => format!("[{}](#{})", info.name, info.name.to_lowercase()),
        Kind::Optional(kind) => linked(kind),
        Kind::List(kind) => format!("list of {}", linked(kind)),
        Kind::Tuple(kind, count) => format!("{count} of {}", linked(kind)),
        Kind::Map(kind) => format!("map of names to {}", linked(kind)),
        Kind::Either(one, other) => format!("{} or {}", linked(one), linked(other)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn examples_and_defaults_are_values_of_their_fields() {
        let mut count = 0;
        let mut all = types();
        visit(Study::INFO, &mut all);
        for info in all {
            for field in info.fields() {
                let name = format!("{}: {}", info.name, field.name);
                assert!((field.takes)(field.example), "the example of {name}");
                assert!(field.default.is_none_or(field.takes), "the default of {name}");
                assert!(!(field.takes)("@") && !(field.takes)("'"), "{name} takes anything");
                count += 1;
            }
        }
        assert!(count > 100, "there are more fields than {count}");
    }

    #[test]
    fn every_type_has_a_page_of_its_own() {
        let mut names: Vec<&str> = types().into_iter().map(|info| info.name).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
    }
}
