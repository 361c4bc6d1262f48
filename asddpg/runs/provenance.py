"""Provenance: the versions and the scene that a run, a result or a recording was made with."""

import platform
import sys
from importlib import metadata

import gymnasium

from asddpg import __version__
from asddpg.config import TrainConfig
from asddpg.recording.recorder import Provenance
from asddpg.runs.run_folder import config_text

_PACKAGES = ("mujoco", "dm-control", "torch", "numpy", "gymnasium")
# Keys of notes in a run's provenance: from how many steps to how many it was prolonged, and what changed at a resume.
PROLONGED, RESUMED = "prolonged", "resumed"


def versions() -> dict[str, str]:
    """Versions of Python and of the packages that a result depends on."""
    own = {"python": platform.python_version(), "asddpg": __version__}
    return own | {name: metadata.version(name) for name in _PACKAGES}


def peak_memory() -> float | None:
    """The most memory that this process has had, MB; None where the system does not say."""
    try:
        import resource
    except ModuleNotFoundError:  # Windows
        return None
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss  # kB, on macOS bytes
    return most / 1024 ** (2 if sys.platform == "darwin" else 1)


def current_versions(environment: gymnasium.Env) -> dict[str, str]:
    """Provenance of what is made now: versions, and the hash of the environment's scene."""
    return versions() | {"model_hash": environment_hash(environment)}


def recording_provenance(config: TrainConfig, provenance: dict[str, str], **more: str) -> Provenance:
    """Provenance of a recording: the configuration as YAML, and facts by name."""
    facts = {"task": config.task.name, "agent": config.agent.name, "seed": str(config.seed)}
    facts |= {**more, **provenance}
    # A path whose bytes are no UTF-8 is escaped.
    facts = {name: text.encode(errors="backslashreplace").decode() for name, text in facts.items()}
    return Provenance(config_text(config, provenance), facts)


def environment_hash(environment: gymnasium.Env) -> str:
    """Hash of an environment's compiled scene."""
    digest: str = environment.get_wrapper_attr("scene_hash")
    return digest


def update_provenance(
    stored: TrainConfig, provenance: dict[str, str], config: TrainConfig, now: dict[str, str], step: int
) -> tuple[dict[str, str], list[str]]:
    """Provenance of a run that resumes at `step`: what it began with, and what has changed since.

    Args:
        stored: configuration before the resume.
        provenance: of the run so far.
        config: configuration from here on.
        now: current versions and scene hash.
        step: of the training.

    Returns:
        The provenance from here on, and a sentence for the user about each change.
    """
    notes = []
    changes = [f"{name} {value}" for name, value in now.items() if provenance.get(name) != value]
    if changes:
        provenance = _append_note(provenance, RESUMED, f"at step {step} with {', '.join(changes)}")
        notes.append(f"it resumes with {', '.join(changes)}, so it will differ from an uninterrupted run")
    if config.total_steps != stored.total_steps:
        change = f"from {stored.total_steps} to {config.total_steps} at step {step}"
        provenance = _append_note(provenance, PROLONGED, change)
        notes.append("schedules (noise, withdrawal, learning rates) span the new length from here on")
    return provenance, notes


def _append_note(provenance: dict[str, str], name: str, note: str) -> dict[str, str]:
    before = provenance.get(name, "")
    return provenance | {name: before if note in before else f"{before}; {note}".removeprefix("; ")}
