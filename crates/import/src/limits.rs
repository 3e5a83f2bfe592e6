//! How large a scene may be. A file is input from strangers: each size is checked before memory is taken for it, and the
//! error names the limit.

use std::fmt;

/// Bounds on what a scene may ask for. [`Limits::DEFAULT`] admits scenes far beyond the gallery's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of one scene file.
    pub scene_bytes: u64,
    /// Bytes of one mesh or picture file.
    pub asset_bytes: u64,
    /// Values (numbers, strings, lists, …) in one scene file.
    pub values: u64,
    /// Brackets within brackets.
    pub nesting: u64,
    /// Files that are included within included files.
    pub include_depth: u64,
    /// Entities above an entity, itself counted. Nothing here recurses that deep but a world's own `despawn` of what is on top: in
    /// bevy_ecs each level takes 0.3 KB of stack, 1.5 KB if it was built without optimization.
    pub hierarchy: u64,
    /// Entities of a scene, those of includes and instances counted as often as they are placed.
    pub entities: u64,
    /// Pixels of the picture that a scene asks for.
    pub picture_pixels: u64,
    /// Pixels of all pictures of a scene together.
    pub image_pixels: u64,
    /// Vertices of all meshes of a scene together.
    pub vertices: u64,
    /// Triangles of all meshes of a scene together.
    pub triangles: u64,
    /// Scenes of a study, times its policies, times its sets of parameters.
    pub study_combinations: u64,
    /// Errors and warnings that are reported.
    pub diagnostics: u64,
}

impl Limits {
    /// What the command line uses.
    pub const DEFAULT: Limits = Limits {
        scene_bytes: 64 << 20,
        asset_bytes: 2 << 30,
        values: 8_000_000,
        nesting: 64,
        include_depth: 16,
        hierarchy: 4096,
        entities: 4_000_000,
        picture_pixels: 1 << 27,
        image_pixels: 100_000_000,
        vertices: 64_000_000,
        triangles: 64_000_000,
        study_combinations: 4096,
        diagnostics: 100,
    };
}

impl Default for Limits {
    fn default() -> Self {
        Limits::DEFAULT
    }
}

/// A limit that was passed: its name in [`Limits`] and its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Exceeded {
    /// The field of [`Limits`].
    pub name: &'static str,
    /// The bound.
    pub bound: u64,
}

impl fmt::Display for Exceeded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "limit `{}` is {}", self.name, self.bound)
    }
}

/// A sum that may not pass a limit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budget {
    name: &'static str,
    bound: u64,
    used: u64,
}

impl Budget {
    pub(crate) fn new(name: &'static str, bound: u64) -> Budget {
        Budget { name, bound, used: 0 }
    }

    /// Takes `amount`, or leaves the sum as it was and says which limit it would pass.
    pub(crate) fn take(&mut self, amount: u64) -> Result<(), Exceeded> {
        let used = self.used.checked_add(amount).filter(|&used| used <= self.bound);
        self.used = used.ok_or(Exceeded { name: self.name, bound: self.bound })?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_admits_its_bound_and_no_more() {
        let mut budget = Budget::new("entities", 10);
        assert_eq!(budget.take(10), Ok(()));
        let over = budget.take(1).expect_err("the bound is reached");
        assert_eq!(over.to_string(), "limit `entities` is 10");
        assert_eq!(budget.take(u64::MAX), Err(over));
        assert_eq!(budget.take(0), Ok(()));
    }
}
