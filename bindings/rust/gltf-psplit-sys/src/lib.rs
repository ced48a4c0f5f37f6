//! The C interface of psplit, as `psplit/psplit.h` declares it.
//!
//! The header describes each function, struct and constant; nothing here differs from it, which a test checks. The crate
//! `gltf-psplit` has safe types over these declarations.
//!
//! `build.rs` finds the library: by `PSPLIT_LIB_DIR`, the folder of `libpsplit.so`, or by pkg-config.
#![allow(non_camel_case_types)]

use std::os::raw::{c_char, c_void};

/// Declares structs of the header. `new` makes one that is zero but for its size, as `PSPLIT_INIT` does.
macro_rules! c_struct {
    ($(pub struct $name:ident { $(pub $member:ident: $type:ty,)* })*) => {$(
        #[repr(C)]
        #[derive(Clone, Copy)]
        pub struct $name { $(pub $member: $type,)* }
        impl $name {
            pub fn new() -> Self {
                // SAFETY: zero is a value of every member: of numbers, pointers and optional functions.
                let mut value: Self = unsafe { std::mem::zeroed() };
                value.struct_size = std::mem::size_of::<Self>() as u32;
                value
            }
        }
        impl Default for $name {
            fn default() -> Self {
                Self::new()
            }
        }
    )*};
}

/// Declares a handle, of which only pointers exist.
macro_rules! opaque {
    ($name:ident) => {
        #[repr(C)]
        pub struct $name {
            _private: [u8; 0],
            _not_send: std::marker::PhantomData<*mut u8>,
        }
    };
}

// PSPLIT_VERSION of the header that these declarations were written from: major, minor, patch.
pub const PSPLIT_VERSION_MAJOR: u32 = 0;
pub const PSPLIT_VERSION_MINOR: u32 = 1;
pub const PSPLIT_VERSION_PATCH: u32 = 0;

