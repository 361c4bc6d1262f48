"""An exported policy: the same commands, all that its user must know, no need of this package."""

import json
import subprocess
import sys
from pathlib import Path

import onnx
import pytest

from asddpg import train
from asddpg.errors import UserError
from tests.conftest import TINY
from tools import export

# What a robot has: onnxruntime and NumPy. Isolated, in a folder without this package.
ROBOT = """
import json, sys
import numpy as np, onnxruntime
session = onnxruntime.InferenceSession(sys.argv[1], providers=["CPUExecutionProvider"])
about = session.get_modelmeta().custom_metadata_map
beams = len(json.loads(about["beam_angles"]))
scans = np.zeros([1, *session.get_inputs()[1].shape[1:]], np.float32)
for _ in range(3):
    command, scans = session.run(None, {
        "ranges": np.full((1, beams), np.inf, np.float32), "previous_scans": scans,
        "velocity": np.zeros((1, 2), np.float32), "goal": np.array([[2.0, 0.0]], np.float32),
    })
print(json.dumps([*map(float, command[0]), sorted({"asddpg", "tasks", "torch"} & set(sys.modules))]))
"""


def test_a_shipped_policy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    export.main(["run=pretrained:nav_complex", "observations=150"])
    written, compared = capsys.readouterr().out.splitlines()
    assert written.startswith("written to nav_complex.onnx, 0.8 MB")
    difference = float(compared.partition(" by ")[2].partition(" ")[0])
    assert 0.0 < difference <= 1e-5
    about = {each.key: each.value for each in onnx.load("nav_complex.onnx").metadata_props}
    assert about["policy"] == "pretrained:nav_complex"
    assert json.loads(about["control_timestep"]) == 0.2
    angles = json.loads(about["beam_angles"])
    assert (len(angles), angles[0], angles[-1]) == (
        40,
        pytest.approx(-2.0944, abs=1e-4),
        pytest.approx(2.0944, abs=1e-4),
    )
    assert about["ranges"].startswith("newest scan, metres")
    robot = [sys.executable, "-I", "-c", ROBOT, "nav_complex.onnx"]
    v, _, ours = json.loads(subprocess.run(robot, capture_output=True, text=True, check=True).stdout)
    assert 0.3 < v <= 0.5
    assert ours == []


def test_a_run_and_its_switch(tiny_run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mine.onnx"
    export.main([f"run={tiny_run}", "switch=true", f"file={file}", "observations=0"])
    assert capsys.readouterr().out == f"written to {file}, {file.stat().st_size / 1e6:.1f} MB\n"
    outputs = [each.name for each in onnx.load(file).graph.output]
    assert outputs == ["command", "scans", "switch_values"]
    before = file.read_bytes()
    export.main([f"run={tiny_run}", "switch=true", f"file={file}", "observations=0"])
    assert file.read_bytes() == before


def test_a_sentence_for_what_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = tmp_path / "run"
    train.main(["task=nav_empty", "agent=ddpg", *TINY, "total_steps=200", f"run_dir={run}"])
    with pytest.raises(UserError, match=r"has no switch: its agent, ddpg, was trained without a controller"):
        export.main([f"run={run}", "switch=true", f"file={tmp_path / 'x.onnx'}"])
    with pytest.raises(UserError, match="format must be onnx, not 'tflite'"):
        export.main([f"run={run}", "format=tflite"])
    with pytest.raises(UserError, match="not the folder of a run"):
        export.main(["run=nowhere"])
    monkeypatch.setitem(sys.modules, "onnx", None)
    for name in [name for name in sys.modules if name.startswith(("asddpg.deployment.onnx", "tools.publishing.onnx"))]:
        monkeypatch.delitem(sys.modules, name)
    with pytest.raises(UserError, match=r"needs onnx: pip install 'asddpg\[onnx\]'"):
        export.main([f"run={run}", f"file={tmp_path / 'x.onnx'}"])
    assert not list(tmp_path.glob("*.onnx"))
