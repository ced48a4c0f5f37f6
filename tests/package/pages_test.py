#!/usr/bin/env python3
"""Links in the pages of each package lead to files of that package:  pages_test.py SOURCE"""
import pathlib, re, subprocess, sys, tempfile

source = pathlib.Path(sys.argv[1])


def make(folder, *arguments):
    done = subprocess.run([sys.executable, source / "scripts/packages/pages.py", folder, *arguments], check=True, capture_output=True, text=True)
    if done.stderr:
        sys.exit(done.stderr)
    links = []
    for page in folder.rglob("*.md"):
        text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.S)
        links += [(page, target) for target in re.findall(r"\]\(([^)#\s:]+)(?:#[^)\s]*)?\)", text)]
    for page, target in links:
        if not (page.parent / target).resolve().is_relative_to(folder.resolve()) or not (page.parent / target).exists():
            sys.exit(f"{page.relative_to(folder)} has a link to {target}, which the package does not have")
    return len(links)


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    # As cmake/archive.cmake and scripts/web ask for them.
    counts = [make(folder / "archive", "--without=libdraco, libpng", "README.md", "SECURITY.md", "CHANGELOG.md", "docs",
                   "gltf_ext/PSPLIT_mesh_draco_patches"),
              make(folder / "npm", "bindings/web/README.md=README.md", "docs/web.md", "bindings/web/js=.")]
    if min(counts) < 3:
        sys.exit(f"only {counts} links were found")
    if "built without libdraco, libpng." not in (folder / "archive/README.md").read_text():
        sys.exit("README.md does not say what the build lacks")
    # A link that leads out of the package is text, one that leads nowhere is an error, and code stays.
    outside = make(folder / "alone", "README.md")
    text = (folder / "alone/README.md").read_text()
    if outside or "| npm package |" not in text or "![" in text or "gltf-psplit encode in.gltf out.glb" not in text:
        sys.exit(f"README.md alone has {outside} links, or not what it should have")
print(f"{sum(counts)} links work")
