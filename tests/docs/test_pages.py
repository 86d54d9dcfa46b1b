"""The documents, executed: every command and every Python block in them runs, every path and option in them exists."""

from __future__ import annotations

import argparse
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from pages import PAGES, ROOT, blocks

from beadband import parameters
from beadband.cli import build_parser, main, reference
from beadband.lammps.engine import program
from beadband.model import laws  # noqa: F401  a law adds its constants to the table

ELSEWHERE = {
    "python3 -m venv": "installs: the test command itself is what runs the tests, on a fresh environment",
    "mpirun": "two ranks: tests/runs/test_release.py",
    "beadband sweep --executor": "needs an engine: tests/studies/test_engines.py",
    "python docs/ovito_render.py": "needs OVITO: test_docs.py",
}
"""How commands begin that are not executed here, and why."""
OWN_TEST = {"extending.md": "test_extending.py, in processes of their own that load the plug-ins"}


@pytest.mark.parametrize("page", [page for page in PAGES if page.name not in OWN_TEST], ids=lambda page: page.stem)
def test_commands_and_python_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The blocks of a page in order, in one folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "data").symlink_to(ROOT / "docs" / "data")
    for block in blocks(page):
        assert block.language in ("sh", "python", "toml", "text"), block
        if block.file:
            Path(block.file).write_text(block.text, encoding="utf-8")
        elif block.language == "python":
            exec(compile(block.text, page.name, "exec"), {"__name__": "block"})
        for line in block.text.splitlines() if block.language == "sh" else ():
            if not line.startswith(tuple(ELSEWHERE)):
                command(shlex.split(line), monkeypatch)


def command(words: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """One line of a block, as a shell would run it."""
    if words[0] == "cd":
        monkeypatch.chdir(words[1])
    elif words[0] == "beadband":
        assert main(words[1:]) == 0, words
    else:
        found = program(words[0])
        assert found, words
        subprocess.run([found, *words[1:]], check=True, capture_output=True)


def subcommands() -> dict[str, argparse.ArgumentParser]:
    """The parser of each command."""
    (action,) = (one for one in build_parser()._actions if isinstance(one, argparse._SubParsersAction))
    return dict(action.choices)


def inline(page: Path) -> Iterator[str]:
    """What a page says in code within its sentences."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    yield from (" ".join(found.split()) for found in re.findall(r"`([^`]+)`", text))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_what_a_page_names_exists(page: Path) -> None:
    """Links and paths lead somewhere; commands and options are known ones."""
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", text):
        assert target.startswith("https://") or (page.parent / target).exists(), target
    parsers = subcommands()
    known = {one.flag for one in parameters.TABLE.values()} | {"--scene", "--grid", "--print-completion"}
    known |= {flag for parser in parsers.values() for one in parser._actions for flag in one.option_strings}
    for code in inline(page):
        if re.fullmatch(r"(beadband|tests|docs|lmp_inputs|analysis)/[\w./]*\w\.\w+", code):
            assert (ROOT / code).is_file(), code
        words = code.split()
        if words[0] == "beadband" and len(words) > 1:
            assert words[1] in parsers or words[1] in known, code
        if words[0] in ("beadband", "run") or code.startswith("--"):
            assert set(re.findall(r"--[a-z][\w-]*", code)) <= known, code


def test_the_front_page_is_short() -> None:
    """A screen and a half of text; what a page says better stands there."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE).split()) < 500
    assert "docs/commands.md" in text


def test_the_continuous_test_finds_its_command() -> None:
    """.ci/run takes the line from the front page."""
    assert len(re.findall(r"^python3 -m venv .*pytest$", (ROOT / "README.md").read_text(), re.MULTILINE)) == 1


def test_the_reference_pages_are_current(tmp_path: Path) -> None:
    """What ``make docs`` writes; in a process of its own, without what other tests have registered."""
    subprocess.run([sys.executable, "-m", "beadband.reporting.documents", str(tmp_path)], check=True)
    for path in tmp_path.iterdir():
        assert (ROOT / "docs" / path.name).read_text(encoding="utf-8") == path.read_text(encoding="utf-8"), "make docs"
    assert (ROOT / "docs" / "commands.md").read_text(encoding="utf-8") == reference(), "make docs"
