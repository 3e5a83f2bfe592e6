//! What columns promise, checked: every id names a row, every number can be computed with, every tree covers its rows.

use brewster_geometry::Affine;
use glam::Vec3;

use crate::{
    Background, Camera, CameraFrame, ColorSource, DetailId, Emitters, Light, MaterialKind, MaterialRow, Materials, Mix,
    Projection, SceneBuffers, Settings, TextureId,
};

/// A broken promise, in words.
type Outcome = Result<(), String>;

impl SceneBuffers {
    /// Checks that ids are in range, keys ascend, numbers are finite, transforms have their inverses beside them, and trees cover
    /// what they stand over. Returns the first broken promise. Looks at everything once.
    pub fn validate(&self) -> Result<(), String> {
        self.validate_instances()?;
        self.geometry().validate()?;
        self.validate_materials()?;
        self.validate_details()?;
        for (row, texture) in self.textures.rows.iter().enumerate() {
            require(texture.is_sound(), || format!("texture {row} is empty or not finite: {texture:?}"))?;
        }
        ascending("lights", self.lights.view().key.iter().copied())?;
        for row in 0..self.lights.len() {
            let light = self.lights.get(row);
            require(is_lit(&light), || format!("light {row} is not finite or has no direction: {light:?}"))?;
        }
        for motion in &self.light_motions {
            let of = (motion.light as usize) < self.lights.len();
            let is_sound = |&[position, direction]: &[Vec3; 2]| {
                is_lit(&Light { position, direction, ..self.lights.get(motion.light as usize) })
            };
            require(of && motion.keys.len() > 1 && motion.keys.iter().all(is_sound), || {
                format!("the motion of light {} has no light or no places: {motion:?}", motion.light)
            })?;
        }
        ascending("motions of lights", self.light_motions.iter().map(|motion| u64::from(motion.light)))?;
        ascending("cameras", self.cameras.iter().map(|camera| camera.key))?;
        for (row, camera) in self.cameras.iter().enumerate() {
            require(sees(camera), || format!("camera {row} has no frame or no picture: {camera:?}"))?;
        }
        require(is_color(self.ambient), || format!("ambient light is {}", self.ambient))?;
        let background = match self.background {
            Background::Constant(color) => is_color(color),
            Background::Gradient { horizon, zenith, ground } => [horizon, zenith, ground].into_iter().all(is_color),
            // A map is checked when it is made.
            Background::Environment(_) => true,
        };
        require(background, || format!("the background is {:?}", self.background))?;
        require(self.emitters == Emitters::new(self), || "the emitters are stale".to_owned())?;
        require(can_be_met(&self.settings), || format!("settings cannot be met: {:?}", self.settings))
    }

    fn validate_instances(&self) -> Outcome {
        let instances = self.instances.view();
        ascending("instances", instances.key.iter().copied())?;
        for row in 0..instances.len() {
            let instance = instances.get(row);
            let inverse: Option<Affine> = instance.object_to_world.inverse().ok();
            require(inverse == Some(instance.world_to_object), || {
                format!("instance {row} has {:?} for an inverse instead of {inverse:?}", instance.world_to_object)
            })?;
            let material = instance.material.0;
            require((material as usize) < self.materials.rows.len(), || {
                format!("instance {row} has material {material} of {}", self.materials.rows.len())
            })?;
        }
        Ok(())
    }

