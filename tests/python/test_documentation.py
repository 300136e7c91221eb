"""Programs in the Markdown files: the ```python blocks of a page run one after the other, and a block ```text output
is what the one before it prints."""

from __future__ import annotations

import contextlib
import io
import pathlib
import re
import subprocess
import sys
from typing import Any

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = [
    page
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    if "\n```python\n" in page.read_text(encoding="utf-8")
]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.name))
def test_programs_of_a_page(page: pathlib.Path, tmp_path: pathlib.Path, monkeypatch: Any) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    text = page.read_text(encoding="utf-8")
    names: dict[str, Any] = {}
    printed: str | None = None
    run = 0
    for block in re.finditer(r"^```([^\n]*)\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE):
        line = text.count("\n", 0, block.start(2))
        if block[1] == "python":
            code = compile("\n" * line + block[2], str(page), "exec")
            with contextlib.redirect_stdout(io.StringIO()) as out:
                exec(code, names)
            run += 1
            printed = out.getvalue()
        else:
            if block[1] == "text output" and printed is not None:
                assert printed == block[2], f"{page}:{line + 1}"
            printed = None
    assert run == text.count("\n```python\n")


def test_the_gallery_is_made(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("matplotlib")
    subprocess.run(
        [sys.executable, ROOT / "examples" / "python" / "gallery.py", tmp_path], check=True, timeout=300
    )
    shown = set(re.findall(r"\(gallery/(\w+\.png)\)", (ROOT / "docs" / "gallery.md").read_text()))
    assert {path.name for path in tmp_path.glob("*.png")} == shown
    for name in shown:
        made = (tmp_path / name).read_bytes()
        assert made.startswith(b"\x89PNG") and len(made) > 5000
        assert (ROOT / "docs" / "gallery" / name).exists()


def test_every_name_has_a_text() -> None:
    import recon


    for module in (recon, recon.mpm, recon.plot):
        for name in module.__all__:
            if not name.startswith("_"):
                assert (getattr(module, name).__doc__ or "").strip(), f"{module.__name__}.{name}"
