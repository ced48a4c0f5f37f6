//! What the crate promises, with the samples of the extension and with meshes that it encodes. No file but the samples is read:
//! they are in the folder `PSPLIT_SAMPLES`, or in the source tree.

use gltf_psplit::*;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

fn sample(name: &str) -> Vec<u8> {
    let folder = std::env::var_os("PSPLIT_SAMPLES").map_or_else(
        || {
            PathBuf::from(concat!(
                env!("CARGO_MANIFEST_DIR"),
                "/../../../gltf_ext/PSPLIT_mesh_draco_patches/samples"
            ))
        },
        PathBuf::from,
    );
    let file = folder.join(name);
    std::fs::read(&file).unwrap_or_else(|error| panic!("{}: {}", file.display(), error))
}

/// A wavy square of `side` * `side` points.
struct Grid {
    indices: Vec<u32>,
    positions: Vec<f32>,
    texcoords: Vec<f32>,
}

impl Grid {
    fn new(side: u32) -> Self {
        let mut grid = Self { indices: Vec::new(), positions: Vec::new(), texcoords: Vec::new() };
        for y in 0..side {
            for x in 0..side {
                let (u, v) = (x as f32 / side as f32, y as f32 / side as f32);
                grid.positions.extend([u, v, 0.1 * (9.0 * u).sin() * (7.0 * v).cos()]);
                grid.texcoords.extend([u, 1.0 - v]);
            }
        }
        for y in 0..side - 1 {
            for x in 0..side - 1 {
                let corner = y * side + x;
                grid.indices.extend([corner, corner + 1, corner + side]);
                grid.indices.extend([corner + 1, corner + side + 1, corner + side]);
            }
        }
        grid
    }

    fn source(&self) -> EncodeSource<'_> {
        EncodeSource::new(&self.indices, self.positions.len() as u32 / 3)
            .with(AttributeValues::new("POSITION", &self.positions, 3))
            .with(AttributeValues::new("TEXCOORD_0", &self.texcoords, 2).exact())
    }

    /// `None`, with a line that says so, if the library has no encoder.
    fn encoded(&self, options: &EncodeOptions<'_>) -> Option<Encoded> {
        match encode(&self.source(), options) {
            Err(error) if error.code() == ErrorCode::Unsupported && !has_encoder() => {
                println!("skipped: the library has no encoder");
                None
            }
            encoded => Some(encoded.unwrap()),
        }
    }
}

fn open(encoded: &Encoded) -> Mesh<'_> {
    let options = OpenOptions { point_count: encoded.point_count().into(), ..OpenOptions::default() };
    Mesh::open(encoded.kind(), encoded.bytes(), &encoded.attributes().unwrap(), &options).unwrap()
}

#[test]
fn versions_agree() {
    let (major, minor, _) = library_version();
    assert_eq!(format!("{}.{}", major, minor), env!("CARGO_PKG_VERSION").rsplit_once('.').unwrap().0);
}

#[test]
fn decodes_a_sample_on_any_threads() {
    let bytes = sample("patches.glb");
    let gltf = Gltf::open(&bytes).unwrap();
    assert_eq!(gltf.compressed_primitives(), [(0, 0)]);
    assert_eq!(gltf.primitive_kind(0, 0), Some(Kind::Patches));
    assert_eq!((gltf.buffer_count(), gltf.buffer_uri(0)), (1, None));
    let mesh = gltf.open_primitive(0, 0).unwrap();
    drop(gltf); // the mesh keeps what it needs
    let info = mesh.info();
    assert_eq!((info.face_count, info.point_count, info.least_index_size), (1222, 663, 2));
    assert!(info.patch_count > 1);
    let decoded = mesh.decode(&Run::serial()).unwrap();
    assert_eq!(decoded.face_count(), 1222);
    assert!(decoded.indices.to_u32().iter().all(|&index| index < 663));
    let position = decoded.attribute("POSITION").unwrap();
    assert_eq!(position.info.semantic, Semantic::Position);
    assert_eq!(position.values::<f32>().unwrap().len(), 3 * 663);
    assert!((position.values::<f32>().unwrap()[0] + 0.636158).abs() < 1e-6);
    assert!(position.values::<u16>().is_none());
    let pool = Pool::new(2).unwrap();
    assert_eq!(pool.threads(), 2);
    for run in [Run::default(), Run::with_pool(&pool)] {
        assert_eq!(mesh.decode(&run).unwrap(), decoded);
    }
    release_scratch();
}

