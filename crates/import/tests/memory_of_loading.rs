//! Loading a glTF file takes at most a stated multiple of its size in memory, beside the entities that it becomes.

#![expect(unsafe_code, reason = "an allocator that counts is the only way to see how much memory is taken")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use brewster_import::Importer;
use serde_json::json;

/// The system's allocator, counting bytes.
struct Counting;

static LIVE: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

fn take(bytes: usize) {
    let live = LIVE.fetch_add(bytes, Ordering::Relaxed) + bytes;
    MOST.fetch_max(live, Ordering::Relaxed);
}

// SAFETY: everything is passed on to the system's allocator, and counting allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        take(layout.size());
        // SAFETY: the caller's promises are the system's conditions.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's promises are the system's conditions.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// What `gltf.md` states: bytes of memory for each byte of a file whose numbers are not compressed.
const MULTIPLE: usize = 6;

/// A sheet of squares with side vertices a side: positions, normals and texture coordinates.
fn sheet(side: usize) -> Vec<u8> {
    let place = |i: usize| i as f32 / side as f32;
    let vertices: Vec<[f32; 8]> = (0..side * side)
        .map(|i| [place(i % side), place(i / side), 0.0, 0.0, 0.0, 1.0, place(i % side), place(i / side)])
        .collect();
    let mut binary: Vec<u8> = Vec::new();
    for (from, to) in [(0, 3), (3, 6), (6, 8)] {
        binary.extend(vertices.iter().flat_map(|vertex| &vertex[from..to]).flat_map(|number| number.to_le_bytes()));
    }
    let squares = (0..(side - 1) * (side - 1)).map(|i| i / (side - 1) * side + i % (side - 1));
    let corners = squares.flat_map(|i| [i, i + 1, i + side, i + side, i + 1, i + side + 1]);
    binary.extend(corners.flat_map(|corner| (corner as u32).to_le_bytes()));
    let (count, indices) = (side * side, 6 * (side - 1) * (side - 1));
    let view = |offset: usize, length: usize| json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
    let accessor = |view: u32, component: u32, count: usize, kind: &str| json!({"bufferView": view, "componentType": component, "count": count, "type": kind, "min": [0, 0, 0], "max": [1, 1, 1]});
    let file = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3}]}],
        "buffers": [{"byteLength": binary.len()}],
        "bufferViews": [
            view(0, 12 * count), view(12 * count, 12 * count), view(24 * count, 8 * count), view(32 * count, 4 * indices),
        ],
        "accessors": [
            accessor(0, 5126, count, "VEC3"), accessor(1, 5126, count, "VEC3"), accessor(2, 5126, count, "VEC2"),
            json!({"bufferView": 3, "componentType": 5125, "count": indices, "type": "SCALAR"}),
        ],
    });
    let mut text = file.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let number = |value: usize| (value as u32).to_le_bytes();
    let length = 28 + text.len() + binary.len();
    let head = [*b"glTF", number(2), number(length), number(text.len()), *b"JSON"].concat();
    [head, text, [number(binary.len()), *b"BIN\0"].concat(), binary].concat()
}

#[test]
fn a_file_takes_a_few_times_its_size() {
    for side in [100, 400] {
        let bytes = sheet(side);
        let before = LIVE.load(Ordering::Relaxed);
        MOST.store(before, Ordering::Relaxed);
        let loaded = Importer::default().load_gltf(Path::new("sheet.glb"), &bytes).expect("it is right");
        let most = MOST.load(Ordering::Relaxed) - before;
        // The studio that lights a file without lights is there for files of any size.
        let studio = 16 << 20;
        assert!(most < MULTIPLE * bytes.len() + studio, "{most} bytes for a file of {}", bytes.len());
        assert!(most > bytes.len(), "the allocator does not count: {most}");
        drop(loaded);
    }
}
