//! Decodes and encodes Draco meshes of `.drc` files, of glTF (`KHR_draco_mesh_compression`), and of the glTF extension
//! `PSPLIT_mesh_draco_patches`, whose patches decode on all threads.
//!
//! The crate calls the C library of psplit, which is linked as a shared library; see `docs/rust.md` of psplit.
//!
//! ```no_run
//! use gltf_psplit::{Gltf, Mesh, Run};
//!
//! // A .drc file.
//! let bytes = std::fs::read("bunny.drc")?;
//! let decoded = Mesh::open_draco_file(&bytes)?.decode(&Run::default())?;
//! let positions: &[f32] = decoded.attribute("POSITION").unwrap().values().unwrap();
//! println!("{} triangles, the first corner at {:?}", decoded.face_count(), &positions[..3]);
//!
//! // A primitive of a .glb file.
//! let bytes = std::fs::read("dragon.glb")?;
//! let gltf = Gltf::open(&bytes)?;
//! let mesh = gltf.open_primitive(0, 0)?;
//! let decoded = mesh.decode(&Run::default())?;
//! # let _ = decoded;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Threads
//!
//! All types are `Send` and `Sync`: functions of the C library may be called from any thread, also with one handle. A
//! function that needs a handle for itself takes `&mut self`.
//!
//! # Errors
//!
//! Malformed bytes give an [`Error`], never a panic, and nothing is written outside the given slices. A panic in a progress
//! callback is caught, and goes on in the thread that called this crate when the C library has returned.

#![deny(unsafe_op_in_unsafe_fn)]

mod decode;
mod encode;
mod error;
mod gltf;
mod mesh;
mod run;
mod values;

pub use decode::{decode_meshes, Buffers, DecodedAttribute, DecodedMesh, Indices};
pub use encode::{encode, AttributeValues, EncodeOptions, EncodeSource, Encoded, Index};
pub use error::{Error, ErrorCode, Place};
pub use gltf::Gltf;
pub use mesh::{
    AttributeInfo, AttributeRequest, Coding, Kind, Mesh, MeshInfo, OpenOptions, PatchInfo, Quantization,
    Semantic,
};
pub use run::{release_scratch, Pool, Run, Stop};
pub use values::{Component, ComponentType, Values};

/// The version of the C library that is linked: major, minor, patch.
pub fn library_version() -> (u32, u32, u32) {
    // SAFETY: a function without arguments.
    let version = unsafe { gltf_psplit_sys::psplit_version() };
    (version >> 16, version >> 8 & 0xff, version & 0xff)
}

/// Whether the library can encode. Without its encoder, [`encode`](encode()) returns [`ErrorCode::Unsupported`].
pub fn has_encoder() -> bool {
    // SAFETY: a function without arguments.
    unsafe { gltf_psplit_sys::psplit_has_encoder() != 0 }
}
