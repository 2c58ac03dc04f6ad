"""Map the repository root onto the package `garmentq` and list its sub-packages by rule, not by hand."""

from setuptools import find_namespace_packages, setup
from setuptools.command.build_py import build_py

ROOMS = ("core", "service", "workers", "cli", "migrations")
DATA = ["*.npz", "*.json", "*.html", "*.css", "*.js", "*.svg", "*.txt", "*.mako", "*.ini", "py.typed"]

packages = ["garmentq"] + [
    f"garmentq.{name}"
    for name in find_namespace_packages(".")
    if name.split(".")[0] in ROOMS and "__pycache__" not in name
]


class Build(build_py):
    """Leave this script out of the package whose folder it lies in."""

    def find_package_modules(self, package, package_dir):
        """List the modules of a package."""
        found = super().find_package_modules(package, package_dir)
        return [module for module in found if module[:2] != ("garmentq", "setup")]


data = {"garmentq": ["py.typed"]} | dict.fromkeys(packages[1:], DATA)
setup(packages=packages, package_data=data, cmdclass={"build_py": Build})
