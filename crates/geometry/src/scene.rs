//! The scene as traversal sees it.

use crate::hit::Hit;
use crate::motion::{Motions, Place};
use crate::ray::Ray;
use crate::shape::{ShapeRef, ShapeTable};
use crate::transform::Affine;
use crate::traverse::ObvhsTrees;
use crate::tree::{Instances, MeshTree, TopTree};

/// Placed shapes and their trees, borrowed from whoever keeps them.
///
/// Columns have a row for each instance. The trees are those of these very columns: [`SceneGeometry::validate`] checks it.
#[derive(Clone, Copy, Debug)]
pub struct SceneGeometry<'a> {
    /// From the space of each instance's shape to world space.
    pub object_to_world: &'a [Affine],
    /// The inverse: what rays are mapped by, and so what says where a shape is.
    pub world_to_object: &'a [Affine],
    /// What moves, and how: of that, the columns hold where it is when the shutter opens.
    pub motions: &'a Motions,
    /// The shape of each instance.
    pub shapes: &'a [ShapeRef],
    /// The shapes.
    pub table: &'a ShapeTable,
    /// The trees of `table.meshes`, in the same order.
    pub mesh_trees: &'a [MeshTree],
    /// The tree over all instances.
    pub top: &'a TopTree,
    /// The instances that are planes without end, in order.
    pub planes: &'a [u32],
    /// What [`Kernel::Obvhs`](crate::Kernel::Obvhs) walks in place of our trees.
    pub obvhs: Option<&'a ObvhsTrees>,
}

impl<'a> SceneGeometry<'a> {
    /// What the top tree is built over.
    pub fn instances(&self) -> Instances<'a> {
        Instances {
            world_to_object: self.world_to_object,
            motions: self.motions,
            shapes: self.shapes,
            table: self.table,
            mesh_trees: self.mesh_trees,
        }
    }

    /// The maps of an instance at a moment, from object to world space and back; `moved` is where they stand if it moves.
    #[inline(always)]
    pub fn place_at<'p>(&'p self, instance: u32, time: f32, moved: &'p mut Option<Place>) -> (&'p Affine, &'p Affine) {
        self.motions.maps_at(instance, time, [self.object_to_world, self.world_to_object], moved)
    }

    /// A ray as the shape of an instance sees it.
    #[inline(always)]
    pub(crate) fn local_ray(&self, instance: u32, ray: &Ray) -> Ray {
        match self.motions.at(instance, ray.time) {
            Some(place) => place.world_to_object.ray(ray),
            None => self.world_to_object[instance as usize].ray(ray),
        }
    }

    /// Checks columns and trees against each other; returns the first broken promise. Looks at everything once.
    pub fn validate(&self) -> Result<(), String> {
        if self.object_to_world.len() != self.shapes.len() {
            return Err("columns of instances differ in length".to_string());
        }
        self.motions.validate(self.shapes.len())?;
        self.top.validate(&self.instances())?;
        if self.planes != self.instances().planes() {
            return Err("the list of planes is stale".to_string());
        }
        for (row, (tree, mesh)) in self.mesh_trees.iter().zip(&self.table.meshes).enumerate() {
            if !std::sync::Arc::ptr_eq(tree.mesh(), mesh) {
                return Err(format!("mesh tree {row} is of another mesh"));
            }
            tree.validate().map_err(|error| format!("mesh tree {row}: {error}"))?;
        }
        Ok(())
    }

    /// The nearest hit found without any tree, by trying every primitive of every instance: what traversal is tested against.
    pub fn brute_force(&self, ray: &Ray) -> Hit {
        let mut nearest = Hit::miss();
        for instance in 0..self.shapes.len() as u32 {
            self.each_hit(ray, instance, |hit| {
                if hit.precedes(&nearest) {
                    nearest = hit;
                }
            });
        }
        nearest
    }

    /// Calls with the nearest hit of an analytic shape, or with the hit of every triangle of a mesh.
    fn each_hit(&self, ray: &Ray, instance: u32, mut found: impl FnMut(Hit)) {
        let shape = self.shapes[instance as usize];
        let local = self.local_ray(instance, ray);
        let mut place = |hit: crate::LocalHit| {
            found(Hit { t: hit.t, u: hit.u, v: hit.v, instance, primitive: hit.primitive });
        };
        crate::shape::with_shape!(self.table, shape,
        analytic => if let Some(hit) = crate::Analytic::intersect(analytic, &local) { place(hit) },
        mesh => {
            let mesh = &self.table.meshes[mesh];
            for triangle in (0..mesh.triangles.len()).filter(|&triangle| !mesh.is_degenerate(triangle)) {
                if let Some(hit) = crate::intersect_triangle(&local, mesh.corners(triangle)) {
                    place(crate::LocalHit { primitive: triangle as u32, ..hit });
                }
            }
        });
    }
}
