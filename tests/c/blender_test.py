#!/usr/bin/env python3
"""Calls Blender's functions as its glTF add-on does, through ctypes:

  blender_test.py --library libextern_draco.so --psplit COMMAND --corpus FOLDER --samples FOLDER

Import: every primitive of KHR_draco_mesh_compression of the corpus is what libdraco decodes. Export: what it encodes is the
same mesh, by `gltf-psplit diff`. Without the corpus only the samples are tested.
"""
import argparse, json, pathlib, struct, subprocess, sys, tempfile
from ctypes import c_bool, c_char_p, c_size_t, c_uint8, c_uint32, c_uint64, c_void_p, cdll

parser = argparse.ArgumentParser()
for name in ("library", "psplit", "corpus", "samples"):
    parser.add_argument("--" + name, required=True)
options = parser.parse_args()
dll = cdll.LoadLibrary(options.library)
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
STOCK = "KHR_draco_mesh_compression"


def declare(name, result, *arguments):
    function = getattr(dll, name)
    function.restype, function.argtypes = result, list(arguments)


declare("decoderCreate", c_void_p)
declare("decoderRelease", None, c_void_p)
declare("decoderDecode", c_bool, c_void_p, c_void_p, c_size_t)
declare("decoderReadAttribute", c_bool, c_void_p, c_uint32, c_size_t, c_char_p)
declare("decoderGetVertexCount", c_uint32, c_void_p)
declare("decoderGetIndexCount", c_uint32, c_void_p)
declare("decoderAttributeIsNormalized", c_bool, c_void_p, c_uint32)
declare("decoderGetAttributeByteLength", c_size_t, c_void_p, c_uint32)
declare("decoderCopyAttribute", None, c_void_p, c_uint32, c_void_p)
declare("decoderReadIndices", c_bool, c_void_p, c_size_t)
declare("decoderGetIndicesByteLength", c_size_t, c_void_p)
declare("decoderCopyIndices", None, c_void_p, c_void_p)
declare("encoderCreate", c_void_p, c_uint32)
declare("encoderRelease", None, c_void_p)
declare("encoderSetCompressionLevel", None, c_void_p, c_uint32)
declare("encoderSetQuantizationBits", None, c_void_p, c_uint32, c_uint32, c_uint32, c_uint32, c_uint32)
declare("encoderSetIndices", None, c_void_p, c_size_t, c_uint32, c_void_p)
declare("encoderEncode", c_bool, c_void_p, c_uint8)
declare("encoderGetEncodedVertexCount", c_uint32, c_void_p)
declare("encoderGetEncodedIndexCount", c_uint32, c_void_p)
declare("encoderGetByteLength", c_uint64, c_void_p)
declare("encoderCopy", None, c_void_p, c_void_p)
# Add-ons pass five arguments, newer ones a sixth.
OLD_SET = (c_uint32, c_void_p, c_char_p, c_size_t, c_char_p, c_void_p)


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\nexits with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout


class Asset:
    """A .glb file in memory."""

    def __init__(self, path):
        file = path.read_bytes()
        json_bytes = struct.unpack_from("<I", file, 12)[0]
        self.json = json.loads(file[20:20 + json_bytes])
        self.binary = file[28 + json_bytes:]

    def view(self, index):
        view = self.json["bufferViews"][index]
        begin = view.get("byteOffset", 0)
        return self.binary[begin:begin + view["byteLength"]]

    def accessor(self, index):
        """The elements without gaps."""
        accessor = self.json["accessors"][index]
        size = COMPONENTS[accessor["type"]] * BYTES[accessor["componentType"]]
        view = self.json["bufferViews"][accessor["bufferView"]]
        data, begin, stride = self.view(accessor["bufferView"]), accessor.get("byteOffset", 0), view.get("byteStride", size)
        return b"".join(data[begin + i * stride:begin + i * stride + size] for i in range(accessor["count"]))

    def primitives(self):
        for m, mesh in enumerate(self.json["meshes"]):
            for p, primitive in enumerate(mesh["primitives"]):
                yield f"mesh {m}, primitive {p}", primitive


def numbers(data, accessor):
    return memoryview(data).cast({5121: "B", 5123: "H", 5125: "I"}[accessor["componentType"]]).tolist()


def import_primitive(asset, primitive):
    """What the add-on reads: the indices, and each attribute under its name."""
    accessors, extension = asset.json["accessors"], primitive["extensions"][STOCK]
    decoder = dll.decoderCreate()
    stream = asset.view(extension["bufferView"])
    assert dll.decoderDecode(decoder, stream, len(stream))
    indices = accessors[primitive["indices"]]
    assert dll.decoderGetIndexCount(decoder) == indices["count"]
    assert dll.decoderReadIndices(decoder, indices["componentType"])
    read = {"indices": bytes(dll.decoderGetIndicesByteLength(decoder))}
    dll.decoderCopyIndices(decoder, read["indices"])
    for name, number in extension["attributes"].items():
        accessor = accessors[primitive["attributes"][name]]
        assert dll.decoderGetVertexCount(decoder) == accessor["count"]
        assert dll.decoderReadAttribute(decoder, number, accessor["componentType"], accessor["type"].encode()), name
        read[name] = bytes(dll.decoderGetAttributeByteLength(decoder, number))
        dll.decoderCopyAttribute(decoder, number, read[name])
    dll.decoderRelease(decoder)
    return read


