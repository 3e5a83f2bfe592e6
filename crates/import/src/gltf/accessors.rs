//! Accessors: rows of numbers in any component type, with strides, sparse rows and normalized integers, checked against their
//! bytes before memory is taken.

use gltf::json::accessor::{ComponentType, Type};
use gltf::json::{Accessor, Index};

use super::document::Document;
use super::{Found, broken};

/// An accessor's rows without gaps: what is between them in the file, and between the columns of matrices, is left out.
#[derive(Clone)]
pub(super) struct Gathered {
    pub bytes: Vec<u8>,
    pub component: ComponentType,
    pub kind: Type,
    /// Whether integers stand for fractions of the largest one.
    pub normalized: bool,
    pub count: usize,
}

/// A row without bytes of its own is zero; so many such rows there may be for every byte of the file.
const ZEROS_PER_BYTE: u64 = 1024;

impl Document {
    /// The rows of an accessor; `path` is what refers to it.
    pub(super) fn gather(&self, index: Index<Accessor>, path: &str) -> Found<Gathered> {
        let accessor = &self.root.accessors[index.value()];
        let here = format!("accessors[{}]", index.value());
        let component = accessor.component_type.unwrap().0;
        let kind = accessor.type_.unwrap();
        let layout = Layout::new(kind, component);
        let count = accessor.count.0;
        if count == 0 {
            return Err(broken(format!("{here}.count"), "an accessor without rows").expected("1 or more").into());
        }
        let bytes = match accessor.buffer_view {
            Some(view) => {
                let stride = self.root.buffer_views[view.value()].byte_stride.map(|stride| stride.0 as u64);
                let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
                let bytes = self.view(view, path)?;
                layout.rows(bytes, offset, stride, count).map_err(|reason| {
                    broken(here.clone(), reason).note(format!(
                        "bufferViews[{}] has {} bytes",
                        view.value(),
                        bytes.len()
                    ))
                })?
            }
            None => {
                let size = count.checked_mul(layout.packed() as u64);
                let size = size.filter(|&size| size <= ZEROS_PER_BYTE.saturating_mul(self.size as u64));
                let message = "the accessor has no bytes, and far more rows than the file could be meant to have";
                vec![0; size.ok_or_else(|| broken(format!("{here}.count"), message))? as usize]
            }
        };
        let mut gathered = Gathered { bytes, component, kind, normalized: accessor.normalized, count: count as usize };
        if let Some(sparse) = &accessor.sparse {
            self.substitute(&mut gathered, &layout, sparse, &format!("{here}.sparse"))?;
        }
        Ok(gathered)
    }

    /// Puts the rows in their places that a sparse accessor gives anew.
    fn substitute(
        &self,
        gathered: &mut Gathered,
        layout: &Layout,
        sparse: &gltf::json::accessor::sparse::Sparse,
        path: &str,
    ) -> Found<()> {
        let count = sparse.count.0;
        if count > gathered.count as u64 {
            return Err(
                broken(format!("{path}.count"), format!("{count} rows of {} are given anew", gathered.count)).into()
            );
        }
        let (at, path_at) = (&sparse.indices, format!("{path}.indices"));
        let of_indices = Layout::new(Type::Scalar, at.component_type.unwrap().0);
        let bytes = self.view(at.buffer_view, &path_at)?;
        let rows =
            of_indices.rows(bytes, at.byte_offset.0, None, count).map_err(|reason| broken(path_at.clone(), reason))?;
        let (values, path_values) = (&sparse.values, format!("{path}.values"));
        let bytes = self.view(values.buffer_view, &path_values)?;
        let new =
            layout.rows(bytes, values.byte_offset.0, None, count).map_err(|reason| broken(path_values, reason))?;
        let size = layout.packed();
        for (row, new) in integers(&rows, of_indices.component).zip(new.chunks_exact(size)) {
            let start = row as usize * size;
            let Some(place) = gathered.bytes.get_mut(start..start + size) else {
                let message = format!("row {row} is given anew, of {} rows", gathered.count);
                return Err(broken(path_at, message).into());
            };
            place.copy_from_slice(new);
        }
        Ok(())
    }
}

impl Gathered {
    /// Rows of `N` numbers, or an error that says what would do.
    pub(super) fn floats<const N: usize>(&self, path: &str) -> Found<Vec<[f32; N]>> {
        if self.kind.multiplicity() != N {
            let message = format!("the accessor holds rows of the type {:?}", self.kind);
            return Err(broken(path, message).expected(format!("rows of {N} numbers")).into());
        }
        let numbers = self.numbers();
        Ok(numbers.as_chunks().0.to_vec())
    }