    /// Rows of a kind stand in the order of the materials that they belong to, one each.
    fn validate_materials(&self) -> Outcome {
        let Materials {
            rows,
            details: _,
            phong,
            lambert,
            rough_diffuse,
            metal,
            dielectric,
            emissive,
            principled,
            coated,
            mix,
        } = &self.materials;
        ascending("materials", rows.view().key.iter().copied())?;
        let mut owned = [0; MaterialKind::ALL.len()];
        for row in 0..rows.len() {
            let material = rows.get(row);
            self.own((material.kind, material.row), &mut owned).map_err(|error| format!("material {row} {error}"))?;
        }
        let lengths = [
            phong.len(),
            lambert.len(),
            rough_diffuse.len(),
            metal.len(),
            dielectric.len(),
            emissive.len(),
            principled.len(),
            coated.len(),
            mix.len(),
        ];
        for ((kind, owned), length) in MaterialKind::ALL.into_iter().zip(owned).zip(lengths) {
            require(owned as usize == length, || format!("{length} {} rows for {owned} materials", kind.name()))?;
        }

        let (phong, metal, dielectric, rough_diffuse) =
            (phong.view(), metal.view(), dielectric.view(), rough_diffuse.view());
        let colors = [
            phong.ambient,
            phong.diffuse,
            phong.specular,
            lambert.view().albedo,
            rough_diffuse.albedo,
            metal.r0,
            metal.specular,
            dielectric.specular,
            emissive.view().radiance,
        ];
        for color in colors.into_iter().flatten() {
            require(self.has_color(color), || format!("a material's color is {color:?}"))?;
        }
        let vectors = [metal.eta, metal.k, metal.r90, metal.f82, dielectric.absorption, dielectric.scattering];
        let numbers = [phong.exponent, metal.exponent, dielectric.exponent, dielectric.ior];
        let finite = vectors.into_iter().flatten().all(|v| v.is_finite())
            && numbers.into_iter().flatten().all(|x| x.is_finite());
        require(finite, || "a material has a number that is not finite".to_owned())?;
        let parts = [rough_diffuse.roughness, metal.alpha, dielectric.alpha, coated.view().alpha];
        let are_parts = parts.into_iter().flatten().all(|part| (0.0..=1.0).contains(part));
        require(are_parts, || "a material has a roughness outside 0 to 1".to_owned())?;
        let turns = |g: &f32| -1.0 < *g && *g < 1.0;
        require(dielectric.anisotropy.iter().all(turns), || {
            "a medium's anisotropy is not between -1 and 1".to_owned()
        })?;
        let mut films = metal.film.iter().chain(dielectric.film).flatten();
        require(
            films.all(|film| film.ior >= 1.0 && film.ior.is_finite() && (0.0..=1e5).contains(&film.thickness)),
            || "a material has a film that is none".to_owned(),
        )?;
        let mut dispersions = dielectric.dispersion.iter().zip(dielectric.thin);
        require(
            dispersions.all(|(dispersion, &thin)| dispersion.is_none_or(|index| index.is_sound() && !thin)),
            || "a material has a dispersion that is none".to_owned(),
        )?;
        self.validate_principled()
    }

    fn validate_principled(&self) -> Outcome {
        let scattering = self.materials.principled.view();
        let colors = [
            scattering.base_color,
            scattering.specular_color,
            scattering.sheen_color,
            scattering.diffuse_transmission_color,
            scattering.emission,
        ];
        for color in colors.into_iter().flatten() {
            require(self.has_color(color), || format!("a principled material's color is {color:?}"))?;
        }
        let scalars = [
            scattering.metallic,
            scattering.roughness,
            scattering.specular,
            scattering.clearcoat,
            scattering.clearcoat_roughness,
            scattering.sheen_roughness,
            scattering.transmission,
            scattering.diffuse_transmission,
            scattering.iridescence,
            scattering.iridescence_thickness_source,
        ];
        for scalar in scalars.into_iter().flatten() {
            let is_part = (0.0..=1.0).contains(&scalar.factor) && self.has_texture(scalar.texture);
            require(is_part, || format!("a principled material has a factor {scalar:?}"))?;
        }
        let mut textures = scattering.anisotropy_texture.iter().chain(scattering.clearcoat_normal);
        let are_sound = textures.all(|&texture| self.has_texture(texture))
            && scattering.clearcoat_normal_scale.iter().all(|scale| scale.is_finite());
        require(are_sound, || "a principled material has a map that is none".to_owned())
    }

