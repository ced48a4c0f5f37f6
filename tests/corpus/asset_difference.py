"""Finds what gltf-psplit changed in an asset that it must not change.

  differences(before, after)     takes two .gltf or .glb files, before and after `encode` without a fallback, and returns a
                                 list of lines
  asset_difference.py BEFORE AFTER

Everything in the JSON must be as before: values, order of arrays, order of members, extras, unknown members and
extensions. Only these may differ:

  extensionsUsed, extensionsRequired   the extensions that primitives are encoded with are at the end, and stock Draco
                                       and patches together, where the first of them was; stock Draco and
                                       meshoptimizer are gone if nothing uses them any more
  buffers                              all buffers with bytes become the first one: it has no uri, another byteLength, no
                                       mark of a fallback, and only the name and extras of the first; buffers without
                                       bytes follow, those of meshoptimizer with another byteLength
  bufferViews                          numbers, buffer and byteOffset. Unused views are gone, new ones are at the end.
                                       Bytes are the same, compressed ones too. A view that meshoptimizer compressed for
                                       an encoded primitive, too, may be compressed again: with another byteLength, count,
                                       mode and filter (other tests check what it decodes to)
  images                               in a GLB, image files are embedded: the file's bytes are in a buffer view, with a
                                       mimeType, and a name if there was none; the uri is gone
  accessors                            numbers. Accessors of encoded primitives change as below, all others only in the
                                       byteOffset in a view that was compressed again
  an encoded primitive                 mode becomes 4 for strips and fans; indices may change; the extension, or stock
                                       Draco of other bytes, is last in its extensions; stock Draco of the input is gone
    accessors of its attributes        count, min, max; bufferView, byteOffset and sparse are gone
    accessor of its indices            as accessors of attributes, and componentType
  accessors of morph targets           count, min, max, bufferView, byteOffset, sparse; `normalized` is gone if it is false. Equal
                                       ones may become one. If none of the three is left, the target is zero everywhere,
                                       or the extension of an encoded primitive stores it
  a mesh of encoded primitives         EXT_mesh_manifold, which refers to indices, is gone, and so are its accessors
"""
import base64, json, pathlib, re, struct, sys, urllib.parse

kName, kStock, kManifold = "PSPLIT_mesh_draco_patches", "KHR_draco_mesh_compression", "EXT_mesh_manifold"
kMeshopt = ("EXT_meshopt_compression", "KHR_meshopt_compression")
kAccessor = re.compile(
    r"/meshes/\d+/primitives/\d+/(attributes/[^/]+|indices|targets/\d+/[^/]+|extensions/CESIUM_primitive_outline/indices)"
    r"|/animations/\d+/samplers/\d+/(input|output)|/skins/\d+/inverseBindMatrices"
    r"|/nodes/\d+/extensions/EXT_mesh_gpu_instancing/attributes/[^/]+")
kView = re.compile(
    r"(?!.*/extras/).*/bufferView"
    r"|/extensions/EXT_structural_metadata/propertyTables/\d+/properties/[^/]+/(values|arrayOffsets|stringOffsets)")
kPrimitive = re.compile(r"/meshes/\d+/primitives/\d+")
kImage = re.compile(r"/images/\d+")
kMimeTypes = {b"\x89PNG\r\n\x1a\n": "image/png", b"\xff\xd8\xff": "image/jpeg", b"RIFF": "image/webp",
              b"\xabKTX 20\xbb\r\n\x1a\n": "image/ktx2", b"DDS ": "image/vnd-ms.dds"}
kApart = ("extensionsUsed", "extensionsRequired", "buffers", "bufferViews", "accessors")
kFreed = {"componentType": 5121, "count": 1, "type": "SCALAR"}  # keeps a number that an unknown extension may use


