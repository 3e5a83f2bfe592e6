//! Names of rows. An id holds until the next flatten.

/// Row of [`InstanceColumns`](crate::InstanceColumns).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct InstanceId(pub u32);

/// Row of [`MaterialRowColumns`](crate::MaterialRowColumns).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MaterialId(pub u32);

/// Row of the details of [`Materials`](crate::Materials), or [`DetailId::NONE`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DetailId(pub u32);

impl DetailId {
    /// No detail.
    pub const NONE: DetailId = DetailId(u32::MAX);
}

/// Row of [`Textures`](crate::Textures), or [`TextureId::NONE`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TextureId(pub u32);

impl TextureId {
    /// No texture: the constant color counts.
    pub const NONE: TextureId = TextureId(u32::MAX);
}
