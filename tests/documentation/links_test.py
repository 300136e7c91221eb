#!/usr/bin/env python3
"""Links of the Markdown pages lead to files and sections that are there; no page and no example is left out.

links_test.py            the pages of the source tree
links_test.py --site DIR the pages of the guide that scripts/site has made of them

The network is not asked: links with a scheme (https:) are passed over.
"""
import pathlib
import re
import sys
from urllib.parse import unquote

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "examples").rglob("*.md")]


def prose(path):
    """The text without code."""
    text = re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    return re.sub(r"`[^`\n]*`", lambda code: re.sub(r"[][()]", "", code[0]), text)


def sections(path):
    """The anchors of the headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.*)$", prose(path), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def links(path):
    for target in re.findall(r"\]\(\s*([^()\s]+)\s*\)", prose(path)):
        if not re.match(r"[a-z]+:", target):
            place, _, section = target.partition("#")
            yield target, (path.parent / unquote(place)).resolve() if place else path, section


def check_sources():
    wrong, count, linked = [], 0, {}
    for page in PAGES:
        linked[page] = set()
        for target, path, section in links(page):
            count += 1
            linked[page].add(path)
            name = f"{page.relative_to(ROOT)}: {target}"
            if not path.exists():
                wrong.append(f"{name}: no such file")
            elif section and (path.suffix != ".md" or section not in sections(path)):
                wrong.append(f"{name}: no such section")
    index = ROOT / "docs/index.md"
    for page in (ROOT / "docs").rglob("*.md"):
        if page != index and page not in linked[index]:
            wrong.append(f"docs/index.md does not lead to {page.relative_to(ROOT)}")
    for example in (ROOT / "examples").rglob("*.cpp"):
        if example not in linked[ROOT / "docs/examples.md"]:
            wrong.append(f"docs/examples.md does not list {example.relative_to(ROOT)}")
    if count < 50:
        wrong.append(f"only {count} links were found")
    return wrong, f"{len(PAGES)} pages, {count} links"


def check_site(folder):
    wrong, count, anchors = [], 0, {}
    pages = sorted(folder.glob("*.html"))
    texts = {page.name: page.read_text(encoding="utf-8", errors="replace") for page in pages}
    for name, text in texts.items():
        anchors[name] = set(re.findall(r'\b(?:id|name)="([^"]+)"', text))
    for name, text in texts.items():  # those of the guide: what the reference links to is Doxygen's affair
        if not re.match(r"page_|index", name):
            continue
        for target in re.findall(r'\b(?:href|src)="([^"]*)"', text):
            if re.match(r"[a-z]+:|$", target):
                continue
            count += 1
            place, _, section = target.partition("#")
            place = unquote(place) or name
            if not (folder / place).exists():
                wrong.append(f"{name}: {target}: no such file")
            elif section and place in anchors and section not in anchors[place]:
                wrong.append(f"{name}: {target}: no such place")
        if "@ref" in text or "\\ref " in text:
            wrong.append(f"{name}: a reference that was not understood")
    if len(pages) < 100:
        wrong.append(f"only {len(pages)} pages were found")
    return wrong, f"{len(pages)} pages, {count} links"


def main():
    wrong, found = check_site(pathlib.Path(sys.argv[2])) if sys.argv[1:2] == ["--site"] else check_sources()
    print("\n".join(wrong) if wrong else found)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
