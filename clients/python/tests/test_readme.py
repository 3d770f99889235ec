"""The code of the README runs as printed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

README = Path(__file__).parents[1] / "README.md"


def test_every_example_runs(server: str, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.setenv("EVSWARM_SERVER", server)
    monkeypatch.delenv("EVSWARM_TOKEN", raising=False)
    examples = re.findall(r"```python\n(.*?)```", README.read_text(), flags=re.DOTALL)
    assert len(examples) == 2
    names: dict[str, object] = {}
    for example in examples:
        exec(compile(example, str(README), "exec"), names)
    said = capsys.readouterr().out
    assert "brownian" in said and "(100, 100)" in said
    assert "/base/controller/alpha" in said
