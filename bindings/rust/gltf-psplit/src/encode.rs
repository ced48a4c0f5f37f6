//! Meshes to be encoded.

use crate::error::{checked, Error};
use crate::mesh::{name_of, number, quantization_of, text_of, AttributeRequest, Kind, Quantization};
use crate::run::{with_progress, Run};
use crate::values::{bytes_of, Component, ComponentType};
use gltf_psplit_sys as sys;
use std::ffi::CString;
use std::ptr::{null_mut, NonNull};

/// The values of an attribute, one for each point.
#[derive(Clone, Debug)]
pub struct AttributeValues<'a> {
    name: String,
    component_type: ComponentType,
    components: u32,
    bytes: &'a [u8],
    stride: usize,
    normalized: bool,
    bits: i32,
}

impl<'a> AttributeValues<'a> {
    /// Values of `components` each, tightly packed. `name` is glTF's: `POSITION`, `NORMAL`, `TEXCOORD_0`, `COLOR_0` ...
    pub fn new<T: Component>(name: &str, values: &'a [T], components: u32) -> Self {
        Self::of_bytes(name, T::TYPE, components, bytes_of(values), 0)
    }

    /// Bytes of any alignment: `stride` from one value to the next; 0: tightly packed.
    pub fn of_bytes(
        name: &str,
        component_type: ComponentType,
        components: u32,
        bytes: &'a [u8],
        stride: usize,
    ) -> Self {
        let name = name.to_string();
        Self { name, component_type, components, bytes, stride, normalized: false, bits: 0 }
    }

    /// The values are integers that stand for numbers from 0, or -1, to 1.
    pub fn normalized(mut self) -> Self {
        self.normalized = true;
        self
    }

    /// Bits of a component of floats, 1 to 30, in place of the options' bits.
    pub fn bits(mut self, bits: u32) -> Self {
        self.bits = i32::try_from(bits).unwrap_or(i32::MAX).max(1);
        self
    }

    /// Floats are kept exactly, as integers always are.
    pub fn exact(mut self) -> Self {
        self.bits = -1;
        self
    }
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for u8 {}
    impl Sealed for u16 {}
    impl Sealed for u32 {}
}
/// A number of a point: `u8`, `u16` or `u32`.
pub trait Index: Component + sealed::Sealed {}
impl Index for u8 {}
impl Index for u16 {}
impl Index for u32 {}

/// A triangle mesh of the caller's.
#[derive(Clone, Debug)]
pub struct EncodeSource<'a> {
    point_count: u32,
    indices: &'a [u8],
    index_size: u32,
    attributes: Vec<AttributeValues<'a>>,
}

impl<'a> EncodeSource<'a> {
    /// Three indices for each face. `POSITION` is one of the attributes that are to be added.
    pub fn new<I: Index>(indices: &'a [I], point_count: u32) -> Self {
        let index_size = std::mem::size_of::<I>() as u32;
        Self { point_count, indices: bytes_of(indices), index_size, attributes: Vec::new() }
    }

    pub fn with(mut self, attribute: AttributeValues<'a>) -> Self {
        self.attributes.push(attribute);
        self
    }
}

/// How a mesh is encoded. `EncodeOptions::default()` has the defaults of the C library.
#[derive(Clone)]
pub struct EncodeOptions<'a> {
    /// `None`: patches if the mesh is split, otherwise a Draco stream. [`Kind::Patches`]: a container of patches, if only of
    /// one. [`Kind::Draco`]: a stream as any encoder of Draco writes it.
    pub kind: Option<Kind>,
    /// 0 (smallest) to 10 (fastest).
    pub speed: i32,
    /// Both 0: 2, 4, 8, 16 or a multiple of 16 patches of about 30,000 faces, from 20,000 faces on.
    pub patch_count: u32,
    pub patch_faces: u32,
    /// Bits of components of floats, 1 to 30; `None` keeps floats exactly.
    pub position_bits: Option<u32>,
    pub normal_bits: Option<u32>,
    pub texcoord_bits: Option<u32>,
    pub color_bits: Option<u32>,
    pub generic_bits: Option<u32>,
    /// Points that are equal in everything stay apart.
    pub keep_duplicates: bool,
    /// Keeps faces that repeat an index; they draw nothing.
    pub keep_degenerate: bool,
    /// Keeps points that no face uses.
    pub keep_unused: bool,
    /// Patches share their tables, if that saves bytes.
    pub condense: bool,
    /// Decodes the result, and compares it with the source.
    pub verify: bool,
    /// Threads, progress in faces, and a flag that ends the work.
    pub run: Run<'a>,
}