#[test]
fn decodes_a_patch_alone() {
    let bytes = sample("patches.glb");
    let mesh = Gltf::open(&bytes).unwrap().open_primitive(0, 0).unwrap();
    let position = mesh.find_name("POSITION").unwrap();
    let whole = mesh.decode(&Run::serial()).unwrap();
    let whole_positions = whole.attribute("POSITION").unwrap().values::<f32>().unwrap();
    let (mut faces, mut owned) = (0, 0);
    for number in 0..mesh.info().patch_count {
        let patch = mesh.patch(number).unwrap();
        assert_eq!((patch.first_face, patch.first_owned_point), (faces, owned));
        faces += patch.face_count;
        owned += patch.owned_point_count;
        let mut indices = vec![u32::MAX; 3 * patch.face_count as usize];
        let mut positions = vec![0f32; 3 * patch.point_count as usize];
        let mut buffers = Buffers::new(&mesh).unwrap();
        buffers.indices_u32(&mut indices).attribute(position, &mut positions).unwrap();
        mesh.decode_patch_into(number, &mut buffers, &Run::serial()).unwrap();
        for (corner, &point) in indices.iter().enumerate() {
            let in_whole = whole.indices.to_u32()[3 * patch.first_face as usize + corner] as usize;
            assert_eq!(positions[3 * point as usize..][..3], whole_positions[3 * in_whole..][..3]);
        }
    }
    assert_eq!((faces, owned), (mesh.info().face_count, mesh.info().point_count));
    let patches = mesh.info().patch_count;
    assert_eq!(mesh.patch(patches).unwrap_err().code(), ErrorCode::Usage);
}

#[test]
fn decodes_to_interleaved_vertices() {
    let bytes = sample("seams.glb");
    let mesh = Gltf::open_copy(&bytes).unwrap().open_primitive(0, 0).unwrap();
    drop(bytes); // it was copied
    let decoded = mesh.decode(&Run::serial()).unwrap();
    let (position, texcoord) =
        (mesh.find_semantic(Semantic::Position, 0).unwrap(), mesh.find_name("TEXCOORD_0").unwrap());
    let points = mesh.info().point_count as usize;
    const STRIDE: usize = 24; // 12 bytes of a position, 4 that nobody writes, 8 of a texture coordinate
    let mut vertices = vec![0xa5u8; points * STRIDE];
    let mut indices = vec![0u16; 3 * mesh.info().face_count as usize];
    let mut buffers = Buffers::new(&mesh).unwrap();
    buffers.indices_u16(&mut indices);
    buffers.interleaved(&mut vertices, STRIDE, &[(position, 0), (texcoord, 16)]).unwrap();
    mesh.decode_into(&mut buffers, &Run::default()).unwrap();
    assert_eq!(Indices::U16(indices), decoded.indices);
    for (point, vertex) in vertices.chunks(STRIDE).enumerate() {
        assert_eq!(vertex[..12], decoded.attributes[position].values.as_bytes()[12 * point..][..12]);
        assert_eq!(vertex[12..16], [0xa5; 4]);
        assert_eq!(vertex[16..], decoded.attributes[texcoord].values.as_bytes()[8 * point..][..8]);
    }
    let mut buffers = Buffers::new(&mesh).unwrap();
    let mut memory = vec![0u8; points * STRIDE];
    let overlap = buffers.interleaved(&mut memory, STRIDE, &[(position, 0), (texcoord, 8)]).err().unwrap();
    assert_eq!((overlap.code(), overlap.message()), (ErrorCode::Usage, "attributes of a vertex overlap"));
    let mut memory = vec![0u8; points * STRIDE];
    let beyond = buffers.interleaved(&mut memory, STRIDE, &[(texcoord, 17)]).err().unwrap();
    assert_eq!(beyond.message(), "TEXCOORD_0 does not fit into a vertex");
}

#[test]
fn refuses_buffers_that_do_not_fit() {
    let bytes = sample("patches.glb");
    let mesh = Gltf::open(&bytes).unwrap().open_primitive(0, 0).unwrap();
    let position = mesh.find_name("POSITION").unwrap();
    let mut indices = vec![0u32; 3 * mesh.info().face_count as usize];
    let mut positions = vec![0f32; 3 * mesh.info().point_count as usize - 1];
    let mut wrong_type = vec![0u16; positions.len() + 1];
    let mut buffers = Buffers::new(&mesh).unwrap();
    let error = buffers.attribute(position, &mut wrong_type).err().unwrap();
    assert_eq!(error.message(), "POSITION has components of F32, and the buffer of U16");
    assert_eq!(
        Buffers::new(&mesh).unwrap().attribute_bytes(99, &mut [], 0).err().unwrap().code(),
        ErrorCode::Usage
    );
    buffers.indices_u32(&mut indices).attribute(position, &mut positions).unwrap();
    let error = mesh.decode_into(&mut buffers, &Run::serial()).unwrap_err();
    assert_eq!(error.code(), ErrorCode::Usage);
    assert_eq!(error.to_string(), "mesh 0, primitive 0: the buffer of POSITION has no room for 663 points");
    assert_eq!(error.place(), Place { mesh: Some(0), primitive: Some(0), patch: None });
}

