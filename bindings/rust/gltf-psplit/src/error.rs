use gltf_psplit_sys as sys;
use std::ffi::CStr;
use std::fmt;

/// What kind of error it is. Values of newer libraries are [`ErrorCode::Failure`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorCode {
    /// The arguments are wrong, or buffers do not fit.
    Usage,
    /// The bytes, or what was said about them, are malformed.
    InvalidInput,
    /// What should not fail failed.
    Failure,
    /// The input is valid, but uses what psplit does not support.
    Unsupported,
    /// A [`Stop`](crate::Stop) was set.
    Cancelled,
    /// Memory ran out; the same call may succeed later.
    NoMemory,
}

/// Where an error is, as far as it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    pub mesh: Option<u64>,
    pub primitive: Option<u64>,
    pub patch: Option<u64>,
}

/// Why a call failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    code: ErrorCode,
    message: String,
    place: Place,
}

impl Error {
    pub fn code(&self) -> ErrorCode {
        self.code
    }

    /// A sentence that begins with the place: "mesh 0, primitive 1, patch 7: ...".
    pub fn message(&self) -> &str {
        &self.message
    }

    pub fn place(&self) -> Place {
        self.place
    }

    pub(crate) fn usage(message: impl Into<String>) -> Self {
        Self { code: ErrorCode::Usage, message: message.into(), place: Place::default() }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Error {}

/// Calls a function of C with a place for its error.
pub(crate) fn checked(call: impl FnOnce(*mut sys::psplit_error) -> sys::psplit_code) -> Result<(), Error> {
    let mut error = sys::psplit_error::new();
    match call(&mut error) {
        sys::PSPLIT_OK => Ok(()),
        code => Err(of_c(code, &error)),
    }
}

/// The error that C describes, of a call that returned `code`.
pub(crate) fn of_c(code: sys::psplit_code, error: &sys::psplit_error) -> Error {
    let code = match code {
        sys::PSPLIT_ERROR_USAGE => ErrorCode::Usage,
        sys::PSPLIT_ERROR_INVALID_INPUT => ErrorCode::InvalidInput,
        sys::PSPLIT_ERROR_UNSUPPORTED => ErrorCode::Unsupported,
        sys::PSPLIT_ERROR_CANCELLED => ErrorCode::Cancelled,
        sys::PSPLIT_ERROR_NO_MEMORY => ErrorCode::NoMemory,
        _ => ErrorCode::Failure,
    };
    let place = |number: i64| u64::try_from(number).ok();
    // SAFETY: the library ends the text with a zero byte, and psplit_error::new() has only zeros.
    let message = unsafe { CStr::from_ptr(error.text.as_ptr()) }.to_string_lossy().into_owned();
    let place =
        Place { mesh: place(error.mesh), primitive: place(error.primitive), patch: place(error.patch) };
    Error { code, message, place }
}
