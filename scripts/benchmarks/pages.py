"""Pages of docs/measured, each of which a script writes as a whole: what was found, how it was measured, and tables."""
import datetime, os, pathlib, re, shlex, sys

from benchmarks.programs import processor_name, root

# A time is noisy if half of its rounds differ by more than this share of their median, as for `gltf-psplit compare`.
kNoisySpread = 0.2
# Of a quiet machine fewer times than this share are noisy.
kMostNoisy = 0.1


def table(head, rows, left=1):
    """Markdown. The first `left` columns are text."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * left + "--:|" * (len(head) - left)]
    return lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows]


def rows_by_subject(rows_of):
    """{subject: rows} as rows of one table, whose first cell names the subject where it begins."""
    return [["" if i else subject, *row] for subject, rows in rows_of.items() for i, row in enumerate(rows)]


def extremes(rows, value, count=10):
    """The `count` rows of the least values and the `count` rows of the greatest, in that order; all rows if there are no more."""
    ordered = sorted(rows, key=value)
    return ordered if len(ordered) <= 2 * count else ordered[:count] + ordered[-count:]


def join(names):
    """"a", "a and b", "a, b and c"."""
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + " and " + names[-1]


def noise(spreads):
    """A sentence about the spreads of all times, if other programs seem to have used the machine; otherwise ""."""
    noisy = sum(spread > kNoisySpread for spread in spreads)
    if noisy <= kMostNoisy * len(spreads):
        return ""
    return (f"**Other programs used the machine:** {noisy} of {len(spreads)} times vary by more than {100 * kNoisySpread:.0f} %. Decoders "
            "took turns, so ratios suffer less than times.")


def how(what, spreads, words, today, processor):
    """A sentence: which command wrote `what`, when and where; and whether the machine was quiet."""
    words = sys.argv if words is None else words
    shown = [pathlib.Path(word).name if os.path.isabs(word) else word for word in words[1:]]
    date = (today or datetime.date.today()).strftime("%-d %B %Y")
    return (f"`{shlex.join([script_name(words[0]), *shown])}` wrote this {what} on {date}, measured on \"{processor or processor_name()}\" with "
            f"{os.cpu_count()} processors. {noise(spreads)}").rstrip()


def script_name(path):
    """A script as its users call it, from the root."""
    path = pathlib.Path(path).resolve()
    return str(path.relative_to(root)) if path.is_relative_to(root) else f"scripts/{path.name}"


def page(title, findings, sections, spreads, words=None, today=None, processor=None):
    """The text of a page. `findings`: sentences, of which the first says where a rival wins. `sections`: lines of Markdown. `words`:
    the script and its arguments."""
    return "\n".join([f"# {title}", "", " ".join(findings), "", how("page", spreads, words, today, processor), "", *sections]) + "\n"


# ---- Pages that have one section for each processor ----

def sections_of(text):
    """{heading: text} of the sections of a page."""
    heading, *others = re.split(r"^## (.*)\n", text, flags=re.M)
    return {name: body.strip() for name, body in zip(others[::2], others[1::2])}


def cells_of(text):
    """The first table of a section: {first cell of a row: {column: cell}}. Columns have different names."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in re.search(r"(^\|.*\n?)+", text, re.M)[0].splitlines()]
    return {row[0]: dict(zip(rows[0], row)) for row in rows[2:]}


def page_by_processor(title, findings_of, introduction, section, before, spreads, words=None, today=None, processor=None):
    """The text of a page that has a section for each processor. This run writes the section of its own; those of others stay as they
    are in `before`, the page's old text. `findings_of` makes sentences of the sections' first tables, of which the first is this
    run's. `introduction`, `section`: lines of Markdown."""
    processor = processor or processor_name()
    own = "\n".join([how("section", spreads, words, today, processor), "", *section])
    sections = {processor: own} | {name: text for name, text in sections_of(before).items() if name != processor}
    findings = findings_of([cells_of(text) for text in sections.values() if re.search(r"^\|", text, re.M)])
    parts = [f"# {title}", " ".join(findings), "\n".join(introduction), *(f"## {name}\n\n{text}" for name, text in sections.items())]
    return "\n\n".join(parts) + "\n"


def text_before(page, output):
    """The old text of a page that is written to `output`, or shown if that is -; "" if there is none."""
    file = page if str(output) == "-" else output
    return file.read_text() if file.is_file() else ""


def value_of(cell):
    """The number of a cell such as `1,170,090` or `+1.4 %`."""
    return float(cell.strip("% ").replace(",", ""))


def span(values, digits=2):
    """"2.55 to 3.61" of numbers; or "2.55" if they are equal."""
    ends = [f"{value:.{digits}f}" for value in (min(values), max(values))]
    return " to ".join(dict.fromkeys(ends))


def write(text, output):
    """Writes a page; - is stdout."""
    if str(output) == "-":
        print(text, end="")
    else:
        output.write_text(text)
