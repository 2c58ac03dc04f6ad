"""Map the repository root onto the package `garmentq` and list its sub-packages by rule, not by hand."""

from setuptools import find_namespace_packages, setup

ROOMS = ("core", "service", "workers", "cli", "migrations")
DATA = ["*.npz", "*.json", "*.html", "*.css", "*.js", "*.svg", "*.txt", "*.mako", "*.ini", "py.typed"]

packages = ["garmentq"] + [
    f"garmentq.{name}"
    for name in find_namespace_packages(".")
    if name.split(".")[0] in ROOMS and "__pycache__" not in name
]

setup(packages=packages, package_data=dict.fromkeys(packages, DATA))
