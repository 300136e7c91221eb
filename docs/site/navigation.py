#!/usr/bin/env python3
"""navigation.py FOLDER writes what the site's side bar shows, layout.xml, and examples.dox, which lists the examples.

The guide is what docs/index.md links to, in its order.
"""
import pathlib
import re
import subprocess
import sys
from xml.sax.saxutils import quoteattr

sys.dont_write_bytecode = True
from filter import ROOT, page_name


def rooms():
    """The headers of each room, in the order of the rooms in CONTRIBUTING.md."""
    table = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").split("## The rooms", 1)[1].split("\n\n- ", 1)[0]
    names = re.findall(r"`(\w+)/`", "\n".join(line.split("|")[1] for line in table.splitlines() if line.startswith("|")))
    include = ROOT / "include/recon"
    assert sorted(names) == sorted(folder.name for folder in include.iterdir() if folder.is_dir()), names
    yield '<tab type="user" url="@ref recon/recon.hpp" title="recon.hpp"/>'
    for name in names:
        yield f'<tab type="usergroup" title="{name}">'
        for path in sorted((include / name).glob("*.hpp")):
            yield f'<tab type="user" url="@ref recon/{name}/{path.name}" title="{path.name}"/>'
        yield '</tab>'


def main():
    folder = pathlib.Path(sys.argv[1])
    index = ROOT / "docs/index.md"
    titles = {}  # by page: the words of the first link
    for text, target in re.findall(r"\[([^]]+)\]\(([^)#]+\.md)\)", index.read_text(encoding="utf-8")):
        titles.setdefault((index.parent / target).resolve(), text[0].upper() + text[1:])

    def tab(path):
        return f'<tab type="user" url="@ref {page_name(path)}" title={quoteattr(titles[path])}/>'

    tutorials = [path for path in titles if path.parent.name == "tutorials"]
    navigation = ['<tab type="mainpage" visible="yes" title="recon"/>', '<tab type="usergroup" title="Guide">']
    navigation += [tab(path) for path in titles if path not in tutorials]
    navigation += ['</tab>', '<tab type="usergroup" title="Tutorials">', *map(tab, tutorials), '</tab>']
    navigation += ['<tab type="examples" visible="yes" title="Examples" intro=""/>',
                   '<tab type="usergroup" title="Headers by room">', *rooms(), '</tab>',
                   '<tab type="classlist" visible="yes" title="Classes" intro=""/>',
                   '<tab type="namespacemembers" visible="yes" title="Functions and names" intro=""/>']
    layout = folder / "layout.xml"
    subprocess.run(["doxygen", "-l", layout], check=True, stdout=subprocess.DEVNULL)
    text = layout.read_text(encoding="utf-8")
    text = re.sub(r"<navindex>.*?</navindex>", lambda _: "<navindex>\n" + "\n".join(navigation) + "\n</navindex>", text,
                  flags=re.DOTALL)
    # What a header or a class is comes before the lists of what is in it.
    for kind in ("class", "file"):
        begin, end = text.index(f"<{kind}>"), text.index(f"</{kind}>")
        part = text[begin:end]
        description = re.search(r"\s*<detaileddescription [^>]*/>", part)[0]
        part = part.replace(description, "")
        part = re.sub(r"\s*<briefdescription [^>]*/>", lambda _: description, part)
        text = text[:begin] + part + text[end:]
    layout.write_text(text, encoding="utf-8")

    examples = []
    for path in sorted((ROOT / "examples").rglob("*.cpp")):
        examples.append(f"/** @example {path.name} */\n")
    (folder / "examples.dox").write_text("\n".join(examples), encoding="utf-8")


if __name__ == "__main__":
    main()
