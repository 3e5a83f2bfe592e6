//! What the project claims as a whole, one module a claim.
//!
//! - `attributed`: light held back, the largest contributions and what is no light are told with where they came from.
//! - `batches_agree`: the same picture, bit for bit, however work is scheduled.
//! - `closed_forms`: pictures that are known by hand.
//! - `conservation`: no ray is lost or made up between queues.
//! - `details`: normal maps, heights, opacity and mixes do what can be said of them by hand.
//! - `edits_agree`: after any series of edits the picture is that of a new scene, bit for bit.
//! - `energy_accounted`: the path integrator's ledger of energy closes.
//! - `explained`: what is told of a pixel adds up to it, to the last unit.
//! - `fresnel_error`: the difference of two Fresnel models over the same paths is that of the models.
//! - `furnace`: in light from everywhere nothing is lost but what the maximum depth cuts.
//! - `gltf_agrees`: a ball in a glTF file is the same ball with the material that it should come to.
//! - `gltf_converts`: a glTF file that was converted to RON makes the picture that the file makes.
//! - `gltf_extensions`: what glTF's extensions say reaches the scene, and the picture as their texts have it.
//! - `gltf_faults`: glTF is free of the faults that other path tracers of it are known for.
//! - `gltf_variants`: a glTF model stored in other ways makes the same picture.
//! - `guiding`: rays that look for caustics change the noise and nothing else.
//! - `layers`: crates depend on each other as the architecture page says, and on nothing else.
//! - `light_layers`: the parts of the light, the albedo and the standard errors are what they claim.
//! - `media_scatter`: fog, milk and wax scatter light as radiative transfer says.
//! - `memory_bounded`: a split tree of any depth stays within the memory that the queues' page states.
//! - `motion`: what moves looks as it does on the mean over the time of the shutter.
//! - `noise_threshold`: adaptive sampling stops where noise is low and depends on nothing but the film.
//! - `path_furnace`: the path integrator sees nothing in even light that absorbs nothing.
//! - `policies_agree`: splitting, choosing, roulette, samplers and integrators agree in mean.
//! - `principled`: glTF's material is at its ends what other materials are.
//! - `recursion_agrees`: the queues compute what a plain recursion of the lecture's algorithm computes.
//! - `references_agree`: twelve scenes look as Mitsuba 3 renders them.
//! - `references_are_whole`: every reference scene can be read, without a warning, and has its picture beside it.
//! - `self_intersection`: no specks and no leaks, at the origin and far from it.
//! - `stages_covered`: one picture uses every stage and every queue.
//! - `threads_agree`: the same picture, bit for bit, on any number of threads.
//! - `tidy`: every source file says what it is.
//!
//! What claims share: `gltf_model` makes glTF files, `scene` reads and renders, `recursion` is the plain recursion, `textbook` has the formulas.

mod attributed;
mod batches_agree;
mod closed_forms;
mod conservation;
mod details;
mod dispersion;
mod edits_agree;
mod energy_accounted;
mod explained;
mod fresnel_error;
mod furnace;
mod gltf_agrees;
mod gltf_converts;
mod gltf_extensions;
mod gltf_faults;
mod gltf_model;
mod gltf_variants;
mod guiding;
mod layers;
mod light_layers;
mod media_scatter;
mod memory_bounded;
mod motion;
mod noise_threshold;
mod path_furnace;
mod policies_agree;
mod principled;
mod recursion;
mod recursion_agrees;
mod references_agree;
mod references_are_whole;
mod scene;
mod self_intersection;
mod stages_covered;
mod textbook;
mod threads_agree;
mod tidy;
