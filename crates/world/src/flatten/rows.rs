//! Writing tables row by row, counting what changed.

use brewster_buffers as buffers;

use super::report::RowEdits;

/// A table of [`brewster_buffers`] that is written by row.
pub(super) trait Rows {
    /// One row.
    type Row: PartialEq;

    /// The number of rows.
    fn len(&self) -> usize;

    /// Writes row `at`, which is at most the first one that does not exist yet. Says whether something else stood there.
    fn put(&mut self, at: usize, row: Self::Row) -> bool;

    /// Drops the rows from `len` on.
    fn truncate(&mut self, len: usize);
}

impl<T: PartialEq> Rows for Vec<T> {
    type Row = T;

    fn len(&self) -> usize {
        self.len()
    }

    fn put(&mut self, at: usize, row: T) -> bool {
        let Some(old) = self.get_mut(at) else {
            self.push(row);
            return true;
        };
        let differs = *old != row;
        // Written even if equal: equal rows may differ in the sign of a zero.
        *old = row;
        differs
    }

    fn truncate(&mut self, len: usize) {
        self.truncate(len);
    }
}

macro_rules! rows {
    ($($columns:ident of $row:ident),*) => {$(
        impl Rows for buffers::$columns {
            type Row = buffers::$row;

            fn len(&self) -> usize {
                self.len()
            }

            fn put(&mut self, at: usize, row: buffers::$row) -> bool {
                if at == self.len() {
                    self.push(row);
                    return true;
                }
                let differs = self.get(at) != row;
                self.set(at, row);
                differs
            }

            fn truncate(&mut self, len: usize) {
                self.truncate(len);
            }
        }
    )*};
}

rows! {
    InstanceColumns of Instance, MaterialRowColumns of MaterialRow, LightColumns of Light,
    PhongColumns of Phong, LambertColumns of Lambert, RoughDiffuseColumns of RoughDiffuse,
    MetalColumns of Metal, DielectricColumns of Dielectric,
    EmissiveColumns of Emissive, PrincipledColumns of Principled, CoatedColumns of Coated, MixColumns of Mix
}

/// Writes rows over those of a table, the first over the first; the table becomes as long as they are.
pub(super) fn overwrite<R: Rows>(table: &mut R, rows: impl IntoIterator<Item = R::Row>) -> RowEdits {
    let before = table.len();
    let mut edits = RowEdits::default();
    let mut len = 0;
    for row in rows {
        let differs = table.put(len, row);
        edits.count(len, before, differs);
        len += 1;
    }
    table.truncate(len);
    edits.removed = before.saturating_sub(len);
    edits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overwriting_counts_what_differs() {
        let check = |old: &[i32], new: &[i32], (added, removed, rewritten): (usize, usize, usize)| {
            let mut table = old.to_vec();
            assert_eq!(overwrite(&mut table, new.to_vec()), RowEdits { added, removed, rewritten }, "{old:?} {new:?}");
            assert_eq!(table, new);
        };
        check(&[], &[], (0, 0, 0));
        check(&[], &[1, 2], (2, 0, 0));
        check(&[1, 2, 3], &[1, 4, 3], (0, 0, 1));
        check(&[1, 2, 3], &[2, 3], (0, 1, 2));
        check(&[1, 2, 3], &[], (0, 3, 0));
    }
}
