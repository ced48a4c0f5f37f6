#!/usr/bin/env python3
"""Figures in README.md and docs/manual.md come from the measured pages: kCells says from which cells."""
import re, sys

from pages import text_of

compare, typical, encoding, cuda, profile, condensed = (f"docs/measured/{page}.md" for page in ("compare", "typical", "encoding", "cuda", "profile-size",
                                                                                                "condensed"))
N = r"(-?[\d,]*\.?\d+)"  # in a sentence or a cell


def codec(name, cells):
    """Cells of a codec on the page of the Dragon: bytes, percent, ms, speed, ms, speed. Those left out are `-`."""
    return rf"^\| {name} " + "".join(rf"\| {'[^|]*' if cell == '-' else cell + ' '}" for cell in cells)


def newest(row):
    """Of a page with a section for each processor, the row in the first, which the last run wrote."""
    return rf"^# (?s:.*?)\n{row.removeprefix('^')}"


kOneThread, kTwoThreads = ("-", "-", "-", N), ("-", "-", "-", "-", "-", N)
kStream, kUsual, kFast = "psplit, one stream a primitive", "psplit, 32 patches", "psplit, 182 patches"
kOldRival, kNewRival = r"meshoptimizer 0\.18, codec 0, zstd", r"meshoptimizer 1\.2, codec 1, brotli"

# (page, pattern of a sentence, measured page, pattern of cells). Each group of a pattern is a number. Two numbers of a sentence are
# the least and the largest cell; one is any of the cells, or after "at least" the least, rounded down.
kCells = [
    ("README.md", rf"Dragon, {N} triangles", compare, rf"has {N} faces"),
    ("README.md", rf"stock Draco, one stream \| {N} \|", compare, newest(codec("libdraco, one stream a primitive, speed 5", [N]))),
    ("README.md", rf"psplit, one stream \| {N} \|", compare, newest(codec(kStream, [N]))),
    ("README.md", rf"psplit, one stream \| [\d,]+ \| {N} to {N} \|", compare, codec(kStream, kOneThread)),
    ("README.md", rf"32 patches, the default \| {N} ", compare, newest(codec(kUsual, [N]))),
    ("README.md", rf"32 patches, the default \| [\d,]+ \(\+{N} %", compare, newest(codec(kUsual, ["-", rf"\+{N} %"]))),
    ("README.md", rf"32 patches, the default \| [^|]* \| {N} to {N} \|", compare, codec(kUsual, kOneThread)),
    ("README.md", rf"32 patches, the default \| [^|]* \| [^|]* \| {N} to {N} \|", compare, codec(kUsual, kTwoThreads)),
    ("README.md", rf"182 patches, `--profile speed` \| {N} ", compare, newest(codec(kFast, [N]))),
    ("README.md", rf"182 patches, `--profile speed` \| [\d,]+ \(\+{N} %", compare, newest(codec(kFast, ["-", rf"\+{N} %"]))),
    ("README.md", rf"182 patches, `--profile speed` \| [^|]* \| {N} to {N} \|", compare, codec(kFast, kOneThread)),
    ("README.md", rf"182 patches, `--profile speed` \| [^|]* \| [^|]* \| {N} to {N} \|", compare, codec(kFast, kTwoThreads)),
    ("README.md", rf"32 patches, `--condense` \| {N} ", compare, newest(codec(f"{kUsual}, condensed", [N]))),
    ("README.md", rf"32 patches, `--condense` \| [\d,]+ \({N} %", compare, newest(codec(f"{kUsual}, condensed", ["-", rf"{N} %"]))),
    ("README.md", rf"32 patches, `--condense` \| [^|]* \| {N} to {N} \|", compare, codec(f"{kUsual}, condensed", kOneThread)),
    ("README.md", rf"32 patches, `--condense` \| [^|]* \| [^|]* \| {N} to {N} \|", compare, codec(f"{kUsual}, condensed", kTwoThreads)),
    ("README.md", rf"0\.18 and zstd \| {N} ", compare, newest(codec(kOldRival, [N]))),
    ("README.md", rf"0\.18 and zstd \| [\d,]+ \(\+{N} %", compare, newest(codec(kOldRival, ["-", rf"\+{N} %"]))),
    ("README.md", rf"0\.18 and zstd \| [^|]* \| {N} to {N} \|", compare, codec(kOldRival, kOneThread)),
    ("README.md", rf"1\.2 and brotli \| {N} ", compare, newest(codec(kNewRival, [N]))),
    ("README.md", rf"1\.2 and brotli \| [\d,]+ \(\+{N} %", compare, newest(codec(kNewRival, ["-", rf"\+{N} %"]))),
    ("README.md", rf"1\.2 and brotli \| [^|]* \| {N} to {N} \|", compare, codec(kNewRival, kOneThread)),
    ("README.md", rf"- {N} assets as people ship them", typical, rf"^\| 5 \| {N} \|"),
    ("README.md", rf"one thread: {N} to {N} times as fast as libdraco", typical, rf"^\| [035] \| 40 \| {N} \|"),
    ("README.md", rf"as libdraco, at least {N} times", typical, rf"^\| [035] \| 40 \| [\d.]+ \| {N} \|"),
    ("README.md", rf"these assets {N} to {N} times as fast with zstd", typical, rf"^\| 5 \| 1\.2, codec 1 \| zstd \| {N} "),
    ("README.md", rf"zstd and {N} to {N} times with brotli", typical, rf"^\| 5 \| 1\.2, codec 1 \| brotli \| {N} "),
    ("README.md", rf"default for {N} of these", typical, rf"^\| 5 \| 1\.2, codec 1 \| brotli .* {N} of 40"),
    ("README.md", rf"takes {N} to {N} of the time of `draco_encoder`", encoding, rf"^\| `gltf-psplit encode -j 1` \| [\d.]+ \| {N} "),
    ("README.md", rf"and {N} to {N} on two threads", encoding, rf"^\| `gltf-psplit encode -j 2` \| [\d.]+ \| {N} "),
    ("docs/manual.md", rf"The Dragon's file takes {N} bytes", profile, rf"by default, {N} "),
    ("docs/manual.md", rf"bytes instead of {N} \(-17", profile, rf"Whole files of the Dragon: {N} by default"),
    ("docs/manual.md", rf"`encode` takes {N} times the processor", profile, rf"^\| `--profile size` \| {N} "),
    ("docs/manual.md", rf"`decode` of the result {N} times", profile, rf"^\| `--profile size` \| [\d.]+ \| {N} "),
    ("docs/manual.md", rf"4,800 faces take {N} to {N} % more bytes", condensed, rf"4,800 faces take .{{9,80}} ordinary ones {N} to {N} % more"),
    ("docs/manual.md", rf"and condensed {N} to {N} % fewer", condensed, rf"4,800 faces take {N} to {N} % fewer"),
    ("docs/manual.md", rf"lossless ones {N} to {N} % fewer", condensed, rf"Lossless ones take {N} to {N} % fewer"),
    ("docs/manual.md", rf"they decode at {N} to {N} times", condensed, rf"decode at {N} to {N} times"),
    ("README.md", rf"10 million triangles in {N} ms", cuda, rf"^\| 10 million \| 440 \| Draco \| {N} "),
    ("README.md", rf"ms, {N} billion a second", cuda, rf"^\| 10 million \| 440 \| Draco \| [\d.]+ \| {N} "),
    ("README.md", rf"memory in {N} ms", cuda, rf"^\| 10 million \| 440 \| Draco (?:\| [\d.]+ ){{3}}\| {N} "),
]


