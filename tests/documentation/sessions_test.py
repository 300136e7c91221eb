#!/usr/bin/env python3
"""Sessions in the pages, blocks marked `text` whose first line is "$ recon...", print what stands there.

sessions_test.py FOLDER: that of the programs. A line "..." stands for any number of lines.
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]


def sessions():
    """(page, line, commands with the lines that each prints)"""
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        text = page.read_text(encoding="utf-8")
        for block in re.finditer(r"^```text\n(\$ recon.*?)^```", text, flags=re.DOTALL | re.MULTILINE):
            commands = []
            for line in block[1].splitlines():
                if line.startswith("$ "):
                    commands.append((line[2:], []))
                else:
                    commands[-1][1].append(line)
            yield page.relative_to(ROOT), text.count("\n", 0, block.start()) + 2, commands


def matches(expected, printed):
    pattern = "".join(r"(?:.*\n)*" if line == "..." else re.escape(line) + r"\n" for line in expected)
    return re.fullmatch(pattern, printed)


def main():
    environment = dict(os.environ, PATH=sys.argv[1] + os.pathsep + os.environ["PATH"])
    wrong, count = 0, 0
    for page, line, commands in sessions():
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "examples").symlink_to(ROOT / "examples")
            for command, expected in commands:
                count += 1
                printed = subprocess.run(command, shell=True, cwd=folder, env=environment, text=True,
                                         stdout=subprocess.PIPE, stderr=subprocess.STDOUT).stdout
                # How far it is, which it says where it is slow.
                printed = re.sub(r"^[a-z ]+: +\d+ %, about \d+ s left\n", "", printed, flags=re.MULTILINE)
                if not matches(expected, printed):
                    wrong += 1
                    print(f"{page}:{line}: {command}\nprints\n{printed}", flush=True)
    print(f"{count} commands, {wrong} print something else")
    return 1 if wrong or count < 4 else 0


if __name__ == "__main__":
    sys.exit(main())
