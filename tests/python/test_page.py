"""The code blocks of docs/python.md run, in order, in one namespace; and the blocks of bindings/python/README.md."""
import json, re, struct

import gltf_psplit
import numpy as np
import pytest
from conftest import ROOT


def dune_glb():
    """The asset that docs/python.md loads: a square of 2 x 99 x 99 faces in four patches, which a node lifts by 3."""
    x, y = np.meshgrid(np.linspace(-1, 1, 100), np.linspace(-1, 1, 100))
    points = np.stack([x, y, 0.1 * np.sin(5 * x) * np.cos(4 * y)], -1).reshape(-1, 3)
    corner = (np.arange(99)[:, None] * 100 + np.arange(99)).reshape(-1, 1)
    container = gltf_psplit.encode_container(points, np.concatenate([corner + [0, 1, 100], corner + [1, 101, 100]]), patches=4)
    names = list(container.accessors)
    document = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["PSPLIT_mesh_draco_patches"], "extensionsRequired": ["PSPLIT_mesh_draco_patches"],
        "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "translation": [0, 0, 3]}], "materials": [{"name": "sand"}],
        "meshes": [{"name": "dune", "primitives": [{
            "attributes": {name: names.index(name) for name in container.attributes}, "indices": names.index("indices"), "material": 0,
            "extensions": {"PSPLIT_mesh_draco_patches": {"bufferView": 0, "attributes": container.attributes}}}]}],
        "accessors": list(container.accessors.values()),
        "bufferViews": [{"buffer": 0, "byteLength": len(container.data)}], "buffers": [{"byteLength": len(container.data)}]}
    document["accessors"][0].update(min=points.min(axis=0).tolist(), max=points.max(axis=0).tolist())

    def chunk(kind, data, fill):
        data += fill * (-len(data) % 4)
        return struct.pack("<I4s", len(data), kind) + data

    body = chunk(b"JSON", json.dumps(document).encode(), b" ") + chunk(b"BIN\0", container.data, b"\0")
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


@pytest.mark.parametrize("page, least", [("docs/python.md", 4), ("bindings/python/README.md", 1)])
def test_page(page, least, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bunny.drc").write_bytes(gltf_psplit.encode([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], normals=[[0, 0, 1]] * 3))
    (tmp_path / "dune.glb").write_bytes(dune_glb())
    text = (ROOT / page).read_text()
    blocks = [(text.count("\n", 0, found.start(1)) + 1, found[1])
              for found in re.finditer(r"^```py(?:thon)?\n(.*?)^```$", text, re.M | re.S)]
    assert len(blocks) >= least
    names = {}
    for line, block in blocks:
        # Lines of the page, so that an error names them.
        exec(compile("\n" * (line - 1) + block, str(ROOT / page), "exec"), names)
