"""Checks the caller's arguments: errors name the argument and its actual type or value."""
from __future__ import annotations

import operator
import os
from typing import TYPE_CHECKING, Any, Dict, Mapping, Optional, Tuple, Union

import numpy as np

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer
    from numpy.typing import NDArray

# Any bytes-like object, or the path of a file.
Source = Union["ReadableBuffer", "NDArray[Any]", str, "os.PathLike[str]"]


def bytes_of(data: Any, what: str) -> Any:
    """The bytes of the file if `data` is a path, otherwise `data` itself, whose bytes must be contiguous."""
    if isinstance(data, bytes):
        return data
    if isinstance(data, (str, os.PathLike)):
        with open(data, "rb") as file:
            return file.read()
    try:
        with memoryview(data) as view:
            if view.c_contiguous:
                return data
    except (TypeError, ValueError, BufferError):
        raise TypeError(f"{what} is a {type(data).__name__}, neither bytes nor the path of a file") from None
    raise TypeError(f"{what} has gaps between its bytes: it is not contiguous")


def first_bytes(data: Any, count: int) -> bytes:
    """The first bytes of a result of bytes_of."""
    if isinstance(data, bytes):
        return data[:count]
    with memoryview(data) as view:
        return bytes(view.cast("B")[:count]) if view.nbytes > 0 else b""


def is_draco(data: Any) -> bool:
    return first_bytes(data, 5) == b"DRACO"


def is_container(data: Any) -> bool:
    return first_bytes(data, 4) == b"PSPL"


def is_gltf(data: Any) -> bool:
    start = first_bytes(data, 64)
    return start[:4] == b"glTF" or start.replace(b"\xef\xbb\xbf", b"", 1).lstrip()[:1] == b"{"


def integer(value: Any, what: str, least: int, most: int) -> int:
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{what} is a {type(value).__name__}, not an integer") from None
    if not least <= number <= most:
        raise ValueError(f"{what} is {number}, not {least} to {most}")
    return number


def thread_count(value: Any) -> int:
    number = integer(value, "threads", -2**31, 2**31 - 1)
    if number < 0:
        raise ValueError("threads is negative")
    return number


def number(value: Any, what: str) -> float:
    try:
        if isinstance(value, (str, bytes, bytearray)):
            raise TypeError
        return float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{what} is a {type(value).__name__}, not a number") from None


def flag(value: Any, what: str) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{what} is a {type(value).__name__}, not a bool")
    return bool(value)


def mapping(value: Any, what: str) -> Mapping[Any, Any]:
    if not isinstance(value, Mapping):
        raise TypeError(f"{what} is a {type(value).__name__}, not a mapping")
    return value


def optional_dict(value: Any, what: str) -> Optional[Dict[Any, Any]]:
    return None if value is None else dict(mapping(value, what))


def attribute_name(value: Any, what: str) -> str:
    """Checks a key of the mapping `what`."""
    if not isinstance(value, str):
        raise TypeError(f"{what} has the key {value!r}, which is not a string")
    try:
        value.encode()
    except UnicodeEncodeError:
        raise ValueError(f"{what} has the name {value!r}, which is not valid Unicode") from None
    return value


def numbers(values: Any, what: str) -> NDArray[Any]:
    """An array of real numbers, or an error."""
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise ValueError(f"{what} is not an array: {error}") from None
    if array.dtype.kind not in "biuf":
        raise TypeError(f"{what} has the type {array.dtype}, not one of real numbers")
    return array


def rows(values: Any, what: str, columns: Tuple[int, ...]) -> NDArray[Any]:
    """An array with a row for each point or face."""
    array = numbers(values, what)
    if array.ndim == 1 and array.size % columns[0] == 0:  # DracoPy accepts flat lists as well
        array = array.reshape(-1, columns[0])
    if array.ndim != 2 or array.shape[1] not in columns:
        wanted = " or ".join(f"(n, {count})" for count in columns)
        raise ValueError(f"{what} has the shape {array.shape}, not {wanted}")
    return array
