//! Trees built in other ways: the scene with them, and the time that they take.

use std::time::Instant;

use brewster::buffers::{SceneBuffers, Trees};
use brewster::geometry::{MeshTree, TopTree, TreeBuilder};
use brewster::import::study::Study;

use super::measure::{interleave, speedups};
use super::record::BuildResult;
use super::run::Watch;
use super::statistics::{Estimate, Verdict, median};
use super::subject::Subject;
use crate::commands::Failure;

/// A scene as subjects see it; what several see alike is there once.
pub(crate) struct Variants<'b> {
    plain: &'b SceneBuffers,
    others: Vec<((TreeBuilder, u64), SceneBuffers)>,
}

impl<'b> Variants<'b> {
    /// Builds what is not there yet.
    pub(crate) fn new(plain: &'b SceneBuffers, subjects: &[Subject]) -> Result<Variants<'b>, Failure> {
        let mut variants = Variants { plain, others: Vec::new() };
        for subject in subjects {
            let key = (subject.tree, subject.seed_shift);
            if key == PLAIN || variants.others.iter().any(|(other, _)| *other == key) {
                continue;
            }
            let mut buffers = plain.clone();
            buffers.settings.seed = buffers.settings.seed.wrapping_add(subject.seed_shift);
            buffers.trees = trees(plain, subject.tree)?;
            variants.others.push((key, buffers));
        }
        Ok(variants)
    }

    /// What a subject sees.
    pub(crate) fn of(&self, subject: &Subject) -> &SceneBuffers {
        let key = (subject.tree, subject.seed_shift);
        self.others.iter().find(|(other, _)| *other == key).map_or(self.plain, |(_, buffers)| buffers)
    }
}

/// How sessions build their trees.
const PLAIN: (TreeBuilder, u64) = (TreeBuilder::Binned, 0);

/// A scene's trees, built anew.
fn trees(buffers: &SceneBuffers, builder: TreeBuilder) -> Result<Trees, Failure> {
    let meshes = buffers.shapes.meshes.iter().map(|mesh| MeshTree::build(mesh.clone(), builder));
    let meshes = meshes.collect::<Result<Vec<_>, _>>().map_err(Failure::input)?;
    let mut geometry = buffers.geometry();
    geometry.mesh_trees = &meshes;
    let top = TopTree::build(&geometry.instances(), builder).map_err(Failure::input)?;
    Ok(Trees { meshes, top, planes: buffers.trees.planes.clone() })
}

/// Builds the trees of a scene in all the ways of a study in turn, on all threads. Nothing if there is one way only.
pub(crate) fn builds(
    study: &Study,
    subjects: &[Subject],
    buffers: &SceneBuffers,
    scene: &str,
    watch: &Watch<'_>,
) -> Result<Vec<BuildResult>, Failure> {
    let mut ways: Vec<TreeBuilder> = Vec::new();
    for subject in subjects {
        if !ways.contains(&subject.tree) {
            ways.push(subject.tree);
        }
    }
    if ways.len() < 2 {
        return Ok(Vec::new());
    }
    // The first one's control is its twin, at the place after it.
    ways.insert(1, ways[0]);
    let mut bytes = vec![0; ways.len()];
    let seconds = interleave(ways.len(), study.warm_up, study.rounds, watch.stop, |place, _| {
        (watch.step)(format!("{scene}: building trees, {:?}", ways[place]));
        let begin = Instant::now();
        let built = trees(buffers, ways[place])?;
        let time = begin.elapsed().as_secs_f64();
        bytes[place] = built.meshes.iter().map(MeshTree::bytes).sum::<usize>() + built.top.bytes();
        Ok::<f64, Failure>(time)
    })?;
    let control = Estimate::of(&speedups(&seconds[0], &seconds[1]));
    let result = |place: usize| {
        let speedup = Estimate::of(&speedups(&seconds[0], &seconds[place])).filter(|_| place > 0);
        let flat: Vec<f64> = seconds[place].iter().flatten().copied().collect();
        BuildResult {
            name: format!("{:?}", ways[place]),
            bytes: bytes[place],
            seconds: seconds[place].clone(),
            median: median(&flat),
            speedup,
            verdict: speedup.zip(control).filter(|_| place > 1).map(|(ratio, control)| Verdict::of(&ratio, &control)),
        }
    };
    Ok((0..ways.len()).map(result).collect())
}
