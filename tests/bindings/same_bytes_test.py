#!/usr/bin/env python3
"""Every interface encodes a mesh to equal bytes:

  same_bytes_test.py --psplit COMMAND --library libpsplit.so --python FOLDER [--corpus FOLDER] [--web PACKAGE] [--table]

Encodes twelve meshes by the command, through the interface for C, by the Python package in FOLDER, and, if there is one, by
the npm package: in containers, as `--always-patches` asks for. The command and C also choose patches or one stream themselves.
The C++ door is what the command calls; tests/c compares C with it. --table prints what was compared.
"""
import argparse, ctypes, json, pathlib, struct, subprocess, sys, tempfile

parser = argparse.ArgumentParser()
parser.add_argument("--psplit", type=pathlib.Path, required=True)
parser.add_argument("--library", type=pathlib.Path, required=True)
parser.add_argument("--python", type=pathlib.Path, required=True)
parser.add_argument("--corpus", type=pathlib.Path)
parser.add_argument("--web", type=pathlib.Path)
parser.add_argument("--table", action="store_true")
options = parser.parse_args()
sys.path.insert(0, str(options.python))
import gltf_psplit
import numpy as np

kGenerated = {f"{shape}, {faces} faces{', ' + ' and '.join(more) if more else ''}": (shape, faces, more) for shape, faces, more in (
    ("terrain", 600, ()), ("blob", 6000, ()), ("terrain", 19000, ("normals",)), ("blob", 20000, ()), ("gyroid", 24000, ("normals",)),
    ("terrain", 45000, ("normals", "texcoords")), ("blob", 60000, ("texcoords",)), ("gyroid", 90000, ()), ("blob", 400000, ()))}
kCorpus = ("mesh/tri/bunny.ply.gz", "mesh/c3d/stanford-bunny.ply.gz", "mesh/tri/chair_model.obj.gz")
kDracoFile, kPatches = 2, 1


def run(*command, **more):
    return subprocess.run([str(part) for part in command], check=True, capture_output=True, **more).stdout


def stream_of(glb):
    """(the stored bytes, whether they are patches) of the only primitive of a GLB."""
    data = glb.read_bytes()
    size, = struct.unpack_from("<I", data, 12)
    asset = json.loads(data[20:20 + size])
    extensions = asset["meshes"][0]["primitives"][0]["extensions"]
    is_container = "PSPLIT_mesh_draco_patches" in extensions
    view = asset["bufferViews"][next(iter(extensions.values()))["bufferView"]]
    begin = 28 + size + view.get("byteOffset", 0)
    return data[begin:begin + view["byteLength"]], is_container


class Values(ctypes.Structure):  # psplit_attribute_values
    _fields_ = [("struct_size", ctypes.c_uint32), ("type", ctypes.c_int32), ("name", ctypes.c_char_p), ("data", ctypes.c_void_p),
                ("size", ctypes.c_size_t), ("stride", ctypes.c_size_t), ("components", ctypes.c_uint32),
                ("normalized", ctypes.c_uint32), ("bits", ctypes.c_int32), ("reserved", ctypes.c_uint32)]


class Source(ctypes.Structure):  # psplit_encode_source
    _fields_ = [("struct_size", ctypes.c_uint32), ("point_count", ctypes.c_uint32), ("indices", ctypes.c_void_p),
                ("indices_size", ctypes.c_size_t), ("index_size", ctypes.c_uint32), ("attribute_count", ctypes.c_uint32),
                ("attributes", ctypes.POINTER(Values))]


class Options(ctypes.Structure):  # psplit_encode_options
    _fields_ = [("struct_size", ctypes.c_uint32), ("kind", ctypes.c_int32), ("speed", ctypes.c_int32), ("threads", ctypes.c_int32),
                ("pool", ctypes.c_void_p), ("patch_count", ctypes.c_uint32), ("patch_faces", ctypes.c_uint32),
                ("bits", ctypes.c_int32 * 5), ("flags", ctypes.c_uint32), ("progress", ctypes.c_void_p), ("user", ctypes.c_void_p),
                ("stop", ctypes.c_void_p)]


class Info(ctypes.Structure):  # psplit_encoded_info
    _fields_ = [("struct_size", ctypes.c_uint32), ("kind", ctypes.c_int32), ("data", ctypes.c_void_p), ("size", ctypes.c_size_t),
                ("point_count", ctypes.c_uint32), ("face_count", ctypes.c_uint32), ("patch_count", ctypes.c_uint32),
                ("attribute_count", ctypes.c_uint32), ("source_points", ctypes.c_void_p), ("position_error", ctypes.c_double),
                ("note_count", ctypes.c_uint32), ("reserved", ctypes.c_uint32)]


library = ctypes.CDLL(str(options.library))


def sized(struct):
    value = struct()
    value.struct_size = ctypes.sizeof(struct)
    return value


