//! Wavefront OBJ: positions, normals, texture coordinates and faces. Groups, objects and materials are read over: an
//! entity has one material.
//!
//! Read here and not by a crate because an error has to name its line: `tobj` 4.0 says what kind of line was wrong, but not
//! which one.

use std::collections::HashMap;

use brewster_world::components::parts::TriangleMesh;
use glam::{Vec2, Vec3};

use super::Problem;
use crate::session::Budgets;

/// Reads a file. A polygon becomes a fan around its first corner.
///
/// Corners that differ in normal or texture coordinates become vertices of their own, in the order of their first use. Where
/// some corners lack a normal (or texture coordinates), none is used.
pub(super) fn read(bytes: &[u8], budgets: &mut Budgets) -> Result<TriangleMesh, Problem> {
    let mut file = File::default();
    let mut at = 0;
    while at < bytes.len() {
        let length = bytes[at..].iter().position(|&byte| byte == b'\n').unwrap_or(bytes.len() - at);
        file.line(&bytes[at..at + length], at, budgets)?;
        at += length + 1;
    }
    if file.corners.is_empty() {
        return Err(Problem {
            expected: Some("lines that begin with `f`"),
            ..Problem::new(None, "the mesh has no faces")
        });
    }
    file.mesh(budgets)
}

/// Row numbers of a corner's position, texture coordinates and normal; [`ABSENT`] where there is none.
type Corner = [u32; 3];

const ABSENT: u32 = u32::MAX;

#[derive(Default)]
struct File {
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// Three a triangle.
    corners: Vec<Corner>,
}

/// A word of a line, and its bytes in the file.
#[derive(Clone, Copy)]
struct Word<'f> {
    text: &'f str,
    start: usize,
}

impl Word<'_> {
    fn place(self) -> Option<(u32, u32)> {
        Some((u32::try_from(self.start).ok()?, u32::try_from(self.start + self.text.len()).ok()?))
    }

    fn number(self) -> Result<f32, Problem> {
        let number = self.text.parse::<f32>().ok().filter(|number| number.is_finite());
        number.ok_or_else(|| Problem {
            expected: Some("a finite number"),
            ..Problem::new(self.place(), format!("`{}` is not a number", self.text))
        })
    }
}

impl File {
    fn line(&mut self, line: &[u8], start: usize, budgets: &mut Budgets) -> Result<(), Problem> {
        let line = line.split(|&byte| byte == b'#').next().unwrap_or(b"");
        let mut words = words(line, start)?;
        let Some(kind) = words.next() else { return Ok(()) };
        match kind.text {
            "v" => {
                let position = Vec3::from(numbers(kind, &mut words)?);
                budgets.vertices.take(1).map_err(|over| Problem::exceeded(kind.place(), "vertices", over))?;
                self.positions.push(position);
            }
            "vn" => self.normals.push(Vec3::from(numbers(kind, &mut words)?)),
            "vt" => self.uvs.push(Vec2::from(numbers(kind, &mut words)?)),
            "f" => self.face(kind, words, budgets)?,
            _ => {}
        }
        Ok(())
    }

    fn face<'f>(
        &mut self,
        kind: Word<'f>,
        words: impl Iterator<Item = Word<'f>>,
        budgets: &mut Budgets,
    ) -> Result<(), Problem> {
        let (mut first, mut last) = (None, None);
        let mut corners = 0;
        for word in words {
            let corner = self.corner(word)?;
            corners += 1;
            if let (Some(first), Some(last)) = (first, last) {
                budgets.triangles.take(1).map_err(|over| Problem::exceeded(kind.place(), "triangles", over))?;
                self.corners.extend([first, last, corner]);
            }
            first.get_or_insert(corner);
            if corners > 1 {
                last = Some(corner);
            }
        }
        if corners < 3 {
            let expected = Some("three corners or more");
            return Err(Problem { expected, ..Problem::new(kind.place(), format!("a face of {corners} corners")) });
        }
        Ok(())
    }

    /// `position`, `position/uv`, `position//normal` or `position/uv/normal`, from 1, or from the last one backwards.
    fn corner(&self, word: Word) -> Result<Corner, Problem> {
        let lengths = [self.positions.len(), self.uvs.len(), self.normals.len()];
        let nouns = ["position", "texture coordinate", "normal"];
        let mut corner = [ABSENT; 3];
        let no_corner = || Problem {
            expected: Some("v, v/vt, v//vn or v/vt/vn with whole numbers"),
            ..Problem::new(word.place(), format!("`{}` is no corner", word.text))
        };
        if word.text.starts_with('/') || word.text.split('/').count() > 3 {
            return Err(no_corner());
        }
        for (i, part) in word.text.split('/').enumerate() {
            if part.is_empty() {
                continue;
            }
            let number = part.parse::<i64>().map_err(|_| no_corner())?;
            let row = if number < 0 { lengths[i] as i64 + number } else { number - 1 };
            if row < 0 || row >= lengths[i] as i64 {
                let message = format!("there is no {} {number}: {} come before this line", nouns[i], lengths[i]);
                return Err(Problem::new(word.place(), message));
            }
            corner[i] = row as u32;
        }
        Ok(corner)
    }

    fn mesh(self, budgets: &mut Budgets) -> Result<TriangleMesh, Problem> {
        let has = |part: usize| self.corners.iter().all(|corner| corner[part] != ABSENT);
        let (has_uvs, has_normals) = (has(1), has(2));
        if !has_uvs && !has_normals {
            let triangles = self.corners.chunks_exact(3).map(|c| [c[0][0], c[1][0], c[2][0]]).collect();
            return Ok(TriangleMesh { positions: self.positions, triangles, ..Default::default() });
        }
        let mut mesh = TriangleMesh::default();
        let mut rows: HashMap<Corner, u32> = HashMap::new();
        let mut indices = Vec::with_capacity(self.corners.len());
        for &[position, uv, normal] in &self.corners {
            let uv = if has_uvs { uv } else { ABSENT };
            let normal = if has_normals { normal } else { ABSENT };
            let next = mesh.positions.len() as u32;
            let row = *rows.entry([position, uv, normal]).or_insert(next);
            if row == next {
                if next as usize >= self.positions.len() {
                    budgets.vertices.take(1).map_err(|over| Problem::exceeded(None, "vertices", over))?;
                }
                mesh.positions.push(self.positions[position as usize]);
                mesh.uvs.extend(self.uvs.get(uv as usize));
                mesh.normals.extend(self.normals.get(normal as usize));
            }
            indices.push(row);
        }
        mesh.triangles = indices.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
        Ok(mesh)
    }
}

