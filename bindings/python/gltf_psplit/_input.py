"""What callers give: bytes of any kind, or a path."""
from __future__ import annotations

import os
from typing import Any, Union

BytesLike = Union[bytes, bytearray, memoryview, "os.PathLike[str]", str, Any]


def bytes_of(data: Any) -> Any:
    """The bytes of a file that is named, or `data` itself."""
    if isinstance(data, (str, os.PathLike)):
        with open(data, "rb") as file:
            return file.read()
    return data


def first_bytes(data: Any, count: int) -> bytes:
    """The first bytes of an object with a buffer. TypeError for others."""
    if isinstance(data, bytes):
        return data[:count]
    with memoryview(data) as view:
        if not view.c_contiguous:
            raise TypeError("expected a contiguous bytes-like object")
        if view.nbytes == 0:
            return b""
        return bytes(view.cast("B")[:count])


def is_draco(data: Any) -> bool:
    return first_bytes(data, 5) == b"DRACO"


def is_container(data: Any) -> bool:
    return first_bytes(data, 4) == b"PSPL"


def is_gltf(data: Any) -> bool:
    start = first_bytes(data, 64)
    return start[:4] == b"glTF" or start.replace(b"\xef\xbb\xbf", b"", 1).lstrip()[:1] == b"{"
