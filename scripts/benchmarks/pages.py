"""Pages of docs/measured, each of which a script writes as a whole: what was found, how it was measured, and tables."""
import datetime, os, pathlib, shlex, sys

from benchmarks.programs import processor_name

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


def page(title, findings, sections, spreads, words=None, today=None, processor=None):
    """The text of a page. `findings`: sentences, of which the first says where a rival wins. `sections`: lines of Markdown. `words`:
    the script and its arguments."""
    words = sys.argv if words is None else words
    shown = [pathlib.Path(word).name if os.path.isabs(word) else word for word in words[1:]]
    command = shlex.join([f"scripts/{pathlib.Path(words[0]).name}", *shown])
    date = (today or datetime.date.today()).strftime("%-d %B %Y")
    how = (f"`{command}` wrote this page on {date}, measured on \"{processor or processor_name()}\" with {os.cpu_count()} processors. "
           f"{noise(spreads)}")
    return "\n".join([f"# {title}", "", " ".join(findings), "", how.rstrip(), "", *sections]) + "\n"
