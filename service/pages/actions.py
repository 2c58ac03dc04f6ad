"""Buttons and forms of the pages of libraries and administration, which one script sends."""

from __future__ import annotations

from .markup import Html, html

DIALOG = """<dialog id="dialog" aria-labelledby="dialog-title"><form method="dialog"><h2 id="dialog-title"></h2>
<p id="dialog-text"></p><p id="dialog-field"><label><span></span> <input maxlength="255"></label></p>
<p id="dialog-format" hidden><label>Format <select>{formats}</select></label></p>
<p class="row"><button value="yes" class="primary"></button><button value="" formnovalidate>Back</button></p></form>
</dialog>"""
"""The dialog of `dialog.js`."""

OUTCOME = """<div id="outcome" role="status"></div>"""
"""Place where the script writes what was answered."""


def draw_action(name: str, method: str, url: str, question: str = "", after: str = "") -> Html:
    """Return a button that sends a request, a question first if there is one; `after` is the page that follows."""
    question_attribute = html(' data-question="{}"', question) if question else Html()
    look = Html(' class="danger"') if method == "DELETE" else Html()
    follows = html(' data-after="{}"', after) if after else Html()
    button = '<button type="button" data-send="{} {}"{}{}{}>{}</button>'
    return html(button, method, url, question_attribute, follows, look, name)


def draw_frame() -> Html:
    """Return the dialog and the place of the outcome."""
    return html("{}{}", html(OUTCOME), html(DIALOG, formats=Html()))
