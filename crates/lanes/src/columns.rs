//! The `columns!` macro: a field is written once and becomes a column everywhere.

/// Appends those values to a column that are marked; `all` says that all of them are.
#[doc(hidden)]
#[inline(always)]
pub fn extend_marked<T: Copy>(column: &mut Vec<T>, values: &[T], marks: &[bool], all: bool) {
    let start = column.len();
    column.extend_from_slice(values);
    if all {
        return;
    }
    let (fresh, mut count) = (&mut column[start..], 0);
    for (&value, &mark) in values.iter().zip(marks) {
        fresh[count] = value;
        count += usize::from(mark);
    }
    column.truncate(start + count);
}

/// Declares a row and, from the same fields, the owner of its columns, a shared view and an exclusive view.
///
/// `struct Row => Columns, View, ViewMut { pub field: Type, … }`; every type is `Copy` and has a `PartialEq`.
///
/// - The owner keeps its columns private and of one length; it grows by `push`, keeps its memory on `clear`, and costs
///   `BYTES_PER_ROW` for each row. Any number of threads may read it; one owner writes.
/// - Views are slices of one length with public fields. `split_at` consumes an exclusive view, so that a parallel split
///   needs no `unsafe`.
#[macro_export]
macro_rules! columns {
    (
        $(#[$meta:meta])*
        $vis:vis struct $Row:ident => $Columns:ident, $View:ident, $ViewMut:ident {
            $( $(#[$field_meta:meta])* pub $field:ident : $type:ty ),* $(,)?
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        $vis struct $Row {
            $( $(#[$field_meta])* pub $field: $type, )*
        }

        #[doc = concat!("Rows of [`", stringify!($Row), "`], stored as columns of one length.")]
        #[derive(Clone, Debug, Default, PartialEq)]
        $vis struct $Columns {
            $( $field: Vec<$type>, )*
        }

        #[doc = concat!("A shared view of [`", stringify!($Columns), "`].")]
        #[derive(Clone, Copy, Debug)]
        $vis struct $View<'a> {
            $( $(#[$field_meta])* pub $field: &'a [$type], )*
        }

        #[doc = concat!("An exclusive view of [`", stringify!($Columns), "`].")]
        #[derive(Debug)]
        $vis struct $ViewMut<'a> {
            $( $(#[$field_meta])* pub $field: &'a mut [$type], )*
        }

        #[allow(dead_code, unreachable_pub, reason = "a declaration offers all of it, whatever its crate uses")]
        impl $Columns {
            /// Bytes that one row takes in all columns together.
            pub const BYTES_PER_ROW: usize = 0 $( + ::core::mem::size_of::<$type>() )*;

            /// Columns without rows; takes no memory.
            pub const fn new() -> Self {
                Self { $( $field: Vec::new(), )* }
            }

            /// Columns without rows, with memory for `capacity` of them.
            pub fn with_capacity(capacity: usize) -> Self {
                Self { $( $field: Vec::with_capacity(capacity), )* }
            }

            /// The number of rows.
            #[inline]
            #[allow(unreachable_code, reason = "the first column speaks for all")]
            pub fn len(&self) -> usize {
                $( return self.$field.len(); )*
            }

            /// Whether there are no rows.
            #[inline]
            pub fn is_empty(&self) -> bool {
                self.len() == 0
            }

            /// Rows that fit without taking more memory.
            #[allow(unreachable_code, reason = "the columns grow together; the first speaks for all")]
            pub fn capacity(&self) -> usize {
                $( return self.$field.capacity(); )*
            }

            /// Takes memory for `additional` more rows.
            pub fn reserve(&mut self, additional: usize) {
                $( self.$field.reserve(additional); )*
            }

            /// Appends a row.
            #[inline]
            pub fn push(&mut self, row: $Row) {
                $( self.$field.push(row.$field); )*
            }

            /// Appends those rows of a view that are marked, without a branch on any of them; panics unless there is a mark for each.
            #[inline(always)]
            pub fn extend_marked(&mut self, view: $View<'_>, marks: &[bool]) {
                assert_eq!(view.len(), marks.len(), "a mark for each row");
                let all = marks.iter().fold(true, |all, &mark| all & mark);
                $( $crate::extend_marked(&mut self.$field, view.$field, marks, all); )*
            }

            /// Inserts a row before row `index`; panics beyond the end.
            pub fn insert(&mut self, index: usize, row: $Row) {
                $( self.$field.insert(index, row.$field); )*
            }

            /// Removes row `index` and closes the gap; panics beyond the end.
            pub fn remove(&mut self, index: usize) -> $Row {
                $Row { $( $field: self.$field.remove(index), )* }
            }

            /// Row `index`; panics beyond the end.
            #[inline]
            pub fn get(&self, index: usize) -> $Row {
                $Row { $( $field: self.$field[index], )* }
            }

            /// Overwrites row `index`; panics beyond the end.
            #[inline]
            pub fn set(&mut self, index: usize, row: $Row) {
                $( self.$field[index] = row.$field; )*
            }

            /// Appends copies of all rows of a view.
            pub fn extend_from_view(&mut self, view: $View<'_>) {
                $( self.$field.extend_from_slice(view.$field); )*
            }

            /// Makes the columns `len` rows long, with copies of `row` where they grow.
            pub fn resize(&mut self, len: usize, row: $Row) {
                $( self.$field.resize(len, row.$field); )*
            }

            /// Drops the rows from `len` on; keeps the memory.
            pub fn truncate(&mut self, len: usize) {
                $( self.$field.truncate(len); )*
            }

            /// Drops all rows; keeps the memory.
            pub fn clear(&mut self) {
                $( self.$field.clear(); )*
            }

            /// All rows, shared.
            #[inline]
            pub fn view(&self) -> $View<'_> {
                $View { $( $field: &self.$field, )* }
            }

            /// All rows, exclusive.
            #[inline]
            pub fn view_mut(&mut self) -> $ViewMut<'_> {
                $ViewMut { $( $field: &mut self.$field, )* }
            }
        }

        impl FromIterator<$Row> for $Columns {
            fn from_iter<I: IntoIterator<Item = $Row>>(rows: I) -> Self {
                let mut columns = Self::new();
                for row in rows {
                    columns.push(row);
                }
                columns
            }
        }

        #[allow(dead_code, unreachable_pub, reason = "a declaration offers all of it, whatever its crate uses")]
        impl<'a> $View<'a> {
            /// A row as columns of one row.
            #[inline(always)]
            pub fn of(row: &'a $Row) -> $View<'a> {
                $View { $( $field: ::core::slice::from_ref(&row.$field), )* }
            }

            /// The number of rows.
            #[inline]
            #[allow(unreachable_code, reason = "the first column speaks for all")]
            pub fn len(&self) -> usize {
                $( return self.$field.len(); )*
            }

            /// Whether there are no rows.
            #[inline]
            pub fn is_empty(&self) -> bool {
                self.len() == 0
            }

            /// Row `index`; panics beyond the end.
            #[inline(always)]
            pub fn get(&self, index: usize) -> $Row {
                $Row { $( $field: self.$field[index], )* }
            }

            /// The rows of a range; panics beyond the end.
            #[inline]
            pub fn slice(&self, range: ::core::ops::Range<usize>) -> $View<'a> {
                $View { $( $field: &self.$field[range.clone()], )* }
            }
        }

        #[allow(dead_code, unreachable_pub, reason = "a declaration offers all of it, whatever its crate uses")]
        impl<'a> $ViewMut<'a> {
            /// The number of rows.
            #[inline]
            #[allow(unreachable_code, reason = "the first column speaks for all")]
            pub fn len(&self) -> usize {
                $( return self.$field.len(); )*
            }

            /// Whether there are no rows.
            #[inline]
            pub fn is_empty(&self) -> bool {
                self.len() == 0
            }

            /// Overwrites row `index`; panics beyond the end.
            #[inline]
            pub fn set(&mut self, index: usize, row: $Row) {
                $( self.$field[index] = row.$field; )*
            }

            /// The rows before `middle` and those from it on; panics beyond the end.
            pub fn split_at(self, middle: usize) -> ($ViewMut<'a>, $ViewMut<'a>) {
                $( let $field = self.$field.split_at_mut(middle); )*
                ($ViewMut { $( $field: $field.0, )* }, $ViewMut { $( $field: $field.1, )* })
            }

            /// The same rows, shared.
            pub fn as_view(&self) -> $View<'_> {
                $View { $( $field: &*self.$field, )* }
            }

            /// The same rows for a shorter time.
            pub fn reborrow(&mut self) -> $ViewMut<'_> {
                $ViewMut { $( $field: &mut *self.$field, )* }
            }
        }
    };
}

#[cfg(test)]
mod tests {
    columns! {
        /// A row for the tests.
        struct Pair => PairColumns, PairView, PairViewMut {
            /// A number.
            pub number: f64,
            /// A letter.
            pub letter: u8,
        }
    }

    const ROWS: [Pair; 4] = [
        Pair { number: 0.5, letter: b'a' },
        Pair { number: 1.5, letter: b'b' },
        Pair { number: 2.5, letter: b'c' },
        Pair { number: 3.5, letter: b'd' },
    ];

    #[test]
    fn rows_come_back_as_they_went_in() {
        let mut columns: PairColumns = ROWS.into_iter().collect();
        assert_eq!(PairColumns::BYTES_PER_ROW, 9);
        assert_eq!((0..4).map(|i| columns.get(i)).collect::<Vec<_>>(), ROWS);
        assert_eq!(columns.remove(1), ROWS[1]);
        columns.insert(0, ROWS[1]);
        assert_eq!((0..4).map(|i| columns.view().letter[i]).collect::<Vec<_>>(), b"bacd");
        columns.set(3, ROWS[0]);
        assert_eq!(columns.view().slice(2..4).letter, b"ca");
        assert_eq!((PairView::of(&ROWS[3]).len(), PairView::of(&ROWS[3]).get(0)), (1, ROWS[3]));
        columns.truncate(1);
        assert_eq!(columns.len(), 1);
        columns.clear();
        assert!(columns.is_empty() && columns.capacity() >= 4);
    }

    #[test]
    fn an_exclusive_view_splits_into_disjoint_halves() {
        let mut columns: PairColumns = ROWS.into_iter().collect();
        let (mut left, mut right) = columns.view_mut().split_at(1);
        assert_eq!((left.len(), right.len()), (1, 3));
        left.set(0, ROWS[3]);
        right.reborrow().set(2, ROWS[0]);
        assert_eq!(right.as_view().get(2), ROWS[0]);
        assert_eq!(columns.view().letter, b"dbca");
    }

    /// Every choice of four rows, behind one that is there already: what is expected is a filter's.
    #[test]
    fn marked_rows_are_appended_in_their_order() {
        let rows: PairColumns = ROWS.into_iter().collect();
        for choice in 0..16 {
            let marks = [0, 1, 2, 3].map(|row| choice >> row & 1 == 1);
            let mut columns: PairColumns = [ROWS[3]].into_iter().collect();
            columns.extend_marked(rows.view(), &marks);
            let marked = ROWS.into_iter().zip(marks).filter(|(_, mark)| *mark).map(|(row, _)| row);
            assert_eq!(columns, [ROWS[3]].into_iter().chain(marked).collect());
        }
    }

    #[test]
    #[should_panic(expected = "a mark for each row")]
    fn rows_without_marks_are_refused() {
        let rows: PairColumns = ROWS.into_iter().collect();
        PairColumns::new().extend_marked(rows.view(), &[true; 3]);
    }
}
