"""The editor's page in a browser, driven as a person does."""

from __future__ import annotations

import numpy as np
from garmentq.core.garment.curves import edge_length
from garmentq.core.garment.garmentcode import read_pattern


class Editor:
    """Drive the page as a person does, and read what it holds."""

    def __init__(self, page):
        self.page = page

    def file(self) -> dict:
        """Return the pattern as it would be written now."""
        return self.module("pattern_model", "patternFile(session.present)")

    def text(self) -> str:
        """Return the text that a download would have."""
        return self.module("pattern_model", "writePattern(session.present)")

    def module(self, name: str, what: str):
        """Return what a function of a module gives for the session."""
        call = f"const {{ session }} = document.querySelector('#editor'); return module.{what}"
        return self.page.evaluate(f"async () => {{ const module = await import('/static/edit/{name}.js'); {call}; }}")

    def pattern(self):
        """Return the present pattern as core reads it."""
        return read_pattern(self.file())

    def settle(self) -> None:
        """Wait until what was asked for is drawn."""
        frames = "requestAnimationFrame(() => requestAnimationFrame(done))"
        self.page.evaluate(f"() => {{ scrollTo(0, 0); return new Promise((done) => {frames}); }}")

    def place(self, panel: str, point: int) -> tuple[float, float]:
        """Return where a control point is on the screen [px]."""
        self.settle()
        return tuple(
            self.page.evaluate(
                """([panel, point]) => {
                    const dot = document.querySelector(`[data-panel="${panel}"] [data-point="${point}"]`);
                    const at = new DOMPoint(...dot.getAttribute('d').match(/-?[0-9.]+/g).slice(0, 2).map(Number));
                    const seen = at.matrixTransform(dot.getScreenCTM());
                    return [seen.x, seen.y];
                }""",
                [panel, point],
            )
        )

    def scale(self) -> float:
        """Return how many mm a pixel of the board is."""
        return 1.0 / self.page.evaluate("document.querySelector('#board').getScreenCTM().a")

    def drag(self, start, by, keys: str = "") -> None:
        """Drag from a place by pixels."""
        mouse = self.page.mouse
        if keys:
            self.page.keyboard.down(keys)
        mouse.move(*start)
        mouse.down()
        mouse.move(start[0] + by[0] / 2, start[1] + by[1] / 2)
        mouse.move(start[0] + by[0], start[1] + by[1])
        mouse.up()
        if keys:
            self.page.keyboard.up(keys)

    def press(self, *keys: str) -> None:
        """Press keys on the board."""
        self.page.locator("#board").focus()
        for key in keys:
            self.page.keyboard.press(key)

    def choose(self, panel: str, *points: int) -> None:
        """Click control points, all but the first with Shift."""
        for number, point in enumerate(points):
            x, y = self.place(panel, point)
            with_shift = number > 0
            if with_shift:
                self.page.keyboard.down("Shift")
            self.page.mouse.click(x, y)
            if with_shift:
                self.page.keyboard.up("Shift")

    def selection(self) -> list[dict]:
        """Return what is selected."""
        return self.page.evaluate("document.querySelector('#editor').session.selection")

    def command(self, name: str) -> None:
        """Click a button of the tool bar."""
        self.page.click(f'[data-command="{name}"]')


def moved(before, after) -> dict[tuple[str, int], np.ndarray]:
    """Return the control points that are elsewhere, and by how much [m]."""
    return {
        (panel.name, k): new - old
        for panel in before.panels
        for k, (old, new) in enumerate(zip(panel.points, after.panel(panel.name).points, strict=True))
        if np.abs(new - old).max() > 1e-9
    }


def lengths(pattern) -> np.ndarray:
    """Return the length of each panel's outline [m], shape [panel_count]."""
    return np.array([sum(edge_length(panel, k) for k in range(len(panel.edges))) for panel in pattern.panels])
