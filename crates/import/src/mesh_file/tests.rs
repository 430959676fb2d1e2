//! A cube through every format, and broken files.

use super::*;
use std::fs;
use std::sync::atomic::{AtomicU32, Ordering};

/// A file that is gone when the test is over.
struct Temporary(PathBuf);

impl Temporary {
    fn new(name: &str, bytes: impl AsRef<[u8]>) -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let folder =
            format!("rockfall-mesh-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let folder = std::env::temp_dir().join(folder);
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join(name), bytes).unwrap();
        Temporary(folder.join(name))
    }

    /// The error without the folder.
    fn error(&self) -> String {
        let folder = format!("{}/", self.0.parent().unwrap().display());
        read(&self.0).unwrap_err().to_string().replace(&folder, "")
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(self.0.parent().unwrap());
    }
}

fn error(name: &str, bytes: impl AsRef<[u8]>) -> String {
    Temporary::new(name, bytes).error()
}

/// Corners of a cuboid, no two sides alike.
fn corner(i: u32) -> Vec3 {
    Vec3::new((i & 1) as f32, 2.0 * (i >> 1 & 1) as f32, 3.0 * (i >> 2 & 1) as f32) - Vec3::splat(0.25)
}

const SIDES: [[u32; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

fn cut() -> Vec<[u32; 3]> {
    SIDES.iter().flat_map(|s| [[s[0], s[1], s[2]], [s[0], s[2], s[3]]]).collect()
}

fn places(soup: &TriangleSoup) -> Vec<[Vec3; 3]> {
    soup.triangles.iter().map(|t| t.map(|c| soup.vertices[c as usize])).collect()
}

fn cuboid() -> Vec<[Vec3; 3]> {
    cut().into_iter().map(|t| t.map(corner)).collect()
}

fn assert_cuboid(name: &str, bytes: impl AsRef<[u8]>) {
    let file = Temporary::new(name, bytes);
    let soup = read(&file.0).unwrap();
    assert_eq!(soup.vertices.len(), 8, "{name}");
    assert_eq!(places(&soup), cuboid(), "{name}");
}

fn obj() -> String {
    let mut text = "# a cuboid\nmtllib none.mtl\no cuboid\n".to_owned();
    (0..8).map(corner).for_each(|v| text += &format!("v {} {} {}\n", v.x, v.y, v.z));
    text += "vt 0 0\nvn 0 0 1\nusemtl none\n";
    SIDES
        .map(|s| s.map(|c| c + 1))
        .iter()
        .for_each(|s| text += &format!("f {}/1/1 {}//1 {}/1 {}\n", s[0], s[1], s[2], s[3]));
    text
}

fn ascii_stl() -> String {
    let mut text = "solid\n".to_owned();
    for t in cuboid() {
        text += "facet normal nan nan nan\n  outer loop\n";
        t.iter().for_each(|v| text += &format!("    vertex {:e} {} {}\n", v.x, v.y, v.z));
        text += "  endloop\nendfacet\n";
    }
    text + "endsolid\n"
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = b"solid but binary".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(12_u32.to_le_bytes());
    for t in cuboid() {
        bytes.extend([0; 12]);
        t.iter().flat_map(|v| v.to_array()).for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn ply_header(format: &str, vertices: u32, faces: u32) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment a cuboid\nelement vertex {vertices}\nproperty float x\nproperty double y\n\
         property float z\nproperty uchar red\nelement face {faces}\nproperty uchar flags\nproperty list uchar int \
         vertex_indices\nelement other 2\nproperty list uchar short things\nend_header\n"
    )
}

fn ascii_ply() -> String {
    let mut text = ply_header("ascii", 8, 6);
    (0..8).map(corner).for_each(|v| text += &format!("{} {} {} 255\n", v.x, v.y, v.z));
    SIDES.iter().for_each(|s| text += &format!("7 4 {} {} {} {}\n", s[0], s[1], s[2], s[3]));
    text + "0\n2 5 6\n"
}

fn binary_ply(big: bool) -> Vec<u8> {
    let order = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = ply_header(order, 8, 6).into_bytes();
    let mut put = |little: &[u8]| {
        let mut number = little.to_vec();
        if big {
            number.reverse();
        }
        bytes.extend(number);
    };
    for v in (0..8).map(corner) {
        put(&v.x.to_le_bytes());
        put(&f64::from(v.y).to_le_bytes());
        put(&v.z.to_le_bytes());
        put(&[255]);
    }
    for s in SIDES {
        put(&[7]);
        put(&[4]);
        s.iter().for_each(|c| put(&c.to_le_bytes()));
    }
    put(&[0]);
    put(&[1]);
    put(&5_i16.to_le_bytes());
    bytes
}

/// Places and indices (16 bits) of the cuboid with y up.
fn gltf_buffer() -> Vec<u8> {
    let mut bytes = Vec::new();
    (0..8).map(corner).flat_map(|v| [v.x, v.z, -v.y]).for_each(|x| bytes.extend(x.to_le_bytes()));
    cut().as_flattened().iter().for_each(|c| bytes.extend((*c as u16).to_le_bytes()));
    bytes
}

/// A glTF document over the buffer of 168 bytes at `buffer`, with these nodes and more of the mesh.
fn gltf_text(buffer: &str, nodes: &str) -> String {
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}], "nodes": [{nodes}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1}}]}}],
        "buffers": [{{{buffer}"byteLength": 168}}],
        "bufferViews": [{{"buffer": 0, "byteOffset": 0, "byteLength": 96}}, {{"buffer": 0, "byteOffset": 96, "byteLength": 72}}],
        "accessors": [
            {{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [-1, -1, -2], "max": [1, 3, 1]}},
            {{"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"}}]}}"#
    )
}

