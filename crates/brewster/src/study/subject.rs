//! A study's policies, as the tracer takes them.

use brewster::geometry::{self, TreeBuilder};
use brewster::import::study::{self, Study};
use brewster::lanes::Level;
use brewster::wavefront::{Compaction, Executor, Policy, QueueOrder, SortKey};

use crate::commands::Failure;

/// A policy, ready to be run.
#[derive(Clone, Debug)]
pub(crate) struct Subject {
    /// Its name.
    pub name: String,
    pub policy: Policy,
    pub threads: usize,
    pub tree: TreeBuilder,
    pub of_batches: bool,
    /// Added to the scene's seed: a stand-in for a policy that changes bits, in tests.
    pub seed_shift: u64,
}

impl Subject {
    fn new(policy: &study::Policy) -> Result<Subject, Failure> {
        let wanted = match policy.level {
            None => Level::detect().name(),
            Some(study::Level::Avx512) => "avx512",
            Some(study::Level::Avx2) => "avx2",
            Some(study::Level::Baseline) => "baseline",
        };
        let missing = || Failure::Input(format!("policy {:?}: this machine has no {wanted}", policy.name));
        Ok(Subject {
            name: policy.name.clone(),
            policy: Policy {
                batch: policy.batch as usize,
                capacity: policy.capacity as usize,
                order: match policy.order {
                    study::Order::ReflectionFirst => QueueOrder::ReflectionFirst,
                    study::Order::TransmissionFirst => QueueOrder::TransmissionFirst,
                    study::Order::Merged => QueueOrder::Merged,
                },
                sort: match policy.sort {
                    study::Sort::None => SortKey::None,
                    study::Sort::Material => SortKey::Material,
                    study::Sort::Octant => SortKey::Octant,
                    study::Sort::Morton => SortKey::Morton,
                    study::Sort::OctantMorton => SortKey::OctantMorton,
                },
                kernel: match policy.kernel {
                    study::Kernel::Packets => geometry::Kernel::Packets,
                    study::Kernel::Wave => geometry::Kernel::Wave,
                    study::Kernel::Single => geometry::Kernel::Single,
                    study::Kernel::Obvhs => geometry::Kernel::Obvhs,
                },
                compaction: match policy.compaction {
                    study::Compaction::Branch => Compaction::Branch,
                    study::Compaction::Cursor => Compaction::Cursor,
                },
                level: Level::named(wanted).ok_or_else(missing)?,
                executor: match policy.executor {
                    study::Executor::Wavefront => Executor::Wavefront,
                    study::Executor::Megakernel => Executor::Megakernel,
                },
                ..Policy::default()
            },
            threads: policy.threads as usize,
            tree: match policy.tree {
                study::Tree::Binned => TreeBuilder::Binned,
                study::Tree::Clustered => TreeBuilder::Clustered,
            },
            of_batches: policy.of_batches,
            seed_shift: 0,
        })
    }

    /// The settings in words: of the baseline all, of others what differs from it.
    pub(crate) fn settings(&self, baseline: &Subject) -> String {
        let mine = self.setting_list();
        let is_new = |place: usize| self.name == baseline.name || mine[place] != baseline.setting_list()[place];
        let new: Vec<&str> = (0..mine.len()).filter(|&place| is_new(place)).map(|place| mine[place].as_str()).collect();
        new.join(", ")
    }

    fn setting_list(&self) -> [String; 10] {
        let Policy { batch, capacity, order, sort, kernel, compaction, level, executor, .. } = self.policy;
        [
            format!("{executor:?}"),
            format!("batch {batch}"),
            format!("capacity {capacity}"),
            format!("threads {}", self.threads),
            format!("order {order:?}"),
            format!("sort {sort:?}"),
            format!("kernel {kernel:?}"),
            format!("compaction {compaction:?}"),
            format!("trees {:?}", self.tree),
            level.name().to_owned(),
        ]
    }
}

/// The ways of building trees that a study's policies see, the baseline's first.
pub(crate) fn ways(subjects: &[Subject]) -> Vec<TreeBuilder> {
    let mut ways = Vec::new();
    for subject in subjects {
        if !ways.contains(&subject.tree) {
            ways.push(subject.tree);
        }
    }
    ways
}

/// How many intervals a study shows: of all that is compared with a baseline, and of the baseline itself as the control.
pub(crate) fn intervals(study: &Study, subjects: &[Subject]) -> usize {
    let if_many = |number: usize| if number > 1 { number } else { 0 };
    let sets = study.parameters.len();
    study.scenes.len() * (sets * (if_many(subjects.len()) + if_many(ways(subjects).len())) + if_many(sets))
}

/// All policies of a study, the baseline first.
pub(crate) fn subjects(study: &Study) -> Result<Vec<Subject>, Failure> {
    study.policies.iter().map(Subject::new).collect()
}
