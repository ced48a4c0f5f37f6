#!/usr/bin/env python3
"""Checks that modules for Blender and Unity need the C library alone:  plugin_libraries_test.py READELF MODULE...

Blender and Unity bring libraries of their own, and their users have no others."""
import re, subprocess, sys

readelf, *modules = sys.argv[1:]
assert modules, "no module is named"
for module in modules:
    dynamic = subprocess.check_output([readelf, "--dynamic", module], text=True)
    needed = re.findall(r"\(NEEDED\).*\[(.*)\]", dynamic)
    assert "libc.so.6" in needed, dynamic
    others = [name for name in needed if not re.match(r"(libc|libm|libpthread|ld-linux.*)\.so", name)]
    assert not others, f"{module} needs {', '.join(others)}"
    print(f"{module}: {', '.join(needed)}")
