//! Tapes as files.
//!
//! A file holds, one after the other: [`MAGIC`]; the version as u32; the length of the header as u32; the header, JSON with what the
//! rays were recorded from and how many there are; the rays' columns in the order of
//! [`PathRay`]'s fields; column, row and number of every sample; and a hash of all that (FNV-1a, 64
//! bits). Numbers are little endian.

use brewster_buffers::{Integrator, SamplerKind};
use brewster_optics::dispersion::PathWavelength;
use brewster_wavefront::media::MediaId;
use brewster_wavefront::queues::{PathRay, PathRayColumns, RaySource, Trail};
use brewster_wavefront::tape::Tape;
use glam::{UVec2, Vec3};
use serde::{Deserialize, Serialize};

use crate::stats::hash_text;
use crate::{PROGRAM, Session, SettingsChoices};

/// How every tape begins.
pub const MAGIC: &[u8; 16] = b"brewster tape \n\0";

/// The version of the format.
pub const TAPE_VERSION: u32 = 1;

/// What a tape was recorded from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TapeHeader {
    program: String,
    scene: String,
    /// Of the scene's files and overrides.
    hash: String,
    /// The camera's number.
    camera: usize,
    resolution: [u32; 2],
    integrator: String,
    max_depth: u32,
    samples_per_pixel: u32,
    seed: u64,
    sampler: String,
    split_depth: u32,
    depth: u32,
    queue: String,
    rays: u32,
    samples: u32,
    media: Vec<Vec<u32>>,
}

/// A tape and what it was recorded from.
#[derive(Clone, Debug, PartialEq)]
pub struct TapeFile {
    /// What it was recorded from.
    pub header: TapeHeader,
    /// The rays.
    pub tape: Tape,
}

/// Bytes of a ray and of a sample in a file.
const RAY: usize = PathRayColumns::BYTES_PER_ROW;
const SAMPLE: usize = 12;

impl TapeFile {
    /// A tape of a session's scene and one of its cameras.
    pub fn new(session: &Session, camera: usize, tape: Tape) -> TapeFile {
        let settings = &session.buffers().settings;
        let header = TapeHeader {
            program: PROGRAM.to_owned(),
            scene: session.path().display().to_string(),
            hash: hash_text(session.hash()),
            camera,
            resolution: settings.resolution.to_array(),
            integrator: format!("{:?}", settings.integrator),
            max_depth: settings.max_depth,
            samples_per_pixel: settings.samples,
            seed: settings.seed,
            sampler: format!("{:?}", settings.sampler),
            split_depth: settings.split_depth,
            depth: tape.depth,
            queue: tape.source.name().to_owned(),
            rays: tape.rays.len() as u32,
            samples: tape.samples.len() as u32,
            media: tape.media.clone(),
        };
        TapeFile { header, tape }
    }

    /// The file's bytes.
    pub fn bytes(&self) -> Vec<u8> {
        let header = serde_json::to_vec(&self.header).expect("strings, numbers and lists are JSON");
        let mut bytes = MAGIC.to_vec();
        let rays = self.tape.rays.view();
        let mut word = |word: u32| bytes.extend(word.to_le_bytes());
        word(TAPE_VERSION);
        word(header.len() as u32);
        bytes.extend(header);
        let floats =
            [rays.origin_x, rays.origin_y, rays.origin_z, rays.direction_x, rays.direction_y, rays.direction_z];
        floats.into_iter().flatten().for_each(|number| bytes.extend(number.to_le_bytes()));
        let weights = rays.weight.iter().flat_map(|weight| weight.to_array());
        weights.chain(rays.pdf.iter().copied()).for_each(|number| bytes.extend(number.to_le_bytes()));
        let words = rays.sample.iter().copied().chain(rays.trail.iter().map(|trail| trail.bits()));
        let words = words.chain(rays.instance.iter().copied()).chain(rays.media.iter().map(|media| media.0));
        words.for_each(|word| bytes.extend(word.to_le_bytes()));
        rays.wavelength.iter().for_each(|wavelength| bytes.extend(wavelength.bits().to_le_bytes()));
        rays.branch.iter().for_each(|branch| bytes.extend(branch.to_le_bytes()));
        self.tape.samples.as_flattened().iter().for_each(|word| bytes.extend(word.to_le_bytes()));
        let hash = fnv(&bytes);
        bytes.extend(hash.to_le_bytes());
        bytes
    }

