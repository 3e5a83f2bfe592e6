//! Objects of the JSON, read field by field.

use gltf::json::Value;
use serde::de::DeserializeOwned;
use serde_json::Map;

use super::{Found, broken, typed};

/// An object of the file with its place. One that is absent has no fields.
pub(super) struct Fields<'d> {
    values: Option<&'d Map<String, Value>>,
    path: String,
}

impl<'d> Fields<'d> {
    /// The object that a value is, if it is there and one.
    pub(super) fn new(value: Option<&'d Value>, path: String) -> Fields<'d> {
        Fields { values: value.and_then(Value::as_object), path }
    }

    /// The value of a field that may be absent.
    pub(super) fn get<T: DeserializeOwned>(&self, name: &str, default: T) -> Found<T> {
        let value = self.values.and_then(|values| values.get(name));
        value.map_or(Ok(default), |value| typed(value, &self.path_of(name)))
    }

    /// The value of a field that must be there.
    pub(super) fn need<T: DeserializeOwned>(&self, name: &str) -> Found<T> {
        let absent = || broken(self.path.as_str(), format!("missing field `{name}`"));
        self.get::<Option<T>>(name, None)?.ok_or_else(|| Box::new(absent()))
    }

    /// The object in a field.
    pub(super) fn within(&self, name: &str) -> Fields<'d> {
        Fields::new(self.values.and_then(|values| values.get(name)), self.path_of(name))
    }

    pub(super) fn path(&self) -> &str {
        &self.path
    }

    pub(super) fn path_of(&self, name: &str) -> String {
        format!("{}.{name}", self.path)
    }

    pub(super) fn is_absent(&self) -> bool {
        self.values.is_none()
    }
}