/// The first numbers of a line. More may follow: a weight, or colors.
fn numbers<'f, const N: usize>(kind: Word, words: &mut impl Iterator<Item = Word<'f>>) -> Result<[f32; N], Problem> {
    let mut numbers = [0.0; N];
    for (i, number) in numbers.iter_mut().enumerate() {
        *number = match words.next() {
            Some(word) => word.number()?,
            // Texture coordinates may lack the second number.
            None if kind.text == "vt" && i == 1 => 0.0,
            None => return Err(Problem::new(kind.place(), format!("`{}` needs {N} numbers, found {i}", kind.text))),
        };
    }
    Ok(numbers)
}

fn words(line: &[u8], start: usize) -> Result<impl Iterator<Item = Word<'_>>, Problem> {
    // Names of groups and materials may be in any encoding; they are not needed.
    let text = match str::from_utf8(line) {
        Ok(text) => text,
        Err(_) if line.first().is_some_and(|byte| !matches!(byte, b'v' | b'f')) => "",
        Err(error) => {
            let at = (start + error.valid_up_to()) as u32;
            return Err(Problem::new(Some((at, at + 1)), "the line is not text"));
        }
    };
    let base = text.as_ptr() as usize;
    Ok(text
        .split_ascii_whitespace()
        .map(move |word| Word { text: word, start: start + (word.as_ptr() as usize - base) }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::{Budget, Limits};

    fn budgets(limits: &Limits) -> Budgets {
        Budgets {
            pixels: Budget::new("image_pixels", limits.image_pixels),
            vertices: Budget::new("vertices", limits.vertices),
            triangles: Budget::new("triangles", limits.triangles),
        }
    }

    fn read_text(text: &str) -> Result<TriangleMesh, Problem> {
        read(text.as_bytes(), &mut budgets(&Limits::DEFAULT))
    }

    #[test]
    fn a_square_becomes_a_fan() {
        let mesh =
            read_text("# a square\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\no square\nf 1 2 3 4\n").expect("it reads");
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.positions[2], Vec3::new(1.0, 1.0, 0.0));
        assert!(mesh.normals.is_empty() && mesh.uvs.is_empty());
    }

    #[test]
    fn corners_with_other_normals_are_other_vertices() {
        let text =
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 0 -1\nvt 0.5\nf 1/1/1 2/1/1 3/1/1\nf -3/-1/-1 -1/1/2 -2/1/2";
        let mesh = read_text(text).expect("it reads");
        assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(mesh.positions[4], Vec3::Y);
        assert_eq!(mesh.normals, [[Vec3::Z; 3], [Vec3::NEG_Z; 3]].concat());
        assert_eq!(mesh.uvs, [Vec2::new(0.5, 0.0); 6]);
    }

    #[test]
    fn a_normal_that_some_corner_lacks_is_not_used() {
        let mesh = read_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3\n").expect("it reads");
        assert!(mesh.normals.is_empty());
        assert_eq!(mesh.positions.len(), 3);
    }

    #[test]
    fn errors_name_the_place_and_the_limit() {
        let few = Limits { vertices: 3, triangles: 1, ..Limits::DEFAULT };
        for (text, place, message) in [
            ("v 0 0\n", Some((0, 1)), "`v` needs 3 numbers, found 2"),
            ("v 0 0 x\n", Some((6, 7)), "`x` is not a number"),
            ("v 0 0 nan\n", Some((6, 9)), "`nan` is not a number"),
            ("v 0 0 0\nf 1 1 2", Some((14, 15)), "there is no position 2: 1 come before this line"),
            ("v 0 0 0\nf 1 1 0", Some((14, 15)), "there is no position 0: 1 come before this line"),
            ("v 0 0 0\nf 1/1/1/1 1 1", Some((10, 17)), "`1/1/1/1` is no corner"),
            ("v 0 0 0\nf 1//x 1 1", Some((10, 14)), "`1//x` is no corner"),
            ("v 0 0 0\nf 1 1\n", Some((8, 9)), "a face of 2 corners"),
            ("v 0 0 0\n", None, "the mesh has no faces"),
            ("v 0 0 \u{e9}\n", Some((6, 8)), "`\u{e9}` is not a number"),
            (
                "v 0 0 0\nv 0 0 0\nv 0 0 0\nv 0 0 0",
                Some((24, 25)),
                "the mesh has too many vertices: limit `vertices` is 3",
            ),
            ("v 0 0 0\nf 1 1 1 1\n", Some((8, 9)), "the mesh has too many triangles: limit `triangles` is 1"),
        ] {
            let problem = read(text.as_bytes(), &mut budgets(&few)).expect_err(text);
            assert_eq!((problem.place, problem.message.as_str()), (place, message), "{text:?}");
        }
        assert!(read(b"v 0 0 \xff\n", &mut budgets(&few)).is_err());
    }
}
