"""`garmentq result`."""

from __future__ import annotations

from pathlib import Path

import click

from . import exits
from .options import WaitOptions, json_option, known_home_option, verbose_option, wait_options


@click.command("result")
@click.argument("job")
@wait_options
@known_home_option
@verbose_option
@json_option
@click.pass_context
def command(
    context: click.Context, job: str, waiting: WaitOptions, home: Path | None, verbose: bool, as_json: bool
) -> None:
    """Show a job's result.

    And the result of each job below it. For a segmented person it waits for the garments. The exit status is the worst
    of theirs: 0 succeeded, 10 succeeded but a check failed, 4 bad input, 5 failed, 6 dead, 7 cancelled; 3 if one has no
    result yet.

    \b
    Example:
      garmentq result 3685ecfd4f81
    """
    from dataclasses import asdict

    from ..service.backend import open_backend
    from ..service.results import ResultMissing
    from ..service.settings import read_settings
    from ..service.states import ENDED, State
    from .family import drop_redrapes, find_family
    from .garments import wait_garments
    from .summary import print_result
    from .terminal import print_error, print_json, print_table

    backend = open_backend(read_settings(home=home))
    family = drop_redrapes(
        wait_garments(backend, drop_redrapes(find_family(backend, backend.find_job(job))), waiting.timeout)
    )
    statuses = []
    for found in family:
        if found.state not in ENDED:
            missing = ResultMissing(f"job {found.id} is {found.state}; `garmentq logs -f {found.id}` follows it.")
            if len(family) == 1:
                raise missing
            print_error(missing.code, missing.message)
            statuses.append(exits.NOT_FOUND)
            continue
        files = backend.list_artifacts(found.id)
        if as_json:
            print_json({**found.as_json(), "files": [asdict(file) for file in files]})
        elif found.state == State.SUCCEEDED or files:
            print_result(found, [], verbose)
            if verbose:
                print_table(["file", "bytes", "sha256"], [[file.name, file.size, file.sha256[:12]] for file in files])
        if found.error:
            print_error(found.error.code, found.error.message)
        statuses.append(exits.job_status(found, waiting.lenient))
    context.exit(exits.worst(statuses))