#[test]
fn encodes_and_decodes_again() {
    let grid = Grid::new(60);
    for kind in [Kind::Patches, Kind::Draco] {
        let options = EncodeOptions {
            kind: Some(kind),
            patch_faces: 1000,
            position_bits: Some(16),
            ..Default::default()
        };
        let encoded = match grid.encoded(&options) {
            Some(encoded) => encoded,
            None => return,
        };
        assert_eq!(encoded.kind(), kind);
        assert_eq!(encoded.patch_count() > 3, kind == Kind::Patches);
        assert_eq!((encoded.face_count() as usize, encoded.point_count()), (grid.indices.len() / 3, 3600));
        assert!(encoded.position_error().unwrap() < 1e-4);
        let mesh = open(&encoded);
        let quantization = mesh.quantization(mesh.find_name("POSITION").unwrap()).unwrap();
        assert_eq!((quantization.bits, quantization.origin.len()), (16, 3));
        assert_eq!(mesh.quantization(mesh.find_name("TEXCOORD_0").unwrap()).unwrap().bits, 0);
        let decoded = mesh.decode(&Run::default()).unwrap();
        let positions = decoded.attribute("POSITION").unwrap().values::<f32>().unwrap();
        let texcoords = decoded.attribute("TEXCOORD_0").unwrap().values::<f32>().unwrap();
        for (point, &source) in encoded.source_points().iter().enumerate() {
            let source = source as usize;
            assert_eq!(texcoords[2 * point..][..2], grid.texcoords[2 * source..][..2]);
            for (decoded, stored) in
                positions[3 * point..][..3].iter().zip(&grid.positions[3 * source..][..3])
            {
                assert!((decoded - stored).abs() <= quantization.range / 65535.0);
            }
        }
    }
}

#[test]
fn writes_gltf_and_says_how_attributes_are_stored() {
    let grid = Grid::new(30);
    let encoded = match grid.encoded(&EncodeOptions::default()) {
        Some(encoded) => encoded,
        None => return,
    };
    let glb = encoded.to_glb().unwrap();
    let mesh = Gltf::open(&glb).unwrap().open_primitive(0, 0).unwrap();
    let decoded = mesh.decode(&Run::serial()).unwrap();
    assert_eq!(decoded, open(&encoded).decode(&Run::serial()).unwrap());
    let json = encoded.gltf_json(5, 2).unwrap();
    assert!(
        json.starts_with("{\"primitive\":{\"attributes\":{\"POSITION\":5,\"TEXCOORD_0\":6},\"indices\":7"),
        "{}",
        json
    );
    assert!(json.contains("\"bufferView\":2"), "{}", json);
    assert_eq!((encoded.quantization(0).unwrap().bits, encoded.quantization(1).unwrap().bits), (14, 0));
    assert_eq!(encoded.reason(0).unwrap(), "POSITION gets 14 bits, as the options say");
    assert_eq!(encoded.reason(1).unwrap(), "TEXCOORD_0 is kept exactly, as its bits say");
    assert_eq!((encoded.reason(2), encoded.quantization(2).unwrap_err().code()), (None, ErrorCode::Usage));
}

#[test]
fn decodes_draco_files() {
    let grid = Grid::new(30);
    let options = EncodeOptions { kind: Some(Kind::Draco), ..Default::default() };
    let encoded = match grid.encoded(&options) {
        Some(encoded) => encoded,
        None => return,
    };
    let mesh = Mesh::open_draco_file(encoded.bytes()).unwrap();
    assert_eq!(mesh.info().kind, Kind::DracoFile);
    assert!(matches!(mesh.info().coding, Coding::Edgebreaker | Coding::EdgebreakerValence));
    let decoded = mesh.decode(&Run::serial()).unwrap();
    let integers = OpenOptions { integers: true, ..Default::default() };
    let mesh = Mesh::open_copy(Kind::DracoFile, encoded.bytes(), &[], &integers).unwrap();
    let position = mesh.find_id(decoded.attribute("POSITION").unwrap().info.unique_id).unwrap();
    let quantization = mesh.quantization(position).unwrap();
    let stored = mesh.decode(&Run::serial()).unwrap();
    assert!(stored.attributes[position].info.is_integers);
    let stored = stored.attributes[position].values::<i32>().unwrap();
    let step = quantization.range / ((1u32 << quantization.bits) - 1) as f32;
    for (component, (value, integer)) in
        decoded.attributes[position].values::<f32>().unwrap().iter().zip(stored).enumerate()
    {
        assert_eq!(*value, quantization.origin[component % 3] + *integer as f32 * step);
    }
}

