"""The pictures of a result: sheets by their columns, each with its head, and bare bodies on demand only."""

from __future__ import annotations

from collections.abc import Sequence

from .contact_sheets import ContactSheet, find_contact_sheet
from .markup import Html, html, join
from .stored_files import Picture


def draw_pictures(base: str, pictures: Sequence[Picture], is_hidden: bool) -> Html:
    """Return the card with the pictures; empty if there are none.

    Args:
        base: Address below which they are sent, without `/pictures/N`.
        pictures: The pictures.
        is_hidden: Whether only a browser without WebGL shows them.
    """
    if not pictures:
        return Html()
    shown = []
    for number, one in enumerate(pictures):
        url, sheet = f"{base}/pictures/{number}", find_contact_sheet(one.title)
        shown.append(_draw_sheet(url, sheet) if sheet else _draw_figure(url, one.title))
    return html(CARD, hidden=Html(" hidden") if is_hidden else Html(), pictures=join(shown))


def _draw_sheet(url: str, sheet: ContactSheet) -> Html:
    shown = join(_draw_figure(f"{url}/{n}", head) for n, head in enumerate(sheet.heads) if n not in sheet.bare)
    bare = join(_draw_figure(f"{url}/{n}", sheet.heads[n]) for n in sheet.bare)
    return join([shown, html(BARE, pictures=bare)]) if sheet.bare else shown


def _draw_figure(url: str, title: str) -> Html:
    return html('<figure><figcaption>{}</figcaption><img src="{}" alt="{}" loading="lazy"></figure>', title, url, title)


CARD = """<section class="card" id="pictures"{hidden}><h2>Pictures</h2>
<div class="pictures">{pictures}</div></section>"""

BARE = """<details class="bare"><summary>Show body</summary>{pictures}</details>"""
