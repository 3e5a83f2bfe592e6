//! Integrators: which stages a bounce runs, in which order.
//!
//! **Depth.** A camera ray has depth 0. A ray's hit on a surface, with its direct light, is an interaction of the ray's depth;
//! it sends reflections and transmissions of depth + 1 only while depth < `max_depth`. So `max_depth` is the number of
//! interactions on a path that may scatter on: 0 shows direct light alone. Crossing a boundary that is none (inside a medium of
//! higher priority) is no interaction and leaves the depth as it is.
//!
//! What each integrator does with each thing a scene may hold:
//!
//! | | `Whitted` |
//! | --- | --- |
//! | Phong | ambient + albedo/π · N·L + highlight, shadow-tested |
//! | Lambert | albedo/π · N·L, shadow-tested |
//! | Metal | highlight · R_0, mirror image · F_r |
//! | Dielectric | highlights · F_r or F_t; reflection · F_r and transmission · F_t; absorption inside |
//! | Emissive | its radiance where a ray meets it; it lights nothing else |
//! | point, spot, directional light | direct light and highlights |
//! | ambient light | Phong's ambient term |
//! | background | what escaped rays see |
//! | thin lens | an error: this integrator takes pinhole and orthographic cameras |

mod whitted;

pub use whitted::whitted;
