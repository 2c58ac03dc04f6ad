"""Sentences of errors in words of a page: controls and pages in place of options and commands of a terminal."""

from __future__ import annotations

import re

CONTROLS = {
    "as": "The scan is", "body": "Body", "labels": "Labels", "wearing": "Wearing", "template": "Template",
    "units": "Unit", "unit": "Unit", "up": "Up axis", "height": "Height", "fabric": "Fabric", "method": "Method",
    "vertices": "Quality", "redrape": "Re-drape", "paper": "Paper",
}  # fmt: skip
"""Labels of the controls that stand for options; any other option is named by its own word."""

COMMANDS = {
    "status": "the list of jobs",
    "retry": "Try again",
    "cancel": "Cancel",
    "export": "the result's page",
    "keys": "the page Keys",
    "templates": "the page Base patterns",
    "materials": "the page Fabrics",
    "webhooks": "the page Webhooks",
}
"""What of the pages stands for a command; any other one is the operator's."""

COMMAND = re.compile(r"`garmentq ([a-z]+)[^`]*`")
OPTION = re.compile(r"(?<![\w-])--([a-z]+(?:-[a-z]+)*)")


def speak_of_controls(message: str) -> str:
    """Return a sentence that names controls and pages where it named options and commands."""
    said = COMMAND.sub(lambda found: COMMANDS.get(found[1], "the operator's program"), message)
    return OPTION.sub(lambda found: f"the option {_name_control(found[1])}", said)


def _name_control(option: str) -> str:
    return CONTROLS.get(option, option.replace("-", " ").capitalize())