    /// Rows of whole numbers, `N` in each.
    pub(super) fn integers<const N: usize>(&self, path: &str) -> Found<Vec<[u32; N]>> {
        let is_whole = matches!(self.component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
        if self.kind.multiplicity() != N || !is_whole {
            let message = format!("the accessor holds rows of the type {:?} of {:?}", self.kind, self.component);
            return Err(broken(path, message).expected(format!("rows of {N} unsigned integers")).into());
        }
        let numbers: Vec<u32> = integers(&self.bytes, self.component).collect();
        Ok(numbers.as_chunks().0.to_vec())
    }

    /// All numbers, row after row.
    pub(super) fn numbers(&self) -> Vec<f32> {
        match self.component {
            ComponentType::I8 => self.each(|[x]| f32::from(x as i8), 127.0),
            ComponentType::U8 => self.each(|[x]| f32::from(x), 255.0),
            ComponentType::I16 => self.each(|x| f32::from(i16::from_le_bytes(x)), 32767.0),
            ComponentType::U16 => self.each(|x| f32::from(u16::from_le_bytes(x)), 65535.0),
            ComponentType::U32 => self.each(|x| u32::from_le_bytes(x) as f32, u32::MAX as f32),
            ComponentType::F32 => self.bytes.as_chunks().0.iter().map(|&x| f32::from_le_bytes(x)).collect(),
        }
    }

    /// All integers; normalized ones stand for c / largest, and for at least -1: glTF 2.0, 3.11.
    fn each<const N: usize>(&self, number: impl Fn([u8; N]) -> f32, largest: f32) -> Vec<f32> {
        let numbers = self.bytes.as_chunks().0.iter().map(|&bytes| number(bytes));
        if self.normalized { numbers.map(|x| (x / largest).max(-1.0)).collect() } else { numbers.collect() }
    }
}

fn integers(bytes: &[u8], component: ComponentType) -> impl Iterator<Item = u32> {
    bytes.chunks_exact(component.size()).map(|bytes| {
        let mut word = [0; 4];
        word[..bytes.len()].copy_from_slice(bytes);
        u32::from_le_bytes(word)
    })
}

/// How a row lies in memory: columns of `rows` components, each column at a multiple of four bytes in matrices.
struct Layout {
    columns: usize,
    rows: usize,
    component: ComponentType,
}

impl Layout {
    fn new(kind: Type, component: ComponentType) -> Layout {
        let (columns, rows) = match kind {
            Type::Scalar => (1, 1),
            Type::Vec2 => (1, 2),
            Type::Vec3 => (1, 3),
            Type::Vec4 => (1, 4),
            Type::Mat2 => (2, 2),
            Type::Mat3 => (3, 3),
            Type::Mat4 => (4, 4),
        };
        Layout { columns, rows, component }
    }

    /// Bytes of a column.
    fn column(&self) -> usize {
        self.rows * self.component.size()
    }

    /// Bytes from a column to the next.
    fn column_stride(&self) -> usize {
        if self.columns > 1 { self.column().next_multiple_of(4) } else { self.column() }
    }

    /// Bytes of a row without gaps.
    fn packed(&self) -> usize {
        self.columns * self.column()
    }

