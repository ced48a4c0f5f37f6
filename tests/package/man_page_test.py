#!/usr/bin/env python3
"""man_page_test.py PSPLIT PAGE: the manual page names every verb, and every option and argument of its --help."""
import re, shutil, subprocess, sys

psplit, page = sys.argv[1], sys.argv[2]
with open(page) as file:
    troff = file.read()
text = troff.replace("\\-", "-").replace("\\(dq", '"').replace("\\&", "").replace("\\e", "\\")
sections = dict(re.findall(r'^\.SH "?(.*?)"?\n(.*?)(?=^\.SH|\Z)', text, re.M | re.S))


def help_of(*words):
    return subprocess.run([psplit, *words, "--help"], capture_output=True, text=True, check=True).stdout


def missing(words, section):
    """Returns the options and arguments of the help that are no tags of paragraphs in the section, and all of the help."""
    tags = " ".join(re.findall(r'^\.B "(.*)"$', section, re.M))
    options = {option for line in words.splitlines() if re.match(r"  \S", line)
               for option in re.findall(r"(?<![\w-])--?[a-z][a-z-]*", re.split(r"\s{2,}", line.strip())[0])}
    return sorted(option for option in options if not re.search(rf"(?<![\w-]){re.escape(option)}(?![\w-])", tags)), options


overview = help_of()
summary = " ".join(overview.split("\n\n")[0].split())
if sections["NAME"].strip() != f"gltf-psplit - {summary}":
    sys.exit(f"{page}: NAME is not the first sentence of --help: {sections['NAME']}")
verbs = re.findall(r"^  ([a-z]+)\s", re.search(r"^Subcommands:\n((?:  .*\n)+)", overview, re.M).group(1), re.M)
seen = 0
for words, heading in [((), "DESCRIPTION")] + [((verb,), f"GLTF-PSPLIT {verb}") for verb in verbs]:
    if heading not in sections:
        sys.exit(f"{page} has no section {heading}")
    absent, options = missing(help_of(*words), sections[heading])
    if absent:
        sys.exit(f"{page}: {heading} lacks {', '.join(absent)}")
    seen += len(options)
if len(verbs) < 5 or seen < 40:
    sys.exit(f"only {len(verbs)} verbs and {seen} options were found in --help")
if shutil.which("groff"):
    said = subprocess.run(["groff", "-man", "-ww", "-z", "-K", "utf8", page], capture_output=True, text=True)
    if said.returncode != 0 or said.stderr:
        sys.exit(f"groff: {said.stderr}")
print(f"{len(verbs)} verbs, {seen} options")
