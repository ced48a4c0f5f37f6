//! Meshes to be decoded: opened, checked and described.

use crate::decode::{Buffers, DecodedMesh};
use crate::error::{checked, Error};
use crate::run::Run;
use crate::values::ComponentType;
use gltf_psplit_sys as sys;
use std::ffi::{CStr, CString};
use std::marker::PhantomData;
use std::os::raw::c_char;
use std::ptr::{null_mut, NonNull};

/// What a primitive's bytes are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A container of `PSPLIT_mesh_draco_patches`.
    Patches,
    /// A stream of `KHR_draco_mesh_compression`, whose attributes the caller knows.
    Draco,
    /// A whole Draco stream, mesh or point cloud: a `.drc` file.
    DracoFile,
}

impl Kind {
    /// `None` for primitives that are not compressed.
    pub(crate) fn of_c(kind: sys::psplit_kind) -> Option<Self> {
        match kind {
            sys::PSPLIT_KIND_PATCHES => Some(Self::Patches),
            sys::PSPLIT_KIND_DRACO => Some(Self::Draco),
            sys::PSPLIT_KIND_DRACO_FILE => Some(Self::DracoFile),
            _ => None,
        }
    }
    pub(crate) fn to_c(self) -> sys::psplit_kind {
        match self {
            Self::Patches => sys::PSPLIT_KIND_PATCHES,
            Self::Draco => sys::PSPLIT_KIND_DRACO,
            Self::DracoFile => sys::PSPLIT_KIND_DRACO_FILE,
        }
    }
}

/// How a `.drc` file stores its mesh or point cloud.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Coding {
    /// The mesh is no `.drc` file.
    Unknown,
    Sequential,
    Edgebreaker,
    EdgebreakerValence,
    CloudSequential,
    CloudKdTree,
}

/// What an attribute is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Semantic {
    Position,
    Normal,
    Color,
    TexCoord,
    Generic,
}

impl Semantic {
    fn of_c(semantic: sys::psplit_semantic) -> Self {
        match semantic {
            sys::PSPLIT_POSITION => Self::Position,
            sys::PSPLIT_NORMAL => Self::Normal,
            sys::PSPLIT_COLOR => Self::Color,
            sys::PSPLIT_TEXCOORD => Self::TexCoord,
            _ => Self::Generic,
        }
    }
    fn to_c(self) -> sys::psplit_semantic {
        match self {
            Self::Position => sys::PSPLIT_POSITION,
            Self::Normal => sys::PSPLIT_NORMAL,
            Self::Color => sys::PSPLIT_COLOR,
            Self::TexCoord => sys::PSPLIT_TEXCOORD,
            Self::Generic => sys::PSPLIT_GENERIC,
        }
    }
}

/// An attribute as glTF's JSON describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AttributeRequest {
    /// glTF's name, such as `POSITION`; of a morph target `targets/0/POSITION`.
    pub name: String,
    /// The extension's number for the attribute.
    pub unique_id: u32,
    /// The accessor's `componentType`: one of glTF's six.
    pub component_type: ComponentType,
    /// The components of a value, 1 to 16.
    pub components: u32,
    pub normalized: bool,
}

/// Facts about the bytes that they do not contain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OpenOptions {
    /// The `count` of the accessors of attributes and of indices, which are compared with the bytes; 0: not known.
    pub point_count: u64,
    pub index_count: u64,
    /// Whether values of `.drc` files are the integers of the stream, `i32`, where it has such.
    pub integers: bool,
}

/// The sizes of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshInfo {
    /// A point is a vertex of glTF: a tuple of attribute values.
    pub point_count: u32,
    /// 0: a point cloud.
    pub face_count: u32,
    pub attribute_count: u32,
    /// The number of patches, including the residue; 1 for a Draco stream.
    pub patch_count: u32,
    /// Whether the last patch has the faces and points that no other stream can carry.
    pub has_residue: bool,
    /// Bytes: 2 if all point numbers fit, otherwise 4.
    pub least_index_size: u32,
    pub kind: Kind,
    pub coding: Coding,
}

