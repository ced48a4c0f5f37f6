#!/usr/bin/env python3
"""Each link of each page leads to a file of the project, and to a heading there; and each page that a comment names exists."""
import re, sys

from pages import anchors, pages, prose, root

bad, count = [], 0
for page in pages():
    text = re.sub(r"`[^`]*`", lambda code: re.sub(r"[\[\]()]", " ", code.group()), prose(page))
    for match in re.finditer(r"\]\(([^)\s]+)\)|^\[[^\]]+\]: (\S+)$", text, re.M):
        target, _, anchor = (match[1] or match[2]).partition("#")
        if re.match(r"[a-z]+:", target):
            continue  # another site: tests have no network
        count += 1
        place = f"{page}:{text.count(chr(10), 0, match.start()) + 1}"
        file = ((root / page).parent / target).resolve() if target else root / page
        if not file.exists():
            bad.append(f"{place}: there is no {target}")
        elif anchor and (file.suffix != ".md" or anchor not in anchors(file.relative_to(root).as_posix())):
            bad.append(f"{place}: {target or page} has no heading #{anchor}")

# docs/NAME.md in a comment, a message or a script.
kSources = ("bench", "bindings", "cmake", "contrib", "decoder_cuda", "encoder", "gltf_ext", "include", "mesh_files", "scripts", "src", "system",
            "tests", "tools")
for folder in kSources:
    for file in (root / folder).rglob("*"):
        if file.suffix in (".md", ".json", ".glb", ".wasm", ".pyc") or not file.is_file() or "node_modules" in file.parts:
            continue
        for name in set(re.findall(rb"\bdocs/(?:measured/)?[a-z-]+\.md\b", file.read_bytes())):
            count += 1
            if not (root / name.decode()).exists():
                bad.append(f"{file.relative_to(root)}: there is no {name.decode()}")
if bad or count < 300:
    sys.exit("\n".join(bad) or f"only {count} links were found")
print(f"{count} links")