    /// Counts the rows that a material owns, which must be the next of their kinds: first those of what it mixes, in their order.
    fn own(&self, (kind, row): (MaterialKind, u32), owned: &mut [u32; MaterialKind::ALL.len()]) -> Outcome {
        let material = MaterialRow { kind, row, key: 0, detail: DetailId::NONE };
        if kind == MaterialKind::Mix && (row as usize) < self.materials.mix.len() {
            let Mix { a, b, by } = self.materials.mix.get(row as usize);
            require(by.factor.is_finite() && self.has_texture(by.texture), || format!("mixes by {by:?}"))?;
            // What it mixes is before it, so this comes to an end.
            for part in [a, b] {
                let is_before = part.0 != MaterialKind::Mix || part.1 < row;
                require(is_before && self.materials.is_mixable(part), || format!("mixes {part:?}"))?;
                self.own(part, owned)?;
            }
        }
        for (kind, row) in [Some((kind, row)), self.materials.second(material)].into_iter().flatten() {
            let expected = &mut owned[kind as usize];
            require(row == *expected, || format!("is {} row {row} instead of {expected}", kind.name()))?;
            *expected += 1;
        }
        Ok(())
    }

    fn has_color(&self, color: &ColorSource) -> bool {
        let ColorSource { factor, texture } = *color;
        is_color(factor) && self.has_texture(texture)
    }

    fn has_texture(&self, texture: TextureId) -> bool {
        texture == TextureId::NONE || (texture.0 as usize) < self.textures.rows.len()
    }
}

fn require(holds: bool, broken: impl FnOnce() -> String) -> Outcome {
    if holds { Ok(()) } else { Err(broken()) }
}

/// Keys are in order and no two are the same.
fn ascending(table: &str, keys: impl Iterator<Item = u64>) -> Outcome {
    let mut last = None;
    for (row, key) in keys.enumerate() {
        require(last < Some(key), || format!("{table}: key {key} of row {row} is not above {last:?}"))?;
        last = Some(key);
    }
    Ok(())
}

fn is_color(color: Vec3) -> bool {
    color.is_finite() && color.min_element() >= 0.0
}

/// Rounding of f32 in a unit vector or in a product of two.
const ROUNDING: f32 = 1e-5;

fn is_unit(direction: Vec3) -> bool {
    (direction.length_squared() - 1.0).abs() <= ROUNDING
}

fn is_lit(light: &Light) -> bool {
    light.position.is_finite()
        && is_unit(light.direction)
        && is_color(light.intensity)
        && light.cone_scale.is_finite()
        && light.cone_offset.is_finite()
        && light.range > 0.0
}

fn sees(camera: &Camera) -> bool {
    let Camera { projection, aperture_radius, focus_distance, blades, motion, .. } = camera;
    let extent = match *projection {
        Projection::Perspective(tangent) => tangent,
        Projection::Orthographic(half_height) => half_height,
    };
    let is_sound = |&CameraFrame { position, right, up, forward }: &CameraFrame| {
        position.is_finite()
            && [right, up, forward].into_iter().all(is_unit)
            && (right.cross(up).dot(-forward) - 1.0).abs() <= ROUNDING
    };
    is_sound(&camera.frame(0.0))
        && motion.iter().all(is_sound)
        && motion.len() != 1
        && extent > 0.0
        && extent.is_finite()
        && *aperture_radius >= 0.0
        && *focus_distance > 0.0
        && !matches!(blades, 1 | 2)
        && (aperture_radius + focus_distance).is_finite()
}

fn can_be_met(settings: &Settings) -> bool {
    settings.resolution.min_element() >= 1
        && settings.samples >= 1
        && settings.contribution_threshold >= 0.0
        && settings.contribution_threshold.is_finite()
        && settings.exposure.is_finite()
        && settings.clamp > 0.0
        && settings.ray_offset >= 0.0
        && settings.ray_offset.is_finite()
        && settings.noise_threshold.is_none_or(|threshold| threshold > 0.0)
}

#[cfg(test)]
mod tests {
    use brewster_geometry::{ShapeKind, ShapeRef, Sphere, TopTree, TreeBuilder};

    use super::*;
    use crate::{Instance, Lambert, LightKind, MaterialId, Texture};