    /// Reads a file's bytes; sizes are checked before memory is taken.
    ///
    /// # Errors
    ///
    /// What is wrong with the file, in words.
    pub fn read(bytes: &[u8]) -> Result<TapeFile, String> {
        let mut file = Bytes(bytes);
        if file.take(MAGIC.len()).ok() != Some(MAGIC.as_slice()) {
            return Err("it is no tape".to_owned());
        }
        let version = file.word()?;
        if version != TAPE_VERSION {
            return Err(format!("it is a tape of version {version}; this program reads version {TAPE_VERSION}"));
        }
        let length = file.word()? as usize;
        let header: TapeHeader =
            serde_json::from_slice(file.take(length)?).map_err(|error| format!("its header: {error}"))?;
        let (rays, samples) = (header.rays as usize, header.samples as usize);
        let expected = rays * RAY + samples * SAMPLE + 8;
        if file.0.len() != expected {
            return Err(format!(
                "its columns take {} bytes and not the {expected} that its header tells",
                file.0.len()
            ));
        }
        let (content, hash) = bytes.split_at(bytes.len() - 8);
        if hash != fnv(content).to_le_bytes() {
            return Err("its hash is another: it was changed".to_owned());
        }
        let source = RaySource::APART.into_iter().find(|source| source.name() == header.queue);
        let source = source.ok_or_else(|| format!("there is no queue {:?}", header.queue))?;
        let columns = read_rays(&mut file, rays)?;
        let words = file.words(3 * samples)?;
        let samples = words.chunks_exact(3).map(|sample| [sample[0], sample[1], sample[2]]).collect();
        let tape = Tape { depth: header.depth, source, rays: columns, samples, media: header.media.clone() };
        Ok(TapeFile { header, tape })
    }
}

impl TapeHeader {
    /// The settings that the rays were recorded with.
    ///
    /// # Errors
    ///
    /// A name that is none.
    pub fn settings(&self) -> Result<SettingsChoices, String> {
        let integrator = [Integrator::Whitted, Integrator::Path].into_iter();
        let sampler = [SamplerKind::Sobol, SamplerKind::Independent].into_iter();
        let unknown = |name: &str| format!("it names {name:?}, which this program does not know");
        Ok(SettingsChoices {
            resolution: Some(UVec2::from_array(self.resolution)),
            integrator: Some(
                integrator
                    .clone()
                    .find(|kind| format!("{kind:?}") == self.integrator)
                    .ok_or_else(|| unknown(&self.integrator))?,
            ),
            max_depth: Some(self.max_depth),
            samples: Some(self.samples_per_pixel),
            seed: Some(self.seed),
            sampler: Some(
                sampler
                    .clone()
                    .find(|kind| format!("{kind:?}") == self.sampler)
                    .ok_or_else(|| unknown(&self.sampler))?,
            ),
            split_depth: Some(self.split_depth),
            ..SettingsChoices::default()
        })
    }

    /// The camera's number.
    pub fn camera(&self) -> usize {
        self.camera
    }

    /// Whether it was recorded from what a session has loaded.
    pub fn is_of(&self, session: &Session) -> bool {
        self.hash == hash_text(session.hash())
    }
}

/// Bytes that are left to be read.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or("it ends too early")?;
        self.0 = rest;
        Ok(taken)
    }

    fn word(&mut self) -> Result<u32, String> {
        Ok(self.words(1)?[0])
    }

    fn words(&mut self, count: usize) -> Result<Vec<u32>, String> {
        let bytes = self.take(4 * count)?.chunks_exact(4);
        Ok(bytes.map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect())
    }

    fn floats(&mut self, count: usize) -> Result<Vec<f32>, String> {
        Ok(self.words(count)?.into_iter().map(f32::from_bits).collect())
    }
}

fn read_rays(file: &mut Bytes<'_>, rays: usize) -> Result<PathRayColumns, String> {
    let [origin_x, origin_y, origin_z] = [file.floats(rays)?, file.floats(rays)?, file.floats(rays)?];
    let [direction_x, direction_y, direction_z] = [file.floats(rays)?, file.floats(rays)?, file.floats(rays)?];
    let (weight, pdf) = (file.floats(3 * rays)?, file.floats(rays)?);
    let [sample, trail, instance, media] = [file.words(rays)?, file.words(rays)?, file.words(rays)?, file.words(rays)?];
    let wavelength = file.take(2 * rays)?;
    let branch = file.words(rays)?;
    (0..rays)
        .map(|row| {
            Ok(PathRay {
                origin_x: origin_x[row],
                origin_y: origin_y[row],
                origin_z: origin_z[row],
                direction_x: direction_x[row],
                direction_y: direction_y[row],
                direction_z: direction_z[row],
                weight: Vec3::from_slice(&weight[3 * row..]),
                pdf: pdf[row],
                sample: sample[row],
                trail: Trail::from_bits(trail[row]).ok_or("a ray has no path behind it")?,
                instance: instance[row],
                media: MediaId(media[row]),
                wavelength: PathWavelength::from_bits(u16::from_le_bytes([
                    wavelength[2 * row],
                    wavelength[2 * row + 1],
                ])),
                branch: branch[row],
            })
        })
        .collect()
}

/// FNV-1a.
fn fnv(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}