/// An attribute of a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AttributeInfo {
    /// glTF's name. Of `.drc` files a name that glTF would allow, or empty for all attributes if glTF cannot hold them.
    pub name: String,
    pub unique_id: u32,
    pub semantic: Semantic,
    /// The type of the decoded values.
    pub component_type: ComponentType,
    pub components: u32,
    pub normalized: bool,
    /// Bytes of a value, tightly packed.
    pub value_size: usize,
    /// Whether they are integers by [`OpenOptions::integers`].
    pub is_integers: bool,
}

/// How the values of an attribute are stored.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantization {
    /// The bits of a component. With 0 bits, values are exact. With bits and an origin, they are places i on a grid: value =
    /// origin + i * range / (2^bits - 1). Without an origin, they are unit vectors on an octahedron.
    pub bits: u32,
    pub range: f32,
    /// The origin of each component, or empty.
    pub origin: Vec<f32>,
}

/// A part of a mesh that is decoded alone. Its faces, and the points that it owns, are consecutive in the whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PatchInfo {
    pub face_count: u32,
    /// The points of the patch when it decodes alone, including points that other patches own.
    pub point_count: u32,
    /// Bytes; 0 for a `.drc` file.
    pub stream_size: u32,
    pub first_face: u32,
    pub first_owned_point: u32,
    pub owned_point_count: u32,
    pub is_residue: bool,
}

/// A compressed mesh, opened and checked. It borrows its bytes, unless they were copied:
///
/// ```compile_fail,E0597
/// let mesh = {
///     let bytes = std::fs::read("bunny.drc").unwrap();
///     gltf_psplit::Mesh::open_draco_file(&bytes).unwrap()
/// };
/// mesh.info(); // the bytes are gone
/// ```
pub struct Mesh<'a> {
    handle: NonNull<sys::psplit_mesh>,
    bytes: PhantomData<&'a [u8]>,
}

// SAFETY: functions of C take a mesh from any thread, also several at once. Freeing it needs it alone, as drop has it.
unsafe impl Send for Mesh<'_> {}
unsafe impl Sync for Mesh<'_> {}

impl Drop for Mesh<'_> {
    fn drop(&mut self) {
        // SAFETY: calls that use the mesh borrow it, so none does any more.
        unsafe { sys::psplit_mesh_free(self.handle.as_ptr()) }
    }
}

impl std::fmt::Debug for Mesh<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Mesh").field(&self.info()).finish()
    }
}

impl<'a> Mesh<'a> {
    /// Opens a whole Draco stream, mesh or point cloud. It has the stream's attributes.
    pub fn open_draco_file(bytes: &'a [u8]) -> Result<Self, Error> {
        Self::open(Kind::DracoFile, bytes, &[], &OpenOptions::default())
    }

    /// Opens the bytes of an extension's buffer view, or a `.drc` file. `attributes` are the wanted ones of the
    /// extension, in any order; none for [`Kind::DracoFile`].
    pub fn open(
        kind: Kind,
        bytes: &'a [u8],
        attributes: &[AttributeRequest],
        options: &OpenOptions,
    ) -> Result<Self, Error> {
        // SAFETY: the bytes are borrowed for as long as the mesh may live.
        unsafe { open(kind, bytes, attributes, options, 0) }
    }

