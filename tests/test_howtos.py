"""The how-to pages for developers work: their blocks are applied to a copy of the checkout and run."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

PAGES = ("add-a-metric", "add-a-part", "add-a-kind-of-job", "add-a-reader", "profile-a-recovery")
"""Pages of docs/howto whose blocks are marked."""

BLOCK = re.compile(r"^```(\w+)(?: file=(\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
"""A fence with a language, and for a new file its path from the checkout's root."""

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


@dataclass(frozen=True)
class Block:
    """Describe a fenced block of a page.

    Attributes:
        language: `python` (a new file), `diff` (a change of the tree) or `bash` (commands in the tree's root).
        file: Path of the new file from the tree's root; empty for other blocks.
        text: What stands between the fences.
    """

    language: str
    file: str
    text: str


def read_blocks(page: str) -> list[Block]:
    """Read the blocks of a page in order; a fence that begins none of the three kinds is refused."""
    text = (ROOT / "docs" / "howto" / f"{page}.md").read_text(encoding="utf-8")
    blocks = [Block(language, file or "", inside) for language, file, inside in BLOCK.findall(text)]
    assert 2 * len(blocks) == len(re.findall(r"^ *```", text, re.MULTILINE)), "a fence is open, or has another mark"
    assert all(block.language in ("diff", "bash") or block.file for block in blocks)
    return blocks


def apply_diff(text: str, root: Path, *options: str) -> None:
    """Apply a diff to a tree; its context must agree to the letter, or it could land elsewhere."""
    command = ["patch", "-p1", "--force", "--fuzz=0", *options]
    done = subprocess.run(command, cwd=root, input=text, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def list_tracked_files() -> list[str]:
    """Return the paths of the checkout's tracked files that are there."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True)
    return [name for name in listed.stdout.split("\0") if (ROOT / name).is_file()]


def copy_checkout(root: Path) -> None:
    """Copy the tracked files of the checkout as they are now."""
    for name in list_tracked_files():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, root / name)


def run_commands(commands: str, root: Path) -> subprocess.CompletedProcess[str]:
    """Run commands in a tree that is the package `garmentq`, up to the first that fails."""
    own = {name: value for name, value in os.environ.items() if not name.startswith(("GARMENTQ_", "PYTEST_"))}
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", os.defpath)])
    home = {"PATH": path, "PYTHONPATH": str(root.parent), "GARMENTQ_HOME": str(root.parent / "home")}
    return subprocess.run(
        ["bash", "-euo", "pipefail", "-c", commands],
        cwd=root, env=own | dict.fromkeys(THREADS, "1") | home, capture_output=True, text=True, check=False,
    )  # fmt: skip


def apply_block(block: Block, root: Path) -> None:
    """Do what a block says."""
    if block.file:
        path = root / block.file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(block.text, encoding="utf-8")
    elif block.language == "diff":
        apply_diff(block.text, root)
    else:
        done = run_commands(block.text, root)
        assert done.returncode == 0, f"{block.text}\n{done.stdout}\n{done.stderr}"


@pytest.mark.parametrize("page", PAGES)
def test_a_page_fits_the_tree(page: str) -> None:
    """Broken where code that a page changes was changed and the page was not, or a page has no step or no proof."""
    blocks = read_blocks(page)
    assert [block for block in blocks if block.file or block.language == "diff"]
    assert blocks[-1].language == "bash"
    assert not {block.file for block in blocks} & set(list_tracked_files())
    if diffs := [block.text for block in blocks if block.language == "diff"]:
        apply_diff("".join(diffs), ROOT, "--dry-run")


@pytest.mark.nightly
@pytest.mark.parametrize("page", PAGES)
def test_a_page_works(page: str, tmp_path: Path) -> None:
    """Broken where a step of a page fails, or its last commands succeed without the steps before them."""
    root = tmp_path / "garmentq"
    copy_checkout(root)
    blocks = read_blocks(page)
    assert run_commands(blocks[-1].text, root).returncode != 0, "the last block proves nothing"
    try:
        for block in blocks:
            apply_block(block, root)
    finally:
        run_commands("test ! -d out/home || garmentq down --home out/home", root)
