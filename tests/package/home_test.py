#!/usr/bin/env python3
"""Every manifest names the project's address, scripts/release --home changes all of them, and NuGet's rules are kept and are rules:
home_test.py SOURCE"""
import pathlib, re, subprocess, sys, tempfile

sys.dont_write_bytecode = True
source = pathlib.Path(sys.argv[1])
sys.path.insert(0, str(source / "scripts"))
from packages import home, nuspec
from release_copy import copy_for_release

if home.disagreements():
    sys.exit("\n".join(home.disagreements()))
# No file but these has an address of its own.
tracked = subprocess.run(["git", "-C", source, "grep", "-lF", home.home()], capture_output=True, text=True)
allowed = {*home.kManifests, "scripts/packages/home.py", "tests/package/home_test.py"}
if tracked.returncode == 0 and (others := {file for file in tracked.stdout.split() if not file.startswith("docs/")} - allowed):
    sys.exit(f"{', '.join(sorted(others))} have the address beside the manifests of scripts/packages/home.py")

with tempfile.TemporaryDirectory() as name:
    copy = pathlib.Path(name)
    release = [sys.executable, copy_for_release(source, copy, home.kManifests)]
    for wrong in ("http://a.example/psplit", "https://a.example/", "https://a.example/p splits"):
        if subprocess.run([*release, "--home", wrong], capture_output=True).returncode == 0:
            sys.exit(f"{wrong} is taken for an address")
    subprocess.run([*release, "--home", "https://a.example/b/psplit", "--maintainer", "A B <c@d.example>"], check=True, capture_output=True)
    for file in home.kManifests:
        text = (copy / file).read_text()
        if home.home() in text or "https://a.example/b/psplit" not in text:
            sys.exit(f"{file} has not the new address")
    if "Maintainer: A B <c@d.example>\n" not in (copy / "contrib/debian/control").read_text():
        sys.exit("contrib/debian/control has not the new maintainer")
    said = subprocess.run([*release, "--home"], check=True, capture_output=True, text=True).stdout
    if said != "https://a.example/b/psplit\nA B <c@d.example>\n":
        sys.exit(f"scripts/release --home says {said!r}")

    # The rules of NuGet find what each of these changes breaks.
    good = (source / "bindings/csharp/GltfPsplit.nuspec").read_text()
    path = copy / "a.nuspec"
    changes = {"": None, r"<authors>.*</authors>": "no authors", r"<id>.*</id>": "no id",
               r"<version>[^<]*": ("<version>1.x", "not that of a release"), r'type="expression"': ('type="mit"', "neither an expression"),
               r"<readme>[^<]*": ("<readme>OTHER.md", "not among the files"), r"<tags>": ("<tag/><tags>", "no element tag"),
               r"<projectUrl>[^<]*": ("<projectUrl>psplit", "no address of https"), r"<id>[^<]*": ("<id>gltf psplit", "not words")}
    for pattern, change in changes.items():
        new, fault = change if isinstance(change, tuple) else ("", change)
        path.write_text(re.sub(pattern, new, good, count=1) if pattern else good)
        found = "; ".join(nuspec.faults(path))
        if (fault is None) != (found == "") or (fault or "") not in found:
            sys.exit(f"with {pattern!r} as {new!r} NuGet's rules find {found!r}")
print(f"{len(home.kManifests)} manifests name {home.home()}")
