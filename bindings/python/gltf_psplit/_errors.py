"""The exceptions of the package."""
from __future__ import annotations

from typing import Any, Optional, Tuple, Type


class Error(ValueError):
    """The reason why data cannot be decoded or encoded, with the place.

    Attributes:
        code: "invalid_input", "unsupported", "usage", "io", "runtime_failure", "out_of_memory" or "may_pass".
        patch: the index of the patch in its container, or None.
        mesh, primitive: the indices of a glTF primitive, or None.
    """

    code = "runtime_failure"

    def __init__(self, message: str, *, code: Optional[str] = None, patch: Optional[int] = None,
                 mesh: Optional[int] = None, primitive: Optional[int] = None) -> None:
        super().__init__(message)
        self.code = code or type(self).code
        self.patch = patch
        self.mesh = mesh
        self.primitive = primitive

    def __reduce__(self) -> Tuple[Any, ...]:  # so that it can be pickled
        return _unpickled, (type(self), str(self), self.code, self.patch, self.mesh, self.primitive)


class InvalidInputError(Error):
    """Data that are malformed or contradictory."""

    code = "invalid_input"


class UnsupportedError(Error):
    """Valid data that psplit does not support, such as Draco bitstreams before 2.2 without libdraco."""

    code = "unsupported"


class OutOfMemoryError(Error, MemoryError):
    """Memory ran out. The same call may succeed with more memory."""

    code = "out_of_memory"


def error_of(code: str, message: str, patch: Optional[int], mesh: Optional[int], primitive: Optional[int]) -> Error:
    """The exception for an error of the C++ module."""
    kind = {kind.code: kind for kind in (InvalidInputError, UnsupportedError, OutOfMemoryError)}.get(code, Error)
    return kind(message, code=code, patch=patch, mesh=mesh, primitive=primitive)


def _unpickled(kind: Type[Error], message: str, code: str, patch: Optional[int], mesh: Optional[int],
               primitive: Optional[int]) -> Error:
    return kind(message, code=code, patch=patch, mesh=mesh, primitive=primitive)
