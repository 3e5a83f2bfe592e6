//! Placing shapes: affine maps in f32, applied in f64.

use glam::{Affine3A, DMat3, DVec3, Mat4, Vec3};

use crate::aabb::Aabb;
use crate::ray::Ray;

/// An affine map as three rows of four: the linear part and, last in each row, the translation.
///
/// Points and vectors are mapped in f64 and rounded once, so a mapped coordinate is off by half a unit in its own last place
/// and not in that of the larger numbers it came from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// The rows.
    pub rows: [[f32; 4]; 3],
}

/// Why a transform cannot place a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransformError {
    /// It has a number that is not finite, or a last row other than (0, 0, 0, 1).
    NotAffine,
    /// It flattens space, or its inverse does not fit f32.
    Singular,
    /// It has an inverse where it begins and where it ends, but not on the way, or hardly any.
    FlatOnTheWay,
}

impl std::fmt::Display for TransformError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            TransformError::NotAffine => "the transform is not finite or not affine",
            TransformError::Singular => "the transform flattens space, so it has no inverse",
            TransformError::FlatOnTheWay => "the motion flattens space on its way, or all but",
        })
    }
}

impl std::error::Error for TransformError {}

impl Default for Affine {
    fn default() -> Affine {
        Affine::IDENTITY
    }
}

impl Affine {
    /// The map that moves nothing.
    pub const IDENTITY: Affine = Affine { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };

    /// Moves by an offset.
    pub fn translation(by: Vec3) -> Affine {
        let mut map = Affine::IDENTITY;
        for axis in 0..3 {
            map.rows[axis][3] = by[axis];
        }
        map
    }

    /// The map of a matrix.
    pub fn from_mat4(matrix: Mat4) -> Result<Affine, TransformError> {
        let [x, y, z, last] = matrix.transpose().to_cols_array_2d();
        if last != [0.0, 0.0, 0.0, 1.0] {
            return Err(TransformError::NotAffine);
        }
        Affine { rows: [x, y, z] }.finite()
    }

    /// The map of glam's affine type.
    pub fn from_affine3a(affine: Affine3A) -> Result<Affine, TransformError> {
        Affine::from_mat4(affine.into())
    }

    fn finite(self) -> Result<Affine, TransformError> {
        if self.rows.as_flattened().iter().all(|x| x.is_finite()) { Ok(self) } else { Err(TransformError::NotAffine) }
    }

    /// The inverse, computed in f64.
    ///
    /// A map is singular if its determinant, or its inverse's, is below 10⁻¹² of the product of the columns' lengths: such a
    /// shape is flat to f32's precision.
    pub fn inverse(&self) -> Result<Affine, TransformError> {
        self.finite()?;
        let (linear, translation) = self.inverse_f64().ok_or(TransformError::Singular)?;
        let inverse = Affine::from_f64(&linear, translation);
        if inverse.finite().is_err() || inverse.inverse_f64().is_none() {
            return Err(TransformError::Singular);
        }
        Ok(inverse)
    }

    /// The inverse's linear part and translation.
    #[inline]
    pub(crate) fn inverse_f64(&self) -> Option<(DMat3, DVec3)> {
        let (linear, translation) = self.to_f64();
        let volume = linear.x_axis.length() * linear.y_axis.length() * linear.z_axis.length();
        let determinant = linear.determinant();
        let inverse = linear.inverse();
        (determinant.abs() > 1e-12 * volume).then(|| (inverse, -(inverse * translation)))
    }

    /// The linear part and the translation.
    #[inline(always)]
    pub(crate) fn to_f64(self) -> (DMat3, DVec3) {
        let column = |c: usize| DVec3::new(self.rows[0][c] as f64, self.rows[1][c] as f64, self.rows[2][c] as f64);
        (DMat3::from_cols(column(0), column(1), column(2)), column(3))
    }

    /// The map of a linear part and a translation, rounded.
    #[inline(always)]
    pub(crate) fn from_f64(linear: &DMat3, translation: DVec3) -> Affine {
        let columns = [linear.x_axis, linear.y_axis, linear.z_axis, translation];
        Affine { rows: std::array::from_fn(|row| std::array::from_fn(|column| columns[column][row] as f32)) }
    }

    /// Maps a point in f64.
    #[inline(always)]
    pub(crate) fn point_f64(&self, p: DVec3) -> DVec3 {
        let map = |r: &[f32; 4]| r[0] as f64 * p.x + r[1] as f64 * p.y + r[2] as f64 * p.z + r[3] as f64;
        DVec3::new(map(&self.rows[0]), map(&self.rows[1]), map(&self.rows[2]))
    }

    /// Maps a vector in f64.
    #[inline(always)]
    pub(crate) fn vector_f64(&self, v: DVec3) -> DVec3 {
        let map = |r: &[f32; 4]| r[0] as f64 * v.x + r[1] as f64 * v.y + r[2] as f64 * v.z;
        DVec3::new(map(&self.rows[0]), map(&self.rows[1]), map(&self.rows[2]))
    }

    /// Maps a vector by the transposed linear part, in f64: the inverse map does this to normals.
    #[inline(always)]
    pub(crate) fn transposed_f64(&self, v: DVec3) -> DVec3 {
        let r = &self.rows;
        let map = |c: usize| r[0][c] as f64 * v.x + r[1][c] as f64 * v.y + r[2][c] as f64 * v.z;
        DVec3::new(map(0), map(1), map(2))
    }

    /// Maps a point.
    #[inline(always)]
    pub fn point(&self, point: Vec3) -> Vec3 {
        self.point_f64(point.as_dvec3()).as_vec3()
    }

