"""The verdict of a finished search on the rig file as it is written, and what of the remainder that file keeps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from config.loading.load import LoadedRig
from config.progress import Progress
from gap.data.data_check import DataProblem
from gap.data.measured import Array, Measured
from gap.fitting.evaluation import Evaluation, mean_cost
from gap.naming import Decided
from gap.outcome.model_file import moved
from gap.outcome.names import Fitted
from gap.outcome.search_state import SearchState
from gap.outcome.steadiness import Steadiness, in_words, steadiness, unsteady
from gap.outcome.verdict import Verdict
from gap.outcome.written import ImprovedFile, Writer, file_model
from gap.remainder.kept_remainder import kept_remainder
from gap.remainder.remainder import remainder, sentence
from gap.settings import Settings


@dataclass(frozen=True, slots=True)
class Searched:
    """A finished search with what it was given. `names`: the channels compared; `nominal`: the hold-out with the file as it was;
    `decided`: what the evidence says; None where the data cannot be used."""

    loaded: LoadedRig
    names: list[str]
    state: SearchState
    nominal: tuple[Evaluation, ...]
    problems: list[DataProblem]
    logs: Sequence[Measured]
    settings: Settings
    progress: Progress
    decided: Decided | None = None

    @property
    def refit(self) -> float:
        """Cost of the hold-out with the best constants alone."""
        return mean_cost(self.state.alone_seen)


@dataclass(frozen=True, slots=True)
class JudgedFile:
    """The verdict on the written file; its text, with a table of the remainder if one is kept; what is left without a name.

    `file`: as the fit logs have it, which predicts the hold-out blind; `all_logs`: the one that is written instead, with its constants
    fitted to all logs in the end. `steady`: changed constants log by log, where they are the verdict.
    """

    word: Verdict
    file: ImprovedFile
    text: str
    rest: dict[str, Any] | None
    steady: list[Steadiness]
    all_logs: ImprovedFile | None

    @property
    def written(self) -> ImprovedFile:
        """The file that is written, but for a table of the remainder."""
        return self.all_logs or self.file


def judged_file(done: Searched, half_width: Array) -> JudgedFile:
    """`half_width`: 95 %, of every free number."""
    state = done.state
    word, model = _word(done), state.current.model
    steady = steadiness(state, model, moved(model, half_width)) if word.word == "parameter_mismatch" else []
    if differing := in_words(unsteady(steady)):
        word = replace(word, why=f"{word.why} But {differing}: a missing effect may hide there.")
    alone = done.decided.alone[0] if done.decided and done.decided.alone else None
    writer = Writer(done.loaded, state, Fitted(model, half_width), done.nominal, alone)
    file, text, rest = _with_remainder(writer, word, writer.file(word), done)
    all_logs = _with_all_logs(writer, word, file, done.decided) if done.decided and text == file.text else None
    if word.word == "unknown":
        said_of_rest = f" {sentence(rest)}" if rest else ""
        word = replace(word, why=f"{word.why} {_of_file(file, all_logs, done.loaded)}{said_of_rest}")
    return JudgedFile(word, file, all_logs.text if all_logs else text, rest, steady, all_logs)


def _word(done: Searched) -> Verdict:
    """The verdict; data that cannot be used say nothing else."""
    if done.decided is None:
        fatal = [problem.text() for problem in done.problems if problem.fatal]
        return Verdict("data_problem", f"Nothing is said about the plant: {'; '.join(fatal)}", False)
    return done.decided.verdict


def _with_all_logs(writer: Writer, word: Verdict, file: ImprovedFile, decided: Decided) -> ImprovedFile | None:
    """The same file with the constants of all logs; None where it has none of its own, or better ones than those are not known. (A table
    of the remainder stands on the constants it was judged with.)"""
    if not file.model.free:
        return None
    fitted = decided.written
    writer = replace(writer, fitted=fitted, alone=fitted.model if decided.alone else None)
    found = writer.file(word)
    return found if found.model.free else None


def _of_file(file: ImprovedFile, all_logs: ImprovedFile | None, loaded: LoadedRig) -> str:
    """What stands in the improved rig file where nothing can be named."""
    if file.text == loaded.text:
        return "The rig file is written unchanged: no other constants predict the hold-out better."
    best = "The improved rig file has the best constants and no names: the hold-out is at"
    if all_logs is None:
        return f"{best} {file.cost:.4g} noise floors with it."
    return f"{best} {file.cost:.4g} noise floors with those of the fit logs, {all_logs.cost:.4g} with those of all logs, which are written."


def _with_remainder(writer: Writer, word: Verdict, file: ImprovedFile, done: Searched) -> tuple[ImprovedFile, str, dict[str, Any] | None]:
    """The file, its text with the remainder in it if that was asked for and is worth it, and the remainder with what became of it.

    Constants that do a missing force's work as well as they can leave less room for its table: the file as it was is tried too."""
    if word.word == "data_problem":
        return file, file.text, None
    files = [file, writer.unchanged()] if done.settings.keep_remainder and word.word == "unknown" and file.model.free else [file]
    tried = [(one, *_kept(one, writer, done)) for one in files]
    return min(tried, key=lambda one: _reached(one[0], one[2]))


def _kept(file: ImprovedFile, writer: Writer, done: Searched) -> tuple[str, dict[str, Any] | None]:
    rest = remainder(writer.nominal, file.seen, done.names, file_model(file.text).rig)
    if rest is None or not done.settings.keep_remainder:
        return file.text, rest | {"kept": None} if rest else None
    text, kept = kept_remainder(file.text, writer.state, rest, file.seen, done.progress)
    return text, rest | {"kept": kept}


def _reached(file: ImprovedFile, rest: dict[str, Any] | None) -> float:
    """Cost of the hold-out with the file and the table it may have."""
    kept = rest["kept"] if rest else None
    return float(kept["holdout_after"]) if kept and kept["kept"] else file.cost
