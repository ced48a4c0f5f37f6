#!/usr/bin/env python3
"""Every file that repeats the version says that of CMakeLists.txt, and scripts/release --version changes all of them:
version_test.py SOURCE"""
import pathlib, re, subprocess, sys, tempfile

sys.dont_write_bytecode = True
source = pathlib.Path(sys.argv[1])
sys.path.insert(0, str(source / "scripts"))
from packages import home, version
from release_copy import copy_for_release

if version.disagreements():
    sys.exit("\n".join(version.disagreements()))
with tempfile.TemporaryDirectory() as name:
    copy = pathlib.Path(name)
    places = [place.partition("#")[0] for place in version.kPlaces]
    release = [sys.executable, copy_for_release(source, copy, [*places, *home.kManifests]), "--version"]
    if subprocess.run([*release, "7.8"], capture_output=True).returncode == 0:
        sys.exit("7.8 is taken for a version")
    subprocess.run([*release, "7.8.9"], check=True, capture_output=True)
    for place, pattern in version.kPlaces.items():
        said = version.said(re.search(pattern, (copy / place.partition("#")[0]).read_text(), re.M))
        if said not in ("7.8.9", "7.8"):
            sys.exit(f"{place} says {said} after scripts/release --version 7.8.9")
    # Debian's changelog gets an entry, and keeps its older entries.
    old, changelog = ((folder / version.kChangelog).read_text() for folder in (source, copy))
    if not changelog.endswith("\n" + old) or changelog.count("\n -- ") != old.count("\n -- ") + 1:
        sys.exit(f"the changelog is {changelog}")
    # One file that was forgotten is noticed.
    text = (copy / "vcpkg.json").read_text()
    (copy / "vcpkg.json").write_text(text.replace("7.8.9", "7.8.8"))
    done = subprocess.run(release, capture_output=True, text=True)
    if done.returncode != 1 or "vcpkg.json says 7.8.8, CMakeLists.txt 7.8.9" not in done.stdout:
        sys.exit(f"scripts/release --version says {done.stdout!r}")
print(f"{len(version.kPlaces)} places say {version.version()}")