class Asset:
    def __init__(self, path):
        content, self.folder, chunk = path.read_bytes(), path.parent, b""
        self.is_glb = content[:4] == b"glTF"
        if self.is_glb:
            length = struct.unpack_from("<I", content, 12)[0]
            chunk = content[28 + length :]
            content = content[20 : 20 + length]
        self.json = json.loads(content.decode("utf-8-sig"))
        self.buffers = [self.load(buffer, chunk if i == 0 else b"") for i, buffer in enumerate(self.all("buffers"))]

    def load(self, buffer, chunk):
        uri = buffer.get("uri")
        if uri is None:
            return chunk
        if uri.startswith("data:"):
            head, data = uri.split(",", 1)
            return base64.b64decode(data + "==") if head.endswith(";base64") else urllib.parse.unquote_to_bytes(data)
        return (self.folder / urllib.parse.unquote(uri)).read_bytes()

    def all(self, name):
        return self.json.get(name, [])

    def bytes_of(self, holder):
        start = holder.get("byteOffset", 0)
        return self.buffers[holder["buffer"]][start : start + holder["byteLength"]]


def accessor_names(tree, path=""):
    """Every path that refers to an accessor, with the accessor's number."""
    if kAccessor.fullmatch(path):
        yield path, tree
    elif isinstance(tree, (dict, list)):
        for key, value in tree.items() if isinstance(tree, dict) else enumerate(tree):
            yield from accessor_names(value, f"{path}/{key}")


