//! An orthonormal frame around a normal: world to local, where +z is the normal, and back.

use glam::Vec3;

/// Three unit vectors at right angles, right-handed: `tangent × bitangent = normal`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// The local x axis.
    pub tangent: Vec3,
    /// The local y axis.
    pub bitangent: Vec3,
    /// The local z axis.
    pub normal: Vec3,
}

impl Basis {
    /// Some frame around a unit normal, without a branch and without a bad spot.
    ///
    /// T. Duff et al., *Building an Orthonormal Basis, Revisited*, JCGT 6(1), 2017. It jumps where `normal.z` changes its
    /// sign, so an anisotropic lobe wants [`Basis::with_tangent`].
    #[inline(always)]
    pub fn around(normal: Vec3) -> Basis {
        let sign = 1f32.copysign(normal.z);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Basis {
            tangent: Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
            bitangent: Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            normal,
        }
    }

    /// The frame around a unit normal whose x axis lies as near to `tangent` as a right angle allows.
    ///
    /// A tangent that is zero, not finite or along the normal gives [`Basis::around`].
    #[inline(always)]
    pub fn with_tangent(normal: Vec3, tangent: Vec3) -> Basis {
        let along = tangent - normal * normal.dot(tangent);
        let square = along.length_squared();
        // What is left of a parallel tangent is the rounding of its length.
        if !(square > 1e-8 * tangent.length_squared() && square < f32::INFINITY) {
            return Basis::around(normal);
        }
        let tangent = along / square.sqrt();
        let tangent = tangent - normal * normal.dot(tangent);
        Basis { tangent, bitangent: normal.cross(tangent), normal }
    }

    /// From the world into this frame.
    #[inline(always)]
    pub fn to_local(&self, world: Vec3) -> Vec3 {
        Vec3::new(self.tangent.dot(world), self.bitangent.dot(world), self.normal.dot(world))
    }

    /// From this frame into the world.
    #[inline(always)]
    pub fn to_world(&self, local: Vec3) -> Vec3 {
        self.tangent * local.x + self.bitangent * local.y + self.normal * local.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strategies::{real, unit_vector};
    use proptest::prelude::*;

    /// Whether three axes are unit, at right angles and right-handed, in f64.
    fn error(basis: &Basis) -> f64 {
        let [x, y, z] = [basis.tangent, basis.bitangent, basis.normal].map(Vec3::as_dvec3);
        let lengths = [x, y, z].map(|axis| (axis.length() - 1.0).abs());
        let angles = [x.dot(y).abs(), y.dot(z).abs(), z.dot(x).abs(), (x.cross(y) - z).length()];
        lengths.into_iter().chain(angles).fold(0.0, f64::max)
    }

    #[test]
    fn axes_give_axes() {
        for normal in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z] {
            assert!(error(&Basis::around(normal)) == 0.0, "{normal}");
        }
        let zero = Basis::around(Vec3::new(1.0, 0.0, -0.0));
        assert!(error(&zero) == 0.0, "{zero:?}");
        let basis = Basis::with_tangent(Vec3::Z, Vec3::new(0.0, 7.0, 3.0));
        assert_eq!((basis.tangent, basis.bitangent), (Vec3::Y, Vec3::NEG_X));
    }

    #[test]
    fn bad_tangents_are_replaced() {
        let normal = Vec3::new(0.6, 0.0, 0.8);
        for tangent in [Vec3::ZERO, normal, -2.0 * normal, Vec3::NAN, Vec3::INFINITY, Vec3::splat(1e30)] {
            assert_eq!(Basis::with_tangent(normal, tangent), Basis::around(normal), "{tangent}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        #[test]
        fn frames_are_orthonormal(normal in unit_vector(), tangent in unit_vector(), length in real(1e-10, 1e10)) {
            prop_assert!(error(&Basis::around(normal)) < 5e-7);
            let basis = Basis::with_tangent(normal, tangent * length);
            prop_assert!(error(&basis) < 5e-7, "{basis:?}");
            prop_assert!(basis.tangent.dot(tangent) > -1e-6);
        }

        #[test]
        fn there_and_back(normal in unit_vector(), direction in unit_vector()) {
            let basis = Basis::around(normal);
            prop_assert!(basis.to_world(basis.to_local(direction)).abs_diff_eq(direction, 1e-6));
            prop_assert!((basis.to_local(direction).z - normal.dot(direction)).abs() < 1e-6);
        }
    }
}
