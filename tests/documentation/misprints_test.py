#!/usr/bin/env python3
"""Each entry of docs/misprints.md names tests that exist, or says why it has none; who cites an entry cites one that is there.

misprints_test.py CTEST BUILD: the tests are those that `CTEST --test-dir BUILD -N` lists.
"""
import pathlib
import re
import sys

sys.dont_write_bytecode = True
from bad_data_test import listed_tests

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/misprints.md"
SOURCES = ("include", "src", "tests", "bench", "examples", "docs")


def entries_of_page():
    """The last column of each entry by its number."""
    rows = [line.strip("|").split("|") for line in PAGE.read_text(encoding="utf-8").splitlines()
            if re.match(r"\| [A-Z]\d+ \|", line)]
    return [(row[0].strip(), row[-1].strip(), len(row)) for row in rows]


def citations():
    """(file, number) for all of "misprints.md, G1" and "misprints.md, G1, T2" in the sources."""
    for file in (file for folder in SOURCES for file in sorted((ROOT / folder).rglob("*"))):
        if file.suffix in (".hpp", ".cpp", ".md", ".toml") and file != PAGE:
            text = re.sub(r"\s*\n\s*(?:(?://|#)\s*)?", " ", file.read_text(encoding="utf-8"))  # over line breaks
            for numbers in re.findall(r"misprints\.md\)?,? ([A-Z]\d+(?:(?:,| and| to) [A-Z]\d+)*)", text):
                for number in re.findall(r"[A-Z]\d+", numbers):
                    yield file.relative_to(ROOT), number


def main():
    ctest, build = sys.argv[1:]
    known, entries, cited = listed_tests(ctest, build), entries_of_page(), list(citations())
    numbers = [number for number, _, _ in entries]
    expected = [f"{letter}{n}" for letter in dict.fromkeys(number[0] for number in numbers)
                for n in range(1, 1 + sum(number[0] == letter for number in numbers))]
    wrong = [f"{number} has {columns} columns, not 5" for number, _, columns in entries if columns != 5]
    wrong += [f"entries are not numbered in order: {numbers}"] if numbers != expected else []
    tests = [(number, name) for number, last, _ in entries for name in re.findall(r"`([^`]+)`", last)]
    wrong += [f"no such test: {name} ({number})" for number, name in tests if name not in known]
    with_tests = {number for number, _ in tests}
    wrong += [f"{number} has neither a test nor 'no test: ' and a reason" for number, last, _ in entries
              if number not in with_tests and not re.match(r"no test: \w", last)]
    wrong += [f"{file} cites {number}, which docs/misprints.md does not have" for file, number in cited if number not in numbers]
    if not entries or not known or not cited:
        wrong.append(f"{len(entries)} entries, {len(known)} tests and {len(cited)} citations were found")
    print("\n".join(wrong) if wrong else f"{len(entries)} entries, {len(with_tests)} with tests, {len(cited)} citations")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