    /// The rows in a view's bytes, without gaps.
    fn rows(&self, bytes: &[u8], offset: u64, stride: Option<u64>, count: u64) -> Result<Vec<u8>, String> {
        let size = (self.columns - 1) as u64 * self.column_stride() as u64 + self.column() as u64;
        let stride = stride.filter(|&stride| stride > 0).unwrap_or(self.columns as u64 * self.column_stride() as u64);
        let end = count.checked_sub(1).map(|steps| steps.checked_mul(stride).and_then(|last| last.checked_add(size)));
        let end = end.unwrap_or(Some(0)).and_then(|end| end.checked_add(offset));
        if end.is_none_or(|end| end > bytes.len() as u64) {
            return Err(format!("{count} rows of {size} bytes, one every {stride} bytes, go beyond their view's end"));
        }
        let (offset, stride, count) = (offset as usize, stride as usize, count as usize);
        if stride == self.packed() {
            return Ok(bytes[offset..offset + count * stride].to_vec());
        }
        let mut rows = Vec::with_capacity(count * self.packed());
        for row in 0..count {
            for column in 0..self.columns {
                let start = offset + row * stride + column * self.column_stride();
                rows.extend_from_slice(&bytes[start..start + self.column()]);
            }
        }
        Ok(rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gltf::testing::{Builder, document};

    #[test]
    fn every_component_type_is_read_as_the_specification_says() {
        let gathered = |component, normalized, bytes: &[u8]| Gathered {
            bytes: bytes.to_vec(),
            component,
            kind: Type::Scalar,
            normalized,
            count: bytes.len() / component.size(),
        };
        // glTF 2.0, 3.11: f = c / 255, c / 65535, max(c / 127, -1), max(c / 32767, -1).
        for (component, normalized, bytes, expected) in [
            (ComponentType::I8, false, &[0x80u8, 0x7f][..], [-128.0, 127.0]),
            (ComponentType::I8, true, &[0x80, 0x7f], [-1.0, 1.0]),
            (ComponentType::U8, false, &[0, 255], [0.0, 255.0]),
            (ComponentType::U8, true, &[51, 255], [0.2, 1.0]),
            (ComponentType::I16, true, &[0x00, 0x80, 0xff, 0x7f], [-1.0, 1.0]),
            (ComponentType::I16, false, &[0x00, 0x80, 0xff, 0x7f], [-32768.0, 32767.0]),
            (ComponentType::U16, true, &[0, 0, 0xff, 0xff], [0.0, 1.0]),
            (ComponentType::U32, false, &[0, 0, 0, 0, 0, 0, 1, 0], [0.0, 65536.0]),
            (ComponentType::F32, false, &[0, 0, 0xc0, 0x3f, 0, 0, 0, 0xc0], [1.5, -2.0]),
        ] {
            let found = gathered(component, normalized, bytes).numbers();
            let close = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-6);
            assert!(found.len() == 2 && close, "{component:?} {normalized}: {found:?} for {expected:?}");
        }
    }

    #[test]
    fn strides_offsets_and_the_gaps_of_matrices_are_left_out() {
        let mut builder = Builder::default();
        let strided = builder.view(&[9, 1, 2, 9, 9, 3, 4, 9], Some(4));
        builder.accessor(strided, 1, 5121, 2, "VEC2");
        // A 2 x 2 matrix of bytes has its columns four bytes apart.
        let matrices = builder.view(&[1, 2, 0, 0, 3, 4, 0, 0, 5, 6, 0, 0, 7, 8], None);
        builder.accessor(matrices, 0, 5121, 2, "MAT2");
        let document = document(&builder);
        let read = |index: u32| document.gather(Index::new(index), "").map(|rows| rows.numbers()).expect("it is whole");
        assert_eq!(read(0), [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(read(1), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    }

    #[test]
    fn sparse_rows_take_the_place_of_others_or_of_zeros() {
        let mut builder = Builder::default();
        let base = builder.view(&[10, 11, 12], None);
        let at = builder.view(&[1, 0], None);
        let values = builder.view(&[77], None);
        let sparse = |base: Option<usize>, row: usize| {
            let base = base.map_or(String::new(), |base| format!("\"bufferView\":{base},"));
            format!(
                r#"{{{base}"componentType":5121,"count":3,"type":"SCALAR","sparse":{{"count":1,
                "indices":{{"bufferView":{at},"byteOffset":{row},"componentType":5121}},"values":{{"bufferView":{values}}}}}}}"#
            )
        };
        builder.accessors.extend([sparse(Some(base), 0), sparse(None, 1)]);
        let document = document(&builder);
        let read = |index: u32| document.gather(Index::new(index), "").map(|rows| rows.numbers()).expect("it is whole");
        assert_eq!(read(0), [10.0, 77.0, 12.0]);
        assert_eq!(read(1), [77.0, 0.0, 0.0]);
    }

    #[test]
    fn what_is_beyond_its_bytes_is_refused() {
        for (offset, count, kind) in [
            (0, 4u64, "VEC2"),
            (7, 1, "VEC2"),
            (0, u64::MAX, "VEC2"),
            (0, u64::MAX / 2 + 1, "VEC2"),
            (0, 0, "VEC2"),
            (0, 3, "VEC3"),
        ] {
            let mut builder = Builder::default();
            let view = builder.view(&[0; 8], None);
            builder.accessors.push(format!(
                r#"{{"bufferView":{view},"byteOffset":{offset},"componentType":5121,"count":{count},"type":"{kind}"}}"#
            ));
            if kind == "VEC2" && count == 4 {
                assert!(document(&builder).gather(Index::new(0), "").is_ok(), "eight bytes are four pairs");
            } else {
                let error = document(&builder).gather(Index::new(0), "").err().expect(kind);
                assert!(error.path.as_deref().is_some_and(|path| path.starts_with("accessors[0]")), "{error}");
            }
        }
        let mut builder = Builder::default();
        builder.accessors.push(r#"{"componentType":5126,"count":4000000000,"type":"MAT4"}"#.into());
        assert!(document(&builder).gather(Index::new(0), "").is_err(), "zeros without end");
    }
}