class Comparison:
    def __init__(self, before, after):
        self.before, self.after, self.found = before, after, []
        self.encoded, self.views = set(), {}  # views: from numbers before to numbers after
        self.names = []  # of the extensions that primitives are encoded with
        self.dropped = set()  # accessors to which only EXT_mesh_manifold referred

    def say(self, path, what):
        self.found.append(f"{path or '/'}: {what}")

    def run(self):
        self.drop_manifolds()
        self.compare(self.before.json, self.after.json, "")
        self.compare_accessors()
        for old, new in list(self.views.items()):
            self.compare_views(old, new)
        numbers = [self.views[old] for old in sorted(self.views)]
        if numbers != sorted(set(numbers)):
            self.say("/bufferViews", "another order")
        self.compare_buffers()
        self.compare_lists()
        return self.found

    def encoding(self, old, new):
        """The extension that a primitive was encoded with, or None if it is stored as it was."""
        extensions = new.get("extensions", {})
        if kName in extensions:
            return kName
        if kStock not in extensions:
            return None
        def stream(asset, primitive):
            return asset.bytes_of(asset.json["bufferViews"][primitive["extensions"][kStock]["bufferView"]])
        is_kept = kStock in old.get("extensions", {}) and stream(self.before, old) == stream(self.after, new)
        return None if is_kept else kStock

    def drop_manifolds(self):
        for old, new in zip(self.before.all("meshes"), self.after.all("meshes")):
            if not any(map(self.encoding, old["primitives"], new["primitives"])):
                continue
            for holder in (old, *old["primitives"]):
                manifold = holder.get("extensions", {}).pop(kManifold, None)
                if manifold is None:
                    continue
                if not holder["extensions"]:
                    del holder["extensions"]
                named = {manifold.get("manifoldPrimitive", {}).get("indices"), manifold.get("mergeIndices"),
                         manifold.get("mergeValues")}
                self.dropped |= named - {None}
        self.dropped -= {index for _, index in accessor_names(self.before.json)}

    def compare(self, old, new, path):
        name = self.encoding(old, new) if kPrimitive.fullmatch(path) else None
        if name:
            self.compare_encoded(old, new, path, name)
        elif kImage.fullmatch(path) and self.file_of(old) is not None:
            self.compare_image(old, new, path)
        else:
            self.compare_values(old, new, path)
            if kPrimitive.fullmatch(path):
                self.compare_targets(old, new, path, {})

    def file_of(self, image):
        """The image's file, or None if it is not a file or the output does not embed it."""
        uri = image.get("uri")
        if not self.after.is_glb or not isinstance(uri, str) or "bufferView" in image or re.match(r"\w+:", uri):
            return None
        file = self.before.folder / urllib.parse.unquote(uri)
        return file if file.is_file() else None

    def compare_image(self, old, new, path):
        content = self.file_of(old).read_bytes()
        kind = next((kind for head, kind in kMimeTypes.items() if content.startswith(head)), None)
        if kind is None:
            return self.compare_values(old, new, path)
        self.compare_values(old, new, path, ("mimeType", "bufferView") + (() if "name" in old else ("name",)), ("uri",))
        if new.get("mimeType") != kind:
            self.say(path, f"is {kind}, not {new.get('mimeType')}")
        if self.after.bytes_of(self.after.json["bufferViews"][new["bufferView"]]) != content:
            self.say(path, "holds other bytes than its file")

    def compare_values(self, old, new, path, free=(), gone=()):
        """Members in `free` may have any value afterwards; members in `gone` must not exist."""
        if type(old) is not type(new):
            return self.say(path, f"was {old!r:.80}, is {new!r:.80}")
        if isinstance(old, dict):
            apart = kApart if path == "" else ()
            kept = [key for key in old if key not in (*free, *gone, *apart)]
            there = [key for key in new if key not in (*free, *apart)]
            if kept != there:
                self.say(path, f"members were {kept}, are {there}")
            for key in kept:
                if key in new:
                    self.compare(old[key], new[key], f"{path}/{key}")
        elif isinstance(old, list):
            if len(old) != len(new):
                self.say(path, f"had {len(old)} elements, has {len(new)}")
            for i, (one, other) in enumerate(zip(old, new)):
                self.compare(one, other, f"{path}/{i}")
        elif kView.fullmatch(path) and isinstance(old, int):
            if self.views.setdefault(old, new) != new:
                self.say(path, "one view has become two")
        elif kAccessor.fullmatch(path):
            pass  # compare_accessors checks them
        elif old != new:
            self.say(path, f"was {old!r:.80}, is {new!r:.80}")

    def compare_encoded(self, old, new, path, name):
        self.encoded.add(path)
        self.names += [name] if name not in self.names else []
        if kName in old.get("extensions", {}):
            return self.say(path, "was encoded before")
        extension = new["extensions"].pop(name)
        stock = old.get("extensions", {}).pop(kStock, None)
        if not new["extensions"] and ("extensions" not in old or stock):
            del new["extensions"]
            old.pop("extensions", None)
        targets = extension.pop("targets", {}) if name == kName else {}
        if list(extension) != ["bufferView", "attributes"] or not set(extension["attributes"]) <= set(old["attributes"]):
            self.say(path, f"the extension is {extension}")
        if new.get("mode", 4) != 4 or ("mode" in old) != ("mode" in new):
            self.say(path, "another mode")
        indices = new.pop("indices")
        self.compare_values(old, new, path, ("mode",), ("indices",))
        shape = ("count", "min", "max")
        gone = ("byteOffset", "sparse")
        for semantic in old["attributes"]:
            stored = semantic in extension["attributes"]
            self.compare_accessor(old["attributes"][semantic], new["attributes"][semantic],
                                  f"{path}, {semantic}", shape if stored else (), (*gone, "bufferView") if stored else ())
        if "indices" in old:
            self.compare_accessor(old["indices"], indices, f"{path}, indices", (*shape, "componentType"),
                                  (*gone, "bufferView"))
        elif list(self.after.all("accessors")[indices]) != ["count", "componentType", "type"]:
            self.say(path, "an accessor of new indices with unneeded members")
        described = self.after.all("accessors")[indices]
        if described["componentType"] not in (5123, 5125) or described["type"] != "SCALAR":
            self.say(path, "indices of another type")
        self.compare_targets(old, new, path, targets)
        new["indices"] = indices  # compare_accessors needs it again

    def compare_targets(self, old, new, path, stored):
        """`stored`: the ids of the extension, by semantic."""
        place = ("bufferView", "byteOffset", "sparse")
        if any(len(ids) != len(old.get("targets", [])) for ids in stored.values()):
            self.say(path, "the extension has other targets")
            return
        for i, (target, now) in enumerate(zip(old.get("targets", []), new.get("targets", []))):
            for semantic in target:
                if semantic not in now:
                    continue  # compare_values said so
                before, after = self.before.all("accessors")[target[semantic]], self.after.all("accessors")[now[semantic]]
                in_patches = stored.get(semantic, [-1] * (i + 1))[i] != -1
                false = () if before.get("normalized", True) else ("normalized",)
                self.compare_accessor(target[semantic], now[semantic], f"{path}, target {i}, {semantic}",
                                      ("count", "min", "max", *(() if in_patches else place)),
                                      (*false, *(place if in_patches else ())))
                if not in_patches and not any(name in after for name in place) and not self.is_zero(before):
                    self.say(path, f"target {i} has lost its {semantic}")

    def is_zero(self, accessor):
        """Of an accessor of the input whose values are not compressed. -0 is zero, too."""
        if "sparse" in accessor:
            return False
        if "bufferView" not in accessor:
            return True
        if self.is_compressed(self.before, accessor["bufferView"]):
            return False
        view = self.before.json["bufferViews"][accessor["bufferView"]]
        size = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}[accessor["componentType"]]
        size *= {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        data, step = self.before.bytes_of(view)[accessor.get("byteOffset", 0):], view.get("byteStride", size)
        values = b"".join(data[i * step : i * step + size] for i in range(accessor["count"]))
        if accessor["componentType"] == 5126:
            return set(struct.unpack(f"<{len(values) // 4}f", values)) <= {0.0}
        return not any(values)

    def compare_accessor(self, old, new, path, free=(), gone=()):
        self.compare_values(self.before.all("accessors")[old], self.after.all("accessors")[new], path, free, gone)

    def compare_accessors(self):
        """All accessors must still be there, in order, except those that only encoded primitives use."""
        def others(asset):
            by_encoded, by_others = set(), set()
            for path, index in accessor_names(asset.json):
                is_own = re.match(kPrimitive, path) and (re.match(kPrimitive, path)[0] in self.encoded or "/targets/" in path)
                (by_encoded if is_own else by_others).add(index)
            gone = self.dropped if asset is self.before else ()
            return [i for i in range(len(asset.all("accessors")))
                    if i in by_others or i not in by_encoded and i not in gone]
        old, new = others(self.before), others(self.after)
        if len(old) != len(new):
            new = [i for i in new if self.after.json["accessors"][i] != kFreed]
        if len(old) != len(new):
            return self.say("/accessors", f"{len(old)} that encoding does not touch have become {len(new)}")
        for one, other in zip(old, new):
            view, now = (asset.json["accessors"][i].get("bufferView") for asset, i in ((self.before, one), (self.after, other)))
            self.compare_accessor(one, other, f"/accessors/{one}", ("byteOffset",) if self.is_again(view, now) else ())
        new_number = dict(zip(old, new))
        after = dict(accessor_names(self.after.json))
        for path, index in accessor_names(self.before.json):
            primitive = re.match(kPrimitive, path)
            if "/targets/" in path:
                continue  # compare_targets checks them
            if (primitive is None or primitive[0] not in self.encoded) and after.get(path) != new_number.get(index):
                self.say(path, "refers to another accessor")

    def compare_views(self, old, new):
        path = f"/bufferViews/{old}"
        one, other = self.before.json["bufferViews"][old], self.after.json["bufferViews"][new]
        free = ("buffer", "byteOffset")
        if self.is_again(old, new):
            self.compare_values({k: v for k, v in one.items() if k != "extensions"},
                                {k: v for k, v in other.items() if k != "extensions"}, path, (*free, "byteLength"))
            for name in kMeshopt:
                extension, now = (view["extensions"].get(name, {}) for view in (one, other))
                self.compare_values(extension, now, f"{path}/extensions/{name}", (*free, "byteLength", "count", "mode", "filter"))
            return
        self.compare_values({k: v for k, v in one.items() if k != "extensions"},
                            {k: v for k, v in other.items() if k != "extensions"}, path, free)
        if self.before.bytes_of(one) != self.after.bytes_of(other):
            self.say(path, "other bytes")
        if one.get("extensions", {}).keys() != other.get("extensions", {}).keys():
            self.say(path, "other extensions")
        for name, extension in one.get("extensions", {}).items():
            now = other.get("extensions", {}).get(name, {})
            inner = free if name in kMeshopt else ()
            self.compare_values(extension, now, f"{path}/extensions/{name}", inner)
            if inner and self.before.bytes_of(extension) != self.after.bytes_of(now):
                self.say(path, "other compressed bytes")

    @staticmethod
    def is_compressed(asset, view):
        return view is not None and any(name in asset.json["bufferViews"][view].get("extensions", {}) for name in kMeshopt)

    def is_again(self, old, new):
        """Whether a view was compressed again, as those may be that encoded primitives have values in."""
        if not (self.is_compressed(self.before, old) and self.is_compressed(self.after, new)):
            return False
        one, other = self.before.json["bufferViews"][old], self.after.json["bufferViews"][new]
        def packed(asset, view):
            return [asset.bytes_of(e) for name, e in view["extensions"].items() if name in kMeshopt]
        accessors = self.before.all("accessors")
        return packed(self.before, one) != packed(self.after, other) and any(
            accessors[index].get("bufferView") == old for path, index in accessor_names(self.before.json)
            if re.match(kPrimitive, path) and re.match(kPrimitive, path)[0] in self.encoded)

    def compare_buffers(self):
        def plain(buffer):
            rest = {key: value for key, value in buffer.items() if key not in ("uri", "byteLength", "extensions")}
            extensions = {k: v for k, v in buffer.get("extensions", {}).items() if k not in kMeshopt}
            return {**rest, **({"extensions": extensions} if extensions else {})}
        views = self.before.all("bufferViews")
        held = [views[old] for old in self.views] if self.encoded else views
        held += [e for view in held for name, e in view.get("extensions", {}).items() if name in kMeshopt]
        kept = {holder["buffer"] for holder in held}
        full, empty = [], []
        if not any(name in view.get("extensions", {}) for view in views for name in kMeshopt):
            kept |= {len(self.before.buffers) - 1}  # new bytes go to the last buffer, or to a new one
        for i, (buffer, data) in enumerate(zip(self.before.all("buffers"), self.before.buffers)):
            if buffer["byteLength"] and not data:
                empty.append(buffer)
            elif i in kept:
                full.append(plain(buffer))
        now = self.after.all("buffers")
        named = {view["buffer"] for view in self.after.all("bufferViews")}
        if not now:
            return
        if plain(now[0]) != (full or [{}])[0]:
            self.say("/buffers/0", f"should be {(full or [{}])[0]}, is {plain(now[0])}")
        def placeholder(buffer):
            is_fallback = any(name in buffer.get("extensions", {}) for name in kMeshopt)
            return {key: value for key, value in buffer.items() if key != "byteLength" or not is_fallback}
        rest, empty = [placeholder(b) for b in now[1:]], [placeholder(b) for b in empty]
        if rest != [b for b in empty if b in rest] or not named <= set(range(len(now))):
            self.say("/buffers", "those without bytes are not as they were")

    def compare_lists(self):
        def has(tree, name):
            if isinstance(tree, dict):
                return name in tree.get("extensions", {}) or any(has(value, name) for value in tree.values())
            return isinstance(tree, list) and any(has(value, name) for value in tree)
        for name in ("extensionsUsed", "extensionsRequired"):
            listed = list(self.before.all(name))
            listed += [n for n in self.names if n not in listed]
            both = [n for n in (kStock, kName) if n in listed]
            if both:
                at = min(map(listed.index, both))
                listed = [n for n in listed if n not in both]
                listed[at:at] = both
            wanted = [n for n in listed if n not in (kStock, kManifold, *kMeshopt) or n in self.names or has(self.after.json, n)]
            if self.after.json.get(name) != (wanted or None):
                self.say(f"/{name}", f"should be {wanted}, is {self.after.json.get(name)}")


def differences(before, after):
    return Comparison(Asset(pathlib.Path(before)), Asset(pathlib.Path(after))).run()


if __name__ == "__main__":
    found = differences(*sys.argv[1:])
    print("\n".join(found) or "no differences but those that may be")
    sys.exit(1 if found else 0)