impl Default for EncodeOptions<'_> {
    fn default() -> Self {
        let mut defaults = sys::psplit_encode_options::new();
        // SAFETY: the struct has its size.
        unsafe { sys::psplit_encode_options_init(&mut defaults) };
        let bits = |bits: i32| u32::try_from(bits).ok();
        let has = |flag: u32| defaults.flags & flag != 0;
        Self {
            kind: Kind::of_c(defaults.kind),
            speed: defaults.speed,
            patch_count: defaults.patch_count,
            patch_faces: defaults.patch_faces,
            position_bits: bits(defaults.position_bits),
            normal_bits: bits(defaults.normal_bits),
            texcoord_bits: bits(defaults.texcoord_bits),
            color_bits: bits(defaults.color_bits),
            generic_bits: bits(defaults.generic_bits),
            keep_duplicates: has(sys::PSPLIT_ENCODE_KEEP_DUPLICATES),
            keep_degenerate: has(sys::PSPLIT_ENCODE_KEEP_DEGENERATE),
            keep_unused: has(sys::PSPLIT_ENCODE_KEEP_UNUSED),
            condense: has(sys::PSPLIT_ENCODE_CONDENSE),
            verify: !has(sys::PSPLIT_ENCODE_WITHOUT_VERIFYING),
            run: Run::default(),
        }
    }
}

impl EncodeOptions<'_> {
    fn to_c(&self) -> sys::psplit_encode_options {
        // C refuses numbers that are too large.
        let bits = |bits: Option<u32>| bits.map_or(-1, |bits| i32::try_from(bits).unwrap_or(i32::MAX));
        let mut options = sys::psplit_encode_options::new();
        // SAFETY: the struct has its size.
        unsafe { sys::psplit_encode_options_init(&mut options) };
        options.kind = self.kind.map_or(sys::PSPLIT_KIND_NONE, Kind::to_c);
        options.speed = self.speed;
        options.threads = self.run.thread_count();
        options.pool = self.run.pool_pointer();
        options.patch_count = self.patch_count;
        options.patch_faces = self.patch_faces;
        options.position_bits = bits(self.position_bits);
        options.normal_bits = bits(self.normal_bits);
        options.texcoord_bits = bits(self.texcoord_bits);
        options.color_bits = bits(self.color_bits);
        options.generic_bits = bits(self.generic_bits);
        options.flags = [
            (self.keep_duplicates, sys::PSPLIT_ENCODE_KEEP_DUPLICATES),
            (self.keep_degenerate, sys::PSPLIT_ENCODE_KEEP_DEGENERATE),
            (self.keep_unused, sys::PSPLIT_ENCODE_KEEP_UNUSED),
            (self.condense, sys::PSPLIT_ENCODE_CONDENSE),
            (!self.verify, sys::PSPLIT_ENCODE_WITHOUT_VERIFYING),
        ]
        .iter()
        .filter(|(is_set, _)| *is_set)
        .fold(0, |flags, (_, flag)| flags | flag);
        options.stop = self.run.stop_pointer();
        options
    }
}

