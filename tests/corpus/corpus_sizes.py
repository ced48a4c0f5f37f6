#!/usr/bin/env python3
"""No output of `encode` is larger than its input, and patches that nobody asked for cost little:

  corpus_sizes.py --psplit COMMAND --corpus FOLDER [--only TEXT]

For each glTF asset of the corpus that `encode` accepts, by default, with --condense and with --profile size: the output, of
the same kind as the input and without images, is at most as large as the input (but for some text of a .gltf); and its
geometry takes at most 1.03 times what one Draco stream for each primitive takes (`decode --to draco`), or what the input has,
if that is more. Exits with 77 (skipped) if there is no corpus: it is not part of the project.
"""
import argparse
import concurrent.futures
import importlib.machinery
import importlib.util
import json
import os
import pathlib
import subprocess
import sys
import tempfile

here = pathlib.Path(__file__).resolve()
path = here.parents[2] / "scripts" / "corpus-bytes"
sys.dont_write_bytecode = True
loader = importlib.machinery.SourceFileLoader("corpus_bytes", str(path))
corpus_bytes = importlib.util.module_from_spec(importlib.util.spec_from_loader("corpus_bytes", loader))
loader.exec_module(corpus_bytes)

kOptions = ([], ["--condense"], ["--profile", "size"])
kMostRatio = 1.03
# A .gltf is written anew: views are aligned, and a buffer without a file gets one.
kMostOfText = 24


def asset_of(file):
    return corpus_bytes.read_json(file) if file.suffix == ".glb" else json.loads(file.read_text(encoding="utf-8-sig"))


def bytes_of(file, asset):
    """The file and its buffers, without images and the paths to them, which depend on the folder of the output, and without
    the names of buffers: psplit names them after their content, also if nothing is encoded."""
    is_beside = lambda item: not item.get("uri", "").startswith("data:")
    buffers = list(filter(is_beside, asset.get("buffers", []))) if file.suffix == ".gltf" else []
    names = [item["uri"] for item in buffers + list(filter(is_beside, asset.get("images", []))) if "uri" in item]
    return file.stat().st_size + sum(buffer["byteLength"] for buffer in buffers) - sum(map(len, names))


def check(psplit, root, file):
    """Returns faults, a line each; None if a command refuses the file."""
    run = lambda *command: subprocess.run([psplit, *map(str, command)], stdout=subprocess.DEVNULL,
                                          stderr=subprocess.DEVNULL).returncode == 0
    wrong = []
    with tempfile.TemporaryDirectory(prefix="psplit-sizes-") as name:
        folder = pathlib.Path(name)
        draco = folder / "draco.glb"
        one = corpus_bytes.geometry_bytes(corpus_bytes.read_json(draco)) \
            if run("decode", "-q", "-j", 1, "--to", "draco", file, draco) else None
        for number, options in enumerate(kOptions):
            output = folder / f"{number}{file.suffix}"
            images = ["--images", "reference"]
            if not run("encode", "-q", "-j", 1, *images, *options, file, output):
                return None
            asset, before = asset_of(output), asset_of(file)
            size, size_before = bytes_of(output, asset), bytes_of(file, before)
            said = f"{file.relative_to(root)} {' '.join(options)}: "
            of_text = 0 if file.suffix == ".glb" else kMostOfText
            if size > size_before + of_text:
                wrong.append(f"{said}{size} bytes, the input {size_before}")
            geometry = corpus_bytes.geometry_bytes(asset)
            if one and geometry > max(kMostRatio * one, corpus_bytes.geometry_bytes(before)):
                wrong.append(f"{said}geometry {geometry}, one stream a primitive {one}")
    return wrong


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--psplit", type=os.path.abspath, required=True)
    parser.add_argument("--corpus", type=pathlib.Path, required=True)
    parser.add_argument("--only", default="", help="only files whose paths contain this")
    arguments = parser.parse_args()
    if not arguments.corpus.is_dir():
        print(f"no corpus at {arguments.corpus}")
        sys.exit(77)
    files = sorted(file for file in (arguments.corpus / "gltf").rglob("*") if file.suffix in (".gltf", ".glb")
                   and "malformed" not in file.parts and arguments.only in str(file))
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        results = list(pool.map(lambda file: check(arguments.psplit, arguments.corpus, file), files))
    checked = [wrong for wrong in results if wrong is not None]
    failures = [line for wrong in checked for line in wrong]
    print("\n".join(failures + [f"{len(checked)} assets of {len(files)}, {len(failures)} failures"]))
    sys.exit(1 if failures or not checked else 0)


if __name__ == "__main__":
    main()