    /// Opens a copy of the bytes, otherwise like [`Mesh::open`].
    pub fn open_copy(
        kind: Kind,
        bytes: &[u8],
        attributes: &[AttributeRequest],
        options: &OpenOptions,
    ) -> Result<Mesh<'static>, Error> {
        // SAFETY: PSPLIT_COPY makes the library read the bytes during the call only.
        unsafe { open(kind, bytes, attributes, options, sys::PSPLIT_COPY) }
    }

    /// `handle` is a mesh whose bytes live as long as `'a`, and which nothing else frees.
    pub(crate) unsafe fn of_handle(handle: *mut sys::psplit_mesh) -> Self {
        Self { handle: NonNull::new(handle).expect("an opened mesh is not null"), bytes: PhantomData }
    }

    pub(crate) fn pointer(&self) -> *const sys::psplit_mesh {
        self.handle.as_ptr()
    }

    pub fn info(&self) -> MeshInfo {
        let mut info = sys::psplit_mesh_info::new();
        // SAFETY: the handle is valid, and the place for the result is a struct of the stated size.
        checked(|error| unsafe { sys::psplit_mesh_get_info(self.pointer(), &mut info, error) })
            .expect("a mesh has sizes");
        MeshInfo {
            point_count: info.point_count,
            face_count: info.face_count,
            attribute_count: info.attribute_count,
            patch_count: info.patch_count,
            has_residue: info.has_residue != 0,
            least_index_size: info.least_index_size,
            kind: Kind::of_c(info.kind).expect("a mesh that was opened has a kind"),
            coding: match info.coding {
                sys::PSPLIT_CODING_SEQUENTIAL => Coding::Sequential,
                sys::PSPLIT_CODING_EDGEBREAKER => Coding::Edgebreaker,
                sys::PSPLIT_CODING_EDGEBREAKER_VALENCE => Coding::EdgebreakerValence,
                sys::PSPLIT_CODING_CLOUD_SEQUENTIAL => Coding::CloudSequential,
                sys::PSPLIT_CODING_CLOUD_KD_TREE => Coding::CloudKdTree,
                _ => Coding::Unknown,
            },
        }
    }

    /// The attribute of that number. Errors: there is none ([`ErrorCode::Usage`](crate::ErrorCode::Usage)).
    pub fn attribute(&self, attribute: usize) -> Result<AttributeInfo, Error> {
        let mut info = sys::psplit_attribute_info::new();
        // SAFETY: the handle is valid, and the place for the result is a struct of the stated size.
        checked(|error| unsafe {
            sys::psplit_mesh_get_attribute(self.pointer(), number(attribute), &mut info, error)
        })?;
        Ok(AttributeInfo {
            // SAFETY: the name belongs to the mesh, which is borrowed.
            name: unsafe { text_of(info.name) },
            unique_id: info.unique_id,
            semantic: Semantic::of_c(info.semantic),
            component_type: ComponentType::of_c(info.r#type)
                .ok_or_else(|| Error::usage("an attribute has a type of a newer version of psplit"))?,
            components: info.components,
            normalized: info.normalized != 0,
            value_size: info.value_size as usize,
            is_integers: info.is_integers != 0,
        })
    }

    pub fn attributes(&self) -> Result<Vec<AttributeInfo>, Error> {
        (0..self.info().attribute_count as usize).map(|attribute| self.attribute(attribute)).collect()
    }

    /// The number of the attribute of that name.
    pub fn find_name(&self, name: &str) -> Option<usize> {
        let name = CString::new(name).ok()?;
        // SAFETY: the handle is valid, and the name lives until the call returns.
        usize::try_from(unsafe { sys::psplit_mesh_find_name(self.pointer(), name.as_ptr()) }).ok()
    }

    /// The number of the attribute with that unique id.
    pub fn find_id(&self, unique_id: u32) -> Option<usize> {
        // SAFETY: the handle is valid.
        usize::try_from(unsafe { sys::psplit_mesh_find_id(self.pointer(), unique_id) }).ok()
    }

    /// The number of the attribute after `skip` others of that semantic.
    pub fn find_semantic(&self, semantic: Semantic, skip: u32) -> Option<usize> {
        // SAFETY: the handle is valid.
        usize::try_from(unsafe { sys::psplit_mesh_find_semantic(self.pointer(), semantic.to_c(), skip) }).ok()
    }

    /// How the values of an attribute are stored. The first call decodes a stream for that, unless the mesh is a `.drc` file
    /// without a kD-tree.
    pub fn quantization(&self, attribute: usize) -> Result<Quantization, Error> {
        let mut found = sys::psplit_quantization::new();
        // SAFETY: the handle is valid, and the place for the result is a struct of the stated size.
        checked(|error| unsafe {
            sys::psplit_mesh_get_quantization(self.pointer(), number(attribute), &mut found, error)
        })?;
        // SAFETY: the origin belongs to the mesh, which is borrowed.
        Ok(unsafe { quantization_of(&found) })
    }

    /// Errors: there is no such patch ([`ErrorCode::Usage`](crate::ErrorCode::Usage)).
    pub fn patch(&self, patch: u32) -> Result<PatchInfo, Error> {
        let mut info = sys::psplit_patch_info::new();
        // SAFETY: the handle is valid, and the place for the result is a struct of the stated size.
        checked(|error| unsafe { sys::psplit_mesh_get_patch(self.pointer(), patch, &mut info, error) })?;
        Ok(PatchInfo {
            face_count: info.face_count,
            point_count: info.point_count,
            stream_size: info.stream_size,
            first_face: info.first_face,
            first_owned_point: info.first_owned_point,
            owned_point_count: info.owned_point_count,
            is_residue: info.is_residue != 0,
        })
    }

    /// Decodes the whole mesh into arrays of its own.
    pub fn decode(&self, run: &Run<'_>) -> Result<DecodedMesh, Error> {
        DecodedMesh::decode(self, run)
    }

    /// Decodes the whole mesh into the caller's memory. After an error it may hold anything.
    pub fn decode_into(&self, buffers: &mut Buffers<'_>, run: &Run<'_>) -> Result<(), Error> {
        buffers.with_c(|buffers| {
            // SAFETY: the handle is valid, and the buffers are borrowed mutably.
            run.with_c(|run| {
                checked(|error| unsafe { sys::psplit_mesh_decode(self.pointer(), buffers, run, error) })
            })
        })
    }

    /// Decodes one patch into the caller's memory, which has the sizes of its [`PatchInfo`]. Indices count from its first
    /// point. No other patch's stream is read.
    pub fn decode_patch_into(
        &self,
        patch: u32,
        buffers: &mut Buffers<'_>,
        run: &Run<'_>,
    ) -> Result<(), Error> {
        buffers.with_c(|buffers| {
            // SAFETY: as decode_into.
            run.with_c(|run| {
                checked(|error| unsafe {
                    sys::psplit_mesh_decode_patch(self.pointer(), patch, buffers, run, error)
                })
            })
        })
    }
}

