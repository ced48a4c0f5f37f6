"""Converts binary PLY files from big-endian to little-endian, the only order that libdraco's reader takes."""

kBytes = {"char": 1, "uchar": 1, "int8": 1, "uint8": 1, "short": 2, "ushort": 2, "int16": 2, "uint16": 2, "int": 4,
          "uint": 4, "int32": 4, "uint32": 4, "float": 4, "float32": 4, "double": 8, "float64": 8}


class PlyError(Exception):
    pass


def parse_header(data):
    """The length of the header, and for each element its name, count and properties. A property is (bytes,), or for a list
    (bytes of its length, bytes of an item)."""
    end = data.find(b"end_header")
    if not data.startswith(b"ply") or end < 0:
        raise PlyError("not a PLY file")
    length = data.index(b"\n", end) + 1
    elements = []
    for line in data[:end].decode("ascii", "replace").splitlines():
        words = line.split()
        try:
            if words[:1] == ["element"]:
                elements.append((words[1], int(words[2]), []))
            elif words[:2] == ["property", "list"]:
                elements[-1][2].append((kBytes[words[2]], kBytes[words[3]]))
            elif words[:1] == ["property"]:
                elements[-1][2].append((kBytes[words[1]],))
        except (IndexError, KeyError, ValueError) as error:
            raise PlyError(f"a line of the header makes no sense: {line}") from error
    return length, elements


def swap_records(body, at, count, fields):
    """Swaps the bytes of each field of `count` records in place, and returns where the records end. `fields` has the bytes of
    each field of a record."""
    size = sum(fields)
    end = at + count * size
    if end > len(body):
        raise PlyError("ends too early")
    start = 0
    for field in fields:
        for i in range(field // 2):
            low, high = at + start + i, at + start + field - 1 - i
            body[low:end:size], body[high:end:size] = body[high:end:size], body[low:end:size]
        start += field
    return end


def to_little_endian(data):
    """Converts a big-endian PLY file to little-endian order. A list must be the only property of its element, and all lists must
    have the length of the first, as lists of triangles have."""
    length, elements = parse_header(data)
    header = data[:length].replace(b"binary_big_endian", b"binary_little_endian")
    body = bytearray(data[length:])
    at = 0
    for name, count, properties in elements:
        lists = [kind for kind in properties if len(kind) == 2]
        if not lists:
            at = swap_records(body, at, count, [kind[0] for kind in properties])
        elif len(properties) > 1:
            raise PlyError(f"{name} has a list beside other properties")
        elif count > 0:
            length_bytes, item_bytes = lists[0]
            items = int.from_bytes(body[at:at + length_bytes], "big")
            size = length_bytes + items * item_bytes
            lengths = [body[at + i:at + count * size:size] for i in range(length_bytes)]
            wanted = items.to_bytes(length_bytes, "big")
            if any(column != bytes([byte]) * count for column, byte in zip(lengths, wanted)):
                raise PlyError(f"the lists of {name} are not all of {items} items")
            at = swap_records(body, at, count, [length_bytes] + [item_bytes] * items)
    return header + bytes(body)
