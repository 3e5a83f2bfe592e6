//! What a glTF file is wrapped in: the chunks of a GLB, and the URIs by which it refers to other files or holds them.

use base64::Engine;
use base64::engine::general_purpose::GeneralPurpose;
use base64::engine::{DecodePaddingMode, GeneralPurposeConfig};

use super::{Found, broken};

/// The parts of a GLB, or a whole .gltf file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Container<'f> {
    pub json: &'f [u8],
    /// The binary chunk, padding included.
    pub binary: Option<&'f [u8]>,
}

const MAGIC: &[u8] = b"glTF";
const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BINARY: u32 = u32::from_le_bytes(*b"BIN\0");

impl Container<'_> {
    /// Takes a file apart. What starts as a GLB is one, whatever its name.
    pub(super) fn open(bytes: &[u8]) -> Found<Container<'_>> {
        if !bytes.starts_with(MAGIC) {
            // Some writers begin with a byte order mark, which JSON does not know.
            let json = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
            return Ok(Container { json, binary: None });
        }
        let word = |at: usize| {
            let word = bytes.get(at..).and_then(|rest| rest.first_chunk()).copied();
            word.map(u32::from_le_bytes).ok_or_else(|| Box::new(broken("", "the GLB ends in the middle of a header")))
        };
        match word(4)? {
            2 => {}
            other => return Err(broken("", format!("the GLB is of version {other}")).expected("version 2").into()),
        }
        let stated = word(8)? as usize;
        if stated > bytes.len() {
            let message = format!("the GLB says it has {stated} bytes, but the file has {}", bytes.len());
            return Err(broken("", message).help("it was probably cut off").into());
        }
        let (mut at, mut chunks) = (12, Vec::new());
        // Chunks after the first two are for extensions that no file here uses.
        while at < stated && chunks.len() < 2 {
            let (length, kind) = (word(at)? as usize, word(at + 4)?);
            let Some(chunk) = bytes[..stated].get(at + 8..).and_then(|rest| rest.get(..length)) else {
                let message = format!("chunk {} of {length} bytes goes beyond the GLB's end", chunks.len());
                return Err(broken("", message).into());
            };
            chunks.push((kind, chunk));
            at += 8 + length.next_multiple_of(4);
        }
        match chunks[..] {
            [(JSON, json), (BINARY, binary)] => Ok(Container { json, binary: Some(binary) }),
            [(JSON, json), ..] => Ok(Container { json, binary: None }),
            _ => Err(broken("", "the first chunk of the GLB is not JSON").into()),
        }
    }
}

/// What a URI stands for.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Uri {
    /// The bytes that it holds.
    Data(Vec<u8>),
    /// A file's name, relative to the file it stands in.
    File(String),
}

impl Uri {
    /// Reads a URI: `data:` or relative.
    pub(super) fn parse(uri: &str, path: &str) -> Found<Uri> {
        if let Some(data) = uri.strip_prefix("data:") {
            let (kind, payload) =
                data.split_once(',').ok_or_else(|| broken(path, "a data URI without a comma before its data"))?;
            let payload = percent_decoded(payload);
            if !kind.trim_end().ends_with(";base64") {
                return Ok(Uri::Data(payload));
            }
            let decoded = BASE64.decode(&payload);
            return Ok(Uri::Data(decoded.map_err(|error| broken(path, format!("the data is not base64: {error}")))?));
        }
        // A scheme is letters, digits, +, - and . before a colon; one letter is a drive of Windows.
        if let Some((scheme, _)) = uri.split_once(':')
            && scheme.starts_with(|c: char| c.is_ascii_alphabetic())
            && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
        {
            let problem =
                broken(path, format!("{uri:.60?} is no file beside this one: nothing is fetched from elsewhere"));
            return Err(problem.expected("a relative path, or a data: URI").into());
        }
        let name = String::from_utf8(percent_decoded(uri));
        Ok(Uri::File(name.map_err(|_| broken(path, format!("{uri:.60?} is not UTF-8 once decoded")))?))
    }
}

const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// The bytes that a text with `%20` and the like stands for. A percent sign without two hexadecimal digits is itself.
fn percent_decoded(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let digits = bytes.get(at + 1..at + 3).and_then(|digits| str::from_utf8(digits).ok());
        let digits = digits.filter(|digits| digits.bytes().all(|digit| digit.is_ascii_hexdigit()));
        match digits.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) if bytes[at] == b'%' => {
                decoded.push(byte);
                at += 3;
            }
            _ => {
                decoded.push(bytes[at]);
                at += 1;
            }
        }
    }
    decoded
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(version: u32, length: u32, chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
        let mut bytes = b"glTF".to_vec();
        bytes.extend(version.to_le_bytes());
        bytes.extend(length.to_le_bytes());
        for (kind, chunk) in chunks {
            bytes.extend((chunk.len() as u32).to_le_bytes());
            bytes.extend(*kind);
            bytes.extend(*chunk);
        }
        bytes
    }

    #[test]
    fn a_glb_is_its_chunks() {
        let file = glb(2, 36, &[(b"JSON", b"{}  "), (b"BIN\0", &[1, 2, 3, 4])]);
        let container = Container::open(&file).expect("it is whole");
        assert_eq!(container, Container { json: b"{}  ", binary: Some(&[1, 2, 3, 4]) });
        let file = glb(2, 24, &[(b"JSON", b"{}  ")]);
        assert_eq!(Container::open(&file).expect("it is whole"), Container { json: b"{}  ", binary: None });
        assert_eq!(Container::open(b"{}").expect("plain JSON").json, b"{}");
    }

    #[test]
    fn what_is_no_whole_glb_is_refused() {
        let whole = glb(2, 24, &[(b"JSON", b"{}  ")]);
        let short: Vec<&[u8]> = (4..whole.len()).map(|length| &whole[..length]).collect();
        let others = [
            glb(1, 24, &[(b"JSON", b"{}  ")]),
            glb(2, 28, &[(b"JSON", b"{}  ")]),
            glb(2, 24, &[(b"BIN\0", b"{}  ")]),
            glb(2, 12, &[]),
            glb(2, 0, &[]),
        ];
        for file in short.into_iter().chain(others.iter().map(Vec::as_slice)) {
            assert!(Container::open(file).is_err(), "{file:?}");
        }
    }

    #[test]
    fn uris_are_data_or_files_beside() {
        let file = |name: &str| Some(Uri::File(name.into()));
        let data = |bytes: &[u8]| Some(Uri::Data(bytes.to_vec()));
        for (uri, expected) in [
            ("a.bin", file("a.bin")),
            ("Box%20With%20Spaces.bin", file("Box With Spaces.bin")),
            ("Box With Spaces.bin", file("Box With Spaces.bin")),
            ("100%.bin", file("100%.bin")),
            ("%+1x", file("%+1x")),
            ("%C3%A9.png", file("é.png")),
            ("%FF.png", None),
            // RFC 4648: "foobar" is Zm9vYmFy, "foob" Zm9vYg==.
            ("data:application/octet-stream;base64,Zm9vYmFy", data(b"foobar")),
            ("data:;base64,Zm9vYg==", data(b"foob")),
            ("data:;base64,Zm9vYg", data(b"foob")),
            ("data:;base64,Zm9vYg%3D%3D", data(b"foob")),
            ("data:text/plain,a%20b", data(b"a b")),
            ("data:;base64,!", None),
            ("data:", None),
            ("http://example.org/a.bin", None),
            ("file:///etc/passwd", None),
        ] {
            assert_eq!(Uri::parse(uri, "buffers[0].uri").ok(), expected, "{uri}");
        }
    }
}