fn embedded(nodes: &str) -> String {
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(gltf_buffer());
    gltf_text(&format!(r#""uri": "data:application/octet-stream;base64,{data}", "#), nodes)
}

fn glb() -> Vec<u8> {
    let mut json = gltf_text("", r#"{"mesh": 0}"#).into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let binary = gltf_buffer();
    let mut bytes = b"glTF".to_vec();
    let length = 12 + 8 + json.len() + 8 + binary.len();
    bytes.extend([2, length as u32, json.len() as u32].iter().flat_map(|n| n.to_le_bytes()));
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend((binary.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(binary);
    bytes
}

#[test]
fn a_cuboid_comes_out_of_every_format_as_it_went_in() {
    assert_cuboid("cuboid.obj", obj());
    assert_cuboid("CUBOID.OBJ", obj().replace('\n', "\r\n"));
    assert_cuboid("cuboid.stl", ascii_stl());
    assert_cuboid("cuboid.Stl", ascii_stl().to_uppercase());
    assert_cuboid("cuboid.stl", binary_stl());
    assert_cuboid("cuboid.ply", ascii_ply());
    assert_cuboid("cuboid.ply", binary_ply(false));
    assert_cuboid("cuboid.ply", binary_ply(true));
    assert_cuboid("cuboid.gltf", embedded(r#"{"mesh": 0}"#));
    assert_cuboid("cuboid.glb", glb());
}

#[test]
fn a_gltf_finds_its_buffer_beside_it() {
    let file = Temporary::new("cuboid.gltf", gltf_text(r#""uri": "the%20data.bin", "#, r#"{"mesh": 0}"#));
    assert_eq!(
        file.error(),
        "cuboid.gltf: not a sound glTF file: buffer 0: the data.bin: no such file, expected a mesh"
    );
    let buffer = file.0.with_file_name("the data.bin");
    fs::write(&buffer, &gltf_buffer()[..100]).unwrap();
    assert_eq!(
        file.error(),
        "cuboid.gltf: not a sound glTF file: buffer 0 should have 168 bytes, but has only 100"
    );
    fs::write(&buffer, gltf_buffer()).unwrap();
    assert_eq!(places(&read(&file.0).unwrap()), cuboid());
}

#[test]
fn gltf_nodes_are_placed_and_mirrors_keep_the_outside_out() {
    // Along y of the file, which is up; then mirrored and doubled along x.
    let nodes =
        r#"{"children": [1, 2], "translation": [0, 10, 0]}, {"mesh": 0}, {"mesh": 0, "scale": [-2, 1, 1]}"#;
    let file = Temporary::new("two.gltf", embedded(nodes));
    let soup = read(&file.0).unwrap();
    let mut expected: Vec<_> = cuboid().iter().map(|t| t.map(|v| v + 10.0 * Vec3::Z)).collect();
    expected.extend(
        cuboid().iter().map(|&[a, b, c]| [a, c, b].map(|v| Vec3::new(-2.0, 1.0, 1.0) * v + 10.0 * Vec3::Z)),
    );
    assert_eq!(places(&soup), expected);
}

#[test]
fn gltf_strips_and_fans_are_cut_into_triangles() {
    let with_mode = |mode: u32| {
        let text = embedded(r#"{"mesh": 0}"#).replace(r#""indices": 1"#, &format!(r#""mode": {mode}"#));
        read(&Temporary::new("mode.gltf", text).0).map(|s| s.triangles)
    };
    assert_eq!(with_mode(5).unwrap()[..3], [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
    assert_eq!(with_mode(6).unwrap()[..3], [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    assert_eq!(with_mode(4).unwrap(), [[0, 1, 2], [3, 4, 5]]);
    assert!(matches!(with_mode(1), Err(MeshFileError::NoTriangles(_))));
}

#[test]
fn several_stl_solids_are_put_together() {
    let soup = read(&Temporary::new("two.stl", ascii_stl() + &ascii_stl()).0).unwrap();
    assert_eq!((soup.vertices.len(), soup.triangles.len()), (8, 24));
}

#[test]
fn obj_corners_may_count_backwards() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0 2\nv 9 9 9 1 0 0\nf -4 -3 \\\n -2\n";
    let soup = read(&Temporary::new("back.obj", text).0).unwrap();
    assert_eq!(places(&soup), [[Vec3::ZERO, Vec3::X, 0.5 * Vec3::Y]]);
}

#[test]
fn files_that_are_none_are_refused() {
    let missing = Temporary::new("here.obj", "");
    let folder = missing.0.parent().unwrap();
    let text =
        |path: &Path| read(path).unwrap_err().to_string().replace(&folder.display().to_string(), "DIR");
    assert_eq!(text(&folder.join("there.obj")), "DIR/there.obj: no such file, expected a mesh");
    assert_eq!(text(folder), "DIR: not a file, expected a mesh");
    fs::create_dir(folder.join("folder.stl")).unwrap();
    assert_eq!(text(&folder.join("folder.stl")), "DIR/folder.stl: not a file, expected a mesh");
    assert_eq!(
        error("cuboid.step", "x"),
        "cuboid.step: can't tell the format by the name, expected .obj, .stl, .ply, .gltf or .glb"
    );
    assert_eq!(
        error("cuboid", "x"),
        "cuboid: can't tell the format by the name, expected .obj, .stl, .ply, .gltf or .glb"
    );
    for name in ["a.obj", "a.stl", "a.ply", "a.gltf", "a.glb"] {
        assert_eq!(error(name, ""), format!("{name}: the file is empty, expected a mesh"));
    }
    #[cfg(unix)]
    {
        // A file that never ends.
        std::os::unix::fs::symlink("/dev/zero", folder.join("zero.obj")).unwrap();
        assert_eq!(text(&folder.join("zero.obj")), "DIR/zero.obj: not a file, expected a mesh");
    }
}

#[test]
fn a_file_of_five_gigabytes_is_refused_without_being_read() {
    let file = Temporary::new("large.stl", "");
    File::options().write(true).open(&file.0).unwrap().set_len(5 << 30).unwrap();
    assert_eq!(file.error(), "large.stl: the file is larger than 4 GiB");
}

#[test]
fn broken_obj_files_are_refused() {
    let v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let garbage: Vec<u8> = (0..4000_u32).map(|i| (i * i / 7) as u8).collect();
    let sound = "not a sound OBJ file: line 4:";
    for (text, message) in [
        (format!("{v}f 1 2 4\n"), format!("{sound} a face names vertex 4, but there are only 3")),
        (format!("{v}f 0 1 2\n"), format!("{sound} a face names vertex 0, but there are 3 so far")),
        (format!("{v}f 1 2 -4\n"), format!("{sound} a face names vertex -4, but there are 3 so far")),
        (format!("{v}f 1 2\n"), format!("{sound} a face needs at least 3 corners")),
        (format!("{v}f 1 2 x\n"), format!("{sound} expected the number of a vertex, found `x`")),
        (
            format!("{v}f 1 2 99999999999999999999"),
            format!("{sound} expected the number of a vertex, found `99999999999999999999`"),
        ),
        (format!("{v}v 1 2\n"), format!("{sound} expected `v` and three numbers")),
        (format!("{v}v 1 2 two\n"), format!("{sound} expected `v` and three numbers")),
        (format!("{v}v 1 2 3 0\n"), "not a sound OBJ file: scaling (w) by zero".into()),
        ("v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n".into(), "vertex 1 is not finite".into()),
        ("v 0 0 0\nv 1 0 0\nv 0 1e99 0\nf 1 2 3\n".into(), "vertex 2 is not finite".into()),
        (v.into(), "there are no triangles in the file".into()),
    ] {
        assert_eq!(error("a.obj", &text), format!("a.obj: {message}"), "{text}");
    }
    assert_eq!(error("a.obj", garbage), "a.obj: there are no triangles in the file");
}

#[test]
fn broken_stl_files_are_refused() {
    let text = ascii_stl();
    let binary = binary_stl();
    let cut_off = "the file is cut off: it does not end with `endsolid`";
    let neither = "it is neither text that begins with `solid` nor long enough to be binary";
    let three = "line 4: expected `vertex` and three finite numbers";
    let mut claims = binary.clone();
    claims[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    claims[..5].copy_from_slice(b"stuff");
    let cases: Vec<(Vec<u8>, &str)> = vec![
        (text.as_bytes()[..500].to_vec(), cut_off),
        (b"solid".to_vec(), cut_off),
        (text.replacen("vertex", "vortex", 1).into_bytes(), "line 4: `vortex` has no meaning here"),
        (text.replacen("-2.5e-1", "nan", 1).into_bytes(), three),
        (text.replacen("-2.5e-1", "two", 1).into_bytes(), three),
        (text.replacen("-2.5e-1 ", "", 1).into_bytes(), three),
        (text.replacen("endloop\n", "\n", 1).into_bytes(), "expected [\"endloop\"], got [\"endfacet\"]"),
        (vec![0xff; 60], neither),
        (claims, "4294967295 triangles take 214748364834 bytes, but there are only 684"),
        ([b"stuff", &binary[5..600]].concat(), "12 triangles take 684 bytes, but there are only 600"),
    ];
    for (bytes, message) in cases {
        assert_eq!(error("a.stl", &bytes), format!("a.stl: not a sound STL file: {message}"));
    }
    let mut nan = binary.clone();
    nan[84 + 50 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(error("a.stl", nan), "a.stl: vertex 3 is not finite");
    let mut nothing = binary[..84].to_vec();
    nothing[80] = 0;
    assert_eq!(error("a.stl", nothing), "a.stl: there are no triangles in the file");
    assert_eq!(error("a.stl", "solid x\nendsolid x\n"), "a.stl: there are no triangles in the file");
}

#[test]
fn broken_ply_files_are_refused() {
    let text = ascii_ply();
    let binary = binary_ply(false);
    let face = |row: &str| text.replacen("7 4 0 2 3 1", row, 1).into_bytes();
    let first = |place: &str| text.replacen("-0.25 -0.25", place, 1).into_bytes();
    let cases: Vec<(Vec<u8>, &str)> = vec![
        (b"\xff\xfe\x00garbage".to_vec(), "stream did not contain valid UTF-8"),
        (b"ply\n".to_vec(), "Line 2: Unexpected end of file while reading header (missing 'end_header')."),
        (b"plywood\n".to_vec(), "Line 1: Expected magic number 'ply'. String: 'plywood '"),
        (text.as_bytes()[..100].to_vec(), "Line 7: Couldn't parse line. String: 'property f'"),
        (
            text.as_bytes()[..text.len() - 60].to_vec(),
            "Line 24: Couldn't read element line. String: '7 4 4 5 ' Error: Expected 4 list elements, but found only 2.",
        ),
        (
            binary[..binary.len() - 60].to_vec(),
            "Line 25: Unexpected end of file while reading binary element 'face' (expected 6, got 2). Error: Couldn't \
             find a list element at index 3. Error: failed to fill whole buffer",
        ),
        (
            text.replace("vertex 8", "vertex 4000000000").into_bytes(),
            "the header announces 4000000000 rows of `vertex`, but only 244 bytes follow",
        ),
        (
            text.replace("vertex 8", "vertex 99999999999999999999").into_bytes(),
            "Line 4: Invalid element String: 'element vertex 99999999999999999999 '",
        ),
        (
            ply_header("binary_little_endian", 4_000_000_000, 6).into_bytes(),
            "the header announces 4000000000 rows of `vertex`, but only 0 bytes follow",
        ),
        (
            b"ply\nformat binary_little_endian 1.0\nelement nothing 4000000000\nend_header\n".to_vec(),
            "its 4000000000 rows of `nothing` have no properties",
        ),
        (text.replace("property float z\n", "").into_bytes(), "its vertices have no `z`"),
        (
            text.replace("float x", "list uchar float x").into_bytes(),
            "Line 15: Couldn't read element line. String: '-0.25 -0.25 -0.25 255 ' Error: Parse error. Value: '-0.25' \
             Error: ParseIntError { kind: InvalidDigit },",
        ),
        (
            face("7 4 0 2 3 -1"),
            "Line 23: Couldn't read element line. String: '7 4 0 2 3 -1 ' Error: PLY property 'vertex_indices' with \
             declared type List(UChar, Int) is unsupported by the destination element",
        ),
        (
            face("7 4000000000 0 2 3 1"),
            "Line 23: Couldn't read element line. String: '7 4000000000 0 2 3 1 ' Error: Expected 4000000000 list \
             elements, but found only 4.",
        ),
        (
            first("nan -0.25"),
            "Line 15: Couldn't read element line. String: 'nan -0.25 -0.25 255 ' Error: Couldn't parse element line. \
             String: 'nan -0.25 -0.25 255 '",
        ),
        (
            ply_header("ascii", 0, 0).into_bytes(),
            "the header announces 2 rows of `other`, but only 0 bytes follow",
        ),
    ];
    for (bytes, message) in cases {
        assert_eq!(error("a.ply", &bytes), format!("a.ply: not a sound PLY file: {message}"));
    }
    assert_eq!(error("a.ply", face("7 4 0 2 3 9")), "a.ply: triangle 1 names vertex 9, but there are only 8");
    assert_eq!(error("a.ply", first("1e99 -0.25")), "a.ply: vertex 0 is not finite");
    assert_eq!(
        error("a.ply", ply_header("ascii", 0, 0).replace("other 2", "other 0")),
        "a.ply: there are no triangles in the file"
    );
}

#[test]
fn broken_gltf_files_are_refused() {
    let whole = embedded(r#"{"mesh": 0}"#);
    let binary = glb();
    let with = |from: &str, to: &str| {
        assert!(whole.contains(from));
        whole.replace(from, to).into_bytes()
    };
    let beyond = "accessor 0 reaches beyond its data";
    let cut_off = "could not completely read the object";
    let cases: Vec<(Vec<u8>, &str)> = vec![
        (b"\xff\xfe\x00garbage".to_vec(), "expected value at line 1 column 1"),
        (b"{}".to_vec(), "missing field `asset` at line 1 column 2"),
        (whole.as_bytes()[..300].to_vec(), "EOF while parsing a string at line 3 column 121"),
        (vec![b'['; 100_000], "invalid type: sequence, expected index into child of root at line 1 column 3"),
        (with(r#"{"mesh": 0}"#, r#"{"mesh": 1}"#), "nodes[0].mesh: Index out of bounds"),
        (with(r#"{"mesh": 0}"#, r#"{"children": [0]}"#), "node 0 has two parents, or is its own ancestor"),
        (
            with(r#"{"mesh": 0}"#, r#"{"children": [1, 1]}, {"mesh": 0}"#),
            "node 1 has two parents, or is its own ancestor",
        ),
        (with("\"count\": 8", "\"count\": 4000000000"), beyond),
        (with("\"count\": 8", "\"count\": 0"), beyond),
        (with("\"count\": 8", "\"count\": 7"), "a triangle names vertex 7, but its primitive has only 7"),
        (with("\"byteLength\": 96", "\"byteLength\": 9600"), beyond),
        (
            with("\"byteLength\": 168", "\"byteLength\": 18446744073709551615"),
            "buffer 0 should have 18446744073709551615 bytes, but has only 168",
        ),
        (
            with("\"byteOffset\": 96", "\"byteOffset\": 18446744073709551615"),
            "accessor 1 reaches beyond its data",
        ),
        (with("5126", "5123"), "accessor 0 is of a type that it can't have in its place"),
        (with("5123", "5126"), "accessor 1 is of a type that it can't have in its place"),
        (with("\"bufferView\": 0, ", ""), "accessors[0].bufferView: Missing data"),
        (with("\"POSITION\": 0", "\"POSITION\": 5"), "a mesh names accessor 5, but there are only 2"),
        (with(";base64,", ";base32,"), "buffer 0: its data are not in base64"),
        (with(";base64,", ";base64,*"), "buffer 0: Invalid symbol 42, offset 0."),
        (
            gltf_text(r#""uri": "https://example.org/a.bin", "#, r#"{"mesh": 0}"#).into_bytes(),
            "buffer 0: `https://example.org/a.bin` is not a file",
        ),
        (
            with(r#""scene": 0"#, r#""extensionsRequired": ["KHR_draco_mesh_compression"], "scene": 0"#),
            "it requires the extension KHR_draco_mesh_compression, which is not supported",
        ),
        (binary[..binary.len() - 40].to_vec(), cut_off),
        (binary[..16].to_vec(), cut_off),
        (b"glTF".to_vec(), "failed to fill whole buffer"),
    ];
    for (bytes, message) in cases {
        assert_eq!(error("a.gltf", &bytes), format!("a.gltf: not a sound glTF file: {message}"));
    }
    let far = r#"{"mesh": 0, "scale": [1e38, 1, 1], "translation": [3e38, 0, 0]}"#;
    assert_eq!(error("a.gltf", with(r#"{"mesh": 0}"#, far)), "a.gltf: vertex 1 is not finite");
    assert_eq!(
        error("a.gltf", with(r#""indices": 1"#, r#""mode": 0"#)),
        "a.gltf: there are no triangles in the file"
    );
}

#[test]
fn a_small_gltf_cannot_unfold_without_bound() {
    // Nodes that all place one mesh of 80,000 vertices: together more than are read.
    let nodes = |count: usize| {
        let children: Vec<String> = (1..=count).map(|i| i.to_string()).collect();
        format!(r#"{{"children": [{}]}}{}"#, children.join(","), r#", {"mesh": 0}"#.repeat(count))
    };
    let small = read(&Temporary::new("few.gltf", embedded(&nodes(2000))).0).unwrap();
    assert_eq!(small.triangles.len(), 2000 * 12);
    let text = gltf_text(r#""uri": "zero.bin", "#, &nodes(1000))
        .replace(r#", "indices": 1"#, "")
        .replace("\"byteLength\": 168", "\"byteLength\": 960000")
        .replace("\"byteLength\": 96}", "\"byteLength\": 960000}")
        .replace("\"count\": 8", "\"count\": 80000");
    let file = Temporary::new("many.gltf", text);
    fs::write(file.0.with_file_name("zero.bin"), vec![0; 960_000]).unwrap();
    assert_eq!(
        file.error(),
        "many.gltf: not a sound glTF file: it unfolds to more than 67108864 triangles or vertices"
    );
}

#[test]
fn no_damage_to_a_file_makes_its_reader_panic() {
    let formats: [(Vec<u8>, Parse); 8] = [
        (obj().into_bytes(), |bytes, _| obj::parse(bytes)),
        (ascii_stl().into_bytes(), |bytes, _| stl::parse(bytes)),
        (binary_stl(), |bytes, _| stl::parse(bytes)),
        (ascii_ply().into_bytes(), |bytes, _| ply::parse(bytes)),
        (binary_ply(false), |bytes, _| ply::parse(bytes)),
        (binary_ply(true), |bytes, _| ply::parse(bytes)),
        (embedded(r#"{"mesh": 0}"#).into_bytes(), gltf::parse),
        (glb(), gltf::parse),
    ];
    let path = Path::new("none.gltf");
    let mut state = 1_u64;
    let mut next = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for (whole, parse) in formats {
        for end in (0..whole.len()).step_by(7) {
            let _ = parse(&whole[..end], path);
        }
        for _ in 0..3000 {
            let mut harmed = whole.clone();
            for _ in 0..=next(3) {
                let at = next(harmed.len());
                // Often a digit for a digit, so that text stays text.
                harmed[at] = if next(2) == 0 { b'0' + next(10) as u8 } else { next(256) as u8 };
            }
            let _ = parse(&harmed, path);
        }
    }
}
