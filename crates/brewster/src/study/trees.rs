//! Trees built in other ways: the scene with them, and the time that they take.

use std::sync::Arc;

use brewster::buffers::{SceneBuffers, Trees};
use brewster::geometry::{Kernel, MeshTree, ObvhsTrees, TopTree, TreeBuilder};
use brewster::import::study::Study;

use super::measure::{Block, Clock, Side, Took, in_turn};
use super::record::BuildResult;
use super::rows::speedup;
use super::run::Watch;
use super::statistics::{Verdict, are_enough, median};
use super::subject::{Subject, intervals, ways};
use crate::commands::Failure;

/// A scene as subjects see it; what several see alike is there once.
pub(crate) struct Variants<'b> {
    plain: &'b SceneBuffers,
    others: Vec<(Key, SceneBuffers)>,
}

impl<'b> Variants<'b> {
    /// Builds what is not there yet.
    pub(crate) fn new(plain: &'b SceneBuffers, subjects: &[Subject]) -> Result<Variants<'b>, Failure> {
        let mut variants = Variants { plain, others: Vec::new() };
        for subject in subjects {
            let key = key(subject);
            if key == PLAIN || variants.others.iter().any(|(other, _)| *other == key) {
                continue;
            }
            let mut buffers = plain.clone();
            buffers.settings.seed = buffers.settings.seed.wrapping_add(subject.seed_shift);
            buffers.trees = trees(plain, subject.tree)?;
            if subject.policy.kernel == Kernel::Obvhs {
                let eye = plain.cameras.first().map_or(0.0, |camera| camera.position.abs().max_element());
                buffers.trees.obvhs = Some(Arc::new(ObvhsTrees::build(&buffers.geometry(), eye)));
            }
            variants.others.push((key, buffers));
        }
        Ok(variants)
    }

    /// What a subject sees.
    pub(crate) fn of(&self, subject: &Subject) -> &SceneBuffers {
        let key = key(subject);
        self.others.iter().find(|(other, _)| *other == key).map_or(self.plain, |(_, buffers)| buffers)
    }
}

/// What a subject's scene differs in from others': how trees are built, whether obvhs's are there, too, and the seed.
type Key = (TreeBuilder, bool, u64);

/// As sessions make it.
const PLAIN: Key = (TreeBuilder::Binned, false, 0);

fn key(subject: &Subject) -> Key {
    (subject.tree, subject.policy.kernel == Kernel::Obvhs, subject.seed_shift)
}

/// A scene's trees, built anew.
fn trees(buffers: &SceneBuffers, builder: TreeBuilder) -> Result<Trees, Failure> {
    let meshes = buffers.shapes.meshes.iter().map(|mesh| MeshTree::build(mesh.clone(), builder));
    let meshes = meshes.collect::<Result<Vec<_>, _>>().map_err(Failure::input)?;
    let mut geometry = buffers.geometry();
    geometry.mesh_trees = &meshes;
    let top = TopTree::build(&geometry.instances(), builder).map_err(Failure::input)?;
    Ok(Trees { meshes, top, planes: buffers.trees.planes.clone(), obvhs: None })
}

/// Builds the trees of a scene in all the ways of a study in turn, on all threads. Nothing if there is one way only.
pub(crate) fn builds(
    study: &Study,
    subjects: &[Subject],
    buffers: &SceneBuffers,
    scene: &str,
    watch: &Watch<'_>,
) -> Result<Vec<BuildResult>, Failure> {
    let mut ways = ways(subjects);
    if ways.len() < 2 {
        return Ok(Vec::new());
    }
    // The first one's control is its twin, at the place after it.
    ways.insert(1, ways[0]);
    let mut bytes = vec![0; ways.len()];
    let blocks = in_turn(ways.len(), study.rounds, watch.stop, |place, _| {
        (watch.step)(format!("{scene}: building trees, {:?}", ways[place]));
        let block = Block::run(|side, _| {
            let place = if side == Side::Own { place } else { 0 };
            let (built, took) = Took::by(|| trees(buffers, ways[place]))?;
            bytes[place] = built.meshes.iter().map(MeshTree::bytes).sum::<usize>() + built.top.bytes();
            Ok::<Took, Failure>(took)
        });
        block.map(Some)
    })?;
    let intervals = intervals(study, subjects);
    let of = |place: usize| speedup(&blocks[place], Clock::Wall, intervals);
    let control = of(1);
    let trusted = are_enough(blocks[1].len(), intervals) && control.is_some_and(|control| control.is_even());
    let result = |place: usize| {
        let speedup = if place > 0 { of(place) } else { None };
        // The baseline's are those around its twin's.
        let runs = blocks[place.max(1)].iter().flat_map(|block| if place > 0 { block.own } else { block.baseline });
        BuildResult {
            name: format!("{:?}", ways[place]),
            bytes: bytes[place],
            blocks: blocks[place.max(1)].clone(),
            median: median(&runs.map(|took| took.wall).collect::<Vec<_>>()),
            speedup,
            verdict: speedup
                .zip(control)
                .filter(|_| place > 1)
                .map(|(ratio, control)| Verdict::of(&ratio, &control, trusted)),
        }
    };
    Ok((0..ways.len()).map(result).collect())
}