/// Encodes a triangle mesh, to the bytes of `gltf-psplit encode` with any number of threads. Faces and points get another
/// order: see [`Encoded::source_points`].
///
/// ```no_run
/// # use gltf_psplit::{encode, AttributeValues, EncodeOptions, EncodeSource};
/// # fn run(indices: &[u32], positions: &[f32]) -> Result<(), gltf_psplit::Error> {
/// let source = EncodeSource::new(indices, positions.len() as u32 / 3)
///     .with(AttributeValues::new("POSITION", positions, 3));
/// let encoded = encode(&source, &EncodeOptions::default())?;
/// println!("{:?}, {} bytes", encoded.kind(), encoded.bytes().len());
/// # Ok(())
/// # }
/// ```
pub fn encode(source: &EncodeSource<'_>, options: &EncodeOptions<'_>) -> Result<Encoded, Error> {
    let names: Vec<CString> =
        source.attributes.iter().map(|attribute| name_of(&attribute.name)).collect::<Result<_, _>>()?;
    let attributes: Vec<sys::psplit_attribute_values> = source
        .attributes
        .iter()
        .zip(&names)
        .map(|(attribute, name)| {
            let mut values = sys::psplit_attribute_values::new();
            values.r#type = attribute.component_type.to_c();
            values.name = name.as_ptr();
            values.data = attribute.bytes.as_ptr().cast();
            values.size = attribute.bytes.len();
            values.stride = attribute.stride;
            values.components = attribute.components;
            values.normalized = attribute.normalized.into();
            values.bits = attribute.bits;
            values
        })
        .collect();
    let mut c_source = sys::psplit_encode_source::new();
    c_source.point_count = source.point_count;
    c_source.indices = source.indices.as_ptr().cast();
    c_source.indices_size = source.indices.len();
    c_source.index_size = source.index_size;
    c_source.attribute_count = number(attributes.len());
    c_source.attributes = attributes.as_ptr();
    let mut c_options = options.to_c();
    let mut encoded = null_mut();
    with_progress(options.run.progress, |progress, user| {
        c_options.progress = progress;
        c_options.user = user;
        // SAFETY: all that the structs point to lives until the call returns.
        checked(|error| unsafe { sys::psplit_encode(&c_source, &c_options, &mut encoded, error) })
    })?;
    Ok(Encoded(NonNull::new(encoded).expect("a mesh that was encoded is not null")))
}

/// Encoded bytes, and what a loader must know about them.
pub struct Encoded(NonNull<sys::psplit_encoded>);

// SAFETY: functions of C take it from any thread, and only read it. Freeing it needs it alone, as drop has it.
unsafe impl Send for Encoded {}
unsafe impl Sync for Encoded {}

impl Drop for Encoded {
    fn drop(&mut self) {
        // SAFETY: what borrows from it is gone.
        unsafe { sys::psplit_encoded_free(self.0.as_ptr()) }
    }
}

impl std::fmt::Debug for Encoded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Encoded({:?}, {} bytes)", self.kind(), self.bytes().len())
    }
}

impl Encoded {
    fn info(&self) -> sys::psplit_encoded_info {
        let mut info = sys::psplit_encoded_info::new();
        // SAFETY: the handle is valid, and the place for the result is a struct of the stated size.
        checked(|error| unsafe { sys::psplit_encoded_get_info(self.0.as_ptr(), &mut info, error) })
            .expect("what was encoded has sizes");
        info
    }

    /// A kind for [`Mesh::open`](crate::Mesh::open).
    pub fn kind(&self) -> Kind {
        Kind::of_c(self.info().kind).expect("what was encoded has a kind")
    }

    /// The bytes of the extension's buffer view.
    pub fn bytes(&self) -> &[u8] {
        let info = self.info();
        // SAFETY: they belong to the handle. Encoded bytes are never empty, so the pointer is not null.
        unsafe { std::slice::from_raw_parts(info.data.cast(), info.size) }
    }

    pub fn point_count(&self) -> u32 {
        self.info().point_count
    }
    pub fn face_count(&self) -> u32 {
        self.info().face_count
    }
    /// The number of patches, including a residue.
    pub fn patch_count(&self) -> u32 {
        self.info().patch_count
    }

    /// For each decoded point the point of the source that it was. Data beside the attributes, such as morph targets, are
    /// reordered by it.
    pub fn source_points(&self) -> &[u32] {
        let info = self.info();
        // SAFETY: they belong to the handle, one for each point. A mesh has points, so the pointer is not null.
        unsafe { std::slice::from_raw_parts(info.source_points, info.point_count as usize) }
    }

    /// The largest distance between a position and its decoded one, if it was measured.
    pub fn position_error(&self) -> Option<f64> {
        Some(self.info().position_error).filter(|error| *error >= 0.0)
    }

