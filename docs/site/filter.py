#!/usr/bin/env python3
"""What Doxygen reads in the place of a file, so that headers and pages are written for people and not for it.

filter.py FILE, the INPUT_FILTER of docs/site/Doxyfile:
    *.hpp   the comment before a declaration becomes its documentation, the one that opens the file that of the file;
            lines that are set in (formulas, tables) stay as they are; what is in a namespace `detail` is left out
    *.md    links between pages, to sections, headers and examples become those of the site
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]

# ---- Headers ------------------------------------------------------------------------------------------------------

SCOPE = re.compile(r"(template .*)?(class|struct|union|enum)\b")


def escaped(text):
    """Prose without the signs that are commands, HTML or emphasis to Doxygen."""
    return re.sub(r"([\\@#<>&*`])", lambda sign: {"<": "&lt;", ">": "&gt;", "&": "&amp;", "*": "&lowast;", "`": "`"}
                  .get(sign[1], "\\" + sign[1]), text)


def documentation(lines, indent, opening=""):
    """The lines of a comment, without their slashes, as one of Doxygen's."""
    out, block, fence, item, blank = [], False, False, None, 0
    lead = " " * indent + "///"

    def close():
        nonlocal block, blank
        if block:
            out.append(f"{lead} @endcode")
        out.extend([lead] * blank)
        block, blank = False, 0

    if opening:
        out.append(f"{lead} {opening}")
    for text in lines:
        depth = len(text) - len(text.lstrip())
        if text.strip().startswith("```"):
            close()
            fence = not fence
            out.append(f"{lead} " + ("@code{.cpp}" if fence else "@endcode"))
            continue
        if fence:
            out.append(f"{lead} {text}")
            continue
        if not text.strip():
            blank += 1
            continue
        is_item = text.strip().startswith("- ")
        if is_item:
            item = depth
        elif item is not None and depth != item + 2:
            item = None
        if depth >= 2 and item is None:
            if block:
                out.extend([lead] * blank)
                blank = 0
            else:
                close()
                out.append(f"{lead} @code{{.unparsed}}")
            block = True
            out.append(f"{lead} {text}")
            continue
        close()
        out.append(f"{lead} {escaped(text)}".rstrip())
    close()
    return out


def header(text):
    """The file with its comments as documentation. Layout says where a declaration stands: a scope's members are set in by
    two columns more than the scope."""
    lines = text.split("\n")
    out = []
    at = 0
    while at < len(lines) and lines[at].startswith("//"):
        at += 1
    name = sys.argv[1].split("/include/")[-1]
    out += documentation([line[2:].removeprefix(" ") for line in lines[:at]], 0, f"@file {name}")
    scopes, hidden = [], False  # the columns of the scopes that are open; within a namespace detail
    while at < len(lines):
        line = lines[at]
        indent = len(line) - len(line.lstrip())
        if re.match(r"namespace ([\w:]*::)?detail\b.*{$", line):
            hidden = True
        if hidden:
            hidden = not line.startswith("}  // namespace")
            out.append("" if hidden or "detail" in line else line)
            at += 1
            continue
        while scopes and indent <= scopes[-1] and line.strip() and not re.match(r"\s*(requires|//|&&)", line):
            scopes.pop()
        level = scopes[-1] + 2 if scopes else 0
        if line.strip().startswith("//") and indent == level:
            end = at
            while end < len(lines) and lines[end].strip().startswith("//"):
                end += 1
            following = lines[end].strip() if end < len(lines) else ""
            comment = [each.strip()[2:].removeprefix(" ") for each in lines[at:end]]
            if following and not re.match(r"(}|#|namespace|friend class|public:|private:|static_assert)", following) and \
                    not comment[0].startswith("---"):
                out += documentation(comment, indent)
            else:
                out += [""] * (end - at)
            at = end
            continue
        if indent == level and SCOPE.match(line.strip()) and line.endswith("{"):
            scopes.append(indent)
        elif indent == level and line.endswith("{") and re.match(r"\s*(requires|&&|})", line) and \
                any(SCOPE.match(each.strip()) for each in lines[max(0, at - 3):at + 1]):
            scopes.append(indent)
        elif indent == level and re.search(r"\bstruct \w+(<.*>)? {$", line):
            scopes.append(indent)
        trailing = re.match(r"(\s*\S.*[;,]|\s*\w+(?: = \S+)?)\s+// (.*)$", line)
        if trailing and indent == level and scopes and not line.strip().startswith("//"):
            line = f"{trailing[1]}  ///< {escaped(trailing[2])}"
        out.append(line)
        at += 1
    return "\n".join(out)


# ---- Pages --------------------------------------------------------------------------------------------------------


def page_name(path):
    return "page_" + re.sub(r"\W", "_", str(path.relative_to(ROOT).with_suffix("")).removeprefix("docs/"))


def slug(heading):
    """As GitHub makes the anchor of a heading."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def link(page, text, target):
    if re.match(r"[a-z]+:", target):
        return f"[{text}]({target})"
    place, _, section = target.partition("#")
    path = (page.parent / place).resolve() if place else page
    relative = path.relative_to(ROOT)
    if path.suffix == ".md" and relative.parts[0] in ("docs", "README.md", "CONTRIBUTING.md"):
        if section:
            return f"[{text}](@ref {page_name(path)}-{section})"
        return f"[{text}](@ref {'index' if relative == pathlib.Path('docs/index.md') else page_name(path)})"
    if path.suffix == ".hpp":
        return f"[{text}](@ref {relative.relative_to('include')})"
    if relative.parts[0] == "examples" and path.suffix == ".cpp":
        return f'<a href="{path.stem}_8cpp-example.html">{text}</a>'
    return f"{text} (`{relative}`)" if text != str(relative) else f"`{text}`"


def page(text):
    path = pathlib.Path(sys.argv[1]).resolve()
    # The words of a link on one line.
    text = re.sub(r"\[[^][]*\]\([^()`]*\)", lambda each: re.sub(r"\s+", " ", each[0]), text)
    name, out, fence, first = page_name(path), [], False, True
    for line in text.split("\n"):
        if line.startswith("```"):
            fence = not fence
            language = line[3:].split(" ")[0]
            out.append("```" + {"cpp": "{.cpp}", "sh": "{.unparsed}", "text": "{.unparsed}", "cmake": "{.unparsed}", "toml": "{.unparsed}", "":
                                "{.unparsed}"}.get(language, "{." + language + "}") if fence else "```")
            continue
        if fence or line.startswith("    "):
            out.append(line)
            continue
        heading = re.match(r"(#+) (.*)$", line)
        if heading:
            anchor = name if first else f"{name}-{slug(heading[2])}"
            out.append(f"{line} {{#{anchor}}}")
            first = False
            continue
        line = re.sub(r"!\[([^]]*)\]\(([^)]*)\)", lambda m: f"![{m[1]}]({pathlib.PurePath(m[2]).name})", line)
        line = re.sub(r"(`[^`]*`)|(?<!!)\[((?:`[^`]*`|[^]`])+)\]\(([^)\s]+)\)",
                      lambda each: each[1] or link(path, each[2].replace("`", ""), each[3]), line)
        out.append(line)
    return "\n".join(out)


def main():
    text = pathlib.Path(sys.argv[1]).read_text(encoding="utf-8")
    print(header(text) if sys.argv[1].endswith(".hpp") else page(text))


if __name__ == "__main__":
    main()
