"""What the runs of a table were made with: version and scenes, and a warning where a scene is not today's."""

from asddpg.runs.provenance import versions
from tasks import ALL_TASKS
from tools.experiments.current_scenes import scene_today
from tools.experiments.run_tables import Results

Scenes = dict[tuple[str, int], set[str]]
UNKNOWN = "unknown"


def provenance(results: Results) -> str:
    """Sentences to stand below a table; nothing where there are no runs."""
    runs = [result.run for found in results.values() for result in found]
    if not runs:
        return ""
    scenes: Scenes = {}
    for run in runs:
        scene = (run.settings["task"]["name"], run.settings["task"]["laser"]["num_beams"])
        scenes.setdefault(scene, set()).add(run.provenance.get("model_hash", UNKNOWN))
    provenance = ", ".join(sorted({run.provenance.get("asddpg", UNKNOWN) for run in runs}))
    named = "; ".join(f"{_title(scene)} {', '.join(sorted(hashes))}" for scene, hashes in scenes.items())
    return " ".join([f"Trained with asddpg {provenance}; scene {named}.", *_mixed(scenes), *_changed(scenes)])


def _title(scene: tuple[str, int]) -> str:
    return "{} with {} beams".format(*scene)


def _mixed(scenes: Scenes) -> list[str]:
    """Runs in different models of one scene are not one experiment."""
    mixed = [_title(scene) for scene, hashes in scenes.items() if len(hashes) > 1]
    return [f"Runs made with different models of a scene stand side by side: {', '.join(mixed)}."] if mixed else []


def _changed(scenes: Scenes) -> list[str]:
    """Scenes that none of the runs saw as they are now."""
    changed = []
    for scene, hashes in scenes.items():
        today = scene_today(*scene) if scene[0] in ALL_TASKS else "none"
        changed += [f"{_title(scene)} is {today}"] if today not in hashes else []
    return [f"No run is of today's scene: {'; '.join(changed)} now (asddpg {versions()['asddpg']})."] if changed else []
