"""The code blocks of docs/python.md run, in order, in one namespace."""
import re

from conftest import ROOT


def test_page(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "python.md").read_text()
    blocks = [(page.count("\n", 0, found.start(1)) + 1, found[1])
              for found in re.finditer(r"^```python\n(.*?)^```$", page, re.M | re.S)]
    assert len(blocks) > 8
    names = {}
    for line, block in blocks:
        # Lines of the page, so that an error names them.
        exec(compile("\n" * (line - 1) + block, str(ROOT / "docs" / "python.md"), "exec"), names)