pub type psplit_code = i32;
pub const PSPLIT_OK: psplit_code = 0;
pub const PSPLIT_ERROR_USAGE: psplit_code = 1;
pub const PSPLIT_ERROR_INVALID_INPUT: psplit_code = 3;
pub const PSPLIT_ERROR_FAILURE: psplit_code = 4;
pub const PSPLIT_ERROR_UNSUPPORTED: psplit_code = 5;
pub const PSPLIT_ERROR_CANCELLED: psplit_code = 6;
pub const PSPLIT_ERROR_NO_MEMORY: psplit_code = 8;
c_struct! {
    pub struct psplit_error {
        pub struct_size: u32,
        pub code: psplit_code,
        pub mesh: i64,
        pub primitive: i64,
        pub patch: i64,
        pub text: [c_char; 480],
    }
}
opaque!(psplit_pool);
opaque!(psplit_stop);
pub type psplit_progress = Option<unsafe extern "C" fn(user: *mut c_void, done: usize, total: usize)>;
c_struct! {
    pub struct psplit_run {
        pub struct_size: u32,
        pub threads: i32,
        pub pool: *const psplit_pool,
        pub progress: psplit_progress,
        pub user: *mut c_void,
        pub stop: *const psplit_stop,
    }
}
opaque!(psplit_mesh);
pub type psplit_kind = i32;
pub const PSPLIT_KIND_NONE: psplit_kind = 0;
pub const PSPLIT_KIND_PATCHES: psplit_kind = 1;
pub const PSPLIT_KIND_DRACO: psplit_kind = 2;
pub const PSPLIT_KIND_DRACO_FILE: psplit_kind = 3;
pub type psplit_type = i32;
pub const PSPLIT_INT8: psplit_type = 1;
pub const PSPLIT_UINT8: psplit_type = 2;
pub const PSPLIT_INT16: psplit_type = 3;
pub const PSPLIT_UINT16: psplit_type = 4;
pub const PSPLIT_INT32: psplit_type = 5;
pub const PSPLIT_UINT32: psplit_type = 6;
pub const PSPLIT_INT64: psplit_type = 7;
pub const PSPLIT_UINT64: psplit_type = 8;
pub const PSPLIT_FLOAT32: psplit_type = 9;
pub const PSPLIT_FLOAT64: psplit_type = 10;
pub const PSPLIT_BOOL: psplit_type = 11;
pub type psplit_semantic = i32;
pub const PSPLIT_POSITION: psplit_semantic = 0;
pub const PSPLIT_NORMAL: psplit_semantic = 1;
pub const PSPLIT_COLOR: psplit_semantic = 2;
pub const PSPLIT_TEXCOORD: psplit_semantic = 3;
pub const PSPLIT_GENERIC: psplit_semantic = 4;
pub type psplit_coding = i32;
pub const PSPLIT_CODING_UNKNOWN: psplit_coding = -1;
pub const PSPLIT_CODING_SEQUENTIAL: psplit_coding = 0;
pub const PSPLIT_CODING_EDGEBREAKER: psplit_coding = 1;
pub const PSPLIT_CODING_EDGEBREAKER_VALENCE: psplit_coding = 3;
pub const PSPLIT_CODING_CLOUD_SEQUENTIAL: psplit_coding = 4;
pub const PSPLIT_CODING_CLOUD_KD_TREE: psplit_coding = 5;
c_struct! {
    pub struct psplit_attribute_request {
        pub struct_size: u32,
        pub unique_id: u32,
        pub name: *const c_char,
        pub r#type: psplit_type,
        pub components: u32,
        pub normalized: u32,
        pub reserved: u32,
    }
}
pub const PSPLIT_COPY: u32 = 1;
pub const PSPLIT_INTEGERS: u32 = 2;
c_struct! {
    pub struct psplit_source {
        pub struct_size: u32,
        pub kind: psplit_kind,
        pub data: *const c_void,
        pub size: usize,
        pub attributes: *const psplit_attribute_request,
        pub attribute_count: u32,
        pub flags: u32,
        pub point_count: u64,
        pub index_count: u64,
    }
}
c_struct! {
    pub struct psplit_mesh_info {
        pub struct_size: u32,
        pub kind: psplit_kind,
        pub coding: psplit_coding,
        pub point_count: u32,
        pub face_count: u32,
        pub attribute_count: u32,
        pub patch_count: u32,
        pub has_residue: u32,
        pub least_index_size: u32,
    }
}
c_struct! {
    pub struct psplit_attribute_info {
        pub struct_size: u32,
        pub unique_id: u32,
        pub semantic: psplit_semantic,
        pub r#type: psplit_type,
        pub components: u32,
        pub normalized: u32,
        pub value_size: u32,
        pub is_integers: u32,
        pub name: *const c_char,
    }
}
c_struct! {
    pub struct psplit_quantization {
        pub struct_size: u32,
        pub bits: i32,
        pub range: f32,
        pub origin_count: u32,
        pub origin: *const f32,
    }
}
c_struct! {
    pub struct psplit_patch_info {
        pub struct_size: u32,
        pub face_count: u32,
        pub point_count: u32,
        pub stream_size: u32,
        pub first_face: u32,
        pub first_owned_point: u32,
        pub owned_point_count: u32,
        pub is_residue: u32,
    }
}
c_struct! {
    pub struct psplit_attribute_buffer {
        pub struct_size: u32,
        pub reserved: u32,
        pub data: *mut c_void,
        pub size: usize,
        pub stride: usize,
    }
}
c_struct! {
    pub struct psplit_buffers {
        pub struct_size: u32,
        pub index_size: u32,
        pub indices: *mut c_void,
        pub indices_size: usize,
        pub attributes: *const psplit_attribute_buffer,
        pub attribute_count: u32,
        pub reserved: u32,
    }
}
c_struct! {
    pub struct psplit_job {
        pub struct_size: u32,
        pub code: psplit_code,
        pub mesh: *const psplit_mesh,
        pub buffers: *const psplit_buffers,
        pub error: *mut psplit_error,
    }
}
opaque!(psplit_gltf);
c_struct! {
    pub struct psplit_gltf_source {
        pub struct_size: u32,
        pub flags: u32,
        pub data: *const c_void,
        pub size: usize,
    }
}
c_struct! {
    pub struct psplit_attribute_values {
        pub struct_size: u32,
        pub r#type: psplit_type,
        pub name: *const c_char,
        pub data: *const c_void,
        pub size: usize,
        pub stride: usize,
        pub components: u32,
        pub normalized: u32,
        pub bits: i32,
        pub reserved: u32,
    }
}
c_struct! {
    pub struct psplit_encode_source {
        pub struct_size: u32,
        pub point_count: u32,
        pub indices: *const c_void,
        pub indices_size: usize,
        pub index_size: u32,
        pub attribute_count: u32,
        pub attributes: *const psplit_attribute_values,
    }
}
pub const PSPLIT_ENCODE_KEEP_DUPLICATES: u32 = 1;
pub const PSPLIT_ENCODE_KEEP_DEGENERATE: u32 = 2;
pub const PSPLIT_ENCODE_KEEP_UNUSED: u32 = 4;
pub const PSPLIT_ENCODE_CONDENSE: u32 = 8;
pub const PSPLIT_ENCODE_WITHOUT_VERIFYING: u32 = 16;
pub const PSPLIT_ENCODE_POINTS: u32 = 32;
c_struct! {
    pub struct psplit_encode_options {
        pub struct_size: u32,
        pub kind: psplit_kind,
        pub speed: i32,
        pub threads: i32,
        pub pool: *const psplit_pool,
        pub patch_count: u32,
        pub patch_faces: u32,
        pub position_bits: i32,
        pub normal_bits: i32,
        pub texcoord_bits: i32,
        pub color_bits: i32,
        pub generic_bits: i32,
        pub flags: u32,
        pub progress: psplit_progress,
        pub user: *mut c_void,
        pub stop: *const psplit_stop,
    }
}
opaque!(psplit_encoded);
opaque!(psplit_output);
c_struct! {
    pub struct psplit_encoded_info {
        pub struct_size: u32,
        pub kind: psplit_kind,
        pub data: *const c_void,
        pub size: usize,
        pub point_count: u32,
        pub face_count: u32,
        pub patch_count: u32,
        pub attribute_count: u32,
        pub source_points: *const u32,
        pub position_error: f64,
        pub note_count: u32,
        pub reserved: u32,
    }
}
extern "C" {
    pub fn psplit_version() -> u32;
    pub fn psplit_has_encoder() -> i32;
    pub fn psplit_code_name(code: psplit_code) -> *const c_char;
    pub fn psplit_pool_create(
        threads: i32,
        pool: *mut *mut psplit_pool,
        error: *mut psplit_error,
    ) -> psplit_code;
    pub fn psplit_pool_threads(pool: *const psplit_pool) -> i32;
    pub fn psplit_pool_free(pool: *mut psplit_pool);
    pub fn psplit_stop_create(stop: *mut *mut psplit_stop, error: *mut psplit_error) -> psplit_code;
    pub fn psplit_stop_set(stop: *mut psplit_stop, value: i32);
    pub fn psplit_stop_free(stop: *mut psplit_stop);
    pub fn psplit_release_scratch();
    pub fn psplit_mesh_open(
        source: *const psplit_source,
        mesh: *mut *mut psplit_mesh,
        error: *mut psplit_error,
    ) -> psplit_code;
    pub fn psplit_mesh_free(mesh: *mut psplit_mesh);
    pub fn psplit_mesh_get_info(
        mesh: *const psplit_mesh,
        info: *mut psplit_mesh_info,
        error: *mut psplit_error,
    ) -> psplit_code;
    pub fn psplit_mesh_get_attribute(
        mesh: *const psplit_mesh,
        attribute: u32,
        info: *mut psplit_attribute_info,
        error: *mut psplit_error,
    ) -> psplit_code;
    pub fn psplit_mesh_find_name(mesh: *const psplit_mesh, name: *const c_char) -> i32;
    pub fn psplit_mesh_find_id(mesh: *const psplit_mesh, unique_id: u32) -> i32;
    pub fn psplit_mesh_find_semantic(mesh: *const psplit_mesh, semantic: psplit_semantic, skip: u32) -> i32;
    pub fn psplit_mesh_get_quantization(
        mesh: *const psplit_mesh,
        attribute: u32,
        quantization: *mut psplit_quantization,
        error: *mut psplit_error,
    ) -> psplit_code;
    pub fn psplit_mesh_get_patch(
        mesh: *const psplit_mesh,
        patch: u32,
        info: *mut psplit_patch_info,
        error: *mut psplit_error,
    ) -> psplit_code;
    pub fn psplit_mesh_decode(
        mesh: *const psplit_mesh,
        buffers: *const psplit_buffers,
        run: *const psplit_run,
        error: *mut psplit_error,
    ) -> psplit_code;
    pub fn psplit_mesh_decode_patch(
        mesh: *const psplit_mesh,
        patch: u32,
        buffers: *const psplit_buffers,
        run: *const psplit_run,
        error: *mut psplit_error,
    ) -> psplit_code;
    pub fn psplit_decode_meshes(
        jobs: *mut psplit_job,
        job_count: usize,
        run: *const psplit_run,
        error: *mut psplit_error,
    ) -> psplit_code;
    pub fn psplit_gltf_open(
        source: *const psplit_gltf_source,
        gltf: *mut *mut psplit_gltf,
        error: *mut psplit_error,
    ) -> psplit_code;
    pub fn psplit_gltf_free(gltf: *mut psplit_gltf);
    pub fn psplit_gltf_buffer_count(gltf: *const psplit_gltf) -> u32;
    pub fn psplit_gltf_buffer_uri(gltf: *const psplit_gltf, buffer: u32) -> *const c_char;
    pub fn psplit_gltf_set_buffer(
        gltf: *mut psplit_gltf,
        buffer: u32,
        data: *const c_void,
        size: usize,
        error: *mut psplit_error,
    ) -> psplit_code;
    pub fn psplit_gltf_mesh_count(gltf: *const psplit_gltf) -> u32;
    pub fn psplit_gltf_primitive_count(gltf: *const psplit_gltf, mesh: u32) -> u32;
    pub fn psplit_gltf_primitive_kind(gltf: *const psplit_gltf, mesh: u32, primitive: u32) -> psplit_kind;
    pub fn psplit_gltf_open_primitive(
        gltf: *const psplit_gltf,
        mesh: u32,
        primitive: u32,
        result: *mut *mut psplit_mesh,
        error: *mut psplit_error,
    ) -> psplit_code;
    pub fn psplit_encode_options_init(options: *mut psplit_encode_options);
    pub fn psplit_encode(
        source: *const psplit_encode_source,
        options: *const psplit_encode_options,
        encoded: *mut *mut psplit_encoded,
        error: *mut psplit_error,
    ) -> psplit_code;
    pub fn psplit_encoded_free(encoded: *mut psplit_encoded);
    pub fn psplit_encoded_get_info(
        encoded: *const psplit_encoded,
        info: *mut psplit_encoded_info,
        error: *mut psplit_error,
    ) -> psplit_code;
    pub fn psplit_encoded_note(encoded: *const psplit_encoded, note: u32) -> *const c_char;
    pub fn psplit_encoded_get_attribute(
        encoded: *const psplit_encoded,
        attribute: u32,
        request: *mut psplit_attribute_request,
        error: *mut psplit_error,
    ) -> psplit_code;
    pub fn psplit_encoded_get_quantization(
        encoded: *const psplit_encoded,
        attribute: u32,
        quantization: *mut psplit_quantization,
        error: *mut psplit_error,
    ) -> psplit_code;
    pub fn psplit_encoded_reason(encoded: *const psplit_encoded, attribute: u32) -> *const c_char;
    pub fn psplit_output_data(output: *const psplit_output) -> *const c_void;
    pub fn psplit_output_size(output: *const psplit_output) -> usize;
    pub fn psplit_output_free(output: *mut psplit_output);
    pub fn psplit_encoded_write_json(
        encoded: *const psplit_encoded,
        first_accessor: u32,
        buffer_view: u32,
        output: *mut *mut psplit_output,
        error: *mut psplit_error,
    ) -> psplit_code;
    pub fn psplit_encoded_write_glb(
        encoded: *const psplit_encoded,
        output: *mut *mut psplit_output,
        error: *mut psplit_error,
    ) -> psplit_code;
}
