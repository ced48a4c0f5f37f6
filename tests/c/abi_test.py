#!/usr/bin/env python3
"""Compares what the C interface promises with the list beside this file:

  abi_test.py --nm COMMAND --readelf COMMAND --compiler C-COMPILER --library FILE --header psplit.h --version TEXT [--update]

The list has the exported symbols with their versions, and the sizes and offsets of all structs, of 64-bit Linux. Programs
that were built once depend on all of it: lines may be added, but none may change. --update writes the list anew.

Also, nothing may unload the library, because its threads wait in it.
"""
import argparse, pathlib, re, subprocess, sys, tempfile

parser = argparse.ArgumentParser()
for name in ("nm", "readelf", "compiler", "library", "header", "version"):
    parser.add_argument("--" + name, required=True)
parser.add_argument("--update", action="store_true")
options = parser.parse_args()
header = pathlib.Path(options.header)
text = re.sub(r"//.*", "", header.read_text())
stored = pathlib.Path(__file__).with_name("abi.txt")


def symbols():
    """Every exported symbol, which must be a function of the header with a version."""
    declared = set(re.findall(r"^PSPLIT_API .*?(\w+)\(", text, re.M))
    lines = []
    for line in subprocess.check_output([options.nm, "-D", "--defined-only", options.library], text=True).splitlines():
        kind, name = line.split()[-2:]
        if kind == "A":  # the version itself
            continue
        function = name.split("@")[0]
        if kind != "T" or function not in declared:
            sys.exit(f"{options.library} exports {line}, which {header.name} does not declare")
        declared.remove(function)
        lines.append(name)
    if declared:
        sys.exit(f"{options.library} does not export {', '.join(sorted(declared))}")
    return sorted(lines)


def structs():
    """Name and members of each struct that is not opaque."""
    for body, name in re.findall(r"typedef struct \w+ \{(.*?)\} (\w+);", text, re.S):
        members = []
        for declaration in body.split(";"):
            if declaration.strip():
                members += [re.search(r"(\w+)\s*(\[\d+\])?\s*$", part).group(1) for part in declaration.split(",")]
        yield name, members


def layouts():
    """What a program in C says about them. A struct has no gaps: a member that is added would not change its size."""
    lines = ['#include "psplit.h"', "#include <stdio.h>", "int main(void) {"]
    for name, members in structs():
        lines.append(f'  printf("{name} %zu\\n", sizeof({name}));')
        for member in members:
            place = f"offsetof({name}, {member}), sizeof((({name}*)0)->{member})"
            lines.append(f'  printf("{name}.{member} at %zu, %zu\\n", {place});')
    lines += ['  printf("version %d.%d.%d\\n", PSPLIT_VERSION_MAJOR, PSPLIT_VERSION_MINOR, PSPLIT_VERSION_PATCH);', "}"]
    with tempfile.TemporaryDirectory() as folder:
        source, program = pathlib.Path(folder, "layout.c"), pathlib.Path(folder, "layout")
        source.write_text("\n".join(lines) + "\n")
        subprocess.check_call([options.compiler, "-std=c99", f"-I{header.parent}", "-o", program, source])
        *said, version = subprocess.check_output([program], text=True).splitlines()
    if version != f"version {options.version}":
        sys.exit(f"{header.name} says {version}, the project is {options.version}")
    return said


def check_gaps(said):
    size = end = 0
    name = ""
    for line in said + ["end 0"]:
        whole = re.fullmatch(r"(\w+) (\d+)", line)
        if whole:
            if end != size:
                sys.exit(f"{name} has {size - end} unnamed bytes at its end")
            name, size, end = whole.group(1), int(whole.group(2)), 0
            continue
        begin, member = map(int, re.search(r"at (\d+), (\d+)$", line).groups())
        if begin != end:
            sys.exit(f"{line}: {begin - end} unnamed bytes before it")
        end = begin + member


said = layouts()
check_gaps(said)
found = symbols() + said
if options.update:
    stored.write_text("\n".join(found) + "\n")
wanted = stored.read_text().splitlines()
for line in wanted:
    if line not in found:
        sys.exit(f"the interface lost: {line}")
for line in found:
    if line not in wanted:
        sys.exit(f"the interface has, and {stored.name} lacks: {line}")
if "NODELETE" not in subprocess.check_output([options.readelf, "-d", options.library], text=True):
    sys.exit(f"{options.library} may be unloaded")
print(f"{len(found)} lines")
