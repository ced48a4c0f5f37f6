//! Memory that meshes are decoded into.

use crate::error::{checked, of_c, Error};
use crate::mesh::{number, AttributeInfo, Mesh};
use crate::run::Run;
use crate::values::{bytes_of_mut, Component, Values};
use gltf_psplit_sys as sys;
use std::marker::PhantomData;

/// The caller's memory for a mesh, or for a patch. Attributes that get none are not decoded.
///
/// ```no_run
/// # use gltf_psplit::{Buffers, Mesh, Run};
/// # fn run(mesh: &Mesh) -> Result<(), gltf_psplit::Error> {
/// let info = mesh.info();
/// let mut indices = vec![0u32; 3 * info.face_count as usize];
/// let mut positions = vec![0f32; 3 * info.point_count as usize];
/// let mut buffers = Buffers::new(mesh)?;
/// buffers.indices_u32(&mut indices);
/// buffers.attribute(mesh.find_name("POSITION").unwrap(), &mut positions)?;
/// mesh.decode_into(&mut buffers, &Run::default())
/// # }
/// ```
///
/// The memory stays borrowed, mutably, as long as they are used:
///
/// ```compile_fail,E0502
/// # fn run(mesh: &gltf_psplit::Mesh) {
/// let mut indices = vec![0u32; 3];
/// let mut buffers = gltf_psplit::Buffers::new(mesh).unwrap();
/// buffers.indices_u32(&mut indices);
/// println!("{}", indices[0]);
/// buffers.indices_u32(&mut []);
/// # }
/// ```
pub struct Buffers<'b> {
    infos: Vec<AttributeInfo>,
    buffers: sys::psplit_buffers, // its array is `attributes`, set when C is called
    attributes: Vec<sys::psplit_attribute_buffer>,
    memory: PhantomData<&'b mut [u8]>,
}

// SAFETY: it has mutable slices of numbers, which may go to another thread.
unsafe impl Send for Buffers<'_> {}

impl<'b> Buffers<'b> {
    /// Buffers for `mesh`, which have no memory yet.
    pub fn new(mesh: &Mesh<'_>) -> Result<Self, Error> {
        let infos = mesh.attributes()?;
        let mut buffers = sys::psplit_buffers::new();
        buffers.index_size = 4;
        let attributes = vec![sys::psplit_attribute_buffer::new(); infos.len()];
        Ok(Self { infos, buffers, attributes, memory: PhantomData })
    }

    /// Three for each face.
    pub fn indices_u32(&mut self, indices: &'b mut [u32]) -> &mut Self {
        self.indices(indices)
    }

    /// Three for each face; for at most 65,535 points.
    pub fn indices_u16(&mut self, indices: &'b mut [u16]) -> &mut Self {
        self.indices(indices)
    }

    fn indices<T: Component>(&mut self, indices: &'b mut [T]) -> &mut Self {
        self.buffers.index_size = T::TYPE.size() as u32;
        self.buffers.indices = indices.as_mut_ptr().cast();
        self.buffers.indices_size = std::mem::size_of_val(indices);
        self
    }

    /// Values of the type of the attribute, tightly packed.
    pub fn attribute<T: Component>(
        &mut self,
        attribute: usize,
        values: &'b mut [T],
    ) -> Result<&mut Self, Error> {
        let info = self.info(attribute)?;
        if info.component_type != T::TYPE {
            return Err(Error::usage(format!(
                "{} has components of {:?}, and the buffer of {:?}",
                info.name,
                info.component_type,
                T::TYPE
            )));
        }
        self.attribute_bytes(attribute, bytes_of_mut(values), 0)
    }

    /// Bytes of any alignment: `stride` from one value to the next, at least the size of a value; 0: tightly packed. The bytes
    /// between two values are not touched.
    pub fn attribute_bytes(
        &mut self,
        attribute: usize,
        bytes: &'b mut [u8],
        stride: usize,
    ) -> Result<&mut Self, Error> {
        self.info(attribute)?;
        self.set(attribute, bytes.as_mut_ptr(), bytes.len(), stride);
        Ok(self)
    }

    /// Vertices of `stride` bytes, each with several attributes: their numbers, and where they begin in a vertex. Errors: they
    /// overlap, or do not fit into a vertex.
    pub fn interleaved(
        &mut self,
        vertices: &'b mut [u8],
        stride: usize,
        attributes: &[(usize, usize)],
    ) -> Result<&mut Self, Error> {
        let mut ends: Vec<(usize, usize)> = Vec::new();
        for &(attribute, offset) in attributes {
            let info = self.info(attribute)?;
            match offset.checked_add(info.value_size) {
                Some(end) if end <= stride => ends.push((offset, end)),
                _ => return Err(Error::usage(format!("{} does not fit into a vertex", info.name))),
            }
        }
        ends.sort_unstable();
        if ends.windows(2).any(|pair| pair[1].0 < pair[0].1) {
            return Err(Error::usage("attributes of a vertex overlap"));
        }
        // All pointers come from one, so that all of them stay valid.
        let first = vertices.as_mut_ptr();
        for &(attribute, offset) in attributes {
            let offset = offset.min(vertices.len()); // C refuses a buffer that is too short
                                                     // SAFETY: within the slice, or at its end.
            let data = unsafe { first.add(offset) };
            self.set(attribute, data, vertices.len() - offset, stride);
        }
        Ok(self)
    }

