"""The sentences with which measured pages of one program begin, made of the figures of their tables."""
from benchmarks.pages import join, span, value_of


def libdraco_findings(streams, programs):
    """Of the rows of scripts/libdraco: streams (the third and the fifth cell are ratios) and programs (the last cell)."""
    slower = [f"{row[0]} takes {1 / value_of(row[-1]):.2f} times the time" for row in programs if value_of(row[-1]) < 1]
    gains = [value_of(row[-1]) for row in programs if value_of(row[-1]) >= 1]
    return [*([f"In libdraco's place, {join(slower)}."] if slower else []),
            f"psplit fills libdraco's classes {span([value_of(row[3]) for row in streams])} times as fast as libdraco on one thread, and "
            f"{span([value_of(row[5]) for row in streams])} times in the first decode of a process.",
            *([f"{'Other whole' if slower else 'Whole'} programs are {span(gains)} times as fast."] if gains else [])]


def python_findings(mesh, decoding, encoding, sizes):
    """Of the rows of bindings/python/benchmark.py, ours first, whose third and fifth cell are times over ours, and of the bytes that
    encoders make of the mesh."""
    (ours, size), *others = sizes.items()
    sentences = [f"{other} makes {100 * (1 - rival / size):.1f} % fewer bytes of {mesh} than {ours}." for other, rival in others if rival < size]
    slower = []
    for rows in (decoding, encoding):
        for name, *cells in rows[1:]:
            ratios = [value_of(cells[1]), value_of(cells[3])]
            if min(ratios) < 1:
                sentences.append(f"{name} takes {span(ratios)} times the time of {rows[0][0]}.")
            else:
                slower.append((rows[0][0], f"{name} takes {span(ratios)} times"))
    return sentences + [f"{join([words for way, words in slower if way == ours])} the time of {ours}." for ours in dict.fromkeys(way for way, _ in slower)]


def batch_findings(speeds, memory):
    """Of the rows of bench/small_assets: assets, what, seconds, assets a second, microseconds; and lines, what, megabytes of the batch,
    of its worker, seconds."""
    sentences = []
    if memory:
        most = max(memory, key=lambda row: max(map(value_of, filter(None, row[2:4]))))
        sentences.append(f"{most[1]} of {most[0]} lines takes {max(filter(None, most[2:4]), key=value_of)} MB, the most of all steps.")
        batches = [f"{row[2]} MB for a manifest of {row[0]} lines" for row in memory if row[1].startswith("manifest")]
        sentences.append(f"A batch takes {join(batches)}.")
    by_what = {row[1]: row for row in speeds}
    encoded, unchanged = (by_what.get(f"one shard, 2 threads: {what}") for what in ("encoded", "up to date"))
    if encoded:
        sentences.append(f"One shard on two threads encodes {encoded[3]} assets a second, at {encoded[4]} microseconds of CPU each; if all are "
                         f"up to date, it checks {unchanged[3]} a second.")
    return sentences


def out_of_core_findings(rows, limit):
    """Of the rows of bench/out_of_core: triangles, step, seconds, seconds of CPU, nanoseconds a triangle, megabytes, bytes, disk space."""
    whole = next(row for row in rows if row[1] == "encode in memory")
    return [f"Encoding {row[0]} triangles with `--memory {limit}` takes {row[2]} seconds and {row[5]} MB: {value_of(row[4]) / value_of(whole[4]):.2f} times as "
            f"long for each triangle as {whole[0]} triangles in memory, which take {whole[5]} MB." for row in rows if row[1] == "encode"]


kTypicalHead = ["Draco's speed", "assets", "over libdraco, one thread", "worst", "two threads over one, assets of many primitives"]


def typical_findings(tables):
    """A sentence about the tables of scripts/typical on several processors, under kTypicalHead: of the speeds of the first."""
    gains = [span([value_of(table[speed][kTypicalHead[2]]) for table in tables if speed in table]) for speed in tables[0]]
    worst = min(value_of(table[speed][kTypicalHead[3]]) for table in tables for speed in tables[0] if speed in table)
    return (f"At {'speeds' if len(gains) > 1 else 'speed'} {join(list(tables[0]))}, psplit decodes {join(gains)} times as fast as libdraco, "
            f"{'in this order, ' if len(gains) > 1 else ''}on the processors below, and no asset less than {worst:.2f} times.")
