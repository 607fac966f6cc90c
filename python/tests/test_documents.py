"""The Python that stands in the documents runs as it stands there."""

import re
import shutil
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCUMENTS = ["README.md", "python/README.md", "docs/src/python.md"]


@pytest.mark.parametrize("document", DOCUMENTS)
def test_a_document_runs(document, day, tmp_path, monkeypatch, capsys):
    shutil.copytree(day, tmp_path / "day")
    for file in ["luminaire.ldt", "luminaire.spdx"]:
        shutil.copy(day / "results" / file, tmp_path)
    for file in (ROOT / "examples/hidden-effect").iterdir():
        shutil.copy(file, tmp_path)
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / document).read_text(encoding="utf-8"), re.M | re.S)
    assert blocks
    names = {}
    for block in blocks:
        exec(compile(block, document, "exec"), names)
    if document == "README.md":
        assert re.search(r"33\d\.\d\d lm give 4\.\d{4} W/m² on \(2048, 2048\) pixels", capsys.readouterr().out)
