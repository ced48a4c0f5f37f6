"""docs/measured/profile-size.md: bytes of `--profile size`, and the processor time that options take."""
from benchmarks.pages import page, span, table
from benchmarks.ratios import spread_of

kWays = {"default": [], "`--condense`": ["--condense"], "`--profile size`": ["--profile", "size"],
         "`--profile size --condense`": ["--profile", "size", "--condense"]}
# Options whose times are measured. What `decode` takes depends on the options that its input was encoded with.
kTimed = {**{way: kWays[way] for way in ("default", "`--condense`", "`--profile size`")}, "`--encode-speed 0`": ["--encode-speed", "0"],
          "`--patches 4`": ["--patches", "4"], "`--fallback coarse`": ["--fallback", "coarse"]}


def over_default(rounds, command, way):
    """The ratio of the least times of all rounds."""
    return min(of[command, way] for of in rounds) / min(of[command, "default"] for of in rounds)


def saved(of, way, base="default"):
    return 100 * (1 - of[way] / of[base])


def findings(bytes_of, rounds, timed_mesh):
    size, both = "`--profile size`", "`--profile size --condense`"
    encode, decode = (over_default(rounds, command, size) for command in ("encode", "decode"))
    return [f"For the {timed_mesh}, `--profile size` takes {encode:.2f} times the processor time of the default's `encode`, and {decode:.2f} times that of its "
            f"`decode`; `--condense` takes {over_default(rounds, 'encode', '`--condense`'):.2f} and {over_default(rounds, 'decode', '`--condense`'):.2f} times.",
            f"`--profile size` saves {span([saved(of, size) for of in bytes_of.values()], 1)} % of the bytes of the default, and with `--condense` "
            f"{span([saved(of, both) for of in bytes_of.values()], 1)} %, "
            f"which is {span([saved(of, both, '`--condense`') for of in bytes_of.values()], 1)} % of those with `--condense` alone."]


def text_of(bytes_of, files, rounds, timed_mesh, **how):
    """`bytes_of`: {asset: {way: bytes of geometry}}. `files`: {way: bytes of the file} of the timed mesh. `rounds`: each {(command, way):
    seconds of the processor}."""
    change = lambda way, of: f"{of[way]:,}" + ("" if way == "default" else f" ({100 * (of[way] / of['default'] - 1):+.1f} %)")
    ratio = lambda command, way: f"{over_default(rounds, command, way):.2f}"
    lines = ["Bytes of geometry:", "",
             *table(["asset", *kWays], [[name, *(change(way, of) for way in kWays)] for name, of in bytes_of.items()]), "",
             f"Whole files of the {timed_mesh}: {change('default', files)} by default, {change('`--profile size`', files)} with `--profile size`, "
             f"and {change('`--profile size --condense`', files)} with `--condense` as well.", "",
             f"Processor time of whole commands for the {timed_mesh} on one thread (`-j 1`), with verification, over that of the default: the least of",
             f"{len(rounds)} rounds in turn. `decode` reads what `encode` wrote with these options.", "",
             *table(["options of `encode`", "`encode`", "`decode`"], [[way, ratio("encode", way), ratio("decode", way)] for way in kTimed if way != "default"])]
    spreads = [spread_of([of[key] for of in rounds]) for key in rounds[0]]
    return page("The fewest bytes", findings(bytes_of, rounds, timed_mesh), lines, spreads, **how)
