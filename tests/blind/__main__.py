"""`make blind`: seal the answers if there is no study yet, run cases without a result, open the seal, write docs/results/blind.md.

A study can be interrupted at any time and continued later or on another machine: see result_file.
"""

from __future__ import annotations

import argparse
import os
import secrets
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gap.executor import each, executor
from tests.blind.cases import Case, cases, sizes
from tests.blind.one_case import Work, commit, finder_digest, run_case
from tests.blind.result_file import ENDED, gather, of_case, results
from tests.blind.scoring.page import write_page
from tests.blind.scoring.score import score
from tests.blind.seal import HASH, seal, sealed_in, unseal

STUDY = Path(__file__).with_name("study") / "evidence"
DEVELOPMENT_SEED = 900_000


def main() -> int:
    """Exit 0; 130 when interrupted (what is done is kept)."""
    arguments = _arguments()
    signal.signal(signal.SIGTERM, _interrupt)  # a study that is stopped leaves its page
    study: Path = arguments.study
    if not (sealed_in(study) / HASH).exists():
        master = arguments.seed if arguments.development else secrets.randbits(48)
        drawn = cases(master, sizes())
        print(f"sealed {len(drawn)} cases: sha256 {seal(study, drawn, master)}; commit {study / HASH} before the run", flush=True)
    if arguments.seal:
        return 0
    try:
        _run(study, unseal(study), arguments)
    except KeyboardInterrupt:
        print("interrupted; finished cases are kept, the same command goes on", file=sys.stderr)
        return 130
    finally:
        gather(study)
        if study == STUDY:
            write_page(study)
    return 0


def _interrupt(_number: int, _frame: object) -> None:
    raise KeyboardInterrupt


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="make blind", description=__doc__)
    parser.add_argument(
        "--cases", type=int, default=20, metavar="N", help="run the next N cases without a result (default 20; 0: page only)"
    )
    parser.add_argument("--minutes", type=float, default=float("inf"), metavar="M", help="start no further case after M minutes")
    parser.add_argument("--group", help="only cases of this group, such as single or null")
    parser.add_argument("--again", action="store_true", help="also cases whose result is of another version of the finder")
    parser.add_argument("--workers", type=int, metavar="N", help="processes (default: one a processor)")
    parser.add_argument("--dask", metavar="ADDRESS", help="run on this Dask cluster instead; paths must mean the same there")
    parser.add_argument(
        "--study", type=Path, default=STUDY, metavar="DIR", help="folder of the results; answers lie in it or in the one above"
    )
    parser.add_argument("--seal", action="store_true", help="seal the answers and stop")
    parser.add_argument("--development", action="store_true", help="a study whose answers may be looked at: fixed seed, no page")
    parser.add_argument("--seed", type=int, default=DEVELOPMENT_SEED, help="of a development study (default %(default)s)")
    return parser.parse_args()


def waiting(study: Path, every: Sequence[Case], again: bool) -> list[Case]:
    """Cases to run, in their order."""
    done, now = results(study), finder_digest()
    return [case for case in every if case.name not in done or (again and done[case.name]["finder"] != now)]


def _run(study: Path, every: Sequence[Case], arguments: argparse.Namespace) -> None:
    todo = [c for c in waiting(study, every, arguments.again) if arguments.group in (None, c.group)][: arguments.cases]
    (study / ENDED).mkdir(parents=True, exist_ok=True)
    start = time.monotonic()
    threads = 1 if arguments.workers != 1 else 2
    with executor(arguments.workers, arguments.dask) as pool:
        batch = 6 * (arguments.workers or os.cpu_count() or 1) if arguments.dask is None else len(todo)
        for first in range(0, len(todo), max(batch, 1)):
            if time.monotonic() - start > 60 * arguments.minutes:
                break
            some = todo[first : first + batch]
            work = [Work(case.as_json(), str(of_case(study, case.name)), threads, commit()) for case in some]
            for number, result in each(pool, run_case, work):
                minutes = (time.monotonic() - start) / 60
                print(f"{minutes:5.1f} min  {_line(some[number], result, arguments.development)}", flush=True)
            if study == STUDY:
                write_page(study)


def _line(case: Case, result: dict[str, Any], tell_answer: bool) -> str:
    """Progress; the answer only of development cases."""
    names = ", ".join(f"{f['effect']} at {f['where']}" for f in result["findings"])
    text = f"{case.name}: {result['verdict']} {names} ({result['seconds']:.0f} s)"
    if not tell_answer:
        return text
    judged = score(case, result)
    hidden = ", ".join(f"{h.effect} at {h.where} = {h.value:.4g}" for h in case.setting.hidden)
    gap = result["gap"] or {}
    costs = " → ".join(f"{gap[k]:.3g}" for k in ("holdout_before", "holdout_refit", "holdout_after") if k in gap)
    return f"{text}; {case.group} x{case.multiple:g} form {case.setting.friction_form:g}: {hidden}; {costs}; in set: {judged.in_set}"


if __name__ == "__main__":
    sys.exit(main())
