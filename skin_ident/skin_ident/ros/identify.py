"""One goal of the action `identify`, from its first check to its result: the same core as the command lines, in a thread."""

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from threading import Lock
from traceback import format_exc

from rclpy.logging import get_logger
from skin_testbed_msgs.action import Identify

from skin_ident.cli.common import check_no_answer, check_no_model, check_output, refusal, topics_of, whole_folder, write_json
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.estimate import Estimate
from skin_ident.estimators.fit import Options, fit_recordings, sessions_of
from skin_ident.estimators.robust import LINEAR, LOSSES
from skin_ident.estimators.text import as_dict
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.load import find, load_one
from skin_models.errors import SkinError
from skin_models.model import Model
from skin_models.model_file import load_model, save_model
from skin_models.parameter import parameters_of
from skin_models.words import counted

Result = Identify.Result
_LOOK = 0.1  # s, between two looks whether a goal that waits is still wanted


class Cancelled(Exception):
    """The goal was cancelled."""


class NotWritten(Exception):
    """The results cannot be written where the goal wants them."""


@contextmanager
def _writing() -> Iterator[None]:
    """Turns every `SkinError` and `OSError` of the block into `NotWritten`: what fails there is the writing, not the input."""
    try:
        yield
    except SkinError as error:
        raise NotWritten(str(error)) from error
    except OSError as error:
        raise NotWritten(refusal(error)) from error


@dataclass
class Run:
    """`result()` does the work; `cancelled` is asked between steps, `publish` gets the feedback."""

    goal: Identify.Goal
    cancelled: Callable[[], bool]
    publish: Callable[[Identify.Feedback], None]
    done: float = field(default=0.0)

    def after(self, others: Lock) -> Result:
        """Wait until the goals before this one have ended, then do the work. The goal can be cancelled while it waits."""
        while not others.acquire(timeout=_LOOK):
            if self.cancelled():
                return Result(error_code=Result.CANCELLED, error_string="cancelled; nothing was written")
        try:
            return self.result()
        finally:
            others.release()

    def result(self) -> Result:
        """The result, whatever happens."""
        try:
            if self.goal.output_directory:
                with _writing():
                    check_output(self.goal.output_directory)  # here, not after minutes of work
                (check_no_model if self.goal.criticise else check_no_answer)(self.goal.output_directory)
            if not self.goal.recordings:
                raise RecordingError("the goal names no recordings")
            return self._criticised() if self.goal.criticise else self._fitted()
        except Cancelled:
            return Result(error_code=Result.CANCELLED, error_string="cancelled; nothing was written")
        except SkinError as error:
            return Result(error_code=Result.UNUSABLE_INPUT, error_string=str(error))
        except NotWritten as error:
            return Result(error_code=Result.WRITE_FAILED, error_string=str(error))
        except OSError as error:
            return Result(error_code=Result.UNUSABLE_INPUT, error_string=refusal(error))
        except Exception as error:  # a result that rclpy makes up would say SUCCESS
            get_logger("identify").error(format_exc())
            said = f"{type(error).__name__}: {' '.join(str(error).split())}"
            return Result(error_code=Result.FAILED, error_string=f"a mistake of this program, not of the goal: {said}")

    def _say(self, stage: str, progress: float | None = None) -> None:
        if self.cancelled():
            raise Cancelled
        self.done = self.done if progress is None else progress
        self.publish(Identify.Feedback(progress=self.done, stage=stage))

    def _ended(self) -> None:
        """The last feedback. What is written is written: a goal that is cancelled from here on has succeeded all the same."""
        self.publish(Identify.Feedback(progress=1.0, stage="done"))

    def _load(self, files: list[Path], share: float) -> list:
        topics = topics_of(self.goal.topics)
        start, loaded = self.done, []
        for i, file in enumerate(files):
            self._say(f"reading {file.name}", start + share * i / len(files))
            loaded.append(load_one(file, topics, self.goal.log_time, self.goal.keep_stamps))
        return loaded

    def _fitted(self) -> Result:
        options = Options(loss=self.goal.loss or LINEAR)
        if options.loss not in LOSSES:
            raise FitError(f"the loss is one of {', '.join(LOSSES)}, not {options.loss!r}")
        files = [file for path in self.goal.recordings for file in find(path)]
        recordings, _ = sessions_of(self._load(files, 0.6))
        self._say(f"fitting {counted(len(recordings), 'session')}", 0.6)
        estimate = fit_recordings(recordings, options)
        self._say("writing", 0.95)
        self._write(estimate)
        self._ended()
        return Result(error_code=Result.SUCCESS, **_parameters(estimate))

    def _write(self, estimate: Estimate) -> None:
        if not self.goal.output_directory:
            return
        with _writing(), whole_folder(self.goal.output_directory) as folder:
            write_json(folder / "fit.json", as_dict(estimate))
            if estimate.model is not None:
                save_model(estimate.model, folder / "model.yaml", estimate.std)

    def _criticised(self) -> Result:
        # Imported here: the criticism and its report take a second to load, and a node that only fits never needs them.
        from skin_ident.cli.diagnose import Files, apart, warned, write
        from skin_ident.criticism.diagnose import diagnose

        def read(files: Files, share: float) -> list:
            loaded = self._load([file for file, _ in files], share)
            return [warned(r, said) for r, (_, said) in zip(loaded, files, strict=True)]

        model = load_model(self.goal.model) if self.goal.model else None
        files, kept = apart(self.goal.recordings, self.goal.hold_out)
        recordings, held = read(files, 0.2), read(kept, 0.1)
        outcome = diagnose(recordings, held, model, lambda stage: self._say(stage, min(0.9, self.done + 0.02)))
        path = ""
        if self.goal.output_directory:
            self._say("writing the report", 0.95)
            with _writing(), whole_folder(self.goal.output_directory) as folder:
                write(outcome, folder)
            path = str(folder / "findings.json")
        self._ended()
        causes = [f["cause"] for f in outcome.findings["findings"]]
        found = {} if outcome.model is None else _of_model(outcome.model, outcome.std)
        return Result(error_code=Result.SUCCESS, verdict=outcome.findings["verdict"], causes=causes, findings=path, **found)


def _of_model(model: Model, std: Mapping[str, float]) -> dict[str, list]:
    """Dispersion parameters by name, those of effects as `Model.listed_as` says; a standard error that is not known is NaN."""
    named = [(p.name, p) for p in parameters_of(model.dispersion)]
    named += [(model.listed_as(i, p.name), p) for i, e in enumerate(model.effects) for p in parameters_of(e)]
    return {
        "parameter_names": [name for name, _ in named],
        "values": [float(p.value) for _, p in named],
        "standard_errors": [float(std.get(name, math.nan)) for name, _ in named],
        "units": [p.unit for _, p in named],
    }


def _parameters(estimate: Estimate) -> dict[str, list]:
    return {
        "parameter_names": [p.name for p in estimate.parameters],
        "values": [p.value for p in estimate.parameters],
        "standard_errors": [estimate.std[p.name] for p in estimate.parameters],
        "units": [p.unit for p in estimate.parameters],
    }
