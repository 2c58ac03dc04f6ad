"""A dressed person's scan on the command line: one job for each garment that is kept."""

from __future__ import annotations

from garmentq.service.jobs import claim, find_job
from garmentq.service.kinds import read_request
from garmentq.service.kinds.recover import Recover
from garmentq.service.kinds.recover_request import RecoverRequest
from garmentq.service.services import Services
from garmentq.workers.recovery import unpack
from garmentq_home import put_file


def unpack_request(settings, database, store, held, folder):
    """Return what the pipeline would get, with the files in a folder."""
    request = read_request(RecoverRequest, held.request)
    return request.unpack(unpack(Services(settings, database, store), held, folder, Recover(), request).files)


def test_each_keep_is_a_job(cli, settings, database, store, tmp_path):
    """Broken where the second garment of a scan is lost, or labels and colour do not reach the job that runs."""
    person, labels = put_file(tmp_path, "person.ply"), put_file(tmp_path, "labels.npz")
    done = cli("submit", person, "--labels", labels, "--labels-key", "part", "--keep", "upper", "--keep", "lower")
    assert done.returncode == 0, done.stderr
    jobs = [line.split()[0] for line in done.stdout.splitlines()]
    assert len(set(jobs)) == 2
    for job, keep in zip(jobs, ("upper", "lower"), strict=True):
        chosen = find_job(database, job).request["settings"]
        assert (chosen["keep"], chosen["cloth"]) == (keep, "lower" if keep == "upper" else "upper")
        held = claim(database, job, "me", 60.0)
        request = unpack_request(settings, database, store, held, tmp_path / job)
        assert request.body is None and request.labels is not None
        assert request.labels.read_bytes() == labels.read_bytes()
        selection = request.selection
        assert selection is not None
        assert (selection.labels, selection.key, selection.keep) == (request.labels, "part", (keep,))
        assert selection.cloth == (chosen["cloth"],)


def test_colour_reaches_the_job(cli, settings, database, store, tmp_path):
    """Broken where a colour is dropped, or its tolerance."""
    person = put_file(tmp_path, "person.ply")
    done = cli("submit", person, "--keep-colour", "#465faa", "--colour-tolerance", "30")
    held = claim(database, done.stdout.split()[0], "me", 60.0)
    selection = unpack_request(settings, database, store, held, tmp_path / "job").selection
    assert selection is not None
    assert (selection.colour, selection.tolerance, selection.labels) == ("#465faa", 30.0, None)


def test_what_cannot_be_meant_is_refused(cli, tmp_path):
    """Broken where contradicting options pass."""
    person = put_file(tmp_path, "person.ply")
    both = cli("submit", person, "--keep", "a", "--keep-colour", "#465faa")
    assert both.returncode == 2 and both.stderr.startswith("error settings.bad")
