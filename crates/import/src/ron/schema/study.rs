//! The study format, field by field: what a throughput study compares. It is read like a scene.

use std::sync::OnceLock;

use super::super::decode::{Context, Decode, Fields, check_name, schema, variant};
use super::super::info::{FieldInfo, Form, Kind, Range, TypeInfo, VariantInfo};
use super::super::node::Node;
use super::super::values::{Named, Spanned};
use super::{DEPTH, Integrator, PIXELS, SAMPLES};
use crate::source::Span;

const ROUNDS: Range = Range { text: "1 to 1000", admits: |x| (1.0..=1000.0).contains(&x) };
const WARM_UP: Range = Range { text: "0 to 100", admits: |x| (0.0..=100.0).contains(&x) };
const THREADS: Range = Range { text: "1 to 1024", admits: |x| (1.0..=1024.0).contains(&x) };
const BATCH: Range = Range { text: "1 to 16777216", admits: |x| (1.0..=16_777_216.0).contains(&x) };

schema! {
    /// The whole file: every scene is rendered by every policy with every set of parameters.
    record Study {
        /// What the folder of the results is called, behind the date.
        name: String => "\"batch size\"",
        /// What the report says at its head, in the author's words. An empty line begins a new paragraph.
        text: String = "\"\"" => "\"Does a batch that fits the cache pay?\"",
        /// Scene files, seen from the folder of the study.
        scenes: Spanned<Vec<Spanned<String>>> => "[\"water-glass.ron\"]",
        /// Ways of scheduling the same work, by name. None of them changes a bit of a picture; one that does fails the study.
        policies: Spanned<Named<Policy>> = "{}" => "{\"as it is\": (), \"sorted\": (sort: Octant)}",
        /// Policies that differ from the baseline in their batch alone, named after it.
        batches: Spanned<Vec<u32>> as "rays" where BATCH = "[]" => "[1024, 4096, 16384]",
        /// The policy that all others are compared with; the first one where absent.
        baseline: Option<Spanned<String>> => "\"as it is\"",
        /// Settings of the scenes that change the picture, by name. They are compared by the noise that is left after equal time,
        /// all with the baseline's policy, and with the first of them.
        parameters: Spanned<Named<Parameters>> = "{}" => "{\"choice\": (split_depth: 0), \"split\": (split_depth: 4)}",
        /// Width and height of all pictures; as the scenes say where absent.
        resolution: Option<Spanned<[u32; 2]>> as "pixels" where PIXELS => "(320, 180)",
        /// Samples per pixel of all pictures; as the scenes say where absent.
        samples: Option<u32> where SAMPLES => "8",
        /// Rounds of measurement. In a round every policy takes a block of two runs between two of the baseline: A B B A. A policy that is
        /// alone takes one.
        rounds: u32 where ROUNDS = "9" => "15",
        /// Runs of either before a block, which are thrown away.
        warm_up: u32 where WARM_UP = "1" => "2",
    }

    /// How work is scheduled.
    record Policy {
        /// Camera rays in a batch, which is how many rays are traced at once, too.
        batch: u32 as "rays" where BATCH = "4096" => "1024",
        /// Rays traced at once, if not as many as a batch has camera rays.
        capacity: Option<u32> as "rays" where BATCH => "8192",
        /// Threads.
        threads: u32 where THREADS = "1" => "2",
        /// The key by which rays are ordered before they are traced.
        sort: Sort = "None" => "Octant",
        /// Which queue of a depth is traced first.
        order: Order = "ReflectionFirst" => "Merged",
        /// How rays are taken through the trees.
        kernel: Kernel = "Packets" => "Single",
        /// How escaped rays leave the queue of hits.
        compaction: Compaction = "Branch" => "Cursor",
        /// How trees over triangles and instances are built.
        tree: Tree = "Binned" => "Clustered",
        /// The instruction set that kernels are compiled for; one that the machine lacks is an error.
        level: Level = "Best" => "Avx2",
        /// How paths are followed.
        executor: Executor = "Wavefront" => "Megakernel",
    }

    /// The key by which rays are ordered.
    choice Sort {
        /// As they come.
        None {},
        /// By the material of the surface that they left.
        Material {},
        /// By the octant of their direction.
        Octant {},
        /// By the place of their origin on a Morton curve.
        Morton {},
        /// By octant, then along the curve.
        OctantMorton {},
    }

    /// Which queue of a depth is traced first.
    choice Order {
        /// Reflections, then transmissions.
        ReflectionFirst {},
        /// Transmissions, then reflections.
        TransmissionFirst {},
        /// Both together, as one queue.
        Merged {},
    }

    /// How rays are taken through the trees.
    choice Kernel {
        /// Packets of sixteen coherent rays on AVX-512, all others in waves.
        Packets {},
        /// Many rays in flight, each on its own way.
        Wave {},
        /// One ray after the other.
        Single {},
        /// One ray after the other, by obvhs's traversal of its own binary trees, over the same instances and patches of triangles.
        Obvhs {},
    }

    /// How escaped rays leave the queue of hits.
    choice Compaction {
        /// Row by row, at a branch.
        Branch {},
        /// Before the others are looked at: every row is written to both lists, and the cursor of one goes on.
        Cursor {},
    }

    /// How trees are built. The time that it takes is compared apart from that of pictures.
    choice Tree {
        /// From the top down, by the surfaces of bins.
        Binned {},
        /// From the bottom up, by obvhs: clustering and reinsertion.
        Clustered {},
    }

    /// How paths are followed.
    choice Executor {
        /// A batch at a time, one bounce after the other, from queue to queue.
        Wavefront {},
        /// One path at a time to its end, ray by ray, without queues: capacity, sort, order, kernel and compaction mean nothing then.
        Megakernel {},
    }

    /// An instruction set.
    choice Level {
        /// The best that the machine has.
        Best {},
        /// AVX-512.
        Avx512 {},
        /// AVX2 and FMA.
        Avx2 {},
        /// What every machine has: SSE2 on x86-64.
        Baseline {},
    }

    /// Settings of a scene that change its picture; as the scene says where absent.
    record Parameters {
        /// How light is carried.
        integrator: Option<Integrator> => "Path",
        /// `Path`: interactions before which a dielectric sends both rays.
        split_depth: Option<u32> where DEPTH => "3",
        /// `Path`: whether diffuse surfaces look for the light that mirrors and glass throw on them.
        guiding: Option<bool> => "true",
        /// Samples per pixel.
        samples: Option<u32> where SAMPLES => "16",
        /// The number of interactions on a path that may scatter on.
        max_depth: Option<u32> where DEPTH => "8",
    }
}
