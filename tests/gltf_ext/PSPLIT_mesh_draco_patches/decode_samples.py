#!/usr/bin/env python3
"""decode_samples.py SAMPLES PROGRAM...: checks that the decoder's library decodes the extension's samples to what
SAMPLES/expected.json says (SHA-256). PROGRAM is built from decode_samples.cpp; an emulator may come before it."""
import hashlib, json, pathlib, subprocess, sys, tempfile

samples, program = pathlib.Path(sys.argv[1]), sys.argv[2:]
arrays = 0
for asset, expected in json.loads((samples / "expected.json").read_text()).items():
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([*program, samples / asset, folder], check=True)
        found = {path.name: path.read_bytes() for path in pathlib.Path(folder).iterdir()}
    for number, primitive in enumerate(expected["primitives"]):
        wanted = {"indices": primitive["indices_sha256"], **primitive["attributes_sha256"],
                  **{name.replace("/", "."): digest for name, digest in primitive.get("targets_sha256", {}).items()}}
        for name, digest in wanted.items():
            values = found.pop(f"0.{number}.{name}")
            if hashlib.sha256(values).hexdigest() != digest:
                sys.exit(f"{asset}, primitive {number}: {name} differs")
            if name == "indices" and len(values) != 4 * primitive["indices"]:
                sys.exit(f"{asset}, primitive {number}: {len(values)} bytes of indices")
            arrays += 1
    if found:
        sys.exit(f"{asset}: unexpected {', '.join(found)}")
if arrays < 10:
    sys.exit(f"only {arrays} arrays")
print(f"{arrays} arrays are as expected")
