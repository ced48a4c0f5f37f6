"""The code blocks of docs/python.md run, in order, in one namespace; and those of bindings/python/README.md."""
import re

import gltf_psplit
import pytest
from conftest import ROOT


@pytest.mark.parametrize("page, least", [("docs/python.md", 9), ("bindings/python/README.md", 1)])
def test_page(page, least, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bunny.drc").write_bytes(gltf_psplit.encode([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], normals=[[0, 0, 1]] * 3))
    text = (ROOT / page).read_text()
    blocks = [(text.count("\n", 0, found.start(1)) + 1, found[1])
              for found in re.finditer(r"^```py(?:thon)?\n(.*?)^```$", text, re.M | re.S)]
    assert len(blocks) >= least
    names = {}
    for line, block in blocks:
        # Lines of the page, so that an error names them.
        exec(compile("\n" * (line - 1) + block, str(ROOT / page), "exec"), names)
