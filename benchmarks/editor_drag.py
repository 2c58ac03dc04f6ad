"""Measure how long the editor takes from a pointer's movement to the next frame, with WebGL and drawing by software.

    garmentq serve --home H --port 8080 &
    python benchmarks/editor_drag.py http://127.0.0.1:8080 H/api.token

For each template a control point is dragged sixty times, 30 ms apart; seams and symmetry are kept. Printed are the
median and the 95th percentile [ms] of the time until the frame that shows the movement has been drawn, and of the CPU
time that the page's thread spends on one movement (scripts, styles, layout, drawing), which other programs on the
machine lengthen little.
"""

from __future__ import annotations

import argparse
import shutil
import statistics
from pathlib import Path

from playwright.sync_api import CDPSession, Page, sync_playwright

FLAGS = ("--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader")
TEMPLATES = ("tshirt", "dress")
LAYERS = ("between", "within", "difference", "possible")
"""Layers that are drawn too in the second row of each template."""

DRAG = """async () => {
    const board = document.querySelector('#board'), { session } = document.querySelector('#editor');
    const dot = document.querySelector('[data-panel="front"] [data-point="2"]');
    const place = new DOMPoint(...dot.getAttribute('d').match(/-?[0-9.]+/g).slice(0, 2).map(Number));
    const start = place.matrixTransform(dot.getScreenCTM());
    board.setPointerCapture = () => {};
    const send = (type, by) => board.dispatchEvent(new PointerEvent(type, {
        clientX: start.x + by, clientY: start.y + by, pointerId: 1, pointerType: 'mouse', altKey: true, bubbles: true,
    }));
    const drawn = () => new Promise((done) => requestAnimationFrame(() => {
        const { port1, port2 } = new MessageChannel();
        port1.onmessage = done;
        port2.postMessage(0);
    }));
    const answers = [];
    send('pointerdown', 0);
    for (let step = 1; step <= 60; step += 1) {
        await new Promise((done) => setTimeout(done, 30));
        const begun = performance.now();
        send('pointermove', 4 + step / 2);
        await drawn();
        answers.push(performance.now() - begun);
    }
    send('pointerup', 34);
    session.undo();
    return answers;
}"""

MOVE = """async (step) => {
    const { session } = document.querySelector('#editor'), by = [step * 1e-4, step * 1e-4];
    const { moveItems } = await import('/static/edit/movement.js');
    session.preview(moveItems(session.present, [{ item: { panel: 'front', point: 2 }, by }], session.keep));
    await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
}"""
"""One movement, shown in the next frame."""


def measure(page: Page, template: str, layers: tuple[str, ...]) -> str:
    """Return a line of the table."""
    page.goto(f"/templates/{template}/edit")
    page.locator("#said", has_text="Ready.").wait_for()
    for layer in layers:
        page.check(f"[data-option={layer}]")
    watch = page.context.new_cdp_session(page)
    watch.send("Performance.enable", {"timeDomain": "threadTicks"})
    found = []
    for times in (page.evaluate(DRAG), [move(page, watch, step) for step in range(1, 61)]):
        found.append(f"{statistics.median(times):5.1f} {statistics.quantiles(times, n=20)[-1]:5.1f}")
    return f"{template:8} {'all layers' if layers else 'plain':10}  to the frame {found[0]}  CPU {found[1]}"


def move(page: Page, watch: CDPSession, step: int) -> float:
    """Move the point once more; give the CPU time [ms]."""
    before = read_cpu(watch)
    page.evaluate(MOVE, step)
    return 1e3 * (read_cpu(watch) - before)


def read_cpu(watch: CDPSession) -> float:
    """Return the CPU seconds that the page's thread has spent on tasks."""
    return next(
        one["value"] for one in watch.send("Performance.getMetrics")["metrics"] if one["name"] == "TaskDuration"
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Measure the editor's answer to a drag.")
    parser.add_argument("url", help="where garmentq serves")
    parser.add_argument("token", type=Path, help="the file api.token of its home")
    given = parser.parse_args()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=list(FLAGS))
        context = browser.new_context(base_url=given.url, viewport={"width": 1280, "height": 900})
        context.request.post("/signin", form={"token": given.token.read_text().strip()})
        page = context.new_page()
        for template in TEMPLATES:
            for layers in ((), LAYERS):
                print(measure(page, template, layers))
        browser.close()


if __name__ == "__main__":
    main()