def value(number):
    return float(number.replace(",", ""))


def is_rounded(number, cell):
    """Whether a number of a sentence is a cell, rounded to the digits that the sentence has."""
    digits = len(number.partition(".")[2])
    return abs(abs(value(number)) - abs(cell)) <= 0.5 * 10 ** -digits + 1e-9


def is_at_least(number, cell):
    """Whether a number of a sentence is a cell, rounded down to the digits that the sentence has."""
    return 0 <= cell - value(number) < 10 ** -len(number.partition(".")[2])


def flat(text):
    return " ".join(text.split())


def faults_of_cells():
    for page, sentence, source, cells in kCells:
        said = re.search(sentence, flat(text_of(page)))
        # Sentences go over lines of their page, rows do not.
        text = text_of(source)
        found = [value(cell) for match in re.finditer(cells, text if cells.startswith("^") else flat(text), re.M) for cell in match.groups()]
        if not said or not found:
            yield f"{page if not said else source} has no longer {sentence if not said else cells!r}: change {sys.argv[0]}"
        elif len(said.groups()) == 1 and not (
                is_at_least(said[1], min(found)) if "at least" in said.group() else any(is_rounded(said[1], cell) for cell in found)):
            yield f"{page}: {said.group()!r}, but {source} has {found}"
        elif len(said.groups()) == 2 and not (is_rounded(said[1], min(found)) and is_rounded(said[2], max(found))):
            yield f"{page}: {said.group()!r}, but {source} has {found}"


bad = list(faults_of_cells())
if bad:
    sys.exit("\n".join(bad))
print(f"{len(kCells)} figures of README.md and docs/manual.md")
