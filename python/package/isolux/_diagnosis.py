"""Where model and measurement disagree, and what a model predicts."""

from __future__ import annotations

import html
import tempfile
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence, Union

import numpy as np

from isolux._isolux import _diagnose, _predict
from isolux._run import Run
from isolux._tables import read_back, structured

AnyPath = Union[str, "PathLike[str]"]
Observations = Union[AnyPath, Run]


@dataclass(frozen=True)
class Diagnosis:
    """What a diagnosis found.

    ``document`` has the keys of ``diagnosis.json``; ``folder`` holds the report, both models and the figures.
    """

    document: Dict[str, Any]
    folder: Path
    #: Lines that the model after has and the model as given has not (``+``), and the other way round (``-``).
    diff: List[str]
    #: The next version of the model, with ``accept=True``.
    accepted: Optional[Path]
    _kept: Any = field(default=None, repr=False, compare=False)

    @property
    def verdict(self) -> str:
        """``"consistent"``, ``"named"``, ``"ambiguous"`` or ``"unexplained"``."""
        return str(self.document["verdict"])

    @property
    def sentence(self) -> str:
        """The verdict in one sentence."""
        return str(self.document["sentence"])

    @property
    def effects(self) -> List[Dict[str, Any]]:
        """The effects that were added to the model, with their parameters."""
        return list(self.document["effects"])

    @property
    def ranked(self) -> List[List[Dict[str, Any]]]:
        """For each place that disagreed: the effects that could explain it, the best one first."""
        return list(self.document["ranked"])

    @property
    def gap(self) -> Dict[str, Any]:
        """How far model and readings are apart, before and after, on readings that were fitted and on held-out ones."""
        return dict(self.document["gap"])

    @property
    def model_after(self) -> Path:
        """The model with the effects that were found."""
        return self.folder / "model.after.toml"

    @property
    def report(self) -> Path:
        """The report as a page."""
        return self.folder / "report.html"

    @property
    def figures(self) -> Dict[str, str]:
        """The figures of the report by name, as SVG."""
        return {path.stem: path.read_text(encoding="utf-8") for path in sorted(self.folder.glob("*.svg"))}

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{html.escape(str(effect.get('standard_name', effect['name'])))}</td>"
            f"<td>{html.escape(', '.join(effect['parameters']))}</td></tr>"
            for effect in self.effects
        )
        figures = "".join(f'<div style="max-width:40em">{svg}</div>' for svg in self.figures.values())
        return f"<div><b>{html.escape(self.sentence)}</b><table>{rows}</table>{figures}</div>"


def _path(observations: Observations) -> AnyPath:
    return observations.path if isinstance(observations, Run) else observations


def diagnose(
    model: AnyPath,
    readings: Union[Observations, Sequence[Observations]],
    *,
    held_out: Optional[Observations] = None,
    seed: int = 1,
    out: Optional[AnyPath] = None,
    accept: bool = False,
    force: bool = False,
    progress: Optional[Callable[[str, Optional[int], Optional[int], str], Any]] = None,
) -> Diagnosis:
    """Where ``model`` and ``readings`` disagree, which physical effect is missing, and the model that has it.

    ``readings``: run directories, readings CSVs, ``maps.toml`` or ``spectra.toml`` files; several are fitted together.
    ``held_out``: observations that are predicted but never fitted; without them whole planes, maps and dark blocks are
    kept back. ``out``: the folder of the report and the models; without it a temporary one, which goes with the object.
    """
    several = [readings] if isinstance(readings, (str, PathLike, Run)) else list(readings)
    kept = None
    if out is None:
        kept = tempfile.TemporaryDirectory(prefix="isolux-")
        out = Path(kept.name) / "diagnosis"
    document, diff, accepted = _diagnose(
        model,
        [_path(one) for one in several],
        out,
        held_out=None if held_out is None else _path(held_out),
        seed=seed,
        accept=accept,
        force=force,
        progress=progress,
    )
    return Diagnosis(document, Path(out), diff, None if accepted is None else Path(accepted), kept)


def predict(model: AnyPath, observations: Observations) -> np.ndarray:
    """What ``model`` says would be read at the coordinates of ``observations``: one record a row, in their order.

    The last field is the prediction, ``predicted_illuminance_lx``, ``predicted_signal`` or that of spectra.
    """
    _, texts, name, values = _predict(model, _path(observations))
    columns: Dict[str, Any] = {key: read_back(key, column) for key, column in texts.items() if key != name}
    columns[name] = values
    return structured(columns)
