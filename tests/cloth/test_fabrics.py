"""The fabric library."""

from __future__ import annotations

import subprocess
import sys

import pytest
from garmentq.core.cloth.fabrics import PARAMETERS, FabricUnknown, get_fabric, load_fabrics


def test_library_is_complete_and_sourced():
    """A number without a source, or a source without its kind, breaks this."""
    fabrics = load_fabrics()
    assert len(fabrics) >= 12
    assert len({fabric.name for fabric in fabrics}) == len(fabrics)
    for fabric in fabrics:
        sources = dict(fabric.sources)
        assert set(sources) == set(PARAMETERS)
        for text in sources.values():
            assert text.split(":")[0] in ("measured", "derived", "assumed")
            assert len(text.split(":", 1)[1].strip()) > 10


@pytest.mark.parametrize("fabric", load_fabrics(), ids=lambda fabric: fabric.name)
def test_fabrics_are_physical(fabric):
    """A unit slip (g for kg, mm for m) or an indefinite stiffness breaks this."""
    assert fabric.H00 > 0 and fabric.H11 > 0 and fabric.H22 > 0
    assert fabric.H00 * fabric.H11 > fabric.H01**2
    assert 0.02 <= fabric.density <= 0.6
    assert 1e-4 <= fabric.thickness <= 5e-3
    assert 5e-7 <= fabric.k <= 5e-4
    # hung from one edge by a metre, no cloth stretches by more than a fifth
    assert fabric.density * 9.81 / min(fabric.H00, fabric.H11) < 0.2


def test_unknown_fabric_lists_what_there_is():
    """The default has to exist; an unknown one ends in one line with the names."""
    assert get_fabric("cotton_poplin").density == pytest.approx(0.12)
    with pytest.raises(FabricUnknown, match="cotton_poplin") as caught:
        get_fabric("kevlar")
    assert caught.value.code == "fabric.unknown"


def test_listing_fabrics_stays_light():
    """`garmentq materials` must not load the compiled kernels."""
    code = "import sys; from garmentq.core.cloth.fabrics import load_fabrics; load_fabrics(); "
    code += "print('numba' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