    /// Two balls of one material under a lamp, and a camera.
    fn scene() -> SceneBuffers {
        let mut buffers = SceneBuffers::default();
        buffers.shapes.spheres.push(Sphere { radius: 1.0 });
        buffers.textures.rows.push(Texture::Checker { a: Vec3::ZERO, b: Vec3::ONE, size: 1.0 });
        buffers.materials.rows.push(MaterialRow {
            kind: MaterialKind::Lambert,
            row: 0,
            key: 3,
            detail: DetailId::NONE,
        });
        let albedo = ColorSource { factor: Vec3::ONE, texture: TextureId(0) };
        buffers.materials.lambert.push(Lambert { albedo });
        for key in [1, 2] {
            let object_to_world = Affine::translation(Vec3::X * key as f32);
            buffers.instances.push(Instance {
                object_to_world,
                world_to_object: object_to_world.inverse().unwrap(),
                shape: ShapeRef { kind: ShapeKind::Sphere, row: 0 },
                material: MaterialId(0),
                key,
            });
        }
        buffers.trees.top = TopTree::build(&buffers.geometry().instances(), TreeBuilder::default()).unwrap();
        buffers.lights.push(Light {
            kind: LightKind::Point,
            position: Vec3::Y,
            direction: Vec3::NEG_Z,
            intensity: Vec3::ONE,
            cone_scale: 0.0,
            cone_offset: 1.0,
            range: f32::INFINITY,
            key: 4,
        });
        buffers.emitters = Emitters::new(&buffers);
        buffers.cameras.push(Camera {
            name: String::new(),
            position: Vec3::Z,
            right: Vec3::X,
            up: Vec3::Y,
            forward: Vec3::NEG_Z,
            projection: Projection::Perspective(0.5),
            aperture_radius: 0.0,
            focus_distance: 1.0,
            blades: 0,
            key: 5,
            motion: Vec::new(),
        });
        buffers
    }

    /// Every broken promise is found, and the message names it.
    #[test]
    fn broken_promises_are_found() {
        assert_eq!(scene().validate(), Ok(()));
        assert_eq!(SceneBuffers::default().validate(), Ok(()));
        let check = |named: &str, spoil: fn(&mut SceneBuffers)| {
            let mut buffers = scene();
            spoil(&mut buffers);
            let error = buffers.validate().expect_err(named);
            assert!(error.contains(named), "{error} does not name {named}");
        };
        check("instances: key 1", |b| b.instances.view_mut().key[1] = 1);
        check("instance 1", |b| b.instances.view_mut().object_to_world[1] = Affine::IDENTITY);
        check("instance 0 has material 1", |b| b.instances.view_mut().material[0].0 = 1);
        check("instance 1", |b| b.instances.view_mut().shape[1].row = 7);
        check("2", |b| b.instances.truncate(1));
        check("planes", |b| b.trees.planes.push(0));
        check("lambert row 1", |b| b.materials.rows.view_mut().row[0] = 1);
        check("0 lambert rows for 1", |b| b.materials.lambert.clear());
        check("color", |b| b.materials.lambert.view_mut().albedo[0].texture.0 = 1);
        check("color", |b| b.materials.lambert.view_mut().albedo[0].factor.y = f32::NAN);
        check("texture 0", |b| b.textures.rows[0] = Texture::Checker { a: Vec3::ZERO, b: Vec3::ONE, size: 0.0 });
        check("emitters", |b| b.emitters = Emitters::default());
        check("light 0", |b| b.lights.view_mut().direction[0] = Vec3::ONE);
        check("light 0", |b| b.lights.view_mut().intensity[0].x = f32::INFINITY);
        check("camera 0", |b| b.cameras[0].right = Vec3::NEG_X);
        check("camera 0", |b| b.cameras[0].projection = Projection::Perspective(f32::NAN));
        check("cameras: key 5", |b| b.cameras.push(b.cameras[0].clone()));
        check("ambient", |b| b.ambient.z = -1.0);
        check("background", |b| b.background = Background::Constant(Vec3::NAN));
        check("settings", |b| b.settings.samples = 0);
        check("settings", |b| b.settings.clamp = 0.0);
        check("settings", |b| b.settings.noise_threshold = Some(f32::NAN));
    }
}