#[test]
fn decodes_many_meshes_and_reports_each() {
    let files = [sample("patches.glb"), sample("seams.glb"), sample("condensed.glb")];
    let meshes: Vec<Mesh> =
        files.iter().map(|bytes| Gltf::open(bytes).unwrap().open_primitive(0, 0).unwrap()).collect();
    let mut indices: Vec<Vec<u32>> =
        meshes.iter().map(|mesh| vec![0; 3 * mesh.info().face_count as usize]).collect();
    indices[1].clear();
    let mut jobs: Vec<(&Mesh, Buffers)> = Vec::new();
    for (mesh, indices) in meshes.iter().zip(&mut indices) {
        let mut buffers = Buffers::new(mesh).unwrap();
        buffers.indices_u32(indices);
        jobs.push((mesh, buffers));
    }
    let results = decode_meshes(&mut jobs, &Run::default());
    assert!(results[0].is_ok() && results[2].is_ok());
    assert_eq!(results[1].as_ref().unwrap_err().code(), ErrorCode::Usage);
    let wrong = decode_meshes(&mut jobs, &Run { threads: 5000, ..Run::default() });
    assert!(wrong.iter().all(|result| result.as_ref().unwrap_err().code() == ErrorCode::Usage));
    drop(jobs);
    for number in [0, 2] {
        assert_eq!(indices[number], meshes[number].decode(&Run::serial()).unwrap().indices.to_u32());
    }
}

#[test]
fn malformed_bytes_are_errors() {
    let bytes = sample("condensed-residue.glb");
    let glb = Gltf::open(&bytes).unwrap();
    assert!(glb.open_primitive(0, 0).unwrap().decode(&Run::serial()).is_ok());
    for end in 0..bytes.len() {
        // The file's own length is in bytes 8 to 12.
        let mut cut = bytes[..end].to_vec();
        if end >= 12 {
            cut[8..12].copy_from_slice(&(end as u32).to_le_bytes());
        }
        // Without a binary chunk, the file opens, and its buffer is not set.
        let decoded = Gltf::open(&cut).and_then(|gltf| gltf.open_primitive(0, 0)?.decode(&Run::serial()));
        let error = decoded.err().unwrap_or_else(|| panic!("{} bytes are decoded", end));
        assert!(
            matches!(error.code(), ErrorCode::InvalidInput | ErrorCode::Usage),
            "{} bytes: {}",
            end,
            error
        );
        assert!(!error.message().is_empty());
    }
    for at in 0..bytes.len() {
        let mut changed = bytes.clone();
        changed[at] ^= 0x55;
        // Some changes are of values only. None is a panic.
        let _ = Gltf::open(&changed).and_then(|gltf| gltf.open_primitive(0, 0)?.decode(&Run::serial()));
    }
    assert_eq!(Mesh::open_draco_file(b"").unwrap_err().code(), ErrorCode::InvalidInput);
    assert_eq!(Mesh::open_draco_file(b"DRACO").unwrap_err().code(), ErrorCode::InvalidInput);
}

#[test]
fn names_with_zero_bytes_are_errors() {
    let request = AttributeRequest {
        name: "POS\0ITION".to_string(),
        unique_id: 0,
        component_type: ComponentType::F32,
        components: 3,
        normalized: false,
    };
    let error = Mesh::open(Kind::Patches, b"", &[request], &OpenOptions::default()).unwrap_err();
    assert_eq!(error.message(), "the name \"POS\\0ITION\" has a zero byte");
    let bytes = sample("patches.glb");
    let mesh = Gltf::open(&bytes).unwrap().open_primitive(0, 0).unwrap();
    assert_eq!(mesh.find_name("POSITION\0"), None);
}

