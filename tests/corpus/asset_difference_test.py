#!/usr/bin/env python3
"""asset_difference.py finds every change that it must find:  asset_difference_test.py GLTF_PSPLIT

An asset that uses many features is encoded; only what may change has changed. Then the test changes each value of the
result, one at a time. Each change must be found, except those to the few values that encoding owns.
"""
import copy, json, pathlib, re, struct, subprocess, sys, tempfile
from asset_difference import Asset, Comparison, differences

psplit = pathlib.Path(sys.argv[1]).resolve()
# The values that encoding owns: another value there is not a difference (`validate` checks these).
kOwned = re.compile(
    r"/buffers/0/byteLength|/accessors/\d+/(count|min/\d+|max/\d+)|/bufferViews/\d+/(buffer|byteOffset|byteLength)"
    r"|/bufferViews/7/target"  # of the morph target, which is new
    r"|/meshes/[01]/primitives/0/extensions/PSPLIT_mesh_draco_patches/(bufferView|attributes/\w+|targets/\w+/\d+)")
kMorphData = "/accessors/2/bufferView"


def rich_asset(folder):
    """Two meshes to encode: one has a morph target, the other also a primitive of points that shares an accessor."""
    subprocess.run([psplit, "generate", "-q", folder / "shape.gltf", "--shape", "blob", "--faces", "600"], check=True)
    json_before = json.loads((folder / "shape.gltf").read_text())
    asset, binary = json_before, bytearray((folder / json_before["buffers"][0]["uri"]).read_bytes())

    def add_accessor(values, kind, **members):
        asset["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": 4 * len(values)})
        binary.extend(struct.pack(f"<{len(values)}f", *values))
        size = {"SCALAR": 1, "VEC3": 3}[kind]
        asset["accessors"].append({"bufferView": len(asset["bufferViews"]) - 1, "componentType": 5126,
                                   "count": len(values) // size, "type": kind, **members})
        return len(asset["accessors"]) - 1

    primitive = asset["meshes"][0]["primitives"][0]
    points = asset["accessors"][primitive["attributes"]["POSITION"]]["count"]
    primitive.update(material=0, extras={"part": [1, {"deep": None}]}, extensions={"EXT_unknown": {"level": "high"}},
                     targets=[{"POSITION": add_accessor([0.01 * (i % 7) for i in range(3 * points)], "VEC3",
                                                        min=[0, 0, 0], max=[0.06, 0.06, 0.06])}])
    second = {"attributes": {"POSITION": add_accessor([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0], "VEC3", min=[0, 0, 0],
                                                      max=[1, 1, 0], name="corners", extras=7)},
              "mode": 5, "unknown": {"a": [True, 2.5]}}
    asset["meshes"].append({"primitives": [second, {"attributes": dict(second["attributes"]), "mode": 0}]})
    asset["nodes"].append({"mesh": 1})
    asset["scenes"][0]["nodes"].append(1)
    asset["meshes"][0].update(name="blob", weights=[0.5], extras="text")
    time = add_accessor([0.0, 1.0], "SCALAR", min=[0], max=[1])
    asset.update(
        materials=[{"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}, "doubleSided": True}],
        animations=[{"name": "grow", "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
                     "samplers": [{"input": time, "output": add_accessor([0.0, 1.0], "SCALAR")}]}],
        cameras=[{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.01}}],
        extensionsUsed=["EXT_unknown"], extensions={"EXT_unknown": {"version": "x"}}, extras=[0, "a", {"b": 1}],
        unknown_root=[[1], {}])
    (folder / "red.png").write_bytes(b"\x89PNG\r\n\x1a\nred")
    asset["images"] = [{"uri": "red.png", "extras": 1}]
    asset["nodes"][0].update(name="node", translation=[1, 2, 3.5], extras={"level": 0})
    asset["buffers"] = [{"byteLength": len(binary), "uri": "rich.bin", "name": "all"}]
    (folder / "rich.bin").write_bytes(binary)
    (folder / "rich.gltf").write_text(json.dumps(asset))
    return folder / "rich.gltf"


def leaves(tree, path=""):
    if isinstance(tree, (dict, list)) and tree:
        for key, value in tree.items() if isinstance(tree, dict) else enumerate(tree):
            yield from leaves(value, f"{path}/{key}")
    else:
        yield path


def changes(tree):
    """Yields a description, the path, the kind of change and the changed tree: each value changed, each member removed, each
    array reversed."""
    for path in leaves(tree):
        steps = [int(step) if step.isdigit() else step for step in path.split("/")[1:]]
        for kind in ("value", "member", "element"):
            changed = copy.deepcopy(tree)
            holder = changed
            for step in steps[:-1]:
                holder = holder[step]
            old = holder[steps[-1]]
            if kind == "value":
                holder[steps[-1]] = old + 1 if type(old) in (int, float) else "other"
            elif kind == "member" and isinstance(holder, dict):
                del holder[steps[-1]]
            elif kind == "element" and isinstance(holder, list) and holder[::-1] != holder:
                holder.reverse()
            else:
                continue
            yield f"{kind} {path}", path, kind, changed


def found_in(before, after, changed):
    other = copy.copy(after)
    other.json = changed
    fresh = copy.copy(before)
    fresh.json = copy.deepcopy(before.json)
    try:
        return Comparison(fresh, other).run()
    except (KeyError, IndexError, TypeError, AttributeError) as error:  # it is no longer glTF
        return [repr(error)]


with tempfile.TemporaryDirectory(prefix="psplit-difference-") as name:
    folder = pathlib.Path(name)
    source, encoded = rich_asset(folder), folder / "encoded.gltf"
    subprocess.run([psplit, "encode", "-q", "--always-patches", "--patches", "4", source, encoded], check=True)
    failures = [f"before any change: {line}" for line in differences(source, encoded)]
    before, after = Asset(source), Asset(encoded)
    count = 0
    for what, path, kind, changed in changes(after.json):
        if kOwned.fullmatch(path) or path == "/buffers/0/uri" or (path, kind) == (kMorphData, "value"):
            continue
        count += 1
        if not found_in(before, after, changed):
            failures.append(f"not found: {what}")
    embedded = folder / "embedded.glb"
    subprocess.run([psplit, "encode", "-q", "--patches", "4", source, embedded], check=True)
    failures += [f"before any change of an image: {line}" for line in differences(source, embedded)]
    before, after = Asset(source), Asset(embedded)
    for what, path, kind, changed in changes(after.json):
        if not path.startswith("/images") or path == "/images/0/name":
            continue
        count += 1
        if not found_in(before, after, changed):
            failures.append(f"not found: {what}")
    for line in failures:
        print(f"FAILED  {line}")
    print(f"asset_difference: {count} changes, {len(failures)} failures")
    sys.exit(1 if failures or count < 120 else 0)
