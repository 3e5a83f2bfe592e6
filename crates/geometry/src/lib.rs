//! Where a ray meets the scene: shapes, trees and traversal kernels.