    /// How [`Mesh::open`](crate::Mesh::open), or glTF's JSON, requests the attributes, in the order of the source.
    pub fn attributes(&self) -> Result<Vec<AttributeRequest>, Error> {
        (0..self.info().attribute_count)
            .map(|attribute| {
                let mut request = sys::psplit_attribute_request::new();
                // SAFETY: the handle is valid, and the place for the result is a struct of the stated size.
                checked(|error| unsafe {
                    sys::psplit_encoded_get_attribute(self.0.as_ptr(), attribute, &mut request, error)
                })?;
                Ok(AttributeRequest {
                    // SAFETY: the name belongs to the handle.
                    name: unsafe { text_of(request.name) },
                    unique_id: request.unique_id,
                    component_type: ComponentType::of_c(request.r#type).ok_or_else(|| {
                        Error::usage("an attribute has a type of a newer version of psplit")
                    })?,
                    components: request.components,
                    normalized: request.normalized != 0,
                })
            })
            .collect()
    }

    /// Sentences about the precision of the mesh: what the encoder did for it, or what it lost.
    pub fn notes(&self) -> Vec<String> {
        // SAFETY: the handle is valid, and the texts belong to it.
        (0..self.info().note_count)
            .map(|note| unsafe { text_of(sys::psplit_encoded_note(self.0.as_ptr(), note)) })
            .collect()
    }

    /// How an attribute is stored. Errors: there is no such attribute.
    pub fn quantization(&self, attribute: usize) -> Result<Quantization, Error> {
        let mut found = sys::psplit_quantization::new();
        // SAFETY: the handle is valid, and the place for the result is a struct of the stated size.
        checked(|error| unsafe {
            sys::psplit_encoded_get_quantization(self.0.as_ptr(), number(attribute), &mut found, error)
        })?;
        // SAFETY: the origin belongs to the handle.
        Ok(unsafe { quantization_of(&found) })
    }

    /// Why it is stored so: "POSITION gets 14 bits, as the options say". `None` if there is no such attribute.
    pub fn reason(&self, attribute: usize) -> Option<String> {
        // SAFETY: the handle is valid, and the text belongs to it.
        unsafe {
            let reason = sys::psplit_encoded_reason(self.0.as_ptr(), number(attribute));
            (!reason.is_null()).then(|| text_of(reason))
        }
    }

    /// What glTF's JSON says about the mesh: an object with `primitive`, `accessors`, which get the numbers from
    /// `first_accessor` on, and `extensions`, the names that are used and required. The bytes are in the buffer view of the
    /// number `buffer_view`.
    pub fn gltf_json(&self, first_accessor: u32, buffer_view: u32) -> Result<String, Error> {
        // SAFETY: the handle is valid, and the place for the result is a pointer.
        let mut bytes = output(|made, error| unsafe {
            sys::psplit_encoded_write_json(self.0.as_ptr(), first_accessor, buffer_view, made, error)
        })?;
        bytes.pop(); // the zero that ends the text
        Ok(String::from_utf8(bytes).expect("JSON is UTF-8"))
    }

    /// A whole `.glb` file with the mesh in a scene, without a material.
    pub fn to_glb(&self) -> Result<Vec<u8>, Error> {
        // SAFETY: the handle is valid, and the place for the result is a pointer.
        output(|made, error| unsafe { sys::psplit_encoded_write_glb(self.0.as_ptr(), made, error) })
    }
}

/// A copy of the bytes that a function of C makes.
fn output(
    call: impl FnOnce(*mut *mut sys::psplit_output, *mut sys::psplit_error) -> sys::psplit_code,
) -> Result<Vec<u8>, Error> {
    let mut made = null_mut();
    checked(|error| call(&mut made, error))?;
    // SAFETY: the handle was made, and is freed when its bytes are copied. They are never empty, so their pointer is not null.
    unsafe {
        let data = sys::psplit_output_data(made).cast::<u8>();
        let bytes = std::slice::from_raw_parts(data, sys::psplit_output_size(made)).to_vec();
        sys::psplit_output_free(made);
        Ok(bytes)
    }
}