/// The bytes live as long as `'m`, unless `flags` copy them.
unsafe fn open<'m>(
    kind: Kind,
    bytes: &[u8],
    attributes: &[AttributeRequest],
    options: &OpenOptions,
    flags: u32,
) -> Result<Mesh<'m>, Error> {
    let names: Vec<CString> =
        attributes.iter().map(|request| name_of(&request.name)).collect::<Result<_, _>>()?;
    let requests: Vec<sys::psplit_attribute_request> = attributes
        .iter()
        .zip(&names)
        .map(|(request, name)| {
            let mut element = sys::psplit_attribute_request::new();
            element.unique_id = request.unique_id;
            element.name = name.as_ptr();
            element.r#type = request.component_type.to_c();
            element.components = request.components;
            element.normalized = request.normalized.into();
            element
        })
        .collect();
    let mut source = sys::psplit_source::new();
    source.kind = kind.to_c();
    source.data = bytes.as_ptr().cast();
    source.size = bytes.len();
    source.attributes = requests.as_ptr();
    source.attribute_count = number(requests.len());
    source.flags = flags | if options.integers { sys::PSPLIT_INTEGERS } else { 0 };
    source.point_count = options.point_count;
    source.index_count = options.index_count;
    let mut mesh = null_mut();
    // SAFETY: the struct and what it points to live until the call returns; the bytes longer, says the caller.
    unsafe {
        checked(|error| sys::psplit_mesh_open(&source, &mut mesh, error))?;
        Ok(Mesh::of_handle(mesh))
    }
}

/// A number of C. What does not fit is larger than any that exists.
pub(crate) fn number(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

pub(crate) fn name_of(name: &str) -> Result<CString, Error> {
    CString::new(name).map_err(|_| Error::usage(format!("the name {:?} has a zero byte", name)))
}

/// `text` is null or a string of C.
pub(crate) unsafe fn text_of(text: *const c_char) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: by the caller.
    unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
}

/// The origin is still there.
pub(crate) unsafe fn quantization_of(found: &sys::psplit_quantization) -> Quantization {
    let origin = if found.origin.is_null() {
        Vec::new()
    } else {
        // SAFETY: by the caller.
        unsafe { std::slice::from_raw_parts(found.origin, found.origin_count as usize) }.to_vec()
    };
    Quantization { bits: found.bits as u32, range: found.range, origin }
}
