//! What the command line promises, tried on the program itself.
//!
//! - `render_writes_pictures`: every format, option and error of `render`.
//! - `stats_agree`: counts do not depend on threads or batches, and every field is documented.
//! - `replay_repeats`: tapes run to the same result, and bad ones are refused.
//! - `ctrl_c_saves`: an interrupted render, or one with a time limit, leaves what is finished.
//! - `gltf_renders`: pictures of glTF files, views, frames, and the report.
//! - `gltf_views`: every argument that chooses a part of a glTF file, a camera, a moment or a sky.
//! - `watch_follows_edits`: a preview follows its files and survives broken ones.
//! - `check_tells`: what is wrong with a scene, as text and as JSON.
//! - `explain_tells`: how a pixel's light came about adds up, and every field is documented.
//! - `fresnel_tabulates`: reflectance at known angles, and its plots.
//! - `compare_measures`: figures and maps of differences worked out by hand.
//! - `study_measures`: the folder of a study, an interrupted one, and broken study files.
//! - `shells_are_served`: completions and manual pages.

mod door {
    pub(crate) mod desk;

    mod check_tells;
    mod compare_measures;
    #[cfg(unix)]
    mod ctrl_c_saves;
    mod explain_tells;
    mod fresnel_tabulates;
    mod gltf_renders;
    mod gltf_views;
    mod render_writes_pictures;
    mod replay_repeats;
    mod shells_are_served;
    mod stats_agree;
    #[cfg(unix)]
    mod study_measures;
    mod watch_follows_edits;
}