def check_import(path, plain):
    """plain: the same file as libdraco decodes it."""
    asset, decoded, count = Asset(path), Asset(plain), 0
    for (place, primitive), (_, expected) in zip(asset.primitives(), decoded.primitives()):
        if STOCK not in primitive.get("extensions", {}):
            continue
        read = import_primitive(asset, primitive)
        # The decoded file may have indices of another type.
        indices = numbers(read.pop("indices"), asset.json["accessors"][primitive["indices"]])
        same = indices == numbers(decoded.accessor(expected["indices"]), decoded.json["accessors"][expected["indices"]])
        if not same or any(values != decoded.accessor(expected["attributes"][name]) for name, values in read.items()):
            sys.exit(f"{path.name}, {place}: the mesh differs from libdraco's")
        count += 1
    return count


def export_primitive(asset, primitive, binary, with_normalized):
    """Replaces the data of a primitive by a stream, as the add-on does."""
    accessors = asset.json["accessors"]
    encoder = dll.encoderCreate(accessors[primitive["attributes"]["POSITION"]]["count"])
    declare("encoderSetAttribute", *OLD_SET, *([c_bool] if with_normalized else []))
    ids = {}
    for name, index in primitive["attributes"].items():
        accessor = accessors[index]
        more = [accessor.get("normalized", False)] if with_normalized else []
        ids[name] = dll.encoderSetAttribute(encoder, name.encode(), accessor["componentType"], accessor["type"].encode(),
                                            asset.accessor(index), *more)
    indices = accessors[primitive["indices"]]
    dll.encoderSetIndices(encoder, indices["componentType"], indices["count"], asset.accessor(primitive["indices"]))
    dll.encoderSetCompressionLevel(encoder, 6)
    dll.encoderSetQuantizationBits(encoder, 14, 10, 12, 10, 12)
    assert dll.encoderEncode(encoder, len(primitive.get("targets", [])) > 0)
    stream = bytes(dll.encoderGetByteLength(encoder))
    dll.encoderCopy(encoder, stream)
    asset.json["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(stream)})
    binary += stream + b"\0" * (-len(stream) % 4)
    primitive["extensions"] = {STOCK: {"bufferView": len(asset.json["bufferViews"]) - 1, "attributes": ids}}
    for index, count in [(primitive["indices"], dll.encoderGetEncodedIndexCount(encoder))] + \
            [(index, dll.encoderGetEncodedVertexCount(encoder)) for index in primitive["attributes"].values()]:
        accessors[index]["count"] = count
        accessors[index].pop("bufferView", None)
        accessors[index].pop("byteOffset", None)
    dll.encoderRelease(encoder)


def check_export(plain, folder, with_normalized):
    asset = Asset(plain)
    binary = bytearray(asset.binary)
    for _, primitive in asset.primitives():
        export_primitive(asset, primitive, binary, with_normalized)
    asset.json["buffers"][0]["byteLength"] = len(binary)
    for key in ("extensionsUsed", "extensionsRequired"):
        asset.json[key] = sorted({*asset.json.get(key, []), STOCK})
    text = json.dumps(asset.json).encode()
    text += b" " * (-len(text) % 4)
    encoded = folder / "encoded.glb"
    encoded.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(binary), len(text), 0x4E4F534A) + text +
                        struct.pack("<II", len(binary), 0x004E4942) + binary)
    run(options.psplit, "validate", encoded)
    run(options.psplit, "diff", plain, encoded)


def shared_accessors(path):
    """Whether primitives share data, which the exporter of the add-on never writes."""
    seen = [index for _, primitive in Asset(path).primitives()
            for index in [primitive.get("indices", -1), *primitive["attributes"].values()]]
    return -1 in seen or len(set(seen)) != len(seen)


with tempfile.TemporaryDirectory(prefix="psplit-blender-") as name:
    folder = pathlib.Path(name)
    assets = []
    for sample in ("seams.glb", "patches.glb"):
        run(options.psplit, "decode", "-q", pathlib.Path(options.samples) / sample, folder / sample, "--to", "draco")
        assets.append(folder / sample)
    if pathlib.Path(options.corpus).is_dir():
        assets += sorted(path for path in pathlib.Path(options.corpus).rglob("*.glb")
                         if "malformed" not in path.parts and STOCK.encode() in path.read_bytes())
    imported = exported = 0
    for path in assets:
        plain = folder / "plain.glb"
        run(options.psplit, "decode", "-q", path, plain, "--backend", "draco")
        imported += check_import(path, plain)
        if not shared_accessors(plain):
            check_export(plain, folder, exported % 2 == 1)
            exported += 1
    if imported < 2 or exported < 2:
        sys.exit(f"only {imported} primitives were imported, and {exported} files exported")
    print(f"{len(assets)} files: {imported} primitives imported, {exported} files exported")
