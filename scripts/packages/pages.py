#!/usr/bin/env python3
"""Copies pages of the project into a package, with links that work there:

  pages.py FOLDER [--without NAMES] PLACE[=PLACE_IN_PACKAGE]...

PLACE is a file or a folder of the project, relative to its root. It has the same place in FOLDER, or that which is named. A link to
something that the package does not have becomes text. --without says in README.md what libraries the build lacks, as
"libdraco, libpng".
"""
import argparse, os, pathlib, re, shutil, sys

root = pathlib.Path(__file__).resolve().parent.parent.parent
# Code, which has no links, or a link: an exclamation mark if it is an image, its text, its target and the place in that.
kLink = re.compile(r"```.*?```|`[^`\n]*`|(!?)\[((?:`[^`]*`|[^\]`])*)\]\(([^)#\s:]+)(#[^)\s]*)?\)", re.S)


def placed_files(places):
    """{file of the project: its place in the package}, both relative paths."""
    files = {}
    for place in places:
        source, _, target = place.partition("=")
        target = pathlib.PurePosixPath(target or source)
        if not (root / source).exists():
            sys.exit(f"pages: there is no {source}")
        for file in sorted((root / source).rglob("*")) if (root / source).is_dir() else [root / source]:
            if file.is_file():
                files[file.relative_to(root).as_posix()] = (target / file.relative_to(root / source)).as_posix()
    return files


def place_of(target, files):
    """Where a file or a folder of the project is in the package; None if it is not."""
    if target in files:
        return files[target]
    inside = next((file for file in files if file.startswith(target + "/")), None)
    rest = inside and inside[len(target):]
    return files[inside].removesuffix(rest) if inside and files[inside].endswith(rest) else None


def with_links(page, text, files):
    folder, new_folder = os.path.dirname(page), os.path.dirname(files[page])

    def link(match):
        image, words, target, anchor = match.groups()
        if target is None:
            return match.group()
        meant = os.path.normpath(os.path.join(folder, target))
        if not (root / meant).exists():
            print(f"pages: {page} has a link to {target}, which does not exist", file=sys.stderr)
        place = place_of(meant, files)
        return words if place is None else f"{image}[{words}]({os.path.relpath(place, new_folder or '.')}{anchor or ''})"

    return kLink.sub(link, text)


def copy(folder, places, without=""):
    files = placed_files(places)
    for source, place in files.items():
        target = pathlib.Path(folder, place)
        target.parent.mkdir(parents=True, exist_ok=True)
        if not place.endswith(".md"):
            shutil.copyfile(root / source, target)
            continue
        text = with_links(source, (root / source).read_text(encoding="utf-8"), files)
        if place == "README.md" and without:
            title, rest = text.split("\n", 1)
            text = f"{title}\n\nThe command of this package was built without {without}. docs/portability.md says what it then lacks, " \
                   f"under \"What a build may lack\".\n{rest}"
        target.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("folder")
    parser.add_argument("--without", default="")
    parser.add_argument("places", nargs="+")
    options = parser.parse_args()
    copy(options.folder, options.places, options.without)