def by_c(faces, attributes, kind):
    """(bytes, whether they are patches, number of patches)"""
    values = (Values * len(attributes))()
    for value, (name, array) in zip(values, attributes):
        value.struct_size, value.type, value.name = ctypes.sizeof(Values), 9, name.encode()  # PSPLIT_FLOAT32
        value.data, value.size, value.components = array.ctypes.data, array.nbytes, array.shape[1]
    source, wanted, info = sized(Source), sized(Options), sized(Info)
    source.point_count, source.indices, source.indices_size = len(attributes[0][1]), faces.ctypes.data, faces.nbytes
    source.index_size, source.attribute_count, source.attributes = 4, len(attributes), values
    library.psplit_encode_options_init(ctypes.byref(wanted))
    wanted.kind = kind
    encoded = ctypes.c_void_p()
    code = library.psplit_encode(ctypes.byref(source), ctypes.byref(wanted), ctypes.byref(encoded), None)
    assert code == 0, f"psplit_encode: {code}"
    library.psplit_encoded_get_info(encoded, ctypes.byref(info), None)
    result = ctypes.string_at(info.data, info.size), info.kind == kPatches, info.patch_count
    library.psplit_encoded_free(encoded)
    return result


def by_python(faces, attributes):
    named = dict(attributes)
    return gltf_psplit.encode_container(named["POSITION"], faces, normals=named.get("NORMAL"), tex_coord=named.get("TEXCOORD_0")).data


def by_web(folder, faces, attributes):
    (folder / "faces").write_bytes(faces.tobytes())
    for name, array in attributes:
        (folder / name).write_bytes(array.tobytes())
    program = """
      const { readFileSync, writeFileSync } = require('fs'), [package_folder, folder, ...names] = process.argv.slice(1);
      const floats = (name) => new Float32Array(new Uint8Array(readFileSync(`${folder}/${name}`)).buffer);
      import(`${package_folder}/encode.js`).then(async ({ encodeMesh }) => {
        const attributes = Object.fromEntries(names.map((name) =>
          [name, { array: floats(name), componentCount: name === 'TEXCOORD_0' ? 2 : 3 }]));
        const indices = new Uint32Array(new Uint8Array(readFileSync(`${folder}/faces`)).buffer);
        writeFileSync(`${folder}/container`, (await encodeMesh({ indices, attributes })).container);
      });"""
    run("node", "-e", program, options.web.resolve(), folder, *(name for name, _ in attributes))
    return (folder / "container").read_bytes()


def meshes(folder):
    for name, (shape, faces, more) in kGenerated.items():
        asset = folder / "mesh.glb"
        run(options.psplit, "generate", "-q", asset, "--shape", shape, "--faces", faces, *(f"--{option}" for option in more))
        yield name, asset
    for file in kCorpus:
        if options.corpus and (options.corpus / file).exists():
            asset = folder / "mesh.glb"
            run(options.psplit, "decode", "-q", options.corpus / file, asset)
            yield file, asset


def main(folder):
    failures, rows = [], []
    for name, asset in meshes(folder):
        mesh = gltf_psplit.load(asset).meshes[0].primitives[0]  # a mesh
        faces = np.ascontiguousarray(mesh.faces, dtype=np.uint32)
        # Python's function takes no others.
        attributes = [(key, np.ascontiguousarray(mesh[key])) for key in ("POSITION", "NORMAL", "TEXCOORD_0") if key in mesh]
        skipped = [word for key in mesh if key not in dict(attributes) for word in ("--skip", key)]
        plain = folder / "plain.glb"
        run(options.psplit, "encode", "-q", asset, plain, "--always-patches", *skipped)
        wanted, is_container = stream_of(plain)
        run(options.psplit, "encode", "-q", asset, plain, *skipped)
        as_fits, splits = stream_of(plain)
        in_c, c_splits, c_patches = by_c(faces, attributes, 0)
        got = {"C": by_c(faces, attributes, kPatches)[0], "Python": by_python(faces, attributes)}
        if options.web:
            got["web"] = by_web(folder, faces, attributes)
        assert is_container, name
        differs = [face for face, data in got.items() if data != wanted]
        if (in_c, c_splits) != (as_fits, splits):
            differs.append("C, which chooses")
        failures += [f"{name}: {face}" for face in differs]
        rows.append(f"| {name} | {c_patches if splits else 'one stream'} | {len(wanted):,} | "
                    f"{'equal' if not differs else ', '.join(differs)} |")
    if options.table:
        print("| mesh | by default | bytes in a container | command, C, Python, web |\n|---|---|--:|---|", *rows, sep="\n")
    print(f"{len(rows)} meshes by the command, {', '.join(got)}")
    sys.exit("these faces write other bytes:\n" + "\n".join(failures) if failures else 0)


with tempfile.TemporaryDirectory() as name:
    main(pathlib.Path(name))