    fn info(&self, attribute: usize) -> Result<&AttributeInfo, Error> {
        self.infos.get(attribute).ok_or_else(|| Error::usage(format!("there is no attribute {}", attribute)))
    }

    fn set(&mut self, attribute: usize, data: *mut u8, size: usize, stride: usize) {
        let buffer = &mut self.attributes[attribute];
        buffer.data = data.cast();
        buffer.size = size;
        buffer.stride = stride;
    }

    /// Gives `call` these buffers as C has them.
    pub(crate) fn with_c<R>(&mut self, call: impl FnOnce(&sys::psplit_buffers) -> R) -> R {
        let mut buffers = self.buffers;
        buffers.attributes = self.attributes.as_ptr();
        buffers.attribute_count = number(self.attributes.len());
        call(&buffers)
    }
}

/// The numbers of points, three for each face.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Indices {
    /// Indices of at most 65,535 points.
    U16(Vec<u16>),
    U32(Vec<u32>),
}

impl Indices {
    pub fn len(&self) -> usize {
        match self {
            Self::U16(indices) => indices.len(),
            Self::U32(indices) => indices.len(),
        }
    }
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    pub fn to_u32(&self) -> Vec<u32> {
        match self {
            Self::U16(indices) => indices.iter().copied().map(u32::from).collect(),
            Self::U32(indices) => indices.clone(),
        }
    }
}

/// The values of an attribute, one for each point.
#[derive(Clone, Debug, PartialEq)]
pub struct DecodedAttribute {
    pub info: AttributeInfo,
    pub values: Values,
}

impl DecodedAttribute {
    /// The components of all points, if they have the type `T`.
    pub fn values<T: Component>(&self) -> Option<&[T]> {
        self.values.get()
    }
}

/// A decoded mesh or point cloud.
#[derive(Clone, Debug, PartialEq)]
pub struct DecodedMesh {
    pub point_count: u32,
    /// Empty for a point cloud.
    pub indices: Indices,
    pub attributes: Vec<DecodedAttribute>,
}

impl DecodedMesh {
    pub fn face_count(&self) -> usize {
        self.indices.len() / 3
    }

    /// The attribute of that name.
    pub fn attribute(&self, name: &str) -> Option<&DecodedAttribute> {
        self.attributes.iter().find(|attribute| attribute.info.name == name)
    }

    pub(crate) fn decode(mesh: &Mesh<'_>, run: &Run<'_>) -> Result<Self, Error> {
        let info = mesh.info();
        let (points, corners) = (info.point_count as usize, 3 * info.face_count as usize);
        let mut indices = match info.least_index_size {
            2 => Indices::U16(vec![0; corners]),
            _ => Indices::U32(vec![0; corners]),
        };
        let mut buffers = Buffers::new(mesh)?;
        let mut values: Vec<Values> = buffers
            .infos
            .iter()
            .map(|attribute| Values::zeros(attribute.component_type, attribute.components as usize * points))
            .collect();
        match &mut indices {
            Indices::U16(indices) => buffers.indices_u16(indices),
            Indices::U32(indices) => buffers.indices_u32(indices),
        };
        for (attribute, values) in values.iter_mut().enumerate() {
            buffers.attribute_bytes(attribute, values.as_bytes_mut(), 0)?;
        }
        mesh.decode_into(&mut buffers, run)?;
        let infos = buffers.infos;
        let attributes =
            infos.into_iter().zip(values).map(|(info, values)| DecodedAttribute { info, values }).collect();
        Ok(Self { point_count: info.point_count, indices, attributes })
    }
}

/// Decodes many meshes at once, so that all threads are busy. The error of one mesh does not affect another.
pub fn decode_meshes(jobs: &mut [(&Mesh<'_>, Buffers<'_>)], run: &Run<'_>) -> Vec<Result<(), Error>> {
    const NOT_CALLED: sys::psplit_code = -1;
    let buffers: Vec<sys::psplit_buffers> =
        jobs.iter_mut().map(|(_, buffers)| buffers.with_c(|buffers| *buffers)).collect();
    let mut errors = vec![sys::psplit_error::new(); jobs.len()];
    let mut c_jobs: Vec<sys::psplit_job> = jobs
        .iter()
        .zip(&buffers)
        .zip(&mut errors)
        .map(|(((mesh, _), buffers), error)| {
            let mut job = sys::psplit_job::new();
            job.code = NOT_CALLED;
            job.mesh = mesh.pointer();
            job.buffers = buffers;
            job.error = error;
            job
        })
        .collect();
    // SAFETY: all that the jobs point to lives until the call returns, and the buffers are borrowed mutably.
    let all = run.with_c(|run| {
        checked(|error| unsafe { sys::psplit_decode_meshes(c_jobs.as_mut_ptr(), c_jobs.len(), run, error) })
    });
    c_jobs
        .iter()
        .zip(&errors)
        .map(|(job, error)| match job.code {
            sys::PSPLIT_OK => Ok(()),
            NOT_CALLED => all.clone(), // an error of the call as a whole
            code => Err(of_c(code, error)),
        })
        .collect()
}
