"""The form that queues scans: files, options for all of them, and what is detected in each."""

from __future__ import annotations

from ...core.recover.settings import METHODS, QUALITIES, REDRAPES
from ...core.run.units import UNITS
from ...core.scan.header import CLOUDS, FORMATS
from ..materials import list_materials
from ..services import Services
from .markup import Html, html, join


def draw_form(services: Services) -> Html:
    """Return the form; the fabrics are those of the home's library."""
    fabrics = join(html('<option value="{}">{}</option>', one.name, one.title or one.name)
                   for one in list_materials(services.database))  # fmt: skip
    qualities = join(html("<option>{}</option>", name) for name in QUALITIES)
    methods = join(html("<option>{}</option>", name) for name in METHODS)
    units = join((html("<option>{}</option>", name) for name in UNITS), "")
    redrapes = join(html("<option>{}</option>", name) for name in REDRAPES)
    scans, bodies = ([f".{name}" for name in names] for names in ((*FORMATS, *CLOUDS), (*FORMATS, "npz", "json")))
    return html(DROP, fabrics=fabrics, qualities=qualities, methods=methods, redrapes=redrapes, units=units,
                scans=",".join(scans), bodies=",".join(bodies),
                formats=", ".join((*FORMATS, *CLOUDS)).upper())  # fmt: skip


DROP = """<form id="submit" class="card"><h2 class="hushed">New jobs</h2>
<div id="drop" class="drop"><p class="row">Drop scans or folders here, or
<input id="scan" class="hushed" type="file" accept="{scans}" multiple>
<label for="scan" class="button">Choose files</label>
<button type="button" id="folder-button">Choose a folder</button></p>
<input id="folder" type="file" webkitdirectory hidden aria-label="Folder">
<p id="told" class="soft" role="status">Raw scans of persons, or garments: {formats}.</p>
</div>
<details><summary>Options</summary><div class="options">
<label id="name-option">Name <input name="name" maxlength="255" placeholder="the file's name"></label>
<label>Tags <input name="tags" placeholder="spring, fitting"></label>
<label>The scan is <select name="as"><option value="">detected</option><option value="person">a person</option>
<option value="garment">a garment</option></select></label>
<label>Unit <select name="units"><option value="">detected</option>{units}</select></label>
<label>Up axis <select name="up"><option value="">detected</option><option>y</option><option>z</option>
<option>-y</option><option>-z</option><option>x</option><option>-x</option></select></label>
<label>Height <input name="height" type="number" min="0.5" max="2.5" step="0.01" placeholder="by the unit"></label>
<label>Body <input name="body" placeholder="builtin:female,height=1.70"></label>
<label>Body's file <input name="body_file" type="file" accept="{bodies}"></label>
<label>Labels <input name="labels" type="file" accept=".npz,.npy,.json,.txt"></label>
<label>Wearing <input name="wearing" placeholder="upper,lower"></label>
<label>Template <input name="template" placeholder="chosen from the scan"></label>
<label>Fabric <select name="fabric"><option value="">default</option>{fabrics}</select></label>
<label>Quality <select name="quality"><option value="">default</option>{qualities}</select></label>
<label>Method <select name="method"><option value="">default</option>{methods}</select></label>
<label>Re-drape <select name="redrape"><option value="">default</option>{redrapes}</select></label>
</div></details>
<section id="batch" hidden aria-label="Chosen files"><p><label>Batch <input name="batch" maxlength="64"></label>
<span class="soft">A tag of all its jobs.</span></p><ol class="files"></ol>
<p id="batch-state" role="status"></p></section>
<p class="row"><button type="submit" class="primary">Queue the job</button><progress id="sent" max="1" value="0" hidden
 aria-label="Upload"></progress></p><div id="problem"></div>
<section id="understood" hidden aria-label="Detected in the scan"><h3>Detected in the scan</h3>
<div class="wide"><table></table></div><p id="looking" class="soft" role="status"></p></section></form>"""
