"""Export a policy: `python -m tools.export run=pretrained:nav_complex`.

Writes an ONNX file that needs this package no more: from a scan in metres, velocity and goal to v and ω. It is compared
with the policy itself on the observations of drives in its own task.
"""

from collections.abc import Sequence
from dataclasses import MISSING, dataclass
from pathlib import Path

from asddpg.build import prepare_torch
from asddpg.errors import UserError
from asddpg.messages import print_line
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from asddpg.runs import weights_file
from asddpg.runs.loading import PREFIX, open_trained
from tasks.options import between, one_of, option

EXTRA = "asddpg[onnx]"


@dataclass(frozen=True)
class ExportArguments:
    """The policy, and the file."""

    run: str = option(MISSING, f"Folder of a run, or {PREFIX}<name>.")
    checkpoint: str = option("last", "Checkpoint of a run's folder.", one_of("last", "best"))
    format: str = option("onnx", "Format of the file.", one_of("onnx"))
    switch: bool = option(False, "Whether the file has the switch too: values of policy and controller.")
    file: Path | None = option(None, "The file; null names it <policy>.onnx, in the present folder.")
    observations: int = option(
        1000, "Observations on which file and policy are compared; 0 compares nothing.", between(0, 10**6)
    )


@prepare_torch()
def main(arguments: Sequence[str]) -> None:
    """Write the file, compare it, print both figures."""
    parsed = parse_arguments(ExportArguments, arguments)
    try:
        from asddpg.deployment.onnx_file import write_onnx
        from tools.publishing.onnx_check import compare
    except ModuleNotFoundError as error:
        raise UserError(f"an export needs {error.name}: pip install '{EXTRA}'") from error
    trained = open_trained(parsed.run, parsed.checkpoint, controller=None)
    networks, _, _ = weights_file.read(trained.weights)
    name = Path(parsed.run.removeprefix(PREFIX)).resolve().name
    file = parsed.file or Path(f"{name}.onnx")
    write_onnx(file, networks, trained.config, parsed.run if parsed.run.startswith(PREFIX) else name, parsed.switch)
    print_line(f"written to {file}, {file.stat().st_size / 1e6:.1f} MB")
    if parsed.observations:
        difference, microseconds = compare(file, parsed.run, parsed.checkpoint, parsed.observations)
        print_line(
            f"on {parsed.observations} observations its commands differ from the policy's by {difference:.1e} at most; "
            f"a decision takes {microseconds:.0f} µs (median, onnxruntime, one thread)"
        )


if __name__ == "__main__":
    run(main, help_text(__doc__, ExportArguments))
