#!/usr/bin/env python3
"""The archives of a release do not depend on who makes them, where and with what umask:  archive_test.py SOURCE"""
import io, pathlib, sys, tarfile, tempfile, zipfile

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(sys.argv[1]) / "scripts"))
from packages import archive

kFiles = {"psplit/bin/gltf-psplit": (b"a program", 0o777), "psplit/README.md": (b"a page", 0o666)}


def make_tar(path, names, user, umask):
    with tarfile.open(path, "w:gz") as packed:
        for name in names:
            content, mode = kFiles[name]
            member = tarfile.TarInfo(name)
            member.size, member.mode, member.uid, member.gid = len(content), mode & ~umask, user, user
            member.uname = member.gname = str(user)
            packed.addfile(member, io.BytesIO(content))


def make_zip(path, names, year, umask):
    with zipfile.ZipFile(path, "w") as packed:
        for name in names:
            content, mode = kFiles[name]
            entry = zipfile.ZipInfo(name, (year, 1, 1, 0, 0, 0))
            entry.external_attr = (mode & ~umask) << 16
            packed.writestr(entry, content)


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    for make, kind in ((make_tar, ".tar.gz"), (make_zip, ".zip")):
        placed = []
        for number, names, umask in ((2001, list(kFiles), 0o022), (2002, list(reversed(kFiles)), 0o077)):
            made = folder / f"{number}{kind}"
            make(made, names, number, umask)
            placed.append(folder / f"placed-{number}{kind}")
            archive.sort(made, placed[-1], 1_000_000_000)
        if placed[0].read_bytes() != placed[1].read_bytes():
            sys.exit(f"two {kind} of the same files differ")
        if kind == ".zip":
            found = {entry.filename: entry.external_attr >> 16 & 0o777 for entry in zipfile.ZipFile(placed[0]).infolist()}
        else:
            found = {member.name: member.mode for member in tarfile.open(placed[0]).getmembers()}
        if found != {"psplit/bin/gltf-psplit": 0o755, "psplit/README.md": 0o644}:
            sys.exit(f"{kind} has {found}")
print("archives have the same bytes for every user")
