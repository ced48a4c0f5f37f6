"""The pages of the project as tests see them: code blocks, inline code, headings and links."""
import pathlib, re, typing

root = pathlib.Path(__file__).resolve().parent.parent.parent


class Block(typing.NamedTuple):
    page: str      # relative to the root
    line: int      # of the first line of code
    language: str
    code: str

    def __str__(self):
        return f"{self.page}:{self.line}"


def pages():
    """All pages of the project, relative to the root."""
    found = [page for folder in ("", "docs", "docs/measured") for page in (root / folder).glob("*.md")]
    found += [page for folder in ("bindings", "contrib", "gltf_ext", "third_party") for page in (root / folder).rglob("*.md")]
    return sorted(name for page in found if "node_modules" not in (name := page.relative_to(root).as_posix()))


def text_of(page):
    return (root / page).read_text(encoding="utf-8")


def blocks(page):
    text = text_of(page)
    found = re.finditer(r"^( *)```(\w*)\n(.*?)^\1```$", text, re.M | re.S)
    return [Block(page, text.count("\n", 0, match.start(3)) + 1, match[2], re.sub(f"^{match[1]}", "", match[3], flags=re.M)) for match in found]


def prose(page):
    """The page without code blocks, whose lines stay, empty."""
    return re.sub(r"^( *)```.*?^\1```$", lambda match: "\n" * match.group().count("\n"), text_of(page), flags=re.M | re.S)


def inline_code(page):
    """(line, code) of each `code`."""
    text = prose(page)
    return [(text.count("\n", 0, match.start()) + 1, " ".join(match[1].split())) for match in re.finditer(r"`([^`]+)`", text)]


def anchors(page):
    """The anchors of headings as GitHub makes them, and the ids and names in HTML."""
    found = set(re.findall(r'<a (?:id|name)="([^"]+)"', text_of(page)))
    for heading in re.findall(r"^#{1,6} (.*)$", prose(page), re.M):
        name = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        name = re.sub(r"[^\w\- ]", "", name).replace(" ", "-")
        i = 0
        while (numbered := f"{name}-{i}" if i else name) in found:
            i += 1
        found.add(numbered)
    return found