#[test]
fn buffers_of_uris_are_the_callers() {
    let json = sample("fallback.gltf");
    let files: Vec<Option<Vec<u8>>> = {
        let gltf = Gltf::open(&json).unwrap();
        (0..gltf.buffer_count()).map(|buffer| gltf.buffer_uri(buffer).map(|uri| sample(&uri))).collect()
    };
    let mut gltf = Gltf::open(&json).unwrap();
    let (mesh, primitive) = gltf.compressed_primitives()[0];
    let error = gltf.open_primitive(mesh, primitive).unwrap_err();
    assert_eq!(error.code(), ErrorCode::Usage);
    assert!(error.message().ends_with("are not set"), "{}", error);
    for (buffer, file) in files.iter().enumerate() {
        if let Some(file) = file {
            assert_eq!(
                gltf.set_buffer(buffer as u32, &file[1..]).unwrap_err().code(),
                ErrorCode::InvalidInput
            );
            gltf.set_buffer(buffer as u32, file).unwrap();
        }
    }
    let mesh = gltf.open_primitive(mesh, primitive).unwrap();
    assert!(mesh.decode(&Run::default()).unwrap().face_count() > 0);
}

#[test]
fn a_panic_of_a_callback_does_not_cross_c() {
    let bytes = sample("patches.glb");
    let mesh = Gltf::open(&bytes).unwrap().open_primitive(0, 0).unwrap();
    let calls = AtomicUsize::new(0);
    let panics = |done: usize, total: usize| {
        assert!(done >= 1 && done <= total);
        calls.fetch_add(1, Ordering::Relaxed);
        panic!("in a callback");
    };
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {})); // the panics are expected
    let caught =
        catch_unwind(AssertUnwindSafe(|| mesh.decode(&Run { progress: Some(&panics), ..Run::default() })));
    std::panic::set_hook(hook);
    assert_eq!(caught.unwrap_err().downcast_ref(), Some(&"in a callback"));
    assert_eq!(calls.load(Ordering::Relaxed), mesh.info().patch_count as usize);
    let counted = AtomicUsize::new(0);
    let count = |_: usize, total: usize| {
        counted.fetch_add(1, Ordering::Relaxed);
        assert_eq!(total, mesh.info().patch_count as usize);
    };
    mesh.decode(&Run { progress: Some(&count), ..Run::default() }).unwrap();
    assert_eq!(counted.load(Ordering::Relaxed), mesh.info().patch_count as usize);
}

#[test]
fn a_flag_stops_decoding_and_encoding() {
    let bytes = sample("patches.glb");
    let mesh = Gltf::open(&bytes).unwrap().open_primitive(0, 0).unwrap();
    let stop = Stop::new().unwrap();
    let run = Run { stop: Some(&stop), ..Run::default() };
    stop.set(true);
    assert_eq!(mesh.decode(&run).unwrap_err().code(), ErrorCode::Cancelled);
    if has_encoder() {
        let options = EncodeOptions { run, ..Default::default() };
        assert_eq!(encode(&Grid::new(20).source(), &options).unwrap_err().code(), ErrorCode::Cancelled);
    }
    stop.set(false);
    assert!(mesh.decode(&run).is_ok());
}

#[test]
fn threads_share_handles() {
    fn is_shared<T: Send + Sync>() {}
    is_shared::<Mesh>();
    is_shared::<Gltf>();
    is_shared::<Pool>();
    is_shared::<Stop>();
    is_shared::<Encoded>();
    is_shared::<Error>();
    let bytes = sample("seams.glb");
    let gltf = Gltf::open(&bytes).unwrap();
    let mesh = gltf.open_primitive(0, 0).unwrap();
    let pool = Pool::new(2).unwrap();
    let wanted = mesh.decode(&Run::serial()).unwrap();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for _ in 0..20 {
                    assert_eq!(mesh.decode(&Run::with_pool(&pool)).unwrap(), wanted);
                    assert_eq!(gltf.open_primitive(0, 0).unwrap().info(), mesh.info());
                }
            });
        }
    });
}

#[test]
fn wrong_sources_are_errors_of_the_encoder() {
    if !has_encoder() {
        return println!("skipped: the library has no encoder");
    }
    let positions = [0f32; 9];
    let code = |source: &EncodeSource| encode(source, &EncodeOptions::default()).unwrap_err().code();
    assert_eq!(code(&EncodeSource::new(&[0u8, 1, 2], 3)), ErrorCode::InvalidInput);
    assert_eq!(
        code(&EncodeSource::new(&[0u8, 1, 3], 3).with(AttributeValues::new("POSITION", &positions, 3))),
        ErrorCode::InvalidInput
    );
    let zero = EncodeSource::new(&[0u16, 1, 2], 3).with(AttributeValues::new("POS\0", &positions, 3));
    assert_eq!(code(&zero), ErrorCode::Usage);
}
