"""vcmm certificate: what the certificate of a machine is worth for a part."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from vcmm.face.cli.options import Seed

LEAST = 0.94  # of machines at the limit: 95 % less what is seen by chance in some thousand of them


def certificate_command(
    scenario: Path,
    *,
    trials: int | None = 20_000,
    seed: Seed | None = None,
    json: Annotated[bool, Parameter(name="--json")] = False,
) -> int:
    """What a certificate is worth for a part: U under three priors and with every further fact, machines at the limit counted.

    Exit code 1 when machines at the limit are covered less often than their intervals say.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1) whose machine states a [certificate] and no errors of its own.
    trials
        Monte Carlo trials of each evaluation.
    seed
        Seed of the random streams (default: the scenario's).
    json
        Print one JSON document.
    """
    from vcmm.answer.evaluation.at_limit import smallest
    from vcmm.files.learned.certificate_comparison import certificate_worth
    from vcmm.show.console.complaints import about
    from vcmm.show.console.documents import document, print_json, sources
    from vcmm.show.console.terminal import progress, say_warnings, show_answers, show_table
    from vcmm.show.tables.answers_parts import certificate_answers
    from vcmm.show.tables.certificate import worth_json, worth_tables

    with progress() as report, about(scenario, "machine"):
        found = certificate_worth(scenario, trials=trials, seed=seed, progress=report)
    if json:
        print_json(
            document(
                "vcmm.certificate/1",
                worth_json(found),
                seed=found.seed,
                files=sources(scenario),
                warnings=found.warnings,
            )
        )
    else:
        show_answers(certificate_answers(found, LEAST))
        print(found.stated)
        for table in worth_tables(found):
            show_table(table)
        say_warnings(found.warnings)
    return int(smallest(found.covered) < LEAST)
