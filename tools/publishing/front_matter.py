"""A card's front matter, which model hubs read: https://huggingface.co/docs/hub/model-cards."""

from collections.abc import Mapping
from typing import Any

import yaml

RATES = ("success_rate", "collision_rate")  # of the actor alone, on a card
_TAGS = ["reinforcement-learning", "deep-reinforcement-learning", "robotics", "navigation", "mujoco", "ddpg"]


def front_matter(name: str, task: str, rates: Mapping[str, float]) -> str:
    """YAML between two lines of dashes.

    Args:
        name: of the policy.
        task: that its figures are of.
        rates: of the actor alone on the stored test pairs, RATES.
    """
    metrics = [
        {"type": rate, "name": rate.replace("_", " "), "value": round(value, 4), "verified": False}
        for rate, value in rates.items()
    ]
    result = {
        "task": {"type": "reinforcement-learning", "name": "local navigation"},
        "dataset": {"type": task, "name": f"{task}, stored test pairs"},
        "metrics": metrics,
    }
    content: dict[str, Any] = {
        "license": "mit",
        "library_name": "asddpg",
        "pipeline_tag": "robotics",
        "tags": _TAGS,
        "model-index": [{"name": name, "results": [result]}],
    }
    return f"---\n{yaml.safe_dump(content, sort_keys=False, allow_unicode=True)}---\n"
