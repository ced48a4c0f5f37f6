//! Values of attributes: types of components, and arrays of them.

use gltf_psplit_sys as sys;

/// The type of a component of an attribute.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ComponentType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
    /// A byte, of Draco streams only.
    Bool,
}

impl ComponentType {
    /// Bytes of a component.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 | Self::Bool => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    pub(crate) fn of_c(number: sys::psplit_type) -> Option<Self> {
        Some(match number {
            sys::PSPLIT_INT8 => Self::I8,
            sys::PSPLIT_UINT8 => Self::U8,
            sys::PSPLIT_INT16 => Self::I16,
            sys::PSPLIT_UINT16 => Self::U16,
            sys::PSPLIT_INT32 => Self::I32,
            sys::PSPLIT_UINT32 => Self::U32,
            sys::PSPLIT_INT64 => Self::I64,
            sys::PSPLIT_UINT64 => Self::U64,
            sys::PSPLIT_FLOAT32 => Self::F32,
            sys::PSPLIT_FLOAT64 => Self::F64,
            sys::PSPLIT_BOOL => Self::Bool,
            _ => return None,
        })
    }

    pub(crate) fn to_c(self) -> sys::psplit_type {
        match self {
            Self::I8 => sys::PSPLIT_INT8,
            Self::U8 => sys::PSPLIT_UINT8,
            Self::I16 => sys::PSPLIT_INT16,
            Self::U16 => sys::PSPLIT_UINT16,
            Self::I32 => sys::PSPLIT_INT32,
            Self::U32 => sys::PSPLIT_UINT32,
            Self::I64 => sys::PSPLIT_INT64,
            Self::U64 => sys::PSPLIT_UINT64,
            Self::F32 => sys::PSPLIT_FLOAT32,
            Self::F64 => sys::PSPLIT_FLOAT64,
            Self::Bool => sys::PSPLIT_BOOL,
        }
    }
}

mod sealed {
    pub trait Sealed {}
}

/// A number that a component may be: `i8` to `u64`, `f32` and `f64`. Any bytes are a value of it.
pub trait Component:
    sealed::Sealed + Copy + Default + PartialEq + std::fmt::Debug + Send + Sync + 'static
{
    const TYPE: ComponentType;
    #[doc(hidden)]
    fn of_values(values: &Values) -> Option<&[Self]>;
}

/// The values of an attribute, one component after the other.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    I8(Vec<i8>),
    U8(Vec<u8>),
    I16(Vec<i16>),
    U16(Vec<u16>),
    I32(Vec<i32>),
    U32(Vec<u32>),
    I64(Vec<i64>),
    U64(Vec<u64>),
    F32(Vec<f32>),
    F64(Vec<f64>),
    /// 0 or 1, as the stream has it.
    Bool(Vec<u8>),
}

macro_rules! components {
    ($($variant:ident: $type:ty,)*) => {
        $(
            impl sealed::Sealed for $type {}
            impl Component for $type {
                const TYPE: ComponentType = ComponentType::$variant;
                fn of_values(values: &Values) -> Option<&[Self]> {
                    match values {
                        Values::$variant(values) => Some(values),
                        _ => None,
                    }
                }
            }
        )*
        impl Values {
            /// `count` components, all zero.
            pub(crate) fn zeros(component_type: ComponentType, count: usize) -> Self {
                match component_type {
                    $(ComponentType::$variant => Self::$variant(vec![<$type>::default(); count]),)*
                    ComponentType::Bool => Self::Bool(vec![0; count]),
                }
            }

            pub fn component_type(&self) -> ComponentType {
                match self {
                    $(Self::$variant(_) => ComponentType::$variant,)*
                    Self::Bool(_) => ComponentType::Bool,
                }
            }

            /// The number of components of all points together.
            pub fn len(&self) -> usize {
                match self {
                    $(Self::$variant(values) => values.len(),)*
                    Self::Bool(values) => values.len(),
                }
            }

            pub fn as_bytes(&self) -> &[u8] {
                match self {
                    $(Self::$variant(values) => bytes_of(values),)*
                    Self::Bool(values) => values,
                }
            }

            pub(crate) fn as_bytes_mut(&mut self) -> &mut [u8] {
                match self {
                    $(Self::$variant(values) => bytes_of_mut(values),)*
                    Self::Bool(values) => values,
                }
            }
        }
    };
}

components! {
    I8: i8,
    U8: u8,
    I16: i16,
    U16: u16,
    I32: i32,
    U32: u32,
    I64: i64,
    U64: u64,
    F32: f32,
    F64: f64,
}

impl Values {
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The components, if they have the type `T`.
    pub fn get<T: Component>(&self) -> Option<&[T]> {
        T::of_values(self)
    }
}

pub(crate) fn bytes_of<T: Component>(values: &[T]) -> &[u8] {
    // SAFETY: components have no padding, and any of their bytes is a u8.
    unsafe { std::slice::from_raw_parts(values.as_ptr().cast(), std::mem::size_of_val(values)) }
}

pub(crate) fn bytes_of_mut<T: Component>(values: &mut [T]) -> &mut [u8] {
    // SAFETY: as bytes_of, and any bytes are values of a component.
    unsafe { std::slice::from_raw_parts_mut(values.as_mut_ptr().cast(), std::mem::size_of_val(values)) }
}