    /// Maps a vector.
    #[inline(always)]
    pub fn vector(&self, vector: Vec3) -> Vec3 {
        self.vector_f64(vector.as_dvec3()).as_vec3()
    }

    /// Maps a ray; the direction is not normalized, so t keeps its meaning.
    #[inline(always)]
    pub fn ray(&self, ray: &Ray) -> Ray {
        Ray { origin: self.point(ray.origin), direction: self.vector(ray.direction), time: ray.time }
    }

    /// Maps a normal the way the *inverse* of this map moves surfaces: `world_to_object.normal_to_source(n)` takes a normal
    /// from object space to world space, with unit length. It stays on its side of the surface under mirroring.
    pub fn normal_to_source(&self, normal: Vec3) -> Vec3 {
        self.transposed_f64(normal.as_dvec3()).normalize().as_vec3()
    }

    /// The smallest box around a mapped box.
    pub fn bounds(&self, aabb: &Aabb) -> Aabb {
        let (linear, translation) = self.to_f64();
        bounds_f64(&linear, translation, aabb)
    }

    /// The factor by which the map scales every direction alike, but for f32's rounding; none if it scales some differently.
    pub fn uniform_scale(&self) -> Option<f64> {
        let (linear, _) = self.to_f64();
        let square = linear.x_axis.length_squared();
        let lengths = linear.y_axis.length_squared().max(linear.z_axis.length_squared()) - square;
        let shortest = square - linear.y_axis.length_squared().min(linear.z_axis.length_squared());
        let angles =
            [linear.x_axis.dot(linear.y_axis), linear.y_axis.dot(linear.z_axis), linear.z_axis.dot(linear.x_axis)];
        let off = angles.iter().fold(lengths.max(shortest), |most, angle| most.max(angle.abs()));
        (off <= 2e-6 * square).then(|| square.sqrt())
    }

    /// Whether the map turns right hands into left ones.
    pub fn mirrors(&self) -> bool {
        self.to_f64().0.determinant() < 0.0
    }
}

/// The smallest box around a mapped box; empty stays empty.
#[inline]
pub(crate) fn bounds_f64(linear: &DMat3, translation: DVec3, aabb: &Aabb) -> Aabb {
    if aabb.is_empty() {
        return Aabb::EMPTY;
    }
    let center = (aabb.min.as_dvec3() + aabb.max.as_dvec3()) * 0.5;
    let half = (aabb.max.as_dvec3() - aabb.min.as_dvec3()) * 0.5;
    let center = *linear * center + translation;
    let half = linear.x_axis.abs() * half.x + linear.y_axis.abs() * half.y + linear.z_axis.abs() * half.z;
    Aabb::outward(center - half, center + half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    fn odd() -> Affine {
        let matrix = Mat4::from_scale_rotation_translation(
            Vec3::new(2.0, -0.5, 30.0),
            Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 0.7),
            Vec3::new(100.0, -20.0, 3.0),
        );
        Affine::from_mat4(matrix).unwrap()
    }

    /// Against glam's matrices.
    #[test]
    fn maps_as_its_matrix() {
        let map = odd();
        let [x, y, z] = map.rows.map(glam::Vec4::from_array);
        let matrix = Mat4::from_cols(x, y, z, glam::Vec4::W).transpose();
        let p = Vec3::new(0.3, -4.0, 0.01);
        assert!((map.point(p) - matrix.transform_point3(p)).length() < 1e-4);
        assert!((map.vector(p) - matrix.transform_vector3(p)).length() < 1e-5);
        let back = map.inverse().unwrap();
        assert!((back.point(map.point(p)) - p).length() < 1e-4);
        assert!(map.mirrors() && !Affine::IDENTITY.mirrors());
    }

    /// A normal is at right angles to the surface it left, and on the same side.
    #[test]
    fn normals_stay_normal() {
        let map = odd();
        let back = map.inverse().unwrap();
        let normal = Vec3::new(0.48, 0.6, 0.64);
        let world = back.normal_to_source(normal);
        for tangent in [normal.cross(Vec3::X), normal.cross(Vec3::Y)] {
            assert!(world.dot(map.vector(tangent).normalize()).abs() < 1e-5);
        }
        assert!(world.dot(map.vector(normal)) > 0.0);
        assert!((world.length() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn bounds_hold_the_corners() {
        let aabb = Aabb { min: Vec3::new(-1.0, 2.0, 0.0), max: Vec3::new(0.5, 2.0, 7.0) };
        let bounds = odd().bounds(&aabb);
        for corner in aabb.corners() {
            let p = odd().point(corner);
            assert!(bounds.padded(1e-5).contains(&Aabb { min: p, max: p }));
        }
        assert!(odd().bounds(&Aabb::EMPTY).is_empty());
    }

    #[test]
    fn flat_maps_are_errors() {
        let flat = Mat4::from_scale(Vec3::new(1.0, 0.0, 1.0));
        assert_eq!(Affine::from_mat4(flat).unwrap().inverse(), Err(TransformError::Singular));
        let tiny = Mat4::from_scale(Vec3::splat(1e-20));
        assert!(Affine::from_mat4(tiny).unwrap().inverse().is_ok());
        let lost = Mat4::from_scale(Vec3::splat(1e-42));
        assert_eq!(Affine::from_mat4(lost).unwrap().inverse(), Err(TransformError::Singular));
        assert_eq!(Affine::from_mat4(Mat4::NAN), Err(TransformError::NotAffine));
        let perspective = Mat4::from_cols_array(&[1., 0., 0., 0.1, 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.]);
        assert_eq!(Affine::from_mat4(perspective), Err(TransformError::NotAffine));
    }
}
