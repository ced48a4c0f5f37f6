//! Primitives of glTF files.

use crate::error::{checked, Error};
use crate::mesh::{text_of, Kind, Mesh};
use gltf_psplit_sys as sys;
use std::marker::PhantomData;
use std::ptr::{null_mut, NonNull};

/// The JSON of a glTF file, and its bytes, which it borrows unless they were copied.
pub struct Gltf<'a> {
    handle: NonNull<sys::psplit_gltf>,
    bytes: PhantomData<&'a [u8]>,
}

// SAFETY: functions of C take it from any thread, also several at once, but for psplit_gltf_set_buffer, which has &mut self,
// and for freeing it.
unsafe impl Send for Gltf<'_> {}
unsafe impl Sync for Gltf<'_> {}

impl Drop for Gltf<'_> {
    fn drop(&mut self) {
        // SAFETY: calls that use it borrow it, so none does any more. Meshes keep what they need.
        unsafe { sys::psplit_gltf_free(self.handle.as_ptr()) }
    }
}

impl<'a> Gltf<'a> {
    /// Opens a `.glb` file, or the JSON of a `.gltf` file, and checks its meshes, accessors, buffer views and buffers.
    pub fn open(bytes: &'a [u8]) -> Result<Self, Error> {
        // SAFETY: the bytes are borrowed for as long as the result may live, and the meshes that it opens.
        unsafe { open(bytes, 0) }
    }

    /// Opens a copy of the bytes, otherwise like [`Gltf::open`].
    pub fn open_copy(bytes: &[u8]) -> Result<Gltf<'static>, Error> {
        // SAFETY: PSPLIT_COPY makes the library read the bytes during the call only.
        unsafe { open(bytes, sys::PSPLIT_COPY) }
    }

    pub fn buffer_count(&self) -> u32 {
        // SAFETY: the handle is valid.
        unsafe { sys::psplit_gltf_buffer_count(self.handle.as_ptr()) }
    }

    /// The URI of a buffer, which the caller reads for [`Gltf::set_buffer`]. `None` if it has none, as the buffer in a `.glb`
    /// file.
    pub fn buffer_uri(&self, buffer: u32) -> Option<String> {
        // SAFETY: the handle is valid, and the text belongs to it.
        unsafe {
            let uri = sys::psplit_gltf_buffer_uri(self.handle.as_ptr(), buffer);
            (!uri.is_null()).then(|| text_of(uri))
        }
    }

    /// Sets the bytes of a buffer, for the primitives that are opened afterwards. They are never copied.
    pub fn set_buffer(&mut self, buffer: u32, bytes: &'a [u8]) -> Result<(), Error> {
        // SAFETY: the handle is valid and not shared, and the bytes are borrowed for as long as meshes may live.
        checked(|error| unsafe {
            sys::psplit_gltf_set_buffer(
                self.handle.as_ptr(),
                buffer,
                bytes.as_ptr().cast(),
                bytes.len(),
                error,
            )
        })
    }

    pub fn mesh_count(&self) -> u32 {
        // SAFETY: the handle is valid.
        unsafe { sys::psplit_gltf_mesh_count(self.handle.as_ptr()) }
    }

    /// 0 if there is no such mesh.
    pub fn primitive_count(&self, mesh: u32) -> u32 {
        // SAFETY: the handle is valid.
        unsafe { sys::psplit_gltf_primitive_count(self.handle.as_ptr(), mesh) }
    }

    /// How a primitive is compressed. `None` if it is not, or does not exist.
    pub fn primitive_kind(&self, mesh: u32, primitive: u32) -> Option<Kind> {
        // SAFETY: the handle is valid.
        Kind::of_c(unsafe { sys::psplit_gltf_primitive_kind(self.handle.as_ptr(), mesh, primitive) })
    }

    /// Opens a primitive with all attributes that its extension stores, under their names in glTF. Errors name mesh and
    /// primitive. [`ErrorCode::Usage`](crate::ErrorCode::Usage): there is no such primitive, it is not compressed, or the
    /// bytes of its buffer are not set.
    pub fn open_primitive(&self, mesh: u32, primitive: u32) -> Result<Mesh<'a>, Error> {
        let mut result = null_mut();
        // SAFETY: the handle is valid. Its bytes, and the bytes of set_buffer, live as long as 'a, and so may the mesh.
        unsafe {
            checked(|error| {
                sys::psplit_gltf_open_primitive(self.handle.as_ptr(), mesh, primitive, &mut result, error)
            })?;
            Ok(Mesh::of_handle(result))
        }
    }

    /// Mesh and primitive of all primitives that are compressed.
    pub fn compressed_primitives(&self) -> Vec<(u32, u32)> {
        (0..self.mesh_count())
            .flat_map(|mesh| (0..self.primitive_count(mesh)).map(move |primitive| (mesh, primitive)))
            .filter(|&(mesh, primitive)| self.primitive_kind(mesh, primitive).is_some())
            .collect()
    }
}

/// The bytes live as long as `'g`, unless `flags` copy them.
unsafe fn open<'g>(bytes: &[u8], flags: u32) -> Result<Gltf<'g>, Error> {
    let mut source = sys::psplit_gltf_source::new();
    source.flags = flags;
    source.data = bytes.as_ptr().cast();
    source.size = bytes.len();
    let mut gltf = null_mut();
    // SAFETY: the struct lives until the call returns; the bytes longer, says the caller.
    checked(|error| unsafe { sys::psplit_gltf_open(&source, &mut gltf, error) })?;
    Ok(Gltf { handle: NonNull::new(gltf).expect("an opened file is not null"), bytes: PhantomData })
}
