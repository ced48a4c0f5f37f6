#!/usr/bin/env python3
"""tinygltf with its own libdraco, and with psplit in its place, load the same models:

  tinygltf_test.py PRINT_BY_LIBDRACO PRINT_BY_PSPLIT FOLDER...

Every .glb with Draco below the folders is loaded by both programs. Exits with 77, for skipped, if there is none."""
import pathlib, subprocess, sys

by_libdraco, by_psplit = sys.argv[1:3]
count = failures = 0
for folder in map(pathlib.Path, sys.argv[3:]):
    for asset in sorted(folder.glob("**/*.glb")):
        if b'"KHR_draco_mesh_compression"' not in asset.read_bytes():
            continue
        expected, seen = (subprocess.run([program, asset], capture_output=True, text=True) for program in (by_libdraco, by_psplit))
        if expected.returncode != 0:
            print(f"skipped: tinygltf does not load {asset.name}: {expected.stderr.strip()}")
            continue
        count += 1
        if expected.stdout != seen.stdout or "buffer of" not in seen.stdout:
            failures += 1
            print(f"FAILED {asset.name}: {expected.stdout[:300]} and {seen.stdout[:300]}{seen.stderr}")
print(f"{count} models, {failures} failed")
sys.exit(1 if failures else 0 if count else 77)
